// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/body/beam.hpp"
#include "kernels/gap.hpp"
#include "kernels/limits.hpp"
#include "tests/effort.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

/// Leaving out the nodes that cannot touch changes nothing: `nodes = "candidates"` and `nodes =
/// "all"` are compared bit for bit, and both with a march written plainly here.
namespace ra2d::test {
namespace {

/// A steel plate under a short block, 20 um per node.
Scene plate_and_block() {
  Scene s = plate_scene(12, 0.004, 0.004);
  s.speed = 0.2;
  s.spacing = 2e-5;
  s.contact.stiffness = 1e15;
  return s;
}

TEST(Candidates, RandomScenesAreTheSameBitForBit) {
  const int scenes = draws(60);
  int touching = 0, in_and_out = 0;
  double evaluated = 0, steps_nodes = 0;
  for (int seed = 1; seed <= scenes; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Started c = random_scene(seed);
    const Outcome all = march(c.model, c.start, Nodes::all);
    const Outcome some = march(c.model, c.start, Nodes::candidates);
    EXPECT_TRUE(same(all, some));
    touching += all.end.contact_steps > 0;
    in_and_out += all.end.shocks_begun >= 5;
    evaluated += static_cast<double>(some.end.evaluated);
    steps_nodes += static_cast<double>(all.end.evaluated);
  }
  if (!draws_enough()) return;
  // the scenes do what they are for: most of them touch, many part and meet again, most nodes are
  // left out
  EXPECT_GE(touching, scenes * 2 / 3);
  EXPECT_GE(in_and_out, scenes / 3);
  EXPECT_LT(evaluated, 0.5 * steps_nodes);
}

TEST(Candidates, CoarsestSpacingThatIsTaken) {
  Scene s = plate_and_block();
  s.spacing = 1e-4;
  s.speed = 5;
  s.slider.support = Support::free;
  s.slider.load = 5;
  s.resonator.surface = gaussian(2e-6, 8e-4, 11);
  s.slider.surface = gaussian(2e-6, 8e-4, 12);
  s.contact.stiffness = 1e13;
  // as many modes as the displacement series can follow at this spacing
  for (int modes = 90; modes > 5; --modes) {
    s.resonator.modes = modes;
    const Model model = make_model(s);
    const ModalStart start = make_start(model);
    try {
      const Batch probe({model}, {start});
    } catch (const RequestError&) {
      continue;
    }
    SCOPED_TRACE(std::to_string(modes) + " modes");
    EXPECT_GT(expect_both_same(model, start).end.shocks_begun, 3);
    return;
  }
  FAIL() << "no number of modes is taken";
}

// ---- scenes that a culling that guesses gets wrong
// -----------------------------------------------------

TEST(Candidates, OneNodePeakArrivesAtHighSpeed) {
  for (const double nodes_per_step : {0.03, 0.31, 0.97, 1.0, 1.37, 3.7}) {
    SCOPED_TRACE(nodes_per_step);
    Scene s = plate_and_block();
    s.speed = nodes_per_step * s.spacing / s.time.step;
    s.duration = 0.03 / s.speed;
    s.start = 0.005;
    // half as wide as the spacing: a single node on either side
    s.resonator.surface = peaks({{.at = 0.0300, .height = 2e-5, .half_width = 1e-5}});
    s.slider.surface = peaks({{.at = 0.0020, .height = 2e-5, .half_width = 1e-5},
                              {.at = 0.0040, .height = 2e-5, .half_width = 1e-5}});
    s.gap = 3e-5;
    s.contact.stiffness = 1e13;
    const Model model = make_model(s);
    const Outcome all = expect_both_same(model, make_start(model));
    // at a whole number of nodes a step they meet for sure, at more than one they may pass unseen
    if (nodes_per_step <= 1) {
      EXPECT_GE(all.end.contact_steps, 1);
    }
  }
}

TEST(Candidates, HugeVelocityCrossesALargeGapWithinOneForecast) {
  for (const double steps_to_cross : {0.5, 3.0, 30.0, 300.0, 3000.0}) {
    for (const int mode : {0, 1, 7, 11}) {
      SCOPED_TRACE(std::to_string(steps_to_cross) + " steps, mode " + std::to_string(mode));
      Scene s = plate_and_block();
      s.gap = 1e-3;
      s.start = 0.027;
      s.duration = 1e-3;
      s.contact.stiffness = 1e12;
      const Model model = make_model(s);
      ModalStart start = make_start(model);
      start.resonator_v[mode] =
          1e-3 / (steps_to_cross * s.time.step) / model.resonator.modes[mode].shape->largest();
      count_energy(model, start);
      const Outcome all = expect_both_same(model, start);
      if (steps_to_cross <= 30 && mode == 0) {
        EXPECT_GT(all.end.contact_steps, 0);
      }
    }
  }
}

TEST(Candidates, SliderThrownAtThePlate) {
  for (const double speed : {0.01, 1.0, 100.0, 1e4}) {
    SCOPED_TRACE(speed);
    Scene s = plate_and_block();
    s.gap = 1e-4;
    s.slider.support = Support::free;
    s.slider.modes = 2;
    s.slider.surface = gaussian(1e-6, 2e-4, 5);
    const Model model = make_model(s);
    ModalStart start = make_start(model);
    start.slider_v[0] = speed * std::sqrt(s.slider.length);
    start.slider_v[1] = -0.3 * start.slider_v[0];  // tumbling
    count_energy(model, start);
    EXPECT_EQ(expect_both_same(model, start).end.contact_steps > 0, speed > 0.05);
  }
}

TEST(Candidates, MovingForceArrivesSuddenly) {
  Scene s = plate_and_block();
  s.speed = 0.05;
  s.gap = 5e-6;
  s.slider.surface = gaussian(5e-7, 2e-4, 3);
  for (const double start : {-1e-5, -5e-3, 0.0299}) {
    SCOPED_TRACE(start);
    // before it stands on the beam, nothing moves at all
    s.resonator.moving_forces = {{.force = 40, .speed = 20, .start = start}};
    const Model model = make_model(s);
    EXPECT_GT(expect_both_same(model, make_start(model)).end.shocks_begun, 3);
  }
}

TEST(Candidates, ModeSwingsTheFarEndIntoContact) {
  // the block's left peak rests on the plate; the plate's mode is blown up where the other peak is
  for (const int mode : {3, 6, 11}) {
    SCOPED_TRACE(mode);
    Scene s = plate_and_block();
    s.speed = 0;
    s.start = 0.0187;  // none of these modes has a node where the slider ends
    s.slider.length = 0.03;
    s.slider.surface = peaks({{.at = 0, .height = 1e-5, .half_width = 2e-5},
                              {.at = 0.03, .height = 7e-6, .half_width = 2e-5}});
    s.gap = 1e-5 - 1e-8;
    s.contact.stiffness = 1e14;
    const Model model = make_model(s);
    ModalStart start = make_start(model);
    start.resonator_v[mode] =
        1e-5 * model.resonator.modes[mode].omega / model.resonator.modes[mode].shape->largest();
    count_energy(model, start);
    const Outcome all = expect_both_same(model, start);
    EXPECT_GE(all.end.most_nodes, 2);
  }
}

TEST(Candidates, CubicsAreOffByManyStepsOfAFineMarch) {
  // A peak above a plate that swings up in its only mode. Towards the edge of a patch its cubic,
  // and the cubic's rate, are below the plate's by some 1e-3; a step is a far smaller part of the
  // amplitude.
  Scene s = plate_scene(1, 0.004, 0.001);
  s.spacing = 2e-5;
  s.speed = 0;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 1e-5}});
  s.contact.stiffness = 1e13;
  const BodyMode mode = make_body(s.resonator).modes[0];
  const double amplitude = 1e-4;  // m, where the peak is
  // the gap, as a share of the amplitude: far up, and as far as the plate moves in one forecast
  // from rest
  for (const auto& [phase_of_a_step, gap] : {std::pair{1e-5, 0.3}, std::pair{1e-7, 3e-4}}) {
    s.time.step = phase_of_a_step / mode.omega;
    s.duration = 1.2 * gap / mode.omega;
    s.output.rate = 1 / s.duration;
    s.gap = 1e-5 + gap * amplitude;
    for (double start = 0.01; start < 0.05; start += 0.0017) {
      SCOPED_TRACE(testing::Message() << "gap " << gap << ", start " << start);
      s.start = start;
      const double psi = shape_at(mode, start + 0.002);
      const Model model = make_model(s);
      ModalStart at = make_start(model);
      at.resonator_v[0] = amplitude / psi * mode.omega;
      count_energy(model, at);
      EXPECT_GE(expect_both_same(model, at).end.shocks_begun, 1);
    }
  }
}

