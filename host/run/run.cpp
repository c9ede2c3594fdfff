// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/clock.hpp"
#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/plan/plan.hpp"
#include "host/run/disk_room.hpp"
#include "host/run/result_header.hpp"
#include "host/run/run_files.hpp"
#include "host/run/run_key.hpp"
#include "host/run/run_watch.hpp"
#include "host/run/simulation.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/result_reader.hpp"
#include "host/system/interruption.hpp"

namespace ra2d {
namespace {

/// `first`: the step that this process began with, `wall` seconds ago.
Progress progress_of(const SceneRun& run, std::int64_t first, double wall) {
  Progress progress;
  progress.time = run.time();
  progress.duration = static_cast<double>(run.model().end) * run.model().tick;
  progress.wall = wall;
  progress.steps_per_second =
      static_cast<double>(run.steps_made()) / std::max(1e-9, run.accounts().march_seconds);
  const auto step = static_cast<double>(run.accounts().now.step);
  progress.left = wall * (static_cast<double>(run.model().end) - step) /
                  std::max(1.0, step - static_cast<double>(first));
  return progress;
}

/// The name of a scene: "name = ..." of its text; empty where it has none.
std::string name_in(const std::string& scene) {
  constexpr std::string_view key = "\nname = ";
  const std::size_t at = scene.find(key);
  if (at == scene.npos) return {};
  const std::size_t begin = at + key.size();
  return printable(shortened(scene.substr(begin, scene.find('\n', begin) - begin), 80));
}

/// "a finished run of another scene, "NAME", made TIME: 'speed = 0.1' there, 'speed = 0.2' here"
std::string description(const ResultStamp& there, const Scene& scene) {
  const std::string name = name_in(there.scene), words = first_difference(there.scene, echo(scene));
  const std::string run = there.complete ? "a finished run"
                                         : fmt::format("a run that was cut short ({})",
                                                       printable(shortened(there.ended, 120)));
  return fmt::format(
      "{} of {}{}, made {}{}", run, words.empty() ? "this scene" : "another scene",
      name.empty() ? "" : ", " + name, printable(shortened(there.started)),
      words.empty() ? ", by another version or build of ra2d or with other heights" : ": " + words);
}

/// Whether a result is finished, or would be but for an interrupt. What failed would fail again.
bool is_wanted(const ResultStamp& stamp) {
  return stamp.complete || stamp.ended == ending_name(Ending::interrupted) ||
         stamp.ended == ending_name(Ending::out_of_time);
}

/// How much of a run an output has.
enum class There { nothing, part, all };

/// Finds what the output has of this run. Throws RequestError where something else stands there
/// that must not be lost unasked.
There what_is_there(const std::filesystem::path& output, const std::string& key, const Scene& scene,
                    const RunOptions& options) {
  std::error_code none;
  if (!std::filesystem::exists(output, none) || std::filesystem::file_size(output, none) == 0)
    return There::nothing;
  std::string what;
  bool is_replaced = options.force;
  try {
    const ResultStamp there = read_stamp(output);
    if (there.key == key && !is_segment_name(output))
      return there.complete                        ? There::all
             : is_wanted(there) && there.steps > 0 ? There::part  // with a checkpoint
                                                   : There::nothing;
    what = is_segment_name(output) ? "a segment of a run" : description(there, scene);
    is_replaced = is_replaced || !is_wanted(there);
  } catch (const UnreadableResult& fault) {
    what = "a file that cannot be read as a result: " + fault.reason;
  } catch (const FileError& fault) {
    what = fmt::format("a file that cannot be read as a result: {}", fault.what());
  }
  if (!is_replaced)
    throw RequestError(
        fmt::format("'{}' is there already, {}. It is left as it is: name another file with -o, or "
                    "say --force to replace it",
                    output.string(), what));
  if (options.tell)
    options.tell(fmt::format("'{}' is {}: it will be replaced", output.string(), what));
  return There::nothing;
}

/// One run on its way to its file.
class FiledRun {
 public:
  FiledRun(Model model, ModalStart start, const MeanSquares& mean_squares, RunFiles& files,
           std::optional<Checkpoint> before, const RunOptions& options)
      : options_{options},
        files_{files},
        mean_squares_{mean_squares},
        wall_before_{before ? before->wall_seconds : 0.0},
        watch_{model, files.sink()},
        scene_run_{std::move(model), std::move(start), {}, &watch_} {
    if (!before) return;
    if (before->seen.samples != static_cast<std::uint64_t>(before->accounts.samples))
      throw std::invalid_argument("its intervals and its statistics are from different times");
    watch_.go_on(std::move(before->seen));
    scene_run_.go_on(std::move(before->state), std::move(before->accounts));
  }

  /// Marches the run to its end, or to where it is cut off.
  void march() {
    SimulationOptions launches;
    launches.seconds = launch_seconds(options_.checkpoint, options_.most_wall);
    Simulation simulation(launches);
    simulation.run({&scene_run_}, [&] {
      show_progress();
      if (scene_run_.over()) return;
      if (seconds_since(begun_) >= options_.most_wall) {
        simulation.stop();
        out_of_time_ = true;
      }
      if (take_checkpoint_request() || !simulation.goes_on() ||
          files_.since_checkpoint() >= options_.checkpoint)
        files_.keep(
            scene_run_, simulation.save(scene_run_), wall(), [&] { return summary_of(report()); },
            &watch_);
    });
    memory_ = simulation.memory();
  }

