// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/collocation_tables.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "host/device/lobatto.hpp"
#include "kernels/adaptive/pace.hpp"

namespace ra2d {
namespace {

using Real = long double;
constexpr int degree = last_point;

/// Integrals of the Legendre polynomials up to `degree`, from -1 to y.
std::array<Real, degree + 1> legendre_integrals(Real y) {
  const auto p = legendre(y, degree + 1);
  std::array<Real, degree + 1> integrals{y + 1};
  for (int k = 1; k <= degree; ++k) integrals[k] = (p[k + 1] - p[k - 1]) / (2 * k + 1);
  return integrals;
}

/// Their coefficients as polynomials of x = (y + 1)/2.
std::array<std::array<Real, degree + 1>, degree + 1> legendre_powers() {
  std::array<std::array<Real, degree + 1>, degree + 1> c{};
  c[0][0] = 1;
  c[1][0] = -1;
  c[1][1] = 2;
  for (int k = 1; k < degree; ++k)
    for (int m = 0; m <= degree; ++m) {
      const Real below = m > 0 ? c[k][m - 1] : 0;
      c[k + 1][m] = ((2 * k + 1) * (2 * below - c[k][m]) - k * c[k - 1][m]) / (k + 1);
    }
  return c;
}

using Matrix = std::array<std::array<Real, collocation_points>, collocation_points>;

/// (k, j): coefficient of degree k in the polynomial that is 1 at point j and 0 at the others.
Matrix legendre_coefficients(const LobattoRule& rule) {
  Matrix c;
  for (int j = 0; j <= degree; ++j) {
    const auto p = legendre(rule.points[j], degree);
    // the rule takes the square of the highest one for 2/degree
    for (int k = 0; k <= degree; ++k)
      c[k][j] = rule.weights[j] * p[k] * (k < degree ? Real(2 * k + 1) : Real(degree)) / 2;
  }
  return c;
}

}  // namespace

void fill_collocation(double* table) {
  const LobattoRule rule = lobatto_rule(collocation_points);
  const std::vector<Real>& points = rule.points;
  const Matrix coefficients = legendre_coefficients(rule);
  const auto powers = legendre_powers();
  Matrix integral{};  // (i, j): from the beginning to point i, of what is 1 at point j alone
  for (int i = 0; i <= degree; ++i) {
    const auto integrals = legendre_integrals(points[i]);
    for (int j = 0; j <= degree; ++j)
      for (int k = 0; k <= degree; ++k) integral[i][j] += coefficients[k][j] * integrals[k] / 2;
  }
  for (int pace = 0; pace < paces; ++pace, table += pace_numbers) {
    const auto number = [&](int row, int j) -> double& { return table[row + j]; };
    std::array<Real, collocation_points> rate;
    for (int j = 0; j <= degree; ++j) {
      const double x = static_cast<double>((points[j] + 1) / 2);
      rate[j] = pace_rate(static_cast<Pace>(pace), x);
      number(point_places, j) = x;
      if (j > 0) table[point_shares + j - 1] = pace_share(static_cast<Pace>(pace), x);
    }
    for (int j = 1; j <= degree; ++j) {
      const Real before = points[j] - points[j - 1],
                 after = j < degree ? points[j + 1] - points[j] : Real(0),
                 longer = std::max(before, after) / 2;
      table[point_sags + j - 1] = static_cast<double>(longer * longer / 8);
    }
    for (int j = 0; j <= degree; ++j) {
      const auto of_degree = [&](int k) {
        return static_cast<double>(coefficients[k][j] * rate[j]);
      };
      // for points of a Gaussian rule they go with the roots of its weights
      const double root = std::sqrt(static_cast<double>(integral[degree][j]));
      number(barycentric_weights, j) = j % 2 == 0 ? root : -root;
      number(end_weights, j) = static_cast<double>(integral[degree][j] * rate[j]);
      number(legendre_8, j) = of_degree(8);
      number(legendre_7, j) = of_degree(7);
      number(legendre_4, j) = of_degree(4);
      number(legendre_3, j) = of_degree(3);
      for (int m = 1; m < motion_terms; ++m) {
        Real power = 0;
        for (int k = 0; k <= degree; ++k) power += coefficients[k][j] * powers[k][m - 1];
        number(motion_weights + m * collocation_points, j) =
            static_cast<double>(power * rate[j] / m);
      }
      for (int i = 1; i <= degree; ++i) {
        Real twice = 0;
        for (int k = 0; k <= degree; ++k)
          twice += integral[i][k] * rate[k] * integral[k][j] * rate[j];
        table[velocity_columns + j * point_row + i - 1] =
            static_cast<double>(integral[i][j] * rate[j]);
        table[displacement_columns + j * point_row + i - 1] = static_cast<double>(twice);
      }
    }
  }
}

}  // namespace ra2d
