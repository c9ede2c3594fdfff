// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include "host/errors.hpp"
#include "host/partial_file.hpp"
#include "host/store/hash.hpp"
#include "host/store/hdf5.hpp"
#include "host/store/writer_thread.hpp"

#ifndef RA2D_VERSION
#define RA2D_VERSION "unknown"
#endif
#ifndef RA2D_COMMIT
#define RA2D_COMMIT "unknown"
#endif

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using h5::check;

constexpr std::int64_t format =
    2;  // of the file; raised when a dataset changes its meaning or goes
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t rows_at_once = 8192;          // 64 KiB of one column: a chunk, a shock window
constexpr std::size_t bytes_at_once = 4096 * 1024;  // buffered, and written between two flushes
constexpr std::size_t bytes_read_at_once = 1024 * 1024;  // which are still at hand when hashed
constexpr std::size_t chunk_bytes = 128 * 1024;

/// Of datasets that grow, in rows of so many numbers.
hsize_t chunk_rows(hsize_t width) {
  return std::clamp<hsize_t>(std::bit_floor(chunk_bytes / (width * sizeof(double))), 1,
                             rows_at_once);
}

// Where the numbers of a dataset come from, which also says when they are written.
using Fixed = std::vector<double> (*)(const ResultHeader&);  // at the start, (rows, columns)
using Sampled = std::vector<double> SampleBlock::*;          // block by block
using PerShock = double Shock::*;                            // one row a shock
using Final = double ResultSummary::*;                       // at the end, scalar; NaN: left out

struct Entry {
  const char *path, *units, *long_name;
  const char *rows, *columns;  // the scales of its axes; a scale is its own; "" where there is none
  std::variant<Fixed, Sampled, PerShock, Final> source;
};

std::vector<double> node_positions(std::size_t nodes, double spacing) {
  std::vector<double> x(nodes);
  for (std::size_t n = 0; n < nodes; ++n) x[n] = double(n) * spacing;
  return x;
}

std::vector<double> numbers(std::size_t count) { return node_positions(count, 1.0); }

constexpr const char* groups[] = {
    "resonator", "slider", "contact", "probes",  "slider_probes",  "energy",
    "shocks",    "level",  "summary", "surface", "surface/slider", "surface/resonator"};

/// Those that hold samples: the time stands in each, so that it can be read alone.
constexpr const char* sampled_groups[] = {"resonator", "slider",        "contact",
                                          "probes",    "slider_probes", "energy"};

