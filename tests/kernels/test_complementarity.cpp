// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "host/base/decompositions.hpp"
#include "kernels/contact/complementarity.hpp"
#include "kernels/lanes.hpp"
#include "tests/dice.hpp"
#include "tests/kernels_of.hpp"

/// The contact forces of one step, on nodes and modes made up here, against an exhaustive search
/// and against the conditions that they must meet.
namespace {

using namespace ra2d;
using test::Dice;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

constexpr int width = HostLanes::width;
constexpr int most_modes = 24;
constexpr int K = (most_modes + width - 1) / width, stride = K * width;
using Real = HostLanes::Real;
constexpr double ulp = std::numeric_limits<double>::epsilon();

const HostLanes lanes;

// ---- problem and solver -----------------------------------------------------------------------

/// Where the modes would be without contact, and what the nodes see of it.
struct Problem {
  Matrix phi;             // (node, mode)
  Vector face;            // overlap of the faces alone
  Vector receptance;      // U1 of a unit force
  Vector free;            // U1 without contact
  double compliance = 0;  // of a node

  int nodes() const { return static_cast<int>(phi.rows()); }
  int modes() const { return static_cast<int>(phi.cols()); }
  Vector overlap(const Vector& u) const { return face + phi * u; }
  Matrix across() const { return phi * receptance.asDiagonal() * phi.transpose(); }
  /// The scene with its nodes numbered otherwise.
  Problem ordered(const std::vector<int>& order) const {
    Problem out = *this;
    for (int n = 0; n < nodes(); ++n) {
      out.phi.row(n) = phi.row(order[n]);
      out.face[n] = face[order[n]];
    }
    return out;
  }
  /// Overlap that counts as none: 16 roundings of the faces' heights (host/device/batch.cpp).
  double touch() const { return 16 * ulp * face.cwiseAbs().maxCoeff(); }
};

struct Answer {
  Solution solution = Solution::solved;
  Vector u, v;
  Vector force;  // of every node
  double most = 0;
  int searches = 0;  // how often nodes were listed
  int contacts = 0;
  double total = 0, face_work = 0, deflection_work = 0;
};

/// Nodes that are listed: all, or those that overlap, as the march lists them.
enum class Listing { all, overlapping };

class Solver {
 public:
  explicit Solver(const Problem& problem, Listing listing = Listing::all)
      : p_{problem}, listing_{listing} {
    const int nodes = p_.nodes(), modes = p_.modes();
    EXPECT_LE(modes, stride);
    tables_.faces.nodes = nodes;
    tables_.contact.compliance = p_.compliance;
    tables_.contact.tolerance = p_.touch();
    held_u_.assign(stride, 0.0);
    held_v_ = largest_shape_ = held_u_;
    for (int k = 0; k < modes; ++k) {
      held_u_[k] = p_.receptance[k];
      held_v_[k] = velocity(k);
      largest_shape_[k] = p_.phi.col(k).cwiseAbs().maxCoeff();
    }
    tables_.contact.receptance = held_u_.data(), tables_.contact.mobility = held_v_.data(),
    tables_.bounds.largest_shape = largest_shape_.data();
    shape_.assign(static_cast<std::size_t>(nodes) * 4 * stride, 0.0);
    face_.assign(2 * nodes, 0.0);
    window_.assign(nodes, 0);
    for (int n = 0; n < nodes; ++n) {
      for (int k = 0; k < modes; ++k) {
        shape_[(n * 4 + 0) * stride + k] = p_.phi(n, k);
        shape_[(n * 4 + 1) * stride + k] = slope(n, k);
      }
      face_[2 * n] = p_.face[n];
      face_[2 * n + 1] = rise(n);
    }
    const int room = p_.compliance > 0 ? nodes : std::min(nodes, modes);  // host/device/batch.cpp
    listed_nodes_.assign(nodes, -1);
    contact_nodes_ = listed_nodes_;
    place_ = listed_nodes_;
    contact_forces_.assign(nodes, 0.0);
    active_nodes_.assign(room, 0);
    active_forces_.assign(room, 0.0);
    across_ = share_ = active_forces_;
    factor_.assign(static_cast<std::size_t>(room + 1) * room, 0.0);
    state_.caches.node_shape = shape_.data(), state_.caches.node_face = face_.data(),
    state_.marks.node_window = window_.data();
    state_.work.listed_nodes = listed_nodes_.data(),
    state_.work.contact_list.nodes = contact_nodes_.data(),
    state_.work.contact_list.forces = contact_forces_.data();
    state_.work.active.capacity = room;
    state_.work.active.nodes = active_nodes_.data(), state_.marks.active_index = place_.data();
    state_.work.active.forces = active_forces_.data(), state_.work.active.factor = factor_.data();
    state_.work.active.coupling = across_.data(), state_.work.active.solution = share_.data();
  }
  static double rise(int node) { return 0.25 * node - 1; }
  static double slope(int node, int mode) { return 0.5 * node - mode; }
  static double velocity(int mode) { return 3 + mode; }  // V1 of a unit force
  static double start_velocity(int mode) { return 1 - 0.5 * mode; }

  Answer operator()() {
    state_.carried.latest_contact.step = -1;
    return solve();
  }
  /// With these nodes as those that carried force at the end of the step before.
  Answer resumed(std::initializer_list<int> nodes) {
    state_.carried.latest_contact.step = step - 1;
    state_.carried.latest_contact.nodes = static_cast<int>(nodes.size());
    std::copy_n(nodes.begin(), std::min<std::size_t>(2, nodes.size()),
                state_.carried.latest_contact.pair);
    return solve();
  }

