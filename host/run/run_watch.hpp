// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "host/analysis/level_history.hpp"
#include "host/analysis/mesh_tone.hpp"
#include "host/run/run_report.hpp"
#include "host/run/simulation.hpp"

namespace ra2d {

/// Looks at what a run records while it is at hand, and passes it on: so the report has intervals
/// and the mesh's tone without reading the file again.
class RunWatch : public Sink {
 public:
  /// `next` takes what was looked at; it may be none.
  RunWatch(const Model& model, Sink* next);

  void take(const SampleBlock& samples) override;
  void take(const std::vector<Shock>& shocks) override;
  /// All that it has taken so far. A checkpoint keeps it: the file need not hold all of it.
  struct Seen {
    std::uint64_t samples = 0;
    LevelParts::Sums level;
    MeshToneWatch::Sums tone;
  };
  Seen seen() const { return {samples_, parts_.sums(), tone_.sums()}; }
  /// Throws std::invalid_argument where that is of another run.
  void go_on(Seen seen);

  /// `mean_squares`: of the resonator's modes.
  void add_to(RunReport& report, const std::vector<double>& mean_squares) const;

 private:
  void add(const SampleBlock& samples);
  void add(const std::vector<Shock>& shocks);

  Sink* next_;
  std::uint64_t first_;              // sample of the run that is kept
  std::vector<double> frequencies_;  // Hz, of the resonator
  double damping_;
  std::uint64_t samples_ = 0;  // looked at
  LevelParts parts_;
  MeshToneWatch tone_;
};

}  // namespace ra2d
