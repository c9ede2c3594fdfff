// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// Reads the tables that the charts write.
namespace ra2d::test {

using Row = std::map<std::string, std::string>;

std::vector<std::string> cells(const std::string& line);

/// A file of comma-separated values, without its # lines; `header` gets its first line.
std::vector<Row> read_csv(const std::filesystem::path& file, std::string& header);

double number(const Row& row, const char* column);

}  // namespace ra2d::test
