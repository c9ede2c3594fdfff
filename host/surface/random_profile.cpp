// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/random_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/fourier.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/surface/bells.hpp"
#include "host/surface/gaussian.hpp"
#include "host/surface/johnson.hpp"
#include "host/surface/profile.hpp"

namespace ra2d {
namespace {

using std::numbers::pi;

/// Places to the shortest wave: as few as bells take (host/surface/bells.hpp).
constexpr double places_per_wave = 4;
constexpr double shortest_of_exponential = 0.02;  // of the correlation length
constexpr double shortest_of_gaussian = 0.5;      // of it: below, the density is under exp(-4 pi^2)
constexpr double most_places = 0x1p26;

/// To make the spacing of elements exact, up to this many lengths of the process are pressed into
/// one length of the beam, from a start that is up to `most_moved` places later.
constexpr double most_stretched = 1.25;
constexpr int most_moved = 64;

using Complex = std::complex<double>;

// ---- the process

/// Waves that repeat after a period, a variance for each of them; the sum is 1.
struct Waves {
  double place = 0;              // m
  int places = 0;                // of a period
  std::vector<double> variance;  // of wave number 2 pi j/period, j = 0, 1, ...

  double turn(std::size_t j) const { return 2 * pi * static_cast<double>(j) / places; }  // a place
};

/// Integral of k^-(1 + 2 H) from a to b.
double self_affine_part(double hurst, double a, double b) {
  return b > a ? (std::pow(a, -2 * hurst) - std::pow(b, -2 * hurst)) / (2 * hurst) : 0.0;
}

/// Distance beyond which two places are uncorrelated.
double memory(const RandomProfile& p) {
  switch (p.correlation) {
    case Correlation::gaussian:
      return 6.1 * p.correlation_length;  // exp(-6.1^2) = 7e-17
    case Correlation::exponential:
      return 37 * p.correlation_length;
    case Correlation::self_affine:
      break;
  }
  return 2 * p.longest;
}

void scale_to_one(std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  for (double& value : values) value /= sum;
}

Waves waves_of(const RandomProfile& p, double length) {
  Waves out;
  out.place = p.shortest / places_per_wave;
  const double least = (most_stretched * length + memory(p)) / out.place + most_moved + 2;
  if (!(least < most_places))
    throw RequestError(fmt::format(
        "waves from {:.10g} m down to {:.10g} m on a beam of {:.10g} m are too many: raise the "
        "shortest",
        length + memory(p), p.shortest, length));
  out.places = static_cast<int>(quick_length(static_cast<std::size_t>(std::ceil(least))));
  const double step = 2 * pi / (out.places * out.place), last = 2 * pi / p.shortest;
  const auto count = static_cast<std::size_t>(std::floor(last / step + 0.5)) + 1;
  out.variance.assign(std::min(count, static_cast<std::size_t>(out.places / 4) + 1), 0.0);
  for (std::size_t j = 1; j < out.variance.size(); ++j) {
    const double k = static_cast<double>(j) * step, kl = k * p.correlation_length;
    switch (p.correlation) {
      case Correlation::gaussian:
        out.variance[j] = std::exp(-kl * kl / 4);
        break;
      case Correlation::exponential:
        out.variance[j] = 1 / (1 + kl * kl);
        break;
      case Correlation::self_affine:
        out.variance[j] = self_affine_part(p.hurst, std::max(k - step / 2, 2 * pi / p.longest),
                                           std::min(k + step / 2, last));
        break;
    }
  }
  scale_to_one(out.variance);
  return out;
}

/// Waves of the normal heights that the map turns into heights with these waves. Variances below 0
/// and waves shorter than the shortest are left out: no normal heights have them.
Waves before_map(Waves waves, const JohnsonHeights& map) {
  if (map.is_identity()) return waves;
  const auto places = static_cast<std::size_t>(waves.places);
  std::vector<Complex> half(places / 2 + 1);
  for (std::size_t j = 0; j < waves.variance.size(); ++j) half[j] = waves.variance[j] / 2;
  const std::vector<double> correlation = from_lines(half, places);
  Fourier normal(places);
  for (std::size_t n = 0; n < places; ++n)
    normal.input()[n] = map.normal_correlation(correlation[n]);
  normal.transform();
  for (std::size_t j = 1; j < waves.variance.size(); ++j)
    waves.variance[j] = std::max(0.0, normal.line(j).real());
  scale_to_one(waves.variance);
  return waves;
}

/// Mean distance of upward crossings of the mean line (Rice 1945), in m.
double crossing_distance(const Waves& normal, const JohnsonHeights& map) {
  double curvature = 0;
  for (std::size_t j = 1; j < normal.variance.size(); ++j) {
    const double k = normal.turn(j) / normal.place;
    curvature += k * k * normal.variance[j];
  }
  const double level = map.at_mean_line();
  return 2 * pi / std::sqrt(curvature) * std::exp(level * level / 2);
}

/// The slope between nodes over the slope at a point, root mean squares. A wave of number k has
/// between nodes a distance d apart the share sin(k d/2)/(k d/2) of its slope.
double slope_between_nodes(const RandomProfile& p, const Waves& waves, double spacing) {
  if (p.correlation == Correlation::gaussian) {
    // 2 (C(0) - C(d))/d^2 over -C''(0), C(x) = exp(-(x/l)^2)
    const double x = spacing * spacing / (p.correlation_length * p.correlation_length);
    return std::sqrt(-std::expm1(-x) / x);
  }
  double between = 0, at_point = 0;
  for (std::size_t j = 1; j < waves.variance.size(); ++j) {
    const double k = waves.turn(j) / waves.place, slope = waves.variance[j] * k * k;
    const double half = k * spacing / 2, share = std::sin(half) / half;
    at_point += slope;
    between += slope * share * share;
  }
  return std::sqrt(between / at_point);
}

/// The spacing at which that is 1 - most_slope_lost.
double fine_spacing(const RandomProfile& p, const Waves& waves, double spacing) {
  double low = 0, high = spacing;
  for (int halving = 0; halving < 12; ++halving) {
    const double middle = (low + high) / 2;
    (slope_between_nodes(p, waves, middle) < 1 - most_slope_lost ? high : low) = middle;
  }
  return low;
}

void doubt_spectrum(const RandomProfile& p, const Waves& waves, double spacing,
                    std::vector<std::string>& doubts) {
  const double lost = 1 - slope_between_nodes(p, waves, spacing);
  if (!(lost > most_slope_lost)) return;
  const bool smooth = p.correlation == Correlation::gaussian;
  doubts.push_back(fmt::format(
      "nodes {:.4g} m apart lose {:.0f} % of the root mean square slope ({} {:.4g} m). A spacing "
      "of {:.2g} m loses {:.0f} %",
      spacing, 100 * lost, smooth ? "rsm" : "shortest wave", smooth ? p.rsm : p.shortest,
      fine_spacing(p, waves, spacing), 100 * most_slope_lost));
}

// ---- the profile

/// A function of x/place whose spread in expectation is `spread`.
struct Process {
  Bells bells;
  double place;  // m
  double spread;
};

int last_place(double length, double place) {
  return static_cast<int>(most_stretched * length / place) + most_moved + 2;
}

/// The process of gaussian_heights. The squares of bells add up to sqrt(4 pi) everywhere.
Process bells_of_noise(const RandomProfile& p, double length, std::uint64_t seed) {
  const double place = p.correlation_length / places_per_length;
  if (!(length / place < most_places))
    throw RequestError(
        fmt::format("a correlation length of {:.10g} m on a beam of {:.10g} m is too short",
                    p.correlation_length, length));
  return {Bells(noise_about(seed, last_place(length, place))), place, std::pow(4 * pi, 0.25)};
}

/// Wave j is s_j (a cos + b sin), a and b standard normal.
Process bells_of_waves(const Waves& of_heights, const JohnsonHeights& map, double length,
                       std::uint64_t seed) {
  const Waves waves = before_map(of_heights, map);
  std::vector<Complex> half(static_cast<std::size_t>(waves.places) / 2 + 1);
  for (std::size_t j = 1; j < waves.variance.size(); ++j) {
    const auto number = static_cast<std::int64_t>(2 * j);
    const Complex noise(white_noise(seed, number), -white_noise(seed, number + 1));
    half[j] = std::sqrt(waves.variance[j]) / 2 / Bells::gain(waves.turn(j)) * noise;
  }
  const std::vector<double> period = from_lines(half, static_cast<std::size_t>(waves.places));
  const int last = last_place(length, waves.place) + 2 * Bells::half_width;
  std::vector<double> coefficients;
  coefficients.reserve(static_cast<std::size_t>(last) + 1);
  for (int i = 0; i <= last; ++i)
    coefficients.push_back(
        period[static_cast<std::size_t>((i - Bells::half_width + waves.places) % waves.places)]);
  return {Bells(std::move(coefficients)), waves.place, 1.0};
}

/// Values at equal distances of 1, between them a line.
struct Line {
  std::vector<double> values, integral;
  double band = 0;              // mean lines are within +- this of 0
  std::vector<std::size_t> up;  // where the line begins to rise into or through the band

