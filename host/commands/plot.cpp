// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/errors.hpp"
#include "host/output_file.hpp"
#include "host/partial_file.hpp"
#include "host/plot/draw.hpp"
#include "host/plot/profile_picture.hpp"
#include "host/plot/result_picture.hpp"
#include "host/text.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

struct Request {
  std::vector<fs::path> files;
  fs::path output;
  std::string what = "overview", x_unit, z_unit;
  std::optional<double> cutoff;  // m
  bool quiet = false;
};

/// What a script is to draw.
struct Drawing {
  std::string script, data;
};

/// What the ending of a picture's name asks for.
std::string format_of(const fs::path& picture) {
  std::string ending = picture.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* format : {"png", "svg", "pdf"})
    if (ending == std::string(".") + format) return format;
  throw RequestError(fmt::format("-o {}: expected a name that ends in .png, .svg or .pdf",
                                 shortened(picture.string())));
}

/// HDF5 files begin in the same way all.
bool is_hdf5(const fs::path& file) {
  constexpr std::string_view signature{"\x89HDF\r\n\x1a\n", 8};
  std::array<char, signature.size()> begin{};
  std::ifstream{file, std::ios::binary}.read(begin.data(), begin.size());
  return std::string_view{begin.data(), begin.size()} == signature;
}

void require_readable(const fs::path& file) {
  std::error_code none;
  if (fs::is_directory(file, none))
    throw FileError(fmt::format("cannot read '{}': this is a folder", file.string()));
  if (!std::ifstream{file})
    throw FileError(fmt::format("cannot read '{}': {}", file.string(),
                                fs::exists(file, none) ? "unreadable" : "there is no such file"));
}

void require_view(const std::string& what, const std::vector<std::string>& views,
                  const std::string& of) {
  if (std::find(views.begin(), views.end(), what) != views.end()) return;
  const auto near = nearest(what, views);
  throw RequestError(fmt::format("--what {}: of {} there {}{}", shortened(what), of,
                                 views.size() == 1 ? "is only " : "are ", any_of(views, "'")) +
                     (near ? fmt::format(" (did you mean '{}'?)", *near) : ""));
}

std::optional<LengthUnit> unit_of(const char* option, const std::string& word) {
  if (word.empty()) return {};
  const auto unit = to_unit(word);
  if (!unit)
    throw RequestError(fmt::format("{}: '{}': expected m, mm, um or nm", option, shortened(word)));
  return unit;
}

Drawing draw_profile(const Request& request) {
  require_view(request.what, {"overview"}, "a profile");
  const ProfilePictureOptions options{.query = {.x_unit = unit_of("--x-unit", request.x_unit),
                                                .z_unit = unit_of("--z-unit", request.z_unit)},
                                      .cutoff = request.cutoff};
  return {"plot_profile.py", profile_picture(request.files.front(), options)};
}

Drawing choose_drawing(const Request& request) {
  for (const fs::path& file : request.files) require_readable(file);
  const auto results = std::count_if(request.files.begin(), request.files.end(), is_hdf5);
  if (results == 0 && request.files.size() == 1) return draw_profile(request);
  for (const fs::path& file : request.files)
    if (!is_hdf5(file))
      throw RequestError(
          fmt::format("{}: no result of 'ra2d run': several files in one picture must all be "
                      "results; a profile has a picture of its own",
                      file.string()));
  if (!request.x_unit.empty() || !request.z_unit.empty() || request.cutoff)
    throw RequestError("--x-unit, --z-unit and --cutoff are of profiles: a result needs none");
  if (results == 1) {
    require_view(request.what, result_views(), "a result");
    return {"plot_result.py", result_picture(request.files.front(), request.what)};
  }
  require_view(request.what, results_views(), "several results");
  if (request.files.size() > most_results && !request.quiet)
    say(fmt::format("a picture keeps {} results apart: the first {} of {} are drawn", most_results,
                    most_results, request.files.size()));
  return {"plot_result.py", results_picture(request.files, request.what)};
}

/// What is to be drawn stands beside the picture while it is drawn, and is gone afterwards.
void make_picture(const Drawing& drawing, const fs::path& picture, const std::string& format) try {
  const fs::path target = replaced_file(picture);
  PartialFile file(target);
  const PartialFile data(target.parent_path() / (target.filename().string() + ".json"));
  {
    std::ofstream out(data.path(), std::ios::binary);
    if (!(out << drawing.data << std::flush))
      throw FileError(fmt::format("cannot write '{}'", data.path().string()));
  }
  draw(drawing.script, {data.path().string(), file.path().string(), format});
  file.sync();
  file.publish();
} catch (const FileError& fault) {
  throw FileError(fmt::format("the picture {} was not made: {}", picture.string(), fault.what()));
}

int plot_files(const Request& request) {
  const fs::path picture = request.output.empty()
                               ? fs::path(request.files.front().stem().string() + ".png")
                               : request.output;
  const std::string format = format_of(picture);
  require_output(picture, request.files);
  make_picture(choose_drawing(request), picture, format);
  if (!request.quiet) print("written: {}\n", printable(picture.string()));
  return done;
}

}  // namespace

void add_plot(CLI::App& app, Chosen& chosen) {
  const auto asked = std::make_shared<Request>();
  Request& request = *asked;
  CLI::App* plot = app.add_subcommand(
      "plot",
      "makes a picture of a result, of several over one another, or of a measured profile; needs "
      "Python with matplotlib");
  plot->add_option("FILE", request.files, "results of 'ra2d run', or one profile")
      ->required()
      ->check(path());
  plot->add_option("-o,--output", request.output,
                   "picture, .png, .svg or .pdf [FILE's name with .png, in the current folder]")
      ->type_name("PICTURE")
      ->check(path());
  plot->add_option("--what", request.what,
                   fmt::format("what of a result is shown: {}; of several results: {}",
                               any_of(result_views(), ""), any_of(results_views(), "")))
      ->type_name("NAME")
      ->check(path())
      ->capture_default_str();
  plot->add_option("--x-unit", request.x_unit,
                   "of a profile's x: m, mm, um or nm [the file's own, or m]")
      ->type_name("UNIT");
  plot->add_option("--z-unit", request.z_unit, "of its heights [the file's own, or m]")
      ->type_name("UNIT");
  plot->add_option("--cutoff", request.cutoff,
                   "of the filter of a profile, in metres [2.5e-3, or none for a short profile]")
      ->type_name("M")
      ->check(positive_number());
  plot->add_flag("--quiet", request.quiet, "print nothing but errors");
  plot->callback([asked, &chosen] { chosen = [asked] { return plot_files(*asked); }; });
}

}  // namespace ra2d
