// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/simulation.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <new>
#include <utility>

#include "host/base/clock.hpp"
#include "host/device/backend.hpp"
#include "host/device/device.hpp"
#include "host/run/samples.hpp"
#include "host/system/interruption.hpp"

namespace ra2d {
namespace {

constexpr std::int64_t forever = std::numeric_limits<std::int64_t>::max();

std::int64_t ticks_of(double time, double tick) {
  const double ticks = time / tick;
  return ticks < 9e18 ? std::llround(ticks) : forever;
}

bool is_finite(const std::vector<Shock>& shocks) {
  return std::all_of(shocks.begin(), shocks.end(), [](const Shock& shock) {
    return std::isfinite(shock.peak_force) && std::isfinite(shock.impulse) &&
           std::isfinite(shock.position);
  });
}

/// Fills the slots of a batch with scenes. Scenes that found no memory wait here for that of
/// others. Threads may fill slots side by side.
class SlotFiller {
 public:
  using Begin = std::function<void(SceneRun&, int slot)>;
  SlotFiller(Batch& batch, std::vector<SceneRun*>& slots, const Simulation::Make& make, Begin begin)
      : batch_{batch}, slots_{slots}, make_{make}, begin_{std::move(begin)} {}

  /// Empties a slot and puts the next scene there, if there is one; false where there is no memory
  /// for it.
  bool fill(int slot) {
    SceneRun*& scene = slots_[static_cast<std::size_t>(slot)];
    batch_.empty(slot);
    scene = nullptr;
    try {
      scene = next();
      if (scene != nullptr) begin_(*scene, slot);
      return true;
    } catch (const std::bad_alloc&) {
      batch_.empty(slot);
      const std::lock_guard lock(mutex_);
      if (scene != nullptr)
        waiting_.push_back(std::exchange(scene, nullptr));
      else
        make_again_ = true;
      return false;
    }
  }

  /// Tries again to fill the slots that a lack of memory left empty. Where no other scene could
  /// free memory any more, a scene that does not fit never will: it is handed to `too_large`.
  void fill_empty(const std::function<void(SceneRun&)>& too_large) {
    if (make_again_.exchange(false)) all_made_ = false;  // whatever other threads were told
    for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
      while (slots_[slot] == nullptr && !(all_made_ && waiting_.empty())) {
        if (fill(static_cast<int>(slot))) continue;
        if (filled() > 0) return;
        if (!too_large || waiting_.empty()) throw std::bad_alloc();
        SceneRun* const refused = waiting_.back();
        waiting_.pop_back();
        too_large(*refused);
      }
    }
  }

  std::size_t filled() const {
    return slots_.size() -
           static_cast<std::size_t>(std::count(slots_.begin(), slots_.end(), nullptr));
  }

 private:
  /// A scene that waits, or a new one; none where all are made.
  SceneRun* next() {
    {
      const std::lock_guard lock(mutex_);
      if (!waiting_.empty()) {
        SceneRun* const scene = waiting_.back();
        waiting_.pop_back();
        return scene;
      }
    }
    SceneRun* const scene = make_(made_++);
    if (scene == nullptr) all_made_ = true;
    return scene;
  }

  Batch& batch_;
  std::vector<SceneRun*>& slots_;
  const Simulation::Make& make_;
  Begin begin_;
  std::atomic<std::size_t> made_ = 0;
  std::atomic<bool> all_made_ = false, make_again_ = false;
  std::mutex mutex_;
  std::vector<SceneRun*> waiting_;  // for memory
};

}  // namespace

SceneRun::SceneRun(Model model, ModalStart start, const RunLimits& limits, Sink* sink)
    : model_{std::move(model)},
      start_{std::move(start)},
      limits_{limits},
      sink_{sink},
      launch_{model_},
      first_{first_counted(model_)},
      last_{ticks_of(limits.time, model_.tick)} {
  accounts_.energy = EnergyAccount(model_.scene.output.from);
}

bool SceneRun::over() const {
  const Snapshot& now = accounts_.now;
  return now.status != Status::running || now.step >= last_ ||
         accounts_.march_seconds >= limits_.wall || now.shocks_begun >= limits_.shocks;
}

std::int64_t SceneRun::target(std::int64_t ticks, int times) const {
  const std::int64_t step = accounts_.now.step;
  const std::int64_t left = last_ - step;
  std::int64_t next = step;
  if (ticks > 0)
    next += std::min(ticks, left);
  else
    next += launch_.steps() < left / times ? times * launch_.steps() : left;
  // a sample at the end of a window takes a step that begins there, and one more where it stands
  // between two
  if (model_.end < model_.steps) next = std::min(next, std::max(model_.end, step) + 2);
  // statistics begin at the end of a launch
  return step < first_ ? std::min(next, first_) : next;
}

void SceneRun::begin(Batch& batch, int slot) {
  batch.put(slot, model_, start_);
  if (saved_)
    batch.restore(slot, *saved_);
  else
    accounts_.now = accounts_.begin = batch.snapshot(slot);
}

