// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "kernels/lanes.hpp"
#include "kernels/shocks.hpp"

// Where the argument's own namespace is searched: containers of them are compared and printed.
namespace ra2d {

static bool operator==(const ShockRow& a, const ShockRow& b) {
  return a.serial == b.serial && a.start == b.start && a.last == b.last && a.peak == b.peak &&
         a.impulse == b.impulse && a.moment == b.moment && a.across_moment == b.across_moment &&
         a.row == b.row;
}
static bool operator==(const OpenShock& a, const OpenShock& b) {
  return a.serial == b.serial && a.start == b.start && a.last == b.last && a.force == b.force &&
         a.peak == b.peak && a.impulse == b.impulse && a.moment == b.moment &&
         a.across_moment == b.across_moment && a.row == b.row;
}
static bool operator==(const ContactRun& a, const ContactRun& b) {
  return a.first == b.first && a.last == b.last && a.shock == b.shock && a.force == b.force &&
         a.moment == b.moment;
}
static void PrintTo(const ShockRow& r, std::ostream* out) {
  *out << "{serial " << r.serial << ", steps " << r.start << " to " << r.last << ", peak " << r.peak
       << ", impulse " << r.impulse << ", moment " << r.moment << ", across " << r.across_moment
       << ", row " << r.row << "}";
}

}  // namespace ra2d

namespace {

using namespace ra2d;

/// Contact in space and time: the force of each (step, node), negative where there is no contact.
/// Forces are whole numbers and positions quarters, so every sum is exact in whatever order.
struct Pattern {
  int nodes = 0, steps = 0;
  int row = 0;  // areal: length of a row, its last node being padding; 0: one row
  std::vector<double> force;

  Pattern(int n, int s) : nodes{n}, steps{s}, force(static_cast<std::size_t>(n) * s, -1.0) {}
  /// One string a step: '.' is no contact, a digit a contact of that force.
  explicit Pattern(const std::vector<std::string>& rows)
      : Pattern(static_cast<int>(rows[0].size()), static_cast<int>(rows.size())) {
    for (int step = 0; step < steps; ++step)
      for (int node = 0; node < nodes; ++node)
        if (rows[step][node] != '.') at(step, node) = rows[step][node] - '0';
  }
  double& at(int step, int node) { return force[static_cast<std::size_t>(step) * nodes + node]; }
  double at(int step, int node) const {
    return force[static_cast<std::size_t>(step) * nodes + node];
  }
  bool touches(int step, int node) const {
    return step >= 0 && step < steps && node >= 0 && node < nodes && at(step, node) >= 0;
  }
  static double position(int step) { return 100 + 0.25 * step; }
  int along(int node) const { return row == 0 ? node : node % row; }
  int across(int node) const { return row == 0 ? 0 : node / row; }
  /// From a node to itself and its neighbours.
  std::vector<int> asides() const {
    if (row == 0) return {-1, 0, 1};
    return {-row - 1, -row, -row + 1, -1, 0, 1, row - 1, row, row + 1};
  }
};

/// A scene's state with the buffers of shocks alone, of the sizes that a scene has.
class Tracker {
 public:
  explicit Tracker(int nodes, int shock_capacity = 1000) {
    s.work.runs.capacity = nodes / 2 + 2;
    s.out.ended_shocks.capacity = shock_capacity;
    runs_.resize(s.work.runs.capacity);
    new_runs_.resize(s.work.runs.capacity);
    open_.resize(2 * s.work.runs.capacity);
    rows_.resize(shock_capacity);
    touched_.resize(nodes);
    forces_.resize(nodes);
    s.carried.shocks.runs = runs_.data();
    s.work.runs.next = new_runs_.data();
    s.carried.shocks.open = open_.data();
    s.out.ended_shocks.rows = rows_.data();
    s.work.contact_list.nodes = touched_.data();
    s.work.contact_list.forces = forces_.data();
  }
  Tracker(const Tracker&) = delete;

