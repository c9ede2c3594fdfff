// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/contact/cell_contact.hpp"
#include "kernels/contact/node_contact.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"

namespace ra2d {

/// The overlap in a cell: one cubic on each side of the resonator's node within it.
struct CellOverlap {
  Cubic side[2];
  double knot;  // that node

  KOKKOS_FORCEINLINE_FUNCTION double from(int i) const { return i == 0 ? -0.5 : knot; }
  KOKKOS_FORCEINLINE_FUNCTION double to(int i) const { return i == 0 ? knot : 0.5; }
};

/// Cells as expand_cell leaves them (Caches), at a place of the slider's path.
template <class Lanes, int packs>
class ExpandedCells {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  RA2D_FUNCTION ExpandedCells(const Lanes& lanes, const Caches& caches)
      : lanes_{lanes}, caches_{caches} {}

  /// The resonator's share of the shapes along a cell, phi_j eta^j for j = 1, 2, 3: what changes as
  /// the slider moves.
  RA2D_FUNCTION void path(int cell, double offset, Real (*phi)[packs]) const {
    const Real x(offset);
    for (int p = 0; p < packs; ++p) {
      const Real c3 = row(cell, 3, p);
      phi[1][p] = multiply_add(multiply_add(Real(3.0) * c3, x, Real(2.0) * row(cell, 2, p)), x,
                               row(cell, 1, p));
      phi[2][p] = multiply_add(Real(3.0) * c3, x, row(cell, 2, p));
      phi[3][p] = c3;
    }
  }
  /// Shapes of the modes of both bodies along a cell, sum_j phi_j eta^j.
  RA2D_FUNCTION void shapes(int cell, double offset, Real (*phi)[packs]) const {
    path(cell, offset, phi);
    const Real x(offset);
    for (int p = 0; p < packs; ++p) {
      const Real c2 = multiply_add(row(cell, 3, p), x, row(cell, 2, p));
      phi[0][p] = multiply_add(multiply_add(c2, x, row(cell, 1, p)), x, row(cell, 0, p));
      for (int j = 1; j < 4; ++j) phi[j][p] = phi[j][p] + row(cell, cell_slider + j - 1, p);
    }
  }
  /// sum_j phi_j eta^j
  KOKKOS_FORCEINLINE_FUNCTION static Real at(const Real (*phi)[packs], int p, double eta) {
    const Real x(eta);
    return multiply_add(multiply_add(multiply_add(phi[3][p], x, phi[2][p]), x, phi[1][p]), x,
                        phi[0][p]);
  }
  /// u_1 + u_2 along a cell whose shapes are phi.
  RA2D_FUNCTION Cubic displacement(const Real (*phi)[packs], const Real* u) const {
    Real part[4];
    for (int j = 0; j < 4; ++j) {
      part[j] = phi[j][0] * u[0];
      for (int p = 1; p < packs; ++p) part[j] = multiply_add(phi[j][p], u[p], part[j]);
    }
    Cubic sum;
    lanes_.sum(part[0], part[1], sum.c[0], sum.c[1]);
    lanes_.sum(part[2], part[3], sum.c[2], sum.c[3]);
    return sum;
  }
  /// The overlap in a cell that moved by `displacement`.
  RA2D_FUNCTION CellOverlap overlap(int cell, double theta, const Cubic& displacement) const {
    const Cubic moving = cubic(cell, 0) + displacement;
    return {{moving + passing(cell, 0, theta), moving + passing(cell, 1, theta)}, 0.5 - theta};
  }
  /// The rough faces' part of the overlap at a place of a cell [m].
  RA2D_FUNCTION double face(int cell, double theta, double eta) const {
    return cubic(cell, 0)(eta) + passing(cell, eta > 0.5 - theta ? 1 : 0, theta)(eta);
  }
  /// Slope of the resonator's face there [m/chi].
  RA2D_FUNCTION double rise(int cell, double theta, double eta) const {
    return passing(cell, eta > 0.5 - theta ? 1 : 0, theta).slope(eta);
  }

 private:
  Lanes lanes_;
  const Caches& caches_;

  KOKKOS_FORCEINLINE_FUNCTION Real row(int cell, int m, int p) const {
    return lanes_.load(caches_.node_shape +
                       ((static_cast<std::int64_t>(cell) * cell_rows + m) * packs + p) * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION Cubic cubic(int cell, int i) const {
    const double* c = caches_.node_face + static_cast<std::int64_t>(cell) * cell_numbers + 4 * i;
    return {{c[0], c[1], c[2], c[3]}};
  }
  /// A piece of the resonator's face, about the middle of the cell.
  KOKKOS_FORCEINLINE_FUNCTION Cubic passing(int cell, int side, double theta) const {
    return cubic(cell, 1 + side).about(theta + 0.5 - side);
  }
};

}  // namespace ra2d
