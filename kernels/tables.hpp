// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/nodes.hpp"
#include "kernels/schemes/mode_step.hpp"

/// The tables of one scene, which a march only reads, in parts: each kernel is handed the parts
/// that it uses. Plain data; the pointers are addresses of the memory where the kernels run. The
/// host builds and checks them (host/model/model.hpp); the kernels check nothing again.
///
/// Modes. The modes of both bodies stand in one list, one lane each: the resonator's, then the
/// slider's; the rest of the last pack is zero. Signs are those of docs/model.md, which treats both
/// bodies alike: every mode closes the gap by U_k psi_k at a node, and a contact force f drives it
/// with -f psi_k.
///
/// Nodes. Slider node n stands at resonator position pos(m) + n in units of chi, pos(m) = position
/// + m advance at step m. The search for contact takes the nodes in groups, one node a lane.
///
/// Rows. The nodes of an areal scene stand on rows of constant y (RowTables). Node i of row j has
/// the number j L + i, L the length of a row with its padding, and stands at pos(m) + i. A row
/// begins with a group of its own and ends with a padding node at the least, so nodes whose numbers
/// are neighbours are neighbours along x. A node keeps its y: over a row the shapes of the modes
/// are those along x times a number each. A plane scene has no such tables, and one row.
///
/// Patches. Under the slider the resonator's displacement is smooth: its shortest wavelength spans
/// hundreds of nodes. On patches fixed to the resonator it is a power series in eta = (x -
/// centre)/radius, |eta| <= 1, whose coefficients are sums over the modes:
///   u_2 = sum_j q_j eta^j,  q_j = sum_k U_k radius^j psi_k^(j)(centre) / j!.
/// Four terms, with a bound on the rest, decide which nodes can come into contact. Such a node is
/// then evaluated to below the roundings with `terms` terms. All modes here satisfy psi'''' =
/// beta^4 psi, so four derivatives are stored and the others follow with (beta radius)^4.
///
/// Smooth faces. A face is a straight line between its nodes, or (FaceTables::curvature2) a cubic
/// spline through them; in an areal scene along each row. Between smooth faces contact is
/// integrated over the cells of the slider, a cell from a node to the next
/// (kernels/contact/cell_contact.hpp); lists of nodes to evaluate are then lists of cells, each
/// called by its left node.
///
/// Windows. Over a fraction of chi (1/windows) a mode's shape at a moving node is a cubic of its
/// offset, again to below the roundings. A node that is or could soon be in contact is expanded
/// once a window. Its overlap and the modal force of its contact force are then one product over
/// the modes each. Where squares of nodes share their sums (ClusterTables) a window is all of chi.
///
/// Time is counted in steps of a fixed scheme. The adaptive scheme chooses the length of its steps
/// and counts in ticks, which are too short to change any answer: times are integers, and their
/// sums exact.
namespace ra2d {

/// The form of a step; a scene has one of these (kernels/fixed/contact_step.hpp).
enum class Form : int {
  semi_implicit,  // U1 = U0 + tau V1 with the contact force of the old time
  staged,         // the contact force at each stage of the scheme
  implicit,       // one contact force a step, found together with the end of the step
  adaptive        // steps of any length, which end where a contact begins or ends
};
inline constexpr int forms = 4;

/// Longest series of a patch that a scene may need (host/device/layout.cpp chooses).
inline constexpr int most_terms = 24;

struct MovingForceTable {
  double force;     // N
  double position;  // m, at t = 0
  double advance;   // m per step
};

/// Rows of SchemeWeights::end. The constant outer force, the load, is multiplied in.
enum EndRow : int {
  end_u_u,
  end_u_v,
  end_u_load,
  end_v_u,
  end_v_v,
  end_v_load,
  end_now_mean,
  end_now_pushed,
  end_forces
};
inline constexpr int end_rows(int stages) { return end_forces + 2 * stages; }  // u_f, v_f of each
/// First row of stage i >= 1 in SchemeWeights::stage: stage_u, stage_v, load, then stage_f[j] for j
/// < i. For the host, like end_rows; the march finds it in SchemeWeights::stage_row.
inline constexpr int first_stage_row(int i) { return 3 * (i - 1) + i * (i - 1) / 2; }

/// Rows of FlightTables::rows, for each level: what 2^level ticks do to (U - rest, V, 1), and to
/// the integral of V^2, in ticks.
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
/// Terms of an overlap's series: the mode shapes along the slider's path are cubics.
inline constexpr int overlap_terms = most_order + 4;
/// Sums of each of a shape's four terms that three orders leave to the next ones.
inline constexpr int moment_numbers = 12;
/// Length of a table of Bernstein coefficients, one for each order of the series: (coefficient,
/// overlap_terms), then two masks.
inline constexpr int hull_length = (overlap_terms + 2) * overlap_terms;
/// Points of the Gauss-Legendre rule over an adaptive step. Eight are exact to the 15th power, and
/// off by 3.6e-10 of the 16th. A motion that carries most of the energy turns by no more than theta
/// = 1.8 as far as the error control lets a series go: of the product of two such the 16th power is
/// below (2 theta)^16/16! = 4e-5. Of a raised order (StepControl) it turns by up to 4.3, of which
/// the rule leaves out 2e-8. What turns further is too small a part to matter.
inline constexpr int gauss_points = 8;
/// Length of each of the rule's two rows, points and weights, padded for any number of lanes.
inline constexpr int gauss_row = 32;

/// Lobatto's rules for the integral of V^2 over a piece of a step of raised order: of 5, 7 and 9
/// points, the ends among them. Rules of n points leave out of the square of a motion that turns by
/// theta at the most
///   n (n - 1)^3 (n - 2)!^4/((2 n - 1) (2 n - 2)!^3) (2 theta)^(2 n - 2).
/// It turns by up to 4.3 over the usable length of a series. So five points leave out 1e-9 of
/// pieces of up to `most_by_five` of that length, seven the same of up to `most_by_seven`, and nine
/// 2e-8 of all of it.
inline constexpr int lobatto_inner[] = {3, 5, 7};  // points between the ends
inline constexpr double most_by_five = 0.12, most_by_seven = 0.42;
inline constexpr int lobatto_rules = 3;
/// Numbers of a rule: a row of its inner points, from 0 to 1, then one of their weights, and that
/// of an end.
inline constexpr int lobatto_row = 8, lobatto_numbers = 2 * lobatto_row;

/// Points of an adaptive step between smooth faces at which the equations of motion hold: those of
/// Lobatto's rule, the first at its beginning and the last at its end.
inline constexpr int collocation_points = 9, last_point = collocation_points - 1;
/// Lanes of a row of one number for each point but the first.
constexpr int padded_points(int width) { return width > last_point ? width : last_point; }
/// Terms of the motion over such a step, a polynomial.
inline constexpr int motion_terms = collocation_points + 1;

/// How the time of such a step, as a share of its length, follows from the x of its formula. A
/// contact force grows from its onset on as (t - t_0)^1.5, and dies as (t_1 - t)^1.5. Of the square
/// root of the distance it is a smooth function.
enum class Pace : int {
  even,        // x
  from_onset,  // x^2: a contact begins with the step
  to_release   // 1 - (1 - x)^2: one ends with it, or nearly so
};
inline constexpr int paces = 3;

/// Where the numbers of a pace stand in CollocationTables. With y' = f at the points and the
/// polynomial through these f, the weights are of f, over the length of the step.
///
/// First rows of one number for each point but the first, padded for any number of lanes:
inline constexpr int point_row = 32;
inline constexpr int point_shares = 0;  // of the step's time
/// an eighth of the square of the longer of the intervals beside it, in x,
inline constexpr int point_sags = point_shares + point_row;
/// row j: weights of f_j in y there,
inline constexpr int velocity_columns = point_sags + point_row;
/// and in the integral of y: those weights of these weights
inline constexpr int displacement_columns = velocity_columns + collocation_points * point_row;
/// Then, of one number for each point:
enum CollocationRow : int {
  point_places = displacement_columns + collocation_points * point_row,  // x of each point
  // weights in the polynomial through a value at each point,
  barycentric_weights = point_places + collocation_points,
  // in y(1) - y(0),
  end_weights = barycentric_weights + collocation_points,
  // in f's coefficients in Legendre polynomials of these degrees,
  legendre_8 = end_weights + collocation_points,
  legendre_7 = legendre_8 + collocation_points,
  legendre_4 = legendre_7 + collocation_points,
  legendre_3 = legendre_4 + collocation_points,
  // row m: in that of x^m in y(x) - y(0)
  motion_weights = legendre_3 + collocation_points,
  collocation_end = motion_weights + motion_terms * collocation_points
};
inline constexpr int pace_numbers = (collocation_end + point_row - 1) / point_row * point_row;

/// Nodes of a tile along a row, but for lanes that are more, and rows of one.
inline constexpr int tile_nodes = 32, tile_rows = 8;

/// Clusters of nodes that share their sums over the modes: how far their nodes may stand from their
/// place, in nodes and in rows; the most places that are kept; rows of modes that are kept of a
/// place, the last one the slider's own. Under the adaptive scheme
/// (kernels/adaptive/contact_clusters.hpp) clusters form where contact is, the most of them in a
/// step; under fixed steps (kernels/contact/clustered_contact.hpp) they are squares of so many
/// nodes.
inline constexpr int cluster_reach = 2, square_reach = 8, most_clusters = 48, most_places = 160;
inline constexpr int square_nodes = 2 * square_reach;
inline constexpr int cluster_rows = 11, cluster_own = 10;

/// Nodes of an areal scene that can be evaluated at once, whatever the memory.
inline constexpr int most_areal_nodes = 1 << 16;

/// Lengths from which those of all arrays of a scene follow: see visit_arrays below, and those of
/// kernels/state.hpp.
struct Extents {
  int width = 0;                // lanes of a pack
  int lanes = 0;                // of all modes, padded to whole packs
  int nodes = 0, groups = 0;    // of the slider; of rows with what pads them, but for the last
  int rows = 0;                 // of nodes, in areal scenes; 0: a plane scene
  int row_nodes = 0;            // of a row, without what pads it
  int row_groups = 0;           // of a row
  int behind = 0;               // the resonator's nodes in a row that the slider never meets again
  int heights = 0;              // the resonator's nodes in all rows, without those, and padded
  int row_heights = 0;          // the same in a row
  int patches = 0;              // of the resonator
  int slider_modes = 0;         //
  bool smooth = false;          // faces
  int stage_rows = 0;           // of SchemeWeights::stage
  int end_rows = 0;             // of SchemeWeights::end
  int flight_levels = 0;        // 0: not adaptive
  int moving_forces = 0;        //
  int samples = 0, shocks = 0;  // rows that a launch can record
  int listed = 0;               // nodes that can be evaluated at once: all, in plane scenes
  int active = 0;               // nodes that can carry force at once under Form::implicit
  int contacts = 0;             // nodes that can be in contact at once under Form::adaptive
  int higher_orders = 0;        // SeriesTables::most_raised
  int cluster_degree = 0;       // ClusterTables::degree
  bool keeps_lists = false;     // CandidateLists::kept
  int footprint_terms = 0, footprint_places = 0;  // FootprintTables

