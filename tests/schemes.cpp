// SPDX-License-Identifier: BSD-3-Clause
#include "tests/schemes.hpp"

#include <cmath>

namespace ra2d::test {

std::vector<Scheme> schemes_and_implicit() {
  std::vector<Scheme> out = schemes;
  out.push_back({{{SchemeKind::backward_euler, ForceTime::new_time}}, "FullyImplicit"});
  return out;
}

Scene lone_beam(int modes, double damping) {
  Scene s = strip_scene(modes, damping, 0.1, 0.1);
  s.gap = 1.0;
  s.contact.stiffness = 1e14;
  return s;
}

void set_steps(Scene& s, double step, std::int64_t steps, std::int64_t samples) {
  s.time.step = step;
  s.duration = static_cast<double>(steps) * step;
  s.output.rate = static_cast<double>(samples) / s.duration;
}

double modal_energy(const Body& beam, const std::vector<double>& u, const std::vector<double>& v) {
  double sum = 0;
  for (std::size_t k = 0; k < u.size(); ++k)
    sum += 0.5 * beam.modes[k].mass * (v[k] * v[k] + std::pow(beam.modes[k].omega * u[k], 2));
  return sum;
}

void count_energy(const Model& model, ModalStart& start) {
  start.energy = modal_energy(model.resonator, start.resonator_u, start.resonator_v) +
                 modal_energy(model.slider, start.slider_u, start.slider_v);
  for (const double overlap : overlaps(model, start.resonator_u, start.slider_u))
    if (overlap > 0) start.energy += 0.5 * model.node_stiffness * overlap * overlap;
}

}  // namespace ra2d::test
