// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <utility>

#include "host/device/backend.hpp"
#include "host/errors.hpp"
#include "host/interruption.hpp"
#include "host/plan/plan.hpp"
#include "host/run/simulation.hpp"
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

}  // namespace

ResultHeader result_header(const Model& model) { return make_header(model); }

std::unique_ptr<Sink> file_sink(ResultFile& file) { return std::make_unique<FileSink>(file); }

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
