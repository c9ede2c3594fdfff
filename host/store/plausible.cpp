// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/plausible.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/result/level.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

constexpr double slack = 1e-6;        // of the run's time, and of a body's length: for roundings
constexpr double rate_slack = 1e-3;   // of the scene's rate, as of the places of samples
constexpr double level_slack = 1e-9;  // dB: roundings of a logarithm of another library

/// The scene that bounds times and places; none where this program does not understand it.
std::optional<Scene> scene_in(const ResultContents& contents) try {
  return parse_echo(contents.scene, "the scene of the result");
} catch (const RequestError&) {
  return std::nullopt;
}

bool within(double value, double low, double high) { return value >= low && value <= high; }

bool are_finite_and_not_negative(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](double value) { return value >= 0 && is_of_a_run(value); });
}

/// The first fault of modes and probes.
std::string fault_of_bodies(const ResultContents& c, const std::optional<Scene>& scene) {
  if (!are_finite_and_not_negative(c.resonator_frequency))
    return "/resonator/frequency has a value that is no frequency";
  if (!are_finite_and_not_negative(c.slider_frequency))
    return "/slider/frequency has a value that is no frequency";
  if (!are_finite_and_not_negative(c.mean_square))
    return "/resonator/mean_square has a value that is no mean of squares";
  const double unbounded = std::numeric_limits<double>::max();
  const auto outside = [](const std::vector<double>& places, double length) {
    return !std::all_of(places.begin(), places.end(),
                        [&](double x) { return within(x, -slack * length, (1 + slack) * length); });
  };
  if (outside(c.probe_position, scene ? scene->resonator.length : unbounded))
    return "/probes/position has a place outside the resonator";
  if (outside(c.slider_probe_position, scene ? scene->slider.length : unbounded))
    return "/slider_probes/position has a place outside the slider";
  if (outside(c.probe_y, scene ? scene->resonator.width : unbounded))
    return "/probes/y has a place outside the resonator";
  if (outside(c.slider_probe_y, scene ? scene->slider.width : unbounded))
    return "/slider_probes/y has a place outside the slider";
  return {};
}

/// Steps may end one beyond the duration, and a shock lasts to the end of its last step.
double latest_time(const std::optional<Scene>& scene) {
  return scene ? (1 + slack) * scene->duration + 2 * scene->time.step
               : std::numeric_limits<double>::max();
}

/// The first fault of the samples' times and of the shocks.
std::string fault_of_times(const ResultContents& c, const std::optional<Scene>& scene) {
  const double end = latest_time(scene);
  const double length = scene ? scene->resonator.length : std::numeric_limits<double>::max();
  const double width = scene ? scene->resonator.width : std::numeric_limits<double>::max();
  const double aside = scene ? scene->spacing : 0;
  if (c.samples > 0 && !within(c.end, 0, end))
    return fmt::format("its samples end at {} s, which is no time of the run", c.end);
  if (scene && !std::isnan(c.rate) && std::abs(c.rate / scene->output.rate - 1) > rate_slack)
    return fmt::format("it has {} samples a second, and its scene asks for {}", c.rate,
                       scene->output.rate);
  for (const Shock& shock : c.shocks) {
    if (!within(shock.start, 0, end))
      return fmt::format("a shock begins at {} s, which is no time of the run", shock.start);
    if (!within(shock.duration, 0, end - shock.start + slack * end))
      return fmt::format("a shock that begins at {} s lasts {} s, which is beyond the run",
                         shock.start, shock.duration);
    if (!within(shock.position, -aside - slack * length, (1 + slack) * length + aside))
      return fmt::format("a shock is at {} m, outside the resonator", shock.position);
    if (!within(shock.y, -slack * width, (1 + slack) * width))
      return fmt::format("a shock is at y = {} m, outside the resonator", shock.y);
  }
  return {};
}

/// The first fault of the figures. Missing ones are NaN. A run that failed may have infinite ones.
std::string fault_of_summary(const ResultSummary& s, const std::optional<Scene>& scene) {
  if (!(std::isnan(s.v_rms) || s.v_rms >= 0))
    return fmt::format("its velocity is {} m/s: expected no negative number", s.v_rms);
  if (const double expected = level(s.v_rms);
      std::isnan(s.lv) != std::isnan(s.v_rms) ||
      (std::isfinite(expected) ? std::abs(s.lv - expected) > level_slack
                               : !std::isnan(s.lv) && s.lv != expected))
    return fmt::format("its level is {} dB, and that of its velocity of {} m/s is {} dB", s.lv,
                       s.v_rms, expected);
  for (const auto& [name, value] : {std::pair{"shock_rate", s.shock_rate},
                                    {"shock_duration_median", s.shock_duration_median},
                                    {"shock_duration_90", s.shock_duration_90},
                                    {"peak_force_median", s.peak_force_median},
                                    {"peak_force_90", s.peak_force_90},
                                    {"contact_share", s.contact_share},
                                    {"nodes_evaluated", s.nodes_evaluated},
                                    {"step_seconds", s.step_seconds},
                                    {"wall_seconds", s.wall_seconds},
                                    {"steps", static_cast<double>(s.steps)}})
    if (!(std::isnan(value) || (value >= 0 && (!s.complete || std::isfinite(value)))))
      return fmt::format("its {} is {}, which no run comes to", name, value);
  for (const auto& [name, value] : {std::pair{"lv_low", s.lv_low},
                                    {"lv_high", s.lv_high},
                                    {"shock_rate_low", s.shock_rate_low},
                                    {"shock_rate_high", s.shock_rate_high},
                                    {"energy_residual", s.energy_residual},
                                    {"energy_turnover", s.energy_turnover},
                                    {"energy_closure", s.energy_closure}})
    if (s.complete && std::isinf(value))
      return fmt::format("its {} is {}, which no run comes to", name, value);
  if (s.shock_rate > 0 && s.shock_rate * latest_time(scene) < 1)
    return fmt::format("its shock_rate is {} a second: less than one shock in the run",
                       s.shock_rate);
  if (s.contact_share > 1 + slack)
    return fmt::format("its contact_share is {}: expected at most 1", s.contact_share);
  return {};
}

}  // namespace

bool is_of_a_run(double value) { return std::abs(value) < 1e100; }

std::string implausible(const ResultContents& contents) {
  const std::optional<Scene> scene = scene_in(contents);
  for (const std::string& fault :
       {fault_of_bodies(contents, scene), fault_of_times(contents, scene),
        fault_of_summary(contents.summary, scene)})
    if (!fault.empty()) return fault;
  return {};
}

}  // namespace ra2d
