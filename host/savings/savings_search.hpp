// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string>

#include "host/base/clock.hpp"
#include "host/savings/savings.hpp"

/// A search for savings on its way: the state that all of its parts share.
namespace ra2d {

/// The share of the budget at which runs are cut off. The rest is for the final timings.
inline constexpr double runs_end = 0.96;

using Runs = std::shared_ptr<Ensemble>;

struct SavingsSearch {
  SavingsSearch(const Scene& scene, const SavingsOptions& options);

  /// Share of the budget that is used up.
  double spent() const;
  /// Seconds until that share is `end`.
  double left(double end) const { return (end - spent()) * options.budget; }
  /// Share of the budget at which a part must stop, so that `parts` more get as much until `end`.
  double next_end(double end, double parts) const;
  void say(const std::string& text) const;
  /// A scene as it is run here: as long as all of them, and without what only files need.
  Scene for_runs(Scene scene) const;
  /// The whole scene with other numerics.
  Scene marched(const TimeSettings& time) const;
  TimeSettings adaptive(double tolerance) const;

  const Scene whole;  // the scene as written, with the reference's faces
  const SavingsOptions options;
  TimeSettings plain;     // the scene's own, as far as the answer goes
  double cost_whole = 0;  // as of Ensemble, before any trial: what a saving must be below
  Runs reference, base;   // base: with the numerics that were chosen
  Runs last;              // of the last trial
  Savings out;

 private:
  const Clock::time_point begun_;
};

/// For people: scheme and step.
std::string text_of(const Scene& scene);

/// Throws RequestError where a scene cannot be marched.
void require_possible(const Scene& scene);

}  // namespace ra2d
