// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/tables.hpp"

/// What changes while a scene is marched, and what it hands out. Plain data, pointers as in
/// SceneTables. Five parts, by what becomes of them between two launches:
///
///   CarriedState   what the next step goes on from: kept, and all that a saved run keeps
///   Marks          what the caches and the work space hold, -1: nothing, which is what they begin
///   with Caches         what can be found anew from it: kept, or emptied, with the same answers
///   WorkSpace      means nothing between two launches
///   HandOut        buffers of what is recorded: emptied after each launch
namespace ra2d {

enum class Status : int {
  running,
  done,
  unstable,
  not_finite,
  blocked,  // Form::implicit: no motion of the modes keeps the bodies apart
  crowded,  // more nodes carry force than there is room for: goes on once there is more
  stalled   // Form::adaptive: the motion is too fast for the clock
};

/// Bounds on a polynomial over a stretch (kernels/adaptive/crossing.hpp).
struct Hull {
  double least, most;      // of the polynomial
  double falling, rising;  // of its slope: least and most
  double curve;            // on the size of its second derivative
};

/// Integrals over a stretch of a node's overlap o(x) [m]: of o, x o, and o times its rise along the
/// way.
struct NodeSums {
  double overlap, moment, work;
};

/// A run of neighbouring slider nodes in contact.
struct ContactRun {
  int first, last;  // nodes
  int shock;        // index of the open shock that it belongs to
  double force;     // N
  double moment;    // N, sum of f_n n
};

/// A shock that has begun and not ended.
struct OpenShock {
  std::int64_t serial;       // number in order of start
  std::int64_t start, last;  // first and latest step in contact
  double force;              // N, at the latest step
  double peak;               // N
  double impulse;            // N steps
  double moment;             // N steps chi, sum of f_n x_n/chi
  double place;              // chi, of its first node when it began
};

/// A shock that has ended.
struct ShockRow {
  std::int64_t serial, start, last;
  double peak, impulse, moment, place;
};

/// A sample: modal displacements, modal velocities (lanes of each), then these columns.
namespace sample {
enum Column : int { force, nodes, contact_energy, damping_loss, sliding_work, force_work, columns };
constexpr int row(int lanes) { return 2 * lanes + columns; }
}  // namespace sample

/// All that a march goes on from. A run that was saved and goes on from this gives the same bits.
struct CarriedState {
  Status status = Status::running;
  std::int64_t step = 0;

  // modes, one lane each
  double* u = nullptr;            // m^(3/2)
  double* v = nullptr;            // m^(3/2)/s
  double* start = nullptr;        // u at t = 0
  double* start_v = nullptr;      // v at t = 0
  bool begun = false;             // v has been brought to where the scheme has it
  double* square = nullptr;       // sum of V^2 over the steps, but for ...
  double* square_part = nullptr;  // ... those since the last sample (adaptive: in 4096)

  // sums over the steps, in the same two parts
  double sliding_work = 0;                // J
  double gross_climb = 0;                 // N m: sum of |climb|
  double climb_part = 0;                  // N m: see ContactTotals
  double* bend_part = nullptr;            // N m, a lane each
  double force_work = 0, force_part = 0;  // J, of the moving forces
  std::int64_t contact_steps = 0;         // steps with any node in contact
  std::int64_t most_nodes = 0;            // largest number of nodes in contact at once
  std::int64_t evaluated = 0;             // nodes whose gap was evaluated (a measure of cost)

  // energy at t = 0, and what the watch over it found
  double energy_start = 0;  // J, kinetic + elastic + contact
  double most_paid = 0;     // J, the most that loads and moving forces had put in at any look
  double energy = 0;        // J, kinetic + elastic at the last look, or when it stopped
  double energy_limit = 0;  // J, what it was not allowed to pass

  std::int64_t next_sample = 0;
  bool sample_pending = false;    // the next sample still misses its share of the next step ...
  double* pending_row = nullptr;  // ... and this is the rest of it

  // shocks
  ContactRun* runs = nullptr;  // of the step runs_step
  OpenShock* open = nullptr;
  int run_count = 0, open_count = 0;
  std::int64_t runs_step = -2;
  std::int64_t shocks_begun = 0;

