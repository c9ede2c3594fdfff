// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "host/scene/scene.hpp"

/// What the tests' scenes have in common; each test changes on it what it is about.
namespace ra2d::test {

/// A face of raised cosines.
inline SurfaceSpec peaks(std::vector<Peak> list) {
  SurfaceSpec surface;
  surface.kind = SurfaceKind::peaks;
  surface.peaks = std::move(list);
  return surface;
}

/// A rough face, by the root mean square of its heights and the mean spacing of its elements.
inline SurfaceSpec gaussian(double rq, double rsm, std::uint64_t seed) {
  SurfaceSpec surface;
  surface.kind = SurfaceKind::gaussian;
  surface.rq = rq;
  surface.rsm = rsm;
  surface.seed = seed;
  return surface;
}

/// A flat body of steel, pinned.
inline BodySpec steel(double length, double thickness, double width, double damping, int modes) {
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

/// A body that is held and does not bend.
inline BodySpec rigid(BodySpec body) {
  body.support = Support::rigid;
  body.modes = 0;
  return body;
}

/// A steel plate, 60 mm by 20 mm and 1 mm thick, under a rigid slider of its width that stands
/// still. Contact stiffness and gap are left to the test.
inline Scene plate_scene(int modes, double slider_length, double slider_thickness,
                         double damping = 0.02) {
  Scene s;
  s.duration = 2e-3;
  s.start = 0.02;
  s.spacing = 4e-5;
  s.step = 1e-7;
  s.rate = 1e6;
  s.resonator = steel(0.06, 1e-3, 0.02, damping, modes);
  s.slider = rigid(steel(slider_length, slider_thickness, 0.02, damping, 0));
  return s;
}

/// A plate, pressed by an imposed overlap on one node, number 50, of a rigid slider's peak.
inline Scene pressed_plate() {
  Scene s = plate_scene(6, 0.004, 1e-3);
  s.duration = 2e-2;
  s.start = 0.021;
  s.gap = 5e-6;  // of 10 um: 5 um of overlap
  s.step = 1e-6;
  s.rate = 1e4;
  s.initial = Initial::statics;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 3e-5}});
  return s;
}

/// A steel strip, 300 mm by 200 mm and 2 mm thick, under a rigid slider of its width that stands
/// still. Contact stiffness, gap and time are left to the test.
inline Scene strip_scene(int modes, double damping, double start, double slider_length) {
  Scene s;
  s.start = start;
  s.spacing = 1e-3;
  s.resonator = steel(0.3, 0.002, 0.2, damping, modes);
  s.slider = rigid(steel(slider_length, 0.002, 0.2, damping, 0));
  return s;
}

}  // namespace ra2d::test