void SceneRun::take(Batch& batch, int slot, double wanted) {
  const double took = batch.seconds(slot);
  accounts_.march_seconds += took;
  processor_seconds_ += batch.processor_seconds(slot);
  const Drained drained = batch.drain(slot);
  if (sink_ != nullptr) sink_->take_raw(drained);
  const std::int64_t before = accounts_.now.step;
  accounts_.now = batch.snapshot(slot);
  if (before < first_) accounts_.begin = accounts_.now;
  const std::int64_t kept = accounts_.samples + drained.samples;
  if (accounts_.now.status == Status::running && accounts_.now.step >= model_.end &&
      model_.end < model_.steps && kept >= model_.kept_samples())
    accounts_.now.status = Status::done;
  launch_.took(accounts_.now.step - before, took, wanted);

  const SampleBlock block =
      make_samples(model_, start_, drained, model_.first_sample + accounts_.samples);
  accounts_.samples += drained.samples;
  accounts_.energy.add(block);
  if (sink_ != nullptr) sink_->take(block);
  if (!is_finite(block)) accounts_.now.status = Status::not_finite;
  keep(make_shocks(model_, drained.shocks));
}

void SceneRun::keep(const std::vector<Shock>& shocks) {
  for (const Shock& shock : shocks) {
    if (shock.start < model_.scene.output.from) continue;
    accounts_.durations.add(shock.duration);
    accounts_.forces.add(shock.peak_force);
  }
  if (sink_ != nullptr) sink_->take(shocks);
  if (!is_finite(shocks)) accounts_.now.status = Status::not_finite;
}

void SceneRun::close() { keep(make_shocks(model_, accounts_.now.open_shocks)); }

Simulation::Simulation(const SimulationOptions& options) : options_{options} {}

void Simulation::run(const Make& make, const std::function<void(SceneRun&)>& done,
                     const std::function<void()>& between,
                     const std::function<void(SceneRun&)>& too_large) {
  if (options_.batch.memory == 0) options_.batch.memory = backend_memory();
  Batch batch(options_.slots, options_.batch);
  batch_ = &batch;
  scenes_.assign(static_cast<std::size_t>(options_.slots), nullptr);
  std::atomic<double> busy = 0, in_march = 0;
  SlotFiller filler(batch, scenes_, make,
                    [&](SceneRun& scene, int slot) { scene.begin(batch, slot); });
  side_by_side(options_.slots, [&](int slot) {
    const Clock::time_point begin = Clock::now();
    filler.fill(slot);
    busy += seconds_since(begin);
  });

  // on a device the clock ends a launch, for all scenes at once; without one it would be too long
  const int times = march_device() != nullptr ? 8 : 1;
  std::vector<std::int64_t> targets(scenes_.size(), 0);
  for (goes_on_ = interruption() == 0; goes_on_;) {
    filler.fill_empty(too_large);
    const std::size_t running = filler.filled();
    if (running == 0) return;
    most_at_once_ = std::max(most_at_once_, running);
    memory_ = std::max(memory_, batch.bytes());
    // on a CPU they share the threads
    const double wanted =
        std::max(1e-3, options_.seconds * std::min(1.0, static_cast<double>(scenes_at_once()) /
                                                            static_cast<double>(running)));
    for (std::size_t i = 0; i < scenes_.size(); ++i)
      targets[i] = scenes_[i] != nullptr ? scenes_[i]->target(options_.ticks, times) : 0;
    const Clock::time_point begin = Clock::now();
    batch.march(targets, wanted, [&](int slot) {
      const Clock::time_point marched = Clock::now();
      busy += batch.seconds(slot);
      in_march += batch.seconds(slot);
      SceneRun& scene = *scenes_[static_cast<std::size_t>(slot)];
      scene.take(batch, slot, wanted);
      if (scene.over()) {
        scene.close();
        if (done) done(scene);
        filler.fill(slot);
      }
      busy += seconds_since(marched);
    });
    seconds_ += seconds_since(begin);
    busy_seconds_ = busy;
    marched_seconds_ = in_march;
    goes_on_ = interruption() == 0;
    if (between) between();
  }
  for (SceneRun* scene : scenes_)
    if (scene != nullptr) scene->close();
}

bool Simulation::holds(const SceneRun& scene) const {
  return std::find(scenes_.begin(), scenes_.end(), &scene) != scenes_.end();
}

SavedState Simulation::save(const SceneRun& scene) const {
  const auto place = std::find(scenes_.begin(), scenes_.end(), &scene);
  return batch_->save(static_cast<int>(place - scenes_.begin()));
}

void Simulation::run(const std::vector<SceneRun*>& scenes, const std::function<void()>& between) {
  options_.slots = static_cast<int>(scenes.size());
  run([&](std::size_t i) { return i < scenes.size() ? scenes[i] : nullptr; }, {}, between);
}

}  // namespace ra2d
