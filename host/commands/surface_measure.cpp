// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/map_report.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/profile_options.hpp"
#include "host/surface/measure.hpp"

namespace ra2d {
namespace {

struct MeasureRequest {
  std::vector<std::filesystem::path> files;
  ProfileOptions profile;
  bool json = false;
};

enum class Kind { length, number, share };  // shares are printed in percent
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
    {"Rvk", &Roughness::rvk, Kind::length}, {"Mr1", &Roughness::mr1, Kind::share},
    {"Mr2", &Roughness::mr2, Kind::share}};

nlohmann::ordered_json to_json(const std::string& file, const Measurement& m,
                               const MeasureOptions& options) {
  nlohmann::ordered_json json;
  json["file"] = file;
  json["nodes"] = m.nodes;
  json["spacing"] = m.spacing;
  json["length"] = m.length;
  json["missing"] = m.missing;
  json["filter"] = options.filter == ProfileFilter::gaussian ? "gaussian"
                   : options.filter == ProfileFilter::done   ? "done"
                                                             : "none";
  json["cutoff"] = nullptr;
  if (m.cutoff) json["cutoff"] = *m.cutoff;
  json["sampling_lengths"] = m.sampling_lengths;
  for (const Named& p : parameters) json["parameters"][p.name] = m.parameters.*p.value;
  if (options.level) json["parameters"]["Rmr"] = m.material_ratio;
  json["standard"] = options.standard == RoughnessStandard::iso4287 ? "iso4287" : "iso21920";
  return json;
}

void print_line(const char* what, const std::string& value) { print("  {:<11}{}\n", what, value); }

void print_value(std::string name, bool filtered, const std::string& value) {
  // nothing was filtered off: those of the primary profile
  if (!filtered && name[0] == 'R') name[0] = 'P';
  print("  {:<11}{}\n", name, value);
}

std::string filter_text(const Measurement& m, ProfileFilter filter) {
  switch (filter) {
    case ProfileFilter::gaussian:
      return fmt::format("Gaussian, cut-off {}; half of it dropped at each end",
                         length_text(*m.cutoff));
    case ProfileFilter::done:
      return fmt::format("done before, cut-off {}: nothing is filtered or dropped",
                         length_text(*m.cutoff));
    case ProfileFilter::none:
      break;
  }
  return "none: parameters of the primary profile";
}

void print_table(const std::string& file, const Measurement& m, const MeasureOptions& options) {
  print("{}\n", printable(file));
  print_line(
      "profile",
      fmt::format("{} points, {} apart: {}{}", m.nodes, length_text(m.spacing),
                  length_text(m.length),
                  m.missing > 0 ? fmt::format("; {} missing points filled", m.missing) : ""));
  print_line("filter", filter_text(m, options.filter));
  const bool one = m.sampling_lengths == 1;
  print_line("evaluated",
             fmt::format("{} sampling length{} of {}{}", m.sampling_lengths, one ? "" : "s",
                         length_text(m.sampling_length),
                         m.fitting > m.sampling_lengths
                             ? fmt::format("; {} would fit (--sampling-lengths all)", m.fitting)
                             : ""));
  print_line("standard", name_of(options.standard));
  const bool filtered = options.filter != ProfileFilter::none;
  for (const Named& p : parameters) {
    const double value = m.parameters.*p.value;
    print_value(p.name, filtered,
                !std::isfinite(value)    ? "not defined"
                : p.kind == Kind::length ? length_text(value)
                : p.kind == Kind::share  ? fmt::format("{:.4g} %", 100 * value)
                                         : fmt::format("{:.4g}", value));
  }
  if (options.level)
    print_value(fmt::format("Rmr({})", length_text(*options.level)), filtered,
                fmt::format("{:.4g} %", 100 * m.material_ratio));
}

int measure_files(const MeasureRequest& request) {
  const ProfileQuery& query = request.profile.query;
  const MeasureOptions& options = request.profile.measure;
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
  return exit_status::done;
}

}  // namespace

void add_surface_measure(CLI::App& surface, ChosenCommand& chosen) {
  const auto shared = std::make_shared<MeasureRequest>();
  MeasureRequest& request = *shared;
  CLI::App* measure =
      surface.add_subcommand("measure",
                             "roughness parameters (ISO 21920-2 or 4287) of measured "
                             "profiles: text of two columns, x and z, SDF or X3P");
  measure->add_option("FILE", request.files, "profiles")->required()->check(path());
  add_profile_options(*measure, request.profile);
  measure
      ->add_option("--rmr", request.profile.measure.level, "also the material ratio at this height")
      ->type_name("M")
      ->check(number_from(std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max(),
                          "a height in metres above the mean line, like -1e-6"));
  measure->add_flag("--json", request.json, "print JSON, in SI units");
  measure->callback(
      [shared, &chosen] { chosen.run = [shared] { return measure_files(*shared); }; });
}

}  // namespace ra2d
