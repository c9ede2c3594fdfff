// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "host/device/layout.hpp"
#include "host/device/saved_state.hpp"
#include "host/model/model.hpp"
#include "kernels/state.hpp"

/// Scenes on the device: tables, states, launches.
namespace ra2d {

/// Samples and shocks that a scene has recorded since it was last drained.
struct Drained {
  int lanes = 0;  // modal lanes of a sample row
  int samples = 0;
  std::vector<double> sample_rows;  // (sample, 2 lanes + sample::columns): U, V, columns
  std::vector<ShockRow> shocks;     // in order of their end
};

/// The present state of a scene.
struct Snapshot {
  Status status = Status::running;
  std::int64_t step = 0;  // in ticks (Model)
  std::vector<double> resonator_u, resonator_v, slider_u, slider_v;
  std::vector<double> resonator_square;  // sum over the steps of V_k^2
  std::int64_t contact_steps = 0, most_nodes = 0, evaluated = 0, shocks_begun = 0;
  double energy = 0, energy_limit = 0;
  double sliding_work = 0, force_work = 0;
  std::vector<OpenShock> open_shocks;
  std::int64_t steps_made = 0;  // of adaptive length or fixed
};

struct BatchOptions {
  Capacity capacity;
  int least_packs = 0;     // pad the modes to more packs than needed (for tests)
  std::size_t memory = 0;  // bytes that its scenes may take together; 0: as many as there are
};

/// Scenes marched side by side, each in a slot of its own, in one team. The answer of a scene does
/// not depend on the others. Slots may be filled, read and emptied side by side, each by one thread
/// at a time.
class Batch {
 public:
  /// Slots without a scene.
  explicit Batch(int slots, const BatchOptions& options = {});
  /// A slot each for these scenes.
  Batch(const std::vector<Model>& models, const std::vector<ModalStart>& starts,
        const BatchOptions& options = {});
  ~Batch();
  Batch(Batch&&) noexcept;
  Batch& operator=(Batch&&) noexcept;

  int slots() const;
  /// Puts a scene where it starts into a slot. Throws RequestError where it cannot be marched, and
  /// std::bad_alloc, with the slot empty, where there is no memory for it.
  void put(int slot, const Model& model, const ModalStart& start);
  void empty(int slot);

  /// One launch: each running scene goes on to its own target, its end, a full buffer, an interrupt
  /// (host/system/interruption.hpp; not on a GPU) or a failure; each on a GPU `seconds` at most.
  /// `marched` is called for each of them once it has been marched, on a CPU by the thread that
  /// did: it may drain the slot and fill it anew. A scene without memory for its contacts has
  /// stopped short, and has more the next time. Rethrows what `marched` throws.
  void march(const std::vector<std::int64_t>& targets, double seconds = 1e9,
             const std::function<void(int slot)>& marched = {});
  /// Marches all to one target.
  void march(std::int64_t target);
  /// Seconds that the latest launch spent on a scene, by the clock.
  double seconds(int slot) const;
  /// Processor seconds of the thread that marched it, whatever else the machine did. On a GPU it is
  /// the same as by the clock.
  double processor_seconds(int slot) const;

  /// Hands out and empties a scene's buffers.
  Drained drain(int slot);
  Snapshot snapshot(int slot) const;
  SavedState save(int slot) const;
  /// Takes a scene that was put into this slot on to where it was saved. Throws
  /// std::invalid_argument where the state does not fit the scene (fault_of).
  void restore(int slot, const SavedState& saved);
  /// Memory on the device.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ra2d
