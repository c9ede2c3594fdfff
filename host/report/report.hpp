// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace ra2d {

/// A page of results, complete in itself (docs/report.md). `command`: what made it. Throws
/// FileError and RequestError as analyze() does.
std::string report_page(const std::vector<std::filesystem::path>& files,
                        const std::string& command);

}  // namespace ra2d
