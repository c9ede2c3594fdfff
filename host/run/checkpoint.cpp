// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/checkpoint.hpp"

#include <fmt/format.h>

#include <cstring>
#include <sstream>
#include <type_traits>

#include "host/device/backend.hpp"
#include "host/errors.hpp"
#include "host/run/run_key.hpp"
#include "host/store/sealed_file.hpp"
#include "host/text.hpp"

#ifndef RA2D_VERSION
#define RA2D_VERSION "unknown"
#endif
#ifndef RA2D_COMMIT
#define RA2D_COMMIT "unknown"
#endif

namespace ra2d {
namespace {

constexpr const char* kind = "ra2d checkpoint";
constexpr std::uint32_t format = 1;
constexpr std::size_t most_bytes = std::size_t{1} << 32;

// ---- values and bytes --------------------------------------------------------------------------
// One list of members serves both ways: a Packer appends what it is shown, an Unpacker fills it.

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class Packer {
 public:
  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }
  std::string bytes;

 private:
  template <class T>
  requires(Plain<T> || std::is_same_v<T, OpenShock> ||
           std::is_same_v<T, CarriedState>) void put(const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(const std::string& text) {
    put(text.size());
    bytes += text;
  }
  template <class T>
  void put(std::vector<T>& list) {
    put(list.size());
    for (T& element : list) one(element);
  }
  template <class T>
  void put(T& value) requires requires {
    visit_members(value, *this);
  }
  { visit_members(value, *this); }
  void one(std::byte value) { bytes += static_cast<char>(value); }
  template <class T>
  void one(T& value) {
    put(value);
  }
};

class Unpacker {
 public:
  explicit Unpacker(const std::string& bytes) : rest_{bytes} {}
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  void end() const {
    if (!rest_.empty()) throw Unbelieved("longer than what it holds");
  }

 private:
  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw Unbelieved("shorter than what it holds");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  template <class T>
  requires(Plain<T> || std::is_same_v<T, OpenShock> ||
           std::is_same_v<T, CarriedState>) void get(T& value) {
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
  }
  void get(bool& value) { value = take(1)[0] != 0; }
  std::size_t size() {
    std::size_t count = 0;
    get(count);
    if (count > rest_.size())
      throw Unbelieved("shorter than what it holds");  // a byte each at least
    return count;
  }
  void get(std::string& text) {
    const std::size_t count = size();
    text = take(count);
  }
  void get(std::vector<std::byte>& list) {
    const std::string_view bytes = take(size());
    list.resize(bytes.size());
    if (!bytes.empty()) std::memcpy(list.data(), bytes.data(), bytes.size());
  }
  template <class T>
  void get(std::vector<T>& list) {
    const std::size_t count = size();
    list.clear();
    for (std::size_t i = 0; i < count; ++i) get(list.emplace_back());
  }
  template <class T>
  void get(T& value) requires requires {
    visit_members(value, *this);
  }
  { visit_members(value, *this); }

