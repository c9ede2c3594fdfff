// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/checked_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <sstream>
#include <string_view>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/base/hash.hpp"
#include "host/base/text.hpp"
#include "host/store/entries.hpp"
#include "host/store/hdf5.hpp"
#include "host/store/plausible.hpp"
#include "host/store/result_reader.hpp"
#include "host/store/seal.hpp"
#include "host/store/table.hpp"
#include "host/system/child_answer.hpp"

namespace ra2d {
namespace {

using h5::check;

constexpr hsize_t checked_at_once = 1 << 16, longest_row = 1 << 28;

// of the child that asks HDF5
constexpr double least_memory = 512e6, least_seconds = 10;  // bytes, s
constexpr double least_speed = 20e6;                        // bytes/s, at which a file is read

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

/// Reads an attribute that is a number or a text, to see whether it can be read.
herr_t read_attribute(hid_t object, const char* name, const H5A_info_t*, void*) {
  const h5::Attribute attribute{H5Aopen(object, name, H5P_DEFAULT)};
  if (!attribute.is_open()) return -1;
  const h5::Type type{H5Aget_type(attribute)};
  const h5::Space space{H5Aget_space(attribute)};
  const H5T_class_t kind = H5Tget_class(type);
  if (H5Sget_simple_extent_npoints(space) != 1) return 0;
  if (H5Tis_variable_str(type) > 0) {
    char* characters = nullptr;
    if (H5Aread(attribute, type, &characters) < 0) return -1;
    H5free_memory(characters);
  } else if (kind == H5T_INTEGER || kind == H5T_FLOAT) {
    double number = 0;
    if (H5Aread(attribute, H5T_NATIVE_DOUBLE, &number) < 0) return -1;
  }
  return 0;
}

/// Hash, size and soundness of the numbers of a dataset.
class ReadNumbers {
 public:
  explicit ReadNumbers(hid_t dataset) {
    const h5::Type stored{check(H5Dget_type(dataset))};
    is_real_ = H5Tget_class(stored) == H5T_FLOAT;
    type_ = h5::Type{check(H5Tget_native_type(stored, H5T_DIR_ASCEND))};
    size_ = H5Tget_size(type_);
    if (size_ != H5Tget_size(stored) || size_ > sizeof(double) ||
        (is_real_ && size_ < sizeof(float)))
      throw h5::Failure{"its numbers are of a type that ra2d does not write"};
  }
  hid_t type() const { return type_; }
  std::size_t size() const { return size_; }  // bytes of a number
  void add(const std::string& block) {
    hash_.add(std::string_view{block});
    bytes += static_cast<double>(block.size());
    if (is_real_)
      finite = finite && (size_ == sizeof(float) ? all<float>(block) : all<double>(block));
  }
  std::string hash() const { return hash_.text(); }

  double bytes = 0;
  bool finite = true;

