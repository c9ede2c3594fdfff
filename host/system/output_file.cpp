// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/errors.hpp"
#include "host/system/input_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {

namespace {

namespace fs = std::filesystem;

std::string refusal(const fs::path& path, const std::string& why, const char* option) {
  return fmt::format("cannot write to '{}': {}. Name a file with {}", path.string(), why, option);
}

/// Follows `path` to the file that is written; says why there can be none, or nothing. Throws
/// FileError for links in a ring.
std::string follow(fs::path& path, const char* option) {
  if (!path.has_filename()) return "this is a folder";
  const fs::path given = path;
  std::error_code unknown;
  // as the system follows it: also to a pipe behind /dev/stdout, which no link names
  const fs::file_status end = fs::status(given, unknown);
  if (unknown == std::errc::too_many_symbolic_link_levels)
    throw FileError(refusal(given, "its symbolic links lead in a ring", option));
  const char* const leads =
      fs::is_symlink(fs::symlink_status(given, unknown)) ? "it leads to " : "this is ";
  if (fs::exists(end) && !fs::is_regular_file(end))
    return std::string(leads) + kind_name(end.type());
  constexpr int most_links = 40;  // as many as the system follows
  for (int links = 0; fs::is_symlink(fs::symlink_status(path, unknown)); ++links) {
    if (links == most_links)
      throw FileError(refusal(given, "its symbolic links lead in a ring", option));
    path = path.parent_path() /
           fs::read_symlink(path, unknown);  // an absolute one replaces the folder
  }
  // Of an open file that was removed /proc still tells a name, with "(deleted)" behind it.
  if (path != given && fs::exists(end) && !is_same_file(given, path))
    return std::string(leads) + "a file that has lost its name";
  return {};
}

/// A name in a study's folder of ledgers, where every file is taken for one.
bool is_among_ledgers(const fs::path& file) {
  std::error_code none;
  const fs::path folder = fs::weakly_canonical(folder_of(file), none);
  return folder.filename() == "ledger" && fs::exists(folder.parent_path() / "study.json", none);
}

/// Whether what is printed goes to this file.
bool is_printed_to(const fs::path& file) {
  struct stat output {
  }, printed{};
  if (stat(file.c_str(), &output) != 0) return false;
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    if (fstat(stream, &printed) == 0 && S_ISREG(printed.st_mode) &&
        printed.st_dev == output.st_dev && printed.st_ino == output.st_ino)
      return true;
  return false;
}

/// How files begin that are made from others, by the ending of their names. Tables have no such
/// mark.
constexpr std::pair<std::string_view, std::string_view> beginnings[] = {
    {".wav", "RIFF"}, {".flac", "fLaC"}, {".json", "{"}, {".png", "\x89PNG"},
    {".pdf", "%PDF"}, {".svg", "<"},     {".html", "<"}, {".htm", "<"}};

/// "no .wav file" of one that begins otherwise than its name says; else empty.
std::string kind_of_other(std::string ending, const std::string& beginning) {
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [of_name, mark] : beginnings)
    if (ending == of_name && !beginning.empty() && !beginning.starts_with(mark))
      return fmt::format("no {} file", ending);
  return {};
}

/// The kind of a file that is costly to make again, "a result, or other data in HDF5", or is not
/// what its name says. Empty for other files, and for one that cannot be read. `ending`: of the
/// name that was given, which may be a link to the file.
std::string kind_of_kept(const fs::path& file, const std::string& ending) {
  std::error_code none;
  if (!fs::exists(file, none)) return {};
  const std::string name = file.filename().string();
  const fs::path folder = folder_of(file);
  const bool of_study =
      name == "study.json" || (name.starts_with("status") && name.ends_with(".json"));
  if (of_study && fs::is_directory(folder / "ledger", none)) return "a study's own file";
  try {
    const std::string beginning = InputFile(file).beginning(200);
    if (beginning.starts_with("\x89HDF\r\n\x1a\n")) return "a result, or other data in HDF5";
    if (beginning.starts_with("ra2d checkpoint")) return "the checkpoint of a run";
    if (beginning.starts_with("ra2dlog\n")) return "a study's ledger";
    const bool is_planned = beginning.starts_with("# ") &&
                            beginning.find(" with no more than level, ") != beginning.npos;
    if (file.extension() == ".toml" && !beginning.empty() && !is_planned)
      return "a scene or a study";
    return kind_of_other(ending, beginning);
  } catch (const FileError&) {  // a file that cannot be read is no result that could be lost
  }
  return {};
}

}  // namespace

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