  /// With so many that carried force then.
  Answer after(int nodes) {
    state_.carried.latest_contact.step = step - 1;
    state_.carried.latest_contact.nodes = nodes;
    return solve();
  }
  Solver& interrupted_by(const int* flag) {
    tables_.interrupted = flag;
    return *this;
  }

 private:
  static constexpr std::int64_t step = 7;
  const Problem& p_;
  Listing listing_;
  SceneTables tables_;
  SceneState state_;
  std::vector<double> held_u_, held_v_, largest_shape_, shape_, face_, contact_forces_,
      active_forces_, factor_, across_, share_;
  std::vector<std::int64_t> window_;
  std::vector<int> listed_nodes_, contact_nodes_, place_, active_nodes_;

  Answer solve() {
    Answer out;
    std::vector<double> u(stride, 0.0), v(stride, 0.0);
    for (int k = 0; k < p_.modes(); ++k) {
      u[k] = p_.free[k];
      v[k] = start_velocity(k);
    }
    Real packs_u[K], packs_v[K];
    for (int p = 0; p < K; ++p) {
      packs_u[p] = lanes.load(u.data() + p * width);
      packs_v[p] = lanes.load(v.data() + p * width);
    }
    Place place(tables_.motion, 0);
    place.offset = 0;  // where the shapes are those of the problem
    const auto contact = test::node_contact_of<K>(tables_, state_);
    const auto list = [&](const Real* at) {
      ++out.searches;
      int count = 0;
      for (int n = 0; n < p_.nodes(); ++n) {
        Real phi[K];
        contact.shape(n, 0.0, phi);
        if (listing_ == Listing::overlapping && !(contact.overlap(n, 0.0, phi, at) >= 0)) continue;
        listed_nodes_[count++] = n;
      }
      return count;
    };
    ContactTotals<Real> totals;
    auto solve = test::complementarity_of<K>(tables_, state_);
    out.solution = solve(place, step, packs_u, packs_v, list, totals, out.most);
    for (int p = 0; p < K; ++p) {
      lanes.store(u.data() + p * width, packs_u[p]);
      lanes.store(v.data() + p * width, packs_v[p]);
    }
    out.u = Eigen::Map<const Vector>(u.data(), p_.modes());
    out.v = Eigen::Map<const Vector>(v.data(), p_.modes());
    out.contacts = totals.nodes;
    out.total = totals.force, out.face_work = totals.face_work,
    out.deflection_work = lanes.sum(totals.deflection_work);
    out.force = Vector::Zero(p_.nodes());
    for (int e = 0; e < totals.nodes; ++e) {
      EXPECT_TRUE(e == 0 || contact_nodes_[e - 1] < contact_nodes_[e]) << "not in ascending order";
      out.force[contact_nodes_[e]] = contact_forces_[e];
    }
    // the work space is left as it was found
    EXPECT_EQ(std::count(place_.begin(), place_.end(), -1), p_.nodes());
    return out;
  }
};

Answer solve(const Problem& problem, Listing listing = Listing::all) {
  return Solver(problem, listing)();
}

// ---- what an answer must be -------------------------------------------------------------------

/// Overlap that roundings may leave [m]: what the solver lets pass at the worst
/// (ContactTables::tolerance, and 256 roundings of the modes' sums: kernels/candidates.hpp,
/// rounding), and those of the last search here, one for each mode and each node that pushes.
double rounding_of(const Problem& p, const Answer& a) {
  const Vector largest_shape = p.phi.cwiseAbs().colwise().maxCoeff();
  const Vector modal_force = p.phi.cwiseAbs().transpose() * a.force;
  const Vector ends = p.free.cwiseAbs() + a.u.cwiseAbs();
  return p.touch() + 256 * ulp * largest_shape.dot(ends) +
         (p.modes() + p.nodes() + 4) * ulp *
             largest_shape.dot(ends + p.receptance.cwiseProduct(modal_force));
}

/// The conditions, each to the roundings, and what the answer says of itself.
void expect_conditions(const Problem& p, const Answer& a) {
  ASSERT_EQ(a.solution, Solution::solved);
  const double least = rounding_of(p, a);
  const Vector over = p.overlap(a.u);
  for (int n = 0; n < p.nodes(); ++n) {
    EXPECT_GE(a.force[n], 0) << "node " << n;
    const double left = over[n] - p.compliance * a.force[n];
    EXPECT_LE(left, least) << "node " << n << " overlaps";
    if (a.force[n] > 0) {
      EXPECT_GE(left, -least) << "node " << n << " pushes across a gap";
    }
  }
  // the end of the step is that of these forces
  const Vector modal_force = p.phi.transpose() * a.force;
  const Vector size = p.phi.cwiseAbs().transpose() * a.force;
  for (int k = 0; k < p.modes(); ++k) {
    const double count = 2 * p.nodes() + 4;  // products, sums, and the last difference
    EXPECT_NEAR(a.u[k], p.free[k] - p.receptance[k] * modal_force[k],
                count * ulp * (p.receptance[k] * size[k] + std::abs(p.free[k])));
    const double start = Solver::start_velocity(k);
    EXPECT_NEAR(a.v[k], start - Solver::velocity(k) * modal_force[k],
                count * ulp * (Solver::velocity(k) * size[k] + std::abs(start)));
  }
  // and so is the record
  EXPECT_EQ(a.contacts, (a.force.array() > 0).count());
  const double count = 2 * p.nodes();
  EXPECT_NEAR(a.total, a.force.sum(), count * ulp * a.force.sum());
  EXPECT_GE(a.most, a.total * (1 - count * ulp));
  double face_work = 0, deflection_work = 0, face_work_size = 0, deflection_work_size = 0;
  for (int n = 0; n < p.nodes(); ++n) {
    face_work += a.force[n] * Solver::rise(n);
    face_work_size += std::abs(a.force[n] * Solver::rise(n));
    for (int k = 0; k < p.modes(); ++k) {
      deflection_work += a.force[n] * Solver::slope(n, k) * a.u[k];
      deflection_work_size += std::abs(a.force[n] * Solver::slope(n, k) * a.u[k]);
    }
  }
  EXPECT_NEAR(a.face_work, face_work, count * ulp * face_work_size);
  EXPECT_NEAR(a.deflection_work, deflection_work,
              (count + 2 * most_modes) * ulp * deflection_work_size);
}

/// Distance of two ends of a step in the metric in which the answer is nearest to the free one.
double distance(const Problem& p, const Vector& a, const Vector& b) {
  return std::sqrt(((a - b).array().square() / p.receptance.array()).sum());
}

/// Two states that meet the conditions but for an overlap of e, with forces f and f', are near:
/// (U - U')^T (U - U')/b = -sum (o_n - o'_n)(f_n - f'_n) <= e sum (f_n + f'_n). No more can be had
/// in general: where nodes have all but the same shape, roundings of the gaps weigh as their root.
void expect_near(const Problem& p, const Answer& a, const Vector& u, const Vector& force) {
  const double roundings = 4 * ulp * distance(p, 2 * p.free, p.free);  // of the two ends themselves
  EXPECT_LE(distance(p, a.u, u),
            std::sqrt(2 * rounding_of(p, a) * (a.force.sum() + force.sum())) + roundings);
}

// ---- exhaustive reference ---------------------------------------------------------------------

struct Reference {
  bool feasible = false;
  Vector u, force;
  double breach = 0;       // of the conditions, over the size of the overlaps
  double least_pivot = 1;  // of the nodes that carry force, over their own yielding
  double slack = 0;        // how far from another set of nodes: least force or gap, relative
};

/// Tries all sets of nodes that do not depend on one another, in long double.
class Exhaustive {
 public:
  explicit Exhaustive(const Problem& p)
      : p_{p},
        phi_{p.phi.cast<long double>()},
        w_{phi_ * p.receptance.cast<long double>().asDiagonal() * phi_.transpose()},
        free_{p.face.cast<long double>() + phi_ * p.free.cast<long double>()},
        scale_{free_.cwiseAbs().maxCoeff()} {
    for (int n = 0; n < p.nodes(); ++n) w_(n, n) += p.compliance;
    factor_ = LongMatrix::Zero(p.nodes(), p.nodes());
    best_ = std::numeric_limits<long double>::infinity();
    grow(0, 1.0L);
    out_.breach = static_cast<double>(best_);
    out_.feasible = best_ < 1e-12L;
    out_.u =
        p.free - (p.receptance.cast<long double>().asDiagonal() * (phi_.transpose() * best_force_))
                     .cast<double>();
    out_.force = best_force_.cast<double>();
  }
  const Reference& operator()() const { return out_; }

