// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_checkpoints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t key_length = 32;  // hexadecimal digits

/// Calls `visit` with each file beside a result, KEY.h5.checkpoint or KEY.h5.parts, and its run's
/// key.
template <class Visit>
void visit_files(const StudyFolder& folder, const Visit& visit) {
  std::error_code none;  // no such folder: no such files
  for (fs::directory_iterator entry(folder.results(), none), end; !none && entry != end;
       entry.increment(none)) {
    const std::string name = entry->path().filename().string();
    if (name.size() > key_length && name.compare(key_length, 4, ".h5.") == 0 &&
        name.find_first_not_of("0123456789abcdef") == key_length)
      visit(entry->path(), name.substr(0, key_length));
  }
}

}  // namespace

StudyCheckpoints::StudyCheckpoints(StudyFolder folder, double seconds,
                                   std::function<void(const std::string&)> tell)
    : folder_{std::move(folder)}, seconds_{seconds}, tell_{std::move(tell)} {
  visit_files(folder_, [&](const fs::path&, const std::string& key) { there_.insert(key); });
}

void StudyCheckpoints::remove_those_of(const FinishedRuns& finished) {
  if (there_.empty()) return;
  for (const auto& [scene, run] : finished.runs) {
    const std::string key = key_text(run.run);
    if (!there_.contains(key)) continue;
    try {
      ClaimedOutput(folder_.path / StudyFolder::result(key)).remove_all();
    } catch (const OutputTaken&) {  // another process runs it again
    }
    there_.erase(key);
  }
}

std::optional<Checkpoint> StudyCheckpoints::last(RunFiles& files, const std::string& key,
                                                 const Model& model, Outputs outputs,
                                                 const std::string& name) {
  if (!there_.contains(key)) return std::nullopt;
  try {
    files.claim();
  } catch (const OutputTaken&) {
    return std::nullopt;
  }
  FoundCheckpoint found = files.find(model, outputs);
  const std::string fault = found.damage.empty() ? found.difference : found.damage;
  if (!fault.empty() && tell_) {
    const std::lock_guard lock(telling_);
    tell_(found.checkpoint
              ? fmt::format("{}. The run {} goes on from '{}', which is older", fault, name,
                            found.file.string())
              : fmt::format("{}. It is removed, and the run {} starts anew", fault, name));
  }
  if (!found.checkpoint) {
    files.remove();
    return std::nullopt;
  }
  files.remove_after_checkpoint();
  ++went_on_;
  steps_saved_ += found.checkpoint->accounts.now.steps_made;
  return std::move(found.checkpoint);
}

void StudyCheckpoints::keep(RunFiles& files, const SceneRun& run, SavedState state, double wall,
                            const std::function<ResultSummary()>& so_far) {
  if (!files.is_claimed()) {
    try {
      folder_.make(true);
      files.claim();
    } catch (const OutputTaken&) {  // it keeps this run; here it ends without
      return;
    }
    files.remove();  // of a process that is gone, and that ran this point after this one had begun
  }
  files.keep(run, std::move(state), wall, so_far);
}

std::vector<fs::path> study_checkpoints(const StudyFolder& folder) {
  std::vector<fs::path> files;
  visit_files(folder, [&](const fs::path& path, const std::string&) {
    const std::string end = path.extension().string();
    if (end == ".checkpoint" || end == ".previous") files.push_back(path);
  });
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace ra2d