  std::size_t padded_nodes() const { return static_cast<std::size_t>(groups) * width; }
  std::size_t padded_row() const { return static_cast<std::size_t>(row_groups) * width; }
  /// Runs of neighbouring nodes: at the most every other node.
  int runs() const {
    return (rows == 0 || nodes / 2 < most_areal_nodes ? nodes / 2 : most_areal_nodes) + 2;
  }
  /// Areal scenes: places for expanded nodes. A window may need more nodes than are listed at once.
  std::size_t slots() const { return 2 * static_cast<std::size_t>(listed); }
  /// Areal scenes: groups in a tile of nodes (TileTables), tiles in a row, the same so padded that
  /// a pack may begin at each, bands of rows, and numbers in a strip.
  int tile_groups() const { return tile_nodes > width ? tile_nodes / width : 1; }
  int tiles() const { return (row_groups + tile_groups() - 1) / tile_groups(); }
  int padded_tiles() const { return (tiles() + 2 * width - 2) / width * width; }
  int bands() const { return (rows + tile_rows - 1) / tile_rows; }
  /// Footprint::sums.
  std::size_t footprint_sums() const {
    return static_cast<std::size_t>((footprint_terms + width - 1) / width * width);
  }
  /// Even rows on which a place of a cluster may stand: that of a square may lie beyond the last.
  int place_rows() const { return (rows + square_reach) / 2 + 1; }
  /// Packs of nodes in all clusters.
  int cluster_packs() const { return contacts / width + most_clusters; }
  int strip() const { return row_heights / (width * tile_groups()) + width + 2; }
  int column_row() const { return row_groups + width; }
  int column_strip() const { return row_heights / width + width + 2; }
  bool adaptive() const { return flight_levels > 0; }
  /// Whether single nodes in contact add moments up (ModalSeries::expand_by_moments).
  bool node_moments() const { return adaptive() && rows > 0 && !smooth && lanes > 3 * width; }
  std::size_t series_orders() const { return 1 + static_cast<std::size_t>(higher_orders); }
  /// Rows of lanes, and numbers of the faces, of an expanded node or cell (Caches).
  std::size_t shape_rows() const { return smooth ? 7 : 4; }
  std::size_t face_numbers() const { return smooth ? 12 : 2; }
};

/// The modes as oscillators, one lane each (padded with zeros, as are all rows of lanes).
struct ModeTables {
  int count = 0;                    // of both bodies
  const double* load = nullptr;     // N m^(-1/2), constant modal load
  const double* mass = nullptr;     // kg/m
  const double* omega = nullptr;    // rad/s
  const double* damping = nullptr;  // 2 zeta omega m tau: damping loss of a step over V^2
};

/// How the slider moves.
struct SliderMotion {
  double position = 0;      // of slider node 0 on the resonator at t = 0, in chi
  double advance = 0;       // per step, in chi
  double spacing = 0;       // m, chi
  double time_step = 0;     // s, tau; under the adaptive scheme a tick
  int windows = 1;          // parts of a node's width
  double window_width = 1;  // chi, 1/windows
};

/// The rows of an areal scene. Those of a plane scene are as they stand here: one without an end.
struct RowTables {
  int nodes = 0;                   // of a row, without what pads it
  int length = 0;                  // of a row with it
  int groups = 0x7fffffff;         // of a row
  int excess = 0;                  // nodes that a row of height2 has more than one of height1
  int behind = 0;                  // the resonator's nodes in a row before the first of height2
  const double* across = nullptr;  // (row, lane): psi(x, y)/psi(x) there; null: a plane scene
};

/// The nodes of an areal scene in tiles: groups of some neighbouring rows, which make a band. They
/// bound the overlaps of all nodes in a tile at once (kernels/candidate_groups.hpp).
struct TileTables {
  int groups = 1;  // of a tile along a row
  int count = 0;   // of tiles along a row
  int row = 0;     // the same, padded
  int bands = 0;   //
  int strip = 0;   // length of a row of highest2
  // (band, tile): highest of height1; smooth faces: with all that a cell may exceed its ends by
  const double* highest1 = nullptr;
  /// (band, i, j): highest of height2 that the nodes of a tile meet whose first one stands in the
  /// resonator's group i + j groups, until they have gone `width` nodes further
  const double* highest2 = nullptr;
  // (band, group): as highest1 and highest2 of a column, the part of a tile that is a group wide;
  // of column2 the resonator's group
  const double *column1 = nullptr, *column2 = nullptr;
  int column_row = 0, column_strip = 0;  // lengths of their rows
  const double* shape = nullptr;         // (slider mode, tile): psi in the middle of a tile
  const double* across = nullptr;  // (band, lane): as RowTables::across, in the middle of a band
};

/// The rough faces [m] at the nodes.
struct FaceTables {
  int nodes = 0, groups = 0;        // slider nodes; groups of one node a lane
  double rounding = 0;              // bound on the rounding of the rough faces' part of a gap
  double steepest_rise = 0;         // largest rise of the resonator's face over one spacing
  double highest_overlap = 0;       // that the faces alone can have anywhere
  RowTables rows;                   // of the nodes
  TileTables tiles;                 // areal scenes
  const double* height1 = nullptr;  // (group, lane): h_1 - delta; far below for the padding
  const double* height2 = nullptr;  // (row, resonator node), padded beyond the end of a row
  // plane scenes: bound on the face from a node to the `width`-th after it
  const double* highest2 = nullptr;

