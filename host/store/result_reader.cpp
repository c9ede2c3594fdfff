// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/result_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/base/text.hpp"
#include "host/store/entries.hpp"
#include "host/store/hdf5.hpp"
#include "host/store/plausible.hpp"
#include "host/store/seal.hpp"
#include "host/store/sealed_hdf5.hpp"
#include "host/store/table.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

using h5::check;

constexpr double evenness = 1e-3;  // how far a sample may stand from its place, in samples

/// A fault of a file, without its path.
struct Fault {
  std::string text;
};

bool has(hid_t file, const char* path) { return check(H5Lexists(file, path, H5P_DEFAULT)) > 0; }

h5::Attribute open_attribute(hid_t file, const char* name) {
  if (check(H5Aexists(file, name)) == 0)
    throw Fault{fmt::format("its attribute '{}' is missing", name)};
  return h5::Attribute{check(H5Aopen(file, name, H5P_DEFAULT))};
}

/// Reading more than one value would write beyond the memory for one.
bool is_single(hid_t attribute) {
  const h5::Space space{check(H5Aget_space(attribute))};
  return check(H5Sget_simple_extent_npoints(space)) == 1;
}

std::string text_attribute(hid_t file, const char* name) {
  const h5::Attribute attribute = open_attribute(file, name);
  const h5::Type type{check(H5Aget_type(attribute))};
  if (H5Tis_variable_str(type) <= 0 || !is_single(attribute))
    throw Fault{fmt::format("its attribute '{}' is no text", name)};
  char* characters = nullptr;
  check(H5Aread(attribute, type, &characters));
  std::string text = characters == nullptr ? "" : characters;
  H5free_memory(characters);
  return text;
}

std::int64_t number_attribute(hid_t file, const char* name) {
  const h5::Attribute attribute = open_attribute(file, name);
  const h5::Type type{check(H5Aget_type(attribute))};
  if (H5Tget_class(type) != H5T_INTEGER || !is_single(attribute))
    throw Fault{fmt::format("its attribute '{}' is no whole number", name)};
  std::int64_t number = 0;
  check(H5Aread(attribute, H5T_NATIVE_INT64, &number));
  return number;
}

/// The extent of a dataset of numbers.
std::vector<hsize_t> extent_of(hid_t dataset, const char* path) {
  const h5::Type type{check(H5Dget_type(dataset))};
  if (const H5T_class_t kind = H5Tget_class(type); kind != H5T_FLOAT && kind != H5T_INTEGER)
    throw Fault{fmt::format("/{} holds no numbers", path)};
  const h5::Space space{check(H5Dget_space(dataset))};
  std::vector<hsize_t> extent(check(H5Sget_simple_extent_ndims(space)));
  check(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
  return extent;
}

/// Whether every dataset is there, and as long as its axes. All together they hold no more numbers
/// than a file of `room` bytes can. Returns whether the modes' motion is among them: all of it or
/// nothing.
bool require_shapes(hid_t file, std::int64_t format, double room) {
  std::map<std::string_view, hsize_t> length;  // of the scales
  const bool has_modes = !has(file, "resonator") || has(file, "resonator/velocity");
  for (const Entry& entry : entries()) {
    if (!entry.is_of(format == areal_format)) continue;
    const char* const path = entry.path_in(format);
    const bool may_be_missing =
        source_of<Final>(entry) || (entry.is_modal() && !has_modes) || path == entry.old_path;
    if (may_be_missing && !has(file, path)) continue;  // there was none
    if (entry.is_modal() && !has_modes)
      throw Fault{fmt::format("/{} is there, and /resonator/velocity is not", path)};
    const h5::Dataset dataset{H5Dopen2(file, path, H5P_DEFAULT)};
    if (!dataset.is_open()) {
      h5::require_undamaged();
      throw Fault{fmt::format("/{} is missing", path)};
    }
    if (h5::is_elsewhere(dataset)) throw Fault{fmt::format("/{} is kept in other files", path)};
    const std::vector<hsize_t> extent = extent_of(dataset, path);
    const h5::Type type{check(H5Dget_type(dataset))};
    if (H5Tget_class(type) !=
        (entry.numbers == Numbers::whole && format >= file_format ? H5T_INTEGER : H5T_FLOAT))
      throw Fault{fmt::format("/{} holds numbers of another type", path)};
    // a scale comes first and says how long its axis is; format 2 may have no shocks/serial
    if (extent.size() == 1) length.try_emplace(entry.rows, extent[0]);
    std::vector<hsize_t> expected;
    double numbers = 1;
    for (const std::string_view scale : {entry.rows, entry.columns})
      if (!scale.empty()) {
        expected.push_back(length[scale]);
        numbers *= static_cast<double>(expected.back());
      }
    if (extent != expected)
      throw Fault{fmt::format("/{} is of the shape ({}), its axes of ({})", path,
                              fmt::join(extent, ", "), fmt::join(expected, ", "))};
    if (!h5::takes_room(dataset, numbers, room))
      throw Fault{fmt::format("/{} should hold more numbers than the file has room for", path)};
  }
  return has_modes;
}

/// Missing values read as NaN.
void require_finite(const std::vector<double>& data, const char* path) {
  if (!std::all_of(data.begin(), data.end(), is_of_a_run))
    throw Fault{fmt::format(
        "/{} has values that are no numbers, or too large for any run: it is damaged", path)};
}

/// A whole dataset.
std::vector<double> all_of(hid_t file, const char* path) {
  const h5::Dataset dataset{check(H5Dopen2(file, path, H5P_DEFAULT))};
  hsize_t numbers = 1;
  for (const hsize_t length : extent_of(dataset, path)) numbers *= length;
  std::vector<double> data(numbers);
  if (numbers > 0)
    check(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()));
  return data;
}

