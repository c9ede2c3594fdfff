// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/run/checkpoint.hpp"
#include "host/run/file_sink.hpp"
#include "host/run/simulation.hpp"
#include "host/store/output_names.hpp"
#include "host/store/recording.hpp"

/// The files of a run while it goes on: checkpoints, and its recorded data where that is kept.
namespace ra2d {

class RunFiles {
 public:
  /// `output`: where the result goes, or would go if it were kept. `key`: run_key. Nothing is
  /// touched yet.
  RunFiles(std::filesystem::path output, std::string key);

  /// Makes the output this process' own, if it is not yet. Throws OutputTaken, FileError.
  void claim();
  bool is_claimed() const { return claimed_ != nullptr; }
  const OutputNames& names() const { return claimed_->names(); }  // once it is claimed

  /// Looks for the checkpoint that the run goes on from. The output must be claimed.
  FoundCheckpoint find(const Model& model, Outputs outputs);

  /// Keeps what the run records from now on; `before`: what it goes on from. Throws FileError.
  void record(ResultHeader header, const std::optional<Checkpoint>& before);
  bool records() const { return recording_.has_value(); }
  /// Takes what the run records; none where that is not kept.
  Sink* sink() { return sink_ ? &*sink_ : nullptr; }

  /// s of wall time since the last checkpoint, or since the run began here.
  double since_checkpoint() const;
  bool has_checkpoint() const { return has_checkpoint_; }
  /// Whether the last checkpoint and all that it vouches for are there.
  bool can_go_on() const;
  /// Writes a checkpoint of a run between two launches, `wall` seconds after its start. The output
  /// must be claimed. `so_far` gives the figures until now, for a segment; `watch` may be none.
  /// Throws FileError.
  void keep(const SceneRun& run, SavedState state, double wall,
            const std::function<ResultSummary()>& so_far, const RunWatch* watch = nullptr);

  /// Finishes a result that is kept and gives it its name. Returns how long reading back took [s].
  double close(const ResultSummary& summary);
  /// Removes what the last checkpoint does not vouch for, or all that there is but the result.
  void remove_after_checkpoint() const;
  void remove() const;

 private:
  std::filesystem::path output_;
  std::string key_;
  std::unique_ptr<ClaimedOutput> claimed_;
  std::size_t vouched_ = 0;  // segments that the last checkpoint vouches for
  bool has_checkpoint_ = false;
  bool last_is_damaged_ = false;  // the run goes on from the checkpoint before it
  std::optional<Recording> recording_;
  std::optional<FileSink<Recording>> sink_;
  std::chrono::steady_clock::time_point kept_ = std::chrono::steady_clock::now();
};

/// Wall time of a launch [s], short enough for a checkpoint every `checkpoint` seconds and for the
/// end at `most_wall`.
double launch_seconds(double checkpoint, double most_wall);

}  // namespace ra2d