  /// One step. Whether continue_shocks was enough.
  bool take(const Pattern& pattern, int step, bool may_continue) {
    const int count = list(pattern, step);
    if (count == 0) {
      if (s.carried.shocks.open_count > 0) end_shocks(s.carried.shocks, s.out.ended_shocks, step);
      return false;
    }
    if (may_continue) {
      const auto open = open_shocks();
      const auto runs = contact_runs();
      const auto ended = s.out.ended_shocks.count;
      if (continue_shocks(s.carried.shocks, s.work.runs, s.work.contact_list, count, step,
                          Pattern::position(step)))
        return true;
      EXPECT_EQ(open, open_shocks()) << "changed by a continuation that failed";
      EXPECT_EQ(runs, contact_runs());
      EXPECT_EQ(ended, s.out.ended_shocks.count);
    }
    track_shocks(s.carried.shocks, s.work.runs, s.out.ended_shocks, s.work.contact_list, count,
                 step, Pattern::position(step));
    return false;
  }
  /// One step as the march makes it, with a list of nodes from `first` on, which may be a new one.
  /// Whether the contact lasted.
  bool take_steadily(const Pattern& pattern, int step, int first, bool is_new) {
    if (is_new) steady_.begin_list();
    ListedContact listed;
    std::uint32_t bit = 1;
    for (int node = first; node < pattern.nodes; ++node, bit <<= 1)
      if (pattern.touches(step, node))
        listed.add(bit, steady_.second(), node, pattern.at(step, node));
    if (steady_.lasts_to(step) && steady_.take(listed, Pattern::position(step))) return true;

    const int count = list(pattern, step);
    if (count > 0) {
      take_contact(HostLanes(), steady_, s.carried.shocks, s.work.runs, s.out.ended_shocks,
                   s.work.contact_list, count, step, Pattern::position(step));
    } else if (s.carried.shocks.open_count > 0) {
      put_back();
      end_shocks(s.carried.shocks, s.out.ended_shocks, step);
    }
    steady_.hold(listed.nodes, pattern.nodes - first);
    return false;
  }
  void put_back() { steady_.put_back(s.carried.shocks, true); }
  void take_all(const Pattern& pattern, bool may_continue = false) {
    for (int step = 0; step <= pattern.steps; ++step) take(pattern, step, may_continue);
  }

  std::vector<ShockRow> rows() const {
    return {s.out.ended_shocks.rows, s.out.ended_shocks.rows + s.out.ended_shocks.count};
  }
  std::vector<ShockRow> rows_by_serial() const {
    std::vector<ShockRow> sorted = rows();
    std::sort(sorted.begin(), sorted.end(),
              [](const ShockRow& a, const ShockRow& b) { return a.serial < b.serial; });
    return sorted;
  }
  std::vector<OpenShock> open_shocks() const {
    return {s.carried.shocks.open, s.carried.shocks.open + s.carried.shocks.open_count};
  }
  std::vector<ContactRun> contact_runs() const {
    return {s.carried.shocks.runs, s.carried.shocks.runs + s.carried.shocks.run_count};
  }

  SceneState s;

 private:
  /// The nodes in contact at a step. Their number.
  int list(const Pattern& pattern, int step) {
    int count = 0;
    for (int node = 0; node < pattern.nodes; ++node)
      if (pattern.touches(step, node)) {
        s.work.contact_list.nodes[count] = node;
        s.work.contact_list.forces[count++] = pattern.at(step, node);
      }
    return count;
  }

