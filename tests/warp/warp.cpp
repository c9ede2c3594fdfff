// SPDX-License-Identifier: BSD-3-Clause
// Not to be compiled with a sanitizer: what lanes hand to one another here is no memory of the
// kernels. Where the thread sanitizer is linked to the program, it is told of the fibers.
#include "tests/warp/warp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/context/fiber.hpp>
#include <boost/context/fixedsize_stack.hpp>
#include <cstring>
#include <exception>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>

extern "C" {
[[gnu::weak]] void* __tsan_get_current_fiber();
[[gnu::weak]] void* __tsan_create_fiber(unsigned flags);
[[gnu::weak]] void __tsan_destroy_fiber(void* fiber);
[[gnu::weak]] void __tsan_switch_to_fiber(void* fiber, unsigned flags);
[[gnu::weak]] void __tsan_acquire(void* what);
[[gnu::weak]] void __tsan_release(void* what);
}

namespace ra2d::test {
namespace {

namespace context = boost::context;

constexpr std::size_t stack_size = 1 << 18;

void acquire(void* what) {
  if (__tsan_acquire) __tsan_acquire(what);
}
void release(void* what) {
  if (__tsan_release) __tsan_release(what);
}
/// From here on it is `fiber` that reads and writes. The switch itself orders nothing.
void announce(void* fiber) {
  if (__tsan_switch_to_fiber) __tsan_switch_to_fiber(fiber, 1);
}

/// Ends a lane whose warp has come to nothing.
struct Abandoned {};

struct Lane {
  context::fiber fiber;
  void* tsan_fiber = nullptr;  // the thread sanitizer's name of it
  bool ended = false;
  std::exception_ptr fault;
  // where it waits
  Warp::Meeting meeting = Warp::Meeting::sync;
  std::source_location where;
  double value = 0, level = 0;

  bool meets(const Lane& other) const {
    return ended == other.ended &&
           (ended || (meeting == other.meeting && where.line() == other.where.line() &&
                      where.column() == other.where.column() &&
                      std::strcmp(where.file_name(), other.where.file_name()) == 0));
  }
  std::string place() const {
    constexpr const char* names[] = {"sync", "sum", "min", "next", "at_least"};
    return ended ? "at its end"
                 : fmt::format("at a {} ({}:{})", names[static_cast<int>(meeting)],
                               where.file_name(), where.line());
  }
};

}  // namespace

struct Warp::Impl {
  LaneOrder order;
  std::mt19937 random{1};
  std::array<Lane, warp_width> lanes;
  context::fiber back;         // to run(), from the lane that is on
  void* tsan_fiber = nullptr;  // run()
  bool abandoned = false;
  double result = 0;
  WarpValues next{};  // results of Meeting::next, one a lane
  std::int64_t syncs = 0, reductions = 0;
  char begun = 0, over = 0, met[2] = {};  // addresses by which the thread sanitizer knows an order

  void start(int number, const std::function<void(int)>& body) {
    Lane& lane = lanes[static_cast<std::size_t>(number)];
    lane = Lane();
    if (__tsan_create_fiber) lane.tsan_fiber = __tsan_create_fiber(0);
    lane.fiber = context::fiber(std::allocator_arg, context::fixedsize_stack(stack_size),
                                [this, &lane, number, &body](context::fiber&& from) {
                                  back = std::move(from);
                                  acquire(&begun);
                                  try {
                                    if (!abandoned) body(number);
                                  } catch (const Abandoned&) {
                                  } catch (...) {
                                    lane.fault = std::current_exception();
                                  }
                                  lane.ended = true;
                                  release(&over);
                                  announce(tsan_fiber);
                                  return std::move(back);
                                });
  }
  /// On to its next meeting or its end.
  void go_on(Lane& lane) {
    if (lane.ended) return;
    announce(lane.tsan_fiber);
    lane.fiber = std::move(lane.fiber).resume();
  }
  void wait() {
    announce(tsan_fiber);
    back = std::move(back).resume();
    if (abandoned) throw Abandoned();
  }
  void reduce() {
    const Lane& first = lanes.front();
    WarpValues values;
    std::transform(lanes.begin(), lanes.end(), values.begin(),
                   [](const Lane& lane) { return lane.value; });
    switch (first.meeting) {
      case Meeting::sync:
        ++syncs;
        return;
      case Meeting::sum:
        result = tree_sum(values);
        break;
      case Meeting::min:
        result = smallest(values);
        break;
      case Meeting::next:
        next = next_lanes(values);
        break;
      case Meeting::at_least:
        result = lanes_at_least(values, first.level);
        break;
    }
    ++reductions;
  }
  /// All lanes to where they meet or end. What went wrong is thrown once all have ended.
  void meet() {
    std::array<int, warp_width> turn;
    std::iota(turn.begin(), turn.end(), 0);
    if (order == LaneOrder::descending) std::reverse(turn.begin(), turn.end());
    while (true) {
      if (order == LaneOrder::shuffled) std::shuffle(turn.begin(), turn.end(), random);
      for (const int lane : turn) go_on(lanes[static_cast<std::size_t>(lane)]);
      const auto faulty = std::find_if(lanes.begin(), lanes.end(),
                                       [](const Lane& lane) { return lane.fault != nullptr; });
      const auto other = std::find_if(lanes.begin(), lanes.end(),
                                      [&](const Lane& lane) { return !lane.meets(lanes.front()); });
      if (faulty == lanes.end() && other == lanes.end()) {
        if (lanes.front().ended) return;
        reduce();
        continue;
      }
      const std::string ways =
          other == lanes.end() ? std::string()
                               : fmt::format("lane 0 is {}, lane {} is {}", lanes.front().place(),
                                             other - lanes.begin(), other->place());
      abandoned = true;
      for (Lane& lane : lanes) go_on(lane);
      if (faulty != lanes.end()) std::rethrow_exception(faulty->fault);
      throw Diverged(ways);
    }
  }
};

Warp::Warp(LaneOrder order) : impl_{std::make_unique<Impl>()} { impl_->order = order; }
Warp::~Warp() = default;

std::int64_t Warp::syncs() const { return impl_->syncs; }
std::int64_t Warp::reductions() const { return impl_->reductions; }

void Warp::run(const std::function<void(int lane)>& body) {
  Impl& warp = *impl_;
  warp.abandoned = false;
  warp.syncs = warp.reductions = 0;
  if (__tsan_get_current_fiber) warp.tsan_fiber = __tsan_get_current_fiber();
  release(&warp.begun);
  for (int lane = 0; lane < warp_width; ++lane) warp.start(lane, body);
  std::exception_ptr fault;
  try {
    warp.meet();
  } catch (...) {
    fault = std::current_exception();
  }
  acquire(&warp.over);
  if (__tsan_destroy_fiber)
    for (const Lane& lane : warp.lanes) __tsan_destroy_fiber(lane.tsan_fiber);
  if (fault) std::rethrow_exception(fault);
}

double Warp::meet(int number, Meeting meeting, const std::source_location& where, double value,
                  double level) {
  Impl& warp = *impl_;
  Lane& lane = warp.lanes[static_cast<std::size_t>(number)];
  lane.meeting = meeting;
  lane.where = where;
  lane.value = value;
  lane.level = level;
  // the first lanes may be at the next sync while the last ones are still to leave this one
  char* const order = &warp.met[warp.syncs % 2];
  if (meeting == Meeting::sync) release(order);
  warp.wait();
  if (meeting == Meeting::sync) acquire(order);
  return meeting == Meeting::next ? warp.next[static_cast<std::size_t>(number)] : warp.result;
}

}  // namespace ra2d::test
