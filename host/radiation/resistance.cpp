// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/resistance.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

namespace ra2d {
namespace {

std::size_t in_lower_half(std::size_t a, std::size_t b) {
  return std::max(a, b) * (std::max(a, b) + 1) / 2 + std::min(a, b);
}

/// Transforms of the shapes across, from the middle: at a few wave numbers, and between them by
/// interpolation. `weighted`: (shape, point of `y`).
class AcrossTransforms {
 public:
  AcrossTransforms(const std::vector<std::vector<double>>& weighted, const Points& y, double width,
                   double highest, const Fineness& fineness)
      : shapes_{weighted.size()}, between_{highest, width / 2, fineness} {
    std::vector<std::complex<double>> waves(y.size());
    for (const double q : between_.points().at) {
      for (std::size_t i = 0; i < y.size(); ++i)
        waves[i] = std::polar(1.0, -q * (y.at[i] - width / 2));
      for (const std::vector<double>& shape : weighted)
        found_.push_back(
            std::inner_product(waves.begin(), waves.end(), shape.begin(), std::complex<double>{}));
    }
  }

  std::size_t shapes() const { return shapes_; }
  /// Of each shape, at a wave number from 0 to the highest.
  void at(double q, std::vector<std::complex<double>>& transforms) const {
    double weights[most_points_of_rule];
    const std::complex<double>* sample = &found_[between_.weigh(q, weights) * shapes_];
    std::fill(transforms.begin(), transforms.end(), std::complex<double>{});
    for (std::size_t n = 0; n < between_.order(); ++n)
      for (std::size_t a = 0; a < shapes_; ++a) transforms[a] += weights[n] * *sample++;
  }

 private:
  std::size_t shapes_;
  Interpolation between_;
  std::vector<std::complex<double>> found_;  // (point of between_, shape)
};

/// Integrals over the angle of b_a b_b* at q = rest sin(angle), from -pi/2 to pi/2, for every pair
/// of shapes, lower half. The integrands have the period pi, so that equal steps converge as fast
/// as Gauss's; -q has the conjugates of q, so that half of the angles are enough.
std::vector<double> across_powers(const AcrossTransforms& across, double rest, double width) {
  const int half = 12 + static_cast<int>(std::ceil(rest * width / 2));
  const std::size_t shapes = across.shapes();
  std::vector<double> sums(shapes * (shapes + 1) / 2, 0.0);
  std::vector<std::complex<double>> transforms(shapes);
  for (int step = 0; step < half; ++step) {
    across.at(rest * std::sin(M_PI * (step + 0.5) / (2 * half)), transforms);
    for (std::size_t a = 0; a < shapes; ++a)
      for (std::size_t b = 0; b <= a; ++b)
        sums[in_lower_half(a, b)] += (transforms[a] * std::conj(transforms[b])).real();
  }
  for (double& sum : sums) sum = sum * M_PI / half;
  return sums;
}

}  // namespace

RadiationResistance::RadiationResistance(const Radiator& radiator, const Air& air, double highest,
                                         const Fineness& fineness)
    : air_{air},
      highest_{2 * M_PI * highest / air.sound_speed},
      turning_{radiator.length + radiator.width},
      fineness_{fineness},
      across_count_{radiator.across.size()},
      along_{highest_, radiator.length / 2, fineness},
      across_{highest_, radiator.width, fineness} {
  const Points x = even_points(0, radiator.length, highest_ + radiator.turning_along, fineness);
  std::vector<double> shapes;  // (mode, point), with the points' weights
  for (const RadiatingMode& mode : radiator.modes) {
    across_of_.push_back(mode.across);
    for (std::size_t i = 0; i < x.size(); ++i) shapes.push_back(x.weight[i] * mode.along(x.at[i]));
  }
  std::vector<double> cosine(x.size()), sine(x.size());
  for (const double p : along_.points().at) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      cosine[i] = std::cos(p * (x.at[i] - radiator.length / 2));
      sine[i] = std::sin(p * (x.at[i] - radiator.length / 2));
    }
    const std::size_t modes = across_of_.size();
    Transforms found{std::vector<double>(modes), std::vector<double>(modes)};
    for (std::size_t k = 0; k < modes; ++k) {
      const double* of_mode = &shapes[k * x.size()];
      for (std::size_t i = 0; i < x.size(); ++i) {
        found.re[k] += of_mode[i] * cosine[i];
        found.im[k] -= of_mode[i] * sine[i];
      }
    }
    transforms_.push_back(std::move(found));
  }
  const Points y = even_points(0, radiator.width, highest_ + radiator.turning_across, fineness);
  std::vector<std::vector<double>> weighted;
  for (const LineShape& shape : radiator.across) {
    weighted.emplace_back();
    for (std::size_t i = 0; i < y.size(); ++i)
      weighted.back().push_back(y.weight[i] * shape(y.at[i]));
  }
  tables_.resize(across_count_ * (across_count_ + 1) / 2);
  const AcrossTransforms transforms(weighted, y, radiator.width, highest_, fineness);
  for (const double rest : across_.points().at) {
    const std::vector<double> powers = across_powers(transforms, rest, radiator.width);
    for (std::size_t pair = 0; pair < powers.size(); ++pair) tables_[pair].push_back(powers[pair]);
  }
}

