// SPDX-License-Identifier: BSD-3-Clause
// White noise xi_ij stands on a grid of places, a quarter of the correlation length apart, and the
// map is the sum of xi_ij bell(x - i) bell(y - j), x and y in places (host/surface/bells.hpp). The
// bells are products: a tile of points takes the sums along x for each row of noise that it needs,
// then the sums along y. No more than a tile's sums are held.
// Every step is one that IEEE 754 defines exactly, in an order that depends on x and y alone. Needs
// -ffp-contract=off.
#include "host/surface/random_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "host/base/errors.hpp"
#include "host/surface/bells.hpp"
#include "host/surface/gaussian.hpp"
#include "host/surface/portable.hpp"
#include "host/surface/profile.hpp"
#include "host/surface/random_profile.hpp"
#include "host/surface/sum.hpp"
#include "host/surface/surface.hpp"
#include "host/system/blocks.hpp"

namespace ra2d {
namespace {

constexpr int bell_range = Bells::half_width;
constexpr std::size_t bells_at_a_point = 2 * bell_range + 1;
// Of the product of two bells: beyond, exp(-overlap^2/16) = 1e-17 of it is left.
constexpr int overlap = 25;
constexpr std::size_t tile_columns = 512, tile_rows = 512, side_by_side = 16;
constexpr double least_points = 4;    // of a wave, as in a scene (host/scene_file/checks.cpp)
constexpr double longest_wave = 100;  // correlation lengths, of the area: beyond, it is bent
constexpr double most_noise_places = 1e9;
constexpr double rsm_of_length = std::numbers::sqrt2 * std::numbers::pi;

/// The next multiple of side_by_side.
std::size_t in_groups(std::size_t count) {
  return (count + side_by_side - 1) / side_by_side * side_by_side;
}

/// The bells that a point is in range of, from the first on.
struct BellsThere {
  std::int64_t first;  // place
  std::array<double, bells_at_a_point> value;
};

/// At `x` [places]: bell k is exp(-(a - k)^2/8), a from the nearest place.
BellsThere bells_there(double x) {
  static const auto bell = [] {
    std::array<double, bell_range + 1> values{};
    for (int k = 0; k <= bell_range; ++k) values[k] = portable::exp(-0.125 * k * k);
    return values;
  }();
  const double place = std::floor(x + 0.5), a = x - place;
  const double middle = portable::exp(-0.125 * a * a), ahead = portable::exp(0.25 * a);
  const double behind = 1 / ahead;
  BellsThere there{static_cast<std::int64_t>(place) - bell_range, {}};
  there.value[bell_range] = middle;
  double right = middle, left = middle;
  for (int k = 1; k <= bell_range; ++k) {
    right *= ahead;
    left *= behind;
    there.value[bell_range + k] = bell[k] * right;
    there.value[bell_range - k] = bell[k] * left;
  }
  return there;
}

// ---- the sums over bells

/// Points first ... last - 1 of one direction, at (n + shift) spacing.
struct TileSide {
  std::size_t first, last;
  double shift, spacing, place;  // in points, m, m

  BellsThere bells(std::size_t n) const {
    return bells_there((static_cast<double>(n) + shift) * spacing / place);
  }
};

/// The sums along x for all rows of noise that a tile needs, and then along y.
void fill_tile(const RandomMap& map, const TileSide& x, const TileSide& y, HeightMap& out) {
  const std::size_t columns = x.last - x.first;
  const std::size_t padded = in_groups(columns);
  std::vector<std::array<double, bells_at_a_point * side_by_side>> weights(padded / side_by_side);
  std::vector<std::size_t> from(padded, 0);  // place of the first bell, from that of the tile on
  std::int64_t first_place = 0, last_place = 0;
  for (std::size_t c = 0; c < padded; ++c) {
    const BellsThere there = x.bells(x.first + std::min(c, columns - 1));
    if (c == 0) first_place = there.first;
    last_place = there.first + 2 * bell_range;
    from[c] = static_cast<std::size_t>(there.first - first_place);
    for (std::size_t k = 0; k < bells_at_a_point; ++k)
      weights[c / side_by_side][k * side_by_side + c % side_by_side] = there.value[k];
  }
  const std::int64_t first_row = y.bells(y.first).first;
  const std::int64_t last_row = y.bells(y.last - 1).first + 2 * bell_range;
  std::vector<double> noise(static_cast<std::size_t>(last_place - first_place) + 1);
  std::vector<double> along_x(static_cast<std::size_t>(last_row - first_row + 1) * padded);
  for (std::int64_t j = first_row; j <= last_row; ++j) {
    white_noise_row(map.seed, first_place, j, noise);
    double* const sums = &along_x[static_cast<std::size_t>(j - first_row) * padded];
    for (std::size_t g = 0; g < padded / side_by_side; ++g) {
      std::array<double, side_by_side> sum{};
      const std::size_t* const begin = &from[g * side_by_side];
      for (std::size_t k = 0; k < bells_at_a_point; ++k)
        for (std::size_t c = 0; c < side_by_side; ++c)
          sum[c] += weights[g][k * side_by_side + c] * noise[begin[c] + k];
      std::copy_n(sum.data(), side_by_side, sums + g * side_by_side);
    }
  }
  for (std::size_t n = y.first; n < y.last; ++n) {
    const BellsThere there = y.bells(n);
    const double* const sums = &along_x[static_cast<std::size_t>(there.first - first_row) * padded];
    double* const row = &out.heights[n * out.nx + x.first];
    for (std::size_t c = 0; c < padded; c += side_by_side) {
      std::array<double, side_by_side> sum{};
      for (std::size_t k = 0; k < bells_at_a_point; ++k)
        for (std::size_t i = 0; i < side_by_side; ++i)
          sum[i] += there.value[k] * sums[k * padded + c + i];
      std::copy_n(sum.data(), std::min(side_by_side, columns - c), row + c);
    }
  }
}

// ---- mean and root mean square over the area, from the noise

/// Integrals over (0, length) of bells and of products of two of them, divided by the length.
class BellIntegrals {
 public:
  struct Of {
    double bell;                              // of bell i
    std::array<double, overlap + 1> product;  // of bells i and i + d, d = 0 ... overlap
  };