TEST(Candidates, ForceThatSetsOutFromRest) {
  // Motion that accelerates from rest is further off after a forecast's time than an even one.
  Scene s = plate_scene(1, 0.004, 0.001);
  s.spacing = 2e-5;
  s.speed = 0;
  s.start = 0.028;
  s.contact.stiffness = 1e12;
  s.resonator.moving_forces = {{.force = 10, .speed = 0, .start = 0.03}};
  s.time.step = 1e-8;
  const double longest = longest_flight * s.time.step;
  s.duration = 5 * longest;
  s.output.rate = 1 / s.duration;
  const Body plate = make_body(s.resonator);
  const double acceleration =
      10 * std::pow(plate.modes[0].shape->largest(), 2) / plate.modes[0].mass;
  for (const double share : {0.02, 0.2, 0.45, 0.7, 1.1, 1.3, 1.6, 1.9, 3.0, 5.0}) {
    SCOPED_TRACE(share);
    s.gap = share * acceleration * longest * longest;
    const Model model = make_model(s);
    EXPECT_GE(expect_both_same(model, make_start(model)).end.shocks_begun, 1);
  }
}

TEST(Candidates, PushAtOneEndLowersTheOther) {
  // A spring under one end of a body at rest lifts that end and lets the other down by half as
  // much, onto a second spring: nothing but the contact force itself tells of it.
  Scene s = plate_and_block();
  s.resonator = rigid(s.resonator);
  s.slider.support = Support::free;
  s.slider.modes = 0;
  s.speed = 0;
  s.start = 0.02;
  s.time.step = 1e-9;
  s.duration = 3e-6;
  s.output.rate = 1 / s.duration;
  s.contact.stiffness = 1e13;
  const double height = 1e-6, pressed = 1e-9;
  s.gap = height - pressed;
  for (const double open : {3e-16, 1e-15, 3e-15, 1e-14, 3e-14, 1e-13, 1e-12}) {
    SCOPED_TRACE(open);
    s.slider.surface =
        peaks({{.at = 0, .height = height, .half_width = 1e-5},
               {.at = 0.004, .height = height - pressed - open, .half_width = 1e-5}});
    const Model model = make_model(s);
    EXPECT_EQ(expect_both_same(model, make_start(model)).end.most_nodes, 2);
  }
}

