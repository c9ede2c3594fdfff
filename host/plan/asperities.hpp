// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/model/model.hpp"

/// How stiff the asperities of a scene are, as Hertz has them of the bodies' materials and as the
/// scene's springs make them, and how long their shocks last (docs/schemes.md, "What kappa?").
namespace ra2d {

/// A contact that carries F = 4/3 E sqrt(R) d^(3/2) when it is pressed in by d; between linear
/// faces k d where that is less stiff than nodes can show.
struct AsperityContact {
  double stiffness = 0;  // N/m, dF/dd under the static load; 0 without one
  double shock = 0;      // N/m, at the peak of a shock; 0 where nothing moves
  double peak = 0;       // N, of the shock
  double duration = 0;   // s
};

struct Asperities {
  double modulus = 0;  // Pa, E*; infinite where neither body yields
  double hertz = 0;    // Pa/m, what contact.stiffness = "hertz" takes
  double radius = 0;   // m, of the summits that touch; 0 where there is none
  int contacts = 0;    // that share the load
  double load = 0;     // N, on each; 0 without a load
  double closing = 0;  // m/s, at which faces close: the speed times the slope of both
  double inertia = 0;  // kg, of both bodies against a force at one place, on average
  AsperityContact material, springs;
  // m, of a contact on the scene's springs at the peak of a shock: along the faces, and how far it
  // is pressed in; 0 where nothing moves, and under multipliers
  double width = 0, depth = 0;
};

/// `start`: of the model. A radius is that of a parabola through the highest summit of both faces
/// together, over the contact's own width and no less than three nodes, on average over places
/// along the slider's path. Under a load that is known the static contact is that of the load over
/// the number of contacts at the start, at least two of a free slider. A shock is one of the mean
/// inertia at the closing speed (Hertz's impact).
Asperities asperities_of(const Model& model, const ModalStart& start);

}  // namespace ra2d
