// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/contact/cell_parts.hpp"
#include "kernels/displacement.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The overlap in a cell: one cubic on each side of the resonator's node within it.
struct CellOverlap {
  Cubic side[2];
  double knot;  // that node

  KOKKOS_FORCEINLINE_FUNCTION double from(int i) const { return i == 0 ? -0.5 : knot; }
  KOKKOS_FORCEINLINE_FUNCTION double to(int i) const { return i == 0 ? knot : 0.5; }
  KOKKOS_FORCEINLINE_FUNCTION double highest() const {
    return Kokkos::max(highest_on(side[0], from(0), to(0)).value,
                       highest_on(side[1], from(1), to(1)).value);
  }
};

/// Rows of an expanded cell (expand_cell).
enum CellRow : int { cell_path = 0, cell_slider = 4, cell_rows = 7 };
inline constexpr int cell_numbers = 12;

/// Expands one cell over one window, about its middle: as for a node the shapes of all modes there,
/// resonator's as cubics of the offset (cell_path); then the slider's derivatives psi', psi''/2 and
/// psi'''/6 along the cell (cell_slider). The resonator's follow from its cubics: offset and place
/// in the cell add up. `face`: the cubics of CellFaces. A pure function of cell and window.
template <class Lanes, int packs>
KOKKOS_INLINE_FUNCTION void expand_cell(const Lanes& lanes, const FaceTables& faces,
                                        const SliderShapes& slider, const PatchTables& patches,
                                        const Place& place, int cell, double* shape, double* face) {
  using Real = typename Lanes::Real;
  RA2D_CHECK(is_cell(faces, cell));
  const RowTables& rows = faces.rows;
  // in an areal scene: its row, and where it stands in that
  const int j = rows.across == nullptr ? 0 : cell / slider.row, i = cell - j * slider.row;
  const int at = place.base + i;
  Real c[cell_rows][packs];
  Real path[4][packs];
  expand_modes<Lanes, packs>(lanes, patches, at / patches.nodes, at + 0.5 + place.middle, path);
  for (int p = 0; p < filled<packs>(lanes); ++p) {
    for (int m = 0; m < 4; ++m) c[m][p] = path[m][p];
    for (int m = cell_slider; m < cell_rows; ++m) c[m][p] = Real(0.0);
  }
  const std::int64_t row = slider.row;
  for (int k = 0; k < slider.modes; ++k)
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      const Real unit = lanes.load(slider.unit + (k * packs + p) * Lanes::width);
      const double* own = slider.cell + 4 * k * row + i;
      c[0][p] = multiply_add(own[0], unit, c[0][p]);
      for (int m = 1; m < 4; ++m)
        c[cell_slider + m - 1][p] = multiply_add(own[m * row], unit, c[cell_slider + m - 1][p]);
    }
  if (rows.across != nullptr) [[unlikely]]
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      const Real share =
          lanes.load(rows.across + (static_cast<std::int64_t>(j) * packs + p) * Lanes::width);
      for (int m = 0; m < cell_rows; ++m) c[m][p] = share * c[m][p];
    }
  for (int m = 0; m < cell_rows; ++m)
    for (int p = 0; p < filled<packs>(lanes); ++p)
      lanes.store(shape + (m * packs + p) * Lanes::width, c[m][p]);
  if (lanes.leader()) {
    const double *h1 = faces.height1 + cell, *b1 = faces.curvature1 + cell;
    const int passed = place.base - rows.behind + cell + j * rows.excess;
    const double *h2 = faces.height2 + passed, *b2 = faces.curvature2 + passed;
    const Cubic pieces[3] = {spline_piece(h1[0], h1[1], b1[0], b1[1]).about(0.5),
                             spline_piece(h2[0], h2[1], b2[0], b2[1]),
                             spline_piece(h2[1], h2[2], b2[1], b2[2])};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) face[4 * i + j] = pieces[i].c[j];
  }
}

/// Cells as expand_cell leaves them (Caches), at a place of the slider's path.
template <class Lanes, int packs>
class ExpandedCells {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  RA2D_FUNCTION ExpandedCells(const Lanes& lanes, const Marks& marks, const Caches& caches)
      : lanes_{lanes}, caches_{caches}, node_slot_{marks.node_slot} {}

