// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/tables.hpp"

/// The state of one scene, which changes while it is marched. Plain data, pointers as in
/// SceneTables. Five parts, by what becomes of them between two launches:
///
///   carried  what the next step goes on from: kept, and saved in a checkpoint
///   marks    what the caches and the work space hold, -1 for nothing, as at the beginning
///   caches   what can be computed again from it: kept or emptied, with the same answers
///   work     means nothing between two launches
///   out      buffers of what is recorded: emptied after each launch
///
/// Kernels are handed the parts of these that they use, and those that they only read as const.
namespace ra2d {

enum class Status : int {
  running,
  done,
  unstable,
  not_finite,
  blocked,  // Form::implicit: no motion of the modes keeps the bodies apart
  crowded,  // more nodes carry force than there is memory for: goes on once there is more
  stalled   // Form::adaptive: the motion is too fast for the clock
};

/// Bounds on a polynomial over an interval (kernels/adaptive/crossing.hpp).
struct Hull {
  double least, most;      // of the polynomial
  double falling, rising;  // of its slope: least and most
  double curvature;        // on the size of its second derivative
};

/// Integrals over an interval of a node's overlap o(x) [m]: of o, of x o, and of o times its rise
/// along the slider's path.
struct NodeSums {
  double overlap, moment, work;
};

/// Consecutive slider nodes in contact; in areal scenes all in one row.
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
  double across_moment;      // N steps rows, areal scenes: sum of f_n times the row of n
  double row;                // areal scenes: of its first node when it began
};

/// A shock that has ended.
struct ShockRow {
  std::int64_t serial, start, last;
  double peak, impulse, moment, place, across_moment, row;
};

/// A sample: modal displacements, modal velocities (lanes of each), then these columns.
namespace sample {
enum Column : int { force, nodes, contact_energy, damping_loss, sliding_work, force_work, columns };
constexpr int row(int lanes) { return 2 * lanes + columns; }
/// In their buffer each begins on a line of 128 bytes.
inline constexpr int padded_columns = 16;
constexpr int pitch(int lanes) { return 2 * lanes + padded_columns; }
}  // namespace sample

// ---- carried

/// The modes, one lane each.
struct CarriedModes {
  double* u = nullptr;            // m^(3/2)
  double* v = nullptr;            // m^(3/2)/s
  double* start_u = nullptr;      // u at t = 0
  double* start_v = nullptr;      // v at t = 0
  bool begun = false;             // v has been brought to the time at which the scheme has it
  double* square = nullptr;       // sum of V^2 over the steps up to the last sample
  double* square_part = nullptr;  // sum since then (adaptive: within 4096 steps)
};

/// Sums over the steps, each in two parts: up to the last sample, and since then.
struct RunningSums {
  double sliding_work = 0;                 // J
  double gross_face_work = 0;              // J/chi: sum of the largest |face_work| of a step
  double face_work_part = 0;               // J/chi: see ContactTotals
  double* deflection_work_part = nullptr;  // J/chi, a lane each
  double force_work = 0, force_part = 0;   // J, of the moving forces
  std::int64_t contact_steps = 0;          // steps with any node in contact
  std::int64_t most_nodes = 0;             // largest number of nodes in contact at once
  std::int64_t evaluated = 0;              // nodes whose gap was evaluated (a measure of cost)
};

/// Energy at t = 0, and what its checks found.
struct EnergyCheck {
  double start = 0;          // J, kinetic + elastic + contact
  double most_supplied = 0;  // J, the most that loads and moving forces had supplied at any check
  double latest = 0;         // J, kinetic + elastic at the latest check, or when the march stopped
  double limit = 0;          // J, which it was not allowed to pass
};

struct Sampling {
  std::int64_t next = 0;
  bool pending = false;           // the next sample still lacks its share of the next step
  double* pending_row = nullptr;  // what there is of that sample
};

struct ShockTracking {
  ContactRun* runs = nullptr;  // of the step runs_step
  OpenShock* open = nullptr;
  int run_count = 0, open_count = 0;
  std::int64_t runs_step = -2;
  std::int64_t begun = 0;
};

