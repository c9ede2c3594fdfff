// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host/result/energy.hpp"
#include "host/result/record.hpp"
#include "host/run/simulation.hpp"

/// Runs kept in memory, with the time that the march takes.
namespace ra2d {

/// Modal displacements and velocities of both bodies at one instant.
struct State {
  std::vector<double> resonator_u, resonator_v, slider_u, slider_v;
};

struct TimedRun {
  Status status = Status::running;  // running: a limit of RunLimits was met
  double time = 0;                  // s simulated
  double seconds = 0;               // in the march, of all scenes side by side
  double processor = 0;             // s of the processor in the march, of all of them together
  State state;                      // at the last sample, both at the same time
  EnergyBalance energy;             // from the first sample after output.from to the last
  std::vector<Shock> shocks;        // by start; those going on as long as they have lasted
  Snapshot begin, end;              // where statistics begin (output.from), and where the run ended
};

/// Marches scenes side by side from t = 0, each to its own end or limit. Throws Interrupted
/// (host/system/interruption.hpp).
std::vector<TimedRun> timed_runs(const std::vector<Model>& models,
                                 const std::vector<ModalStart>& starts,
                                 const RunLimits& limits = {});

/// Marches one scene.
TimedRun timed_run(const Model& model, const ModalStart& start, const RunLimits& limits = {});

/// Why a run ended before its end, for people; empty where it did not.
std::string status_text(Status status);

/// Whether a state has as many modes as the model.
bool fits(const Model& model, const State& state);

/// Distance of a state from another in the norm of the energy, sqrt(sum m (V^2 + omega^2 U^2)) over
/// the modes of both bodies, relative to the other's. Modes without stiffness count by their
/// velocity alone. NaN where the other state is at rest.
double state_error(const Model& model, const State& state, const State& reference);

}  // namespace ra2d
