// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/check.hpp"
#include "kernels/contact/penalty.hpp"
#include "kernels/displacement.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// Sums over the nodes in contact at one state.
template <class Real>
struct ContactTotals {
  double force = 0;  // N
  // works of the imposed motion over one spacing of the slider's path [J/chi]
  double face_work = 0;       // sum of f_n times the rise of the resonator's face
  Real deflection_work{0.0};  // sum of f_n times the rise of its deflection; one part a lane
  int nodes = 0;              // in contact, listed in WorkSpace::contact_list
};

/// Expands one slider node over one window: the parts of its overlap and its modal force.
/// Overlap -g = face + theta rise + sum_k U_k phi_k(offset), with phi_k cubic in the offset; phi
/// holds both bodies' modes, so the modal force of a nodal force f is -f phi_k (paper, the line
/// under equation 6). A pure function of node and window: it gives the same bits whatever a
/// node is evaluated for.
template <class Lanes, int packs>
KOKKOS_INLINE_FUNCTION void expand_node(const Lanes& lanes, const SliderMotion& motion,
                                        const FaceTables& faces, const SliderShapes& slider,
                                        const PatchTables& patches, const Place& place, int node,
                                        double* shape, double* face) {
  using Real = typename Lanes::Real;
  RA2D_CHECK(node >= 0 && node < faces.nodes);
  const int at = place.base + node;
  Real c[4][packs];
  expand_modes<Lanes, packs>(lanes, patches, at / patches.nodes,
                             at + (place.part + 0.5) * motion.window_width, c);
  const std::int64_t row = slider.row;
  for (int k = 0; k < slider.modes; ++k)
    for (int p = 0; p < packs; ++p)
      c[0][p] = multiply_add(slider.shape[k * row + node],
                             lanes.load(slider.unit + (k * packs + p) * Lanes::width), c[0][p]);
  for (int m = 0; m < 4; ++m)
    for (int p = 0; p < packs; ++p) lanes.store(shape + (m * packs + p) * Lanes::width, c[m][p]);
  if (lanes.leader()) {
    face[0] = faces.height1[node] + faces.height2[at];
    face[1] = faces.height2[at + 1] - faces.height2[at];
  }
}

/// Contact detection and penalty contact force at single nodes, each one product over the modes.
template <class Lanes, int packs>
class NodeContact {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width;

