// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/study/study_folder.hpp"

/// A study as its user wrote it.
namespace ra2d {

/// One line of [vary]: an axis of the table.
struct StudyDimension {
  std::string name;
  std::vector<std::string> keys;                 // "section.key", which change together
  std::vector<std::vector<std::string>> values;  // (value, key), as TOML
  bool is_text = false;
  bool in_weights = false;         // numbers that count the slider's weight
  std::vector<double> numbers;     // the coordinates: the first key's number in each value; or,
  std::vector<std::string> texts;  // where one of these is a word, its texts

  std::size_t size() const { return values.size(); }
  /// A value as a message names it.
  const std::string& shown(std::size_t value) const { return values[value].front(); }
};

struct Study {
  std::filesystem::path file;       // where it was read from
  std::string text;                 // what stood there
  std::filesystem::path base;       // the scene, an absolute path
  std::string base_text;            // what stood there
  std::vector<std::string> set;     // "section.key=value" of [set]
  std::vector<std::string> given;   // and of --set
  std::vector<std::int64_t> seeds;  // run k takes both surfaces' seeds + 1000 k
  bool keep_level = true, keep_shocks = true, keep_sound = false, keep_files = false;
  std::vector<StudyDimension> dimensions;  // in the order in which they stand

  /// Whether what is kept of a run depends on its scene's microphones and air.
  bool keeps_microphones() const { return keep_sound || keep_files; }
};

/// Runs of one study at the most.
inline constexpr std::size_t most_study_runs = 1'000'000;

/// Reads and checks a study (docs/studies.md) and the scene it begins with. `given`: texts of
/// --set, which override the base and [set]. Throws RequestError that names every fault of the
/// study at once, FileError when a file cannot be read. The scenes are checked by StudyPoints.
Study read_study(const std::filesystem::path& file, const std::vector<std::string>& given = {});

/// Reads and checks the text of a study; the base is not read.
Study parse_study(const std::string& text, const std::filesystem::path& file,
                  const std::vector<std::string>& given = {});

/// The study as JSON. A study's folder keeps it, so that it can be read without the study's files.
std::string snapshot_text(const Study& study);
/// Throws FileError for what is no snapshot; `file` is used in messages.
Study parse_snapshot(const std::string& text, const std::filesystem::path& file);
/// The study that a folder is of. Throws FileError.
Study study_of(const StudyFolder& folder);

}  // namespace ra2d
