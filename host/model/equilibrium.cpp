// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <list>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "host/base/decompositions.hpp"
#include "host/base/errors.hpp"
#include "host/model/contact_program.hpp"
#include "host/model/model.hpp"
#include "host/model/smooth_contact.hpp"
#include "kernels/tables.hpp"

/// Static equilibrium under load and contact: the minimum of the convex potential
///   sum_k m omega_k^2 U_k^2 / 2 - load_k U_k  +  sum_n kappa chi w max(0, -g_n)^2 / 2,
/// by Newton's method on its piecewise quadratic form. The contact springs are stiffened step by
/// step to their full stiffness, each step starting from the one before: a slider first settles as
/// a whole, then onto its two or three highest asperities.
///
/// Springs that are too stiff for that (roundings of an overlap are then forces) and multipliers
/// are solved as a quadratic programme (host/model/contact_program.hpp).
namespace ra2d {
namespace {

/// How Newton's Hessian is kept regular: by one stiffness for all modes, or by a share of each
/// mode's own stiffness, where the share of stiff modes would exceed what holds the rigid ones.
enum class Shift { common, own };

/// The few nodes that overlap anywhere on a line u + length step.
class OverlapsAlong {
 public:
  /// `at`: overlaps of all nodes at u [m]; `change`: how they change over a step [m].
  OverlapsAlong(const Eigen::VectorXd& at, const Eigen::VectorXd& change)
      : all_at_{at}, all_change_{change}, at_(at.size()), change_(at.size()) {}

  /// sum_n max(0, overlap_n) change_n at a length >= 0 [m^2].
  double sum(double length) {
    if (length > listed_to_) find(length);
    return (at_.head(count_) + length * change_.head(count_))
        .cwiseMax(0.0)
        .dot(change_.head(count_));
  }

 private:
  const Eigen::VectorXd &all_at_, &all_change_;
  Eigen::VectorXd at_, change_;  // of the first `count_`
  Eigen::Index count_ = 0;
  double listed_to_ = -1;  // they are all that overlap up to this length

  /// A node that overlaps at neither end of a stretch overlaps nowhere within. Nodes are kept or
  /// dropped in blocks as wide as the sum's, so that the sum has the order of the one over all.
  void find(double length) {
    constexpr Eigen::Index block = 16;
    count_ = 0;
    for (Eigen::Index n = 0; n < all_at_.size(); n += block) {
      const Eigen::Index size = std::min(block, all_at_.size() - n);
      const auto at = all_at_.segment(n, size), change = all_change_.segment(n, size);
      if (!(at.maxCoeff() > 0 || (at + length * change).maxCoeff() > 0)) continue;
      at_.segment(count_, size) = at;
      change_.segment(count_, size) = change;
      count_ += size;
    }
    listed_to_ = length;
  }
};

constexpr int pack = 8;  // modes that are summed up at a time

/// The shapes of the modes of both bodies at some nodes, in ascending order, at t = 0.
struct NodeShapes {
  Eigen::MatrixXd shapes;  // (node, mode)
  Eigen::MatrixXd rows;    // (mode, padded to packs; node)
  Eigen::VectorXd sizes;   // of each node, the sum over the modes of |shape|

  NodeShapes(const Model& model, const std::vector<int>& nodes) {
    const auto modes =
        static_cast<Eigen::Index>(model.resonator.modes.size() + model.slider.modes.size());
    const auto count = static_cast<Eigen::Index>(nodes.size());
    const double chi = model.scene.spacing;
    shapes.resize(count, modes);
    for (Eigen::Index i = 0; i < count; ++i) {
      const int n = nodes[static_cast<std::size_t>(i)];
      const int along = n % model.row_nodes();
      const double eta = model.eta(n / model.row_nodes());
      int column = 0;
      for (const BodyMode& mode : model.resonator.modes)
        shapes(i, column++) = shape_at(mode, (model.position + along) * chi, model.side + eta);
      for (const BodyMode& mode : model.slider.modes)
        shapes(i, column++) = shape_at(mode, along * chi, eta);
    }
    rows = Eigen::MatrixXd::Zero((modes + pack - 1) / pack * pack, count);
    rows.topRows(modes) = shapes.transpose();
    sizes = Eigen::VectorXd::Zero(count);
    for (Eigen::Index k = 0; k < modes; ++k) sizes += shapes.col(k).cwiseAbs();
  }
};

/// Shapes of the last plane scenes, at all nodes. The runs of a study mostly have equal bodies, and
/// shapes take a sine for every node and mode.
class ShapeCache {
 public:
  std::shared_ptr<const NodeShapes> of(const Model& model, const std::vector<int>& nodes) {
    if (model.is_areal) return std::make_shared<const NodeShapes>(model, nodes);
    const Key key = key_of(model);
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [cached, shapes] : cache_)
        if (cached == key) return shapes;
    }
    const auto shapes = std::make_shared<const NodeShapes>(model, nodes);
    const std::lock_guard lock(mutex_);
    if (shapes->shapes.size() > most_values) return shapes;
    cache_.emplace_front(key, shapes);
    if (cache_.size() > most) cache_.pop_back();
    return shapes;
  }

