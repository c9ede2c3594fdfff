// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <optional>

namespace ra2d {

/// Static contact of two bodies as a convex quadratic programme: find the displacements u that
/// minimise
///   sum_k K_k u_k^2 / 2 - L_k u_k + sum_n compliance f_n^2 / 2
/// such that no overlap o_n = faces_n + sum_k shapes_nk u_k exceeds compliance f_n. Its multipliers
/// are the contact forces: f_n >= 0, and 0 where the overlap is less. Without compliance nothing
/// penetrates; the springs of penalty contact have a compliance of 1/(kappa chi w).
struct ContactProgram {
  Eigen::VectorXd stiffness;  // K, N/m of modal displacement; 0 of rigid modes
  Eigen::VectorXd load;       // L, N
  Eigen::MatrixXd shapes;     // (node, mode)
  Eigen::VectorXd faces;      // m
  double compliance = 0;      // m/N
};

struct RestingContact {
  bool feasible = true;  // false: no displacement keeps the faces apart; the rest is empty
  Eigen::VectorXd u;
  Eigen::VectorXd forces;  // N, of all nodes
};

/// Solves it by the dual active set method (Goldfarb and Idnani 1983): nodes that overlap are added
/// one by one, nodes that would pull are dropped. In each round weak springs hold the rigid modes
/// where they were before; without them the programme is solved for the active nodes found. Nothing
/// when the rounds do not end.
std::optional<RestingContact> solve(const ContactProgram& program);

}  // namespace ra2d