/// Form::implicit: the contact at the end of the latest step with any.
struct LatestContact {
  std::int64_t step = -1;
  double force = 0;   // N
  double energy = 0;  // J
  int nodes = 0;
  int pair[2] = {};  // the first two of them
};

/// Form::adaptive: the nodes in contact, in ascending order; smooth faces: the cells in contact, or
/// in which it begins.
struct ContactSet {
  int count = 0;
  int* nodes = nullptr;
};

/// Form::adaptive: what the next step starts with.
struct StepControl {
  int shape_terms = 2;       // of the shapes at a node, which the latest step with contact needed
  int raised = 0;            // of the series: 2 raised more orders than usual
  double used_share = 0.45;  // mean share of its usable length that a step with contact has made
  double series_scale = 0;   // s, guess at the length of the next step with forces
  int flight_level = 0;      // of the next flight: 2^level ticks
  // smooth faces
  bool contact_begins = false;  // at the beginning of the next step
  // s after that: when a contact is expected to begin, and to end
  double expected_onset = 1e300, expected_release = 1e300;
};

/// Form::adaptive, smooth faces: what the next step in contact starts with, as the step before it
/// left it.
struct StepStart {
  bool knows_forces = false, knows_rates = false;
  int count = 0;                                 // cells that carry force
  double energy = 0;                             // J, of the springs
  double most_energy = 0;                        // J, of the springs after a step so far
  double power = 0, moving_power = 0;            // W, of the imposed motion, of the moving forces
  int* cells = nullptr;                          // that carry force, in ascending order
  double *forces = nullptr, *centres = nullptr;  // N; chi, where each acts on the slider
  double* acceleration = nullptr;                // of the modes
  double* jerk = nullptr;                        // (3, lane): its first three derivatives
};

/// All that a march goes on from. A saved run that goes on from this gives the same bits. A
/// checkpoint holds its bytes, and its arrays.
struct CarriedState {
  Status status = Status::running;
  std::int64_t step = 0;  // or tick
  CarriedModes modal;
  RunningSums sums;
  EnergyCheck energy;
  Sampling sampling;
  ShockTracking shocks;
  LatestContact latest_contact;
  std::int64_t adaptive_steps = 0;  // made
  ContactSet contacts;
  StepControl control;
  StepStart begin;
};

// ---- marks and caches

/// Of each node.
struct Marks {
  std::int64_t* node_window = nullptr;  // plane scenes: for which it is expanded (Caches)
  int* active_index = nullptr;          // Form::implicit: its index in the active set
  // Areal scenes have places for few expanded nodes, which are those of one window. Node n stands
  // at place s = node_slot[n] if s < slots_used and slot_node[s] = n.
  int* node_slot = nullptr;
  int* slot_node = nullptr;
  int slots = 0, slots_used = 0;
  std::int64_t slots_window = -1;
  // Places of clusters: the i-th column is that of place_id[i], for i < places_used.
  int* place_id = nullptr;
  int places_used = 0;
  std::int64_t places_window = -1;
};

/// Expanded nodes or cells. Areal scenes: where Marks says.
struct Caches {
  double* node_shape = nullptr;  // (node, 4, lane); (cell, 7, lane)
  double* node_face = nullptr;   // (node, 2); (cell, 12)
  double* columns = nullptr;     // (place, pack, term, lane): kernels/contact/cluster_places.hpp
};

// ---- work