  SteadyShocks steady_;
  std::vector<ContactRun> runs_, new_runs_;
  std::vector<OpenShock> open_;
  std::vector<ShockRow> rows_;
  std::vector<int> touched_;
  std::vector<double> forces_;
};

// ---- brute force ------------------------------------------------------------------------------

/// Flood fill over (step, node) up to a step: neighbours stand next to each other at the same step,
/// or no further than one node apart at the next, and in areal scenes one row. 0 where there is no
/// contact.
std::vector<int> flood(const Pattern& pattern, int until) {
  std::vector<int> label(pattern.force.size(), 0);
  int labels = 0;
  std::deque<std::pair<int, int>> edge;
  const auto visit = [&](int step, int node) {
    int& mark = label[static_cast<std::size_t>(step) * pattern.nodes + node];
    if (mark != 0) return;
    mark = labels;
    edge.emplace_back(step, node);
  };
  for (int step = 0; step <= until && step < pattern.steps; ++step)
    for (int node = 0; node < pattern.nodes; ++node) {
      if (!pattern.touches(step, node) ||
          label[static_cast<std::size_t>(step) * pattern.nodes + node] != 0)
        continue;
      ++labels;
      visit(step, node);
      for (; !edge.empty(); edge.pop_front())
        for (int ahead = -1; ahead <= 1; ++ahead)
          for (const int aside : pattern.asides()) {
            const int there = edge.front().first + ahead, next = edge.front().second + aside;
            if (there <= until && pattern.touches(there, next)) visit(there, next);
          }
    }
  return label;
}

/// First and last nodes of the runs of neighbouring nodes at a step.
std::vector<std::pair<int, int>> runs_at(const Pattern& pattern, int step) {
  std::vector<std::pair<int, int>> runs;
  for (int node = 0; node < pattern.nodes; ++node) {
    if (!pattern.touches(step, node)) continue;
    if (pattern.touches(step, node - 1))
      runs.back().second = node;
    else
      runs.emplace_back(node, node);
  }
  return runs;
}

std::vector<ShockRow> expected_shocks(const Pattern& pattern) {
  const std::vector<int> whole = flood(pattern, pattern.steps);
  std::map<int, ShockRow> shocks;  // by label
  const auto place = [&](int step, int node) {
    return static_cast<std::size_t>(step) * pattern.nodes + node;
  };
  std::int64_t serial = 0;
  for (int step = 0; step < pattern.steps; ++step) {
    // a run that continues nothing takes the next number, its shock keeps the first that it gets
    for (const auto& [first, last] : runs_at(pattern, step)) {
      bool continues = false;
      for (int node = first; node <= last; ++node)
        for (const int aside : pattern.asides())
          continues = continues || pattern.touches(step - 1, node + aside) ||
                      (aside < -1 && pattern.touches(step, node + aside));
      if (continues) continue;
      ShockRow begun{.serial = serial++, .start = step, .last = step};
      begun.row = pattern.across(first);
      shocks.try_emplace(whole[place(step, first)], begun);
    }
    // what had met by this step counts as one shock: the peak is the largest force of such a one
    const std::vector<int> now = flood(pattern, step);
    std::map<int, double> force;
    for (int node = 0; node < pattern.nodes; ++node)
      if (pattern.touches(step, node)) {
        const double f = pattern.at(step, node);
        force[now[place(step, node)]] += f;
        ShockRow& shock = shocks.at(whole[place(step, node)]);
        shock.last = step;
        shock.impulse += f;
        shock.moment += f * (pattern.along(node) + Pattern::position(step));
        shock.across_moment += f * pattern.across(node);
      }
    for (int node = 0; node < pattern.nodes; ++node)
      if (pattern.touches(step, node)) {
        ShockRow& shock = shocks.at(whole[place(step, node)]);
        shock.peak = std::max(shock.peak, force[now[place(step, node)]]);
      }
  }
  std::vector<ShockRow> out;
  for (const auto& [label, shock] : shocks) out.push_back(shock);
  std::sort(out.begin(), out.end(),
            [](const ShockRow& a, const ShockRow& b) { return a.serial < b.serial; });
  return out;
}

/// Whether the runs of a step pair off with those of the step before, in order, with no other
/// neighbour.
bool pairs_off(const Pattern& pattern, int step) {
  const auto before = runs_at(pattern, step - 1), now = runs_at(pattern, step);
  if (before.size() != now.size()) return false;
  for (std::size_t i = 0; i < now.size(); ++i)
    for (std::size_t j = 0; j < before.size(); ++j) {
      const bool touch =
          before[j].second >= now[i].first - 1 && before[j].first <= now[i].second + 1;
      if (touch != (i == j)) return false;
    }
  return true;
}

enum class Kind { noise, slow };

/// Noise: every (step, node) by itself. Slow: each node keeps its contact for a while.
Pattern random_pattern(std::mt19937& random, Kind kind) {
  const auto chance = [&](double p) { return std::bernoulli_distribution(p)(random); };
  const int nodes = std::uniform_int_distribution<int>(1, 14)(random);
  const int steps = std::uniform_int_distribution<int>(1, 30)(random);
  const double density = std::uniform_real_distribution<double>(0.02, 0.8)(random);
  Pattern pattern(nodes, steps);
  for (int step = 0; step < steps; ++step)
    for (int node = 0; node < nodes; ++node) {
      const bool keeps = kind == Kind::slow && step > 0 && !chance(0.06);
      const bool touches = keeps ? pattern.touches(step - 1, node) : chance(density);
      if (touches) pattern.at(step, node) = std::uniform_int_distribution<int>(0, 7)(random);
    }
  return pattern;
}

/// A random pattern on several rows, each with a node of padding.
Pattern random_areal_pattern(std::mt19937& random, Kind kind) {
  const Pattern plain = random_pattern(random, kind);
  const int rows = std::uniform_int_distribution<int>(1, 6)(random);
  const int row = std::max(2, plain.nodes / 2);
  Pattern pattern(rows * row, plain.steps);
  pattern.row = row;
  for (int step = 0; step < plain.steps; ++step)
    for (int node = 0; node < pattern.nodes; ++node)
      if (node % row != row - 1 && plain.touches(step, (7 * node + node / row) % plain.nodes))
        pattern.at(step, node) = plain.at(step, (7 * node + node / row) % plain.nodes);
  return pattern;
}

std::string picture(const Pattern& pattern) {
  std::string text;
  for (int step = 0; step < pattern.steps; ++step) {
    for (int node = 0; node < pattern.nodes; ++node)
      text += pattern.touches(step, node) ? std::to_string(static_cast<int>(pattern.at(step, node)))
                                          : ".";
    text += '\n';
  }
  return text;
}

// ---- by hand ----------------------------------------------------------------------------------

/// serial, start and last of each shock, by serial.
std::vector<std::vector<std::int64_t>> spans(const std::vector<std::string>& rows) {
  const Pattern pattern(rows);
  Tracker tracker(pattern.nodes);
  tracker.take_all(pattern);
  EXPECT_EQ(tracker.rows_by_serial(), expected_shocks(pattern)) << picture(pattern);
  std::vector<std::vector<std::int64_t>> out;
  for (const ShockRow& row : tracker.rows_by_serial())
    out.push_back({row.serial, row.start, row.last});
  return out;
}
using Spans = std::vector<std::vector<std::int64_t>>;

TEST(Shocks, OneNodeOneStep) {
  const Pattern pattern({"...", ".3.", "..."});
  Tracker tracker(3);
  tracker.take_all(pattern);
  // position of node 1 at step 1: 100.25 + 1
  EXPECT_EQ(tracker.rows(), std::vector<ShockRow>({{0, 1, 1, 3, 3, 3 * 101.25}}));
  EXPECT_EQ(tracker.s.carried.shocks.open_count, 0);
  EXPECT_EQ(tracker.s.carried.shocks.begun, 1);
}

TEST(Shocks, PeakImpulseAndMomentAreSumsOverNodesAndSteps) {
  const Pattern pattern({"12.", "34.", "5.."});
  Tracker tracker(3);
  tracker.take_all(pattern);
  const double moment = 1 * 100 + 2 * 101 + 3 * 100.25 + 4 * 101.25 + 5 * 100.5;
  EXPECT_EQ(tracker.rows(), std::vector<ShockRow>({{0, 0, 2, 7, 15, moment}}));
}

TEST(Shocks, TouchingAtExactlyZeroIsAShockWithoutForce) {
  const Pattern pattern({"0"});
  Tracker tracker(1);
  tracker.take_all(pattern);
  EXPECT_EQ(tracker.rows(), std::vector<ShockRow>({{0, 0, 0, 0, 0, 0}}));
}

TEST(Shocks, NeighboursAreOneAndAGapOfOneNodeSeparates) {
  EXPECT_EQ(spans({".11."}), Spans({{0, 0, 0}}));
  EXPECT_EQ(spans({"1.1."}), Spans({{0, 0, 0}, {1, 0, 0}}));
}

TEST(Shocks, DiagonalNeighboursInSpaceAndTimeAreOne) {
  EXPECT_EQ(spans({"1...", ".1..", "..1.", ".1.."}), Spans({{0, 0, 3}}));
  EXPECT_EQ(spans({"1...", "..1."}), Spans({{0, 0, 0}, {1, 1, 1}}));
}

TEST(Shocks, AStepWithoutContactEndsAShock) {
  EXPECT_EQ(spans({"1", ".", "1"}), Spans({{0, 0, 0}, {1, 2, 2}}));
  EXPECT_EQ(spans({"1.1", "..1", "1.1"}), Spans({{0, 0, 0}, {1, 0, 2}, {2, 2, 2}}));
}

TEST(Shocks, OlderSurvivesAMerge) {
  EXPECT_EQ(spans({"1...1", "1...1", "11.11", ".111."}), Spans({{0, 0, 3}}));
  EXPECT_EQ(spans({"....1", "1...1", ".111."}), Spans({{0, 0, 2}}));
}

TEST(Shocks, MergedPeakIsTheLargerUntilTheyMetAndTheSumSince) {
  const auto peak = [](const std::vector<std::string>& rows) {
    const Pattern pattern(rows);
    Tracker tracker(pattern.nodes);
    tracker.take_all(pattern);
    EXPECT_EQ(tracker.s.out.ended_shocks.count, 1);
    return tracker.rows().at(0).peak;
  };
  EXPECT_EQ(peak({"5.7", "111"}), 7);
  EXPECT_EQ(peak({"5.7", "555"}), 15);
  EXPECT_EQ(peak({"5.7", "111", "5.7"}), 12);  // apart again, but one shock since they met
}

TEST(Shocks, SplitsStayOne) {
  EXPECT_EQ(spans({"111", "1.1", "1.1"}), Spans({{0, 0, 2}}));
  EXPECT_EQ(spans({"111", "1.1", "1..", "1.."}), Spans({{0, 0, 3}}));
}

TEST(Shocks, SplitAndMergedAgainIsOne) {
  EXPECT_EQ(spans({"111..", "1.1..", "1.1..", "111..", "1.1.1", "1.111", "1...."}),
            Spans({{0, 0, 6}}));
}

TEST(Shocks, ThreeMergeAtOnce) {
  EXPECT_EQ(spans({"..1..", "1.1.1", "11111"}), Spans({{0, 0, 2}}));
  EXPECT_EQ(spans({"1.1.1", ".1.1."}), Spans({{0, 0, 1}}));
}

TEST(Shocks, SerialsCountStartsAndMergedOnesLeaveHoles) {
  EXPECT_EQ(spans({"1.1..", ".1...", "....1"}), Spans({{0, 0, 1}, {2, 2, 2}}));
}

TEST(Shocks, EndedOnesAreHandedOutAtTheStepAfter) {
  const Pattern pattern({"1.1", "1..", "..."});
  Tracker tracker(3);
  tracker.take(pattern, 0, false);
  EXPECT_EQ(tracker.s.out.ended_shocks.count, 0);
  EXPECT_EQ(tracker.s.carried.shocks.open_count, 2);
  tracker.take(pattern, 1, false);
  EXPECT_EQ(tracker.rows(), std::vector<ShockRow>({{1, 0, 0, 1, 1, 102}}));
  ASSERT_EQ(tracker.s.carried.shocks.open_count, 1);
  EXPECT_EQ(tracker.s.carried.shocks.open[0].serial, 0);
  tracker.take(pattern, 2, false);
  EXPECT_EQ(tracker.s.out.ended_shocks.count, 2);
  EXPECT_EQ(tracker.s.carried.shocks.open_count, 0);
}

TEST(Shocks, AllNodesAtOnce) {
  const Pattern pattern({"1111111", "1.1.1.1", "......."});
  Tracker tracker(7);
  tracker.take_all(pattern);
  EXPECT_EQ(tracker.rows().size(), 1);
  EXPECT_EQ(tracker.rows()[0].impulse, 11);
}

TEST(Shocks, ContactOfLongListsDoesNotLast) {
  // nodes 33 and on have no bit of their own
  for (const int nodes : {32, 33}) {
    Pattern pattern(nodes, 4);
    for (int step = 0; step < pattern.steps; ++step) {
      pattern.at(step, 2) = 1;
      if (step == 3) pattern.at(step, nodes - 1) = 1;
    }
    Tracker tracker(nodes);
    for (int step = 0; step < pattern.steps; ++step)
      EXPECT_EQ(tracker.take_steadily(pattern, step, 0, false),
                nodes == 32 && (step == 1 || step == 2))
          << nodes << " nodes, step " << step;
    tracker.put_back();
    EXPECT_EQ(tracker.s.carried.shocks.begun, 2) << nodes;
  }
}

// ---- at random --------------------------------------------------------------------------------

class RandomShocks : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Shocks, RandomShocks, testing::Values(Kind::noise, Kind::slow),
                         [](const auto& info) {
                           return info.param == Kind::noise ? "Noise" : "Slow";
                         });

