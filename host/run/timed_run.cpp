// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/timed_run.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "host/base/quiet_nan.hpp"
#include "host/device/backend.hpp"
#include "host/result/energy.hpp"
#include "host/system/interruption.hpp"

namespace ra2d {
namespace {

/// The last of `count` rows.
std::vector<double> last_row(const std::vector<double>& rows, std::size_t count) {
  return {rows.end() - static_cast<std::ptrdiff_t>(rows.size() / count), rows.end()};
}

/// Twice the energy per mass of a body's modes, weighted by the mass: sum m (V^2 + omega^2 U^2).
double square_norm(const Body& body, const std::vector<double>& u, const std::vector<double>& v) {
  double sum = 0;
  for (std::size_t k = 0; k < u.size(); ++k)
    sum += body.modes[k].mass * (v[k] * v[k] + std::pow(body.modes[k].omega * u[k], 2));
  return sum;
}

std::vector<double> minus(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size());
  std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::minus<>());
  return out;
}

/// Keeps the shocks and the latest state.
class MemorySink : public Sink {
 public:
  void take(const SampleBlock& block) override {
    const std::size_t count = block.time.size();
    if (count == 0) return;
    state = {last_row(block.resonator_displacement, count),
             last_row(block.resonator_velocity, count), last_row(block.slider_displacement, count),
             last_row(block.slider_velocity, count)};
  }
  void take(const std::vector<Shock>& more) override {
    shocks.insert(shocks.end(), more.begin(), more.end());
  }
  State state;
  std::vector<Shock> shocks;
};

TimedRun timed(const SceneRun& scene, MemorySink& sink) {
  const Accounts& accounts = scene.accounts();
  TimedRun out;
  out.status = scene.status();
  out.time = scene.time();
  out.state = std::move(sink.state);
  out.energy = accounts.energy.balance();
  out.shocks = std::move(sink.shocks);
  std::sort(out.shocks.begin(), out.shocks.end(),
            [](const Shock& a, const Shock& b) { return a.serial < b.serial; });
  out.begin = accounts.begin;
  out.end = accounts.now;
  return out;
}

}  // namespace

std::vector<TimedRun> timed_runs(const std::vector<Model>& models,
                                 const std::vector<ModalStart>& starts, const RunLimits& limits) {
  std::vector<MemorySink> sinks(models.size());
  std::vector<std::unique_ptr<SceneRun>> scenes;
  std::vector<SceneRun*> all;
  for (std::size_t i = 0; i < models.size(); ++i) {
    scenes.push_back(std::make_unique<SceneRun>(models[i], starts[i], limits, &sinks[i]));
    all.push_back(scenes.back().get());
  }
  Simulation simulation({.seconds = std::clamp(0.1 * limits.wall, 1e-3, 0.2)});
  simulation.run(all);
  if (interruption() != 0) throw Interrupted{};
  double marched = 0, processor = 0;
  for (const auto& scene : scenes) {
    marched += scene->accounts().march_seconds;
    processor += scene->processor_seconds();
  }
  const double side_by_side =
      std::min(static_cast<double>(scenes_at_once()), static_cast<double>(scenes.size()));
  std::vector<TimedRun> out;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    out.push_back(timed(*scenes[i], sinks[i]));
    out.back().seconds = marched / side_by_side;
    out.back().processor = processor;
  }
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
      return "too many nodes touch at once for the memory";
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
  if (size == 0) return quiet_nan;
  return norm({minus(state.resonator_u, reference.resonator_u),
               minus(state.resonator_v, reference.resonator_v),
               minus(state.slider_u, reference.slider_u),
               minus(state.slider_v, reference.slider_v)}) /
         size;
}

}  // namespace ra2d
