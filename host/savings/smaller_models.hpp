// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// Fewer modes and a coarser spacing, and more of both than written.
namespace ra2d {

/// Each until `end`, a share of the budget.
void find_modes(SavingsSearch& search, BodySpec Scene::*body, double end);
void find_spacing(SavingsSearch& search, double end);

/// How the scene as written stands: its own numerics, more modes, a finer spacing. Until `end`.
void look_beyond(SavingsSearch& search, double end);

}  // namespace ra2d
