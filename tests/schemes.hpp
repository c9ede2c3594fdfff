// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "host/plan/schemes.hpp"
#include "host/run/model.hpp"
#include "kernels/schemes/mode_step.hpp"
#include "tests/scenes.hpp"

/// The time schemes in tests: their steps as matrices, and scenes on which they are alone.
namespace ra2d::test {

/// A scheme with the time of its contact force.
struct Scheme {
  std::string name;
  SchemeKind kind;
  ForceTime force_time = ForceTime::old_time;

  const SchemeTable& table() const { return scheme_table(kind); }
  bool implicit() const { return force_time == ForceTime::new_time; }
};
inline const std::vector<Scheme> schemes = {{"ExplicitEuler", SchemeKind::explicit_euler},
                                            {"Midpoint", SchemeKind::midpoint},
                                            {"BackwardEuler", SchemeKind::backward_euler},
                                            {"Heun", SchemeKind::heun},
                                            {"Rk4", SchemeKind::rk4},
                                            {"Rk8", SchemeKind::rk8},
                                            {"Exact", SchemeKind::exact}};
/// ... and backward Euler with the contact force of the new time.
inline std::vector<Scheme> schemes_and_implicit() {
  std::vector<Scheme> out = schemes;
  out.push_back({"FullyImplicit", SchemeKind::backward_euler, ForceTime::new_time});
  return out;
}
inline Scene with(Scene scene, const Scheme& scheme) {
  scene.scheme = scheme.kind;
  scene.force_time = scheme.force_time;
  return scene;
}

/// omega tau from 1e-4 to 1e2, damping from none to beyond critical.
struct RandomModes {
  std::mt19937_64 random{7};
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  double tau() { return std::pow(10.0, uniform(-7, -4)); }
  Mode mode(double tau, double most = 1e2) {
    const double zeta = uniform(0, 1) < 0.3 ? 0.0 : std::pow(10.0, uniform(-3, 0.3));
    return {std::pow(10.0, uniform(-4, std::log10(most))) / tau, zeta, uniform(0.1, 10)};
  }
};

// ---- steps as matrices

/// The modes that contact springs of equal stiffness join; without nodes, free modes.
struct Joined {
  std::vector<Mode> modes;
  Eigen::MatrixXd phi;  // (node, mode)
  double spring = 0;    // N/m, of each node

  Eigen::Index size() const { return static_cast<Eigen::Index>(modes.size()); }
};
inline Joined alone(const Mode& mode) { return {{mode}, Eigen::MatrixXd(0, 1), 0}; }

/// One step of (U_1, ..., V_1, ...), all springs closed, as the schemes' tables define it.
inline Eigen::MatrixXd lagged_step(const Scheme& scheme, const Joined& j, double tau) {
  const Eigen::Index n = j.size();
  const int stages = scheme.table().stages;
  std::vector<ModeStep> w;
  for (const Mode& mode : j.modes) w.push_back(scheme.table().prepare(mode, tau));
  const Eigen::MatrixXd pull = -j.spring * j.phi.transpose() * j.phi;
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
      force.push_back(scheme.implicit() ? Eigen::VectorXd::Zero(n) : Eigen::VectorXd(pull * at));
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
  // U1 = U* + held_u F, V1 = V* + held_v F, F = pull U1
  Eigen::VectorXd held_u(n), held_v(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    held_u[k] = w[k].held_u();
    held_v[k] = w[k].held_v();
  }
  const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(n, n) - held_u.asDiagonal() * pull;
  map.topRows(n) = left.partialPivLu().solve(Eigen::MatrixXd(map.topRows(n)));
  map.bottomRows(n) += held_v.asDiagonal() * pull * map.topRows(n);
  return map;
}

/// From the velocities that a scheme keeps to those at the time of U, which samples hold.
inline Eigen::MatrixXd synchronise(const Scheme& scheme, const Eigen::MatrixXd& lagged) {
  const Eigen::Index n = lagged.rows() / 2;
  const double lag = scheme.implicit() ? 0.0 : scheme.table().velocity_lag;
  Eigen::MatrixXd s = Eigen::MatrixXd::Identity(2 * n, 2 * n);
  s.bottomRows(n) += lag * (lagged.bottomRows(n) - s.bottomRows(n));
  return s;
}
/// One step of (omega U, V), both at the same time; of rigid modes, of (U/tau, V).
inline Eigen::MatrixXd step_matrix(const Scheme& scheme, const Joined& j, double tau) {
  const Eigen::MatrixXd lagged = lagged_step(scheme, j, tau), s = synchronise(scheme, lagged);
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(2 * j.size());
  for (Eigen::Index k = 0; k < j.size(); ++k)
    scale[k] = j.modes[k].omega > 0 ? j.modes[k].omega : 1 / tau;
  return scale.asDiagonal() * s * lagged * s.inverse() * scale.cwiseInverse().asDiagonal();
}
/// Spectral radius of a step.
inline double radius(const Scheme& scheme, const Joined& j, double tau) {
  return step_matrix(scheme, j, tau).eigenvalues().cwiseAbs().maxCoeff();
}

/// What a step does to the motion that it multiplies most. The amplitude of that motion in any
/// state, |left . y|, is multiplied by the radius at each step, whatever else moves.
struct Dominant {
  double radius;
  Eigen::VectorXcd left;
  Eigen::VectorXd shape;  // the motion itself, at a moment
  double condition;       // of the eigenvectors: |M^n| <= condition radius^n

