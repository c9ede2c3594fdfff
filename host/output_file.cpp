// SPDX-License-Identifier: BSD-3-Clause
#include "host/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "host/errors.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

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

/// Follows `path` to the file that is written; says why there can be none, or nothing.
std::string follow(fs::path& path) {
  if (!path.has_filename()) return "this is a folder";
  std::error_code unknown;
  // as the system follows it: also to a pipe behind /dev/stdout, which no link names
  const fs::file_status end = fs::status(path, unknown);
  if (fs::exists(end) && !fs::is_regular_file(end))
    return std::string(fs::is_symlink(fs::symlink_status(path, unknown)) ? "it leads to "
                                                                         : "this is ") +
           kind_name(end.type());
  constexpr int most_links = 40;  // as many as the system follows
  for (int links = 0;; ++links) {
    if (!fs::is_symlink(fs::symlink_status(path, unknown))) return {};
    if (links == most_links) return "its symbolic links lead in a ring";
    path = path.parent_path() /
           fs::read_symlink(path, unknown);  // an absolute one replaces the folder
  }
}

std::string refusal(const fs::path& path, const std::string& why) {
  return fmt::format("cannot write to '{}': {}. Name a file with -o", path.string(), why);
}

}  // namespace

fs::path replaced_file(const fs::path& path) {
  fs::path file = path;
  if (const std::string why = follow(file); !why.empty()) throw FileError(refusal(path, why));
  return file;
}

void require_output(const fs::path& output, const std::vector<fs::path>& inputs) {
  fs::path file = output;
  if (const std::string why = follow(file); !why.empty()) throw RequestError(refusal(output, why));
  std::error_code none;
  for (const fs::path& input : inputs)
    if (fs::equivalent(file, input, none))
      throw RequestError(
          fmt::format("'{}' would be overwritten with the output, and it is an input ('{}'): name "
                      "another file with -o",
                      output.string(), input.string()));
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, none))
    throw FileError(fmt::format("cannot write '{}': there is no folder '{}'", output.string(),
                                folder.string()));
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw FileError(fmt::format("cannot write '{}': the folder '{}': {}", output.string(),
                                folder.string(), std::strerror(errno)));
}

}  // namespace ra2d
