// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>

/// Processes that share one piece of work: those that mpirun starts together, called ranks. MPI
/// itself is in a library of its own (ranks/mpi), which is loaded where there are several ranks and
/// nowhere else: it takes longer to start than a short run.
namespace ra2d {

/// This process among those that were started together; alone it is 0 of 1.
struct Launch {
  int rank = 0, size = 1;
};

/// The launch by the environment variables of mpirun (Open MPI, MPICH and its descendants) and of
/// srun with pmi2 or pmix. Processes that srun starts without either are each alone.
Launch launch();

/// A rank's report to rank 0 on its part of the work.
struct RankReport {
  static constexpr std::int64_t fault = -1;

  std::int64_t done = 0, failed = 0, running = 0;  // runs
  std::int64_t ended = 0;                          // the signal that ended it early, or fault
  std::int64_t went_on = 0, steps_saved = 0;       // from checkpoints
  std::int64_t threads = 0;
  std::int64_t busy = 0, marched = 0;  // us of all its threads together
};

/// All ranks at once. Any thread may call; a thread that waits for other ranks sleeps.
class Ranks {
 public:
  virtual ~Ranks() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Threads for this rank: the processors that it may use, divided among the ranks that may use
  /// the same ones; at least 1.
  virtual int threads() const = 0;
  /// Ranks on this machine, this one among them.
  virtual int neighbours() const = 0;
  /// Every rank gets the bytes of rank 0. All must call it.
  virtual void broadcast(void* bytes, std::size_t count) = 0;
  /// 0, 1, 2, ...: each number goes to one caller on one rank.
  virtual std::size_t next_number() = 0;
  virtual void report(const RankReport& report) = 0;
  virtual RankReport report_of(int rank) = 0;
  /// Whether all ranks have called it since all last had. To be called again until it is true.
  virtual bool all_are_here() = 0;
  /// Waits until all ranks leave. MPI is over then.
  virtual void leave() = 0;
  /// Ends all ranks at once, with this exit status as far as mpirun hands it on.
  virtual void abort(int status) noexcept = 0;
};

/// Makes this process one of its ranks, once; null where it is alone. Throws RequestError where
/// ra2d was built without MPI, FileError where MPI cannot be loaded or is not that of mpirun.
Ranks* join_ranks();

/// The result of join_ranks(); null before.
Ranks* joined_ranks();

/// Throws RequestError where there are several ranks: they would all do the same.
void require_one_process();

}  // namespace ra2d
