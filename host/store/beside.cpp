// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/beside.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include "host/errors.hpp"
#include "host/output_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t digits = 6;

/// Whether the open folder still stands under this name.
bool stands_at(int descriptor, const fs::path& path) {
  struct stat opened, named;
  return fstat(descriptor, &opened) == 0 && lstat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

/// The number of a segment's file name; 0 of any other.
std::size_t number_of(const std::string& name) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc() && std::string_view(end) == ".h5" &&
                 name.size() >= digits + std::strlen(".h5")
             ? number
             : 0;
}

}  // namespace

OutputNames names_beside(const fs::path& output) {
  OutputNames names;
  names.result = replaced_file(output);
  const auto with = [&](const char* end) {
    fs::path path = names.result;
    return path += end;
  };
  names.segments = with(".parts");
  names.checkpoint = with(".checkpoint");
  names.previous = with(".checkpoint.previous");
  return names;
}

ClaimedOutput::ClaimedOutput(const fs::path& output) : names_{names_beside(output)} {
  const auto fail = [&](int error) {
    throw write_failure("make the folder", names_.segments, std::strerror(error), error);
  };
  while (folder_ < 0) {
    std::error_code none;
    // before the folder: a signal may come as soon as it is there
    if (!fs::exists(fs::symlink_status(names_.segments, none))) partial_.emplace(names_.segments);
    if (mkdir(names_.segments.c_str(), 0777) != 0) {
      const int error = errno;
      partial_.reset();  // it may be somebody else's
      if (error != EEXIST) fail(error);
    }
    folder_ = open(names_.segments.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder_ < 0 && errno == ENOENT) continue;  // whoever had it is done
    if (folder_ < 0 && (errno == ENOTDIR || errno == ELOOP))
      throw FileError(
          fmt::format("'{}' stands where the segments of '{}' go, and is no folder: move it, "
                      "or choose another output with -o",
                      names_.segments.string(), names_.result.string()));
    if (folder_ < 0) fail(errno);
    const bool taken = flock(folder_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!taken && stands_at(folder_, names_.segments)) break;
    close(folder_);
    folder_ = -1;
    if (taken)
      throw OutputTaken(
          fmt::format("another process writes '{}': wait until it is done, or choose "
                      "another output with -o",
                      names_.result.string()));
  }
  if (!partial_) partial_.emplace(names_.segments);
}

ClaimedOutput::~ClaimedOutput() {
  rmdir(names_.segments.c_str());  // unless there is something in it
  close(folder_);
}

std::string segment_name(std::size_t number) { return fmt::format("{:0{}}.h5", number, digits); }

fs::path segments_of(const fs::path& checkpoint) {
  std::string path = checkpoint.string();
  for (const std::string_view end : {".previous", ".checkpoint"})
    if (path.ends_with(end)) path.resize(path.size() - end.size());
  return path + ".parts";
}

fs::path OutputNames::segment(std::size_t number) const { return segments / segment_name(number); }

void ClaimedOutput::remove_segments(std::size_t from) const {
  std::error_code none;
  for (fs::directory_iterator entry(names_.segments, none), end; !none && entry != end;
       entry.increment(none)) {
    const std::size_t number = number_of(entry->path().filename().string());
    if (number >= from && number > 0) unlink(entry->path().c_str());
  }
}

void ClaimedOutput::remove_all() const {
  // segments without a checkpoint are nothing; a checkpoint without segments would be refused
  unlink(names_.checkpoint.c_str());
  unlink(names_.previous.c_str());
  remove_segments(1);
}

}  // namespace ra2d
