// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>

#include "host/analysis/analysis_text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/print.hpp"
#include "host/errors.hpp"
#include "host/output_file.hpp"
#include "host/partial_file.hpp"
#include "host/text.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr const char* tables[] = {"spectrum.csv", "bands.csv", "shocks.csv"};

/// How the names of a result's tables begin: in a folder by the result's name; else by the prefix that
/// was given, and the result's name where there are several.
std::string prefix_of(const std::string& asked, const fs::path& result, bool several) {
  const std::string name = result.stem().string() + '-';
  if (!fs::path(asked).has_filename() || fs::is_directory(asked)) return fs::path(asked) / name;
  return several ? asked + '-' + name : asked + '-';
}

/// One for each result; before any is read.
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
    for (const char* table : tables) require_output(prefixes.back() + table, request.files);
  }
  return prefixes;
}

void write_tables(const std::string& prefix, const Analysis& analysis) {
  write_text(prefix + tables[0], spectrum_csv(analysis));
  write_text(prefix + tables[1], bands_csv(analysis));
  write_text(prefix + tables[2], shocks_csv(analysis));
}

}  // namespace

int analyze_command(const AnalyzeRequest& request) {
  const std::vector<std::string> prefixes = choose_prefixes(request);
  std::vector<Analysis> analyses;
  for (const fs::path& file : request.files) {
    analyses.push_back(analyze(file, request.options));
    const Analysis& analysis = analyses.back();
    if (!analysis.complete && request.json && !request.quiet)
      say(fmt::format("{}: the run was cut short: {}", file.string(), analysis.ended));
  }
  for (std::size_t i = 0; i < prefixes.size(); ++i) write_tables(prefixes[i], analyses[i]);
  if (request.json) {
    print_text(json_of(analyses));
    return done;
  }
  for (const Analysis& analysis : analyses) print_text(describe(analysis));
  if (analyses.size() > 1) print_text(describe_means(analyses));
  for (const std::string& prefix : prefixes)
    if (!request.quiet) print("  {:<17}{}{{spectrum,bands,shocks}}.csv\n", "written", prefix);
  return done;
}

}  // namespace ra2d
