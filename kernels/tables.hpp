// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/nodes.hpp"
#include "kernels/schemes/mode_step.hpp"

/// The tables of one scene, as the march reads them. Plain data: the pointers point to where the
/// kernels run. Built and checked on the host (host/model/model.hpp); nothing is checked here
/// again.
///
/// Modes. Both bodies' modes stand in one list, one lane each: the resonator's, then the slider's;
/// the rest of the last pack is zero. Signs are those of docs/model.md, which treats both bodies
/// alike: every mode closes the gap by U_k psi_k at a node, and a contact force f drives it with -f
/// psi_k.
///
/// Nodes. Slider node n stands at resonator position pos(m) + n in units of chi, pos(m) = position
/// + m advance at step m. To find which nodes can touch, they are taken in groups, one a lane.
///
/// Patches. Under the slider the resonator's displacement is smooth: its shortest wavelength spans
/// hundreds of nodes. On patches fixed to the resonator it is a power series in eta = (x -
/// centre)/radius, |eta| <= 1, whose coefficients are sums over the modes:
///   u_2 = sum_j q_j eta^j,  q_j = sum_k U_k radius^j psi_k^(j)(centre) / j!.
/// Four terms, with a bound on the rest, tell which nodes can touch. A node that can is then
/// evaluated to below the roundings with `terms` terms: all modes here satisfy psi'''' = beta^4
/// psi, so four derivatives are stored and the others follow with (beta radius)^4.
///
/// Windows. Over a fraction of chi (1/windows) a mode's shape at a moving node is a cubic of its
/// offset, again to below the roundings. A node that touches or soon could is expanded so once a
/// window; its overlap and the modal force of its contact force are then one product over the modes
/// each.
///
/// Time is counted in steps of the scheme; under the adaptive one, whose steps have any length, in
/// ticks so short that no answer feels them: times are integers, and sums of them exact.
namespace ra2d {

/// What a step is made of; a scene has one of these (kernels/fixed/contact_step.hpp).
enum class Form : int {
  semi_implicit,  // U1 = U0 + tau V1 with the contact force of the old time
  staged,         // the contact force at each stage of the scheme
  implicit,       // one contact force a step, found together with its end
  adaptive        // steps of any length, that end where a contact begins or ends
};
inline constexpr int forms = 4;

/// Longest series of a patch that a scene may need (host/device/layout.cpp chooses).
inline constexpr int most_terms = 24;

struct MovingForceTable {
  double force;     // N
  double position;  // m, at t = 0
  double advance;   // m per step
};

/// Rows of SceneTables::end. The outer force that stays the same, the load, is multiplied in.
enum EndRow : int { end_u_u, end_u_v, end_u_load, end_v_u, end_v_v, end_v_load, end_forces };
inline constexpr int end_rows(int stages) { return end_forces + 2 * stages; }  // u_f, v_f of each
/// First row of stage i >= 1 in SceneTables::stage: stage_u, stage_v, load, then stage_f[j] for j <
/// i. For the host, like end_rows; the march finds it in SceneTables::stage_row.
inline constexpr int first_stage_row(int i) { return 3 * (i - 1) + i * (i - 1) / 2; }

/// Rows of SceneTables::flight, per level: what so many ticks do to (U - rest, V, 1), and to the
/// integral of V^2, in ticks.
enum FlightRow : int {
  flight_u_u,
  flight_u_v,
  flight_u,
  flight_v_u,
  flight_v_v,
  flight_v,
  flight_s_uu,
  flight_s_uv,
  flight_s_vv,
  flight_s_v,
  flight_s,
  flight_rows
};

/// Highest order of the series of an adaptive step.
inline constexpr int most_order = 28;
/// Terms of an overlap's series: the mode shapes along the way are cubics.
inline constexpr int overlap_terms = most_order + 4;
/// Points of the Gauss-Legendre rule over an adaptive step. Eight are exact to the 15th power, and
/// off by 3.6e-10 of the 16th. A motion that carries most of the energy turns by no more than theta
/// = 1.8 as far as the error control lets a series go: of the product of two such the 16th power is
/// below (2 theta)^16/16! = 4e-5. What turns further is too small a part to matter.
inline constexpr int gauss_points = 8;
/// Its places take this much room, padded to any number of lanes; then come the weights.
inline constexpr int gauss_room = 32;

/// Lengths from which those of all arrays of a scene follow: see visit_arrays below, and those of
/// kernels/state.hpp.
struct Extents {
  int width = 0;                // lanes of a pack
  int lanes = 0;                // of all modes, padded to whole packs
  int nodes = 0, groups = 0;    // of the slider
  int heights = 0;              // the resonator's nodes, padded beyond its end
  int patches = 0;              // of the resonator
  int slider_modes = 0;         //
  int stage_rows = 0;           // of SceneTables::stage
  int end_rows = 0;             // of SceneTables::end
  int flight_levels = 0;        // 0: not adaptive
  int moving_forces = 0;        //
  int samples = 0, shocks = 0;  // rows that a launch can hand out
  int pressed = 0;              // nodes that can carry force at once under Form::implicit
  int closed = 0;               // nodes that can be in contact at once under Form::adaptive