/// The lists of kernels/candidate_groups.hpp.
struct CandidateLists {
  int* groups = nullptr;                  // that can come into contact while the list holds
  double* reference_u = nullptr;          // modal displacements at which it was made
  int* coarse_groups = nullptr;           // of the coarse list, from which the other is drawn
  double* coarse_highest = nullptr;       // m, largest overlap of each on the path ahead
  double* coarse_displacement = nullptr;  // m, areal scenes: the modes' part in it
  double* coarse_reference_u = nullptr;   // modal displacements at which the coarse list was made
  int* tiles = nullptr;                   // areal scenes: of a band, that come close
  int* columns = nullptr;                 // of these: their groups in a row
  double* tile_displacement = nullptr;    // m, of each tile of a band: the most of its nodes
  double* footprint = nullptr;            // m, (term): the resonator's, see Footprint::expand
  bool kept = false;                      // whether lists of nodes are (Candidates::keep_list)
  double *line_u = nullptr, *line_v = nullptr;  // if they are: the line that the modes follow
  int most_listed = 0;  // nodes that there is room for in WorkSpace::listed_nodes
  // m, Form::adaptive in areal scenes: bound on the overlap of each group, less what is followed
  // (kernels/adaptive/group_bounds.hpp), and what the faces raise it by on this spacing, per chi
  double *highest = nullptr, *slope = nullptr;
};

/// Rows of ContactList::cell_parts, each of a lane's width and of 2 at the least.
inline constexpr int cell_part_rows = 17;

/// The nodes (smooth faces: cells) in contact at a step, and their forces [N].
struct ContactList {
  int* nodes = nullptr;
  double* forces = nullptr;
  double* centres = nullptr;     // smooth faces: where the force of a cell acts on the slider, chi
  double* cell_parts = nullptr;  // smooth faces: (row, part), kernels/contact/cell_parts.hpp
};

/// The next runs of neighbouring nodes.
struct RunBuffer {
  ContactRun* next = nullptr;
  int capacity = 0;
  int row = 0;  // areal scenes: from a node's number to that of its neighbour in the next row
};

/// Form::implicit: the nodes that carry force, in the order in which they came
/// (kernels/contact/complementarity.hpp); of smooth faces, points in cells.
struct ActiveSet {
  int capacity = 0;
  int* nodes = nullptr;
  double* forces = nullptr;    // N
  double* factor = nullptr;    // Cholesky factor, (row, column) with `capacity` columns
  double* coupling = nullptr;  // m/N, of the next node with each of them
  double* solution = nullptr;  // of a system with the factor, first its right-hand side
  double* places = nullptr;    // smooth faces: of a point, from the middle of its cell, chi
  double* rows = nullptr;      // smooth faces: (point, lane), shapes of the modes there
};

/// Form::adaptive: coefficients of power series (kernels/adaptive/series.hpp).
struct SeriesBuffers {
  double* modes = nullptr;      // (order, lane), then a row of zeros
  double* squares = nullptr;    // (order, lane): of the integral of V^2
  double* forces = nullptr;     // (order, lane): of the moving forces
  double* nodes = nullptr;      // (node in contact, 2, order): overlap, sliding rate
  double* shapes = nullptr;     // (node in contact, 4, lane)
  double* one_shape = nullptr;  // (4, lane): of one more node
  double* moments = nullptr;    // (node in contact, moment_numbers): M_t of the latest three orders
};

/// Form::adaptive: clusters of nodes in contact (kernels/adaptive/contact_clusters.hpp). Their
/// members stand in packs, each of one cluster.
struct ClusterBuffers {
  int* cluster = nullptr;         // of each node in contact
  int* node = nullptr;            // (cluster): of its place, along x
  int* row = nullptr;             // (cluster): of its place, across
  int* column = nullptr;          // (cluster): of its place, in Caches::columns
  int* first = nullptr;           // (cluster): pack of its first members; then one behind the last
  int* members = nullptr;         // (pack, lane): number of the node in contact, or -1
  double* faces = nullptr;        // (pack, 2, lane): overlap of the faces [m], rise [m per chi]
  double* powers = nullptr;       // (pack, cluster_rows, lane): of xi_0 and eta
  double* terms = nullptr;        // (pack, order, 2, lane): overlap, sliding rate
  double* moments = nullptr;      // (cluster, order, cluster_rows): M_ab
  double* forces = nullptr;       // (cluster, order, cluster_rows): Q_ab
  double* polynomials = nullptr;  // (cluster, cluster_rows, order): P_ab
};

