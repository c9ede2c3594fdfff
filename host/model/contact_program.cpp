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
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The softest stiffness of a mode; infinite without any.
double softest(const ContactProgram& p) {
  double least = infinity;
  for (Eigen::Index k = 0; k < p.stiffness.size(); ++k)
    if (p.stiffness[k] > 0) least = std::min(least, p.stiffness[k]);
  return least;
}

/// Overlap that roundings alone may leave [m]: of the faces, of the displacements, and of those
/// that the load would make where contact takes them back (a flat body on a flat one does not move
/// at all).
double roundings(const ContactProgram& p, const VectorXd& u) {
  const double reference = softest(p);
  VectorXd size = u.cwiseAbs();
  for (Eigen::Index k = 0; k < u.size(); ++k)
    size[k] += std::abs(p.load[k]) / (p.stiffness[k] > 0 ? p.stiffness[k] : reference);
  return 16 * eps * (p.faces.cwiseAbs().maxCoeff() + (p.shapes.cwiseAbs() * size).maxCoeff());
}

/// The nodes that carry force.
class ActiveSet {
 public:
  explicit ActiveSet(const ContactProgram& program) : p_{&program} {}

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

/// Where the modes rest when the active nodes, and they alone, carry force; in units in which the
/// stiffness of every mode that has one is 1. False where these nodes hold the modes in no balance.
bool settle(const ContactProgram& p, ActiveSet& active, double reference, VectorXd& u) {
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

/// The programme with all stiffnesses positive, to overlaps of `tolerance` [m], from no contact on.
Outcome find_active(const ContactProgram& p, double tolerance, ActiveSet& active, VectorXd& u) {
  const VectorXd yielding = p.stiffness.cwiseInverse();
  u = yielding.cwiseProduct(p.load);
  bool fresh = true;  // u and the forces are without the roundings of the way
  const int most_rounds = 20 * static_cast<int>(p.stiffness.size()) + 1000;
  for (int round = 0; round < most_rounds; ++round) {
    VectorXd overlap = p.faces + p.shapes * u;
    for (int i = 0; i < active.size(); ++i) overlap[active.nodes()[i]] = -infinity;
    int node = 0;
    double over = overlap.maxCoeff(&node);
    if (!(over > tolerance)) {
      if (fresh || p.compliance > 0)
        return Outcome::solved;  // what springs give is known well enough
      // what roundings took for a push on the way may be a pull
      Eigen::Index least = 0;
      while (settle(p, active, 1.0, u) && active.size() > 0 &&
             active.forces().minCoeff(&least) < -1e-12 * active.forces().maxCoeff())
        active.drop(static_cast<int>(least));
      fresh = true;
      continue;
    }
    const VectorXd row = p.shapes.row(node).transpose();
    const double own = row.dot(yielding.cwiseProduct(row));  // m/N, of the node alone
    double force = 0;
    for (bool taken = false; !taken; ++round) {
      if (round >= most_rounds) return Outcome::endless;
      // what a newton on the node does while the others keep their overlaps
      const MatrixXd held = active.shapes();
      VectorXd share(active.size());
      if (active.size() > 0) {
        MatrixXd across = held * yielding.asDiagonal() * held.transpose();
        across.diagonal().array() += p.compliance;
        share = -across.ldlt().solve(held * yielding.cwiseProduct(row));
      }
      const VectorXd change = -yielding.cwiseProduct(row + held.transpose() * share);
      const double parting = p.compliance - row.dot(change);  // m/N
      const bool dependent = !(parting > 1e-13 * (own + p.compliance));
      double most = infinity;
      int first = -1;
      for (int i = 0; i < active.size(); ++i)
        if (share[i] < 0 && active.forces()[i] < -most * share[i]) {
          most = -active.forces()[i] / share[i];
          first = i;
        }
      const double whole = dependent ? infinity : over / parting;
      const double step = std::min(most, whole);
      if (std::isinf(step)) return Outcome::infeasible;
      if (!dependent) {
        u += step * change;
        over -= step * parting;
      }
      force += step;
      active.forces() += step * share;
      if (whole <= most) {
        active.add(node, force);
        taken = true;
        fresh = false;
      } else {
        active.drop(first);
      }
    }
  }
  return Outcome::endless;
}

}  // namespace

std::optional<RestingContact> solve(const ContactProgram& p) {
  const Eigen::Index modes = p.stiffness.size();
  // a body that moves as a whole is first brought to where it touches
  VectorXd u = VectorXd::Zero(modes), settled;
  for (Eigen::Index k = 0; k < modes; ++k)
    if (!(p.stiffness[k] > 0) && p.shapes.col(k).minCoeff() == p.shapes.col(k).maxCoeff()) {
      u[k] = -p.faces.maxCoeff() / p.shapes(0, k);
      break;
    }
  // how far it must move from there, and how far the load bends it: the weak springs give way by a
  // hundred times that
  const double most = p.load.cwiseAbs().maxCoeff(), shape = p.shapes.cwiseAbs().maxCoeff();
  const double stiffness = std::isinf(softest(p)) ? 1.0 : softest(p);
  const double way = (p.faces.maxCoeff() - p.faces.minCoeff()) / shape +
                     (std::isinf(softest(p)) ? 0.0 : most / stiffness);
  const double weak = most > 0 && way > 0 ? 1e-2 * most / way : stiffness;
  // rigid and flat on flat there is no way at all
  const double least = way > 0 ? 0.0 : 16 * eps * shape * most / weak;
  ContactProgram held = p;
  for (Eigen::Index k = 0; k < modes; ++k)
    if (!(p.stiffness[k] > 0)) held.stiffness[k] = weak;
  const VectorXd springs = held.stiffness - p.stiffness;

  for (int round = 0; round < 100; ++round) {
    held.load = p.load + springs.cwiseProduct(u);
    ActiveSet active(p);
    const Outcome outcome = find_active(held, roundings(p, u) + least, active, u);
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
