// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/contact/cell_parts.hpp"
#include "kernels/contact/expanded_cells.hpp"
#include "kernels/contact/moving_cell.hpp"
#include "kernels/contact/penalty.hpp"
#include "kernels/displacement.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/shocks.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Sums over the nodes in contact at one state.
template <class Real>
struct ContactTotals {
  double force = 0;  // N
  // works of the imposed motion over one spacing of the slider's path [J/chi]
  double face_work = 0;       // sum of f_n times the rise of the resonator's face
  double energy = 0;          // J, of the springs; of smooth faces alone
  Real deflection_work{0.0};  // sum of f_n times the rise of its deflection; one part a lane
  int nodes = 0;              // in contact, listed in WorkSpace::contact_list
  ListedContact listed;       // at single nodes, for SteadyShocks
};

/// Expands one slider node over one window: the parts of its overlap and its modal force.
/// Overlap -g = face + theta rise + sum_k U_k phi_k(offset), with phi_k cubic in the offset; phi
/// holds both bodies' modes, so the modal force of a nodal force f is -f phi_k (paper, the line
/// under equation 6). A pure function of node and window: it gives the same bits whatever a
/// node is evaluated for.
template <class Lanes, int packs>
KOKKOS_INLINE_FUNCTION void expand_node(const Lanes& lanes, const FaceTables& faces,
                                        const SliderShapes& slider, const PatchTables& patches,
                                        const Place& place, int node, double* shape, double* face) {
  using Real = typename Lanes::Real;
  RA2D_CHECK(node >= 0 && node < faces.nodes);
  const RowTables& rows = faces.rows;
  // in an areal scene: its row, and where it stands in that
  const int j = rows.across == nullptr ? 0 : node / slider.row, i = node - j * slider.row;
  const int at = place.base + i;
  Real c[4][packs];
  expand_modes<Lanes, packs>(lanes, patches, at / patches.nodes, at + place.middle, c);
  const std::int64_t row = slider.row;
  for (int k = 0; k < slider.modes; ++k)
    for (int p = 0; p < filled<packs>(lanes); ++p)
      c[0][p] = multiply_add(slider.shape[k * row + i],
                             lanes.load(slider.unit + (k * packs + p) * Lanes::width), c[0][p]);
  if (rows.across != nullptr) [[unlikely]]
    for (int p = 0; p < filled<packs>(lanes); ++p) {
      const Real share =
          lanes.load(rows.across + (static_cast<std::int64_t>(j) * packs + p) * Lanes::width);
      for (int m = 0; m < 4; ++m) c[m][p] = share * c[m][p];
    }
  for (int m = 0; m < 4; ++m)
    for (int p = 0; p < filled<packs>(lanes); ++p)
      lanes.store(shape + (m * packs + p) * Lanes::width, c[m][p]);
  if (lanes.leader()) {
    const double* const h2 = faces.height2 + (place.base - rows.behind + node + j * rows.excess);
    face[0] = faces.height1[node] + h2[0];
    face[1] = h2[1] - h2[0];
  }
}