  std::string_view rest_;
};

template <class Archive>
void visit_members(Identity& i, Archive& archive) {
  archive(i.program, i.arithmetic, i.backend, i.key, i.scene);
}
template <class Archive>
void visit_members(SavedState& s, Archive& archive) {
  archive(s.values, s.arrays, s.room);
}
template <class Archive>
void visit_members(Snapshot& s, Archive& archive) {
  archive(s.status, s.step, s.resonator_u, s.resonator_v, s.slider_u, s.slider_v,
          s.resonator_square, s.contact_steps, s.most_nodes, s.evaluated, s.shocks_begun, s.energy,
          s.energy_limit, s.sliding_work, s.force_work, s.open_shocks, s.strides);
}
template <class Archive>
void visit_members(EnergyAccount& account, Archive& archive) {
  account.visit(archive);
}
template <class Archive>
void visit_members(LogHistogram& histogram, Archive& archive) {
  histogram.visit(archive);
}
template <class Archive>
void visit_members(Accounts& a, Archive& archive) {
  archive(a.samples, a.begin, a.now, a.energy, a.durations, a.forces, a.march_seconds);
}
template <class Archive>
void visit_members(Segment& s, Archive& archive) {
  archive(s.bytes, s.xxh3_128, s.samples, s.shocks);
}

/// The sections of a file, each with its members.
template <class Visit>
void visit_sections(Checkpoint& c, Visit&& visit) {
  visit("identity", c.identity);
  visit("state", c.state);
  visit("accounts", c.accounts);
  visit("time", c.wall_seconds);
  visit("outputs", c.segments);
}

// ---- whether it fits ---------------------------------------------------------------------------

/// The first line of a text that another one does not have in its place.
std::string first_difference(const std::string& there, const std::string& here) {
  std::istringstream a(there), b(here);
  std::string of_a, of_b;
  while (true) {
    const bool more_a = static_cast<bool>(std::getline(a, of_a));
    const bool more_b = static_cast<bool>(std::getline(b, of_b));
    if (!more_a && !more_b) return "a surface has other heights";
    if (!more_a) of_a = "nothing";
    if (!more_b) of_b = "nothing";
    // its name and the place of its files make no other run
    if (of_a != of_b && !(of_a.starts_with("name =") && of_b.starts_with("name =")))
      return fmt::format("'{}' there, '{}' here", printable(shortened(of_a, 80)),
                         printable(shortened(of_b, 80)));
  }
}

bool fits(const Snapshot& s, const Model& model) {
  const std::size_t resonator = model.resonator.modes.size(), slider = model.slider.modes.size();
  return s.resonator_u.size() == resonator && s.resonator_v.size() == resonator &&
         s.resonator_square.size() == resonator && s.slider_u.size() == slider &&
         s.slider_v.size() == slider && s.step >= 0 && s.step <= model.steps && s.strides >= 0;
}

/// What in the accounts does not fit the scene, or the state; empty where nothing is found.
std::string fault_of(const Checkpoint& c, const Model& model) {
  const Accounts& a = c.accounts;
  std::int64_t samples = 0;
  for (const Segment& segment : c.segments) samples += segment.samples;
  if (!fits(a.begin, model) || !fits(a.now, model)) return "its accounts are of another scene";
  if (a.now.step != c.state.values.step || a.now.status != Status::running ||
      a.begin.step > a.now.step || a.samples < 0 || a.samples > model.samples)
    return "its accounts and its state are of two moments";
  if (samples != a.samples) return "its outputs and its accounts do not agree";
  if (!a.durations.is_sound() || !a.forces.is_sound()) return "its histograms are none";
  return {};
}

}  // namespace

Identity identity_of(const std::string& key, const std::string& scene) {
  return {fmt::format("ra2d {} ({}), numerics {}, state of {} bytes", RA2D_VERSION, RA2D_COMMIT,
                      numerics_version, sizeof(CarriedState)),
          arithmetic(), backend_name(), key, scene};
}

std::string bytes_of(const Checkpoint& checkpoint) {
  Checkpoint copy = checkpoint;
  // addresses mean nothing, and would make each file another
  Extents none;
  none.flight_levels = 1;
  visit_arrays(copy.state.values, none,
               [](const char*, auto*& array, std::size_t) { array = nullptr; });
  std::vector<Section> sections;
  visit_sections(copy, [&](const char* name, auto& members) {
    Packer pack;
    pack(members);
    sections.push_back({name, std::move(pack.bytes)});
  });
  return seal(kind, format, sections);
}

Checkpoint checkpoint_of(const std::string& bytes) {
  const std::vector<Section> sections = unseal(kind, format, bytes);
  Checkpoint checkpoint;
  auto section = sections.begin();
  visit_sections(checkpoint, [&](const char* name, auto& members) {
    if (section == sections.end() || section->name != name)
      throw Unbelieved(fmt::format("without its section '{}'", name));
    Unpacker unpack(section->bytes);
    unpack(members);
    unpack.end();
    ++section;
  });
  return checkpoint;
}

Checkpoint read_checkpoint(const std::filesystem::path& file) {
  return checkpoint_of(read_whole(file, most_bytes));
}

std::string difference(const Checkpoint& checkpoint, const Identity& run, const Model& model) {
  const Identity& there = checkpoint.identity;
  if (there.key != run.key && there.arithmetic == run.arithmetic && there.program == run.program)
    return "it is of another scene: " + first_difference(there.scene, run.scene);
  const auto other = [](const char* what, const std::string& there_, const std::string& here) {
    return fmt::format("it is of another {}: '{}' there, '{}' here", what,
                       printable(shortened(there_, 120)), here);
  };
  if (there.program != run.program) return other("version", there.program, run.program);
  if (there.arithmetic != run.arithmetic) return other("build", there.arithmetic, run.arithmetic);
  if (there.backend != run.backend) return other("backend", there.backend, run.backend);
  return fault_of(checkpoint, model);
}

void write_checkpoint(const ClaimedOutput& output, const Checkpoint& checkpoint) {
  write_sealed(output.names().checkpoint, bytes_of(checkpoint), output.names().previous);
}

std::optional<Checkpoint> last_checkpoint(const ClaimedOutput& output, const Identity& run,
                                          const Model& model,
                                          const std::function<void(const std::string&)>& warn) {
  const OutputNames& names = output.names();
  std::string damage;
  for (const std::filesystem::path* file : {&names.checkpoint, &names.previous}) {
    if (!std::filesystem::exists(*file)) continue;
    try {
      Checkpoint checkpoint = read_checkpoint(*file);
      if (const std::string what = difference(checkpoint, run, model); !what.empty())
        throw RequestError(
            fmt::format("cannot go on from '{}': {}. It is left as it is: choose another output "
                        "with -o, or --fresh "
                        "to start anew and have it removed",
                        file->string(), what));
      for (std::size_t i = 0; i < checkpoint.segments.size(); ++i)
        require_segment(output.segment(i + 1), checkpoint.segments[i]);
      if (!damage.empty())
        warn(fmt::format("{}. The run goes on from '{}', which is older", damage, file->string()));
      return checkpoint;
    } catch (const Unbelieved& fault) {
      if (damage.empty()) damage = fmt::format("'{}' is {}", file->string(), fault.what());
    } catch (const FileError& fault) {
      if (damage.empty())
        damage = fmt::format("'{}' cannot be gone on from: {}", file->string(), fault.what());
    }
  }
  if (damage.empty()) return std::nullopt;
  throw FileError(damage + ". It is left as it is: --fresh starts the run anew and has it removed");
}

}  // namespace ra2d
