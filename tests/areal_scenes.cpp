// SPDX-License-Identifier: BSD-3-Clause
#include "tests/areal_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/body/block.hpp"
#include "host/body/plate.hpp"
#include "tests/dice.hpp"
#include "tests/scenes.hpp"

namespace ra2d::test {

HeightMap rough_map(int rows, int nodes, double rms, std::uint64_t seed) {
  constexpr int waves = 12;
  Dice dice(seed);
  HeightMap map(rows, std::vector<double>(nodes, 0.0));
  for (int w = 0; w < waves; ++w) {
    const double wave = 2 * std::numbers::pi / dice.uniform(6, 25),
                 direction = dice.uniform(0, 2 * std::numbers::pi),
                 phase = dice.uniform(0, 2 * std::numbers::pi);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < nodes; ++i)
        map[j][i] += rms * std::sqrt(2.0 / waves) *
                     std::cos(wave * (i * std::cos(direction) + j * std::sin(direction)) + phase);
  }
  return map;
}

ArealScene small_areal_scene(Support block, int modes) {
  ArealScene s;
  s.plate = steel(0.06, 1e-3, 0.04, 0.02, modes);
  s.plate.poisson = 0.3;
  s.block = steel(5.8e-3, 5e-3, 2.5e-3, 0, 0);
  s.block.support = block;
  s.spacing = 2e-4, s.spacing_y = 2.5e-4;
  s.start = 0.0101, s.side = 0.007;
  s.speed = 2;
  s.gap = 5.5e-6;
  s.stiffness = 1e14;
  s.plate_heights = rough_map(10, 301, 2e-6, 1);
  s.block_heights = rough_map(10, 30, 2e-6, 2);
  if (block == Support::free) s.block.load = 5;
  return s;
}

