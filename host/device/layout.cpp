// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/errors.hpp"
#include "host/device/footprint_tables.hpp"
#include "host/model/bounds.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {

Form form_of(const Scene& scene) {
  if (is_adaptive(scene)) return Form::adaptive;
  return holds_forces(scene)                   ? Form::implicit
         : is_semi_implicit(scene.time.scheme) ? Form::semi_implicit
                                               : Form::staged;
}

PatchSeries choose_series(const Model& model, int width) {
  const double beta_chi = highest_wave_number(model.resonator) * model.scene.spacing;
  const double widest = model.row_heights();
  // radius = (patch_nodes + width)/2 + 1 in chi
  const double nodes = beta_chi > 0 ? std::min(widest, 0.5 / beta_chi - width - 2) : widest;
  PatchSeries series;
  series.patch_nodes = std::max(1, static_cast<int>(nodes));
  const double range = beta_chi * (0.5 * (series.patch_nodes + width) + 1.0);
  const auto left_out = [&] {
    return std::exp(series.terms * std::log(range) - std::lgamma(series.terms + 1.0));
  };
  while (range > 0 && series.terms <= most_terms && left_out() > 0x1p-53) series.terms += 4;
  if (series.terms > most_terms)
    throw refusal(
        model.scene, "scene.spacing",
        fmt::format("{} m gives the resonator's highest mode only {:.1f} nodes to a wavelength, "
                    "{:.0f} are needed here: refine it, or keep fewer modes "
                    "(resonator.max_frequency)",
                    model.scene.spacing, 2 * M_PI / beta_chi,
                    std::ceil(2 * M_PI * (0.5 * (1 + width) + 1.0) / 2.1)));
  return series;
}

int first_flight_level(const Model& model) {
  const double rate = std::max(fastest_rate(model), 1e-3);
  return std::clamp(std::ilogb(2e-4 / (rate * model.tick)), 0, 40);
}

double cluster_remainder(const Model& model, const BodyMode& mode, int degree) {
  const ModeShape& shape = *mode.shape;
  if (shape.wave_number() == 0.0) return 0.0;
  const int nodes = is_adaptive(model.scene) ? cluster_reach : square_reach;
  // along and across together; the distance along grows by half a node within a window
  const double along = (nodes + 0.5) * model.scene.spacing, across = nodes * model.spacing_y;
  const double change = shape.change_rate() * along + shape.across_rate() * across;
  return shape.size() * shape.growth(along) * std::pow(change, degree + 1) /
         std::tgamma(degree + 2.0);
}

int cluster_degree(const Model& model, int width) {
  const auto modes = static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
  const Form form = form_of(model.scene);
  if (!model.is_areal || model.has_smooth_faces() || form == Form::implicit || modes <= 3 * width)
    return 0;
  if (form != Form::adaptive && width > square_nodes) return 0;
  for (const BodyMode& mode : model.slider.modes)
    if (mode.shape->wave_number() > 0.0) return 0;
  // of a mode's shape; of a displacement, most of which is that of low modes, far less
  const double bearable = form == Form::adaptive
                              ? 0.03 * model.scene.time.tolerance.value_or(usual_tolerance)
                              : 0x1p-24;
  for (const int degree : {2, 3})
    if (std::all_of(
            model.resonator.modes.begin(), model.resonator.modes.end(), [&](const BodyMode& mode) {
              return cluster_remainder(model, mode, degree) <= bearable * mode.shape->largest();
            }))
      return degree;
  return 0;
}

namespace {

/// Nodes along the resonator whose patches are needed. The map of an areal scene, `padded`, ends
/// where the slider does; moving forces go on to the plate's end.
int nodes_with_shapes(const Model& model, int padded) {
  if (!model.is_areal || model.scene.resonator.moving_forces.empty()) return padded;
  constexpr double most = 0x1p30;
  const double along = std::ceil(model.scene.resonator.length / model.scene.spacing) + 1;
  return std::max(padded, static_cast<int>(std::min(along, most)));
}

/// Whether keeping lists of nodes costs less than forecasts (kernels/candidates.hpp): where squares
/// make listed nodes cheap, or steps are long. A forecast serves for many short ones.
bool keeps_lists(const Model& model, const Extents& n) {
  const Form form = form_of(model.scene);
  if (form == Form::implicit || form == Form::adaptive || n.smooth || n.width > square_nodes)
    return false;
  constexpr double long_step = 0.05;  // rad of the fastest mode
  double fastest = 0;
  for (const BodyMode& mode : model.resonator.modes) fastest = std::max(fastest, mode.omega);
  return n.cluster_degree > 0 || fastest * model.tick > long_step;
}

}  // namespace

