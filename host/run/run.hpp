// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/device/batch.hpp"
#include "host/result/energy.hpp"
#include "host/result/record.hpp"
#include "host/scene/scene.hpp"

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

enum class Ending { complete, interrupted, failed };

struct RunReport {
  Ending ending = Ending::complete;
  std::string failure;       // what, when, which limit, which cure; empty unless it failed
  std::string beyond_limit;  // what the step goes beyond (time.force); empty while it holds
  double time = 0;           // s simulated
  double counted = 0;        // s of them after output.from
  std::int64_t steps = 0;    // made, of fixed or of adaptive length
  // from output.from on; what there is none of is NaN
  double v_rms = 0, lv = 0;                     // m/s, dB
  double shocks = 0;                            // per simulated second
  double duration_median = 0, duration_90 = 0;  // s
  double force_median = 0, force_90 = 0;        // N, of the peak force
  double contact_share = 0;                     // of the time
  double evaluated = 0;                         // nodes a step, of the whole run
  EnergyBalance energy;
  double march_seconds = 0;  // in the kernels
  double wall_seconds = 0;
  double read_back_seconds = 0;  // of these: to read the file back

  double step_seconds() const { return march_seconds / std::max(1.0, static_cast<double>(steps)); }
};

/// Runs a scene to its end, an interrupt (host/interruption.hpp) or a failure, and writes the result
/// file in every case (marked when it was cut short). Throws RequestError, also for a step beyond the limits of
/// stability that the scene does not force, and FileError.
RunReport run(const Scene& scene, const RunOptions& options);

}  // namespace ra2d
