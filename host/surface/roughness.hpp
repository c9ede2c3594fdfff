// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>

/// Roughness parameters of ISO 21920-2, of heights at even steps that are counted from the mean line.
/// docs/surfaces.md has every formula. NaN where a parameter has no meaning.
namespace ra2d {

/// What counts as a profile element.
enum class ElementRule {
  iso21920,  // above 10 % of Rp and below 10 % of Rv; both ways through the profile
  iso4287    // 10 % of Rz up and down, and 1 % of a sampling length wide; from the left
};

struct Roughness {
  double ra, rq, rz, rt, rp, rv;  // m
  double rsk, rku;
  double rsm;           // m
  double rdq;           // m/m
  double rk, rpk, rvk;  // m
};

/// `heights` [m] are the evaluation length, divided into as many equal `sections` (sampling lengths).
Roughness roughness(std::span<const double> heights, double spacing, std::size_t sections,
                    ElementRule rule = ElementRule::iso21920);

/// What a part of the profile above or below the mean line must reach in order to count.
struct ElementThresholds {
  double up, down;   // m
  double width = 0;  // m
};

/// Mean width of the profile elements. Parts at the ends that are cut off do not count.
double mean_spacing(std::span<const double> heights, double spacing,
                    const ElementThresholds& thresholds, bool both_ways = true);

/// Root mean square of the slopes from six neighbours. At the three points at each end the seven
/// outermost points serve.
double rms_slope(std::span<const double> heights, double spacing);

/// What the material ratio curve is made of: a core, peaks above it, valleys below.
struct Core {
  double rk, rpk, rvk;    // m
  double peaks, valleys;  // shares of the length: Mrk1 and 1 - Mrk2
};
Core core(std::span<const double> heights);

/// Rmr(c): share of the heights at or above the level [m].
double material_ratio(std::span<const double> heights, double level);

}  // namespace ra2d
