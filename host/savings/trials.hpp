// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// Trying out what to give up: a scene with one change against another, in pairs of runs.
namespace ra2d {

inline constexpr int first_pairs = 4, sure_pairs = 8;  // before a trial is judged, and given up

Trial changed(const std::string& key, const std::string& what, std::function<void(Scene&)> change,
              const Scene& from);

/// Runs both until the trial is judged, the time is up (`end`, as a share of the budget) or it
/// takes too long to tell. The cost is what one expects; 0: as of the base. Where even the first
/// pairs are not expected to end by `begin_by` (0: by `end`), nothing is run, and the trial says
/// so.
Trial try_out(SavingsSearch& search, Trial trial, const Runs& base, double end,
              double expected_cost = 0, double begin_by = 0);

/// Whether there was no time for a trial.
bool was_not_run(const Trial& trial);

}  // namespace ra2d