 private:
  const Problem& p_;
  LongMatrix phi_, w_, factor_;
  LongVector free_, best_force_;
  long double scale_, best_;
  std::vector<int> set_;
  Reference out_;

  void grow(int from, long double pivot) {
    weigh(pivot);
    for (int n = from; n < p_.nodes(); ++n) {
      const int row = static_cast<int>(set_.size());
      long double left = w_(n, n);
      for (int i = 0; i < row; ++i) {
        long double y = w_(n, set_[i]);
        for (int j = 0; j < i; ++j) y -= factor_(i, j) * factor_(row, j);
        factor_(row, i) = y / factor_(i, i);
        left -= factor_(row, i) * factor_(row, i);
      }
      if (!(left > 1e-14L * w_(n, n))) continue;
      factor_(row, row) = std::sqrt(left);
      set_.push_back(n);
      grow(n + 1, std::min(pivot, left / w_(n, n)));
      set_.pop_back();
    }
  }
  void weigh(long double pivot) {
    const int count = static_cast<int>(set_.size());
    LongVector f(count);
    for (int i = 0; i < count; ++i) {
      long double y = free_[set_[i]];
      for (int j = 0; j < i; ++j) y -= factor_(i, j) * f[j];
      f[i] = y / factor_(i, i);
    }
    for (int i = count - 1; i >= 0; --i) {
      for (int j = i + 1; j < count; ++j) f[i] -= factor_(j, i) * f[j];
      f[i] /= factor_(i, i);
    }
    long double breach = 0, slack = 1;
    for (int i = 0; i < count; ++i) {
      const long double worth = f[i] * w_(set_[i], set_[i]) / scale_;
      breach = std::max(breach, -worth);
      slack = std::min(slack, worth);
    }
    if (breach >= best_) return;
    for (int n = 0; n < p_.nodes(); ++n) {
      long double over = free_[n];
      for (int i = 0; i < count; ++i) over -= w_(n, set_[i]) * f[i];
      const bool in = std::find(set_.begin(), set_.end(), n) != set_.end();
      breach = std::max(breach, (in ? std::abs(over) : over) / scale_);
      if (!in) slack = std::min(slack, -over / scale_);
    }
    if (!(breach < best_)) return;
    best_ = breach;
    best_force_ = LongVector::Zero(p_.nodes());
    for (int i = 0; i < count; ++i) best_force_[set_[i]] = f[i];
    out_.least_pivot = static_cast<double>(pivot);
    out_.slack = static_cast<double>(slack);
  }
};

// ---- random problems --------------------------------------------------------------------------

enum class Shapes { random, positive, mesh, fine_mesh, rigid };

/// Nodes and modes as a step brings them: heights of micrometres, shapes of m^(-1/2), and answers
/// to a force as of steps of a nanosecond to a tenth of a millisecond.
Problem random_problem(Dice& dice, Shapes shapes, int nodes, int modes) {
  Problem p;
  p.phi.resize(nodes, modes);
  p.face.resize(nodes);
  p.receptance.resize(modes);
  p.free.resize(modes);
  const double scale = std::pow(10, dice.uniform(-18, -8));
  for (int k = 0; k < modes; ++k) {
    p.receptance[k] = scale * std::pow(10, dice.uniform(-1.5, 0));
    p.free[k] = dice.uniform(-1e-6, 1e-6) / std::sqrt(modes);
  }
  const double first = dice.uniform(0.1, 0.8);
  // neighbours on a mesh have all but the same shape
  const double apart = shapes == Shapes::fine_mesh ? 1e-4 : 1e-2;
  for (int n = 0; n < nodes; ++n) {
    const double x = first + n * apart / modes;
    for (int k = 0; k < modes; ++k) switch (shapes) {
        case Shapes::random:
          p.phi(n, k) = dice.uniform(-3, 3);
          break;
        case Shapes::positive:
          p.phi(n, k) = k == 0 ? 2 : dice.uniform(-3, 3);
          break;
        case Shapes::rigid:  // of a free slider, and on it a resonator's modes
          p.phi(n, k) = k == 0   ? 7
                        : k == 1 ? 12 * (n + 0.5 - 0.5 * nodes) / nodes
                                 : 2.6 * std::sin((k - 1) * M_PI * (first + 0.01 * n));
          break;
        case Shapes::mesh:
        case Shapes::fine_mesh:
          p.phi(n, k) = 2.6 * std::sin((k + 1) * M_PI * x);
          break;
      }
    p.face[n] = dice.uniform(-1e-6, 1e-6);
  }
  if (shapes == Shapes::mesh || shapes == Shapes::fine_mesh) {
    // faces that bend over as few nodes as the shapes would need forces out of all proportion
    const double bump = dice.uniform(0, nodes), curve = apart * dice.uniform(0.1, 3);
    for (int n = 0; n < nodes; ++n)
      p.face[n] = 1e-6 * (0.3 - curve * (n - bump) * (n - bump)) +
                  (dice.one_in(2) ? 1e-6 * apart * apart * dice.uniform(-1, 1) : 0.0);
  }
  return p;
}

/// Some nodes as others are, with the same face, a higher one or a lower one.
void repeat_nodes(Dice& dice, Problem& p) {
  for (int n = 1; n < p.nodes(); ++n) {
    if (!dice.one_in(2)) continue;
    const int other = dice.pick(n);
    p.phi.row(n) = p.phi.row(other);
    const double faces[] = {0.0, 1e-7, -1e-7};
    p.face[n] = p.face[other] + faces[dice.pick(3)];
  }
}

/// A problem made around its answer: nodes that carry force, most of them neighbours, nodes that
/// touch without force, and nodes with a gap.
struct Made {
  Problem problem;
  Vector u, force;
};
Made made_problem(Dice& dice, Shapes shapes, int nodes, int modes, int carrying) {
  Made m;
  Problem& p = m.problem;
  p = random_problem(dice, shapes, nodes, modes);
  if (dice.one_in(2)) {  // a mesh of any fineness
    const double apart = std::pow(10, dice.uniform(-6, -1));
    for (int n = 0; n < nodes; ++n)
      for (int k = 0; k < modes; ++k)
        p.phi(n, k) = 2.6 * std::cos(0.3 + (0.5 + k) * (1 + apart * n / modes));
  }
  p.phi.col(0).setConstant(2.0);  // else nodes could be pinched to a point, which roundings decide
  const double own = p.across().diagonal().maxCoeff();
  m.u = p.free;
  m.force = Vector::Zero(nodes);
  p.face = -p.phi * m.u;  // every node touches ...
  for (int n = 0; n < nodes; ++n)
    if (!dice.one_in(4)) p.face[n] -= std::pow(10, dice.uniform(-18, -7));  // ... or not
  const double penetration = std::pow(10, dice.uniform(-12, -5));
  for (int i = 0, n = dice.pick(nodes); i < carrying; ++i) {
    m.force[n] = penetration / own * std::pow(10, dice.uniform(-3, 0));
    p.face[n] = -p.phi.row(n) * m.u;
    n = dice.one_in(4) ? dice.pick(nodes) : (n + 1) % nodes;
  }
  if (dice.one_in(2)) {
    p.compliance = own * std::pow(10, dice.uniform(-6, 8));
    p.face += p.compliance * m.force;
  }
  p.free += p.receptance.cwiseProduct(p.phi.transpose() * m.force);
  return m;
}

// ---- tests ------------------------------------------------------------------------------------

constexpr Shapes all_shapes[] = {Shapes::random, Shapes::positive, Shapes::rigid, Shapes::mesh,
                                 Shapes::fine_mesh};

/// A random problem of any kind, small enough to be searched.
Problem any_problem(Dice& dice) {
  Problem p = random_problem(dice, all_shapes[dice.pick(5)],
                             1 + dice.pick(dice.one_in(20) ? 12 : 9), 1 + dice.pick(20));
  if (dice.one_in(2)) repeat_nodes(dice, p);
  if (dice.one_in(3))
    p.compliance = p.across().diagonal().mean() * std::pow(10, dice.uniform(-6, 2));
  return p;
}

TEST(Complementarity, AgreesWithAnExhaustiveSearch) {
  Dice dice(1);
  int blocked = 0, with_two_or_more = 0, unique = 0;
  for (int i = 0; i < 4000; ++i) {
    SCOPED_TRACE(i);
    const Problem p = any_problem(dice);
    const Reference best = Exhaustive(p)();
    // no problem here is all but feasible
    ASSERT_TRUE(best.breach < 1e-12 || best.breach > 1e-6) << best.breach;
    const Answer a = solve(p);
    ASSERT_EQ(a.solution, best.feasible ? Solution::solved : Solution::blocked);
    blocked += !best.feasible;
    if (!best.feasible) continue;
    expect_conditions(p, a);
    expect_near(p, a, best.u, best.force);
    with_two_or_more += a.contacts > 1;

    // Where no other set of nodes comes near, the same ones carry force: U - U' is then
    // b Phi^T W^-1 (o - o') on them, so its square in the metric is (o - o')^T W^-1 (o - o').
    std::vector<int> set;
    for (int n = 0; n < p.nodes(); ++n)
      if (best.force[n] > 0) set.push_back(n);
    if (set.empty() || best.slack < 1e-9) continue;
    const Matrix w =
        p.across()(set, set) +
        p.compliance * Matrix::Identity(static_cast<int>(set.size()), static_cast<int>(set.size()));
    const Vector stiff = symmetric_eigen(w).values;
    if (stiff[0] < 1e-6 * stiff[stiff.size() - 1]) continue;
    ++unique;
    const double off = 2 * rounding_of(p, a) * std::sqrt(static_cast<double>(set.size()));
    EXPECT_LE(distance(p, a.u, best.u), off / std::sqrt(stiff[0]));
    EXPECT_LE((a.force - best.force).norm(), off / stiff[0]);
  }
  // the problems are what they are for
  EXPECT_GE(blocked, 20);
  EXPECT_GE(with_two_or_more, 1000);
  EXPECT_GE(unique, 1000);
}

TEST(Complementarity, FindsTheAnswerThatAProblemWasMadeAround) {
  // up to hundreds of nodes, up to a dozen neighbours that carry force, on meshes so fine that they
  // all but depend on one another
  Dice dice(2);
  for (const int most : {3, 15, 300})
    for (int i = 0; i < (most == 300 ? 300 : 6000); ++i) {
      SCOPED_TRACE(std::to_string(i) + " of up to " + std::to_string(most));
      const int nodes = 1 + dice.pick(most), modes = 1 + dice.pick(20);
      const Made m = made_problem(dice, all_shapes[dice.pick(5)], nodes, modes, dice.pick(12));
      const Answer a = solve(m.problem);
      expect_conditions(m.problem, a);
      expect_near(m.problem, a, m.u, m.force);
      // the rounds that it gives itself are 64 + 8 for each node: an eighth of that is not passed
      EXPECT_LE(a.searches, 8 + nodes);
    }
}

TEST(Complementarity, NodesThatPushTogetherTouchToTheRoundingsOfOneSearch) {
  // what the forces gather on their way is taken out of them: what counts as touching remains, and
  // the roundings of a sum over the modes, there and here
  Dice dice(6);
  int with_two_or_more = 0;
  for (int i = 0; i < 8000; ++i) {
    SCOPED_TRACE(i);
    const Made m = made_problem(dice, all_shapes[dice.pick(5)], 2 + dice.pick(100),
                                2 + dice.pick(9), 1 + dice.pick(12));
    const Problem& p = m.problem;
    const Answer a = solve(p);
    ASSERT_EQ(a.solution, Solution::solved);
    if (a.contacts < 2) continue;
    ++with_two_or_more;
    const Vector over = p.overlap(a.u), modal_force = p.phi.cwiseAbs().transpose() * a.force;
    const Vector size =
        p.phi.cwiseAbs() * (p.free.cwiseAbs() + p.receptance.cwiseProduct(modal_force));
    for (int n = 0; n < p.nodes(); ++n)
      if (a.force[n] > 0) {
        EXPECT_NEAR(over[n], p.compliance * a.force[n], p.touch() + (p.modes() + 4) * ulp * size[n])
            << "node " << n;
      }
  }
  EXPECT_GE(with_two_or_more, 2000);
}

TEST(Complementarity, OrderOfTheNodesDoesNotMatter) {
  Dice dice(3);
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    const Problem p = any_problem(dice);
    std::vector<int> mirrored(p.nodes());
    std::iota(mirrored.rbegin(), mirrored.rend(), 0);
    const Answer a = solve(p);
    for (const std::vector<int>& order : {mirrored, dice.order(p.nodes())}) {
      const Answer b = solve(p.ordered(order));
      ASSERT_EQ(b.solution, a.solution);
      if (a.solution == Solution::solved) expect_near(p, a, b.u, b.force);
    }
  }
}

