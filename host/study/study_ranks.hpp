// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <limits>
#include <string>

#include "host/ranks/ranks.hpp"
#include "host/study/study_worker.hpp"

/// A study under mpirun. Rank 0 decides what is to be done and writes the table. All ranks take
/// their runs from one list, and each writes a ledger of its own.
namespace ra2d {

/// At first, on all ranks: throws RequestError where a rank was started with other words than rank
/// 0. `words`: those that say which runs are to be made.
void require_one_request(Ranks& ranks, const std::string& words);

/// On rank 0, once the study is in its folder: gives the other ranks the list of runs. Throws
/// FileError.
void give_work(Ranks& ranks, const StudyFolder& folder, const Study& study,
               const PointCensus& census, const StudyWork& work);

/// How a rank marches its runs.
struct RankOptions {
  int threads = 1, device = -1;
  double checkpoint = 600;                                     // s between two of a run
  double most_wall = std::numeric_limits<double>::infinity();  // s
  std::function<void(const std::string&)> tell;                // a message
};

/// On the other ranks: takes runs until there are no more. Throws FileError where this rank sees
/// another folder than rank 0, or would run other scenes.
void help_with_study(Ranks& ranks, const StudyFolder& folder, const Shard& shard,
                     const RankOptions& options);

/// Adds the runs of the other ranks.
void add_others(Ranks& ranks, StudyProgress& progress);

/// The sum over all ranks.
struct SharedOutcome {
  StudyOutcome outcome;
  int threads = 0;
  int signal = 0;                // that ended one of them early; 0: none
  std::size_t went_on = 0;       // runs, from checkpoints
  std::int64_t steps_saved = 0;  // by that
};
/// Adds the share of the other ranks.
void add_others(Ranks& ranks, SharedOutcome& all);

/// Sleeps until all ranks have done their part. `on_wait` is called at once and a few times a
/// second, with the time waited [s]. Throws FileError on rank 0 where another has given up.
void wait_for_others(Ranks& ranks, const std::function<void(double waited)>& on_wait);

}  // namespace ra2d
