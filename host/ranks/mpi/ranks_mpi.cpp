// SPDX-License-Identifier: BSD-3-Clause
// Ranks by MPI: a library that the program loads at run time (host/ranks/ranks.cpp).
#include <mpi.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "host/ranks/ranks.hpp"

namespace ra2d {
namespace {

using namespace std::chrono_literals;

using Numbers = std::array<std::int64_t, sizeof(RankReport) / sizeof(std::int64_t)>;

/// One thread at a time calls MPI: with several at once Open MPI has no windows over TCP. MPI's own
/// errors end all ranks (MPI_ERRORS_ARE_FATAL), with a message of MPI.
class RanksOfMpi final : public Ranks {
 public:
  RanksOfMpi() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    count_neighbours();
    // on rank 0: the next number, then a report of each rank
    const MPI_Aint count = rank_ == 0 ? 1 + size_ * static_cast<MPI_Aint>(Numbers{}.size()) : 0;
    constexpr int unit = sizeof(std::int64_t);
    std::int64_t* memory = nullptr;
    MPI_Win_allocate(count * unit, unit, MPI_INFO_NULL, MPI_COMM_WORLD, &memory, &window_);
    MPI_Win_lock_all(0, window_);
    std::fill_n(memory, count, 0);
    MPI_Win_sync(window_);
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank_ == 0) attendant_ = std::thread([this] { attend(); });
  }
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int threads() const override { return threads_; }
  int neighbours() const override { return neighbours_; }

  void broadcast(void* bytes, std::size_t count) override {
    constexpr std::size_t most = std::size_t{1} << 30;  // MPI counts with an int
    for (auto* at = static_cast<char*>(bytes); count > 0;) {
      const std::size_t part = std::min(count, most);
      const std::lock_guard lock(mutex_);
      MPI_Bcast(at, static_cast<int>(part), MPI_BYTE, 0, MPI_COMM_WORLD);
      at += part;
      count -= part;
    }
  }

  std::size_t next_number() override {
    constexpr std::int64_t one = 1;
    std::int64_t number = 0;
    const std::lock_guard lock(mutex_);
    MPI_Fetch_and_op(&one, &number, MPI_INT64_T, 0, 0, MPI_SUM, window_);
    MPI_Win_flush(0, window_);
    return static_cast<std::size_t>(number);
  }

  void report(const RankReport& report) override {
    const auto numbers = std::bit_cast<Numbers>(report);
    const int count = static_cast<int>(numbers.size());
    const std::lock_guard lock(mutex_);
    MPI_Accumulate(numbers.data(), count, MPI_INT64_T, 0, place_of(rank_), count, MPI_INT64_T,
                   MPI_REPLACE, window_);
    MPI_Win_flush(0, window_);
  }

  RankReport report_of(int rank) override {
    Numbers numbers{};
    const int count = static_cast<int>(numbers.size());
    const std::lock_guard lock(mutex_);
    MPI_Get_accumulate(nullptr, 0, MPI_INT64_T, numbers.data(), count, MPI_INT64_T, 0,
                       place_of(rank), count, MPI_INT64_T, MPI_NO_OP, window_);
    MPI_Win_flush(0, window_);
    return std::bit_cast<RankReport>(numbers);
  }

  bool all_are_here() override {
    const std::lock_guard lock(mutex_);
    if (arrival_ == MPI_REQUEST_NULL) MPI_Ibarrier(MPI_COMM_WORLD, &arrival_);
    int here = 0;
    MPI_Test(&arrival_, &here, MPI_STATUS_IGNORE);
    return here != 0;
  }

  void leave() override {
    while (!all_are_here()) std::this_thread::sleep_for(2ms);
    over_ = true;
    if (attendant_.joinable()) attendant_.join();
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
    MPI_Finalize();
  }

  void abort(int status) noexcept override {
    const std::lock_guard lock(mutex_);
    MPI_Abort(MPI_COMM_WORLD, status);
    _exit(status);
  }

 private:
  static MPI_Aint place_of(int rank) { return 1 + rank * static_cast<MPI_Aint>(Numbers{}.size()); }

  /// Ranks of one machine that may use the same processors divide them. All ranks call it.
  void count_neighbours() {
    cpu_set_t mine;
    CPU_ZERO(&mine);
    const bool has_set = sched_getaffinity(0, sizeof mine, &mine) == 0;
    MPI_Comm machine;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
    int place = 0;
    MPI_Comm_rank(machine, &place);
    MPI_Comm_size(machine, &neighbours_);
    std::vector<cpu_set_t> sets(static_cast<std::size_t>(neighbours_));
    MPI_Allgather(&mine, sizeof mine, MPI_BYTE, sets.data(), sizeof mine, MPI_BYTE, machine);
    MPI_Comm_free(&machine);
    if (!has_set) return;
    int sharers = 0, before = 0;
    for (int i = 0; i < neighbours_; ++i) {
      if (CPU_EQUAL(&sets[static_cast<std::size_t>(i)], &mine) == 0) continue;
      ++sharers;
      before += i < place ? 1 : 0;
    }
    const int processors = CPU_COUNT(&mine);
    threads_ = std::max(1, processors / sharers + (before < processors % sharers ? 1 : 0));
  }

  /// Between machines MPI answers the others' requests only while rank 0 is in a call of MPI, and
  /// its threads march.
  void attend() {
    while (!over_) {
      {
        const std::lock_guard lock(mutex_);
        int found = 0;
        MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &found, MPI_STATUS_IGNORE);
      }
      std::this_thread::sleep_for(1ms);
    }
  }

  int rank_ = 0, size_ = 1, threads_ = 1, neighbours_ = 1;
  MPI_Win window_ = MPI_WIN_NULL;
  MPI_Request arrival_ = MPI_REQUEST_NULL;
  std::mutex mutex_;  // of all calls of MPI
  std::atomic<bool> over_ = false;
  std::thread attendant_;
};

}  // namespace
}  // namespace ra2d

/// Starts MPI and gives the ranks. `size`: what mpirun says they are. Returns what is wrong, or
/// null.
extern "C" __attribute__((visibility("default"))) const char* ra2d_join_ranks(int size,
                                                                              ra2d::Ranks** ranks) {
  static std::string fault;
  int threads = 0, found = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &threads);
  MPI_Comm_size(MPI_COMM_WORLD, &found);
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> version{};
  int length = 0;
  MPI_Get_library_version(version.data(), &length);
  const std::string name(version.data(), std::strcspn(version.data(), ",\n"));
  if (found != size)
    fault = "it started " + std::to_string(size) + " processes, of which " + name +
            ", which ra2d was built with, sees " + std::to_string(found) +
            ". Use the mpirun of that MPI, or build ra2d again with the other one";
  else if (threads < MPI_THREAD_SERIALIZED)
    fault = name + " knows no threads. Build ra2d with an MPI that does";
  if (!fault.empty()) {
    MPI_Finalize();
    return fault.c_str();
  }
  static auto* const joined = new ra2d::RanksOfMpi;  // for as long as the process lives
  *ranks = joined;
  return nullptr;
}