  std::size_t padded_nodes() const { return static_cast<std::size_t>(groups) * width; }
  /// Runs of neighbouring nodes: at the most every other node.
  int runs() const { return nodes / 2 + 2; }
  bool adaptive() const { return flight_levels > 0; }
};

struct SceneTables {
  // what there is
  int resonator_modes = 0, slider_modes = 0;
  int nodes = 0, groups = 0;  // slider nodes; groups of one a lane
  int patches = 0,
      patch_nodes = 0;    // patches; their width in nodes (radius = half of it + half a group + 1)
  int heights = 0;        // of the resonator's nodes, with what is padded beyond its end
  int flight_levels = 0;  // of the flight tables
  double inverse_patch = 0;  // 1/patch_nodes
  int windows = 1;           // parts of a node's width
  int terms = 4;             // of the full series, a multiple of 4
  int moving_forces = 0;
  Nodes look_at = Nodes::candidates;
  Form form = Form::semi_implicit;

  // motion
  double position = 0;          // of slider node 0 on the resonator at t = 0, in chi
  double advance = 0;           // per step, in chi
  double spacing = 0;           // m, chi
  double step = 0;              // s, tau, or a tick
  double inverse_radius = 0;    // chi / radius
  double window_width = 1;      // chi, 1/windows
  double resonator_length = 0;  // m

  // contact
  double node_stiffness = 0;  // N/m, kappa chi w
  double compliance = 0;      // m/N, 1/(kappa chi w); 0 under multipliers
  double touch = 0;           // m, overlap that counts as none under Form::implicit: roundings
  double least_yielding = 0;  // m/N, of a node that any mode moves: what is less is roundings
  double slack = 0;           // m, bound on the rounding of the rough faces' part of a gap
  double steepest = 0;        // m, largest rise of the resonator's face over one spacing

  // how the guarantee is used: these set the cost, never the answer
  double least_reach = 0;   // m, of a near list
  double least_leeway = 0;  // m, of a watch
  double least_energy = 0;  // J, below which energy is not watched

  // the scheme (kernels/schemes/mode_step.hpp)
  int stages = 1;
  double place[most_stages] = {};   // of the stages, in steps
  int stage_row[most_stages] = {};  // first_stage_row
  double velocity_lag = 0;          // steps
  double loss_ends = 0;             // weight of the damping loss at both ends of a stretch of steps
  int longest_look = 1;             // steps over which the bounds on the modes hold

  // Form::adaptive
  double tolerance = 0;      // relative local error of a step
  int order = 0;             // of the series
  int first_level = 0;       // flight tables are of 2^first_level, 2^(first_level + 1), ... ticks
  double longest_scale = 0;  // s, unit of a series beyond which its terms could overflow
  double cubic_excess = 1;   // derivatives of a mode's cubic over a patch, over those of the mode
  double fourth_rest = 0;    // m/s^4, of where the load holds the modes, see Flight::bounds
  double top = 0;            // m, the highest overlap that the faces alone can have anywhere
  const double* flight = nullptr;  // (level, FlightRow, lane)
  const double* rest = nullptr;    // m^(3/2), where the load holds a mode; 0 for a rigid one
  const double* free_acceleration =
      nullptr;                           // m^(3/2)/s^2, load/m of a rigid mode; 0 for the others
  const double* decay = nullptr;         // 1/s, 2 zeta omega
  const double* fastest_rate = nullptr;  // 1/s, |(omega U, V)'| over |(omega U, V)| is no more
  const double* swing = nullptr;   // s, 2/omega: the farthest a mode gets over its energy norm
  const double* fourth = nullptr;  // m^(-1/2)/s^3, fourth derivative of an overlap, the same
  const double* passing_rate = nullptr;  // 1/s, speed times the largest wave number of a mode
  const double* inverse_mass = nullptr;  // m/kg
  const double* hull = nullptr;   // (coefficient, overlap_terms): see Hull; then its two masks
  const double* gauss = nullptr;  // places in (0, 1), then weights; padded with zeros

