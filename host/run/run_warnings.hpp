// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/analysis/sound_pressure.hpp"
#include "host/run/run_report.hpp"

namespace ra2d {

/// Warnings that a reader of a run's figures should not overlook, each a sentence. `sound`: at the
/// scene's microphones.
std::vector<std::string> warnings_of(const Scene& scene, const RunReport& report,
                                     const SceneSound& sound);

}  // namespace ra2d
