// SPDX-License-Identifier: BSD-3-Clause
#include "tests/kernels/plain_march.hpp"

namespace ra2d::test {

RA2D_PLAIN_MARCH(Form::staged)

}  // namespace ra2d::test