TEST_P(RandomShocks, AreTheConnectedPiecesOfContact) {
  std::mt19937 random(11);
  int shocks = 0, merged = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Pattern pattern = random_pattern(random, GetParam());
    Tracker tracker(pattern.nodes);
    tracker.take_all(pattern);
    const std::vector<ShockRow> expected = expected_shocks(pattern);
    ASSERT_EQ(tracker.rows_by_serial(), expected) << picture(pattern);
    EXPECT_EQ(tracker.s.carried.shocks.open_count, 0);
    const std::vector<ShockRow> rows = tracker.rows();
    EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end(), [](const ShockRow& a, const ShockRow& b) {
      return a.last < b.last;
    })) << "in order of their end";
    shocks += static_cast<int>(expected.size());
    merged += static_cast<int>(tracker.s.carried.shocks.begun) - static_cast<int>(expected.size());
  }
  EXPECT_GT(shocks, 1500);  // the patterns must not be so dense, or so thin, that nothing is tried
  EXPECT_GT(merged, 100);
}

TEST_P(RandomShocks, OpenShocksAreThePiecesThatReachThePresent) {
  std::mt19937 random(12);
  for (int trial = 0; trial < 300; ++trial) {
    const Pattern pattern = random_pattern(random, GetParam());
    Tracker tracker(pattern.nodes);
    for (int step = 0; step < pattern.steps; ++step) {
      tracker.take(pattern, step, false);
      const std::vector<int> label = flood(pattern, step);
      std::map<int, double> force;
      for (int node = 0; node < pattern.nodes; ++node)
        if (pattern.touches(step, node))
          force[label[static_cast<std::size_t>(step) * pattern.nodes + node]] +=
              pattern.at(step, node);
      std::vector<double> expected, found;
      for (const auto& [which, sum] : force) expected.push_back(sum);
      for (const OpenShock& open : tracker.open_shocks()) {
        EXPECT_EQ(open.last, step);
        found.push_back(open.force);
      }
      ASSERT_THAT(found, testing::UnorderedElementsAreArray(expected)) << picture(pattern);
    }
  }
}

