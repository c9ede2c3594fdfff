// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/analysis/sound_pressure.hpp"
#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/chart/chart_files.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/profile_options.hpp"
#include "host/commands/python.hpp"
#include "host/store/result_reader.hpp"
#include "host/study/study_table.hpp"
#include "host/surface/profile_series.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

const std::vector<std::string> result_views{
    "overview", "profiles", "force", "displacement", "spectrum",  "probe-spectra", "shocks",
    "level",    "energy",   "bands", "spectrogram",  "waterfall", "shock",         "motion"};
const std::vector<std::string> heard_views{"overview", "bands", "level"};  // that show pressure
const std::vector<std::string> results_views{"overview", "spectrum", "bands", "level"};
constexpr std::size_t most_results = 8;  // that a picture keeps apart

struct PlotRequest {
  std::vector<fs::path> files;
  fs::path output;
  std::string what = "overview";
  std::optional<double> from, to, time;     // s
  std::optional<unsigned long long> shock;  // its number
  SoundRequest sound;
  ProfileOptions profile;
  std::string of_profiles;  // the first of their options that was given; empty: none
  bool quiet = false;
};

void require_view(const std::string& what, const std::vector<std::string>& views,
                  const std::string& of) {
  if (std::find(views.begin(), views.end(), what) != views.end()) return;
  const auto near = nearest(what, views);
  throw RequestError(fmt::format("--what {}: of {} there {}{}", shortened(what), of,
                                 views.size() == 1 ? "is only " : "are ", any_of(views, "'")) +
                     (near ? fmt::format(" (did you mean '{}'?)", *near) : ""));
}

/// Options of results alone are refused for other files.
void refuse_result_options(const PlotRequest& request, const char* what) {
  for (const auto& [name, given] : {std::pair{"--from", request.from.has_value()},
                                    std::pair{"--to", request.to.has_value()},
                                    std::pair{"--shock", request.shock.has_value()},
                                    {"--time", request.time.has_value()},
                                    std::pair{"--at", request.sound.asks()}})
    if (given) throw RequestError(fmt::format("{} is of results: {} has none", name, what));
}

Json profile_request(const PlotRequest& request) {
  refuse_result_options(request, "a profile");
  require_view(request.what, {"overview"}, "a profile");
  std::vector<std::string> doubts;
  const std::string series = profile_series(request.files.front(),
                                            {.query = request.profile.query,
                                             .measure = request.profile.measure,
                                             .usual_filter = !request.profile.has_filter},
                                            &doubts);
  say_doubts(doubts, request.quiet);
  return {{"subject", "profile"}, {"profile", Json::parse(series)}};
}

Json results_request(const PlotRequest& request) {
  if (request.shock && request.what != "shock")
    throw RequestError("--shock N goes with --what shock alone");
  if (request.time && request.what != "motion")
    throw RequestError("--time goes with --what motion alone");
  if (request.files.size() == 1) {
    require_view(request.what, result_views, "a result");
  } else {
    require_view(request.what, results_views, "several results");
    if (request.files.size() > most_results && !request.quiet)
      say(fmt::format("a picture keeps {} results apart: the first {} of {} are drawn",
                      most_results, most_results, request.files.size()));
  }
  require_microphones(request.sound);
  if (request.sound.asks() &&
      std::find(heard_views.begin(), heard_views.end(), request.what) == heard_views.end())
    throw RequestError(fmt::format("--at goes with --what {} alone", any_of(heard_views, "")));
  if (request.files.size() > 1 && request.sound.microphones.size() > 1)
    throw RequestError(
        fmt::format("{} microphones (--at): a picture of several results has one; 'ra2d analyze' "
                    "takes more",
                    request.sound.microphones.size()));
  for (const fs::path& file : request.files) read_stamp(file);
  Json json{{"subject", "results"}, {"what", request.what}, {"files", path_texts(request.files)}};
  if (request.from) json["start"] = *request.from;
  if (request.to) json["stop"] = *request.to;
  if (request.shock) json["shock"] = *request.shock;
  if (request.time) json["time"] = *request.time;
  add_microphones_to(json, request.sound);
  return json;
}

/// Options of profiles alone are refused for other files: none is read and ignored.
void refuse_profile_options(const PlotRequest& request, const char* what) {
  if (!request.of_profiles.empty())
    throw RequestError(fmt::format("{} is of profiles: {} needs none", request.of_profiles, what));
}

