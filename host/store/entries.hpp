// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "host/result/record.hpp"
#include "host/store/store.hpp"

/// Everything that a result file holds (docs/results.md).
namespace ra2d {

/// Raised when a sampled dataset comes, or when any changes its meaning or goes.
inline constexpr std::int64_t file_format = 3;
/// Of a file of an areal scene: as format 3, with maps for profiles, numbers of half waves for
/// shapes, the y of shocks, and the units of bodies that have an area. An older one is not read.
inline constexpr std::int64_t areal_format = 5;
inline constexpr std::int64_t old_areal_format = 4;
/// The oldest format that is read. In format 2 the scale of the shocks is their start, counts are
/// stored as doubles, and groups have no description.
inline constexpr std::int64_t oldest_format = 2;

// Where the numbers of a dataset come from, which also says when they are written.
using Fixed = SharedNumbers (*)(const ResultHeader&);  // at the start, (rows, columns)
using Sampled = std::vector<double> SampleBlock::*;    // block by block
struct PerShock {                                      // one row a shock
  double (*get)(const Shock&);
  void (*set)(Shock&, double);
};
using Final = double ResultSummary::*;  // at the end, scalar; NaN: left out

/// How the numbers of a dataset stand in a file. In memory they are doubles.
enum class Stored { real64, real32, integer64 };

/// The scenes whose files have a dataset.
enum class Of { all, plane, areal };

/// Whether a dataset counts or measures.
enum class Numbers { real, whole };

/// One dataset.
struct Entry {
  const char *path, *units, *long_name;
  const char *rows, *columns;  // the scales of its axes; a scale is its own; "" where there is none
  std::variant<Fixed, Sampled, PerShock, Final> source;
  Numbers numbers = Numbers::real;
  const char* old_path = nullptr;  // in files of format 2, which may lack it
  Of of = Of::all;
  const char* areal_units = nullptr;  // in files of areal scenes; null: the same

  bool is_of(bool is_areal) const { return of == Of::all || (of == Of::areal) == is_areal; }

  bool has_columns() const { return *columns != '\0'; }
  bool is_sampled() const { return std::holds_alternative<Sampled>(source); }
  /// Whether it has a column for each mode of a body, which output.modes = "none" leaves out.
  bool is_modal() const;
  const char* path_in(std::int64_t format) const {
    return format < file_format && old_path != nullptr ? old_path : path;
  }
};

/// In the order readers list them. Scales come before the datasets that use them.
std::span<const Entry> entries();

struct Group {
  const char *path, *description;
  bool is_sampled = false;  // it has the time, so that it can be read alone
};

/// Their groups, each after the one that it is in.
std::span<const Group> groups();

/// Whether the file of a header has the dataset.
bool is_kept(const Entry& entry, const ResultHeader& header);

/// How it stands there.
Stored stored_in(const Entry& entry, const ResultHeader& header);

/// The source of the entry's numbers if it is of this kind, else null.
template <class Source>
const Source* source_of(const Entry& entry) {
  return std::get_if<Source>(&entry.source);
}

/// How many columns a dataset has: as many as their scale is long, else one.
std::size_t column_count(const Entry& entry, const ResultHeader& header);

}  // namespace ra2d
