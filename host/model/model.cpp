// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/errors.hpp"
#include "host/model/doubts.hpp"
#include "host/model/smooth_contact.hpp"
#include "host/scene/schemes.hpp"
#include "host/surface/spline.hpp"
#include "host/surface/surface.hpp"
#include "kernels/gap.hpp"
#include "kernels/tables.hpp"

namespace ra2d {
namespace {

std::vector<double> surface_of(const std::string& body, const BodySpec& spec, const Scene& scene,
                               std::vector<std::string>& doubts) {
  const std::string key = body + ".surface";
  try {
    std::vector<std::string> odd;
    std::vector<double> heights =
        make_surface(spec.surface, spec.length, scene.spacing, scene.file, spec.thickness, &odd);
    for (const std::string& what : odd)  // a measured face names its file
      doubts.push_back(spec.surface.kind == SurfaceKind::file ? what : key + ": " + what);
    return heights;
  } catch (const RequestError& fault) {
    throw refusal(scene, key, fault.what());
  } catch (const FileError& fault) {
    throw FileError(place_of(scene, key) + ": " + key + ": " + fault.what());
  }
}

/// A step is a tick. Samples may fall between two.
void count_steps(Model& m) {
  const Scene& scene = m.scene;
  m.tick = scene.time.step;
  m.steps = std::llround(scene.duration / scene.time.step);
  // where there is no sample but the first, any interval beyond the end will do
  m.steps_per_sample = 1.0 / (std::max(scene.output.rate, 0.5 / scene.duration) * scene.time.step);
  const double whole = std::round(m.steps_per_sample);
  if (std::abs(m.steps_per_sample - whole) < 1e-12 * whole) m.steps_per_sample = whole;
  // the roundings of a rate of one sample a step are forgiven; samples closer than steps are not
  m.steps_per_sample = std::max(m.steps_per_sample, 1.0);
  m.samples =
      1 + static_cast<std::int64_t>(static_cast<double>(m.steps) / m.steps_per_sample + 1e-9);
}

/// Ticks of at most `finest`, 2^halvings to a sample, as long as their number has room to spare in
/// 64 bits.
void set_clock(Model& m) {
  constexpr double finest = 0x1p-60, most_ticks = 0x1p60;
  const Scene& scene = m.scene;
  // where there is no sample but the first, any interval beyond the end will do
  const double rate = std::max(scene.output.rate, 0.5 / scene.duration);
  double intervals = scene.duration * rate;
  const double whole = std::round(intervals);
  // the end falls on the last sample where it should
  if (std::abs(intervals - whole) < 0x1p-50 * whole) intervals = whole;
  int halvings = 0;
  while (std::ldexp(1.0 / rate, -halvings) > finest) ++halvings;
  while (halvings > 0 && std::ldexp(intervals, halvings) >= most_ticks) --halvings;
  m.tick = std::ldexp(1.0 / rate, -halvings);
  m.steps = std::llround(std::ldexp(intervals, halvings));
  m.steps_per_sample = std::ldexp(1.0, halvings);
  m.samples = 1 + static_cast<std::int64_t>(intervals);
}

/// Lets the run end where its window ends. The clock stays, and so does its end, for the length of
/// steps depends on what is left: so the motion is that of the whole run, bit for bit.
void cut_to_window(Model& m) {
  m.end = m.steps;
  const std::vector<double>& window = m.scene.output.window;
  if (window.size() != 2) return;
  constexpr double forgiven = 1e-9;  // of a sample, for roundings
  m.end = std::min<std::int64_t>(m.steps, std::llround(std::ceil(window[1] / m.tick - forgiven)));
  const auto sample = [&](double ticks) { return ticks / m.steps_per_sample; };
  m.samples = 1 + static_cast<std::int64_t>(sample(static_cast<double>(m.end)) + forgiven);
  m.first_sample = std::min<std::int64_t>(
      m.samples, std::llround(std::ceil(sample(window[0] / m.tick) * (1 - 1e-15) - forgiven)));
}

/// The largest of the lengths that an overlap is the difference of [m].
double largest_height(const Model& m) {
  double size = std::abs(m.delta);
  for (const std::vector<double>* face : {&m.resonator_height, &m.slider_height})
    for (const double h : *face) size = std::max(size, std::abs(h));
  return size;
}

/// Of the undeformed faces at t = 0 [m].
double largest_overlap(const Model& m) {
  if (m.has_smooth_faces()) return largest_smooth_overlap(m);
  const std::vector<double> overlap = overlaps(m, {}, {});
  return *std::max_element(overlap.begin(), overlap.end());
}

/// Springs so stiff that the roundings of an overlap are forces like the load are refused.
void check_roundings(const Model& m) {
  const Scene& scene = m.scene;
  if (scene.contact.law != ContactLaw::penalty || scene.slider.support != Support::free) return;
  if (!(m.slider.load_force > 0)) return;
  constexpr double share = 0.01;  // of the load
  const double rounding = 2 * std::numeric_limits<double>::epsilon() * largest_height(m);
  if (rounding * m.node_stiffness <= share * m.slider.load_force) return;
  throw refusal(
      scene, "contact.stiffness",
      fmt::format(
          "{} Pa/m makes forces of {:.3g} N of the roundings of an overlap, and the "
          "load is {:.3g} N: expected at most {:.3g} Pa/m",
          scene.contact.stiffness, rounding * m.node_stiffness, m.slider.load_force,
          scene.contact.stiffness * share * m.slider.load_force / (rounding * m.node_stiffness)));
}

}  // namespace

Model make_model(const Scene& scene) {
  Model m;
  m.scene = scene;
  m.resonator = make_body(scene.resonator);
  m.slider = make_body(scene.slider);
  m.doubts = scene_doubts(scene);
  m.resonator_height = surface_of("resonator", scene.resonator, scene, m.doubts);
  m.slider_height = surface_of("slider", scene.slider, scene, m.doubts);
  if (m.has_smooth_faces()) {
    m.resonator_curvature = spline_curvatures(m.resonator_height);
    m.slider_curvature = spline_curvatures(m.slider_height);
  }
  m.node_stiffness =
      scene.contact.stiffness * scene.spacing * std::min(scene.resonator.width, scene.slider.width);
  m.position = scene.start / scene.spacing;
  if (is_adaptive(scene))
    set_clock(m);
  else
    count_steps(m);
  cut_to_window(m);
  m.advance = scene.speed * m.tick / scene.spacing;

  if (scene.gap) {
    m.delta = *scene.gap;
  } else {
    // the smallest distance without overlap at t = 0
    m.delta = largest_overlap(m);
  }
  check_roundings(m);
  doubt_faces(m, m.doubts);
  doubt_sound(m, m.doubts);
  if (scene.contact.law == ContactLaw::penalty && scene.initial == Initial::rest)
    if (const double over = rest_overlap(m); over > 0)
      m.doubts.push_back(
          fmt::format("the faces overlap by {:.3g} m at t = 0 and start from rest: the contact "
                      "springs will throw "
                      "the bodies apart. scene.gap = \"touching\"{} does without",
                      over, has_equilibrium(scene) ? " or scene.initial = \"static\"" : ""));
  return m;
}

std::int64_t first_counted(const Model& model) {
  const double ticks = model.scene.output.from / model.tick;
  return static_cast<std::int64_t>(std::ceil(ticks * (1 - 1e-15)));  // 0.3/1e-8 is a whole number
}

double rest_overlap(const Model& model) {
  const double most = largest_overlap(model);
  return most > 64 * std::numeric_limits<double>::epsilon() * largest_height(model) ? most : 0.0;
}

int series_order(double tolerance) {
  return std::clamp(static_cast<int>(std::lround(4 - 1.25 * std::log10(tolerance))), 8, most_order);
}

std::vector<double> overlaps(const Model& m, const std::vector<double>& resonator_u,
                             const std::vector<double>& slider_u) {
  const double chi = m.scene.spacing;
  const int base = static_cast<int>(m.position);
  const double theta = m.position - base;
  std::vector<double> overlap(m.slider_height.size());
  for (int n = 0; n < m.nodes(); ++n) {
    const std::size_t left = std::min<std::size_t>(base + n, m.resonator_height.size() - 1);
    const std::size_t right = std::min<std::size_t>(left + 1, m.resonator_height.size() - 1);
    const FaceBetweenNodes<double> h2{m.resonator_height[left], m.resonator_height[right], theta};
    // of the faces; then the modes' displacements, one by one
    double sum = -gap(m.delta, m.slider_height[n], 0.0, h2, 0.0);
    for (std::size_t k = 0; k < resonator_u.size(); ++k) {
      if (resonator_u[k] == 0.0) continue;
      sum += resonator_u[k] * shape_at(m.resonator.modes[k], (m.position + n) * chi);
    }
    for (std::size_t k = 0; k < slider_u.size(); ++k) {
      if (slider_u[k] == 0.0) continue;
      sum += slider_u[k] * shape_at(m.slider.modes[k], n * chi);
    }
    overlap[n] = sum;
  }
  return overlap;
}

}  // namespace ra2d
