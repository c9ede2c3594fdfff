// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/smooth_contact.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "host/base/decompositions.hpp"
#include "host/model/contact_program.hpp"

namespace ra2d {
namespace {

using Polynomial = std::array<double, 4>;  // of the place in a cell, from its middle, in chi

double value(const Polynomial& p, double x) { return p[0] + x * (p[1] + x * (p[2] + x * p[3])); }
double slope(const Polynomial& p, double x) { return p[1] + x * (2 * p[2] + x * 3 * p[3]); }

/// The spline between two nodes of a row, with the origin `x` from the left one.
Polynomial piece(const double* height, const double* curvature, int nodes, int left, double x) {
  const int i = std::min(left, nodes - 1), j = std::min(left + 1, nodes - 1);
  const Polynomial p{height[i], height[j] - height[i] - (2 * curvature[i] + curvature[j]) / 6,
                     curvature[i] / 2, (curvature[j] - curvature[i]) / 6};
  return {value(p, x), slope(p, x), p[2] + 3 * x * p[3], p[3]};
}

/// The faces of one cell at t = 0: the overlap of both, on each side of the resonator's node.
struct CellOverlap {
  double knot;
  std::array<Polynomial, 2> sides;
};

/// `cell`: its left node.
CellOverlap faces_of(const Model& m, int cell) {
  const int base = static_cast<int>(m.position), row = cell / m.row_nodes(),
            along = cell % m.row_nodes();
  const double theta = m.position - base;
  const std::ptrdiff_t first1 = std::ptrdiff_t{row} * m.row_nodes(),
                       first2 = std::ptrdiff_t{row} * m.row_heights();
  Polynomial own = piece(m.slider_height.data() + first1, m.slider_curvature.data() + first1,
                         m.row_nodes(), along, 0.5);
  own[0] -= m.delta;
  CellOverlap out{0.5 - theta, {}};
  for (int side = 0; side < 2; ++side) {
    const Polynomial other =
        piece(m.resonator_height.data() + first2, m.resonator_curvature.data() + first2,
              m.row_heights(), base + along + side, theta + 0.5 - side);
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

/// The modes' shapes along the cells of a row at t = 0: (4 cell + power of the place; mode). In an
/// areal scene each mode has its share of them on a row (AllCells).
Eigen::MatrixXd shapes_along_row(const Model& m) {
  const double chi = m.scene.spacing;
  const auto modes = static_cast<Eigen::Index>(m.resonator.modes.size() + m.slider.modes.size());
  const int cells = m.row_nodes() - 1;
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

/// Gauss-Legendre of four points, exact to the seventh power: for products of two cubics.
constexpr std::array<std::pair<double, double>, 4> gauss{
    {{-0.8611363115940526, 0.3478548451374538},
     {-0.3399810435848563, 0.6521451548625461},
     {0.3399810435848563, 0.6521451548625461},
     {0.8611363115940526, 0.3478548451374538}}};

/// Whether it is negative everywhere within half a unit of its origin, by its coefficients.
bool is_open(const Polynomial& o) {
  return o[0] + 0.5 * std::abs(o[1]) + 0.25 * std::abs(o[2]) + 0.125 * std::abs(o[3]) < 0;
}

CellOverlap moved_by(CellOverlap cell, const double* displacement) {
  for (Polynomial& side : cell.sides)
    for (int j = 0; j < 4; ++j) side[j] += displacement[j];
  return cell;
}

/// Faces along some cells of the slider, and how the modes move them.
class Cells {
 public:
  /// `numbers`: of the cells, each that of its left node. `shapes`: along them.
  Cells(const Model& model, std::vector<int> numbers, Eigen::MatrixXd shapes)
      : numbers_{std::move(numbers)}, shapes_{std::move(shapes)} {
    for (const int n : numbers_) faces_.push_back(faces_of(model, n));
  }
  int count() const { return static_cast<int>(faces_.size()); }
  int number(int cell) const { return numbers_[cell]; }
  const Eigen::MatrixXd& shapes() const { return shapes_; }  // (4 cell + power of the place; mode)
  /// The overlap in a cell that is moved by this polynomial.
  CellOverlap overlap(int cell, const double* displacement) const {
    return moved_by(faces_[cell], displacement);
  }
  /// Calls visit(place, overlap, weight) for the points of a quadrature over what overlaps of a
  /// cell.
  template <class Visit>
  static void visit_points(const CellOverlap& cell, const Visit& visit) {
    for (int side = 0; side < 2; ++side) {
      const Polynomial& o = cell.sides[side];
      if (is_open(o)) continue;
      visit_positive(o, side == 0 ? -0.5 : cell.knot, side == 0 ? cell.knot : 0.5,
                     [&](double from, double to) {
                       const double half = 0.5 * (to - from), middle = 0.5 * (from + to);
                       for (const auto& [at, weight] : gauss)
                         visit(middle + half * at, value(o, middle + half * at), half * weight);
                     });
    }
  }
  /// The highest place of a cell, and its overlap.
  static std::pair<double, double> highest(const CellOverlap& cell) {
    std::pair<double, double> best{0, -std::numeric_limits<double>::infinity()};
    for (int side = 0; side < 2; ++side)
      for (const double edge : monotonic_between(cell.sides[side], side == 0 ? -0.5 : cell.knot,
                                                 side == 0 ? cell.knot : 0.5))
        if (const double over = value(cell.sides[side], edge); over > best.second)
          best = {edge, over};
    return best;
  }

 private:
  std::vector<int> numbers_;
  Eigen::MatrixXd shapes_;
  std::vector<CellOverlap> faces_;
};

/// All cells of the slider. Of an areal scene they are too many for a matrix of their shapes: that
/// of one row, and each mode's share on the rows, make it.
class AllCells {
 public:
  explicit AllCells(const Model& model)
      : model_{model}, along_{shapes_along_row(model)}, across_(along_.cols(), model.rows) {
    across_.setOnes();
    if (!model.is_areal) return;
    for (int row = 0; row < model.rows; ++row) {
      Eigen::Index k = 0;
      for (const BodyMode& mode : model.resonator.modes)
        mode.shape->evaluate_across(model.side + model.eta(row), 1, &across_(k++, row));
      for (const BodyMode& mode : model.slider.modes)
        mode.shape->evaluate_across(model.eta(row), 1, &across_(k++, row));
    }
  }
  /// Calls visit(number, overlap) for each cell at the displacements u.
  template <class Visit>
  void visit(const Eigen::VectorXd& u, const Visit& visit) const {
    for (int row = 0; row < model_.rows; ++row) {
      const Eigen::VectorXd moved = along_ * across_.col(row).cwiseProduct(u);
      const int first = row * model_.row_nodes();
      for (int i = 0; i + 1 < model_.row_nodes(); ++i)
        visit(first + i, moved_by(faces_of(model_, first + i), &moved[Eigen::Index{4} * i]));
    }
  }
  /// Those with an overlap above 0 anywhere at u, by their numbers.
  std::vector<int> touching(const Eigen::VectorXd& u) const {
    std::vector<int> numbers;
    visit(u, [&](int number, const CellOverlap& cell) {
      if (is_open(cell.sides[0]) && is_open(cell.sides[1])) return;
      if (Cells::highest(cell).second > 0) numbers.push_back(number);
    });
    return numbers;
  }
  std::vector<int> all() const {
    std::vector<int> numbers;
    for (int n = 0; n < model_.nodes(); ++n)
      if (n % model_.row_nodes() < model_.row_nodes() - 1) numbers.push_back(n);
    return numbers;
  }
  Cells some(std::vector<int> numbers) const {
    Eigen::MatrixXd shapes(4 * static_cast<Eigen::Index>(numbers.size()), along_.cols());
    for (std::size_t e = 0; e < numbers.size(); ++e) {
      const int row = numbers[e] / model_.row_nodes(), i = numbers[e] % model_.row_nodes();
      shapes.middleRows<4>(4 * static_cast<Eigen::Index>(e)) =
          along_.middleRows<4>(Eigen::Index{4} * i) * across_.col(row).asDiagonal();
    }
    return {model_, std::move(numbers), std::move(shapes)};
  }

 private:
  const Model& model_;
  Eigen::MatrixXd along_;   // shapes_along_row
  Eigen::MatrixXd across_;  // (mode, row)
};

/// Stiffness [N/m] and load [N] of the modes of both bodies.
struct ModalSprings {
  Eigen::VectorXd stiffness, load;

  ModalSprings(const Model& model, Eigen::Index modes) : stiffness(modes), load(modes) {
    Eigen::Index k = 0;
    for (const Body* body : {&model.resonator, &model.slider})
      for (std::size_t i = 0; i < body->modes.size(); ++i, ++k) {
        const BodyMode& mode = body->modes[i];
        stiffness[k] = mode.mass * mode.omega * mode.omega;
        load[k] = body->load[i];
      }
  }
};

class SmoothPotential {
 public:
  SmoothPotential(const Model& model, Cells cells)
      : cells_{std::move(cells)}, springs_{model, modes()}, spring_{model.node_stiffness} {}
  Eigen::Index modes() const { return cells_.shapes().cols(); }
  double spring() const { return spring_; }

  /// Minimises from `u`, until the residual is `enough` of the forces; false when it does not
  /// settle.
  bool minimise(Eigen::VectorXd& u, double spring, double enough) const {
    const Eigen::VectorXd &stiffness = springs_.stiffness, &load = springs_.load;
    Eigen::VectorXd best_u = u;
    double best = std::numeric_limits<double>::infinity();  // residual over the forces
    for (int round = 0, stalled = 0; round < 300 && stalled < 12; ++round) {
      Eigen::VectorXd force = load - stiffness.cwiseProduct(u);
      double scale = load.lpNorm<1>() + stiffness.cwiseProduct(u).lpNorm<1>();
      Eigen::MatrixXd hessian = stiffness.asDiagonal();
      const Eigen::VectorXd displacement = cells_.shapes() * u;
      for (int n = 0; n < cells_.count(); ++n) {
        // moments of force and stiffness along the cell
        Eigen::Vector4d pressed = Eigen::Vector4d::Zero();
        Eigen::Matrix4d stiff = Eigen::Matrix4d::Zero();
        Cells::visit_points(cells_.overlap(n, &displacement[4 * n]),
                            [&](double x, double over, double weight) {
                              const Eigen::Vector4d powers(1, x, x * x, x * x * x);
                              pressed += spring * weight * over * powers;
                              stiff += spring * weight * powers * powers.transpose();
                            });
        if (stiff(0, 0) == 0) continue;
        const auto shapes = cells_.shapes().middleRows<4>(4 * n);
        const Eigen::VectorXd on_modes = shapes.transpose() * pressed;
        force -= on_modes;
        scale += on_modes.lpNorm<1>();
        const Eigen::MatrixXd held = stiff * shapes;
        hessian.noalias() += shapes.transpose() * held;
      }
      const double residual = scale > 0 ? force.lpNorm<Eigen::Infinity>() / scale : 0.0;
      ++stalled;
      if (residual < best) {
        if (residual < 0.5 * best) stalled = 0;
        best = residual;
        best_u = u;
      }
      if (best <= enough) break;
      // directions that nothing holds yet take a share of the springs of all cells
      for (Eigen::Index k = 0; k < modes(); ++k) {
        const double all = spring * cells_.shapes().col(k).squaredNorm();
        hessian(k, k) += 1e-14 * (hessian(k, k) > 0 ? hessian(k, k) : all) + 1e-300;
      }
      const Eigen::VectorXd step = solve_symmetric(hessian, force);
      u += best_length(u, displacement, step, spring) * step;
    }
    u = best_u;
    return best <= std::max(enough, 1e-10);
  }

 private:
  Cells cells_;
  ModalSprings springs_;
  double spring_;  // N/m, of a whole cell

  /// The length along `step` at which the potential is least, from the sign of its slope, which
  /// never falls. `displacement`: along the cells at u.
  double best_length(const Eigen::VectorXd& u, const Eigen::VectorXd& displacement,
                     const Eigen::VectorXd& step, double spring) const {
    const Eigen::VectorXd change = cells_.shapes() * step;
    const auto displaced = [&](int n, double length, double* moved) {
      for (int j = 0; j < 4; ++j) moved[j] = displacement[4 * n + j] + length * change[4 * n + j];
    };
    const auto opens = [&](int n, double length) {
      double moved[4];
      displaced(n, length, moved);
      const CellOverlap cell = cells_.overlap(n, moved);
      return is_open(cell.sides[0]) && is_open(cell.sides[1]);
    };
    // a cell that is open at both ends of the line, by a convex function of it, is so in between
    std::vector<int> touching;
    const auto list_touching = [&](double length) {
      touching.clear();
      for (int n = 0; n < cells_.count(); ++n)
        if (!opens(n, 0.0) || !opens(n, length)) touching.push_back(n);
    };
    const auto slope = [&](double length) {
      double sum = (springs_.stiffness.cwiseProduct(u + length * step) - springs_.load).dot(step);
      for (const int n : touching) {
        double moved[4];
        displaced(n, length, moved);
        const Polynomial rate{change[4 * n], change[4 * n + 1], change[4 * n + 2],
                              change[4 * n + 3]};
        Cells::visit_points(cells_.overlap(n, moved), [&](double x, double over, double weight) {
          sum += spring * weight * over * value(rate, x);
        });
      }
      return sum;
    };
    list_touching(1.0);
    const double start = std::abs(slope(0.0));
    double low = 0.0, high = 1.0, at_high = slope(1.0);
    if (std::abs(at_high) <= 1e-3 * start) return 1.0;
    while (at_high < 0 && high < 1e6) {
      low = high;
      high *= 2;
      list_touching(high);
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
  for (int n = 0; n < m.nodes(); ++n) {
    if (n % m.row_nodes() == m.row_nodes() - 1) continue;  // no cell begins there
    const CellOverlap cell = faces_of(m, n);
    for (int side = 0; side < 2; ++side)
      for (const double edge : monotonic_between(cell.sides[side], side == 0 ? -0.5 : cell.knot,
                                                 side == 0 ? cell.knot : 0.5))
        largest = std::max(largest, value(cell.sides[side], edge));
  }
  return largest;
}

SmoothContact smooth_contact(const Model& model, const std::vector<double>& u) {
  const double spring = model.node_stiffness;
  SmoothContact sum;
  AllCells(model).visit(
      Eigen::Map<const Eigen::VectorXd>(u.data(), static_cast<Eigen::Index>(u.size())),
      [&](int number, const CellOverlap& cell) {
        Cells::visit_points(cell, [&](double, double over, double weight) {
          sum.force += spring * weight * over;
          sum.energy += 0.5 * spring * weight * over * over;
          if (sum.cells.empty() || sum.cells.back() != number) sum.cells.push_back(number);
        });
      });
  return sum;
}

namespace {

/// As smooth_equilibrium, of these cells alone.
std::optional<Eigen::VectorXd> settled_on(const SmoothPotential& potential,
                                          const std::vector<double>& guess) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(potential.modes());
  if (!guess.empty()) {
    u = Eigen::Map<const Eigen::VectorXd>(guess.data(), potential.modes());
    if (potential.minimise(u, potential.spring(), 1e-16)) return u;
    u.setZero();
  }
  for (double soft = 1e-10; soft < 0.5; soft *= 10)
    if (!potential.minimise(u, soft * potential.spring(), 1e-6)) return std::nullopt;
  if (!potential.minimise(u, potential.spring(), 1e-16)) return std::nullopt;
  return u;
}

/// Takes the cells of `more` into those of an ascending list. Whether any was missing.
bool take_in(std::vector<int>& cells, const std::vector<int>& more) {
  std::vector<int> all;
  std::set_union(cells.begin(), cells.end(), more.begin(), more.end(), std::back_inserter(all));
  const bool any = all.size() > cells.size();
  cells = std::move(all);
  return any;
}

}  // namespace

std::optional<std::vector<double>> smooth_equilibrium(const Model& model,
                                                      const std::vector<double>& guess,
                                                      const std::vector<int>& first) {
  const AllCells all(model);
  const auto vector = [](const Eigen::VectorXd& u) {
    return std::vector<double>(u.data(), u.data() + u.size());
  };
  if (!model.is_areal) {
    const auto settled = settled_on({model, all.some(all.all())}, guess);
    return settled ? std::optional(vector(*settled)) : std::nullopt;
  }
  // Of millions of cells few carry force. The equilibrium with some of them is that with all, where
  // no other overlaps.
  constexpr int rounds = 100;
  std::vector<double> u = guess;
  std::vector<int> cells = first;
  if (!u.empty())
    take_in(cells, all.touching(Eigen::Map<const Eigen::VectorXd>(
                       u.data(), static_cast<Eigen::Index>(u.size()))));
  for (int round = 0; round < rounds; ++round) {
    const auto settled = settled_on({model, all.some(cells)}, u);
    if (!settled) return std::nullopt;
    u = vector(*settled);
    if (!take_in(cells, all.touching(*settled))) return u;
  }
  return std::nullopt;
}

std::optional<SmoothRest> smooth_rest(const Model& model, const std::vector<int>& first_cells) {
  constexpr int rounds = 200;
  constexpr std::size_t most_added = 4096;
  constexpr double eps = std::numeric_limits<double>::epsilon();
  const AllCells all(model);
  const Cells first = all.some(first_cells.empty() ? all.all() : first_cells);
  const Eigen::Index modes = first.shapes().cols();
  const ModalSprings springs(model, modes);
  ContactProgram program{springs.stiffness, springs.load, Eigen::MatrixXd(0, modes),
                         Eigen::VectorXd(0), 0.0};
  std::vector<int> cell_of;  // of each place
  Eigen::VectorXd u = Eigen::VectorXd::Zero(modes), forces;
  struct HighPlace {
    int cell;
    double at, over;
  };
  std::vector<HighPlace> added;
  const double still[4] = {};
  for (int n = 0; n < first.count(); ++n) {
    const auto [at, over] = Cells::highest(first.overlap(n, still));
    added.push_back({first.number(n), at, over});
  }
  double allowed = 0;
  for (int round = 0; round < rounds; ++round) {
    if (round > 0) {
      added.clear();
      all.visit(u, [&](int number, const CellOverlap& cell) {
        if (is_open(cell.sides[0]) && is_open(cell.sides[1])) return;
        if (const auto [at, over] = Cells::highest(cell); over > allowed)
          added.push_back({number, at, over});
      });
      if (added.size() > most_added) {
        std::nth_element(added.begin(), added.begin() + most_added, added.end(),
                         [](const HighPlace& a, const HighPlace& b) { return a.over > b.over; });
        added.resize(most_added);
        std::sort(added.begin(), added.end(),
                  [](const HighPlace& a, const HighPlace& b) { return a.cell < b.cell; });
      }
    }
    if (added.empty()) {
      SmoothRest rest{.feasible = true,
                      .u = {u.data(), u.data() + u.size()},
                      .force = forces.sum(),
                      .cells = {}};
      for (Eigen::Index i = 0; i < forces.size(); ++i)
        if (forces[i] > 0) rest.cells.push_back(cell_of[i]);
      std::sort(rest.cells.begin(), rest.cells.end());
      rest.cells.erase(std::unique(rest.cells.begin(), rest.cells.end()), rest.cells.end());
      return rest;
    }
    std::vector<int> numbers;
    for (const HighPlace& place : added) numbers.push_back(place.cell);
    const Cells cells = all.some(numbers);
    Eigen::Index row = program.faces.size();
    program.shapes.conservativeResize(row + static_cast<Eigen::Index>(added.size()), modes);
    program.faces.conservativeResize(program.shapes.rows());
    for (int n = 0; n < cells.count(); ++n) {
      const double x = added[n].at;
      const CellOverlap faces = cells.overlap(n, still);
      program.faces[row] = value(faces.sides[x > faces.knot ? 1 : 0], x);
      program.shapes.row(row++) =
          Eigen::RowVector4d(1, x, x * x, x * x * x) * cells.shapes().middleRows<4>(4 * n);
      cell_of.push_back(cells.number(n));
    }
    const std::optional<RestingContact> solved = solve(program);
    if (!solved) return std::nullopt;
    if (!solved->feasible) return SmoothRest{.feasible = false, .u = {}, .force = 0, .cells = {}};
    u = solved->u;
    // roundings, and what they leave of the places taken so far
    const Eigen::VectorXd left = program.faces + program.shapes * u;
    allowed = 2 * std::max(0.0, left.maxCoeff()) +
              64 * eps *
                  (program.faces.cwiseAbs().maxCoeff() +
                   (program.shapes.cwiseAbs() * u.cwiseAbs()).maxCoeff());
    forces = solved->forces;
  }
  return std::nullopt;
}

}  // namespace ra2d
