// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/errors.hpp"

/// Files that appear under their names whole or not at all.
namespace ra2d {

/// A file while it is written: beside the one that it will be, as `.NAME.partial-HOST-PID`, under a
/// lock that the system lets go of with the process. What processes of this machine that are gone have
/// left in the folder is removed first, and that is said on stderr; others' files are never touched.
/// Unless publish() is reached, nothing is left. Throws FileError.
class PartialFile {
 public:
  /// `target` is followed where it is a symbolic link (host/output_file.hpp).
  explicit PartialFile(const std::filesystem::path& target);
  ~PartialFile() { drop(); }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  const std::filesystem::path& path() const { return path_; }  // where it stands now
  int descriptor() const { return descriptor_; }               // for reading and writing

  /// Adds to what was written.
  void write(std::string_view text);
  /// Brings what was written to the disk, and what was set aside for more back to it. What is read
  /// after this comes from the disk where the system can arrange that.
  void sync();
  /// Gives the file, which was synced, its name. Fails also when it has its name and is whole, but the
  /// folder could not be brought to the disk: the message says so.
  void publish();
  /// Takes everything back.
  void drop() noexcept;

 private:
  std::filesystem::path target_, path_;
  int descriptor_ = -1;
  std::size_t place_;  // among those that drop_partials() knows
};

/// Unlinks all partial files of this process, which ends: signal handlers may call it. Of more than 64
/// at once it knows 64.
void drop_partials() noexcept;

/// Writes a text under its name once it is complete. Throws FileError.
void write_text(const std::filesystem::path& path, const std::string& text);

/// "cannot DOING 'FILE': REASON", and the cure for `error`, an errno or 0; `smaller` says what else
/// makes a file smaller.
FileError write_failure(const std::string& doing, const std::filesystem::path& file,
                        const std::string& reason, int error, const std::string& smaller = {});

}  // namespace ra2d
