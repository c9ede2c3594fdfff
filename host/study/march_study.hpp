// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "host/study/study_ranks.hpp"
#include "host/study/study_runs.hpp"
#include "host/study/study_worker.hpp"

/// A study from its folder to its table: what `ra2d study` does.
namespace ra2d {

struct StudyMarch {
  StudyFolder folder;
  Shard shard;
  bool retry_failed = false;
  int threads = 1, device = -1;
  double checkpoint = 600;                                     // s between two of a run
  double most_wall = std::numeric_limits<double>::infinity();  // s
  Ranks* ranks = nullptr;                                      // under mpirun, on rank 0
};

/// Functions that are called while a study runs. Each may be empty.
struct StudyListener {
  std::function<void(const std::string&)> tell;                 // a message
  std::function<void(const std::vector<std::string>&)> doubts;  // of the scenes
  std::function<void(const std::string&)> stage;  // what is being done now; "" when it is done
  std::function<void(const StudyProgress&)> progress;
};

struct MarchedStudy {
  StudyWork work;     // what was to be done
  SharedOutcome all;  // of all ranks
  std::size_t most_at_once = 0;
  std::string device;    // that the runs were marched on; empty: the processor
  bool was_cut = false;  // by a signal, or by the wall time
  std::size_t finished() const { return all.outcome.done + all.outcome.failed; }
};

/// Runs what is missing of the study, keeps every run in the folder's ledger at once, and writes
/// the table. The same call goes on where an earlier one ended. Throws RequestError where the
/// folder's files are somebody else's, FileError.
MarchedStudy march_study(StudyRuns& runs, const StudyMarch& march, const StudyListener& listener);

}  // namespace ra2d
