// SPDX-License-Identifier: BSD-3-Clause
// The march, contact forces found with the end of the step: many packs of modes.
#include "host/device/march_instance.hpp"

namespace ra2d {

RA2D_MARCH_MANY(Form::implicit);

}  // namespace ra2d
