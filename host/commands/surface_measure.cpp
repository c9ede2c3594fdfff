// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/errors.hpp"
#include "host/surface/measure.hpp"
#include "host/text.hpp"

namespace ra2d {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// What the options say, word by word.
struct Request {
  std::vector<std::filesystem::path> files;
  std::optional<std::string> x_unit, z_unit, spacing, column, row, decimal, filter, cutoff,
      cutoff_s, sampling_lengths, fill, rsm, rmr;
  std::string form = "none";
  bool json = false;
};

[[noreturn]] void refuse_option(const char* option, const std::string& text, const char* expected) {
  throw RequestError(fmt::format("{}: '{}': expected {}", option, shortened(text), expected));
}

/// A number that no locale changes.
std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<double> to_length(const char* option, const std::optional<std::string>& text) {
  if (!text) return {};
  const auto value = number_of(*text);
  if (!value || *value <= 0) refuse_option(option, *text, "a length in metres, like 2.5e-3");
  return value;
}

std::optional<LengthUnit> to_axis_unit(const char* option, const std::optional<std::string>& text) {
  if (!text) return {};
  const auto unit = to_unit(*text);
  if (!unit) refuse_option(option, *text, "m, mm, um or nm");
  return unit;
}

std::optional<int> to_index(const char* option, const std::optional<std::string>& text,
                            const char* expected) {
  if (!text) return {};
  const auto index = number_of(*text);
  if (!index || *index < 1 || *index > 1e8 || *index != std::floor(*index))
    refuse_option(option, *text, expected);
  return static_cast<int>(*index);
}

/// One of two words, or what is meant without one.
bool is_first(const char* option, const std::optional<std::string>& text, const char* first,
              const char* second) {
  if (!text || *text == first) return true;
  if (*text == second) return false;
  refuse_option(option, *text, fmt::format("{} or {}", first, second).c_str());
}

ProfileQuery query_of(const Request& request) {
  ProfileQuery query;
  query.x_unit = to_axis_unit("--x-unit", request.x_unit);
  query.z_unit = to_axis_unit("--z-unit", request.z_unit);
  query.spacing = to_length("--spacing", request.spacing);
  query.column = to_index("--column", request.column, "a number of a column, from 1");
  query.row = to_index("--row", request.row, "a number of a row, from 1");
  if (request.decimal)
    query.decimal = is_first("--decimal", request.decimal, "point", "comma") ? DecimalMark::point
                                                                             : DecimalMark::comma;
  return query;
}

MeasureOptions options_of(const Request& request) {
  MeasureOptions options;
  options.form = to_form(request.form);
  options.filter = is_first("--filter", request.filter, "gaussian", "none");
  options.cutoff = to_length("--cutoff", request.cutoff);
  options.cutoff_s = to_length("--cutoff-s", request.cutoff_s);
  options.rule = is_first("--rsm", request.rsm, "iso21920", "iso4287") ? ElementRule::iso21920
                                                                       : ElementRule::iso4287;
  if (request.sampling_lengths) {
    const auto count = number_of(*request.sampling_lengths);
    const bool all = *request.sampling_lengths == "all";
    if (!all && (!count || *count < 1 || *count > 1e6 || *count != std::floor(*count)))
      refuse_option("--sampling-lengths", *request.sampling_lengths, "a number from 1, or all");
    options.sampling_lengths = all ? 0 : static_cast<std::size_t>(*count);
  }
  if (request.fill) {
    const std::string& text = *request.fill;
    const auto width = to_fill_width(text);
    if (!width)
      refuse_option("--fill", text, "linear:WIDTH, with a width in metres, like linear:1e-5");
    options.fill = *width;
  }
  if (request.rmr) {
    options.level = number_of(*request.rmr);
    if (!options.level)
      refuse_option("--rmr", *request.rmr, "a height in metres above the mean line, like -1e-6");
  }
  return options;
}

/// A length [m] for people.
std::string length_text(double length) {
  const double size = std::abs(length);
  if (size >= 1) return fmt::format("{:.4g} m", length);
  if (size >= 0.9995e-3) return fmt::format("{:.4g} mm", length * 1e3);
  if (size >= 0.9995e-7 || size == 0) return fmt::format("{:.4g} um", length * 1e6);
  return fmt::format("{:.4g} nm", length * 1e9);
}

enum class Kind { length, number, share };
struct Named {
  const char* name;
  double Roughness::*value;
  Kind kind;
};
constexpr Named parameters[] = {
    {"Ra", &Roughness::ra, Kind::length},   {"Rq", &Roughness::rq, Kind::length},
    {"Rz", &Roughness::rz, Kind::length},   {"Rt", &Roughness::rt, Kind::length},
    {"Rp", &Roughness::rp, Kind::length},   {"Rv", &Roughness::rv, Kind::length},
    {"Rsk", &Roughness::rsk, Kind::number}, {"Rku", &Roughness::rku, Kind::number},
    {"RSm", &Roughness::rsm, Kind::length}, {"Rdq", &Roughness::rdq, Kind::number},
    {"Rk", &Roughness::rk, Kind::length},   {"Rpk", &Roughness::rpk, Kind::length},
    {"Rvk", &Roughness::rvk, Kind::length}};

nlohmann::ordered_json to_json(const std::string& file, const Measurement& m,
                               const MeasureOptions& options) {
  nlohmann::ordered_json json;
  json["file"] = file;
  json["nodes"] = m.nodes;
  json["spacing"] = m.spacing;
  json["length"] = m.length;
  json["missing"] = m.missing;
  json["filter"] = options.filter ? "gaussian" : "none";
  json["cutoff"] = nullptr;
  if (m.cutoff) json["cutoff"] = *m.cutoff;
  json["sampling_lengths"] = m.sampling_lengths;
  for (const Named& p : parameters) json["parameters"][p.name] = m.parameters.*p.value;
  if (options.level) json["parameters"]["Rmr"] = m.material_ratio;
  return json;
}

void print_line(const char* what, const std::string& value) { print("  {:<11}{}\n", what, value); }

void print_value(std::string name, bool filtered, const std::string& value) {
  if (!filtered) name[0] = 'P';  // nothing was filtered off: those of the primary profile
  print("  {:<11}{}\n", name, value);
}

void print_table(const std::string& file, const Measurement& m, const MeasureOptions& options) {
  print("{}\n", printable(file));
  print_line(
      "profile",
      fmt::format("{} points, {} apart: {}{}", m.nodes, length_text(m.spacing),
                  length_text(m.length),
                  m.missing > 0 ? fmt::format("; {} missing points filled", m.missing) : ""));
  print_line("filter", options.filter
                           ? fmt::format("Gaussian, cut-off {}; half of it dropped at each end",
                                         length_text(*m.cutoff))
                           : std::string("none: parameters of the primary profile"));
  const bool one = m.sampling_lengths == 1;
  print_line("evaluated",
             fmt::format("{} sampling length{} of {}{}", m.sampling_lengths, one ? "" : "s",
                         length_text(m.sampling_length),
                         m.fitting > m.sampling_lengths
                             ? fmt::format("; {} would fit (--sampling-lengths all)", m.fitting)
                             : ""));
  for (const Named& p : parameters) {
    const double value = m.parameters.*p.value;
    print_value(p.name, options.filter,
                !std::isfinite(value)    ? "not defined"
                : p.kind == Kind::length ? length_text(value)
                                         : fmt::format("{:.4g}", value));
  }
  if (options.level)
    print_value(fmt::format("Rmr({})", length_text(*options.level)), options.filter,
                fmt::format("{:.4g} %", 100 * m.material_ratio));
}

int measure_files(const Request& request) {
  const ProfileQuery query = query_of(request);
  const MeasureOptions options = options_of(request);
  std::vector<std::pair<std::string, Measurement>> measured;
  for (const auto& file : request.files)
    measured.emplace_back(
        file.string(), measure_profile(read_measured_profile(file, query), options, file.string()));
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& [file, m] : measured) {
    say_doubts(m.doubts, false);
    if (request.json)
      list.push_back(to_json(file, m, options));
    else
      print_table(file, m, options);
  }
  if (request.json) {
    using Handler = nlohmann::ordered_json::error_handler_t;  // of names that are no UTF-8
    const auto& json = list.size() == 1 ? list[0] : list;
    print_text(json.dump(2, ' ', false, Handler::replace) + '\n');
  }
  return done;
}

}  // namespace

