// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/analysis/sound_pressure.hpp"
#include "host/run/run_report.hpp"

namespace ra2d {

/// Warnings that a reader of a run's figures should not overlook, each a sentence.
std::vector<std::string> warnings_of_figures(const Scene& scene, const RunReport& report);

/// The report's, and those of the sound at the scene's microphones.
std::vector<std::string> warnings_of(const RunReport& report, const SceneSound& sound);

}  // namespace ra2d