 private:
  template <class Number>
  static bool all(const std::string& block) {
    for (std::size_t at = 0; at + sizeof(Number) <= block.size(); at += sizeof(Number)) {
      Number number;
      std::memcpy(&number, block.data() + at, sizeof number);
      if (!is_of_a_run(number)) return false;
    }
    return true;
  }
  h5::Type type_;
  std::size_t size_ = 0;
  bool is_real_ = false;
  Hash hash_;
};

/// Block by block. `room`: bytes that the file has for them, of which it takes its own.
ReadNumbers read_numbers(hid_t dataset, double& room) {
  ReadNumbers found(dataset);
  const h5::Space space{check(H5Dget_space(dataset))};
  const int rank = check(H5Sget_simple_extent_ndims(space));
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  if (rank > 0) check(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
  double numbers = 1;
  for (const hsize_t length : extent) numbers *= static_cast<double>(length);
  if (h5::is_elsewhere(dataset)) throw h5::Failure{"it is kept in other files"};
  if (!h5::takes_room(dataset, numbers, room))
    throw h5::Failure{"it should hold more numbers than the file has room for"};
  std::string block;
  if (rank == 0) {
    block.resize(found.size());
    check(H5Dread(dataset, found.type(), H5S_ALL, H5S_ALL, H5P_DEFAULT, block.data()));
    found.add(block);
    return found;
  }
  hsize_t width = 1;  // numbers of a row
  for (std::size_t axis = 1; axis < extent.size(); ++axis) {
    if (extent[axis] > 0 && width > longest_row / extent[axis])
      throw h5::Failure{"its rows are too long"};
    width *= extent[axis];
  }
  const hsize_t at_once =
      std::max<hsize_t>(1, checked_at_once / std::max<hsize_t>(width * found.size(), 1));
  for (hsize_t first = 0; width > 0 && first < extent[0]; first += at_once) {
    std::vector<hsize_t> start(extent.size(), 0), count = extent;
    start[0] = first;
    count[0] = std::min(at_once, extent[0] - first);
    block.resize(count[0] * width * found.size());
    const h5::Space memory{check(H5Screate_simple(rank, count.data(), nullptr))};
    check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr));
    check(H5Dread(dataset, found.type(), memory, space, H5P_DEFAULT, block.data()));
    found.add(block);
  }
  return found;
}

struct Reading {
  CheckedFile found;
  double room = 0;  // bytes of the file that no dataset has taken yet
};

herr_t read_object(hid_t file, const char* name, const H5O_info_t* info, void* data) {
  auto& [found, room] = *static_cast<Reading*>(data);
  const std::string shown = printable(shortened(name, 80));
  try {
    const h5::Object object{check(H5Oopen(file, name, H5P_DEFAULT))};
    check(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, read_attribute, nullptr));
    if (info->type != H5O_TYPE_DATASET) return 0;
    ++found.datasets;
    const h5::Type type{check(H5Dget_type(object))};
    const H5T_class_t kind = H5Tget_class(type);
    if (kind != H5T_FLOAT && kind != H5T_INTEGER) return 0;  // texts carry no hash
    if (check(H5Aexists(object, "xxh3_128")) == 0) {
      found.faults.push_back(fmt::format("/{} has no hash", shown));
      return 0;
    }
    const ReadNumbers numbers = read_numbers(object, room);
    found.bytes += numbers.bytes;
    if (numbers.hash() != text_of(object, "xxh3_128"))
      found.faults.push_back(fmt::format("/{} is damaged: its numbers have another hash", shown));
    else if (!numbers.finite)
      found.not_finite.push_back(shown);
  } catch (const h5::Failure& failure) {
    found.faults.push_back(fmt::format("/{} cannot be read: {}", shown, failure.reason));
  }
  return 0;
}

/// Only a child process may call this: the bytes may be hostile.
CheckedFile read_objects(const std::filesystem::path& path) {
  Reading reading;
  const auto library = h5::take_library();
  try {
    const h5::Properties access = h5::file_access();
    const h5::File file{check(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access))};
    hsize_t size = 0;
    check(H5Fget_filesize(file, &size));
    reading.room = static_cast<double>(size);
    check(H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, read_object, &reading, H5O_INFO_BASIC));
  } catch (const h5::Failure& failure) {
    reading.found.faults.push_back(
        fmt::format("it cannot be read: {}: cut short, or damaged", failure.reason));
  }
  return reading.found;
}

/// No more nodes touch than the slider has.
void check_nodes(const ResultReader& reader, std::vector<std::string>& faults) {
  const std::size_t columns =
      reader.contents().is_areal ? reader.rows("surface/slider/position") : 1;
  const auto most = static_cast<double>(reader.rows("surface/slider/height") * columns);
  for (std::size_t first = 0; first < reader.contents().samples; first += rows_at_once) {
    const std::size_t count = std::min(rows_at_once, reader.contents().samples - first);
    for (const double nodes : reader.column("contact/nodes", first, count))
      if (!(nodes >= 0 && nodes <= most) || nodes != std::floor(nodes)) {
        faults.push_back(fmt::format(
            "/contact/nodes has {} nodes in contact, and the slider has {}", nodes, most));
        return;
      }
  }
}

