// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/resistance.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace ra2d {
namespace {

/// Integral over the angle of b_a b_b* at q = rest sin(angle), from -pi/2 to pi/2. Its integrand
/// has the period pi, so that equal steps converge as fast as Gauss's.
double across_power(const LineShape& a, const LineShape& b, const Points& y, double middle,
                    double rest, double width) {
  const int steps = 24 + static_cast<int>(std::ceil(rest * width));
  std::vector<double> weighted_a(y.size()), weighted_b(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    weighted_a[i] = y.weight[i] * a(y.at[i]);
    weighted_b[i] = y.weight[i] * b(y.at[i]);
  }
  double sum = 0;
  for (int step = 0; step < steps; ++step) {
    const double q = rest * std::sin(M_PI * (step + 0.5) / steps - M_PI / 2);
    std::complex<double> of_a, of_b;
    for (std::size_t i = 0; i < y.size(); ++i) {
      const std::complex<double> wave = std::polar(1.0, -q * (y.at[i] - middle));
      of_a += weighted_a[i] * wave;
      of_b += weighted_b[i] * wave;
    }
    sum += (of_a * std::conj(of_b)).real();
  }
  return sum * M_PI / steps;
}

std::size_t in_lower_half(std::size_t a, std::size_t b) {
  return std::max(a, b) * (std::max(a, b) + 1) / 2 + std::min(a, b);
}

}  // namespace

RadiationResistance::RadiationResistance(const Radiator& radiator, const Air& air, double highest,
                                         const Fineness& fineness)
    : air_{air},
      highest_{2 * M_PI * highest / air.sound_speed},
      turning_{radiator.length + radiator.width},  // of the transforms' products
      fineness_{fineness},
      across_count_{radiator.across.size()} {
  along_ = even_points(0, radiator.length, highest_ + radiator.turning_along, fineness);
  for (const RadiatingMode& mode : radiator.modes) {
    across_of_.push_back(mode.across);
    for (std::size_t i = 0; i < along_.size(); ++i)
      shapes_.push_back(along_.weight[i] * mode.along(along_.at[i]));
  }
  for (double& x : along_.at) x -= radiator.length / 2;
  const Points y = even_points(0, radiator.width, highest_ + radiator.turning_across, fineness);
  for (std::size_t a = 0; a < across_count_; ++a)
    for (std::size_t b = 0; b <= a; ++b)
      tables_.emplace_back(
          highest_, 5 * radiator.width,  // to interpolate takes more points than to integrate
          [&](double rest) {
            return across_power(radiator.across[a], radiator.across[b], y, radiator.width / 2, rest,
                                radiator.width);
          },
          fineness);
  panels_ = even_points(0, highest_, turning_, fineness);
  for (const double p : panels_.at) at_panels_.push_back(transforms(p));
}

RadiationResistance::Transforms RadiationResistance::transforms(double wave_number) const {
  const std::size_t points = along_.size(), modes = across_of_.size();
  std::vector<double> cosine(points), sine(points);
  for (std::size_t i = 0; i < points; ++i) {
    cosine[i] = std::cos(wave_number * along_.at[i]);
    sine[i] = std::sin(wave_number * along_.at[i]);
  }
  Transforms found{std::vector<double>(modes), std::vector<double>(modes)};
  for (std::size_t k = 0; k < modes; ++k)
    for (std::size_t i = 0; i < points; ++i) {
      found.re[k] += shapes_[k * points + i] * cosine[i];
      found.im[k] -= shapes_[k * points + i] * sine[i];
    }
  return found;
}

double RadiationResistance::across(std::size_t a, std::size_t b, double rest) const {
  return tables_[in_lower_half(a, b)](std::min(rest, highest_));
}

/// Calls `add` with weight, transforms and what is left across, for points from 0 to a wave number:
/// those of the full panels below it, and of the rest of its own panel.
template <class Add>
void RadiationResistance::each_point(double wave_number, Add add) const {
  const auto order = static_cast<std::size_t>(fineness_.points);
  const std::size_t panels = panels_.size() / order;
  const double width = highest_ / static_cast<double>(panels);
  const std::size_t full =
      std::min(panels, static_cast<std::size_t>(std::floor(wave_number / width)));
  const auto rest = [&](double p) {
    return std::sqrt(std::max(0.0, (wave_number - p) * (wave_number + p)));
  };
  for (std::size_t i = 0; i < full * order; ++i)
    add(panels_.weight[i], at_panels_[i], rest(panels_.at[i]));
  const double begin = static_cast<double>(full) * width;
  if (!(wave_number > begin)) return;
  const Points own = even_points(begin, wave_number, turning_, fineness_);
  for (std::size_t i = 0; i < own.size(); ++i)
    add(own.weight[i], transforms(own.at[i]), rest(own.at[i]));
}

std::vector<double> RadiationResistance::lower_half(double frequency) const {
  const std::size_t modes = across_of_.size();
  std::vector<double> found(modes * (modes + 1) / 2, 0.0), of_pair(tables_.size());
  const double wave_number = 2 * M_PI * frequency / air_.sound_speed;
  // omega density/(4 pi^2), twice: both signs of p give the same
  const double scale = frequency * air_.density / M_PI;
  each_point(wave_number, [&](double weight, const Transforms& t, double rest) {
    for (std::size_t a = 0; a < across_count_; ++a)
      for (std::size_t b = 0; b <= a; ++b)
        of_pair[in_lower_half(a, b)] = scale * weight * across(a, b, rest);
    double* to = found.data();
    for (std::size_t k = 0; k < modes; to += ++k) {
      const double re = t.re[k], im = t.im[k];
      if (across_count_ == 1) {
        for (std::size_t l = 0; l <= k; ++l) to[l] += of_pair[0] * (re * t.re[l] + im * t.im[l]);
      } else {
        for (std::size_t l = 0; l <= k; ++l)
          to[l] +=
              of_pair[in_lower_half(across_of_[k], across_of_[l])] * (re * t.re[l] + im * t.im[l]);
      }
    }
  });
  return found;
}

double RadiationResistance::of_mode(std::size_t mode, double frequency) const {
  const double scale = frequency * air_.density / M_PI;
  const std::size_t a = across_of_[mode];
  double sum = 0;
  each_point(2 * M_PI * frequency / air_.sound_speed, [&](double weight, const Transforms& t,
                                                          double rest) {
    sum += weight * across(a, a, rest) * (t.re[mode] * t.re[mode] + t.im[mode] * t.im[mode]);
  });
  return scale * sum;
}

double inertia_of_air(const Radiator& radiator, const Air& air, double mass_per_area) {
  // The integral of 1/r over any region of this area is at most that over a disc about its centre,
  // 2 pi radius. So is the norm of the integral operator (Schur), and |cos(k r)/r| <= 1/r.
  const double radius = std::sqrt(radiator.area() / M_PI);
  // Two sides add at most 2 density radius to the mass; half of that is taken off the frequency.
  return air.density * radius / mass_per_area;
}

}  // namespace ra2d
