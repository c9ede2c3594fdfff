// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/body/body.hpp"

/// Thin (Kirchhoff) plates, pinned along all four edges: the resonator of an areal scene.
namespace ra2d {

/// Number (m, n) of an elastic mode: half waves along x and along y, from 1.
struct PinnedPlateMode {
  int m = 1, n = 1;
  double omega = 0;  // rad/s
};

/// The elastic modes that a plate keeps, up to `most`, by frequency; modes whose frequencies differ
/// by roundings alone by m. With a length a along x, the width b along y, the thickness h,
///   D = young h^3/(12 (1 - nu^2)),  mu = density h,
///   omega_mn = sqrt(D/mu) pi^2 (m^2/a^2 + n^2/b^2).
/// nu is `poisson` (none: 0.3). Throws RequestError unless -1 < nu < 0.5.
std::vector<PinnedPlateMode> plate_modes(const BodySpec& spec, int most);

/// One side of a plate over the other, at the most: of longer strips countless modes are equally
/// high but for roundings.
inline constexpr double most_slender_plate = 1e6;

/// Whether plate_modes comes to an end: -1 < nu < 0.5, and the sides are in proportion.
bool has_plate_modes(const BodySpec& spec);

/// The plate that a scene describes: psi_mn = 2/sqrt(a b) sin(m pi x/a) sin(n pi y/b), modal mass
/// mu [kg/m^2], and the modal loads of an evenly spread load. A rigid one has no modes. Throws
/// RequestError for free edges, which have no closed form, and as plate_modes.
Body make_plate(const BodySpec& spec);

/// elastic_frequency of a plate (host/body/body.hpp).
double plate_frequency(const BodySpec& spec, int k);

}  // namespace ra2d
