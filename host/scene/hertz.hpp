// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/scene/scene.hpp"

/// The contact stiffness that the bodies' materials give, by Hertz (docs/schemes.md, "What
/// kappa?").
namespace ra2d {

/// Poisson's ratio of a body that names none.
inline constexpr double usual_poisson = 0.3;

/// Hertz's contact modulus E* [Pa], 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2. A body without a
/// Young's modulus (only a rigid one) does not deform. Infinite where neither deforms.
double contact_modulus(const Scene& scene);

/// That of an areal scene, where a block has no Young's modulus, and counts as the plate's
/// material.
double plate_contact_modulus(const Scene& scene);

/// The kappa [Pa/m] of `contact.stiffness = "hertz"`: E*/(sqrt(2) w), w the width of the contact
/// strip. A ridge of curvature 1/R, pressed in by d, carries F = 4/3 kappa w sqrt(2 R) d^(3/2) on
/// its bed of springs. A round asperity of the same curvature carries F = 4/3 E* sqrt(R) d^(3/2)
/// (Hertz; K. L. Johnson, Contact Mechanics, 1985, equation 4.23). With this kappa the two are one,
/// whatever the load and the radius. It is the rule of the method of dimensionality reduction
/// (Popov and Hess, 2015), for a profile that is left as it is.
double hertz_stiffness(const Scene& scene);

/// The largest kappa [Pa/m] that a half-space of the materials can have below a ridge as wide as
/// the strip: 1.18 E*/a (Johnson, section 4.3, line contact), with a half-width a of half a
/// spacing, the narrowest that nodes show.
double stiffest_half_space(const Scene& scene);

}  // namespace ra2d