  explicit Line(std::vector<double> all) : values{std::move(all)}, integral(values.size(), 0.0) {
    double squares = 0;
    for (std::size_t i = 1; i < values.size(); ++i) {
      integral[i] = integral[i - 1] + (values[i - 1] + values[i]) / 2;
      squares += values[i] * values[i];
    }
    band = std::sqrt(squares / static_cast<double>(values.size()));
    for (std::size_t i = 0; i + 1 < values.size(); ++i)
      if (values[i] < std::min(values[i + 1], band) && values[i + 1] >= -band) up.push_back(i);
  }

  /// Mean distance from the first to the last upward crossing of the mean over (begin, begin +
  /// length). NaN where there are fewer than two.
  double element_spacing(std::size_t begin, double length) const {
    const auto whole = begin + static_cast<std::size_t>(length);
    const double share = static_cast<double>(begin) + length - static_cast<double>(whole);
    const double end = values[whole] + share * (values[whole + 1] - values[whole]);
    const double mean =
        (integral[whole] - integral[begin] + share * (values[whole] + end) / 2) / length;
    if (!(std::abs(mean) < band)) return quiet_nan;
    double first = 0, last = 0;
    int count = 0;
    for (auto it = std::lower_bound(up.begin(), up.end(), begin); it != up.end(); ++it) {
      const std::size_t i = *it;
      if (!(values[i] < mean && values[i + 1] >= mean)) continue;
      const double at = static_cast<double>(i) + (mean - values[i]) / (values[i + 1] - values[i]);
      if (at > static_cast<double>(begin) + length) break;
      if (count++ == 0) first = at;
      last = at;
    }
    return count > 1 ? (last - first) / (count - 1) : quiet_nan;
  }
};

/// Part of a function that is pressed into (0, length).
struct Window {
  double begin, factor;  // in the function's units; by how much it is longer
};

/// Window in which the spacing of elements is exactly `spacing` once it is brought to the length:
/// near the beginning, and of nearly the length. The mean line moves with the window, elements come
/// and go, and the spacing jumps. Where it jumps past `spacing`, the next beginning is tried.
Window window_of(const std::function<void(std::vector<double>&)>& evaluate, double length,
                 double spacing) {
  constexpr int finer = 16;  // points to a place
  if (!(finer * length < most_places))
    throw RequestError(
        "exact = \"rq+rsm\": the profile has too many waves to be searched: raise the "
        "shortest, or leave exact out");
  std::vector<double> points;
  for (int i = 0; i <= finer * (most_stretched * length + most_moved) + 1; ++i)
    points.push_back(static_cast<double>(i) / finer);
  evaluate(points);
  const Line line(std::move(points));
  constexpr double step = 1e-3, least = 2 - most_stretched;
  for (int begin = 0; begin <= most_moved; ++begin) {
    const auto miss = [&](double factor) {
      return line.element_spacing(static_cast<std::size_t>(finer * begin),
                                  finer * factor * length) /
                 (finer * factor * spacing) -
             1;
    };
    double near[2] = {1, 1}, at_near[2] = {miss(1), miss(1)};
    for (double away = step; away < 1 - least; away += step)
      for (const int side : {0, 1}) {
        double low = near[side], high = side == 0 ? 1 + away : 1 - away;
        const double at_low = std::exchange(at_near[side], miss(high));
        near[side] = high;
        if (!(at_low * at_near[side] <= 0)) continue;
        for (int halving = 0; halving < 60; ++halving) {
          const double middle = 0.5 * (low + high);
          (miss(middle) * at_low > 0 ? low : high) = middle;
        }
        for (const double factor : {low, high})
          if (std::abs(miss(factor)) < 1e-9) return {static_cast<double>(begin), factor};
      }
  }
  throw RequestError(
      "no part of this random profile has exactly the rsm that is asked for: take another seed, a "
      "longer beam, or leave exact = \"rq+rsm\" out");
}

// ---- what the keys of a scene mean

JohnsonHeights map_of(const SurfaceSpec& spec) {
  if (!spec.skewness && !spec.kurtosis) return {};
  return {spec.skewness.value_or(0), spec.kurtosis.value_or(3)};
}

double positive_length(const std::optional<double>& value, const char* name) {
  if (value && !(*value > 0 && std::isfinite(*value)))
    throw RequestError(fmt::format("{}: expected a length > 0 in metres", name));
  return value.value_or(0);
}

/// The x > 0 at which a function that grows reaches `value`, from a guess on; nothing where it does
/// not within a factor of 1e6.
std::optional<double> solve_growing(double guess, double value,
                                    const std::function<double(double)>& function) {
  double low = guess, high = guess;
  double at_low = function(guess) - value, at_high = at_low;
  while (at_low > 0 && low > 1e-6 * guess) at_low = function(low /= 2) - value;
  while (at_high < 0 && high < 1e6 * guess) at_high = function(high *= 2) - value;
  if (!(at_low <= 0 && at_high >= 0)) return std::nullopt;
  // false position, what stays weighing half (the Illinois rule)
  int stayed = 0;
  double x = at_low == 0 ? low : high;
  for (int round = 0; round < 100 && at_low < 0 && at_high > 0; ++round) {
    x = low + (high - low) * (-at_low / (at_high - at_low));
    if (high - low < 1e-12 * x) break;
    const double at = function(x) - value;
    if (std::abs(at) < 1e-13 * value) break;
    if (at < 0) {
      low = x;
      at_low = at;
      if (stayed == 1) at_high /= 2;
      stayed = 1;
    } else {
      high = x;
      at_high = at;
      if (stayed == -1) at_low /= 2;
      stayed = -1;
    }
  }
  return x;
}

/// A Gaussian process crosses its mean line upwards every 2 pi sqrt(C(0)/-C''(0)) on average
/// (Rice): sqrt(2) pi l for C(x) = exp(-(x/l)^2).
constexpr double rsm_per_length = std::numbers::sqrt2 * pi;

void check_wave_lengths(const RandomProfile& p) {
  if (p.correlation == Correlation::self_affine && !(p.shortest < p.longest))
    throw RequestError(
        fmt::format("a shortest wave of {:.10g} m is not shorter than the longest, {:.10g} m",
                    p.shortest, p.longest));
  if (p.correlation == Correlation::exponential && !(p.shortest < p.correlation_length))
    throw RequestError(
        fmt::format("a shortest wave of {:.10g} m is not shorter than the correlation length, "
                    "{:.10g} m",
                    p.shortest, p.correlation_length));
}

/// Finds the lengths that a scene leaves open.
class Resolver {
 public:
  Resolver(const SurfaceSpec& spec, const JohnsonHeights& map, double length)
      : spec_{spec}, map_{map}, length_{length}, rsm_{positive_length(spec.rsm, "rsm")} {}

