// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/face_search.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "host/base/errors.hpp"
#include "host/plan/expected_work.hpp"
#include "host/plan/face_choices.hpp"
#include "host/savings/trials.hpp"
#include "host/surface/spline.hpp"

namespace ra2d {
namespace {

constexpr const char* faces_key = "scene.faces";
/// Costs that differ by less are alike.
constexpr double alike_costs = 0.95;

bool is_flat(const Scene& scene) {
  return scene.resonator.surface.kind == SurfaceKind::flat &&
         scene.slider.surface.kind == SurfaceKind::flat;
}

/// Whether linear and smooth faces are compared.
bool chooses_faces(const Scene& reference) {
  // smooth faces on maps cost more than fine linear ones that are as good
  return reference.faces == Faces::smooth && reference.kind == SceneKind::plane &&
         !is_flat(reference);
}

/// Runs the base with other faces, and adds how far it moves.
const Trial& try_faces(SavingsSearch& search, Faces faces, double spacing, double end,
                       double latest, double expected_cost = 0) {
  const bool chooses = chooses_faces(search.whole);
  const Scene& written = search.out.written;
  const auto change = [faces, spacing](Scene& s) {
    s.faces = faces;
    set_spacing(s, spacing);
  };
  std::string what = chooses ? faces_text(faces, spacing) : fmt::format("{:g} um", spacing * 1e6);
  if (faces == written.faces && spacing == written.spacing) what += ", as written";
  search.out.trials.push_back(try_out(
      search, changed(chooses ? faces_key : "scene.spacing", what, change, search.base->scene()),
      search.base, end, expected_cost, latest));
  return search.out.trials.back();
}

/// Cost of the base with other faces; NaN where it cannot be run.
double cost_with(const SavingsSearch& search, Faces faces, double spacing) {
  Scene scene = search.base->scene();
  scene.faces = faces;
  set_spacing(scene, spacing);
  try {
    return measure_cost(scene, 0.004 * search.options.budget);
  } catch (const RequestError&) {
    return quiet_nan;  // the trial says why
  }
}

/// Wider spacings: upwards by two, then once between. Between smooth faces only as long as they
/// save anything.
void widen(SavingsSearch& search, Faces faces, double end) {
  const double own = search.whole.spacing;
  const bool smooth = faces == Faces::smooth;
  double wide = 1, too_wide = std::numeric_limits<double>::infinity();
  double least = smooth ? cost_with(search, faces, own) : quiet_nan;
  double cost = 0;
  for (double factor = 2;
       factor < too_wide && factor < 1000 && (factor == 2 || search.left(end) > 0);) {
    if (smooth) {
      cost = cost_with(search, faces, own * factor);
      if (cost > alike_costs * least) return;
      least = cost;
    }
    const Trial& trial = try_faces(search, faces, own * factor, search.next_end(end, 3), end,
                                   std::isfinite(cost) ? cost : 0.0);
    if (was_not_run(trial)) return;  // the others take as long
    const bool enough = trial.verdict == Verdict::kept;
    (enough ? wide : too_wide) = factor;
    if (factor == 1.5 * wide || factor == 1.5 * std::exp2(std::floor(std::log2(factor)))) return;
    factor = enough ? 2 * factor : 1.5 * wide;
  }
}

/// Linear faces of this spacing and finer ones, until some hold, or cost as much as the best ones
/// so far.
void refine_linear(SavingsSearch& search, double spacing, double best, double end) {
  for (; search.left(end) > 0; spacing /= 2) {
    const double cost = cost_with(search, Faces::linear, spacing);
    if (!(cost < alike_costs * search.base->cost() / best)) return;
    const Trial& trial =
        try_faces(search, Faces::linear, spacing, search.next_end(end, 2), end, cost);
    if (trial.verdict != Verdict::moved) return;
  }
}

/// Times that a trial is cheaper than the base: estimated where it ran too short to be measured.
double times_cheaper(const SavingsSearch& search, const Trial& trial) {
  return std::isfinite(trial.cheaper)
             ? trial.cheaper
             : expected_work(search.base->scene()).march / expected_work(trial.scene).march;
}

/// By how much the cheapest faces that hold are cheaper than the reference's; which trial it is.
std::pair<double, std::optional<std::size_t>> cheapest_faces(const SavingsSearch& search) {
  const Savings& out = search.out;
  double most = 1;
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < out.trials.size(); ++i) {
    const Trial& trial = out.trials[i];
    if (trial.key != faces_key || trial.verdict != Verdict::kept) continue;
    const double cheaper = times_cheaper(search, trial);
    if (!(cheaper > most)) continue;
    most = cheaper;
    best = i;
  }
  return {most, best};
}

}  // namespace

Scene with_faces_of_reference(const Scene& written) {
  Scene scene = written;
  scene.faces = Faces::smooth;
  if (written.faces == Faces::smooth || !chooses_faces(scene)) return written;
  try {
    const Model model = make_model(scene);
    if (spline_error(model.resonator_height) <= most_spline_error &&
        spline_error(model.slider_height) <= most_spline_error)
      return scene;
  } catch (const RequestError&) {  // the scene's own fault is found where it is run
  }
  return written;
}

void check_faces(SavingsSearch& search, double end) {
  const Scene& written = search.out.written;
  if (written.faces == search.whole.faces) return;
  const double cost = cost_with(search, written.faces, written.spacing);
  try_faces(search, written.faces, written.spacing, end, end, std::isfinite(cost) ? cost : 0.0);
}

void find_faces(SavingsSearch& search, double end) {
  const double own = search.whole.spacing;
  if (!chooses_faces(search.whole)) {
    widen(search, search.whole.faces, end);
    for (auto trial = search.out.trials.rbegin(); trial != search.out.trials.rend(); ++trial)
      if (trial->key == "scene.spacing" && !trial->checked && trial->verdict == Verdict::kept) {
        trial->taken = true;  // the widest
        return;
      }
    return;
  }
  const Trial* const written = faces_as_written(search.out);
  const std::optional<Verdict> linear =
      written ? std::optional(written->verdict) : std::nullopt;  // of the scene's spacing
  if (linear == Verdict::kept) widen(search, Faces::linear, search.next_end(end, 2));
  widen(search, Faces::smooth, search.next_end(end, 2));
  if (!linear || linear == Verdict::moved)
    refine_linear(search, linear ? own / 2 : own, cheapest_faces(search).first, end);
  if (const auto best = cheapest_faces(search).second) search.out.trials[*best].taken = true;
  // what the savings below start from, and where they end if all of them are given up
  if (linear != Verdict::open) search.out.chosen.faces = search.whole.faces;
}

const Trial* faces_as_written(const Savings& savings) {
  for (const Trial& trial : savings.trials)
    if (trial.key == faces_key && trial.scene.faces == savings.written.faces &&
        trial.scene.spacing == savings.written.spacing)
      return &trial;
  return nullptr;
}

}  // namespace ra2d
