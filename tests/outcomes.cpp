// SPDX-License-Identifier: BSD-3-Clause
#include "tests/outcomes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/dice.hpp"

namespace ra2d::test {

Outcome march(Model model, const ModalStart& start, Nodes nodes, const BatchOptions& options) {
  model.scene.time.nodes = nodes;
  Batch batch({model}, {start}, options);
  Outcome out;
  out.tick = model.tick;
  out.sample_interval = model.steps_per_sample * model.tick;
  do {
    batch.march(std::numeric_limits<std::int64_t>::max());
    const Drained drained = batch.drain(0);
    out.lanes = drained.lanes;
    out.rows.insert(out.rows.end(), drained.sample_rows.begin(), drained.sample_rows.end());
    out.shocks.insert(out.shocks.end(), drained.shocks.begin(), drained.shocks.end());
    out.end = batch.snapshot(0);
  } while (out.end.status == Status::running);
  return out;
}

Outcome march_from_saved_states(const Model& model, const ModalStart& start, std::uint64_t seed) {
  std::mt19937_64 dice(seed);
  Outcome out;
  SavedState saved = Batch({model}, {start}).save(0);
  for (std::int64_t launches = 0;; ++launches) {
    Batch batch({model}, {start});
    batch.restore(0, saved);
    const std::int64_t longest = std::max<std::int64_t>(1, model.steps / 8);
    batch.march(batch.snapshot(0).step + 1 +
                static_cast<std::int64_t>(dice() % static_cast<std::uint64_t>(longest)));
    const Drained drained = batch.drain(0);
    out.lanes = drained.lanes;
    out.rows.insert(out.rows.end(), drained.sample_rows.begin(), drained.sample_rows.end());
    out.shocks.insert(out.shocks.end(), drained.shocks.begin(), drained.shocks.end());
    out.end = batch.snapshot(0);
    if (out.end.status != Status::running) return out;
    saved = batch.save(0);
  }
}

Variant SchemeUnderLaw::variant() const {
  Variant of_it;
  of_it.scheme = scheme;
  of_it.adapt = [law = law](Scene& scene) { scene.contact.law = law; };
  return of_it;
}

std::vector<SchemeUnderLaw> schemes_under_laws() {
  std::vector<SchemeUnderLaw> all;
  for (const Scheme& scheme : schemes_and_implicit()) all.push_back({scheme, ContactLaw::penalty});
  for (const Scheme& scheme : schemes)
    if (scheme.time.scheme != SchemeKind::explicit_euler)
      all.push_back({scheme, ContactLaw::multiplier});
  return all;
}

testing::AssertionResult same(const Outcome& a, const Outcome& b) {
  Comparison comparison;
  const auto lanes = static_cast<std::size_t>(a.lanes), row = 2 * lanes + sample::columns;
  comparison.add("modal lanes of a sample", std::int64_t{a.lanes}, std::int64_t{b.lanes});
  Axes axes{.row = "sample"};
  if (a.sample_interval > 0)
    for (std::size_t i = 0; i < a.rows.size() / row; ++i)
      axes.times.push_back(static_cast<double>(i) * a.sample_interval);
  std::size_t first = 0;
  const auto add = [&](const char* name, std::size_t columns) {
    const auto cut = [&](const std::vector<double>& rows) {
      std::vector<double> part;
      for (std::size_t at = first; at < rows.size(); at += row)
        part.insert(part.end(), rows.begin() + static_cast<std::ptrdiff_t>(at),
                    rows.begin() + static_cast<std::ptrdiff_t>(at + columns));
      return part;
    };
    axes.columns = columns;
    comparison.add(name, cut(a.rows), cut(b.rows), axes);
    first += columns;
  };
  add("displacement", lanes);
  add("velocity", lanes);
  for (const char* name : {"force", "nodes in contact", "contact energy", "damping loss",
                           "sliding work", "work of forces"})
    add(name, 1);
  comparison.add_shocks("shocks:", a.shocks, b.shocks, a.tick);
  comparison.add(a.end, b.end, a.tick);
  return comparison.result();
}

testing::AssertionResult goes_on_when_saved(const Started& started, std::int64_t step) {
  Batch whole({started.model}, {started.start}), first({started.model}, {started.start}),
      second({started.model}, {started.start});
  // a launch ends where there is no room for the nodes in contact
  const auto march_to = [](Batch& batch, std::int64_t target) {
    while (batch.snapshot(0).status == Status::running && batch.snapshot(0).step < target)
      batch.march(target);
  };
  march_to(whole, started.model.steps);
  march_to(first, step);
  if (first.snapshot(0).contact_steps == 0)
    return testing::AssertionFailure() << "saved before the first contact";
  second.restore(0, first.save(0));
  march_to(second, started.model.steps);
  Outcome a, b;
  a.end = whole.snapshot(0), b.end = second.snapshot(0);
  return same(a, b);
}

Outcome expect_both_same(const Model& model, const ModalStart& start) {
  const Outcome all = march(model, start, Nodes::all);
  const Outcome some = march(model, start, Nodes::candidates);
  EXPECT_TRUE(same(all, some));
  // every step has its share of all the nodes; leaving none out would make the comparison empty
  EXPECT_EQ(all.end.evaluated, all.end.step * model.nodes());
  return all;
}

double largest_shape(const Body& body) {
  double sum = 0;
  for (const BodyMode& mode : body.modes) sum += std::pow(mode.shape->largest(), 2) / mode.mass;
  return sum;
}

double stiffness_for(const Scene& scene, double z) {
  const double mobility =
      largest_shape(make_body(scene.resonator)) + largest_shape(make_body(scene.slider));
  return std::pow(z / scene.time.step, 2) / mobility / scene.spacing /
         std::min(scene.resonator.width, scene.slider.width);
}

Started random_scene(std::uint64_t seed, const Variant& variant) {
  Dice dice(seed);
  Scene s = with(Scene{}, variant.scheme);
  s.spacing = dice.ratio(1e-5, 1e-4);
  s.time.step = dice.ratio(1e-8, 1e-6);
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

  double fastest = 0;
  for (const BodySpec* body : {&r, &b})
    for (const BodyMode& mode : make_body(*body).modes) fastest = std::max(fastest, mode.omega);
  if (variant.turn > 0 && fastest > 0) s.time.step = variant.turn / fastest;

  // any of: at rest, a few nodes in all, a node in some steps, some nodes in a step
  const double room = (nodes2 - nodes1 - 1) * s.spacing;
  std::int64_t steps = 10'000 + dice.pick(30'000);
  const double advances[] = {0.0, dice.ratio(1e-6, 1e-4), dice.ratio(1e-4, 1e-2),
                             dice.ratio(1e-2, 0.9), dice.ratio(1, 5)};
  const double advance = advances[dice.pick(5)];
  if (advance > 0)
    steps = std::min(steps, static_cast<std::int64_t>(0.9 * room / s.spacing / advance));
  steps = std::max<std::int64_t>(steps, 50);
  s.speed = advance * s.spacing / s.time.step;
  s.duration = static_cast<double>(steps) * s.time.step;
  // the last nodes of the resonator, too: there the end of the run
  const double last = room - s.speed * s.duration;
  s.start = dice.one_in(3) ? last : dice.uniform(0, last);
  s.output.rate = 1 / (s.time.step * dice.uniform(1.0, 40.0));
  s.contact.stiffness = stiffness_for(s, dice.ratio(0.01, 1.2));

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