void RadiationResistance::across(double rest, std::vector<double>& of_pair) const {
  double weights[most_points_of_rule];
  const std::size_t first = across_.weigh(std::min(rest, highest_), weights);
  for (std::size_t pair = 0; pair < tables_.size(); ++pair)
    of_pair[pair] =
        std::inner_product(weights, weights + across_.order(), &tables_[pair][first], 0.0);
}

/// Calls `add` with weight, transforms and what is left across, for points from 0 to a wave number.
template <class Add>
void RadiationResistance::each_point(double wave_number, Add add) const {
  if (!(wave_number > 0)) return;
  const Points points = even_points(0, wave_number, turning_, fineness_);
  const std::size_t modes = across_of_.size();
  Transforms here{std::vector<double>(modes), std::vector<double>(modes)};
  double weights[most_points_of_rule];
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double p = points.at[i];
    std::fill(here.re.begin(), here.re.end(), 0.0);
    std::fill(here.im.begin(), here.im.end(), 0.0);
    const std::size_t first = along_.weigh(p, weights);
    for (std::size_t n = 0; n < along_.order(); ++n) {
      const Transforms& sample = transforms_[first + n];
      for (std::size_t k = 0; k < modes; ++k) {
        here.re[k] += weights[n] * sample.re[k];
        here.im[k] += weights[n] * sample.im[k];
      }
    }
    add(points.weight[i], here, std::sqrt((wave_number - p) * (wave_number + p)));
  }
}

std::vector<double> RadiationResistance::lower_half(double frequency) const {
  const std::size_t modes = across_of_.size();
  std::vector<double> found(modes * (modes + 1) / 2, 0.0), of_pair(tables_.size());
  std::vector<double> factors(across_count_ * modes);  // of a shape across with that of each mode
  const double wave_number = 2 * M_PI * frequency / air_.sound_speed;
  // omega density/(4 pi^2), twice: both signs of p give the same
  const double scale = frequency * air_.density / M_PI;
  each_point(wave_number, [&](double weight, const Transforms& t, double rest) {
    across(rest, of_pair);
    for (double& value : of_pair) value *= scale * weight;
    for (std::size_t a = 0; a < across_count_; ++a)
      for (std::size_t l = 0; l < modes; ++l)
        factors[a * modes + l] = of_pair[in_lower_half(a, across_of_[l])];
    double* to = found.data();
    for (std::size_t k = 0; k < modes; to += ++k) {
      const double re = t.re[k], im = t.im[k];
      const double* factor = &factors[across_of_[k] * modes];
      for (std::size_t l = 0; l <= k; ++l) to[l] += factor[l] * (re * t.re[l] + im * t.im[l]);
    }
  });
  return found;
}

double RadiationResistance::of_mode(std::size_t mode, double frequency) const {
  const double scale = frequency * air_.density / M_PI;
  const std::size_t a = across_of_[mode];
  std::vector<double> of_pair(tables_.size());
  double sum = 0;
  each_point(2 * M_PI * frequency / air_.sound_speed,
             [&](double weight, const Transforms& t, double rest) {
               across(rest, of_pair);
               sum += weight * of_pair[in_lower_half(a, a)] *
                      (t.re[mode] * t.re[mode] + t.im[mode] * t.im[mode]);
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
