// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/analysis/analysis_text.hpp"
#include "host/analysis/sound_pressure.hpp"
#include "host/base/clock.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/threads.hpp"
#include "host/device/backend.hpp"
#include "host/result/energy.hpp"
#include "host/run/run.hpp"
#include "host/run/run_json.hpp"
#include "host/run/run_key.hpp"
#include "host/run/run_warnings.hpp"
#include "host/run/zoom.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/result_reader.hpp"
#include "host/system/interruption.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t longest_title = 200;  // bytes

struct RunRequest {
  SceneOptions common;
  std::filesystem::path output;
  bool fresh = false, force = false, json = false;
  double checkpoint = 10;                                      // min between two checkpoints
  double most_wall = std::numeric_limits<double>::infinity();  // s, windows included
  Clock::time_point begun = Clock::now();
  std::vector<std::string> zooms;
  std::optional<double> zoom_rate;  // Hz
};

void show_run_progress(const Progress& p) {
  show(fmt::format("{:5.1f} %  {:.4f} of {:g} s   {:.3g} million steps/s   {} left ",
                   100 * p.time / p.duration, p.time, p.duration, p.steps_per_second * 1e-6,
                   clock_text(p.left)));
}

void print_title(const Scene& scene, const RunReport& r) {
  print("{}: {:g} s {}, {} steps {}\n", printable(shortened(title(scene), longest_title)), r.time,
        scene.speed > 0 ? fmt::format("of sliding at {:g} m/s", scene.speed) : "without sliding",
        r.steps,
        is_adaptive(scene)
            ? fmt::format("to a tolerance of {:g}", scene.time.tolerance.value_or(usual_tolerance))
            : fmt::format("of {:g} s", scene.time.step));
}

void print_level(const Scene& scene, const RunReport& r) {
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
}

void print_shocks(const RunReport& r) {
  if (r.counted > 0)
    print_line("shocks",
               fmt::format("{:.0f} a second{}", r.shock_rate, rate_interval_text(r.intervals)));
  if (!(r.shock_rate > 0)) return;
  print_line("  duration", fmt::format("median {:.3g} us, 90 % up to {:.3g} us",
                                       r.shock_duration_median * 1e6, r.shock_duration_90 * 1e6));
  print_line("  peak force", fmt::format("median {:.3g} N, 90 % up to {:.3g} N",
                                         r.peak_force_median, r.peak_force_90));
}

void print_energy(const EnergyBalance& energy) {
  print_line("energy",
             energy.samples < 2
                 ? std::string("not known: fewer than two samples were counted (output.rate)")
             : energy.is_of_roundings()
                 ? fmt::format("nothing to compare: {:.1e} J went through, which are roundings",
                               energy.turnover)
             : energy.turnover > 0
                 ? fmt::format("balance off by {:.1e} of its largest term ({:.2e} of {:.2e} J)",
                               energy.closure(), energy.residual, energy.turnover)
                 : std::string("none went through"));
}

void print_cost(const RunReport& r) {
  print_line("cost",
             fmt::format("{} a step; {:.2f} s in all, {:.3f} s of them to read the file back",
                         seconds_text(r.step_seconds()), r.wall_seconds, r.read_back_seconds));
  if (const std::string device = backend_device(); !device.empty() && r.memory > 0)
    print_line("device", fmt::format("{}: this scene took {}, there is room for {} of them", device,
                                     bytes_text(r.memory), backend_memory() / r.memory));
}

void print_report(const Scene& scene, const RunReport& r, const std::filesystem::path& output) {
  print_title(scene, r);
  print_level(scene, r);
  print_shocks(r);
  if (!r.beyond_limit.empty()) print_line("beyond limit", r.beyond_limit);
  if (r.counted > 0)
    print_line("in contact", fmt::format("{:.2f} % of the time", 100 * r.contact_share));
  if (r.mesh.stands_out()) print_line("mesh tone", mesh_tone_text(r.mesh));
  print_line("nodes evaluated", fmt::format("{:.4g} a step, on average", r.nodes_evaluated));
  print_energy(r.energy);
  for (const std::string& warning : r.warnings) print_line("warning", warning);
  print_cost(r);
  print_line("file", printable(output.string()));
}

/// Says how a run ended that is not complete; returns the exit status.
int say_run_ending(const SceneOptions& common, const RunReport& report,
                   const std::filesystem::path& output) {
  const std::string kept =
      fmt::format("the results so far are in {}, marked as cut short{}", output.string(),
                  report.resumable ? ". The same command continues from here" : "");
  switch (report.ending) {
    case Ending::failed:
      say(fmt::format("{}: {}. What was computed until then is in {}, marked as cut short",
                      common.scene.string(), report.failure, output.string()));
      return exit_status::failed;
    case Ending::interrupted:
      say(fmt::format("interrupted at t = {:g} s: {}", report.time, kept));
      return exit_status::interrupted + interruption();
    case Ending::out_of_time:
      say(fmt::format("stopped by --max-wall at t = {:g} s: {}", report.time, kept));
      return exit_status::out_of_time;
    default:
      return exit_status::done;
  }
}

