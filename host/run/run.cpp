// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

#include "host/errors.hpp"
#include "host/format.hpp"
#include "host/interruption.hpp"
#include "host/plan/plan.hpp"
#include "host/result/energy.hpp"
#include "host/result/level.hpp"
#include "host/result/statistics.hpp"
#include "host/run/launch_length.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/store.hpp"
#include "kernels/limits.hpp"

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

/// Whether all that a file is given are numbers.
bool is_finite(const SampleBlock& block) {
  for (const auto column :
       {&SampleBlock::resonator_displacement, &SampleBlock::resonator_velocity,
        &SampleBlock::slider_displacement, &SampleBlock::slider_velocity, &SampleBlock::force,
        &SampleBlock::probe_displacement, &SampleBlock::probe_velocity,
        &SampleBlock::slider_probe_displacement, &SampleBlock::slider_probe_velocity,
        &SampleBlock::kinetic, &SampleBlock::elastic, &SampleBlock::contact,
        &SampleBlock::damping_loss, &SampleBlock::sliding_work, &SampleBlock::load_work})
    for (const double value : block.*column)
      if (!std::isfinite(value)) return false;
  return true;
}
bool is_finite(const std::vector<Shock>& shocks) {
  return std::all_of(shocks.begin(), shocks.end(), [](const Shock& shock) {
    return std::isfinite(shock.peak_force) && std::isfinite(shock.impulse) &&
           std::isfinite(shock.position);
  });
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
  const OrderlyEnd orderly;  // before, there is nothing to keep

  EnergyAccount energy(scene.output.from);
  LogHistogram durations, forces;
  const std::int64_t first = first_counted(model);
  std::int64_t samples = 0;
  LaunchLength launch(model);
  Snapshot now = batch.snapshot(0), begin = now;  // `begin`: where statistics do
  const auto keep = [&](const std::vector<Shock>& shocks) {
    for (const Shock& shock : shocks) {
      if (shock.start < scene.output.from) continue;
      durations.add(shock.duration);
      forces.add(shock.peak_force);
    }
    file.append(shocks);
  };
  Clock::time_point shown = Clock::now();
  const Clock::time_point marching = shown;
  while (now.status == Status::running) {
    if (interruption() != 0) {
      report.ending = Ending::interrupted;
      break;
    }
    const Clock::time_point launched = Clock::now();
    const std::int64_t target = now.step + launch.steps();
    batch.march(now.step < first ? std::min(target, first) : target);
    const double took = seconds_since(launched);
    report.march_seconds += took;
    const Drained drained = batch.drain(0);
    const std::int64_t before = now.step;
    now = batch.snapshot(0);
    if (before < first) begin = now;
    launch.took(now.step - before, took);

    const SampleBlock block = make_samples(model, start, drained, samples);
    const std::vector<Shock> shocks = make_shocks(model, drained.shocks);
    samples += drained.samples;
    energy.add(block);
    file.append(block);
    keep(shocks);
    if (!is_finite(block) || !is_finite(shocks)) {
      now.status = Status::not_finite;
      break;
    }

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
  const std::vector<Shock> going_on = make_shocks(model, now.open_shocks);
  keep(going_on);
  if (!is_finite(going_on)) now.status = Status::not_finite;
  if (now.status != Status::running && now.status != Status::done) {
    report.ending = Ending::failed;
    report.failure = describe_failure(model, now);
  }

  const double counted = static_cast<double>(now.step - begin.step) * model.tick;  // s
  report.steps = steps_made(model, now);
  report.time = time_of(model, now);
  report.counted = counted;
  report.v_rms = v_rms(header.resonator.mean_square, now, begin);
  report.lv = level(report.v_rms);
  // per nothing there is none, also where a shock began at once
  report.shocks = counted > 0 ? static_cast<double>(durations.total()) / counted
                              : std::numeric_limits<double>::quiet_NaN();
  report.duration_median = durations.quantile(0.5);
  report.duration_90 = durations.quantile(0.9);
  report.force_median = forces.quantile(0.5);
  report.force_90 = forces.quantile(0.9);
  report.contact_share = static_cast<double>(now.contact_steps - begin.contact_steps) /
                         static_cast<double>(now.step - begin.step);
  report.evaluated = static_cast<double>(now.evaluated) /
                     static_cast<double>(std::max<std::int64_t>(1, report.steps));
  report.energy = energy.balance();
  report.wall_seconds = seconds_since(begun);

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
  file.close(summary);
  report.wall_seconds = seconds_since(begun);
  return report;
}

}  // namespace ra2d
