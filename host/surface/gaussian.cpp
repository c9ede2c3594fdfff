// SPDX-License-Identifier: BSD-3-Clause
// A seed gives the same profile, bit for bit, everywhere: integers make the noise, and every step
// from there to a height is one that IEEE 754 defines exactly, in a fixed order. No libm function
// but sqrt, frexp, ldexp and floor. Needs -ffp-contract=off (the regression test's hash tells).
#include "host/surface/gaussian.hpp"

#include <Random123/philox.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/errors.hpp"
#include "host/surface/portable.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

/// The upper 54 of 64 random bits as a number in [-1, 1), a multiple of 2^-53.
double signed_unit(std::uint64_t high, std::uint64_t low) {
  const auto bits = static_cast<std::int64_t>(high << 32 | low);
  return static_cast<double>(bits >> 10) * 0x1p-53;
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

// correlation lengths, of beams: beyond it is no roughness, below it a slip, and slow
constexpr double longest = 100, shortest = 1e-8;

/// White noise xi_i stands at places i d apart, a bell exp(-2 (x/l)^2) about each, and their sum is
/// the profile. Squared and summed over all i, bells of d = l/4 give the same variance between the
/// places as at them, to 2 exp(-(pi l/2d)^2) = 1e-17: no spacing shows, neither d nor the scene's.
constexpr double places_per_length = 4;
/// Beyond this many places a bell, exp(-i^2/8), is below the roundings of the sum.
constexpr int reach = 18;

/// The sum of the bells before it is moved to mean zero and scaled. Lengths are in places.
class Bells {
 public:
  Bells(std::uint64_t seed, int places) {
    noise_.reserve(static_cast<std::size_t>(places) + 2 * reach + 1);
    for (int i = -reach; i <= places + reach; ++i) noise_.push_back(white_noise(seed, i));
    for (int i = 0; i <= reach; ++i) bell_[i] = portable::exp(-0.125 * i * i);
  }

  /// At every x >= 0 of `x`, which are replaced.
  void evaluate(std::vector<double>& x) const {
    for (std::size_t first = 0; first < x.size(); first += side_by_side) {
      const std::size_t count = std::min(side_by_side, x.size() - first);
      Group group;
      group.fill(x[first]);  // the last group may have places to spare
      std::copy_n(x.data() + first, count, group.data());
      sum(group);
      std::copy_n(group.data(), count, x.data() + first);
    }
  }

 private:
  /// Places computed side by side: the divisions of one exp wait for each other, those of eight do not.
  /// Each place goes through the same operations in the same order as it would alone, so its bits do
  /// not depend on its neighbours.
  static constexpr std::size_t side_by_side = 8;
  using Group = std::array<double, side_by_side>;

  /// At `x`: exp(-(a - i)^2/8) = exp(-a^2/8) exp(a/4)^i exp(-i^2/8), a from the nearest place.
  void sum(Group& x) const {
    Group middle, ahead, behind, right, left, sums;
    std::array<std::ptrdiff_t, side_by_side> near;
    for (std::size_t k = 0; k < side_by_side; ++k) {
      const double place = std::floor(x[k] + 0.5), a = x[k] - place;
      near[k] = reach + static_cast<std::ptrdiff_t>(place);
      ahead[k] = 0.25 * a;
      middle[k] = -0.125 * a * a;
    }
    small_exp(ahead);
    small_exp(middle);
    const double* noise = noise_.data();
    for (std::size_t k = 0; k < side_by_side; ++k) {
      behind[k] = 1 / ahead[k];
      right[k] = left[k] = 1;
      sums[k] = noise[near[k]];
    }
    for (int i = 1; i <= reach; ++i)
      for (std::size_t k = 0; k < side_by_side; ++k) {
        right[k] *= ahead[k];
        left[k] *= behind[k];
        sums[k] += bell_[i] * (right[k] * noise[near[k] + i] + left[k] * noise[near[k] - i]);
      }
    for (std::size_t k = 0; k < side_by_side; ++k) x[k] = middle[k] * sums[k];
  }

  /// portable::exp of each, bit for bit, where |x| < ln 2 / 2: no power of two is taken out there.
  static void small_exp(Group& x) {
    Group sums;
    sums.fill(1);
    for (int n = portable::exp_terms; n > 0; --n)
      for (std::size_t k = 0; k < side_by_side; ++k) sums[k] = 1 + x[k] * sums[k] / n;
    x = sums;
  }

  std::vector<double> noise_;  // of the places -reach ... places + reach
  std::array<double, reach + 1> bell_{};
};

/// Mean and root mean square over (0, length), the latter about the former: Gauss's rule of five
/// points between places, which is off by 1e-11 for a square of such bells.
struct Moments {
  double mean, rms;
};
Moments moments(const Bells& bells, double length) {
  constexpr double at[] = {0, 0.53846931010568309, 0.90617984593866399};
  constexpr double share[] = {0.56888888888888889, 0.47862867049936647, 0.23692688505618909};
  std::vector<double> values, weights;
  for (std::vector<double>* points : {&values, &weights})
    points->reserve(5 * (static_cast<std::size_t>(length) + 1));
  for (double begin = 0; begin < length; ++begin) {
    const double half = 0.5 * std::fmin(1.0, length - begin), middle = begin + half;
    for (int i = -2; i <= 2; ++i) {
      const int point = i < 0 ? -i : i;
      values.push_back(middle + (i < 0 ? -half : half) * at[point]);
      weights.push_back(share[point] * half / length);
    }
  }
  bells.evaluate(values);
  Moments m{};
  m.mean = compensated_sum(values.size(), [&](std::size_t i) { return weights[i] * values[i]; });
  m.rms = std::sqrt(compensated_sum(values.size(), [&](std::size_t i) {
    const double away = values[i] - m.mean;
    return weights[i] * (away * away);
  }));
  return m;
}

}  // namespace

std::vector<double> gaussian_heights(double rq, double correlation_length, std::uint64_t seed,
                                     double length, int nodes, double spacing) {
  std::vector<double> heights(static_cast<std::size_t>(nodes), 0.0);
  if (rq == 0) return heights;
  if (nodes < 2) throw RequestError("a gaussian surface needs a beam of at least 2 nodes");
  if (correlation_length > longest * length)
    throw RequestError(fmt::format(
        "a correlation length of {:.10g} m is more than {} times the beam's length: the "
        "beam would be bent, not rough; lower rsm or correlation_length",
        correlation_length, longest));
  if (correlation_length < shortest * length)
    throw RequestError(
        fmt::format("a correlation length of {:.10g} m is less than {} of the beam's "
                    "length; raise rsm or correlation_length",
                    correlation_length, shortest));
  const double place = correlation_length / places_per_length;
  // the last node may stand a rounding beyond the end
  const Bells bells(seed, static_cast<int>(length / place) + 2);
  const auto [mean, rms] = moments(bells, length / place);
  const double factor = rq / rms;
  for (std::size_t n = 0; n < heights.size(); ++n)
    heights[n] = static_cast<double>(n) * spacing / place;
  bells.evaluate(heights);
  for (double& height : heights) height = (height - mean) * factor;
  return heights;
}

}  // namespace ra2d
