// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/transfer.hpp"

#include <algorithm>
#include <cmath>

#include "host/base/fourier.hpp"

namespace ra2d {
namespace {

using Complex = std::complex<double>;

/// The face's points for one place, and the shapes there.
class FacePoints {
 public:
  FacePoints(const Radiator& radiator, const Position& at, double wave_number,
             const Fineness& fineness)
      : radiator_{radiator},
        at_{at},
        fineness_{fineness},
        turning_across_{wave_number + radiator.turning_across},
        x_{graded_points(0, radiator.length, wave_number + radiator.turning_along,
                         {at[0], beyond(at[1], radiator.width, at[2])}, fineness)} {}

  std::size_t rows() const { return x_.size(); }
  double x(std::size_t row) const { return x_.at[row]; }

  /// The points of one row, and how far it is from the place.
  struct Row {
    Points y;
    double x_weight = 0, apart = 0;
  };
  Row row(std::size_t i) const {
    const double apart = std::hypot(x_.at[i] - at_[0], at_[2]);
    return {graded_points(0, radiator_.width, turning_across_, {at_[1], apart}, fineness_),
            x_.weight[i], apart};
  }
  double distance(const Row& row, std::size_t j) const {
    return std::hypot(row.y.at[j] - at_[1], row.apart);
  }

 private:
  /// The distance of a place from an interval and its plane.
  static double beyond(double y, double width, double z) {
    return std::hypot(std::max({-y, y - width, 0.0}), z);
  }

  const Radiator& radiator_;
  Position at_;
  Fineness fineness_;
  double turning_across_;
  Points x_;
};

double sign_of(const Position& at) { return at[2] < 0 ? -1 : 1; }

/// The kernel by which an arrival is spread over a grid: exp(b (sqrt(1 - u^2) - 1)), u from -1 to 1
/// over its width (Barnett, Magland, af Klinteberg 2019). At twice the rate its error is 1e-11.
class SpreadingKernel {
 public:
  static constexpr int width = 13;  // samples of the grid

  static double at(double apart) {  // in samples of the grid
    const double u = 2 * apart / width, rest = 1 - u * u;
    return rest > 0 ? std::exp(sharpness * (std::sqrt(rest) - 1)) : 0;
  }

  /// Its transform at `turns` per sample of the grid.
  static double transform(double turns) {
    static const Points points = even_points(0, width / 2.0, 2 * M_PI, {20, 4, 1});
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      sum += points.weight[i] * at(points.at[i]) * std::cos(2 * M_PI * turns * points.at[i]);
    return 2 * sum;
  }