  explicit Dominant(const Eigen::MatrixXd& step) {
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(step);
    const Eigen::VectorXd size = solver.eigenvalues().cwiseAbs();
    Eigen::Index most = 0;
    radius = size.maxCoeff(&most);
    const Eigen::MatrixXcd right = solver.eigenvectors(), inverse = right.inverse();
    left = inverse.row(most).transpose();
    // at the phase at which it is largest
    const Eigen::VectorXcd motion = right.col(most);
    const std::complex<double> square = (motion.transpose() * motion)(0);
    shape = (std::polar(1.0, -0.5 * std::arg(square)) * motion).real();
    const Eigen::JacobiSVD<Eigen::MatrixXcd> svd(right);
    condition = svd.singularValues().maxCoeff() / svd.singularValues().minCoeff();
  }
  double amplitude(const Eigen::VectorXd& y) const {
    return std::abs((left.transpose() * y.cast<std::complex<double>>())(0));
  }
};

// ---- scenes

/// A pinned strip whose slider is a metre away.
inline Scene lone_beam(int modes, double damping) {
  Scene s = strip_scene(modes, damping, 0.1, 0.1);
  s.gap = 1.0;
  s.stiffness = 1e14;
  return s;
}

/// So many steps of a length, with a sample at the beginning, at the end, and `samples` - 1
/// between.
inline void set_steps(Scene& s, double step, std::int64_t steps, std::int64_t samples = 1) {
  s.step = step;
  s.duration = static_cast<double>(steps) * step;
  s.rate = static_cast<double>(samples) / s.duration;
}

/// Kinetic and elastic energy of a body's modes [J].
inline double modal_energy(const Beam& beam, const std::vector<double>& u,
                           const std::vector<double>& v) {
  double sum = 0;
  for (std::size_t k = 0; k < u.size(); ++k)
    sum += 0.5 * beam.mass_per_length * (v[k] * v[k] + std::pow(beam.modes[k].omega * u[k], 2));
  return sum;
}

/// The energy at t = 0 of a start whose modal state was set by hand: the watch over the energy asks
/// for it.
inline void count_energy(const Model& model, ModalStart& start) {
  start.energy = modal_energy(model.resonator, start.resonator_u, start.resonator_v) +
                 modal_energy(model.slider, start.slider_u, start.slider_v);
  for (const double overlap : overlaps(model, start.resonator_u, start.slider_u))
    if (overlap > 0) start.energy += 0.5 * model.node_stiffness * overlap * overlap;
}

}  // namespace ra2d::test
