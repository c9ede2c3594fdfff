// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <span>

/// Roughness parameters of heights at even steps that are counted from the mean line, by one of two
/// standards. docs/surfaces.md has every formula. NaN where a parameter has no meaning.
namespace ra2d {

/// Whose definitions are taken.
enum class RoughnessStandard {
  iso21920,  // ISO 21920-2:2021: over the evaluation length, but for Rz, Rp and Rv
  iso4287  // ISO 4287:1997 and ISO 13565-2:1996: means over the sampling lengths, but for Rt and Rk
};

/// Its number, for people.
const char* name_of(RoughnessStandard standard);

struct Roughness {
  double ra, rq, rz, rt, rp, rv;  // m
  double rsk, rku;
  double rsm;           // m
  double rdq;           // m/m
  double rk, rpk, rvk;  // m
  double mr1, mr2;      // shares of the length, where the core begins and ends
};

/// `heights` [m] are the evaluation length, divided into as many equal `sections` (sampling
/// lengths). ISO 4287 counts from the mean line of the filter in each of them: they get no mean
/// line of their own.
Roughness roughness(std::span<const double> heights, double spacing, std::size_t sections,
                    RoughnessStandard standard = RoughnessStandard::iso21920);

/// Sizes that a part above or below the mean line must have in order to count.
struct ElementThresholds {
  double up, down;   // m
  double width = 0;  // m
};

/// Mean width of the profile elements. Parts at the ends that are cut off do not count.
double mean_spacing(std::span<const double> heights, double spacing,
                    const ElementThresholds& thresholds, bool both_directions = true);

/// Root mean square of the slopes from six neighbours, at the points from `begin` to before `end`.
/// At the three points at each end of all heights the seven outermost points serve.
double rms_slope(std::span<const double> heights, double spacing, std::size_t begin,
                 std::size_t end);
double rms_slope(std::span<const double> heights, double spacing);

/// Parts of the material ratio curve: a core, peaks above it, valleys below.
struct Core {
  double rk, rpk, rvk;    // m
  double peaks, valleys;  // shares of the length: Mrk1 and 1 - Mrk2
};
Core core(std::span<const double> heights);

/// Takes the parameters of a core.
void set_core(Roughness& parameters, const Core& parts);

/// Rmr(c): share of the heights at or above the level [m].
double material_ratio(std::span<const double> heights, double level);

}  // namespace ra2d
