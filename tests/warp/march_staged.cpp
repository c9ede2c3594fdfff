// SPDX-License-Identifier: BSD-3-Clause
#include "tests/warp/march_instance.hpp"

namespace ra2d::test {

RA2D_WARP_MARCHES(Form::staged);

}  // namespace ra2d::test