  RandomProfile resolve() {
    p_.correlation = spec_.correlation;
    p_.correlation_length = positive_length(spec_.correlation_length, "correlation_length");
    p_.longest = positive_length(spec_.longest, "longest");
    p_.shortest = positive_length(spec_.shortest, "shortest");
    p_.hurst = spec_.hurst.value_or(0);
    switch (p_.correlation) {
      case Correlation::gaussian:
        resolve_gaussian();
        break;
      case Correlation::exponential:
        resolve_exponential();
        break;
      case Correlation::self_affine:
        resolve_self_affine();
        break;
    }
    check_wave_lengths(p_);
    p_.rsm = p_.correlation == Correlation::gaussian && map_.is_identity()
                 ? rsm_per_length * p_.correlation_length
                 : crossing(p_);
    return p_;
  }

 private:
  double crossing(const RandomProfile& p) const {
    check_wave_lengths(p);
    return crossing_distance(before_map(waves_of(p, length_), map_), map_);
  }
  /// Solves for the length that gives the rsm; `with` makes the profile of a length.
  void find(double guess, const std::function<RandomProfile(double)>& with) {
    const auto found = solve_growing(guess, rsm_, [&](double x) { return crossing(with(x)); });
    if (!found)
      throw RequestError(
          fmt::format("no surface of this kind has an rsm of {:.10g} m: change what else is "
                      "asked of it",
                      rsm_));
    p_ = with(*found);
  }
  void resolve_gaussian() {
    const auto with = [&](double l) {
      RandomProfile q = p_;
      q.correlation_length = l;
      q.shortest = shortest_of_gaussian * l;
      return q;
    };
    if (!(rsm_ > 0 || p_.correlation_length > 0))
      throw RequestError("a gaussian surface needs a positive rsm or correlation_length in metres");
    if (p_.correlation_length > 0)
      p_ = with(p_.correlation_length);
    else if (map_.is_identity())
      p_ = with(rsm_ / rsm_per_length);
    else
      find(rsm_ / rsm_per_length, with);
  }
  void resolve_exponential() {
    const auto with = [&](double l) {
      RandomProfile q = p_;
      q.correlation_length = l;
      if (!spec_.shortest) q.shortest = shortest_of_exponential * l;
      return q;
    };
    if (!(rsm_ > 0 || p_.correlation_length > 0))
      throw RequestError(
          "an exponential correlation needs a positive rsm or correlation_length in metres");
    if (p_.correlation_length > 0)
      p_ = with(p_.correlation_length);
    else
      find(std::max(2 * rsm_, 2 * p_.shortest),
           [&](double l) { return with(std::max(l, 1.01 * p_.shortest)); });
  }
  void resolve_self_affine() {
    if (!(p_.hurst > 0 && p_.hurst < 1))
      throw RequestError("hurst: a self-affine surface needs an exponent between 0 and 1");
    if ((rsm_ > 0) + (p_.longest > 0) + (p_.shortest > 0) != 2)
      throw RequestError(
          "a self-affine surface needs two of longest, shortest and rsm, in metres: the third "
          "follows");
    if (!(p_.shortest > 0))
      find(0.5 * rsm_, [&](double shortest) {
        RandomProfile q = p_;
        q.shortest = std::min(shortest, 0.99 * p_.longest);
        return q;
      });
    else if (!(p_.longest > 0))
      find(4 * rsm_, [&](double longest) {
        RandomProfile q = p_;
        q.longest = std::max(longest, 1.01 * p_.shortest);
        return q;
      });
  }