void print_zoom(std::size_t number, const ZoomWindow& window, double rate,
                const std::filesystem::path& output) {
  const std::string shock =
      window.shock
          ? fmt::format("shock {}: {:.3g} N, {:.3g} us, from {:.6f} s on; ", window.shock->serial,
                        window.shock->peak_force, window.shock->duration * 1e6, window.shock->start)
          : "";
  print_line(fmt::format("zoom {}", number).c_str(),
             fmt::format("{}{:.6f} to {:.6f} s at {:g} MHz in {}", shock, window.begin, window.end,
                         rate * 1e-6, printable(output.string())));
}

struct ZoomsRun {
  int status = exit_status::done;
  bool resumable = false;                    // one was cut short and goes on from a checkpoint
  std::vector<std::filesystem::path> files;  // that are complete
};

/// Runs windows to `zooms` until one of them is not complete. Throws RequestError, FileError.
void run_windows(const RunRequest& request, const Scene& scene, const ZoomRequest& zoom,
                 RunOptions options, ZoomsRun& zooms) {
  const std::filesystem::path output = options.output;
  const std::vector<ZoomWindow> windows =
      zoom_windows(scene, zoom, ResultReader(output).contents().shocks);
  const std::size_t strongest = windows.size() - zoom.shocks.size() - zoom.windows.size();
  if (strongest < zoom.strongest && !request.common.quiet)
    say(fmt::format("--zoom strongest={}: all shocks have room in {} window{}", zoom.strongest,
                    strongest, strongest == 1 ? "" : "s"));
  for (std::size_t i = 0; i < windows.size(); ++i) {
    options.output = zoom_name(output, i + 1);
    require_output(options.output, files_of(scene));
    options.doubts = {};  // they have been printed
    options.most_wall = std::max(1e-3, request.most_wall - seconds_since(request.begun));
    const Scene zoom_scene = zoomed(scene, windows[i], zoom.rate);
    const RunReport report = run(zoom_scene, options);
    if (options.progress) show({});
    if (report.ending != Ending::there && report.ending != Ending::complete) {
      zooms.status = say_run_ending(request.common, report, options.output);
      zooms.resumable = report.resumable;
      return;
    }
    zooms.files.push_back(options.output);
    if (!request.common.quiet && !request.json)
      print_zoom(i + 1, windows[i], zoom_scene.output.rate, options.output);
  }
}

/// Runs the windows that were requested, each to a file of its own beside that of the whole run.
/// Faults are said: the whole run is there all the same, and has its JSON. Names windows that are
/// left of another run.
ZoomsRun run_zooms(const RunRequest& request, const Scene& scene, const ZoomRequest& zoom,
                   const RunOptions& options) {
  ZoomsRun zooms;
  if (!zoom.is_empty()) try {
      run_windows(request, scene, zoom, options, zooms);
    } catch (const RequestError& fault) {
      say(fault.what());
      zooms.status = exit_status::wrong_request;
    } catch (const FileError& fault) {
      say(fault.what());
      zooms.status = exit_status::wrong_file;
    } catch (const std::filesystem::filesystem_error& fault) {
      say(fault_text(fault));
      zooms.status = exit_status::wrong_file;
    }
  if (request.common.quiet) return zooms;
  const auto others = windows_of_other_runs(scene, options.output, zooms.files);
  if (others.empty()) return zooms;
  std::vector<std::string> names;
  for (const std::filesystem::path& file : others)
    names.push_back(fmt::format("'{}'", file.string()));
  say(
      fmt::format("windows of another run stand beside '{}': {}. Remove them, or have --zoom with "
                  "--force replace them",
                  options.output.string(), fmt::join(names, ", ")));
  return zooms;
}

/// Whether the scene of a result has other microphones or other air. Its motion is the same.
bool has_other_sound(const Scene& scene, const std::filesystem::path& result) try {
  const Scene there = parse_echo(read_stamp(result).scene, result);
  return sound_settings(there) != sound_settings(scene);
} catch (const RequestError&) {  // a scene that another program wrote
  return false;
}

/// The last lines of a report: the levels at the scene's microphones.
SceneSound print_sound(const Scene& scene, const std::filesystem::path& output, bool shown) {
  if (scene.output.microphones.empty()) return {};
  SceneSound sound = sound_of_scene(scene, output);
  if (!shown) return sound;
  for (std::size_t i = 0; i < sound.microphones.size(); ++i) {
    const MicrophoneLevels& m = sound.microphones[i];
    print_line(fmt::format("microphone {}", i + 1).c_str(),
               level_text(m) + interval_text(m.intervals));
    if (const std::string warning = warning_of(m); !warning.empty()) print_line("warning", warning);
  }
  if (!sound.why_none.empty()) print_line("microphones", "none: " + printable(sound.why_none));
  return sound;
}