ArealScene rigid_block() { return small_areal_scene(Support::rigid); }
ArealScene free_block() { return small_areal_scene(Support::free); }
ArealScene sixty_modes() {
  ArealScene s = small_areal_scene(Support::rigid, 60);
  s.spacing_y = 1e-4;
  s.block.width = 1e-3;
  s.gap = 5e-6;
  return s;
}
ArealScene one_bump() {
  ArealScene s = small_areal_scene(Support::rigid);
  for (std::vector<double>& row : s.block_heights) row.assign(30, 0.0);
  for (std::vector<double>& row : s.plate_heights) row.assign(301, 0.0);
  s.gap = 9.5e-6;
  s.plate_heights[3][64] = 1e-5;
  s.plate_heights[4][64] = 1.1e-5;
  s.plate_heights[4][65] = 9e-6;
  return s;
}
ArealScene many_nodes(int modes) {
  ArealScene s = small_areal_scene(Support::free, modes);
  s.spacing = 5e-5, s.spacing_y = 1e-4;
  s.block.length = 149 * s.spacing, s.block.width = 37 * s.spacing_y;
  s.side = 0.003;
  s.gap = 6.5e-6;
  s.plate_heights = rough_map(37, 1201, 2e-6, 3);
  s.block_heights = rough_map(37, 150, 2e-6, 4);
  return s;
}
ArealScene fine_maps(int modes, int rows, double last_row) {
  constexpr int nodes = 40;
  ArealScene s = small_areal_scene(Support::free, modes);
  s.spacing = 3e-6, s.spacing_y = 2.5e-6;
  s.block.length = (nodes - 1) * s.spacing, s.block.width = rows * s.spacing_y;
  s.block.thickness = 0.05;  // heavy enough to keep the faces in contact
  s.block.load = 0.03;
  s.speed = 0.2;
  s.stiffness = 1e16;
  s.plate_heights = rough_map(rows, 3420 + nodes, 1e-7, 5);
  s.block_heights = rough_map(rows, nodes, 1e-7, 6);
  for (double& height : s.block_heights.back()) height += last_row;
  double highest = -1;
  const auto first = static_cast<int>(s.start / s.spacing);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < nodes; ++i)
      highest = std::max(highest, s.plate_heights[j][first + i] + s.block_heights[j][i]);
  s.gap = highest - 3e-8;
  return s;
}
RandomMaps random_maps(std::uint64_t seed, int most_modes, bool is_small) {
  Dice dice(seed);
  RandomMaps drawn;
  ArealScene& s = drawn.scene;
  s.plate = steel(0.06, dice.ratio(3e-4, 3e-3), 0.04, dice.one_in(4) ? 0 : dice.ratio(1e-3, 0.3),
                  static_cast<int>(dice.ratio(1, most_modes + 1)));
  s.plate.poisson = dice.uniform(-0.5, 0.45);
  const Body plate = make_plate(s.plate);
  drawn.fastest = plate.modes.back().omega;
  drawn.duration = dice.ratio(3, is_small ? 20 : 60) / drawn.fastest;

  // whole squares of nodes, and one to three rows more
  const bool has_squares = !is_small && dice.one_in(2);
  const int rows = has_squares ? 16 * (1 + dice.pick(2)) + dice.pick(4)
                               : 1 + dice.pick(is_small ? 6 : 12),
            nodes = 2 + dice.pick(is_small ? 10 : 30);
  s.spacing = dice.ratio(2e-6, 3e-4);
  s.spacing_y = std::min(s.spacing * dice.ratio(0.3, 3), 0.03 / rows);
  s.block = steel((nodes - 1) * s.spacing, 5e-3, rows * s.spacing_y, 0, 0);
  s.block.support = dice.one_in(3) ? Support::rigid : Support::free;
  s.side = dice.one_in(4) ? 0 : dice.uniform(0, s.plate.width - s.block.width);

  // any of: at rest, less than a spacing, some, many
  const double paths[] = {0, dice.ratio(1e-3, 1), dice.ratio(1, 10), dice.ratio(10, 80)};
  const double path = paths[dice.pick(4)];
  s.speed = path * s.spacing / drawn.duration;
  const double room = s.plate.length - (nodes + path) * s.spacing;
  s.start = dice.one_in(4) ? 0 : dice.uniform(0, room);

  // the plate's map up to where the block comes to
  const double rms = dice.ratio(1e-8, 1e-5);
  const auto first = static_cast<int>(s.start / s.spacing);
  const HeightMap strip = rough_map(rows, nodes + static_cast<int>(path) + 3, rms, 2 * seed);
  s.block_heights = rough_map(rows, nodes, dice.one_in(4) ? 0 : rms, 2 * seed + 1);
  for (const std::vector<double>& row : strip) {
    std::vector<double>& all = s.plate_heights.emplace_back(first, 0.0);
    all.insert(all.end(), row.begin(), row.end());
  }
  double highest = -1;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < nodes; ++i)
      highest = std::max(highest, strip[j][i] + s.block_heights[j][i]);
  s.gap = highest + rms * dice.uniform(-0.1, 0.3);

  const Body block = make_block(s.block);
  const double mobility = largest_shape(plate) + largest_shape(block);
  s.stiffness =
      std::pow(drawn.fastest * dice.ratio(0.1, 2), 2) / (mobility * s.spacing * s.spacing_y);
  const auto set_velocities = [&](const Body& body, std::vector<double>& u,
                                  std::vector<double>& v) {
    u.assign(body.modes.size(), 0.0);
    for (const BodyMode& mode : body.modes)
      v.push_back(dice.uniform(-1, 1) * rms * std::max(mode.omega, 3 / drawn.duration) /
                  (mode.shape->largest() * std::sqrt(static_cast<double>(body.modes.size()))));
  };
  if (!dice.one_in(4)) set_velocities(plate, s.plate_u, s.plate_v);
  if (s.block.support == Support::free) {
    s.block.load = dice.ratio(0.01, 10);
    set_velocities(block, s.block_u, s.block_v);
  }
  if (dice.one_in(4))
    s.forces.push_back({dice.uniform(-5, 5), dice.ratio(1, 100), dice.uniform(0, 0.05),
                        dice.uniform(0, s.plate.width)});
  return drawn;
}

ArealScene mirrored(ArealScene scene) {
  scene.side = scene.plate.width - scene.block.width - scene.side;
  std::reverse(scene.plate_heights.begin(), scene.plate_heights.end());
  std::reverse(scene.block_heights.begin(), scene.block_heights.end());
  for (ArealForce& f : scene.forces) f.y = scene.plate.width - f.y;
  return scene;
}

ArealState mirrored(const ArealScene& scene, ArealState state) {
  const std::vector<PinnedPlateMode> modes = plate_modes(scene.plate, 1000);
  for (std::size_t k = 0; k < modes.size(); ++k)
    if (modes[k].n % 2 == 0) state.plate_u[k] *= -1, state.plate_v[k] *= -1;
  if (!state.block_u.empty()) state.block_u[2] *= -1, state.block_v[2] *= -1;
  return state;
}

double apart(const Body& body, const std::vector<double>& u, const std::vector<double>& v,
             const std::vector<double>& u1, const std::vector<double>& v1) {
  double sum = 0;
  for (std::size_t k = 0; k < body.modes.size(); ++k)
    sum += 0.5 * body.modes[k].mass *
           (std::pow(v[k] - v1[k], 2) + std::pow(body.modes[k].omega * (u[k] - u1[k]), 2));
  return sum;
}

