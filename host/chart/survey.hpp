// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/chart/accuracy_chart.hpp"
#include "host/run/timed_run.hpp"

/// A chart of accuracy in the making: what all of its parts use.
namespace ra2d {

// Shares of the budget; what the peers take comes off before.
inline constexpr double peer_share = 0.25, reference_share = 0.1, state_share = 0.15,
                        stretch_share = 0.5, long_share = 0.25;

inline constexpr const char* continuous_force = "continuous";  // where no steps are fixed

struct Survey {
  Survey(const Scene& scene, const AccuracyOptions& options);

  void say(const std::string& what) const;
  /// Equilibrium of the scene under a law; found once, with the first model.
  const ModalStart& start_of(ContactLaw law, const Model& model);
  TimedRun march(const Scene& scene, const RunLimits& limits = {});
  /// A method at a step four times finer than all that is compared, or a tolerance ten times so.
  Method finest(const Method& method) const;
  /// The point of a setting whose first stretch was timed; null without.
  const Measured* measured(const Method& setting) const;

  Scene scene;              // without what only files need
  AccuracyOptions options;  // steps, with the scene's own, and tolerances: the coarse ones first
  double budget;            // s, without the peers'
  std::vector<Method> methods;
  AccuracyChart chart;

 private:
  std::map<ContactLaw, ModalStart> starts_;
};

/// A row of the chart that can be measured.
struct ChartPoint {
  std::size_t row;
  Model model;
};

/// A setting that states are measured against, and its states.
struct StateReference {
  Method setting;
  std::string text;
  std::vector<std::optional<State>> states;  // one an instant; none where that took too long
};

/// What the chart calls a setting of ours.
Name name_of(const Method& setting);

/// Whether a run ended neither at its end nor at one of its limits.
bool failed(const TimedRun& run);

}  // namespace ra2d