  // Form::implicit: the contact at the end of the latest step with any
  std::int64_t contact_step = -1;
  double contact_force = 0;   // N
  double contact_energy = 0;  // J
  int contact_nodes = 0;
  int contact_pair[2] = {};  // the first two of them

  // Form::adaptive: the nodes in contact, in ascending order, and what the next step starts with
  std::int64_t strides = 0;  // steps made
  int closed_count = 0;
  int* closed = nullptr;
  int shape_terms = 2;  // of the shapes at a node, that the latest step with contact wanted
  double stride = 0;    // s, guess at the length of the next step with forces
  int level = 0;        // of the next flight: 2^level ticks
};

/// Of each node.
struct Marks {
  std::int64_t* node_window = nullptr;  // for which it is expanded (Caches)
  int* pressed_place =
      nullptr;  // Form::implicit: its place among those that carry force (WorkSpace)
};

/// What is found once and read often.
struct Caches {
  // expanded nodes: shape (node, 4, lane), faces (node, 2)
  double* node_shape = nullptr;
  double* node_face = nullptr;
};

struct WorkSpace {
  int* near = nullptr;              // groups that can touch while the near list holds
  double* near_u = nullptr;         // modal displacements at which the near list was made
  int* far = nullptr;               // groups from which the near list is drawn ...
  double* far_top = nullptr;        // ... the highest that each can come in the way ahead, m ...
  double* far_u = nullptr;          // ... and where they were found
  double* lanes = nullptr;          // modal displacements and rates, to be read one by one
  int* watch = nullptr;             // nodes evaluated at each step
  int* touched = nullptr;           // nodes that touch at this step ...
  double* touched_force = nullptr;  // ... and their forces, N
  ContactRun* new_runs = nullptr;   // room for the next runs
  int run_capacity = 0;

  // Form::implicit: the nodes that carry force, in the order in which they came
  int pressed_capacity = 0;
  int* pressed = nullptr;
  double* pressed_force = nullptr;  // N
  double* factor = nullptr;         // Cholesky factor, (row, column) with pressed_capacity columns
  double* across = nullptr;         // m/N, of the next node with each of them
  double* share = nullptr;          // what each gives up for a newton on the next

  // Form::adaptive
  int closed_capacity = 0;
  double* series = nullptr;         // (order, lane): of the modes
  double* square_series = nullptr;  // (order, lane): of the integral of V^2
  double* push_series = nullptr;    // (order, lane): of the moving forces
  double* node_series = nullptr;    // (closed node, 2, order): overlap, climb
  double* closed_shape = nullptr;   // (closed node, 4, lane)
  double* scan_shape = nullptr;     // (4, lane)
  double* scan = nullptr;           // (order): of one more node
  double* hull_room = nullptr;      // one series and two values more
  Hull* closed_hull = nullptr;      // of the overlaps of the nodes in contact over the step
  NodeSums* closed_sums = nullptr;  // of them, over a part of the step
  double* closed_roots = nullptr;   // where the nodes in contact let go, in units of the series ...
  double* roots = nullptr;          // ... and where those that are looked at begin to touch
  double* seen = nullptr;  // (2, near group, 2, lane): overlap and its rate at both ends of a step
};

/// What is recorded, until the host takes it, and how the scene stands at the end of a launch. The
/// host reads and a march writes it at one address, on a GPU over its bus: nothing here is read by
/// a march.
struct HandOut {
  double* sample_rows = nullptr;  // see sample::row
  int sample_capacity = 0, sample_count = 0;
  ShockRow* shock_rows = nullptr;
  int shock_capacity = 0, shock_count = 0;

