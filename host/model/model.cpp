// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/errors.hpp"
#include "host/model/areal_size.hpp"
#include "host/model/doubts.hpp"
#include "host/model/point_contacts.hpp"
#include "host/model/smooth_contact.hpp"
#include "host/scene/schemes.hpp"
#include "host/surface/map_face.hpp"
#include "host/surface/random_map.hpp"
#include "host/surface/spline.hpp"
#include "host/surface/surface.hpp"
#include "host/system/machine_memory.hpp"
#include "kernels/gap.hpp"
#include "kernels/tables.hpp"

namespace ra2d {
namespace {

/// The heights that `make` makes, its faults and doubts under the key of the face.
template <class Make>
auto face_of(const std::string& body, const BodySpec& spec, const Scene& scene,
             std::vector<std::string>& doubts, const Make& make) {
  const std::string key = body + ".surface";
  try {
    std::vector<std::string> odd;
    auto face = make(&odd);
    for (const std::string& what : odd)  // a measured face names its file
      doubts.push_back(spec.surface.kind == SurfaceKind::file ? what : key + ": " + what);
    return face;
  } catch (const RequestError& fault) {
    throw refusal(scene, key, fault.what());
  } catch (const FileError& fault) {
    throw FileError(place_of(scene, key) + ": " + key + ": " + fault.what());
  }
}

std::vector<double> surface_of(const std::string& body, const BodySpec& spec, const Scene& scene,
                               std::vector<std::string>& doubts) {
  return face_of(body, spec, scene, doubts, [&](std::vector<std::string>* odd) {
    return make_surface(spec.surface, spec.length, scene.spacing, scene.file, spec.thickness, odd);
  });
}

/// The maps of an areal scene's own surfaces. On the resonator they end where the slider does, or
/// little later.
HeightMaps maps_of(const Scene& scene, std::vector<std::string>& doubts) {
  require_areal_memory(scene, static_cast<double>(available_memory()));
  const double spacing_y = *scene.spacing_y, rows = map_rows(scene.slider.width, spacing_y);
  MapNodes nodes;
  nodes.length = scene.resonator.length;
  nodes.width = scene.slider.width;
  nodes.thickness = scene.resonator.thickness;
  nodes.spacing = scene.spacing;
  nodes.spacing_y = spacing_y;
  nodes.side = *scene.side;
  nodes.rows = static_cast<std::size_t>(rows);
  nodes.nx = static_cast<std::size_t>(last_node(scene)) + 1;
  // A map may begin where the slider starts, though roundings or the pairs of runs of
  // 'ra2d plan --accuracy' let it start a little in front of that.
  constexpr double in_front = 1e-3;  // of a spacing
  nodes.first = static_cast<std::size_t>(scene.start / scene.spacing + in_front);
  HeightMaps maps{static_cast<int>(rows), spacing_y, *scene.side, {}, {}};
  if (scene.faces == Faces::smooth) {
    // so that a spline does not feel where the run ends, but for the body's own end
    const auto whole = static_cast<std::size_t>(scene.resonator.length / scene.spacing) + 1;
    nodes.beyond = std::min<std::size_t>(spline_reach, std::max(whole, nodes.nx) - nodes.nx);
  }
  const auto face = [&](const char* name, const BodySpec& body) {
    return face_of(name, body, scene, doubts, [&](std::vector<std::string>* odd) {
      return map_face(body.surface, nodes, scene.file, odd);
    });
  };
  MapRows strip = face("resonator", scene.resonator);
  maps.resonator = std::move(strip.heights);
  maps.first = static_cast<int>(strip.first);
  maps.beyond = static_cast<int>(strip.nx - nodes.nx);
  nodes.length = scene.slider.length;
  nodes.thickness = scene.slider.thickness;
  nodes.side = 0;
  nodes.nx = static_cast<std::size_t>(nodes_along(scene));
  nodes.first = nodes.beyond = 0;
  maps.slider = face("slider", scene.slider).heights;
  return maps;
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

/// Refuses places without a y.
void require_y(const Scene& scene) {
  for (const MovingForce& force : scene.resonator.moving_forces)
    if (!force.y) throw refusal(scene, "resonator.moving_force", "has no y: expected one");
  for (const auto& [key, places] : {std::pair{"output.probes", &scene.output.probes},
                                    {"output.slider_probes", &scene.output.slider_probes}})
    for (const ProbePlace& place : *places)
      if (!place.y) throw refusal(scene, key, "a place without y: expected pairs, [x, y]");
}

/// Maps that are no whole rows, or not those of the bodies; a block that leaves the plate.
void check_maps(const Scene& scene, const HeightMaps& maps) {
  const auto refuse = [&](bool is_wrong, const char* key, const std::string& what) {
    if (is_wrong) throw refusal(scene, key, what);
  };
  refuse(!(maps.spacing_y > 0) || !std::isfinite(maps.spacing_y), "scene.spacing_y",
         fmt::format("{} m; expected a length above 0", maps.spacing_y));
  const double rows = map_rows(scene.slider.width, maps.spacing_y), along = nodes_along(scene);
  refuse(rows < 1, "scene.spacing_y",
         fmt::format("{} m is more than twice the slider's width; the slider has no row of nodes",
                     maps.spacing_y));
  refuse(along < 2, "scene.spacing",
         fmt::format("{} m leaves a row of the slider {:.0f} node: expected 2 or more",
                     scene.spacing, along));
  const auto whole = static_cast<std::size_t>(std::max(maps.rows, 1));
  refuse(static_cast<double>(maps.rows) != rows ||
             static_cast<double>(maps.slider.size()) != rows * along,
         "slider.surface",
         fmt::format("a map of {} heights in {} rows; expected {:.0f} rows of {:.0f}",
                     maps.slider.size(), maps.rows, rows, along));
  const double last = last_node(scene);
  const std::size_t length = maps.resonator.size() / whole;
  refuse(maps.resonator.size() % whole != 0 || !(scene.start >= 0) ||
             !(static_cast<double>(length) > last),
         "resonator.surface",
         fmt::format("a map of {} heights in {} rows; the slider reaches node {:.0f} of a row",
                     maps.resonator.size(), maps.rows, last));
  refuse(
      !(maps.side >= 0) || !(maps.side + scene.slider.width <= scene.resonator.width * (1 + 1e-12)),
      "scene.side",
      fmt::format("{} m: the slider, {} m wide, leaves the resonator, {} m wide", maps.side,
                  scene.slider.width, scene.resonator.width));
  // numbers of nodes, with what pads the rows for any number of lanes
  constexpr double lanes = 32, most = 0x1p31;
  const double padded =
      rows * (static_cast<double>(length) + along + 4 * lanes);  // as extents_of, and more
  refuse(padded >= most, "scene.spacing",
         fmt::format("maps of {:.3g} heights; expected at most {:.3g}: coarsen spacing or "
                     "spacing_y, or shorten the resonator",
                     padded, most));
  for (const auto& [key, heights] :
       {std::pair{"resonator.surface", &maps.resonator}, std::pair{"slider.surface", &maps.slider}})
    refuse(
        !std::all_of(heights->begin(), heights->end(), [](double h) { return std::isfinite(h); }),
        key, "a height that is not a number");
}

/// All that follows from bodies, faces and the stiffness of a node.
void make_ready(Model& m) {
  const Scene& scene = m.scene;
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
    m.delta = 0;
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
}

/// The splines along the rows of a face from node `first` on (spline_curvatures).
std::vector<double> row_curvatures(const std::vector<double>& height, int rows, int first = 0) {
  const std::size_t length = height.size() / rows;
  std::vector<double> curvature(height.size(), 0.0);
  for (int row = 0; row < rows; ++row) {
    const auto begin = static_cast<std::ptrdiff_t>(row * length);
    const std::vector<double> of_row = spline_curvatures(
        {height.begin() + begin + first, height.begin() + begin + static_cast<int>(length)});
    std::copy(of_row.begin(), of_row.end(), curvature.begin() + begin + first);
  }
  return curvature;
}

/// Rows without so many of their last numbers.
std::vector<double> shortened(std::vector<double> rows_of, int rows, int without) {
  if (without == 0) return rows_of;
  const std::size_t length = rows_of.size() / rows, kept = length - without;
  for (int row = 1; row < rows; ++row)
    std::copy_n(rows_of.begin() + static_cast<std::ptrdiff_t>(row * length), kept,
                rows_of.begin() + static_cast<std::ptrdiff_t>(row * kept));
  rows_of.resize(rows * kept);
  return rows_of;
}

/// `doubts`: of the maps.
Model areal_model(Scene scene, HeightMaps maps, std::vector<std::string> doubts) {
  check_maps(scene, maps);
  scene.spacing_y = maps.spacing_y;
  scene.side = maps.side;
  make_areal(scene);
  Model m;
  m.scene = std::move(scene);
  m.resonator = make_body(m.scene.resonator);
  m.slider = make_body(m.scene.slider);
  m.doubts = std::move(doubts);
  m.is_areal = true;
  m.rows = maps.rows;
  m.spacing_y = maps.spacing_y;
  m.side = maps.side;
  if (m.has_smooth_faces()) {
    m.resonator_curvature =
        shortened(row_curvatures(maps.resonator, m.rows, maps.first), m.rows, maps.beyond);
    m.slider_curvature = row_curvatures(maps.slider, m.rows);
  }
  m.resonator_height = shortened(std::move(maps.resonator), m.rows, maps.beyond);
  m.slider_height = std::move(maps.slider);
  m.node_stiffness = m.scene.contact.stiffness * m.scene.spacing * m.spacing_y;
  make_ready(m);
  return m;
}

}  // namespace

Model make_model(const Scene& scene) {
  if (scene.kind == SceneKind::areal) {
    require_y(scene);
    std::vector<std::string> doubts = scene_doubts(scene);
    HeightMaps maps = maps_of(scene, doubts);
    Model m = areal_model(scene, std::move(maps), std::move(doubts));
    if (std::string doubt = doubt_mesh(m); !doubt.empty()) m.doubts.push_back(std::move(doubt));
    return m;
  }
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
  make_ready(m);
  return m;
}

Model make_model(const Scene& scene, const HeightMaps& maps) {
  require_y(scene);
  return areal_model(scene, maps, {});
}

Model with_settings(const Model& made, const Scene& scene) {
  Model m = made;
  m.scene.time = scene.time;
  m.scene.output = scene.output;
  m.scene.contact.law = scene.contact.law;
  m.scene.duration = scene.duration;
  make_ready(m);
  m.doubts = made.doubts;
  return m;
}

std::int64_t first_counted(const Model& model) {
  const double ticks = model.scene.output.from / model.tick;
  return static_cast<std::int64_t>(std::ceil(ticks * (1 - 1e-15)));  // 0.3/1e-8 is a whole number
}

double largest_height(const Model& m) {
  double size = std::abs(m.delta);
  for (const SharedNumbers* face : {&m.resonator_height, &m.slider_height})
    for (const double h : *face) size = std::max(size, std::abs(h));
  return size;
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
    const int row = n / m.row_nodes(), i = n % m.row_nodes();
    const double* const face =
        m.resonator_height.data() + static_cast<std::size_t>(row) * m.row_heights();
    const int left = std::min(base + i, m.row_heights() - 1);
    const int right = std::min(left + 1, m.row_heights() - 1);
    const FaceBetweenNodes<double> h2{face[left], face[right], theta};
    overlap[n] = -gap(m.delta, m.slider_height[n], 0.0, h2, 0.0);
  }
  // mode by mode, each found once along a row and once across the rows
  std::vector<double> along(m.row_nodes());
  const auto add = [&](const BodyMode& mode, double u, double x, double y) {
    if (u == 0.0) return;
    for (int i = 0; i < m.row_nodes(); ++i) along[i] = shape_at(mode, (x + i) * chi);
    double* to = overlap.data();
    for (int row = 0; row < m.rows; ++row) {
      double across = 0;
      mode.shape->evaluate_across(y + m.eta(row), 1, &across);
      for (int i = 0; i < m.row_nodes(); ++i) *to++ += u * (along[i] * across);
    }
  };
  for (std::size_t k = 0; k < resonator_u.size(); ++k)
    add(m.resonator.modes[k], resonator_u[k], m.position, m.side);
  for (std::size_t k = 0; k < slider_u.size(); ++k) add(m.slider.modes[k], slider_u[k], 0.0, 0.0);
  return overlap;
}

}  // namespace ra2d
