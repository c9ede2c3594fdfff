// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/contact_program.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace ra2d {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double unbounded = std::numeric_limits<double>::infinity();

/// The softest stiffness of a mode; infinite without any.
double softest(const ContactProgram& p) {
  double least = unbounded;
  for (Eigen::Index k = 0; k < p.stiffness.size(); ++k)
    if (p.stiffness[k] > 0) least = std::min(least, p.stiffness[k]);
  return least;
}

/// Overlap that roundings alone may leave [m]: those of the faces, of the displacements, and of the
/// displacements that the load would make without contact (a flat body on a flat one does not
/// move).
double roundings(const ContactProgram& p, const VectorXd& u) {
  const double reference = softest(p);
  VectorXd size = u.cwiseAbs();
  for (Eigen::Index k = 0; k < u.size(); ++k)
    size[k] += std::abs(p.load[k]) / (p.stiffness[k] > 0 ? p.stiffness[k] : reference);
  return 16 * eps * (p.faces.cwiseAbs().maxCoeff() + (p.shapes.cwiseAbs() * size).maxCoeff());
}

/// The nodes that carry force.
class ActiveContacts {
 public:
  explicit ActiveContacts(const ContactProgram& program) : p_{&program} {}

  int size() const { return static_cast<int>(nodes_.size()); }
  const std::vector<int>& nodes() const { return nodes_; }
  Eigen::Map<VectorXd> forces() { return {forces_.data(), size()}; }
  void add(int node, double force) {
    nodes_.push_back(node);
    forces_.push_back(force);
  }
  void drop(int place) {
    nodes_.erase(nodes_.begin() + place);
    forces_.erase(forces_.begin() + place);
  }
  MatrixXd shapes() const { return p_->shapes(nodes_, Eigen::all); }

 private:
  const ContactProgram* p_;
  std::vector<int> nodes_;
  std::vector<double> forces_;  // N, of nodes_
};

/// Finds the rest of the modes when the active nodes alone carry force, in units in which the
/// stiffness of every elastic mode is 1. False where these nodes cannot balance the load.
bool settle(const ContactProgram& p, ActiveContacts& active, double reference, VectorXd& u) {
  const Eigen::Index modes = p.stiffness.size(), count = active.size();
  VectorXd unit(modes);  // of u_k
  for (Eigen::Index k = 0; k < modes; ++k)
    unit[k] = 1 / std::sqrt(p.stiffness[k] > 0 ? p.stiffness[k] : reference);
  const MatrixXd held = active.shapes() * unit.asDiagonal();
  const double newton = count > 0 ? 1 / held.cwiseAbs().maxCoeff() : 1.0;
  MatrixXd system = MatrixXd::Zero(modes + count, modes + count);
  VectorXd right(modes + count);
  for (Eigen::Index k = 0; k < modes; ++k) system(k, k) = p.stiffness[k] > 0 ? 1.0 : 0.0;
  system.topRightCorner(modes, count) = newton * held.transpose();
  system.bottomLeftCorner(count, modes) = newton * held;
  system.bottomRightCorner(count, count).diagonal().setConstant(-newton * newton * p.compliance);
  right.head(modes) = unit.cwiseProduct(p.load);
  for (Eigen::Index i = 0; i < count; ++i) right[modes + i] = -newton * p.faces[active.nodes()[i]];
  const Eigen::FullPivLU<MatrixXd> factors(system);
  VectorXd found = factors.solve(right);
  found += factors.solve(right - system * found);
  u = unit.cwiseProduct(found.head(modes));
  active.forces() = newton * found.tail(count);
  const double left = (right - system * found).cwiseAbs().maxCoeff();
  const double terms = (system.cwiseAbs() * found.cwiseAbs()).maxCoeff();
  return left <= 1e-9 * right.cwiseAbs().maxCoeff() + 64 * eps * terms;
}

enum class Outcome { solved, infeasible, endless };

/// The programme with all stiffnesses positive, solved from no contact on.
class DualMethod {
 public:
  /// To overlaps of `tolerance` [m].
  DualMethod(const ContactProgram& program, double tolerance, ActiveContacts& active, VectorXd& u)
      : p_{program},
        tolerance_{tolerance},
        most_rounds_{20 * static_cast<int>(program.stiffness.size()) + 1000},
        compliance_{program.stiffness.cwiseInverse()},
        active_{active},
        u_{u} {}

  Outcome find() {
    u_ = compliance_.cwiseProduct(p_.load);
    bool fresh = true;  // u and the forces are without the roundings of earlier rounds
    for (round_ = 0; round_ < most_rounds_; ++round_) {
      VectorXd overlap = p_.faces + p_.shapes * u_;
      for (const int node : active_.nodes()) overlap[node] = -unbounded;
      int node = 0;
      const double over = overlap.maxCoeff(&node);
      if (over > tolerance_) {
        if (const Outcome outcome = add(node, over); outcome != Outcome::solved) return outcome;
        fresh = false;
      } else if (fresh || p_.compliance > 0) {
        return Outcome::solved;  // roundings do not matter with springs
      } else {
        drop_pulling();
        fresh = true;
      }
    }
    return Outcome::endless;
  }

