// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/batch.hpp"

#include <fmt/format.h>

#include <Kokkos_Core.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#if defined(KOKKOS_ENABLE_OPENMP)
#include <omp.h>
#endif

#include "host/device/flight_tables.hpp"
#include "host/device/gauss.hpp"
#include "host/device/launch.hpp"
#include "host/errors.hpp"
#include "host/interruption.hpp"
#include "host/model/step_bounds.hpp"
#include "host/scene/schemes.hpp"
#include "kernels/candidates.hpp"
#include "kernels/limits.hpp"

namespace ra2d {
namespace {

constexpr int width = LanesOf<Space>::width;

/// One block of device memory with a host copy; pieces are handed out before it is made.
class Arena {
 public:
  /// Room for `count` values of T; returns its offset in bytes.
  template <class T>
  std::size_t reserve(std::size_t count) {
    const std::size_t offset = (bytes_ + 63) / 64 * 64;
    bytes_ = offset + count * sizeof(T);
    return offset;
  }
  void allocate() {
    // one cache line more, so that the pieces can start on one
    device_ = Kokkos::View<char*, Space>("ra2d::arena", bytes_ + 64);
    host_ = Kokkos::create_mirror_view(device_);
    shift_ = (64 - reinterpret_cast<std::uintptr_t>(device_.data()) % 64) % 64;
  }
  template <class T>
  T* device(std::size_t offset) const {
    return reinterpret_cast<T*>(device_.data() + shift_ + offset);
  }
  template <class T>
  T* host(std::size_t offset) const {
    return reinterpret_cast<T*>(host_.data() + shift_ + offset);
  }
  std::size_t bytes() const { return bytes_; }
  void upload() { Kokkos::deep_copy(device_, host_); }
  /// Brings part of the device's copy back.
  void fetch(std::size_t offset, std::size_t bytes) const {
    const auto range = std::make_pair(shift_ + offset, shift_ + offset + bytes);
    Kokkos::deep_copy(Kokkos::subview(host_, range), Kokkos::subview(device_, range));
  }

