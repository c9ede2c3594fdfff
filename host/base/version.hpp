// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace ra2d {

/// "0.1.0"
std::string version();
/// The commit that this was built from, with "-dirty" where something was changed; "unknown"
/// outside a repository.
std::string commit();
/// "ra2d VERSION (COMMIT)": what made a file.
std::string program_text();

}  // namespace ra2d
