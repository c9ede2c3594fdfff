// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <optional>

namespace ra2d {

/// Modes that rest on one another under a load, as a convex quadratic programme: the displacements
/// u that make
///   sum_k K_k u_k^2 / 2 - L_k u_k + sum_n compliance f_n^2 / 2
/// least, where no overlap o_n = faces_n + sum_k shapes_nk u_k exceeds compliance f_n. Its
/// multipliers are the contact forces: f_n >= 0, and 0 where the overlap is less. A compliance of 0
/// is contact without penetration; the springs of penalty contact have 1/(kappa chi w).
struct ContactProgram {
  Eigen::VectorXd stiffness;  // K, N/m of modal displacement; 0 of rigid modes
  Eigen::VectorXd load;       // L, N
  Eigen::MatrixXd shapes;     // (node, mode)
  Eigen::VectorXd faces;      // m
  double compliance = 0;      // m/N
};

struct RestingContact {
  bool feasible = true;  // false: no displacement keeps the faces apart; then there is nothing else
  Eigen::VectorXd u;
  Eigen::VectorXd forces;  // N, of all nodes
};

/// Solves it by the dual active set method (Goldfarb and Idnani 1983): nodes that overlap are taken
/// in one by one, those that would pull are let go. Rigid modes are held by a weak spring to where
/// they were a round before; of the set that comes out the programme is solved as it stands.
/// Nothing when the rounds do not end.
std::optional<RestingContact> solve(const ContactProgram& program);

}  // namespace ra2d