 private:
  std::size_t bytes_ = 0, shift_ = 0;
  Kokkos::View<char*, Space> device_;
  typename Kokkos::View<char*, Space>::host_mirror_type host_;
};

/// The displacement series of a scene's resonator.
struct Series {
  int terms = 4;
  int patch_nodes = 1;
};

Form form_of(const Scene& scene) {
  if (is_adaptive(scene)) return Form::adaptive;
  return holds_forces(scene)                   ? Form::held
         : is_semi_implicit(scene.time.scheme) ? Form::semi_implicit
                                               : Form::staged;
}

/// Nodes that can be in contact at once under the adaptive scheme.
int closed_capacity(const Model& model) {
  return is_adaptive(model.scene) ? std::min(model.nodes(), most_sprung_nodes) : 0;
}

/// Nodes that can carry force at once under Form::held: no more than there are modes under
/// multipliers; with the springs' compliance any number, of which this many are provided for.
int pressed_capacity(const Model& model) {
  const int modes = static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
  return std::min(model.nodes(),
                  model.scene.contact.law == ContactLaw::multiplier ? modes : most_sprung_nodes);
}

double highest_beta(const Beam& beam) {
  double beta = 0;
  for (const ModeShape& mode : beam.modes) beta = std::max(beta, mode.beta);
  return beta;
}

/// Patches as wide as beta radius = 1/4 allows (four terms then leave out 2e-4 of the highest mode
/// and far less of the others), or of a single node when the nodes are that coarse; and terms until
/// what is left out, (beta radius)^terms / terms!, is below half an ulp.
Series choose_series(const Model& model) {
  const double beta_chi = highest_beta(model.resonator) * model.scene.spacing;
  const double widest = static_cast<double>(model.resonator_height.size());
  // radius = (patch_nodes + width)/2 + 1 in chi
  const double nodes = beta_chi > 0 ? std::min(widest, 0.5 / beta_chi - width - 2) : widest;
  Series series;
  series.patch_nodes = std::max(1, static_cast<int>(nodes));
  const double range = beta_chi * (0.5 * (series.patch_nodes + width) + 1.0);
  const auto left_out = [&] {
    return std::exp(series.terms * std::log(range) - std::lgamma(series.terms + 1.0));
  };
  while (range > 0 && series.terms <= most_terms && left_out() > 0x1p-53) series.terms += 4;
  if (series.terms > most_terms)
    throw refusal(
        model.scene, "scene.spacing",
        fmt::format("{} m gives the resonator's highest mode only {:.1f} nodes to a wavelength, "
                    "{:.0f} are needed here: refine it, or keep fewer modes "
                    "(resonator.max_frequency)",
                    model.scene.spacing, 2 * M_PI / beta_chi,
                    std::ceil(2 * M_PI * (0.5 * (1 + width) + 1.0) / 2.1)));
  return series;
}

/// A scene's place in the arena.
struct Layout {
  int lanes, groups, patches, run_capacity;
  Series series;
  int stage_rows, end_rows, pressed_capacity;
  int first_level, levels, closed_capacity;
  std::size_t mode_tables, flight, gauss, hull, stage, end, patch, shapes, unit, height1, height2,
      highest2, moving;
  std::size_t modal_state, samples, runs, new_runs, open, shocks, near, far, far_top, watch,
      touched, force, amplitudes, node_shape, node_face, node_window, pressed, pressed_place,
      pressed_force, factor, across, share, closed, closed_hull, closed_sums, closed_roots, roots,
      modal_series, square_series, push_series, node_series, closed_shape, scan_shape, scan,
      hull_room, seen;
  int height2_size;
  int sample_capacity, shock_capacity, row;
};

enum ModeTable {
  held_u,
  held_v,
  load,
  mass,
  omega,
  damping,
  pull,
  push,
  yield,
  reach,
  slope,
  curve,
  tail,
  tail_slope,
  quartic,
  // of the adaptive scheme
  rest,
  fall,
  decay,
  turn,
  swing,
  fourth,
  wander,
  light,
  mode_tables
};
enum ModalArray {
  u,
  v,
  start,
  start_v,
  square,
  square_part,
  near_u,
  far_u,
  bend_part,
  modal_arrays
};

/// 1/s: |(omega U, V)'| over |(omega U, V)| is no more.
double quickest(const Mode& mode) {
  return mode.omega * (mode.zeta + std::sqrt(1.0 + mode.zeta * mode.zeta));
}
/// ... of all modes, together with the spring of a node.
double quickest(const Model& model) {
  double square = 0, spring = 0;
  for (const Beam* beam : {&model.resonator, &model.slider})
    for (const ModeShape& shape : beam->modes) {
      const double turn = quickest(Mode{shape.omega, beam->zeta, beam->mass_per_length});
      square = std::max(square, turn * turn);
      spring += model.node_stiffness * std::pow(shape.largest, 2) / beam->mass_per_length;
    }
  return std::sqrt(square + spring);
}

/// The lowest level of the flight tables. Flights of less are a Taylor step of third order: of
/// (turn time)^4/24 nothing is left there.
int first_level(const Model& model) {
  if (!is_adaptive(model.scene)) return 0;
  const double turn = std::max(quickest(model), 1e-3);
  return std::clamp(std::ilogb(2e-4 / (turn * model.tick)), 0, 40);
}

/// C(i, j)/C(n, j), row j, for i <= n; what is beyond repeats the last and is masked out of the
/// first and second differences (kernels/adaptive/crossing.hpp).
void fill_hull(double* table, int n) {
  for (int i = 0; i < overlap_terms; ++i) {
    const int last = std::min(i, n);
    double share = 1.0;
    for (int j = 0; j <= last; ++j) {
      table[j * overlap_terms + i] = share;
      share *= static_cast<double>(last - j) / std::max(1, n - j);
    }
    double* mask = table + overlap_terms * overlap_terms + i;
    mask[0] = i < n ? 1.0 : 0.0;
    mask[overlap_terms] = i < n - 1 ? 1.0 : 0.0;
  }
}

/// Steps over which bounds on the modes are worth anything: what a scheme beyond its limit makes of
/// them in more is out of all proportion.
int longest_look(const Model& model) {
  const SchemeTable& scheme = scheme_table(model.scene.time.scheme);
  const double tau = model.scene.time.step;
  const auto grows = [&](int steps) {
    for (const Beam* beam : {&model.resonator, &model.slider})
      for (const ModeShape& shape : beam->modes) {
        const Mode mode{shape.omega, beam->zeta, beam->mass_per_length};
        if (bound_step(mode, scheme.prepare(mode, tau), scheme.place, tau, steps).growth > 2.0)
          return true;
      }
    return false;
  };
  int steps = longest_flight;
  while (steps > 16 && grows(steps)) steps /= 2;
  return steps;
}

}  // namespace

Backend::Backend(int threads) {
  Kokkos::InitializationSettings settings;
  settings.set_disable_warnings(true);  // about thread binding: one scene runs on one thread
  if (threads > 0) settings.set_num_threads(threads);
#if defined(KOKKOS_ENABLE_OPENMP)
  // before it heeds that number, Kokkos starts a thread on every processor, and where the system
  // starts no more, that ends the program
  if (threads > 0) omp_set_num_threads(threads);
#endif
  Kokkos::initialize(settings);
}
Backend::~Backend() { Kokkos::finalize(); }

std::string backend_name() { return Space::name(); }
int backend_threads() { return Space().concurrency(); }
int backend_lanes() { return width; }

struct Batch::Impl {
  using HostState = Kokkos::View<SceneState, Kokkos::HostSpace, Kokkos::MemoryUnmanaged>;

  std::vector<Model> models;
  std::vector<Layout> layouts;
  int packs = 0;
  Arena arena;
  Kokkos::View<SceneTables*, Space> tables;
  Kokkos::View<SceneState*, Space> states;
  std::array<ScenesView, forms> scenes;  // of each form

