// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/timed_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <limits>

#include "host/interruption.hpp"
#include "host/result/energy.hpp"
#include "host/run/launch_length.hpp"

namespace ra2d {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The last of `count` rows.
std::vector<double> last_row(const std::vector<double>& rows, std::size_t count) {
  return {rows.end() - static_cast<std::ptrdiff_t>(rows.size() / count), rows.end()};
}

/// Twice the energy per mass of a body's modes, weighted by the mass: sum m (V^2 + omega^2 U^2).
double square_norm(const Beam& beam, const std::vector<double>& u, const std::vector<double>& v) {
  double sum = 0;
  for (std::size_t k = 0; k < u.size(); ++k)
    sum += v[k] * v[k] + std::pow(beam.modes[k].omega * u[k], 2);
  return beam.mass_per_length * sum;
}

std::vector<double> minus(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size());
  std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::minus<>());
  return out;
}

/// What one scene of a batch has handed out so far.
class Follower {
 public:
  Follower(const Model& model, const ModalStart& start)
      : model_{&model},
        start_{&start},
        energy_{model.scene.output.from},
        first_{first_counted(model)} {
    counting_ = first_ == 0;
  }

  void take(Batch& batch, int index) {
    const Drained drained = batch.drain(index);
    out_.end = batch.snapshot(index);
    if (!counting_) out_.begin = out_.end;
    counting_ = counting_ || out_.end.step >= first_ || out_.end.status != Status::running;
    const SampleBlock block = make_samples(*model_, *start_, drained, samples_);
    samples_ += drained.samples;
    energy_.add(block);
    if (const std::size_t count = block.time.size(); count > 0)
      out_.state = {
          last_row(block.resonator_displacement, count), last_row(block.resonator_velocity, count),
          last_row(block.slider_displacement, count), last_row(block.slider_velocity, count)};
    keep(make_shocks(*model_, drained.shocks));
  }
  const Snapshot& end() const { return out_.end; }
  /// The step to stop at, so that statistics can begin there.
  std::int64_t stop() const {
    return counting_ ? std::numeric_limits<std::int64_t>::max() : first_;
  }

  TimedRun finish(double seconds, double processor) {
    keep(make_shocks(*model_, out_.end.open_shocks));
    std::sort(out_.shocks.begin(), out_.shocks.end(),
              [](const Shock& a, const Shock& b) { return a.serial < b.serial; });
    out_.status = out_.end.status;
    out_.time = static_cast<double>(out_.end.step) * model_->tick;
    out_.seconds = seconds;
    out_.processor = processor;
    out_.energy = energy_.balance();
    return out_;
  }

 private:
  void keep(const std::vector<Shock>& shocks) {
    out_.shocks.insert(out_.shocks.end(), shocks.begin(), shocks.end());
  }
  const Model* model_;
  const ModalStart* start_;
  std::int64_t samples_ = 0;
  EnergyAccount energy_;
  std::int64_t first_;
  bool counting_ = false;
  TimedRun out_;
};

}  // namespace

std::vector<TimedRun> timed_runs(const std::vector<Model>& models,
                                 const std::vector<ModalStart>& starts, const RunLimits& limits) {
  Batch batch(models, starts);
  std::vector<Follower> scenes;
  for (std::size_t i = 0; i < models.size(); ++i) scenes.emplace_back(models[i], starts[i]);
  const double ticks = limits.time / models.front().tick;
  const std::int64_t last =
      ticks < 9e18 ? std::llround(ticks) : std::numeric_limits<std::int64_t>::max();
  LaunchLength launch(models.front(), std::clamp(0.1 * limits.wall, 1e-3, 0.2));
  double seconds = 0, processor = 0;
  for (std::int64_t now = 0;;) {
    if (interruption() != 0) throw Interrupted{};
    std::int64_t target = now + std::min(launch.steps(), last - now);
    for (const Follower& scene : scenes) target = std::min(target, scene.stop());
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t clock = std::clock();
    batch.march(target);
    const double took = seconds_since(begin);
    processor += static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
    seconds += took;
    const std::int64_t before = now;
    now = std::numeric_limits<std::int64_t>::max();  // of the one that is furthest behind
    bool going_on = false, shocks_missing = false;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      scenes[i].take(batch, static_cast<int>(i));
      const Snapshot& end = scenes[i].end();
      shocks_missing = shocks_missing || end.shocks_begun < limits.shocks;
      if (end.status != Status::running) continue;
      going_on = true;
      now = std::min(now, end.step);
    }
    if (!going_on || now >= last || seconds >= limits.wall || !shocks_missing) break;
    launch.took(now - before, took);
  }
  std::vector<TimedRun> out;
  for (Follower& scene : scenes) out.push_back(scene.finish(seconds, processor));
  return out;
}

TimedRun timed_run(const Model& model, const ModalStart& start, const RunLimits& limits) {
  return timed_runs({model}, {start}, limits).front();
}

std::string status_text(Status status) {
  switch (status) {
    case Status::running:
    case Status::done:
      return "";
    case Status::unstable:
      return "unstable";
    case Status::not_finite:
      return "not finite";
    case Status::blocked:
      return "the kept modes cannot keep the faces apart";
    case Status::crowded:
      return "too many nodes touch at once";
    case Status::stalled:
      return "too fast for the clock";
  }
  return "";
}

bool fits(const Model& model, const State& state) {
  const std::size_t modes2 = model.resonator.modes.size(), modes1 = model.slider.modes.size();
  return state.resonator_u.size() == modes2 && state.resonator_v.size() == modes2 &&
         state.slider_u.size() == modes1 && state.slider_v.size() == modes1;
}

double state_error(const Model& model, const State& state, const State& reference) {
  const auto norm = [&](const State& s) {
    return std::sqrt(square_norm(model.resonator, s.resonator_u, s.resonator_v) +
                     square_norm(model.slider, s.slider_u, s.slider_v));
  };
  const double size = norm(reference);
  if (size == 0) return std::numeric_limits<double>::quiet_NaN();
  return norm({minus(state.resonator_u, reference.resonator_u),
               minus(state.resonator_v, reference.resonator_v),
               minus(state.slider_u, reference.slider_u),
               minus(state.slider_v, reference.slider_v)}) /
         size;
}

}  // namespace ra2d
