// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/study/ledger.hpp"
#include "host/study/study_checkpoints.hpp"
#include "host/study/study_folder.hpp"
#include "host/study/study_points.hpp"

/// Runs the points of a study that have not been run yet.
namespace ra2d {

/// The runs of a study that are to be done, and the number of those that are finished.
struct StudyWork {
  std::vector<std::size_t> jobs;  // points to run, the dearest first
  std::size_t runs = 0;           // different ones of this part of the study
  std::size_t done = 0, failed = 0;
  double cost = 0;           // s of one thread, of the jobs, by what finished runs took
  double correction = 1;     // measured cost over the estimate; of no run 1
  std::size_t measured = 0;  // runs that it is of
};

/// Divides the different runs among the shards, the dearest first, one after the other, so that
/// every shard takes about as long. Of its own a shard takes those that are missing, with
/// `retry_failed` those that failed, and those for which `lacks` returns true.
StudyWork find_work(const PointCensus& census, const FinishedRuns& finished, const Shard& shard,
                    bool retry_failed, const std::function<bool(const FinishedRun&)>& lacks = {});

struct StudyProgress {
  std::size_t runs = 0, done = 0, failed = 0, running = 0;
  double elapsed = 0;       // s of wall time
  double left = quiet_nan;  // the same; NaN where it is not known
};

struct StudyOptions {
  std::function<void(const StudyProgress&)> progress;  // a few times a second
  bool keep_results = false;                           // each run's own, in the folder:
  bool keep_sound = false;                             // the levels of its sound
  std::filesystem::path folder;                        // of the study
  std::function<void()> tick;  // a few times a second on a thread of its own, during the march
  /// Which of the jobs is next, from 0 on; beyond the last there are no more. Several processes
  /// that share the jobs take each once. None: all are for this process.
  std::function<std::size_t()> next_job;
  int processes = 1;  // that run parts of the study on this machine, this one among them
  std::function<void(const std::string&)> tell;  // a message
  StudyCheckpoints* checkpoints = nullptr;       // that runs go on from, and leave; none: neither
  double most_wall =
      std::numeric_limits<double>::infinity();  // s, after which the study is cut off
};

struct StudyOutcome {
  std::size_t done = 0, failed = 0;                           // of the jobs
  std::vector<std::pair<std::string, std::string>> failures;  // names and reasons, the first few
  double elapsed = 0;                                         // s of wall time
  double busy = 0;     // s of all threads together, making scenes ready, marching and recording
  double marched = 0;  // of that in the march alone
  std::size_t most_at_once = 0;  // runs that were on their way side by side, at the most
};

/// Runs the jobs to their end, an interrupt (host/system/interruption.hpp) or the wall time, on
/// each of the backend's threads one after the other: threads that shared launches would wait for
/// one another at the end of each. What ends goes to the ledger at once. A run that fails is
/// recorded and stops nothing; one for which memory is short for now waits. Throws FileError where
/// that cannot be kept, and what `tick` throws.
StudyOutcome run_study(const StudyPoints& points, const PointCensus& census, const StudyWork& work,
                       LedgerWriter& ledger, const StudyOptions& options = {});

}  // namespace ra2d