 private:
  static constexpr double sharpness = 2.30 * width;
};

/// When sound from the face arrives: of each mode, in `slots` samples of the grid from `begin` on,
/// each arrival spread over its neighbours by SpreadingKernel.
std::vector<double> spread_arrivals(const Radiator& radiator, const Air& air, const Position& at,
                                    const FacePoints& face, double grid_rate, double begin,
                                    std::size_t slots) {
  constexpr int wide = SpreadingKernel::width;
  const std::size_t modes = radiator.modes.size();
  std::vector<double> arrivals(modes * slots, 0.0);
  std::vector<double> across(radiator.across.size() * slots, 0.0);
  const double scale = sign_of(at) * air.density / (2 * M_PI);
  for (std::size_t i = 0; i < face.rows(); ++i) {
    const FacePoints::Row row = face.row(i);
    std::size_t first = slots, beyond = 0;
    for (std::size_t j = 0; j < row.y.size(); ++j) {
      const double r = face.distance(row, j);
      const double arrival = r / air.sound_speed * grid_rate - begin;
      const auto slot = static_cast<std::size_t>(std::ceil(arrival - wide / 2.0));
      double spread[wide];
      for (int s = 0; s < wide; ++s)
        spread[s] =
            row.y.weight[j] / r * SpreadingKernel::at(static_cast<double>(slot) + s - arrival);
      for (std::size_t a = 0; a < radiator.across.size(); ++a) {
        const double shape = radiator.across[a](row.y.at[j]);
        double* to = &across[a * slots + slot];
        for (int s = 0; s < wide; ++s) to[s] += shape * spread[s];
      }
      first = std::min(first, slot);
      beyond = std::max(beyond, slot + wide);
    }
    for (std::size_t k = 0; k < modes; ++k) {
      const double shape = scale * row.x_weight * radiator.modes[k].along(face.x(i));
      const double* from = &across[radiator.modes[k].across * slots];
      double* to = &arrivals[k * slots];
      for (std::size_t s = first; s < beyond; ++s) to[s] += shape * from[s];
    }
    for (std::size_t a = 0; a < radiator.across.size(); ++a)
      std::fill(across.begin() + static_cast<std::ptrdiff_t>(a * slots + first),
                across.begin() + static_cast<std::ptrdiff_t>(a * slots + beyond), 0.0);
  }
  return arrivals;
}

}  // namespace

Distances distances(const Radiator& radiator, const Position& at) {
  const auto outside = [](double x, double length) { return std::max({-x, x - length, 0.0}); };
  const auto far = [](double x, double length) {
    return std::max(std::abs(x), std::abs(x - length));
  };
  return {std::hypot(outside(at[0], radiator.length), outside(at[1], radiator.width), at[2]),
          std::hypot(far(at[0], radiator.length), far(at[1], radiator.width), at[2])};
}

double face_points(const Radiator& radiator, const Air& air, double rate) {
  const Fineness usual;
  const double wave_number = M_PI * rate / air.sound_speed;
  const auto on_line = [&](double length, double turning) {  // the last panel begun counts
    return usual.points * (1 + length * (wave_number + turning) / (2 * usual.phase));
  };
  return on_line(radiator.length, radiator.turning_along) *
         on_line(radiator.width, radiator.turning_across);
}

std::vector<Complex> transfer(const Radiator& radiator, const Air& air, const Position& at,
                              double frequency, const Fineness& fineness) {
  const double wave_number = 2 * M_PI * frequency / air.sound_speed;
  const FacePoints face(radiator, at, wave_number, fineness);
  std::vector<Complex> found(radiator.modes.size()), across(radiator.across.size());
  for (std::size_t i = 0; i < face.rows(); ++i) {
    const FacePoints::Row row = face.row(i);
    std::fill(across.begin(), across.end(), Complex{});
    for (std::size_t j = 0; j < row.y.size(); ++j) {
      const double r = face.distance(row, j);
      const Complex wave = std::polar(row.y.weight[j] / r, -wave_number * r);
      for (std::size_t a = 0; a < across.size(); ++a)
        across[a] += wave * radiator.across[a](row.y.at[j]);
    }
    const double weight = sign_of(at) * air.density / (2 * M_PI) * row.x_weight;
    for (std::size_t k = 0; k < found.size(); ++k)
      found[k] += weight * radiator.modes[k].along(face.x(i)) * across[radiator.modes[k].across];
  }
  return found;
}

TransferLines transfer_lines(const Radiator& radiator, const Air& air, const Position& at,
                             double rate, std::size_t length, const Fineness& fineness) {
  constexpr int wide = SpreadingKernel::width;
  const double wave_number = M_PI * rate / air.sound_speed;  // at half the rate
  const double grid_rate = 2 * rate;
  const Distances ways = distances(radiator, at);
  TransferLines lines;
  lines.lead = static_cast<std::size_t>(std::floor(ways.least / air.sound_speed * rate));
  const double begin = 2 * static_cast<double>(lines.lead) - wide;  // of the grid, in its samples
  const auto slots = static_cast<std::size_t>(
      std::ceil(ways.largest / air.sound_speed * grid_rate - begin) + 2 * wide);
  const std::size_t modes = radiator.modes.size();
  const FacePoints face(radiator, at, wave_number, fineness);
  const std::vector<double> arrivals =
      spread_arrivals(radiator, air, at, face, grid_rate, begin, slots);

  // the kernel's transform taken off, and the grid's beginning, `wide` samples before the lead
  std::vector<Complex> correction(length / 2 + 1);
  for (std::size_t j = 0; j < correction.size(); ++j) {
    const double turns = static_cast<double>(j) / (2 * static_cast<double>(length));
    correction[j] = std::polar(1 / SpreadingKernel::transform(turns), 2 * M_PI * turns * wide);
  }
  Fourier fourier(2 * length);
  for (std::size_t k = 0; k < modes; ++k) {
    const auto input = fourier.input();
    std::fill(input.begin(), input.end(), 0.0);
    for (std::size_t s = 0; s < slots; ++s)  // later arrivals fold over: the lines stay right
      input[s % input.size()] += arrivals[k * slots + s];
    fourier.transform();
    std::vector<Complex> of_mode(correction.size());
    for (std::size_t j = 0; j < of_mode.size(); ++j) of_mode[j] = fourier.line(j) * correction[j];
    lines.modes.push_back(std::move(of_mode));
  }
  return lines;
}

}  // namespace ra2d
