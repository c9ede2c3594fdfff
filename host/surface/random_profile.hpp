// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace ra2d {

/// Parameters of a random surface, those that the scene left open found. Lengths in m.
struct RandomProfile {
  Correlation correlation = Correlation::gaussian;
  double correlation_length = 0;  // gaussian, exponential: where the correlation is 1/e
  double hurst = 0;               // self-affine
  double longest = 0;             // self-affine: its longest wave
  double shortest = 0;            // the shortest wave that it has
  double rsm = 0;                 // mean distance of its crossings of the mean line, upwards
};

/// Parameters of `spec` on a beam of `length` [m]. Throws RequestError where they contradict each
/// other or no surface has them.
RandomProfile resolve_random(const SurfaceSpec& spec, double length);

/// Heights [m] at n spacing, n = 0 ... nodes - 1, of a random profile along a beam of `length` [m]:
/// a smooth function of x that the seed, the lengths and the moments fix; its mean over the beam is
/// 0 and its root mean square spec.rq. The correlation is of the heights as they come out, also
/// where they are not normal:
///   gaussian     exp(-(x/l)^2)
///   exponential  exp(-|x|/l), but for waves shorter than `shortest` (default: l/50), which are
///   left out self-affine  waves from `longest` to `shortest`, their density as k^-(1 + 2 hurst)
/// With normal heights and the Gaussian correlation the same bits on every platform (gaussian.hpp),
/// else within 1e-12 rq. `doubts` takes a sentence where nodes are too far apart to show the
/// shortest waves: where straight lines between them lose more than `most_slope_lost` of the root
/// mean square slope.
std::vector<double> random_heights(const SurfaceSpec& spec, double length, int nodes,
                                   double spacing, std::vector<std::string>* doubts = nullptr);

}  // namespace ra2d
