// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/scene/scene.hpp"

/// Euler-Bernoulli beams and their modes (docs/model.md; paper, equations 1 to 6).
namespace ra2d {

/// One mode, in a form that stays accurate for high mode numbers:
///   psi(x) = sine sin(beta x) + cosine cos(beta x) + left exp(-beta x) + right exp(-beta (L - x))
///            + constant + slope x,
/// normalised so that the integral of psi^2 over the beam is 1. Units: psi in m^(-1/2).
struct ModeShape {
  double omega = 0;  // rad/s
  double beta = 0;   // 1/m, 0 for a rigid mode
  double sine = 0, cosine = 0, left = 0, right = 0;
  double constant = 0, slope = 0;
  double largest = 0;  // max |psi| over the beam (an upper bound, tight to a few per cent)
};

struct Beam {
  double length = 0;             // m
  double mass_per_length = 0;    // kg/m, m = rho a b
  double stiffness = 0;          // N m^2, D = E b a^3 / 12
  double zeta = 0;               // modal damping ratio
  std::vector<ModeShape> modes;  // rigid modes first, then elastic ones by frequency
  std::vector<double> load;      // N m^(-1/2), modal load of the body's evenly spread load W
  double load_force = 0;         // N, W
};

/// psi and its first `derivatives` - 1 derivatives at x [m]: out[j] = d^j psi / dx^j.
void evaluate(const ModeShape& mode, double length, double x, int derivatives, double* out);

/// The beam of one body: its modes (Support; max_frequency or modes), and its modal load.
/// The elastic modes of a free beam solve cosh(beta L) cos(beta L) = 1, to full precision for any
/// number. Standard gravity 9.80665 m/s^2 for load = "weight".
Beam make_beam(const BodySpec& body);

/// How many modes a body keeps, its rigid ones among them; of max_frequency up to `most` elastic
/// ones are counted.
int mode_count(const BodySpec& body, int most);

/// Frequency in Hz of elastic mode k = 0, 1, ... of a body, whether it is kept or not.
double elastic_frequency(const BodySpec& body, int k);

}  // namespace ra2d
