// SPDX-License-Identifier: BSD-3-Clause
#include "host/plot/result_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/analysis/analysis.hpp"
#include "host/analysis/bands.hpp"
#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/base/text.hpp"
#include "host/plot/envelope.hpp"
#include "host/result/level.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/result_reader.hpp"

namespace ra2d {
namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite

constexpr std::size_t most_series_points =
    1200;  // of a series: about as many as a picture has dots across
constexpr std::size_t close_samples = 600;  // of a close-up
constexpr std::size_t most_lines = 6;       // of probes
constexpr const char* no_probes = "the scene has no probes (output.probes, output.slider_probes)";
constexpr std::size_t most_dots = 2000;    // of shocks
constexpr std::size_t most_windows = 100;  // of the level in time
constexpr std::size_t most_frames = 200;   // of a spectrogram
constexpr std::size_t place_bins = 120;    // of the places of shocks

constexpr const char* no_spectrum = "the run is too short for a spectrum: fewer than 16 samples";

/// Why a panel has nothing to show.
Json nothing(const std::string& why) { return {{"empty", why}}; }

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -low;
};

/// One result, open, with what its panels are made of.
class ResultPanels {
 public:
  explicit ResultPanels(const std::filesystem::path& file)
      : reader_{file}, contents_{reader_.contents()}, analysis_{analyze(file, {})} {
    try {
      scene_ = parse_scene(contents_.scene, file);
    } catch (const RequestError&) {  // of another version: the facts of the scene are left out
    }
  }

  const Analysis& analysis() const { return analysis_; }

  Json panel(const std::string& name) const {
    if (name == "profiles") return profiles();
    if (name == "shocks") return shocks();
    if (contents_.samples < 2)
      return nothing("fewer than two samples: the run ended before, or output.rate is too low");
    if (name == "force") return force();
    if (name == "displacement") return displacement();
    if (name == "spectrum") return spectrum();
    if (name == "probe-spectra") return probe_spectra();
    if (name == "level") return level_in_time();
    if (name == "energy") return energy();
    if (name == "bands") return bands();
    return spectrogram();
  }

  Json head() const {
    Json json{{"title", printable(shortened(analysis_.title))},
              {"file", printable(shortened(analysis_.file.filename().string()))},
              {"complete", analysis_.complete},
              {"ended", printable(shortened(analysis_.ended, 120))},
              {"end", contents_.end},
              {"from", analysis_.from},
              {"beyond_limit", !contents_.beyond_limit.empty()},
              {"lv", analysis_.lv},
              {"at_rest", analysis_.v_rms == 0},
              {"v_rms", analysis_.v_rms},
              {"shock_rate", analysis_.shocks.rate},
              {"contact_share", analysis_.contact_share},
              {"energy_closure", analysis_.energy_closure}};
    return json;
  }

 private:
  // ---- faces ------------------------------------------------------------------------------------

  struct Face {
    std::vector<double> at, height;
  };

  Face face(const char* position, const char* height) const {
    const std::size_t nodes = reader_.rows(height);
    return {reader_.column(position, 0, nodes), reader_.column(height, 0, nodes)};
  }

  static Json drawn(const Face& face) {
    return envelope(face.at, face.height, even_groups(face.at.size(), most_series_points));
  }

  static Face part_of(const Face& face, const Extent& range) {
    Face part;
    for (std::size_t i = 0; i < face.at.size(); ++i)
      if (face.at[i] >= range.low && face.at[i] <= range.high) {
        part.at.push_back(face.at[i]);
        part.height.push_back(face.height[i]);
      }
    return part;
  }

