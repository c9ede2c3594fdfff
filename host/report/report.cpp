// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/analysis/analysis.hpp"
#include "host/analysis/analysis_text.hpp"
#include "host/analysis/bands.hpp"
#include "host/analysis/several.hpp"
#include "host/analysis/stretch.hpp"
#include "host/base/hash.hpp"
#include "host/base/text.hpp"
#include "host/report/asked.hpp"
#include "host/report/clips.hpp"
#include "host/report/folders.hpp"
#include "host/report/html.hpp"
#include "host/report/page.hpp"
#include "host/report/pictures.hpp"
#include "host/store/result_reader.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_title = 200;  // bytes
constexpr double much_energy = 0.05;        // of what went through

/// All that the page says of one result.
struct ReportedResult {
  Analysis analysis;
  std::optional<Scene> scene;
  std::string scene_text, beyond_limit, origin;
  Clips clips;
};

/// The names of the files of measured faces, and the hashes of the heights that were made of them:
/// with these a reader of the page can recognise the files.
std::string profiles_text(const ResultReader& reader, const std::optional<Scene>& scene) {
  std::string text;
  if (!scene) return text;
  for (const auto& [body, surface] :
       {std::pair{"resonator", &scene->resonator.surface}, {"slider", &scene->slider.surface}}) {
    if (surface->kind != SurfaceKind::file) continue;
    const std::string dataset = fmt::format("surface/{}/height", body);
    const std::vector<double> heights =
        reader.column(dataset.c_str(), 0, reader.rows(dataset.c_str()));
    Hash hash;
    hash.add(heights.data(), heights.size());
    text += fmt::format("# {}: put it beside this scene. {} in the result: xxh3_128 {}\n",
                        printable(surface->path.filename().string()), dataset, hash.text());
  }
  return text;
}

ReportedResult read(const fs::path& file) {
  ReportedResult result;
  result.analysis = analyze(file, {});
  const ResultReader reader(file);
  const ResultContents& contents = reader.contents();
  result.scene = scene_of(contents, file);
  result.scene_text = profiles_text(reader, result.scene) + without_folders(contents.scene);
  result.beyond_limit = contents.beyond_limit;
  result.origin = contents.origin;
  return result;
}

std::string title_of(const Analysis& a) { return html(shortened(a.title, longest_title)); }

// ---- what came out -----------------------------------------------------------------------------

std::string level_fact(const ReportedResult& result) {
  const Analysis& a = result.analysis;
  if (std::isnan(a.v_rms)) return "none: nothing was counted";
  if (!(a.v_rms > 0)) return "−∞ dB: the resonator did not vibrate";
  std::string text = fmt::format("<b>{:.2f} dB</b> re 1 nm/s (v<sub>rms</sub> {} m/s)", a.lv,
                                 html_number(a.v_rms));
  return text + html(interval_text(a.intervals));
}

std::string rate_fact(const ReportedResult& result) {
  const Analysis& a = result.analysis;
  if (a.shocks.count == 0) return "none";
  return fmt::format("<b>{:.0f} a second</b> ({} in all){}", a.shocks.rate, a.shocks.count,
                     rate_interval_text(a.intervals));
}

std::string spread_fact(const Spread& s, double unit, const char* name) {
  return fmt::format("median {} {}; eight of ten from {} to {}", html_number(s.median / unit), name,
                     html_number(s.p10 / unit), html_number(s.p90 / unit));
}

std::string loudest_band(const BandLevels& b) {
  const auto at =
      static_cast<std::size_t>(std::max_element(b.level.begin(), b.level.end()) - b.level.begin());
  return fmt::format("{} Hz, {:.1f} dB (95 %: ± {:.1f} dB)", third_octave_name(b.number[at]),
                     b.level[at], 1.96 * b.spread[at]);
}

/// The smallest and the largest damping of all modes that have one; empty without any.
std::string damping_fact(const Analysis& a) {
  double least = HUGE_VAL, most = 0;
  std::size_t count = 0;
  for (const SpectralPeak& peak : a.peaks)
    if (peak.half_power.why == NoDamping::found) {
      least = std::min(least, peak.half_power.damping);
      most = std::max(most, peak.half_power.damping);
      ++count;
    }
  if (count == 0) return {};
  return fmt::format("{} to {}, of {} of {} modes{}", html_number(least), html_number(most), count,
                     a.peaks.size(),
                     std::isfinite(a.modal_damping)
                         ? fmt::format("; modal damping {}", html_number(a.modal_damping))
                         : "");
}

