// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/run/model.hpp"
#include "kernels/schemes/mode_step.hpp"

/// Limits of stability, from theory (kernels/schemes/ has each scheme's own).
namespace ra2d {

/// A scheme with the time at which it takes the penalty force.
struct SchemeChoice {
  SchemeKind scheme = SchemeKind::backward_euler;
  ForceTime force_time = ForceTime::old_time;
};

/// Largest factor by which a step multiplies a free mode's amplitude, the spectral radius of its
/// step; x = omega tau.
double amplification(SchemeKind scheme, double zeta, double x);

/// The x = omega tau up to which a free mode of damping ratio zeta stays bounded: 0 when it grows at
/// every step, infinity when at none.
double mode_limit(SchemeKind scheme, double zeta);

/// Modes that a contact spring joins at one place: mode k with the square of its shape there.
/// Modes without stiffness all move alike and stand here as one (mass-weighted), so that what
/// drifts freely is left out.
struct JoinedModes {
  std::vector<Mode> modes;
  std::vector<double> square;  // psi_k^2 at the place, 1/m
};

/// Largest factor by which a step multiplies a motion of the joined modes while a contact spring of
/// `stiffness` [N/m] stays closed.
double amplification(SchemeChoice choice, const JoinedModes& joined, double stiffness, double tau);

/// The largest step [s] up to which such motion stays bounded: 0 and infinity as above.
double contact_limit(SchemeChoice choice, const JoinedModes& joined, double stiffness);

/// The modes of both bodies where they yield most to a contact force.
JoinedModes most_yielding(const Model& model);

/// What a scheme's step may be in a scene, and what binds it.
struct StepLimits {
  double modes = 0;                          // s, of the free modes
  double binding_frequency = 0;              // Hz, of the mode that sets it
  double contact_one = 0, contact_many = 0;  // s, one and `many` nodes closed at one place (penalty)
  int many = 16;
  /// The largest step that holds: of the free modes and, under penalty, of one node in contact.
  double holds() const { return modes < contact_one ? modes : contact_one; }
};

/// Under multipliers there is no contact spring: contact_one and contact_many are infinite.
StepLimits step_limits(const Model& model, SchemeChoice choice);

}  // namespace ra2d