TEST_P(RandomShocks, ContinuingAgreesWithTracking) {
  std::mt19937 random(13);
  int continued = 0, contact = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Pattern pattern = random_pattern(random, GetParam());
    Tracker one(pattern.nodes), other(pattern.nodes);
    for (int step = 0; step <= pattern.steps; ++step) {
      const bool usual = pairs_off(pattern, step) && !runs_at(pattern, step).empty() &&
                         other.s.carried.shocks.open_count == other.s.carried.shocks.run_count;
      one.take(pattern, step, false);
      ASSERT_EQ(other.take(pattern, step, true), usual) << "step " << step << '\n'
                                                        << picture(pattern);
      continued += usual;
      contact += !runs_at(pattern, step).empty();
      ASSERT_EQ(one.open_shocks(), other.open_shocks()) << "step " << step << '\n'
                                                        << picture(pattern);
      ASSERT_EQ(one.rows(), other.rows());
      ASSERT_EQ(one.s.carried.shocks.begun, other.s.carried.shocks.begun);
      if (runs_at(pattern, step).empty()) continue;  // the runs are then of no step that counts
      ASSERT_EQ(one.contact_runs(), other.contact_runs());
      ASSERT_EQ(one.s.carried.shocks.runs_step, other.s.carried.shocks.runs_step);
    }
  }
  EXPECT_GT(continued, contact / 50);  // both ways are tried
  EXPECT_LT(continued, contact);
}

