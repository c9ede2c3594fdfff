// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Measured profiles, whatever file they come from.
namespace ra2d {

/// A profile as every reader gives it.
struct Profile {
  double spacing = 0;           // m
  std::vector<double> heights;  // m, NaN where a point is missing
  std::string first_missing;    // "file:line"
  std::string doubt;            // a sentence where something looks wrong in the file

  double length() const { return static_cast<double>(heights.size() - 1) * spacing; }
  std::size_t missing() const;
};

struct LengthUnit {
  std::string_view name;
  double metres;
};

/// Of `m`, `mm`, `um` or `nm`, also with the sign for micro; nothing for another word.
std::optional<LengthUnit> to_unit(std::string_view word);

enum class DecimalMark { of_the_file, point, comma };

/// Options of the user about a file.
struct ProfileQuery {
  std::optional<LengthUnit> x_unit, z_unit;
  std::optional<double> spacing;  // m, of a file that has no x
  std::optional<int> column;      // of the heights, from 1; of an areal file a profile along y
  std::optional<int> row;         // of an areal file, from 1: a profile along x
  DecimalMark decimal = DecimalMark::of_the_file;
};

enum class ProfileFormat { text, sdf, x3p };

/// Format of a file by its content; text for anything else.
ProfileFormat format_of(const std::filesystem::path& file);

/// Throws RequestError, which names the format, for a file that format_of calls text and that is
/// none.
void require_text(const std::filesystem::path& file);

/// Throws RequestError for heights of a damaged file: they span more than any face. Those that are
/// missing do not count.
void require_possible_heights(const std::filesystem::path& file,
                              const std::vector<double>& heights);

/// Reads a file in the format that its content has. Throws RequestError, with file and line, for
/// what cannot be understood and for units that are missing; FileError where it cannot be read.
Profile read_measured_profile(const std::filesystem::path& file, const ProfileQuery& query);

/// Share of a face's root mean square slope that straight lines between nodes may lose in silence.
constexpr double most_slope_lost = 0.05;

/// Says how much of a measured profile's root mean square slope the nodes of a scene lose, where
/// that is more: its slope from point to point, `step` [m] apart, and from node to node, `spacing`
/// [m] apart.
void doubt_lost_slope(const std::filesystem::path& file, double slope_of_points, double step,
                      double slope_of_nodes, double spacing, std::vector<std::string>* doubts);

/// Doubt of a text that may be cut off in its last number (NumbersAtEnds).
std::string doubt_of_last_line(const std::filesystem::path& file);

/// The width of `linear:WIDTH` [m]; nothing for another text.
std::optional<double> to_fill_width(std::string_view text);

/// Puts straight lines through gaps of missing points that are at most `width` [m] wide, of which
/// each missing point is a spacing. Throws RequestError for wider ones and for those at the ends;
/// with a width of 0 for any.
void fill_gaps(Profile& profile, double width);

}  // namespace ra2d
