// SPDX-License-Identifier: BSD-3-Clause
#include "tests/csv.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/child.hpp"

namespace ra2d::test {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> list(1);
  for (const char c : line)
    if (c == ',')
      list.emplace_back();
    else
      list.back() += c;
  return list;
}

std::vector<Row> read_csv(const std::filesystem::path& file, std::string& header) {
  std::istringstream in(read_file(file));
  while (std::getline(in, header) && header.starts_with('#')) {
  }
  const std::vector<std::string> names = cells(header);
  std::vector<Row> rows;
  for (std::string line; std::getline(in, line);) {
    const std::vector<std::string> values = cells(line);
    EXPECT_EQ(values.size(), names.size()) << line;
    Row row;
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i)
      row[names[i]] = values[i];
    rows.push_back(row);
  }
  return rows;
}

double number(const Row& row, const char* column) { return std::stod(row.at(column)); }

}  // namespace ra2d::test
