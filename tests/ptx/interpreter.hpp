// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/ptx/control_flow.hpp"
#include "tests/ptx/program.hpp"
#include "tests/ptx/watched_memory.hpp"

/// A warp of a GPU on a CPU: runs what nvcc makes of a march, instruction by instruction.
///
/// It watches what a GPU would do wrong in silence. An access outside the arrays that a test
/// allows, one that is not aligned, and lanes that come to different meetings are faults. Two lanes
/// that touch one place without a `bar.warp.sync` between, one of them writing, are a race. A
/// shuffle orders no memory. The clock (%globaltimer) begins a run with 0 and counts the lanes'
/// meetings.
namespace ra2d::test {

/// A cache of 16 ways that drops what was not used for longest.
class ModelCache {
 public:
  static constexpr std::uint64_t sector = 32;  // bytes, as a GPU moves them

  explicit ModelCache(std::uint64_t bytes) : sets_(bytes / (ways * sector)) {}
  void access(std::uint64_t sector_number);
  std::uint64_t missed_bytes() const { return sector * misses_; }

 private:
  static constexpr std::size_t ways = 16;
  std::vector<std::array<std::uint64_t, ways>> sets_;  // sectors, the latest first
  std::uint64_t misses_ = 0;
};

/// A warp that cannot go on.
struct WarpFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PtxWarp {
 public:
  /// In which order lanes go on from a meeting: side by side as on a GPU, or each by itself to the
  /// next one.
  enum class Order { in_step, ascending, descending, shuffled };

  /// `width`: lanes of a team; the warp has as many teams as fit.
  explicit PtxWarp(const Program& program, Order order = Order::in_step, int width = warp_width);

  int teams() const { return static_cast<int>(teams_.size()); }
  /// Memory that the lanes of a team may touch, before they run.
  void allow(std::string name, const void* begin, std::size_t bytes, bool writable, int team = 0);
  /// Runs as if a sync, by its index, were not there.
  void ignore(std::size_t sync) { ignored_ = sync; }
  /// Whether races are sought: without, it is twice as fast.
  void check_races(bool wanted) { checks_races_ = wanted; }

  /// Runs the kernel to its end, each team with parameters of its own. Throws WarpFault.
  void run(const std::vector<std::vector<std::uint64_t>>& parameters);

  /// Has a cache see all memory but the lanes' own from now on; it must outlive the warp.
  void add_cache(ModelCache& cache) { caches_.push_back(&cache); }

  /// The races of all runs, each pair of places once, as text.
  std::vector<std::string> races() const;
  /// How often each instruction was issued to lanes of the warp, in all runs. As a GPU counts where
  /// they go together.
  const std::vector<std::uint64_t>& counts() const { return counts_; }
  /// To how many lanes.
  const std::vector<std::uint64_t>& lanes() const { return lanes_; }
  /// Instructions issued from one sync of the block to the next.
  const std::vector<std::uint64_t>& stretches() const { return stretches_; }
  /// Reductions over the lanes. Each ends with an exchange between neighbours, in two halves.
  std::uint64_t reductions() const { return neighbour_exchanges_ / 2; }

 private:
  /// Lanes that march a scene together.
  struct Team {
    std::uint32_t lanes;
    WatchedMemory memory;
  };

  /// Lanes at one place, and where others wait for them.
  struct Going {
    std::uint32_t lanes;
    std::size_t at, until;
  };

  void issue(std::size_t index, std::uint32_t lanes) {
    ++counts_[index];
    lanes_[index] += static_cast<std::uint64_t>(std::popcount(lanes));
    ++in_stretch_;
  }
  void run_in_step();
  void run_by_turns(bool shuffle);
  void run_to_meetings(const std::vector<int>& turn);
  std::size_t run_group(std::uint32_t lanes, std::size_t at, std::size_t until,
                        std::uint32_t& taken);
  void leave(std::uint32_t lanes, std::size_t at);
  bool are_teams(std::uint32_t lanes) const;
  std::size_t check_meeting(const Team& team) const;
  std::string place(std::size_t index) const;
  void meet(std::uint32_t lanes, std::size_t at);
  void access(const Instruction& instruction, std::size_t index, std::uint32_t mask);
  void exchange(const Instruction& instruction, std::uint32_t lanes);
  void ballot(const Instruction& instruction, std::uint32_t lanes);
  char* memory(const Instruction& instruction, std::size_t index, std::uint64_t address, int lane,
               bool writes);
  std::uint32_t guarded(const Instruction& instruction, std::uint32_t mask) const;
  bool is_meeting(std::size_t index) const;
  bool is_local(std::uint64_t address) const;
  [[noreturn]] void fault(const Instruction& instruction, const std::string& problem) const;

  const Program& program_;
  Order order_;
  int width_;
  std::vector<Team> teams_;
  std::vector<LaneBits> registers_;
  std::vector<char> local_;  // of all lanes, one after the other
  std::uint64_t local_begin_ = 0;
  std::array<std::size_t, warp_width> at_{};  // next instruction of each lane
  std::uint32_t alive_ = 0;
  std::size_t ignored_ = static_cast<std::size_t>(-1);
  bool checks_races_ = true;
  std::vector<std::size_t> joins_;    // ways_join_at()
  std::vector<std::uint32_t> hints_;  // of each instruction: the array that it touched last
  std::vector<WatchedMemory::Conflict> conflicts_;
  std::set<std::pair<int, int>> races_;
  std::vector<std::uint64_t> counts_, lanes_, stretches_;
  std::uint64_t in_stretch_ = 0;
  std::uint64_t neighbour_exchanges_ = 0;
  std::vector<ModelCache*> caches_;
};

}  // namespace ra2d::test
