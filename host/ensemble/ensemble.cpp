// SPDX-License-Identifier: BSD-3-Clause
#include "host/ensemble/ensemble.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "host/base/clock.hpp"
#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/device/backend.hpp"
#include "host/plan/plan.hpp"
#include "host/result/record.hpp"
#include "host/result/statistics.hpp"
#include "host/run/v_rms.hpp"

namespace ra2d {
namespace {

/// Runs side by side: enough for all threads, few enough to be stopped between.
int runs_at_once() { return std::clamp(backend_threads(), 4, 64); }

/// Two sigma of Student's t with n - 1 degrees of freedom, by its expansion in 1/(n - 1): within a
/// hundredth from n = 4 on.
double confidence(int pairs) {
  const double free = pairs - 1;
  return 2 + 2.5 / free + 3.06 / (free * free) + 3 / (free * free * free);
}

}  // namespace

double Movement::margin() const { return error > 0 ? confidence(pairs) * error : 0.0; }

Movement movement(const std::vector<double>& reference, const std::vector<double>& values) {
  Movement m;
  double sum = 0, of_reference = 0;
  const std::size_t count = std::min(reference.size(), values.size());
  const auto is_pair = [&](std::size_t i) {
    return !std::isnan(reference[i]) && !std::isnan(values[i]);
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_pair(i)) continue;
    sum += values[i];
    of_reference += reference[i];
    ++m.pairs;
  }
  if (sum == of_reference && of_reference == 0) return m;
  if (of_reference == 0) {
    m.relative = std::numeric_limits<double>::infinity();
    return m;
  }
  const double ratio = sum / of_reference;
  m.relative = ratio - 1;
  if (m.pairs < 2) return m;
  double square = 0;
  for (std::size_t i = 0; i < count; ++i)
    if (is_pair(i)) square += std::pow(values[i] - ratio * reference[i], 2);
  m.error = std::sqrt(square * m.pairs / (m.pairs - 1)) / std::abs(of_reference);
  return m;
}

Movement movement(const std::vector<Answer>& reference, const std::vector<Answer>& values,
                  double Answer::*quantity) {
  const auto list = [&](const std::vector<Answer>& answers) {
    std::vector<double> out;
    for (const Answer& a : answers) out.push_back(a.failure.empty() ? a.*quantity : quiet_nan);
    return out;
  };
  return movement(list(reference), list(values));
}

Verdict judge(const Movement& m, double accuracy) {
  const double away = std::abs(m.relative), margin = m.margin();
  if (away + margin <= accuracy) return Verdict::kept;
  return away - margin > accuracy ? Verdict::moved : Verdict::open;
}

double pairs_needed(const Movement& m, double accuracy) {
  if (judge(m, accuracy) != Verdict::open) return m.pairs;
  const double left = std::abs(accuracy - std::abs(m.relative));
  // close to the limit no number will do
  return left > 0 ? std::max(m.pairs + 1.0, m.pairs * std::pow(2 * m.error / left, 2))
                  : std::numeric_limits<double>::infinity();
}

bool has_seeds(const Scene& scene) {
  return scene.resonator.surface.kind == SurfaceKind::gaussian ||
         scene.slider.surface.kind == SurfaceKind::gaussian;
}

Answer answer_of(const std::vector<double>& mean_squares, const TimedRun& run, double from) {
  Answer a;
  if (run.status != Status::running) a.failure = status_text(run.status);
  a.v_rms = v_rms(mean_squares, run.end, run.begin);
  a.first_duration = quiet_nan;
  std::vector<double> durations;
  for (const Shock& shock : run.shocks) {
    if (shock.start >= from) durations.push_back(shock.duration);
    if (shock.start > 0 && std::isnan(a.first_duration)) a.first_duration = shock.duration;
  }
  a.shock_rate = run.time > from ? static_cast<double>(durations.size()) / (run.time - from) : 0.0;
  a.shock_duration_median = median(durations);
  a.energy_closure = run.energy.closure();
  return a;
}

