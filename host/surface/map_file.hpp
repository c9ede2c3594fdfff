// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/surface/height_map.hpp"
#include "host/surface/profile.hpp"

/// Height maps in files.
namespace ra2d {

/// Options of the user about a file that has a map.
struct MapQuery {
  std::optional<LengthUnit> z_unit;
  std::optional<double> spacing, spacing_y;  // m, of a file that has none. spacing_y: as spacing
  DecimalMark decimal = DecimalMark::of_the_file;
};

/// Spacings, unit and heights as a file of bare numbers has them, before the user's options.
struct BareMap {
  std::size_t nx = 0, ny = 0;
  std::vector<double> numbers;               // row after row, NaN where a point is missing
  std::optional<LengthUnit> unit;            // of the numbers
  std::optional<double> spacing, spacing_y;  // m
  std::string doubt;                         // a sentence where something looks wrong in the file
};

/// The map of bare numbers with the user's options. Throws RequestError where the options disagree
/// with the file, where spacings are missing, and for numbers without a unit that cannot be metres.
HeightMap to_height_map(const std::filesystem::path& file, BareMap bare, const MapQuery& query);

/// Reads a whole map in the format that its content has: SDF, X3P, NumPy's .npy of shape (rows, x),
/// or text with a row of constant y in each line. Heights as they stand, NaN where a point is
/// missing. No memory is taken for sizes that require_map_size refuses. Throws RequestError for
/// what cannot be understood, FileError where the file cannot be read.
HeightMap read_height_map(const std::filesystem::path& file, const MapQuery& query);

/// Preparation of a measured map.
struct MapPreparation {
  double fill = 0;  // m, the widest gap
  MapForm form;
};

/// Fills gaps, takes the form off, and moves the heights to mean zero. `doubts` takes a sentence
/// for what looks wrong but may be intended. `name` is the map's in messages. Throws RequestError
/// as fill_map_gaps does.
void prepare_map(HeightMap& map, const MapPreparation& how, const std::string& name,
                 std::vector<std::string>* doubts);

}  // namespace ra2d
