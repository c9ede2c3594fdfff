// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "host/scene/scene.hpp"
#include "tests/areal_reference.hpp"
#include "tests/outcomes.hpp"

/// Areal scenes of the tests, and how far two states of one are apart.
namespace ra2d::test {

/// Waves of random directions, 6 to 25 nodes long; `rms` in m.
HeightMap rough_map(int rows, int nodes, double rms, std::uint64_t seed);

/// A block of 30 x 10 nodes on a plate of 60 x 40 x 1 mm, off its middle.
ArealScene small_areal_scene(Support block, int modes = 40);
ArealScene rigid_block();
ArealScene free_block();
ArealScene sixty_modes();
ArealScene one_bump();
/// 150 x 37 nodes: many tiles.
ArealScene many_nodes(int modes = 30);

/// 40 x 24 nodes, 3 um apart: contacts of many nodes each, which the march gathers in clusters at
/// tolerances of 1e-6 and 1e-8. Or other rows, the last of which is raised [m].
ArealScene fine_maps(int modes = 40, int rows = 24, double last_row = 0);

struct RandomMaps {
  ArealScene scene;
  double fastest = 0;   // rad/s, of the plate
  double duration = 0;  // s, that a march is to take
};
/// A scene of any kind, with up to so many modes of the plate. `is_small`: so few nodes, and so
/// briefly, that the reference takes part of a second.
RandomMaps random_maps(std::uint64_t seed, int most_modes, bool is_small = false);

/// A scene with y turned round.
ArealScene mirrored(ArealScene scene);
/// A state of it, as of the scene that was turned round.
ArealState mirrored(const ArealScene& scene, ArealState state);

/// The energy of the difference of two motions of a body [J].
double apart(const Body& body, const std::vector<double>& u, const std::vector<double>& v,
             const std::vector<double>& u1, const std::vector<double>& v1);
/// The distance of two states in the norm whose square is the energy, over that of the first.
double state_distance(const ArealScene& scene, const ArealState& a, const ArealState& b);

/// The scene made ready to march in fixed steps, with so many samples besides the first.
Started areal_march(const ArealScene& scene, const Scheme& scheme, double step, std::int64_t steps,
                    std::int64_t samples = 1, Nodes nodes = Nodes::all);

/// The scene made ready for the adaptive scheme.
Started areal_march(const ArealScene& scene, double tolerance, double duration,
                    std::int64_t samples = 1, Nodes nodes = Nodes::candidates);

/// The areal twin of a plane scene: beams in place of plate and block, the same faces in every row.
Started with_rows(Started plane, int rows);

/// The march of one scene.
Recording simulate(const Started& started, const Launches& launches = {});

/// Displacements and rates at a sample.
ArealState state_at(const Recording& recording, std::size_t sample);

/// The reference at t = 0 and so many samples of a run.
ArealReference reference_at_samples(const ArealScene& scene, double duration, int samples);
/// The largest state_distance between its states and those of a recording.
double largest_distance(const ArealScene& scene, const ArealReference& reference,
                        const Recording& recording);

}  // namespace ra2d::test
