// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/chart/survey.hpp"

/// The reference of a chart, and the instants at which states are compared with it.
namespace ra2d {

/// Finds the instants by a run of the reference, its states there, and how far off they are
/// themselves. Throws SimulationError where the reference fails.
StateReference find_reference(Survey& survey);

}  // namespace ra2d
