// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/model/contact_program.hpp"
#include "host/model/model.hpp"

/// Static equilibrium under load and contact: the minimum of the convex potential
///   sum_k m omega_k^2 U_k^2 / 2 - load_k U_k  +  sum_n kappa chi w max(0, -g_n)^2 / 2,
/// by Newton's method on its piecewise quadratic form. The contact springs are stiffened from soft
/// to the asked value, each stage starting from the one before: a slider first settles as a whole,
/// then onto its two or three highest asperities.
///
/// Springs that are too stiff for that (the roundings of an overlap are forces then), and
/// multipliers, whose springs do not yield at all, are solved as the quadratic programme that the
/// minimum is.
namespace ra2d {
namespace {

/// How Newton's Hessian is kept regular: by the same stiffness for all modes, or by a share of each
/// one's own, where the stiff modes' would be more than what holds the rigid ones.
enum class Shift { common, own };

/// The nodes that overlap anywhere on a line u + length step: few of all.
class OverlapsAlong {
 public:
  /// Of all nodes: the overlaps at u, and how they change over a step [m].
  OverlapsAlong(const Eigen::VectorXd& at, const Eigen::VectorXd& change)
      : all_at_{at}, all_change_{change}, at_(at.size()), change_(at.size()) {}

  /// sum_n max(0, overlap_n) change_n at a length >= 0 [m^2].
  double sum(double length) {
    if (length > reach_) find(length);
    return (at_.head(count_) + length * change_.head(count_))
        .cwiseMax(0.0)
        .dot(change_.head(count_));
  }

 private:
  const Eigen::VectorXd &all_at_, &all_change_;
  Eigen::VectorXd at_, change_;  // of the first `count_`
  Eigen::Index count_ = 0;
  double reach_ = -1;  // they are all that overlap up to this length

  /// A node that overlaps at neither end of a stretch overlaps nowhere within. They are taken or
  /// left by as many as the sum takes in at a time, so that it adds up in the order of the sum of
  /// all.
  void find(double length) {
    constexpr Eigen::Index together = 16;
    count_ = 0;
    for (Eigen::Index n = 0; n < all_at_.size(); n += together) {
      const Eigen::Index size = std::min(together, all_at_.size() - n);
      const auto at = all_at_.segment(n, size), change = all_change_.segment(n, size);
      if (!(at.maxCoeff() > 0 || (at + length * change).maxCoeff() > 0)) continue;
      at_.segment(count_, size) = at;
      change_.segment(count_, size) = change;
      count_ += size;
    }
    reach_ = length;
  }
};

constexpr int pack = 8;  // modes that are summed up at a time

/// The shapes of the modes of both bodies at the nodes, at t = 0.
struct NodeShapes {
  Eigen::MatrixXd shapes;  // (node, mode)
  Eigen::MatrixXd rows;    // (mode, padded to packs; node)
  Eigen::VectorXd sizes;   // of each node, the sum over the modes of |shape|

  explicit NodeShapes(const Model& model) {
    const auto modes =
        static_cast<Eigen::Index>(model.resonator.modes.size() + model.slider.modes.size());
    const double chi = model.scene.spacing;
    shapes.resize(model.nodes(), modes);
    for (int n = 0; n < model.nodes(); ++n) {
      int column = 0;
      for (const ModeShape& mode : model.resonator.modes)
        evaluate(mode, model.resonator.length, (model.position + n) * chi, 1, &shapes(n, column++));
      for (const ModeShape& mode : model.slider.modes)
        evaluate(mode, model.slider.length, n * chi, 1, &shapes(n, column++));
    }
    rows = Eigen::MatrixXd::Zero((modes + pack - 1) / pack * pack, model.nodes());
    rows.topRows(modes) = shapes.transpose();
    sizes = Eigen::VectorXd::Zero(model.nodes());
    for (Eigen::Index k = 0; k < modes; ++k) sizes += shapes.col(k).cwiseAbs();
  }
};

/// Those of the scenes before: the runs of a study mostly have equal bodies, and their shapes take
/// a sine for every node and mode.
class KnownShapes {
 public:
  std::shared_ptr<const NodeShapes> of(const Model& model) {
    const Key key = key_of(model);
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [known, shapes] : known_)
        if (known == key) return shapes;
    }
    const auto shapes = std::make_shared<const NodeShapes>(model);
    const std::lock_guard lock(mutex_);
    if (shapes->shapes.size() > most_values) return shapes;
    known_.emplace_front(key, shapes);
    if (known_.size() > most) known_.pop_back();
    return shapes;
  }