// Everything the file holds (contract: "Output"), in the order readers list it. Scales come before
// the datasets that use them.
// clang-format off
const Entry entries[] = {
    {"time", "s", "time", "time", "", &SampleBlock::time},
    {"resonator/mode", "1", "numbers of the resonator's modes, rigid ones first", "resonator/mode", "",
     [](const ResultHeader& h) { return numbers(h.resonator.frequency.size()); }},
    {"resonator/position", "m", "places on the resonator from its left end", "resonator/position", "",
     [](const ResultHeader& h) { return h.resonator.position; }},
    {"resonator/frequency", "Hz", "natural frequencies of the resonator", "resonator/mode", "",
     [](const ResultHeader& h) { return h.resonator.frequency; }},
    {"resonator/shape", "m-0.5", "mode shapes of the resonator", "resonator/mode", "resonator/position",
     [](const ResultHeader& h) { return h.resonator.shape; }},
    {"resonator/mean_square", "m-1", "mean squares of the elastic mode shapes over all nodes", "resonator/mode", "",
     [](const ResultHeader& h) { return h.resonator.mean_square.get(); }},
    {"resonator/displacement", "m1.5", "modal displacements of the resonator", "time", "resonator/mode", &SampleBlock::resonator_displacement},
    {"resonator/velocity", "m1.5 s-1", "modal velocities of the resonator", "time", "resonator/mode", &SampleBlock::resonator_velocity},
    {"slider/mode", "1", "numbers of the slider's modes, rigid ones first", "slider/mode", "",
     [](const ResultHeader& h) { return numbers(h.slider.frequency.size()); }},
    {"slider/position", "m", "places on the slider from its left end", "slider/position", "",
     [](const ResultHeader& h) { return h.slider.position; }},
    {"slider/frequency", "Hz", "natural frequencies of the slider", "slider/mode", "",
     [](const ResultHeader& h) { return h.slider.frequency; }},
    {"slider/shape", "m-0.5", "mode shapes of the slider", "slider/mode", "slider/position",
     [](const ResultHeader& h) { return h.slider.shape; }},
    {"slider/mean_square", "m-1", "mean squares of the elastic mode shapes over all nodes", "slider/mode", "",
     [](const ResultHeader& h) { return h.slider.mean_square.get(); }},
    {"slider/displacement", "m1.5", "modal displacements of the slider", "time", "slider/mode", &SampleBlock::slider_displacement},
    {"slider/velocity", "m1.5 s-1", "modal velocities of the slider", "time", "slider/mode", &SampleBlock::slider_velocity},
    {"contact/force", "N", "total normal contact force", "time", "", &SampleBlock::force},
    {"contact/nodes", "1", "number of nodes in contact", "time", "", &SampleBlock::nodes},
    {"probes/position", "m", "positions of the probes on the resonator", "probes/position", "",
     [](const ResultHeader& h) { return h.probe_position; }},
    {"probes/displacement", "m", "displacements of the resonator at the probes", "time", "probes/position", &SampleBlock::probe_displacement},
    {"probes/velocity", "m s-1", "velocities of the resonator at the probes", "time", "probes/position", &SampleBlock::probe_velocity},
    {"slider_probes/position", "m", "positions of the probes on the slider", "slider_probes/position", "",
     [](const ResultHeader& h) { return h.slider_probe_position; }},
    {"slider_probes/displacement", "m", "displacements of the slider at its probes", "time", "slider_probes/position", &SampleBlock::slider_probe_displacement},
    {"slider_probes/velocity", "m s-1", "velocities of the slider at its probes", "time", "slider_probes/position", &SampleBlock::slider_probe_velocity},
    {"energy/kinetic", "J", "kinetic energy", "time", "", &SampleBlock::kinetic},
    {"energy/elastic", "J", "elastic energy", "time", "", &SampleBlock::elastic},
    {"energy/contact", "J", "energy stored in the contact", "time", "", &SampleBlock::contact},
    {"energy/damping_loss", "J", "energy lost to damping since t = 0", "time", "", &SampleBlock::damping_loss},
    {"energy/sliding_work", "J", "work done by the imposed sliding since t = 0", "time", "", &SampleBlock::sliding_work},
    {"energy/load_work", "J", "work done by the loads since t = 0", "time", "", &SampleBlock::load_work},
    {"shocks/start", "s", "starts of the shocks", "shocks/start", "", &Shock::start},
    {"shocks/duration", "s", "durations of the shocks", "shocks/start", "", &Shock::duration},
    {"shocks/peak_force", "N", "peak forces of the shocks", "shocks/start", "", &Shock::peak_force},
    {"shocks/impulse", "N s", "impulses of the shocks", "shocks/start", "", &Shock::impulse},
    {"shocks/position", "m", "positions of the shocks on the resonator, weighted by force", "shocks/start", "", &Shock::position},
    {"level/v_rms", "m s-1", "root mean square velocity of the resonator's elastic motion, over its nodes and the run from output.from on", "", "", &ResultSummary::v_rms},
    {"level/lv", "dB", "vibration velocity level re 1e-9 m s-1, over the run from output.from on", "", "", &ResultSummary::lv},
    {"summary/lv", "dB", "vibration velocity level re 1e-9 m s-1", "", "", &ResultSummary::lv},
    {"summary/v_rms", "m s-1", "root mean square velocity of the resonator's elastic motion", "", "", &ResultSummary::v_rms},
    {"summary/shock_rate", "s-1", "shocks a second", "", "", &ResultSummary::shock_rate},
    {"summary/shock_duration_median", "s", "median of the shocks' durations, to 0.1 %", "", "", &ResultSummary::shock_duration_median},
    {"summary/shock_duration_90", "s", "what 90 % of the shocks' durations do not exceed, to 0.1 %", "", "", &ResultSummary::shock_duration_90},
    {"summary/peak_force_median", "N", "median of the shocks' peak forces, to 0.1 %", "", "", &ResultSummary::peak_force_median},
    {"summary/peak_force_90", "N", "what 90 % of the shocks' peak forces do not exceed, to 0.1 %", "", "", &ResultSummary::peak_force_90},
    {"summary/contact_share", "1", "share of the time with any node in contact", "", "", &ResultSummary::contact_share},
    {"summary/nodes_evaluated", "1", "nodes whose gap was evaluated, a step", "", "", &ResultSummary::nodes_evaluated},
    {"summary/energy_residual", "J", "stored and lost energy less the work put in, since the first sample counted", "", "", &ResultSummary::energy_residual},
    {"summary/energy_turnover", "J", "energy that went through", "", "", &ResultSummary::energy_turnover},
    {"summary/energy_closure", "1", "residual over turnover, its size", "", "", &ResultSummary::energy_closure},
    {"summary/step_seconds", "s", "wall time a step", "", "", &ResultSummary::step_seconds},
    {"summary/wall_seconds", "s", "wall time of the run, until this file was closed", "", "", &ResultSummary::wall_seconds},
    {"surface/slider/position", "m", "positions of the slider's nodes from its left end", "surface/slider/position", "",
     [](const ResultHeader& h) { return node_positions(h.slider_height.size(), h.spacing); }},
    {"surface/slider/height", "m", "heights of the slider's profile", "surface/slider/position", "",
     [](const ResultHeader& h) { return h.slider_height; }},
    {"surface/resonator/position", "m", "positions of the resonator's nodes from its left end", "surface/resonator/position", "",
     [](const ResultHeader& h) { return node_positions(h.resonator_height.size(), h.spacing); }},
    {"surface/resonator/height", "m", "heights of the resonator's profile", "surface/resonator/position", "",
     [](const ResultHeader& h) { return h.resonator_height; }},
};
// clang-format on