FactTable found_facts(const ReportedResult& result) {
  const Analysis& a = result.analysis;
  FactTable facts{{"level Lv", level_fact(result)}, {"shocks", rate_fact(result)}};
  if (a.shocks.count > 0) {
    facts.emplace_back("their duration", spread_fact(a.shocks.duration, 1e-6, "µs"));
    facts.emplace_back("their peak force", spread_fact(a.shocks.peak_force, 1, "N"));
    facts.emplace_back("at once",
                       fmt::format("{} on average, {} at most", html_number(a.shocks.at_once_mean),
                                   a.shocks.at_once_most));
  }
  if (std::isfinite(a.energy_per_shock))
    facts.emplace_back("energy they give", fmt::format("{} nJ each, on average",
                                                       html_number(a.energy_per_shock * 1e9)));
  if (std::isfinite(a.contact_share))
    facts.emplace_back("in contact", fmt::format("{:.2f} % of the time", 100 * a.contact_share));
  if (!a.bands.level.empty() && a.v_rms > 0)
    facts.emplace_back("loudest third octave", loudest_band(a.bands));
  if (const std::string dampings = damping_fact(a); !dampings.empty())
    facts.emplace_back("half-power damping", dampings);
  if (std::isfinite(a.energy.sliding))
    facts.emplace_back(
        "power", fmt::format("{} W from sliding, {} W to damping", html_number(a.energy.sliding),
                             html_number(a.energy.damping)));
  if (std::isfinite(a.energy_closure))
    facts.emplace_back("energy balance", fmt::format("closes to {} of what went through",
                                                     html_number(a.energy_closure, 2)));
  return facts;
}

/// Warnings for the reader.
std::vector<std::string> doubts_of(const ReportedResult& result) {
  const Analysis& a = result.analysis;
  std::vector<std::string> doubts;
  if (!a.complete) doubts.push_back("The run was cut short: " + html(shortened(a.ended, 300)));
  if (!result.beyond_limit.empty())
    doubts.push_back("The step is beyond a limit of stability, on request: " +
                     html(shortened(result.beyond_limit, 300)));
  if (a.energy_closure > much_energy)
    doubts.push_back(
        fmt::format("{:.0f} % of the energy is unaccounted for.", 100 * a.energy_closure));
  if (a.aliased_modes > 0)
    doubts.push_back(fmt::format(
        "{} mode{} above half the rate of the samples: spectrum, third octaves and sound "
        "have their power in wrong places. A higher output.rate mends that.",
        a.aliased_modes, a.aliased_modes == 1 ? " lies" : "s lie"));
  if (a.mesh.stands_out())
    doubts.push_back(fmt::format(
        "The mesh's own tone at {} Hz stands {:.0f} dB above what is around it: it belongs to "
        "the spacing, not to the surface.",
        html_number(a.mesh.frequency, 5), a.mesh.rise));
  return doubts;
}

std::string doubts_box(const ReportedResult& result) {
  std::string text;
  for (const std::string& doubt : doubts_of(result)) text += "<p>" + doubt + "</p>\n";
  return text.empty() ? text : "<div class=\"note\" role=\"note\">\n" + text + "</div>\n";
}

// ---- pictures, sound, scene --------------------------------------------------------------------

std::string pictures_part(const ReportedResult& result) {
  std::string text;
  for (const Picture& picture : pictures_of(result.analysis, result.analysis.history))
    text += fmt::format("<figure>\n{}<figcaption>{}</figcaption>\n</figure>\n", picture.svg,
                        picture.caption);
  return text.empty() ? text : "<h3>Pictures</h3>\n<div class=\"columns\">\n" + text + "</div>\n";
}

std::string sound_part(const Clips& clips) {
  std::string text = "<div class=\"sound\">\n<h3>Sound</h3>\n";
  if (clips.clips.empty()) return text + "<p>" + clips.why_none + "</p>\n</div>\n";
  text +=
      "<p class=\"soft\">The velocity of a place on the resonator; it is no sound pressure.</p>\n"
      "<div class=\"columns\">\n";
  for (const Clip& clip : clips.clips)
    text += fmt::format(
        "<figure>\n<figcaption>{}</figcaption>\n<audio controls preload=\"metadata\" "
        "src=\"{}\"></audio>\n</figure>\n",
        clip.caption, clip.data_address);
  return text + "</div>\n</div>\n";
}

std::string scene_part(const ReportedResult& result, std::size_t number) {
  return "<h3>The scene</h3>\n" +
         text_to_copy(
             "Save it as <code>scene.toml</code> and run it again: <code>ra2d run scene.toml -o "
             "result.h5</code>",
             "the scene", fmt::format("scene{}", number), result.scene_text);
}