  /// `length` in places.
  explicit BellIntegrals(double length) : length_{length} {
    last_ = static_cast<std::int64_t>(std::floor(length + 0.5)) + bell_range;
    for (int d = 0; d <= overlap; ++d) fading_[d] = portable::exp(-0.125 * d * d);
    inner_.bell = std::sqrt(8 * std::numbers::pi) / length;
    for (int d = 0; d <= overlap; ++d)
      inner_.product[d] = std::sqrt(4 * std::numbers::pi) / length * portable::exp(-0.0625 * d * d);
    last_low_ = std::min<std::int64_t>(bell_range, last_);
    first_high_ = std::max<std::int64_t>(last_low_ + 1, last_ - 2 * bell_range - overlap);
    for (std::int64_t i = -bell_range; i <= last_low_; ++i) low_.push_back(near_an_end(i));
    for (std::int64_t i = first_high_; i <= last_; ++i) high_.push_back(near_an_end(i));
  }
  std::int64_t last() const { return last_; }  // the first is -bell_range
  const Of& of(std::int64_t i) const {
    if (i <= last_low_) return low_[static_cast<std::size_t>(i + bell_range)];
    return i < first_high_ ? inner_ : high_[static_cast<std::size_t>(i - first_high_)];
  }

 private:
  /// Gauss's rule of five points between places, as moments() has it (host/surface/bells.hpp).
  Of near_an_end(std::int64_t i) const {
    constexpr double at[] = {0, 0.53846931010568309, 0.90617984593866399};
    constexpr double share[] = {0.56888888888888889, 0.47862867049936647, 0.23692688505618909};
    Of sums{};
    const auto first = std::max<std::int64_t>(0, i - bell_range - 1);
    for (std::int64_t cell = first; cell <= i + bell_range; ++cell) {
      const auto begin = static_cast<double>(cell);
      if (!(begin < length_)) break;
      const double half = 0.5 * std::fmin(1.0, length_ - begin);
      for (int point = -2; point <= 2; ++point) {
        const double x = begin + half + (point < 0 ? -half : half) * at[std::abs(point)];
        const double away = x - static_cast<double>(i);
        const double bell = portable::exp(-0.125 * away * away);
        const double weight = half * share[std::abs(point)] / length_ * bell;
        sums.bell += weight;
        // bell i + d there: exp(-away^2/8) exp(away/4)^d exp(-d^2/8)
        const double ahead = portable::exp(0.25 * away);
        double next = weight * bell;
        for (int d = 0; d <= overlap; ++d, next *= ahead) sums.product[d] += next * fading_[d];
      }
    }
    return sums;
  }

