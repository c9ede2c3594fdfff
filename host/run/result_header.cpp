// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/result_header.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "host/base/text.hpp"
#include "host/body/plate.hpp"
#include "host/device/backend.hpp"
#include "host/run/v_rms.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

/// The shapes at evenly spaced nodes, at most 1001 of them.
ModesHeader make_modes(const Body& body, std::size_t nodes, double spacing) {
  constexpr std::size_t most_places = 1001;
  const std::size_t stride =
      std::max<std::size_t>(1, (nodes + most_places - 3) / (most_places - 1));
  ModesHeader header;
  for (std::size_t n = 0; n < nodes; n += stride)
    header.position.push_back(static_cast<double>(n) * spacing);
  for (const BodyMode& mode : body.modes) {
    header.frequency.push_back(mode.omega / (2 * M_PI));
    for (const double x : header.position) header.shape.push_back(shape_at(mode, x));
  }
  header.mean_square = mean_squares(body, static_cast<int>(nodes), spacing);
  return header;
}

/// Shapes of an areal body are products of one along x and one along y: at evenly spaced places, 16
/// to the shortest half wave but at most 1001.
ModesHeader areal_modes(const Body& body, const BodySpec& spec, double spacing) {
  ModesHeader header;
  for (const BodyMode& mode : body.modes) header.frequency.push_back(mode.omega / (2 * M_PI));
  if (spec.kind == BodyKind::plate)
    for (const PinnedPlateMode& mode : plate_modes(spec, static_cast<int>(body.modes.size()))) {
      header.mode_x.push_back(mode.m);
      header.mode_y.push_back(mode.n);
    }
  const auto places = [](double length, const std::vector<double>& half_waves) {
    constexpr double fewest = 64, most = 1000, of_a_half_wave = 16;
    double parts = fewest;
    for (const double waves : half_waves) parts = std::max(parts, of_a_half_wave * waves);
    parts = std::min(parts, most);
    std::vector<double> found;
    for (int i = 0; i <= static_cast<int>(parts); ++i) found.push_back(i / parts * length);
    return found;
  };
  header.position = places(spec.length, header.mode_x);
  header.y = places(spec.width, header.mode_y);
  for (const BodyMode& mode : body.modes) {
    for (const double x : header.position) header.shape_x.push_back(shape_at(mode, x));
    for (const double y : header.y)
      mode.shape->evaluate_across(y, 1, &header.shape_y.emplace_back());
  }
  header.mean_square = mean_squares(body, 1, spacing);
  return header;
}

/// Places along a body, and across it.
void split(const std::vector<ProbePlace>& places, std::vector<double>& x, std::vector<double>& y) {
  for (const ProbePlace& place : places) {
    x.push_back(place.x);
    if (place.y) y.push_back(*place.y);
  }
}

}  // namespace

ResultHeader result_header(const Model& model, const std::string& key) {
  ResultHeader header;
  header.scene = echo(model.scene);
  header.key = key;
  header.backend = backend_name();
  header.threads = backend_threads();
  for (const std::string& doubt : model.doubts)
    header.doubts += (header.doubts.empty() ? "" : "\n") + printable(doubt);
  header.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  const double spacing = model.scene.spacing;
  if (model.is_areal) {
    header.resonator = areal_modes(model.resonator, model.scene.resonator, spacing);
    header.slider = areal_modes(model.slider, model.scene.slider, spacing);
    header.is_areal = true;
    header.rows = model.rows;
    header.spacing_y = model.spacing_y;
    header.side = model.side;
  } else {
    header.resonator = make_modes(model.resonator, model.resonator_height.size(), spacing);
    header.slider = make_modes(model.slider, model.slider_height.size(), spacing);
  }
  split(model.scene.output.probes, header.probe_position, header.probe_y);
  split(model.scene.output.slider_probes, header.slider_probe_position, header.slider_probe_y);
  header.resonator_height = model.resonator_height;
  header.slider_height = model.slider_height;
  header.spacing = spacing;
  header.modes = model.scene.output.modes;
  header.precision = model.scene.output.precision;
  header.compression = model.scene.output.compression;
  return header;
}

}  // namespace ra2d
