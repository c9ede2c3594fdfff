// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "host/base/hash.hpp"
#include "host/store/attributes.hpp"
#include "host/store/entries.hpp"
#include "host/store/hdf5.hpp"

namespace ra2d {

/// At most so many rows at a time are asked of a table: 64 KiB of one column.
inline constexpr std::size_t rows_at_once = 8192;

/// A dataset, seen as rows of `width` numbers; the first axis may grow.
struct Table {
  const Entry* entry = nullptr;
  h5::Dataset dataset;
  hsize_t width = 1;
  Hash hash;                                // of the rows that were given
  std::vector<h5::GivenAttribute> given{};  // its attributes

  void give(h5::GivenAttribute attribute);
  void resize(hsize_t rows) const;
  /// Of datasets that grow. Whole chunks go to the file as they are, by no copy in HDF5's cache.
  void write(hsize_t first, hsize_t rows, const double* data) const;
  void read(hsize_t first, hsize_t rows, double* data) const;

 private:
  std::pair<h5::Space, h5::Space> select(hsize_t first, hsize_t rows) const;
};

/// Makes the dataset of an entry, with its scales, units and name, and so many rows for now.
Table make_table(hid_t file, const Entry& entry, hsize_t rows, hsize_t columns);

}  // namespace ra2d
