// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/base/shared_numbers.hpp"
#include "host/result/mean_squares.hpp"
#include "host/result/noise_figures.hpp"
#include "host/result/record.hpp"
#include "host/scene/scene.hpp"
#include "host/system/input_file.hpp"

/// The result file (docs/results.md).
namespace ra2d {

/// A body's modes; it may have none.
struct ModesHeader {
  std::vector<double> frequency;  // Hz
  std::vector<double> position;   // m, places along the body
  std::vector<double> shape;      // (mode, position), m^-1/2
  // of an areal scene instead
  std::vector<double> mode_x, mode_y;  // half waves along x and y
  std::vector<double> y;               // m, places across the body
  std::vector<double> shape_x;         // (mode, position), 1/m: where the shape is largest across
  std::vector<double> shape_y;         // (mode, y): the shape over that
  MeanSquares mean_square;  // 1/m, of the shape over all the nodes; 0 of a rigid mode. Areal:
                            // 1/m^2, over the area
};

/// The place in a run where a file begins: its start, unless the file holds only a part of the run.
struct SegmentStart {
  std::vector<long> open_shocks;  // serials of the shocks that are going on, in ascending order
  long shocks_begun = 0;          // serial of the next one
};

/// The part of a result that is known before the first step.
struct ResultHeader {
  std::string scene;    // TOML text of the scene
  std::string key;      // of the run (run_key)
  std::string backend;  // e.g. "OpenMP"
  int threads = 1;
  std::string beyond_limit;  // the limit of stability that time.force passes; no attribute if empty
  std::string doubts;   // values of the scene that look wrong, a line each; no attribute if empty
  std::string started;  // ISO 8601, UTC
  ModesHeader resonator, slider;
  std::vector<double> probe_position, slider_probe_position;  // m; either may be empty
  std::vector<double> probe_y, slider_probe_y;                // m, of an areal scene
  SharedNumbers resonator_height, slider_height;              // m, the profiles used, row by row
  double spacing = 0;                                         // m, chi
  bool is_areal = false;
  int rows = 1;
  double spacing_y = 0, side = 0;  // m, of an areal scene: chi_y, y0
  // of what is sampled
  KeptModes modes = KeptModes::all;
  Precision precision = Precision::real64;
  Compression compression = Compression::none;
  SegmentStart segment;
};

/// The figures of a run, known after its last step; those of shocks are NaN where there was none.
struct ResultSummary : NoiseFigures {
  double energy_residual = 0, energy_turnover = 0;  // J
  double energy_closure = 0;                        // residual over turnover, its size
  // bounds of 95 % intervals (IntervalsOfRun)
  double lv_low = quiet_nan, lv_high = quiet_nan;                  // dB
  double shock_rate_low = quiet_nan, shock_rate_high = quiet_nan;  // 1/s
  double step_seconds = 0;                                         // of wall time, a step
  double wall_seconds = 0;
  long steps = 0;
  bool complete = true;  // false: cut short
  std::string warnings;  // of the run's figures, a line each; no attribute if empty
  std::string ended;     // "complete", "interrupted", "unstable: ..."
};

/// Writes one HDF5 file, on a thread beside the caller's: what append() takes is on its way when it
/// returns, and what goes wrong with it is thrown by a call after it. Until close() the file stands
/// under a temporary name beside the final one, so a killed run leaves nothing under the final
/// name; close() renames it. Destroyed without close(), it removes what it wrote. Every method
/// throws FileError (disk full included) and then nothing is left.
class ResultFile {
 public:
  ResultFile(const std::filesystem::path& path, const ResultHeader& header);
  ~ResultFile();
  ResultFile(const ResultFile&) = delete;
  ResultFile& operator=(const ResultFile&) = delete;

  void append(const SampleBlock& block);
  /// In any order: each goes to the row of its serial. Memory does not grow with their number.
  void append(const std::vector<Shock>& shocks);
  /// Finishes the file, reads it back and gives it its name; returns how long reading back took
  /// [s].
  double close(const ResultSummary& summary);
  /// Finishes it under another name in the same file system. `kept` takes the whole file, open,
  /// before it has that.
  double close(const ResultSummary& summary, const std::filesystem::path& name,
               std::unique_ptr<InputFile>& kept);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ra2d
