// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/johnson.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "host/base/errors.hpp"

namespace ra2d {
namespace {

/// Points and weights of means over the standard normal distribution: the trapezoidal rule, which
/// for smooth functions that fade is exact to roundings.
struct Normal {
  static constexpr int points = 225;
  std::array<double, points> at, weight;
  Normal() {
    constexpr double step = 0.125;
    constexpr int middle = points / 2;
    for (int i = 0; i < points; ++i) {
      at[i] = step * (i - middle);
      weight[i] = step * std::exp(-at[i] * at[i] / 2) / std::sqrt(2 * std::numbers::pi);
    }
  }
};
const Normal& normal() {
  static const Normal rule;
  return rule;
}

struct HeightMoments {
  double mean, spread, skewness, kurtosis;
};
/// Of the values of a function of a standard normal number.
template <class Function>
HeightMoments height_moments(const Function& function) {
  std::array<double, Normal::points> value;
  HeightMoments s{};
  for (int i = 0; i < Normal::points; ++i) {
    value[i] = function(normal().at[i]);
    s.mean += normal().weight[i] * value[i];
  }
  double second_moment = 0, third_moment = 0, fourth_moment = 0;
  for (int i = 0; i < Normal::points; ++i) {
    const double away = value[i] - s.mean, square = away * away;
    second_moment += normal().weight[i] * square;
    third_moment += normal().weight[i] * square * away;
    fourth_moment += normal().weight[i] * square * square;
  }
  s.spread = std::sqrt(second_moment);
  s.skewness = third_moment / (second_moment * s.spread);
  s.kurtosis = fourth_moment / (second_moment * second_moment);
  return s;
}

/// Where a function that falls (or grows) passes a value between two arguments.
template <class Function>
double bisect(double low, double high, bool grows, double value, const Function& function) {
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (low + high);
    ((function(middle) < value) == grows ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Limits of skewness and kurtosis: sharper heights are hardly a surface's.
constexpr double most_kurtosis = 30, least_beyond = 1.4;  // kurtosis - skewness^2; 1: two heights

}  // namespace

/// With normal heights g: unbounded sinh((g + gamma)/delta), bounded 1/(1 + exp(-(g +
/// gamma)/delta)), lognormal exp(g/delta), skewed to the high side; `sign_` turns them round.
double JohnsonHeights::raw(double g) const {
  const double t = (g + gamma_) / delta_;
  switch (family_) {
    case Family::normal:
      return g;
    case Family::unbounded:
      return std::sinh(t);
    case Family::bounded:
      return 1 / (1 + std::exp(-t));
    case Family::lognormal:
      break;
  }
  return std::exp(t);
}

double JohnsonHeights::operator()(double g) const {
  return sign_ * (raw(sign_ * g) - mean_) / spread_;
}

double JohnsonHeights::at_mean_line() const {
  switch (family_) {
    case Family::normal:
      return 0;
    case Family::unbounded:
      return sign_ * (delta_ * std::asinh(mean_) - gamma_);
    case Family::bounded:
      return sign_ * (delta_ * std::log(mean_ / (1 - mean_)) - gamma_);
    case Family::lognormal:
      break;
  }
  return sign_ * (delta_ * std::log(mean_) - gamma_);
}

void JohnsonHeights::standardise() {
  const HeightMoments shape = height_moments([&](double g) { return raw(g); });
  mean_ = shape.mean;
  spread_ = shape.spread;
}

/// Of a lognormal height: w = exp(1/delta^2), skewness^2 = (w - 1)(w + 2)^2.
JohnsonHeights::JohnsonHeights(double skewness, double kurtosis) {
  const double skew = std::abs(skewness);
  if (!(kurtosis - skew * skew >= least_beyond) || !(kurtosis <= most_kurtosis))
    throw RequestError(
        fmt::format("no heights are made with a skewness of {:.10g} and a kurtosis of {:.10g}: "
                    "expected a kurtosis "
                    "from skewness^2 + {} to {} (normal heights: 0 and 3)",
                    skewness, kurtosis, least_beyond, most_kurtosis));
  if (skew < 1e-6 && std::abs(kurtosis - 3) < 1e-5) return;
  sign_ = skewness < 0 ? -1 : 1;
  const double w =
      bisect(1, 3, true, skew * skew, [](double v) { return (v - 1) * (v + 2) * (v + 2); });
  const double lognormal = ((w + 2) * w + 3) * w * w - 3;  // kurtosis
  if (std::abs(kurtosis - lognormal) < 1e-6) {
    family_ = Family::lognormal;
    delta_ = 1 / std::sqrt(std::log(w));
  } else {
    family_ = kurtosis > lognormal ? Family::unbounded : Family::bounded;
    // for a given delta the skewness rises with gamma (bounded: falls) from 0 towards the
    // lognormal's
    const auto settle = [&](double delta) {
      delta_ = delta;
      gamma_ = 0;
      if (skew > 0) {
        const double far = 14 * delta;
        const bool unbounded = family_ == Family::unbounded;
        gamma_ = bisect(unbounded ? 0 : -far, unbounded ? far : 0, unbounded, skew, [&](double at) {
          gamma_ = at;
          return height_moments([&](double g) { return raw(g); }).skewness;
        });
      }
      return height_moments([&](double g) { return raw(g); }).kurtosis;
    };
    const double most = skew > 1e-9 ? 1 / std::sqrt(std::log(w)) : 1000.0;
    const double least = family_ == Family::unbounded ? 0.6 : 0.2;
    settle(bisect(least, most, family_ == Family::bounded, kurtosis, settle));
  }
  standardise();
  const HeightMoments made = height_moments([&](double g) { return (*this)(g); });
  if (!(std::abs(made.skewness - skewness) < 1e-6 && std::abs(made.kurtosis - kurtosis) < 1e-6))
    throw RequestError(fmt::format(
        "no heights were found with a skewness of {:.10g} and a kurtosis of {:.10g}: move "
        "them towards 0 and 3, the normal heights'",
        skewness, kurtosis));
  find_series();
}

/// a_n = E[z(g) He_n(g)]/n!: of correlated normal heights E[z z'] = sum n! a_n^2 rho^n (Mehler).
void JohnsonHeights::find_series() {
  constexpr int most = 30;
  double left = 1;
  for (int n = 1; n <= most && left > 1e-12; ++n) {
    // normalised: He_n/sqrt(n!)
    double b = 0;
    for (int i = 0; i < Normal::points; ++i) {
      const double g = normal().at[i];
      double before = 0, now = 1;
      for (int j = 0; j < n; ++j) {
        const double next =
            (g * now - std::sqrt(static_cast<double>(j)) * before) / std::sqrt(j + 1.0);
        before = now;
        now = next;
      }
      b += normal().weight[i] * (*this)(g)*now;
    }
    series_.push_back(b * b);
    left -= b * b;
  }
}

double JohnsonHeights::correlation(double normal) const {
  if (is_identity()) return normal;
  double sum = 0, all = 0;
  for (std::size_t n = series_.size(); n-- > 0;) {
    sum = normal * (series_[n] + sum);
    all += series_[n];
  }
  return sum / all;  // of equal heights: 1
}

double JohnsonHeights::normal_correlation(double of_heights) const {
  if (is_identity()) return of_heights;
  if (of_heights >= 1) return 1;
  if (of_heights <= correlation(-1)) return -1;
  double low = -1, high = 1, at = of_heights;
  for (int round = 0; round < 60; ++round) {  // Newton's steps, halved where they leave the bracket
    const double miss = correlation(at) - of_heights;
    if (std::abs(miss) < 1e-15) break;
    (miss < 0 ? low : high) = at;
    double slope = 0;
    for (std::size_t n = series_.size(); n-- > 0;)
      slope = slope * at + static_cast<double>(n + 1) * series_[n];
    const double next = at - miss / slope;
    at = next > low && next < high ? next : 0.5 * (low + high);
  }
  return at;
}

}  // namespace ra2d
