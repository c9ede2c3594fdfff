// SPDX-License-Identifier: BSD-3-Clause
// The march, contact forces found with the end of the step: many packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

RA2D_MARCH(Form::held, 2);
RA2D_MARCH(Form::held, 3);

}  // namespace ra2d