template <class Source>
const Source* source_of(const Entry& entry) {
  return std::get_if<Source>(&entry.source);
}

/// The width of a dataset that has columns is the length of their scale.
hsize_t column_count(const Entry& entry, const ResultHeader& header) {
  for (const Entry& scale : entries)
    if (scale.path == std::string_view{entry.columns})
      return (*source_of<Fixed>(scale))(header).size();
  return 1;
}

/// HDF5 need not be built thread safe, and a program may write several files at once.
std::unique_lock<std::mutex> take_library() {
  static std::mutex mutex;
  std::unique_lock lock{mutex};
  // Before all other calls: a file that a failed flush has spoilt must not crash the program's exit.
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its stack goes into our own messages
  return lock;
}

// ---- small pieces of HDF5 --------------------------------------------------------------------

h5::Properties file_access() {
  h5::Properties access{check(H5Pcreate(H5P_FILE_ACCESS))};
  check(H5Pset_fapl_sec2(access));
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && H5_VERSION_LE(1, 10, 99))
  // The temporary name is ours alone, and locks fail on many network disks.
  check(H5Pset_file_locking(access, false, true));
#endif
  return access;
}

h5::Properties ordered(hid_t kind) {
  h5::Properties properties{check(H5Pcreate(kind))};
  constexpr unsigned order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
  if (kind != H5P_DATASET_CREATE) check(H5Pset_link_creation_order(properties, order));
  check(H5Pset_attr_creation_order(properties, order));
  return properties;
}

/// Text of any length: one of a fixed length ends at 64 KiB.
h5::Type text_type() {
  h5::Type text{check(H5Tcopy(H5T_C_S1))};
  check(H5Tset_size(text, H5T_VARIABLE));
  check(H5Tset_cset(text, H5T_CSET_UTF8));
  return text;
}

using Value = std::variant<std::string, double, std::int64_t>;

void set_attribute(hid_t object, const char* name, const Value& value) {
  const h5::Space scalar{check(H5Screate(H5S_SCALAR))};
  const auto set = [&](hid_t type, const void* data) {
    h5::Attribute attribute{
        check(H5Acreate2(object, name, type, scalar, H5P_DEFAULT, H5P_DEFAULT))};
    check(H5Awrite(attribute, type, data));
    h5::close(attribute);
  };
  if (const auto* text = std::get_if<std::string>(&value)) {
    const char* characters = text->c_str();
    set(text_type(), &characters);
  } else if (const auto* number = std::get_if<double>(&value)) {
    set(H5T_NATIVE_DOUBLE, number);
  } else {
    set(H5T_NATIVE_INT64, &std::get<std::int64_t>(value));
  }
}

/// Whether the attribute reads as the value.
bool holds(hid_t object, const char* name, const Value& value) {
  const h5::Attribute attribute{check(H5Aopen(object, name, H5P_DEFAULT))};
  if (const auto* text = std::get_if<std::string>(&value)) {
    char* characters = nullptr;
    check(H5Aread(attribute, text_type(), &characters));
    const bool same = characters != nullptr && *text == characters;
    H5free_memory(characters);
    return same;
  }
  const auto reads = [&](hid_t type, auto number, auto read) {
    check(H5Aread(attribute, type, &read));
    return std::memcmp(&read, &number, sizeof read) == 0;  // NaN is NaN
  };
  if (const auto* number = std::get_if<double>(&value))
    return reads(H5T_NATIVE_DOUBLE, *number, 0.0);
  return reads(H5T_NATIVE_INT64, std::get<std::int64_t>(value), std::int64_t{0});
}