 private:
  static constexpr std::size_t most = 4;
  static constexpr Eigen::Index most_values = 1 << 20;  // of larger ones the memory is worth more

  using Key = std::vector<double>;  // all that they depend on
  static Key key_of(const Model& model) {
    Key key{model.scene.spacing, model.position, static_cast<double>(model.nodes())};
    for (const Beam* beam : {&model.resonator, &model.slider}) {
      key.push_back(beam->length);
      key.push_back(static_cast<double>(beam->modes.size()));
      for (const ModeShape& m : beam->modes)
        key.insert(key.end(), {m.beta, m.sine, m.cosine, m.left, m.right, m.constant, m.slope});
    }
    return key;
  }
  std::mutex mutex_;
  std::list<std::pair<Key, std::shared_ptr<const NodeShapes>>> known_;
};

class Potential {
 public:
  explicit Potential(const Model& model) : nodes_{known_shapes().of(model)} {
    const auto add = [&](const Beam& beam) {
      for (std::size_t k = 0; k < beam.modes.size(); ++k) {
        stiffness_.push_back(beam.mass_per_length * beam.modes[k].omega * beam.modes[k].omega);
        load_.push_back(beam.load[k]);
      }
    };
    add(model.resonator);
    add(model.slider);
    const std::vector<double> faces = overlaps(model, {}, {});
    faces_ = Eigen::Map<const Eigen::VectorXd>(faces.data(), model.nodes());
  }

  /// The same minimum as a programme, the springs' compliance in m/N.
  ContactProgram program(double compliance) const {
    return {.stiffness = Eigen::Map<const Eigen::VectorXd>(stiffness_.data(), modes()),
            .load = Eigen::Map<const Eigen::VectorXd>(load_.data(), modes()),
            .shapes = nodes_->shapes,
            .faces = faces_,
            .compliance = compliance};
  }

  int modes() const { return static_cast<int>(stiffness_.size()); }
  Eigen::VectorXd overlap(const Eigen::VectorXd& u) const { return faces_ + nodes_->shapes * u; }
  /// ... as overlaps() sums them up, mode by mode.
  Eigen::VectorXd overlap_by_modes(const Eigen::VectorXd& u) const {
    Eigen::VectorXd sum = faces_;
    for (int k = 0; k < modes(); ++k)
      if (u[k] != 0.0) sum += u[k] * nodes_->shapes.col(k);
    return sum;
  }

