// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/output_names.hpp"

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
#include <utility>

#include "host/base/errors.hpp"
#include "host/store/result_reader.hpp"
#include "host/store/sealed_hdf5.hpp"
#include "host/system/input_file.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t digits = 6;

constexpr int most_attempts = 1000;  // to make the folder, which others may remove

/// The number of a segment's file name; 0 of any other.
std::size_t number_of(const std::string& name) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc() && std::string_view(end) == ".h5" &&
                 name.size() >= digits + std::strlen(".h5")
             ? number
             : 0;
}

/// Whether a file that is there is a checkpoint, or was begun as one.
bool is_checkpoint(const fs::path& file) {
  constexpr std::string_view kind = "ra2d checkpoint";
  return kind.starts_with(InputFile(file).beginning(kind.size()));
}

/// Throws where something has a name of ours that is not ours.
void require_own(const fs::path& file, const fs::path& output, const char* what,
                 bool (*is_own)(const fs::path&)) {
  std::error_code none;
  const fs::file_status status = fs::symlink_status(file, none);
  if (!fs::exists(status)) return;
  if (!fs::is_regular_file(status) || !is_own(file))
    throw FileError(
        fmt::format("'{}' stands where {} of '{}' goes, and is none: it is left as it is. Move it "
                    "away, or choose "
                    "another output with -o",
                    file.string(), what, output.string()));
  require_replaceable(file);
}

}  // namespace

bool is_segment_name(const fs::path& file) {
  return number_of(file.filename().string()) > 0 && file.parent_path().extension() == ".parts";
}

void require_output_names(const OutputNames& names, const std::vector<fs::path>& inputs) {
  std::error_code none;
  for (const fs::path& input : inputs) {
    const fs::path file = fs::canonical(input, none);
    const bool is_segment =
        number_of(file.filename().string()) > 0 && is_same_file(file.parent_path(), names.segments);
    if (is_segment || is_same_file(input, names.checkpoint) || is_same_file(input, names.previous))
      throw RequestError(
          fmt::format("the input '{}' has the name of a file that a run to '{}' makes and removes: "
                      "rename it, or choose another output with -o",
                      input.string(), names.result.string()));
  }
  for (const fs::path& file : {names.checkpoint, names.previous})
    require_own(file, names.result, "a checkpoint", is_checkpoint);
  if (fs::is_directory(fs::symlink_status(names.segments, none)) &&
      access(names.segments.c_str(), W_OK | X_OK) != 0)
    throw write_failure("write to the folder", names.segments, std::strerror(errno), errno);
  for (fs::directory_iterator entry(names.segments, none), end; !none && entry != end;
       entry.increment(none))
    if (number_of(entry->path().filename().string()) > 0)
      require_own(entry->path(), names.result, "a segment", [](const fs::path& file) {
        // damage is found by the run that goes on from it
        return is_damaged_with(file, "creator") || stamp_of(file).has_value();
      });
}

OutputNames output_names(const fs::path& output) {
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

ClaimedOutput::ClaimedOutput(const fs::path& output) : names_{output_names(output)} { take(); }

ClaimedOutput::~ClaimedOutput() {
  if (folder_ < 0) return;
  rmdir(names_.segments.c_str());  // unless there is something in it
  close(folder_);
}

void ClaimedOutput::hold() {
  if (stands_at(folder_, names_.segments)) return;
  close(std::exchange(folder_, -1));
  take();
}

/// Makes the folder and takes its lock.
void ClaimedOutput::take() {
  const auto fail = [&](int error) {
    throw write_failure("make the folder", names_.segments, std::strerror(error), error);
  };
  for (int attempt = 0; folder_ < 0; ++attempt) {
    if (attempt == most_attempts) fail(ENOENT);
    std::error_code none;
    // before the folder: a signal may come as soon as it is there
    if (!fs::exists(fs::symlink_status(names_.segments, none))) partial_.emplace(names_.segments);
    if (mkdir(names_.segments.c_str(), 0777) != 0) {
      const int error = errno;
      partial_.reset();  // it may be somebody else's
      if (error != EEXIST) fail(error);
    }
    folder_ = open(names_.segments.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder_ < 0 && errno == ENOENT) continue;  // the process that had it is done
    if (folder_ < 0 && (errno == ENOTDIR || errno == ELOOP))
      throw FileError(
          fmt::format("'{}' stands where the segments of '{}' go, and is no folder: move it, "
                      "or choose another output with -o",
                      names_.segments.string(), names_.result.string()));
    if (folder_ < 0) fail(errno);
    const bool taken = flock(folder_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    try {
      if (!taken && stands_at(folder_, names_.segments)) break;
    } catch (...) {
      rmdir(names_.segments.c_str());
      close(std::exchange(folder_, -1));
      throw;
    }
    close(std::exchange(folder_, -1));
    if (taken)
      throw OutputTaken(
          fmt::format("another process writes '{}': wait until it is done, or choose "
                      "another output with -o",
                      names_.result.string()));
  }
  if (!partial_) partial_.emplace(names_.segments);
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
