// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// Trying out what to give up: a scene with one change against another, in pairs of runs.
namespace ra2d {

inline constexpr int first_pairs = 4, sure_pairs = 8;  // before a trial is judged, and given up

Trial changed(const std::string& key, const std::string& what, std::function<void(Scene&)> change,
              const Scene& from);

/// Runs both until the trial is judged, the time is up (`end`, as a share of the budget) or it takes
/// too long to tell. The cost is what one expects; 0: as of the base.
Trial try_out(SavingsSearch& search, Trial trial, const Runs& base, double end,
              double expected_cost = 0);

}  // namespace ra2d