TEST_P(RandomShocks, SteadyOnesAgreeWithTracking) {
  std::mt19937 random(19);
  int steady = 0, lasted = 0, contact = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Pattern pattern = trial % 4 == 0 ? random_areal_pattern(random, GetParam())
                                           : random_pattern(random, GetParam());
    const double share = std::uniform_real_distribution<double>(0.0, 0.5)(random);
    Tracker one(pattern.nodes), other(pattern.nodes);
    one.s.work.runs.row = other.s.work.runs.row = pattern.row;
    int first = 0;  // of the list: any node up to the first in contact
    for (int step = 0; step <= pattern.steps; ++step) {
      one.take(pattern, step, false);
      const auto runs = runs_at(pattern, step);
      const int most = runs.empty() ? 0 : runs[0].first;
      const bool is_new = first > most || random() % 3 == 0;
      if (is_new) first = std::uniform_int_distribution<int>(0, most)(random);
      lasted += other.take_steadily(pattern, step, first, is_new);
      const bool touches = !runs_at(pattern, step).empty();
      contact += touches;
      steady += touches && other.s.carried.shocks.runs_step != step;
      ASSERT_EQ(one.rows(), other.rows()) << "step " << step << '\n' << picture(pattern);
      ASSERT_EQ(one.s.carried.shocks.begun, other.s.carried.shocks.begun);
      if (step < pattern.steps && !std::bernoulli_distribution(share)(random)) continue;
      other.put_back();
      ASSERT_EQ(one.open_shocks(), other.open_shocks()) << "step " << step << '\n'
                                                        << picture(pattern);
    }
  }
  EXPECT_GT(lasted, contact / 100);  // all ways are tried
  EXPECT_GT(steady, lasted + contact / 200);
  EXPECT_LT(steady, contact);
}