Json study_request(const PlotRequest& request, const fs::path& table) {
  require_view(request.what, {"overview"}, "a study");
  refuse_profile_options(request, "a study");
  refuse_result_options(request, "a study");
  read_study_table(table);
  return {{"subject", "study"}, {"files", path_texts(request.files)}};
}

/// The subject of the picture and its files.
Json choose_subject(const PlotRequest& request, const fs::path& picture) {
  if (request.files.size() == 1)
    if (const fs::path table = study_table_of(request.files.front()); !table.empty())
      return study_request(request, table);
  std::vector<bool> results;
  for (const fs::path& file : request.files) results.push_back(is_hdf5(file));
  if (const auto chart = find_chart(request.files)) {
    require_view(request.what, {"overview"}, "a chart");
    refuse_profile_options(request, "a chart");
    refuse_result_options(request, "a chart");
    require_derived_output(picture, chart->tables);
    return {
        {"subject", "chart"}, {"chart", chart->kind->name}, {"files", path_texts(chart->tables)}};
  }
  const auto other = std::find(results.begin(), results.end(), false);
  if (other != results.end() && request.files.size() == 1) return profile_request(request);
  if (other != results.end())
    throw RequestError(
        fmt::format("{}: no result of 'ra2d run': several files in one picture must all be "
                    "results, or the tables of one chart; a profile has a picture of its own",
                    request.files[static_cast<std::size_t>(other - results.begin())].string()));
  refuse_profile_options(request, "a result");
  return results_request(request);
}

int plot_files(const PlotRequest& request) {
  const fs::path picture =
      request.output.empty() ? fs::path(name_of(request.files.front()) + ".png") : request.output;
  picture_kind(picture);
  require_derived_output(picture, request.files);
  Json subject = choose_subject(request, picture);
  subject["quiet"] = request.quiet;
  const int status = make_picture(subject, picture);
  if (status == exit_status::done && !request.quiet)
    print("written: {}\n", printable(picture.string()));
  return status;
}

}  // namespace

void add_plot(CLI::App& app, ChosenCommand& chosen) {
  const auto shared = std::make_shared<PlotRequest>();
  PlotRequest& request = *shared;
  CLI::App* plot = app.add_subcommand("plot",
                                      "makes a picture of a result, of several over one another, "
                                      "of a study, of a measured profile, "
                                      "or of a chart; needs Python");
  plot->add_option("FILE", request.files,
                   "results of 'ra2d run'; or a study's folder; or one profile; or a table of "
                   "'ra2d chart', with the "
                   "chart's other tables beside it")
      ->required()
      ->check(path());
  plot->add_option("-o,--output", request.output,
                   "picture, .png, .svg or .pdf [FILE's name with .png, in the current folder]")
      ->type_name("PICTURE")
      ->check(path());
  plot->add_option("--what", request.what,
                   fmt::format("what of a result is shown: {}; of several results: {}",
                               any_of(result_views, ""), any_of(results_views, "")))
      ->type_name("NAME")
      ->check(path())
      ->capture_default_str();
  const auto add_time = [plot](const char* name, std::optional<double>& time, const char* what) {
    plot->add_option(name, time, what)
        ->type_name("SECONDS")
        ->check(number_from(0, 1e12, "from 0 to 1e12"));
  };
  add_time("--from", request.from, "of results: where the picture begins [0]");
  add_time("--to", request.to, "of results: where it ends [the end of the run]");
  add_time("--time", request.time,
           "with --what motion: when [at the sample of the largest contact force]");
  plot->add_option("--shock", request.shock,
                   "with --what shock: which one, counted from 0 in order of start [the strongest]")
      ->type_name("N")
      ->check(whole_number());
  add_microphones(*plot, request.sound);
  const auto of_profiles = add_profile_options(*plot, request.profile);
  for (CLI::Option* option : of_profiles)
    option->group("Of a profile, as of 'ra2d surface measure'");
  plot->add_flag("--quiet", request.quiet, "print nothing but errors");
  plot->callback([shared, of_profiles, &chosen] {
    for (const CLI::Option* option : of_profiles)
      if (option->count() > 0 && shared->of_profiles.empty())
        shared->of_profiles = option->get_name();
    chosen.run = [shared] { return plot_files(*shared); };
  });
}

}  // namespace ra2d
