// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/half_power.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

constexpr double usual_damping = 0.02;  // to begin with, where nothing is expected
constexpr double around = 2;            // widths on either side of the top that are looked at
constexpr double groups_a_width = 50;   // about, where a width has more lines
constexpr std::size_t fewest = 8;       // groups
constexpr int rounds = 30, steps = 50;
constexpr std::size_t curve_parts = 8;                     // in which the curve must fit
constexpr double most_misfit = 0.25, misfit_errors = 3.5;  // beside what chance does
constexpr double largest = 0.3;                            // a damping that is no peak any more

/// Means of neighbouring lines.
struct Groups {
  std::vector<double> frequency, power;
  double lines = 0;  // that are independent, in each
};

struct Curve {
  double top = 0, frequency = 0, damping = 0;

  double width() const { return 2 * damping * frequency; }
  double place_of(double f) const { return (f / frequency - frequency / f) / (2 * damping); }
  double at(double f) const {
    const double x = place_of(f);
    return top / (1 + x * x);
  }
};

/// How the logarithm of a curve changes with those of its top and its damping, and with its
/// frequency in units of half its width.
std::array<double, 3> slopes(const Curve& curve, double f) {
  const double x = curve.place_of(f);
  const double turn = -(f / curve.frequency + curve.frequency / f) / 2;
  return {1, 2 * x * x / (1 + x * x), -2 * x / (1 + x * x) * turn};
}

Groups gather(const ModeLines& lines, const Curve& curve) {
  const double far = around * curve.width();
  const double width = curve.width() / lines.resolution;  // in lines
  const auto size = static_cast<std::size_t>(std::max(1.0, std::floor(width / groups_a_width)));
  const auto first = static_cast<std::size_t>(
      std::max(1.0, std::ceil((curve.frequency - far) / lines.resolution)));
  const auto last = static_cast<std::size_t>(
      std::min(static_cast<double>(lines.power.size()) - 1,
               std::max(0.0, std::floor((curve.frequency + far) / lines.resolution))));
  Groups groups;
  groups.lines = static_cast<double>(size) * lines.independent;
  for (std::size_t j = first; j + size <= last + 1; j += size) {
    double sum = 0;
    for (std::size_t i = j; i < j + size; ++i) sum += lines.power[i];
    groups.power.push_back(sum / static_cast<double>(size));
    groups.frequency.push_back((static_cast<double>(j) + 0.5 * static_cast<double>(size - 1)) *
                               lines.resolution);
  }
  return groups;
}

using Matrix = std::array<std::array<double, 3>, 3>;

