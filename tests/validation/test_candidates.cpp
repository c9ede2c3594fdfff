// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "host/errors.hpp"
#include "tests/simulate.hpp"

/// Leaving out the nodes that cannot touch changes nothing: `nodes = "candidates"` and `nodes =
/// "all"` are compared bit for bit, and both with a march written plainly here.
namespace ra2d::test {
namespace {

std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> out;
  for (const double x : values) out.push_back(std::bit_cast<std::uint64_t>(x));
  return out;
}

/// Everything that a scene hands out.
struct Outcome {
  std::vector<double> rows;  // samples: U, V, force, nodes, energies, works
  std::vector<ShockRow> shocks;
  Snapshot end;
};

Outcome march(Model model, const ModalStart& start, Nodes nodes) {
  model.scene.nodes = nodes;
  Batch batch({model}, {start});
  Outcome out;
  do {
    batch.march(std::numeric_limits<std::int64_t>::max());
    const Drained drained = batch.drain(0);
    out.rows.insert(out.rows.end(), drained.sample_rows.begin(), drained.sample_rows.end());
    out.shocks.insert(out.shocks.end(), drained.shocks.begin(), drained.shocks.end());
    out.end = batch.snapshot(0);
  } while (out.end.status == Status::running);
  return out;
}

template <class Shock>
std::vector<std::uint64_t> shock_bits(const std::vector<Shock>& shocks) {
  std::vector<std::uint64_t> out;
  for (const Shock& s : shocks) {
    for (const std::int64_t i : {s.serial, s.start, s.last})
      out.push_back(static_cast<std::uint64_t>(i));
    for (const double x : {s.peak, s.impulse, s.moment})
      out.push_back(std::bit_cast<std::uint64_t>(x));
  }
  return out;
}

void expect_same(const Outcome& all, const Outcome& some) {
  EXPECT_EQ(all.end.status, some.end.status);
  EXPECT_EQ(all.end.step, some.end.step);
  EXPECT_EQ(bits(all.end.resonator_u), bits(some.end.resonator_u));
  EXPECT_EQ(bits(all.end.resonator_v), bits(some.end.resonator_v));
  EXPECT_EQ(bits(all.end.slider_u), bits(some.end.slider_u));
  EXPECT_EQ(bits(all.end.slider_v), bits(some.end.slider_v));
  EXPECT_EQ(bits(all.end.resonator_square), bits(some.end.resonator_square));
  EXPECT_EQ(
      bits({all.end.energy, all.end.energy_limit, all.end.sliding_work, all.end.force_work}),
      bits({some.end.energy, some.end.energy_limit, some.end.sliding_work, some.end.force_work}));
  EXPECT_EQ(all.end.contact_steps, some.end.contact_steps);
  EXPECT_EQ(all.end.most_nodes, some.end.most_nodes);
  EXPECT_EQ(all.end.shocks_begun, some.end.shocks_begun);
  // not EXPECT_EQ: on failure it would print every sample
  EXPECT_TRUE(bits(all.rows) == bits(some.rows)) << "the samples differ";
  EXPECT_TRUE(shock_bits(all.shocks) == shock_bits(some.shocks)) << "the shocks differ";
  EXPECT_TRUE(shock_bits(all.end.open_shocks) == shock_bits(some.end.open_shocks))
      << "the open shocks differ";
}

/// Marches both ways, compares, and returns the march over all the nodes.
Outcome expect_both_same(const Model& model, const ModalStart& start) {
  const Outcome all = march(model, start, Nodes::all);
  const Outcome some = march(model, start, Nodes::candidates);
  expect_same(all, some);
  // every step has its share of all the nodes; leaving none out would make the comparison empty
  EXPECT_EQ(all.end.evaluated, all.end.step * model.nodes());
  return all;
}

/// The energy at t = 0 of a start whose modal state was set by hand: the watch over the energy asks
/// for it.
void count_energy(const Model& model, ModalStart& start) {
  start.energy = 0;
  const auto add = [&](const Beam& beam, const std::vector<double>& u,
                       const std::vector<double>& v) {
    for (std::size_t k = 0; k < u.size(); ++k)
      start.energy +=
          0.5 * beam.mass_per_length * (v[k] * v[k] + std::pow(beam.modes[k].omega * u[k], 2));
  };
  add(model.resonator, start.resonator_u, start.resonator_v);
  add(model.slider, start.slider_u, start.slider_v);
  for (const double overlap : overlaps(model, start.resonator_u, start.slider_u))
    if (overlap > 0) start.energy += 0.5 * model.node_stiffness * overlap * overlap;
}

double largest_shape(const Beam& beam) {
  double sum = 0;
  for (const ModeShape& mode : beam.modes) sum += mode.largest * mode.largest;
  return beam.modes.empty() ? 0 : sum / beam.mass_per_length;
}

/// The kappa with which one node in contact has omega_c tau = z, at the most, anywhere on the
/// bodies.
double stiffness_for(const Scene& scene, double z) {
  const double yield =
      largest_shape(make_beam(scene.resonator)) + largest_shape(make_beam(scene.slider));
  return std::pow(z / scene.step, 2) / yield / scene.spacing /
         std::min(scene.resonator.width, scene.slider.width);
}

/// A steel plate under a short block, 20 um per node.
Scene plate_and_block() {
  Scene s;
  s.duration = 2e-3;
  s.speed = 0.2;
  s.start = 0.02;
  s.spacing = 2e-5;
  s.step = 1e-7;
  s.rate = 1e6;
  s.resonator.length = 0.06;
  s.resonator.thickness = 1e-3;
  s.resonator.width = 0.02;
  s.resonator.young = 210e9;
  s.resonator.density = 7800;
  s.resonator.damping = 0.02;
  s.resonator.modes = 12;
  s.slider = s.resonator;
  s.slider.length = 0.004;
  s.slider.thickness = 0.004;
  s.slider.support = Support::rigid;
  s.slider.modes = 0;
  s.stiffness = 1e15;
  return s;
}

SurfaceSpec peaks(std::vector<Peak> list) {
  SurfaceSpec surface;
  surface.kind = SurfaceKind::peaks;
  surface.peaks = std::move(list);
  return surface;
}

SurfaceSpec gaussian(double rq, double rsm, std::uint64_t seed) {
  SurfaceSpec surface;
  surface.kind = SurfaceKind::gaussian;
  surface.rq = rq;
  surface.rsm = rsm;
  surface.seed = seed;
  return surface;
}

/// Numbers that are the same everywhere: the standard's engine, but not its distributions.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_{seed} {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  double ratio(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
  int pick(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  bool one_in(int count) { return pick(count) == 0; }

 private:
  std::mt19937_64 engine_;
};

struct Case {
  Model model;
  ModalStart start;
};

/// A scene of any kind that the march takes.
Case random_case(std::uint64_t seed) {
  Dice dice(seed);
  Scene s;
  s.spacing = dice.ratio(1e-5, 1e-4);
  s.step = dice.ratio(1e-8, 1e-6);
  const int nodes1 = 20 + dice.pick(180);
  const bool smooth_modes = dice.one_in(2);  // hundreds of nodes to a wave, or tens
  const int nodes2 = nodes1 * (2 + dice.pick(5)) + (smooth_modes ? 3000 + dice.pick(6000) : 200);
  const double least_per_wave = smooth_modes ? 950 : 60;
  const int most_modes = std::max(1, static_cast<int>(2 * nodes2 / least_per_wave));

  BodySpec& r = s.resonator;
  r.support = dice.one_in(4) ? Support::free : Support::pinned;
  r.length = (nodes2 - 1) * s.spacing;
  r.thickness = r.length / dice.ratio(20, 300);
  r.width = 0.02;
  r.young = 210e9;
  r.density = 7800;
  r.damping = dice.one_in(4) ? 0.0 : dice.ratio(1e-3, 0.7);
  r.modes = r.support == Support::free ? dice.pick(std::max(1, std::min(50, most_modes) - 3))
                                       : 1 + dice.pick(std::min(60, most_modes));
  BodySpec& b = s.slider;
  b = r;
  const Support supports[] = {Support::free, Support::free, Support::pinned, Support::rigid};
  b.support = supports[dice.pick(4)];
  b.length = (nodes1 - 1) * s.spacing;
  b.thickness = b.length / dice.ratio(1, 30);
  b.width = 0.01;
  b.modes = b.support == Support::pinned ? 1 + dice.pick(6)
            : b.support == Support::free ? dice.pick(5)
                                         : 0;

  // any of: at rest, a few nodes in all, a node in some steps, some nodes in a step
  const double room = (nodes2 - nodes1 - 1) * s.spacing;
  std::int64_t steps = 10'000 + dice.pick(30'000);
  const double advances[] = {0.0, dice.ratio(1e-6, 1e-4), dice.ratio(1e-4, 1e-2),
                             dice.ratio(1e-2, 0.9), dice.ratio(1, 5)};
  const double advance = advances[dice.pick(5)];
  if (advance > 0)
    steps = std::min(steps, static_cast<std::int64_t>(0.9 * room / s.spacing / advance));
  steps = std::max<std::int64_t>(steps, 50);
  s.speed = advance * s.spacing / s.step;
  s.duration = static_cast<double>(steps) * s.step;
  // the last nodes of the resonator, too: there the end of the run
  const double last = room - s.speed * s.duration;
  s.start = dice.one_in(3) ? last : dice.uniform(0, last);
  s.rate = 1 / (s.step * dice.uniform(1.0, 40.0));
  s.stiffness = stiffness_for(s, dice.ratio(0.01, 1.2));

