// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace ra2d {

/// How many of the threads that were asked for there can be: one for each processor that this
/// process may use, as many as the march takes, as many as the system starts. `why` says what
/// lowered them; it stays empty where nothing did.
int usable_threads(int asked, std::string& why);

}  // namespace ra2d
