// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "bench/peers/contact_equations.hpp"
#include "host/body/beam.hpp"
#include "host/model/model.hpp"

/// The equations of plane scenes, written for speed with dense products, exact to roundings.
///
/// Slider node n stands d_n from the slider's middle, and that at X = x_0 + V t + (N - 1) chi/2 on
/// the resonator. Its overlap is
///
///   -g_n = h_1n - delta + h_2(X + d_n) + sum_k U_k psi_k(X + d_n) + sum_k U_k psi_k(s_n).
///
/// Each mode of the resonator is a sum of waves, solutions of P'' = kappa P: trigonometric
/// (kappa = -beta^2), hyperbolic (beta^2) or straight (0). With c(d) = cos or cosh of beta d, or 1,
/// and s(d) = sin/beta, sinh/beta, or d,
///
///   P(X + d) = P(X) c(d) + P'(X) s(d),    P'(X + d) = P'(X) c(d) + kappa P(X) s(d).
///
/// So one table of c and one of s, over half of the slider's nodes (c is even, s is odd), serve
/// every position: the displacement of all nodes is two products with half the nodes each.
namespace ra2d::peers {

/// Where the slider stands, within a window: between two node crossings.
struct Place {
  std::int64_t base = nowhere;              // resonator's node at or left of slider node 0
  double theta = 0;                         // rest, in chi; 0 to 1
  double time = -1;                         // s
  Eigen::ArrayXd value, slope;              // P, P' of each wave at the middle where theta = 0
  Eigen::ArrayXd cosine, sine;              // c(theta chi), s(theta chi)
  Eigen::ArrayXd value_there, slope_there;  // P, P' at the middle where it is
};

/// Some slider nodes, to be evaluated one by one within a window.
struct SomeNodes {
  std::vector<int> list;

  std::int64_t base = nowhere;   // of the window that the rest was prepared for
  Rows value, slope;             // P, P' at theta = 0 (node, wave)
  Rows slider;                   // psi of the slider's modes (node, mode)
  Eigen::VectorXd height, rise;  // m: overlap of the faces at theta = 0, and what it gains per chi
};

class PlaneEquations final : public ContactEquations {
 public:
  explicit PlaneEquations(const Model& model);

  int nodes() const override { return static_cast<int>(height1_.size()); }
  void list_above(double t, std::int64_t base, int windows, const double* u, double level,
                  std::vector<int>& out) override;
  void evaluate_only(const std::vector<int>& nodes) override;
  void contact(double t, const double* u, double* force) override;
  void outer_force(double t, double* force) const override;

  /// The place at a time; with a window, seen from there: at a crossing the two differ in what lies
  /// ahead. Good until the next call.
  const Place& place(double t);
  const Place& place(double t, std::int64_t base);

  /// Overlap [m] of every node.
  void overlaps(const Place& place, const double* u, Eigen::ArrayXd& out);
  /// Adds the modal force of a force on one node.
  void project(const Place& place, int node, double node_force, double* force);

  /// Gets nodes ready for a window. The others below ask for it.
  void prepare(const Place& place, SomeNodes& nodes) const;
  /// Overlaps [m] and their rates [m/s].
  void overlaps(const Place& place, SomeNodes& nodes, const double* u, Eigen::VectorXd& out);
  void rates(const Place& place, SomeNodes& nodes, const double* u, const double* v,
             Eigen::VectorXd& out);
  /// Adds the modal force of forces on the nodes.
  void project(const Place& place, SomeNodes& nodes, const Eigen::VectorXd& node_force,
               double* force);
  /// psi of every mode (node, mode).
  void shapes(const Place& place, SomeNodes& nodes, Rows& out) const;

  /// Times at which a moving force comes or goes [s], ascending.
  std::vector<double> force_jumps() const;

  double face_rate;  // m/s, of the overlap of the faces at the most

 private:
  struct Half {
    Eigen::Index row;
    double side;
  };
  Half half_of(int node) const;
  void locate(Place& place) const;
  void spread(const double* modes, Eigen::ArrayXd& waves) const;
  void displace(const Place& place, const double* u);

  std::vector<BeamShape> shapes_;  // the resonator's
  double length_;                  // m, of the resonator
  /// Trigonometric and straight waves, one a mode, then the hyperbolic ones of the last modes.
  Eigen::Index hyperbolic_ = 0;
  Eigen::ArrayXd kappa_;              // 1/m^2, of each wave
  int terms_ = 1;                     // of c and s as series over a window
  double half_length_;                // m, from the slider's middle to its last node
  Eigen::Index half_;                 // nodes on one side, the middle one included
  Eigen::MatrixXd even_, odd_;        // c and s, then halves of psi (node from the middle, column)
  Eigen::ArrayXd height1_, height2_;  // h_1 - delta; h_2 and, behind its end, its last value again

  Place place_;
  bool evaluates_all_ = true;
  SomeNodes evaluated_;
  Eigen::ArrayXd overlap_;
  std::vector<int> touching_;
  Eigen::VectorXd some_;
  Eigen::VectorXd even_u_, odd_u_, sum_even_, sum_odd_;
  Eigen::ArrayXd u_waves_, v_waves_;
  Eigen::VectorXd with_value_, with_slope_;
};

}  // namespace ra2d::peers
