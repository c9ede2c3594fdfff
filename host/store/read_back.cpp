// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/read_back.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <memory>
#include <string_view>

#include "host/store/hdf5.hpp"
#include "host/store/seal.hpp"
#include "host/store/sealed_hdf5.hpp"
#include "host/store/table.hpp"

namespace ra2d {
namespace {

using h5::check;

constexpr std::size_t read_at_once = 1024 * 1024;  // which are still at hand when they are hashed

void require_scales(hid_t file, const Table& table) {
  unsigned axis = 0;
  for (const std::string_view scale : {table.entry->rows, table.entry->columns}) {
    if (scale == table.entry->path) {
      require_as_given(check(H5DSis_scale(table.dataset)) > 0);
    } else if (!scale.empty()) {
      const h5::Dataset coordinate{check(H5Dopen2(file, scale.data(), H5P_DEFAULT))};
      require_as_given(check(H5DSis_attached(table.dataset, coordinate, axis++)) > 0);
    }
  }
}

/// Hashes all the numbers of a dataset.
void read_all(Table& table, const std::vector<hsize_t>& extent) {
  std::vector<double> rows(1);
  if (extent.empty()) {
    check(H5Dread(table.dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
    return table.add_to_hash(rows.data(), 1);
  }
  if (extent.size() == 2) table.width = extent[1];
  // whole chunks
  const hsize_t at_once = std::bit_floor(
      std::max<hsize_t>(read_at_once / (std::max<hsize_t>(table.width, 1) * sizeof(double)), 1));
  for (hsize_t first = 0; first < extent[0]; first += at_once) {
    const hsize_t count = std::min(at_once, extent[0] - first);
    rows.resize(count * table.width);
    table.read(first, count, rows.data());
    table.add_to_hash(rows.data(), rows.size());
  }
}

}  // namespace

void require_as_given(bool right) {
  if (!right) throw h5::Failure{"what was written does not read back", EIO};
}

void read_back(const std::filesystem::path& path, int descriptor, const GivenContent& given) try {
  const auto bytes = std::make_shared<SealedBytes>(descriptor);
  h5::File file = open_sealed(path, bytes);
  for (const h5::GivenAttribute& attribute : given.attributes)
    require_as_given(h5::holds(file, attribute));
  for (const auto& [path_of_group, attribute] : given.of_groups) {
    const h5::Group group{check(H5Gopen2(file, path_of_group.c_str(), H5P_DEFAULT))};
    require_as_given(h5::holds(group, attribute));
  }

  // Every number is read once: HDF5 may put them where they are wanted, without a copy of its own.
  const h5::Properties once{check(H5Pcreate(H5P_DATASET_ACCESS))};
  check(H5Pset_chunk_cache(once, 0, 0, 1));
  for (const GivenContent::Dataset& one : given.datasets) {
    Table table{one.entry, h5::Dataset{check(H5Dopen2(file, one.entry->path, once))}, 1,
                one.stored};
    const h5::Type type{check(H5Dget_type(table.dataset))};
    require_as_given(check(H5Tequal(type, file_type(one.stored))) > 0);
    const h5::Space space{check(H5Dget_space(table.dataset))};
    std::vector<hsize_t> extent(check(H5Sget_simple_extent_ndims(space)));
    check(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
    require_as_given(extent == one.extent);
    require_scales(file, table);
    for (const h5::GivenAttribute& attribute : one.attributes)
      require_as_given(h5::holds(table.dataset, attribute));
    read_all(table, extent);
    require_as_given(h5::holds(table.dataset, {"xxh3_128", table.hash.text()}));
  }
  check(file.close());
  bytes->check_rest();
} catch (const Unreadable&) {
  require_as_given(false);
}

}  // namespace ra2d
