// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace ra2d {

/// While one lives, a crash of its thread (a segmentation fault, an abort) ends the program as a
/// file that cannot be read does: the message goes to standard error, partial files are removed,
/// and the exit status is 4. It is for libraries that may crash on a hostile file. Only one may
/// live at a time.
class CrashMessage {
 public:
  explicit CrashMessage(const std::string& text);
  ~CrashMessage();
  CrashMessage(const CrashMessage&) = delete;
  CrashMessage& operator=(const CrashMessage&) = delete;
};

/// From now on this process crashes as if there were no CrashMessage: its parent wants to see it.
void crash_plainly();

}  // namespace ra2d
