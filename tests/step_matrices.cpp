// SPDX-License-Identifier: BSD-3-Clause
#include "tests/step_matrices.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "host/base/decompositions.hpp"

namespace ra2d::test {

Joined alone(const Mode& mode) { return {{mode}, Eigen::MatrixXd(0, 1), 0}; }

Eigen::MatrixXd lagged_step(const Scheme& scheme, const Joined& j, double tau) {
  const Eigen::Index n = j.size();
  const int stages = scheme.table().stages;
  std::vector<ModeStep> w;
  for (const Mode& mode : j.modes) w.push_back(scheme.table().prepare(mode, tau));
  const Eigen::MatrixXd contact_stiffness = -j.spring * j.phi.transpose() * j.phi;
  Eigen::MatrixXd map(2 * n, 2 * n);
  for (Eigen::Index column = 0; column < 2 * n; ++column) {
    const Eigen::VectorXd y = Eigen::VectorXd::Unit(2 * n, column);
    std::vector<Eigen::VectorXd> force;
    for (int i = 0; i < stages; ++i) {
      Eigen::VectorXd at = y.head(n);
      for (Eigen::Index k = 0; k < n; ++k) {
        if (i > 0) at[k] += w[k].stage_u[i] * y[k] + w[k].stage_v[i] * y[n + k];
        for (int l = 0; l < i; ++l) at[k] += w[k].stage_f[i][l] * force[l][k];
      }
      force.push_back(scheme.implicit() ? Eigen::VectorXd::Zero(n)
                                        : Eigen::VectorXd(contact_stiffness * at));
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      map(k, column) = y[k] + w[k].u_u * y[k] + w[k].u_v * y[n + k];
      map(n + k, column) = w[k].v_u * y[k] + w[k].v_v * y[n + k];
      for (int i = 0; i < stages; ++i) {
        map(k, column) += w[k].u_f[i] * force[i][k];
        map(n + k, column) += w[k].v_f[i] * force[i][k];
      }
    }
  }
  if (!scheme.implicit()) return map;
  // U1 = U* + held_u F, V1 = V* + held_v F, F = contact_stiffness U1
  Eigen::VectorXd held_u(n), held_v(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    held_u[k] = w[k].held_u();
    held_v[k] = w[k].held_v();
  }
  const Eigen::MatrixXd left =
      Eigen::MatrixXd::Identity(n, n) - held_u.asDiagonal() * contact_stiffness;
  map.topRows(n) = left.partialPivLu().solve(Eigen::MatrixXd(map.topRows(n)));
  map.bottomRows(n) += held_v.asDiagonal() * contact_stiffness * map.topRows(n);
  return map;
}

Eigen::MatrixXd synchronise(const Scheme& scheme, const Joined& j, double tau,
                            const Eigen::MatrixXd& lagged) {
  const Eigen::Index n = j.size();
  const double lag = scheme.implicit() ? 0.0 : scheme.table().velocity_lag;
  Eigen::MatrixXd s = Eigen::MatrixXd::Identity(2 * n, 2 * n);
  if (lag == 0) return s;
  const Eigen::MatrixXd change = lagged.bottomRows(n) - s.bottomRows(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const ModeStep w = scheme.table().prepare(j.modes[k], tau);
    Eigen::RowVectorXd pushed = lagged.row(n + k);
    pushed[n + k] -= w.v_v;
    s.row(n + k) = w.now_mean * (s.row(n + k) + lag * change.row(k)) + w.now_pushed * pushed;
  }
  return s;
}

Eigen::MatrixXd step_matrix(const Scheme& scheme, const Joined& j, double tau) {
  const Eigen::MatrixXd lagged = lagged_step(scheme, j, tau),
                        s = synchronise(scheme, j, tau, lagged);
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(2 * j.size());
  for (Eigen::Index k = 0; k < j.size(); ++k)
    scale[k] = j.modes[k].omega > 0 ? j.modes[k].omega : 1 / tau;
  return scale.asDiagonal() * s * lagged * s.inverse() * scale.cwiseInverse().asDiagonal();
}

double radius(const Scheme& scheme, const Joined& j, double tau) {
  return eigenvalues(step_matrix(scheme, j, tau)).cwiseAbs().maxCoeff();
}

Eigensystem::Eigensystem(const Eigen::MatrixXd& a) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(a);
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
  inverse = vectors.inverse();
}

namespace {

/// The largest singular value.
double largest_stretch(const Eigen::MatrixXcd& a) {
  const Eigen::Index n = a.cols();
  const Eigen::MatrixXcd square = a.adjoint() * a;
  Eigen::MatrixXd real(2 * n, 2 * n);  // each of its eigenvalues twice
  real << square.real(), -square.imag(), square.imag(), square.real();
  return std::sqrt(symmetric_eigen(real).values.maxCoeff());
}

}  // namespace

Dominant::Dominant(const Eigen::MatrixXd& step) {
  const Eigensystem system(step);
  const Eigen::VectorXd size = system.values.cwiseAbs();
  Eigen::Index most = 0;
  radius = size.maxCoeff(&most);
  left = system.inverse.row(most).transpose();
  // at the phase at which it is largest
  const Eigen::VectorXcd motion = system.vectors.col(most);
  const std::complex<double> square = (motion.transpose() * motion)(0);
  shape = (std::polar(1.0, -0.5 * std::arg(square)) * motion).real();
  condition = largest_stretch(system.vectors) * largest_stretch(system.inverse);
}

double Dominant::amplitude(const Eigen::VectorXd& y) const {
  return std::abs((left.transpose() * y.cast<std::complex<double>>())(0));
}

}  // namespace ra2d::test