/// Fixed steps: squares of nodes that share their sums over the modes
/// (kernels/contact/clustered_contact.hpp), and the groups of listed nodes in them.
struct SquareBuffers {
  int count = 0, groups = 0;
  int* group = nullptr;       // (group): its number among all, ascending
  int* listed = nullptr;      // (group): a bit for each node that is listed
  int* of_group = nullptr;    // (group): its square
  int* square = nullptr;      // (square): its number among all, ascending
  int* column = nullptr;      // (square): of its place, in Caches::columns
  double* moments = nullptr;  // (square, cluster_rows): M_ab
  double* forces = nullptr;   // (square, cluster_rows): R_ab
};

/// A run of neighbouring cells in contact at some stage of a step between smooth faces.
struct CellRun {
  int first, last;
  bool grown;         // from cells in contact at the beginning of the step
  bool at_end;        // in contact at its end
  std::int64_t ends;  // the tick of the step before which its contact ends
};

/// Form::adaptive, smooth faces: a step by collocation, and the motion over it
/// (kernels/adaptive/smooth_step.hpp). "points" are all but the first; see padded_points.
struct PointBuffers {
  double* velocity = nullptr;       // (point, lane)
  double* acceleration = nullptr;   // (point, lane)
  double* u = nullptr;              // (power of x, lane): the modes' displacement
  double* v = nullptr;              // (power of x, lane): their velocity
  double* u_at = nullptr;           // (mode, points)
  double* v_at = nullptr;           // (mode, points)
  double* a_at = nullptr;           // (mode, points)
  double* force_at = nullptr;       // N m^(-1/2), (mode, points): of all but contact
  double* contact_at = nullptr;     // N m^(-1/2), (mode, points): with contact, where there is any
  double* u_before = nullptr;       // (mode, points): displacement by what the beginning tells
  double* v_before = nullptr;       // (mode, points)
  double* spring_energy = nullptr;  // J, (points)
  double* power = nullptr;  // W: (first point, points) of the imposed motion, then of moving forces
  int* cells = nullptr;     // evaluated
  double* force = nullptr;  // N, (cell, first point, points)
  double* moment = nullptr;       // N chi, (cell, first point, points): of it, along the slider
  double* shock_force = nullptr;  // N, (point): of one shock
  double* highest = nullptr;      // m, (first point, points): overlap anywhere in one cell
  double* ends = nullptr;         // of contact: (cell, side, 2, points)
  double* springs = nullptr;      // (spring, 2, points): stiffness [N/m], displacement [m]
  int* spring_cells = nullptr;    // in whose middle they stand
  CellRun* runs = nullptr;
  int run_count = 0, listed = 0;
};

/// Form::adaptive: of each node in contact, over a step.
struct ContactSpans {
  int capacity = 0;
  Hull* hulls = nullptr;     // of its overlap over the step
  NodeSums* sums = nullptr;  // of it over a part of the step
  double* ends = nullptr;    // where its contact ends, in units of the series
};

/// Form::adaptive: the search for contacts that begin (kernels/adaptive/overlaps.hpp).
struct OnsetSearch {
  double* overlaps = nullptr;    // (end of the step, candidate group, 2, lane): overlap, rate
  double* onsets = nullptr;      // where the contact of a listed node begins
  double* polynomial = nullptr;  // (order): of one node
  double* bernstein = nullptr;   // one series and two values more
};

/// Areal scenes: of the candidate groups, see kernels/adaptive/group_bounds.hpp.
struct GroupBuffers {
  int* selected = nullptr;            // those that can come into contact within the step
  std::int64_t* evaluated = nullptr;  // at which step's beginning the overlaps are known
  double* own_shape = nullptr;        // (slider mode, group): psi in the middle of the group
  // (4, lane): Bernstein coefficients of the slider's modes over a step; the last: at its end
  double* own_motion = nullptr;
  double* sums = nullptr;  // (4, term): of the footprint's terms (Footprint::expand)
};

