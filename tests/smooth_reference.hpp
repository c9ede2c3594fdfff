// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/model/model.hpp"

/// A reference for contact between smooth faces, in long double and without steps of a fixed size.
/// It takes from the model the heights at the nodes, the modes' masses, frequencies, damping and
/// loads, and the start. Splines, shapes, contact and time integration are its own. In an areal
/// scene each row of the slider is a line of contact, and the modes' numbers are the program's.
///
/// In space: the overlap o(s) along the slider is a polynomial on each piece between two nodes of
/// either face: cubic faces, and the shapes' Taylor polynomials, continued until nothing is left
/// out. The force on a mode, -kappa w times the integral of max(0, o) psi ds, is a Gauss-Legendre
/// sum on each piece, exact for such polynomials.
///
/// In time: extrapolation of the modified midpoint rule (Gragg, Bulirsch and Stoer) to order 16. A
/// step ends wherever the force is not analytic in time: where a piece of contact begins, ends,
/// parts or meets another (the force has a term (t - t0)^1.5 there; such steps have a variable
/// whose square is the time from that event), and where an end of contact passes a node. Within a
/// step the ends of contact are roots of the polynomials of the pieces that they started in.
namespace ra2d::test {

struct ReferenceOptions {
  /// Local error of a step, of the largest motion so far.
  double tolerance = 1e-17;
  /// The longest step, over the inverse of the highest angular frequency.
  double longest = 1.0;
};

/// The scene at one time.
struct ReferenceState {
  double time = 0;
  std::vector<double> resonator_u, resonator_v, slider_u, slider_v;
  double force = 0;                                          // N
  double kinetic = 0, elastic = 0, contact = 0;              // J
  double damping_loss = 0, sliding_work = 0, load_work = 0;  // J, since t = 0
};

/// A connected piece of contact: ends of contact in the same cell of the slider, or in neighbours,
/// belong together, as in the program.
struct ReferenceShock {
  double start = 0, end = 0;  // s; end: of the run, where it goes on
  double impulse = 0;         // N s
  double peak = 0;            // N
  double centre = 0;          // m on the resonator, mean weighted by force
  bool is_open = false;       // at the end of the run
};

struct Reference {
  std::vector<ReferenceState> states;
  std::vector<ReferenceShock> shocks;  // by start
  long steps = 0, evaluations = 0, events = 0;
};

/// States at `times` [s], in ascending order. The run ends at the last.
Reference smooth_reference(const Model& model, const ModalStart& start,
                           const std::vector<double>& times, const ReferenceOptions& options = {});

}  // namespace ra2d::test
