// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <source_location>
#include <stdexcept>

#include "tests/reductions.hpp"

/// A warp on a CPU: what WarpLanes (kernels/lanes.hpp) is on a GPU, for tests.
///
/// Each lane is a fiber that runs by itself up to the next meeting: a `sync` or a reduction. When
/// all have come, they go on one after the other, in an order that a test chooses: a kernel whose
/// answer depends on it lacks a `sync`. A thread sanitizer sees each lane as a thread, and a
/// `sync`, but no reduction, as what orders their reads and writes: a shuffle orders no memory
/// either.
namespace ra2d::test {

/// Lanes went different ways: some ended, or came to another meeting than the others.
struct Diverged : std::logic_error {
  using std::logic_error::logic_error;
};

/// In which order lanes go on from a meeting.
enum class LaneOrder { ascending, descending, shuffled };

class Warp {
 public:
  explicit Warp(LaneOrder order = LaneOrder::ascending);
  ~Warp();
  Warp(const Warp&) = delete;
  Warp& operator=(const Warp&) = delete;

  /// Runs `lane` for 0, ..., 31 side by side to their ends. Throws Diverged, and what a lane
  /// throws.
  void run(const std::function<void(int lane)>& lane);

  /// Meetings of the latest run.
  std::int64_t syncs() const;
  std::int64_t reductions() const;

  // for FiberLanes

  enum class Meeting { sync, sum, min, next, at_least };
  /// Hands in this lane's values, and returns with the reduction of all of them. `level` of
  /// at_least.
  double meet(int lane, Meeting meeting, const std::source_location& where, double value = 0,
              double level = 0);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The interface of kernels/lanes.hpp for one lane of such a warp.
struct FiberLanes {
  using Real = double;
  static constexpr int width = warp_width;
  static constexpr bool on_gpu = true;
  using Where = std::source_location;

  Warp& warp;
  int lane;

  Real load(const double* p) const { return p[lane]; }
  void store(double* p, Real x) const { p[lane] = x; }
  Real index() const { return lane; }
  double sum(Real x, const Where& where = Where::current()) const {
    return warp.meet(lane, Warp::Meeting::sum, where, x);
  }
  void sum(Real x, Real y, double& of_x, double& of_y,
           const Where& where = Where::current()) const {
    of_x = sum(x, where);
    of_y = sum(y, where);
  }
  double min(Real x, const Where& where = Where::current()) const {
    return warp.meet(lane, Warp::Meeting::min, where, x);
  }
  double max(Real x, const Where& where = Where::current()) const { return -min(-x, where); }
  Real next(Real x, const Where& where = Where::current()) const {
    return warp.meet(lane, Warp::Meeting::next, where, x);
  }
  std::uint32_t at_least(Real x, double level, const Where& where = Where::current()) const {
    return static_cast<std::uint32_t>(warp.meet(lane, Warp::Meeting::at_least, where, x, level));
  }
  bool leader() const { return lane == 0; }
  static void prefetch(const double*) {}
  static void meet_scenes() {}
  static void meet_in_warp() {}
  static constexpr bool time_is_up() { return false; }
  void sync(const Where& where = Where::current()) const {
    warp.meet(lane, Warp::Meeting::sync, where);
  }
};

}  // namespace ra2d::test
