// SPDX-License-Identifier: BSD-3-Clause
// The march, the adaptive scheme: few packs of modes.
#include "host/device/march_instance.hpp"

namespace ra2d {

RA2D_MARCH_FEW(Form::adaptive);

}  // namespace ra2d
