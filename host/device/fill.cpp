// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/fill.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/device/collocation_tables.hpp"
#include "host/device/flight_tables.hpp"
#include "host/device/footprint_tables.hpp"
#include "host/device/gauss.hpp"
#include "host/device/lobatto.hpp"
#include "host/model/bounds.hpp"
#include "host/model/step_bounds.hpp"
#include "host/scene/schemes.hpp"
#include "kernels/limits.hpp"

namespace ra2d {
namespace {

/// C(i, j)/C(n, j), row j, for i <= n; what is beyond repeats the last and is masked out of the
/// first and second differences (kernels/adaptive/crossing.hpp).
void fill_hull(double* table, int n) {
  for (int i = 0; i < overlap_terms; ++i) {
    const int last = std::min(i, n);
    double share = 1.0;
    for (int j = 0; j <= last; ++j) {
      table[j * overlap_terms + i] = share;
      share *= static_cast<double>(last - j) / std::max(1, n - j);
    }
    double* mask = table + overlap_terms * overlap_terms + i;
    mask[0] = i < n ? 1.0 : 0.0;
    mask[overlap_terms] = i < n - 1 ? 1.0 : 0.0;
  }
}

/// Steps over which bounds on the modes are of use. Beyond its limit a scheme lets them grow within
/// more steps to many times what the motion is.
int count_valid_steps(const Model& model) {
  const SchemeTable& scheme = scheme_table(model.scene.time.scheme);
  const double tau = model.scene.time.step;
  const auto grows = [&](int steps) {
    for (const Body* body : {&model.resonator, &model.slider})
      for (const BodyMode& mode : body->modes) {
        if (bound_step(mode, scheme.prepare(mode, tau), scheme.place, tau, steps).growth > 2.0)
          return true;
      }
    return false;
  };
  int steps = longest_flight;
  while (steps > 16 && grows(steps)) steps /= 2;
  return steps;
}

/// Parts of a node's width so narrow that a cubic over one, off by beta^4 (width/2)^4/4!, is right
/// to two ulp, or far below the asked tolerance. Between smooth faces each part ends a step.
int count_windows(const Model& model) {
  const Scene& scene = model.scene;
  double left_out = 0x1p-51;
  if (is_adaptive(scene)) {
    const double tolerance = scene.time.tolerance.value_or(usual_tolerance);
    double most = 1e-13;
    if (model.has_smooth_faces()) most = std::clamp(1e-5 * tolerance, most, 1e-11);
    left_out = std::clamp(1e-4 * tolerance, left_out, most);
  }
  return static_cast<int>(
      std::ceil(std::max(1.0, 0.5 * highest_wave_number(model.resonator) * scene.spacing /
                                  std::pow(24 * left_out, 0.25))));
}

/// Whether a cell's cubics of the modes' shapes do for the cells beside it, too: off there by a
/// hundredth of what a step's error may be.
bool neighbours_share(const Model& model) {
  const double beta =
      std::max(highest_wave_number(model.resonator), highest_wave_number(model.slider));
  const double farthest = 1.5 + 0.5 / count_windows(model);  // chi, from the cubics' middle
  return std::pow(beta * model.scene.spacing * farthest, 4) / 24 <=
         1e-3 * model.scene.time.tolerance.value_or(usual_tolerance);
}

/// One mode of either body, on its lane.
struct ModeOnLane {
  int lane;
  const Mode& oscillator;
  const ModeShape& shape;
  double load;         // N m^(-1/2)
  bool of_resonator;   // its nodes move
  double largest;      // m^(-1/2), max |psi|
  double outer_force;  // N m^(-1/2), bound on the modal forces that do not come from contact
};

/// Fills the tables of one scene, part by part.
class Filler {
 public:
  Filler(SceneTables& tables, const Model& model, const PatchSeries& series, const Extents& n,
         const HostCopy& host)
      : tables_{tables},
        model_{model},
        scene_{model.scene},
        n_{n},
        host_{host},
        radius_{series.radius(model, n.width)} {
    tables_.patches.nodes = series.patch_nodes;
    tables_.patches.terms = series.terms;
  }

  void numbers();
  void scheme();
  void modes();
  void patches();
  void slider_shapes();
  void across();
  void faces();
  void tiles();
  void tile_variation(const ModeOnLane& mode);
  void smooth_faces(const double* h2);
  void adaptive();
  void clusters();
  void moving_forces();

 private:
  SceneTables& tables_;
  const Model& model_;
  const Scene& scene_;
  const Extents& n_;
  HostCopy host_;
  double radius_;                               // m, of a patch's series
  std::vector<double> acceleration_per_force_;  // of each mode: StepBounds

