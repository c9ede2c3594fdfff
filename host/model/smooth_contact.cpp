// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/smooth_contact.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "host/base/decompositions.hpp"

namespace ra2d {
namespace {

using Polynomial = std::array<double, 4>;  // of the place in a cell, from its middle, in chi

double value(const Polynomial& p, double x) { return p[0] + x * (p[1] + x * (p[2] + x * p[3])); }
double slope(const Polynomial& p, double x) { return p[1] + x * (2 * p[2] + x * 3 * p[3]); }

/// The spline between two nodes, with the origin `x` from the left one.
Polynomial piece(const std::vector<double>& height, const std::vector<double>& curvature,
                 std::size_t left, double x) {
  const std::size_t last = height.size() - 1, i = std::min(left, last),
                    j = std::min(left + 1, last);
  const Polynomial p{height[i], height[j] - height[i] - (2 * curvature[i] + curvature[j]) / 6,
                     curvature[i] / 2, (curvature[j] - curvature[i]) / 6};
  return {value(p, x), slope(p, x), p[2] + 3 * x * p[3], p[3]};
}

/// The faces of one cell at t = 0: the overlap of both, on each side of the resonator's node.
struct CellOverlap {
  double knot;
  std::array<Polynomial, 2> sides;
};

CellOverlap faces_of(const Model& m, int cell) {
  const int base = static_cast<int>(m.position);
  const double theta = m.position - base;
  Polynomial own = piece(m.slider_height, m.slider_curvature, cell, 0.5);
  own[0] -= m.delta;
  CellOverlap out{0.5 - theta, {}};
  for (int side = 0; side < 2; ++side) {
    const Polynomial other =
        piece(m.resonator_height, m.resonator_curvature, base + cell + side, theta + 0.5 - side);
    for (int j = 0; j < 4; ++j) out.sides[side][j] = own[j] + other[j];
  }
  return out;
}

/// Where the polynomial is monotonic between neighbours, in [from, to].
std::vector<double> monotonic_between(const Polynomial& p, double from, double to) {
  std::vector<double> edges{from};
  const double a = 3 * p[3], b = p[2], c = p[1], discriminant = b * b - a * c;
  if (discriminant > 0) {
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    std::array<double, 2> roots{c / q, q / a};
    std::sort(roots.begin(), roots.end());
    for (const double root : roots)
      if (root > edges.back() && root < to) edges.push_back(root);
  }
  edges.push_back(to);
  return edges;
}

double root_between(const Polynomial& p, double low, double high) {
  const bool rises = value(p, low) < value(p, high);
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    ((value(p, middle) < 0) == rises ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Calls visit(from, to) for each stretch of [from, to] where p > 0.
template <class Visit>
void visit_positive(const Polynomial& p, double from, double to, const Visit& visit) {
  const std::vector<double> edges = monotonic_between(p, from, to);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double left = value(p, edges[i]), right = value(p, edges[i + 1]);
    if (!(left > 0 || right > 0)) continue;
    if (left > 0 && right > 0)
      visit(edges[i], edges[i + 1]);
    else if (left > 0)
      visit(edges[i], root_between(p, edges[i], edges[i + 1]));
    else
      visit(root_between(p, edges[i], edges[i + 1]), edges[i + 1]);
  }
}

/// The modes' shapes along the cells at t = 0: (4 cell + power of the place; mode).
Eigen::MatrixXd shapes_along_cells(const Model& m) {
  const double chi = m.scene.spacing;
  const auto modes = static_cast<Eigen::Index>(m.resonator.modes.size() + m.slider.modes.size());
  const int cells = m.nodes() - 1;
  Eigen::MatrixXd shapes(4 * cells, modes);
  for (int n = 0; n < cells; ++n) {
    Eigen::Index k = 0;
    const auto put = [&](const BodyMode& mode, double place) {
      double d[4];
      mode.shape->evaluate(place * chi, 4, d);
      shapes.col(k++).segment<4>(4 * n) << d[0], d[1] * chi, d[2] * chi * chi / 2,
          d[3] * chi * chi * chi / 6;
    };
    for (const BodyMode& mode : m.resonator.modes) put(mode, m.position + n + 0.5);
    for (const BodyMode& mode : m.slider.modes) put(mode, n + 0.5);
  }
  return shapes;
}

/// A point of a quadrature over the places in contact.
struct ContactPoint {
  int cell;
  double place, overlap, weight;  // chi from the cell's middle, m, chi
};

/// Gauss-Legendre of four points, exact to the seventh power: for products of two cubics.
constexpr std::array<std::pair<double, double>, 4> gauss{
    {{-0.8611363115940526, 0.3478548451374538},
     {-0.3399810435848563, 0.6521451548625461},
     {0.3399810435848563, 0.6521451548625461},
     {0.8611363115940526, 0.3478548451374538}}};

class SmoothPotential {
 public:
  explicit SmoothPotential(const Model& model)
      : model_{model}, shapes_{shapes_along_cells(model)}, spring_{model.node_stiffness} {
    for (int n = 0; n + 1 < model.nodes(); ++n) faces_.push_back(faces_of(model, n));
    const auto modes = shapes_.cols();
    stiffness_.resize(modes);
    load_.resize(modes);
    Eigen::Index k = 0;
    for (const Body* body : {&model.resonator, &model.slider})
      for (std::size_t i = 0; i < body->modes.size(); ++i, ++k) {
        const BodyMode& mode = body->modes[i];
        stiffness_[k] = mode.mass * mode.omega * mode.omega;
        load_[k] = body->load[i];
      }
  }
  Eigen::Index modes() const { return shapes_.cols(); }
  double spring() const { return spring_; }

  std::vector<ContactPoint> points(const Eigen::VectorXd& u) const {
    const Eigen::VectorXd displacement = shapes_ * u;
    std::vector<ContactPoint> out;
    for (int n = 0; n < static_cast<int>(faces_.size()); ++n)
      for (int side = 0; side < 2; ++side) {
        Polynomial o = faces_[n].sides[side];
        for (int j = 0; j < 4; ++j) o[j] += displacement[4 * n + j];
        visit_positive(o, side == 0 ? -0.5 : faces_[n].knot, side == 0 ? faces_[n].knot : 0.5,
                       [&](double from, double to) {
                         const double half = 0.5 * (to - from), middle = 0.5 * (from + to);
                         for (const auto& [at, weight] : gauss) {
                           const double x = middle + half * at;
                           out.push_back({n, x, value(o, x), half * weight});
                         }
                       });
      }
    return out;
  }
  Eigen::VectorXd shape_at(const ContactPoint& at) const {
    const auto rows = shapes_.middleRows<4>(4 * at.cell);
    const double x = at.place;
    return rows.transpose() * Eigen::Vector4d(1, x, x * x, x * x * x);
  }

  /// Minimises from `u`; false when it does not settle.
  bool minimise(Eigen::VectorXd& u, double spring) const {
    Eigen::VectorXd best_u = u;
    double best = std::numeric_limits<double>::infinity();  // residual over the forces
    for (int round = 0, stalled = 0; round < 300 && stalled < 12; ++round) {
      Eigen::VectorXd force = load_ - stiffness_.cwiseProduct(u);
      double scale = load_.lpNorm<1>() + stiffness_.cwiseProduct(u).lpNorm<1>();
      Eigen::MatrixXd hessian = stiffness_.asDiagonal();
      for (const ContactPoint& at : points(u)) {
        const Eigen::VectorXd shape = shape_at(at);
        const double weight = spring * at.weight;
        force -= weight * at.overlap * shape;
        scale += weight * at.overlap * shape.lpNorm<1>();
        hessian += weight * shape * shape.transpose();
      }
      const double residual = scale > 0 ? force.lpNorm<Eigen::Infinity>() / scale : 0.0;
      ++stalled;
      if (residual < best) {
        if (residual < 0.5 * best) stalled = 0;
        best = residual;
        best_u = u;
      }
      if (best <= 1e-16) break;
      // directions that nothing holds yet take a share of the springs of all cells
      for (Eigen::Index k = 0; k < modes(); ++k) {
        const double all = spring * shapes_.col(k).squaredNorm();
        hessian(k, k) += 1e-14 * (hessian(k, k) > 0 ? hessian(k, k) : all) + 1e-300;
      }
      const Eigen::VectorXd step = solve_symmetric(hessian, force);
      u += best_length(u, step, spring) * step;
    }
    u = best_u;
    return best <= 1e-10;
  }

 private:
  const Model& model_;
  Eigen::MatrixXd shapes_;
  double spring_;  // N/m, of a whole cell
  std::vector<CellOverlap> faces_;
  Eigen::VectorXd stiffness_, load_;

  /// The length along `step` at which the potential is least, from the sign of its slope, which
  /// never falls.
  double best_length(const Eigen::VectorXd& u, const Eigen::VectorXd& step, double spring) const {
    const auto slope = [&](double length) {
      const Eigen::VectorXd at = u + length * step;
      double sum = (stiffness_.cwiseProduct(at) - load_).dot(step);
      for (const ContactPoint& point : points(at))
        sum += spring * point.weight * point.overlap * shape_at(point).dot(step);
      return sum;
    };
    const double start = std::abs(slope(0.0));
    double low = 0.0, high = 1.0, at_high = slope(1.0);
    if (std::abs(at_high) <= 1e-3 * start) return 1.0;
    while (at_high < 0 && high < 1e6) {
      low = high;
      high *= 2;
      at_high = slope(high);
    }
    for (int halving = 0; halving < 40; ++halving) {
      const double middle = 0.5 * (low + high), at = slope(middle);
      if (std::abs(at) <= 1e-3 * start) return middle;
      (at < 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
};

}  // namespace

double largest_smooth_overlap(const Model& m) {
  double largest = -std::numeric_limits<double>::infinity();
  for (int n = 0; n + 1 < m.nodes(); ++n) {
    const CellOverlap cell = faces_of(m, n);
    for (int side = 0; side < 2; ++side)
      for (const double edge : monotonic_between(cell.sides[side], side == 0 ? -0.5 : cell.knot,
                                                 side == 0 ? cell.knot : 0.5))
        largest = std::max(largest, value(cell.sides[side], edge));
  }
  return largest;
}

SmoothContact smooth_contact(const Model& model, const std::vector<double>& u) {
  const SmoothPotential potential(model);
  SmoothContact sum;
  const Eigen::Map<const Eigen::VectorXd> at_start(u.data(), static_cast<Eigen::Index>(u.size()));
  for (const ContactPoint& at : potential.points(at_start)) {
    sum.force += potential.spring() * at.weight * at.overlap;
    sum.energy += 0.5 * potential.spring() * at.weight * at.overlap * at.overlap;
    if (sum.cells.empty() || sum.cells.back() != at.cell) sum.cells.push_back(at.cell);
  }
  return sum;
}

std::optional<std::vector<double>> smooth_equilibrium(const Model& model) {
  const SmoothPotential potential(model);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(potential.modes());
  for (double soft = 1e-10; soft < 2; soft *= 10)
    if (!potential.minimise(u, soft * potential.spring())) return std::nullopt;
  return std::vector<double>(u.data(), u.data() + u.size());
}

}  // namespace ra2d