TEST(Complementarity, NodesThatDoNotOverlapNeedNotBeListed) {
  Dice dice(4);
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    const Problem p = i % 2 == 0 ? any_problem(dice)
                                 : made_problem(dice, all_shapes[dice.pick(5)], 1 + dice.pick(40),
                                                1 + dice.pick(20), dice.pick(6))
                                       .problem;
    const Answer all = solve(p), some = solve(p, Listing::overlapping);
    ASSERT_EQ(all.solution, some.solution);
    EXPECT_EQ(all.u, some.u);
    EXPECT_EQ(all.v, some.v);
    EXPECT_EQ(all.force, some.force);
    EXPECT_EQ(all.most, some.most);
    EXPECT_EQ(all.searches, some.searches);
  }
}

TEST(Complementarity, NodesOfTheStepBeforeGiveTheSameAnswer) {
  Dice dice(5);
  int taken = 0, refused = 0;
  for (int i = 0; i < 4000; ++i) {
    SCOPED_TRACE(i);
    const Problem p = i % 2 == 0 ? any_problem(dice)
                                 : made_problem(dice, all_shapes[dice.pick(5)], 1 + dice.pick(15),
                                                1 + dice.pick(20), 1 + dice.pick(3))
                                       .problem;
    const Answer a = solve(p);
    const auto expect_same = [&](const Answer& b) {
      ASSERT_EQ(b.solution, a.solution);
      if (a.solution != Solution::solved) return;
      expect_conditions(p, b);
      expect_near(p, b, a.u, a.force);
      // a guess costs one search: it was right if there is no other
      taken += b.contacts > 0 && b.searches == 1;
      refused += b.contacts > 0 && b.searches > 1;
    };
    // those that carry force now, and some that need not
    std::vector<int> carrying;
    for (int n = 0; n < p.nodes(); ++n)
      if (a.solution == Solution::solved && a.force[n] > 0) carrying.push_back(n);
    if (carrying.size() == 1) expect_same(Solver(p).resumed({carrying[0]}));
    if (carrying.size() == 2) expect_same(Solver(p).resumed({carrying[0], carrying[1]}));
    const int one = dice.pick(p.nodes()), other = dice.pick(p.nodes());
    expect_same(Solver(p).resumed({one}));
    if (one != other) expect_same(Solver(p).resumed({std::min(one, other), std::max(one, other)}));
    expect_same(Solver(p).resumed({}));
    expect_same(Solver(p).resumed({0, 1, 2}));  // more than two are not remembered
  }
  EXPECT_GE(taken, 1000);
  EXPECT_GE(refused, 1000);
}

