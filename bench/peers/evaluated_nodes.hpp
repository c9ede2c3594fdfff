// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <vector>

#include "bench/peers/contact_equations.hpp"

/// The nodes to evaluate: all, or a list of those that can touch for a while.
///
/// Over some windows from a reference state on, the overlap of the faces at a node is at most that
/// at the crossings among them; the displacement there differs from the reference one by at most
///   sum_k |U_k| max|psi_k'| (path of the slider) + sum_k |U_k(t) - U_k| max|psi_k|.
/// The nodes that this brings together with `range` for the last sum are listed, and the list is
/// made anew before that sum, or the windows, are used up.
namespace ra2d::peers {

class EvaluatedNodes {
 public:
  EvaluatedNodes(ContactEquations& equations, Nodes nodes);

  /// Makes the list anew unless it holds for `time` [s] from a state on, at rates of up to 1.5
  /// times the present ones. Returns whether the list has changed.
  bool prepare(double t, const double* y, double time);
  /// After a step from one state to another: whether the list held for it. If not, it is made anew,
  /// from the first state on, so that it holds.
  bool covered(double t, const double* y, double t_end, const double* y_end);
  /// Until when it can be good [s].
  double end() const { return end_; }

  const std::vector<int>& list() const { return list_; }
  bool all() const { return nodes_ == Nodes::all; }

  /// Bound on the rate of the displacements [m/s].
  double rate_bound(const double* y) const;

 private:
  double moved(const double* y) const;
  void make(double t, const double* y, double time, double range);

  ContactEquations& equations_;
  Nodes nodes_;
  double horizon_;  // s
  std::vector<int> list_;
  Eigen::ArrayXd reference_;
  double range_ = -1, end_ = -1;
};

}  // namespace ra2d::peers
