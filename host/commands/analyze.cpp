// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/analysis/analysis_text.hpp"
#include "host/analysis/means.hpp"
#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/study/law.hpp"
#include "host/study/study_csv.hpp"
#include "host/study/study_folder.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr const char* figures = "figures.csv";
constexpr const char* tables[] = {"spectrum.csv", "bands.csv", "shocks.csv"};
constexpr const char* sound_tables[] = {"sound.csv", "sound-level.csv"};
constexpr const char* study_tables[] = {"means.csv", "law.csv"};

struct AnalyzeRequest {
  std::vector<fs::path> files;
  AnalysisOptions options;
  bool json = false;
  std::string csv;  // folder, or how the files' names begin; empty: none
  bool quiet = false;
};

/// How the names of a result's tables begin: in a folder with the result's name; else with the
/// prefix that was given, and the result's name where there are other results.
std::string prefix_of(const std::string& given, const fs::path& result, bool among_others) {
  const std::string name = result.stem().string() + '-';
  if (!fs::path(given).has_filename() || fs::is_directory(given)) return fs::path(given) / name;
  return among_others ? given + '-' + name : given + '-';
}

/// The one table of all results: in the folder, or under the prefix.
std::string figures_file(const AnalyzeRequest& request) {
  if (request.files.size() == 1)
    return prefix_of(request.csv, request.files.front(), false) + figures;
  const bool folder = !fs::path(request.csv).has_filename() || fs::is_directory(request.csv);
  return folder ? (fs::path(request.csv) / figures).string() : request.csv + '-' + figures;
}

/// A prefix for each result. It is chosen before any result is read.
std::vector<std::string> choose_prefixes(const AnalyzeRequest& request) {
  std::vector<std::string> prefixes;
  if (request.csv.empty()) return prefixes;
  for (const fs::path& file : request.files) {
    prefixes.push_back(prefix_of(request.csv, file, request.files.size() > 1));
    if (std::count(prefixes.begin(), prefixes.end(), prefixes.back()) > 1)
      throw RequestError(
          fmt::format("--csv {}: two results would write '{}{}': expected results of different "
                      "names",
                      request.csv, prefixes.back(), tables[0]));
    for (const char* table : tables)
      require_derived_output(prefixes.back() + table, request.files, "--csv");
    if (request.options.sound.asks())
      for (const char* table : sound_tables)
        require_derived_output(prefixes.back() + table, request.files, "--csv");
  }
  require_derived_output(figures_file(request), request.files, "--csv");
  return prefixes;
}

void write_tables(const std::string& prefix, const Analysis& analysis) {
  write_text(prefix + tables[0], spectrum_csv(analysis), "--csv");
  write_text(prefix + tables[1], bands_csv(analysis), "--csv");
  write_text(prefix + tables[2], shocks_csv(analysis), "--csv");
  if (!analysis.microphones.empty() || analysis.power)
    write_text(prefix + sound_tables[0], sound_csv(analysis), "--csv");
  if (!analysis.microphones.empty())
    write_text(prefix + sound_tables[1], sound_history_csv(analysis), "--csv");
}

/// The table of a study: a folder's, or the file itself.
fs::path table_of(const fs::path& file) {
  return fs::is_directory(file) ? StudyFolder{file}.table() : file;
}

/// Whether there was a law to be written, too. An older law must not stay next to new means.
bool write_study_tables(const std::string& prefix, const StudyAnswers& answers) {
  write_text(prefix + study_tables[0], means_csv(answers), "--csv");
  std::vector<LawQuantity> wanted = sounds_of(answers);
  wanted.insert(wanted.begin(), vibration);
  std::vector<StudyLaw> laws;
  for (const LawQuantity& of : wanted) try {
      laws.push_back(fit_law(answers, of));
    } catch (const RequestError&) {  // the text and the JSON say why
    }
  write_text(prefix + study_tables[1], law_csv(laws), "--csv");
  return !laws.empty();
}

