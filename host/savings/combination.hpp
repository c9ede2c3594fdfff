// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// All savings at once.
namespace ra2d {

/// Tries all savings at once. Where that moves the answer too far, it gives up one after the other,
/// the least valuable first. `end`: the share of the budget until which it may go on.
void combine_savings(SavingsSearch& search, double end);

}  // namespace ra2d
