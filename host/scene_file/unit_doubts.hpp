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
  double factor;      // from what stands to what was meant
  const char* unit;   // that the number may be in; empty: the mistake is another one,
  const char* words;  // in words
};
inline constexpr Slip millimetres{1e-3, "mm", ""}, micrometres{1e-6, "um", ""},
    too_small{1e3, "", "was it divided by 1000 once too often"},
    too_large{1e-3, "", "was it multiplied by 1000 once too often"};

/// Adds "slider.density = 8.5 kg/m^3: lighter than foam: is it in g/cm^3 (8500 kg/m^3)? Then write
/// "8.5 g/cm^3"". `key`: its path in the table of keys, which has its unit.
void doubt(std::vector<std::string>& doubts, const std::string& key, double value,
           const std::string& why, const Slip& slip);

}  // namespace ra2d
