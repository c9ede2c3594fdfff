// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run_watch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace ra2d {
namespace {

/// Samples a second [Hz].
double rate_of(const Model& model) { return 1 / (model.steps_per_sample * model.tick); }

/// The first sample from output.from on.
std::size_t first_sample(const Model& model) {
  return std::max(static_cast<std::size_t>(model.first_sample),
                  static_cast<std::size_t>(
                      std::ceil(std::max(0.0, model.scene.output.from * rate_of(model)) - 1e-6)));
}

/// The number of samples that are counted.
std::size_t samples_of(const Model& model) {
  const auto all = static_cast<std::size_t>(model.samples);
  return all - std::min(all, first_sample(model));
}

}  // namespace

RunWatch::RunWatch(const Model& model, Sink* next)
    : next_{next},
      first_{static_cast<std::uint64_t>(model.first_sample)},
      damping_{model.scene.resonator.damping},
      parts_{first_sample(model), samples_of(model), rate_of(model), model.resonator.modes.size()},
      tone_{mesh_tone_frequency(model.scene), first_sample(model), samples_of(model),
            rate_of(model), model.resonator.modes.size()} {
  for (const BodyMode& mode : model.resonator.modes)
    frequencies_.push_back(mode.omega / (2 * std::numbers::pi));
}

void RunWatch::take(const SampleBlock& samples) {
  add(samples);
  if (next_ != nullptr) next_->take(samples);
}

void RunWatch::take(const std::vector<Shock>& shocks) {
  add(shocks);
  if (next_ != nullptr) next_->take(shocks);
}

void RunWatch::add(const SampleBlock& samples) {
  parts_.add_rows(first_ + samples_, samples.resonator_velocity);
  tone_.add_rows(first_ + samples_, samples.resonator_velocity);
  samples_ += samples.time.size();
}

void RunWatch::add(const std::vector<Shock>& shocks) {
  for (const Shock& shock : shocks) parts_.add_shock(shock.start);
}

void RunWatch::go_on(Seen seen) {
  samples_ = seen.samples;
  parts_.go_on(std::move(seen.level));
  tone_.go_on(std::move(seen.tone));
}

void RunWatch::add_to(RunReport& report, const std::vector<double>& mean_squares) const {
  report.intervals = intervals_of_run(parts_.history(mean_squares), report.lv, report.shock_rate,
                                      ringing_of(frequencies_, damping_));
  report.mesh = tone_.tone(mean_squares, frequencies_, damping_);
}

}  // namespace ra2d
