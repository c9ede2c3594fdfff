// SPDX-License-Identifier: BSD-3-Clause
#include "tests/scenes.hpp"

#include <utility>

namespace ra2d::test {

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

BodySpec steel(double length, double thickness, double width, double damping, int modes) {
  BodySpec body;
  body.length = length;
  body.thickness = thickness;
  body.width = width;
  body.young = 210e9;
  body.density = 7800;
  body.damping = damping;
  body.modes = modes;
  return body;
}

BodySpec rigid(BodySpec body) {
  body.support = Support::rigid;
  body.modes = 0;
  return body;
}

Scene plate_scene(int modes, double slider_length, double slider_thickness, double damping) {
  Scene s;
  s.duration = 2e-3;
  s.start = 0.02;
  s.spacing = 4e-5;
  s.time.step = 1e-7;
  s.output.rate = 1e6;
  s.resonator = steel(0.06, 1e-3, 0.02, damping, modes);
  s.slider = rigid(steel(slider_length, slider_thickness, 0.02, damping, 0));
  return s;
}

Scene pressed_plate() {
  Scene s = plate_scene(6, 0.004, 1e-3);
  s.duration = 2e-2;
  s.start = 0.021;
  s.gap = 5e-6;  // of 10 um: 5 um of overlap
  s.time.step = 1e-6;
  s.output.rate = 1e4;
  s.initial = Initial::statics;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 3e-5}});
  return s;
}

Scene strip_scene(int modes, double damping, double start, double slider_length) {
  Scene s;
  s.start = start;
  s.spacing = 1e-3;
  s.resonator = steel(0.3, 0.002, 0.2, damping, modes);
  s.slider = rigid(steel(slider_length, 0.002, 0.2, damping, 0));
  return s;
}

}  // namespace ra2d::test
