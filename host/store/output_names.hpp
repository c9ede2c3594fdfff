// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/system/partial_file.hpp"

/// The files beside a result while it is made (docs/results.md).
namespace ra2d {

struct OutputNames {
  std::filesystem::path result;                // what a symbolic link leads to
  std::filesystem::path segments;              // OUT.h5.parts, a folder
  std::filesystem::path checkpoint, previous;  // OUT.h5.checkpoint, OUT.h5.checkpoint.previous

  /// Path of segment number 1, 2, ...
  std::filesystem::path segment(std::size_t number) const;
};
OutputNames output_names(const std::filesystem::path& output);

/// To be asked before anything of an output is made. Throws RequestError where one of `inputs` has
/// one of these names, or is a segment of the output; FileError where something else has one that
/// is not ra2d's own, or that may not be replaced. Nothing of that is ever removed.
void require_output_names(const OutputNames& names,
                          const std::vector<std::filesystem::path>& inputs);

/// Another process writes an output.
struct OutputTaken : FileError {
  using FileError::FileError;
};

/// "000001.h5", "000002.h5", ...
std::string segment_name(std::size_t number);

/// Whether a file has the name of a segment, in a folder of segments.
bool is_segment_name(const std::filesystem::path& file);

/// The folder of the segments that a checkpoint (or the one before) vouches for.
std::filesystem::path segments_of(const std::filesystem::path& checkpoint);

/// Makes an output one process' own, by a lock on the folder of its segments, which is made and,
/// where it is empty at the end, removed. The system lets go of the lock with the process.
class ClaimedOutput {
 public:
  /// Throws OutputTaken where another process of this machine writes the output, FileError where
  /// the folder cannot be made.
  explicit ClaimedOutput(const std::filesystem::path& output);
  ~ClaimedOutput();
  ClaimedOutput(const ClaimedOutput&) = delete;
  ClaimedOutput& operator=(const ClaimedOutput&) = delete;

  const OutputNames& names() const { return names_; }
  /// Makes the folder anew where somebody has removed it, with its lock. Throws as the constructor.
  void hold();
  /// Removes the segments from this number on: what no checkpoint vouches for.
  void remove_segments(std::size_t from) const;
  /// Removes the checkpoints, and then all segments.
  void remove_all() const;

 private:
  void take();

  OutputNames names_;
  std::optional<PartialFolder> partial_;
  int folder_ = -1;
};

}  // namespace ra2d
