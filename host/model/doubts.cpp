// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "host/base/format.hpp"
#include "host/scene/hertz.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/unit_doubts.hpp"
#include "host/surface/spline.hpp"
#include "host/surface/usual_faces.hpp"

namespace ra2d {
namespace {

using Doubts = std::vector<std::string>;

bool is_rough(const SurfaceSpec& surface) {
  return surface.kind == SurfaceKind::gaussian || surface.kind == SurfaceKind::file;
}

/// The cure of a stiffness that is far too small.
std::string soft_cure(double kappa, double most) {
  constexpr double about = 100;
  if (kappa * 1e9 <= about * most) return fmt::format("is it in MPa/mm ({:g} Pa/m)?", kappa * 1e9);
  return "contacts are too wide and too long. 'ra2d plan' names the stiffness of Hertz's contacts";
}

/// In an areal scene: compares the spring of a node with a half-space of the material under a spot
/// as wide as the node's cell, the narrowest contact that nodes show: kappa = 2 E* a/area. That of
/// Hertz's contacts, 3 E*/(4 pi a), falls with their half-width a, at most half of the slider's.
void doubt_point_stiffness(const Scene& scene, Doubts& doubts) {
  constexpr double much_stiffer = 4, far_softer = 0.1;
  const double modulus = plate_contact_modulus(scene), kappa = scene.contact.stiffness;
  if (!std::isfinite(modulus)) return;
  if (!is_rough(scene.resonator.surface) && !is_rough(scene.slider.surface)) return;
  const double across = scene.spacing_y.value_or(scene.spacing),
               along = scene.faces == Faces::smooth ? across : scene.spacing;
  const double area = along * across;
  const double most = 2 * modulus * std::sqrt(area / M_PI) / area,  // 2 E* a of a round spot
      least = 1.5 * modulus / (M_PI * std::max(scene.slider.length, scene.slider.width));
  if (kappa > much_stiffer * most)
    doubts.push_back(fmt::format(
        "contact.stiffness = {:g} Pa/m: a node's spring is {:.2g} times as stiff as the bodies' "
        "material under a spot as wide (E* = {:.3g} GPa, at most {:.2g} Pa/m on this spacing): "
        "shocks are too short and too hard. 'ra2d plan' names the stiffness of Hertz's contacts",
        kappa, kappa / most, modulus * 1e-9, most));
  else if (kappa < far_softer * least)
    doubts.push_back(
        fmt::format("contact.stiffness = {:g} Pa/m: far softer than the bodies' "
                    "material, which gives at least {:.2g} Pa/m under all of the "
                    "slider: {}",
                    kappa, least, soft_cure(kappa, most)));
}

/// Compares the contact stiffness with that of the bodies' materials.
void doubt_stiffness(const Scene& scene, Doubts& doubts) {
  const ContactSettings& contact = scene.contact;
  if (contact.law != ContactLaw::penalty || contact.is_hertz) return;
  if (scene.kind == SceneKind::areal) {
    doubt_point_stiffness(scene, doubts);
    return;
  }
  constexpr double much_stiffer = 2, far_softer = 1e-2;
  const double hertz = hertz_stiffness(scene), most = stiffest_half_space(scene);
  if (!std::isfinite(hertz)) return;  // neither body deforms
  const SurfaceSpec &of_resonator = scene.resonator.surface, &of_slider = scene.slider.surface;
  const bool rough = is_rough(of_resonator) || is_rough(of_slider);
  if (!rough && of_resonator.kind != SurfaceKind::peaks && of_slider.kind != SurfaceKind::peaks)
    return;  // flat on flat: no contact is narrow
  const double ratio = std::pow(contact.stiffness / hertz, 2.0 / 3);  // of N/m, under one load
  const std::string stiffness = fmt::format("contact.stiffness = {:g} Pa/m: ", contact.stiffness);
  const std::string take = fmt::format("(\"hertz\" takes {:.3g} Pa/m)", hertz);
  // between smooth faces asperities touch over their own width
  const bool shows_width = rough && scene.faces == Faces::smooth;
  if (contact.stiffness > most && !shows_width)
    doubts.push_back(stiffness +
                     fmt::format("stiffer than the bodies' material, which gives a ridge as "
                                 "wide as the slider at most {:.2g} Pa/m on this spacing {}",
                                 most, take));
  else if (rough && ratio > much_stiffer)
    doubts.push_back(stiffness +
                     fmt::format("under a given load asperities are {:.2g} times as stiff as "
                                 "their material makes them {}: shocks are too short and too hard",
                                 ratio, take));
  else if (contact.stiffness < far_softer * hertz)
    doubts.push_back(stiffness + fmt::format("far softer than the bodies' material {}: {}", take,
                                             soft_cure(contact.stiffness, most)));
}

/// Finds loads that nothing holds.
void doubt_held(const Scene& scene, Doubts& doubts) {
  const auto moves_off = [&](const char* body, const char* load) {
    doubts.push_back(
        fmt::format("nothing holds the free {} against {}: it moves off as a whole. The level "
                    "counts its elastic "
                    "motion alone",
                    body, load));
  };
  const bool pressed = scene.slider.load_is_weight || scene.slider.load > 0;
  if (scene.slider.support == Support::free && scene.slider.load < 0)
    moves_off("slider", "its load, which pulls it off the resonator (slider.load < 0)");
  if (scene.resonator.support != Support::free) return;
  if (scene.slider.support == Support::free && pressed) moves_off("resonator", "the slider's load");
  for (const MovingForce& force : scene.resonator.moving_forces)
    if (force.force != 0) {
      moves_off("resonator", "its moving force");
      break;
    }
}

struct Relief {
  double highest, lowest, rms;  // m
  double slope;                 // root mean square, between nodes
};

/// Of heights in rows of so many nodes.
Relief relief_of(const std::vector<double>& heights, int row, double spacing) {
  Relief relief{heights.front(), heights.front(), 0, 0};
  for (std::size_t i = 0; i < heights.size(); ++i) {
    relief.highest = std::max(relief.highest, heights[i]);
    relief.lowest = std::min(relief.lowest, heights[i]);
    relief.rms += heights[i] * heights[i];
    if (i % static_cast<std::size_t>(row) > 0)
      relief.slope += (heights[i] - heights[i - 1]) * (heights[i] - heights[i - 1]);
  }
  const auto count = static_cast<double>(heights.size());
  relief.rms = std::sqrt(relief.rms / count);
  const double rises = count - std::round(count / row);
  relief.slope = std::sqrt(relief.slope / std::max(rises, 1.0)) / spacing;
  return relief;
}

/// Checks a random face; measured ones are checked where they are read.
void doubt_roughness(const std::string& name, const BodySpec& body, const Relief& relief,
                     Doubts& doubts) {
  constexpr double large_share = 0.05, largest_share = 0.5;  // of the thickness, as measured ones
  constexpr double steep = 0.5;
  constexpr double most_millimetres = 0.1;  // m: larger numbers are of micrometres
  const double rq = body.surface.rq, span = relief.highest - relief.lowest;
  const std::string key = name + ".surface.rq";
  // in another unit the face would be as smooth as none is
  const bool may_be_other = relief.slope > 1e3 * usual_faces::smooth || rq >= most_millimetres;
  if (body.thickness > 0 && span > (may_be_other ? large_share : largest_share) * body.thickness)
    doubt(doubts, key, rq,
          fmt::format("the heights span {:.3g} m, and {}.thickness is {:g} m", span, name,
                      body.thickness),
          rq < most_millimetres ? millimetres : micrometres);
  else if (relief.slope > steep)
    doubt(doubts, key, rq,
          fmt::format("its slopes have a root mean square of {:.2g}, steeper than faces are",
                      relief.slope),
          too_large);
  else if (relief.slope < usual_faces::smooth)
    doubt(doubts, key, rq,
          fmt::format("its slopes have a root mean square of {:.2g}, smoother than faces are",
                      relief.slope),
          too_small);
}

/// Compares an imposed gap with the heights that are to meet across it.
void doubt_gap(const Model& model, const Relief& resonator, const Relief& slider, Doubts& doubts) {
  constexpr double near = 0.05;              // of the root mean square of both faces
  constexpr double held = 3, falling = 100;  // of the highest points of both faces
  const Scene& scene = model.scene;
  if (!scene.gap) return;
  const double gap = *scene.gap,
               heights = std::max(resonator.highest, 0.0) + std::max(slider.highest, 0.0);
  const double rms = std::hypot(resonator.rms, slider.rms);
  const double most = scene.slider.support == Support::free ? falling : held;
  if (heights > 0 && gap > most * heights)
    doubt(doubts, "scene.gap", gap,
          fmt::format("the faces rise no higher than {:.3g} m together", heights), millimetres);
  else if (heights > 0 && gap < -held * heights)
    doubt(doubts, "scene.gap", gap,
          fmt::format("the faces overlap by far more than they rise, {:.3g} m together", heights),
          millimetres);
  else if (gap != 0 && std::abs(gap) < near * rms)
    doubt(doubts, "scene.gap", gap,
          fmt::format("next to nothing beside faces of {:.3g} m, root mean square", rms),
          too_small);
}

/// Along a cell of smooth faces a mode's shape is its Taylor cubic: off by beta^4 (spacing/2)^4/4!
/// at its ends.
void doubt_cells(const Model& model, Doubts& doubts) {
  if (!model.has_smooth_faces()) return;
  constexpr double of_fixed_steps = 1e-6;
  const Scene& scene = model.scene;
  const double allowed =
      is_adaptive(scene) ? scene.time.tolerance.value_or(usual_tolerance) : of_fixed_steps;
  const double beta =
      std::max(highest_wave_number(model.resonator), highest_wave_number(model.slider));
  const double off = std::pow(0.5 * beta * scene.spacing, 4) / 24;
  if (!(off > allowed)) return;
  doubts.push_back(fmt::format(
      "scene.spacing = {:g} m: along a cell of that length the highest mode's shape is taken for a "
      "cubic, off by {:.1g} of its size{}: with scene.spacing = {} it is {:g}",
      scene.spacing, off, is_adaptive(scene) ? ", more than time.tolerance" : "",
      rounded_down(scene.spacing * std::pow(allowed / off, 0.25)), allowed));
}

/// Where nodes are too far apart for a rough face, its spline rings between them. Of a map some
/// rows are looked at. Peaks touch at their tops, and ring at their feet.
void doubt_splines(const Model& model, Doubts& doubts) {
  if (!model.has_smooth_faces()) return;
  constexpr int most_rows = 64;
  const Scene& scene = model.scene;
  for (const auto& [name, body, heights, length] :
       {std::tuple{"resonator", &scene.resonator, &model.resonator_height, model.row_heights()},
        std::tuple{"slider", &scene.slider, &model.slider_height, model.row_nodes()}}) {
    if (!is_rough(body->surface)) continue;
    double error = 0, off = 0;  // m
    for (int i = 0, looked_at = std::min(model.rows, most_rows); i < looked_at; ++i) {
      const double* const first =
          heights->data() + std::ptrdiff_t{length} * (std::int64_t{i} * model.rows / looked_at);
      const std::vector<double> row(first, first + length);
      const double here = spline_error(row);
      if (!(here > error)) continue;
      error = here;
      off = spline_off(row);
    }
    if (!(error > most_spline_error)) continue;
    doubts.push_back(fmt::format(
        "{}.surface: between nodes {:g} m apart its spline may be off by up to some {:.2g} m, "
        "{:.0f} % of its root mean square height, and rates of shocks by as much: take a finer "
        "scene.spacing{}",
        name, scene.spacing, off, 100 * error,
        model.is_areal ? "" : ", or scene.faces = \"linear\" ('ra2d plan' compares them)"));
  }
}

void doubt_samples(const Scene& scene, Doubts& doubts) {
  if (!(scene.output.rate * scene.duration < 1 - 1e-9)) return;
  const double least = 1 / scene.duration, unit = std::pow(10, std::floor(std::log10(least)) - 2);
  doubts.push_back(fmt::format(
      "output.rate = {:g} Hz: the run ends after {:g} s, before a second sample: its file has the "
      "state at t = 0 alone. Take {:g} Hz or more",
      scene.output.rate, scene.duration, unit * std::ceil(least / unit - 1e-8)));
}

}  // namespace

std::vector<std::string> scene_doubts(const Scene& scene) {
  Doubts doubts = unit_doubts(scene);
  doubt_held(scene, doubts);
  doubt_stiffness(scene, doubts);
  doubt_samples(scene, doubts);
  return doubts;
}

void doubt_faces(const Model& model, std::vector<std::string>& doubts) {
  const Scene& scene = model.scene;
  const Relief resonator = relief_of(model.resonator_height, model.row_heights(), scene.spacing);
  const Relief slider = relief_of(model.slider_height, model.row_nodes(), scene.spacing);
  if (scene.resonator.surface.kind == SurfaceKind::gaussian)
    doubt_roughness("resonator", scene.resonator, resonator, doubts);
  if (scene.slider.surface.kind == SurfaceKind::gaussian)
    doubt_roughness("slider", scene.slider, slider, doubts);
  doubt_gap(model, resonator, slider, doubts);
  doubt_cells(model, doubts);
  doubt_splines(model, doubts);
}

void doubt_sound(const Model& model, std::vector<std::string>& doubts) {
  const OutputSettings& output = model.scene.output;
  if (output.microphones.empty()) return;
  int above = 0;
  double highest = 0;  // Hz
  for (const BodyMode& mode : model.resonator.modes) {
    const double frequency = mode.omega / (2 * M_PI);
    if (frequency > output.rate / 2) ++above;
    highest = std::max(highest, frequency);
  }
  if (above > 0)
    doubts.push_back(fmt::format(
        "output.rate = {:g} Hz: {} mode{} of the resonator, up to {:.4g} Hz, above half of it: "
        "microphones hear them at frequencies that are not theirs. Take more than {:.3g} Hz",
        output.rate, above, above == 1 ? "" : "s", highest, 2.02 * highest));
}

}  // namespace ra2d
