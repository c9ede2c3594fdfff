// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/version.hpp"

#ifndef RA2D_VERSION
#define RA2D_VERSION "unknown"
#endif
#ifndef RA2D_COMMIT
#define RA2D_COMMIT "unknown"
#endif

namespace ra2d {

std::string version() { return RA2D_VERSION; }
std::string commit() { return RA2D_COMMIT; }
std::string program_text() { return "ra2d " + version() + " (" + commit() + ")"; }

}  // namespace ra2d