TEST(Candidates, NodesThatDoNotExistTouchNothing) {
  // 201 nodes are no whole number of groups; the plate has run away beyond any height
  Scene s = plate_and_block();
  s.speed = 0;
  s.start = 0.028;
  s.gap = 1e-5;
  s.contact.stiffness = 1e3;
  s.duration = 4 * s.time.step;
  s.output.rate = 1 / s.duration;
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_u[0] = 1e33;
  count_energy(model, start);
  EXPECT_EQ(expect_both_same(model, start).end.most_nodes, model.nodes());
}

TEST(Candidates, PeaksAtTheTwoEndsOfARockingSlider) {
  for (const double at : {0.0, 0.056}) {  // the slider stands at either end of the plate
    SCOPED_TRACE(at);
    Scene s = plate_and_block();
    s.speed = 0;
    s.start = at;
    s.slider.support = Support::free;
    s.slider.load_is_weight = true;
    s.slider.surface = peaks({{.at = 0, .height = 1e-6, .half_width = 1e-5},
                              {.at = 0.004, .height = 1e-6, .half_width = 1e-5}});
    s.contact.stiffness = 1e14;
    s.duration = 5e-3;
    const Model model = make_model(s);
    ModalStart start = make_start(model);
    start.slider_v[1] = 2e-4 * std::sqrt(s.slider.length);
    count_energy(model, start);
    EXPECT_GE(expect_both_same(model, start).end.shocks_begun, 3);
  }
}

