// SPDX-License-Identifier: BSD-3-Clause
// A seed gives the same profile, bit for bit, everywhere: integers make the noise, and every step
// from there to a height is one that IEEE 754 defines exactly, in a fixed order. No libm function
// but sqrt, frexp, ldexp and floor. Needs -ffp-contract=off (the regression test's hash tells).
#include "host/surface/gaussian.hpp"

#include <Random123/philox.h>
#include <fmt/format.h>

#include <cmath>

#include "host/errors.hpp"
#include "host/surface/portable.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

constexpr int most_nodes = 100'000;  // per correlation length: beyond it is a slip, and slow

/// The upper 54 of 64 random bits as a number in [-1, 1), a multiple of 2^-53.
double signed_unit(std::uint64_t high, std::uint64_t low) {
  const auto bits = static_cast<std::int64_t>(high << 32 | low);
  return static_cast<double>(bits >> 10) * 0x1p-53;
}

/// Weights exp(-2 (i chi/l)^2), i = 0, 1, ...: convolved with itself, the filter gives
/// exp(-(x/l)^2).
std::vector<double> half_filter(double correlation_length, double spacing) {
  std::vector<double> weights;
  for (int i = 0;; ++i) {
    const double a = i * spacing / correlation_length, exponent = -2 * a * a;
    if (exponent < -39.2) return weights;  // e^-39.2 < 1e-17: below the roundings of the sum
    weights.push_back(portable::exp(exponent));
  }
}

}  // namespace

double white_noise(std::uint64_t seed, std::int64_t index) {
  const auto counter = static_cast<std::uint64_t>(index);  // negative indices wrap to the far end
  const r123::Philox4x32::key_type key = {
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  for (std::uint32_t attempt = 0;; ++attempt) {  // Marsaglia's polar method, accepts 79 in 100
    const auto random =
        r123::Philox4x32{}({{static_cast<std::uint32_t>(counter),
                             static_cast<std::uint32_t>(counter >> 32), attempt, 0}},
                           key);
    const double u = signed_unit(random[0], random[1]), v = signed_unit(random[2], random[3]);
    const double square = u * u + v * v;
    if (square > 0 && square < 1) return u * std::sqrt(-2 * portable::log(square) / square);
  }
}

std::vector<double> gaussian_heights(double rq, double correlation_length, std::uint64_t seed,
                                     int nodes, double spacing) {
  const auto count = static_cast<std::size_t>(nodes);
  if (rq == 0) return std::vector<double>(count, 0.0);
  if (nodes < 2) throw RequestError("a gaussian surface needs a beam of at least 2 nodes");
  if (correlation_length > most_nodes * spacing)
    throw RequestError(
        fmt::format("a correlation length of {:.10g} m spans more than {} nodes of a gaussian "
                    "surface; lower rsm or correlation_length, or enlarge the spacing",
                    correlation_length, most_nodes));

  const std::vector<double> weights = half_filter(correlation_length, spacing);
  const std::size_t reach = weights.size() - 1;
  std::vector<double> noise(count + 2 * reach);
  for (std::size_t i = 0; i < noise.size(); ++i)
    noise[i] = white_noise(seed, static_cast<std::int64_t>(i) - static_cast<std::int64_t>(reach));

  std::vector<double> heights(count);  // weight by weight: each height is still one ordered sum
  for (std::size_t n = 0; n < count; ++n) heights[n] = weights[0] * noise[n + reach];
  for (std::size_t i = 1; i <= reach; ++i)
    for (std::size_t n = 0; n < count; ++n)
      heights[n] += weights[i] * (noise[n + reach - i] + noise[n + reach + i]);

  subtract_mean(heights);
  const double square = compensated_sum(heights, [](double h) { return h * h; });
  const double factor = rq / std::sqrt(square / nodes);
  for (double& height : heights) height *= factor;
  return heights;
}

}  // namespace ra2d
