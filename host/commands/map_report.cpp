// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/map_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/errors.hpp"
#include "host/commands/print.hpp"
#include "host/surface/map_output.hpp"
#include "host/surface/map_roughness.hpp"
#include "host/system/input_file.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {

std::string length_text(double length) {
  const double size = std::abs(length);
  if (size >= 1) return fmt::format("{:.4g} m", length);
  if (size >= 0.9995e-3) return fmt::format("{:.4g} mm", length * 1e3);
  if (size >= 0.9995e-7 || size == 0) return fmt::format("{:.4g} um", length * 1e6);
  return fmt::format("{:.4g} nm", length * 1e9);
}

void print_map(const HeightMap& map, std::size_t missing) {
  const auto line = [](const char* what, const std::string& value) {
    print("  {:<20}{}\n", what, value);
  };
  const auto length = [](double value) {
    return std::isfinite(value) ? length_text(value) : std::string("not defined");
  };
  const auto number = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.4g}", value) : std::string("not defined");
  };
  const MapRoughness r = map_roughness(map);
  line("map", fmt::format("{} by {} points, {} and {} apart{}", map.nx, map.ny,
                          length_text(map.spacing), length_text(map.spacing_y),
                          missing > 0 ? fmt::format("; {} missing points filled", missing) : ""));
  line("size", fmt::format("{} along x, {} rows of {} along y",
                           length_text(static_cast<double>(map.nx - 1) * map.spacing), map.ny,
                           length_text(map.spacing_y)));
  line("Sq", length(r.sq));
  line("Sz", length(r.sz));
  line("Ssk", number(r.ssk));
  line("Sku", number(r.sku));
  line("RSm along x", length(r.rsm));
  line("RSm along y", length(r.rsm_y));
}

nlohmann::ordered_json map_json(const HeightMap& map, std::size_t missing) {
  const MapRoughness r = map_roughness(map);
  nlohmann::ordered_json json;
  json["nodes"] = {{"x", map.nx}, {"y", map.ny}};
  json["spacing"] = map.spacing;
  json["spacing_y"] = map.spacing_y;
  json["missing"] = missing;
  json["parameters"] = {{"Sq", r.sq},   {"Sz", r.sz},   {"Ssk", r.ssk},
                        {"Sku", r.sku}, {"RSm", r.rsm}, {"RSm_y", r.rsm_y}};
  return json;
}

void require_map_output(const std::filesystem::path& output, const std::string& command,
                        const std::vector<std::filesystem::path>& inputs) {
  require_derived_output(output, inputs);
  const std::string title = "# " + command;
  std::error_code none;
  if (!std::filesystem::exists(output, none) || std::filesystem::file_size(output, none) == 0)
    return;
  if (is_npy_name(output))
    throw RequestError(fmt::format(
        "'{}' is there already: an .npy does not say who made it, so it is left as it is. Name "
        "another file with -o, or remove it",
        output.string()));
  if (InputFile(output).beginning(title.size()) != title)
    throw RequestError(
        fmt::format("'{}' is there already, and '{}' has not made it: it is left as it is. Name "
                    "another file with -o, or remove it",
                    output.string(), command));
}

}  // namespace ra2d