/// A dataset seen as rows of `width` numbers; the first axis may grow.
struct Table {
  const Entry* entry = nullptr;
  h5::Dataset dataset;
  hsize_t width = 1;
  Hash hash;  // of the rows that were given

  bool has_columns() const { return *entry->columns != '\0'; }

  void resize(hsize_t rows) const {
    const hsize_t extent[] = {rows, width};
    check(H5Dset_extent(dataset, extent));
  }
  /// Of datasets that grow. Whole chunks go to the file as they are, by no copy in HDF5's cache.
  void write(hsize_t first, hsize_t rows, const double* data) const {
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
  void read(hsize_t first, hsize_t rows, double* data) const {
    if (rows * width == 0) return;
    const auto [memory, file] = select(first, rows);
    check(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, file, H5P_DEFAULT, data));
  }

 private:
  std::pair<h5::Space, h5::Space> select(hsize_t first, hsize_t rows) const {
    const hsize_t start[] = {first, 0}, count[] = {rows, width};
    h5::Space memory{check(H5Screate_simple(has_columns() ? 2 : 1, count, nullptr))};
    h5::Space file{check(H5Dget_space(dataset))};
    check(H5Sselect_hyperslab(file, H5S_SELECT_SET, start, nullptr, count, nullptr));
    return {std::move(memory), std::move(file)};
  }
};

void require_as_given(bool right) {
  if (!right) throw h5::Failure{"what was written does not read back", EIO};
}

/// Rows of all the shocks' datasets, in memory.
class ShockWindow {
 public:
  explicit ShockWindow(const std::vector<Table>& tables)
      : tables_{tables}, columns_(tables.size()), row_(tables.size()) {}

  void read(hsize_t first, hsize_t rows) {
    for (std::size_t k = 0; k < tables_.size(); ++k) {
      columns_[k].resize(rows);
      tables_[k].read(first, rows, columns_[k].data());
    }
  }
  void write(hsize_t first) const {
    for (std::size_t k = 0; k < tables_.size(); ++k)
      tables_[k].write(first, rows(), columns_[k].data());
  }
  std::size_t rows() const { return columns_.front().size(); }
  const double* column(std::size_t k) const { return columns_[k].data(); }
  double start(std::size_t row) const { return columns_.front()[row]; }  // the first entry
  bool is_full(std::size_t row) const { return !std::isnan(start(row)); }
  void put(std::size_t row, const Shock& shock) {
    for (std::size_t k = 0; k < tables_.size(); ++k)
      columns_[k][row] = shock.*std::get<PerShock>(tables_[k].entry->source);
  }
  void close_holes() {
    std::size_t kept = 0;
    for (std::size_t row = 0; row < rows(); ++row)
      if (is_full(row)) {
        for (std::vector<double>& column : columns_) column[kept] = column[row];
        ++kept;
      }
    for (std::vector<double>& column : columns_) column.resize(kept);
  }
  void add(std::size_t row, HashSum& sum) { sum.add(gathered(row), row_.size()); }
  void take_back(std::size_t row, HashSum& sum) { sum.take_back(gathered(row), row_.size()); }

 private:
  const double* gathered(std::size_t row) {
    for (std::size_t k = 0; k < columns_.size(); ++k) row_[k] = columns_[k][row];
    return row_.data();
  }
  const std::vector<Table>& tables_;
  std::vector<std::vector<double>> columns_;  // of tables_
  std::vector<double> row_;
};

}  // namespace

// ---- the file --------------------------------------------------------------------------------

// What is given is written buffer by buffer on a thread beside the caller's, who fills the next one
// meanwhile; so is what the file begins with. HDF5 is called by one thread at a time: by the writer
// until it is waited for.
struct ResultFile::Impl {
  Impl(const fs::path& path, const ResultHeader& header);
  ~Impl();

  void append(const SampleBlock& block);
  void append(const std::vector<Shock>& shocks);
  double close(const ResultSummary& summary);

 private:
  /// A dataset as the finished file must hold it.
  struct Whole {
    const Entry* entry;
    std::vector<hsize_t> extent;
  };
  /// An attribute of the dataset at `path`, or of the file.
  struct Given {
    std::string path, name;
    Value value;
  };
  /// Samples of one quantity on their way to the file.
  struct Column {
    const Entry* entry;
    std::size_t width;
    std::vector<double> rows;

    const std::vector<double>& of(const SampleBlock& block) const {
      return block.*std::get<Sampled>(entry->source);
    }
  };
  struct Buffer {
    std::vector<Column> columns;
    std::size_t rows = 0;
    std::vector<Shock> shocks;
  };