TEST(Candidates, NodeThatTouchesForASingleStep) {
  // so stiff that one step's force turns the plate round
  Scene s = plate_and_block();
  s.speed = 0;
  s.start = 0.028;
  s.resonator.modes = 3;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 1e-5}});
  // the peak stands over the middle, where the second of the three modes does not move
  s.contact.stiffness = stiffness_for(s, 1.9 * std::sqrt(1.5));
  s.gap = 1.2e-5;
  int single = 0;
  for (int phase = 0; phase < 8; ++phase) {
    SCOPED_TRACE(phase);
    const Model model = make_model(s);
    ModalStart start = make_start(model);
    start.resonator_v[0] = (0.11 + 0.0137 * phase) * std::sqrt(s.resonator.length);
    count_energy(model, start);
    for (const ShockRow& shock : expect_both_same(model, start).shocks)
      single += shock.start == shock.last;
  }
  EXPECT_GT(single, 0);
}

TEST(Candidates, ContactReleasedByDampingOnly) {
  // an overdamped mode creeps back from contact: no velocity to speak of, and the gap opens for
  // good
  Scene s = plate_and_block();
  s.speed = 0;
  s.start = 0.028;
  s.resonator.modes = 1;
  s.resonator.damping = 20;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 2e-4}});
  s.gap = 2e-5;
  s.contact.stiffness = 1e11;
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_u[0] = 1.05e-5 / model.resonator.modes[0].shape->largest();
  count_energy(model, start);
  const Outcome all = expect_both_same(model, start);
  EXPECT_EQ(all.end.shocks_begun, 1);
  ASSERT_EQ(all.shocks.size(), 1u);
  EXPECT_GT(all.shocks[0].last, 100);
}

TEST(Candidates, FlatOnFlatTouchesEverywhere) {
  Scene s = plate_and_block();
  s.gap = 0;
  s.slider.support = Support::free;
  s.slider.load_is_weight = true;
  s.contact.stiffness = 1e12;
  for (const double speed : {0.0, 0.5}) {
    s.speed = speed;
    const Model model = make_model(s);
    EXPECT_GT(expect_both_same(model, make_start(model)).end.most_nodes, 20);
  }
}

TEST(Candidates, CreepSlowerThanTheRoundingOfThePosition) {
  // The slider's position, some 20 000 chi, is rounded to 3.6e-12 chi: here it stands still for
  // tens of steps, then moves by one rounding. Contact comes when a rounded position makes it, not
  // when a line would.
  Scene s = plate_and_block();
  s.spacing = 1e-5;
  s.time.step = 1e-8;
  s.duration = 7e-5;
  s.resonator.length = 0.3;
  s.resonator.modes = 1;
  s.slider.length = 2e-4;
  s.start = 0.2;
  s.resonator.surface = peaks({{.at = 0.2006, .height = 2e-5, .half_width = 1e-3}});
  s.slider.surface = peaks({{.at = 1e-4, .height = 2e-5, .half_width = 5e-6}});
  for (const double speed : {4e-11, 1e-10, 2e-10}) {
    s.speed = speed;
    for (int i = 0; i < 10; ++i) {
      SCOPED_TRACE(testing::Message() << speed << " m/s, " << i);
      Model model = make_model(s);
      const double rise = 2e-5 * std::numbers::pi / 2 / 1e-3;  // m/m, half way up the peak
      model.delta += (2000 + 157 * i) * speed * s.time.step * rise;
      EXPECT_GT(expect_both_same(model, make_start(model)).end.contact_steps, 0);
      if (HasFailure()) return;  // one is enough to read
    }
  }
}

// ---- a march written plainly
// -----------------------------------------------------------------------------

/// All nodes, all modes, at every step: docs/model.md and the scheme's definition, nothing else.
struct Plain {
  std::vector<double> u, v;                // (step, mode): the resonator's, then the slider's
  std::vector<std::vector<int>> nodes;     // in contact, at each step
  std::vector<std::vector<double>> force;  // N, on them
  double largest_displacement = 0;         // m, sum |psi_k| |U_k| at its largest