struct WorkSpace {
  CandidateLists candidates;
  double* amplitudes = nullptr;  // modal displacements and rates, to be read one by one
  int* listed_nodes = nullptr;   // evaluated at each step, or flagged for a search
  ContactList contact_list;
  RunBuffer runs;
  ActiveSet active;
  SeriesBuffers series;
  ClusterBuffers clusters;
  SquareBuffers squares;
  PointBuffers points;
  ContactSpans spans;
  OnsetSearch search;
  GroupBuffers groups;
};

// ---- out

struct SampleBuffer {
  double* rows = nullptr;  // see sample::pitch
  int capacity = 0, count = 0;
};

struct ShockBuffer {
  ShockRow* rows = nullptr;
  int capacity = 0, count = 0;
};

/// Copies of carried arrays.
struct CarriedCopies {
  double* u = nullptr;
  double* v = nullptr;
  double* square = nullptr;
  double* square_part = nullptr;
  double* deflection_work_part = nullptr;
  OpenShock* open = nullptr;
};

/// The record, until the host takes it, and how the scene stands at the end of a launch. The
/// host reads it and a march writes it at one address, on a GPU over its bus: a march reads none
/// of its arrays.
struct RecordBuffers {
  SampleBuffer samples;
  ShockBuffer ended_shocks;
  CarriedCopies now;
};

struct SceneState {
  CarriedState carried;
  Marks marks;
  Caches caches;
  WorkSpace work;
  RecordBuffers out;
};

// Every array of each part, once, as for the tables (kernels/tables.hpp). A checkpoint holds the
// carried ones in this order; messages name them as here.

template <class Visit>
void visit_arrays(CarriedState& s, const Extents& n, Visit&& visit) {
  const auto lanes = static_cast<std::size_t>(n.lanes);
  visit("u", s.modal.u, lanes);
  visit("v", s.modal.v, lanes);
  visit("start", s.modal.start_u, lanes);
  visit("start_v", s.modal.start_v, lanes);
  visit("square", s.modal.square, lanes);
  visit("square_part", s.modal.square_part, lanes);
  visit("deflection_work_part", s.sums.deflection_work_part, static_cast<std::size_t>(n.width));
  visit("pending_row", s.sampling.pending_row, static_cast<std::size_t>(sample::row(n.lanes)));
  visit("runs", s.shocks.runs, static_cast<std::size_t>(n.runs()));
  visit("open", s.shocks.open, 2 * static_cast<std::size_t>(n.runs()));
  if (n.adaptive()) visit("closed", s.contacts.nodes, static_cast<std::size_t>(n.contacts));
  if (n.adaptive() && n.smooth) {
    const auto contacts = static_cast<std::size_t>(n.contacts);
    visit("acceleration", s.begin.acceleration, lanes);
    visit("jerk", s.begin.jerk, 3 * lanes);
    visit("begin_cells", s.begin.cells, contacts);
    visit("begin_forces", s.begin.forces, contacts);
    visit("begin_centres", s.begin.centres, contacts);
  }
}

template <class Visit>
void visit_arrays(Marks& s, const Extents& n, Visit&& visit) {
  const auto nodes = static_cast<std::size_t>(n.nodes);
  if (n.rows == 0) {
    visit("node_window", s.node_window, nodes);
  } else {
    visit("node_slot", s.node_slot, nodes);
    visit("slot_node", s.slot_node, n.slots());
  }
  if (n.cluster_degree > 0) visit("place_id", s.place_id, std::size_t{most_places});
  if (n.active > 0) visit("active_index", s.active_index, nodes);
}

template <class Visit>
void visit_arrays(Caches& s, const Extents& n, Visit&& visit) {
  const std::size_t places = n.rows == 0 ? static_cast<std::size_t>(n.nodes) : n.slots();
  visit("node_shape", s.node_shape, places * n.shape_rows() * n.lanes);
  visit("node_face", s.node_face, places * n.face_numbers());
  if (n.cluster_degree > 0)
    visit("columns", s.columns, std::size_t{most_places} * cluster_rows * n.lanes);
}

