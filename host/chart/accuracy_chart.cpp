// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/accuracy_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "host/chart/peers.hpp"
#include "host/ensemble/ensemble.hpp"
#include "host/errors.hpp"
#include "host/format.hpp"
#include "host/plan/plan.hpp"
#include "host/result/level.hpp"
#include "host/result/statistics.hpp"
#include "host/run/timed_run.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

constexpr std::size_t shocks_asked[] = {5, 20};

// Shares of the budget; what the peers take comes off before.
constexpr double peer_share = 0.25, reference_share = 0.1, state_share = 0.15, stretch_share = 0.5,
                 long_share = 0.25;

constexpr const char* peer_integrators[] = {"cvode-adams", "cvode-bdf", "dopri5"};
constexpr double peer_tolerances[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
constexpr const char* continuous_force = "continuous";  // where no steps are fixed
constexpr double starting = 5;       // s that a peer may take beside the integration
constexpr double peer_probe = 1e-5;  // s: what every peer is first asked for

/// The time with the fewest digits in the last tenth of what lies between two times.
double round_time_before(double time, double after) {
  const double least = time - 0.1 * (time - after);
  const int first = -static_cast<int>(std::floor(std::log10(time)));
  for (int digits = first; digits < first + 15; ++digits) {
    const double scale = std::pow(10.0, digits), rounded = std::floor(time * scale) / scale;
    if (rounded > least && rounded < time) return rounded;
  }
  return least;
}

bool failed(const TimedRun& run) {
  return run.status != Status::running && run.status != Status::done;
}

Name name_of(const Method& setting) {
  const auto& [time, law] = setting;
  // under multipliers the force is that of the end of the step
  const bool at_end = law == ContactLaw::multiplier || time.contact_force == ForceTime::new_time;
  return {.scheme = schemes.name(time.scheme),
          .law = contact_laws.name(law),
          .contact_force = is_adaptive(time) ? continuous_force
                                             : force_times.name(at_end ? ForceTime::new_time
                                                                       : ForceTime::old_time),
          .nodes = node_choices.name(Nodes::candidates),
          .text = text(setting)};
}

/// Mean and standard error of values; `apart` are their differences from the reference's.
Statistic statistic(const std::vector<double>& values, const std::vector<double>& apart) {
  const auto mean_of = [](const std::vector<double>& x, double& mean, double& error) {
    const double count = static_cast<double>(x.size());
    double sum = 0, square = 0;
    for (const double value : x) sum += value;
    mean = sum / count;
    for (const double value : x) square += (value - mean) * (value - mean);
    error = x.size() > 1 ? std::sqrt(square / (count - 1) / count) : missing;
  };
  Statistic s;
  mean_of(values, s.mean, s.error);
  if (!apart.empty()) mean_of(apart, s.difference, s.difference_error);
  return s;
}

std::array<double, quantities> quantities_of(const Model& model, const TimedRun& run) {
  const Answer answer = answer_of(mean_squares(model), run, model.scene.output.from);
  return {level(answer.v_rms), answer.shock_rate, answer.shock_duration};
}

class Survey {
 public:
  Survey(const Scene& scene, const AccuracyOptions& options)
      : scene_{scene},
        options_{options},
        budget_{options.budget * (options.peers.empty() ? 1.0 : 1.0 - peer_share)} {
    scene_.time.nodes = Nodes::candidates;
    scene_.time.force = false;
    scene_.output.from = 0;  // the stretches are short: all of them counts
    if (!(scene_.time.step > 0))
      scene_.time.step = 1e-8;  // of a scene that leaves it to its scheme
  }

  AccuracyChart run() {
    const auto begun = std::chrono::steady_clock::now();
    list_points();
    find_reference();
    first_stretches();
    compare_states();
    start_peers();
    for (int i = 1; i < options_.repetitions; ++i) repeat(i);
    run_long();
    chart_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    return chart_;
  }

 private:
  /// What is measured of a point, beside the chart's row of it.
  struct Point {
    std::size_t row;
    Model model;
  };
  struct PeerPoint {
    std::size_t row;
    Peer peer;
  };
  /// A setting that states are measured against, and its states.
  struct Reference {
    Method setting;
    std::string text;
    std::vector<std::optional<State>> states;
  };

  void say(const std::string& what) const {
    if (options_.progress) options_.progress(what);
  }
  const ModalStart& start_of(ContactLaw law, const Model& model) {
    const auto found = starts_.find(law);
    return found != starts_.end() ? found->second
                                  : starts_.emplace(law, make_start(model)).first->second;
  }
  TimedRun march(const Scene& scene, const RunLimits& limits = {}) {
    const Model model = make_model(scene);
    return timed_run(model, start_of(scene.contact.law, model), limits);
  }

  void list_points();
  void find_reference();
  void find_instants(const TimedRun& search);
  void first_stretches();
  void compare_states();
  void compare_states(const Method& method, const Reference& reference);
  Reference own_reference(const Method& method);
  PeerRun ask(const Peer& peer, double until, double limit) const;
  void confirm(double limit);
  void start_peers();
  void first_answers(const Peer& peer, double limit);
  void repeat(int repetition);
  void run_long();
  std::vector<Method> long_settings(Method& reference) const;

  Method finest(const Method& method) const {
    if (is_adaptive(method.time))
      return sized(method,
                   0.1 * *std::min_element(options_.tolerances.begin(), options_.tolerances.end()));
    return sized(method, 0.25 * *std::min_element(options_.steps.begin(), options_.steps.end()));
  }
  const Measured* measured(const Method& setting) const {
    for (const Measured& point : chart_.points)
      if (point.setting == setting && point.name.program == "ra2d" && !point.wall.empty())
        return &point;
    return nullptr;
  }
  /// s of march that one comparison of states may take.
  double state_limit() const { return 0.05 * state_share * budget_; }

  Scene scene_;
  AccuracyOptions options_;
  double budget_;  // s, without the peers'
  AccuracyChart chart_;
  std::vector<Method> methods_;
  std::map<ContactLaw, ModalStart> starts_;
  std::vector<Point> points_;
  Reference reference_;
  std::unique_ptr<Peers> peers_;
  std::vector<PeerPoint> peer_points_;
};

void Survey::list_points() {
  say("limits of stability");
  methods_ = methods_of(scene_);
  std::vector<double> steps = options_.steps;
  if (std::none_of(steps.begin(), steps.end(),
                   [&](double step) { return std::abs(step / scene_.time.step - 1) < 0.01; }))
    steps.push_back(scene_.time.step);
  std::sort(steps.begin(), steps.end(), std::greater<>());
  options_.steps = steps;
  std::sort(options_.tolerances.begin(), options_.tolerances.end(), std::greater<>());

  for (const Method& method : methods_) {
    const bool chooses = is_adaptive(method.time);
    std::string hindrance;
    double holds = missing;
    for (const double size : chooses ? options_.tolerances : steps) {
      const Method setting = sized(method, size);
      Measured row{.name = name_of(setting), .setting = setting};
      const Model model = make_model(with(scene_, setting));
      if (hindrance.empty() && method.law == ContactLaw::multiplier) try {
          hindrance = overlap_at_start(model);
          start_of(method.law, model);
        } catch (const RequestError& fault) {
          hindrance = fault.what();
        }
      row.left_out = hindrance;
      if (!chooses && hindrance.empty()) {
        if (std::isnan(holds)) holds = step_limits(model, method.time).holds();
        const StepLimits limits{.modes = holds, .contact_one = holds};
        if (!beyond_limit(model, limits).empty())
          row.left_out = holds > 0 ? fmt::format("beyond its limit of {} s", rounded_down(holds))
                                   : std::string("grows at every step");
      }
      if (row.left_out.empty()) points_.push_back({chart_.points.size(), model});
      chart_.points.push_back(std::move(row));
    }
  }
}

void Survey::find_reference() {
  say("the reference");
  // the one that chooses its own steps, or the one of the highest order
  const Method best =
      *std::max_element(methods_.begin(), methods_.end(), [](const Method& a, const Method& b) {
        const auto rank = [](const Method& method) {
          const SchemeKind scheme = method.time.scheme;
          const int order = is_adaptive(method.time) ? 100 : scheme_table(scheme).order;
          return method.law == ContactLaw::penalty ? order
                 : scheme == SchemeKind::midpoint  ? 0
                                                   : -order;
        };
        return rank(a) < rank(b);
      });
  reference_.setting = finest(best);
  chart_.reference = reference_.text =
      fmt::format("{}, {}", text(best), size_text(reference_.setting));
  Scene searched = with(scene_, reference_.setting);
  searched.output.rate = std::min(searched.output.rate, 1000.0);
  const TimedRun search =
      march(searched, {.wall = reference_share * budget_, .shocks = shocks_asked[1]});
  if (failed(search))
    throw SimulationError(fmt::format("the reference, {}, ended at t = {:g} s: {}",
                                      chart_.reference, search.time, status_text(search.status)));
  find_instants(search);

  Method coarser = reference_.setting;
  coarser.time.step *= 2;
  if (coarser.time.tolerance) *coarser.time.tolerance *= 10;
  chart_.reference_check = size_text(coarser);
  for (const Instant& instant : chart_.instants) {
    const Scene scene = ending_at(scene_, reference_.setting, instant.time);
    const Model model = make_model(scene);
    const TimedRun run = march(scene);
    reference_.states.push_back(run.state);
    chart_.reference_error.push_back(
        state_error(model, march(ending_at(scene_, coarser, instant.time)).state, run.state));
  }
}

/// Before the 5th and before the 20th shock; those that there are not, at the end of the search.
void Survey::find_instants(const TimedRun& search) {
  const bool whole = search.status == Status::done;
  const auto end = [&](std::size_t shocks) {
    const double time = whole ? scene_.duration : round_time_before(search.time, 0.0);
    return Instant{"state-end",
                   fmt::format("the state at {} ({} shock{}{})", seconds_text(time), shocks,
                               shocks == 1 ? "" : "s", whole ? ", the end" : ""),
                   time};
  };
  for (const std::size_t asked : shocks_asked) {
    // those that were there at t = 0 have no time before them
    std::size_t i = asked - 1;
    while (i < search.shocks.size() && search.shocks[i].start == 0) ++i;
    if (i >= search.shocks.size()) {
      chart_.instants.push_back(end(search.shocks.size()));
      break;
    }
    double after = 0;
    for (const Shock& shock : search.shocks)
      if (shock.start < search.shocks[i].start) after = std::max(after, shock.start);
    const double time = round_time_before(search.shocks[i].start, after);
    chart_.instants.push_back(
        {fmt::format("state-{}", asked),
         fmt::format("the state before the {}th shock (t = {} s)", asked, time), time});
  }
}

/// The coarse ones first: what they leave of their share goes to the fine ones.
void Survey::first_stretches() {
  std::stable_sort(points_.begin(), points_.end(), [&](const Point& a, const Point& b) {
    const auto size = [&](const Point& p) {
      const TimeSettings& time = chart_.points[p.row].setting.time;
      return time.tolerance.value_or(time.step);
    };
    return size(a) > size(b);
  });
  double left = stretch_share * budget_;
  std::vector<Point> going;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    say(fmt::format("stretch {} of {}", i + 1, points_.size()));
    Point& point = points_[i];
    Measured& row = chart_.points[point.row];
    const double share = left / static_cast<double>(points_.size() - i) / options_.repetitions;
    const TimedRun run =
        timed_run(point.model, start_of(row.setting.law, point.model), {.wall = share});
    left = std::max(0.0, left - run.seconds * options_.repetitions);
    if (failed(run)) {
      row.left_out = fmt::format("ended at t = {:.3g} s: {}", run.time, status_text(run.status));
      continue;
    }
    row.stretch = run.time;
    row.wall.push_back(run.seconds / run.time);
    // before the shocks that the states are compared at, little has gone through
    if (run.time > 0.99 * chart_.instants.back().time && run.energy.turnover > 0)
      row.closure = std::abs(run.energy.relative());
    going.push_back(std::move(point));
  }
  points_ = std::move(going);
}