  Plain(const Model& m, const ModalStart& start, double shift) {
    const Scene& s = m.scene;
    struct Loaded {
      const BodyMode* mode;
      double load;
      bool resonator;
    };
    std::vector<Loaded> modes;
    for (std::size_t k = 0; k < m.resonator.modes.size(); ++k)
      modes.push_back({&m.resonator.modes[k], m.resonator.load[k], true});
    for (std::size_t k = 0; k < m.slider.modes.size(); ++k)
      modes.push_back({&m.slider.modes[k], m.slider.load[k], false});
    std::vector<double> now = start.resonator_u, rate = start.resonator_v;
    now.insert(now.end(), start.slider_u.begin(), start.slider_u.end());
    rate.insert(rate.end(), start.slider_v.begin(), start.slider_v.end());
    const double chi = s.spacing, tau = s.time.step;

    for (std::int64_t step = 0; step <= m.steps; ++step) {
      u.insert(u.end(), now.begin(), now.end());
      v.insert(v.end(), rate.begin(), rate.end());
      nodes.emplace_back();
      force.emplace_back();
      std::vector<double> modal_force;
      for (const Loaded& mode : modes) modal_force.push_back(mode.load);
      for (int n = 0; n < m.nodes(); ++n) {
        const double x = s.start + s.speed * (static_cast<double>(step) * tau) + n * chi;
        const auto left = static_cast<std::size_t>(std::floor(x / chi));
        const double share = x / chi - static_cast<double>(left);
        double u1 = 0, u2 = 0, displacement = 0;
        std::vector<double> psi(modes.size());
        for (std::size_t k = 0; k < modes.size(); ++k) {
          psi[k] = shape_at(*modes[k].mode, modes[k].resonator ? x : n * chi);
          (modes[k].resonator ? u2 : u1) += now[k] * psi[k];
          displacement += std::abs(now[k] * psi[k]);
        }
        largest_displacement = std::max(largest_displacement, displacement);
        const double g = gap(m.delta + shift, m.slider_height[n], u1,
                             {m.resonator_height[left], m.resonator_height[left + 1], share}, u2);
        if (g > 0) continue;
        const double f =
            -s.contact.stiffness * chi * std::min(s.resonator.width, s.slider.width) * g;
        nodes.back().push_back(n);
        force.back().push_back(f);
        for (std::size_t k = 0; k < modes.size(); ++k) modal_force[k] -= f * psi[k];
      }
      for (std::size_t k = 0; k < modes.size(); ++k) {
        const auto [omega, zeta, mass] = static_cast<const Mode&>(*modes[k].mode);
        rate[k] = (rate[k] - tau * omega * omega * now[k] + tau * modal_force[k] / mass) /
                  (1 + 2 * zeta * omega * tau + omega * omega * tau * tau);
        now[k] += tau * rate[k];
      }
    }
  }
};

/// Connected pieces of contact, by spreading labels until nothing changes: rows of start, last,
/// peak, impulse, moment about the resonator's end in N steps chi.
std::vector<ShockRow> plain_shocks(const Plain& run, const Model& model) {
  std::vector<std::vector<int>> label;
  int labels = 0;
  for (const std::vector<int>& nodes : run.nodes) {
    label.emplace_back();
    for (std::size_t i = 0; i < nodes.size(); ++i) label.back().push_back(labels++);
  }
  for (bool changed = true; changed;) {
    changed = false;
    const auto join = [&](std::size_t a, std::size_t b) {
      for (std::size_t i = 0; i < run.nodes[a].size(); ++i)
        for (std::size_t j = 0; j < run.nodes[b].size(); ++j) {
          if (std::abs(run.nodes[a][i] - run.nodes[b][j]) > 1 || label[a][i] == label[b][j])
            continue;
          label[a][i] = label[b][j] = std::min(label[a][i], label[b][j]);
          changed = true;
        }
    };
    for (std::size_t s = 0; s < label.size(); ++s) {
      join(s, s);
      if (s > 0) join(s - 1, s);
    }
    for (std::size_t s = label.size() - 1; s > 0; --s) join(s - 1, s);
  }
  std::map<int, ShockRow> shocks;
  for (std::size_t s = 0; s < label.size(); ++s) {
    std::map<int, double> total;
    for (std::size_t i = 0; i < label[s].size(); ++i) {
      const auto step = static_cast<std::int64_t>(s);
      ShockRow& shock =
          shocks.try_emplace(label[s][i], ShockRow{0, step, step, 0, 0, 0, 0}).first->second;
      const double f = run.force[s][i];
      shock.last = step;
      shock.impulse += f;
      shock.moment +=
          f * (model.position + static_cast<double>(s) * model.advance + run.nodes[s][i]);
      shock.peak = std::max(shock.peak, total[label[s][i]] += f);
    }
  }
  std::vector<ShockRow> out;
  for (const auto& [key, shock] : shocks) out.push_back(shock);
  return out;
}