int run_scene(RunRequest& request) {
  const CheckpointKeeper keeper;  // from here on SIGUSR1 ends nothing
  const SceneOptions& common = request.common;
  const Scene scene = read_scene(common.scene, common.overrides);
  // a window of --zoom may lie before output.from
  if (const auto& window = scene.output.window; !window.empty() && scene.output.from >= window[1])
    throw refusal(scene, "output.from",
                  fmt::format("{} s is not before the end of output.window, {} s, where the run "
                              "ends: expected less, or drop one of them",
                              scene.output.from, window[1]));
  std::filesystem::path& output = request.output;
  if (output.empty()) output = common.scene.stem().string() + ".h5";
  require_output(output, files_of(scene));

  RunOptions options;
  options.output = output;
  options.fresh = request.fresh;
  options.force = request.force;
  options.checkpoint = 60 * request.checkpoint;
  options.most_wall = request.most_wall;
  if (!common.quiet) options.tell = [](const std::string& text) { say(text); };
  options.doubts = [&](const std::vector<std::string>& doubts) {
    say_doubts(doubts, common.quiet);
  };
  if (shows_progress(common.quiet)) options.progress = show_run_progress;

  ZoomRequest zoom = zoom_request(request.zooms, request.zoom_rate);
  if (!zoom.is_empty()) {
    require_zoom(scene, zoom, output);
    require_output(zoom_name(output, 1), files_of(scene));
  }

  const Backend backend(common.threads, common.device);
  RunReport report = run(scene, options);
  if (options.progress) show({});
  if (report.ending == Ending::there) {
    if (!request.json && !common.quiet)
      print("{} has this run already, complete: nothing to do (--fresh runs it again)\n",
            printable(output.string()));
    if (!common.quiet && has_other_sound(scene, output))
      say(
          fmt::format("'{}' keeps the microphones and the air that it was made with, and analyze, "
                      "report and sound take those. --fresh makes it with the scene's",
                      output.string()));
    const SceneSound sound = print_sound(scene, output, !request.json && !common.quiet);
    const ZoomsRun zooms = run_zooms(request, scene, zoom, options);
    if (request.json) {
      RunReport there = report_of_file(scene, output);
      there.resumable = zooms.resumable;
      there.doubts = report.doubts;
      print_text(run_json(scene, there, output, zooms.status, zooms.files, sound));
    }
    return zooms.status;
  }
  if (!common.quiet && !request.json) print_report(scene, report, output);
  const SceneSound sound = print_sound(scene, output, !common.quiet && !request.json);
  if (request.json) say_doubts(warnings_of(report, sound), common.quiet);
  if (report.ending != Ending::complete) zoom = {};
  const ZoomsRun zooms = run_zooms(request, scene, zoom, options);
  const int status =
      zooms.status == exit_status::done ? say_run_ending(common, report, output) : zooms.status;
  report.resumable = report.resumable || zooms.resumable;
  if (request.json) print_text(run_json(scene, report, output, status, zooms.files, sound));
  return status;
}

}  // namespace

void add_run(CLI::App& app, ChosenCommand& chosen) {
  const auto request = std::make_shared<RunRequest>();
  CLI::App* command = app.add_subcommand("run", "simulates a scene and writes one HDF5 file");
  add_scene(*command, request->common, scene_words)->required();
  add_scene_options(*command, request->common);
  command->get_option("--quiet")->description("print nothing but errors");
  command
      ->add_option("-o,--output", request->output,
                   "result file [SCENE's name with .h5, in the current folder]")
      ->type_name("OUT.h5")
      ->check(path());
  command->add_flag(
      "--fresh", request->fresh,
      "start anew: ignore the checkpoint, and run again if the result of this same run is there");
  command->add_flag("--force", request->force,
                    "replace any file that is there, also the result of another run (of this one: "
                    "--fresh)");
  add_checkpoints(*command, request->checkpoint, request->most_wall);
  CLI::Option* zoom = command->add_option(
      "--zoom", request->zooms,
      "also sample a window at 1 MHz, to OUT.zoom-1.h5: strongest=N for those around "
      "the N strongest shocks, shock=NUMBER, or BEGIN,END (s); may be repeated");
  zoom->type_name("WINDOW");
  one_value_each_time(*zoom);
  command
      ->add_option("--zoom-rate", request->zoom_rate,
                   "samples a second in such windows, up to 1e7 [1e6]")
      ->type_name("HZ")
      ->check(positive_number());
  command->add_flag("--json", request->json,
                    "prints the outcome as one JSON object, also where the run was cut short");
  command->callback([request, &chosen] {
    chosen.takes_checkpoints = true;
    chosen.run = [request] {
      limit_threads(request->common.threads, request->common.quiet);
      return run_scene(*request);
    };
  });
}

}  // namespace ra2d