Scene variant(const Scene& scene, int index) {
  Scene out = scene;
  if (index == 0) return out;
  if (has_seeds(scene)) {
    for (BodySpec* body : {&out.resonator, &out.slider})
      if (body->surface.kind == SurfaceKind::gaussian)
        body->surface.seed = (body->surface.seed + 1000 * static_cast<std::uint64_t>(index)) &
                             static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    return out;
  }
  (scene.start > 0 ? out.start : out.speed) *= 1 - 1e-10 * index;
  return out;
}

std::string varied(const Scene& scene) {
  if (has_seeds(scene)) return "other seeds";
  if (scene.start > 0) return "scene.start other by some 1e-10 of it";
  return scene.speed > 0 ? "scene.speed other by some 1e-10 of it" : "";
}

Ensemble::Ensemble(const Scene& scene) : scene_{scene} {}

std::string Ensemble::failure() const {
  for (const Answer& a : answers_)
    if (!a.failure.empty()) return a.failure;
  return {};
}

void Ensemble::extend(int runs, double seconds) {
  const Clock::time_point begun = Clock::now();
  while (this->runs() < runs) {
    const double left = seconds - seconds_since(begun);
    const int count = std::min(runs - this->runs(), runs_at_once());
    if (!(left > 0) || !run(this->runs(), count, left)) return;
  }
}

bool Ensemble::run(int first, int count, double seconds) {
  const Clock::time_point begun = Clock::now();
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  std::vector<Answer> answers(static_cast<std::size_t>(count));
  std::vector<std::size_t> numbers;  // of the answers that the models give
  std::size_t whole = answers.size();
  for (int i = 0; i < count; ++i) {
    Model model = make_model(variant(scene_, first + i));
    // what is wrong with the start is a matter of these surfaces
    std::string& failure = answers[static_cast<std::size_t>(i)].failure;
    if (!overlap_at_start(model).empty()) failure = "the faces overlap at t = 0";
    try {
      if (failure.empty()) starts.push_back(make_start(model));
    } catch (const RequestError&) {
      failure = "no equilibrium to start from";
    }
    if (!failure.empty()) continue;
    models.push_back(std::move(model));
    numbers.push_back(static_cast<std::size_t>(i));
  }
  if (!models.empty()) {
    if (mean_squares_.empty()) mean_squares_ = mean_squares(models.front());
    // the threads share the scenes: each scene has as long a march
    const double rounds = std::ceil(static_cast<double>(models.size()) / backend_threads());
    const double left = std::max(0.0, seconds - seconds_since(begun));
    const std::vector<TimedRun> runs = timed_runs(models, starts, {.wall = left / rounds});
    march_seconds_ += runs.front().processor;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      answers[numbers[i]] = answer_of(mean_squares_, runs[i], scene_.output.from);
      time_ += runs[i].time;
      // pairs are compared by their numbers: the runs behind one that was cut off do not count
      if (runs[i].status == Status::running) whole = std::min(whole, numbers[i]);
    }
  }
  answers_.insert(answers_.end(), answers.begin(),
                  answers.begin() + static_cast<std::ptrdiff_t>(whole));
  seconds_ += seconds_since(begun);
  return whole == answers.size();
}

namespace {

TimedRun beginning_of(const Scene& scene, double enough) {
  const Model model = make_model(scene);
  return timed_run(model, make_start(model), {.wall = enough});
}

}  // namespace

double measure_cost(const Scene& scene, double enough) {
  const TimedRun run = beginning_of(scene, enough);
  return run.time > 0 ? run.processor / run.time : quiet_nan;
}

double measure_wall_cost(const Scene& scene, double enough) {
  const TimedRun run = beginning_of(scene, enough);
  return run.time > 0 ? run.seconds / run.time : quiet_nan;
}

}  // namespace ra2d
