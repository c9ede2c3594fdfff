// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/store/buffer.hpp"
#include "host/store/hdf5.hpp"
#include "host/store/read_back.hpp"
#include "host/store/shock_rows.hpp"
#include "host/store/store.hpp"
#include "host/store/table.hpp"
#include "host/system/input_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {

/// A result file on the disk, from its making until it has its name: all that calls HDF5. Its
/// methods may be called by one thread after the other. Each throws FileError, and then nothing is
/// left.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::filesystem::path& path);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// First: makes all that the file holds, and writes what is known before the first step.
  void describe(const ResultHeader& header);
  /// Writes what the buffer holds, and empties it.
  void write(WriteBuffer& buffer);
  /// Last: writes what is known after the last step, seals the file (host/store/seal.hpp), reads it
  /// back and gives it its name, or another one. `kept` takes the whole file, open, before it has
  /// that. Returns how long reading back took [s].
  double finish(const ResultSummary& summary, const std::filesystem::path& name = {},
                std::unique_ptr<InputFile>* kept = nullptr);

 private:
  template <class Body>
  void guarded(Body body);
  void make_datasets(const ResultHeader& header);
  void write_samples(WriteBuffer& buffer);
  void write_shocks(std::vector<Shock>& shocks);
  void write_summary(const ResultSummary& summary);
  void give(h5::GivenAttribute attribute);
  void close(Table& table, hsize_t rows);
  void reserve(std::size_t bytes);
  void flush();
  void discard() noexcept;

  std::filesystem::path path_;
  std::optional<PartialFile> partial_;
  std::string doing_ = "create";  // what an error interrupts
  h5::File file_;
  std::vector<Table> samples_;
  hsize_t sample_rows_ = 0;
  ShockRows shocks_;
  GivenContent given_;
};

}  // namespace ra2d