template <class Visit>
void visit_arrays(ClusterBuffers& s, const Extents& n, Visit&& visit) {
  constexpr std::size_t clusters = most_clusters;
  const auto group = static_cast<std::size_t>(n.cluster_packs()) * n.width;
  visit("cluster", s.cluster, static_cast<std::size_t>(n.contacts));
  visit("cluster_node", s.node, clusters);
  visit("cluster_row", s.row, clusters);
  visit("cluster_column", s.column, clusters);
  visit("cluster_first", s.first, clusters + 1);
  visit("cluster_members", s.members, group);
  visit("cluster_faces", s.faces, 2 * group);
  visit("cluster_powers", s.powers, cluster_rows * group);
  visit("cluster_terms", s.terms, 2 * overlap_terms * group);
  visit("cluster_moments", s.moments, clusters * overlap_terms * cluster_rows);
  visit("cluster_forces", s.forces, clusters * overlap_terms * cluster_rows);
  visit("cluster_polynomials", s.polynomials, clusters * cluster_rows * overlap_terms);
}

template <class Visit>
void visit_adaptive_arrays(WorkSpace& s, const Extents& n, Visit&& visit) {
  const auto lanes = static_cast<std::size_t>(n.lanes);
  const std::size_t nodes = n.padded_nodes(), groups = n.groups;
  const auto contacts = static_cast<std::size_t>(n.contacts);
  visit("series", s.series.modes, (most_order + 2) * lanes);
  visit("square_series", s.series.squares, most_order * lanes);
  visit("force_series", s.series.forces, (most_order + 1) * lanes);
  visit("node_series", s.series.nodes, contacts * 2 * overlap_terms);
  visit("contact_shapes", s.series.shapes, contacts * 4 * lanes);
  visit("one_shape", s.series.one_shape, 4 * lanes);
  if (n.node_moments()) visit("node_moments", s.series.moments, contacts * moment_numbers);
  visit("polynomial", s.search.polynomial, std::size_t{overlap_terms});
  visit("bernstein", s.search.bernstein, std::size_t{2 * overlap_terms});
  visit("hulls", s.spans.hulls, contacts);
  visit("sums", s.spans.sums, contacts);
  visit("ends", s.spans.ends, contacts);
  visit("onsets", s.search.onsets, static_cast<std::size_t>(n.listed));
  visit("end_overlaps", s.search.overlaps, 4 * nodes);
  if (n.cluster_degree > 0) visit_arrays(s.clusters, n, visit);
  if (n.rows > 0) {
    const std::size_t padded = groups + n.width;
    visit("highest", s.candidates.highest, padded);
    visit("slope", s.candidates.slope, padded);
    visit("selected", s.groups.selected, groups);
    visit("evaluated", s.groups.evaluated, groups);
    visit("own_shape", s.groups.own_shape, n.slider_modes * padded);
    visit("own_motion", s.groups.own_motion, 4 * lanes);
    visit("footprint_sums", s.groups.sums, 4 * n.footprint_sums());
  }
  if (n.smooth) {
    const auto points = static_cast<std::size_t>(padded_points(n.width));
    visit("point_velocity", s.points.velocity, collocation_points * lanes);
    visit("point_acceleration", s.points.acceleration, collocation_points * lanes);
    visit("motion_u", s.points.u, motion_terms * lanes);
    visit("motion_v", s.points.v, motion_terms * lanes);
    for (double** rows : {&s.points.u_at, &s.points.v_at, &s.points.a_at, &s.points.force_at,
                          &s.points.contact_at, &s.points.u_before, &s.points.v_before})
      visit("at_points", *rows, lanes * points);
    visit("spring_energy", s.points.spring_energy, points);
    visit("point_power", s.points.power, 2 * (1 + points));
    visit("shock_force", s.points.shock_force, std::size_t{collocation_points});
    visit("highest", s.points.highest, std::size_t{1 + point_row});
    visit("point_cells", s.points.cells, contacts);
    visit("point_force", s.points.force, contacts * (1 + points));
    visit("point_moment", s.points.moment, contacts * (1 + points));
    visit("contact_ends", s.points.ends, contacts * 4 * points);
    visit("springs", s.points.springs, contacts * 2 * points);
    visit("spring_cells", s.points.spring_cells, contacts);
    visit("cell_runs", s.points.runs, contacts);
  }
}

