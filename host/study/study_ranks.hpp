// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <limits>

#include "host/ranks/ranks.hpp"
#include "host/study/study_worker.hpp"

/// A study under mpirun: rank 0 decides what is to be done and writes the table; all take the runs
/// from one list, each into a ledger of its own.
namespace ra2d {

/// On rank 0, once the study is in its folder: the others get their work.
void hand_out(Ranks& ranks, const Study& study, const PointCensus& census, const StudyWork& work);

/// How a rank marches its runs.
struct RankChoices {
  int threads = 1, device = -1;
  double checkpoint = 600;                                     // s between two of a run
  double most_wall = std::numeric_limits<double>::infinity();  // s
};

/// On the others: does its part, and waits for nobody. Throws FileError where this rank sees
/// another folder than rank 0, or would run other scenes.
void help_with_study(Ranks& ranks, const StudyFolder& folder, const Shard& shard,
                     const RankChoices& choices);

/// Adds the runs of the other ranks.
void add_others(Ranks& ranks, StudyProgress& progress);

/// What all ranks together have done.
struct SharedOutcome {
  StudyOutcome outcome;
  int threads = 0;
  int signal = 0;                // that ended one of them early; 0: none
  std::size_t went_on = 0;       // runs, from checkpoints
  std::int64_t steps_saved = 0;  // by that
};
/// Adds what the others have done.
void add_others(Ranks& ranks, SharedOutcome& all);

/// Sleeps until all ranks have done their part. `beside` is called at once and a few times a
/// second, with the time waited [s]. Throws FileError on rank 0 where another has given up.
void wait_for_others(Ranks& ranks, const std::function<void(double waited)>& beside);

}  // namespace ra2d
