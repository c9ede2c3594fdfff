// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/checkpoint.hpp"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "host/device/backend.hpp"
#include "host/run/run_key.hpp"
#include "host/store/sealed_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 32;

// ---- whether it fits ---------------------------------------------------------------------------

bool fits(const Snapshot& s, const Model& model) {
  const std::size_t resonator = model.resonator.modes.size(), slider = model.slider.modes.size();
  return s.resonator_u.size() == resonator && s.resonator_v.size() == resonator &&
         s.resonator_square.size() == resonator && s.slider_u.size() == slider &&
         s.slider_v.size() == slider && s.step >= 0 && s.step <= model.steps && s.steps_made >= 0;
}

/// The first of the accounts that does not fit the scene or the state; empty where all fit.
std::string fault_of(const Checkpoint& c, const Model& model, Outputs outputs) {
  const Accounts& a = c.accounts;
  std::int64_t samples = 0;
  for (const Segment& segment : c.segments) {
    if (segment.samples < 0 || segment.samples > model.kept_samples() - samples)
      return "its outputs have more samples than the run";
    samples += segment.samples;
  }
  if (!fits(a.begin, model) || !fits(a.now, model)) return "its accounts are of another scene";
  if (a.now.step != c.state.values.step || a.now.status != Status::running ||
      a.now.shocks_begun != c.state.values.shocks.begun ||
      std::ssize(a.now.open_shocks) != c.state.values.shocks.open_count ||
      a.begin.step > a.now.step || a.samples < 0 || a.samples > model.kept_samples())
    return "its statistics and its state are from different times";
  if (outputs == Outputs::kept && samples != a.samples)
    return "its outputs and its accounts do not agree";
  if (!a.durations.is_sound() || !a.forces.is_sound()) return "its histograms are none";
  return {};
}

}  // namespace

Identity identity_of(const std::string& key, const std::string& scene) {
  return {fmt::format("{}, numerics {}, state of {} bytes", program_text(), numerics_version,
                      sizeof(CarriedState)),
          arithmetic(), backend_name(), key, scene};
}

Checkpoint read_checkpoint(const std::filesystem::path& file) {
  return checkpoint_of(read_whole(file, most_bytes));
}

std::string difference(const Checkpoint& checkpoint, const Identity& run, const Model& model,
                       Outputs outputs) {
  const Identity& there = checkpoint.identity;
  if (there.key != run.key && there.arithmetic == run.arithmetic && there.program == run.program) {
    const std::string words = first_difference(there.scene, run.scene);
    return "it is of another scene: " + (words.empty() ? "a surface has other heights" : words);
  }
  const auto other = [](const char* what, const std::string& there_, const std::string& here) {
    return fmt::format("it is of another {}: '{}' there, '{}' here", what,
                       printable(shortened(there_, 120)), here);
  };
  if (there.program != run.program) return other("version", there.program, run.program);
  if (there.arithmetic != run.arithmetic) return other("build", there.arithmetic, run.arithmetic);
  if (there.backend != run.backend) return other("backend", there.backend, run.backend);
  return fault_of(checkpoint, model, outputs);
}

void write_checkpoint(const ClaimedOutput& output, const Checkpoint& checkpoint,
                      bool last_is_damaged) {
  write_sealed(output.names().checkpoint, bytes_of(checkpoint),
               last_is_damaged ? std::filesystem::path{} : output.names().previous);
}

FoundCheckpoint find_checkpoint(const OutputNames& names, const Identity& run, const Model& model,
                                Outputs outputs) {
  FoundCheckpoint found;
  for (const std::filesystem::path* file : {&names.checkpoint, &names.previous}) {
    if (!std::filesystem::exists(*file)) continue;
    try {
      Checkpoint checkpoint = read_checkpoint(*file);
      if (const std::string what = difference(checkpoint, run, model, outputs); !what.empty()) {
        found.difference = fmt::format("cannot go on from '{}': {}", file->string(), what);
        return found;
      }
      if (outputs == Outputs::kept)
        for (std::size_t i = 0; i < checkpoint.segments.size(); ++i)
          require_segment(names.segment(i + 1), checkpoint.segments[i]);
      found.file = *file;
      found.checkpoint = std::move(checkpoint);
      return found;
    } catch (const CorruptFile& fault) {
      if (found.damage.empty())
        found.damage = fmt::format("'{}' is {}", file->string(), fault.what());
    } catch (const FileError& fault) {
      if (found.damage.empty())
        found.damage = fmt::format("'{}' cannot be gone on from: {}", file->string(), fault.what());
    }
  }
  return found;
}

}  // namespace ra2d