Survey::Reference Survey::own_reference(const Method& method) {
  Reference own{finest(method), {}, {}};
  // the finest whose rate is known, where one four times finer would take too long
  const Measured* known = nullptr;
  for (const double step : options_.steps)
    if (const Measured* point = measured(sized(method, step))) known = point;
  if (known == nullptr) return own;
  for (const Instant& instant : chart_.instants) {
    const double expected =
        known->wall.front() * known->setting.time.step / own.setting.time.step * instant.time;
    if (expected > 2 * state_limit()) own.setting = known->setting;
  }
  own.text = fmt::format("its own finest, {}", size_text(own.setting));
  for (const Instant& instant : chart_.instants) {
    const TimedRun run =
        march(ending_at(scene_, own.setting, instant.time), {.wall = 4 * state_limit()});
    own.states.push_back(run.status == Status::done ? std::optional(run.state) : std::nullopt);
  }
  return own;
}

void Survey::compare_states() {
  for (const Method& method : methods_) {
    say(fmt::format("states, {}", text(method)));
    const bool shared = method.law == reference_.setting.law && method.law == ContactLaw::penalty;
    compare_states(method, shared ? reference_ : own_reference(method));
  }
}

void Survey::compare_states(const Method& method, const Reference& reference) {
  for (const Point& point : points_) {
    Measured& row = chart_.points[point.row];
    if (row.name.text != text(method)) continue;
    row.against = reference.text;
    for (std::size_t i = 0; i < chart_.instants.size(); ++i) {
      StateError state;
      const double time = chart_.instants[i].time;
      if (row.setting.time.step >= 2 * time)
        state.note = "the step is longer than the time";
      else if (row.setting == reference.setting)
        state.note = "it is the reference";
      else if (reference.states.size() <= i || !reference.states[i])
        state.note = "no reference";
      else if (std::isnan(chart_.reference_error[i]))
        state.note = "nothing has moved by then";
      else if (const double expected = row.wall.front() * time; expected > state_limit())
        state.note = fmt::format("would take {}", seconds_text(expected));
      if (state.note.empty()) {
        const Scene scene = ending_at(scene_, row.setting, time);
        const TimedRun run = march(scene, {.wall = 4 * state_limit()});
        if (run.status == Status::done) {
          state.error = state_error(point.model, run.state, *reference.states[i]);
          state.step = is_adaptive(scene) ? 0.0 : scene.time.step;
        } else {
          state.note = failed(run) ? status_text(run.status) : "took too long";
        }
      }
      row.states.push_back(state);
    }
  }
}

