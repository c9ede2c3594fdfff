// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

#include "kernels/schemes/mode_step.hpp"
#include "tests/schemes.hpp"

/// The steps of the time schemes as matrices.
namespace ra2d::test {

/// The modes that contact springs of equal stiffness join; without nodes, free modes.
struct Joined {
  std::vector<Mode> modes;
  Eigen::MatrixXd phi;  // (node, mode)
  double spring = 0;    // N/m, of each node

  Eigen::Index size() const { return static_cast<Eigen::Index>(modes.size()); }
};
Joined alone(const Mode& mode);

/// One step of (U_1, ..., V_1, ...), all springs closed, as the schemes' tables define it.
Eigen::MatrixXd lagged_step(const Scheme& scheme, const Joined& j, double tau);

/// From the velocities that a scheme keeps to those at the time of U, which samples hold.
Eigen::MatrixXd synchronise(const Scheme& scheme, const Joined& j, double tau,
                            const Eigen::MatrixXd& lagged);
/// One step of (omega U, V), both at the same time; of rigid modes, of (U/tau, V).
Eigen::MatrixXd step_matrix(const Scheme& scheme, const Joined& j, double tau);
/// Spectral radius of a step.
double radius(const Scheme& scheme, const Joined& j, double tau);

/// Eigenvalues of a matrix, its right eigenvectors in columns, and their inverse. It stands behind
/// a function because it takes the compiler seconds.
struct Eigensystem {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors, inverse;

  explicit Eigensystem(const Eigen::MatrixXd& a);
};

/// The motion that a step multiplies most. The amplitude of that motion in any state, |left . y|,
/// is multiplied by the radius at each step; no other motion adds to it.
struct Dominant {
  double radius;
  Eigen::VectorXcd left;
  Eigen::VectorXd shape;  // the motion itself, at a moment
  double condition;       // of the eigenvectors: |M^n| <= condition radius^n

  explicit Dominant(const Eigen::MatrixXd& step);
  double amplitude(const Eigen::VectorXd& y) const;
};

}  // namespace ra2d::test
