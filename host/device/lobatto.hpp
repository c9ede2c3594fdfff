// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

namespace ra2d {

/// Lobatto's rule of n points: its first point is -1, its last 1, and it is exact for polynomials
/// of degree 2 n - 3.
struct LobattoRule {
  std::vector<long double> points, weights;
};
LobattoRule lobatto_rule(int points);

/// Legendre polynomials of the degrees 0 ... `highest` at y.
std::vector<long double> legendre(long double y, int highest);

/// Fills SeriesTables::lobatto.
void fill_lobatto(double* table);

}  // namespace ra2d
