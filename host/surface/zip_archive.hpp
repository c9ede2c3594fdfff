// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

struct zip;  // of libzip

namespace ra2d {

/// The entries of a zip archive that nobody has to trust: what they claim is checked before
/// anything is inflated, and their names are compared, never used as paths. Throws RequestError for
/// what is refused, FileError where the file cannot be read.
class ZipArchive {
 public:
  explicit ZipArchive(std::filesystem::path file);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /// Bytes of an entry, as it claims; nothing where there is none of this name.
  std::optional<std::uint64_t> size_of(const std::string& name) const;
  /// Throws for an entry that would grow as no measurement does: what is kept of it is memory.
  void require_usual_ratio(const std::string& name) const;
  /// An entry as a whole, of at most `most` bytes.
  std::string read(const std::string& name, std::uint64_t most) const;
  /// Gives `take` an entry of exactly `size` bytes in parts of whole `units`, and returns its MD5.
  std::string stream(const std::string& name, std::uint64_t size, std::size_t unit,
                     const std::function<void(const char*, std::size_t)>& take) const;

 private:
  struct Entry {
    std::uint64_t index, size, packed;
  };
  std::optional<Entry> find(const std::string& name) const;
  Entry entry(const std::string& name) const;
  [[noreturn]] void refuse_archive(const std::string& why) const;

  std::filesystem::path file_;
  ::zip* archive_ = nullptr;
};

}  // namespace ra2d
