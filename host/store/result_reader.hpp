// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/store/store.hpp"

/// Result files, read again (docs/results.md).
namespace ra2d {

/// All that a result file holds but its samples.
struct ResultContents {
  std::string scene;          // TOML text of the scene
  std::string key;            // of the run; empty in files of older programs
  std::string origin;         // "ra2d 0.1 (commit), started ...": what wrote it, and when
  std::string beyond_limit;   // empty where the step held
  std::size_t samples = 0;    // T
  double rate = 0;            // Hz, of the samples; NaN of fewer than two
  double start = 0, end = 0;  // s, times of the first and of the last sample; NaN of none
  bool is_areal = false;
  bool has_modes = true;  // whether the modes' motion is in it (output.modes)
  std::vector<double> resonator_frequency, slider_frequency;  // Hz, 0 of rigid modes
  std::vector<double> mean_square;            // 1/m, of the resonator's elastic modes; areal: 1/m^2
  std::vector<double> probe_position;         // m, on the resonator
  std::vector<double> slider_probe_position;  // m, on the slider
  std::vector<double> probe_y, slider_probe_y;  // m, across them, of an areal scene
  std::vector<Shock> shocks;                    // in order of start
  ResultSummary summary;  // NaN where the file has none; complete and ended as it says
};

/// The attributes by which a result is recognised.
struct ResultStamp {
  std::string key, started;  // empty in files of older programs
  std::string scene, ended;  // as ResultContents has them
  bool complete = false;
  std::int64_t steps = 0;  // that were made
};

/// A file that is no result, is damaged, or was changed by another program.
struct UnreadableResult : FileError {
  UnreadableResult(const std::filesystem::path& file, const std::string& why);
  std::string reason;  // without the file's name: "it is no HDF5 file"
};

/// Compares every byte of the file with its seal. Throws FileError, UnreadableResult.
ResultStamp read_stamp(const std::filesystem::path& path);

/// The stamp of a result; none where the file is not there or is no HDF5 file.
std::optional<ResultStamp> stamp_of(const std::filesystem::path& path);

/// Whether a file is HDF5, as results are, or the rest of such a file. Throws FileError where it
/// cannot be read.
bool is_hdf5(const std::filesystem::path& file);

/// Whether the bytes of a file are known good (host/store/seal.hpp). HDF5 crashes on some that are
/// not: those are for a child process alone (host/store/checked_file.cpp).
enum class Bytes { sealed, hostile };

/// A result file that is open for reading. Throws FileError where it is none, of another format,
/// cut short, damaged or changed by another program, where its datasets do not fit together, or
/// where a number is none that a run can have come to.
class ResultReader {
 public:
  explicit ResultReader(const std::filesystem::path& path, Bytes bytes = Bytes::sealed);
  ~ResultReader();
  ResultReader(const ResultReader&) = delete;
  ResultReader& operator=(const ResultReader&) = delete;

  const ResultContents& contents() const;

  /// Throws RequestError where the motion of the modes is not in the file.
  void require_modes() const;
  /// Samples of a dataset, e.g. "resonator/velocity": of `rows` samples from `first` on, `count` of
  /// its columns from `column` on, each in a vector of its own. Takes the memory of these, and a
  /// block. Throws as require_modes where the dataset is of the modes.
  std::vector<std::vector<double>> columns(const char* dataset, std::size_t first, std::size_t rows,
                                           std::size_t column, std::size_t count) const;
  /// All that was recorded of `count` samples from `first` on.
  SampleBlock samples(std::size_t first, std::size_t count) const;
  /// How many rows a dataset has.
  std::size_t rows(const char* dataset) const;
  /// The one column of a dataset that has no more.
  std::vector<double> column(const char* dataset, std::size_t first, std::size_t rows) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ra2d
