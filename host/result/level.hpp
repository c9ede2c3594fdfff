// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/device/batch.hpp"
#include "host/model/model.hpp"

/// The level of the resonator's noise.
namespace ra2d {

/// Root mean square velocity of the resonator's elastic motion [m/s]: over its nodes, and over the
/// steps from `begin` (none: t = 0) to `end`; NaN where there is none. What a free body does as a whole is no noise.
/// The mean over nodes is taken mode by mode; cross terms between modes vanish for pinned modes on
/// a whole number of spacings, and are of the order of spacing/length otherwise.
double v_rms(const Model& model, const Snapshot& end, const Snapshot& begin = {});

/// Mean of psi_k^2 over a body's nodes, of each elastic mode [1/m], 0 of a rigid one.
std::vector<double> mean_squares(const Beam& beam, int nodes, double spacing);
/// Those of the resonator ...
std::vector<double> mean_squares(const Model& model);
/// ... and v_rms with them at hand, for many runs of bodies that are alike.
double v_rms(const std::vector<double>& mean_squares, const Snapshot& end,
             const Snapshot& begin = {});

/// 20 log10(v_rms / 1e-9 m/s) (paper, equation 12); -inf at rest.
double level(double v_rms);

}  // namespace ra2d
