// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/model/model.hpp"
#include "kernels/state.hpp"

/// Scenes on the device: tables, states, launches. The only part of host/ that knows Kokkos.
namespace ra2d {

/// Starts Kokkos, once in a program and for as long as anything here is used. `threads` = 0 leaves
/// their number to the machine.
class Backend {
 public:
  explicit Backend(int threads = 0);
  ~Backend();
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
};

/// Where the batch runs: the name of Kokkos' default execution space, and how many threads it has.
std::string backend_name();
int backend_threads();

/// Values that a team computes side by side: of a SIMD register, or the threads of a warp.
int backend_lanes();

/// What a scene handed out since the last time it was asked.
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
  std::int64_t strides = 0;  // steps made: of adaptive length or fixed
};

struct BatchOptions {
  int samples_at_once = 4096;  // capacity of the sample buffer of a scene, in rows
  int shocks_at_once = 8192;   // of the shock buffer, beside what one step can end
  int least_packs = 0;         // pad the modes to more packs than needed (for tests)
};

/// Scenes marched side by side, one team each. The answer of a scene does not depend on the others.
class Batch {
 public:
  Batch(const std::vector<Model>& models, const std::vector<ModalStart>& starts,
        const BatchOptions& options = {});
  ~Batch();
  Batch(Batch&&) noexcept;

  /// One launch: every running scene goes on to step `target`, its end, a full buffer, an interrupt
  /// (host/interruption.hpp; not on a GPU, which finishes its launch) or a failure.
  void march(std::int64_t target);
  /// Hands out and empties a scene's buffers.
  Drained drain(int scene);
  Snapshot snapshot(int scene) const;
  /// Memory on the device.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ra2d
