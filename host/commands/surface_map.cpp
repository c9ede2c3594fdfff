// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/map_report.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/map_output.hpp"
#include "host/surface/random_map.hpp"
#include "host/surface/surface.hpp"

namespace ra2d {
namespace {

constexpr const char* map_title = "ra2d surface map";

struct MapRequest {
  std::filesystem::path file, output;
  MapQuery query;
  MapPreparation preparation;
  std::string extension;                // "repeat" or "mirror"
  std::optional<double> length, width;  // m
  bool json = false;
};

/// The map on the area that is asked for, or as it is.
HeightMap on_the_area(HeightMap map, const MapRequest& request) {
  if (!request.length && !request.width) return map;
  const std::string name = request.file.string();
  const double nx = request.length ? std::floor(*request.length / map.spacing + 1e-9) + 1
                                   : static_cast<double>(map.nx);
  const double ny =
      request.width ? map_rows(*request.width, map.spacing_y) : static_cast<double>(map.ny);
  require_map_size(name, nx, ny);
  const auto columns = static_cast<std::size_t>(nx), rows = static_cast<std::size_t>(ny);
  if (request.extension.empty() && (columns > map.nx || rows > map.ny))
    throw RequestError(
        fmt::format("{}: {} by {} points are asked for, and the map has {} by {}: say with "
                    "--extend how it goes on, or lower --length and --width",
                    name, columns, rows, map.nx, map.ny));
  const MapExtension how =
      request.extension == "repeat" ? MapExtension::repeat : MapExtension::mirror;
  HeightMap made = extended_map(map, how, columns, rows, name);
  subtract_map_mean(made);
  return made;
}

int describe_map(const MapRequest& request) {
  const std::string name = request.file.string();
  if (!request.output.empty()) require_map_output(request.output, map_title, {request.file});
  if (!request.extension.empty() && !request.length && !request.width)
    throw RequestError("--extend has nothing to do without --length or --width");
  HeightMap map = read_height_map(request.file, request.query);
  const std::size_t missing = map.missing();
  std::vector<std::string> doubts;
  prepare_map(map, request.preparation, name, &doubts);
  map = on_the_area(std::move(map), request);
  if (!request.output.empty())
    write_height_map(request.output, map, fmt::format("{}: from {}", map_title, printable(name)));
  say_doubts(doubts, false);
  if (request.json) {
    nlohmann::ordered_json json{{"file", name}};
    json.update(map_json(map, missing));
    using Handler = nlohmann::ordered_json::error_handler_t;  // of names that are no UTF-8
    print_text(json.dump(2, ' ', false, Handler::replace) + '\n');
  } else {
    print("{}\n", printable(name));
    print_map(map, missing);
  }
  return exit_status::done;
}

/// How the file is read, and the map prepared.
void add_preparation(CLI::App& map, MapRequest& request) {
  const auto word = [&](const char* name, const char* type, const char* words, const char* expected,
                        auto understand, auto take) {
    map.add_option_function<std::string>(
           name, [=](const std::string& text) { take(*understand(text)); }, words)
        ->type_name(type)
        ->check(understood(expected, understand));
  };
  word(
      "--z-unit", "UNIT:{m,mm,um,nm}", "of the heights [the file's own, or m]", "m, mm, um or nm",
      [](const std::string& text) { return to_unit(text); },
      [&request](const LengthUnit& unit) { request.query.z_unit = unit; });
  word(
      "--decimal", "MARK:{point,comma}",
      "the decimal mark, where the text is ambiguous [from the file]", "point or comma",
      [](const std::string& text) -> std::optional<DecimalMark> {
        if (text == "point") return DecimalMark::point;
        if (text == "comma") return DecimalMark::comma;
        return {};
      },
      [&request](DecimalMark mark) { request.query.decimal = mark; });
  word(
      "--fill", "linear:M",
      "straight lines along x or y through missing points, over gaps up to M metres [they are "
      "refused]",
      "linear:WIDTH, with a width in metres, like linear:1e-5",
      [](const std::string& text) { return to_fill_width(text); },
      [&request](double width) { request.preparation.fill = width; });
  word(
      "--form", "FORM:{none,mean,plane,poly:N}",
      "form to be taken off, by least squares; poly:N of degree N in x and y together [none]",
      "none, mean, plane or poly:N with N from 0 to 10",
      [](const std::string& text) { return understand_map_form(text); },
      [&request](MapForm form) { request.preparation.form = form; });
}

}  // namespace

void add_surface_map(CLI::App& surface, ChosenCommand& chosen) {
  const auto shared = std::make_shared<MapRequest>();
  MapRequest& request = *shared;
  CLI::App* map =
      surface.add_subcommand("map",
                             "size and roughness of a height map: X3P, SDF, .npy of shape (rows, "
                             "x), or text with a row of "
                             "constant y in each line; with -o the prepared map as a file");
  map->add_option("FILE", request.file, "the map")->required()->check(path());
  const auto length = [&](const char* name, std::optional<double>& value, const char* words) {
    map->add_option(name, value, words)->type_name("M")->check(length_in_metres());
  };
  length("--spacing", request.query.spacing,
         "from point to point along x in metres, of a file that has no spacing");
  length("--spacing-y", request.query.spacing_y,
         "from row to row in metres, of such a file [as --spacing]");
  add_preparation(*map, request);
  length("--length", request.length, "along x of the map that comes out [the file's]");
  length("--width", request.width, "along y of the map that comes out [the file's]");
  map->add_option("--extend", request.extension,
                  "how a map goes on that is smaller than that: in copies that fade into one "
                  "another, or mirrored")
      ->check(CLI::IsMember({"repeat", "mirror"}));
  map->add_option("-o,--output", request.output,
                  "write the map, in metres: .npy, or text with any other ending")
      ->type_name("FILE")
      ->check(path());
  map->add_flag("--json", request.json, "print JSON, in SI units");
  map->callback([shared, &chosen] { chosen.run = [shared] { return describe_map(*shared); }; });
}

}  // namespace ra2d
