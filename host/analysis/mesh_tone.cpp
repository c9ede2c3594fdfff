// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/mesh_tone.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "host/analysis/distributions.hpp"
#include "host/analysis/peaks.hpp"
#include "host/analysis/spectrum.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/result/statistics.hpp"

namespace ra2d {
namespace {

using Complex = std::complex<double>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ComplexRows = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr std::size_t blocks_of_segment = 128;
constexpr std::size_t splines = 4, parts = 2 * splines;  // that a place lies under

Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

/// exp(-2 pi i turns / whole), of any whole numbers.
Complex rotation(std::size_t turns, std::size_t whole) {
  return std::polar(
      1.0, -2 * std::numbers::pi * static_cast<double>(turns % whole) / static_cast<double>(whole));
}

/// The cubic splines over a place t of 0 to 1 in its block: the one that ends there first. They add
/// up to 1.
std::array<double, splines> splines_at(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6,
          t * t * t / 6};
}

/// The share of a tone that the average under a spline leaves, so many lines away from the middle.
double left_by_splines(std::size_t lines, std::size_t block, std::size_t segment) {
  double sum = 0;
  for (std::size_t r = 0; r < block; ++r) {
    const std::array<double, splines> w =
        splines_at(static_cast<double>(r) / static_cast<double>(block));
    for (std::size_t q = 0; q < splines; ++q) {
      // from the middle of spline q, two blocks after its beginning
      const double place =
          static_cast<double>(r) + (1 - static_cast<double>(q)) * static_cast<double>(block);
      sum += w[q] * std::cos(2 * std::numbers::pi * static_cast<double>(lines) * place /
                             static_cast<double>(segment));
    }
  }
  return sum / static_cast<double>(block);
}

}  // namespace

double rise_by_chance(double degrees_of_freedom) {
  // the median of the lines around is chance, too: for that the tail is a tenth of once in a
  // thousand
  constexpr double tail = 1e-4 / (2 * lines_of_tone + 1);
  return 10 * std::log10(chi_square_quantile(1 - tail, degrees_of_freedom) /
                         chi_square_quantile(0.5, degrees_of_freedom));
}

double rise_of_a_mode(const std::vector<double>& natural, double damping, double tone,
                      double resolution) {
  const double range = static_cast<double>(lines_around_tone) * resolution;
  if (std::isnan(damping) || std::none_of(natural.begin(), natural.end(), [&](double f) {
        return f > 0 && std::abs(f - tone) <= range;
      }))
    return 0;
  std::vector<double> around;
  for (std::size_t j = lines_of_tone + 1; j <= lines_around_tone; ++j) {
    const double away = static_cast<double>(j) * resolution / (damping * tone);  // half widths
    around.push_back(1 / (1 + away * away));
  }
  return -10 * std::log10(median(std::move(around)));
}

MeshToneWatch::MeshToneWatch(double frequency, std::size_t first, std::size_t count, double rate,
                             std::size_t modes)
    : frequency_{frequency},
      rate_{rate},
      first_{first},
      count_{count},
      modes_{modes},
      segment_{usual_segment(count)} {
  if (!(frequency_ > 0) || !(frequency_ < rate_ / 2) || segment_ == 0 || modes_ == 0) return;
  line_ = static_cast<std::size_t>(std::lround(frequency_ / rate_ * static_cast<double>(segment_)));
  if (line_ <= lines_around_tone || line_ + lines_around_tone > segment_ / 2) return;
  block_ = std::max<std::size_t>(1, segment_ / blocks_of_segment);
  for (std::size_t r = 0; r < block_; ++r) {
    const Complex turned = rotation(line_ * r, segment_);
    for (const double w : splines_at(static_cast<double>(r) / static_cast<double>(block_)))
      kernel_.insert(kernel_.end(), {w * turned.real(), w * turned.imag()});
  }
  sums_.block.resize(parts * modes_);
  sums_.averages.resize((count_ / block_ + splines) * modes_);
}

