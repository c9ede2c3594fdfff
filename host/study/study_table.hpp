// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/study/ledger.hpp"
#include "host/study/study_points.hpp"

/// The one table of a study (docs/studies.md): HDF5, with the varied names as dimensions.
namespace ra2d {

/// Raised when a dataset changes its meaning or goes.
inline constexpr int study_format = 1;

/// Writes it whole under its name. It is made by the study, the build and the finished runs alone:
/// but for wall_seconds its bytes are the same whoever ran what. Throws FileError.
void write_study_table(const std::filesystem::path& file, const StudyPoints& points,
                       const PointCensus& census, const FinishedRuns& finished);

/// One axis of a table: numbers, or words.
struct StudyAxis {
  std::string name;
  std::vector<double> numbers;
  std::vector<std::string> texts;
  std::string units = "1";  // of the numbers, as in the table: "m s-1"
  std::string keys;         // of the scene, whose values they are: "slider.load"; of several a list
  std::size_t size() const { return texts.empty() ? numbers.size() : texts.size(); }
};

/// The contents of a table that an analysis needs.
struct StudyAnswers {
  std::vector<StudyAxis> axes;        // in the order of the table, the seeds last
  std::vector<double> v_rms;          // in C order; NaN where there is none
  std::vector<double> shock_rate;     // 1/s, in the same order; empty where the table has none
  std::vector<double> lp, lp_a;       // dB re 20 uPa, likewise
  std::vector<double> lw, lw_a;       // dB re 1 pW, likewise
  std::vector<double> status;         // RunStatus
  std::vector<std::string> messages;  // why a run failed; of one that is done its warnings
  std::string study, base;            // their texts
  std::string given;                  // --set, a line each
  std::string origin;                 // what wrote the table: "ra2d 0.1 (commit)"
};

/// Whether the file is one: false also for what cannot be opened, or is damaged.
bool is_study_table(const std::filesystem::path& file);

/// Whether a file is a table that was damaged or changed. Throws FileError where it cannot be read.
bool is_damaged_table(const std::filesystem::path& file);

/// The table of a study's folder, whole or not, or the file itself where it is one; empty of
/// anything else.
std::filesystem::path study_table_of(const std::filesystem::path& file);

/// Throws FileError for what is no such table, is damaged, or was changed by another program.
StudyAnswers read_study_table(const std::filesystem::path& file);

}  // namespace ra2d