 private:
  /// Drops nodes whose force only roundings made positive.
  void drop_pulling() {
    Eigen::Index least = 0;
    while (settle(p_, active_, 1.0, u_) && active_.size() > 0 &&
           active_.forces().minCoeff(&least) < -1e-12 * active_.forces().maxCoeff())
      active_.drop(static_cast<int>(least));
  }

  /// Raises the force of a node until its overlap of `over` [m] is gone. The active nodes keep
  /// their overlaps; nodes that would have to pull are dropped.
  Outcome add(int node, double over) {
    const VectorXd row = p_.shapes.row(node).transpose();
    const double own = row.dot(compliance_.cwiseProduct(row));  // m/N, of the node alone
    double force = 0;
    for (;; ++round_) {
      if (round_ >= most_rounds_) return Outcome::endless;
      // per newton on the node: what the other forces change by, and the modes
      const MatrixXd held = active_.shapes();
      const VectorXd share = shares(held, row);
      const VectorXd change = -compliance_.cwiseProduct(row + held.transpose() * share);
      const double parting = p_.compliance - row.dot(change);  // m/N
      const bool dependent = !(parting > 1e-13 * (own + p_.compliance));
      double most = unbounded;  // N, before an active node pulls
      int first = -1;           // that node
      for (int i = 0; i < active_.size(); ++i)
        if (share[i] < 0 && active_.forces()[i] < -most * share[i]) {
          most = -active_.forces()[i] / share[i];
          first = i;
        }
      const double whole = dependent ? unbounded : over / parting;
      const double step = std::min(most, whole);
      if (std::isinf(step)) return Outcome::infeasible;
      if (!dependent) {
        u_ += step * change;
        over -= step * parting;
      }
      force += step;
      active_.forces() += step * share;
      if (whole <= most) {
        active_.add(node, force);
        ++round_;
        return Outcome::solved;
      }
      active_.drop(first);
    }
  }

  /// Changes of the active nodes' forces per newton on a node, such that they keep their overlaps.
  VectorXd shares(const MatrixXd& held, const VectorXd& row) const {
    if (active_.size() == 0) return VectorXd(0);
    MatrixXd across = held * compliance_.asDiagonal() * held.transpose();
    across.diagonal().array() += p_.compliance;
    return -across.ldlt().solve(held * compliance_.cwiseProduct(row));
  }

  const ContactProgram& p_;
  double tolerance_;  // m
  int round_ = 0, most_rounds_;
  VectorXd compliance_;  // m/N, of the modes
  ActiveContacts& active_;
  VectorXd& u_;
};

}  // namespace

std::optional<RestingContact> solve(const ContactProgram& p) {
  const Eigen::Index modes = p.stiffness.size();
  // a rigid mode that moves the body as a whole first brings it to where it touches
  VectorXd u = VectorXd::Zero(modes), settled;
  for (Eigen::Index k = 0; k < modes; ++k)
    if (!(p.stiffness[k] > 0) && p.shapes.col(k).minCoeff() == p.shapes.col(k).maxCoeff()) {
      u[k] = -p.faces.maxCoeff() / p.shapes(0, k);
      break;
    }
  // The weak springs deflect by a hundred times the distance from there and the bend under load.
  const double most = p.load.cwiseAbs().maxCoeff(), shape = p.shapes.cwiseAbs().maxCoeff();
  const double stiffness = std::isinf(softest(p)) ? 1.0 : softest(p);
  const double distance = (p.faces.maxCoeff() - p.faces.minCoeff()) / shape +
                          (std::isinf(softest(p)) ? 0.0 : most / stiffness);
  const double weak = most > 0 && distance > 0 ? 1e-2 * most / distance : stiffness;
  // rigid and flat on flat: no distance
  const double least = distance > 0 ? 0.0 : 16 * eps * shape * most / weak;
  ContactProgram held = p;
  for (Eigen::Index k = 0; k < modes; ++k)
    if (!(p.stiffness[k] > 0)) held.stiffness[k] = weak;
  const VectorXd springs = held.stiffness - p.stiffness;

  for (int round = 0; round < 100; ++round) {
    held.load = p.load + springs.cwiseProduct(u);
    ActiveContacts active(p);
    const Outcome outcome = DualMethod(held, roundings(p, u) + least, active, u).find();
    if (outcome == Outcome::infeasible)
      return RestingContact{.feasible = false, .u = {}, .forces = {}};
    if (outcome == Outcome::endless) return std::nullopt;
    if (!settle(p, active, stiffness, settled)) continue;
    const auto forces = active.forces();
    if (active.size() > 0 && forces.minCoeff() < -1e-12 * forces.maxCoeff()) continue;
    VectorXd overlap = p.faces + p.shapes * settled;
    for (const int node : active.nodes()) overlap[node] = 0;
    if (!(overlap.maxCoeff() <= 4 * roundings(p, settled) + least)) continue;
    RestingContact rest{.feasible = true, .u = settled, .forces = VectorXd::Zero(p.faces.size())};
    for (int i = 0; i < active.size(); ++i)
      rest.forces[active.nodes()[i]] = std::max(0.0, forces[i]);
    return rest;
  }
  return std::nullopt;
}

}  // namespace ra2d
