// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "host/scene/scene.hpp"

/// Scenes of the tests; each test changes the keys that it is about.
namespace ra2d::test {

/// A face of raised cosines.
SurfaceSpec peaks(std::vector<Peak> list);

/// A rough face, by the root mean square of its heights and the mean spacing of its elements.
SurfaceSpec gaussian(double rq, double rsm, std::uint64_t seed);

/// A flat body of steel, pinned.
BodySpec steel(double length, double thickness, double width, double damping, int modes);

/// A body that is held and does not bend.
BodySpec rigid(BodySpec body);

/// A steel plate, 60 mm by 20 mm and 1 mm thick, under a rigid slider of its width that stands
/// still. Contact stiffness and gap are left to the test.
Scene plate_scene(int modes, double slider_length, double slider_thickness, double damping = 0.02);

/// A plate, pressed by an imposed overlap on one node, number 50, of a rigid slider's peak.
Scene pressed_plate();

/// A steel strip, 300 mm by 200 mm and 2 mm thick, under a rigid slider of its width that stands
/// still. Contact stiffness, gap and time are left to the test.
Scene strip_scene(int modes, double damping, double start, double slider_length);

}  // namespace ra2d::test