  double length_;  // places
  std::int64_t last_, last_low_, first_high_;
  std::array<double, overlap + 1> fading_{};
  std::vector<Of> low_, high_;
  Of inner_{};
};

/// Part of the mean and of the mean square over the area.
struct AreaSums {
  double mean = 0, square = 0;
};

/// Part of the places from (left, low) to before (right, top): products of their noise with one
/// another and with the noise to the right and above.
AreaSums sums_of_block(std::uint64_t seed, const BellIntegrals& along, const BellIntegrals& across,
                       std::int64_t left, std::int64_t right, std::int64_t low, std::int64_t top) {
  const auto columns = static_cast<std::size_t>(right - left);
  const std::size_t whole = in_groups(columns), padded = in_groups(whole + overlap);
  const std::int64_t last_row = std::min(top + overlap, across.last() + 1);
  const auto there = static_cast<std::size_t>(std::min(right + overlap, along.last() + 1) - left);
  // products along x, by distance: a row of noise is multiplied by all of one distance at once
  std::vector<double> product((overlap + 1) * whole, 0.0), bell(columns);
  for (std::size_t i = 0; i < columns; ++i) {
    const BellIntegrals::Of& of = along.of(left + static_cast<std::int64_t>(i));
    bell[i] = of.bell;
    for (std::size_t d = 0; d <= overlap; ++d) product[d * whole + i] = of.product[d];
  }
  std::vector<double> noise(static_cast<std::size_t>(last_row - low) * padded, 0.0);
  for (std::int64_t j = low; j < last_row; ++j)
    white_noise_row(seed, left, j,
                    std::span(noise).subspan(static_cast<std::size_t>(j - low) * padded, there));
  std::vector<double> weighed(padded), sums(whole);
  AreaSums all;
  for (std::int64_t j = low; j < top; ++j) {
    const BellIntegrals::Of& row = across.of(j);
    const double* const own = &noise[static_cast<std::size_t>(j - low) * padded];
    all.mean +=
        row.bell * compensated_sum(columns, [&](std::size_t i) { return bell[i] * own[i]; });
    // this row and those above it, whose products with this one count twice
    const int above = static_cast<int>(std::min<std::int64_t>(overlap, last_row - 1 - j));
    for (std::size_t i = 0; i < padded; i += side_by_side) {
      std::array<double, side_by_side> sum{};
      for (int d = 0; d <= above; ++d) {
        const double share = row.product[d] * (d == 0 ? 1 : 2);
        const double* const there_above = own + static_cast<std::size_t>(d) * padded + i;
        for (std::size_t k = 0; k < side_by_side; ++k) sum[k] += share * there_above[k];
      }
      std::copy_n(sum.data(), side_by_side, &weighed[i]);
    }
    // the sum of product_ik own_i weighed_k, symmetric in i and k
    for (std::size_t i = 0; i < whole; i += side_by_side) {
      const double *const own_here = own + i, *const weighed_here = &weighed[i];
      std::array<double, side_by_side> sum{};
      for (std::size_t k = 0; k < side_by_side; ++k)
        sum[k] = product[i + k] * own_here[k] * weighed_here[k];
      for (std::size_t d = 1; d <= overlap; ++d)
        for (std::size_t k = 0; k < side_by_side; ++k)
          sum[k] += product[d * whole + i + k] *
                    (own_here[k] * weighed_here[k + d] + own_here[k + d] * weighed_here[k]);
      std::copy_n(sum.data(), side_by_side, &sums[i]);
    }
    all.square += compensated_sum(columns, [&](std::size_t i) { return sums[i]; });
  }
  return all;
}

/// Of the map over its area, by the bilinear form of the noise; both in the noise's unit.
Moments moments_over_area(std::uint64_t seed, double length, double width) {
  constexpr std::int64_t columns = 2048, rows = 256;  // of a block
  const BellIntegrals along(length), across(width);
  const std::int64_t wide = (along.last() + bell_range) / columns + 1;
  const std::int64_t high = (across.last() + bell_range) / rows + 1;
  std::vector<AreaSums> parts(static_cast<std::size_t>(wide * high));
  in_blocks(parts.size(), 1, [&](std::size_t block, std::size_t, std::size_t) {
    const auto number = static_cast<std::int64_t>(block);
    const std::int64_t left = number % wide * columns - bell_range,
                       low = number / wide * rows - bell_range;
    parts[block] =
        sums_of_block(seed, along, across, left, std::min(left + columns, along.last() + 1), low,
                      std::min(low + rows, across.last() + 1));
  });
  const double mean = compensated_sum(parts.size(), [&](std::size_t b) { return parts[b].mean; });
  const double square =
      compensated_sum(parts.size(), [&](std::size_t b) { return parts[b].square; });
  return {mean, std::sqrt(square - mean * mean)};
}

// ---- what is asked

/// Root mean square slope that straight lines between points lose: 2 (C(0) - C(d))/d^2 over -C''(0)
/// of C(x) = exp(-(x/l)^2).
double lost_slope(double spacing, double correlation_length) {
  const double x = spacing * spacing / (correlation_length * correlation_length);
  return 1 - std::sqrt(-std::expm1(-x) / x);
}

struct MapSide {
  const char *rsm_name, *spacing_name, *size_name;
  double rsm, spacing, size;  // m
};

void check_side(const MapSide& side) {
  if (!(side.rsm > 0) || !(side.spacing > 0) || !(side.size > 0) || !std::isfinite(side.size) ||
      !std::isfinite(side.spacing))
    throw RequestError(fmt::format("a random map needs {}, {} and {} > 0 in metres", side.rsm_name,
                                   side.spacing_name, side.size_name));
  if (side.rsm < least_points * side.spacing)
    throw RequestError(
        fmt::format("{} = {:g} m is not resolved by {} = {:g} m: expected at least "
                    "{} spacings",
                    side.rsm_name, side.rsm, side.spacing_name, side.spacing, least_points));
  if (side.size / side.rsm * rsm_of_length * places_per_length > most_noise_places)
    throw RequestError(fmt::format("{} = {:g} m is too short for {} = {:g} m", side.rsm_name,
                                   side.rsm, side.size_name, side.size));
}

/// Rows that are all the random profile of the seed.
void repeat_profile(const RandomMap& map, double length, HeightMap& out) {
  SurfaceSpec profile;
  profile.kind = SurfaceKind::gaussian;
  profile.rq = map.rq;
  profile.rsm = map.rsm;
  profile.seed = map.seed;
  profile.exact = map.exact ? Exactly::rq : Exactly::nothing;
  const std::vector<double> row =
      random_heights(profile, length, static_cast<int>(out.nx), out.spacing);
  for (std::size_t j = 0; j < out.ny; ++j)
    std::copy(row.begin(), row.end(),
              out.heights.begin() + static_cast<std::ptrdiff_t>(j * out.nx));
}

}  // namespace

double map_rows(double width, double spacing_y) { return std::round(width / spacing_y); }

HeightMap random_map(const RandomMap& map, double length, double width, double spacing,
                     double spacing_y, std::vector<std::string>* doubts,
                     std::optional<std::size_t> nx) {
  const MapSide sides[] = {{"rsm", "spacing", "the length", map.rsm, spacing, length},
                           {"rsm_y", "spacing_y", "the width", map.rsm_y, spacing_y, width}};
  for (const MapSide& side : sides) check_side(side);
  if (!(map.rq >= 0) || !std::isfinite(map.rq))
    throw RequestError("a random map needs rq >= 0 in metres");
  const double place = map.rsm / rsm_of_length / places_per_length;
  const double place_y = map.rsm_y / rsm_of_length / places_per_length;
  if (map.rsm > longest_wave * rsm_of_length * length)
    throw RequestError(
        fmt::format("rsm = {:g} m is more than {:.3g} times the length: the map "
                    "would be bent, not rough; lower rsm",
                    map.rsm, longest_wave * rsm_of_length));
  require_map_size("the random map",
                   nx ? static_cast<double>(*nx) : std::floor(length / spacing + 1e-9) + 1,
                   map_rows(width, spacing_y));
  HeightMap out{nx ? *nx : static_cast<std::size_t>(node_count(length, spacing)),
                static_cast<std::size_t>(map_rows(width, spacing_y)),
                spacing,
                spacing_y,
                {}};
  for (const MapSide& side : sides) {
    const double lost = lost_slope(side.spacing, side.rsm / rsm_of_length);
    if (doubts != nullptr && lost > most_slope_lost)
      doubts->push_back(fmt::format(
          "points {} = {:.4g} m apart lose {:.0f} % of the root mean square slope ({} {:.4g} m)",
          side.spacing_name, side.spacing, 100 * lost, side.rsm_name, side.rsm));
  }
  out.heights.assign(out.nx * out.ny, 0.0);
  if (map.rq == 0) return out;
  if (!std::isfinite(map.rsm_y)) {
    repeat_profile(map, length, out);
    return out;
  }
  const std::size_t wide = (out.nx + tile_columns - 1) / tile_columns;
  const std::size_t high = (out.ny + tile_rows - 1) / tile_rows;
  in_blocks(wide * high, 1, [&](std::size_t tile, std::size_t, std::size_t) {
    const auto side = [](std::size_t number, std::size_t size, std::size_t count) {
      return std::pair(number * size, std::min((number + 1) * size, count));
    };
    const auto [left, right] = side(tile % wide, tile_columns, out.nx);
    const auto [low, top] = side(tile / wide, tile_rows, out.ny);
    fill_tile(map, {left, right, 0, spacing, place}, {low, top, 0.5, spacing_y, place_y}, out);
  });
  const auto [mean, rms] = moments_over_area(map.seed, length / place, width / place_y);
  // in expectation the squares of bells add up to sqrt(4 pi), along x and along y
  const double spread = std::sqrt(4 * std::numbers::pi);
  const double factor = map.rq / (map.exact ? rms : spread);
  for (double& height : out.heights) height = (height - mean) * factor;
  return out;
}

}  // namespace ra2d