 private:
  static constexpr std::size_t most = 4;
  static constexpr Eigen::Index most_values = 1 << 20;  // larger ones take too much memory

  using Key = std::vector<double>;  // all that the shapes depend on
  static Key key_of(const Model& model) {
    Key key{model.scene.spacing, model.position, static_cast<double>(model.nodes())};
    for (const Body* body : {&model.resonator, &model.slider}) {
      key.push_back(static_cast<double>(body->modes.size()));
      for (const BodyMode& mode : body->modes) mode.shape->append_parameters(key);
    }
    return key;
  }
  std::mutex mutex_;
  std::list<std::pair<Key, std::shared_ptr<const NodeShapes>>> cache_;
};

/// All nodes of a scene.
std::vector<int> all_nodes(const Model& model) {
  std::vector<int> nodes(static_cast<std::size_t>(model.nodes()));
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

/// Of a scene with no other nodes than these. `faces`: overlaps of all its nodes without the modes
/// [m].
class Potential {
 public:
  explicit Potential(const Model& model)
      : Potential(model, all_nodes(model), overlaps(model, {}, {})) {}
  Potential(const Model& model, const std::vector<int>& nodes, const std::vector<double>& faces)
      : nodes_{shape_cache().of(model, nodes)}, faces_(static_cast<Eigen::Index>(nodes.size())) {
    for (const Body* body : {&model.resonator, &model.slider}) {
      for (const BodyMode& mode : body->modes)
        stiffness_.push_back(mode.mass * mode.omega * mode.omega);
      load_.insert(load_.end(), body->load.begin(), body->load.end());
    }
    for (std::size_t i = 0; i < nodes.size(); ++i)
      faces_[static_cast<Eigen::Index>(i)] = faces[static_cast<std::size_t>(nodes[i])];
  }

  /// The minimum as a quadratic programme. `compliance` of the springs in m/N.
  ContactProgram program(double compliance) const {
    return {.stiffness = Eigen::Map<const Eigen::VectorXd>(stiffness_.data(), modes()),
            .load = Eigen::Map<const Eigen::VectorXd>(load_.data(), modes()),
            .shapes = nodes_->shapes,
            .faces = faces_,
            .compliance = compliance};
  }

  int modes() const { return static_cast<int>(stiffness_.size()); }
  Eigen::VectorXd overlap(const Eigen::VectorXd& u) const { return faces_ + nodes_->shapes * u; }
  /// Overlaps summed mode by mode, as overlaps() (host/model/model.hpp) does.
  Eigen::VectorXd overlap_by_modes(const Eigen::VectorXd& u) const {
    Eigen::VectorXd sum = faces_;
    for (int k = 0; k < modes(); ++k)
      if (u[k] != 0.0) sum += u[k] * nodes_->shapes.col(k);
    return sum;
  }

  /// Negative gradient and the size of the terms that it is made of, where the nodes `touching`
  /// overlap, as all do by `over`.
  void expand(const Eigen::VectorXd& u, const Eigen::VectorXd& over,
              const std::vector<int>& touching, double spring, Eigen::VectorXd& force,
              double& scale) const {
    force.resize(modes());
    scale = 0;
    for (int k = 0; k < modes(); ++k) {
      force[k] = load_[k] - stiffness_[k] * u[k];
      scale += std::abs(load_[k]) + std::abs(stiffness_[k] * u[k]);
    }
    for (const int n : touching) {
      force -= spring * over[n] * nodes_->rows.col(n).head(modes());
      scale += spring * over[n] * nodes_->sizes[n];
    }
  }

  /// The Hessian's lower triangle where these nodes overlap. By packs of modes; entries above the
  /// diagonal in its own pack are computed in vain. Each sum adds one node after the other, a block
  /// of nodes between two accesses to memory.
  Eigen::MatrixXd hessian(const std::vector<int>& touching, double spring) const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(padded_modes(), modes());
    for (int k = 0; k < modes(); ++k) sum(k, k) = stiffness_[k];
    Eigen::Matrix<double, Eigen::Dynamic, block> weighted(padded_modes(), int{block});
    for (std::size_t first = 0; first < touching.size(); first += block) {
      const int* const nodes = touching.data() + first;
      const int count = static_cast<int>(std::min<std::size_t>(block, touching.size() - first));
      for (int e = 0; e < count; ++e) weighted.col(e) = spring * nodes_->rows.col(nodes[e]);
      for (int k = 0; k < modes(); ++k)
        for (int i = k / pack * pack; i < padded_modes(); i += pack) {
          Eigen::Matrix<double, pack, 1> part = sum.col(k).segment<pack>(i);
          for (int e = 0; e < count; ++e)
            part += nodes_->rows(k, nodes[e]) * weighted.col(e).segment<pack>(i);
          sum.col(k).segment<pack>(i) = part;
        }
    }
    return sum.topRows(modes());
  }

  /// That matrix, kept regular. The shift keeps directions finite that nothing holds: a slider on
  /// one asperity may tilt. A mode that nothing holds yet takes a share of the springs of all
  /// nodes.
  Eigen::MatrixXd regular_hessian(const std::vector<int>& touching, double spring,
                                  Shift shift) const {
    Eigen::MatrixXd sum = hessian(touching, spring);
    const double most = sum.diagonal().maxCoeff();
    for (int k = 0; k < modes(); ++k) {
      const double own = sum(k, k) > 0 ? sum(k, k) : spring * nodes_->shapes.col(k).squaredNorm();
      sum(k, k) += 1e-14 * (shift == Shift::common && most > 0 ? most : own) + 1e-300;
    }
    return sum;
  }

  /// The length along `step` at which the potential is least, from the sign of its slope: the
  /// slope, unlike the value, is exact to the last digits. It never falls, since the potential is
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
    double best =
        std::numeric_limits<double>::infinity();  // residual over the forces it is made of
    int stalled = 0;
    std::vector<Eigen::VectorXd> seen;
    std::vector<int> touching, held;
    std::optional<SymmetricSolver> newton;  // with the springs of the nodes `held`
    for (int round = 0; round < 1000 && stalled < 30; ++round) {
      // a round depends on u alone: from here on they would repeat
      if (std::find(seen.begin(), seen.end(), u) != seen.end()) break;
      seen.push_back(u);
      double scale = 0;
      const Eigen::VectorXd over = overlap(u);
      touching.clear();
      for (int n = 0; n < over.size(); ++n)
        if (over[n] > 0) touching.push_back(n);
      expand(u, over, touching, spring, force, scale);
      const double residual = scale > 0 ? force.lpNorm<Eigen::Infinity>() / scale : 0.0;
      ++stalled;
      if (residual < best) {
        if (residual < 0.5 * best) stalled = 0;
        best = residual;
        best_u = u;
      }
      if (best <= 1e-16) break;
      if (!newton || touching != held) {
        newton.emplace(regular_hessian(touching, spring, shift));
        held = touching;
      }
      const Eigen::VectorXd step = newton->solve(force);
      u += best_length(u, over, step, spring) * step;
    }
    u = best_u;
    return best <= 1e-10;
  }

 private:
  static constexpr int block = 8;  // nodes summed at a time
  static ShapeCache& shape_cache() {
    static ShapeCache cache;
    return cache;
  }
  int padded_modes() const { return static_cast<int>(nodes_->rows.rows()); }

  std::shared_ptr<const NodeShapes> nodes_;
  std::vector<double> stiffness_, load_;
  Eigen::VectorXd faces_;  // overlap of the faces alone
};