/// Places along the bodies and numbers of modes rise. Times, shocks and probes are not asked: the
/// reader has looked at them, and a scene names its probes in any order.
void check_scales(const ResultReader& reader, std::vector<std::string>& faults) {
  for (const Entry& entry : entries()) {
    const std::string_view path = entry.path;
    if (path != entry.rows || !entry.is_of(reader.contents().is_areal) ||
        source_of<Fixed>(entry) == nullptr || path.find("probes/") != path.npos)
      continue;
    const std::vector<double> places = reader.column(entry.path, 0, reader.rows(entry.path));
    if (std::adjacent_find(places.begin(), places.end(), std::greater_equal<>{}) != places.end())
      faults.push_back(fmt::format("/{} does not rise: it is damaged", path));
  }
}

CheckedFile read_as_result(const std::filesystem::path& path) {
  CheckedFile found = read_objects(path);
  if (found.datasets == 0 && !found.faults.empty()) return found;
  for (const std::string& name : found.not_finite)
    if (!name.ends_with("/lv"))  // -inf at rest
      found.faults.push_back(
          fmt::format("/{} has values that are no numbers, or too large for any run", name));
  try {
    const ResultReader reader(path, Bytes::hostile);
    check_nodes(reader, found.faults);
    check_scales(reader, found.faults);
    const ResultSummary& summary = reader.contents().summary;
    found.what = summary.complete ? "a complete result"
                                  : fmt::format("a result that was cut short: {}",
                                                printable(shortened(summary.ended, 200)));
  } catch (const FileError& fault) {
    found.faults.emplace_back(fault.what());
  }
  return found;
}

// ---- a child's answer, as text ------------------------------------------------------------------

/// Each part with its length before it.
std::string packed(const CheckedFile& found) {
  std::string text = fmt::format("{} {} ", found.datasets, found.bytes);
  const auto put = [&](const std::string& part) {
    text += fmt::format("{} {}", part.size(), part);
  };
  put(found.what);
  for (const std::string& fault : found.faults) put(fault);
  return text;
}

CheckedFile unpacked(const std::string& text) {
  CheckedFile found;
  std::istringstream in(text);
  in >> found.datasets >> found.bytes;
  std::vector<std::string> parts;
  for (std::size_t size = 0; in >> size;) {
    in.get();
    std::string& part = parts.emplace_back(size, '\0');
    in.read(part.data(), static_cast<std::streamsize>(size));
  }
  if (parts.empty()) return found;
  found.what = parts.front();
  found.faults.assign(parts.begin() + 1, parts.end());
  return found;
}

/// The seal first, in this process. What HDF5 says comes from a child: a forger's seal fits, and of
/// a file whose seal does not fit HDF5 may still say what is damaged.
CheckedFile ask_of(const std::filesystem::path& path,
                   CheckedFile (*read)(const std::filesystem::path&)) {
  CheckedFile found;
  std::string unsealed;
  try {
    require_seal(path);
  } catch (const Unsealed& fault) {
    unsealed = fault.what();
  } catch (const std::runtime_error& fault) {  // FileError, Unreadable
    found.faults.emplace_back(fault.what());
    return found;
  }
  std::error_code none;
  const auto size = static_cast<double>(std::filesystem::file_size(path, none));
  const ChildAnswer answer =
      ask_in_child([&] { return packed(read(path)); }, least_memory + 4 * size,
                   least_seconds + size / least_speed);
  if (!answer.started && unsealed.empty())
    found = read(path);
  else if (answer.fault.empty())
    found = unpacked(answer.text);
  else
    found.faults.push_back(fmt::format("HDF5 cannot read it: it {}", answer.fault));
  if (!unsealed.empty()) found.faults.insert(found.faults.begin(), unsealed);
  return found;
}

}  // namespace

CheckedFile check_hashes(const std::filesystem::path& path) { return ask_of(path, read_objects); }

CheckedFile check_result(const std::filesystem::path& path) { return ask_of(path, read_as_result); }

}  // namespace ra2d