  bool smooth = false;                 // what follows is of smooth faces, else null and 0
  const double* curvature1 = nullptr;  // (group, lane): h_1'' chi^2 at the nodes
  const double* curvature2 = nullptr;  // h_2'' chi^2 at the nodes, padded as height2
  double largest_face_curvature = 0;   // max |curvature2|
  // Each face's share of cell_sag (kernels/candidate_groups.hpp), of either sign.
  const double* sag1 = nullptr;  // (group, lane)
  const double* sag2 = nullptr;  // resonator node, padded as height2
  // plane scenes: max of sag2 over a node and the `width` after it
  const double* highest_sag2 = nullptr;
  double sag_per_travel = 0;  // of the modes, over their travel
};

/// The slider's modes at its nodes.
struct SliderShapes {
  int modes = 0;
  int first_lane = 0;             // of the first of them; before it stand the resonator's modes
  int row = 0;                    // length of a row of `shape`: nodes, padded to whole groups
  const double* shape = nullptr;  // (slider mode, group, lane): psi at the nodes; of one row
  const double* unit = nullptr;   // (slider mode, lane): 1 at that mode's own lane
  // smooth faces: (slider mode, 4, group, lane), chi^j psi^(j)/j! in the middle of the cells; of
  // one row
  const double* cell = nullptr;
};

/// The resonator's modes on patches.
struct PatchTables {
  int count = 0;
  int nodes = 0;              // width of a patch in nodes (radius = half of it + half a group + 1)
  double inverse_nodes = 0;   // 1/nodes
  double inverse_radius = 0;  // chi / radius
  int terms = 4;              // of the full series, a multiple of 4
  const double* quartic = nullptr;      // (beta radius)^4
  const double* derivatives = nullptr;  // (patch, 4, lane): radius^j psi^(j)(centre)
};

/// The contact law.
struct ContactTables {
  double node_stiffness = 0;  // N/m, kappa chi w
  double compliance = 0;      // m/N, 1/(kappa chi w); 0 under multipliers

