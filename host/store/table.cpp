// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

using h5::check;

/// Numbers as they stand in a file.
class StoredNumbers {
 public:
  StoredNumbers(Stored as, const double* data, std::size_t count) {
    if (as == Stored::real64) {
      bytes_ = {reinterpret_cast<const char*>(data), count * sizeof(double)};
    } else if (as == Stored::real32) {
      // a run that blows up passes what a float holds before what a double holds
      constexpr double most = std::numeric_limits<float>::max();
      convert<float>(data, count, [=](double x) { return std::clamp(x, -most, most); });
    } else {
      convert<std::int64_t>(data, count, [](double x) { return std::abs(x) < 0x1p53 ? x : -1.0; });
    }
  }
  const void* data() const { return bytes_.data(); }
  std::string_view bytes() const { return bytes_; }

 private:
  template <class Number, class Bound>
  void convert(const double* data, std::size_t count, Bound bound) {
    made_.resize(count * sizeof(Number));
    for (std::size_t i = 0; i < count; ++i) {
      const auto number = static_cast<Number>(bound(data[i]));
      std::memcpy(made_.data() + i * sizeof number, &number, sizeof number);
    }
    bytes_ = made_;
  }
  std::string made_;
  std::string_view bytes_;
};

}  // namespace

hsize_t chunk_rows(hsize_t width) {
  constexpr std::size_t chunk_bytes = 128 * 1024;
  return std::clamp<hsize_t>(std::bit_floor(chunk_bytes / (width * sizeof(double))), 1,
                             rows_at_once);
}

void Table::give(h5::GivenAttribute attribute) {
  h5::set_attribute(dataset, attribute);
  given.push_back(std::move(attribute));
}

void Table::add_to_hash(const double* data, std::size_t count) {
  hash.add(StoredNumbers(stored, data, count).bytes());
}

void Table::resize(hsize_t rows) const {
  const hsize_t extent[] = {rows, width};
  check(H5Dset_extent(dataset, extent));
}

void Table::write(hsize_t first, hsize_t rows, const double* data) const {
  if (rows * width == 0) return;
  const hsize_t chunk = chunk_rows(width), end = first + rows;
  for (; !is_compressed && first % chunk == 0 && first + chunk <= end;
       first += chunk, data += chunk * width) {
    const hsize_t place[] = {first, 0};
    const StoredNumbers numbers(stored, data, chunk * width);
    check(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, place, numbers.bytes().size(), numbers.data()));
  }
  if (first == end) return;
  const auto [memory, file] = select(first, end - first);
  const StoredNumbers numbers(stored, data, (end - first) * width);
  check(H5Dwrite(dataset, file_type(stored), memory, file, H5P_DEFAULT, numbers.data()));
}

void Table::write_all(const double* data) const {
  const h5::Space space{check(H5Dget_space(dataset))};
  const hssize_t count = check(H5Sget_simple_extent_npoints(space));
  const StoredNumbers numbers(stored, data, static_cast<std::size_t>(count));
  check(H5Dwrite(dataset, file_type(stored), H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()));
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

hid_t file_type(Stored stored) {
  return stored == Stored::real64   ? H5T_IEEE_F64LE
         : stored == Stored::real32 ? H5T_IEEE_F32LE
                                    : H5T_STD_I64LE;
}

Table make_table(hid_t file, const Entry& entry, const ResultHeader& header, hsize_t rows,
                 hsize_t columns) {
  const Stored stored = stored_in(entry, header);
  const h5::Properties creation = h5::ordered(H5P_DATASET_CREATE);
  // of rows that were never written
  const double empty = stored == Stored::integer64 ? -1.0 : quiet_nan;
  check(H5Pset_fill_value(creation, H5T_NATIVE_DOUBLE, &empty));

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
  const bool is_compressed = entry.is_sampled() && header.compression == Compression::deflate;
  if (is_compressed) {
    constexpr unsigned deflate_level = 4;  // higher ones take longer and save less than 1 % more
    check(H5Pset_shuffle(creation));
    check(H5Pset_deflate(creation, deflate_level));
  }
  Table table{&entry,
              h5::Dataset{check(H5Dcreate2(file, entry.path, file_type(stored), space, H5P_DEFAULT,
                                           creation, H5P_DEFAULT))},
              columns, stored, is_compressed};
  table.give({"units", header.is_areal && entry.areal_units ? entry.areal_units : entry.units});
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
