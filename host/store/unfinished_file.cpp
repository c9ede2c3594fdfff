// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/unfinished_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <utility>

#include "host/base/clock.hpp"
#include "host/base/errors.hpp"
#include "host/base/version.hpp"
#include "host/store/seal.hpp"

namespace ra2d {
namespace {

using h5::check;

constexpr std::size_t least_slack = 4096 * 1024;  // bytes

}  // namespace

/// Runs what calls HDF5: whatever goes wrong, nothing is left on the disk.
template <class Body>
void UnfinishedFile::guarded(Body body) {
  const auto library = h5::take_library();
  try {
    body();
  } catch (const h5::Failure& failure) {
    discard();
    throw write_failure(doing_, path_, failure.reason, failure.error, "lower output.rate");
  } catch (...) {
    discard();
    throw;
  }
}

UnfinishedFile::UnfinishedFile(const std::filesystem::path& path) : path_{path} {
  partial_.emplace(path);
  guarded([&] {
    const h5::Properties creation = h5::ordered(H5P_FILE_CREATE), access = h5::file_access();
    file_ = h5::File{check(H5Fcreate(partial_->path().c_str(), H5F_ACC_TRUNC, creation, access))};
  });
}

UnfinishedFile::~UnfinishedFile() {
  const auto library = h5::take_library();
  discard();
}

// ---- the beginning -----------------------------------------------------------------------------

void UnfinishedFile::describe(const ResultHeader& header) {
  guarded([&] {
    reserve(header.scene.size() +
            2 * sizeof(double) * (header.resonator_height.size() + header.slider_height.size()));
    give({"creator", "ra2d"});
    give({"format", header.is_areal ? areal_format : file_format});
    give({"version", version()});
    give({"commit", commit()});
    give({"scene", header.scene});
    give({"key", header.key});
    give({"backend", header.backend});
    give({"threads", std::int64_t{header.threads}});
    give({"started", header.started});
    if (!header.beyond_limit.empty()) give({"beyond_limit", header.beyond_limit});
    if (!header.doubts.empty()) give({"doubts", header.doubts});
    make_datasets(header);
    flush();
  });
}

void UnfinishedFile::make_datasets(const ResultHeader& header) {
  const h5::Properties creation = h5::ordered(H5P_GROUP_CREATE);
  for (const Group& one : groups()) {
    h5::Group group{check(H5Gcreate2(file_, one.path, H5P_DEFAULT, creation, H5P_DEFAULT))};
    const h5::GivenAttribute description{"description", one.description};
    h5::set_attribute(group, description);
    given_.of_groups.emplace_back(one.path, description);
    h5::close(group);
  }
  shocks_.begin(header.segment);
  for (const Entry& entry : entries()) {
    if (!is_kept(entry, header)) continue;
    const hsize_t columns = column_count(entry, header);
    if (const Fixed* fixed = source_of<Fixed>(entry)) {
      const SharedNumbers data = (*fixed)(header);
      const hsize_t rows = data.size() / std::max<hsize_t>(columns, 1);
      Table table = make_table(file_, entry, header, rows, columns);
      table.add_to_hash(data.data(), data.size());
      if (!data.empty()) table.write_all(data.data());
      close(table, rows);
    } else if (source_of<Sampled>(entry)) {
      samples_.push_back(make_table(file_, entry, header, 0, columns));
    } else if (source_of<PerShock>(entry)) {
      shocks_.add(make_table(file_, entry, header, 0, columns));
    }
  }
  for (const Group& group : groups())
    if (group.is_sampled)
      check(H5Lcreate_hard(file_, "time", file_, fmt::format("{}/time", group.path).c_str(),
                           H5P_DEFAULT, H5P_DEFAULT));
}

/// Sets an attribute of the file, to be found there when it is read back.
void UnfinishedFile::give(h5::GivenAttribute attribute) {
  h5::set_attribute(file_, attribute);
  given_.attributes.push_back(std::move(attribute));
}

/// Closes a dataset that has all its rows.
void UnfinishedFile::close(Table& table, hsize_t rows) {
  table.give({"xxh3_128", table.hash.text()});
  h5::close(table.dataset);
  std::vector<hsize_t> extent;
  if (source_of<Final>(*table.entry) == nullptr) extent.push_back(rows);
  if (table.entry->has_columns()) extent.push_back(table.width);
  given_.datasets.push_back({table.entry, table.stored, std::move(extent), std::move(table.given)});
}

// ---- samples and shocks ------------------------------------------------------------------------

void UnfinishedFile::write(WriteBuffer& buffer) {
  guarded([&] {
    if (buffer.rows > 0) write_samples(buffer);
    if (!buffer.shocks.empty()) write_shocks(buffer.shocks);
  });
}

void UnfinishedFile::write_samples(WriteBuffer& buffer) {
  doing_ =
      fmt::format("write the samples from t = {} s on to", buffer.columns.front().rows.front());
  std::size_t bytes = 0;
  for (const WriteBuffer::Column& column : buffer.columns)
    bytes += column.rows.size() * sizeof(double);
  reserve(bytes);
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    std::vector<double>& rows = buffer.columns[k].rows;
    samples_[k].resize(sample_rows_ + buffer.rows);
    samples_[k].add_to_hash(rows.data(), rows.size());
    samples_[k].write(sample_rows_, buffer.rows, rows.data());
    rows.clear();
  }
  sample_rows_ += buffer.rows;
  buffer.rows = 0;
  flush();
  partial_->begin_sync();
}

