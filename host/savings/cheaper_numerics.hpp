// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// The cheapest scheme and step that keep the answer.
namespace ra2d {

/// Tries them by what they cost, until `end`, a share of the budget.
void find_numerics(SavingsSearch& search, double end);

}  // namespace ra2d