constexpr double most_serials = 0x1p53;  // which a double counts one by one

void require_serials(const std::vector<double>& serials, const char* path) {
  double last = -1;
  for (const double serial : serials) {
    if (!(serial > last && serial < most_serials && serial == std::floor(serial)))
      throw Fault{fmt::format("/{} does not ascend in whole numbers: it is damaged", path)};
    last = serial;
  }
}

std::vector<Shock> shocks_of(hid_t file, std::int64_t format) {
  std::vector<Shock> shocks;
  bool numbered = false;
  for (const Entry& entry : entries())
    if (const PerShock* member = source_of<PerShock>(entry);
        member != nullptr && entry.is_of(format == areal_format)) {
      const char* const path = entry.path_in(format);
      if (path == entry.old_path && !has(file, path)) continue;
      const std::vector<double> values = all_of(file, path);
      require_finite(values, path);
      if (entry.numbers == Numbers::whole) {
        require_serials(values, path);
        numbered = true;
      }
      shocks.resize(values.size());
      for (std::size_t i = 0; i < values.size(); ++i) member->set(shocks[i], values[i]);
    }
  for (std::size_t i = 0; i < shocks.size() && !numbered; ++i)
    shocks[i].serial = static_cast<long>(i);
  return shocks;
}

ResultSummary summary_of(hid_t file) {
  ResultSummary summary;
  for (const Entry& entry : entries())
    if (const Final* member = source_of<Final>(entry))
      summary.** member = has(file, entry.path) ? all_of(file, entry.path).front() : quiet_nan;
  for (const Entry& entry : entries())  // level and velocity stand there twice
    if (const Final* member = source_of<Final>(entry);
        member != nullptr && has(file, entry.path) &&
        !(all_of(file, entry.path).front() == summary.**member))
      throw Fault{fmt::format("/{} has another value than the file has elsewhere", entry.path)};
  summary.steps = number_attribute(file, "steps");
  summary.complete = number_attribute(file, "complete") != 0;
  summary.ended = text_attribute(file, "ended");
  if (check(H5Aexists(file, "warnings")) > 0) summary.warnings = text_attribute(file, "warnings");
  return summary;
}

/// The rate of samples that stand evenly; a whole one without the roundings of its times.
double rate_of(const std::vector<double>& time) {
  if (time.size() < 2) return quiet_nan;
  const double rate = static_cast<double>(time.size() - 1) / (time.back() - time.front());
  for (std::size_t j = 0; j < time.size(); ++j)
    if (!(std::abs((time[j] - time.front()) * rate - static_cast<double>(j)) < evenness))
      throw Fault{fmt::format("its samples do not stand evenly: the {}th is at {} s", j, time[j])};
  const double whole = std::round(rate);
  return std::abs(rate - whole) < 1e-9 * rate ? whole : rate;
}

