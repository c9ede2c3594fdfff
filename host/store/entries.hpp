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
inline constexpr std::int64_t file_format = 2;

// Where the numbers of a dataset come from, which also says when they are written.
using Fixed = std::vector<double> (*)(const ResultHeader&);  // at the start, (rows, columns)
using Sampled = std::vector<double> SampleBlock::*;          // block by block
struct PerShock {                                            // one row a shock
  double (*get)(const Shock&);
  void (*set)(Shock&, double);
};
using Final = double ResultSummary::*;  // at the end, scalar; NaN: left out

/// One dataset.
struct Entry {
  const char *path, *units, *long_name;
  const char *rows, *columns;  // the scales of its axes; a scale is its own; "" where there is none
  std::variant<Fixed, Sampled, PerShock, Final> source;
  bool is_new = false;  // results of older programs may lack it

  bool has_columns() const { return *columns != '\0'; }
};

/// In the order readers list them. Scales come before the datasets that use them.
std::span<const Entry> entries();

/// Their groups, each after the one that it is in.
std::span<const char* const> groups();

/// The groups of samples: each has the time, so that it can be read alone.
std::span<const char* const> sampled_groups();

/// The source of the entry's numbers if it is of this kind, else null.
template <class Source>
const Source* source_of(const Entry& entry) {
  return std::get_if<Source>(&entry.source);
}

/// How many columns a dataset has: as many as their scale is long, else one.
std::size_t column_count(const Entry& entry, const ResultHeader& header);

}  // namespace ra2d