  Layout lay_out(const Model& model, const Series& series, const BatchOptions& options) {
    Layout l{};
    const int modes1 = static_cast<int>(model.slider.modes.size());
    l.series = series;
    l.lanes = packs * width;
    l.groups = (model.nodes() + width - 1) / width;
    const int reach2 =
        static_cast<int>(model.resonator_height.size()) + l.groups * width + 2 * width;
    l.patches = reach2 / series.patch_nodes + 1;
    l.height2_size = reach2;
    // runs of neighbouring nodes: at the most every other node
    l.run_capacity = model.nodes() / 2 + 2;
    l.sample_capacity =
        static_cast<int>(std::min<std::int64_t>(options.samples_at_once, model.samples));
    l.shock_capacity = options.shocks_at_once + l.run_capacity;
    l.row = 2 * l.lanes + sample::columns;

    const bool adaptive = is_adaptive(model.scene);
    const int stages = adaptive ? 1 : scheme_table(model.scene.time.scheme).stages;
    l.stage_rows = first_stage_row(stages);
    l.end_rows = ra2d::end_rows(stages);
    const bool held = form_of(model.scene) == Form::held;
    l.pressed_capacity = held ? pressed_capacity(model) : 0;
    l.closed_capacity = closed_capacity(model);
    l.first_level = first_level(model);
    l.levels = adaptive
                   ? std::max(1, std::ilogb(static_cast<double>(model.steps)) + 1 - l.first_level)
                   : 0;

    l.mode_tables = arena.reserve<double>(ra2d::mode_tables * l.lanes);
    l.stage = arena.reserve<double>(static_cast<std::size_t>(l.stage_rows) * l.lanes);
    l.end = arena.reserve<double>(static_cast<std::size_t>(l.end_rows) * l.lanes);
    l.patch = arena.reserve<double>(static_cast<std::size_t>(l.patches) * 4 * l.lanes);
    l.shapes = arena.reserve<double>(static_cast<std::size_t>(modes1) * l.groups * width);
    l.unit = arena.reserve<double>(static_cast<std::size_t>(modes1) * l.lanes);
    l.height1 = arena.reserve<double>(l.groups * width);
    l.height2 = arena.reserve<double>(l.height2_size);
    l.highest2 = arena.reserve<double>(l.height2_size);
    l.moving = arena.reserve<MovingForceTable>(model.scene.resonator.moving_forces.size());
    l.modal_state = arena.reserve<double>(modal_arrays * l.lanes);
    l.samples = arena.reserve<double>(static_cast<std::size_t>(l.sample_capacity) * l.row);
    l.runs = arena.reserve<ContactRun>(l.run_capacity);
    l.new_runs = arena.reserve<ContactRun>(l.run_capacity);
    l.open = arena.reserve<OpenShock>(2 * l.run_capacity);
    l.shocks = arena.reserve<ShockRow>(l.shock_capacity);
    l.near = arena.reserve<int>(l.groups);
    l.far = arena.reserve<int>(l.groups);
    l.far_top = arena.reserve<double>(l.groups);
    l.watch = arena.reserve<int>(l.groups * width);
    l.touched = arena.reserve<int>(l.groups * width);
    l.force = arena.reserve<double>(l.groups * width);
    l.node_shape = arena.reserve<double>(static_cast<std::size_t>(model.nodes()) * 4 * l.lanes);
    l.node_face = arena.reserve<double>(2 * model.nodes());
    l.node_window = arena.reserve<std::int64_t>(model.nodes());
    l.amplitudes = arena.reserve<double>(2 * l.lanes);
    const auto room = static_cast<std::size_t>(l.pressed_capacity);
    l.pressed = arena.reserve<int>(room);
    l.pressed_place = arena.reserve<int>(held ? model.nodes() : 0);
    l.pressed_force = arena.reserve<double>(room);
    l.factor = arena.reserve<double>((room + 1) * room);
    l.across = arena.reserve<double>(room);
    l.share = arena.reserve<double>(room);
    if (adaptive) {
      const auto closed = static_cast<std::size_t>(l.closed_capacity);
      l.flight = arena.reserve<double>(static_cast<std::size_t>(l.levels) * flight_rows * l.lanes);
      l.gauss = arena.reserve<double>(2 * gauss_room);
      l.closed = arena.reserve<int>(closed);
      l.hull = arena.reserve<double>((overlap_terms + 2) * overlap_terms);
      l.closed_hull = arena.reserve<Hull>(closed);
      l.closed_sums = arena.reserve<NodeSums>(closed);
      l.closed_roots = arena.reserve<double>(closed);
      l.roots = arena.reserve<double>(l.groups * width);
      l.modal_series = arena.reserve<double>((most_order + 1) * l.lanes);
      l.square_series = arena.reserve<double>(most_order * l.lanes);
      l.push_series = arena.reserve<double>((most_order + 1) * l.lanes);
      l.node_series = arena.reserve<double>(closed * 2 * overlap_terms);
      l.closed_shape = arena.reserve<double>(closed * 4 * l.lanes);
      l.scan_shape = arena.reserve<double>(4 * l.lanes);
      l.scan = arena.reserve<double>(overlap_terms);
      l.hull_room = arena.reserve<double>(2 * overlap_terms);
      l.seen = arena.reserve<double>(static_cast<std::size_t>(4) * l.groups * width);
    }
    return l;
  }

