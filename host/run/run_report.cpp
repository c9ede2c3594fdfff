// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/plan/plan.hpp"
#include "host/result/level.hpp"
#include "host/run/run_warnings.hpp"
#include "host/run/v_rms.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"
#include "kernels/tables.hpp"

namespace ra2d {
namespace {

/// Which limit the step crossed with the nodes that were in contact, and the cure.
std::string describe_limit(const Model& model, int nodes) {
  const Scene& scene = model.scene;
  if (is_adaptive(scene))
    return ". adaptive has no limit of stability: check the scene for values far from what they "
           "should be";
  const TimeSettings choice = choice_of(scene);
  const JoinedModes place = most_compliant(model);
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
                                       static_cast<double>(end.step) * model.tick, end.steps_made);
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
  if (end.status == Status::crowded)
    return fmt::format(
        "{}: at {} more nodes touch at once than there is memory for{}. Coarser nodes "
        "(scene.spacing{}) or a smaller load need less; or leave it more of the memory (fewer runs "
        "side by side)",
        model.is_areal ? "too many contacts" : "out of memory", when,
        model.is_areal ? fmt::format(", or than the {} that can be followed", most_areal_nodes)
                       : "",
        model.is_areal ? ", scene.spacing_y" : "");
  const int nodes = static_cast<int>(std::max<std::int64_t>(1, end.most_nodes));
  return (end.status == Status::not_finite
              ? fmt::format("not finite: at {} the state is no longer a number", when)
              : fmt::format("unstable: by {} the energy had grown to {:.3g} J, over {:.3g} J, ten "
                            "times all that sliding and loads had put in",
                            when, end.energy, end.energy_limit)) +
         describe_limit(model, nodes);
}

}  // namespace

std::string checked_limit(const Model& model) {
  const Scene& scene = model.scene;
  if (is_adaptive(scene)) return {};
  const TimeSettings choice = choice_of(scene);
  const JoinedModes place = most_compliant(model);
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
  report.displacement_rms = displacement_rms(run.model(), mean_squares, now, begin);
  // per nothing there is none, also where a shock began at once
  report.shock_rate =
      report.counted > 0 ? static_cast<double>(a.durations.total()) / report.counted : quiet_nan;
  report.shock_duration_median = a.durations.quantile(0.5);
  report.shock_duration_90 = a.durations.quantile(0.9);
  report.peak_force_median = a.forces.quantile(0.5);
  report.peak_force_90 = a.forces.quantile(0.9);
  report.contact_share = static_cast<double>(now.contact_steps - begin.contact_steps) / ticks;
  report.nodes_evaluated = static_cast<double>(now.evaluated) /
                           static_cast<double>(std::max<std::int64_t>(1, report.steps));
  report.energy = a.energy.balance();
  report.contact_share_of_energy = a.energy.contact_share_of_energy();
  // on average a mode has as much kinetic as elastic energy
  const BodySpec& resonator = run.model().scene.resonator;
  report.vibration_share_of_energy = resonator.density * resonator.length * resonator.width *
                                     resonator.thickness * report.v_rms * report.v_rms /
                                     report.energy.turnover;
  report.march_seconds = a.march_seconds;
  report.warnings = warnings_of_figures(run.model().scene, report);
  return report;
}

std::string ending_name(Ending ending) {
  return ending == Ending::interrupted   ? "interrupted"
         : ending == Ending::out_of_time ? "stopped by --max-wall"
                                         : "complete";
}

ResultSummary summary_of(const RunReport& report) {
  ResultSummary summary;
  static_cast<NoiseFigures&>(summary) = report;
  summary.energy_closure = report.energy.closure();
  if (report.energy.samples >= 2) {
    summary.energy_residual = report.energy.residual;
    summary.energy_turnover = report.energy.turnover;
  } else {
    summary.energy_residual = summary.energy_turnover = summary.energy_closure;
  }
  summary.lv_low = report.intervals.level.low;
  summary.lv_high = report.intervals.level.high;
  summary.shock_rate_low = report.intervals.shock_rate.low;
  summary.shock_rate_high = report.intervals.shock_rate.high;
  summary.step_seconds = report.step_seconds();
  summary.wall_seconds = report.wall_seconds;
  summary.steps = static_cast<long>(report.steps);
  summary.complete = report.ending == Ending::complete;
  summary.warnings = fmt::format("{}", fmt::join(report.warnings, "\n"));
  summary.ended = report.ending == Ending::failed ? report.failure : ending_name(report.ending);
  return summary;
}

}  // namespace ra2d
