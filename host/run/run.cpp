// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "host/errors.hpp"
#include "host/format.hpp"
#include "host/plan/plan.hpp"
#include "host/plan/schemes.hpp"
#include "host/run/launch_length.hpp"
#include "host/run/statistics.hpp"
#include "host/store/store.hpp"

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

ResultHeader make_header(const Model& model) {
  ResultHeader header;
  header.scene = echo(model.scene);
  header.backend = backend_name();
  header.threads = backend_threads();
  header.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  for (const ModeShape& mode : model.resonator.modes)
    header.resonator_frequency.push_back(mode.omega / (2 * M_PI));
  for (const ModeShape& mode : model.slider.modes)
    header.slider_frequency.push_back(mode.omega / (2 * M_PI));
  header.probe_position = model.scene.probes;
  header.resonator_height = model.resonator_height;
  header.slider_height = model.slider_height;
  header.spacing = model.scene.spacing;
  return header;
}

double time_of(const Model& model, const Snapshot& at) {
  return static_cast<double>(at.step) * model.tick;
}

std::int64_t steps_made(const Model& model, const Snapshot& at) {
  return is_adaptive(model.scene) ? at.strides : at.step;
}

/// Which limit the step crossed with the nodes that were in contact, and the cure.
std::string describe_limit(const Model& model, int nodes) {
  const Scene& scene = model.scene;
  if (is_adaptive(scene))
    return ". adaptive has no limit of stability: check the scene for values far from what they "
           "should be";
  const SchemeChoice choice = choice_of(scene);
  const JoinedModes place = most_yielding(model);
  StepLimits limits = step_limits(model, choice, place);
  if (scene.law == ContactLaw::penalty)
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
                                   rounded_down(holds), scene.step);
  if (scene.step >= holds)
    text += step_cure(scene, holds);
  else
    text += "The step is within it: check the scene for values far from what they should be";
  return text;
}

std::string describe_failure(const Model& model, const Snapshot& end) {
  const double time = time_of(model, end);
  const std::string when = fmt::format("t = {:.6g} s (step {})", time, steps_made(model, end));
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
  if (end.status == Status::crowded && is_adaptive(model.scene))
    return fmt::format(
        "more nodes than there is room for ({}) touch at once with time.scheme = \"adaptive\", at "
        "{}: use a fixed step (time.scheme = \"midpoint\" with time.step) or a wider scene.spacing",
        most_sprung_nodes, when);
  if (end.status == Status::crowded)
    return fmt::format(
        "more nodes than there is room for ({}) carry force at once with time.contact_force = "
        "\"new\", at {}: use time.contact_force = \"old\", contact.law = \"multiplier\" or a wider "
        "scene.spacing",
        most_sprung_nodes, when);
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
  const SchemeChoice choice = choice_of(scene);
  const JoinedModes place = most_yielding(model);
  // the search for its limit takes many times as long as a look at the step that is asked for
  if (choice.scheme == SchemeKind::exact &&
      (scene.law == ContactLaw::multiplier || holds_in_contact(model, choice, place, scene.step)))
    return {};
  const StepLimits limits = step_limits(model, choice, place);
  const std::string beyond = beyond_limit(model, limits);
  if (!beyond.empty() && !scene.force)
    throw refusal(scene, "time.step",
                  fmt::format("{}. {}, or time.force = true to run it as it is", beyond,
                              step_cure(scene, limits.holds())));
  return beyond;
}

}  // namespace

RunReport run(const Scene& scene, const RunOptions& options) {
  const Clock::time_point begun = Clock::now();
  const Model model = make_model(scene);
  if (options.doubts) options.doubts(model.doubts);
  RunReport report;
  report.beyond_limit = checked_limit(model);
  if (const std::string overlap = overlap_at_start(model); !overlap.empty())
    throw refusal(scene, "scene.gap", overlap);
  const ModalStart start = make_start(model);
  Batch batch({model}, {start});
  ResultHeader header = make_header(model);
  header.beyond_limit = report.beyond_limit;
  ResultFile file(options.output, header);

  EnergyAccount energy;
  LogHistogram durations, forces;
  std::int64_t samples = 0;
  LaunchLength launch(model);
  Snapshot now = batch.snapshot(0);
  const auto keep = [&](const std::vector<Shock>& shocks) {
    for (const Shock& shock : shocks) {
      durations.add(shock.duration);
      forces.add(shock.peak_force);
    }
    file.append(shocks);
  };
  Clock::time_point shown = Clock::now();
  const Clock::time_point marching = shown;
  while (now.status == Status::running) {
    if (options.interrupted && *options.interrupted) {
      report.ending = Ending::interrupted;
      break;
    }
    const Clock::time_point launched = Clock::now();
    batch.march(now.step + launch.steps());
    const double took = seconds_since(launched);
    report.march_seconds += took;
    const Drained drained = batch.drain(0);
    const std::int64_t before = now.step;
    now = batch.snapshot(0);
    launch.took(now.step - before, took);

    const SampleBlock block = make_samples(model, start, drained, samples);
    samples += drained.samples;
    energy.add(block);
    file.append(block);
    keep(make_shocks(model, drained.shocks));

    if (options.progress && seconds_since(shown) > 0.2) {
      shown = Clock::now();
      Progress progress;
      progress.time = time_of(model, now);
      progress.duration = scene.duration;
      progress.wall = seconds_since(marching);
      progress.steps_per_second = static_cast<double>(steps_made(model, now)) / progress.wall;
      progress.left = progress.wall * static_cast<double>(model.steps - now.step) /
                      static_cast<double>(std::max<std::int64_t>(1, now.step));
      options.progress(progress);
    }
  }
  keep(make_shocks(model, now.open_shocks));
  if (now.status != Status::running && now.status != Status::done) {
    report.ending = Ending::failed;
    report.failure = describe_failure(model, now);
  }

  const double ticks = static_cast<double>(std::max<std::int64_t>(1, now.step));
  report.steps = steps_made(model, now);
  report.time = time_of(model, now);
  report.v_rms = v_rms(model, now);
  report.lv = level(report.v_rms);
  report.shocks = now.step > 0 ? static_cast<double>(durations.total()) / report.time : 0.0;
  report.duration_median = durations.quantile(0.5);
  report.duration_90 = durations.quantile(0.9);
  report.force_median = forces.quantile(0.5);
  report.force_90 = forces.quantile(0.9);
  report.contact_share = static_cast<double>(now.contact_steps) / ticks;
  report.evaluated = static_cast<double>(now.evaluated) /
                     static_cast<double>(std::max<std::int64_t>(1, report.steps));
  report.energy = energy.balance();
  report.wall_seconds = seconds_since(begun);

  ResultSummary summary;
  summary.v_rms = report.v_rms;
  summary.lv = report.lv;
  summary.wall_seconds = report.wall_seconds;
  summary.steps = static_cast<long>(report.steps);
  summary.complete = report.ending == Ending::complete;
  summary.ended = report.ending == Ending::complete      ? "complete"
                  : report.ending == Ending::interrupted ? "interrupted"
                                                         : report.failure;
  file.close(summary);
  report.wall_seconds = seconds_since(begun);
  return report;
}

}  // namespace ra2d
