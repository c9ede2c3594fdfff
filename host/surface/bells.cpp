// SPDX-License-Identifier: BSD-3-Clause
// Every step is one that IEEE 754 defines exactly, in a fixed order. Needs -ffp-contract=off.
#include "host/surface/bells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/surface/portable.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {

Bells::Bells(std::vector<double> coefficients) : coefficients_{std::move(coefficients)} {
  for (int i = 0; i <= reach; ++i) bell_[i] = portable::exp(-0.125 * i * i);
}

void Bells::evaluate(std::vector<double>& x) const {
  for (std::size_t first = 0; first < x.size(); first += side_by_side) {
    const std::size_t count = std::min(side_by_side, x.size() - first);
    Group group;
    group.fill(x[first]);  // the last group may have places to spare
    std::copy_n(x.data() + first, count, group.data());
    sum(group);
    std::copy_n(group.data(), count, x.data() + first);
  }
}

double Bells::gain(double turn) {
  return std::sqrt(8 * std::numbers::pi) * std::exp(-2 * turn * turn);
}

/// At `x`: exp(-(a - i)^2/8) = exp(-a^2/8) exp(a/4)^i exp(-i^2/8), a from the nearest place.
void Bells::sum(Group& x) const {
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
  const double* c = coefficients_.data();
  for (std::size_t k = 0; k < side_by_side; ++k) {
    behind[k] = 1 / ahead[k];
    right[k] = left[k] = 1;
    sums[k] = c[near[k]];
  }
  for (int i = 1; i <= reach; ++i)
    for (std::size_t k = 0; k < side_by_side; ++k) {
      right[k] *= ahead[k];
      left[k] *= behind[k];
      sums[k] += bell_[i] * (right[k] * c[near[k] + i] + left[k] * c[near[k] - i]);
    }
  for (std::size_t k = 0; k < side_by_side; ++k) x[k] = middle[k] * sums[k];
}

/// portable::exp of each, bit for bit, where |x| < ln 2 / 2: no power of two is taken out there.
void Bells::small_exp(Group& x) {
  Group sums;
  sums.fill(1);
  for (int n = portable::exp_terms; n > 0; --n)
    for (std::size_t k = 0; k < side_by_side; ++k) sums[k] = 1 + x[k] * sums[k] / n;
  x = sums;
}

Moments moments(const std::function<void(std::vector<double>&)>& evaluate, double length) {
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
  evaluate(values);
  Moments m{};
  m.mean = compensated_sum(values.size(), [&](std::size_t i) { return weights[i] * values[i]; });
  m.rms = std::sqrt(compensated_sum(values.size(), [&](std::size_t i) {
    const double away = values[i] - m.mean;
    return weights[i] * (away * away);
  }));
  return m;
}

}  // namespace ra2d