  /// Writes the result; what the run does not go on from any more is removed.
  RunReport finish(const std::string& beyond_limit) {
    RunReport report = this->report();
    report.beyond_limit = beyond_limit;
    watch_.add_to(report, mean_squares_.get());
    if (report.ending == Ending::interrupted && out_of_time_ && interruption() == 0)
      report.ending = Ending::out_of_time;
    report.resumable = files_.has_checkpoint() && report.ending != Ending::complete &&
                       report.ending != Ending::failed;
    report.read_back_seconds = files_.close(summary_of(report));
    report.wall_seconds = wall();
    report.resumable ? files_.remove_after_checkpoint() : files_.remove();
    return report;
  }

 private:
  double wall() const { return wall_before_ + seconds_since(begun_); }
  RunReport report() const {
    RunReport report = report_on(scene_run_, mean_squares_.get());
    report.wall_seconds = wall();
    report.memory = memory_;
    return report;
  }

  void show_progress() {
    if (!options_.progress || seconds_since(shown_) <= 0.2) return;
    shown_ = Clock::now();
    options_.progress(progress_of(scene_run_, first_step_, seconds_since(begun_)));
  }

  const RunOptions& options_;
  RunFiles& files_;
  MeanSquares mean_squares_;
  double wall_before_;  // s, of what it goes on from
  bool out_of_time_ = false;
  RunWatch watch_;
  SceneRun scene_run_;
  std::size_t memory_ = 0;
  std::int64_t first_step_ = scene_run_.accounts().now.step;
  Clock::time_point begun_ = Clock::now(), shown_ = begun_;
};

/// Empty if there is no checkpoint. Throws FileError if every checkpoint is damaged, or that of the
/// part that is `there` is lost; RequestError if it is that of another run.
std::optional<Checkpoint> checkpoint_to_go_on_from(
    RunFiles& files, const Model& model, There there, bool force,
    const std::function<void(const std::string&)>& tell) {
  FoundCheckpoint found = files.find(model, Outputs::kept);
  if (!found.difference.empty() && !force)
    throw RequestError(found.difference +
                       ". It is left as it is: choose another output with -o, or --fresh to start "
                       "anew and have it removed");
  if (!found.difference.empty()) {
    tell(found.difference + ". It is removed");
    files.remove();
    return std::nullopt;
  }
  if (!found.damage.empty() && !found.checkpoint)
    throw FileError(found.damage +
                    ". It is left as it is: --fresh starts the run anew and has it removed");
  if (!found.damage.empty())
    tell(fmt::format("{}. The run goes on from '{}', which is older", found.damage,
                     found.file.string()));
  if (!found.checkpoint && there == There::part)
    throw FileError(fmt::format(
        "'{}' has a part of this run, and its checkpoint '{}' is missing. It is left as it is: put "
        "the checkpoint and '{}' beside it, or --fresh starts the run anew and replaces it",
        files.names().result.string(), files.names().checkpoint.string(),
        files.names().segments.string()));
  return std::move(found.checkpoint);
}

}  // namespace

RunReport run(const Scene& scene, const RunOptions& options) {
  Model model = make_model(scene);
  const std::string beyond_limit = checked_limit(model);
  if (const std::string overlap = overlap_at_start(model); !overlap.empty())
    throw refusal(scene, "scene.gap", overlap);

  const std::string key = run_key(model);
  RunFiles files(options.output, key);
  require_output_names(output_names(options.output), files_of(scene));
  files.claim();
  ResultHeader header = result_header(model, key);
  header.beyond_limit = beyond_limit;
  There there = what_is_there(files.names().result, key, model.scene, options);
  if (options.fresh) there = There::nothing;
  if (there == There::all) {
    files.remove();
    RunReport report;
    report.ending = Ending::there;
    report.doubts = std::move(model.doubts);
    return report;
  }
  if (options.fresh) files.remove();
  const auto tell = [&](const std::string& text) {
    if (options.tell) options.tell(text);
  };
  std::optional<Checkpoint> before =
      checkpoint_to_go_on_from(files, model, there, options.force, tell);
  files.remove_after_checkpoint();
  if (before)
    tell(fmt::format("goes on from t = {:.6g} s, where its last checkpoint is",
                     static_cast<double>(before->accounts.now.step) * model.tick));
  if (options.doubts) options.doubts(model.doubts);
  require_disk_room(model, files.names().result,
                    before ? static_cast<double>(before->accounts.samples) /
                                 static_cast<double>(model.kept_samples())
                           : 0.0);
  ModalStart start = make_start(model);

  const bool goes_on = before.has_value();
  std::vector<std::string> doubts = model.doubts;
  const MeanSquares mean_squares = header.resonator.mean_square;
  try {
    files.record(std::move(header), before);
    FiledRun run(std::move(model), std::move(start), mean_squares, files, std::move(before),
                 options);
    const OrderlyEnd orderly;  // before, there is nothing to keep
    run.march();
    RunReport report = run.finish(beyond_limit);
    report.doubts = std::move(doubts);
    return report;
  } catch (const FileError& fault) {
    // what a failure to write has cost, and what it has not
    throw FileError(fault.what() +
                    std::string(files.can_go_on()
                                    ? ". What was recorded up to the last checkpoint is kept: the "
                                      "same command continues from there"
                                    : ""));
  } catch (const std::invalid_argument& fault) {
    if (!goes_on) throw;
    throw FileError(
        fmt::format("cannot go on from '{}': its state does not fit its scene: {}. It is left as "
                    "it is: --fresh starts the run anew and has it removed",
                    files.names().checkpoint.string(), fault.what()));
  }
}

}  // namespace ra2d
