// SPDX-License-Identifier: BSD-3-Clause
// The march, the penalty force at each stage: many packs of modes.
#include "host/device/march_instance.hpp"

namespace ra2d {

RA2D_MARCH_MANY(Form::staged);

}  // namespace ra2d