double state_distance(const ArealScene& s, const ArealState& a, const ArealState& b) {
  const double sum = apart(make_plate(s.plate), a.plate_u, a.plate_v, b.plate_u, b.plate_v) +
                     apart(make_block(s.block), a.block_u, a.block_v, b.block_u, b.block_v);
  return std::sqrt(sum / a.energy());
}

namespace {

/// As a scene of the program, whose steps and nodes are still to be chosen.
Scene scene_of(const ArealScene& of) {
  Scene s;
  s.resonator = of.plate;
  s.slider = of.block;
  s.spacing = of.spacing;
  s.faces = of.faces;
  s.start = of.start;
  s.speed = of.speed;
  s.gap = of.gap;
  s.contact.stiffness = of.stiffness;
  for (const ArealForce& f : of.forces)
    s.resonator.moving_forces.push_back({f.force, f.speed, f.start, f.y});
  return s;
}

Started start_of(const ArealScene& of, const Scene& s) {
  HeightMaps maps{.rows = static_cast<int>(of.block_heights.size()),
                  .spacing_y = of.spacing_y,
                  .side = of.side,
                  .resonator = {},
                  .slider = {}};
  for (const auto& [rows, to] :
       {std::pair{&of.plate_heights, &maps.resonator}, {&of.block_heights, &maps.slider}})
    for (const std::vector<double>& row : *rows) to->insert(to->end(), row.begin(), row.end());
  Started started{make_model(s, maps), {}};
  started.start = make_start(started.model);
  const auto take = [](std::vector<double>& to, const std::vector<double>& from) {
    if (!from.empty()) to = from;
  };
  take(started.start.resonator_u, of.plate_u);
  take(started.start.resonator_v, of.plate_v);
  take(started.start.slider_u, of.block_u);
  take(started.start.slider_v, of.block_v);
  count_energy(started.model, started.start);
  return started;
}

}  // namespace

Started areal_march(const ArealScene& of, const Scheme& scheme, double step, std::int64_t steps,
                    std::int64_t samples, Nodes nodes) {
  Scene s = scene_of(of);
  s.time = scheme.time;
  s.contact.law = scheme.law;
  s.time.nodes = nodes;
  set_steps(s, step, steps, samples);
  return start_of(of, s);
}

Started areal_march(const ArealScene& of, double tolerance, double duration, std::int64_t samples,
                    Nodes nodes) {
  Scene s = scene_of(of);
  s.time.scheme = SchemeKind::adaptive;
  s.time.tolerance = tolerance;
  s.time.nodes = nodes;
  s.duration = duration;
  s.output.rate = static_cast<double>(samples) / duration;
  return start_of(of, s);
}

Started with_rows(Started plane, int rows) {
  Model& m = plane.model;
  m.is_areal = true;
  m.rows = rows;
  m.spacing_y = m.scene.slider.width / rows;
  m.node_stiffness = m.scene.contact.stiffness * m.scene.spacing * m.spacing_y;
  for (SharedNumbers* numbers :
       {&m.resonator_height, &m.slider_height, &m.resonator_curvature, &m.slider_curvature}) {
    const std::vector<double> row = *numbers;
    std::vector<double>& all = numbers->edit();
    for (int j = 1; j < rows; ++j) all.insert(all.end(), row.begin(), row.end());
  }
  return plane;
}

Recording simulate(const Started& started, const Launches& launches) {
  return simulate(std::vector{started.model}, std::vector{started.start}, launches)[0];
}

ArealState state_at(const Recording& r, std::size_t sample) {
  const auto row = [&](const std::vector<double>& all, const Body& body) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(sample * body.modes.size());
    return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(body.modes.size()));
  };
  const SampleBlock& s = r.samples;
  ArealState state;
  state.time = s.time[sample];
  state.plate_u = row(s.resonator_displacement, r.model.resonator);
  state.plate_v = row(s.resonator_velocity, r.model.resonator);
  state.block_u = row(s.slider_displacement, r.model.slider);
  state.block_v = row(s.slider_velocity, r.model.slider);
  state.force = s.force[sample];
  state.contacts = static_cast<int>(std::lround(s.nodes[sample]));
  state.kinetic = s.kinetic[sample];
  state.elastic = s.elastic[sample];
  state.contact = s.contact[sample];
  return state;
}

ArealReference reference_at_samples(const ArealScene& scene, double duration, int samples) {
  std::vector<double> times;
  for (int i = 0; i <= samples; ++i) times.push_back(duration * i / samples);
  return areal_reference(scene, times);
}
double largest_distance(const ArealScene& scene, const ArealReference& reference,
                        const Recording& recording) {
  double most = 0;
  for (std::size_t i = 1; i < reference.states.size(); ++i)
    most = std::max(most, state_distance(scene, reference.states[i], state_at(recording, i)));
  return most;
}

}  // namespace ra2d::test
