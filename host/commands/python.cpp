// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/python.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cctype>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <system_error>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/print.hpp"
#include "host/system/partial_file.hpp"
#include "host/system/process.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

/// Exit status of the package where a library is missing (host/python/ra2d/__main__.py). It prints
/// the names of all that are.
constexpr int library_missing = 9;

/// The package: beside the installed program, or where it was built from.
fs::path find_package() {
  std::error_code none;
  const fs::path name = fs::path("ra2d") / "__main__.py";
  const fs::path installed =
      (program_folder() / RA2D_PACKAGE_FROM_PROGRAM / name).lexically_normal();
  if (fs::exists(installed, none)) return installed;
  const fs::path source = fs::path(RA2D_PACKAGE_SOURCE) / name;
  if (fs::exists(source, none)) return source;
  throw FileError(
      fmt::format("the Python package of ra2d is neither at '{}' nor at '{}': install ra2d again",
                  installed.parent_path().string(), source.parent_path().string()));
}

/// A text that a program finds as its standard input.
class Input {
 public:
  explicit Input(const std::string& text) : descriptor_{memfd_create("request", MFD_CLOEXEC)} {
    const auto count = static_cast<ssize_t>(text.size());
    if (descriptor_ < 0 || write(descriptor_, text.data(), text.size()) != count ||
        lseek(descriptor_, 0, SEEK_SET) != 0)
      throw FileError("no memory for the request to the Python package");
  }
  ~Input() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// Whether the package has said how the command ended: not where a signal or a fault of Python's
/// own ended it.
bool is_reported(int status) {
  return status == exit_status::done || status == exit_status::wrong_request ||
         status == exit_status::failed || status == exit_status::wrong_file ||
         status == exit_status::out_of_time || status == exit_status::interrupted + SIGINT;
}

/// This program, to be started again by the package.
fs::path this_program() {
  std::error_code none;
  const fs::path found = fs::read_symlink("/proc/self/exe", none);
  return none ? program_folder() / "ra2d" : found;
}

/// Names of libraries, a line each, as Debian's packages.
std::string debian_packages(const std::string& lines) {
  std::string packages;
  for (std::size_t at = 0, end = 0; (end = lines.find('\n', at)) != lines.npos; at = end + 1)
    packages += (packages.empty() ? "python3-" : " python3-") + lines.substr(at, end - at);
  return printable(packages);
}

}  // namespace

int ask_python(const nlohmann::ordered_json& request) {
  const std::string package = find_package().string();
  // in ASCII, which Python reads alike in every locale
  const std::string text =
      request.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  // the package asks this program, and no other one, for numbers
  setenv("RA2D", this_program().c_str(), 1);
  std::string missing;
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const Input input(text);
    const ProgramRun run = run_program({python, package}, Output::kept,
                                       std::numeric_limits<double>::infinity(), input.descriptor());
    if (run.status < 0 || run.status == 127) continue;
    if (is_reported(run.status)) {
      print_text(run.out);
      return run.status;
    }
    if (run.status > exit_status::interrupted)
      throw FileError(
          fmt::format("signal {} ended Python before it was done: is there enough memory?",
                      run.status - exit_status::interrupted));
    if (run.status != library_missing)
      throw FileError(fmt::format("{} ended with status {}: its message, if any, is above", python,
                                  run.status));
    missing = debian_packages(run.out);
  }
  if (missing.empty())
    throw FileError(
        "this needs Python, and there is no python3: install it (on Debian: apt-get install "
        "python3 "
        "python3-matplotlib python3-h5py python3-xarray python3-pandas python3-scipy "
        "python3-jinja2 python3-soundfile python3-xxhash)");
  throw FileError(fmt::format(
      "this needs libraries that no python3 here has: install them (on Debian: apt-get install {})",
      missing));
}

std::string path_text(const fs::path& path) {
  std::string text;
  for (const char c : path.string()) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xc0 | byte >> 6);
      text += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return text;
}

std::vector<std::string> path_texts(const std::vector<fs::path>& paths) {
  std::vector<std::string> texts;
  for (const fs::path& path : paths) texts.push_back(path_text(path));
  return texts;
}

std::string picture_kind(const fs::path& picture) {
  std::string ending = picture.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* kind : {"png", "svg", "pdf"})
    if (ending == std::string(".") + kind) return kind;
  throw RequestError(fmt::format("-o {}: expected a name that ends in .png, .svg or .pdf",
                                 shortened(picture.string())));
}

int make_picture(nlohmann::ordered_json request, const fs::path& picture) try {
  PartialFile file(picture);
  request["command"] = "plot";
  request["made"] = path_text(picture);
  request["output"] = path_text(file.path());
  request["kind"] = picture_kind(picture);
  const int status = ask_python(request);
  if (status != exit_status::done) return status;
  file.sync();
  file.publish();
  return status;
} catch (const FileError& fault) {
  throw FileError(fmt::format("the picture {} was not made: {}", picture.string(), fault.what()));
}

}  // namespace ra2d
