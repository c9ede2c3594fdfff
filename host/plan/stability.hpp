// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <complex>
#include <vector>

#include "host/model/model.hpp"
#include "kernels/schemes/mode_step.hpp"

/// Limits of stability, from theory (kernels/schemes/ has each scheme's own). Of a `choice` only
/// the scheme and the time of its contact force count: the step is a parameter of its own.
namespace ra2d {

/// Largest factor by which a step multiplies a free mode's amplitude, the spectral radius of its
/// step; x = omega tau.
double amplification(SchemeKind scheme, double zeta, double x);

/// The x = omega tau up to which a free mode of damping ratio zeta stays bounded: 0 when it grows
/// at every step, infinity when at none.
double mode_limit(SchemeKind scheme, double zeta);

/// Modes that a contact spring joins at one place: mode k with the square of its shape there.
/// Modes without stiffness all move alike and stand here as one (mass-weighted), so that what
/// drifts freely is left out.
struct JoinedModes {
  std::vector<Mode> modes;
  std::vector<double> square;  // psi_k^2 at the place, 1/m
};

/// The error of a step in the motion of a free mode.
struct StepError {
  double damping = 0;  // damping ratio that the step adds to zeta; negative: it feeds the mode
  double period = 0;   // relative change of its period; 0 where the step lets it swing no more
};
StepError step_error(SchemeKind scheme, double zeta, double x);

/// Largest factor by which a step multiplies a motion of the joined modes while a contact spring of
/// `stiffness` [N/m] stays closed.
double amplification(const TimeSettings& choice, const JoinedModes& joined, double stiffness,
                     double tau);

/// The largest step [s] up to which such motion stays bounded: 0 and infinity as above. For `exact`
/// it is found by search and 0 stands for any below 1e-5/omega_c, omega_c^2 = k sum psi^2/m.
double contact_limit(const TimeSettings& choice, const JoinedModes& joined, double stiffness);

/// The motions of the joined modes with the spring closed: eigenvalues lambda [1/s] of m_j (U_j'' +
/// 2 zeta_j omega_j U_j' + omega_j^2 U_j) + k psi_j sum_l psi_l U_l = 0. Of conjugate pairs both,
/// or without any damping the one that turns forwards.
std::vector<std::complex<double>> joined_eigenvalues(const JoinedModes& joined, double stiffness);

/// The modes of both bodies where they yield most to a contact force.
JoinedModes most_compliant(const Model& model);

/// Angular frequency [rad/s] of the contact spring of one node against the bodies' inertia there,
/// omega_c^2 = kappa chi w sum psi^2/m.
double contact_frequency(const Model& model, const JoinedModes& place);

/// The longest step of a scheme in a scene, and the mode or contact that limits it.
struct StepLimits {
  double modes = 0;              // s, of the free modes
  double binding_frequency = 0;  // Hz, of the mode that sets it
  double contact_one = 0,
         contact_many = 0;  // s, one and `many` nodes closed at one place (penalty)
  int many = 16;
  /// The largest step that holds: of the free modes and, under penalty, of one node in contact.
  double holds() const { return modes < contact_one ? modes : contact_one; }
  /// Whether the free modes set it: the spring takes away less than a per cent.
  bool modes_bind() const { return modes <= 1.01 * contact_one; }
};

/// Under multipliers there is no contact spring: contact_one and contact_many are infinite.
StepLimits step_limits(const Model& model, const TimeSettings& choice);
/// `place`: most_compliant(model), where it is known already.
StepLimits step_limits(const Model& model, const TimeSettings& choice, const JoinedModes& place);

/// Whether a step holds one node in contact, by the spectral radius of that very step (penalty).
bool holds_in_contact(const Model& model, const TimeSettings& choice, const JoinedModes& place,
                      double tau);

/// Fastest growth [1/s] of a motion's amplitude under steps of tau, of the free modes or with one
/// node closed at that place; what decays most slowly where nothing grows.
double mode_growth(const Model& model, SchemeKind scheme, double tau);
double contact_growth(const Model& model, const TimeSettings& choice, const JoinedModes& place,
                      double tau);

}  // namespace ra2d
