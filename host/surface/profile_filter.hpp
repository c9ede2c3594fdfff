// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

namespace ra2d {

/// Mean line of the Gaussian profile filter (ISO 16610-21) at every point: the heights weighted
/// with
///     s(x) = exp(-pi (x/(alpha cutoff))^2) / (alpha cutoff),   alpha = sqrt(ln 2/pi),
/// which lets a sine of wavelength L through with exp(-pi (alpha cutoff/L)^2), half of it at the
/// cutoff. The bell is followed until it is below the roundings. Where it reaches beyond an end, a
/// line is fitted with the weights that are left (the norm's way to retain moments, of first
/// order), so that a straight line is its own mean line, to the ends. `spacing` and `cutoff` in m;
/// takes no longer for long cutoffs.
std::vector<double> gaussian_mean_line(const std::vector<double>& heights, double spacing,
                                       double cutoff);

/// The mean line of ISO 13565-1:1996, which deep valleys do not pull down: what lies below the mean
/// line of the Gaussian filter is lifted onto it, and the mean line of that is taken.
std::vector<double> mean_line_above_valleys(const std::vector<double>& heights, double spacing,
                                            double cutoff);

}  // namespace ra2d
