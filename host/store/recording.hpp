// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/result/record.hpp"
#include "host/store/output_names.hpp"
#include "host/store/store.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {

/// A closed stretch of what a run records, as a checkpoint vouches for it.
struct Segment {
  std::uint64_t bytes = 0;
  std::string xxh3_128;  // of the file
  std::int64_t samples = 0, shocks = 0;
};

/// Throws FileError where the file is not the segment that is vouched for.
void require_segment(const std::filesystem::path& file, const Segment& segment);

/// The recorded data of a run on its way to the result: one file, or segments that are closed while
/// the run goes on and joined at its end, to the same bits. A segment is whole and on the disk
/// before it has its name, and is never opened for writing again. Its file stays open, and what
/// somebody removes is written once more from there (of the first 256 segments: a process may not
/// have many more files open). Every method throws FileError; the segments closed before stay.
class Recording {
 public:
  /// `before`: the segments that a run that goes on has closed, which were looked at
  /// (require_segment); header.segment: where the next one begins.
  Recording(OutputNames names, const ResultHeader& header, std::vector<Segment> before = {});

  void append(const SampleBlock& block);
  void append(const std::vector<Shock>& shocks);

  /// Closes a segment if there is anything to put into it; the following data begin at `next`. The
  /// output must be claimed (ClaimedOutput). `so_far`: the figures until now, for readers of the
  /// segment. Returns all segments.
  const std::vector<Segment>& close_segment(const ResultSummary& so_far, const SegmentStart& next);

  /// Finishes the result and gives it its name; the segments stay. Returns how long reading back
  /// took [s].
  double close(const ResultSummary& summary);

 private:
  void begin();
  /// Hands on what the segments hold that are closed, in order.
  void each_block(const std::function<void(const SampleBlock&)>& samples,
                  const std::function<void(const std::vector<Shock>&)>& shocks);
  /// Adds a segment, and keeps its file.
  void add(Segment segment, std::unique_ptr<InputFile> file);
  /// Writes segment `i`, from 0, once more where it is gone from its folder.
  void restore(std::size_t i);
  /// Gives what is in the present file its place among the segments, if there is anything.
  bool seal(const ResultSummary& so_far);

  OutputNames names_;
  ResultHeader header_;
  std::vector<Segment> segments_;
  std::vector<std::unique_ptr<InputFile>> held_;  // the files of the first of them
  std::optional<ResultFile> file_;
  std::int64_t samples_ = 0, shocks_ = 0;  // in it
};

}  // namespace ra2d
