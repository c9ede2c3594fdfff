// SPDX-License-Identifier: BSD-3-Clause
#include "tests/effort.hpp"

#include <cstdlib>

namespace ra2d::test {

int draws(int usual) {
#if defined(__SANITIZE_ADDRESS__)
  return (usual + 7) / 8;
#else
  return std::getenv("RA2D_TEST_LONG") ? 4 * usual : usual;
#endif
}

bool draws_enough() { return draws(8) >= 8; }

}  // namespace ra2d::test
