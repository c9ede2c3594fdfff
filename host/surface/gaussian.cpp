// SPDX-License-Identifier: BSD-3-Clause
// A seed gives the same profile, bit for bit, everywhere: integers make the noise, and every step
// from there to a height is one that IEEE 754 defines exactly, in a fixed order. No libm function
// but sqrt, frexp, ldexp and floor. Needs -ffp-contract=off (the regression test's hash tells).
#include "host/surface/gaussian.hpp"

#include <Random123/philox.h>
#include <fmt/format.h>

#include <cmath>

#include "host/base/errors.hpp"
#include "host/surface/bells.hpp"
#include "host/surface/portable.hpp"
#include "host/system/blocks.hpp"

namespace ra2d {
namespace {

/// The upper 54 of 64 random bits as a number in [-1, 1), a multiple of 2^-53.
double signed_unit(std::uint64_t high, std::uint64_t low) {
  const auto bits = static_cast<std::int64_t>(high << 32 | low);
  return static_cast<double>(bits >> 10) * 0x1p-53;
}

/// Two independent numbers from the counters (low, high, attempt, plane), by Marsaglia's polar
/// method, which accepts 79 attempts in 100.
struct NormalPair {
  double first, second;
};
NormalPair normal_pair(std::uint64_t seed, std::uint32_t low, std::uint32_t high,
                       std::uint32_t plane) {
  const r123::Philox4x32::key_type key = {
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  for (std::uint32_t attempt = 0;; ++attempt) {
    const auto random = r123::Philox4x32{}({{low, high, attempt, plane}}, key);
    const double u = signed_unit(random[0], random[1]), v = signed_unit(random[2], random[3]);
    const double square = u * u + v * v;
    if (!(square > 0 && square < 1)) continue;
    const double factor = std::sqrt(-2 * portable::log(square) / square);
    return {u * factor, v * factor};
  }
}

/// Of the places (2 pair, j) and (2 pair + 1, j) of the plane.
NormalPair places_pair(std::uint64_t seed, std::int64_t pair, std::int64_t j) {
  return normal_pair(seed, static_cast<std::uint32_t>(pair), static_cast<std::uint32_t>(j), 1);
}

}  // namespace

double white_noise(std::uint64_t seed, std::int64_t index) {
  const auto counter = static_cast<std::uint64_t>(index);  // negative indices wrap to the far end
  return normal_pair(seed, static_cast<std::uint32_t>(counter),
                     static_cast<std::uint32_t>(counter >> 32), 0)
      .first;
}

void white_noise_row(std::uint64_t seed, std::int64_t first, std::int64_t j,
                     std::span<double> row) {
  std::size_t n = 0;
  if (first % 2 != 0 && !row.empty()) row[n++] = places_pair(seed, first >> 1, j).second;
  for (; n < row.size(); n += 2) {
    const auto [even, odd] = places_pair(seed, (first + static_cast<std::int64_t>(n)) >> 1, j);
    row[n] = even;
    if (n + 1 < row.size()) row[n + 1] = odd;
  }
}

namespace {

// correlation lengths, of beams: beyond it is no roughness, below it a slip, and slow
constexpr double longest_correlation = 100, shortest = 1e-8;

}  // namespace

/// White noise xi_i stands at places i d apart, a bell exp(-2 (x/l)^2) about each, and their sum is
/// the profile. Squared and summed over all i, bells of d = l/4 give the same variance between the
/// places as at them, to 2 exp(-(pi l/2d)^2) = 1e-17: no spacing shows, neither d nor the scene's.
std::vector<double> noise_about(std::uint64_t seed, int places) {
  constexpr std::size_t a_block = 1 << 14;
  std::vector<double> noise(static_cast<std::size_t>(places) + 2 * Bells::half_width + 1);
  in_blocks(noise.size(), a_block, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      noise[i] = white_noise(seed, static_cast<std::int64_t>(i) - Bells::half_width);
  });
  return noise;
}

std::vector<double> gaussian_heights(double rq, double correlation_length, std::uint64_t seed,
                                     double length, int nodes, double spacing) {
  std::vector<double> heights(static_cast<std::size_t>(nodes), 0.0);
  if (rq == 0) return heights;
  if (nodes < 2) throw RequestError("a gaussian surface needs a beam of at least 2 nodes");
  if (correlation_length > longest_correlation * length)
    throw RequestError(fmt::format(
        "a correlation length of {:.10g} m is more than {} times the beam's length: the "
        "beam would be bent, not rough; lower rsm or correlation_length",
        correlation_length, longest_correlation));
  if (correlation_length < shortest * length)
    throw RequestError(
        fmt::format("a correlation length of {:.10g} m is less than {} of the beam's "
                    "length; raise rsm or correlation_length",
                    correlation_length, shortest));
  const double place = correlation_length / places_per_length;
  // the last node may stand a rounding beyond the end
  const Bells bells(noise_about(seed, static_cast<int>(length / place) + 2));
  const auto [mean, rms] =
      moments([&](std::vector<double>& x) { bells.evaluate(x); }, length / place);
  const double factor = rq / rms;
  for (std::size_t n = 0; n < heights.size(); ++n)
    heights[n] = static_cast<double>(n) * spacing / place;
  bells.evaluate(heights);
  for (double& height : heights) height = (height - mean) * factor;
  return heights;
}

}  // namespace ra2d
