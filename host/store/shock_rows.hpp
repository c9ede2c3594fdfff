// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "host/base/hash.hpp"
#include "host/result/record.hpp"
#include "host/store/store.hpp"
#include "host/store/table.hpp"

namespace ra2d {

/// The shocks' datasets: one row a shock, in the order of their serials. They come in any order,
/// and a later word on one takes the place of an earlier one. Memory does not grow with their
/// number.
class ShockRows {
 public:
  /// Makes rows for the shocks that are going on where the file begins; later shocks follow.
  void begin(const SegmentStart& start) { start_ = start; }
  void add(Table table) { tables_.push_back(std::move(table)); }

  /// Bytes by which the file will grow with these.
  std::size_t growth(const std::vector<Shock>& shocks) const;
  /// Writes them and forgets them.
  void write(std::vector<Shock>& shocks);
  /// Closes the holes that merged shocks left. The rows that are read on the way must be those that
  /// were given, in order of start.
  void close_holes();

  /// The datasets of shocks, to be closed at the end.
  std::vector<Table>& tables() { return tables_; }
  hsize_t rows() const { return rows_; }

 private:
  long row_of(const Shock& shock) const;
  hsize_t rows_with(const std::vector<Shock>& shocks) const;

  SegmentStart start_;
  std::vector<Table> tables_;
  hsize_t rows_ = 0;
  HashSum sum_;  // of the rows that were given, over their columns
};

}  // namespace ra2d