  template <class Body>
  void guarded(Body body);
  template <class Body>
  void while_open(Body body);
  void hand_over();
  void describe(const ResultHeader& header);
  h5::Dataset create_dataset(const Entry& entry, hsize_t rows, hsize_t columns);
  void give(hid_t object, const char* path, const char* name, Value value);
  void finish(Table& table, hsize_t rows);
  void write(Buffer& buffer);
  void write_samples(Buffer& buffer);
  void write_shocks(std::vector<Shock>& shocks);
  void compact_shocks();
  void reserve(std::size_t bytes);
  void flush();
  void verify() const;
  void discard() noexcept;

  // of the thread that calls
  fs::path final_;
  bool open_ = true;
  std::size_t buffer_rows_ = 0;
  Buffer filling_;

  // of the thread that writes
  std::optional<PartialFile> partial_;
  std::string doing_;  // what an error interrupts
  h5::File file_;
  std::vector<Table> samples_, shocks_;
  Buffer writing_;
  hsize_t sample_rows_ = 0, shock_rows_ = 0;
  HashSum shock_sum_;  // of the rows that were given, over their columns
  std::vector<Whole> wholes_;
  std::vector<Given> given_;

  WriterThread writer_;
};

/// Runs what calls HDF5: whatever goes wrong, nothing is left on the disk.
template <class Body>
void ResultFile::Impl::guarded(Body body) {
  const auto lock = take_library();
  try {
    body();
  } catch (const h5::Failure& failure) {
    discard();
    throw write_failure(doing_, final_, failure.reason, failure.error, "lower output.rate");
  } catch (...) {
    discard();
    throw;
  }
}

/// Runs what may hear of a failure: nothing more is written after it.
template <class Body>
void ResultFile::Impl::while_open(Body body) {
  if (!open_)
    throw FileError(fmt::format("cannot write to '{}': it is finished, or an earlier write failed.",
                                final_.string()));
  open_ = false;
  body();
  open_ = true;
}

ResultFile::Impl::Impl(const fs::path& path, const ResultHeader& header)
    : final_{path}, doing_{"create"} {
  std::size_t row_bytes = 0;
  for (const Entry& entry : entries)
    if (source_of<Sampled>(entry)) {
      filling_.columns.push_back({&entry, column_count(entry, header), {}});
      row_bytes += filling_.columns.back().width * sizeof(double);
    }
  buffer_rows_ =
      std::clamp<std::size_t>(std::bit_floor(bytes_at_once / row_bytes), 1, rows_at_once);
  writing_ = filling_;
  for (Buffer* buffer : {&filling_, &writing_})
    for (Column& column : buffer->columns) column.rows.reserve(buffer_rows_ * column.width);
  partial_.emplace(final_);
  guarded([&] {
    const h5::Properties creation = ordered(H5P_FILE_CREATE), access = file_access();
    file_ = h5::File{check(H5Fcreate(partial_->path().c_str(), H5F_ACC_TRUNC, creation, access))};
  });
  writer_.start([this, header] {
    for (const ModesHeader* modes : {&header.resonator, &header.slider})
      modes->mean_square.get();  // is waited for before HDF5 is kept from others
    guarded([&] {
      describe(header);
      flush();
    });
  });
}

ResultFile::Impl::~Impl() {
  writer_.finish();
  const auto lock = take_library();
  discard();
}

/// Makes all that the file holds, and writes what is known before the first step.
void ResultFile::Impl::describe(const ResultHeader& header) {
  reserve(header.scene.size() +
          2 * sizeof(double) * (header.resonator_height.size() + header.slider_height.size()));

  const auto root = [&](const char* name, Value value) {
    give(file_, "/", name, std::move(value));
  };
  root("creator", "ra2d");
  root("format", std::int64_t{format});
  root("version", RA2D_VERSION);
  root("commit", RA2D_COMMIT);
  root("scene", header.scene);
  root("backend", header.backend);
  root("threads", std::int64_t{header.threads});
  root("started", header.started);
  if (!header.beyond_limit.empty()) root("beyond_limit", header.beyond_limit);

  const h5::Properties group_creation = ordered(H5P_GROUP_CREATE);
  for (const char* path : groups) {
    h5::Group group{check(H5Gcreate2(file_, path, H5P_DEFAULT, group_creation, H5P_DEFAULT))};
    h5::close(group);
  }

  for (const Entry& entry : entries) {
    const hsize_t columns = column_count(entry, header);
    if (const Fixed* fixed = source_of<Fixed>(entry)) {
      const std::vector<double> data = (*fixed)(header);
      const hsize_t rows = data.size() / std::max<hsize_t>(columns, 1);
      Table table{&entry, create_dataset(entry, rows, columns), columns, {}};
      table.hash.add(data.data(), data.size());
      if (!data.empty())
        check(
            H5Dwrite(table.dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()));
      finish(table, rows);
    } else if (source_of<Sampled>(entry)) {
      samples_.push_back({&entry, create_dataset(entry, 0, columns), columns, {}});
    } else if (source_of<PerShock>(entry)) {
      shocks_.push_back({&entry, create_dataset(entry, 0, 1), 1, {}});
    }
  }
  for (const char* group : sampled_groups)
    check(H5Lcreate_hard(file_, "time", file_, fmt::format("{}/time", group).c_str(), H5P_DEFAULT,
                         H5P_DEFAULT));
}

