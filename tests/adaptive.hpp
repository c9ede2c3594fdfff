// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "tests/outcomes.hpp"
#include "tests/simulate.hpp"

/// Scenes for the adaptive scheme, and how far two runs of one are apart.
namespace ra2d::test {

Scene adaptive(Scene scene, double tolerance);

/// Of any kind: those of random_scene(), and more often what is odd: rigid bodies, sliders of one
/// or two nodes, hardly any speed, a duration that is no whole number of samples.
Started random_adaptive_scene(std::uint64_t seed, Faces faces = Faces::linear);

Recording run(const Started& c, Nodes nodes = Nodes::candidates, const Launches& launches = {});
Recording run(Started c, double tolerance);

/// The most energy that there was at a sample [J].
double most_energy(const Recording& r);

/// How far the ends of two runs of a scene are apart: in the norm whose square is the energy, over
/// the most that there was.
double distance(const Recording& a, const Recording& b);

}  // namespace ra2d::test
