// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "host/analysis/analysis_text.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/print.hpp"
#include "host/device/backend.hpp"
#include "host/result/energy.hpp"
#include "host/run/run.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/interruption.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t longest_title = 200;  // bytes

std::string clock_text(double seconds) {
  if (!(seconds < 360000)) return "long";
  const int s = static_cast<int>(std::ceil(seconds));
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

void show_progress(const Progress& p) {
  show(fmt::format("{:5.1f} %  {:.4f} of {:g} s   {:.3g} million steps/s   {} left ",
                   100 * p.time / p.duration, p.time, p.duration, p.steps_per_second * 1e-6,
                   clock_text(p.left)));
}

void print_line(const char* what, const std::string& value) { print("  {:<17}{}\n", what, value); }

constexpr double much_energy = 0.05;  // of what went through

/// Why a balance is as far off as it is.
std::string energy_text(const Scene& scene, const EnergyBalance& energy) {
  const std::string far =
      fmt::format("{:.0f} % of the energy is unaccounted for: ", 100 * std::abs(energy.relative()));
  if (scene.contact.law == ContactLaw::multiplier && energy.residual < 0)
    return far + "under multipliers each impact takes some, and is meant to";
  if (is_adaptive(scene)) return far + "a smaller time.tolerance is needed";
  return far + fmt::format("steps of {:g} s are too long here; try a tenth, or another time.scheme",
                           scene.time.step);
}

void print_report(const Scene& scene, const RunReport& r, const std::filesystem::path& output) {
  print("{}: {:g} s of sliding at {:g} m/s, {} steps {}\n",
        printable(shortened(title(scene), longest_title)), r.time, scene.speed, r.steps,
        is_adaptive(scene)
            ? fmt::format("to a tolerance of {:g}", scene.time.tolerance.value_or(usual_tolerance))
            : fmt::format("of {:g} s", scene.time.step));
  if (!(r.counted > 0))
    print_line("level Lv", scene.output.from > 0 ? "none: the run ended before output.from"
                                                 : "none: the run ended at its first step");
  else if (r.v_rms > 0)
    print_line(
        "level Lv",
        fmt::format("{:.2f} dB re 1 nm/s (v_rms {:.3e} m/s){}{}", r.lv, r.v_rms,
                    scene.output.from > 0 ? fmt::format(", from {:g} s on", scene.output.from) : "",
                    interval_text(r.intervals)));
  else
    print_line("level Lv", "-inf dB: the resonator did not vibrate");
  if (r.counted > 0)
    print_line("shocks",
               fmt::format("{:.0f} a second{}", r.shocks, rate_interval_text(r.intervals)));
  if (r.shocks > 0) {
    print_line("  duration", fmt::format("median {:.3g} us, 90 % up to {:.3g} us",
                                         r.duration_median * 1e6, r.duration_90 * 1e6));
    print_line("  peak force",
               fmt::format("median {:.3g} N, 90 % up to {:.3g} N", r.force_median, r.force_90));
  }
  if (!r.beyond_limit.empty()) print_line("beyond limit", r.beyond_limit);
  if (r.counted > 0)
    print_line("in contact", fmt::format("{:.2f} % of the time", 100 * r.contact_share));
  if (r.mesh.stands_out()) print_line("mesh's tone", mesh_tone_text(r.mesh));
  print_line("nodes evaluated", fmt::format("{:.2f} a step, on average", r.evaluated));
  print_line("energy",
             r.energy.samples < 2
                 ? std::string("not known: fewer than two samples were counted (output.rate)")
             : r.energy.turnover > 0
                 ? fmt::format("closes to {:.1e} of what went through ({:.2e} of {:.2e} J)",
                               std::abs(r.energy.relative()), r.energy.residual, r.energy.turnover)
                 : std::string("none went through"));
  if (std::abs(r.energy.relative()) > much_energy)
    print_line("warning", energy_text(scene, r.energy));
  print_line(
      "cost",
      fmt::format("{:.1f} ns a step; {:.2f} s in all, {:.3f} s of them to read the file back",
                  r.step_seconds() * 1e9, r.wall_seconds, r.read_back_seconds));
  if (const std::string device = backend_device(); !device.empty() && r.memory > 0)
    print_line("device", fmt::format("{}: this scene took {}, there is room for {} of them", device,
                                     bytes_text(r.memory), backend_memory() / r.memory));
  print_line("file", printable(output.string()));
}

std::string going_on(const RunReport& report) {
  return report.resumable ? ". The same line goes on from here" : "";
}

}  // namespace

int run_command(const CommonOptions& common, RunChoices choices) {
  const CheckpointKeeper keeper;  // from here on SIGUSR1 ends nothing
  const Scene scene = read_scene(common.scene, common.overrides);
  std::filesystem::path& output = choices.output;
  if (output.empty()) output = common.scene.stem().string() + ".h5";
  require_output(output, files_of(scene));

  RunOptions options;
  options.output = output;
  options.fresh = choices.fresh;
  options.force = choices.force;
  options.checkpoint = 60 * choices.checkpoint;
  options.most_wall = choices.most_wall;
  if (!common.quiet) options.tell = [&](const std::string& text) { say(text); };
  options.doubts = [&](const std::vector<std::string>& doubts) {
    say_doubts(doubts, common.quiet);
  };
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal && !common.quiet) options.progress = show_progress;

  const Backend backend(common.threads, common.device);
  const RunReport report = run(scene, options);
  if (options.progress) show({});
  if (report.ending == Ending::there) {
    if (!common.quiet)
      print("{} has this run already, complete: nothing to do (--fresh runs it again)\n",
            printable(output.string()));
    return done;
  }
  if (!common.quiet) print_report(scene, report, output);
  if (report.ending == Ending::failed) {
    say(fmt::format("{}: {}. What was computed until then is in {}, marked as cut short",
                    common.scene.string(), report.failure, output.string()));
    return failed;
  }
  if (report.ending == Ending::interrupted) {
    say(fmt::format(
        "interrupted at t = {:g} s: the results so far are in {}, marked as cut short{}",
        report.time, output.string(), going_on(report)));
    return interrupted + interruption();
  }
  if (report.ending == Ending::out_of_time) {
    say(fmt::format(
        "stopped by --max-wall at t = {:g} s: the results so far are in {}, marked as cut "
        "short{}",
        report.time, output.string(), going_on(report)));
    return out_of_time;
  }
  return done;
}

}  // namespace ra2d