  if (variant.adapt) variant.adapt(s);
  Started c{make_model(s), {}};
  // multipliers would throw apart at once what overlaps at the start
  const double deepest = s.contact.law == ContactLaw::multiplier ? 0.0 : -0.1;
  if (s.initial == Initial::rest) c.model.delta += dice.uniform(deepest, 0.3) * height;
  c.start = make_start(c.model);
  if (s.initial == Initial::rest && dice.one_in(2)) {
    const auto set_velocities = [&](const Body& beam, std::vector<double>& v) {
      for (std::size_t k = 0; k < v.size(); ++k) {
        const double omega = std::max(beam.modes[k].omega, 10 / s.duration);
        v[k] = dice.uniform(-1, 1) * height * omega / beam.modes[k].shape->largest();
      }
    };
    set_velocities(c.model.resonator, c.start.resonator_v);
    set_velocities(c.model.slider, c.start.slider_v);
    count_energy(c.model, c.start);
  }
  return c;
}

Scene rough_scene(Support slider) {
  Scene s = plate_scene(7, 0.004, 1e-3);
  s.duration = 6e-4;
  s.speed = 1.0;
  s.resonator.surface = gaussian(1e-6, 3e-4, 4);
  s.slider.support = slider;
  s.slider.surface = gaussian(1e-6, 3e-4, 3);
  s.slider.modes = slider == Support::rigid ? 0 : 2;
  if (slider == Support::free)
    s.slider.load = 20;
  else
    s.gap = 2e-6;  // the asperities meet
  s.contact.stiffness = 1e14;
  return s;
}

}  // namespace ra2d::test
