// SPDX-License-Identifier: BSD-3-Clause
#include "host/body/beam.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

namespace ra2d {
namespace {

using std::numbers::pi;
/// Covers the roundings of a sum that reaches the largest |psi|, so that the bound stays one.
constexpr double margin = 1 + 8 * std::numeric_limits<double>::epsilon();

double mass_per_length(const BodySpec& spec) { return spec.density * spec.thickness * spec.width; }

double bending_stiffness(const BodySpec& spec) {
  return spec.young * spec.width * std::pow(spec.thickness, 3) / 12;
}

/// Root number k = 0, 1, ... of cosh z cos z = 1 (z > 0), to the last digit.
/// With z = (k + 3/2) pi + d, it reads sin d = (-1)^k / cosh z: no overflow, no cancellation.
double free_root(int k) {
  constexpr double pi_rest = 1.2246467991473532e-16;  // pi - double(pi)
  const double turns = k + 1.5, sign = k % 2 == 0 ? 1 : -1, start = turns * pi;
  double d = 0;
  for (int i = 0; i < 8; ++i) {  // Newton; quadratic from |d| < 0.018
    const double sech = 1 / std::cosh(start + d);
    d -= (std::sin(d) - sign * sech) / (std::cos(d) + sign * sech * std::tanh(start + d));
  }
  return start + (d + std::fma(turns, pi, -start) + turns * pi_rest);
}

/// beta L of elastic mode k.
double wave_number(Support support, int k) {
  return support == Support::free ? free_root(k) : (k + 1) * pi;
}

double angular_frequency(const BodySpec& spec, int k) {
  const double beta = wave_number(spec.support, k) / spec.length;
  return beta * beta * std::sqrt(bending_stiffness(spec) / mass_per_length(spec));
}

BeamShape pinned_mode(double length, int k) {
  BeamShape mode;
  mode.length = length;
  mode.beta = wave_number(Support::pinned, k) / length;
  mode.sine = mode.highest = std::sqrt(2 / length);
  return mode;
}

/// sqrt(L) psi = cosh bx + cos bx - sigma (sinh bx + sin bx), z = bL: its square integrates to 1.
/// At a root, cos z = 1/cosh z and sin z = -s tanh z with s = (-1)^k, the parity of the mode, turn
/// sigma = (cosh z - cos z)/(sinh z - sin z) into sinh z/(cosh z + s): nothing cancels any more.
BeamShape free_mode(double length, int k) {
  const double z = wave_number(Support::free, k), s = k % 2 == 0 ? 1 : -1;
  const double scale = 1 / std::sqrt(length), decay = s * std::exp(-z);
  BeamShape mode;
  mode.length = length;
  mode.beta = z / length;
  mode.cosine = scale;
  mode.sine = -scale * (1 - decay) / (1 + decay);
  mode.left = scale / (1 + decay);
  mode.right = s * mode.left;
  mode.highest = 2 * scale * margin;  // at the ends
  return mode;
}

std::array<BeamShape, 2> rigid_modes(double length) {
  BeamShape translation, rotation;
  translation.length = rotation.length = length;
  translation.constant = translation.highest = 1 / std::sqrt(length);
  rotation.constant = -std::sqrt(3 / length);
  rotation.slope = std::sqrt(12 / length) / length;
  rotation.highest = -rotation.constant * margin;
  return {translation, rotation};
}

int elastic_mode_count(const BodySpec& spec, int most) {
  if (spec.modes) return *spec.modes;
  int count = 0;
  while (count < most && spec.max_frequency && beam_frequency(spec, count) <= *spec.max_frequency)
    ++count;
  return count;
}

/// psi(L - x) = parity psi(x).
double parity(const BeamShape& mode) {
  const bool odd =
      mode.left != 0 ? mode.right < 0 : std::lround(mode.beta * mode.length / pi) % 2 == 0;
  return odd ? -1 : 1;
}

}  // namespace

void BeamShape::evaluate(double x, int derivatives, double* out) const {
  if (beta == 0) {
    for (int j = 0; j < derivatives; ++j)
      out[j] = j == 0 ? constant + slope * x : j == 1 ? slope : 0;
    return;
  }
  // From the nearer end: the rounding of beta x grows with x, and both ends stay equally exact.
  const bool mirrored = x > length / 2;
  if (mirrored) x = length - x;
  const double phase = beta * x;
  if (derivatives == 1 && cosine == 0 && left == 0 && right == 0) {
    // of a pinned body, at each of its nodes: the same number without what it does not need
    const double psi = sine * std::sin(phase) + 0.0;  // no -0, as below
    out[0] = mirrored ? parity(*this) * psi : psi;
    return;
  }
  const double sin = std::sin(phase), cos = std::cos(phase);
  const double falling = left * std::exp(-phase);
  const double rising = right * std::exp(-beta * (length - x));
  // Derivatives of the trigonometric part repeat every four, up to powers of beta.
  const double even = sine * sin + cosine * cos;
  const double odd = sine * cos - cosine * sin;
  const double trigonometric[] = {even, odd, -even, -odd};
  double power = mirrored ? parity(*this) : 1;
  for (int j = 0; j < derivatives; ++j) {
    out[j] = power * (trigonometric[j % 4] + (j % 2 == 0 ? falling : -falling) + rising);
    power *= mirrored ? -beta : beta;
  }
}

double BeamShape::size() const {
  const double wave = std::hypot(sine, cosine) + std::abs(left) + std::abs(right);
  const double rigid = std::max(std::abs(constant), std::abs(constant + slope * length));
  return wave + rigid;
}

double BeamShape::change_rate() const { return std::max(beta, std::abs(slope) / size()); }

double BeamShape::largest_wave(double beyond) const {
  return std::hypot(sine, cosine) + std::abs(left) + std::abs(right) * std::exp(beta * beyond);
}

double BeamShape::largest_slope(double beyond) const {
  return beta * largest_wave(beyond) + std::abs(slope);
}

double BeamShape::largest_curvature(double beyond) const {
  return beta * beta * largest_wave(beyond);
}

double BeamShape::growth(double beyond) const { return std::exp(beta * beyond); }

CubicRemainder BeamShape::cubic_remainder(double radius) const {
  const double wave = largest_wave(2 * radius);
  return {wave * std::pow(beta * radius, 4) / 24, wave * beta * std::pow(beta * radius, 3) / 6};
}

double BeamShape::fourth_derivative_factor(double unit) const { return std::pow(beta * unit, 4); }

void BeamShape::append_parameters(std::vector<double>& out) const {
  out.insert(out.end(), {length, beta, sine, cosine, left, right, constant, slope});
}

double beam_frequency(const BodySpec& spec, int k) {
  if (spec.support == Support::rigid) return std::numeric_limits<double>::infinity();
  return angular_frequency(spec, k) / (2 * pi);
}

int beam_mode_count(const BodySpec& spec, int most) {
  if (spec.support == Support::rigid) return 0;
  return elastic_mode_count(spec, most) + (spec.support == Support::free ? 2 : 0);
}

Body make_beam(const BodySpec& spec) {
  Body beam;
  const double length = spec.length, m = mass_per_length(spec);
  beam.length = length;
  beam.mass = m * length;
  beam.load_force = load_force(spec, beam.mass);
  if (spec.support == Support::rigid) return beam;

  const auto add = [&](double omega, const BeamShape& shape) {
    beam.modes.push_back({{omega, spec.damping, m}, std::make_shared<BeamShape>(shape)});
  };
  const bool is_free = spec.support == Support::free;
  if (is_free)
    for (const BeamShape& shape : rigid_modes(length)) add(0, shape);
  const int count = elastic_mode_count(spec, most_elastic_modes + 1);
  check_mode_count(count);
  // Modal load: W/L times the integral of psi. Every mode of a free beam but the translation is
  // orthogonal to a constant; a pinned mode integrates to sqrt(2/L) (1 - cos(beta L))/beta.
  beam.load.assign(beam.modes.size(), 0.0);
  if (is_free) beam.load[0] = beam.load_force / std::sqrt(length);
  for (int k = 0; k < count; ++k) {
    const BeamShape shape = is_free ? free_mode(length, k) : pinned_mode(length, k);
    add(angular_frequency(spec, k), shape);
    const bool is_loaded = !is_free && k % 2 == 0;
    beam.load.push_back(is_loaded ? beam.load_force / length * shape.sine * 2 / shape.beta : 0.0);
  }
  return beam;
}

const BeamShape& beam_shape(const BodyMode& mode) {
  return dynamic_cast<const BeamShape&>(*mode.shape);
}

}  // namespace ra2d