/// Contact detection and penalty contact force at single nodes, each one product over the modes, or
/// (smooth faces) in single cells.
template <class Lanes, int packs>
class NodeContact {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  RA2D_FUNCTION NodeContact(const Lanes& lanes, const SliderMotion& motion, const FaceTables& faces,
                            const SliderShapes& slider, const PatchTables& patches,
                            const ContactTables& contact, Marks& marks, const Caches& caches,
                            const ContactList& contact_list)
      : lanes_{lanes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        patches_{patches},
        contact_{contact},
        penalty_{contact.node_stiffness},
        marks_{marks},
        caches_{caches},
        contact_list_{contact_list},
        cells_{lanes, marks, caches},
        node_slot_{marks.node_slot} {}

  /// Expands the listed nodes that are not expanded for this window yet. False where areal scenes
  /// have no place for them all.
  RA2D_FUNCTION bool expand(const Place& place, const int* nodes, int count) const {
    const std::int64_t window = place.window(motion_);
    if (node_slot_ != nullptr) [[unlikely]]
      return expand_on_rows(place, window, nodes, count);
    for (int e = 0; e < count; ++e) {
      const int node = nodes[e];
      if (marks_.node_window[node] == window) continue;
      lanes_.sync();
      expand_in(node, place, node);
      if (lanes_.leader()) marks_.node_window[node] = window;
      lanes_.sync();
    }
    return true;
  }
  /// Areal scenes: whether what is expanded serves at this place.
  KOKKOS_FORCEINLINE_FUNCTION bool is_expanded(const Place& place) const {
    return marks_.slots_window == place.window(motion_);
  }
  /// psi of both bodies at an expanded node, and its change over a spacing of the slider's path.
  KOKKOS_FORCEINLINE_FUNCTION void shapes(int node, double offset, Real* phi, Real* slope) const {
    shapes_at(slot(node), offset, phi, slope);
  }
  KOKKOS_FORCEINLINE_FUNCTION void shape(int node, double offset, Real* phi) const {
    const double* c = caches_.node_shape + node_offset(node);
    const Real x(offset);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real c2 = multiply_add(lanes_.load(c + width * (3 * packs + p)), x,
                                   lanes_.load(c + width * (2 * packs + p)));
      const Real c1 = multiply_add(c2, x, lanes_.load(c + width * (packs + p)));
      phi[p] = multiply_add(c1, x, lanes_.load(c + width * p));
    }
  }
  /// Overlap -g of an expanded node whose shapes are phi [m].
  KOKKOS_FORCEINLINE_FUNCTION double overlap(int node, double theta, const Real* phi,
                                             const Real* u) const {
    return overlap_at(face(node, theta), phi, u);
  }
  /// The rough faces' part of the overlap of an expanded node [m].
  KOKKOS_FORCEINLINE_FUNCTION double face(int node, double theta) const {
    const int at = slot(node);
    return Kokkos::fma(theta, rise_at(at), height_at(at));
  }
  /// Cubics of all modes at an expanded node over the window: (derivative, lane).
  KOKKOS_FORCEINLINE_FUNCTION const double* expanded(int node) const {
    return caches_.node_shape + node_offset(node);
  }
  /// Rise of the resonator's face to its next node [m].
  KOKKOS_FORCEINLINE_FUNCTION double rise(int node) const { return rise_at(slot(node)); }

  /// Smooth faces: the largest overlap along an expanded cell at the displacements u [m].
  RA2D_FUNCTION double highest(int cell, const Place& place, const Real* u) const {
    Real phi[4][packs];
    cells_.shapes(cell, place.offset, phi);
    return cells_.overlap(cell, place.theta, cells_.displacement(phi, u)).highest();
  }
  /// Smooth faces: the overlap along an expanded cell at the displacements u, and its rate where
  /// these change by `rate` and the slider moves by `slide_rate` [chi].
  RA2D_FUNCTION MovingCell moving_cell(int cell, const Place& place, const Real* u,
                                       const Real* rate, double slide_rate) const {
    const Real x(place.offset);
    Real part[4], rising[4], slope[3];
    for (int j = 0; j < 4; ++j) part[j] = rising[j] = Real(0.0);
    for (int j = 0; j < 3; ++j) slope[j] = Real(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real phi[4], path[4];
      cells_.along(cell, x, p, phi, path);
      for (int j = 0; j < 4; ++j) {
        part[j] = multiply_add(phi[j], u[p], part[j]);
        rising[j] = multiply_add(phi[j], rate[p], rising[j]);
      }
      for (int j = 0; j < 3; ++j) slope[j] = multiply_add(path[j + 1], u[p], slope[j]);
    }
    Cubic displacement, modes;
    double d1, d2, d3, none;
    lanes_.sum(part[0], part[1], displacement.c[0], displacement.c[1]);
    lanes_.sum(part[2], part[3], displacement.c[2], displacement.c[3]);
    lanes_.sum(rising[0], rising[1], modes.c[0], modes.c[1]);
    lanes_.sum(rising[2], rising[3], modes.c[2], modes.c[3]);
    lanes_.sum(slope[0], slope[1], d1, d2);
    lanes_.sum(slope[2], Real(0.0), d3, none);
    const CellFaces faces = cells_.faces(cell);
    MovingCell moving;
    moving.knot = 0.5 - place.theta;
    moving.steepness = faces.steepness();
    for (int side = 0; side < 2; ++side) {
      const Cubic face = faces.passing[side].about(place.theta + 0.5 - side);
      moving.overlap[side] = faces.own + displacement + face;
      const double passing[4] = {d1 + face.c[1], 2.0 * (d2 + face.c[2]), 3.0 * (d3 + face.c[3]),
                                 0.0};
      for (int j = 0; j < 4; ++j)
        moving.rate[side].c[j] = Kokkos::fma(slide_rate, passing[j], modes.c[j]);
    }
    return moving;
  }