ResultContents contents_of(hid_t file, std::int64_t format) {
  ResultContents contents;
  contents.scene = text_attribute(file, "scene");
  contents.origin = fmt::format("ra2d {} ({}), started {}", text_attribute(file, "version"),
                                text_attribute(file, "commit"), text_attribute(file, "started"));
  if (check(H5Aexists(file, "beyond_limit")) > 0)
    contents.beyond_limit = text_attribute(file, "beyond_limit");
  if (check(H5Aexists(file, "key")) > 0) contents.key = text_attribute(file, "key");
  const std::vector<double> time = all_of(file, "time");
  contents.samples = time.size();
  contents.rate = rate_of(time);
  contents.start = time.empty() ? quiet_nan : time.front();
  contents.end = time.empty() ? quiet_nan : time.back();
  contents.resonator_frequency = all_of(file, "resonator/frequency");
  contents.slider_frequency = all_of(file, "slider/frequency");
  contents.mean_square = all_of(file, "resonator/mean_square");
  contents.probe_position = all_of(file, "probes/position");
  contents.slider_probe_position = all_of(file, "slider_probes/position");
  if (format == areal_format) {
    contents.probe_y = all_of(file, "probes/y");
    contents.slider_probe_y = all_of(file, "slider_probes/y");
  }
  contents.shocks = shocks_of(file, format);
  contents.summary = summary_of(file);
  if (const std::string what = implausible(contents); !what.empty()) throw Fault{what};
  return contents;
}

h5::File open(const std::filesystem::path& path, Bytes bytes) {
  h5::File file;
  if (bytes == Bytes::hostile) {
    const h5::Properties access = h5::file_access();
    file = h5::File{check(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access))};
  } else {
    file = open_sealed(path);
  }
  if (check(H5Aexists(file, "creator")) == 0 || text_attribute(file, "creator") != "ra2d" ||
      check(H5Aexists(file, "format")) == 0)
    throw Fault{"it is no result of ra2d: expected a file that 'ra2d run' wrote"};
  if (const std::int64_t format = number_attribute(file, "format");
      format < oldest_format || format > areal_format || format == old_areal_format)
    throw Fault{fmt::format(
        "its format is {}, and this program reads {}, {} and {}: {}", format, oldest_format,
        file_format, areal_format,
        format > areal_format ? "a newer ra2d wrote it" : "run its scene again with this program")};
  return file;
}

constexpr const char* cure_of_readers =
    "Take a copy of it that is whole, or run its scene again with 'ra2d run --force'";

/// Runs what calls HDF5, and says of which file it was.
template <class Body>
auto guarded(const std::filesystem::path& path, Body body, const char* cure = cure_of_readers) {
  const auto library = h5::take_library();
  const h5::CrashWatch watch(path);
  const auto fault = [&](const std::string& what) {
    return UnreadableResult(path, shortened(what, 300));
  };
  try {
    return body();
  } catch (const Fault& found) {
    throw fault(found.text);
  } catch (const Unsealed& found) {
    throw fault(*cure == '\0' ? found.what() : fmt::format("{}. {}", found.what(), cure));
  } catch (const Unreadable& found) {
    throw fault(found.what());
  } catch (const h5::Failure& failure) {
    throw fault(fmt::format("{}: it is cut short or damaged", failure.reason));
  }
}

}  // namespace

UnreadableResult::UnreadableResult(const std::filesystem::path& file, const std::string& why)
    : FileError(fmt::format("cannot read '{}': {}", file.string(), why)), reason{why} {}

ResultStamp read_stamp(const std::filesystem::path& path) {
  return guarded(
      path,
      [&] {
        require_seal(path);  // all of it: a damaged run is not complete
        const h5::File file = open(path, Bytes::sealed);
        ResultStamp stamp;
        stamp.complete = number_attribute(file, "complete") == 1;
        stamp.steps = number_attribute(file, "steps");
        stamp.started = text_attribute(file, "started");
        stamp.scene = text_attribute(file, "scene");
        stamp.ended = text_attribute(file, "ended");
        if (check(H5Aexists(file, "key")) > 0) stamp.key = text_attribute(file, "key");
        return stamp;
      },
      "");  // callers know what can be done
}

std::optional<ResultStamp> stamp_of(const std::filesystem::path& path) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none) || !is_hdf5(path)) return std::nullopt;
  return read_stamp(path);
}

