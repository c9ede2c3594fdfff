// SPDX-License-Identifier: BSD-3-Clause
// The march, backward Euler and midpoint with the penalty force of the old time: many packs of
// modes.
#include "host/device/march_instance.hpp"

namespace ra2d {

RA2D_MARCH_MANY(Form::semi_implicit);

}  // namespace ra2d