  /// Smooth faces: bound on the overlap along an expanded cell while the slider goes on by
  /// `travelled` [chi] in a time `time`: of all that it carries along, with the highest place of
  /// the resonator's face that comes by. `moving`: the cell at `place`; `curvature`: bound on the
  /// second derivative of the modes' displacement there [m per time^2].
  RA2D_FUNCTION double most_overlap(int cell, const Place& place, const MovingCell& moving,
                                    double slide_rate, double travelled, double time,
                                    double curvature) const {
    const CellFaces faces = cells_.faces(cell);
    const Cubic face = faces.passing[0].about(place.theta + 0.5);
    Cubic carried, rate;
    for (int j = 0; j < 4; ++j) {
      const double passing = j < 3 ? (j + 1.0) * face.c[j + 1] : 0.0;
      carried.c[j] = moving.overlap[0].c[j] - face.c[j];
      rate.c[j] = Kokkos::fma(-slide_rate, passing, moving.rate[0].c[j]);
    }
    const double top =
        Kokkos::max(highest_on(faces.passing[0], place.theta, 1.0).value,
                    highest_on(faces.passing[1], 0.0, place.theta + travelled).value);
    const double rise = time * Kokkos::fma(0.5 * curvature, time,
                                           Kokkos::max(0.0, highest_on(rate, -0.5, 0.5).value));
    return highest_on(carried, -0.5, 0.5).value + top + rise;
  }