int higher_orders(const Scene& scene, const FootprintShape& footprint) {
  if (!is_adaptive(scene) || scene.faces == Faces::smooth || !scene.resonator.moving_forces.empty())
    return 0;
  if (footprint.degree == 0 || footprint.degree > 6) return 0;
  const int order = series_order(scene.time.tolerance.value_or(usual_tolerance));
  return std::min(4, (most_order - order) / 2);
}

Extents extents_of(const Model& model, const PatchSeries& series, int lanes, int width,
                   const Capacity& capacity) {
  const Scene& scene = model.scene;
  Extents n;
  n.width = width;
  n.lanes = lanes;
  n.row_nodes = model.row_nodes();
  // of areal scenes a row ends with a padding node at the least (kernels/tables.hpp, "Rows")
  n.row_groups = (n.row_nodes + (model.is_areal ? 1 : 0) + width - 1) / width;
  n.rows = model.is_areal ? model.rows : 0;
  n.groups = model.rows * n.row_groups;
  n.nodes = (model.rows - 1) * n.row_groups * width + n.row_nodes;
  // whole tiles, so that the tiles' bounds are those of the whole face
  const int tile = n.tile_groups() * width;
  n.behind = model.is_areal ? static_cast<int>(model.position) / tile * tile : 0;
  const int padded = model.row_heights() + n.row_groups * width + 2 * width;
  n.row_heights = padded - n.behind;
  n.heights = model.rows * n.row_heights;
  n.patches = nodes_with_shapes(model, padded) / series.patch_nodes + 1;
  n.slider_modes = static_cast<int>(model.slider.modes.size());
  n.smooth = model.has_smooth_faces();
  n.listed = model.is_areal ? std::min({n.nodes, capacity.nodes, most_areal_nodes}) : n.nodes;
  const FootprintShape footprint = choose_footprint(model);
  const int stages = is_adaptive(scene) ? 1 : scheme_table(scene.time.scheme).stages;
  n.stage_rows = first_stage_row(stages);
  n.end_rows = end_rows(stages);
  if (is_adaptive(scene)) {
    const int levels = std::ilogb(static_cast<double>(model.steps)) + 1;
    n.flight_levels = std::max(1, levels - first_flight_level(model));
    n.contacts = std::min(n.listed, capacity.nodes);
    n.higher_orders = higher_orders(scene, footprint);
  }
  n.cluster_degree = cluster_degree(model, width);
  // fixed steps bound the modes' motion so often that sums of more terms would not pay
  constexpr int highest_under_fixed_steps = 12;
  if (lanes / width >= least_footprint_packs &&
      (is_adaptive(scene) || footprint.degree <= highest_under_fixed_steps)) {
    n.footprint_terms = footprint.terms();
    n.footprint_places = footprint.places;
  }
  n.keeps_lists = n.footprint_terms > 0 && keeps_lists(model, n);
  n.moving_forces = static_cast<int>(scene.resonator.moving_forces.size());
  const auto most_samples = static_cast<std::int64_t>(
      std::max<std::size_t>(1, capacity.sample_bytes / (sizeof(double) * sample::pitch(lanes))));
  n.samples =
      static_cast<int>(std::min({std::int64_t{capacity.samples}, most_samples, model.samples}));
  n.shocks = capacity.shocks + n.runs();
  if (form_of(scene) == Form::implicit) {
    // under multipliers no more nodes than modes carry force
    const int modes = static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
    const bool multipliers = scene.contact.law == ContactLaw::multiplier;
    if (n.smooth) {  // points: several may be in one cell, or each in a cell of its own
      n.active = std::max(1, multipliers ? modes : lanes);
      n.listed = std::max(n.listed, std::min(n.nodes, n.active));
    } else {
      n.active = std::min(n.nodes, multipliers ? modes : capacity.nodes);
    }
  }
  return n;
}

}  // namespace ra2d
