// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// All that was taken alone, taken together.
namespace ra2d {

/// Gives up again, the least valuable first, what is too much together; until `end`, a share of the
/// budget.
void take_together(SavingsSearch& search, double end);

}  // namespace ra2d