  /// Negative gradient, the Hessian's lower triangle and the size of the terms that the gradient is
  /// made of, where the nodes overlap by `over`.
  void expand(const Eigen::VectorXd& u, const Eigen::VectorXd& over, double spring,
              Eigen::VectorXd& force, Eigen::MatrixXd& hessian, double& scale) const {
    force.resize(modes());
    hessian = Eigen::MatrixXd::Zero(modes(), modes());
    scale = 0;
    for (int k = 0; k < modes(); ++k) {
      force[k] = load_[k] - stiffness_[k] * u[k];
      hessian(k, k) = stiffness_[k];
      scale += std::abs(load_[k]) + std::abs(stiffness_[k] * u[k]);
    }
    // By packs of modes, those above the diagonal in its own pack computed in vain. Each sum takes
    // in one node after the other, but several of them between two ways to memory.
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(padded_modes(), modes());
    sum.topRows(modes()) = hessian;
    Eigen::Matrix<double, Eigen::Dynamic, together> pushed(padded_modes(), int{together});
    std::array<int, together> nodes;
    int count = 0;
    for (int n = 0; n < over.size(); ++n) {
      if (over[n] > 0) {
        pushed.col(count) = spring * nodes_->rows.col(n);
        force -= spring * over[n] * nodes_->rows.col(n).head(modes());
        scale += spring * over[n] * nodes_->sizes[n];
        nodes[count++] = n;
      }
      if (count < together && n + 1 < over.size()) continue;
      for (int k = 0; k < modes(); ++k)
        for (int i = k / pack * pack; i < padded_modes(); i += pack) {
          Eigen::Matrix<double, pack, 1> part = sum.col(k).segment<pack>(i);
          for (int e = 0; e < count; ++e)
            part += nodes_->rows(k, nodes[e]) * pushed.col(e).segment<pack>(i);
          sum.col(k).segment<pack>(i) = part;
        }
      count = 0;
    }
    hessian = sum.topRows(modes());
  }

  /// The length along `step` at which the potential is least, from the sign of its slope: that,
  /// unlike its value, is known to the last digits. The slope never falls, since the potential is
  /// convex. `over` are the overlaps at u.
  double best_length(const Eigen::VectorXd& u, const Eigen::VectorXd& over,
                     const Eigen::VectorXd& step, double spring) const {
    const Eigen::VectorXd change = nodes_->shapes * step;
    OverlapsAlong nodes(over, change);
    const auto slope = [&](double length) {
      double sum = 0;
      for (int k = 0; k < modes(); ++k)
        sum += (stiffness_[k] * (u[k] + length * step[k]) - load_[k]) * step[k];
      return sum + spring * nodes.sum(length);
    };
    double low = 0.0, high = 1.0;
    while (slope(high) < 0 && high < 1e6) {
      low = high;
      high *= 2;
    }
    if (low == 0.0 && slope(1.0) <= 1e-12 * std::abs(slope(0.0))) return 1.0;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = 0.5 * (low + high);
      (slope(middle) < 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  /// Minimises from `u`; false when it does not settle.
  bool minimise(Eigen::VectorXd& u, double spring, Shift shift) const {
    Eigen::VectorXd force, best_u = u;
    Eigen::MatrixXd hessian;
    double best =
        std::numeric_limits<double>::infinity();  // residual over the forces it is made of
    int stalled = 0;
    std::vector<Eigen::VectorXd> seen;
    for (int round = 0; round < 1000 && stalled < 30; ++round) {
      // a round depends on u alone: from here on they would repeat
      if (std::find(seen.begin(), seen.end(), u) != seen.end()) break;
      seen.push_back(u);
      double scale = 0;
      const Eigen::VectorXd over = overlap(u);
      expand(u, over, spring, force, hessian, scale);
      const double residual = scale > 0 ? force.lpNorm<Eigen::Infinity>() / scale : 0.0;
      ++stalled;
      if (residual < best) {
        if (residual < 0.5 * best) stalled = 0;
        best = residual;
        best_u = u;
      }
      if (best <= 1e-16) break;
      // the shift keeps directions finite that nothing holds: a slider on one asperity may still
      // tilt; of a mode that nothing holds at all yet, it is that of all nodes together
      const double most = hessian.diagonal().maxCoeff();
      for (int k = 0; k < modes(); ++k) {
        const double own =
            hessian(k, k) > 0 ? hessian(k, k) : spring * nodes_->shapes.col(k).squaredNorm();
        hessian(k, k) += 1e-14 * (shift == Shift::common && most > 0 ? most : own) + 1e-300;
      }
      const Eigen::VectorXd step = hessian.ldlt().solve(force);
      u += best_length(u, over, step, spring) * step;
    }
    u = best_u;
    return best <= 1e-10;
  }

 private:
  static constexpr int together = 8;  // nodes that are summed up at a time
  static KnownShapes& known_shapes() {
    static KnownShapes known;
    return known;
  }
  int padded_modes() const { return static_cast<int>(nodes_->rows.rows()); }

  std::shared_ptr<const NodeShapes> nodes_;
  std::vector<double> stiffness_, load_;
  Eigen::VectorXd faces_;  // overlap of the faces alone
};

/// Settles on springs that are stiffened to `spring`. Nothing when it does not.
std::optional<Eigen::VectorXd> settle(const Potential& potential, double spring, Shift shift) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(potential.modes());
  for (double soft = 1e-10; soft < 0.5; soft *= 10)
    if (!potential.minimise(u, soft * spring, shift)) return std::nullopt;
  if (!potential.minimise(u, spring, shift)) return std::nullopt;
  return u;
}

}  // namespace