  /// Shapes of both bodies' modes of a pack along a cell, sum_j phi_j eta^j, and of these the
  /// resonator's share for j = 1, 2, 3: what changes as the slider moves.
  KOKKOS_FORCEINLINE_FUNCTION void along(int cell, const Real& offset, int p, Real* phi,
                                         Real* path) const {
    const Real c1 = row(cell, 1, p), c2 = row(cell, 2, p), c3 = row(cell, 3, p);
    const Real& x = offset;
    phi[0] = multiply_add(multiply_add(multiply_add(c3, x, c2), x, c1), x, row(cell, 0, p));
    path[1] = multiply_add(multiply_add(Real(3.0) * c3, x, Real(2.0) * c2), x, c1);
    path[2] = multiply_add(Real(3.0) * c3, x, c2);
    path[3] = c3;
    for (int j = 1; j < 4; ++j) phi[j] = path[j] + row(cell, cell_slider + j - 1, p);
  }
  /// Those of all modes, and the resonator's share of them.
  RA2D_FUNCTION void shapes(int cell, double offset, Real (*phi)[packs]) const {
    const Real x(offset);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real all[4], moving[4];
      along(cell, x, p, all, moving);
      for (int j = 0; j < 4; ++j) phi[j][p] = all[j];
    }
  }
  RA2D_FUNCTION void path(int cell, double offset, Real (*phi)[packs]) const {
    const Real x(offset);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real all[4], moving[4];
      along(cell, x, p, all, moving);
      for (int j = 1; j < 4; ++j) phi[j][p] = moving[j];
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
      for (int p = 1; p < filled<packs>(lanes_); ++p)
        part[j] = multiply_add(phi[j][p], u[p], part[j]);
    }
    Cubic sum;
    lanes_.sum(part[0], part[1], sum.c[0], sum.c[1]);
    lanes_.sum(part[2], part[3], sum.c[2], sum.c[3]);
    return sum;
  }
  /// The overlap in a cell that moved by `displacement`.
  RA2D_FUNCTION CellOverlap overlap(int cell, double theta, const Cubic& displacement) const {
    const Cubic moving = own(cell) + displacement;
    return {{moving + passing(cell, 0, theta), moving + passing(cell, 1, theta)}, 0.5 - theta};
  }
  /// The rough faces' part of the overlap at a place of a cell [m].
  RA2D_FUNCTION double face(int cell, double theta, double eta) const {
    return own(cell)(eta) + passing(cell, eta > 0.5 - theta ? 1 : 0, theta)(eta);
  }
  /// Slope of the resonator's face there [m/chi].
  RA2D_FUNCTION double rise(int cell, double theta, double eta) const {
    return passing(cell, eta > 0.5 - theta ? 1 : 0, theta).slope(eta);
  }
  /// The slider's face along the cell.
  KOKKOS_FORCEINLINE_FUNCTION Cubic own(int cell) const { return cubic(cell, 0); }
  /// A piece of the resonator's face, about the middle of the cell.
  KOKKOS_FORCEINLINE_FUNCTION Cubic passing(int cell, int side, double theta) const {
    return cubic(cell, 1 + side).about(theta + 0.5 - side);
  }
  KOKKOS_FORCEINLINE_FUNCTION CellFaces faces(int cell) const {
    return {cubic(cell, 0), {cubic(cell, 1), cubic(cell, 2)}};
  }
  /// Rows of all modes: CellRow.
  KOKKOS_FORCEINLINE_FUNCTION const double* shapes_of(int cell) const {
    return shapes_in(slot(cell));
  }
  /// Where an expanded cell stands in the caches.
  KOKKOS_FORCEINLINE_FUNCTION double* shapes_in(int slot) const {
    return caches_.node_shape + static_cast<std::int64_t>(slot) * (cell_rows * packs * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION double* face_in(int slot) const {
    return caches_.node_face + static_cast<std::int64_t>(slot) * cell_numbers;
  }

 private:
  Lanes lanes_;
  const Caches& caches_;
  const int* node_slot_;  // Marks

  KOKKOS_FORCEINLINE_FUNCTION int slot(int cell) const {
    return node_slot_ == nullptr ? cell : node_slot_[cell];
  }
  KOKKOS_FORCEINLINE_FUNCTION Real row(int cell, int m, int p) const {
    return lanes_.load(shapes_in(slot(cell)) + (m * packs + p) * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION Cubic cubic(int cell, int i) const {
    const double* c = face_in(slot(cell)) + 4 * i;
    return {{c[0], c[1], c[2], c[3]}};
  }
};

}  // namespace ra2d
