// SPDX-License-Identifier: BSD-3-Clause
// The march, the adaptive scheme: many packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

RA2D_MARCH(Form::adaptive, 2);
RA2D_MARCH(Form::adaptive, 3);

}  // namespace ra2d
