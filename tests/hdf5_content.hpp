// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <map>
#include <string>

namespace ra2d::test {

/// Content of a result file: size, numbers and hash of every dataset, and whether the file is
/// marked complete. Empty for any other file.
using Content = std::map<std::string, std::string>;

/// Without the datasets of times, and of what depends on the launches (summary/nodes_evaluated).
Content content_of(const std::filesystem::path& path);

}  // namespace ra2d::test
