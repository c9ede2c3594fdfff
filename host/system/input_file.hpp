// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <streambuf>
#include <string>

#include "host/base/errors.hpp"

/// Files that are read. Whoever opens an input opens it here.
namespace ra2d {

/// An input, open for reading. Only a regular file is one: a folder, a device, a pipe or a socket
/// is refused, also behind a link, and nothing that a name leads to makes the opening wait. No more
/// is read than the file had when it was opened, so that no input is without an end.
class InputFile {
 public:
  /// `what` it is to a message: "the scene". Throws FileError: "cannot read the scene 'x.toml':
  /// why".
  explicit InputFile(const std::filesystem::path& path, const std::string& what = {});
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  int descriptor() const { return descriptor_; }
  std::uint64_t size() const { return size_; }  // bytes, when it was opened

  /// Reads `count` bytes from byte `at` on, fewer only at the end; how many there were. Throws
  /// FileError.
  std::size_t read(std::uint64_t at, char* to, std::size_t count) const;
  /// The first bytes, at most `most` of them. Throws FileError.
  std::string beginning(std::size_t most) const;
  /// "cannot read the scene 'x.toml': WHY"
  FileError unreadable(const std::string& why) const;

 private:
  std::filesystem::path path_;
  std::string what_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// An input as a stream of bytes; seekg() takes it to a byte. It is bad() after a failed reading.
class InputStream : public std::istream {
 public:
  explicit InputStream(const std::filesystem::path& path, const std::string& what = {});
  std::uint64_t size() const { return buffer_.file.size(); }
  const InputFile& file() const { return buffer_.file; }

 private:
  struct Buffer : std::streambuf {
    Buffer(const std::filesystem::path& path, const std::string& what) : file{path, what} {}
    int_type underflow() override;
    pos_type seekpos(pos_type place, std::ios_base::openmode which) override;

    InputFile file;
    std::uint64_t next = 0;  // byte of the file that follows the block
    std::array<char, 1 << 14> block;
  };
  Buffer buffer_;
};

/// "a folder", "a device", "a pipe", "a socket"; "no regular file" for anything else.
const char* kind_name(std::filesystem::file_type type);

}  // namespace ra2d
