// SPDX-License-Identifier: BSD-3-Clause
// Every step is one that IEEE 754 defines exactly, in a fixed order. Needs -ffp-contract=off.
#include "host/surface/bells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/surface/portable.hpp"
#include "host/surface/sum.hpp"
#include "host/system/blocks.hpp"

namespace ra2d {

Bells::Bells(std::vector<double> coefficients) : coefficients_{std::move(coefficients)} {
  for (int i = 0; i <= half_width; ++i) bell_[i] = portable::exp(-0.125 * i * i);
}

void Bells::evaluate(std::vector<double>& x) const {
  constexpr std::size_t a_block = 1 << 14;  // a scene of the paper's size is one
  in_blocks(x.size(), a_block, [&](std::size_t, std::size_t first, std::size_t last) {
    for (; first < last; first += side_by_side) {
      const std::size_t count = std::min(side_by_side, last - first);
      Group group;
      group.fill(x[first]);  // the last group may have places to spare
      std::copy_n(x.data() + first, count, group.data());
      sum(group);
      std::copy_n(group.data(), count, x.data() + first);
    }
  });
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
    near[k] = half_width + static_cast<std::ptrdiff_t>(place);
    ahead[k] = 0.25 * a;
    middle[k] = -0.125 * a * a;
  }
  small_exp(ahead, middle);
  for (std::size_t k = 0; k < side_by_side; ++k) behind[k] = 1 / ahead[k];
  const auto add_up = [&](const auto& coefficient) {
    for (std::size_t k = 0; k < side_by_side; ++k) {
      right[k] = left[k] = 1;
      sums[k] = coefficient(k, 0);
    }
    for (int i = 1; i <= half_width; ++i)
      for (std::size_t k = 0; k < side_by_side; ++k) {
        right[k] *= ahead[k];
        left[k] *= behind[k];
        sums[k] += bell_[i] * (right[k] * coefficient(k, i) + left[k] * coefficient(k, -i));
      }
  };
  const double* const c = coefficients_.data();
  // mostly the nearest place is one for all of them
  if (std::all_of(near.begin(), near.end(), [&](std::ptrdiff_t i) { return i == near[0]; })) {
    const double* const middle_one = c + near[0];
    add_up([&](std::size_t, int i) { return middle_one[i]; });
  } else {
    add_up([&](std::size_t k, int i) { return c[near[k] + i]; });
  }
  for (std::size_t k = 0; k < side_by_side; ++k) x[k] = middle[k] * sums[k];
}

/// portable::exp of each, bit for bit, where |x| < ln 2 / 2: no power of two is taken out there.
void Bells::small_exp(Group& x, Group& y) {
  Group of_x, of_y;
  of_x.fill(1);
  of_y.fill(1);
  for (int n = portable::exp_terms; n > 0; --n)
    for (std::size_t k = 0; k < side_by_side; ++k) {
      of_x[k] = 1 + portable::divide_by(n, x[k] * of_x[k]);
      of_y[k] = 1 + portable::divide_by(n, y[k] * of_y[k]);
    }
  x = of_x;
  y = of_y;
}

Moments moments(const std::function<void(std::vector<double>&)>& evaluate, double length) {
  constexpr double at[] = {0, 0.53846931010568309, 0.90617984593866399};
  constexpr double share[] = {0.56888888888888889, 0.47862867049936647, 0.23692688505618909};
  constexpr std::size_t a_place = 5;
  const auto places = static_cast<std::size_t>(std::ceil(length));
  std::vector<double> values(a_place * places);
  std::array<double, a_place> whole{},
      last{};  // weights, of the last place, which may be a part of one
  for (std::size_t place = 0; place < places; ++place) {
    const auto begin = static_cast<double>(place);
    const double half = 0.5 * std::fmin(1.0, length - begin), middle = begin + half;
    for (std::size_t i = 0; i < a_place; ++i) {
      const std::size_t point = i < 2 ? 2 - i : i - 2;
      values[a_place * place + i] = middle + (i < 2 ? -half : half) * at[point];
      whole[i] = share[point] * 0.5 / length;
      last[i] = share[point] * half / length;
    }
  }
  evaluate(values);
  const std::size_t before_last = values.size() - std::min(values.size(), a_place);
  const auto weight = [&](std::size_t i) {
    return i < before_last ? whole[i % a_place] : last[i - before_last];
  };
  Moments m{};
  m.mean = compensated_sum(values.size(), [&](std::size_t i) { return weight(i) * values[i]; });
  m.rms = std::sqrt(compensated_sum(values.size(), [&](std::size_t i) {
    const double away = values[i] - m.mean;
    return weight(i) * (away * away);
  }));
  return m;
}

}  // namespace ra2d