TEST_P(RandomShocks, StretchesAreTheirSteps) {
  // steps in a row in which the same nodes touch, taken at once: all but the peak, which only who
  // knows the force within the stretch can tell
  std::mt19937 random(15);
  int longer = 0, merged = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Pattern pattern = trial % 2 == 0 ? random_pattern(random, GetParam())
                                           : random_areal_pattern(random, GetParam());
    const auto same = [&](int a, int b) {
      for (int node = 0; node < pattern.nodes; ++node)
        if (pattern.touches(a, node) != pattern.touches(b, node)) return false;
      return true;
    };
    Tracker tracker(pattern.nodes);
    tracker.s.work.runs.row = pattern.row;
    for (int first = 0, last = 0; first <= pattern.steps; first = last = last + 1) {
      // any part of such a stretch will do
      while (last < pattern.steps && same(first, last + 1) && random() % 8 != 0) ++last;
      SceneState& s = tracker.s;
      int count = 0;
      std::vector<double> moments;
      for (int node = 0; node < pattern.nodes; ++node) {
        if (!pattern.touches(first, node)) continue;
        double force = 0, moment = 0;
        for (int step = first; step <= last; ++step) {
          force += pattern.at(step, node);
          moment += pattern.at(step, node) * (pattern.along(node) + Pattern::position(step) - 100);
        }
        s.work.contact_list.nodes[count] = node;
        s.work.contact_list.forces[count++] = force;
        moments.push_back(moment);
      }
      if (count == 0)
        end_shocks(s.carried.shocks, s.out.ended_shocks, first);
      else
        join_shocks(s.carried.shocks, s.work.runs, s.out.ended_shocks, s.work.contact_list, count,
                    first, last, 100, [&](int e) { return moments[e]; });
      longer += count > 0 && last > first;
    }
    std::vector<ShockRow> expected = expected_shocks(pattern);
    for (ShockRow& row : expected) row.peak = 0;
    ASSERT_EQ(tracker.rows_by_serial(), expected) << picture(pattern);
    EXPECT_EQ(tracker.s.carried.shocks.open_count, 0);
    merged += static_cast<int>(tracker.s.carried.shocks.begun) - static_cast<int>(expected.size());
  }
  EXPECT_GT(longer, 300);
  EXPECT_GT(merged, 100);
}

