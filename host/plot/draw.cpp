// SPDX-License-Identifier: BSD-3-Clause
#include "host/plot/draw.hpp"

#include <fmt/format.h>

#include <cctype>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/system/partial_file.hpp"
#include "host/system/process.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

/// Exit status of a script that has no matplotlib (host/plot/chart_style.py).
constexpr int no_matplotlib = 9;

/// Beside the installed program, or where it was built from.
fs::path find_script(const std::string& name) {
  std::error_code none;
  const fs::path installed =
      (program_folder() / RA2D_SCRIPTS_FROM_PROGRAM / name).lexically_normal();
  if (fs::exists(installed, none)) return installed;
  const fs::path source = fs::path(RA2D_SCRIPTS_SOURCE) / name;
  if (fs::exists(source, none)) return source;
  throw FileError(fmt::format("the script {} is neither at '{}' nor at '{}': install ra2d again",
                              name, installed.string(), source.string()));
}

}  // namespace

void draw(const std::string& script, const std::vector<std::string>& arguments) {
  const std::string path = find_script(script).string();
  bool any = false;
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    std::vector<std::string> words{python, path};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const int status = run_program(words).status;
    if (status == 0) return;
    if (status < 0 || status == 127) continue;
    any = true;
    if (status != no_matplotlib)
      throw FileError(fmt::format("{} failed with status {} (its message is above)", path, status));
  }
  throw FileError(
      any ? "no python3 here has matplotlib: install it (on Debian: apt-get install "
            "python3-matplotlib)"
          : "there is no python3: install it with matplotlib (on Debian: apt-get install "
            "python3-matplotlib)");
}

std::string picture_kind(const fs::path& picture) {
  std::string ending = picture.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* kind : {"png", "svg", "pdf"})
    if (ending == std::string(".") + kind) return kind;
  throw RequestError(fmt::format("-o {}: expected a name that ends in .png, .svg or .pdf",
                                 shortened(picture.string())));
}

void draw_picture(const std::string& script, std::vector<std::string> arguments,
                  const fs::path& picture) {
  PartialFile file(picture);
  arguments.push_back(file.path().string());
  arguments.push_back(picture_kind(picture));
  draw(script, arguments);
  file.sync();
  file.publish();
}

}  // namespace ra2d