PeerRun Survey::ask(const Peer& peer, double until, double limit) const {
  PeerRun run = peers_->run(peer, until, limit);
  if (run.failure.empty() && !fits(points_.front().model, run.state))
    run.failure = "its state is not one of this scene";
  return run;
}

/// By the tightest that answers in time.
void Survey::confirm(double limit) {
  std::string failure;
  for (std::size_t t = std::size(peer_tolerances); t-- > 0;) {
    const Peer peer{peer_integrators[0], "candidates", peer_tolerances[t]};
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < chart_.instants.size(); ++i) {
      const PeerRun run = ask(peer, chart_.instants[i].time, limit);
      if (run.failure.empty())
        parts.push_back(fmt::format(
            "{:.1e} ({})", state_error(points_.front().model, run.state, *reference_.states[i]),
            chart_.instants[i].kind));
      else
        failure = run.failure;
    }
    if (parts.empty()) continue;
    chart_.confirmed = fmt::format("{} at tolerance {:g} is apart from it by {}", peer.integrator,
                                   peer.tolerance, fmt::join(parts, ", "));
    return;
  }
  chart_.confirmed = fmt::format("not confirmed: {}", failure);
}

void Survey::start_peers() {
  if (options_.peers.empty() || points_.empty() || reference_.setting.law != ContactLaw::penalty) {
    chart_.confirmed = options_.peers.empty() ? "not confirmed: no peers"
                                              : "not confirmed: the peers know penalty alone";
    return;
  }
  const double share = peer_share * options_.budget;
  Scene scene = with(scene_, Method{});
  peers_ = std::make_unique<Peers>(options_.peers, scene);
  say("the peers confirm the reference");
  confirm(starting + 0.2 * share);
  const double count = std::size(peer_integrators) * 2 * std::size(peer_tolerances);
  // s of one integration; each is asked for the states and, half as long, for every timing
  const double limit = 0.8 * share / count / (1 + 0.5 * options_.repetitions);
  for (const char* integrator : peer_integrators)
    for (const char* nodes : {"candidates", "all"})
      for (const double tolerance : peer_tolerances)
        first_answers({integrator, nodes, tolerance}, limit);
}