/// Settles on springs that are stiffened to `spring`. Nothing when it does not.
std::optional<Eigen::VectorXd> settled_bodies(const Potential& potential, double spring,
                                              Shift shift) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(potential.modes());
  for (double soft = 1e-10; soft < 0.5; soft *= 10)
    if (!potential.minimise(u, soft * spring, shift)) return std::nullopt;
  if (!potential.minimise(u, spring, shift)) return std::nullopt;
  return u;
}

/// Displacements at rest, and what the contact has there: overlaps under penalty, forces where the
/// quadratic programme was solved.
struct Rest {
  Eigen::VectorXd u, overlap, forces;
};

constexpr const char* no_rest =
    "no displacement of the kept modes keeps the faces apart: there is no static equilibrium";

RequestError no_equilibrium(const Scene& scene, const std::string& why) {
  return refusal(
      scene, "scene.initial",
      fmt::format("\"static\", and {} under this load and contact. {}", why,
                  scene.contact.law == ContactLaw::multiplier
                      ? "Widen scene.gap, or keep more modes (max_frequency)"
                      : "Start from \"rest\", or change scene.gap or contact.stiffness"));
}

RequestError too_many_touch(const Scene& scene, std::int64_t nodes) {
  return refusal(scene, "scene.spacing",
                 fmt::format("at the start {} nodes touch at once, and {} can be followed: coarsen "
                             "spacing and spacing_y, or let less touch (load, gap)",
                             nodes, int{most_areal_nodes}));
}