  const double height = dice.ratio(1e-7, 1e-5);
  const auto face = [&](BodySpec& body, int nodes) {
    switch (dice.pick(4)) {
      case 0:
        break;
      case 1: {
        std::vector<Peak> list;
        for (int i = 0; i < 1 + nodes / 100; ++i)
          list.push_back({.at = dice.uniform(0, body.length),
                          .height = height,
                          .half_width = s.spacing * dice.ratio(0.8, 30)});
        body.surface = peaks(list);
        break;
      }
      default:
        body.surface =
            gaussian(height, s.spacing * dice.ratio(4, 60), seed * 2 + (nodes == nodes2));
    }
  };
  face(r, nodes2);
  face(b, nodes1);

  if (b.support == Support::free) b.load_is_weight = !dice.one_in(3);
  if (b.support != Support::rigid && !b.load_is_weight) b.load = dice.ratio(0.01, 10);
  const bool held = r.support == Support::pinned && b.support != Support::rigid;
  s.initial = held && dice.one_in(2) ? Initial::statics : Initial::rest;
  if (dice.one_in(4))
    r.moving_forces.push_back({.force = dice.uniform(-5, 5),
                               .speed = dice.ratio(1, 100),
                               .start = dice.uniform(-0.1, 0.5) * r.length});

