// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "host/analysis/level_history.hpp"
#include "host/analysis/mesh_tone.hpp"
#include "host/result/energy.hpp"
#include "host/result/noise_figures.hpp"
#include "host/run/simulation.hpp"
#include "host/store/store.hpp"

/// The outcome of a run.
namespace ra2d {

enum class Ending {
  complete,
  interrupted,
  out_of_time,  // RunOptions::most_wall was reached
  failed,
  there  // the output has this run already, complete
};

struct RunReport : NoiseFigures {
  Ending ending = Ending::complete;
  std::string failure;              // what, when, which limit, which cure; empty unless it failed
  std::string beyond_limit;         // what the step goes beyond (time.force); empty while it holds
  std::vector<std::string> doubts;  // Model::doubts
  std::vector<std::string> warnings;  // warnings_of_figures
  double time = 0;                    // s simulated
  double counted = 0;                 // s of them after output.from
  std::int64_t steps = 0;             // made, of fixed or of adaptive length
  IntervalsOfRun intervals;           // of lv and shock_rate, by chance within this run
  MeshTone mesh;
  EnergyBalance energy;
  double contact_share_of_energy = quiet_nan;
  double vibration_share_of_energy = quiet_nan;  // of the resonator, of the balance's largest term
  double displacement_rms = quiet_nan;           // m, of the resonator about its mean
  double march_seconds = 0;                      // in the kernels
  double wall_seconds = 0;
  double read_back_seconds = 0;  // of these: to read the file back
  std::size_t memory = 0;        // bytes that the scene took where it was marched
  bool resumable = false;        // the same run goes on from a checkpoint

  double step_seconds() const { return march_seconds / std::max(1.0, static_cast<double>(steps)); }
};

/// The limit that the scene's step passes, where time.force runs it all the same; empty when it
/// holds.
/// Throws RequestError where it does not hold and is not forced.
std::string checked_limit(const Model& model);

/// `mean_squares`: of the resonator's modes (MeanSquares).
RunReport report_on(const SceneRun& run, const std::vector<double>& mean_squares);

/// How a result file calls the ending of a run that did not fail: "complete", "interrupted",
/// "stopped by --max-wall".
std::string ending_name(Ending ending);

/// The report as the figures of a file.
ResultSummary summary_of(const RunReport& report);

}  // namespace ra2d
