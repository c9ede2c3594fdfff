// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>

namespace ra2d::test {

/// A rough plate and a rough slider, 2 ms of sliding: a run takes about a millisecond.
inline const std::string quick_scene = R"(
[scene]
duration = 2e-3
speed    = 0.1
start    = 0.02
gap      = "touching"
spacing  = 2e-5
[resonator]
support   = "pinned"
length    = 0.06
thickness = 1e-3
width     = 0.02
young     = 210e9
density   = 7800
damping   = 0.02
modes     = 6
surface   = { kind = "gaussian", rq = 3e-6, rsm = 5e-4, seed = 2 }
[slider]
support   = "free"
length    = 0.01
thickness = 4e-3
width     = 0.02
young     = 210e9
density   = 7800
damping   = 0.02
modes     = 1
surface   = { kind = "gaussian", rq = 3e-6, rsm = 5e-4, seed = 1 }
load      = "weight"
[contact]
stiffness = 1e13
[time]
scheme    = "adaptive"
tolerance = 1e-6
step      = 2e-7
[output]
rate = 1e5
)";

/// All that a study's table holds but how long each run took: its bytes, made anew with no times.
/// Expects that the program's own table says the same.
std::string timeless_table(const std::filesystem::path& folder);

}  // namespace ra2d::test