  /// The distance of the mean lines at t = 0: the scene's gap, or that at which the first nodes
  /// touch.
  double gap_of(const Face& resonator, const Face& slider) const {
    if (scene_->gap) return *scene_->gap;
    double gap = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < slider.at.size(); ++i) {
      const double node = std::round((scene_->start + slider.at[i]) / scene_->spacing);
      if (node < 0 || node >= static_cast<double>(resonator.at.size())) continue;
      gap = std::max(gap, slider.height[i] + resonator.height[static_cast<std::size_t>(node)]);
    }
    return std::isfinite(gap) ? gap : 0;
  }

  /// The places that the slider passes, and some more on either side.
  Extent track_of(const Face& resonator, const Face& slider) const {
    const double length = slider.at.empty() ? 0 : slider.at.back();
    const double end = std::isfinite(contents_.end) ? contents_.end : 0;
    Extent track{scene_->start, scene_->start + length + scene_->speed * end};
    const double more = 0.04 * (track.high - track.low);
    return {std::max(resonator.at.front(), track.low - more),
            std::min(resonator.at.back(), track.high + more)};
  }

  Json profiles() const {
    const Face resonator = face("surface/resonator/position", "surface/resonator/height");
    Face slider = face("surface/slider/position", "surface/slider/height");
    if (resonator.at.size() < 2) return nothing("the file holds no profiles");
    Extent range{resonator.at.front(), resonator.at.back()};
    Json json;
    if (scene_) {
      const double gap = gap_of(resonator, slider);
      range = track_of(resonator, slider);
      for (std::size_t i = 0; i < slider.at.size(); ++i) {  // upside down, where it starts
        slider.at[i] += scene_->start;
        slider.height[i] = gap - slider.height[i];
      }
      json["slider"] = drawn(slider);
      json["gap"] = gap;
    }
    json["resonator"] = drawn(part_of(resonator, range));
    json["range"] = {range.low, range.high};
    add_places(range, json);
    return json;
  }

  /// How many shocks there are at each place, and the strongest of them one by one.
  void add_places(const Extent& range, Json& json) const {
    std::vector<Shock> shocks = contents_.shocks;
    json["shocks"] = shocks.size();
    if (shocks.empty()) return;
    std::vector<double> edges;
    for (std::size_t i = 0; i <= place_bins; ++i)
      edges.push_back(range.low + (range.high - range.low) * static_cast<double>(i) / place_bins);
    std::vector<std::size_t> counts(place_bins);
    for (const Shock& shock : shocks) {
      const double bin = (shock.position - range.low) / (range.high - range.low) * place_bins;
      ++counts[static_cast<std::size_t>(std::clamp(bin, 0.0, place_bins - 1.0))];
    }
    const std::size_t dots = std::min(most_dots, shocks.size());
    std::partial_sort(shocks.begin(), shocks.begin() + static_cast<std::ptrdiff_t>(dots),
                      shocks.end(),
                      [](const Shock& a, const Shock& b) { return a.peak_force > b.peak_force; });
    shocks.resize(dots);
    std::vector<double> at, time, force;
    for (const Shock& shock : shocks) {
      at.push_back(shock.position);
      time.push_back(shock.start);
      force.push_back(shock.peak_force);
    }
    json["places"] = {{"edges", edges}, {"counts", counts}};
    json["strongest"] = {{"x", at}, {"time", time}, {"force", force}};
  }

  // ---- in time ----------------------------------------------------------------------------------

  std::vector<double> column(const char* dataset) const {
    return reader_.column(dataset, 0, contents_.samples);
  }

  std::vector<double> times() const { return column("time"); }

  Json whole(const std::vector<double>& values) const {
    return envelope(times(), values, even_groups(values.size(), most_series_points));
  }

  /// Samples around one of them, each by itself.
  Json close_up(const std::vector<double>& values, std::size_t middle) const {
    const std::size_t count = std::min(close_samples, values.size());
    const std::size_t first = std::min(middle - std::min(middle, count / 2), values.size() - count);
    const std::vector<double> at = reader_.column("time", first, count);
    return envelope(at, std::span(values).subspan(first, count), even_groups(count, count));
  }

  static std::size_t largest_of(const std::vector<double>& values) {
    return static_cast<std::size_t>(std::max_element(values.begin(), values.end()) -
                                    values.begin());
  }

  Json force() const {
    const std::vector<double> values = column("contact/force");
    const std::size_t largest = largest_of(values);
    if (values[largest] == 0)
      return nothing(contents_.shocks.empty()
                         ? "the bodies never touched: no contact force"
                         : "no sample fell into a contact: the shocks are shorter than the time "
                           "from sample to sample");
    return {{"series", whole(values)}, {"close", close_up(values, largest)}};
  }

  static std::string probe_label(const char* body, double position) {
    return fmt::format("{} at {:.6g} mm", body, 1e3 * position);
  }

  void add_probes(const char* position, const char* displacement, const char* body,
                  std::size_t middle, Json& json) const {
    const std::size_t probes = reader_.rows(position);
    const std::vector<double> at = reader_.column(position, 0, probes);
    for (std::size_t p = 0; p < probes; ++p) {
      if (json["lines"].size() == most_lines) {
        json["left_out"] = json["left_out"].get<std::size_t>() + 1;
        continue;
      }
      const std::vector<double> values =
          std::move(reader_.columns(displacement, 0, contents_.samples, p, 1).front());
      if (std::any_of(values.begin(), values.end(), [](double u) { return u != 0; }))
        json["moved"] = true;
      json["lines"].push_back({{"label", probe_label(body, at[p])},
                               {"series", whole(values)},
                               {"close", close_up(values, middle)}});
    }
  }

  Json displacement() const {
    Json json{{"lines", Json::array()}, {"left_out", std::size_t{0}}, {"moved", false}};
    const std::size_t middle = largest_of(column("contact/force"));
    add_probes("probes/position", "probes/displacement", "resonator", middle, json);
    add_probes("slider_probes/position", "slider_probes/displacement", "slider", middle, json);
    if (json["lines"].empty()) return nothing(no_probes);
    if (!json["moved"]) return nothing("no probe moved");
    return json;
  }

  /// Samples of the resonator's elastic velocity, mode by mode: calls body(weight, samples).
  template <class Body>
  void each_mode(std::size_t first, std::size_t rows, Body body) const {
    const std::vector<double>& weights = contents_.mean_square;
    const auto modes = reader_.columns("resonator/velocity", first, rows, 0, weights.size());
    for (std::size_t k = 0; k < weights.size(); ++k)
      if (weights[k] > 0) body(weights[k], modes[k]);
  }

  bool bends() const {
    return std::any_of(contents_.mean_square.begin(), contents_.mean_square.end(),
                       [](double weight) { return weight > 0; });
  }

  /// Why there is no noise to show; empty where there is.
  std::string why_silent() const {
    if (!bends()) return "the resonator has no elastic modes: it makes no noise";
    if (analysis_.v_rms == 0) return "the resonator is at rest: it did not vibrate";
    return {};
  }

  Json level_in_time() const {
    if (const std::string why = why_silent(); !why.empty()) return nothing(why);
    const std::size_t windows = std::min(most_windows, contents_.samples / 2);
    std::vector<double> at, levels;
    const std::vector<std::size_t> begins = even_groups(contents_.samples, windows);
    // of few samples groups are single ones: two at least make a mean
    const std::size_t step = begins.size() > windows + 1 ? 2 : 1;
    for (std::size_t i = 0; i + step < begins.size(); i += step) {
      const std::size_t first = begins[i], rows = begins[i + step] - first;
      double square = 0;
      each_mode(first, rows, [&](double weight, const std::vector<double>& velocity) {
        for (const double v : velocity) square += weight * v * v / static_cast<double>(rows);
      });
      at.push_back((static_cast<double>(first) + 0.5 * static_cast<double>(rows)) / contents_.rate);
      levels.push_back(level(std::sqrt(square)));
    }
    const double window = static_cast<double>(contents_.samples) /
                          static_cast<double>(std::max<std::size_t>(at.size(), 1)) / contents_.rate;
    return {{"x", at},
            {"level", levels},
            {"window", window},
            {"lv", analysis_.lv},
            {"from", analysis_.from},
            {"to", analysis_.to}};
  }

  Json energy() const {
    const std::vector<double> kinetic = column("energy/kinetic"),
                              elastic = column("energy/elastic"),
                              contact = column("energy/contact"),
                              damping = column("energy/damping_loss"),
                              sliding = column("energy/sliding_work"),
                              load = column("energy/load_work");
    std::vector<double> stored(kinetic.size()), missing(kinetic.size());
    double most = 0;
    for (std::size_t j = 0; j < stored.size(); ++j) {
      stored[j] = kinetic[j] + elastic[j] + contact[j] - (kinetic[0] + elastic[0] + contact[0]);
      missing[j] =
          stored[j] + (damping[j] - damping[0]) - (sliding[j] - sliding[0]) - (load[j] - load[0]);
      for (const double value :
           {kinetic[j], elastic[j], contact[j], damping[j], sliding[j], load[j]})
        most = std::max(most, std::abs(value));
    }
    if (most == 0) return nothing("no energy went through: nothing moved and nothing touched");
    return {{"sliding", whole(sliding)}, {"load", whole(load)},       {"damping", whole(damping)},
            {"stored", whole(stored)},   {"missing", whole(missing)}, {"kinetic", whole(kinetic)},
            {"elastic", whole(elastic)}, {"contact", whole(contact)}};
  }

  // ---- shocks and frequencies
  // --------------------------------------------------------------------

  static Json bins(const LogBins& bins, const Spread& spread) {
    return {{"edges", bins.edges},
            {"counts", bins.counts},
            {"median", spread.median},
            {"p90", spread.p90}};
  }

  Json shocks() const {
    const ShockStatistics& s = analysis_.shocks;
    if (s.count == 0)
      return nothing(contents_.shocks.empty() ? "there were no shocks: nothing touched"
                                              : "no shock began at or after output.from");
    return {{"count", s.count},
            {"from", analysis_.from},
            {"duration", bins(s.durations, s.duration)},
            {"peak_force", bins(s.peak_forces, s.peak_force)},
            {"impulse", bins(s.impulses, s.impulse)},
            {"interval", bins(s.intervals, s.interval)}};
  }

  static bool is_zero(const std::vector<double>& density) {
    return std::all_of(density.begin(), density.end(), [](double d) { return d == 0; });
  }

  /// The texts of all spectra.
  Json spectrum_facts(Json json) const {
    const VelocitySpectrum& s = analysis_.spectrum;
    std::vector<double> natural;
    for (const double f : analysis_.natural_frequencies)
      if (f < analysis_.rate / 2) natural.push_back(f);
    json["resolution"] = s.resolution;
    json["segments"] = s.segments;
    json["low"] = s.confidence.low;
    json["high"] = s.confidence.high;
    json["natural"] = natural;
    json["aliased"] = analysis_.aliased_modes;
    json["mesh"] = analysis_.mesh.in_spectrum ? analysis_.mesh.frequency : quiet_nan;
    return json;
  }

  Json drawn_density(const std::vector<double>& density) const {
    const std::vector<double>& at = analysis_.spectrum.frequency;
    return envelope(at, density, ratio_groups(at.size(), most_series_points));
  }

  Json spectrum() const {
    if (const std::string why = why_silent(); !why.empty()) return nothing(why);
    const VelocitySpectrum& s = analysis_.spectrum;
    if (s.mean.empty()) return nothing(no_spectrum);
    if (is_zero(s.mean)) return nothing("no sample shows any vibration");
    return spectrum_facts({{"series", drawn_density(s.mean)}});
  }

  /// Of each probe of both bodies, as many as can be told apart.
  Json probe_spectra() const {
    const Analysis& a = analysis_;
    if (a.probe_position.empty() && a.slider_probe_position.empty()) return nothing(no_probes);
    if (a.spectrum.mean.empty()) return nothing(no_spectrum);
    Json lines = Json::array();
    std::size_t left_out = 0;
    bool moved = false;
    const auto add = [&](const char* body, const std::vector<double>& at,
                         const std::vector<std::vector<double>>& densities) {
      for (std::size_t p = 0; p < at.size(); ++p) {
        if (lines.size() == most_lines) {
          ++left_out;
          continue;
        }
        moved = moved || !is_zero(densities[p]);
        lines.push_back(
            {{"label", probe_label(body, at[p])}, {"series", drawn_density(densities[p])}});
      }
    };
    add("resonator", a.probe_position, a.spectrum.probe);
    add("slider", a.slider_probe_position, a.spectrum.slider_probe);
    if (!moved) return nothing("no probe moved");
    return spectrum_facts({{"lines", lines}, {"left_out", left_out}});
  }

  Json bands() const {
    if (const std::string why = why_silent(); !why.empty()) return nothing(why);
    const BandLevels& b = analysis_.bands;
    if (b.number.empty()) return nothing("the run is too short for third octaves");
    std::vector<std::string> names;
    for (const int number : b.number) names.push_back(third_octave_name(number));
    return {{"names", names},
            {"level", b.level},
            {"spread", b.spread},
            {"lv", analysis_.lv},
            {"above", bands_above_modes(analysis_)},
            {"last_mode", last_mode(analysis_)}};
  }

  /// Densities of pieces of the run, in dB re 1 (nm/s)^2/Hz, to a tenth.
  Json spectrogram() const {
    if (const std::string why = why_silent(); !why.empty()) return nothing(why);
    const std::size_t length = std::min<std::size_t>(1024, std::bit_floor(contents_.samples / 16));
    if (length < 16)
      return nothing("the run is too short for a spectrogram: fewer than 256 samples");
    Welch welch(half_overlapping(contents_.rate, length));
    const std::size_t piece = std::max(length, contents_.samples / most_frames);
    const std::size_t frames =
        std::min(most_frames, (contents_.samples - piece) / (length / 4) + 1);
    std::vector<double> at;
    Json rows = Json::array();
    for (std::size_t i = 0; i < frames; ++i) {
      const std::size_t first =
          (contents_.samples - piece) * i / std::max<std::size_t>(frames - 1, 1);
      std::vector<double> density(welch.lines());
      each_mode(first, piece, [&](double weight, const std::vector<double>& velocity) {
        const std::vector<double> of_mode = welch.density(velocity);
        for (std::size_t j = 0; j < density.size(); ++j) density[j] += weight * of_mode[j];
      });
      for (double& d : density) d = std::round(10 * level(std::sqrt(d))) / 10;
      rows.push_back(density);
      at.push_back((static_cast<double>(first) + 0.5 * static_cast<double>(piece)) /
                   contents_.rate);
    }
    return {{"x", at},
            {"frequency", welch.frequencies()},
            {"level", rows},
            {"window", static_cast<double>(piece) / contents_.rate},
            {"mesh", analysis_.mesh.in_spectrum ? analysis_.mesh.frequency : quiet_nan}};
  }

  ResultReader reader_;
  const ResultContents& contents_;
  Analysis analysis_;
  std::optional<Scene> scene_;
};

