// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// The data of results' pictures (docs/pictures.md): JSON for host/plot/plot_result.py, so small
/// that a picture can hold all of it.
namespace ra2d {

/// The views of a result, and of several over one another.
const std::vector<std::string>& result_views();
const std::vector<std::string>& results_views();

/// As many results as a picture keeps apart.
inline constexpr std::size_t most_results = 8;

/// Of one result. Throws FileError of the file.
std::string result_picture(const std::filesystem::path& file, const std::string& what);

/// Of several, the first `most_results` of them.
std::string results_picture(const std::vector<std::filesystem::path>& files,
                            const std::string& what);

}  // namespace ra2d
