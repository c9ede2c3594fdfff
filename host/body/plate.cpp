// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/plate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <queue>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/body/areal_shape.hpp"
#include "host/scene/hertz.hpp"

namespace ra2d {
namespace {

using std::numbers::pi;

double mass_per_area(const BodySpec& spec) { return spec.density * spec.thickness; }

/// sqrt(D/mu) pi^2 [m^2/s]: omega over m^2/a^2 + n^2/b^2.
double plate_wave_factor(const BodySpec& spec) {
  const double nu = spec.poisson.value_or(usual_poisson);
  if (!(nu > -1 && nu < 0.5))
    throw RequestError("poisson of a plate is " + std::to_string(nu) +
                       "; expected a number between -1 and 0.5, both excluded (steel: 0.3)");
  const double stiffness = spec.young * std::pow(spec.thickness, 3) / (12 * (1 - nu * nu));
  return std::sqrt(stiffness / mass_per_area(spec)) * pi * pi;
}

}  // namespace

bool has_plate_modes(const BodySpec& spec) {
  const double nu = spec.poisson.value_or(usual_poisson);
  return nu > -1 && nu < 0.5 && spec.length <= most_slender_plate * spec.width &&
         spec.width <= most_slender_plate * spec.length;
}

std::vector<PinnedPlateMode> plate_modes(const BodySpec& spec, int most) {
  if (spec.support == Support::rigid || !(spec.modes || spec.max_frequency)) return {};
  const double factor = plate_wave_factor(spec);
  const auto mode = [&](int m, int n) {
    const double along = m / spec.length, across = n / spec.width;
    return PinnedPlateMode{m, n, factor * (along * along + across * across)};
  };
  const auto is_kept = [&](const PinnedPlateMode& of) {
    return spec.modes || of.omega / (2 * pi) <= *spec.max_frequency;
  };
  const auto wanted = static_cast<std::size_t>(std::min(spec.modes.value_or(most), most));
  // One mode is as high as another where only roundings, four of each, part them.
  constexpr double same = 1 + 8 * std::numeric_limits<double>::epsilon();

  // Next comes the lowest of what follows on a mode already taken: n + 1, and m + 1 where n is 1.
  const auto is_later = [](const PinnedPlateMode& a, const PinnedPlateMode& b) {
    return a.omega != b.omega ? a.omega > b.omega : a.m > b.m;
  };
  std::priority_queue<PinnedPlateMode, std::vector<PinnedPlateMode>, decltype(is_later)> next(
      is_later);
  next.push(mode(1, 1));
  std::vector<PinnedPlateMode> modes;
  while (is_kept(next.top()) &&
         (modes.size() < wanted ||
          (!modes.empty() && next.top().omega <= modes.back().omega * same))) {
    const PinnedPlateMode taken = next.top();
    next.pop();
    modes.push_back(taken);
    next.push(mode(taken.m, taken.n + 1));
    if (taken.n == 1) next.push(mode(taken.m + 1, 1));
  }
  for (auto first = modes.begin(); first != modes.end();) {
    auto last = first + 1;
    while (last != modes.end() && last->omega <= (last - 1)->omega * same) ++last;
    std::sort(first, last,
              [](const PinnedPlateMode& a, const PinnedPlateMode& b) { return a.m < b.m; });
    first = last;
  }
  modes.resize(std::min(modes.size(), wanted));
  return modes;
}

Body make_plate(const BodySpec& spec) {
  if (spec.support == Support::free)
    throw RequestError("a plate with free edges has no modes in closed form; use \"pinned\"");
  Body plate;
  plate.length = spec.length;
  plate.mass = mass_per_area(spec) * spec.length * spec.width;
  plate.load_force = load_force(spec, plate.mass);
  const std::vector<PinnedPlateMode> modes = plate_modes(spec, most_elastic_modes + 1);
  check_mode_count(static_cast<int>(modes.size()));
  const double area = spec.length * spec.width;
  for (const PinnedPlateMode& mode : modes) {
    auto shape = std::make_shared<ArealShape>();
    shape->along.length = spec.length;
    shape->along.beta = mode.m * pi / spec.length;
    shape->along.sine = shape->along.highest = 2 / std::sqrt(area);
    shape->width = spec.width;
    shape->wave = mode.n * pi / spec.width;
    // W/(a b) times the integral of psi: (1 - cos m pi)/beta along x, as much along y
    const bool is_loaded = mode.m % 2 == 1 && mode.n % 2 == 1;
    plate.load.push_back(is_loaded ? plate.load_force / area * shape->along.sine * 4 /
                                         (shape->along.beta * shape->wave)
                                   : 0.0);
    plate.modes.push_back({{mode.omega, spec.damping, mass_per_area(spec)}, shape});
  }
  return plate;
}

double plate_frequency(const BodySpec& spec, int k) {
  if (spec.support == Support::rigid) return std::numeric_limits<double>::infinity();
  BodySpec first = spec;
  first.modes = k + 1;
  first.max_frequency.reset();
  return plate_modes(first, k + 1).back().omega / (2 * pi);
}

}  // namespace ra2d
