// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <utility>

#include "host/device/backend.hpp"
#include "host/errors.hpp"
#include "host/format.hpp"
#include "host/interruption.hpp"
#include "host/plan/plan.hpp"
#include "host/result/energy.hpp"
#include "host/result/level.hpp"
#include "host/run/simulation.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/store.hpp"

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Shapes at every so many nodes, at 1001 places at the most.
ModesHeader make_modes(const Beam& beam, std::size_t nodes, double spacing) {
  constexpr std::size_t most_places = 1001;
  const std::size_t stride =
      std::max<std::size_t>(1, (nodes + most_places - 3) / (most_places - 1));
  ModesHeader header;
  for (std::size_t n = 0; n < nodes; n += stride)
    header.position.push_back(static_cast<double>(n) * spacing);
  for (const ModeShape& mode : beam.modes) {
    header.frequency.push_back(mode.omega / (2 * M_PI));
    for (const double x : header.position) {
      double psi = 0;
      evaluate(mode, beam.length, x, 1, &psi);
      header.shape.push_back(psi);
    }
  }
  header.mean_square = mean_squares(beam, static_cast<int>(nodes), spacing);
  return header;
}

ResultHeader make_header(const Model& model) {
  ResultHeader header;
  header.scene = echo(model.scene);
  header.backend = backend_name();
  header.threads = backend_threads();
  header.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  header.resonator =
      make_modes(model.resonator, model.resonator_height.size(), model.scene.spacing);
  header.slider = make_modes(model.slider, model.slider_height.size(), model.scene.spacing);
  header.probe_position = model.scene.output.probes;
  header.slider_probe_position = model.scene.output.slider_probes;
  header.resonator_height = model.resonator_height;
  header.slider_height = model.slider_height;
  header.spacing = model.scene.spacing;
  return header;
}

/// Which limit the step crossed with the nodes that were in contact, and the cure.
std::string describe_limit(const Model& model, int nodes) {
  const Scene& scene = model.scene;
  if (is_adaptive(scene))
    return ". adaptive has no limit of stability: check the scene for values far from what they "
           "should be";
  const TimeSettings choice = choice_of(scene);
  const JoinedModes place = most_yielding(model);
  StepLimits limits = step_limits(model, choice, place);
  if (scene.contact.law == ContactLaw::penalty)
    limits.contact_one = contact_limit(choice, place, nodes * model.node_stiffness);
  const double holds = limits.holds();
  if (std::isinf(holds))
    return fmt::format(
        ". Limit: none, {} holds at every step: check the scene for values far from "
        "what they should be",
        scheme_text(scene, choice));
  const std::string what = limits.modes_bind()
                               ? fmt::format("free mode at {:.0f} Hz", limits.binding_frequency)
                               : fmt::format("contact spring of {} node{}, the most at once", nodes,
                                             nodes == 1 ? "" : "s");
  std::string text = fmt::format(". Limit: {} holds the {} ", scheme_text(scene, choice), what);
  text += holds == 0 ? std::string("at no step. ")
                     : fmt::format("up to time.step = {} s, and it is {:g} s. ",
                                   rounded_down(holds), scene.time.step);
  if (scene.time.step >= holds)
    text += step_cure(scene, holds);
  else
    text += "The step is within it: check the scene for values far from what they should be";
  return text;
}

std::string describe_failure(const Model& model, const Snapshot& end) {
  const std::string when = fmt::format("t = {:.6g} s (step {})",
                                       static_cast<double>(end.step) * model.tick, end.strides);
  if (end.status == Status::blocked)
    return fmt::format(
        "no motion of the kept modes keeps the faces apart at {}: keep more modes (max_frequency), "
        "use contact.law = \"penalty\", or a larger scene.gap",
        when);
  if (end.status == Status::stalled)
    return fmt::format(
        "at {} the motion is too fast for steps of the clock ({:.2g} s): check the scene for "
        "values "
        "far from what they should be",
        when, model.tick);
  const int nodes = static_cast<int>(std::max<std::int64_t>(1, end.most_nodes));
  return (end.status == Status::not_finite
              ? fmt::format("not finite: at {} the state is no longer a number", when)
              : fmt::format("unstable: by {} the energy had grown to {:.3g} J, over {:.3g} J, ten "
                            "times all that sliding and loads had put in",
                            when, end.energy, end.energy_limit)) +
         describe_limit(model, nodes);
}

/// What the step goes beyond, where the scene forces it; else the request is refused. Empty when it
/// holds.
std::string checked_limit(const Model& model) {
  const Scene& scene = model.scene;
  if (is_adaptive(scene)) return {};
  const TimeSettings choice = choice_of(scene);
  const JoinedModes place = most_yielding(model);
  // the search for its limit takes many times as long as a look at the step that is asked for
  if (choice.scheme == SchemeKind::exact &&
      (scene.contact.law == ContactLaw::multiplier ||
       holds_in_contact(model, choice, place, scene.time.step)))
    return {};
  const StepLimits limits = step_limits(model, choice, place);
  const std::string beyond = beyond_limit(model, limits);
  if (!beyond.empty() && !scene.time.force)
    throw refusal(scene, "time.step",
                  fmt::format("{}. {}, or time.force = true to run it as it is", beyond,
                              step_cure(scene, limits.holds())));
  return beyond;
}

