// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// The cheapest scheme and step that keep the answer.
namespace ra2d {

/// Tries what does if anything does, so that models can be compared under it: the scene's own
/// tolerance, or the usual one. Until `end`, a share of the budget.
void find_base(SavingsSearch& search, double end);

/// Tries all others that cost less than the scene as written, by what they cost, until `end`.
void find_numerics(SavingsSearch& search, double end);

}  // namespace ra2d