fs::path replaced_file(const fs::path& path, const char* option) {
  fs::path file = path;
  if (const std::string why = follow(file, option); !why.empty())
    throw FileError(refusal(path, why, option));
  return file;
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code none;
  if (fs::equivalent(a, b, none)) return true;
  // where the numbers of inodes are not to be relied on
  const fs::path whole_a = fs::canonical(a, none);
  return !none && whole_a == fs::canonical(b, none) && !none;
}

void require_replaceable(const fs::path& file, const char* option) {
  struct stat status;
  if (lstat(file.c_str(), &status) != 0) return;  // there is none
  const auto fail = [&](const char* why) {
    throw FileError(fmt::format(
        "cannot write '{}': the file that is there may not be replaced: {}. Name another with {}",
        file.string(), why, option));
  };
#ifdef STATX_ATTR_MOUNT_ROOT
  struct statx more;
  if (statx(AT_FDCWD, file.c_str(), AT_SYMLINK_NOFOLLOW, 0, &more) == 0 &&
      (more.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0)
    fail("it is mounted there");
#endif
  // rmdir never removes a file. It says so only after it has asked whether this process may remove
  // what is there: whose it is in a folder like /tmp, and whether it is write-protected.
  if (!S_ISDIR(status.st_mode) && rmdir(file.c_str()) != 0 && (errno == EPERM || errno == EACCES))
    fail(std::strerror(errno));
}

void require_output(const fs::path& output, const std::vector<fs::path>& inputs,
                    const char* option) {
  fs::path file = output;
  if (const std::string why = follow(file, option); !why.empty())
    throw RequestError(refusal(output, why, option));
  std::error_code none;
  for (const fs::path& input : inputs) {
    if (is_same_file(file, input))
      throw RequestError(
          fmt::format("'{}' would be overwritten with the output, and it is an input ('{}'): name "
                      "another file with {}",
                      output.string(), input.string(), option));
    if (is_partial_name(input) || is_partial_name(fs::canonical(input, none)))
      throw RequestError(
          fmt::format("the input '{}' bears the name of a partial file of ra2d, and those are "
                      "removed: rename it",
                      input.string()));
  }
  if (is_among_ledgers(file))
    throw RequestError(fmt::format(
        "'{}' is a place among the ledgers of a study: it is left as it is. Name a file "
        "elsewhere with {}",
        output.string(), option));
  if (is_printed_to(file))
    throw RequestError(
        fmt::format("'{}' is also where this program prints to: name another file with {}",
                    output.string(), option));
  const fs::path folder = folder_of(file);
  if (!fs::is_directory(folder, none))
    throw FileError(fmt::format("cannot write '{}': there is no folder '{}'", output.string(),
                                folder.string()));
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw FileError(fmt::format("cannot write '{}': the folder '{}': {}", output.string(),
                                folder.string(), std::strerror(errno)));
  require_replaceable(file, option);
}

void require_derived_output(const fs::path& output, const std::vector<fs::path>& inputs,
                            const char* option) {
  require_output(output, inputs, option);
  if (const std::string kind = kind_of_kept(replaced_file(output, option), output.extension());
      !kind.empty())
    throw RequestError(
        fmt::format("'{}' is {}: it is left as it is. Name another file with {}, or remove it",
                    output.string(), kind, option));
}

}  // namespace ra2d
