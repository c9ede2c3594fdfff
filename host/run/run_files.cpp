// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run_files.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "host/run/run_watch.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

/// The beginning of the segment that follows this moment.
SegmentStart start_after(const Snapshot& now) {
  SegmentStart start;
  for (const OpenShock& open : now.open_shocks) start.open_shocks.push_back(open.serial);
  std::sort(start.open_shocks.begin(), start.open_shocks.end());
  start.shocks_begun = now.shocks_begun;
  return start;
}

}  // namespace

RunFiles::RunFiles(std::filesystem::path output, std::string key)
    : output_{std::move(output)}, key_{std::move(key)} {}

void RunFiles::claim() {
  if (!claimed_) claimed_ = std::make_unique<ClaimedOutput>(output_);
}

FoundCheckpoint RunFiles::find(const Model& model, Outputs outputs) {
  FoundCheckpoint found =
      find_checkpoint(names(), identity_of(key_, echo(model.scene)), model, outputs);
  has_checkpoint_ = found.checkpoint.has_value();
  last_is_damaged_ = has_checkpoint_ && found.file == names().previous;
  vouched_ = has_checkpoint_ ? found.checkpoint->segments.size() : 0;
  return found;
}

void RunFiles::record(ResultHeader header, const std::optional<Checkpoint>& before) {
  std::vector<Segment> segments;
  if (before) {
    header.segment = start_after(before->accounts.now);
    segments = before->segments;
  }
  recording_.emplace(output_names(output_), header, std::move(segments));
  sink_.emplace(*recording_);
}

double RunFiles::since_checkpoint() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - kept_).count();
}

void RunFiles::keep(const SceneRun& run, SavedState state, double wall,
                    const std::function<ResultSummary()>& so_far, const RunWatch* watch) {
  claimed_->hold();
  std::vector<Segment> segments;
  if (recording_) segments = recording_->close_segment(so_far(), start_after(run.accounts().now));
  const std::size_t count = segments.size();
  write_checkpoint(*claimed_,
                   {identity_of(key_, echo(run.model().scene)), std::move(state), run.accounts(),
                    watch != nullptr ? watch->seen() : RunWatch::Seen{}, wall, std::move(segments)},
                   last_is_damaged_);
  vouched_ = count;
  has_checkpoint_ = true;
  last_is_damaged_ = false;
  kept_ = std::chrono::steady_clock::now();
}

bool RunFiles::can_go_on() const {
  std::error_code none;
  if (!has_checkpoint_ || !std::filesystem::exists(names().checkpoint, none)) return false;
  for (std::size_t number = 1; number <= vouched_; ++number)
    if (!std::filesystem::exists(names().segment(number), none)) return false;
  return true;
}

double RunFiles::close(const ResultSummary& summary) {
  if (vouched_ > 0) claimed_->hold();  // for the last segment
  return recording_->close(summary);
}

void RunFiles::remove_after_checkpoint() const { claimed_->remove_segments(vouched_ + 1); }

void RunFiles::remove() const { claimed_->remove_all(); }

double launch_seconds(double checkpoint, double most_wall) {
  return std::clamp(std::min(checkpoint, 0.1 * most_wall), 1e-3, 0.2);
}

}  // namespace ra2d
