// SPDX-License-Identifier: BSD-3-Clause
// The march, the penalty force at each stage: many packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

RA2D_MARCH(Form::staged, 2);
RA2D_MARCH(Form::staged, 3);

}  // namespace ra2d
