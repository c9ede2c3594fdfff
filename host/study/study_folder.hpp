// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

/// Where a study keeps what: its folder, its files and their locks.
namespace ra2d {

/// Part `index` of `count`, from 1; the whole is part 1 of 1.
struct Shard {
  int index = 1, count = 1;
  bool is_whole() const { return count == 1; }
  /// "all" or "shard-2-of-3", in the names of files.
  std::string name() const;
};

struct StudyFolder {
  std::filesystem::path path;

  std::filesystem::path table() const { return path / "results.h5"; }
  std::filesystem::path snapshot() const { return path / "study.json"; }
  std::filesystem::path ledgers() const { return path / "ledger"; }
  /// Of ranks under mpirun each has its own; one process writes that of rank 0.
  std::filesystem::path ledger(const Shard& shard, int rank = 0) const;
  /// Of the launch that runs here under mpirun: what rank 0 writes for the others to see.
  std::filesystem::path launch() const { return ledgers() / "launch"; }
  /// Results of runs where they are kept, and checkpoints of runs on their way.
  std::filesystem::path results() const { return path / "runs"; }
  /// The result of a run by its key (run_key), relative to the folder.
  static std::filesystem::path result(const std::string& key) { return "runs/" + key + ".h5"; }
  std::filesystem::path status(const Shard& shard) const;

  /// Makes what is missing of the folders. Throws RequestError where something else has the name,
  /// FileError.
  void make(bool with_results = false) const;
};

/// A file of at most so many bytes; `what` it is to a message. Throws FileError.
std::string read_text(const std::filesystem::path& file, const char* what, std::size_t most);

/// Takes an open file for this process alone. False where another has it; where the file system has
/// no locks, true. The lock goes with the descriptor.
bool lock_file(int descriptor);

/// Waits until this process alone may write the folder's table; lets go of it when destroyed.
class TableLock {
 public:
  explicit TableLock(const StudyFolder& folder);
  ~TableLock();
  TableLock(const TableLock&) = delete;
  TableLock& operator=(const TableLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace ra2d
