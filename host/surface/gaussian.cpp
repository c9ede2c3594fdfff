// SPDX-License-Identifier: BSD-3-Clause
// A seed gives the same profile, bit for bit, everywhere: integers make the noise, and every step
// from there to a height is one that IEEE 754 defines exactly, in a fixed order. No libm function
// but sqrt, frexp, ldexp and floor. Needs -ffp-contract=off (the regression test's hash tells).
#include "host/surface/gaussian.hpp"

#include <Random123/philox.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

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

namespace {

/// The filtered noise before it is moved to mean zero and scaled to rq.
struct Filtered {
  std::vector<double> weights;
  std::size_t reach;
  std::vector<double> noise;    // of the numbers -reach ... nodes + reach
  std::vector<double> heights;  // (nodes)
  double mean, factor;          // what makes heights of them: (height - mean) factor
};

Filtered filtered(double rq, double correlation_length, std::uint64_t seed, int nodes,
                  double spacing) {
  if (nodes < 2) throw RequestError("a gaussian surface needs a beam of at least 2 nodes");
  if (correlation_length > most_nodes * spacing)
    throw RequestError(
        fmt::format("a correlation length of {:.10g} m spans more than {} nodes of a gaussian "
                    "surface; lower rsm or correlation_length, or enlarge the spacing",
                    correlation_length, most_nodes));
  const auto count = static_cast<std::size_t>(nodes);
  Filtered f;
  f.weights = half_filter(correlation_length, spacing);
  f.reach = f.weights.size() - 1;
  f.noise.resize(count + 2 * f.reach + 1);
  for (std::size_t i = 0; i < f.noise.size(); ++i)
    f.noise[i] =
        white_noise(seed, static_cast<std::int64_t>(i) - static_cast<std::int64_t>(f.reach));

  f.heights.resize(count);  // weight by weight: each height is still one ordered sum
  for (std::size_t n = 0; n < count; ++n) f.heights[n] = f.weights[0] * f.noise[n + f.reach];
  for (std::size_t i = 1; i <= f.reach; ++i)
    for (std::size_t n = 0; n < count; ++n)
      f.heights[n] += f.weights[i] * (f.noise[n + f.reach - i] + f.noise[n + f.reach + i]);

  f.mean = subtract_mean(f.heights);
  const double square = compensated_sum(f.heights, [](double h) { return h * h; });
  f.factor = rq / std::sqrt(square / nodes);
  for (double& height : f.heights) height *= f.factor;
  return f;
}

}  // namespace

std::vector<double> gaussian_heights(double rq, double correlation_length, std::uint64_t seed,
                                     int nodes, double spacing) {
  if (rq == 0) return std::vector<double>(static_cast<std::size_t>(nodes), 0.0);
  return filtered(rq, correlation_length, seed, nodes, spacing).heights;
}

std::vector<double> gaussian_heights_at(double rq, double correlation_length, std::uint64_t seed,
                                        int drawn, double drawn_spacing, int nodes,
                                        double spacing) {
  std::vector<double> heights(static_cast<std::size_t>(nodes), 0.0);
  if (rq == 0) return heights;
  const Filtered f = filtered(rq, correlation_length, seed, drawn, drawn_spacing);
  const auto reach = static_cast<std::int64_t>(f.reach);
  // the bells as seen from between two drawn nodes, by how far from the nearer: of spacings in a
  // simple ratio there are few such places
  std::map<std::int64_t, std::vector<double>> bells;
  constexpr std::size_t most_bells = 1000;
  for (std::size_t n = 0; n < heights.size(); ++n) {
    const double at = static_cast<double>(n) * spacing / drawn_spacing;
    const double whole = std::floor(at + 0.5);
    const auto node = static_cast<std::int64_t>(whole);
    // as for the number of nodes, a billionth of a spacing is none
    if (std::abs(at - whole) < 1e-9 * std::max(1.0, whole) && node < drawn) {
      heights[n] = f.heights[static_cast<std::size_t>(node)];
      continue;
    }
    if (bells.size() > most_bells) bells.clear();
    std::vector<double>& bell = bells[std::llround((at - whole) * 1e9)];
    if (bell.empty())
      for (std::int64_t i = -reach; i <= reach; ++i) {
        const double a = (at - whole - static_cast<double>(i)) * drawn_spacing / correlation_length;
        bell.push_back(portable::exp(-2 * a * a));
      }
    const double* noise = f.noise.data() + node;  // of node - reach
    const std::size_t seen = std::min(bell.size(), f.noise.size() - static_cast<std::size_t>(node));
    double sum = 0;
    for (std::size_t i = 0; i < seen; ++i) sum += bell[i] * noise[i];
    heights[n] = (sum - f.mean) * f.factor;
  }
  return heights;
}

}  // namespace ra2d
