// SPDX-License-Identifier: BSD-3-Clause
// The march, contact forces found with the end of the step: few packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

RA2D_MARCH(Form::held, 0);
RA2D_MARCH(Form::held, 1);

}  // namespace ra2d
