// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/analysis/analysis_text.hpp"
#include "host/analysis/bands.hpp"
#include "host/analysis/means.hpp"

namespace ra2d {
namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite

Json spread_json(const Spread& s) {
  return {{"median", s.median}, {"p10", s.p10}, {"p90", s.p90}, {"mean", s.mean}};
}

/// Of one run, by chance within it.
Json interval_json(const Interval& interval) {
  return {{"low", interval.low}, {"high", interval.high}};
}

Json bins_json(const LogBins& bins) {
  return {{"edges", bins.edges}, {"counts", bins.counts}, {"not_positive", bins.not_positive}};
}

Json shocks_json(const ShockStatistics& s, const Interval& rate) {
  return {{"rate", s.rate},
          {"rate_interval", interval_json(rate)},
          {"duration", spread_json(s.duration)},
          {"peak_force", spread_json(s.peak_force)},
          {"impulse", spread_json(s.impulse)},
          {"simultaneous", {{"mean", s.at_once_mean}, {"max", s.at_once_most}}},
          {"count", s.count},
          {"interval", spread_json(s.interval)},
          {"histograms",
           {{"duration", bins_json(s.durations)},
            {"peak_force", bins_json(s.peak_forces)},
            {"impulse", bins_json(s.impulses)},
            {"interval", bins_json(s.intervals)}}}};
}

Json energy_json(const Analysis& a) {
  const PowerBalance& e = a.energy;
  return {
      {"sliding_power", e.sliding}, {"load_power", e.load},           {"damping_power", e.damping},
      {"storing_power", e.storing}, {"missing_power", e.missing},     {"kinetic", e.kinetic},
      {"elastic", e.elastic},       {"contact", e.contact},           {"closure", a.energy_closure},
      {"contact_power", e.given},   {"per_shock", a.energy_per_shock}};
}

Json spectrum_json(const VelocitySpectrum& s) {
  return {
      {"frequency", s.frequency},
      {"psd_mean", s.mean},
      {"psd_probe", s.probe},
      {"psd_slider_probe", s.slider_probe},
      {"psd_force", s.force},
      {"resolution", s.resolution},
      {"segments", s.segments},
      {"degrees_of_freedom", s.degrees_of_freedom},
      {"confidence",
       {{"level", s.confidence.level}, {"low", s.confidence.low}, {"high", s.confidence.high}}}};
}

Json bands_json(const Analysis& a) {
  const BandLevels& bands = a.bands;
  std::vector<double> centre;
  std::vector<std::string> nominal;
  for (const int number : bands.number) {
    centre.push_back(third_octave_centre(number));
    nominal.push_back(third_octave_name(number));
  }
  Json json{{"centre", centre},
            {"level", bands.level},
            {"nominal", nominal},
            {"spread", bands.spread},
            {"level_probe", bands.level_probe},
            {"above_last_mode", bands_above_modes(a, a.bands.number)},
            {"last_mode", last_mode(a.natural_frequencies)}};
  if (!bands.level_a.empty()) json["level_a"] = bands.level_a;
  return json;
}

Json peaks_json(const std::vector<SpectralPeak>& peaks) {
  Json list = Json::array();
  for (const SpectralPeak& p : peaks)
    list.push_back({{"mode", p.mode},
                    {"natural_frequency", p.natural},
                    {"frequency", p.frequency},
                    {"psd", p.density},
                    {"resonance", p.half_power.frequency},
                    {"damping", p.half_power.damping},
                    {"damping_error", p.half_power.error},
                    {"no_damping", word_of(p.half_power.why)},
                    {"of_mesh", p.of_mesh}});
  return list;
}

Json octaves_json(const Analysis& a, const std::vector<int>& numbers,
                  const std::vector<double>& levels, const std::vector<double>& weighted,
                  const std::vector<double>& spread) {
  std::vector<double> centre;
  std::vector<std::string> nominal;
  for (const int number : numbers) {
    centre.push_back(third_octave_centre(number));
    nominal.push_back(third_octave_name(number));
  }
  return {{"centre", centre},   {"level", levels},
          {"nominal", nominal}, {"level_a", weighted},
          {"spread", spread},   {"above_last_mode", bands_above_modes(a, numbers)}};
}

Json microphones_json(const Analysis& a) {
  Json list = Json::array();
  for (const MicrophoneLevels& m : a.microphones)
    list.push_back({{"position", m.position},
                    {"lp", m.lp},
                    {"lpa", m.lp_a},
                    {"no_lpa", std::isnan(m.lp_a) ? too_short_text(m.shortest) : ""},
                    {"share_above_last_mode", m.above.a_weighted},
                    {"unweighted_share_above_last_mode", m.above.all},
                    {"warning", warning_of(m)},
                    {"lp_interval", interval_json(m.intervals.level)},
                    {"no_interval", m.intervals.why_none},
                    {"p_rms", m.rms},
                    {"p_peak", m.peak},
                    {"from", m.from},
                    {"to", m.to},
                    {"distance", m.distance},
                    {"arrives", m.arrives},
                    {"bands", octaves_json(a, m.number, m.level, m.level_a, m.spread)},
                    {"history",
                     {{"from", m.history.from},
                      {"part_seconds", m.history.part_seconds},
                      {"mean_square", m.history.mean_square}}}});
  return list;
}

Json power_json(const Analysis& a) {
  const RadiatedPower& p = *a.power;
  Json bands = octaves_json(a, p.number, p.level, p.level_a, p.spread);
  bands["efficiency"] = p.band_efficiency;
  return {{"lw", p.lw},
          {"lwa", p.lw_a},
          {"no_lw", std::isnan(p.lw) ? too_short_text(p.shortest) : ""},
          {"share_above_last_mode", p.above.a_weighted},
          {"unweighted_share_above_last_mode", p.above.all},
          {"watts", p.watts},
          {"efficiency", p.efficiency},
          {"bands", bands},
          {"modes",
           {{"frequency", p.mode_frequency},
            {"efficiency", p.mode_efficiency},
            {"damping_of_air", p.mode_damping}}},
          {"damping_power", p.damping_power},
          {"share_of_damping", p.share_of_damping},
          {"air_matters", p.air_matters()},
          {"inertia_of_air", p.inertia}};
}

/// Places as the scene has them: x, or in an areal scene [x, y].
Json places_json(const std::vector<double>& x, const std::vector<double>& y) {
  if (y.empty()) return x;
  Json list = Json::array();
  for (std::size_t i = 0; i < x.size(); ++i) list.push_back({x[i], y[i]});
  return list;
}

Json analysis_json(const Analysis& a) {
  Json json{{"file", a.file.string()},
            {"title", a.title},
            {"complete", a.complete},
            {"ended", a.ended},
            {"from", a.from},
            {"to", a.to},
            {"samples", a.samples},
            {"rate", a.rate},
            {"lv", a.lv},
            {"lv_interval", interval_json(a.intervals.level)},
            {"no_interval", a.intervals.why_none},
            {"v_rms", a.v_rms},
            {"contact_share", a.contact_share},
            {"shocks", shocks_json(a.shocks, a.intervals.shock_rate)},
            {"energy", energy_json(a)},
            {"spectrum", spectrum_json(a.spectrum)},
            {"bands", bands_json(a)},
            {"natural_frequencies", a.natural_frequencies},
            {"aliased_modes", a.aliased_modes},
            {"modal_damping", a.modal_damping},
            {"peaks", peaks_json(a.peaks)},
            {"mesh_tone",
             {{"frequency", a.mesh.frequency},
              {"in_spectrum", a.mesh.in_spectrum},
              {"rise", a.mesh.rise},
              {"rise_by_chance", a.mesh.by_chance},
              {"stands_out", a.mesh.stands_out()}}},
            {"probes", places_json(a.probe_position, a.probe_y)},
            {"slider_probes", places_json(a.slider_probe_position, a.slider_probe_y)}};
  if (!a.bands.level_a.empty()) json["lv_a"] = a.lv_a;
  if (!a.microphones.empty()) json["microphones"] = microphones_json(a);
  if (a.power) json["power"] = power_json(a);
  if (!a.microphones.empty() || a.power)
    json["air"] = {{"sound_speed", a.air.sound_speed}, {"density", a.air.density}};
  return json;
}

Json means_json(const std::vector<Analysis>& analyses) {
  Json json = Json::object();
  for (const FigureOfRuns& figure : means_of(analyses))
    json[figure.name] = {{"mean", figure.value.mean},         {"deviation", figure.value.deviation},
                         {"low", figure.value.low},           {"high", figure.value.high},
                         {"confidence", confidence_of_means}, {"count", figure.value.count}};
  return json;
}

}  // namespace

std::string json_of(const std::vector<Analysis>& analyses) {
  Json json;
  if (analyses.size() == 1) {
    json = analysis_json(analyses.front());
  } else {
    json = {{"files", Json::array()},
            {"mean", means_json(analyses)},
            {"doubts", doubts_of_means(analyses)}};
    for (const Analysis& analysis : analyses) json["files"].push_back(analysis_json(analysis));
  }
  // paths may be of any bytes
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace ra2d