void add_surface_measure(CLI::App& surface, Chosen& chosen) {
  const auto asked = std::make_shared<Request>();
  Request& request = *asked;
  CLI::App* measure = surface.add_subcommand("measure",
                                             "roughness parameters (ISO 21920-2) of measured "
                                             "profiles: text of two columns, x and z, SDF or X3P");
  const auto add = [&](const char* name, std::optional<std::string>& value, const char* type,
                       const char* what) {
    measure->add_option(name, value, what)->type_name(type);
  };
  measure->add_option("FILE", request.files, "profiles")->required()->check(path());
  add("--x-unit", request.x_unit, "UNIT", "of x: m, mm, um or nm [the file's own, or m]");
  add("--z-unit", request.z_unit, "UNIT", "of the heights [the file's own, or m]");
  add("--spacing", request.spacing, "M", "step in metres, of a file that has no x");
  add("--column", request.column, "N",
      "the column of heights, from 1 [the second, after x]; of an areal file a profile along y");
  add("--row", request.row, "N", "the row of an areal file, from 1: a profile along x");
  add("--decimal", request.decimal, "MARK",
      "point or comma, where the file leaves it open [what the file tells]");
  measure
      ->add_option("--form", request.form,
                   "form to be taken off first: none, mean, line or poly:N, by least squares")
      ->type_name("FORM")
      ->capture_default_str();
  add("--filter", request.filter, "KIND",
      "gaussian, which gives the roughness profile, or none, for the primary profile [gaussian]");
  add("--cutoff", request.cutoff, "M",
      "cut-off, and sampling length, in metres [2.5e-3; one length with --filter none]");
  add("--cutoff-s", request.cutoff_s, "M",
      "cut-off of the Gaussian filter against short waves, in metres [no such filter]");
  add("--sampling-lengths", request.sampling_lengths, "N",
      "how many sampling lengths are evaluated, or all [5, or as many as fit]");
  add("--fill", request.fill, "linear:M",
      "straight lines through missing points, over gaps up to M metres [they are refused]");
  add("--rsm", request.rsm, "RULE",
      "what counts as a profile element: iso21920 or iso4287 [iso21920]");
  add("--rmr", request.rmr, "M", "material ratio at a height in metres above the mean line, too");
  measure->add_flag("--json", request.json, "print JSON, in SI units");
  measure->callback([asked, &chosen] { chosen = [asked] { return measure_files(*asked); }; });
}

}  // namespace ra2d
