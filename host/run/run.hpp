// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <filesystem>
#include <functional>
#include <limits>
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
  bool fresh = false;       // go on from no checkpoint, and run this run again where it is there
  bool force = false;       // replace what is there of another run, or whatever else it is
  double checkpoint = 600;  // s of wall time between two checkpoints
  double most_wall = std::numeric_limits<double>::infinity();  // s, after which a run is cut off
  std::function<void(const Progress&)> progress;               // called a few times a second
  /// Takes Model::doubts, before the first step.
  std::function<void(const std::vector<std::string>&)> doubts;
  /// Takes what a user should hear: that a run goes on, and from where; that a result is replaced.
  std::function<void(const std::string&)> tell;
};

/// Runs a scene to its end, an interrupt (host/system/interruption.hpp), its wall time or a
/// failure, and writes the result file in every case (marked when it was cut short). What an
/// interrupt, the wall time, a kill or a disk cut short goes on from its last checkpoint when it is
/// run again, to the same bits as if nothing had happened. A result that has this run already
/// stays. Any other that is finished, or that was interrupted, and any other file but an empty one
/// is replaced by `force` alone; a failed run is replaced, and a message says so. All this is found
/// before the first step. Throws RequestError, also for a step beyond the limits of stability that
/// the scene does not force and for a checkpoint of another run, and FileError.
RunReport run(const Scene& scene, const RunOptions& options);

}  // namespace ra2d