int analyze_study(const AnalyzeRequest& request) {
  if (request.files.size() > 1)
    throw RequestError(
        "several files, and one of them a study's: expected one study, or results of 'ra2d run'");
  const AnalysisOptions& o = request.options;
  if (o.resolution || o.segment || o.from || o.to || o.a_weighting || o.sound.asks())
    throw RequestError(
        "--resolution, --segment, --from, --to, --a-weighting, --at and --power are of results of "
        "'ra2d run': a study takes --json and --csv");
  fs::path named = request.files.front().lexically_normal();
  if (!named.has_filename()) named = named.parent_path();  // "study/"
  const fs::path table = table_of(named);
  const std::string prefix = request.csv.empty() ? "" : prefix_of(request.csv, named, false);
  if (!prefix.empty())
    for (const char* name : study_tables) require_derived_output(prefix + name, {table}, "--csv");
  const StudyAnswers answers = read_study_table(table);
  const bool has_law = !prefix.empty() && write_study_tables(prefix, answers);
  print_text(request.json ? study_json(answers) : describe_study(answers, table.string()));
  if (!prefix.empty() && !request.json && !request.quiet)
    print("  {:<17}{}{}.csv\n", "written", prefix, has_law ? "{means,law}" : "means");
  return exit_status::done;
}

int run_analysis(const AnalyzeRequest& request) {
  request.options.sound.require_sense(true);
  if (std::any_of(request.files.begin(), request.files.end(), [](const fs::path& file) {
        return fs::is_directory(file) || is_study_table(file);
      }))
    return analyze_study(request);
  const std::vector<std::string> prefixes = choose_prefixes(request);
  std::vector<Analysis> analyses;
  for (const fs::path& file : request.files) {
    analyses.push_back(analyze(file, request.options));
    const Analysis& analysis = analyses.back();
    if (!analysis.complete && request.json && !request.quiet)
      say(fmt::format("{}: the run was cut short: {}", file.string(), analysis.ended));
  }
  say_doubts(doubts_of_means(analyses), request.quiet);
  for (std::size_t i = 0; i < prefixes.size(); ++i) write_tables(prefixes[i], analyses[i]);
  if (!prefixes.empty()) write_text(figures_file(request), figures_csv(analyses), "--csv");
  if (request.json) {
    print_text(json_of(analyses));
    return exit_status::done;
  }
  for (const Analysis& analysis : analyses) print_text(describe(analysis));
  if (analyses.size() > 1) print_text(describe_means(analyses));
  for (std::size_t i = 0; i < prefixes.size() && !request.quiet; ++i)
    print("  {:<17}{}{{spectrum,bands,shocks{}{}}}.csv\n", "written", prefixes[i],
          request.options.sound.asks() ? ",sound" : "",
          analyses[i].microphones.empty() ? "" : ",sound-level");
  if (!prefixes.empty() && !request.quiet) print("  {:<17}{}\n", "written", figures_file(request));
  return exit_status::done;
}

}  // namespace

void add_analyze(CLI::App& app, ChosenCommand& chosen) {
  const auto shared = std::make_shared<AnalyzeRequest>();
  AnalyzeRequest& request = *shared;
  CLI::App* analyze = app.add_subcommand(
      "analyze",
      "says what results hold: level, spectrum, third octaves, shocks, powers; of several files "
      "their means with confidence intervals; of a study the means over its seeds and the law of "
      "v_rms");
  analyze->add_option("OUT.h5", request.files, "results of 'ra2d run', or the folder of a study")
      ->required()
      ->check(path());
  analyze->add_flag("--json", request.json, "prints everything as JSON");
  analyze
      ->add_option("--csv", request.csv,
                   "writes spectrum, bands and histograms as tables, of a study its means and its "
                   "law: into this folder, or with names that begin like this")
      ->type_name("PREFIX")
      ->check(path());
  AnalysisOptions& options = request.options;
  CLI::Option* resolution =
      analyze->add_option("--resolution", options.resolution, "of the spectrum, from line to line")
          ->type_name("HZ")
          ->check(number_from(1e-6, 1e12, "from 1e-6 to 1e12"));
  analyze
      ->add_option(
          "--segment", options.segment,
          "samples of a segment of the spectrum [an eighth of the stretch, a power of two]")
      ->type_name("N")
      ->transform(count())
      ->excludes(resolution);
  add_stretch(*analyze, options.from, options.to);
  analyze->add_flag("--a-weighting", options.a_weighting,
                    "weighs the bands as ears do (IEC 61672-1); a plate's velocity is no sound "
                    "pressure all the same: for dB(A) see --at");
  add_microphones(*analyze, options.sound);
  analyze->add_flag("--power", options.sound.power,
                    "the sound power that the resonator radiates, by third octave");
  analyze->add_flag("--quiet", request.quiet, "print results and errors only");
  analyze->callback([shared, &chosen] { chosen.run = [shared] { return run_analysis(*shared); }; });
}

}  // namespace ra2d