  // modes, one lane each (padded with zeros)
  const double* stage = nullptr;  // rows of lanes, see stage_row
  const double* end = nullptr;    // rows of lanes, see EndRow
  const double* receptance =
      nullptr;  // m/N per m of beam: U1 of a modal force of 1 held over the step
  const double* mobility = nullptr;  // ... and its V1
  const double* load = nullptr;      // N m^(-1/2), constant modal load
  const double* mass = nullptr;      // kg/m
  const double* omega = nullptr;     // rad/s
  const double* damping = nullptr;   // 2 zeta omega m tau: damping loss of a step over V^2
  const double* pull = nullptr;      // 1/s, the scheme's bound on |V'| over the modal energy norm
  const double* push = nullptr;      // m^(3/2)/s^2, bound on what the outer modal forces add to V'
  const double* yield = nullptr;     // m^(-1/2)/kg, the same for a newton of contact force
  const double* largest_shape = nullptr;      // max |psi|
  const double* largest_slope = nullptr;      // max |psi'|, resonator only: its nodes move
  const double* largest_curvature = nullptr;  // max |psi''|, resonator only
  const double* cubic_remainder =
      nullptr;  // bound on what a cubic over a patch leaves out, over |U|
  const double* cubic_slope_remainder = nullptr;  // 1/m, the same for its slope
  const double* quartic = nullptr;                // (beta radius)^4
  const double* patch = nullptr;                  // (patch, 4, lane): radius^j psi^(j)(centre)
  const double* slider_shape = nullptr;  // (slider mode, group, lane): psi at the slider's nodes
  const double* unit = nullptr;          // (slider mode, lane): 1 at that mode's own lane

  // surfaces, m
  const double* height1 = nullptr;   // (group, lane): h_1 - delta; far below for the padding
  const double* height2 = nullptr;   // resonator node, padded beyond its end
  const double* highest2 = nullptr;  // max of height2 over a node and the `width` after it

  const MovingForceTable* moving_force = nullptr;

  // when to write
  std::int64_t total_steps = 0;
  std::int64_t counted_from = 0;  // the step at which statistics begin: an adaptive one ends there
  double steps_per_sample = 0;
  std::int64_t samples = 0;

  const int* interrupted = nullptr;  // of host backends: not 0 when the launch is to end soon
};

/// Every array of the tables, once: its name, where its address stands, and how many values it has.
/// Who makes room for them, sets their addresses or copies them goes by this list alone. First
/// those that scenes with equal bodies, schemes and speeds have in common.
template <class Visit>
void visit_shared_arrays(SceneTables& t, const Extents& n, Visit&& visit) {
  const auto lanes = static_cast<std::size_t>(n.lanes);
  visit("stage", t.stage, n.stage_rows * lanes);
  visit("end", t.end, n.end_rows * lanes);
  visit("receptance", t.receptance, lanes);
  visit("mobility", t.mobility, lanes);
  visit("load", t.load, lanes);
  visit("mass", t.mass, lanes);
  visit("omega", t.omega, lanes);
  visit("damping", t.damping, lanes);
  visit("pull", t.pull, lanes);
  visit("push", t.push, lanes);
  visit("yield", t.yield, lanes);
  visit("largest_shape", t.largest_shape, lanes);
  visit("largest_slope", t.largest_slope, lanes);
  visit("largest_curvature", t.largest_curvature, lanes);
  visit("cubic_remainder", t.cubic_remainder, lanes);
  visit("cubic_slope_remainder", t.cubic_slope_remainder, lanes);
  visit("quartic", t.quartic, lanes);
  visit("patch", t.patch, n.patches * 4 * lanes);
  visit("slider_shape", t.slider_shape, n.slider_modes * n.padded_nodes());
  visit("unit", t.unit, n.slider_modes * lanes);
  if (!n.adaptive()) return;
  visit("flight", t.flight, static_cast<std::size_t>(n.flight_levels) * flight_rows * lanes);
  visit("rest", t.rest, lanes);
  visit("free_acceleration", t.free_acceleration, lanes);
  visit("decay", t.decay, lanes);
  visit("fastest_rate", t.fastest_rate, lanes);
  visit("swing", t.swing, lanes);
  visit("fourth", t.fourth, lanes);
  visit("passing_rate", t.passing_rate, lanes);
  visit("inverse_mass", t.inverse_mass, lanes);
  visit("hull", t.hull, std::size_t{(overlap_terms + 2) * overlap_terms});
  visit("gauss", t.gauss, std::size_t{2 * gauss_room});
}
/// ... and those of a scene's own.
template <class Visit>
void visit_own_arrays(SceneTables& t, const Extents& n, Visit&& visit) {
  const std::size_t heights = n.heights;
  visit("height1", t.height1, n.padded_nodes());
  visit("height2", t.height2, heights);
  visit("highest2", t.highest2, heights);
  visit("moving_force", t.moving_force, static_cast<std::size_t>(n.moving_forces));
}
template <class Visit>
void visit_arrays(SceneTables& t, const Extents& n, Visit&& visit) {
  visit_shared_arrays(t, n, visit);
  visit_own_arrays(t, n, visit);
}

}  // namespace ra2d
