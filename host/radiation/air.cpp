// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/air.hpp"

#include <cmath>
#include <stdexcept>

namespace ra2d {

Air air_of(double celsius, double pascal) {
  if (!(celsius >= -50 && celsius <= 100) || !(pascal >= 1e4 && pascal <= 1e6))
    throw std::invalid_argument("air: expected -50 to 100 degrees Celsius and 10 to 1000 kPa");
  constexpr double gas_constant = 287.05, adiabatic = 1.4;  // J/(kg K), 1: of dry air
  const double kelvin = celsius + 273.15;
  return {pascal / (gas_constant * kelvin), std::sqrt(adiabatic * gas_constant * kelvin)};
}

}  // namespace ra2d