/// Short runs, before chaos. Their last two steps are outside contact, or are compared as open.
Scene scene_for_plain(int number) {
  Scene s = plate_and_block();
  s.spacing = 5e-5;
  s.time.step = 2e-7;
  s.duration = 8e-4;
  s.output.rate = 5e6;  // every step
  s.resonator.modes = 8;
  s.contact.stiffness = 2e12;
  s.slider.surface = gaussian(5e-7, 8e-4, 21);
  s.resonator.surface = gaussian(5e-7, 8e-4, 22);
  switch (number) {
    case 0:  // a block let go on the plate
      s.slider.support = Support::free;
      s.slider.load = 2;
      s.speed = 0.5;
      break;
    case 1:  // a thin pinned slider, started from equilibrium, standing still in part
      s.slider.support = Support::pinned;
      s.slider.thickness = 4e-4;
      s.slider.modes = 3;
      s.slider.load = 1;
      s.initial = Initial::statics;
      s.speed = 0.3;
      break;
    case 2:  // a rigid one pressed in and left alone: nothing slides
      s.speed = 0;
      break;
    case 3:  // two peaks against one, fast, with a free plate
      s.speed = 20;
      s.resonator.support = Support::free;
      s.resonator.modes = 5;
      s.slider.surface = peaks({{.at = 1e-3, .height = 1e-5, .half_width = 3e-4},
                                {.at = 3e-3, .height = 1e-5, .half_width = 3e-4}});
      s.resonator.surface = peaks({{.at = 0.029, .height = 1e-5, .half_width = 3e-4}});
      s.gap = 1.95e-5;
      break;
  }
  return s;
}

/// The plain march, and the error of its states that roundings may make.
struct PlainWithError {
  Plain plain;
  double largest_u = 0, largest_v = 0;
  double share = 0;  // of the largest

  PlainWithError(const Model& model, const ModalStart& start) : plain(model, start, 0) {
    // the growth of errors: the change of all states under a gap that is too large at every step
    const double shift = 1e-13;
    const Plain shifted(model, start, shift);
    double growth = 0;
    for (std::size_t i = 0; i < plain.u.size(); ++i) {
      growth = std::max(growth, std::abs(plain.u[i] - shifted.u[i]) / shift);
      largest_u = std::max(largest_u, std::abs(plain.u[i]));
      largest_v = std::max(largest_v, std::abs(plain.v[i]));
    }
    // Roundings of a gap: 64 in the displacement (a sum over modes of polynomials), 4 in the faces,
    // and those of the position, which the face's slope turns into a height; and of the state, 4 a
    // step. They change from step to step and may do worse than a constant shift: ten times.
    double steepest = 0, highest = model.delta;
    for (std::size_t n = 0; n + 1 < model.resonator_height.size(); ++n) {
      steepest =
          std::max(steepest, std::abs(model.resonator_height[n + 1] - model.resonator_height[n]));
      highest = std::max(highest, std::abs(model.resonator_height[n]));
    }
    constexpr double ulp = std::numeric_limits<double>::epsilon();
    const double nodes2 = static_cast<double>(model.resonator_height.size());
    const double steps = static_cast<double>(model.steps);
    const double per_gap =
        ulp * (64 * plain.largest_displacement + 4 * highest + 4 * nodes2 * steepest);
    share = 10 * growth * (per_gap + 4 * steps * ulp * plain.largest_displacement) / largest_u +
            4 * steps * ulp;
  }
};