/// States, as far as they are to be had in `limit` seconds of integration each, and the first
/// timing, over as much.
void Survey::first_answers(const Peer& peer, double limit) {
  say(fmt::format("{} {:g}, nodes {}", peer.integrator, peer.tolerance, peer.nodes));
  Measured row;
  const bool every = peer.nodes == node_choices.name(Nodes::all);
  row.name = {.program = "ra2d_peers",
              .scheme = peer.integrator,
              .law = contact_laws.name(ContactLaw::penalty),
              .contact_force = continuous_force,
              .nodes = peer.nodes,
              .text = peer.integrator + (every ? ", every node" : "")};
  row.setting.time.tolerance = peer.tolerance;
  row.against = chart_.reference;
  double asked = std::min(peer_probe, chart_.instants.front().time);
  PeerRun run = ask(peer, asked, starting + limit);
  row.left_out = run.failure;
  double rate = run.seconds / asked;
  for (std::size_t i = 0; i < chart_.instants.size() && row.left_out.empty(); ++i) {
    StateError state;
    const double time = chart_.instants[i].time;
    if (rate * time > limit)
      state.note = fmt::format("would take {}", seconds_text(rate * time));
    else if (std::isnan(chart_.reference_error[i]))
      state.note = "nothing has moved by then";
    else
      state.note = (run = ask(peer, time, starting + 2 * limit)).failure;
    if (state.note.empty()) {
      state.error = state_error(points_.front().model, run.state, *reference_.states[i]);
      asked = time;
      rate = run.seconds / time;
    }
    row.states.push_back(state);
  }
  if (row.left_out.empty()) {
    row.stretch = std::clamp(0.5 * limit / rate, asked, scene_.duration);
    run = ask(peer, row.stretch, starting + 2 * limit);
    row.left_out = run.failure;
  }
  if (row.left_out.empty()) {
    row.wall.push_back(run.seconds / row.stretch);
    peer_points_.push_back({chart_.points.size(), peer});
  }
  chart_.points.push_back(std::move(row));
}

