// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/model/model.hpp"

/// The equations of motion that the peers integrate. State y = (U, V), the resonator's modes before
/// the slider's:
///
///   m (U'' + 2 zeta omega U' + omega^2 U) = F,  F of contact, loads and moving forces.
///
/// The modes are here; displacements under the nodes and the contact's forces are of the kind of
/// scene (plane_equations.hpp, areal_equations.hpp).
namespace ra2d::peers {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The base of no window.
inline constexpr std::int64_t nowhere = std::numeric_limits<std::int64_t>::min();

class ContactEquations {
 public:
  virtual ~ContactEquations() = default;

  int modes() const { return static_cast<int>(omega.size()); }
  virtual int nodes() const = 0;

  /// Lag of an integrator's clock t behind the time that it has integrated [s]: the roundings of
  /// t + h. Equal steps round alike: those of 1e5 steps sum to 1e-13 s, in which the faces move by
  /// 1e-7 of a shock's overlap.
  double lag = 0;
  /// How often the displacements of all nodes were summed.
  std::int64_t displacement_sums = 0;

  /// Position of slider node 0 [chi], its rate [chi/s], and at which t it is at a node [s].
  double position(double t) const { return position_ + (t + lag) * rate_; }
  double rate() const { return rate_; }
  double time_at(std::int64_t base) const {
    return (static_cast<double>(base) - position_) / rate_ - lag;
  }

  /// Lists, in ascending order, at least the nodes whose overlap can be above `level` while the
  /// slider goes on from window `base`, where it is at t, to the end of window base + windows - 1
  /// and the displacements stay: but for what they vary along the way.
  virtual void list_above(double t, std::int64_t base, int windows, const double* u, double level,
                          std::vector<int>& out) = 0;

  /// From now on contact() evaluates these nodes alone; at first it evaluates all.
  virtual void evaluate_only(const std::vector<int>& nodes) = 0;
  /// Adds the modal forces of the penalties max(0, overlap).
  virtual void contact(double t, const double* u, double* force) = 0;
  /// The force of loads and moving forces [N m^(-1/2); areal: N/m], of each mode.
  virtual void outer_force(double t, double* force) const = 0;
  /// dy/dt = (V, F/m - 2 zeta omega V - omega^2 U).
  void state_rate(const double* y, const double* force, double* rate) const;

  Eigen::ArrayXd omega, damping;     // of each mode: 1/s; 2 zeta omega
  Eigen::ArrayXd mass;               // kg/m; areal: kg/m^2
  Eigen::ArrayXd largest, steepest;  // bounds of |psi| and, of the resonator's, |dpsi/dx|
  double node_stiffness;             // N/m
  double spacing, speed;             // m, m/s
  double roughness;                  // m, root mean square of both faces together

 protected:
  explicit ContactEquations(const Model& model);

  double position_, rate_;
  Eigen::Index modes2_, modes1_;  // of the resonator, of the slider
  Eigen::ArrayXd load_;
  std::vector<MovingForce> moving_;
};

}  // namespace ra2d::peers