template <class Visit>
void visit_arrays(WorkSpace& s, const Extents& n, Visit&& visit) {
  const auto lanes = static_cast<std::size_t>(n.lanes);
  const std::size_t groups = n.groups;
  visit("candidate_groups", s.candidates.groups, groups);
  visit("candidate_reference_u", s.candidates.reference_u, lanes);
  visit("line_u", s.candidates.line_u, n.keeps_lists ? lanes : 0);
  visit("line_v", s.candidates.line_v, n.keeps_lists ? lanes : 0);
  visit("coarse_groups", s.candidates.coarse_groups, groups);
  visit("coarse_highest", s.candidates.coarse_highest, groups + n.width);
  if (n.rows > 0) visit("coarse_displacement", s.candidates.coarse_displacement, groups);
  visit("coarse_reference_u", s.candidates.coarse_reference_u, lanes);
  visit("amplitudes", s.amplitudes, 2 * lanes);
  if (n.rows > 0) {
    visit("tiles", s.candidates.tiles, static_cast<std::size_t>(n.padded_tiles()));
    visit("tile_displacement", s.candidates.tile_displacement,
          static_cast<std::size_t>(n.padded_tiles() + n.width));
    visit("columns_close", s.candidates.columns, static_cast<std::size_t>(n.row_groups));
    visit("footprint_terms", s.candidates.footprint, n.footprint_sums());
  }
  const auto listed = static_cast<std::size_t>(n.listed);
  visit("listed_nodes", s.listed_nodes, listed);
  visit("contact_nodes", s.contact_list.nodes, listed);
  visit("contact_forces", s.contact_list.forces, listed);
  if (n.smooth) {
    visit("contact_centres", s.contact_list.centres, listed);
    visit("cell_parts", s.contact_list.cell_parts,
          static_cast<std::size_t>(cell_part_rows) * (n.width < 2 ? 2 : n.width));
  }
  visit("next_runs", s.runs.next, static_cast<std::size_t>(n.runs()));
  if (n.active > 0) {
    const auto active = static_cast<std::size_t>(n.active);
    visit("active_nodes", s.active.nodes, active);
    visit("active_forces", s.active.forces, active);
    visit("factor", s.active.factor, (active + 1) * active);
    visit("coupling", s.active.coupling, active);
    visit("solution", s.active.solution, active);
    if (n.smooth) {
      visit("active_places", s.active.places, active);
      visit("active_rows", s.active.rows, active * lanes);
    }
  }
  if (n.adaptive()) visit_adaptive_arrays(s, n, visit);
  if (!n.adaptive() && n.cluster_degree > 0) {
    visit("square_groups", s.squares.group, listed);
    visit("square_listed", s.squares.listed, listed);
    visit("squares_of_groups", s.squares.of_group, listed);
    visit("squares", s.squares.square, listed);
    visit("square_columns", s.squares.column, listed);
    visit("square_moments", s.squares.moments, cluster_rows * listed);
    visit("square_forces", s.squares.forces, cluster_rows * listed);
  }
}

template <class Visit>
void visit_arrays(RecordBuffers& s, const Extents& n, Visit&& visit) {
  visit("sample_rows", s.samples.rows,
        static_cast<std::size_t>(n.samples) * sample::pitch(n.lanes));
  visit("shock_rows", s.ended_shocks.rows, static_cast<std::size_t>(n.shocks));
  const auto lanes = static_cast<std::size_t>(n.lanes);
  visit("now_u", s.now.u, lanes);
  visit("now_v", s.now.v, lanes);
  visit("now_square", s.now.square, lanes);
  visit("now_square_part", s.now.square_part, lanes);
  visit("now_deflection_work_part", s.now.deflection_work_part, static_cast<std::size_t>(n.width));
  visit("now_open", s.now.open, 2 * static_cast<std::size_t>(n.runs()));
}

}  // namespace ra2d
