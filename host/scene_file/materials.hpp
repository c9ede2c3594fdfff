// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>
#include <string_view>

/// Typical values of common materials, for new scenes.
namespace ra2d {

struct Material {
  std::string_view name, other_names;  // other names, between blanks: " aluminum "
  double young;                        // Pa
  double density;                      // kg/m^3
  double poisson;
  double least_loss, most_loss;  // loss factor of the material alone; 0: no value here
  std::string_view source;       // of Young's modulus, density and Poisson's ratio
};

std::span<const Material> materials();

/// The source of all loss factors.
extern const std::string_view source_of_losses;

/// A material by one of its names, in any case; null for none.
const Material* find_material(std::string_view name);

}  // namespace ra2d