  void step_of(const ModeOnLane& mode);
  void bounds_per_newton();
  void flight_of(const ModeOnLane& mode);
};

void Filler::numbers() {
  tables_.slider.first_lane = static_cast<int>(model_.resonator.modes.size());
  tables_.slider.modes = static_cast<int>(model_.slider.modes.size());
  tables_.modes.count = tables_.slider.first_lane + tables_.slider.modes;
  tables_.slider.row = static_cast<int>(n_.padded_row());
  tables_.faces.nodes = n_.nodes;
  tables_.faces.groups = n_.groups;
  if (model_.is_areal) {
    tables_.faces.rows.nodes = n_.row_nodes;
    tables_.faces.rows.length = tables_.slider.row;
    tables_.faces.rows.groups = n_.row_groups;
    tables_.faces.rows.excess = n_.row_heights - tables_.slider.row;
    tables_.faces.rows.behind = n_.behind;
    tables_.faces.tiles.groups = n_.tile_groups();
    tables_.faces.tiles.count = n_.tiles();
    tables_.faces.tiles.row = n_.padded_tiles();
    tables_.faces.tiles.bands = n_.bands();
    tables_.faces.tiles.strip = n_.strip();
    tables_.faces.tiles.column_row = n_.column_row();
    tables_.faces.tiles.column_strip = n_.column_strip();
  }
  tables_.faces.smooth = n_.smooth;
  tables_.patches.count = n_.patches;
  tables_.flight.levels = n_.flight_levels;
  tables_.flight.elastic_packs = n_.lanes / n_.width;
  tables_.patches.inverse_nodes = 1.0 / tables_.patches.nodes;
  tables_.forces.count = n_.moving_forces;
  tables_.bounds.searched = scene_.time.nodes;
  tables_.scheme.form = form_of(scene_);
  tables_.motion.position = model_.position;
  tables_.motion.advance = model_.advance;
  tables_.motion.spacing = scene_.spacing;
  tables_.motion.time_step = model_.tick;
  tables_.patches.inverse_radius = scene_.spacing / radius_;
  // the polynomials of squares of nodes reach over a whole spacing (cluster_remainder)
  tables_.motion.windows =
      n_.cluster_degree > 0 && !is_adaptive(scene_) ? 1 : count_windows(model_);
  tables_.motion.window_width = 1.0 / tables_.motion.windows;
  tables_.forces.resonator_length = scene_.resonator.length;
  tables_.contact.node_stiffness = model_.node_stiffness;
  tables_.contact.compliance =
      scene_.contact.law == ContactLaw::multiplier ? 0.0 : 1.0 / model_.node_stiffness;
  tables_.output.total_steps = model_.steps;
  tables_.output.counted_from = first_counted(model_);
  tables_.output.steps_per_sample = model_.steps_per_sample;
  tables_.output.samples = model_.samples;
}

void Filler::scheme() {
  if (is_adaptive(scene_)) return;
  const SchemeTable& scheme = scheme_table(scene_.time.scheme);
  tables_.scheme.stages = scheme.stages;
  std::copy_n(scheme.place, scheme.stages, tables_.scheme.place);
  for (int i = 1; i < tables_.scheme.stages; ++i) tables_.scheme.stage_row[i] = first_stage_row(i);
  tables_.scheme.velocity_lag = scheme.velocity_lag;
  // lanes without a mode, too: ModesStep::lag divides by it
  std::fill_n(host_(tables_.scheme.end) + end_now_mean * n_.lanes, n_.lanes, 1.0);
  tables_.scheme.loss_ends = is_semi_implicit(scene_.time.scheme) ? 0.0 : 0.5;
  tables_.bounds.valid_steps = count_valid_steps(model_);
}

void Filler::modes() {
  double moving = 0;  // N
  for (const MovingForce& f : scene_.resonator.moving_forces) moving += std::abs(f.force);
  double supplied = 0;  // J, by the outer forces within a step from rest
  // m/s: multipliers part faces at once, also those that overlap by roundings, at many steps
  const double rounding =
      scene_.contact.law == ContactLaw::multiplier
          ? 100 * std::numeric_limits<double>::epsilon() * largest_height(model_) / model_.tick
          : 0.0;
  double of_roundings = 0;  // J
  int lane = 0;
  for (const Body* body : {&model_.resonator, &model_.slider})
    for (std::size_t k = 0; k < body->modes.size(); ++k, ++lane) {
      const Mode& oscillator = body->modes[k];
      const ModeShape& shape = *body->modes[k].shape;
      const bool of_resonator = body == &model_.resonator;
      const double largest = shape.size();
      const ModeOnLane mode{lane,
                            oscillator,
                            shape,
                            body->load[k],
                            of_resonator,
                            largest,
                            std::abs(body->load[k]) + (of_resonator ? moving * largest : 0.0)};
      host_(tables_.modes.load)[lane] = mode.load;
      host_(tables_.modes.mass)[lane] = oscillator.mass;
      host_(tables_.modes.omega)[lane] = oscillator.omega;
      host_(tables_.modes.damping)[lane] =
          2.0 * oscillator.zeta * oscillator.omega * oscillator.mass * model_.tick;
      host_(tables_.bounds.largest_shape)[lane] = largest;
      if (model_.is_areal) tile_variation(mode);
      if (is_adaptive(scene_))
        flight_of(mode);
      else
        step_of(mode);
      supplied += 0.5 * std::pow(model_.tick * mode.outer_force, 2) / oscillator.mass;
      of_roundings += 0.5 * oscillator.mass * std::pow(rounding / largest, 2);
      if (n_.smooth) {
        const double eighth = 0.125 * scene_.spacing * scene_.spacing;
        host_(tables_.bounds.cell_sag)[lane] =
            eighth * shape.largest_curvature(of_resonator ? 2 * radius_ : 0.0);
        tables_.faces.sag_per_travel =
            std::max(tables_.faces.sag_per_travel, eighth * std::pow(shape.wave_number(), 2));
      }
      if (!of_resonator) continue;
      // a patch may reach beyond the end of the body
      const CubicRemainder remainder = shape.cubic_remainder(radius_);
      host_(tables_.bounds.largest_slope)[lane] = shape.largest_slope(2 * radius_);
      host_(tables_.bounds.largest_curvature)[lane] = shape.largest_curvature(2 * radius_);
      host_(tables_.bounds.cubic_remainder)[lane] = remainder.value;
      host_(tables_.bounds.cubic_slope_remainder)[lane] = remainder.slope;
      host_(tables_.patches.quartic)[lane] = shape.fourth_derivative_factor(radius_);
    }
  if (!is_adaptive(scene_)) bounds_per_newton();
  // from rest the velocity is up to a step ahead of the work of these forces, or (midpoint) half a
  // step behind
  tables_.output.least_energy = 1e-30 + 4.0 * supplied + of_roundings;
}

/// The weights of a scheme of fixed steps, and the bounds that follow from them.
void Filler::step_of(const ModeOnLane& mode) {
  const SchemeTable& scheme = scheme_table(scene_.time.scheme);
  const ModeStep step = scheme.prepare(mode.oscillator, model_.tick);
  const int lane = mode.lane, lanes = n_.lanes;
  for (int i = 1; i < tables_.scheme.stages; ++i) {
    double* const rows = host_(tables_.scheme.stage) + tables_.scheme.stage_row[i] * lanes + lane;
    rows[0] = step.stage_u[i];
    rows[lanes] = step.stage_v[i];
    rows[2 * lanes] = step.held_stage(i) * mode.load;
    for (int j = 0; j < i; ++j) rows[(3 + j) * lanes] = step.stage_f[i][j];
  }
  double* const ends = host_(tables_.scheme.end) + lane;
  ends[end_u_u * lanes] = step.u_u;
  ends[end_u_v * lanes] = step.u_v;
  ends[end_u_load * lanes] = step.held_u() * mode.load;
  ends[end_v_u * lanes] = step.v_u;
  ends[end_v_v * lanes] = step.v_v;
  ends[end_v_load * lanes] = step.held_v() * mode.load;
  ends[end_now_mean * lanes] = step.now_mean;
  ends[end_now_pushed * lanes] = step.now_pushed;
  host_(tables_.modes.damping)[lane] *= step.mean_square;  // of the sums of V^2
  for (int j = 0; j < tables_.scheme.stages; ++j) {
    ends[(end_forces + 2 * j) * lanes] = step.u_f[j];
    ends[(end_forces + 2 * j + 1) * lanes] = step.v_f[j];
  }
  host_(tables_.contact.receptance)[lane] = step.held_u();
  host_(tables_.contact.mobility)[lane] = step.held_v();
  // shapes are right to some 1e-15 of their largest
  tables_.contact.least_compliance += 1e-26 * step.held_u() * std::pow(mode.largest, 2);
  const StepBounds bounds = bound_step(mode.oscillator, step, tables_.scheme.place, model_.tick,
                                       tables_.bounds.valid_steps);
  host_(tables_.bounds.acceleration_per_energy_norm)[lane] = bounds.acceleration_per_energy_norm;
  host_(tables_.bounds.outer_acceleration)[lane] = mode.outer_force * bounds.acceleration_per_force;
  acceleration_per_force_.push_back(bounds.acceleration_per_force);
}

/// Bounds on how contact forces move a node. With the weights w of the modes, by Cauchy and
/// Schwarz, sum_k w_k |psi_k(x) psi_k(y)| is at most the largest sum_k w_k psi_k(x)^2, wherever the
/// force acts and the node stands.
void Filler::bounds_per_newton() {
  MotionLimits& bounds = tables_.bounds;
  const double* const rate = host_(bounds.acceleration_per_energy_norm);
  std::size_t lane = 0;
  for (const Body* body : {&model_.resonator, &model_.slider}) {
    if (body->modes.empty()) continue;
    const BodySpec& spec = body == &model_.slider ? scene_.slider : scene_.resonator;
    std::array<std::vector<double>, 2> weights;
    for (std::size_t k = 0; k < body->modes.size(); ++k, ++lane) {
      weights[0].push_back(acceleration_per_force_[lane]);
      weights[1].push_back(rate[lane] * acceleration_per_force_[lane]);
    }
    const auto [acceleration, jerk] =
        largest_square_sums(*body, weights, model_.is_areal ? spec.width : 0.0);
    bounds.acceleration_per_newton += acceleration;
    bounds.jerk_per_newton += jerk;
  }
}

/// The closed form of free flight, and the bounds that the adaptive steps rest on.
void Filler::flight_of(const ModeOnLane& mode) {
  const Mode& oscillator = mode.oscillator;
  const int lane = mode.lane, lanes = n_.lanes;
  const double omega = oscillator.omega;
  const double passing = mode.of_resonator ? mode.shape.change_rate() * scene_.speed : 0.0;
  host_(tables_.adaptive.fastest_rate)[lane] = fastest_rate(oscillator);
  host_(tables_.adaptive.inverse_mass)[lane] = 1.0 / oscillator.mass;
  host_(tables_.adaptive.decay)[lane] = 2.0 * oscillator.zeta * omega;
  host_(tables_.adaptive.passing_rate)[lane] = passing;
  if (omega == 0.0) {
    tables_.flight.elastic_packs = std::min(tables_.flight.elastic_packs, lane / n_.width);
    host_(tables_.flight.free_acceleration)[lane] = mode.load / oscillator.mass;
    host_(tables_.flight.displacement_per_energy_norm)[lane] = 1e300;
  } else {
    const double rest = mode.load / (oscillator.mass * omega * omega);
    host_(tables_.flight.rest)[lane] = rest;
    host_(tables_.flight.displacement_per_energy_norm)[lane] = 2.0 / omega;
    host_(tables_.flight.fourth_derivative_per_energy_norm)[lane] =
        fourth_derivative(oscillator, mode.largest, passing);
    tables_.flight.fourth_derivative_at_rest +=
        mode.largest * std::pow(passing, 4) * std::abs(rest);
  }
  const auto levels = flight_tables(oscillator, mode.load, model_.tick, tables_.flight.first_level,
                                    n_.flight_levels);
  double* const flight = host_(tables_.flight.rows) + lane;
  for (int level = 0; level < n_.flight_levels; ++level)
    for (int r = 0; r < flight_rows; ++r)
      flight[(static_cast<std::size_t>(level) * flight_rows + r) * lanes] = levels[level][r];
}

/// The displacement series of the resonator's modes.
void Filler::patches() {
  double* const rows = host_(tables_.patches.derivatives);
  for (int p = 0; p < n_.patches; ++p) {
    const double centre = (p + 0.5) * tables_.patches.nodes * scene_.spacing;
    for (int k = 0; k < tables_.slider.first_lane; ++k) {
      double d[4];
      model_.resonator.modes[k].shape->evaluate(centre, 4, d);
      for (int j = 0; j < 4; ++j)
        rows[(static_cast<std::size_t>(p) * 4 + j) * n_.lanes + k] = d[j] * std::pow(radius_, j);
    }
  }
}

void Filler::slider_shapes() {
  double* const unit = host_(tables_.slider.unit);
  for (int k = 0; k < tables_.slider.modes; ++k) {
    unit[static_cast<std::size_t>(k) * n_.lanes + tables_.slider.first_lane + k] = 1.0;
    double* const shape =
        host_(tables_.slider.shape) + static_cast<std::size_t>(k) * n_.padded_row();
    for (int n = 0; n < n_.row_nodes; ++n)
      shape[n] = shape_at(model_.slider.modes[k], n * scene_.spacing);
    if (!n_.smooth) continue;
    double* const cell =
        host_(tables_.slider.cell) + 4 * static_cast<std::size_t>(k) * n_.padded_row();
    for (int n = 0; n + 1 < n_.row_nodes; ++n) {
      double d[4], unit_power = 1.0;
      model_.slider.modes[k].shape->evaluate((n + 0.5) * scene_.spacing, 4, d);
      for (int j = 0; j < 4; ++j) {
        cell[j * n_.padded_row() + n] = d[j] * unit_power;
        unit_power *= scene_.spacing / (j + 1.0);
      }
    }
  }
}

/// psi(x, y)/psi(x) of the modes of both bodies on the rows of an areal scene.
void Filler::across() {
  if (!model_.is_areal) return;
  for (int row = 0; row < n_.rows; ++row) {
    double* const lanes =
        host_(tables_.faces.rows.across) + static_cast<std::size_t>(row) * n_.lanes;
    int lane = 0;
    for (const BodyMode& mode : model_.resonator.modes)
      mode.shape->evaluate_across(model_.side + model_.eta(row), 1, lanes + lane++);
    for (const BodyMode& mode : model_.slider.modes)
      mode.shape->evaluate_across(model_.eta(row), 1, lanes + lane++);
  }
}

void Filler::faces() {
  double* const h1 = host_(tables_.faces.height1);
  double* const h2 = host_(tables_.faces.height2);
  double* const highest2 = host_(tables_.faces.highest2);
  double scale = 0, scale2 = 0, highest = -1e300;
  for (int row = 0; row < model_.rows; ++row) {
    const double* const own =
        model_.slider_height.data() + static_cast<std::size_t>(row) * n_.row_nodes;
    double* const row1 = h1 + row * n_.padded_row();
    for (int n = 0; n < static_cast<int>(n_.padded_row()); ++n) {
      const bool real = n < n_.row_nodes;
      row1[n] = real ? own[n] - model_.delta : -1e30;
      if (real) scale = std::max(scale, std::abs(row1[n]));
    }
    const int given = model_.row_heights();
    const double* const face =
        model_.resonator_height.data() + static_cast<std::size_t>(row) * given;
    double* const row2 = h2 + static_cast<std::size_t>(row) * n_.row_heights;
    for (int n = 0; n < n_.row_heights; ++n) row2[n] = face[std::min(n_.behind + n, given - 1)];
    for (int n = 0; n < given; ++n) {
      scale2 = std::max(scale2, std::abs(face[n]));
      highest = std::max(highest, face[n]);
    }
    if (!model_.is_areal) fill_highest(row2, n_.row_heights, n_.width, highest2);
    tables_.faces.steepest_rise = std::max(tables_.faces.steepest_rise, steepest_rise(face, given));
  }
  scale += scale2;
  tables_.faces.rounding = face_rounding(scale, n_.smooth);
  tables_.contact.tolerance = tables_.faces.rounding;
  tables_.faces.highest_overlap = *std::max_element(h1, h1 + n_.nodes) + highest;
  if (n_.smooth) smooth_faces(h2);
  if (model_.is_areal) tiles();
  scale += 1e-6 * scene_.spacing;
  tables_.bounds.least_range = 1e-4 * scale;
  tables_.bounds.least_margin = 1e-8 * scale;
}

/// Bounds on the faces and the modes in tiles of nodes.
void Filler::tiles() {
  const TileTables& t = tables_.faces.tiles;
  const int tile = t.groups * n_.width;  // nodes
  const double* const h1 = host_(tables_.faces.height1);
  const double* const h2 = host_(tables_.faces.height2);
  double* const highest1 = host_(t.highest1);
  double* const highest2 = host_(t.highest2);
  const double *const sag1 = n_.smooth ? host_(tables_.faces.sag1) : nullptr,
                      *const sag2 = n_.smooth ? host_(tables_.faces.sag2) : nullptr;
  double* const column1 = host_(t.column1);
  double* const column2 = host_(t.column2);
  std::fill_n(highest1, static_cast<std::size_t>(t.bands) * t.row, -1e30);
  std::fill_n(column1, static_cast<std::size_t>(t.bands) * t.column_row, -1e30);
  const std::size_t groups = n_.row_heights / n_.width + 1;
  std::vector<double> group(groups), sag(groups);
  for (int band = 0; band < t.bands; ++band) {
    const int first = band * tile_rows, last = std::min(first + tile_rows, n_.rows);
    double* const own = highest1 + static_cast<std::size_t>(band) * t.row;
    double* const own_column = column1 + static_cast<std::size_t>(band) * t.column_row;
    // of each group of the resonator: the highest node, and the most that cells may add
    std::fill(group.begin(), group.end(), -1e30);
    std::fill(sag.begin(), sag.end(), 0.0);
    for (int row = first; row < last; ++row) {
      const double* const row1 = h1 + row * n_.padded_row();
      const double* const row2 = h2 + static_cast<std::size_t>(row) * n_.row_heights;
      for (int i = 0; i < n_.row_nodes; ++i) {
        const double most =
            row1[i] + (sag1 == nullptr ? 0.0 : std::max(0.0, sag1[row * n_.padded_row() + i]));
        own[i / tile] = std::max(own[i / tile], most);
        own_column[i / n_.width] = std::max(own_column[i / n_.width], most);
      }
      for (int i = 0; i < n_.row_heights; ++i)
        group[i / n_.width] = std::max(group[i / n_.width], row2[i]);
      for (int i = 0; sag2 != nullptr && i < n_.row_heights; ++i)
        sag[i / n_.width] =
            std::max(sag[i / n_.width], sag2[static_cast<std::size_t>(row) * n_.row_heights + i]);
    }
    // all that so many groups meet whose first node stands in group g, until they have gone a group
    // further, with what CandidateGroups::sag_on_path may add
    const auto highest_on_path = [&](int g, int count) {
      double most = -1e30, most_sag = 0;
      for (int j = g; j < g + count + 2 && j < static_cast<int>(groups); ++j) {
        most = std::max(most, group[j]);
        most_sag = std::max(most_sag, sag[j]);
      }
      return most + 2 * most_sag;
    };
    double* const strips = highest2 + static_cast<std::size_t>(band) * t.groups * t.strip;
    for (int g = 0; g < t.groups * t.strip; ++g)
      strips[static_cast<std::size_t>(g % t.groups) * t.strip + g / t.groups] =
          highest_on_path(g, t.groups);
    for (int g = 0; g < t.column_strip; ++g)
      column2[static_cast<std::size_t>(band) * t.column_strip + g] = highest_on_path(g, 1);
    double* const lanes = host_(t.across) + static_cast<std::size_t>(band) * n_.lanes;
    const double middle = 0.5 * (model_.eta(first) + model_.eta(last - 1));
    int lane = 0;
    for (const BodyMode& mode : model_.resonator.modes)
      mode.shape->evaluate_across(model_.side + middle, 1, lanes + lane++);
    for (const BodyMode& mode : model_.slider.modes)
      mode.shape->evaluate_across(middle, 1, lanes + lane++);
  }
  for (int k = 0; k < tables_.slider.modes; ++k)
    for (int i = 0; i < t.count; ++i)
      host_(t.shape)[k * t.row + i] = shape_at(
          model_.slider.modes[k], std::min(i * tile + tile / 2, n_.row_nodes - 1) * scene_.spacing);
}

/// By its slope along a tile times the way from its middle (of the resonator on the way that a list
/// of candidate groups holds for, too, and without a footprint from the middle of a patch), and its
/// slope across it.
void Filler::tile_variation(const ModeOnLane& mode) {
  const TileTables& t = tables_.faces.tiles;
  double nodes = 0.5 * t.groups * n_.width + 1;
  if (mode.of_resonator) nodes += n_.width + 2;
  if (mode.of_resonator && n_.footprint_terms == 0) nodes += 0.5 * tables_.patches.nodes;
  const double along = nodes * scene_.spacing,
               across = 0.5 * (tile_rows - 1) * model_.spacing_y * mode.shape.across_rate();
  // the middle of a patch, and what the slider would reach, may lie behind the body's end
  const double beyond = mode.of_resonator ? 2 * radius_ + along : 0.0;
  host_(tables_.bounds.tile_variation)[mode.lane] =
      along * mode.shape.largest_slope(beyond) + across * mode.largest * mode.shape.growth(beyond);
}

/// Splines instead of straight lines. `h2`: the resonator's heights, padded.
void Filler::smooth_faces(const double* h2) {
  FaceTables& faces = tables_.faces;
  const int given = model_.row_heights();
  double largest1 = 0;
  faces.steepest_rise = 0;
  for (int row = 0; row < model_.rows; ++row) {
    const auto from = [&](const double* array, std::size_t length) {
      return host_(array) + row * length;
    };
    const std::size_t length = n_.padded_row(), heights = n_.row_heights;
    double *const curvature1 = from(faces.curvature1, length), *const curvature2 =
                                                                   from(faces.curvature2, heights);
    std::fill_n(curvature1, length, 0.0);
    std::copy_n(model_.slider_curvature.data() + static_cast<std::size_t>(row) * n_.row_nodes,
                n_.row_nodes, curvature1);
    std::fill_n(curvature2, heights, 0.0);
    std::copy_n(
        model_.resonator_curvature.data() + static_cast<std::size_t>(row) * given + n_.behind,
        std::min(given - n_.behind, n_.row_heights), curvature2);
    largest1 = std::max(largest1, largest_face_curvature(curvature1, n_.row_nodes));
    faces.largest_face_curvature =
        std::max(faces.largest_face_curvature, largest_face_curvature(curvature2, n_.row_heights));
    const double* const row2 = h2 + row * heights;
    faces.steepest_rise =
        std::max(faces.steepest_rise, steepest_rise(row2, curvature2, n_.row_heights));
    // Both cells beside a slider node reach from the one before it to the one after. While the left
    // of these nodes stands in one spacing of the resonator, its pieces from the node before that
    // under the slider's to the second after it pass them.
    std::fill_n(from(faces.sag1, length), length, 0.0);
    fill_sag(curvature1, n_.row_nodes, 1, 1, from(faces.sag1, length));
    fill_sag(curvature2, n_.row_heights, 1, 2, from(faces.sag2, heights));
    if (model_.is_areal) continue;
    fill_highest(host_(faces.sag2), n_.heights, n_.width, host_(faces.highest_sag2));
    std::vector<double> raised(n_.heights);
    fill_raised(h2, curvature2, n_.heights, raised.data());
    fill_highest(raised.data(), n_.heights, n_.width, host_(faces.highest2));
  }
  faces.highest_overlap += 0.125 * (faces.largest_face_curvature + largest1);
}

void Filler::adaptive() {
  if (!is_adaptive(scene_)) return;
  tables_.adaptive.tolerance = scene_.time.tolerance.value_or(usual_tolerance);
  tables_.adaptive.order = series_order(tables_.adaptive.tolerance);
  tables_.flight.first_level = first_flight_level(model_);
  // reached behind the body's end; on a beam growth(radius) would do: wide by 1.28 where nodes are
  // fine
  tables_.adaptive.cubic_excess = 1.0;
  for (const BodyMode& mode : model_.resonator.modes)
    tables_.adaptive.cubic_excess =
        std::max(tables_.adaptive.cubic_excess, mode.shape->growth(2.0 * radius_));
  tables_.adaptive.longest_scale =
      std::min(scene_.duration, 64.0 / std::max(fastest_rate(model_), 1e-300));
  double* const gauss = host_(tables_.adaptive.gauss);
  std::copy_n(gauss_place, gauss_points, gauss);
  std::copy_n(gauss_weight, gauss_points, gauss + gauss_row);
  fill_lobatto(host_(tables_.adaptive.lobatto));
  tables_.adaptive.most_raised = n_.higher_orders;
  for (int i = 0; i < static_cast<int>(n_.series_orders()); ++i)
    fill_hull(host_(tables_.adaptive.hull) + i * hull_length, tables_.adaptive.order + 2 * i + 3);
  if (n_.smooth) fill_collocation(host_(tables_.collocation.paces));
  tables_.collocation.cells_share = n_.smooth && neighbours_share(model_);
  // where contact ends at the share 1 - e of a step, its formula is off by some e^2.5 of the
  // impulse
  tables_.collocation.early_release = std::pow(tables_.adaptive.tolerance, 0.4);
}

/// Shapes across the bodies about even rows, and what polynomials leave out of shapes. After the
/// bounds of the modes.
void Filler::clusters() {
  if (n_.cluster_degree == 0) return;
  tables_.clusters.degree = n_.cluster_degree;
  tables_.clusters.rows = n_.place_rows();
  double* const across = host_(tables_.clusters.across);
  int lane = 0;
  for (const Body* body : {&model_.resonator, &model_.slider}) {
    const double edge = body == &model_.resonator ? model_.side : 0.0;
    for (const BodyMode& mode : body->modes) {
      const double left_out = cluster_remainder(model_, mode, n_.cluster_degree);
      if (n_.adaptive())
        host_(tables_.clusters.remainder)[lane] = left_out;
      else
        host_(tables_.bounds.cubic_remainder)[lane] += left_out;
      for (int i = 0; i < n_.place_rows(); ++i) {
        double d[4], factor = 1.0;
        mode.shape->evaluate_across(edge + model_.eta(2 * i), 4, d);
        for (int b = 0; b < 4; ++b) {
          across[(static_cast<std::size_t>(i) * 4 + b) * n_.lanes + lane] = factor * d[b];
          factor *= model_.spacing_y / (b + 1.0);
        }
      }
      ++lane;
    }
  }
}

void Filler::moving_forces() {
  MovingForceTable* const moving = host_(tables_.forces.list);
  for (int i = 0; i < tables_.forces.count; ++i) {
    const MovingForce& f = scene_.resonator.moving_forces[i];
    moving[i] = {f.force, f.start, f.speed * model_.tick};
    if (n_.rows == 0) continue;
    double* lanes = host_(tables_.forces.across) + static_cast<std::size_t>(i) * n_.lanes;
    for (const BodyMode& mode : model_.resonator.modes)
      mode.shape->evaluate_across(*f.y, 1, lanes++);
  }
}

}  // namespace

void fill(SceneTables& tables, const Model& model, const PatchSeries& series, const Extents& n,
          const HostCopy& host) {
  Filler filler(tables, model, series, n, host);
  filler.numbers();
  filler.scheme();
  filler.adaptive();
  filler.modes();
  filler.patches();
  filler.slider_shapes();
  filler.across();
  filler.faces();
  filler.clusters();
  if (n.footprint_terms > 0) fill_footprint(tables.bounds, model, n, host);
  filler.moving_forces();
}

void fill(SceneState& state, const Model& model, const ModalStart& start, const Extents& n,
          const HostCopy& host) {
  const std::size_t modes2 = model.resonator.modes.size();
  const auto put = [&](double* array, const std::vector<double>& resonator,
                       const std::vector<double>& slider) {
    std::copy(resonator.begin(), resonator.end(), host(array));
    std::copy(slider.begin(), slider.end(), host(array) + modes2);
  };
  put(state.carried.modal.u, start.resonator_u, start.slider_u);
  put(state.carried.modal.start_u, start.resonator_u, start.slider_u);
  put(state.carried.modal.v, start.resonator_v, start.slider_v);
  put(state.carried.modal.start_v, start.resonator_v, start.slider_v);
  for (double* const lanes :
       {state.out.now.u, state.out.now.v, state.out.now.square, state.out.now.square_part})
    std::fill_n(host(lanes), n.lanes, 0.0);  // this memory may be another scene's before
  std::fill_n(host(state.out.now.deflection_work_part), n.width, 0.0);
  put(state.out.now.u, start.resonator_u, start.slider_u);
  put(state.out.now.v, start.resonator_v, start.slider_v);
  state.carried.energy.start = start.energy;
  state.carried.sampling.next = model.first_sample;
  state.out.samples.capacity = n.samples;
  state.work.candidates.most_listed = n.listed;
  state.work.candidates.kept = n.keeps_lists;
  state.work.runs.capacity = n.runs();
  state.work.runs.row = model.is_areal ? static_cast<int>(n.padded_row()) : 0;
  state.out.ended_shocks.capacity = n.shocks;
  if (model.is_areal) {
    std::fill_n(host(state.marks.node_slot), n.nodes, 0);
    state.marks.slots = static_cast<int>(n.slots());
  } else {
    std::fill_n(host(state.marks.node_window), n.nodes, -1);
  }
  state.work.active.capacity = n.active;
  if (n.active > 0) {
    std::fill_n(host(state.marks.active_index), n.nodes, -1);
    state.carried.latest_contact.step = start.loaded_nodes.empty() ? -1 : 0;
    state.carried.latest_contact.force = start.contact_force;
    state.carried.latest_contact.energy = start.contact_energy;
    state.carried.latest_contact.nodes = static_cast<int>(start.loaded_nodes.size());
    for (std::size_t e = 0; e < 2 && e < start.loaded_nodes.size(); ++e) {
      const int node = start.loaded_nodes[e], row = node / n.row_nodes;
      state.carried.latest_contact.pair[e] =
          node + row * (static_cast<int>(n.padded_row()) - n.row_nodes);
    }
  }
  if (n.adaptive()) {
    state.work.spans.capacity = n.contacts;
    // about as long as the fastest motion, with a node in contact, lets a series be
    const double rate = fastest_rate(model);
    state.carried.control.series_scale = rate > 0 ? 1.0 / rate : model.scene.duration;
    state.carried.control.flight_level =
        std::clamp(std::ilogb(state.carried.control.series_scale / model.tick), 0, 60);
  }
}

}  // namespace ra2d
