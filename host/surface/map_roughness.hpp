// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/surface/height_map.hpp"

namespace ra2d {

/// Roughness of a map about its mean, as ISO 25178-2 defines it for an area that no filter was
/// applied to, and the mean spacing of the profile elements of its rows and of its columns. NaN
/// where a parameter has no meaning, as of a map that is flat.
struct MapRoughness {
  double sq, sz;      // m, root mean square height; from the lowest to the highest
  double ssk, sku;    // skewness and kurtosis of the heights
  double rsm, rsm_y;  // m: RSm (ISO 21920-2) of every row, and of every column, from its own mean;
                      // the mean over those that have one
};

/// No height may be missing.
MapRoughness map_roughness(const HeightMap& map);

}  // namespace ra2d