  // Form::implicit
  double tolerance = 0;         // m, an overlap that counts as none: roundings
  double least_compliance = 0;  // m/N, of a node that any mode moves: what is less is roundings
  const double* receptance = nullptr;  // m/N per m of beam: U1 of a modal force of 1 over the step
  const double* mobility = nullptr;    // (m/s)/N per m of beam: V1 of it
};

/// A scheme of fixed steps (kernels/schemes/mode_step.hpp).
struct SchemeWeights {
  Form form = Form::semi_implicit;
  int stages = 1;
  double place[most_stages] = {};   // of the stages, in steps
  int stage_row[most_stages] = {};  // first_stage_row
  double velocity_lag = 0;          // steps
  double loss_ends = 0;             // weight of the damping loss at both ends of a stretch of steps
  const double* stage = nullptr;    // rows of lanes, see stage_row
  const double* end = nullptr;      // rows of lanes, see EndRow
};

/// The modes' shapes on the part of the resonator that an areal scene's slider stands on, as
/// polynomials (kernels/footprint.hpp). One set of them, a place, serves some nodes of the path.
struct FootprintTables {
  int degree = 0;                //
  int terms = 0;                 // whole blocks of footprint_side_by_side; 0: there are none
  int first = 0;                 // Place::base where the path begins
  int nodes = 1;                 // of the path, to a place
  int places = 0;                //
  double inverse_half = 1;       // 1/chi, of half a place's rectangle along x: xi is 1 at its end
  const double* rows = nullptr;  // (place, term, lane): Phi; 0 of the slider's modes
  // what they leave out of a shape, roundings as well; of the slider's modes all, or what is left
  // where a group's middle is followed
  const double *remainder = nullptr, *remainder_in_group = nullptr;
  const double* alike = nullptr;  // the shape of the slider's modes that move all nodes alike, or 0
};
/// Terms that are summed together.
inline constexpr int footprint_side_by_side = 4;
/// 153 terms: of more the sums would bound hardly better than those of up to 256 modes do.
inline constexpr int highest_footprint_degree = 16;
/// Marches of fewer packs have none.
inline constexpr int least_footprint_packs = 4;

/// Bounds on the motion, from which follows which nodes can come into contact, and how tightly they
/// are used.
struct MotionLimits {
  Nodes searched = Nodes::candidates;
  int valid_steps = 1;  // over which the bounds on the modes hold