std::string section(const ReportedResult& result, std::size_t number, bool one_of_many) {
  const Analysis& a = result.analysis;
  std::string text = fmt::format("<section id=\"result{}\">\n", number);
  if (one_of_many) text += fmt::format("<h2>{}: {}</h2>\n", number, title_of(a));
  text +=
      fmt::format("<p class=\"lead\">{}, {} s to {} s. {}</p>\n", html(a.file.filename().string()),
                  html_number(a.from, 6), html_number(a.to, 6), html(result.origin));
  text += doubts_box(result);
  text += "<h3>What came out</h3>\n" + table_of(found_facts(result));
  text +=
      "<p class=\"soft\">The 95 % intervals of level and shocks are of this run: how far off it "
      "is, had the "
      "same slider gone on over more of the same plate. Other seeds draw other surfaces, which "
      "differ by "
      "more: only several runs tell.</p>\n";
  text += sound_part(result.clips) + pictures_part(result);
  if (result.scene) text += "<h3>What was asked</h3>\n" + table_of(asked_facts(*result.scene));
  return text + scene_part(result, number) + "</section>\n";
}

// ---- several results ---------------------------------------------------------------------------

std::string comparison(const std::vector<ReportedResult>& results) {
  std::string rows;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Analysis& a = results[i].analysis;
    rows += fmt::format(
        "<tr><td><a "
        "href=\"#result{}\">{}</a>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        i + 1, html(a.file.filename().string()), a.complete ? "" : " (cut short)",
        html_number(a.lv, 5), html_number(a.shocks.rate, 5),
        html_number(a.shocks.duration.median * 1e6), html_number(a.shocks.peak_force.median));
  }
  return "<h2>Side by side</h2>\n<div class=\"wide\"><table class=\"means\">\n<tr><th>result</th>"
         "<th>Lv, dB</th><th>shocks, 1/s</th><th>duration, µs</th><th>peak, N</th></tr>\n" +
         rows + "</table></div>\n<p class=\"soft\">Durations and peak forces: medians.</p>\n";
}

/// The name of a figure of analyze's JSON on a page, and the factor to the unit there.
struct FigureWords {
  std::string name;
  double times = 1;
};

FigureWords words_of(const std::string& figure) {
  for (const auto& [name, words] :
       {std::pair{"lv", FigureWords{"level Lv, dB re 1 nm/s"}},
        {"v_rms", {"velocity, rms, mm/s", 1e3}},
        {"contact_share", {"share of the time in contact"}},
        {"shocks.rate", {"shocks, 1/s"}},
        {"shocks.duration.median", {"median duration of shocks, µs", 1e6}},
        {"shocks.peak_force.median", {"median peak force, N"}},
        {"shocks.impulse.median", {"median impulse, µN s", 1e6}},
        {"shocks.simultaneous.mean", {"shocks at once"}},
        {"energy.sliding_power", {"power from sliding, mW", 1e3}},
        {"energy.damping_power", {"power to damping, mW", 1e3}},
        {"energy.per_shock", {"energy that a shock gives, nJ", 1e9}}})
    if (figure == name) return words;
  return {html(figure), 1};
}

std::string means(const std::vector<ReportedResult>& results) {
  std::vector<Analysis> analyses;
  for (const ReportedResult& result : results) analyses.push_back(result.analysis);
  std::string rows;
  for (const FigureOfRuns& f : means_of(analyses)) {
    const auto [name, times] = words_of(f.name);
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{} to {}</td><td>{}</td></tr>\n", name,
                        html_number(times * f.value.mean, 5), html_number(times * f.value.low, 5),
                        html_number(times * f.value.high, 5),
                        html_number(times * f.value.deviation, 2));
  }
  return "<h2>Means</h2>\n<div class=\"wide\"><table class=\"means\">\n<tr><th>figure</th><th>mean"
         "</th><th>95 %</th><th>deviation</th></tr>\n" +
         rows +
         "</table></div>\n<p class=\"soft\">They mean something where the results differ by chance "
         "alone, e.g. by their seeds.</p>\n";
}

}  // namespace

std::string report_page(const std::vector<fs::path>& files, const std::string& command) {
  std::vector<ReportedResult> results;
  for (const fs::path& file : files) results.push_back(read(file));
  std::vector<Clips> clips = clips_of(files);
  for (std::size_t i = 0; i < results.size(); ++i) results[i].clips = std::move(clips[i]);
  const bool one_of_many = results.size() > 1;
  const std::string title = one_of_many ? fmt::format("Roughness noise: {} results", results.size())
                                        : title_of(results.front().analysis);
  std::string body;
  if (one_of_many) body += comparison(results) + means(results);
  for (std::size_t i = 0; i < results.size(); ++i) body += section(results[i], i + 1, one_of_many);
  return whole_page(title, body, command);
}

}  // namespace ra2d
