// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/run/run_report.hpp"
#include "host/run/simulation.hpp"
#include "host/scene/scene.hpp"
#include "host/store/store.hpp"

/// One scene from start to file.
namespace ra2d {

struct Progress {
  double time = 0;      // s simulated
  double duration = 0;  // s to simulate
  double wall = 0;      // s since the first step
  double steps_per_second = 0;
  double left = 0;  // s of wall time, expected
};

struct RunOptions {
  std::filesystem::path output;
  std::function<void(const Progress&)> progress;  // called a few times a second
  /// Takes Model::doubts, before the first step.
  std::function<void(const std::vector<std::string>&)> doubts;
};

/// Runs a scene to its end, an interrupt (host/interruption.hpp) or a failure, and writes the result
/// file in every case (marked when it was cut short). Throws RequestError, also for a step beyond the limits of
/// stability that the scene does not force, and FileError.
RunReport run(const Scene& scene, const RunOptions& options);

/// What a result file says of a run before its first step.
ResultHeader result_header(const Model& model);

/// Writes what a run records to the file.
std::unique_ptr<Sink> file_sink(ResultFile& file);

}  // namespace ra2d