  // of CarriedState
  double* now_u = nullptr;
  double* now_v = nullptr;
  double* now_square = nullptr;
  double* now_square_part = nullptr;
  double* now_bend_part = nullptr;
  OpenShock* now_open = nullptr;
};

struct SceneState : CarriedState, Marks, Caches, WorkSpace, HandOut {};

// Every array of each part, once, as for the tables (kernels/tables.hpp).

template <class Visit>
void visit_arrays(CarriedState& s, const Extents& n, Visit&& visit) {
  const auto lanes = static_cast<std::size_t>(n.lanes);
  visit("u", s.u, lanes);
  visit("v", s.v, lanes);
  visit("start", s.start, lanes);
  visit("start_v", s.start_v, lanes);
  visit("square", s.square, lanes);
  visit("square_part", s.square_part, lanes);
  visit("bend_part", s.bend_part, static_cast<std::size_t>(n.width));
  visit("pending_row", s.pending_row, static_cast<std::size_t>(sample::row(n.lanes)));
  visit("runs", s.runs, static_cast<std::size_t>(n.runs()));
  visit("open", s.open, 2 * static_cast<std::size_t>(n.runs()));
  if (n.adaptive()) visit("closed", s.closed, static_cast<std::size_t>(n.closed));
}

template <class Visit>
void visit_arrays(Marks& s, const Extents& n, Visit&& visit) {
  const auto nodes = static_cast<std::size_t>(n.nodes);
  visit("node_window", s.node_window, nodes);
  if (n.pressed > 0) visit("pressed_place", s.pressed_place, nodes);
}

template <class Visit>
void visit_arrays(Caches& s, const Extents& n, Visit&& visit) {
  const auto nodes = static_cast<std::size_t>(n.nodes);
  visit("node_shape", s.node_shape, nodes * 4 * n.lanes);
  visit("node_face", s.node_face, nodes * 2);
}

template <class Visit>
void visit_arrays(WorkSpace& s, const Extents& n, Visit&& visit) {
  const auto lanes = static_cast<std::size_t>(n.lanes);
  const std::size_t nodes = n.padded_nodes(), groups = n.groups;
  visit("near", s.near, groups);
  visit("near_u", s.near_u, lanes);
  visit("far", s.far, groups);
  visit("far_top", s.far_top, groups);
  visit("far_u", s.far_u, lanes);
  visit("lanes", s.lanes, 2 * lanes);
  visit("watch", s.watch, nodes);
  visit("touched", s.touched, nodes);
  visit("touched_force", s.touched_force, nodes);
  visit("new_runs", s.new_runs, static_cast<std::size_t>(n.runs()));
  if (n.pressed > 0) {
    const auto pressed = static_cast<std::size_t>(n.pressed);
    visit("pressed", s.pressed, pressed);
    visit("pressed_force", s.pressed_force, pressed);
    visit("factor", s.factor, (pressed + 1) * pressed);
    visit("across", s.across, pressed);
    visit("share", s.share, pressed);
  }
  if (n.adaptive()) {
    const auto closed = static_cast<std::size_t>(n.closed);
    visit("series", s.series, (most_order + 1) * lanes);
    visit("square_series", s.square_series, most_order * lanes);
    visit("push_series", s.push_series, (most_order + 1) * lanes);
    visit("node_series", s.node_series, closed * 2 * overlap_terms);
    visit("closed_shape", s.closed_shape, closed * 4 * lanes);
    visit("scan_shape", s.scan_shape, 4 * lanes);
    visit("scan", s.scan, std::size_t{overlap_terms});
    visit("hull_room", s.hull_room, std::size_t{2 * overlap_terms});
    visit("closed_hull", s.closed_hull, closed);
    visit("closed_sums", s.closed_sums, closed);
    visit("closed_roots", s.closed_roots, closed);
    visit("roots", s.roots, nodes);
    visit("seen", s.seen, 4 * nodes);
  }
}

template <class Visit>
void visit_arrays(HandOut& s, const Extents& n, Visit&& visit) {
  visit("sample_rows", s.sample_rows, static_cast<std::size_t>(n.samples) * sample::row(n.lanes));
  visit("shock_rows", s.shock_rows, static_cast<std::size_t>(n.shocks));
  const auto lanes = static_cast<std::size_t>(n.lanes);
  visit("now_u", s.now_u, lanes);
  visit("now_v", s.now_v, lanes);
  visit("now_square", s.now_square, lanes);
  visit("now_square_part", s.now_square_part, lanes);
  visit("now_bend_part", s.now_bend_part, static_cast<std::size_t>(n.width));
  visit("now_open", s.now_open, 2 * static_cast<std::size_t>(n.runs()));
}

}  // namespace ra2d
