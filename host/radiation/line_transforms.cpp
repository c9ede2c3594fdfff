// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/line_transforms.hpp"

#include <algorithm>
#include <cmath>

namespace ra2d {
namespace {

// of a shape's largest value: far above roundings, far below the errors of the quadrature
constexpr double same_value = 1e-11;

/// Of the shape with this number of `shapes`: (point, shape), the points symmetric to the middle.
Parity parity_of(const std::vector<double>& shapes, std::size_t count, std::size_t shape) {
  const std::size_t points = shapes.size() / count;
  double largest = 0, off_even = 0, off_odd = 0;
  for (std::size_t i = 0; i < points; ++i) {
    const double here = shapes[i * count + shape], there = shapes[(points - 1 - i) * count + shape];
    largest = std::max(largest, std::abs(here));
    off_even = std::max(off_even, std::abs(here - there));
    off_odd = std::max(off_odd, std::abs(here + there));
  }
  return off_even <= same_value * largest  ? Parity::even
         : off_odd <= same_value * largest ? Parity::odd
                                           : Parity::neither;
}

}  // namespace

LineTransforms::LineTransforms(const std::vector<LineShape>& shapes, double size, double turning,
                               double highest, const Fineness& fineness)
    : between_{highest, size / 2, fineness} {
  const Points points = even_points(0, size, highest + turning, fineness);
  std::vector<double> weighted;  // (point, shape)
  for (const double x : points.at)
    for (const LineShape& shape : shapes) weighted.push_back(shape(x));
  for (std::size_t k = 0; k < shapes.size(); ++k)
    parities_.push_back(parity_of(weighted, shapes.size(), k));
  if (std::find(parities_.begin(), parities_.end(), Parity::neither) != parities_.end()) {
    std::fill(parities_.begin(), parities_.end(), Parity::neither);
    parts_ = 2;
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < shapes.size(); ++k)
      weighted[i * shapes.size() + k] *= points.weight[i];
  found_.reserve(between_.points().size() * parts_ * shapes.size());
  for (const double wave_number : between_.points().at)
    add_transforms(wave_number, points, size / 2, weighted);
}

/// Of shapes with a parity one half of the line counts twice.
void LineTransforms::add_transforms(double wave_number, const Points& points, double middle,
                                    const std::vector<double>& weighted) {
  const std::size_t shapes = parities_.size();
  const bool both = parts_ == 2;
  const std::size_t used = both ? points.size() : (points.size() + 1) / 2;
  std::vector<double> re(shapes), im(shapes);
  for (std::size_t i = 0; i < used; ++i) {
    const double phase = wave_number * (points.at[i] - middle),
                 times = both || 2 * i + 1 == points.size() ? 1 : 2;
    const double cosine = times * std::cos(phase), sine = times * std::sin(phase);
    const double* const values = &weighted[i * shapes];
    for (std::size_t k = 0; k < shapes; ++k) re[k] += cosine * values[k];
    for (std::size_t k = 0; k < shapes; ++k) im[k] -= sine * values[k];
  }
  for (std::size_t k = 0; k < shapes; ++k)
    found_.push_back(parities_[k] == Parity::odd ? im[k] : re[k]);
  if (both) found_.insert(found_.end(), im.begin(), im.end());
}

void LineTransforms::at(double wave_number, std::vector<double>& parts) const {
  double weights[most_points_of_rule];
  const std::size_t count = parts_ * parities_.size();
  const double* sample = &found_[between_.weigh(wave_number, weights) * count];
  parts.assign(count, 0.0);
  for (std::size_t n = 0; n < between_.order(); ++n, sample += count)
    for (std::size_t k = 0; k < count; ++k) parts[k] += weights[n] * sample[k];
}

}  // namespace ra2d
