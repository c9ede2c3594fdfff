// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/distributions.hpp"

#include <cmath>
#include <limits>

namespace ra2d {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr int most_terms = 100'000;

/// P(a, x), the share of the gamma function's integral up to x: its power series below a + 1, else
/// 1 less the continued fraction of the rest (Lentz).
double gamma_share(double a, double x) {
  if (!(x > 0)) return 0;
  const double front = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < most_terms && term > epsilon * sum; ++n) sum += term *= x / (a + n);
    return front * sum;
  }
  double b = x + 1 - a, c = 1e300, d = 1 / b, fraction = d;
  for (int n = 1; n < most_terms; ++n) {
    const double numerator = -n * (n - a);
    b += 2;
    d = 1 / (numerator * d + b);
    c = b + numerator / c;
    fraction *= d * c;
    if (std::abs(d * c - 1) < epsilon) break;
  }
  return 1 - front * fraction;
}

/// The share of the beta function's integral up to x, by its continued fraction (Lentz), which is
/// quick for x below (a + 1) / (a + b + 2).
double beta_share(double a, double b, double x) {
  if (x > (a + 1) / (a + b + 2)) return 1 - beta_share(b, a, 1 - x);
  if (!(x > 0)) return 0;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x)) /
                       a;
  double c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), fraction = d;
  const auto take = [&](double numerator) {
    d = 1 / (1 + numerator * d);
    c = 1 + numerator / c;
    fraction *= d * c;
    return std::abs(d * c - 1) < epsilon;
  };
  for (int m = 1; m < most_terms; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    take(even);
    if (take(odd)) break;
  }
  return front * fraction;
}

/// Where a share that grows with x from 0 at 0 reaches p, by bisection.
template <class Share>
double where(Share share, double p) {
  double low = 0, high = 1;
  while (share(high) < p) high *= 2;
  while (high - low > 4 * epsilon * high) {
    const double middle = low + (high - low) / 2;
    (share(middle) < p ? low : high) = middle;
  }
  return low + (high - low) / 2;
}

}  // namespace

double chi_square_quantile(double p, double degrees_of_freedom) {
  return where([&](double x) { return gamma_share(degrees_of_freedom / 2, x / 2); }, p);
}

double student_quantile(double p, double degrees_of_freedom) {
  if (p < 0.5) return -student_quantile(1 - p, degrees_of_freedom);
  const double n = degrees_of_freedom;
  // what lies above t and below -t
  return where([&](double t) { return 1 - beta_share(n / 2, 0.5, n / (n + t * t)) / 2; }, p);
}

double fisher_tail(double f, double above, double below) {
  if (!(f > 0)) return std::isnan(f) ? f : 1;
  if (std::isinf(f)) return 0;
  return beta_share(below / 2, above / 2, below / (below + above * f));
}

double student_tail(double t, double degrees_of_freedom) {
  return fisher_tail(t * t, 1, degrees_of_freedom);
}

}  // namespace ra2d