  const SurfaceSpec& spec_;
  const JohnsonHeights& map_;
  double length_, rsm_;  // m; rsm 0 where the scene gives none
  RandomProfile p_;
};

}  // namespace

RandomProfile resolve_random(const SurfaceSpec& spec, double length) {
  const JohnsonHeights map = map_of(spec);
  return Resolver(spec, map, length).resolve();
}

std::vector<double> random_heights(const SurfaceSpec& spec, double length, int nodes,
                                   double spacing, std::vector<std::string>* doubts) {
  const JohnsonHeights map = map_of(spec);
  const RandomProfile p = Resolver(spec, map, length).resolve();
  const bool bells_alone = spec.correlation == Correlation::gaussian && map.is_identity();
  const Waves waves = bells_alone ? Waves{} : waves_of(p, length);
  if (doubts != nullptr && spec.rq != 0) doubt_spectrum(p, waves, spacing, *doubts);
  if (bells_alone && spec.exact == Exactly::rq)
    return gaussian_heights(spec.rq, p.correlation_length, spec.seed, length, nodes, spacing);
  std::vector<double> heights(static_cast<std::size_t>(nodes), 0.0);
  if (spec.rq == 0) return heights;
  if (nodes < 2) throw RequestError("a rough surface needs a beam of at least 2 nodes");
  Process process = bells_alone ? bells_of_noise(p, length, spec.seed)
                                : bells_of_waves(waves, map, length, spec.seed);
  double begin = 0;  // in places
  const auto evaluate = [&](std::vector<double>& x) {
    for (double& place : x) place += begin;
    process.bells.evaluate(x);
    if (!map.is_identity())
      for (double& value : x) value = map(value);
  };
  if (spec.exact == Exactly::rq_and_rsm) {
    const Window window = window_of(evaluate, length / process.place, *spec.rsm / process.place);
    process.place /= window.factor;
    begin = window.begin;
  }
  const auto [mean, rms] = moments(evaluate, length / process.place);
  for (std::size_t n = 0; n < heights.size(); ++n)
    heights[n] = static_cast<double>(n) * spacing / process.place;
  evaluate(heights);
  const double factor = spec.rq / (spec.exact == Exactly::nothing ? process.spread : rms);
  for (double& height : heights) height = (height - mean) * factor;
  return heights;
}

}  // namespace ra2d
