// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/chart_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_line = 4096, most_comments = 100;
constexpr const char* ending = ".csv";

/// One line without its end; a longer one, which no table has, is cut.
bool next_line(std::istream& in, std::string& line) {
  line.clear();
  for (char c = 0; line.size() < longest_line && in.get(c) && c != '\n';) line += c;
  if (line.ends_with('\r')) line.pop_back();
  return in.good() || !line.empty();
}

/// Passes the comments; the line of names.
std::string first_line(std::istream& in, std::size_t& number) {
  std::string line;
  for (number = 1; number <= most_comments && next_line(in, line); ++number)
    if (!line.starts_with('#')) return line;
  return {};
}

struct Recognised {
  const ChartKind* kind = nullptr;
  std::size_t table = 0;
};

Recognised recognise(const fs::path& file) {
  InputStream in(file, "the table");
  std::size_t number = 0;
  const std::string line = first_line(in, number);
  for (const ChartKind* kind : {&stability_tables(), &accuracy_tables()})
    for (std::size_t i = 0; i < kind->tables.size(); ++i)
      if (line == kind->tables[i].columns) return {kind, i};
  return {};
}

void require_rows(const fs::path& file, const ChartKind& kind, const ChartTable& table) {
  InputStream in(file, "the table");
  std::size_t number = 0;
  first_line(in, number);
  const auto columns = std::count(table.columns.begin(), table.columns.end(), ',') + 1;
  for (std::string line; next_line(in, line);) {
    ++number;
    const auto found = std::count(line.begin(), line.end(), ',') + 1;
    if (found != columns)
      throw FileError(fmt::format(
          "cannot draw '{}': line {} has {} columns instead of {}: it is cut short or damaged. "
          "'ra2d chart {}' writes it anew",
          file.string(), number, found, columns, kind.name));
  }
}

/// PREFIX of PREFIX-suffix.csv; nothing for another name.
std::optional<std::string> prefix_of(const fs::path& file, const ChartTable& table) {
  const std::string name = file.string(), end = table.suffix + ending;
  if (!name.ends_with(end)) return {};
  return name.substr(0, name.size() - end.size());
}

/// The table `index` beside `file`, a table of the same chart.
fs::path sibling_of(const fs::path& file, const Recognised& table, std::size_t index) {
  const ChartTable& wanted = table.kind->tables[index];
  const auto prefix = prefix_of(file, table.kind->tables[table.table]);
  const fs::path found = prefix ? *prefix + wanted.suffix + ending : std::string{};
  std::error_code none;
  const Recognised there = prefix && fs::exists(found, none) ? recognise(found) : Recognised{};
  if (there.kind == table.kind && there.table == index) return found;
  throw RequestError(fmt::format(
      "{}: a chart of {} has {} tables, and the one with the columns '{},...' is not beside it{}: "
      "name all of them (ra2d plot {})",
      file.string(), table.kind->name, table.kind->tables.size(),
      wanted.columns.substr(0, wanted.columns.find(',', wanted.columns.find(',') + 1)),
      prefix ? fmt::format(", as '{}'", found.string()) : "",
      fmt::join(
          [&] {
            std::vector<std::string> names;
            for (const ChartTable& one : table.kind->tables)
              names.push_back("PREFIX" + one.suffix + ending);
            return names;
          }(),
          " ")));
}

}  // namespace

const ChartKind& stability_tables() {
  static const ChartKind kind{
      "stability",
      {{"",
        "scheme,contact_force,order,stages,contact,zeta,motion_zeta,theory,measured_low,"
        "measured_high,growth_x,growth_theory,growth_measured"},
       {"-regions", "scheme,contact_force,contact,zeta,limit,re,im"},
       {"-modes", "contact,body,mode,frequency,zeta,re,im"}}};
  return kind;
}

const ChartKind& accuracy_tables() {
  static const ChartKind kind{
      "accuracy",
      {{"",
        "program,scheme,law,contact_force,nodes,step,tolerance,kind,error,against,wall_median,"
        "wall_min,wall_max,repetitions,stretch,how"},
       {"-long",
        "program,scheme,law,contact_force,nodes,step,tolerance,quantity,mean,standard_error,"
        "difference,difference_error,seeds,duration,wall,how"}}};
  return kind;
}

std::string heading(const ChartTable& table) { return table.columns + '\n'; }

std::vector<fs::path> chart_files(const ChartKind& kind, const std::string& prefix) {
  std::vector<fs::path> files;
  for (const ChartTable& table : kind.tables) files.emplace_back(prefix + table.suffix + ending);
  return files;
}

std::optional<FoundChart> find_chart(const std::vector<fs::path>& files) {
  std::vector<Recognised> recognised;
  for (const fs::path& file : files) recognised.push_back(recognise(file));
  const auto first = std::find_if(recognised.begin(), recognised.end(),
                                  [](const Recognised& k) { return k.kind; });
  if (first == recognised.end()) return {};
  const fs::path& file = files[static_cast<std::size_t>(first - recognised.begin())];
  FoundChart chart{first->kind, std::vector<fs::path>(first->kind->tables.size())};
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (recognised[i].kind != chart.kind)
      throw RequestError(
          fmt::format("{}: no table of the chart of {} that {} is of: a chart has a picture of "
                      "its own",
                      files[i].string(), chart.kind->name, file.string()));
    fs::path& place = chart.tables[recognised[i].table];
    if (!place.empty())
      throw RequestError(
          fmt::format("{} and {} are the same table of two charts: a chart has a "
                      "picture of its own",
                      place.string(), files[i].string()));
    place = files[i];
  }
  for (std::size_t i = 0; i < chart.tables.size(); ++i) {
    if (chart.tables[i].empty()) chart.tables[i] = sibling_of(file, *first, i);
    require_rows(chart.tables[i], *chart.kind, chart.kind->tables[i]);
  }
  return chart;
}

}  // namespace ra2d
