// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace ra2d {
namespace {

namespace fs = std::filesystem;

std::string reason(int error) {
  return error == ELOOP ? "its symbolic links lead in a ring" : std::strerror(error);
}

fs::file_type type_of(const struct stat& status) {
  switch (status.st_mode & S_IFMT) {
    case S_IFREG:
      return fs::file_type::regular;
    case S_IFDIR:
      return fs::file_type::directory;
    case S_IFCHR:
      return fs::file_type::character;
    case S_IFBLK:
      return fs::file_type::block;
    case S_IFIFO:
      return fs::file_type::fifo;
    case S_IFSOCK:
      return fs::file_type::socket;
    default:
      return fs::file_type::unknown;
  }
}

}  // namespace

const char* kind_name(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::block:
    case fs::file_type::character:
      return "a device";
    case fs::file_type::fifo:
      return "a pipe";
    case fs::file_type::socket:
      return "a socket";
    default:
      return "no regular file";
  }
}

InputFile::InputFile(const fs::path& path, const std::string& what) : path_{path}, what_{what} {
  struct stat status;
  const auto require_regular = [&] {
    if (S_ISREG(status.st_mode)) return;
    if (descriptor_ >= 0) close(std::exchange(descriptor_, -1));
    const fs::file_type type = type_of(status);
    throw unreadable(
        fmt::format("this is {}: expected a file{}", kind_name(type),
                    type == fs::file_type::fifo ? ": write what comes through it to one" : ""));
  };
  // First by its name: to open a device may move a tape, to open a pipe may wake up its writer.
  if (stat(path.c_str(), &status) != 0) throw unreadable(reason(errno));
  require_regular();
  // It may be another one by now.
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor_ < 0) throw unreadable(reason(errno));
  if (fstat(descriptor_, &status) != 0) {
    const int error = errno;
    close(std::exchange(descriptor_, -1));
    throw unreadable(reason(error));
  }
  require_regular();
  size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::~InputFile() { close(descriptor_); }

FileError InputFile::unreadable(const std::string& why) const {
  return FileError(
      fmt::format("cannot read {}'{}': {}", what_.empty() ? "" : what_ + ' ', path_.string(), why));
}

std::size_t InputFile::read(std::uint64_t at, char* to, std::size_t count) const {
  count = static_cast<std::size_t>(
      std::min<std::uint64_t>(count, at < size_ ? size_ - at : std::uint64_t{0}));
  std::size_t have = 0;
  while (have < count) {
    const ssize_t got = pread(descriptor_, to + have, count - have, static_cast<off_t>(at + have));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw unreadable(reason(errno));
    if (got == 0) break;  // it was cut short meanwhile
    have += static_cast<std::size_t>(got);
  }
  return have;
}

std::string InputFile::beginning(std::size_t most) const {
  std::string bytes(static_cast<std::size_t>(std::min<std::uint64_t>(most, size_)), '\0');
  bytes.resize(read(0, bytes.data(), bytes.size()));
  return bytes;
}

InputStream::InputStream(const fs::path& path, const std::string& what)
    : std::istream(nullptr), buffer_(path, what) {
  rdbuf(&buffer_);
}

InputStream::Buffer::int_type InputStream::Buffer::underflow() {
  const std::size_t count = file.read(next, block.data(), block.size());
  next += count;
  setg(block.data(), block.data(), block.data() + count);
  return count > 0 ? traits_type::to_int_type(block[0]) : traits_type::eof();
}

InputStream::Buffer::pos_type InputStream::Buffer::seekpos(pos_type place,
                                                           std::ios_base::openmode) {
  if (off_type(place) < 0) return off_type(-1);
  next = static_cast<std::uint64_t>(off_type(place));
  setg(nullptr, nullptr, nullptr);
  return place;
}

}  // namespace ra2d