/// Sets an attribute, for verify() to look for.
void ResultFile::Impl::give(hid_t object, const char* path, const char* name, Value value) {
  set_attribute(object, name, value);
  given_.push_back({path, name, std::move(value)});
}

/// Closes a dataset that has all its rows.
void ResultFile::Impl::finish(Table& table, hsize_t rows) {
  give(table.dataset, table.entry->path, "xxh3_128", table.hash.text());
  h5::close(table.dataset);
  Whole whole{table.entry, {}};
  if (source_of<Final>(*table.entry) == nullptr) whole.extent.push_back(rows);
  if (table.has_columns()) whole.extent.push_back(table.width);
  wholes_.push_back(std::move(whole));
}

h5::Dataset ResultFile::Impl::create_dataset(const Entry& entry, hsize_t rows, hsize_t columns) {
  const h5::Properties creation = ordered(H5P_DATASET_CREATE);
  check(H5Pset_fill_value(creation, H5T_NATIVE_DOUBLE, &nan));

  const bool has_columns = *entry.columns != '\0';
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
  h5::Dataset dataset{check(
      H5Dcreate2(file_, entry.path, H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT))};
  give(dataset, entry.path, "units", entry.units);
  give(dataset, entry.path, "long_name", entry.long_name);

  unsigned axis = 0;
  for (const std::string_view scale : {entry.rows, entry.columns}) {
    if (scale == entry.path) {
      const auto name = scale.substr(scale.rfind('/') + 1);  // npos + 1 = 0: the whole
      check(H5DSset_scale(dataset, name.data()));
    } else if (!scale.empty()) {
      h5::Dataset coordinate{check(H5Dopen2(file_, scale.data(), H5P_DEFAULT))};
      check(H5DSattach_scale(dataset, coordinate, axis++));
      h5::close(coordinate);
    }
  }
  return dataset;
}

void ResultFile::Impl::append(const SampleBlock& block) {
  const std::size_t rows = block.time.size();
  for (const Column& column : filling_.columns)
    if (column.of(block).size() != rows * column.width)
      throw std::logic_error(fmt::format("SampleBlock: {} is not {} rows of {}", column.entry->path,
                                         rows, column.width));
  while_open([&] {
    if (writer_.has_failed()) writer_.wait();
    for (std::size_t done = 0; done < rows;) {
      const std::size_t count = std::min(rows - done, buffer_rows_ - filling_.rows);
      for (Column& column : filling_.columns) {
        const double* data = column.of(block).data();
        column.rows.insert(column.rows.end(), data + done * column.width,
                           data + (done + count) * column.width);
      }
      done += count;
      filling_.rows += count;
      if (filling_.rows == buffer_rows_) hand_over();
    }
  });
}

void ResultFile::Impl::append(const std::vector<Shock>& shocks) {
  for (const Shock& shock : shocks)
    if (shock.serial < 0) throw std::logic_error("Shock: the serial is negative");
  while_open([&] {
    if (writer_.has_failed()) writer_.wait();
    for (const Shock& shock : shocks) {
      filling_.shocks.push_back(shock);
      if (filling_.shocks.size() == rows_at_once) hand_over();
    }
  });
}

/// Has the full buffer written, and goes on with the other one once that is written.
void ResultFile::Impl::hand_over() {
  writer_.wait();
  std::swap(filling_, writing_);
  writer_.start([this] { guarded([this] { write(writing_); }); });
}

void ResultFile::Impl::write(Buffer& buffer) {
  if (buffer.rows > 0) write_samples(buffer);
  if (!buffer.shocks.empty()) write_shocks(buffer.shocks);
}

void ResultFile::Impl::write_samples(Buffer& buffer) {
  doing_ =
      fmt::format("write the samples from t = {} s on to", buffer.columns.front().rows.front());
  std::size_t bytes = 0;
  for (const Column& column : buffer.columns) bytes += column.rows.size() * sizeof(double);
  reserve(bytes);
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    std::vector<double>& rows = buffer.columns[k].rows;
    samples_[k].resize(sample_rows_ + buffer.rows);
    samples_[k].hash.add(rows.data(), rows.size());
    samples_[k].write(sample_rows_, buffer.rows, rows.data());
    rows.clear();
  }
  sample_rows_ += buffer.rows;
  buffer.rows = 0;
  flush();
}

