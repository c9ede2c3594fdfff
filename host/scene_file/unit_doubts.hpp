// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

/// Numbers that are likely to be in another unit than the scene's. A sentence each; nothing is
/// refused for it.
namespace ra2d {

/// Of the scene's bodies, loads, speed, spacing and peaks. A NaN, which stands for a number at
/// fault, is not doubted.
std::vector<std::string> unit_doubts(const Scene& scene);

/// The mistake that may have made a number, and the number that was meant.
struct Slip {
  const char* words;
  double factor;  // from what stands to what was meant
};
inline constexpr Slip millimetres{"is it in mm", 1e-3}, micrometres{"is it in um", 1e-6},
    too_small{"was it divided by 1000 once too often", 1e3},
    too_large{"was it multiplied by 1000 once too often", 1e-3};

/// Adds "slider.density = 8.5 kg/m^3: lighter than foam: is it in g/cm^3 (8500 kg/m^3)?" `key`: its
/// path in the table of keys, which has its unit.
void doubt(std::vector<std::string>& doubts, const std::string& key, double value,
           const std::string& why, const Slip& slip);

}  // namespace ra2d
