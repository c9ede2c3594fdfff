// SPDX-License-Identifier: BSD-3-Clause
#include "tests/adaptive.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/dice.hpp"

namespace ra2d::test {

Scene adaptive(Scene scene, double tolerance) {
  scene.time.scheme = SchemeKind::adaptive;
  scene.time.tolerance = tolerance;
  return scene;
}

Started random_adaptive_scene(std::uint64_t seed, Faces faces) {
  Variant variant;
  variant.scheme = {{{SchemeKind::adaptive}}, "Adaptive"};
  variant.adapt = [seed, faces](Scene& s) {
    s.faces = faces;
    Dice dice(seed * 7919 + 13);
    const double tolerances[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
    s.time.tolerance = tolerances[dice.pick(5)];
    s.duration *= dice.ratio(0.05, 0.5);
    // each node that is passed ends a step
    s.speed =
        dice.one_in(8) ? dice.ratio(1e-10, 1e-6) : std::min(s.speed, 2000 * s.spacing / s.duration);
    if (dice.one_in(10)) {
      s.slider.support = Support::rigid;
      s.slider.modes = 0;
      s.slider.load = 0;
      s.slider.load_is_weight = false;
      if (s.resonator.support != Support::pinned) s.initial = Initial::rest;
    }
    if (dice.one_in(12)) {
      s.resonator.support = Support::rigid;
      s.resonator.modes = 0;
      s.resonator.moving_forces.clear();
      s.initial = Initial::rest;
    }
    if (dice.one_in(12)) s.slider.length = s.spacing * (1 + dice.pick(3));
  };
  return random_scene(seed, variant);
}

Recording run(const Started& c, Nodes nodes, const Launches& launches) {
  Model model = c.model;
  model.scene.time.nodes = nodes;
  return simulate(std::vector<Model>{model}, std::vector<ModalStart>{c.start}, launches)[0];
}

Recording run(Started c, double tolerance) {
  c.model.scene.time.tolerance = tolerance;
  return run(c);
}

double most_energy(const Recording& r) {
  double most = 0;
  const SampleBlock& s = r.samples;
  for (std::size_t i = 0; i < s.time.size(); ++i)
    most = std::max(most, s.kinetic[i] + s.elastic[i] + s.contact[i]);
  return most;
}

double distance(const Recording& a, const Recording& b) {
  double square = 0;
  const auto add = [&](const Body& beam, const std::vector<double>& u, const std::vector<double>& v,
                       const std::vector<double>& u1, const std::vector<double>& v1) {
    std::vector<double> du(u), dv(v);
    for (std::size_t k = 0; k < u.size(); ++k) du[k] -= u1[k], dv[k] -= v1[k];
    square += modal_energy(beam, du, dv);
  };
  add(a.model.resonator, a.end.resonator_u, a.end.resonator_v, b.end.resonator_u,
      b.end.resonator_v);
  add(a.model.slider, a.end.slider_u, a.end.slider_v, b.end.slider_u, b.end.slider_v);
  return std::sqrt(square / most_energy(b));
}

}  // namespace ra2d::test