// ---- by name: numbers are dyadic, so these are exact

/// Nodes with one row of shapes each.
Problem by_hand(std::initializer_list<std::initializer_list<double>> phi,
                std::initializer_list<double> face, std::initializer_list<double> receptance,
                std::initializer_list<double> free) {
  const auto vector = [](std::initializer_list<double> from) -> Vector {
    return Eigen::Map<const Vector>(from.begin(), static_cast<int>(from.size()));
  };
  Problem p;
  p.phi.resize(static_cast<int>(phi.size()), static_cast<int>(receptance.size()));
  int n = 0;
  for (const auto& row : phi) p.phi.row(n++) = vector(row);
  p.face = vector(face), p.receptance = vector(receptance), p.free = vector(free);
  return p;
}

TEST(Complementarity, OpenGapsLeaveTheStepAsItIs) {
  const Answer a = solve(by_hand({{1, 0}, {1, 1}}, {-2, -4}, {1, 0.5}, {1, 2}));
  EXPECT_EQ(a.solution, Solution::solved);
  EXPECT_EQ(a.contacts, 0);
  EXPECT_EQ(a.searches, 1);
  EXPECT_EQ(a.most, 0);
  EXPECT_EQ(a.u, (Vector{{1, 2}}));
  EXPECT_EQ(a.v[0], Solver::start_velocity(0));
}

