// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// The reference of all savings.
namespace ra2d {

/// Chooses it, how long every run is, and makes its first runs. Throws RequestError where the scene
/// cannot be run, SimulationError where the reference fails.
void set_reference(SavingsSearch& search);

/// Its answer: means over its runs, and how far one of them spreads.
void take_answer(SavingsSearch& search);

}  // namespace ra2d
