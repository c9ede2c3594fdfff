// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace ra2d::test {

/// As long as one lives, programs that the tests start find a `python3` that starts quickly
/// (tests/host/warm_python.py): the first one starts its server, which ends with this process.
/// Where there is no Python, or one without the package's libraries, nothing changes.
class WarmPython {
 public:
  WarmPython();
  ~WarmPython();
  WarmPython(const WarmPython&) = delete;
  WarmPython& operator=(const WarmPython&) = delete;

 private:
  std::string before_;  // PATH
};

}  // namespace ra2d::test