/// Writes what a run records.
class FileSink : public Sink {
 public:
  explicit FileSink(ResultFile& file) : file_{file} {}
  void take(const SampleBlock& samples) override { file_.append(samples); }
  void take(const std::vector<Shock>& shocks) override { file_.append(shocks); }

 private:
  ResultFile& file_;
};

Progress progress_of(const SceneRun& run, double wall) {
  Progress progress;
  progress.time = run.time();
  progress.duration = run.model().scene.duration;
  progress.wall = wall;
  progress.steps_per_second = static_cast<double>(run.steps_made()) / wall;
  const auto step = static_cast<double>(run.accounts().now.step);
  progress.left = wall * (static_cast<double>(run.model().steps) - step) / std::max(1.0, step);
  return progress;
}

/// What a run has come to.
RunReport report_on(const SceneRun& run, const std::vector<double>& mean_squares) {
  const Accounts& a = run.accounts();
  const Snapshot &now = a.now, &begin = a.begin;
  RunReport report;
  if (now.status == Status::running) {
    report.ending = Ending::interrupted;
  } else if (now.status != Status::done) {
    report.ending = Ending::failed;
    report.failure = describe_failure(run.model(), now);
  }
  const auto ticks = static_cast<double>(now.step - begin.step);
  report.steps = run.steps_made();
  report.time = run.time();
  report.counted = ticks * run.model().tick;
  report.v_rms = v_rms(mean_squares, now, begin);
  report.lv = level(report.v_rms);
  // per nothing there is none, also where a shock began at once
  report.shocks = report.counted > 0 ? static_cast<double>(a.durations.total()) / report.counted
                                     : std::numeric_limits<double>::quiet_NaN();
  report.duration_median = a.durations.quantile(0.5);
  report.duration_90 = a.durations.quantile(0.9);
  report.force_median = a.forces.quantile(0.5);
  report.force_90 = a.forces.quantile(0.9);
  report.contact_share = static_cast<double>(now.contact_steps - begin.contact_steps) / ticks;
  report.evaluated = static_cast<double>(now.evaluated) /
                     static_cast<double>(std::max<std::int64_t>(1, report.steps));
  report.energy = a.energy.balance();
  report.march_seconds = a.march_seconds;
  return report;
}

ResultSummary summary_of(const RunReport& report) {
  ResultSummary summary;
  summary.v_rms = report.v_rms;
  summary.lv = report.lv;
  summary.shock_rate = report.shocks;
  summary.shock_duration_median = report.duration_median;
  summary.shock_duration_90 = report.duration_90;
  summary.peak_force_median = report.force_median;
  summary.peak_force_90 = report.force_90;
  summary.contact_share = report.contact_share;
  summary.nodes_evaluated = report.evaluated;
  summary.energy_closure = std::abs(report.energy.relative());
  if (report.energy.samples >= 2) {
    summary.energy_residual = report.energy.residual;
    summary.energy_turnover = report.energy.turnover;
  } else {
    summary.energy_residual = summary.energy_turnover = summary.energy_closure;
  }
  summary.step_seconds = report.step_seconds();
  summary.wall_seconds = report.wall_seconds;
  summary.steps = static_cast<long>(report.steps);
  summary.complete = report.ending == Ending::complete;
  summary.ended = report.ending == Ending::complete      ? "complete"
                  : report.ending == Ending::interrupted ? "interrupted"
                                                         : report.failure;
  return summary;
}

}  // namespace

RunReport run(const Scene& scene, const RunOptions& options) {
  const Clock::time_point begun = Clock::now();
  Model model = make_model(scene);
  if (options.doubts) options.doubts(model.doubts);
  const std::string beyond_limit = checked_limit(model);
  if (const std::string overlap = overlap_at_start(model); !overlap.empty())
    throw refusal(scene, "scene.gap", overlap);
  ModalStart start = make_start(model);
  ResultHeader header = make_header(model);
  header.beyond_limit = beyond_limit;
  ResultFile file(options.output, header);
  const OrderlyEnd orderly;  // before, there is nothing to keep

  FileSink sink(file);
  SceneRun way(std::move(model), std::move(start), {}, &sink);
  const Clock::time_point marching = Clock::now();
  Clock::time_point shown = marching;
  Simulation().run({&way}, [&] {
    if (!options.progress || seconds_since(shown) <= 0.2) return;
    shown = Clock::now();
    options.progress(progress_of(way, seconds_since(marching)));
  });

  RunReport report = report_on(way, header.resonator.mean_square.get());
  report.beyond_limit = beyond_limit;
  report.wall_seconds = seconds_since(begun);
  report.read_back_seconds = file.close(summary_of(report));
  report.wall_seconds = seconds_since(begun);
  return report;
}

}  // namespace ra2d