  // these set the cost, never the answer
  double least_range = 0;   // m, of a list of candidate groups
  double least_margin = 0;  // m, of a list of nodes

  // Of schemes with fixed steps. The contact forces f accelerate a node within a time t by no more
  // than (acceleration_per_newton + jerk_per_newton t) sum f.
  double acceleration_per_newton = 0;  // 1/kg
  double jerk_per_newton = 0;          // 1/(kg s)

  // Form::adaptive: not of the first two
  const double* acceleration_per_energy_norm =
      nullptr;                                 // 1/s, bound on |V'|/sqrt(V^2 + omega^2U^2)
  const double* outer_acceleration = nullptr;  // m^(3/2)/s^2, bound on |V'| of the outer forces
  const double* largest_shape = nullptr;       // max |psi|
  const double* largest_slope = nullptr;       // max |psi'|, resonator only: its nodes move
  const double* largest_curvature = nullptr;   // max |psi''|, resonator only
  const double* cell_sag = nullptr;  // smooth faces: what psi within a cell exceeds its ends by
  // areal scenes: what psi at the nodes of a tile differs by from psi in its middle or, of the
  // resonator, from its polynomial there (FootprintTables); without one, from psi where the patch
  // and the band there have theirs
  const double* tile_variation = nullptr;
  const double* cubic_remainder = nullptr;        // what a cubic over a patch leaves out, over |U|
  const double* cubic_slope_remainder = nullptr;  // 1/m, of its slope
  FootprintTables footprint;
};

/// The series of an adaptive step.
struct SeriesTables {
  double tolerance = 0;                  // relative local error of a step
  int order = 0;                         // of the series, but for StepControl::raised
  int most_raised = 0;                   // of that
  double longest_scale = 0;              // s, unit of a series beyond which its terms may overflow
  double cubic_excess = 1;               // derivatives of a mode's cubic over a patch, over its own
  const double* decay = nullptr;         // 1/s, 2 zeta omega
  const double* fastest_rate = nullptr;  // 1/s, bound on |(omega U, V)'|/|(omega U, V)|
  const double* passing_rate = nullptr;  // 1/s, speed times the largest wave number of a mode
  const double* inverse_mass = nullptr;  // m/kg
  const double* hull = nullptr;          // (order, coefficient, overlap_terms): see Hull
  const double* gauss = nullptr;         // points in (0, 1), then weights: two rows of gauss_row
  const double* lobatto = nullptr;       // (rule, lobatto_numbers)
};

/// Clusters of nodes that share their sums over the modes, in areal scenes.
struct ClusterTables {
  int degree = 0;                     // of the polynomials; 0: there are no clusters
  int rows = 0;                       // even ones, in `across`
  const double* across = nullptr;     // (even row, 4, lane): d^b across/deta^b / b! there
  const double* remainder = nullptr;  // adaptive: what the polynomials leave out of a shape
};

/// Free flight of any length, under the adaptive scheme.
struct FlightTables {
  int levels = 0;
  int first_level = 0;    // they are of 2^first_level, 2^(first_level + 1), ... ticks
  int elastic_packs = 0;  // the first, up to one with a rigid mode
  double fourth_derivative_at_rest = 0;  // m/s^4, where the load holds the modes: Flight::bounds
  const double* rows = nullptr;          // (level, FlightRow, lane)
  const double* rest = nullptr;          // m^(3/2), where the load holds a mode; 0 for a rigid one
  const double* free_acceleration = nullptr;  // m^(3/2)/s^2, load/m of a rigid mode; else 0
  const double* displacement_per_energy_norm = nullptr;       // s, 2/omega: the farthest it gets
  const double* fourth_derivative_per_energy_norm = nullptr;  // m^(-1/2)/s^3, of an overlap
};

/// The steps of the adaptive scheme in contact between smooth faces
/// (kernels/adaptive/smooth_step.hpp).
struct CollocationTables {
  const double* paces = nullptr;  // (Pace): point_shares and what follows it
  bool cells_share = false;  // a cell's cubics of the modes' shapes do for those beside it, too
  double early_release = 0;  // the share of a step graded towards a release that may follow it
};

struct MovingForces {
  int count = 0;
  double resonator_length = 0;  // m
  const MovingForceTable* list = nullptr;
  const double* across = nullptr;  // (force, lane): as RowTables::across, at its y
};

/// When a march ends, and what it records.
struct RecordTables {
  std::int64_t total_steps = 0;
  std::int64_t counted_from = 0;  // the step at which statistics begin: an adaptive step ends there
  double steps_per_sample = 0;
  std::int64_t samples = 0;
  double least_energy = 0;  // J, below which energy is not checked
};

struct SceneTables {
  ModeTables modes;
  SliderMotion motion;
  FaceTables faces;
  SliderShapes slider;
  PatchTables patches;
  ContactTables contact;
  SchemeWeights scheme;
  MotionLimits bounds;
  SeriesTables adaptive;
  ClusterTables clusters;
  FlightTables flight;
  CollocationTables collocation;
  MovingForces forces;
  RecordTables output;
  const int* interrupted = nullptr;  // of host backends: not 0 when the launch is to end soon
};

/// Every array of the tables, once: its name, where its address stands, and how many values it has.
/// Whatever allocates them, sets their addresses or copies them goes by this list alone. First
/// those that scenes with equal bodies, schemes and speeds share.
template <class Visit>
void visit_shared_arrays(SceneTables& t, const Extents& n, Visit&& visit) {
  const auto lanes = static_cast<std::size_t>(n.lanes);
  visit("stage", t.scheme.stage, n.stage_rows * lanes);
  visit("end", t.scheme.end, n.end_rows * lanes);
  visit("receptance", t.contact.receptance, lanes);
  visit("mobility", t.contact.mobility, lanes);
  visit("load", t.modes.load, lanes);
  visit("mass", t.modes.mass, lanes);
  visit("omega", t.modes.omega, lanes);
  visit("damping", t.modes.damping, lanes);
  visit("acceleration_per_energy_norm", t.bounds.acceleration_per_energy_norm, lanes);
  visit("outer_acceleration", t.bounds.outer_acceleration, lanes);
  visit("largest_shape", t.bounds.largest_shape, lanes);
  visit("largest_slope", t.bounds.largest_slope, lanes);
  visit("largest_curvature", t.bounds.largest_curvature, lanes);
  visit("cubic_remainder", t.bounds.cubic_remainder, lanes);
  visit("cubic_slope_remainder", t.bounds.cubic_slope_remainder, lanes);
  if (n.rows > 0) visit("tile_variation", t.bounds.tile_variation, lanes);
  visit("quartic", t.patches.quartic, lanes);
  visit("patch", t.patches.derivatives, n.patches * 4 * lanes);
  visit("slider_shape", t.slider.shape, n.slider_modes * n.padded_row());
  visit("unit", t.slider.unit, n.slider_modes * lanes);
  if (n.smooth) {
    visit("slider_cell", t.slider.cell, 4 * n.slider_modes * n.padded_row());
    visit("cell_sag", t.bounds.cell_sag, lanes);
  }
  if (!n.adaptive()) return;
  visit("flight", t.flight.rows, static_cast<std::size_t>(n.flight_levels) * flight_rows * lanes);
  visit("rest", t.flight.rest, lanes);
  visit("free_acceleration", t.flight.free_acceleration, lanes);
  visit("decay", t.adaptive.decay, lanes);
  visit("fastest_rate", t.adaptive.fastest_rate, lanes);
  visit("displacement_per_energy_norm", t.flight.displacement_per_energy_norm, lanes);
  visit("fourth_derivative_per_energy_norm", t.flight.fourth_derivative_per_energy_norm, lanes);
  visit("passing_rate", t.adaptive.passing_rate, lanes);
  visit("inverse_mass", t.adaptive.inverse_mass, lanes);
  if (n.cluster_degree > 0) visit("cluster_remainder", t.clusters.remainder, lanes);
  visit("hull", t.adaptive.hull, n.series_orders() * std::size_t{hull_length});
  visit("gauss", t.adaptive.gauss, std::size_t{2 * gauss_row});
  visit("lobatto", t.adaptive.lobatto, std::size_t{lobatto_rules * lobatto_numbers});
  if (n.smooth) visit("collocation", t.collocation.paces, std::size_t{paces * pace_numbers});
}
/// Then those of a scene's own.
template <class Visit>
void visit_own_arrays(SceneTables& t, const Extents& n, Visit&& visit) {
  const std::size_t heights = n.heights;
  visit("height1", t.faces.height1, n.padded_nodes());
  visit("height2", t.faces.height2, heights);
  if (n.rows == 0) {
    visit("highest2", t.faces.highest2, heights);
  } else {
    const std::size_t bands = n.bands();
    visit("across", t.faces.rows.across, static_cast<std::size_t>(n.rows) * n.lanes);
    visit("tile_highest1", t.faces.tiles.highest1, bands * n.padded_tiles());
    visit("tile_highest2", t.faces.tiles.highest2, bands * n.tile_groups() * n.strip());
    visit("column1", t.faces.tiles.column1, bands * n.column_row());
    visit("column2", t.faces.tiles.column2, bands * n.column_strip());
    visit("tile_shape", t.faces.tiles.shape,
          static_cast<std::size_t>(n.slider_modes) * n.padded_tiles());
    visit("tile_across", t.faces.tiles.across, bands * n.lanes);
    if (n.footprint_terms > 0) {
      const auto lanes = static_cast<std::size_t>(n.lanes);
      visit("footprint", t.bounds.footprint.rows, n.footprint_places * n.footprint_terms * lanes);
      visit("footprint_remainder", t.bounds.footprint.remainder, lanes);
      visit("footprint_remainder_in_group", t.bounds.footprint.remainder_in_group, lanes);
      visit("footprint_alike", t.bounds.footprint.alike, lanes);
    }
    if (n.cluster_degree > 0)
      visit("cluster_across", t.clusters.across,
            static_cast<std::size_t>(n.place_rows()) * 4 * n.lanes);
  }
  if (n.smooth) {
    visit("curvature1", t.faces.curvature1, n.padded_nodes());
    visit("curvature2", t.faces.curvature2, heights);
    visit("sag1", t.faces.sag1, n.padded_nodes());
    visit("sag2", t.faces.sag2, heights);
    if (n.rows == 0) visit("highest_sag2", t.faces.highest_sag2, heights);
  }
  const auto moving = static_cast<std::size_t>(n.moving_forces);
  visit("moving_force", t.forces.list, moving);
  if (n.rows > 0) visit("moving_force_across", t.forces.across, moving * n.lanes);
}
template <class Visit>
void visit_arrays(SceneTables& t, const Extents& n, Visit&& visit) {
  visit_shared_arrays(t, n, visit);
  visit_own_arrays(t, n, visit);
}

}  // namespace ra2d
