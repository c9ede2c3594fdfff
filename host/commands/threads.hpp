// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace ra2d {

/// How many of the wanted threads there can be: one for each processor that this process may use,
/// as many as a march takes, as many as the system starts. `why`: the reason where there are fewer.
int usable_threads(int wanted, std::string& why);

/// Lowers the threads of a command to what there can be, and says so unless it is to be quiet.
void limit_threads(int& threads, bool quiet);

}  // namespace ra2d
