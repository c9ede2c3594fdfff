// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/lobatto.hpp"

#include <cmath>
#include <numbers>

#include "kernels/tables.hpp"

namespace ra2d {
namespace {

using Real = long double;

}  // namespace

std::vector<Real> legendre(Real y, int highest) {
  std::vector<Real> p{1, y};
  for (int k = 1; k < highest; ++k) p.push_back(((2 * k + 1) * y * p[k] - k * p[k - 1]) / (k + 1));
  return p;
}

LobattoRule lobatto_rule(int points) {
  const int degree = points - 1;
  LobattoRule rule;
  for (int i = 0; i <= degree; ++i) {
    Real y = -std::cos(std::numbers::pi_v<Real> * i / degree);
    // where the slope of the Legendre polynomial vanishes
    for (int n = 0; n < 20 && i > 0 && i < degree; ++n) {
      const auto p = legendre(y, degree);
      y -= (y * p[degree] - p[degree - 1]) / ((degree + 1) * p[degree]);
    }
    if (i == 0) y = -1;
    if (i == degree) y = 1;
    const Real top = legendre(y, degree)[degree];
    rule.points.push_back(y);
    rule.weights.push_back(2 / (degree * (degree + 1) * top * top));
  }
  return rule;
}

void fill_lobatto(double* table) {
  for (const int inner : lobatto_inner) {
    const LobattoRule rule = lobatto_rule(inner + 2);
    for (int g = 0; g < inner; ++g) {
      table[g] = static_cast<double>((rule.points[g + 1] + 1) / 2);
      table[lobatto_row + g] = static_cast<double>(rule.weights[g + 1] / 2);
    }
    table[lobatto_row + inner] = static_cast<double>(rule.weights.front() / 2);
    table += lobatto_numbers;
  }
}

}  // namespace ra2d
