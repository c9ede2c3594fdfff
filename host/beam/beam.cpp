// SPDX-License-Identifier: BSD-3-Clause
#include "host/beam/beam.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "host/base/errors.hpp"

namespace ra2d {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double gravity = 9.80665;  // m/s^2, standard
/// Covers the roundings of a sum that reaches the largest |psi|, so that the bound stays one.
constexpr double margin = 1 + 8 * std::numeric_limits<double>::epsilon();
constexpr int most_elastic =
    100'000;  // elastic modes of a body: beyond it is a slip of the keyboard

double mass_per_length(const BodySpec& body) { return body.density * body.thickness * body.width; }

double bending_stiffness(const BodySpec& body) {
  return body.young * body.width * std::pow(body.thickness, 3) / 12;
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

double angular_frequency(const BodySpec& body, int k) {
  const double beta = wave_number(body.support, k) / body.length;
  return beta * beta * std::sqrt(bending_stiffness(body) / mass_per_length(body));
}

ModeShape pinned_mode(double length, int k) {
  ModeShape mode;
  mode.beta = wave_number(Support::pinned, k) / length;
  mode.sine = mode.largest = std::sqrt(2 / length);
  return mode;
}

/// sqrt(L) psi = cosh bx + cos bx - sigma (sinh bx + sin bx), z = bL: its square integrates to 1.
/// At a root, cos z = 1/cosh z and sin z = -s tanh z with s = (-1)^k, the parity of the mode, turn
/// sigma = (cosh z - cos z)/(sinh z - sin z) into sinh z/(cosh z + s): nothing cancels any more.
ModeShape free_mode(double length, int k) {
  const double z = wave_number(Support::free, k), s = k % 2 == 0 ? 1 : -1;
  const double scale = 1 / std::sqrt(length), decay = s * std::exp(-z);
  ModeShape mode;
  mode.beta = z / length;
  mode.cosine = scale;
  mode.sine = -scale * (1 - decay) / (1 + decay);
  mode.left = scale / (1 + decay);
  mode.right = s * mode.left;
  mode.largest = 2 * scale * margin;  // at the ends
  return mode;
}

std::vector<ModeShape> rigid_modes(double length) {
  ModeShape translation, rotation;
  translation.constant = translation.largest = 1 / std::sqrt(length);
  rotation.constant = -std::sqrt(3 / length);
  rotation.slope = std::sqrt(12 / length) / length;
  rotation.largest = -rotation.constant * margin;
  return {translation, rotation};
}

int elastic_mode_count(const BodySpec& body, int most) {
  if (body.modes) return *body.modes;
  int count = 0;
  while (count < most && body.max_frequency &&
         elastic_frequency(body, count) <= *body.max_frequency)
    ++count;
  return count;
}

/// psi(L - x) = parity psi(x).
double parity(const ModeShape& mode, double length) {
  const bool odd = mode.left != 0 ? mode.right < 0 : std::lround(mode.beta * length / pi) % 2 == 0;
  return odd ? -1 : 1;
}

}  // namespace

void evaluate(const ModeShape& mode, double length, double x, int derivatives, double* out) {
  if (mode.beta == 0) {
    for (int j = 0; j < derivatives; ++j)
      out[j] = j == 0 ? mode.constant + mode.slope * x : j == 1 ? mode.slope : 0;
    return;
  }
  // From the nearer end: the rounding of beta x grows with x, and both ends stay equally exact.
  const bool mirrored = x > length / 2;
  if (mirrored) x = length - x;
  const double phase = mode.beta * x;
  if (derivatives == 1 && mode.cosine == 0 && mode.left == 0 && mode.right == 0) {
    // of a pinned body, at each of its nodes: the same number without what it does not need
    const double psi = mode.sine * std::sin(phase) + 0.0;  // no -0, as below
    out[0] = mirrored ? parity(mode, length) * psi : psi;
    return;
  }
  const double sine = std::sin(phase), cosine = std::cos(phase);
  const double left = mode.left * std::exp(-phase);
  const double right = mode.right * std::exp(-mode.beta * (length - x));
  // Derivatives of the trigonometric part repeat every four, up to powers of beta.
  const double even = mode.sine * sine + mode.cosine * cosine;
  const double odd = mode.sine * cosine - mode.cosine * sine;
  const double trigonometric[] = {even, odd, -even, -odd};
  double power = mirrored ? parity(mode, length) : 1;
  for (int j = 0; j < derivatives; ++j) {
    out[j] = power * (trigonometric[j % 4] + (j % 2 == 0 ? left : -left) + right);
    power *= mirrored ? -mode.beta : mode.beta;
  }
}

double elastic_frequency(const BodySpec& body, int k) {
  if (body.support == Support::rigid) return std::numeric_limits<double>::infinity();
  return angular_frequency(body, k) / (2 * pi);
}

int mode_count(const BodySpec& body, int most) {
  if (body.support == Support::rigid) return 0;
  return elastic_mode_count(body, most) + (body.support == Support::free ? 2 : 0);
}

Beam make_beam(const BodySpec& body) {
  Beam beam;
  beam.length = body.length;
  beam.mass_per_length = mass_per_length(body);
  beam.stiffness = bending_stiffness(body);
  beam.zeta = body.damping;
  beam.load_force = body.load_is_weight ? beam.mass_per_length * beam.length * gravity : body.load;
  if (body.support == Support::rigid) return beam;

  const bool is_free = body.support == Support::free;
  if (is_free) beam.modes = rigid_modes(beam.length);
  const int count = elastic_mode_count(body, most_elastic + 1);
  if (count > most_elastic)
    throw RequestError("max_frequency keeps more than " + std::to_string(most_elastic) +
                       " elastic modes; lower it, or give modes");
  for (int k = 0; k < count; ++k) {
    beam.modes.push_back(is_free ? free_mode(beam.length, k) : pinned_mode(beam.length, k));
    beam.modes.back().omega = angular_frequency(body, k);
  }

  // Modal load: W/L times the integral of psi. Every mode of a free beam but the translation is
  // orthogonal to a constant; a pinned mode integrates to sqrt(2/L) (1 - cos(beta L))/beta.
  beam.load.assign(beam.modes.size(), 0.0);
  if (is_free) beam.load[0] = beam.load_force / std::sqrt(beam.length);
  if (!is_free)
    for (std::size_t k = 0; k < beam.modes.size(); k += 2)
      beam.load[k] = beam.load_force / beam.length * beam.modes[k].sine * 2 / beam.modes[k].beta;
  return beam;
}

}  // namespace ra2d
