// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/checked_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "host/errors.hpp"
#include "host/hash.hpp"
#include "host/input_file.hpp"
#include "host/store/hdf5.hpp"
#include "host/store/result_reader.hpp"
#include "host/text.hpp"

namespace ra2d {
namespace {

using h5::check;

constexpr hsize_t bytes_at_once = 1 << 16, longest_row = 1 << 28;

/// The text of an attribute; empty where it is no single text.
std::string text_of(hid_t object, const char* name) {
  const h5::Attribute attribute{check(H5Aopen(object, name, H5P_DEFAULT))};
  const h5::Type type{check(H5Aget_type(attribute))};
  const h5::Space space{check(H5Aget_space(attribute))};
  if (H5Tis_variable_str(type) <= 0 || H5Sget_simple_extent_npoints(space) != 1) return {};
  char* characters = nullptr;
  check(H5Aread(attribute, type, &characters));
  std::string text = characters != nullptr ? characters : "";
  H5free_memory(characters);
  return text;
}

/// Hash of the numbers of a dataset, block by block.
std::string hash_of(hid_t dataset, double& bytes) {
  const h5::Space space{check(H5Dget_space(dataset))};
  const int rank = check(H5Sget_simple_extent_ndims(space));
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  if (rank > 0) check(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
  Hash hash;
  if (rank == 0) {
    double number = 0;
    check(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &number));
    hash.add(&number, 1);
    bytes += sizeof number;
    return hash.text();
  }
  hsize_t width = 1;  // numbers of a row
  for (std::size_t axis = 1; axis < extent.size(); ++axis) {
    if (extent[axis] > 0 && width > longest_row / extent[axis])
      throw h5::Failure{"its rows are too long"};
    width *= extent[axis];
  }
  if (width == 0) return hash.text();
  const hsize_t at_once = std::max<hsize_t>(1, bytes_at_once / (width * sizeof(double)));
  std::vector<double> block;
  for (hsize_t first = 0; first < extent[0]; first += at_once) {
    std::vector<hsize_t> start(extent.size(), 0), count = extent;
    start[0] = first;
    count[0] = std::min(at_once, extent[0] - first);
    block.resize(count[0] * width);
    const h5::Space memory{check(H5Screate_simple(rank, count.data(), nullptr))};
    check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr));
    check(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, block.data()));
    hash.add(block.data(), block.size());
    bytes += static_cast<double>(block.size() * sizeof(double));
  }
  return hash.text();
}

herr_t look_at(hid_t file, const char* name, const H5O_info_t* info, void* data) {
  auto& found = *static_cast<CheckedFile*>(data);
  if (info->type != H5O_TYPE_DATASET) return 0;
  const std::string shown = printable(shortened(name, 80));
  try {
    const h5::Dataset dataset{check(H5Dopen2(file, name, H5P_DEFAULT))};
    ++found.datasets;
    const h5::Type type{check(H5Dget_type(dataset))};
    if (H5Tget_class(type) != H5T_FLOAT) return 0;  // texts carry no hash
    if (check(H5Aexists(dataset, "xxh3_128")) == 0) {
      found.faults.push_back(fmt::format("/{} has no hash", shown));
      return 0;
    }
    if (hash_of(dataset, found.bytes) != text_of(dataset, "xxh3_128"))
      found.faults.push_back(fmt::format("/{} is damaged: its numbers have another hash", shown));
  } catch (const h5::Failure& failure) {
    found.faults.push_back(fmt::format("/{} cannot be read: {}", shown, failure.reason));
  }
  return 0;
}

}  // namespace

CheckedFile check_hashes(const std::filesystem::path& path) {
  CheckedFile found;
  const InputFile readable(path);  // before HDF5 is asked, which would wait for a pipe
  const auto library = h5::take_library();
  try {
    const h5::Properties access = h5::file_access();
    const h5::File file{check(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access))};
    check(H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at, &found, H5O_INFO_BASIC));
  } catch (const h5::Failure& failure) {
    found.faults.push_back(
        fmt::format("it cannot be read: {}: cut short, or damaged", failure.reason));
  }
  return found;
}

CheckedFile check_result(const std::filesystem::path& path) {
  CheckedFile found = check_hashes(path);
  if (found.datasets == 0 && !found.faults.empty()) return found;
  try {
    const ResultReader reader(path);
    const ResultSummary& summary = reader.contents().summary;
    found.what = summary.complete ? "a complete result"
                                  : fmt::format("a result that was cut short: {}",
                                                printable(shortened(summary.ended, 200)));
  } catch (const FileError& fault) {
    found.faults.emplace_back(fault.what());
  }
  return found;
}

}  // namespace ra2d
