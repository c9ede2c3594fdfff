// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "host/run/run_files.hpp"
#include "host/study/ledger.hpp"
#include "host/study/study_folder.hpp"

/// Checkpoints of a study's runs on their way: DIR/runs/KEY.h5.checkpoint, and beside it what
/// host/store/output_names.hpp names, also where results are not kept. A run that is over before
/// its first checkpoint costs nothing here.
namespace ra2d {

class StudyCheckpoints {
 public:
  /// `seconds`: of wall time between two checkpoints of a run. `tell` is given messages for the
  /// user, from any thread, one at a time.
  StudyCheckpoints(StudyFolder folder, double seconds,
                   std::function<void(const std::string&)> tell = {});

  /// Removes those of runs that are finished: their process was killed just before it did.
  void remove_those_of(const FinishedRuns& finished);

  /// The checkpoint that a run goes on from; its files are then this process' own. None where there
  /// is none, or where another process runs it at this moment. A checkpoint that is damaged or of
  /// another program is removed, and `tell` says so of the run `name`.
  std::optional<Checkpoint> last(RunFiles& files, const std::string& key, const Model& model,
                                 Outputs outputs, const std::string& name);

  double seconds() const { return seconds_; }
  /// Whether it is time for one.
  bool is_due(const RunFiles& files) const { return files.since_checkpoint() >= seconds_; }
  /// Writes one of a run between two launches (RunFiles::keep), unless another process has the
  /// run's files. Threads may call it. Throws FileError.
  void keep(RunFiles& files, const SceneRun& run, SavedState state, double wall,
            const std::function<ResultSummary()>& so_far);

  /// Runs that went on from a checkpoint, and the steps that this saved.
  std::size_t went_on() const { return went_on_; }
  std::int64_t steps_saved() const { return steps_saved_; }

 private:
  StudyFolder folder_;
  double seconds_;
  std::function<void(const std::string&)> tell_;
  std::unordered_set<std::string> there_;  // keys of runs that have files, from before
  std::mutex telling_;
  std::atomic<std::size_t> went_on_ = 0;
  std::atomic<std::int64_t> steps_saved_ = 0;
};

/// The checkpoints in a study's folder, by name.
std::vector<std::filesystem::path> study_checkpoints(const StudyFolder& folder);

}  // namespace ra2d
