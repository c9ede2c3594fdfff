// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/base/errors.hpp"

/// Files that appear under their names whole or not at all.
namespace ra2d {

/// A file while it is written: beside the one that it will be, as `.NAME.partial-HOST-PID`, under a
/// lock that the system lets go of with the process. What processes of this machine that are gone
/// have left in the folder is removed first, and that is said on stderr; others' files are never
/// touched. Unless publish() is reached, nothing is left. Throws FileError.
class PartialFile {
 public:
  /// `target` is followed where it is a symbolic link; `option` is the one that names it
  /// (host/system/output_file.hpp).
  explicit PartialFile(const std::filesystem::path& target, const char* option = "-o");
  ~PartialFile() { drop(); }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  const std::filesystem::path& path() const { return path_; }  // where it stands now
  int descriptor() const { return descriptor_; }               // for reading and writing

  /// Adds to what was written.
  void write(std::string_view text);
  /// Lets the system begin with that, so that sync() has less to wait for. Nothing fails here.
  void begin_sync() const noexcept;
  /// Brings what was written to the disk, and what was set aside for more back to it. What is read
  /// after this comes from the disk where the system can arrange that.
  void sync();
  /// Gives the file, which was synced, its name. Fails also when it has its name and is whole, but
  /// the folder could not be brought to the disk: the message says so.
  void publish() { publish(target_); }
  /// Gives it another name in the same file system.
  void publish(const std::filesystem::path& name);
  /// Takes everything back.
  void drop() noexcept;

 private:
  FileError failure(const char* doing, const std::filesystem::path& file, int error) const;

  std::filesystem::path target_, path_;
  const char* option_;  // for messages
  int descriptor_ = -1;
  std::size_t place_;  // among those that drop_partials() knows
};

/// Whether a file has the name of a partial file of this machine: those are removed when their
/// process is gone.
bool is_partial_name(const std::filesystem::path& file);

/// Whether an open file or folder still stands where `path` leads. Throws FileError where the
/// system does not say.
bool stands_at(int descriptor, const std::filesystem::path& path);

/// A folder that drop_partials() removes if it is empty then.
class PartialFolder {
 public:
  explicit PartialFolder(const std::filesystem::path& folder);
  ~PartialFolder();
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

 private:
  std::size_t place_;
};

/// Unlinks all partial files of this process, which ends, and removes its partial folders: signal
/// handlers may call it. Of more than 64 at once it knows 64.
void drop_partials() noexcept;

/// Brings a file's name to the disk: it, too, should outlive a power cut. Some file systems cannot
/// promise that, and a folder that may not be read cannot be asked. Throws FileError.
void sync_folder_of(const std::filesystem::path& file);

/// Writes a text under its name once it is complete. Throws FileError.
void write_text(const std::filesystem::path& path, const std::string& text,
                const char* option = "-o");

/// "cannot DOING 'FILE': REASON", and the cure for `error`, an errno or 0; `smaller` says what else
/// makes a file smaller, and `option` which one names another file.
FileError write_failure(const std::string& doing, const std::filesystem::path& file,
                        const std::string& reason, int error, const std::string& smaller = {},
                        const char* option = "-o");

}  // namespace ra2d
