// SPDX-License-Identifier: BSD-3-Clause
// The march, the adaptive scheme: few packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

RA2D_MARCH(Form::adaptive, 0);
RA2D_MARCH(Form::adaptive, 1);

}  // namespace ra2d
