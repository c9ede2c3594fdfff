// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// Fewer modes than written, and more modes and nodes than that.
namespace ra2d {

/// Until `end`, a share of the budget.
void find_modes(SavingsSearch& search, BodySpec Scene::*body, double end);

/// How the scene stands: its own numerics, more modes, a finer spacing. Until `end`.
void compare_with_larger_models(SavingsSearch& search, double end);

}  // namespace ra2d