void MeshToneWatch::add_rows(std::size_t at, std::span<const double> rows) {
  if (block_ == 0) return;
  const std::size_t count = rows.size() / modes_;
  std::size_t i = at < first_ ? first_ - at : 0;
  Eigen::Map<Rows> sum(sums_.block.data(), index(parts), index(modes_));
  while (i < count && sums_.rows < count_) {
    const std::size_t in_block = sums_.rows % block_;
    const std::size_t now = std::min({block_ - in_block, count - i, count_ - sums_.rows});
    const Eigen::Map<const Rows> some(rows.data() + i * modes_, index(now), index(modes_)),
        kernel(kernel_.data() + in_block * parts, index(now), index(parts));
    sum.noalias() += kernel.transpose() * some;
    i += now;
    sums_.rows += now;
    if (sums_.rows % block_ == 0) end_block();
  }
}

void MeshToneWatch::end_block() {
  const std::size_t block = sums_.rows / block_ - 1;
  const Complex turned = rotation(line_ * (block * block_ % segment_), segment_);
  for (std::size_t q = 0; q < splines; ++q)
    for (std::size_t k = 0; k < modes_; ++k)
      sums_.averages[(block + q) * modes_ + k] +=
          turned * Complex(sums_.block[2 * q * modes_ + k], sums_.block[(2 * q + 1) * modes_ + k]);
  std::fill(sums_.block.begin(), sums_.block.end(), 0.0);
}

void MeshToneWatch::go_on(Sums sums) {
  if (sums.rows > count_ || sums.block.size() != sums_.block.size() ||
      sums.averages.size() != sums_.averages.size())
    throw std::invalid_argument("the spectrum about its mesh tone is of another stretch");
  sums_ = std::move(sums);
}

MeshTone MeshToneWatch::tone(const std::vector<double>& weights, const std::vector<double>& natural,
                             double damping) const {
  MeshTone found{frequency_ > 0 ? frequency_ : quiet_nan, frequency_ > 0 && frequency_ < rate_ / 2,
                 quiet_nan, quiet_nan};
  const std::size_t segments = block_ > 0 ? half_overlapping(rate_, segment_).count(sums_.rows) : 0;
  if (segments == 0) return found;
  const std::size_t length = segment_ / block_;  // averages of a segment
  constexpr std::size_t middle = lines_around_tone;
  ComplexRows waves(index(2 * middle + 1), index(length));
  for (std::size_t j = 0; j <= middle; ++j) {
    const double left = left_by_splines(j, block_, segment_);
    for (std::size_t i = 0; i < length; ++i) {
      const double window = 0.5 - 0.5 * rotation(i, length).real();
      const Complex wave = window / left * rotation(i * j, length);
      waves(index(middle + j), index(i)) = wave;
      waves(index(middle - j), index(i)) = std::conj(wave);
    }
  }
  // average i + 1 is that about the beginning of block i
  std::vector<double> density(2 * middle + 1);
  for (std::size_t s = 0; s < segments; ++s) {
    const Eigen::Map<const ComplexRows> part(
        sums_.averages.data() + (s * (length / 2) + 1) * modes_, index(length), index(modes_));
    const ComplexRows lines = waves * part;
    for (std::size_t j = 0; j < density.size(); ++j)
      for (std::size_t k = 0; k < modes_; ++k)
        density[j] += weights[k] * std::norm(lines(index(j), index(k)));
  }
  const auto count = static_cast<double>(segments);
  found.rise = rise_of(density);
  // Hann windows that overlap by a half have a sixth in common (Welch::degrees_of_freedom)
  found.by_chance =
      rise_by_chance(2 * count / (1 + (1 - 1 / count) / 18)) +
      rise_of_a_mode(natural, damping, frequency_, rate_ / static_cast<double>(segment_));
  return found;
}

}  // namespace ra2d