bool is_hdf5(const std::filesystem::path& file) {
  return guarded(file, [&] { return looks_like_hdf5(file); });
}

struct ResultReader::Impl {
  std::filesystem::path path;
  h5::File file;
  ResultContents contents;
};

ResultReader::ResultReader(const std::filesystem::path& path, Bytes bytes)
    : impl_{std::make_unique<Impl>()} {
  impl_->path = path;
  guarded(path, [&] {
    impl_->file = open(path, bytes);
    try {
      hsize_t size = 0;
      check(H5Fget_filesize(impl_->file, &size));
      const std::int64_t format = number_attribute(impl_->file, "format");
      const bool has_modes = require_shapes(impl_->file, format, static_cast<double>(size));
      impl_->contents = contents_of(impl_->file, format);
      impl_->contents.has_modes = has_modes;
      impl_->contents.is_areal = format == areal_format;
    } catch (...) {
      impl_->file = {};  // closed under the watch, too
      throw;
    }
  });
}

ResultReader::~ResultReader() {
  const auto library = h5::take_library();
  const h5::CrashWatch watch(impl_->path);
  impl_.reset();
}

const ResultContents& ResultReader::contents() const { return impl_->contents; }

void ResultReader::require_modes() const {
  if (contents().has_modes) return;
  throw RequestError(
      fmt::format("'{}' has no motion of the modes: its scene has output.modes = \"none\". Run it "
                  "again with --set output.modes=all",
                  impl_->path.string()));
}

std::vector<std::vector<double>> ResultReader::columns(const char* dataset, std::size_t first,
                                                       std::size_t rows, std::size_t column,
                                                       std::size_t count) const {
  for (const Entry& entry : entries())
    if (entry.path == std::string_view{dataset} && entry.is_modal()) require_modes();
  std::vector<std::vector<double>> found(count, std::vector<double>(rows));
  guarded(impl_->path, [&] {
    const h5::Dataset data{check(H5Dopen2(impl_->file, dataset, H5P_DEFAULT))};
    const h5::Space file{check(H5Dget_space(data))};
    const int rank = check(H5Sget_simple_extent_ndims(file));
    std::vector<double> block;
    for (std::size_t done = 0; count > 0 && done < rows; done += rows_at_once) {
      const std::size_t now = std::min(rows_at_once, rows - done);
      const hsize_t start[] = {first + done, column}, size[] = {now, count};
      block.resize(now * count);
      const h5::Space memory{check(H5Screate_simple(rank, size, nullptr))};
      check(H5Sselect_hyperslab(file, H5S_SELECT_SET, start, nullptr, size, nullptr));
      check(H5Dread(data, H5T_NATIVE_DOUBLE, memory, file, H5P_DEFAULT, block.data()));
      require_finite(block, dataset);
      for (std::size_t k = 0; k < count; ++k)
        for (std::size_t j = 0; j < now; ++j) found[k][done + j] = block[j * count + k];
    }
  });
  return found;
}

SampleBlock ResultReader::samples(std::size_t first, std::size_t count) const {
  SampleBlock block;
  guarded(impl_->path, [&] {
    for (const Entry& entry : entries())
      if (const Sampled* member = source_of<Sampled>(entry);
          member != nullptr && entry.is_of(contents().is_areal)) {
        if (entry.is_modal() && !contents().has_modes) continue;
        Table table{&entry, h5::Dataset{check(H5Dopen2(impl_->file, entry.path, H5P_DEFAULT))}};
        const std::vector<hsize_t> extent = extent_of(table.dataset, entry.path);
        if (entry.has_columns()) table.width = extent.back();
        std::vector<double>& rows = block.**member;
        rows.resize(count * table.width);
        table.read(first, count, rows.data());
        require_finite(rows, entry.path);
      }
  });
  return block;
}

std::size_t ResultReader::rows(const char* dataset) const {
  return guarded(impl_->path, [&]() -> std::size_t {
    const h5::Dataset data{check(H5Dopen2(impl_->file, dataset, H5P_DEFAULT))};
    return extent_of(data, dataset).at(0);
  });
}

std::vector<double> ResultReader::column(const char* dataset, std::size_t first,
                                         std::size_t rows) const {
  return std::move(columns(dataset, first, rows, 0, 1).front());
}

}  // namespace ra2d