 public:
  KOKKOS_FUNCTION NodeContact(const Lanes& lanes, const SliderMotion& motion,
                              const FaceTables& faces, const SliderShapes& slider,
                              const PatchTables& patches, const ContactTables& contact,
                              Marks& marks, Caches& caches, ContactList& contact_list)
      : lanes_{lanes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        patches_{patches},
        contact_{contact},
        marks_{marks},
        caches_{caches},
        contact_list_{contact_list} {}

  /// Expands the listed nodes that are not expanded for this window yet.
  KOKKOS_FUNCTION void expand(const Place& place, const int* nodes, int count) const {
    const std::int64_t window = place.window(motion_);
    for (int e = 0; e < count; ++e) {
      const int node = nodes[e];
      if (marks_.node_window[node] == window) continue;
      lanes_.sync();
      expand_node<Lanes, packs>(lanes_, motion_, faces_, slider_, patches_, place, node,
                                caches_.node_shape + node_offset(node),
                                caches_.node_face + 2 * node);
      if (lanes_.leader()) marks_.node_window[node] = window;
      lanes_.sync();
    }
  }
  /// psi of both bodies at an expanded node, and its change over a spacing of the slider's path.
  KOKKOS_FORCEINLINE_FUNCTION void shapes(int node, double offset, Real* phi, Real* slope) const {
    const double* c = caches_.node_shape + node_offset(node);
    const Real x(offset);
    for (int p = 0; p < packs; ++p) {
      const Real c3 = lanes_.load(c + width * (3 * packs + p));
      const Real c2 = multiply_add(c3, x, lanes_.load(c + width * (2 * packs + p)));
      const Real c1 = multiply_add(c2, x, lanes_.load(c + width * (packs + p)));
      phi[p] = multiply_add(c1, x, lanes_.load(c + width * p));
      slope[p] = multiply_add(multiply_add(c3, x, c2), x, c1);
    }
  }
  KOKKOS_FORCEINLINE_FUNCTION void shape(int node, double offset, Real* phi) const {
    const double* c = caches_.node_shape + node_offset(node);
    const Real x(offset);
    for (int p = 0; p < packs; ++p) {
      const Real c2 = multiply_add(lanes_.load(c + width * (3 * packs + p)), x,
                                   lanes_.load(c + width * (2 * packs + p)));
      const Real c1 = multiply_add(c2, x, lanes_.load(c + width * (packs + p)));
      phi[p] = multiply_add(c1, x, lanes_.load(c + width * p));
    }
  }
  /// Overlap -g of an expanded node whose shapes are phi [m].
  KOKKOS_FORCEINLINE_FUNCTION double overlap(int node, double theta, const Real* phi,
                                             const Real* u) const {
    Real product = phi[0] * u[0];
    for (int p = 1; p < packs; ++p) product = multiply_add(phi[p], u[p], product);
    return face(node, theta) + lanes_.sum(product);
  }
  /// The rough faces' part of the overlap of an expanded node [m].
  KOKKOS_FORCEINLINE_FUNCTION double face(int node, double theta) const {
    return Kokkos::fma(theta, rise(node), caches_.node_face[2 * node]);
  }
  /// Cubics of all modes at an expanded node over the window: (derivative, lane).
  KOKKOS_FORCEINLINE_FUNCTION const double* expanded(int node) const {
    return caches_.node_shape + node_offset(node);
  }
  /// Rise of the resonator's face to its next node [m].
  KOKKOS_FORCEINLINE_FUNCTION double rise(int node) const {
    return caches_.node_face[2 * node + 1];
  }

  /// Contact detection and contact force at a state: adds the modal contact force of the listed
  /// nodes (in ascending order, expanded for this window) to `force`, and lists those in contact.
  KOKKOS_FORCEINLINE_FUNCTION ContactTotals<Real> operator()(const Place& place, const Real* u,
                                                             const int* nodes, int count,
                                                             Real* force) const {
    const Penalty penalty{contact_.node_stiffness};
    ContactTotals<Real> totals;
    Real slope_force[packs];  // sum_n f_n dphi/dx
    for (int p = 0; p < packs; ++p) slope_force[p] = Real(0.0);
    for (int e = 0; e < count; ++e) {
      const int node = nodes[e];
      Real phi[packs], slope[packs];
      shapes(node, place.offset, phi, slope);
      const double over = overlap(node, place.theta, phi, u);
      if (!(over >= 0.0)) continue;

      const double f = penalty.force(over);
      for (int p = 0; p < packs; ++p) {
        force[p] = multiply_add(-f, phi[p], force[p]);
        slope_force[p] = multiply_add(f, slope[p], slope_force[p]);
      }
      totals.face_work = Kokkos::fma(f, rise(node), totals.face_work);
      totals.force += f;
      RA2D_CHECK(totals.nodes < faces_.nodes);
      if (lanes_.leader()) {
        contact_list_.nodes[totals.nodes] = node;
        contact_list_.forces[totals.nodes] = f;
      }
      ++totals.nodes;
    }
    if (totals.nodes > 0) {
      for (int p = 0; p < packs; ++p)
        totals.deflection_work = multiply_add(slope_force[p], u[p], totals.deflection_work);
      lanes_.sync();
    }
    return totals;
  }

 private:
  KOKKOS_FORCEINLINE_FUNCTION static std::int64_t node_offset(int node) {
    return static_cast<std::int64_t>(node) * (4 * packs * width);
  }

  Lanes lanes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const PatchTables& patches_;
  const ContactTables& contact_;
  Marks& marks_;
  Caches& caches_;
  ContactList& contact_list_;
};

}  // namespace ra2d
