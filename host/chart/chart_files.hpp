// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// The tables that a chart is written to, and from which it is drawn: at once, or again later.
namespace ra2d {

/// A table is known by its first line, whatever its file is called.
struct ChartTable {
  std::string suffix;   // PREFIX + suffix is its file
  std::string columns;  // the line of names
};

struct ChartKind {
  std::string name;                // `ra2d chart NAME`
  std::vector<ChartTable> tables;  // the first one is PREFIX.csv
};

const ChartKind& stability_tables();
const ChartKind& accuracy_tables();

/// A table's line of names with its end.
std::string heading(const ChartTable& table);

/// The files of a chart, in the order of its tables.
std::vector<std::filesystem::path> chart_files(const ChartKind& kind, const std::string& prefix);

struct FoundChart {
  const ChartKind* kind = nullptr;
  std::vector<std::filesystem::path> tables;
};

/// The chart that these files are of; nothing where none of them is a table of one. Tables that are
/// not named are looked for beside the first, under the names that `ra2d chart` gives them. Throws
/// RequestError where one is missing, or where they do not belong together; FileError where one is
/// damaged.
std::optional<FoundChart> find_chart(const std::vector<std::filesystem::path>& files);

}  // namespace ra2d