/// The panels of a view.
std::vector<std::string> panels_of(const std::string& what) {
  if (what != "overview") return {what};
  return {"profiles", "force", "displacement", "spectrum", "level", "shocks", "energy"};
}

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace

const std::vector<std::string>& result_views() {
  static const std::vector<std::string> views{"overview", "profiles",      "force",  "displacement",
                                              "spectrum", "probe-spectra", "shocks", "level",
                                              "energy",   "spectrogram",   "bands"};
  return views;
}

const std::vector<std::string>& results_views() {
  static const std::vector<std::string> views{"overview", "spectrum", "bands", "level"};
  return views;
}

std::string result_picture(const std::filesystem::path& file, const std::string& what) {
  const ResultPanels result(file);
  Json json{{"what", what}, {"head", result.head()}, {"panels", Json::object()}};
  for (const std::string& name : panels_of(what)) json["panels"][name] = result.panel(name);
  return text_of(json);
}

std::string results_picture(const std::vector<std::filesystem::path>& files,
                            const std::string& what) {
  Json json{{"what", what}, {"results", Json::array()}, {"asked", files.size()}};
  for (std::size_t i = 0; i < std::min(files.size(), most_results); ++i) {
    const ResultPanels result(files[i]);
    Json one{{"head", result.head()}, {"panels", Json::object()}};
    for (const std::string& name : results_views())
      if (name != "overview" && (what == "overview" || what == name))
        one["panels"][name] = result.panel(name);
    json["results"].push_back(std::move(one));
  }
  return text_of(json);
}

}  // namespace ra2d