/// `guess`: displacements near the answer; empty: none.
Rest find_equilibrium(const Model& model, const Potential& potential,
                      const Eigen::VectorXd& guess = {}) {
  const bool multipliers = model.scene.contact.law == ContactLaw::multiplier;
  std::optional<Eigen::VectorXd> settled;
  if (!multipliers && guess.size() > 0)
    if (Eigen::VectorXd u = guess; potential.minimise(u, model.node_stiffness, Shift::common))
      settled = u;
  if (!multipliers)
    for (const Shift shift : {Shift::common, Shift::own})
      if (!settled) settled = settled_bodies(potential, model.node_stiffness, shift);
  Rest rest;
  if (settled) {
    rest.u = *settled;
  } else {
    const auto solved = solve(potential.program(multipliers ? 0.0 : 1 / model.node_stiffness));
    if (!solved || !solved->feasible)
      throw no_equilibrium(model.scene, solved ? no_rest : "no static equilibrium was found");
    rest.u = solved->u;
    rest.forces = solved->forces;
  }
  if (!multipliers) rest.overlap = potential.overlap_by_modes(rest.u);
  return rest;
}

/// Overlaps of all nodes of an areal scene at the displacements u [m], to a few roundings of what
/// overlaps() gives: a shape along x is found once for all rows.
class RowOverlaps {
 public:
  RowOverlaps(const Model& model, const std::vector<double>& faces) : model_{model}, faces_{faces} {
    const double chi = model.scene.spacing;
    along_.resize(model.row_nodes(), modes());
    across_.resize(modes(), model.rows);
    Eigen::Index k = 0;
    for (const Body* body : {&model.resonator, &model.slider}) {
      const bool slides = body == &model.slider;
      for (const BodyMode& mode : body->modes) {
        for (int i = 0; i < model.row_nodes(); ++i)
          along_(i, k) = shape_at(mode, (slides ? i : model.position + i) * chi);
        for (int row = 0; row < model.rows; ++row)
          mode.shape->evaluate_across((slides ? 0.0 : model.side) + model.eta(row), 1,
                                      &across_(k, row));
        ++k;
      }
    }
  }
  Eigen::VectorXd operator()(const Eigen::VectorXd& u) const {
    Eigen::VectorXd over(model_.nodes());
    const Eigen::Index length = model_.row_nodes();
    for (int row = 0; row < model_.rows; ++row)
      over.segment(row * length, length) =
          Eigen::Map<const Eigen::VectorXd>(faces_.data() + row * length, length) +
          along_ * across_.col(row).cwiseProduct(u);
    return over;
  }

