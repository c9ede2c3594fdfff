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

/// The most rows that are read from a table at once: 64 KiB of one column.
inline constexpr std::size_t rows_at_once = 8192;

/// Rows of a chunk of a dataset that grows; a row has `width` numbers. A file has whole chunks.
hsize_t chunk_rows(hsize_t width);

/// A dataset, seen as rows of `width` numbers; the first axis may grow.
struct Table {
  const Entry* entry = nullptr;
  h5::Dataset dataset;
  hsize_t width = 1;
  Stored stored = Stored::real64;
  bool is_compressed = false;
  Hash hash{};                              // of the rows that were given, as they are stored
  std::vector<h5::GivenAttribute> given{};  // its attributes

  void give(h5::GivenAttribute attribute);
  void add_to_hash(const double* data, std::size_t count);
  void resize(hsize_t rows) const;
  /// Writes rows of a dataset that grows. Whole chunks bypass HDF5's cache.
  void write(hsize_t first, hsize_t rows, const double* data) const;
  void read(hsize_t first, hsize_t rows, double* data) const;
  /// Writes all the numbers of a dataset that does not grow.
  void write_all(const double* data) const;

 private:
  std::pair<h5::Space, h5::Space> select(hsize_t first, hsize_t rows) const;
};

/// The type of stored numbers in a file.
hid_t file_type(Stored stored);

/// Makes the dataset of an entry with its scales, units and name. It has `rows` rows for now.
Table make_table(hid_t file, const Entry& entry, const ResultHeader& header, hsize_t rows,
                 hsize_t columns);

}  // namespace ra2d