void UnfinishedFile::write_shocks(std::vector<Shock>& shocks) {
  const auto first =
      std::min_element(shocks.begin(), shocks.end(),
                       [](const Shock& a, const Shock& b) { return a.serial < b.serial; });
  doing_ = fmt::format("write the shocks from t = {} s on to", first->start);
  reserve(shocks_.growth(shocks));
  shocks_.write(shocks);
  flush();
}

/// Sets space aside for `bytes` more, so that a full disk is known before HDF5 is: a flush that
/// fails half way spoils its file handle for good (1.10.8). File systems without this are taken as
/// they come: there, flush() fails.
void UnfinishedFile::reserve(std::size_t bytes) {
  hsize_t end = 0;
  check(H5Fget_filesize(file_, &end));
  const std::size_t slack = bytes / 8 + least_slack;  // the tables' last chunks, the indices
  if (fallocate(partial_->descriptor(), FALLOC_FL_KEEP_SIZE, off_t(end), off_t(bytes + slack)) !=
          0 &&
      (errno == ENOSPC || errno == EDQUOT || errno == EFBIG || errno == EIO))
    throw h5::system_failure(errno);
}

/// Brings everything to the system, the one call that says whether the writes before it succeeded.
void UnfinishedFile::flush() { check(H5Fflush(file_, H5F_SCOPE_LOCAL)); }

// ---- the end -----------------------------------------------------------------------------------

double UnfinishedFile::finish(const ResultSummary& summary, const std::filesystem::path& name,
                              std::unique_ptr<InputFile>* kept) {
  double reading_back = 0;  // s
  guarded([&] {
    doing_ = "order the shocks of";
    shocks_.close_holes();

    doing_ = "finish";
    reserve(0);
    write_summary(summary);
    flush();
    h5::close(file_);
    if (const int error = append_seal(partial_->descriptor()); error != 0)
      throw h5::system_failure(error);
    partial_->sync();
    const Clock::time_point written = Clock::now();
    read_back(partial_->path(), partial_->descriptor(), given_);
    reading_back = seconds_since(written);
    if (kept != nullptr) *kept = std::make_unique<InputFile>(partial_->path());
    name.empty() ? partial_->publish() : partial_->publish(name);
  });
  return reading_back;
}

void UnfinishedFile::write_summary(const ResultSummary& summary) {
  for (const Entry& entry : entries())
    if (const Final* value = source_of<Final>(entry)) {
      if (std::isnan(summary.**value)) continue;  // there is none
      Table table = make_table(file_, entry, {}, 1, 1);
      table.add_to_hash(&(summary.**value), 1);
      table.write_all(&(summary.**value));
      close(table, 1);
    }
  for (Table& table : samples_) close(table, sample_rows_);
  for (Table& table : shocks_.tables()) close(table, shocks_.rows());
  give({"wall_seconds", summary.wall_seconds});
  give({"steps", std::int64_t{summary.steps}});
  give({"complete", std::int64_t{summary.complete}});
  give({"ended", summary.ended});
  if (!summary.warnings.empty()) give({"warnings", summary.warnings});
}

/// Takes everything back. HDF5 cannot drop what it has not written yet, so its descriptor is first
/// turned to nameless memory: a few MB at most, gone with the close; the disk is free at once.
void UnfinishedFile::discard() noexcept {
  void* handle = nullptr;
  if (file_.is_open() && H5Fget_vfd_handle(file_, H5P_DEFAULT, &handle) >= 0 && handle) {
    if (const int memory = memfd_create("ra2d", MFD_CLOEXEC); memory >= 0) {
      dup2(memory, *static_cast<int*>(handle));
      ::close(memory);
    }
  }
  samples_.clear();
  shocks_ = {};
  file_.close();
  if (partial_) partial_->drop();
}

}  // namespace ra2d