/// Of a symmetric positive definite one; nothing where it is none.
std::optional<Matrix> inverse(const Matrix& m) {
  Matrix adjoint{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      adjoint[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
  const double determinant =
      m[0][0] * adjoint[0][0] + m[0][1] * adjoint[1][0] + m[0][2] * adjoint[2][0];
  if (!(determinant > 1e-12 * m[0][0] * m[1][1] * m[2][2])) return {};
  for (auto& row : adjoint)
    for (double& value : row) value /= determinant;
  return adjoint;
}

/// The logarithm of how likely the lines are under a curve, but for what all curves share.
double likelihood(const Groups& groups, const Curve& curve) {
  double sum = 0;
  for (std::size_t j = 0; j < groups.power.size(); ++j) {
    const double expected = curve.at(groups.frequency[j]);
    sum -= std::log(expected) + groups.power[j] / expected;
  }
  return sum;
}

/// A step towards the likeliest curve, and how far chance moves that one.
struct Step {
  std::array<double, 3> change{};
  double variance = 0;  // of ln(damping)
};

/// Fisher's scoring: what the lines still say goes through the information that they can give.
std::optional<Step> step_from(const Groups& groups, const Curve& curve) {
  Matrix information{};
  std::array<double, 3> score{};
  for (std::size_t j = 0; j < groups.power.size(); ++j) {
    const auto slope = slopes(curve, groups.frequency[j]);
    const double rest = groups.power[j] / curve.at(groups.frequency[j]) - 1;
    for (std::size_t a = 0; a < 3; ++a) {
      score[a] += groups.lines * slope[a] * rest;
      for (std::size_t b = 0; b < 3; ++b) information[a][b] += groups.lines * slope[a] * slope[b];
    }
  }
  const auto variance = inverse(information);
  if (!variance) return {};
  Step step{{}, (*variance)[1][1]};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) step.change[a] += (*variance)[a][b] * score[b];
  if (!std::isfinite(step.change[0] + step.change[1] + step.change[2])) return {};
  for (double& value : step.change) value = std::clamp(value, -0.5, 0.5);
  return step;
}

Curve moved(const Curve& curve, const std::array<double, 3>& change, double share) {
  return {curve.top * std::exp(share * change[0]),
          curve.frequency + share * change[2] * curve.width() / 2,
          curve.damping * std::exp(share * change[1])};
}

/// The likeliest curve. Returns the variance of ln(damping); nothing where there is none nearby.
std::optional<double> fit(const Groups& groups, const ModePlace& place, Curve& curve) {
  double before = likelihood(groups, curve);
  for (int count = 0; count < steps; ++count) {
    const std::optional<Step> step = step_from(groups, curve);
    if (!step) return {};
    double share = 1;
    Curve next = moved(curve, step->change, share);
    double after = likelihood(groups, next);
    for (; !(after >= before - 1e-9) && share > 1e-3; after = likelihood(groups, next))
      next = moved(curve, step->change, share /= 2);
    const double far = share * std::max(std::abs(step->change[1]), std::abs(step->change[2]));
    curve = next;
    before = after;
    if (curve.frequency < place.low || curve.frequency > place.high || curve.damping > largest)
      return {};
    if (far < 1e-3 * std::sqrt(step->variance)) return step->variance;
  }
  return {};
}

/// The highest place of lines that are averaged over a quarter of the width that is expected.
std::optional<Curve> begin(const ModeLines& lines, const ModePlace& place) {
  if (!(place.low < lines.resolution * static_cast<double>(lines.power.size()))) return {};
  const bool expected = place.damping > 0 && place.damping < largest;
  Curve curve{0, place.natural, expected ? place.damping : usual_damping};
  const auto size =
      static_cast<std::size_t>(std::max(1.0, std::round(curve.width() / 4 / lines.resolution)));
  const auto first = static_cast<std::size_t>(std::max(1.0, place.low / lines.resolution));
  const auto last =
      std::min(static_cast<double>(lines.power.size()), place.high / lines.resolution);
  double sum = 0;
  for (std::size_t j = first; static_cast<double>(j) < last; ++j) {
    sum += lines.power[j];
    if (j >= first + size) sum -= lines.power[j - size];
    if (j + 1 < first + size || sum <= curve.top * static_cast<double>(size)) continue;
    curve.top = sum / static_cast<double>(size);
    curve.frequency =
        (static_cast<double>(j) - 0.5 * static_cast<double>(size - 1)) * lines.resolution;
  }
  if (!(curve.top > 0)) return {};
  return curve;
}

/// Whether the lines go along with the curve everywhere: in each eighth of them their mean is that
/// of the curve, but for a quarter and for chance.
bool follows(const Groups& groups, const Curve& curve) {
  const std::size_t count = groups.power.size();
  for (std::size_t part = 0; part < curve_parts; ++part) {
    const std::size_t first = part * count / curve_parts, last = (part + 1) * count / curve_parts;
    double sum = 0;
    for (std::size_t j = first; j < last; ++j)
      sum += groups.power[j] / curve.at(groups.frequency[j]);
    const auto here = static_cast<double>(last - first);
    const double chance = 1 / std::sqrt(here * groups.lines);
    if (std::abs(sum / here - 1) > most_misfit + misfit_errors * chance) return false;
  }
  return true;
}

HalfPower without_damping(NoDamping why) { return {quiet_nan, quiet_nan, quiet_nan, why}; }

}  // namespace

const char* word_of(NoDamping why) {
  switch (why) {
    case NoDamping::found:
      return "";
    case NoDamping::short_run:
      return "short";
    case NoDamping::shape:
      return "shape";
    case NoDamping::lost:
      return "lost";
    case NoDamping::mesh:
      return "mesh";
  }
  return "";
}

const char* reason_of(NoDamping why) {
  switch (why) {
    case NoDamping::found:
      return "";
    case NoDamping::short_run:
      return "the run is too short";
    case NoDamping::shape:
      return "the peak has not the shape of one mode";
    case NoDamping::lost:
      return "no peak near the mode";
    case NoDamping::mesh:
      return "on a tone of the mesh";
  }
  return "";
}

ModePlace place_of_mode(std::span<const double> natural, std::size_t k, double damping) {
  const double f = natural[k];
  const double below = k > 0 ? natural[k - 1] : 0.0;
  const double above = k + 1 < natural.size() ? natural[k + 1] : 2 * f;
  return {f, std::max(0.9 * f, (below + f) / 2), std::min(1.1 * f, (f + above) / 2), damping};
}

HalfPower half_power(const ModeLines& lines, const ModePlace& place) {
  std::optional<Curve> curve = begin(lines, place);
  if (!curve) return without_damping(NoDamping::lost);
  // the lines that are looked at follow the width, until they hardly change
  for (int round = 0; round < rounds && curve->damping < largest; ++round) {
    const Groups groups = gather(lines, *curve);
    if (groups.power.size() < fewest) return without_damping(NoDamping::short_run);
    Curve found = *curve;
    const std::optional<double> variance = fit(groups, place, found);
    const double most = 2 * curve->damping;
    if (!variance || found.damping > most) {  // too few of them to see the width
      curve->damping = most;
      continue;
    }
    const double error = std::sqrt(*variance);
    const double change = std::abs(found.damping / curve->damping - 1);
    curve = found;
    if (change > 0.05 * error && round + 1 < rounds) continue;
    if (error > most_uncertain) return without_damping(NoDamping::short_run);
    if (!follows(groups, found)) return without_damping(NoDamping::shape);
    return {found.frequency, found.damping, error * found.damping, NoDamping::found};
  }
  return without_damping(NoDamping::lost);
}

}  // namespace ra2d