TEST(Complementarity, TouchingAtExactlyZeroCarriesNoForce) {
  EXPECT_EQ(solve(by_hand({{1, 0}, {1, 1}}, {-1, -3}, {1, 0.5}, {1, 2})).contacts, 0);
  // one node is pushed clear, and the other then touches: W = 1.5, f = 3/1.5, U = (0, 1)
  const Answer a = solve(by_hand({{1, 1}, {0, 1}}, {-1, -1}, {1, 0.5}, {2, 2}));
  EXPECT_EQ(a.force, (Vector{{2, 0}}));
  EXPECT_EQ(a.contacts, 1);
  EXPECT_EQ(a.u, (Vector{{0, 1}}));
  EXPECT_EQ(a.v, (Vector{{Solver::start_velocity(0) - 2 * Solver::velocity(0),
                          Solver::start_velocity(1) - 2 * Solver::velocity(1)}}));
}

TEST(Complementarity, TieBetweenTwoNodesIsShared) {
  // both overlap by 2, and each yields to the other by half of what it yields to itself
  const Answer a = solve(by_hand({{1, 0, 1}, {0, 1, 1}}, {2, 2}, {0.5, 0.5, 0.5}, {0, 0, 0}));
  EXPECT_NEAR(a.force[0], 4.0 / 3, 4 * ulp);
  EXPECT_NEAR(a.force[1], 4.0 / 3, 4 * ulp);
}

TEST(Complementarity, NodeThatWouldPullIsLetGo) {
  // The second overlaps more and comes first; the first one's force then lifts it clear.
  // W = (1 2; 2 5): the first alone, f = 1.5 > 1, leaves 1.5 * 2 - 2.5 > 0 on the second.
  const Answer a = solve(by_hand({{1, 0}, {2, 1}}, {1.5, 2.5}, {1, 1}, {0, 0}));
  EXPECT_EQ(a.force, (Vector{{1.5, 0}}));
  EXPECT_EQ(a.searches, 3);
}