/// Writes shocks window by window: what a window holds already is read, the new rows
/// are put in, and it goes back in one piece, which is far quicker than a selection of single rows.
void ResultFile::Impl::write_shocks(std::vector<Shock>& shocks) {
  std::stable_sort(shocks.begin(), shocks.end(),
                   [](const Shock& a, const Shock& b) { return a.serial < b.serial; });
  doing_ = fmt::format("write the shocks from t = {} s on to", shocks.front().start);
  const hsize_t rows = std::max<hsize_t>(shock_rows_, shocks.back().serial + 1);
  reserve(((rows - shock_rows_) * shocks_.size()) * sizeof(double));
  shock_rows_ = rows;
  for (const Table& table : shocks_) table.resize(shock_rows_);

  ShockWindow window(shocks_);
  for (auto begin = shocks.begin(); begin != shocks.end();) {
    const long first = begin->serial;
    const long limit = (first / long(rows_at_once) + 1) * long(rows_at_once);  // a chunk's end
    const auto end = std::find_if(begin, shocks.end(),
                                  [&](const Shock& shock) { return shock.serial >= limit; });
    window.read(first, (end - 1)->serial - first + 1);
    for (auto shock = begin; shock != end; ++shock) {
      const std::size_t row = shock->serial - first;
      if (window.is_full(row)) window.take_back(row, shock_sum_);  // an earlier word on this one
      window.put(row, *shock);
      window.add(row, shock_sum_);
    }
    window.write(first);
    begin = end;
  }
  shocks.clear();
  flush();
}

/// Closes the holes that merged shocks left, in place and window by window. The rows that are read on
/// the way must be those that were given, in order of start.
void ResultFile::Impl::compact_shocks() {
  doing_ = "order the shocks of";
  hsize_t kept = 0;
  HashSum sum;
  double last = -std::numeric_limits<double>::infinity();
  ShockWindow window(shocks_);
  for (hsize_t first = 0; first < shock_rows_; first += rows_at_once) {
    const hsize_t count = std::min<hsize_t>(rows_at_once, shock_rows_ - first);
    window.read(first, count);
    window.close_holes();
    for (std::size_t row = 0; row < window.rows(); ++row) {
      window.add(row, sum);
      require_as_given(last <= window.start(row));
      last = window.start(row);
    }
    for (std::size_t k = 0; k < shocks_.size(); ++k)
      shocks_[k].hash.add(window.column(k), window.rows());
    if (kept != first || window.rows() != count) window.write(kept);
    kept += window.rows();
  }
  require_as_given(sum == shock_sum_);
  if (kept != shock_rows_)
    for (const Table& table : shocks_) table.resize(kept);
  shock_rows_ = kept;
}

/// Sets space aside for `bytes` more, so that a full disk is known before HDF5 is: a flush that
/// fails half way spoils its file handle for good (1.10.8). File systems without this are taken as
/// they come: there, flush() fails.
void ResultFile::Impl::reserve(std::size_t bytes) {
  hsize_t end = 0;
  check(H5Fget_filesize(file_, &end));
  const std::size_t slack = bytes / 8 + bytes_at_once;  // the tables' last chunks, the indices
  if (fallocate(partial_->descriptor(), FALLOC_FL_KEEP_SIZE, off_t(end), off_t(bytes + slack)) !=
          0 &&
      (errno == ENOSPC || errno == EDQUOT || errno == EFBIG || errno == EIO))
    throw h5::system_failure(errno);
}

/// Brings everything to the system, the one call that says whether the writes before it succeeded.
void ResultFile::Impl::flush() { check(H5Fflush(file_, H5F_SCOPE_LOCAL)); }

