// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/analysis/sound_pressure.hpp"
#include "host/run/run_report.hpp"

/// The outcome of a run for other programs.
namespace ra2d {

/// One JSON object, a line. Names and units are those of `ra2d analyze --json` (docs/results.md);
/// null for what there is not. `zooms`: the files of its windows; `sound`: at the
/// scene's microphones.
std::string run_json(const Scene& scene, const RunReport& report,
                     const std::filesystem::path& output, int exit_status,
                     const std::vector<std::filesystem::path>& zooms, const SceneSound& sound);

/// The report of a run that was found in its file, complete (Ending::there). Its ending stays
/// `there`. What only the running program knew is NaN or 0. Throws FileError.
RunReport report_of_file(const Scene& scene, const std::filesystem::path& file);

}  // namespace ra2d
