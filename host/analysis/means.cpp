// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/means.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "host/analysis/distributions.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/scene_file/shared_stretch.hpp"

namespace ra2d {
namespace {

/// The scene as text, without its numerics, what is stored of it and what chooses among faces of
/// one roughness.
std::string text_without_faces(Scene scene) {
  scene = without_place(std::move(scene));
  for (SurfaceSpec* face : {&scene.resonator.surface, &scene.slider.surface}) {
    face->seed = 0;
    face->path.clear();
    face->prepared.row.reset();
    face->prepared.column.reset();
  }
  return echo(scene);
}

/// Of different runs that touch a part of the same faces; empty where there are none.
std::string doubt_of_stretches(const std::vector<const Analysis*>& runs) {
  std::vector<Scene> scenes;
  for (const Analysis* one : runs) scenes.push_back(*one->scene);
  const auto two = two_on_one_stretch(scenes);
  if (!two) return {};
  return fmt::format(
      "{} and {} touch a part of the same faces: the means take them for independent, and their "
      "intervals are too narrow. Let starts lie {:.4g} m apart or more (the slider's length and "
      "what it slides), or leave one out",
      runs[two->first]->file.string(), runs[two->second]->file.string(),
      touched_length(scenes.front()));
}

/// Equal for results of one run.
std::string run_of(const Analysis& a) {
  std::error_code none;
  return a.key.empty() ? std::filesystem::weakly_canonical(a.file, none).string() : a.key;
}

struct Figure {
  const char *name, *unit;
  double (*of)(const Analysis&);
  Values kind;
};

constexpr Figure figures[] = {
    {"lv", "dB", [](const Analysis& a) { return a.lv; }, Values::any},
    {"v_rms", "m/s", [](const Analysis& a) { return a.v_rms; }, Values::positive},
    {"lv_a", "dB", [](const Analysis& a) { return a.lv_a; }, Values::any},
    {"contact_share", "1", [](const Analysis& a) { return a.contact_share; }, Values::share},
    {"shocks.rate", "1/s", [](const Analysis& a) { return a.shocks.rate; }, Values::positive},
    {"shocks.duration.median", "s", [](const Analysis& a) { return a.shocks.duration.median; },
     Values::positive},
    {"shocks.peak_force.median", "N", [](const Analysis& a) { return a.shocks.peak_force.median; },
     Values::positive},
    {"shocks.impulse.median", "N s", [](const Analysis& a) { return a.shocks.impulse.median; },
     Values::positive},
    {"shocks.simultaneous.mean", "1", [](const Analysis& a) { return a.shocks.at_once_mean; },
     Values::positive},
    {"energy.sliding_power", "W", [](const Analysis& a) { return a.energy.sliding; }, Values::any},
    {"energy.damping_power", "W", [](const Analysis& a) { return a.energy.damping; },
     Values::positive},
    {"energy.per_shock", "J", [](const Analysis& a) { return a.energy_per_shock; }, Values::any},
};

/// Of each microphone that all have, and of the power.
void add_means_of_sound(const std::vector<Analysis>& analyses, std::vector<FigureOfRuns>& means) {
  const auto add = [&](const std::string& name, auto of) {
    std::vector<double> values;
    for (const Analysis& analysis : analyses) values.push_back(of(analysis));
    means.push_back({name, "dB", mean_of_runs(values)});
  };
  if (analyses.empty()) return;
  std::size_t microphones = analyses.front().microphones.size();
  for (const Analysis& a : analyses) microphones = std::min(microphones, a.microphones.size());
  for (std::size_t i = 0; i < microphones; ++i) {
    add(fmt::format("microphones.{}.lp", i + 1),
        [i](const Analysis& a) { return a.microphones[i].lp; });
    add(fmt::format("microphones.{}.lpa", i + 1),
        [i](const Analysis& a) { return a.microphones[i].lp_a; });
  }
  if (!analyses.front().power) return;
  add("power.lw", [](const Analysis& a) { return a.power->lw; });
  add("power.lwa", [](const Analysis& a) { return a.power->lw_a; });
}

}  // namespace

MeanOfRuns mean_of_runs(const std::vector<double>& values, Values kind) {
  MeanOfRuns m{0, 0, quiet_nan, quiet_nan, quiet_nan};
  double sum = 0, squares = 0, least = quiet_nan, most = quiet_nan;
  for (const double value : values)
    if (!std::isnan(value)) {
      sum += value;
      least = std::fmin(least, value);
      most = std::fmax(most, value);
      ++m.count;
    }
  const auto n = static_cast<double>(m.count);
  m.mean = sum / n;  // of none: NaN
  if (m.count < 2) return m;
  for (const double value : values)
    if (!std::isnan(value)) squares += (value - m.mean) * (value - m.mean);
  m.deviation = std::sqrt(squares / (n - 1));
  if (least == most) return m;  // no scatter shows no chance
  const double half =
      student_quantile((1 + confidence_of_means) / 2, n - 1) * m.deviation / std::sqrt(n);
  if (kind == Values::any) {
    m.low = m.mean - half;
    m.high = m.mean + half;
  } else if (kind == Values::share) {
    // a logit changes by 1/slope of what its share does
    const double slope = m.mean * (1 - m.mean);
    const double odds = m.mean / (1 - m.mean), factor = slope > 0 ? std::exp(half / slope) : 1;
    m.low = odds / (odds + factor);
    m.high = odds * factor / (1 + odds * factor);
    if (std::isinf(factor)) m.low = 0, m.high = 1;
  } else if (m.mean > 0) {
    m.low = m.mean * std::exp(-half / m.mean);
    m.high = m.mean * std::exp(half / m.mean);
  }
  return m;
}

std::vector<FigureOfRuns> means_of(const std::vector<Analysis>& analyses) {
  std::vector<FigureOfRuns> means;
  for (const Figure& figure : figures) {
    std::vector<double> values;
    for (const Analysis& analysis : analyses) values.push_back(figure.of(analysis));
    const MeanOfRuns mean = mean_of_runs(values, figure.kind);
    if (mean.count > 0) means.push_back({figure.name, figure.unit, mean});
  }
  add_means_of_sound(analyses, means);
  return means;
}

std::vector<std::string> doubts_of_means(const std::vector<Analysis>& analyses) {
  std::vector<std::string> doubts;
  std::map<std::string, std::vector<const Analysis*>> runs;
  for (const Analysis& one : analyses) runs[run_of(one)].push_back(&one);
  for (const auto& [key, results] : runs)
    if (results.size() > 1)
      doubts.push_back(fmt::format(
          "{}{} {}{} are of one run: in the means it counts {} times, and their intervals are too "
          "narrow. Leave out all but one",
          results[0]->file.string(), results.size() > 2 ? "," : " and", results[1]->file.string(),
          results.size() > 2 ? fmt::format(" and {} more", results.size() - 2) : "",
          results.size()));
  if (analyses.size() < 2 || !analyses.front().scene) return doubts;
  const std::string first = text_without_faces(*analyses.front().scene);
  const auto other = std::find_if(analyses.begin() + 1, analyses.end(), [&](const Analysis& one) {
    return one.scene && text_without_faces(*one.scene) != first;
  });
  if (other != analyses.end())
    doubts.push_back(
        fmt::format("{} and {} are of scenes that differ in more than their faces ('ra2d compare' "
                    "shows in what): the means mix them",
                    analyses.front().file.string(), other->file.string()));
  std::vector<const Analysis*> with_scene;
  for (const Analysis& one : analyses)
    if (one.scene && runs[run_of(one)].front() == &one) with_scene.push_back(&one);
  if (std::string doubt = doubt_of_stretches(with_scene); !doubt.empty())
    doubts.push_back(std::move(doubt));
  return doubts;
}

}  // namespace ra2d
