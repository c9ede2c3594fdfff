// SPDX-License-Identifier: BSD-3-Clause
#include "tests/warp/march_instance.hpp"

namespace ra2d::test {

RA2D_WARP_MARCHES(Form::semi_implicit);

}  // namespace ra2d::test
