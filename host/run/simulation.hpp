// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "host/device/batch.hpp"
#include "host/model/model.hpp"
#include "host/result/energy.hpp"
#include "host/result/record.hpp"
#include "host/result/statistics.hpp"
#include "host/run/launch_length.hpp"

/// The loop of every run: march, drain, convert, count, pass on.
namespace ra2d {

/// Takes in what a run records, in order.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void take(const SampleBlock& samples) = 0;
  /// Shocks that ended, and at the end those that go on, as long as they have lasted.
  virtual void take(const std::vector<Shock>& shocks) = 0;
  /// The drained rows as they came from the device, in ticks. Called before take().
  virtual void take_raw(const Drained&) {}
};

/// Limits at which a run ends, unless its scene ends before.
struct RunLimits {
  double time = std::numeric_limits<double>::infinity();           // s simulated
  double wall = std::numeric_limits<double>::infinity();           // s in its march
  std::int64_t shocks = std::numeric_limits<std::int64_t>::max();  // begun
};

/// The running sums of a scene. With the state of the march, and what RunWatch has seen, they are
/// all that a saved run needs.
struct Accounts {
  std::int64_t samples = 0;        // taken so far
  Snapshot begin, now;             // where statistics begin (output.from); after the latest launch
  EnergyAccount energy;            // from output.from on
  LogHistogram durations, forces;  // s, N: of shocks that began since
  double march_seconds = 0;        // in the march, of this scene alone on a CPU
};

/// One scene on its way from its start to its end.
class SceneRun {
 public:
  /// `sink` may be none.
  SceneRun(Model model, ModalStart start, const RunLimits& limits = {}, Sink* sink = nullptr);

  /// Goes on from where a run of the same scene was saved, with its accounts then.
  void go_on(SavedState state, Accounts accounts) {
    saved_ = std::move(state);
    accounts_ = std::move(accounts);
  }

  const Model& model() const { return model_; }
  const ModalStart& start() const { return start_; }
  const Accounts& accounts() const { return accounts_; }
  Status status() const { return accounts_.now.status; }
  /// Whether it ended: by itself, or at one of its limits.
  bool over() const;
  double time() const { return static_cast<double>(accounts_.now.step) * model_.tick; }  // s
  std::int64_t steps_made() const { return accounts_.now.steps_made; }
  /// Processor time of the march in this process [s].
  double processor_seconds() const { return processor_seconds_; }

 private:
  friend class Simulation;
  /// Takes its place in a slot.
  void begin(Batch& batch, int slot);
  /// The tick to march to in the next launch, of `ticks` if that is not 0, else so many times as
  /// long as it is expected to last.
  std::int64_t target(std::int64_t ticks, int times) const;
  /// Takes in what a launch has made; the next one is to take about `wanted` seconds.
  void take(Batch& batch, int slot, double wanted);
  void keep(const std::vector<Shock>& shocks);
  /// Hands on the shocks that go on.
  void close();

  Model model_;
  ModalStart start_;
  RunLimits limits_;
  Sink* sink_;
  LaunchLength launch_;
  std::optional<SavedState> saved_;  // to go on from
  std::int64_t first_, last_;        // ticks: where statistics begin, and to march to at the most
  Accounts accounts_;
  double processor_seconds_ = 0;
};

struct SimulationOptions {
  int slots = 1;           // scenes side by side
  double seconds = 0.2;    // of a launch: so that progress and interrupts are prompt ...
  std::int64_t ticks = 0;  // of each scene in a launch, instead of `seconds` (for tests)
  BatchOptions batch;
};

/// Marches scenes side by side, each on its own clock, until all are over or the program is
/// interrupted (host/system/interruption.hpp). A scene for which there is no memory beside the
/// others waits for theirs.
class Simulation {
 public:
  /// Makes another scene, or says that there are no more; the argument counts its calls. Threads
  /// make scenes side by side; a scene must live until the run is over. Where it throws
  /// std::bad_alloc it is called again after the next launch; when no scene is on its way, that
  /// ends the run.
  using Make = std::function<SceneRun*(std::size_t)>;

  explicit Simulation(const SimulationOptions& options = {});

  /// `done` is called for each scene that is over, by the thread that marched it; `between` after
  /// each launch; `too_large` for a scene for which there is no memory even alone, between two
  /// launches. Throws RequestError where a scene cannot be marched, std::bad_alloc instead of
  /// calling a `too_large` that is none, and what sinks throw.
  void run(const Make& make, const std::function<void(SceneRun&)>& done = {},
           const std::function<void()>& between = {},
           const std::function<void(SceneRun&)>& too_large = {});
  /// These scenes, all side by side.
  void run(const std::vector<SceneRun*>& scenes, const std::function<void()>& between = {});

  // between launches:
  /// Whether there will be another one, unless all scenes are over: neither was the program
  /// interrupted nor stop() called.
  bool goes_on() const { return goes_on_; }
  /// Ends the run, as an interrupt does.
  void stop() { goes_on_ = false; }
  /// Whether a scene is on its way: neither over nor waiting for memory.
  bool holds(const SceneRun& scene) const;
  /// The state of a scene that it holds.
  SavedState save(const SceneRun& scene) const;

  /// The most scenes that one launch marched.
  std::size_t most_at_once() const { return most_at_once_; }
  /// The most memory that scenes took together, where they are marched [bytes].
  std::size_t memory() const { return memory_; }
  /// Wall time of all launches [s].
  double seconds() const { return seconds_; }
  /// Time of all threads together for scenes [s]: making them ready, marching them (on a CPU), and
  /// recording.
  double busy_seconds() const { return busy_seconds_; }
  /// Time of all threads together for marching alone [s].
  double marched_seconds() const { return marched_seconds_; }

 private:
  SimulationOptions options_;
  bool goes_on_ = true;
  std::size_t most_at_once_ = 0, memory_ = 0;
  const Batch* batch_ = nullptr;   // of the present run
  std::vector<SceneRun*> scenes_;  // in its slots
  double seconds_ = 0, busy_seconds_ = 0, marched_seconds_ = 0;
};

}  // namespace ra2d
