// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/device/host_copy.hpp"
#include "host/model/model.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The polynomials of the modes' shapes under the slider (kernels/footprint.hpp).
struct FootprintShape {
  int degree = 0;  // 0: there are none
  int nodes = 1;   // of the slider's path, to a place
  int places = 0;  //
  int terms() const;
};

/// Those of a scene: of the lowest degree that leaves little of the shapes out. None in plane
/// scenes, with smooth faces (whose bounds go by the sum of the modes' sizes), or where no degree
/// will do.
FootprintShape choose_footprint(const Model& model);

/// Their tables, after the bounds of the modes.
void fill_footprint(MotionLimits& bounds, const Model& model, const Extents& n,
                    const HostCopy& host);

}  // namespace ra2d
