// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "host/model/model.hpp"
#include "host/store/store.hpp"

/// The model solved by general-purpose integrators: an independent reference for the march, and
/// what its cost is measured against. Nothing here uses the kernels.
namespace ra2d::peers {

enum class Integrator {
  cvode_adams,  // CVODE of SUNDIALS: Adams-Moulton, orders 1 to 12, fixed-point iteration
  cvode_bdf,    // CVODE: BDF, orders 1 to 5, Newton with the exact dense Jacobian
  dopri5        // Boost.Odeint: Dormand and Prince 5(4), step size controlled
};

/// `tolerance` is relative. The absolute one of a mode is tolerance v/max|psi| for its velocity
/// and, divided by its omega, for its displacement, so that every mode may err by as much energy;
/// v [m/s] is the velocity at which the lowest mode swings by the faces' roughness. A mode with
/// omega = 0 has the lowest one's.
struct PeerOptions {
  Integrator integrator = Integrator::cvode_adams;
  Nodes nodes = Nodes::candidates;
  double tolerance = 1e-8;
  double until = 0;  // s
};

struct PeerResult {
  std::vector<double> resonator_u, resonator_v, slider_u, slider_v;  // at `until`
  std::int64_t steps = 0, evaluations = 0;  // accepted steps; right-hand sides
  std::int64_t displacement_sums = 0;       // sums of the displacements of all nodes
  double march_seconds = 0;                 // the integration alone
  /// CVODE only: in order of their start, with start, duration (until `until` at the most), peak
  /// force and serial; impulse and position are left at 0.
  std::vector<Shock> shocks;
  std::int64_t onsets = 0;  // CVODE only: nodes that came into contact
};

/// Integrates from `start` to `until`.
///
/// CVODE follows which nodes touch: in a step that set stays, so that the right-hand side is
/// smooth; the step ends, and the integration starts anew, where a gap changes its sign.
/// dopri5 takes the penalty force as it is and leaves its kinks to the error control.
/// With Nodes::all CVODE evaluates every gap after each step and dopri5 in each right-hand side;
/// with Nodes::candidates at those that can touch (bench/peers/evaluated_nodes.hpp).
///
/// Throws RequestError for what cannot be done (multipliers, smooth faces, areal scenes by CVODE, a
/// tolerance outside 1e-15 to 0.1, an `until` outside the scene), SimulationError when the
/// integrator gives up.
PeerResult march_peer(const Model& model, const ModalStart& start, const PeerOptions& options);

}  // namespace ra2d::peers