void Survey::repeat(int repetition) {
  say(fmt::format("repetition {} of {}", repetition + 1, options_.repetitions));
  for (const Point& point : points_) {
    Measured& row = chart_.points[point.row];
    const TimedRun run =
        timed_run(point.model, start_of(row.setting.law, point.model), {.time = row.stretch});
    row.wall.push_back(run.seconds / run.time);
  }
  for (const PeerPoint& point : peer_points_) {
    Measured& row = chart_.points[point.row];
    const PeerRun run = ask(point.peer, row.stretch, peer_share * options_.budget);
    if (run.failure.empty()) row.wall.push_back(run.seconds / row.stretch);
  }
}

/// What is run for long, of the settings whose rate is known; and which of them the others are
/// compared with.
std::vector<Method> Survey::long_settings(Method& reference) const {
  const auto known = [&](const Method& setting) { return measured(setting) != nullptr; };
  const auto step_near = [&](double wanted) {
    return *std::min_element(options_.steps.begin(), options_.steps.end(), [&](double a, double b) {
      return std::abs(std::log(a / wanted)) < std::abs(std::log(b / wanted));
    });
  };
  const double step = step_near(scene_.time.step);
  const ContactLaw law = methods_.front().law;
  const Method midpoint{{SchemeKind::midpoint}, law}, own{choice_of(scene_), scene_.contact.law},
      euler{{SchemeKind::backward_euler}, ContactLaw::penalty},
      inelastic{{SchemeKind::backward_euler}, ContactLaw::multiplier};
  std::vector<Method> settings;
  const auto add = [&](const Method& setting) {
    if (known(setting) && std::find(settings.begin(), settings.end(), setting) == settings.end())
      settings.push_back(setting);
  };
  for (const Method& method : methods_)
    if (is_adaptive(method.time))
      for (const double tolerance : {1e-8, 1e-6, 1e-4})
        if (std::find(options_.tolerances.begin(), options_.tolerances.end(), tolerance) !=
            options_.tolerances.end())
          add(sized(method, tolerance));
  if (settings.empty()) add(sized(midpoint, step_near(step / 3)));
  if (settings.empty()) add(sized(midpoint, step));
  if (!settings.empty()) reference = settings.front();
  add(sized(own, is_adaptive(scene_) ? scene_.time.tolerance.value_or(0) : step));
  add(sized(euler, step));
  add(sized(midpoint, step));
  for (const double coarse : {step_near(10 * step), step_near(3 * step)})
    if (known(sized(midpoint, coarse))) {
      add(sized(midpoint, coarse));
      break;
    }
  add(sized(inelastic, step));
  return settings;
}