ModalStart make_start(const Model& model) {
  const int modes2 = static_cast<int>(model.resonator.modes.size());
  const int modes1 = static_cast<int>(model.slider.modes.size());
  const bool multipliers = model.scene.contact.law == ContactLaw::multiplier;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(modes2 + modes1), forces;
  Eigen::VectorXd overlap;  // without multipliers
  if (model.scene.initial == Initial::statics && u.size() > 0) {
    const Potential potential(model);
    std::optional<Eigen::VectorXd> settled;
    if (!multipliers)
      for (const Shift shift : {Shift::common, Shift::own})
        if (!settled) settled = settle(potential, model.node_stiffness, shift);
    if (settled) {
      u = *settled;
    } else {
      const auto rest = solve(potential.program(multipliers ? 0.0 : 1 / model.node_stiffness));
      if (!rest || !rest->feasible)
        throw refusal(
            model.scene, "scene.initial",
            fmt::format(
                "\"static\", and {} under this load and contact. {}",
                rest ? "no displacement of the kept modes keeps the faces apart: there is no "
                       "static equilibrium"
                     : "no static equilibrium was found",
                multipliers ? "Widen scene.gap, or keep more modes (max_frequency)"
                            : "Start from \"rest\", or lower contact.stiffness"));
      u = rest->u;
      forces = rest->forces;
    }
    if (!multipliers) overlap = potential.overlap_by_modes(u);
  } else if (!multipliers) {
    const std::vector<double> faces = overlaps(model, {}, {});
    overlap = Eigen::Map<const Eigen::VectorXd>(faces.data(), model.nodes());
  }
  ModalStart start;
  start.resonator_u.assign(u.data(), u.data() + modes2);
  start.slider_u.assign(u.data() + modes2, u.data() + modes2 + modes1);
  start.resonator_v.assign(modes2, 0.0);
  start.slider_v.assign(modes1, 0.0);
  const auto elastic = [](const Beam& beam, const std::vector<double>& amplitude) {
    double sum = 0;
    for (std::size_t k = 0; k < amplitude.size(); ++k) {
      const double stretch = beam.modes[k].omega * amplitude[k];
      sum += 0.5 * beam.mass_per_length * stretch * stretch;
    }
    return sum;
  };
  start.energy =
      elastic(model.resonator, start.resonator_u) + elastic(model.slider, start.slider_u);
  if (multipliers) {
    for (int n = 0; n < forces.size(); ++n)
      if (forces[n] > 0) start.loaded_nodes.push_back(n);
    start.contact_force = forces.sum();
    return start;
  }
  for (int n = 0; n < model.nodes(); ++n) {
    if (overlap[n] < 0) continue;
    start.loaded_nodes.push_back(n);
    start.contact_force += model.node_stiffness * overlap[n];
    start.contact_energy += 0.5 * model.node_stiffness * overlap[n] * overlap[n];
  }
  start.energy += start.contact_energy;
  return start;
}

}  // namespace ra2d
