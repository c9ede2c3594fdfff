// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/base/clock.hpp"
#include "host/chart/accuracy_chart.hpp"
#include "host/run/timed_run.hpp"

/// A chart of accuracy in the making: the state that all of its parts share.
namespace ra2d {

// The end of each part, as a share of the budget. A part begins a run only where it is expected to
// end by then (Survey::fits). The next parts have the time that one leaves. Without peers their
// share goes to the others, in proportion.
inline constexpr double reference_end = 0.15, stretch_end = 0.32, state_end = 0.45, peer_end = 0.65,
                        repeat_end = 0.85, long_end = 1.0;

inline constexpr const char* continuous_force = "continuous";  // where no steps are fixed

struct Survey {
  Survey(const Scene& scene, const AccuracyOptions& options);

  void say(const std::string& text) const;
  /// s of wall time since the survey began, and until a part must end (one of the shares above).
  double elapsed() const;
  double left(double end) const;
  /// Whether what is expected to take so many seconds may still begin.
  bool fits(double seconds, double end) const { return seconds <= left(end); }
  /// Equilibrium of the scene under a law; found once, with the first model.
  const ModalStart& start_of(ContactLaw law, const Model& model);
  /// The scene under another setting, or one that ends earlier (ending_at): all models share the
  /// faces of the first, which take long to make and much memory.
  Model model_of(const Scene& scene);
  TimedRun march(const Scene& scene, const RunLimits& limits = {});
  /// A method at a step four times finer than all that is compared, or a tolerance ten times so.
  Method finest(const Method& method) const;
  /// The point of a setting whose first stretch was timed; null without.
  const Measured* measured(const Method& setting) const;

  Scene scene;              // without what only files need
  AccuracyOptions options;  // steps, with the scene's own, and tolerances: the coarse ones first
  std::vector<Method> methods;
  AccuracyChart chart;

 private:
  std::optional<Model> made_;
  std::map<ContactLaw, ModalStart> starts_;
  const Clock::time_point begun_ = Clock::now();
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

/// The name of one of our settings in the chart.
Name name_of(const Method& setting);

/// Whether a run ended neither at its end nor at one of its limits.
bool has_failed(const TimedRun& run);

}  // namespace ra2d
