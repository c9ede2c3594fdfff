// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/device/batch.hpp"
#include "host/model/model.hpp"
#include "host/result/mean_squares.hpp"

/// The velocity of the resonator's noise.
namespace ra2d {

/// Mean squares of a body's modes, found on a thread of their own where that is worth one.
MeanSquares mean_squares(const Body& body, int nodes, double spacing);
/// Mean squares of the resonator's modes, found at once.
std::vector<double> mean_squares(const Model& model);

/// Root mean square velocity of the resonator's elastic motion [m/s] (paper, equation 13): over its
/// nodes, and over the steps from `begin` (none: t = 0) to `end`; NaN where there is no step. The
/// motion of a free body as a whole is no noise. The mean over nodes is taken mode by mode: cross
/// terms between modes vanish for pinned modes on a whole number of spacings, and are of the order
/// of spacing/length otherwise.
double v_rms(const std::vector<double>& mean_squares, const Snapshot& end,
             const Snapshot& begin = {});
double v_rms(const Model& model, const Snapshot& end, const Snapshot& begin = {});

/// Estimate of the root mean square displacement of that motion about its mean [m]: each mode's
/// velocity over its angular frequency, as where it swings freely.
double displacement_rms(const Model& model, const std::vector<double>& mean_squares,
                        const Snapshot& end, const Snapshot& begin = {});

}  // namespace ra2d