  /// Smooth faces: sum_k x_k psi_k along an expanded cell.
  RA2D_FUNCTION Cubic along(int cell, const Place& place, const Real* x) const {
    const Real offset(place.offset);
    Real part[4];
    for (int j = 0; j < 4; ++j) part[j] = Real(0.0);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real phi[4], path[4];
      cells_.along(cell, offset, p, phi, path);
      for (int j = 0; j < 4; ++j) part[j] = multiply_add(phi[j], x[p], part[j]);
    }
    Cubic sum;
    lanes_.sum(part[0], part[1], sum.c[0], sum.c[1]);
    lanes_.sum(part[2], part[3], sum.c[2], sum.c[3]);
    return sum;
  }
  /// Contact detection and contact force at a state: adds the modal contact force of the listed
  /// nodes (in ascending order, expanded for this window) to `force`. Lists those in contact, if it
  /// is to be recorded.
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals<Real> operator()(const Place& place, const Real* u,
                                                             const int* nodes, int count,
                                                             Real* force,
                                                             bool recorded = true) const {
    if (faces_.smooth) [[unlikely]]
      return in_cells(place, u, nodes, count, force, recorded);
    if (count == 0) return {};
    return at_nodes<true>(place, u, nodes, count, force, recorded && lanes_.leader(), ~0u);
  }
  /// As above for one node or more of a plane scene with rough faces; neither lists nor counts
  /// those in contact. `second`: see ListedContact.
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals<Real> unlisted(const Place& place, const Real* u,
                                                           const int* nodes, int count, Real* force,
                                                           std::uint32_t second) const {
    return at_nodes<false>(place, u, nodes, count, force, false, second);
  }

 private:
  template <bool lists>
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals<Real> at_nodes(const Place& place, const Real* u,
                                                           const int* nodes, int count, Real* force,
                                                           bool writes,
                                                           std::uint32_t second) const {
    ContactTotals<Real> totals;
    Real slope_force[packs];  // sum_n f_n dphi/dx
    for (int p = 0; p < filled<packs>(lanes_); ++p) slope_force[p] = Real(0.0);
    std::uint32_t bit = 1;
    int e = 0;
    do {
      const int node = nodes[e];
      const int at = lists ? slot(node) : node;
      Real phi[packs], slope[packs];
      shapes_at(at, place.offset, phi, slope);
      const double rise = rise_at(at);
      const double over = overlap_at(Kokkos::fma(place.theta, rise, height_at(at)), phi, u);
      if (over >= 0.0) {
        const double f = penalty_.pressing(over);
        for (int p = 0; p < filled<packs>(lanes_); ++p) {
          force[p] = multiply_add(-f, phi[p], force[p]);
          slope_force[p] = multiply_add(f, slope[p], slope_force[p]);
        }
        totals.face_work = Kokkos::fma(f, rise, totals.face_work);
        totals.force += f;
        totals.listed.add(bit, second, node, f);
        if constexpr (lists) {
          RA2D_CHECK(totals.nodes < faces_.nodes);
          if (writes) {
            contact_list_.nodes[totals.nodes] = node;
            contact_list_.forces[totals.nodes] = f;
          }
          ++totals.nodes;
        }
      }
      bit <<= 1;
    } while (++e < count);
    if (lists && totals.nodes == 0) return totals;
    for (int p = 0; p < filled<packs>(lanes_); ++p)
      totals.deflection_work = multiply_add(slope_force[p], u[p], totals.deflection_work);
    if constexpr (lists) lanes_.sync();
    return totals;
  }
  /// Contact between smooth faces, in the listed cells.
  RA2D_FUNCTION ContactTotals<Real> in_cells(const Place& place, const Real* u, const int* cells,
                                             int count, Real* force, bool recorded) const {
    ContactTotals<Real> totals;
    Real slope_force[packs];  // sum of the integrals of o dphi/dx
    for (int p = 0; p < filled<packs>(lanes_); ++p) slope_force[p] = Real(0.0);
    CellParts<Lanes> parts(lanes_, contact_list_.cell_parts);
    for (int e = 0; e < count;) {
      // as many cells as there is room for
      parts.clear();
      for (; e < count && parts.has_room(); ++e)
        parts.add_cell(cells[e], cells_.faces(cells[e]), place.theta, along(cells[e], place, u));
      if (parts.count() == 0) continue;
      parts.integrate();
      for (int part = 0; part < parts.count();) {
        const int cell = parts.cell(part);
        CellContact contact;
        for (; part < parts.count() && parts.cell(part) == cell; ++part)
          contact = contact + parts.integrals(part);
        if (contact.moment[0] > 0.0)
          add_cell(cell, place.offset, contact, force, slope_force, totals, recorded);
      }
      lanes_.sync();
    }
    if (totals.nodes > 0) {
      for (int p = 0; p < filled<packs>(lanes_); ++p)
        totals.deflection_work = multiply_add(slope_force[p], u[p], totals.deflection_work);
      lanes_.sync();
    }
    return totals;
  }
  KOKKOS_FORCEINLINE_FUNCTION void add_cell(int cell, double offset, const CellContact& contact,
                                            Real* force, Real* slope_force,
                                            ContactTotals<Real>& totals, bool recorded) const {
    const double spring = contact_.node_stiffness;  // of a whole cell
    const double* m = contact.moment;
    const double f0 = spring * m[0], f1 = spring * m[1], f2 = spring * m[2], f3 = spring * m[3];
    const Real x(offset);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      Real phi[4], path[4];
      cells_.along(cell, x, p, phi, path);
      Real sum = multiply_add(-f0, phi[0], force[p]);
      sum = multiply_add(-f1, phi[1], sum);
      sum = multiply_add(-f2, phi[2], sum);
      force[p] = multiply_add(-f3, phi[3], sum);
      sum = multiply_add(f0, path[1], slope_force[p]);
      sum = multiply_add(2.0 * f1, path[2], sum);
      slope_force[p] = multiply_add(3.0 * f2, path[3], sum);
    }
    totals.face_work = Kokkos::fma(spring, contact.face_work, totals.face_work);
    totals.energy = Kokkos::fma(0.5 * spring, contact.square, totals.energy);
    totals.force += f0;
    RA2D_CHECK(totals.nodes < faces_.nodes);
    if (recorded && lanes_.leader()) {
      contact_list_.nodes[totals.nodes] = cell;
      contact_list_.forces[totals.nodes] = f0;
      contact_list_.centres[totals.nodes] = along_row(faces_, cell) + 0.5 + m[1] / m[0];
    }
    ++totals.nodes;
  }

  /// Where an expanded node stands in the caches.
  KOKKOS_FORCEINLINE_FUNCTION int slot(int node) const {
    return node_slot_ == nullptr ? node : node_slot_[node];
  }
  KOKKOS_FORCEINLINE_FUNCTION static std::int64_t offset_of(int slot) {
    return static_cast<std::int64_t>(slot) * (4 * packs * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION std::int64_t node_offset(int node) const {
    return offset_of(slot(node));
  }
  KOKKOS_FORCEINLINE_FUNCTION void shapes_at(int slot, double offset, Real* phi,
                                             Real* slope) const {
    const double* c = caches_.node_shape + offset_of(slot);
    const Real x(offset);
    for (int p = 0; p < filled<packs>(lanes_); ++p) {
      const Real c3 = lanes_.load(c + width * (3 * packs + p));
      const Real c2 = multiply_add(c3, x, lanes_.load(c + width * (2 * packs + p)));
      const Real c1 = multiply_add(c2, x, lanes_.load(c + width * (packs + p)));
      phi[p] = multiply_add(c1, x, lanes_.load(c + width * p));
      slope[p] = multiply_add(multiply_add(c3, x, c2), x, c1);
    }
  }
  KOKKOS_FORCEINLINE_FUNCTION double overlap_at(double face, const Real* phi, const Real* u) const {
    Real product = phi[0] * u[0];
    for (int p = 1; p < filled<packs>(lanes_); ++p) product = multiply_add(phi[p], u[p], product);
    return face + lanes_.sum(product);
  }
  /// The faces' part of the overlap at the resonator's node before it.
  KOKKOS_FORCEINLINE_FUNCTION double height_at(int slot) const {
    return caches_.node_face[std::int64_t{2} * slot];
  }
  KOKKOS_FORCEINLINE_FUNCTION double rise_at(int slot) const {
    return caches_.node_face[std::int64_t{2} * slot + 1];
  }
  /// Expands a node or cell in this slot of the caches.
  RA2D_FUNCTION void expand_in(int slot, const Place& place, int node) const {
    if (faces_.smooth) [[unlikely]]
      expand_cell<Lanes, packs>(lanes_, faces_, slider_, patches_, place, node,
                                cells_.shapes_in(slot), cells_.face_in(slot));
    else
      expand_node<Lanes, packs>(lanes_, faces_, slider_, patches_, place, node,
                                caches_.node_shape + offset_of(slot), caches_.node_face + 2 * slot);
  }
  /// Areal scenes. All that is expanded is of one window.
  RA2D_FUNCTION bool expand_on_rows(const Place& place, std::int64_t window, const int* nodes,
                                    int count) const {
    int used = marks_.slots_window == window ? marks_.slots_used : 0;
    bool has_room = true;
    for (int e = 0; e < count; ++e) {
      const int node = nodes[e], at_slot = node_slot_[node];
      if (at_slot < used && marks_.slot_node[at_slot] == node) continue;
      if (used == marks_.slots) {
        has_room = false;
        break;
      }
      lanes_.sync();
      expand_in(used, place, node);
      if (lanes_.leader()) {
        node_slot_[node] = used;
        marks_.slot_node[used] = node;
      }
      ++used;
      lanes_.sync();
    }
    lanes_.sync();
    if (lanes_.leader()) {
      marks_.slots_used = used;
      marks_.slots_window = window;
    }
    lanes_.sync();
    return has_room;
  }

  Lanes lanes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  const ContactTables& contact_;
  const Penalty penalty_;
  Marks& marks_;
  // copies: they hold nothing but addresses
  const Caches caches_;
  const ContactList contact_list_;
  ExpandedCells<Lanes, packs> cells_;
  int* node_slot_;  // Marks
};

}  // namespace ra2d
