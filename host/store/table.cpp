// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/table.hpp"

#include <algorithm>
#include <bit>
#include <string_view>

#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

using h5::check;

constexpr std::size_t chunk_bytes = 128 * 1024;

/// Rows of a chunk of a dataset that grows; a row has `width` numbers.
hsize_t chunk_rows(hsize_t width) {
  return std::clamp<hsize_t>(std::bit_floor(chunk_bytes / (width * sizeof(double))), 1,
                             rows_at_once);
}

}  // namespace

void Table::give(h5::GivenAttribute attribute) {
  h5::set_attribute(dataset, attribute);
  given.push_back(std::move(attribute));
}

void Table::resize(hsize_t rows) const {
  const hsize_t extent[] = {rows, width};
  check(H5Dset_extent(dataset, extent));
}

void Table::write(hsize_t first, hsize_t rows, const double* data) const {
  if (rows * width == 0) return;
  const hsize_t chunk = chunk_rows(width), end = first + rows;
  for (; first % chunk == 0 && first + chunk <= end; first += chunk, data += chunk * width) {
    const hsize_t place[] = {first, 0};
    check(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, place, chunk * width * sizeof(double), data));
  }
  if (first == end) return;
  const auto [memory, file] = select(first, end - first);
  check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, file, H5P_DEFAULT, data));
}

void Table::read(hsize_t first, hsize_t rows, double* data) const {
  if (rows * width == 0) return;
  const auto [memory, file] = select(first, rows);
  check(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, file, H5P_DEFAULT, data));
}

std::pair<h5::Space, h5::Space> Table::select(hsize_t first, hsize_t rows) const {
  const hsize_t start[] = {first, 0}, count[] = {rows, width};
  h5::Space memory{check(H5Screate_simple(entry->has_columns() ? 2 : 1, count, nullptr))};
  h5::Space file{check(H5Dget_space(dataset))};
  check(H5Sselect_hyperslab(file, H5S_SELECT_SET, start, nullptr, count, nullptr));
  return {std::move(memory), std::move(file)};
}

Table make_table(hid_t file, const Entry& entry, hsize_t rows, hsize_t columns) {
  const h5::Properties creation = h5::ordered(H5P_DATASET_CREATE);
  check(H5Pset_fill_value(creation, H5T_NATIVE_DOUBLE, &quiet_nan));

  const bool has_columns = entry.has_columns();
  h5::Space space;
  if (source_of<Final>(entry)) {
    space = h5::Space{check(H5Screate(H5S_SCALAR))};
  } else if (source_of<Fixed>(entry)) {
    const hsize_t extent[] = {rows, columns};
    space = h5::Space{check(H5Screate_simple(has_columns ? 2 : 1, extent, nullptr))};
  } else {
    // HDF5 wants chunks of at least one number and no larger than the axis may grow: an axis
    // without modes may therefore grow to one.
    const hsize_t width = std::max<hsize_t>(columns, 1);
    const hsize_t chunk[] = {chunk_rows(width), width};
    const hsize_t now[] = {rows, columns}, later[] = {H5S_UNLIMITED, width};
    space = h5::Space{check(H5Screate_simple(has_columns ? 2 : 1, now, later))};
    check(H5Pset_chunk(creation, has_columns ? 2 : 1, chunk));
  }
  Table table{&entry,
              h5::Dataset{check(H5Dcreate2(file, entry.path, H5T_IEEE_F64LE, space, H5P_DEFAULT,
                                           creation, H5P_DEFAULT))},
              columns,
              {}};
  table.give({"units", entry.units});
  table.give({"long_name", entry.long_name});

  unsigned axis = 0;
  for (const std::string_view scale : {entry.rows, entry.columns}) {
    if (scale == entry.path) {
      const auto name = scale.substr(scale.rfind('/') + 1);  // npos + 1 = 0: the whole
      check(H5DSset_scale(table.dataset, name.data()));
    } else if (!scale.empty()) {
      h5::Dataset coordinate{check(H5Dopen2(file, scale.data(), H5P_DEFAULT))};
      check(H5DSattach_scale(table.dataset, coordinate, axis++));
      h5::close(coordinate);
    }
  }
  return table;
}

}  // namespace ra2d
