// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

#include "host/base/errors.hpp"
#include "host/store/buffer.hpp"
#include "host/store/entries.hpp"
#include "host/store/unfinished_file.hpp"
#include "host/store/writer_thread.hpp"

namespace ra2d {

// Data are written buffer by buffer on a thread of their own, while the caller fills the next
// buffer. The beginning of the file is written there, too. One thread at a time touches the file:
// the writer, until it was waited for.
struct ResultFile::Impl {
  Impl(const std::filesystem::path& path, const ResultHeader& header);

  void append(const SampleBlock& block);
  void append(const std::vector<Shock>& shocks);
  double close(const ResultSummary& summary, const std::filesystem::path& name,
               std::unique_ptr<InputFile>* kept);

 private:
  template <class Body>
  void while_open(Body body);
  void hand_over();

  std::filesystem::path path_;
  bool open_ = true;
  std::size_t buffer_rows_ = 0;  // samples to a buffer
  WriteBuffer filling_;

  // the writer's
  UnfinishedFile file_;
  WriteBuffer writing_;
  WriterThread writer_;  // ends first
};

/// Runs what may hear of a failure: nothing more is written after it.
template <class Body>
void ResultFile::Impl::while_open(Body body) {
  if (!open_)
    throw FileError(fmt::format("cannot write to '{}': it is finished, or an earlier write failed.",
                                path_.string()));
  open_ = false;
  if (writer_.has_failed()) writer_.wait();
  body();
  open_ = true;
}

ResultFile::Impl::Impl(const std::filesystem::path& path, const ResultHeader& header)
    : path_{path}, file_{path} {
  constexpr std::size_t bytes = 4096 * 1024;  // of a buffer
  std::size_t row_bytes = 0;
  for (const Entry& entry : entries())
    if (entry.is_sampled() && is_kept(entry, header)) {
      filling_.columns.push_back({&entry, column_count(entry, header), {}});
      row_bytes += filling_.columns.back().width * sizeof(double);
    }
  buffer_rows_ = std::clamp<std::size_t>(std::bit_floor(bytes / row_bytes), 1, rows_at_once);
  writing_ = filling_;
  for (WriteBuffer* buffer : {&filling_, &writing_})
    for (WriteBuffer::Column& column : buffer->columns)
      column.rows.reserve(buffer_rows_ * column.width);
  writer_.start([this, header] {
    for (const ModesHeader* modes : {&header.resonator, &header.slider})
      modes->mean_square.get();  // is waited for before HDF5 is kept from others
    file_.describe(header);
  });
}

void ResultFile::Impl::append(const SampleBlock& block) {
  const std::size_t rows = block.time.size();
  for (const WriteBuffer::Column& column : filling_.columns)
    if (column.of(block).size() != rows * column.width)
      throw std::logic_error(fmt::format("SampleBlock: {} is not {} rows of {}", column.entry->path,
                                         rows, column.width));
  while_open([&] {
    for (std::size_t done = 0; done < rows;) {
      const std::size_t count = std::min(rows - done, buffer_rows_ - filling_.rows);
      for (WriteBuffer::Column& column : filling_.columns) {
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
  writer_.start([this] { file_.write(writing_); });
}

double ResultFile::Impl::close(const ResultSummary& summary, const std::filesystem::path& name,
                               std::unique_ptr<InputFile>* kept) {
  double reading_back = 0;
  while_open([&] {
    writer_.wait();
    file_.write(filling_);
    reading_back = file_.finish(summary, name, kept);
  });
  open_ = false;
  return reading_back;
}

// ---- the public face -------------------------------------------------------------------------

ResultFile::ResultFile(const std::filesystem::path& path, const ResultHeader& header)
    : impl_{std::make_unique<Impl>(path, header)} {}
ResultFile::~ResultFile() = default;
void ResultFile::append(const SampleBlock& block) { impl_->append(block); }
void ResultFile::append(const std::vector<Shock>& shocks) { impl_->append(shocks); }
double ResultFile::close(const ResultSummary& summary) {
  return impl_->close(summary, {}, nullptr);
}
double ResultFile::close(const ResultSummary& summary, const std::filesystem::path& name,
                         std::unique_ptr<InputFile>& kept) {
  return impl_->close(summary, name, &kept);
}

}  // namespace ra2d