double ResultFile::Impl::close(const ResultSummary& summary) {
  std::chrono::duration<double> reading_back{};
  while_open([&] {
    writer_.wait();
    guarded([&] {
      write(filling_);
      compact_shocks();

      doing_ = "finish";
      reserve(0);
      for (const Entry& entry : entries)
        if (const Final* value = source_of<Final>(entry)) {
          if (std::isnan(summary.**value)) continue;  // there is none
          Table table{&entry, create_dataset(entry, 1, 1), 1, {}};
          table.hash.add(&(summary.**value), 1);
          check(H5Dwrite(table.dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                         &(summary.**value)));
          finish(table, 1);
        }
      for (Table& table : samples_) finish(table, sample_rows_);
      for (Table& table : shocks_) finish(table, shock_rows_);
      give(file_, "/", "wall_seconds", summary.wall_seconds);
      give(file_, "/", "steps", std::int64_t{summary.steps});
      give(file_, "/", "complete", std::int64_t{summary.complete});
      give(file_, "/", "ended", summary.ended);
      flush();
      h5::close(file_);
      partial_->sync();
      const auto written = std::chrono::steady_clock::now();
      verify();
      reading_back = std::chrono::steady_clock::now() - written;
      partial_->publish();
    });
  });
  open_ = false;
  return reading_back.count();
}

/// Opens the closed file as a reader would: all that was given must be in it.
void ResultFile::Impl::verify() const {
  const h5::Properties access = file_access();
  h5::File file{check(H5Fopen(partial_->path().c_str(), H5F_ACC_RDONLY, access))};
  // Every number is read once: HDF5 may put them where they are wanted, without a copy of its own.
  const h5::Properties once{check(H5Pcreate(H5P_DATASET_ACCESS))};
  check(H5Pset_chunk_cache(once, 0, 0, 1));
  h5::Object object;
  std::string_view opened;  // the path of `object`
  for (const Given& given : given_) {
    if (opened != given.path)
      object = h5::Object{check(H5Oopen(file, given.path.c_str(), H5P_DEFAULT))};
    opened = given.path;
    require_as_given(holds(object, given.name.c_str(), given.value));
  }
  object.close();
  std::vector<double> rows;
  for (const Whole& whole : wholes_) {
    const Entry& entry = *whole.entry;
    Table table{&entry, h5::Dataset{check(H5Dopen2(file, entry.path, once))}, 1, {}};
    const h5::Type type{check(H5Dget_type(table.dataset))};
    require_as_given(check(H5Tequal(type, H5T_IEEE_F64LE)) > 0);
    const h5::Space space{check(H5Dget_space(table.dataset))};
    std::vector<hsize_t> extent(check(H5Sget_simple_extent_ndims(space)));
    check(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
    require_as_given(extent == whole.extent);
    unsigned axis = 0;
    for (const std::string_view scale : {entry.rows, entry.columns}) {
      if (scale == entry.path) {
        require_as_given(check(H5DSis_scale(table.dataset)) > 0);
      } else if (!scale.empty()) {
        const h5::Dataset coordinate{check(H5Dopen2(file, scale.data(), H5P_DEFAULT))};
        require_as_given(check(H5DSis_attached(table.dataset, coordinate, axis++)) > 0);
      }
    }

    if (extent.empty()) {
      rows.resize(1);
      check(H5Dread(table.dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
      table.hash.add(rows.data(), 1);
    } else {
      if (extent.size() == 2) table.width = extent[1];
      // whole chunks
      const hsize_t at_once = std::bit_floor(std::max<hsize_t>(
          bytes_read_at_once / (std::max<hsize_t>(table.width, 1) * sizeof(double)), 1));
      for (hsize_t first = 0; first < extent[0]; first += at_once) {
        const hsize_t count = std::min(at_once, extent[0] - first);
        rows.resize(count * table.width);
        table.read(first, count, rows.data());
        table.hash.add(rows.data(), rows.size());
      }
    }
    require_as_given(holds(table.dataset, "xxh3_128", table.hash.text()));
  }
  check(file.close());
}

/// Takes everything back. HDF5 cannot drop what it has not written yet, so its descriptor is first
/// turned to nameless memory: a few MB at most, gone with the close; the disk is free at once.
void ResultFile::Impl::discard() noexcept {
  void* handle = nullptr;
  if (file_.is_open() && H5Fget_vfd_handle(file_, H5P_DEFAULT, &handle) >= 0 && handle) {
    if (const int memory = memfd_create("ra2d", MFD_CLOEXEC); memory >= 0) {
      dup2(memory, *static_cast<int*>(handle));
      ::close(memory);
    }
  }
  samples_.clear();
  shocks_.clear();
  file_.close();
  if (partial_) partial_->drop();
}

// ---- the public face -------------------------------------------------------------------------

ResultFile::ResultFile(const fs::path& path, const ResultHeader& header)
    : impl_{std::make_unique<Impl>(path, header)} {}
ResultFile::~ResultFile() = default;
void ResultFile::append(const SampleBlock& block) { impl_->append(block); }
void ResultFile::append(const std::vector<Shock>& shocks) { impl_->append(shocks); }
double ResultFile::close(const ResultSummary& summary) { return impl_->close(summary); }

}  // namespace ra2d