  Case c{make_model(s), {}};
  if (s.initial == Initial::rest) c.model.delta += dice.uniform(-0.1, 0.3) * height;
  c.start = make_start(c.model);
  if (s.initial == Initial::rest && dice.one_in(2)) {
    const auto kick = [&](const Beam& beam, std::vector<double>& v) {
      for (std::size_t k = 0; k < v.size(); ++k) {
        const double omega = std::max(beam.modes[k].omega, 10 / s.duration);
        v[k] = dice.uniform(-1, 1) * height * omega / beam.modes[k].largest;
      }
    };
    kick(c.model.resonator, c.start.resonator_v);
    kick(c.model.slider, c.start.slider_v);
    count_energy(c.model, c.start);
  }
  return c;
}

TEST(Candidates, RandomScenesAreTheSameBitForBit) {
  constexpr int scenes = 60;
  int touching = 0, in_and_out = 0;
  double evaluated = 0, steps_nodes = 0;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Case c = random_case(seed);
    const Outcome all = march(c.model, c.start, Nodes::all);
    const Outcome some = march(c.model, c.start, Nodes::candidates);
    expect_same(all, some);
    touching += all.end.contact_steps > 0;
    in_and_out += all.end.shocks_begun >= 5;
    evaluated += static_cast<double>(some.end.evaluated);
    steps_nodes += static_cast<double>(all.end.evaluated);
  }
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
  s.stiffness = 1e13;
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
    s.speed = nodes_per_step * s.spacing / s.step;
    s.duration = 0.03 / s.speed;
    s.start = 0.005;
    // half as wide as the spacing: a single node on either side
    s.resonator.surface = peaks({{.at = 0.0300, .height = 2e-5, .half_width = 1e-5}});
    s.slider.surface = peaks({{.at = 0.0020, .height = 2e-5, .half_width = 1e-5},
                              {.at = 0.0040, .height = 2e-5, .half_width = 1e-5}});
    s.gap = 3e-5;
    s.stiffness = 1e13;
    const Model model = make_model(s);
    const Outcome all = expect_both_same(model, make_start(model));
    // at a whole number of nodes a step they meet for sure, at more than one they may pass unseen
    if (nodes_per_step <= 1) {
      EXPECT_GE(all.end.contact_steps, 1);
    }
  }
}

TEST(Candidates, HugeVelocityCrossesALargeGapWithinOneLook) {
  for (const double steps_to_cross : {0.5, 3.0, 30.0, 300.0, 3000.0}) {
    for (const int mode : {0, 1, 7, 11}) {
      SCOPED_TRACE(std::to_string(steps_to_cross) + " steps, mode " + std::to_string(mode));
      Scene s = plate_and_block();
      s.gap = 1e-3;
      s.start = 0.027;
      s.duration = 1e-3;
      s.stiffness = 1e12;
      const Model model = make_model(s);
      ModalStart start = make_start(model);
      start.resonator_v[mode] =
          1e-3 / (steps_to_cross * s.step) / model.resonator.modes[mode].largest;
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
    s.stiffness = 1e14;
    const Model model = make_model(s);
    ModalStart start = make_start(model);
    start.resonator_v[mode] =
        1e-5 * model.resonator.modes[mode].omega / model.resonator.modes[mode].largest;
    count_energy(model, start);
    const Outcome all = expect_both_same(model, start);
    EXPECT_GE(all.end.most_nodes, 2);
  }
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
    s.stiffness = 1e14;
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
  s.stiffness = stiffness_for(s, 1.9 * std::sqrt(1.5));
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
  s.stiffness = 1e11;
  const Model model = make_model(s);
  ModalStart start = make_start(model);
  start.resonator_u[0] = 1.05e-5 / model.resonator.modes[0].largest;
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
  s.stiffness = 1e12;
  for (const double speed : {0.0, 0.5}) {
    s.speed = speed;
    const Model model = make_model(s);
    EXPECT_GT(expect_both_same(model, make_start(model)).end.most_nodes, 20);
  }
}

}  // namespace
}  // namespace ra2d::test
