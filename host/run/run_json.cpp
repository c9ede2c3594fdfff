// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/run_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "host/analysis/analysis.hpp"
#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/run/run_warnings.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/result_reader.hpp"

namespace ra2d {
namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite

Json limits_json(const Interval& interval) {
  return {{"low", interval.low}, {"high", interval.high}};
}

Json shocks_json(const RunReport& r) {
  return {{"rate", r.shock_rate},
          {"rate_interval", limits_json(r.intervals.shock_rate)},
          {"duration", {{"median", r.shock_duration_median}, {"p90", r.shock_duration_90}}},
          {"peak_force", {{"median", r.peak_force_median}, {"p90", r.peak_force_90}}}};
}

Json energy_json(const EnergyBalance& energy) {
  const bool is_defined = energy.samples >= 2;
  return {{"closure", energy.closure()},
          {"residual", is_defined ? energy.residual : quiet_nan},
          {"turnover", is_defined ? energy.turnover : quiet_nan}};
}

Json mesh_json(const MeshTone& mesh) {
  return {{"frequency", mesh.frequency},
          {"in_spectrum", mesh.in_spectrum},
          {"rise", mesh.rise},
          {"rise_by_chance", mesh.by_chance},
          {"stands_out", mesh.stands_out()}};
}

/// All that the run warns of, each once: doubts of two faces may be the same.
std::vector<std::string> all_warnings(const RunReport& r, const SceneSound& sound) {
  std::vector<std::string> all = r.doubts;
  for (std::string& warning : warnings_of(r, sound)) all.push_back(std::move(warning));
  std::vector<std::string> once;
  for (std::string& warning : all)
    if (std::find(once.begin(), once.end(), warning) == once.end())
      once.push_back(std::move(warning));
  return once;
}

}  // namespace

std::string run_json(const Scene& scene, const RunReport& r, const std::filesystem::path& output,
                     int exit_status, const std::vector<std::filesystem::path>& zooms,
                     const SceneSound& sound) {
  std::vector<std::string> zoom_files;
  for (const std::filesystem::path& zoom : zooms) zoom_files.push_back(zoom.string());
  const bool is_there = r.ending == Ending::there;
  const bool has_level = is_there || r.counted > 0;
  Json json{{"file", output.string()},
            {"zooms", zoom_files},
            {"title", title(scene)},
            {"complete", is_there || r.ending == Ending::complete},
            {"ended", r.ending == Ending::failed ? r.failure : ending_name(r.ending)},
            {"was_there", is_there},
            {"resumable", r.resumable},
            {"exit_status", exit_status},
            {"from", scene.output.from},
            {"to", r.time},
            {"duration", scene.duration},
            {"steps", r.steps},
            {"lv", has_level ? r.lv : quiet_nan},
            {"lv_interval", limits_json(r.intervals.level)},
            {"no_interval", r.intervals.why_none},
            {"v_rms", has_level ? r.v_rms : quiet_nan},
            {"contact_share", r.contact_share},
            {"shocks", shocks_json(r)},
            {"nodes_evaluated", r.nodes_evaluated},
            {"energy", energy_json(r.energy)},
            {"mesh_tone", mesh_json(r.mesh)},
            {"beyond_limit", r.beyond_limit.empty() ? Json() : Json(r.beyond_limit)},
            {"warnings", all_warnings(r, sound)},
            {"wall_seconds", r.wall_seconds},
            {"march_seconds", r.march_seconds},
            {"read_back_seconds", r.read_back_seconds},
            {"step_seconds", r.step_seconds()},
            {"memory_bytes", r.memory > 0 ? Json(r.memory) : Json()}};
  if (!scene.output.microphones.empty()) {
    json["microphones"] = Json::array();
    for (const MicrophoneLevels& m : sound.microphones)
      json["microphones"].push_back(
          {{"position", m.position},
           {"lp", m.lp},
           {"lpa", m.lp_a},
           {"no_lpa", std::isnan(m.lp_a) ? too_short_text(m.shortest) : ""},
           {"share_above_last_mode", m.above.a_weighted},
           {"unweighted_share_above_last_mode", m.above.all},
           {"warning", warning_of(m)},
           {"lp_interval", limits_json(m.intervals.level)}});
    json["no_sound"] = sound.why_none;
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

RunReport report_of_file(const Scene& scene, const std::filesystem::path& file) {
  const ResultReader reader(file);
  const ResultContents& contents = reader.contents();
  const ResultSummary& summary = contents.summary;
  RunReport report;
  static_cast<NoiseFigures&>(report) = static_cast<const NoiseFigures&>(summary);
  report.ending = Ending::there;
  report.beyond_limit = contents.beyond_limit;
  report.time = contents.end;
  report.steps = summary.steps;
  report.mesh.frequency = report.mesh.rise = report.mesh.by_chance = quiet_nan;
  report.intervals.level = report.intervals.shock_rate = {quiet_nan, quiet_nan};
  try {
    const Analysis analysis = analyze(file, {});
    report.intervals = analysis.intervals;
    report.mesh = analysis.mesh;
  } catch (const RequestError& too_short) {
    report.intervals.why_none = too_short.what();
  }
  report.energy.residual = summary.energy_residual;
  report.energy.turnover = summary.energy_turnover;
  report.energy.samples = std::isfinite(summary.energy_turnover) ? 2 : 0;
  std::istringstream lines(summary.warnings);
  for (std::string line; std::getline(lines, line);) report.warnings.push_back(line);
  if (report.warnings.empty()) report.warnings = warnings_of_figures(scene, report);  // older files
  report.march_seconds = summary.step_seconds * static_cast<double>(summary.steps);
  report.wall_seconds = summary.wall_seconds;
  report.read_back_seconds = quiet_nan;
  return report;
}

}  // namespace ra2d
