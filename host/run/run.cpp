// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "host/errors.hpp"
#include "host/interruption.hpp"
#include "host/plan/plan.hpp"
#include "host/run/checkpoint.hpp"
#include "host/run/file_sink.hpp"
#include "host/run/result_header.hpp"
#include "host/run/run_key.hpp"
#include "host/run/simulation.hpp"
#include "host/store/beside.hpp"
#include "host/store/recording.hpp"
#include "host/store/result_reader.hpp"

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// `first`: the step that this process began with, `wall` seconds ago.
Progress progress_of(const SceneRun& run, std::int64_t first, double wall) {
  Progress progress;
  progress.time = run.time();
  progress.duration = run.model().scene.duration;
  progress.wall = wall;
  progress.steps_per_second =
      static_cast<double>(run.steps_made()) / std::max(1e-9, run.accounts().march_seconds);
  const auto step = static_cast<double>(run.accounts().now.step);
  progress.left = wall * (static_cast<double>(run.model().steps) - step) /
                  std::max(1.0, step - static_cast<double>(first));
  return progress;
}

/// Where in a run a segment begins that follows this moment.
SegmentStart start_after(const Snapshot& now) {
  SegmentStart start;
  for (const OpenShock& open : now.open_shocks) start.open_shocks.push_back(open.serial);
  std::sort(start.open_shocks.begin(), start.open_shocks.end());
  start.shocks_begun = now.shocks_begun;
  return start;
}

/// Whether the output has this run already, complete; what of another run will be replaced is told.
bool is_there(const std::filesystem::path& output, const std::string& key,
              const RunOptions& options) {
  const std::optional<ResultStamp> there = stamp_of(output);
  if (!there || !there->complete) return false;
  if (there->key == key) return true;
  if (options.tell)
    options.tell(
        fmt::format("'{}' has a run of another scene or version, made {}: it will be replaced",
                    output.string(), there->started));
  return false;
}

/// One run on its way to its file.
class FiledRun {
 public:
  FiledRun(Model model, ModalStart start, ResultHeader header, Identity identity,
           const ClaimedOutput& output, std::optional<Checkpoint> before, const RunOptions& options)
      : options_{options},
        output_{output},
        identity_{std::move(identity)},
        mean_squares_{header.resonator.mean_square},
        wall_before_{before ? before->wall_seconds : 0.0},
        vouched_{before ? before->segments.size() : 0},
        has_checkpoint_{before.has_value()},
        recording_{output, header_after(std::move(header), before),
                   before ? before->segments : std::vector<Segment>()},
        sink_{recording_},
        way_{std::move(model), std::move(start), {}, &sink_} {
    if (before) way_.go_on(std::move(before->state), std::move(before->accounts));
  }

  /// Marches the run to its end, or to where it is cut off.
  void march() {
    // launches short enough for the checkpoints and the wall time that are asked for
    SimulationOptions launches;
    launches.seconds =
        std::clamp(std::min(options_.checkpoint, 0.1 * options_.most_wall), 1e-3, 0.2);
    Simulation simulation(launches);
    simulation.run({&way_}, [&] {
      show_progress();
      if (way_.over()) return;
      if (seconds_since(begun_) >= options_.most_wall) {
        simulation.stop();
        out_of_time_ = true;
      }
      if (take_checkpoint_request() || !simulation.goes_on() ||
          seconds_since(kept_) >= options_.checkpoint)
        keep(simulation);
    });
    memory_ = simulation.memory();
  }

  /// Writes the result; what the run does not go on from any more is removed.
  RunReport finish(const std::string& beyond_limit) {
    RunReport report = this->report();
    report.beyond_limit = beyond_limit;
    if (report.ending == Ending::interrupted && out_of_time_ && interruption() == 0)
      report.ending = Ending::out_of_time;
    report.resumable =
        has_checkpoint_ && report.ending != Ending::complete && report.ending != Ending::failed;
    report.read_back_seconds = recording_.close(summary_of(report));
    report.wall_seconds = wall();
    report.resumable ? output_.remove_segments(vouched_ + 1) : output_.remove_all();
    return report;
  }

