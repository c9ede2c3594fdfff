// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/study/scene_key.hpp"
#include "host/study/study_file.hpp"

/// The runs that a study asks for: every combination once.
namespace ra2d {

/// A point is one run. Points are numbered in C order of the dimensions as they stand, the seed
/// last: so they lie in the table.
class StudyPoints {
 public:
  explicit StudyPoints(Study study);

  const Study& study() const { return study_; }
  std::size_t size() const { return combinations_ * study_.seeds.size(); }
  /// Without the seeds.
  std::size_t combinations() const { return combinations_; }
  /// Lengths of the table's axes, the seeds' last.
  std::vector<std::size_t> shape() const;
  /// Which value of each dimension, and which seed, a point takes.
  std::vector<std::size_t> place(std::size_t point) const;
  /// "speed = 0.1, rq = 2e-6, seed 3"
  std::string name(std::size_t point) const;
  /// Throws RequestError, with the name of the point.
  Scene scene(std::size_t point) const;
  /// A fault of its scene, for a message: without the place of the base, and with the study's own
  /// changes set apart from those of the command line.
  std::string in_words_of_the_study(std::string fault, std::size_t point) const;

 private:
  std::vector<std::string> overrides(const std::vector<std::size_t>& place) const;
  Scene combination(std::size_t point) const;
  /// `base`: the study's scene, parsed, if it can be.
  Scene combination(std::size_t point, const std::optional<ParsedText>& base) const;
  friend struct PointCensus;
  Study study_;
  std::size_t combinations_ = 1;
};

/// Key and cost of each point, before it is run.
struct PointCensus {
  std::vector<Key128> keys;
  std::vector<float> costs;  // s of one thread, estimates (host/plan/expected_work.hpp)
  bool has_seeds = true;     // whether a scene has a surface that a seed changes
  std::vector<std::filesystem::path> profiles;  // files that the scenes read

  /// Reads and checks the scene of every point, on all threads. Throws RequestError that names
  /// those that are wrong, the first few of them; FileError for a profile that cannot be read.
  /// `progress` is called a few times a second with the number of points that have been read, by
  /// one thread at a time.
  explicit PointCensus(const StudyPoints& points,
                       const std::function<void(std::size_t)>& progress = {});

  /// Points of which no earlier one is the same run, in their order.
  std::vector<std::size_t> different() const;
};

}  // namespace ra2d