  SceneState fetch_state(int scene) const {
    SceneState state;
    Kokkos::deep_copy(HostState(&state), Kokkos::subview(states, scene));
    return state;
  }
  void put_state(int scene, SceneState state) const {
    Kokkos::deep_copy(Kokkos::subview(states, scene), HostState(&state));
  }

  SceneTables fill_tables(const Model& model, const Layout& l);
  SceneState fill_state(const Model& model, const ModalStart& start, const Layout& l);
};

SceneTables Batch::Impl::fill_tables(const Model& model, const Layout& l) {
  const Scene& scene = model.scene;
  const int modes2 = static_cast<int>(model.resonator.modes.size());
  const int modes1 = static_cast<int>(model.slider.modes.size());
  const double chi = scene.spacing, tau = model.tick;
  const double radius = (0.5 * (l.series.patch_nodes + width) + 1.0) * chi;

  SceneTables t;
  t.resonator_modes = modes2;
  t.slider_modes = modes1;
  t.nodes = model.nodes();
  t.groups = l.groups;
  t.patches = l.patches;
  t.patch_nodes = l.series.patch_nodes;
  t.inverse_patch = 1.0 / t.patch_nodes;
  t.terms = l.series.terms;
  t.moving_forces = static_cast<int>(scene.resonator.moving_forces.size());
  t.look_at = scene.time.nodes;
  t.form = form_of(scene);
  t.position = model.position;
  t.advance = model.advance;
  t.spacing = chi;
  t.step = tau;
  t.inverse_radius = chi / radius;
  // cubic over a window: beta^4 (width/2)^4 / 4! below two ulp, or far below the asked tolerance
  const double left_out =
      is_adaptive(scene)
          ? std::clamp(1e-4 * scene.time.tolerance.value_or(usual_tolerance), 0x1p-51, 1e-13)
          : 0x1p-51;
  t.windows = static_cast<int>(std::ceil(
      std::max(1.0, 0.5 * highest_beta(model.resonator) * chi / std::pow(24 * left_out, 0.25))));
  t.window_width = 1.0 / t.windows;
  t.resonator_length = scene.resonator.length;
  t.node_stiffness = model.node_stiffness;
  t.compliance = scene.contact.law == ContactLaw::multiplier ? 0.0 : 1.0 / model.node_stiffness;
  t.total_steps = model.steps;
  t.counted_from = first_counted(model);
  t.steps_per_sample = model.steps_per_sample;
  t.samples = model.samples;
  if constexpr (Kokkos::SpaceAccessibility<Space, Kokkos::HostSpace>::accessible)
    t.interrupted = interruption_flag();

  const bool adaptive = is_adaptive(scene);
  const SchemeTable* scheme = adaptive ? nullptr : &scheme_table(scene.time.scheme);
  if (scheme != nullptr) {
    t.stages = scheme->stages;
    std::copy_n(scheme->place, scheme->stages, t.place);
    for (int i = 1; i < t.stages; ++i) t.stage_row[i] = first_stage_row(i);
    t.velocity_lag = scheme->velocity_lag;
    t.loss_ends = is_semi_implicit(scene.time.scheme) ? 0.0 : 0.5;
    t.longest_look = longest_look(model);
  }

  // modes
  double* m = arena.host<double>(l.mode_tables);
  double* stages = arena.host<double>(l.stage);
  double* ends = arena.host<double>(l.end);
  const auto table = [&](int which) { return m + which * l.lanes; };
  double push_of_forces = 0;  // N
  double kick = 0;            // J, see least_energy
  for (const MovingForce& f : scene.resonator.moving_forces) push_of_forces += std::abs(f.force);
  const auto fill_step = [&](int lane, const Mode& oscillator, double load_force, double reach_of,
                             double pushed) {
    const ModeStep step = scheme->prepare(oscillator, tau);
    const StepBounds bounds = bound_step(oscillator, step, t.place, tau, t.longest_look);
    for (int i = 1; i < t.stages; ++i) {
      const auto row = [&](int r) -> double& {
        return stages[(t.stage_row[i] + r) * l.lanes + lane];
      };
      row(0) = step.stage_u[i];
      row(1) = step.stage_v[i];
      row(2) = step.held_stage(i) * load_force;
      for (int j = 0; j < i; ++j) row(3 + j) = step.stage_f[i][j];
    }
    const auto end = [&](int r) -> double& { return ends[r * l.lanes + lane]; };
    end(end_u_u) = step.u_u;
    end(end_u_v) = step.u_v;
    end(end_u_load) = step.held_u() * load_force;
    end(end_v_u) = step.v_u;
    end(end_v_v) = step.v_v;
    end(end_v_load) = step.held_v() * load_force;
    for (int j = 0; j < t.stages; ++j) {
      end(end_forces + 2 * j) = step.u_f[j];
      end(end_forces + 2 * j + 1) = step.v_f[j];
    }
    table(held_u)[lane] = step.held_u();
    table(held_v)[lane] = step.held_v();
    table(pull)[lane] = bounds.pull;
    // shapes are right to some 1e-15 of their largest
    t.least_yielding += 1e-26 * step.held_u() * std::pow(reach_of, 2);
    table(yield)[lane] = reach_of * bounds.force;
    table(push)[lane] = pushed * bounds.force;
  };
  double* flights = arena.host<double>(l.flight);
  const auto fill_flight = [&](int lane, const Mode& oscillator, double load_force, double reach_of,
                               double beta) {
    const double omega_k = oscillator.omega, b = beta * scene.speed, turn_k = quickest(oscillator);
    table(turn)[lane] = turn_k;
    table(light)[lane] = 1.0 / oscillator.mass;
    table(decay)[lane] = 2.0 * oscillator.zeta * omega_k;
    table(wander)[lane] = b;
    if (omega_k == 0.0) {
      table(fall)[lane] = load_force / oscillator.mass;
      table(swing)[lane] = 1e300;
    } else {
      table(rest)[lane] = load_force / (oscillator.mass * omega_k * omega_k);
      table(swing)[lane] = 2.0 / omega_k;
      // |U^(j)| <= turn^(j - 1) E, and the node passes over the mode: (turn + b)^4 term by
      // term
      table(fourth)[lane] = reach_of * (turn_k * turn_k * (turn_k + 4.0 * b) +
                                        b * b * (6.0 * turn_k + 4.0 * b) + b * b * b * b / omega_k);
      t.fourth_rest += reach_of * std::pow(b, 4) * std::abs(table(rest)[lane]);
    }
    const auto tables = flight_tables(oscillator, load_force, tau, l.first_level, l.levels);
    for (int level = 0; level < l.levels; ++level)
      for (int r = 0; r < flight_rows; ++r)
        flights[(static_cast<std::size_t>(level) * flight_rows + r) * l.lanes + lane] =
            tables[level][r];
  };
  const auto fill_mode = [&](int lane, const Beam& beam, std::size_t k, bool moves) {
    const ModeShape& mode = beam.modes[k];
    const Mode oscillator{mode.omega, beam.zeta, beam.mass_per_length};
    table(load)[lane] = beam.load[k];
    table(mass)[lane] = beam.mass_per_length;
    table(omega)[lane] = mode.omega;
    table(damping)[lane] = 2.0 * beam.zeta * mode.omega * beam.mass_per_length * tau;
    const double wave =
        std::hypot(mode.sine, mode.cosine) + std::abs(mode.left) + std::abs(mode.right);
    const double rigid =
        std::max(std::abs(mode.constant), std::abs(mode.constant + mode.slope * beam.length));
    table(reach)[lane] = wave + rigid;
    const double pushed = std::abs(beam.load[k]) + (moves ? push_of_forces * (wave + rigid) : 0.0);
    if (adaptive)
      fill_flight(lane, oscillator, beam.load[k], wave + rigid,
                  moves ? std::max(mode.beta, std::abs(mode.slope) / (wave + rigid)) : 0.0);
    else
      fill_step(lane, oscillator, beam.load[k], wave + rigid, pushed);
    kick += 0.5 * std::pow(tau * pushed, 2) / beam.mass_per_length;
    if (moves) {
      // a patch may reach beyond the end of the beam, where the exponential of a free beam grows on
      const double out = std::hypot(mode.sine, mode.cosine) + std::abs(mode.left) +
                         std::abs(mode.right) * std::exp(2 * mode.beta * radius);
      table(slope)[lane] = mode.beta * out + std::abs(mode.slope);
      table(curve)[lane] = mode.beta * mode.beta * out;
      table(tail)[lane] = out * std::pow(mode.beta * radius, 4) / 24;
      table(tail_slope)[lane] = out * mode.beta * std::pow(mode.beta * radius, 3) / 6;
      table(quartic)[lane] = std::pow(mode.beta * radius, 4);
    }
  };
  for (int k = 0; k < modes2; ++k) fill_mode(k, model.resonator, k, true);
  for (int k = 0; k < modes1; ++k) fill_mode(modes2 + k, model.slider, k, false);

  // displacement series of the resonator's modes
  double* rows = arena.host<double>(l.patch);
  for (int p = 0; p < l.patches; ++p) {
    const double centre = (p + 0.5) * l.series.patch_nodes * chi;
    for (int k = 0; k < modes2; ++k) {
      double d[4];
      evaluate(model.resonator.modes[k], model.resonator.length, centre, 4, d);
      for (int j = 0; j < 4; ++j)
        rows[(static_cast<std::size_t>(p) * 4 + j) * l.lanes + k] = d[j] * std::pow(radius, j);
    }
  }
  // the slider's modes at its nodes
  double* shapes = arena.host<double>(l.shapes);
  double* unit = arena.host<double>(l.unit);
  for (int k = 0; k < modes1; ++k) {
    unit[static_cast<std::size_t>(k) * l.lanes + modes2 + k] = 1.0;
    for (int n = 0; n < model.nodes(); ++n)
      evaluate(model.slider.modes[k], model.slider.length, n * chi, 1,
               shapes + static_cast<std::size_t>(k) * l.groups * width + n);
  }

  // faces
  double* h1 = arena.host<double>(l.height1);
  double scale = 0;
  for (int n = 0; n < l.groups * width; ++n) {
    const bool real = n < model.nodes();
    h1[n] = real ? model.slider_height[n] - model.delta : -1e30;
    if (real) scale = std::max(scale, std::abs(h1[n]));
  }
  double* h2 = arena.host<double>(l.height2);
  double scale2 = 0;
  for (int n = 0; n < l.height2_size; ++n) {
    h2[n] = model.resonator_height[std::min<std::size_t>(n, model.resonator_height.size() - 1)];
    scale2 = std::max(scale2, std::abs(h2[n]));
  }
  scale += scale2;
  double* highest2 = arena.host<double>(l.highest2);
  fill_highest(h2, l.height2_size, width, highest2);
  t.slack = 16 * 0x1p-52 * scale;
  t.touch = t.slack;
  for (int n = 0; n + 1 < l.height2_size; ++n)
    t.steepest = std::max(t.steepest, std::abs(h2[n + 1] - h2[n]));
  scale += 1e-6 * chi;
  t.least_reach = 1e-4 * scale;
  t.least_leeway = 1e-8 * scale;
  // What the outer forces put in within a step: from rest the velocity is up to a step ahead of
  // their work, or (midpoint) half a step behind.
  t.least_energy = 1e-30 + 4.0 * kick;

  if (adaptive) {
    t.tolerance = scene.time.tolerance.value_or(usual_tolerance);
    t.order = series_order(t.tolerance);
    t.first_level = l.first_level;
    t.cubic_excess = std::exp(2.0 * highest_beta(model.resonator) * radius);
    t.longest_scale = std::min(scene.duration, 64.0 / std::max(quickest(model), 1e-300));
    t.top = *std::max_element(h1, h1 + model.nodes()) + *std::max_element(h2, h2 + l.height2_size);
    double* gauss = arena.host<double>(l.gauss);
    std::copy_n(gauss_place, gauss_points, gauss);
    std::copy_n(gauss_weight, gauss_points, gauss + gauss_room);
    t.flight = arena.device<double>(l.flight);
    t.gauss = arena.device<double>(l.gauss);
    fill_hull(arena.host<double>(l.hull), t.order + 3);
    t.hull = arena.device<double>(l.hull);
  }

  auto* moving = arena.host<MovingForceTable>(l.moving);
  for (int i = 0; i < t.moving_forces; ++i) {
    const MovingForce& f = scene.resonator.moving_forces[i];
    moving[i] = {f.force, f.start, f.speed * tau};
  }

  const double* dm = arena.device<double>(l.mode_tables);
  const auto on_device = [&](int which) { return dm + which * l.lanes; };
  t.stage = arena.device<double>(l.stage), t.end = arena.device<double>(l.end);
  t.held_u = on_device(held_u), t.held_v = on_device(held_v);
  t.load = on_device(load), t.mass = on_device(mass), t.omega = on_device(omega);
  t.damping = on_device(damping), t.pull = on_device(pull), t.push = on_device(push);
  t.yield = on_device(yield);
  t.reach = on_device(reach), t.reach_slope = on_device(slope), t.reach_curve = on_device(curve);
  t.tail = on_device(tail), t.tail_slope = on_device(tail_slope);
  t.quartic = on_device(quartic);
  t.rest = on_device(rest), t.fall = on_device(fall), t.decay = on_device(decay);
  t.turn = on_device(turn), t.swing = on_device(swing), t.fourth = on_device(fourth),
  t.wander = on_device(wander);
  t.light = on_device(light);
  t.patch = arena.device<double>(l.patch);
  t.slider_shape = arena.device<double>(l.shapes);
  t.unit = arena.device<double>(l.unit);
  t.height1 = arena.device<double>(l.height1);
  t.height2 = arena.device<double>(l.height2);
  t.highest2 = arena.device<double>(l.highest2);
  t.moving_force = arena.device<MovingForceTable>(l.moving);
  return t;
}

SceneState Batch::Impl::fill_state(const Model& model, const ModalStart& begin, const Layout& l) {
  const std::size_t modes2 = model.resonator.modes.size();
  double* host = arena.host<double>(l.modal_state);
  const auto copy = [&](const std::vector<double>& from, int array, std::size_t lane) {
    std::copy(from.begin(), from.end(), host + array * l.lanes + lane);
  };
  for (const int array : {static_cast<int>(ra2d::u), static_cast<int>(ra2d::start)}) {
    copy(begin.resonator_u, array, 0);
    copy(begin.slider_u, array, modes2);
  }
  for (const int array : {static_cast<int>(ra2d::v), static_cast<int>(ra2d::start_v)}) {
    copy(begin.resonator_v, array, 0);
    copy(begin.slider_v, array, modes2);
  }

  double* modal = arena.device<double>(l.modal_state);
  SceneState s;
  s.u = modal + ra2d::u * l.lanes;
  s.v = modal + ra2d::v * l.lanes;
  s.start = modal + ra2d::start * l.lanes;
  s.start_v = modal + ra2d::start_v * l.lanes;
  s.square = modal + ra2d::square * l.lanes;
  s.square_part = modal + ra2d::square_part * l.lanes;
  s.bend_part = modal + ra2d::bend_part * l.lanes;
  s.near_u = modal + ra2d::near_u * l.lanes;
  s.far_u = modal + ra2d::far_u * l.lanes;
  s.energy_start = begin.energy;
  s.sample_rows = arena.device<double>(l.samples);
  s.sample_capacity = l.sample_capacity;
  s.runs = arena.device<ContactRun>(l.runs);
  s.new_runs = arena.device<ContactRun>(l.new_runs);
  s.open = arena.device<OpenShock>(l.open);
  s.run_capacity = l.run_capacity;
  s.shock_rows = arena.device<ShockRow>(l.shocks);
  s.shock_capacity = l.shock_capacity;
  s.near = arena.device<int>(l.near);
  s.far = arena.device<int>(l.far);
  s.far_top = arena.device<double>(l.far_top);
  s.watch = arena.device<int>(l.watch);
  s.touched = arena.device<int>(l.touched);
  s.touched_force = arena.device<double>(l.force);
  s.lanes = arena.device<double>(l.amplitudes);
  s.node_shape = arena.device<double>(l.node_shape);
  s.node_face = arena.device<double>(l.node_face);
  s.node_window = arena.device<std::int64_t>(l.node_window);
  std::fill_n(arena.host<std::int64_t>(l.node_window), model.nodes(), -1);
  if (form_of(model.scene) == Form::held) {
    s.held_step = begin.loaded_nodes.empty() ? -1 : 0;
    s.held_force = begin.contact_force;
    s.held_energy = begin.contact_energy;
    s.held_nodes = static_cast<int>(begin.loaded_nodes.size());
    for (std::size_t e = 0; e < 2 && e < begin.loaded_nodes.size(); ++e)
      s.held_pair[e] = begin.loaded_nodes[e];
    std::fill_n(arena.host<int>(l.pressed_place), model.nodes(), -1);
  }
  s.pressed_capacity = l.pressed_capacity;
  s.pressed = arena.device<int>(l.pressed);
  s.pressed_place = arena.device<int>(l.pressed_place);
  s.pressed_force = arena.device<double>(l.pressed_force);
  s.factor = arena.device<double>(l.factor);
  s.across = arena.device<double>(l.across);
  s.share = arena.device<double>(l.share);
  if (is_adaptive(model.scene)) {
    // about as long as the fastest motion, with a node in contact, lets a series be
    const double turn = quickest(model);
    s.stride = turn > 0 ? 1.0 / turn : model.scene.duration;
    s.level = std::clamp(std::ilogb(s.stride / model.tick), 0, 60);
    s.closed_capacity = l.closed_capacity;
    s.closed = arena.device<int>(l.closed);
    s.closed_hull = arena.device<Hull>(l.closed_hull);
    s.closed_sums = arena.device<NodeSums>(l.closed_sums);
    s.closed_roots = arena.device<double>(l.closed_roots);
    s.roots = arena.device<double>(l.roots);
    s.series = arena.device<double>(l.modal_series);
    s.square_series = arena.device<double>(l.square_series);
    s.push_series = arena.device<double>(l.push_series);
    s.node_series = arena.device<double>(l.node_series);
    s.closed_shape = arena.device<double>(l.closed_shape);
    s.scan_shape = arena.device<double>(l.scan_shape);
    s.scan = arena.device<double>(l.scan);
    s.hull_room = arena.device<double>(l.hull_room);
    s.seen = arena.device<double>(l.seen);
  }
  return s;
}

Batch::Batch(const std::vector<Model>& models, const std::vector<ModalStart>& starts,
             const BatchOptions& options)
    : impl_{std::make_unique<Impl>()} {
  Impl& b = *impl_;
  b.models = models;
  std::vector<Series> series;
  int packs = options.least_packs;
  for (const Model& model : models) {
    const int modes = static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
    if (modes > most_modes)
      throw RequestError(
          fmt::format("{} modes in both bodies together, at the most {} can be marched: lower "
                      "max_frequency or modes",
                      modes, most_modes));
    packs = std::max(packs, std::max(1, (modes + width - 1) / width));
    series.push_back(choose_series(model));
  }
  b.packs = compiled_packs(packs);
  for (std::size_t i = 0; i < models.size(); ++i)
    b.layouts.push_back(b.lay_out(models[i], series[i], options));
  b.arena.allocate();
  b.tables = Kokkos::View<SceneTables*, Space>("ra2d::tables", models.size());
  b.states = Kokkos::View<SceneState*, Space>("ra2d::states", models.size());
  const auto tables_host = Kokkos::create_mirror_view(b.tables);
  const auto states_host = Kokkos::create_mirror_view(b.states);
  for (std::size_t i = 0; i < models.size(); ++i) {
    tables_host(i) = b.fill_tables(models[i], b.layouts[i]);
    states_host(i) = b.fill_state(models[i], starts[i], b.layouts[i]);
  }
  for (int form = 0; form < forms; ++form) {
    std::vector<int> list;
    for (std::size_t i = 0; i < models.size(); ++i)
      if (tables_host(i).form == static_cast<Form>(form)) list.push_back(static_cast<int>(i));
    b.scenes[form] = ScenesView("ra2d::scenes", list.size());
    const auto list_host = Kokkos::create_mirror_view(b.scenes[form]);
    std::copy(list.begin(), list.end(), list_host.data());
    Kokkos::deep_copy(b.scenes[form], list_host);
  }
  b.arena.upload();
  Kokkos::deep_copy(b.tables, tables_host);
  Kokkos::deep_copy(b.states, states_host);
}

Batch::~Batch() = default;
Batch::Batch(Batch&&) noexcept = default;

void Batch::march(std::int64_t target) {
  for (int form = 0; form < forms; ++form)
    if (impl_->scenes[form].extent(0) > 0)
      launch_march(static_cast<Form>(form), impl_->packs, impl_->tables, impl_->states,
                   impl_->scenes[form], target);
  Space{}.fence();
}

std::size_t Batch::bytes() const { return impl_->arena.bytes(); }

Drained Batch::drain(int scene) {
  Impl& b = *impl_;
  const Layout& l = b.layouts[scene];
  SceneState s = b.fetch_state(scene);
  Drained out;
  out.lanes = l.lanes;
  out.samples = s.sample_count;
  const std::size_t row = l.row;
  // a row that still misses its share of the next step stays
  const std::size_t rows = s.sample_count + (s.sample_pending ? 1 : 0);
  b.arena.fetch(l.samples, rows * row * sizeof(double));
  double* samples = b.arena.host<double>(l.samples);
  out.sample_rows.assign(samples, samples + s.sample_count * row);
  b.arena.fetch(l.shocks, s.shock_count * sizeof(ShockRow));
  const auto* shocks = b.arena.host<ShockRow>(l.shocks);
  out.shocks.assign(shocks, shocks + s.shock_count);
  if (s.sample_pending && s.sample_count > 0) {
    const Kokkos::View<double*, Space, Kokkos::MemoryUnmanaged> first(
        b.arena.device<double>(l.samples), row),
        last(b.arena.device<double>(l.samples) + s.sample_count * row, row);
    Kokkos::deep_copy(first, last);
  }
  s.sample_count = s.shock_count = 0;
  b.put_state(scene, s);
  return out;
}

Snapshot Batch::snapshot(int scene) const {
  const Impl& b = *impl_;
  const Layout& l = b.layouts[scene];
  const Model& model = b.models[scene];
  const SceneState s = b.fetch_state(scene);
  b.arena.fetch(l.modal_state, modal_arrays * l.lanes * sizeof(double));
  b.arena.fetch(l.open, s.open_count * sizeof(OpenShock));
  const double* modal = b.arena.host<double>(l.modal_state);
  const std::size_t modes2 = model.resonator.modes.size(), modes1 = model.slider.modes.size();
  const auto take = [&](int array, std::size_t lane, std::size_t count) {
    const double* from = modal + array * l.lanes + lane;
    return std::vector<double>(from, from + count);
  };
  Snapshot out;
  out.status = s.status;
  out.step = s.step;
  out.strides = is_adaptive(model.scene) ? s.strides : s.step;
  out.resonator_u = take(ra2d::u, 0, modes2);
  out.resonator_v = take(ra2d::v, 0, modes2);
  out.slider_u = take(ra2d::u, modes2, modes1);
  out.slider_v = take(ra2d::v, modes2, modes1);
  out.resonator_square = take(ra2d::square, 0, modes2);
  const std::vector<double> part = take(ra2d::square_part, 0, modes2);
  for (std::size_t k = 0; k < modes2; ++k) out.resonator_square[k] += part[k];
  out.contact_steps = s.contact_steps;
  out.most_nodes = s.most_nodes;
  out.evaluated = s.evaluated;
  out.shocks_begun = s.shocks_begun;
  out.energy = s.energy;
  out.energy_limit = s.energy_limit;
  double bend = 0;
  for (const double part : take(ra2d::bend_part, 0, width)) bend += part;
  out.sliding_work = s.sliding_work + model.advance * (s.climb_part + bend);
  out.force_work = s.force_work + s.force_part;
  const auto* open = b.arena.host<OpenShock>(l.open);
  out.open_shocks.assign(open, open + s.open_count);
  return out;
}

}  // namespace ra2d