TEST(Complementarity, OneNodeLetsGoOnTheWayAndNoOther) {
  // W = (1 1 1; 1 2 0; 1 0 6). The second comes with 7/2, the third with 2/3. The first still
  // overlaps by 11/6: at 4 N on it the third lets go and 1/2 of that is left, gone with 1 N more,
  // as the second would let go only at 3 N more. So each comes once, and one goes: three searches
  // and a last one.
  const Answer a =
      solve(by_hand({{1, 0, 0}, {1, 0, -1}, {1, 2, 1}}, {6, 7, 4}, {1, 1, 1}, {0, 0, 0}));
  EXPECT_EQ(a.searches, 4);
  for (int n = 0; n < 3; ++n)
    EXPECT_NEAR(a.force[n], (Vector{{5, 1, 0}})[n], 64 * ulp) << "node " << n;
}

TEST(Complementarity, EqualNodesCarryWhatOneWould) {
  const Answer one = solve(by_hand({{1, 0.5}}, {1}, {1, 2}, {0.5, 0}));
  const Answer three = solve(by_hand({{1, 0.5}, {1, 0.5}, {1, 0.5}}, {1, 1, 1}, {1, 2}, {0.5, 0}));
  EXPECT_EQ(three.u, one.u);
  EXPECT_EQ(three.force.sum(), one.force.sum());
  // of a step in the face the highest alone carries force
  const Answer step = solve(by_hand({{1, 0.5}, {1, 0.5}}, {0.5, 1}, {1, 2}, {0.5, 0}));
  EXPECT_EQ(step.u, one.u);
  EXPECT_EQ(step.force[0], 0);
}

TEST(Complementarity, OneModePinchedOnBothSidesOfAVibrationNode) {
  // U <= -1 at the first and U >= -lowest at the second
  const auto pinched = [](double lowest) {
    return solve(by_hand({{1}, {-1}}, {1, -lowest}, {0.5}, {4}));
  };
  const Answer room = pinched(2);
  ASSERT_EQ(room.solution, Solution::solved);
  EXPECT_EQ(room.u[0], -1);
  EXPECT_EQ(room.force, (Vector{{10, 0}}));
  const Answer none = pinched(1);  // no room at all, but no overlap either
  ASSERT_EQ(none.solution, Solution::solved);
  EXPECT_EQ(none.u[0], -1);
  EXPECT_EQ(pinched(0.5).solution, Solution::blocked);
}

TEST(Complementarity, NodeThatNothingMoves) {
  const Problem open = by_hand({{0}, {1}}, {-1, 1}, {0.5}, {0});
  EXPECT_EQ(solve(open).solution, Solution::solved);
  const Problem over = by_hand({{0}, {1}}, {1, 1}, {0.5}, {0});
  EXPECT_EQ(solve(over).solution, Solution::blocked);
  // it carried force before it came to where nothing moves
  EXPECT_EQ(Solver(over).resumed({0}).solution, Solution::blocked);
  EXPECT_EQ(Solver(over).resumed({0, 1}).solution, Solution::blocked);
  // ... or to where next to nothing does
  const Problem hardly = by_hand({{1e-160}, {1}}, {1, 1}, {0.5}, {0});
  EXPECT_EQ(solve(hardly).solution, Solution::blocked);
  EXPECT_EQ(Solver(hardly).resumed({0}).solution, Solution::blocked);
  // a spring gives way
  Problem soft = over;
  soft.compliance = 0.5;
  const Answer a = solve(soft);
  EXPECT_EQ(a.solution, Solution::solved);
  EXPECT_EQ(a.force, (Vector{{2, 1}}));
}

TEST(Complementarity, FreeSliderFlatOnFlat) {
  // Translation and rotation of a bar of length 1 and mass 1, dropped flat by 1/4 (and, a second
  // time, onto faces that have no heights at all: then nothing but roundings counts as touching).
  for (const double face : {0.25, 0.0})
    for (const int nodes : {1, 2, 3, 100, 300}) {
      SCOPED_TRACE(std::to_string(nodes) + " nodes");
      Problem p;
      p.phi.resize(nodes, 2);
      for (int n = 0; n < nodes; ++n) {
        const double x = nodes > 1 ? n / (nodes - 1.0) - 0.5 : 0.25;
        p.phi.row(n) = Eigen::RowVector2d(1, std::sqrt(12) * x);
      }
      p.face = Vector::Constant(nodes, face);
      p.receptance = Vector{{1e-3, 1e-3}};
      p.free = Vector{{face > 0 ? 0.0 : 0.3, 0.0}};
      const double drop = face + p.free[0];
      const Answer a = solve(p);
      expect_conditions(p, a);
      EXPECT_LE(a.contacts, 2);
      if (nodes == 1) {  // off the middle it turns, too: W = 1e-3 (1 + 12/16)
        EXPECT_NEAR(a.total, drop / 1.75e-3, 8 * ulp * a.total);
      } else {  // the forces balance: it stays level
        EXPECT_NEAR(a.total, drop / 1e-3, 300 * ulp * a.total);
        EXPECT_NEAR(a.u[1], 0, 300 * ulp * drop);
      }
    }
}