void expect_same_states(const Outcome& out, const PlainWithError& expected, const Model& model,
                        std::size_t modes) {
  const Plain& plain = expected.plain;
  const std::size_t samples = static_cast<std::size_t>(model.steps) + 1;
  const std::size_t row = out.rows.size() / samples, lanes = (row - sample::columns) / 2;
  ASSERT_EQ(out.rows.size(), row * samples);
  double worst_u = 0, worst_v = 0, worst_force = 0, largest_force = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    for (std::size_t k = 0; k < modes; ++k) {
      worst_u = std::max(worst_u, std::abs(out.rows[i * row + k] - plain.u[i * modes + k]));
      worst_v = std::max(worst_v, std::abs(out.rows[i * row + lanes + k] - plain.v[i * modes + k]));
    }
    const double* columns = &out.rows[i * row + 2 * lanes];
    double force = 0;
    for (const double f : plain.force[i]) force += f;
    ASSERT_EQ(columns[sample::nodes], static_cast<double>(plain.nodes[i].size())) << "step " << i;
    worst_force = std::max(worst_force, std::abs(columns[sample::force] - force));
    largest_force = std::max(largest_force, force);
  }
  const double share = expected.share;
  EXPECT_LT(worst_u, share * expected.largest_u);
  EXPECT_LT(worst_v, share * expected.largest_v);
  // a force is the difference of displacements: its error is theirs
  EXPECT_LT(worst_force, share * largest_force + model.node_stiffness * out.end.most_nodes * share *
                                                     plain.largest_displacement);
}

/// Which nodes touch: through the shocks, whose moments are sums over the nodes' places. The march
/// counts the contacts of the steps it makes, so not those of the last state.
void expect_same_shocks(const Outcome& out, Plain plain, const Model& model) {
  plain.nodes.pop_back();
  plain.force.pop_back();
  double largest_force = 0;
  for (const std::vector<double>& forces : plain.force)
    largest_force = std::max(largest_force, std::accumulate(forces.begin(), forces.end(), 0.0));
  std::vector<ShockRow> expected = plain_shocks(plain, model), got = out.shocks;
  for (const OpenShock& o : out.end.open_shocks)
    got.push_back({o.serial, o.start, o.last, o.peak, o.impulse, o.moment});
  ASSERT_EQ(got.size(), expected.size());
  ASSERT_GE(got.size(), 1u);
  const auto order = [](const ShockRow& a, const ShockRow& b) {
    return std::tie(a.start, a.last, a.moment) < std::tie(b.start, b.last, b.moment);
  };
  std::sort(got.begin(), got.end(), order);
  std::sort(expected.begin(), expected.end(), order);
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].start, expected[i].start);
    EXPECT_EQ(got[i].last, expected[i].last);
    if (!(expected[i].impulse > 1e-6 * largest_force)) continue;  // a graze: all rounding
    const double place = expected[i].moment / expected[i].impulse;
    EXPECT_NEAR(got[i].impulse, expected[i].impulse, 1e-5 * expected[i].impulse);
    EXPECT_NEAR(got[i].moment / got[i].impulse, place, 1e-5);  // chi: a wrong node would show
  }
}

class AgainstPlainMarch : public testing::TestWithParam<int> {};

TEST_P(AgainstPlainMarch, SameNodesAndStateToRoundOff) {
  Model model = make_model(scene_for_plain(GetParam()));
  if (GetParam() == 2) model.delta -= 2e-7;
  ASSERT_EQ(model.steps_per_sample, 1.0);
  ModalStart start = make_start(model);
  start.energy = 1;  // J, far more than there is: the check of the energy is not tested here
  const PlainWithError expected(model, start);
  ASSERT_LT(expected.share, 1e-7) << "too chaotic a scene to compare";
  for (const Nodes nodes : {Nodes::all, Nodes::candidates}) {
    const Outcome out = march(model, start, nodes);
    expect_same_states(out, expected, model, start.resonator_u.size() + start.slider_u.size());
    expect_same_shocks(out, expected.plain, model);
  }
}
INSTANTIATE_TEST_SUITE_P(Candidates, AgainstPlainMarch, testing::Range(0, 4));

}  // namespace
}  // namespace ra2d::test
