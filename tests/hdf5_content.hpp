// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <map>
#include <string>

namespace ra2d::test {

/// What a result file holds: every dataset's size, numbers and hash, and whether it says that it is
/// complete. Empty for a file that is none.
using Content = std::map<std::string, std::string>;

/// Without the datasets of times, and of what depends on the launches (summary/nodes_evaluated).
Content content_of(const std::filesystem::path& path);

}  // namespace ra2d::test