void Survey::run_long() {
  Method reference;
  const std::vector<Method> settings = long_settings(reference);
  if (settings.empty()) {
    chart_.long_notes = "no long run: nothing of the right kind could be measured";
    return;
  }
  const bool random = has_seeds(scene_);
  // surfaces from which every law finds its start
  std::vector<int> seeds;
  std::map<ContactLaw, std::vector<ModalStart>> starts;
  for (int seed = 0; seed < (random ? options_.seeds : 1); ++seed) {
    std::map<ContactLaw, ModalStart> found;
    try {
      for (const Method& setting : settings)
        if (!found.contains(setting.law))
          found[setting.law] = make_start(make_model(variant(with(scene_, setting), seed)));
    } catch (const RequestError&) {
      continue;
    }
    seeds.push_back(seed);
    for (auto& [law, start] : found) starts[law].push_back(std::move(start));
  }
  chart_.seeds = static_cast<int>(seeds.size());
  if (!random) chart_.long_notes = "one run of each: the surfaces have no seeds";
  if (seeds.empty()) {
    chart_.long_notes = "no long run: no surfaces were found to start from";
    return;
  }
  double rates = 0;
  for (const Method& setting : settings) rates += measured(setting)->wall_median();
  chart_.long_time =
      std::min(scene_.duration, long_share * budget_ / rates / static_cast<double>(seeds.size()));

  std::vector<std::array<double, quantities>> of_reference;
  for (const Method& setting : settings) {
    LongRun row{.name = name_of(setting), .setting = setting, .reference = setting == reference};
    say(fmt::format("long runs, {}, {}", row.name.text, size_text(setting)));
    std::vector<Model> models;
    for (const int seed : seeds) models.push_back(make_model(variant(with(scene_, setting), seed)));
    const std::vector<TimedRun> runs =
        timed_runs(models, starts[setting.law], {.time = chart_.long_time});
    std::vector<std::array<double, quantities>> found;
    double marched = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (failed(runs[i])) row.note = status_text(runs[i].status);
      marched += runs[i].time;
      found.push_back(quantities_of(models[i], runs[i]));
    }
    row.wall = runs.front().seconds / marched;
    if (row.note.empty()) {
      if (row.reference) of_reference = found;
      for (std::size_t q = 0; q < quantities; ++q) {
        std::vector<double> values, apart;
        for (std::size_t i = 0; i < found.size(); ++i) {
          values.push_back(found[i][q]);
          if (!row.reference && !of_reference.empty())
            apart.push_back(found[i][q] - of_reference[i][q]);
        }
        row.statistics[q] = statistic(values, apart);
      }
    }
    chart_.long_runs.push_back(std::move(row));
  }
}

}  // namespace

double Measured::wall_median() const { return median(wall); }

AccuracyChart measure_accuracy(const Scene& scene, const AccuracyOptions& options) {
  return Survey(scene, options).run();
}

}  // namespace ra2d