  /// What a failure to write has cost, and what it has not.
  std::string kept_text() const {
    return has_checkpoint_
               ? fmt::format(
                     ". What was recorded up to the last checkpoint is kept: the same line goes on "
                     "from there")
               : std::string();
  }

 private:
  static ResultHeader header_after(ResultHeader header, const std::optional<Checkpoint>& before) {
    if (before) header.segment = start_after(before->accounts.now);
    return header;
  }
  double wall() const { return wall_before_ + seconds_since(begun_); }
  RunReport report() const {
    RunReport report = report_on(way_, mean_squares_.get());
    report.wall_seconds = wall();
    report.memory = memory_;
    return report;
  }

  void keep(const Simulation& simulation) {
    const std::vector<Segment>& segments =
        recording_.close_segment(summary_of(report()), start_after(way_.accounts().now));
    write_checkpoint(output_,
                     {identity_, simulation.save(way_), way_.accounts(), wall(), segments});
    vouched_ = segments.size();
    has_checkpoint_ = true;
    kept_ = Clock::now();
  }

  void show_progress() {
    if (!options_.progress || seconds_since(shown_) <= 0.2) return;
    shown_ = Clock::now();
    options_.progress(progress_of(way_, first_step_, seconds_since(begun_)));
  }

  const RunOptions& options_;
  const ClaimedOutput& output_;
  Identity identity_;
  MeanSquares mean_squares_;
  double wall_before_;   // s, of what it goes on from
  std::size_t vouched_;  // segments that the last checkpoint vouches for
  bool has_checkpoint_, out_of_time_ = false;
  Recording recording_;
  FileSink<Recording> sink_;
  SceneRun way_;
  std::size_t memory_ = 0;
  std::int64_t first_step_ = way_.accounts().now.step;
  Clock::time_point begun_ = Clock::now(), kept_ = begun_, shown_ = begun_;
};

}  // namespace

RunReport run(const Scene& scene, const RunOptions& options) {
  Model model = make_model(scene);
  if (options.doubts) options.doubts(model.doubts);
  const std::string beyond_limit = checked_limit(model);
  if (const std::string overlap = overlap_at_start(model); !overlap.empty())
    throw refusal(scene, "scene.gap", overlap);

  const ClaimedOutput output(options.output);
  const std::string key = run_key(model);
  ResultHeader header = result_header(model, key);
  header.beyond_limit = beyond_limit;
  const Identity identity = identity_of(key, header.scene);
  if (options.fresh) output.remove_all();
  if (!options.fresh && is_there(output.names().result, key, options)) {
    output.remove_all();
    RunReport report;
    report.ending = Ending::there;
    return report;
  }
  const auto tell = [&](const std::string& text) {
    if (options.tell) options.tell(text);
  };
  std::optional<Checkpoint> before = last_checkpoint(output, identity, model, tell);
  output.remove_segments(before ? before->segments.size() + 1 : 1);
  if (before)
    tell(fmt::format("goes on from t = {:.6g} s, where its last checkpoint is",
                     static_cast<double>(before->accounts.now.step) * model.tick));
  ModalStart start = make_start(model);

  const bool goes_on = before.has_value();
  FiledRun run(std::move(model), std::move(start), std::move(header), identity, output,
               std::move(before), options);
  const OrderlyEnd orderly;  // before, there is nothing to keep
  try {
    run.march();
    return run.finish(beyond_limit);
  } catch (const FileError& fault) {
    throw FileError(fault.what() + run.kept_text());
  } catch (const std::invalid_argument& fault) {
    if (!goes_on) throw;
    throw FileError(
        fmt::format("cannot go on from '{}': its state does not fit its scene: {}. It is left as "
                    "it is: --fresh starts the run anew and has it removed",
                    output.names().checkpoint.string(), fault.what()));
  }
}

}  // namespace ra2d
