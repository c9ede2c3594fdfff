// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <vector>

#include "host/model/model.hpp"

/// Contact between smooth faces at t = 0, by quadrature: an independent form of what the march
/// integrates in closed form (kernels/contact/cell_contact.hpp).
namespace ra2d {

/// Of the undeformed faces at t = 0 [m], anywhere along the slider.
double largest_smooth_overlap(const Model& model);

/// The contact at t = 0, summed over the cells.
struct SmoothContact {
  double force = 0, energy = 0;  // N, J
  std::vector<int> cells;        // with any contact, by their left nodes, in ascending order
};

/// Contact at the modal displacements u, the resonator's first.
SmoothContact smooth_contact(const Model& model, const std::vector<double>& u);

/// Displacements in static equilibrium under load and contact: the minimum of the convex potential
///   sum_k m omega_k^2 U_k^2 / 2 - load_k U_k  +  kappa w / 2 times the integral of max(0, o)^2,
/// by Newton's method from `guess` (none: empty) or, should that not settle, from no displacement
/// with springs that are stiffened to their full stiffness. Nothing when neither settles. `first`:
/// of areal scenes, cells that are looked at from the beginning, by their left nodes.
std::optional<std::vector<double>> smooth_equilibrium(const Model& model,
                                                      const std::vector<double>& guess,
                                                      const std::vector<int>& first);

/// Static equilibrium under multipliers.
struct SmoothRest {
  bool feasible = true;    // false: no displacement keeps the faces apart; the rest is empty
  std::vector<double> u;   // displacements, the resonator's first
  double force = 0;        // N
  std::vector<int> cells;  // that carry force, in ascending order
};

/// The quadratic programme of host/model/contact_program.hpp with a condition at every place along
/// the slider, by exchange: it is solved for some places, and those where the faces overlap then
/// come in, until none is left. Nothing when it does not settle. `first`: cells of which the
/// highest places are taken first, by their left nodes; empty: all.
std::optional<SmoothRest> smooth_rest(const Model& model, const std::vector<int>& first);

}  // namespace ra2d