TEST_P(RandomShocks, NothingIsLostThroughTheSmallestBuffer) {
  std::mt19937 random(14);
  for (int trial = 0; trial < 300; ++trial) {
    const Pattern pattern = random_pattern(random, GetParam());
    Tracker tracker(pattern.nodes, pattern.nodes / 2 + 3);  // one more than a step can end
    std::vector<ShockRow> drained;
    int drains = 0;
    for (int step = 0; step <= pattern.steps; ++step) {
      if (!can_record_shocks(tracker.s.out.ended_shocks, tracker.s.work.runs)) {
        const auto rows = tracker.rows();
        drained.insert(drained.end(), rows.begin(), rows.end());
        tracker.s.out.ended_shocks.count = 0;
        ++drains;
        ASSERT_TRUE(can_record_shocks(tracker.s.out.ended_shocks, tracker.s.work.runs));
      }
      tracker.take(pattern, step, step % 2 == 0);
      ASSERT_LE(tracker.s.out.ended_shocks.count, tracker.s.out.ended_shocks.capacity);
      ASSERT_LE(tracker.s.carried.shocks.open_count, tracker.s.work.runs.capacity);
    }
    const auto rows = tracker.rows();
    drained.insert(drained.end(), rows.begin(), rows.end());
    std::sort(drained.begin(), drained.end(),
              [](const ShockRow& a, const ShockRow& b) { return a.serial < b.serial; });
    ASSERT_EQ(drained, expected_shocks(pattern)) << picture(pattern);
    EXPECT_LE(drains, static_cast<int>(drained.size()));
  }
}

TEST_P(RandomShocks, OnRowsAreThoseOfABruteForceSearch) {
  std::mt19937 random(16);
  int merged = 0, crossed = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Pattern pattern = random_areal_pattern(random, GetParam());
    Tracker tracker(pattern.nodes);
    tracker.s.work.runs.row = pattern.row;
    tracker.take_all(pattern, trial % 2 == 0);
    const std::vector<ShockRow> expected = expected_shocks(pattern);
    ASSERT_EQ(tracker.rows_by_serial(), expected) << pattern.row << '\n' << picture(pattern);
    EXPECT_EQ(tracker.s.carried.shocks.open_count, 0);
    merged += static_cast<int>(tracker.s.carried.shocks.begun) - static_cast<int>(expected.size());
    Pattern one_row = pattern;
    one_row.row = 0;
    crossed += expected_shocks(one_row).size() != expected.size();
  }
  EXPECT_GT(merged, 300);
  EXPECT_GT(crossed, 1000);
}

TEST(Shocks, OnRowsTheEightNeighboursAreOne) {
  // rows of four nodes and one of padding, at two steps
  const auto shocks = [](std::vector<std::string> steps) {
    for (std::string& step : steps) std::erase(step, ' ');
    Pattern pattern(steps);
    pattern.row = 5;
    Tracker tracker(pattern.nodes);
    tracker.s.work.runs.row = 5;
    tracker.take_all(pattern);
    return tracker.rows().size();
  };
  EXPECT_EQ(shocks({"1.... .1... .1..."}), 1u);  // diagonal, then below
  EXPECT_EQ(shocks({"...1. 1...."}), 2u);        // the end of a row and the next one's beginning
  EXPECT_EQ(shocks({"1.1.. .1..."}), 1u);        // two that meet in the next row
  EXPECT_EQ(shocks({"1.... ..... 1...."}), 2u);  // two rows apart
  EXPECT_EQ(shocks({"1.... .....", "..... .1..."}), 1u);  // diagonal, a step later
  EXPECT_EQ(shocks({"..... .1...", "1.... ....."}), 1u);
  EXPECT_EQ(shocks({"..... ..1..", "1.... ....."}), 2u);
}

TEST(Shocks, AStepCanEndEveryOtherNodesShock) {
  const Pattern pattern({"1.1.1.1.1", ".........", "1.1.1.1.1", "........."});
  Tracker tracker(9, 9 / 2 + 2 + 1);
  ASSERT_TRUE(can_record_shocks(tracker.s.out.ended_shocks, tracker.s.work.runs));
  tracker.take(pattern, 0, true);
  tracker.take(pattern, 1, true);
  EXPECT_EQ(tracker.s.out.ended_shocks.count, 5);
  EXPECT_FALSE(can_record_shocks(tracker.s.out.ended_shocks, tracker.s.work.runs));
}

}  // namespace