TEST(Complementarity, RigidSliderPressedOntoFewModes) {
  // A flat block pressed by `deep` onto the middle stretch of a pinned beam of length 1, whose
  // modes bend below it: one mode, closed form; more, the conditions.
  for (const int modes : {1, 2, 3})
    for (const int nodes : {2, 7, 64, 300}) {
      SCOPED_TRACE(std::to_string(modes) + " modes, " + std::to_string(nodes) + " nodes");
      Problem p;
      p.phi.resize(nodes, modes);
      for (int n = 0; n < nodes; ++n)
        for (int k = 0; k < modes; ++k)
          p.phi(n, k) = std::sqrt(2) * std::sin((k + 1) * M_PI * (0.3 + 0.4 * n / (nodes - 1)));
      p.face = Vector::Constant(nodes, 1e-3);
      p.receptance = Vector::Constant(modes, 1e-6);
      p.free = Vector::Zero(modes);
      const Answer a = solve(p);
      expect_conditions(p, a);
      if (modes == 1) {  // the ends of the block, where the mode is lowest
        EXPECT_NEAR(a.u[0], -1e-3 / (std::sqrt(2) * std::sin(0.3 * M_PI)), 8 * ulp * 1e-3);
      }
      // the second mode alone goes up on one side as it goes down on the other
      Problem seesaw = p;
      seesaw.phi = Matrix(nodes, 1);
      for (int n = 0; n < nodes; ++n)
        seesaw.phi(n, 0) = std::sqrt(2) * std::sin(2 * M_PI * (0.3 + 0.4 * n / (nodes - 1)));
      seesaw.receptance = p.receptance.head(1), seesaw.free = p.free.head(1);
      EXPECT_EQ(solve(seesaw).solution, Solution::blocked);
    }
}

TEST(Complementarity, SpringsCarryForceAtMoreNodesThanThereAreModes) {
  // one mode on 300 equal springs: each carries f = over/(300 W + c)
  Problem p;
  p.phi = Matrix::Constant(300, 1, 2.0);
  p.face = Vector::Constant(300, 1e-6);
  p.receptance = Vector{{0.25e-9}};
  p.free = Vector{{0.0}};
  p.compliance = 1e-8;
  const Answer a = solve(p);
  expect_conditions(p, a);
  EXPECT_EQ(a.contacts, 300);
  // each force is a difference of displacements: wrong by the roundings of an overlap over c
  for (int n = 0; n < 300; ++n)
    EXPECT_NEAR(a.force[n], 1e-6 / (300 * 1e-9 + 1e-8), 2 * rounding_of(p, a) / p.compliance);
}

// ---- many nodes on springs ----------------------------------------------------------------------

/// Searches that are enough for any number of nodes: one for each node that is pressed
/// before Newton's method takes over, and some for its steps.
constexpr int enough_searches = Complementarity<HostLanes, K>::many + 100;

TEST(Complementarity, ManyNodesOnSpringsMeetTheSameConditions) {
  Dice dice(20261122);
  int many = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const int nodes = 700;
    Made m = made_problem(dice, Shapes::mesh, nodes, 1 + dice.pick(most_modes), 500);
    if (m.problem.compliance == 0) continue;
    // where springs are softer than all nodes together, roundings of overlaps stay what they are
    const double own = m.problem.across().diagonal().maxCoeff();
    const double softer = own * nodes * std::pow(10, dice.uniform(0, 3));
    m.problem.face += (softer - m.problem.compliance) * m.force;
    m.problem.compliance = softer;
    const Answer all = solve(m.problem), overlapping = solve(m.problem, Listing::overlapping);
    expect_conditions(m.problem, all);
    expect_near(m.problem, all, m.u, m.force);
    EXPECT_LE(all.searches, enough_searches);
    many += all.contacts > Complementarity<HostLanes, K>::many;
    // which nodes are listed beside those that overlap changes no bit
    EXPECT_EQ(all.u, overlapping.u);
    EXPECT_EQ(all.force, overlapping.force);
  }
  EXPECT_GE(many, 4);
}

/// Flat on flat: n springs k under a plate that moves as a whole, u = (u* - n k b phi face)/(1 + n
/// k b phi^2).
Problem flat_on_flat(int nodes, double compliance) {
  Problem p;
  p.phi = Matrix::Constant(nodes, 1, 2.0);
  p.face = Vector::Constant(nodes, -1e-6);
  p.receptance = Vector::Constant(1, 1e-3);
  p.free = Vector::Constant(1, 2e-6);
  p.compliance = compliance;
  return p;
}

TEST(Complementarity, FlatOnFlatOnSpringsIsTheClosedForm) {
  for (const double compliance : {1e-6, 1e-3, 1e3}) {
    const Problem p = flat_on_flat(1000, compliance);
    const Answer a = solve(p);
    ASSERT_EQ(a.solution, Solution::solved);
    const double k = 1000 / compliance, stiffening = k * 1e-3 * 2.0;
    const double u = (2e-6 + stiffening * 1e-6) / (1 + 2 * stiffening);
    EXPECT_NEAR(
        a.u[0], u,
        (2 + stiffening) * 64 * ulp * 2e-6);  // roundings of 1000 overlaps, as stiff as they are
    EXPECT_NEAR(a.total, k * (2 * u - 1e-6), k * (2 + stiffening) * 128 * ulp * 2e-6);
    EXPECT_EQ(a.contacts, 1000);
    EXPECT_LE(a.searches, enough_searches);
  }
}

TEST(Complementarity, ManyNodesOfTheStepBeforeAreNotPressedOneByOne) {
  const Problem p = flat_on_flat(1000, 1.0);
  Solver solver(p);
  EXPECT_LE(solver.after(1000).searches, 10);
  EXPECT_GT(solver.after(Complementarity<HostLanes, K>::many).searches, 256);
}

TEST(Complementarity, AnInterruptEndsTheSearch) {
  const int interrupted = 1;
  const Problem p = flat_on_flat(1000, 1.0), few = flat_on_flat(8, 1.0);
  for (const int before : {0, 1000}) {
    const Answer a = Solver(p).interrupted_by(&interrupted).after(before);
    EXPECT_EQ(a.solution, Solution::interrupted);
    EXPECT_EQ(a.u, p.free);  // nothing is done
    EXPECT_LE(a.searches, 17);
  }
  EXPECT_EQ(Solver(few).interrupted_by(&interrupted).after(0).solution, Solution::solved);
}

}  // namespace
