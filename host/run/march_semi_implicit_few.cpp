// SPDX-License-Identifier: BSD-3-Clause
// The march, backward Euler and midpoint with the penalty force of the old time: few packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

RA2D_MARCH(Form::semi_implicit, 0);
RA2D_MARCH(Form::semi_implicit, 1);

}  // namespace ra2d
