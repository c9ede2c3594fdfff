// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How the program ends (docs/results.md).
namespace ra2d::exit_status {

inline constexpr int done = 0, wrong_request = 2, failed = 3, wrong_file = 4, out_of_time = 5;
inline constexpr int interrupted = 128;  // and the signal's number

}  // namespace ra2d::exit_status