 private:
  const Model& model_;
  const std::vector<double>& faces_;
  Eigen::MatrixXd along_;   // (node of a row, mode)
  Eigen::MatrixXd across_;  // (mode, row)

  Eigen::Index modes() const {
    return static_cast<Eigen::Index>(model_.resonator.modes.size() + model_.slider.modes.size());
  }
};

/// The node of the highest overlap in each of some 4000 tiles, in ascending order.
std::vector<int> highest_of_tiles(const Model& model, const std::vector<double>& over) {
  constexpr double most = 4096;
  const int size =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(model.nodes()) / most)));
  const int tiles = (model.row_nodes() + size - 1) / size, bands = (model.rows + size - 1) / size;
  std::vector<int> nodes(static_cast<std::size_t>(tiles) * bands, -1);
  for (int n = 0; n < model.nodes(); ++n) {
    int& highest = nodes[static_cast<std::size_t>(n / model.row_nodes() / size) * tiles +
                         n % model.row_nodes() / size];
    if (highest < 0 || over[n] > over[highest]) highest = n;
  }
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

/// The cells at these nodes, by their left nodes.
std::vector<int> highest_cells(const Model& model) {
  std::vector<int> cells = highest_of_tiles(model, overlaps(model, {}, {}));
  for (int& n : cells)
    if (n % model.row_nodes() == model.row_nodes() - 1) --n;
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

/// Of millions of nodes few carry force. The equilibrium with some of them is that with all, where
/// no other overlaps; those that do are taken in.
Rest find_areal_equilibrium(const Model& model) {
  constexpr int rounds = 100;
  const std::vector<double> faces = overlaps(model, {}, {});
  const RowOverlaps all_at(model, faces);
  std::vector<int> nodes = highest_of_tiles(model, faces);
  Eigen::VectorXd guess;
  for (int round = 0; round < rounds; ++round) {
    const Rest some = find_equilibrium(model, Potential(model, nodes, faces), guess);
    guess = some.u;
    Rest rest{some.u, all_at(some.u), {}};
    for (std::size_t i = 0; i < nodes.size(); ++i)  // each node once
      if (some.overlap.size() > 0)
        rest.overlap[nodes[i]] = some.overlap[static_cast<Eigen::Index>(i)];
    std::vector<char> is_in(static_cast<std::size_t>(model.nodes()), 0);
    for (const int n : nodes) is_in[static_cast<std::size_t>(n)] = 1;
    std::vector<int> missing;
    for (int n = 0; n < model.nodes(); ++n)
      if (!is_in[static_cast<std::size_t>(n)] && rest.overlap[n] > 0) missing.push_back(n);
    if (missing.empty()) {
      if (some.forces.size() == 0) return rest;
      rest.forces = Eigen::VectorXd::Zero(model.nodes());
      for (std::size_t i = 0; i < nodes.size(); ++i)
        rest.forces[nodes[i]] = some.forces[static_cast<Eigen::Index>(i)];
      return rest;
    }
    const std::size_t most_taken = nodes.size();  // at a time: the bodies still sink too deep
    if (nodes.size() > 2 * std::size_t{most_areal_nodes})
      throw too_many_touch(model.scene, (rest.overlap.array() >= 0).count());
    if (missing.size() > most_taken) {
      std::nth_element(missing.begin(), missing.begin() + static_cast<std::ptrdiff_t>(most_taken),
                       missing.end(),
                       [&](int a, int b) { return rest.overlap[a] > rest.overlap[b]; });
      missing.resize(most_taken);
    }
    nodes.insert(nodes.end(), missing.begin(), missing.end());
    std::sort(nodes.begin(), nodes.end());
  }
  throw no_equilibrium(model.scene, "no static equilibrium was found");
}

double elastic_energy(const Body& body, const std::vector<double>& amplitude) {
  double sum = 0;
  for (std::size_t k = 0; k < amplitude.size(); ++k) {
    const double stretch = body.modes[k].omega * amplitude[k];
    sum += 0.5 * body.modes[k].mass * stretch * stretch;
  }
  return sum;
}

/// The equilibrium of contact at the nodes alone, which is not far from that of smooth faces; empty
/// where it is not found.
std::vector<double> settled_nodes(const Model& model) {
  std::optional<Eigen::VectorXd> u;
  try {
    u = model.is_areal ? find_areal_equilibrium(model).u
                       : settled_bodies(Potential(model), model.node_stiffness, Shift::common);
  } catch (const RequestError&) {  // of straight faces: those of this scene are not
  }
  return u ? std::vector<double>(u->data(), u->data() + u->size()) : std::vector<double>();
}

/// Static equilibrium, or the bodies at rest, and the contact there, between smooth faces.
Eigen::VectorXd smooth_start(const Model& model, ModalStart& start) {
  const std::size_t modes = model.resonator.modes.size() + model.slider.modes.size();
  const bool multipliers = model.scene.contact.law == ContactLaw::multiplier;
  std::vector<double> u(modes, 0.0);
  const char* const not_found = "no static equilibrium was found";
  if (model.scene.initial == Initial::statics && modes > 0) {
    std::vector<int> first;
    if (model.is_areal) first = highest_cells(model);
    if (multipliers) {
      const std::optional<SmoothRest> rest = smooth_rest(model, first);
      if (!rest || !rest->feasible) throw no_equilibrium(model.scene, rest ? no_rest : not_found);
      u = rest->u;
      start.contact_force = rest->force;
      start.loaded_nodes = rest->cells;
    } else {
      const std::optional<std::vector<double>> settled =
          smooth_equilibrium(model, settled_nodes(model), first);
      if (!settled) throw no_equilibrium(model.scene, not_found);
      u = *settled;
    }
  }
  if (!multipliers) {
    SmoothContact contact = smooth_contact(model, u);
    start.contact_force = contact.force;
    start.contact_energy = contact.energy;
    start.loaded_nodes = std::move(contact.cells);
  }
  return Eigen::Map<const Eigen::VectorXd>(u.data(), static_cast<Eigen::Index>(u.size()));
}

ModalStart find_start(const Model& model) {
  const auto modes2 = static_cast<Eigen::Index>(model.resonator.modes.size());
  const auto modes1 = static_cast<Eigen::Index>(model.slider.modes.size());
  const bool multipliers = model.scene.contact.law == ContactLaw::multiplier;
  ModalStart start;
  Rest rest{Eigen::VectorXd::Zero(modes2 + modes1), {}, {}};
  if (model.has_smooth_faces()) {
    rest.u = smooth_start(model, start);
  } else if (model.scene.initial == Initial::statics && rest.u.size() > 0) {
    rest =
        model.is_areal ? find_areal_equilibrium(model) : find_equilibrium(model, Potential(model));
  } else if (!multipliers) {
    const std::vector<double> faces = overlaps(model, {}, {});
    rest.overlap = Eigen::Map<const Eigen::VectorXd>(faces.data(), model.nodes());
  }
  start.resonator_u.assign(rest.u.data(), rest.u.data() + modes2);
  start.slider_u.assign(rest.u.data() + modes2, rest.u.data() + modes2 + modes1);
  start.resonator_v.assign(modes2, 0.0);
  start.slider_v.assign(modes1, 0.0);
  start.energy = elastic_energy(model.resonator, start.resonator_u) +
                 elastic_energy(model.slider, start.slider_u);
  if (model.has_smooth_faces()) {
    start.energy += start.contact_energy;
    return start;
  }
  if (multipliers) {
    for (int n = 0; n < rest.forces.size(); ++n)
      if (rest.forces[n] > 0) start.loaded_nodes.push_back(n);
    start.contact_force = rest.forces.sum();
    return start;
  }
  for (int n = 0; n < model.nodes(); ++n) {
    if (rest.overlap[n] < 0) continue;
    start.loaded_nodes.push_back(n);
    start.contact_force += model.node_stiffness * rest.overlap[n];
    start.contact_energy += 0.5 * model.node_stiffness * rest.overlap[n] * rest.overlap[n];
  }
  start.energy += start.contact_energy;
  return start;
}

}  // namespace

ModalStart make_start(const Model& model) {
  ModalStart start = find_start(model);
  if (model.is_areal && start.loaded_nodes.size() > std::size_t{most_areal_nodes})
    throw too_many_touch(model.scene, static_cast<std::int64_t>(start.loaded_nodes.size()));
  return start;
}

}  // namespace ra2d
