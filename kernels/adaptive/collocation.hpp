// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/adaptive/pace.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/contact/cell_parts.hpp"
#include "kernels/contact/expanded_cells.hpp"
#include "kernels/function.hpp"
#include "kernels/lanes.hpp"
#include "kernels/place.hpp"
#include "kernels/state.hpp"
#include "kernels/tables.hpp"

namespace ra2d {

/// The motion of the modes at the points of a step between smooth faces (CollocationTables), at
/// which the equations of motion are to hold:
///
///   V_i = V_0 + T sum_j b_ij A_j,   U_i = U_0 + T sum_j b_ij V_j,   A = f/m - 2 zeta omega V -
///   omega^2 U.
///
/// Found by Picard's iteration: displacements from accelerations (move), accelerations from these
/// (accelerate). A sweep multiplies the error by some (omega T)^2 over a number that grows with
/// each, and takes all points at once: lanes hold points here, not modes, so that sums over the
/// modes need no exchange between lanes.
template <class Lanes, int packs>
class CollocationSweeps {
  using Real = typename Lanes::Real;
  static constexpr int width = Lanes::width, row = packs * width;
  static constexpr int pitch = padded_points(width), groups = pitch / width;
  static_assert(pitch % width == 0 && pitch <= point_row);

 public:
  RA2D_FUNCTION CollocationSweeps(const Lanes& lanes, const ModeTables& modes,
                                  const SliderMotion& motion, const FaceTables& faces,
                                  const SliderShapes& slider, const SeriesTables& adaptive,
                                  const ContactTables& contact,
                                  const CollocationTables& collocation,
                                  const ExpandedCells<Lanes, packs>& cells, double* cell_parts,
                                  PointBuffers& buffers)
      : lanes_{lanes},
        modes_{modes},
        motion_{motion},
        faces_{faces},
        slider_{slider},
        adaptive_{adaptive},
        contact_{contact},
        cells_{cells},
        parts_{lanes, cell_parts},
        buffers_{buffers},
        cells_share_{collocation.cells_share} {}

  /// Rows of all modes at the beginning.
  struct Beginning {
    const double *u, *v, *a;
    const double* jerk;  // the first three derivatives of the accelerations
  };
  /// A longer try of the same step, whose accelerations are still here; `share`: of its time that
  /// this one takes. Without a table: none.
  struct Earlier {
    const double* table;
    Pace pace;
    double share;
  };
  /// A step of `ticks` from `start` on, at the pace of `table`. The accelerations are first taken
  /// to be those of an earlier try, or to go on at their rate.
  RA2D_FUNCTION void begin(const double* table, double ticks, const Place& start,
                           const Beginning& now, const Earlier& earlier) {
    table_ = table;
    time_ = ticks * motion_.time_step;
    Real time[groups], velocity[groups], displacement[groups];
    for (int g = 0; g < groups; ++g) {
      const Real share = at_points(point_shares, g);
      const Real travelled = motion_.advance * ticks * share;
      theta_[g] = Real(start.theta) + travelled;
      offset_[g] = Real(start.offset) + travelled;
      time[g] = time_ * share;
      velocity[g] = time_ * at_points(velocity_columns, g);
      displacement[g] = time_ * time_ * at_points(displacement_columns, g);
    }
    const int modes = modes_.count;
    for (int m = 0; m < modes; ++m) {
      const Real u(now.u[m]), v(now.v[m]), a(now.a[m]), load(modes_.load[m]);
      for (int g = 0; g < groups; ++g) {
        store(buffers_.u_before, m, g,
              multiply_add(a, displacement[g], multiply_add(v, time[g], u)));
        store(buffers_.v_before, m, g, multiply_add(a, velocity[g], v));
        store(buffers_.force_at, m, g, load);
      }
    }
    if (earlier.table != nullptr)
      interpolate(earlier, now.a);
    else
      for (int m = 0; m < modes; ++m) {
        const Real a(now.a[m]), first(now.jerk[m]), second(0.5 * now.jerk[row + m]),
            third(1.0 / 6.0 * now.jerk[2 * row + m]);
        for (int g = 0; g < groups; ++g) {
          const Real rate = multiply_add(multiply_add(third, time[g], second), time[g], first);
          store(buffers_.a_at, m, g, multiply_add(rate, time[g], a));
        }
      }
    lanes_.sync();
  }
  /// Adds the moving forces: series of the modes, (power, lane), up to `order`, in units of `scale`
  /// [s].
  RA2D_FUNCTION void add_moving_forces(const double* series, int order, double scale) {
    for (int g = 0; g < groups; ++g) {
      const Real x = time_ / scale * at_points(point_shares, g);
      for (int m = 0; m < modes_.count; ++m) {
        Real f(series[order * row + m]);
        for (int j = order - 1; j >= 0; --j) f = multiply_add(f, x, Real(series[j * row + m]));
        store(buffers_.force_at, m, g, f + load(buffers_.force_at, m, g));
      }
    }
    lanes_.sync();
  }

  /// Displacements and velocities from the accelerations.
  RA2D_FUNCTION void move() const {
    for (int g = 0; g < groups; ++g) {
      Real velocity[last_point], displacement[last_point];
      for (int j = 0; j < last_point; ++j) {
        velocity[j] = time_ * at_points(velocity_columns + (j + 1) * point_row, g);
        displacement[j] = time_ * time_ * at_points(displacement_columns + (j + 1) * point_row, g);
      }
      const double* const a = buffers_.a_at;
      for (int m = 0, modes = modes_.count; m < modes; ++m) {
        Real u = load(buffers_.u_before, m, g), v = load(buffers_.v_before, m, g);
        for (int j = 0; j < last_point; ++j) {
          const Real a_j(a[m * pitch + j]);
          v = multiply_add(a_j, velocity[j], v);
          u = multiply_add(a_j, displacement[j], u);
        }
        store(buffers_.v_at, m, g, v);
        store(buffers_.u_at, m, g, u);
      }
    }
    lanes_.sync();
  }

  /// The accelerations' change by a sweep, and their size, as kinetic energies over the step [J]:
  /// the most of all points.
  struct Change {
    double by, size;
  };
  /// Accelerations from displacements and velocities, with contact in the listed cells. `again`: it
  /// is not the first sweep.
  RA2D_FUNCTION Change accelerate(const int* cells, int count, bool again) {
    for (int g = 0; g < groups; ++g) work_[g] = square_[g] = Real(0.0);
    contact_acts_ = false;
    springs_ = 0;
    for (int e = 0; e < count; ++springs_) {
      const Neighbours joint = neighbours(cells, e, count);
      add_contact(cells, joint, again);
      e = joint.end;
    }
    const double* const forces = contact_acts_ ? buffers_.contact_at : buffers_.force_at;
    Real by(0.0), size(0.0);
    for (int g = 0; g < groups; ++g)
      for (int m = 0, modes = modes_.count; m < modes; ++m) {
        const Real force = load(forces, m, g);
        const Real a = acceleration(m, g, force), change = a - load(buffers_.a_at, m, g);
        by = multiply_add(modes_.mass[m], change * change, by);
        size = multiply_add(modes_.mass[m], a * a, size);
        store(buffers_.a_at, m, g, a);
      }
    lanes_.sync();
    const double square = time_ * time_;
    return {square * lanes_.max(by), square * lanes_.max(size)};
  }

  /// Accelerations as accelerate() finds them, but with springs for contact: a force changes in
  /// proportion to the length of its contact and to the change of the displacement since then. That
  /// takes a quarter of the time, and comes nearly as far.
  RA2D_FUNCTION void accelerate_on_springs() {
    const double* const forces = contact_acts_ ? buffers_.contact_at : buffers_.force_at;
    Spring last;
    for (int i = 0; contact_acts_ && i < springs_; ++i) {
      const Spring spring = compressed(i);
      if (spring.shape == nullptr) continue;
      if (last.shape != nullptr) add_spring(last);
      last = spring;
    }
    const int modes = modes_.count;
    if (last.shape == nullptr)
      for (int m = 0; m < modes; ++m)
        for (int g = 0; g < groups; ++g)
          store(buffers_.a_at, m, g, acceleration(m, g, load(forces, m, g)));
    else
      for (int m = 0; m < modes; ++m) {
        const Real shape(-last.shape[m]);
        for (int g = 0; g < groups; ++g)
          store(buffers_.a_at, m, g,
                acceleration(m, g, multiply_add(shape, last.force[g], load(forces, m, g))));
      }
    lanes_.sync();
  }

  /// Takes those of the listed cells out of the list that carry no force anywhere in the step so
  /// far. Returns the number of those left.
  RA2D_FUNCTION int leave_out_open(int count) const {
    constexpr int points = 1 + pitch;
    lanes_.sync();
    if (lanes_.leader()) {
      int kept = 0;
      for (int e = 0; e < count; ++e) {
        double *const force = buffers_.force + e * points,
                      *const moment = buffers_.moment + e * points,
                      *const ends = buffers_.ends + e * (4 * pitch);
        bool closed = false;
        for (int i = 0; i <= last_point; ++i) closed = closed || force[i] > 0.0;
        if (!closed) continue;
        if (kept < e) {
          buffers_.cells[kept] = buffers_.cells[e];
          for (int i = 0; i < points; ++i) {
            buffers_.force[kept * points + i] = force[i];
            buffers_.moment[kept * points + i] = moment[i];
          }
          for (int i = 0; i < 4 * pitch; ++i) buffers_.ends[kept * (4 * pitch) + i] = ends[i];
        }
        ++kept;
      }
      buffers_.listed = kept;
    }
    lanes_.sync();
    return buffers_.listed;
  }

  KOKKOS_FORCEINLINE_FUNCTION CellFaces faces(int cell) const { return cells_.faces(cell); }
  /// Points from `first` to `last`; none where `last` < `first`.
  struct PointRange {
    int first, last;
  };
  /// Finds the largest overlap anywhere in a cell at each point but the first
  /// (PointBuffers::highest) [m]. Returns from which of these points to which it may come to
  /// `level` beside them, given a bound on its second derivative [m per x^2]: between two points it
  /// is at most the larger of both and interval^2/8 of that.
  RA2D_FUNCTION PointRange points_near(int cell, double second, double level) const {
    const CellFaces faces = cells_.faces(cell);
    PointRange near{1 + last_point, 0};
    Cubic passing[groups], own[groups];
    displacements(cell, passing, own);
    for (int g = 0; g < groups; ++g) {
      Real most(-1e300);
      Real moving[4];
      for (int j = 0; j < 4; ++j)
        moving[j] = (Real(faces.own.c[j]) + passing[g].c[j]) + own[g].c[j];
      const Real knot = Real(0.5) - theta_[g];
      for (int side = 0; side < 2; ++side) {
        Real piece[4], o[4];
        for (int j = 0; j < 4; ++j) piece[j] = Real(faces.passing[side].c[j]);
        shift_cubic(piece, theta_[g] + Real(0.5 - side), o);
        for (int j = 0; j < 4; ++j) o[j] = moving[j] + o[j];
        most = Kokkos::max(most, side == 0 ? highest_between(o, Real(-0.5), knot)
                                           : highest_between(o, knot, Real(0.5)));
      }
      lanes_.store(buffers_.highest + 1 + g * width, most);
      std::uint32_t over =
          lanes_.at_least(multiply_add(at_points(point_sags, g), Real(second), most), level);
      const int left = last_point - g * width;
      if (left < width) over &= (1u << left) - 1u;
      if (over == 0) continue;
      const int before = 1 + g * width;
      near.first =
          Kokkos::min(near.first, before + Kokkos::Experimental::countr_zero_builtin(over));
      near.last = before + Kokkos::Experimental::bit_width_builtin(over) - 1;
    }
    return near;
  }

  /// Writes velocities and accelerations of the points as rows of modes, their displacement at the
  /// end to `u_end`, and the powers.
  RA2D_FUNCTION void finish(double* u_end) const {
    lanes_.sync();
    if (lanes_.leader())
      for (int m = 0; m < modes_.count; ++m) {
        for (int i = 0; i < last_point; ++i) {
          buffers_.velocity[(i + 1) * row + m] = buffers_.v_at[m * pitch + i];
          buffers_.acceleration[(i + 1) * row + m] = buffers_.a_at[m * pitch + i];
        }
        u_end[m] = buffers_.u_at[m * pitch + last_point - 1];
      }
    for (int g = 0; g < groups; ++g) {
      Real moving(0.0);
      for (int m = 0; m < modes_.count; ++m)
        moving = multiply_add(load(buffers_.force_at, m, g) - Real(modes_.load[m]),
                              load(buffers_.v_at, m, g), moving);
      double* const power = buffers_.power + 1 + g * width;
      lanes_.store(power, motion_.advance / motion_.time_step * work_[g]);
      lanes_.store(power + 1 + pitch, moving);
      lanes_.store(buffers_.spring_energy + g * width,
                   Real(0.5 * contact_.node_stiffness) * square_[g]);
    }
    lanes_.sync();
  }

 private:
  Lanes lanes_;
  const ModeTables& modes_;
  const SliderMotion& motion_;
  const FaceTables& faces_;
  const SliderShapes& slider_;
  const SeriesTables& adaptive_;
  const ContactTables& contact_;
  ExpandedCells<Lanes, packs> cells_;
  CellParts<Lanes> parts_;
  PointBuffers& buffers_;
  bool cells_share_;
  const double* table_ = nullptr;
  double time_ = 0.0;
  Real theta_[groups], offset_[groups];
  Real work_[groups];    // J/chi, of the imposed motion over a spacing of the slider's path
  Real square_[groups];  // m^2, of the overlaps
  bool contact_acts_ = false;
  int springs_ = 0;

  KOKKOS_FORCEINLINE_FUNCTION Real at_points(int numbers, int g) const {
    return lanes_.load(table_ + numbers + g * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION Real load(const double* rows, int m, int g) const {
    return lanes_.load(rows + m * pitch + g * width);
  }
  KOKKOS_FORCEINLINE_FUNCTION void store(double* rows, int m, int g, const Real& x) const {
    lanes_.store(rows + m * pitch + g * width, x);
  }

  /// Accelerations at the points by the polynomials through those of an earlier try. `first`: at
  /// the beginning.
  RA2D_FUNCTION void interpolate(const Earlier& earlier, const double* first) const {
    Real weight[groups][collocation_points];
    for (int g = 0; g < groups; ++g) {
      const Real x = pace_x(earlier.pace, earlier.share * at_points(point_shares, g));
      Real before(1.0), after(1.0), sum(0.0);  // products of x less its places
      for (int j = 0; j < collocation_points; ++j) {
        weight[g][j] = before;
        before = before * (x - Real(earlier.table[point_places + j]));
      }
      for (int j = last_point; j >= 0; --j) {
        weight[g][j] = weight[g][j] * (Real(earlier.table[barycentric_weights + j]) * after);
        after = after * (x - Real(earlier.table[point_places + j]));
        sum = sum + weight[g][j];
      }
      const Real inverse = Real(1.0) / sum;
      for (int j = 0; j < collocation_points; ++j) weight[g][j] = inverse * weight[g][j];
    }
    for (int m = 0; m < modes_.count; ++m) {
      const double* const a = buffers_.a_at + m * pitch;
      Real there[groups];
      for (int g = 0; g < groups; ++g) {
        there[g] = weight[g][0] * Real(first[m]);
        for (int j = 1; j < collocation_points; ++j)
          there[g] = multiply_add(weight[g][j], Real(a[j - 1]), there[g]);
      }
      lanes_.sync();
      for (int g = 0; g < groups; ++g) store(buffers_.a_at, m, g, there[g]);
    }
  }

  KOKKOS_FORCEINLINE_FUNCTION Real acceleration(int m, int g, const Real& force) const {
    const Real omega(modes_.omega[m]);
    const Real held = multiply_add(Real(adaptive_.decay[m]), load(buffers_.v_at, m, g),
                                   omega * (omega * load(buffers_.u_at, m, g)));
    return multiply_add(Real(adaptive_.inverse_mass[m]), force, -held);
  }

  /// The integrals of contact in a cell, at each point, and its length.
  struct Contact {
    Real moment[4], square, face_work, length;
    bool any = false;
  };
  /// `moving`: the overlap but for the resonator's face. `ends`: where contact begins and ends, on
  /// each side of the resonator's node; as the sweep before left it, if there was one (`again`).
  KOKKOS_FORCEINLINE_FUNCTION Contact contact(const CellFaces& faces, const Real& theta,
                                              const Real* moving, double* ends, bool again) {
    Contact sum;
    sum.square = sum.face_work = sum.length = Real(0.0);
    for (int j = 0; j < 4; ++j) sum.moment[j] = Real(0.0);
    const Real knot = Real(0.5) - theta;
    for (int side = 0; side < 2; ++side) {
      const Real left = side == 0 ? Real(-0.5) : knot, right = side == 0 ? knot : Real(0.5);
      Real piece[4], face[4], o[4];
      for (int j = 0; j < 4; ++j) piece[j] = Real(faces.passing[side].c[j]);
      shift_cubic(piece, theta + Real(0.5 - side), face);
      for (int j = 0; j < 4; ++j) o[j] = moving[j] + face[j];
      Real at_left[4], at_right[4];
      shift_cubic(o, left, at_left);
      shift_cubic(o, right, at_right);
      double* const low = ends + side * 2 * pitch;
      const Real near = nearness(at_left, at_right);
      if (lanes_.at_least(near, 0.0) == 0) {
        lanes_.store(low, Real(0.0));
        lanes_.store(low + pitch, Real(0.0));
        continue;
      }
      typename CellParts<Lanes>::Integrals part;
      if (!again || !parts_.integrate_from(o, face, left, right, at_left, at_right, near,
                                           lanes_.load(low), lanes_.load(low + pitch), part))
        parts_.integrate(o, face, left, right, again ? parts_.roots_close : 0.1, part);
      lanes_.store(low, part.low);
      lanes_.store(low + pitch, part.high);
      for (int j = 0; j < 4; ++j) sum.moment[j] = sum.moment[j] + part.moment[j];
      sum.square = sum.square + part.square;
      sum.face_work = sum.face_work + part.face_work;
      sum.length = sum.length + (part.high - part.low);
      sum.any = true;
    }
    sum.any = sum.any && lanes_.at_least(sum.moment[0], 1e-300) != 0;
    return sum;
  }
  /// Negative where an overlap is plainly negative between two places: it is concave there, and
  /// from a negative end on it falls. Given the cubic about both.
  KOKKOS_FORCEINLINE_FUNCTION static Real nearness(const Real* at_left, const Real* at_right) {
    return Kokkos::max(
        Kokkos::max(at_left[2], at_right[2]),
        Kokkos::min(Kokkos::max(at_left[0], at_left[1]), Kokkos::max(at_right[0], -at_right[1])));
  }

  enum class Body { resonator, slider };
  /// The modes of a body, and the rows of their cubics in an expanded cell.
  struct Shapes {
    int first, end;
    const double *c0, *c1, *c2, *c3;
  };
  KOKKOS_FORCEINLINE_FUNCTION Shapes shapes(Body body, const double* rows) const {
    const bool passes = body == Body::resonator;
    const double* const c1 = rows + (passes ? cell_path + 1 : cell_slider) * row;
    return {passes ? 0 : slider_.first_lane,
            passes ? slider_.first_lane : modes_.count,
            rows,
            c1,
            c1 + row,
            c1 + 2 * row};
  }
  struct Cubic {
    Real c[4];
  };
  /// The displacement of a body, in its modes' own terms, at the points of each group.
  KOKKOS_FORCEINLINE_FUNCTION void sum_modes(Body body, const double* rows, Cubic* sum) const {
    const Shapes phi = shapes(body, rows);
    for (int g = 0; g < groups; ++g)
      for (int j = 0; j < 4; ++j) sum[g].c[j] = Real(0.0);
    for (int m = phi.first; m < phi.end; ++m) {
      const Real c0(phi.c0[m]), c1(phi.c1[m]), c2(phi.c2[m]), c3(phi.c3[m]);
      for (int g = 0; g < groups; ++g) {
        const Real u = load(buffers_.u_at, m, g);
        sum[g].c[0] = multiply_add(c0, u, sum[g].c[0]);
        sum[g].c[1] = multiply_add(c1, u, sum[g].c[1]);
        sum[g].c[2] = multiply_add(c2, u, sum[g].c[2]);
        sum[g].c[3] = multiply_add(c3, u, sum[g].c[3]);
      }
    }
  }
  /// Adds the modal forces of contact whose moments are f.
  KOKKOS_FORCEINLINE_FUNCTION void add_modal_forces(Body body, const double* rows,
                                                    const Cubic* f) const {
    const Shapes phi = shapes(body, rows);
    const double* const others = contact_acts_ ? buffers_.contact_at : buffers_.force_at;
    for (int m = phi.first; m < phi.end; ++m) {
      const Real c0(phi.c0[m]), c1(phi.c1[m]), c2(phi.c2[m]), c3(phi.c3[m]);
      for (int g = 0; g < groups; ++g) {
        const Real low = multiply_add(c0, f[g].c[0], c1 * f[g].c[1]),
                   high = multiply_add(c2, f[g].c[2], c3 * f[g].c[3]);
        store(buffers_.contact_at, m, g, load(others, m, g) - (low + high));
      }
    }
  }

  /// Displacements in an expanded cell at the points of each group: of the resonator, along its
  /// path, and of the slider.
  KOKKOS_FORCEINLINE_FUNCTION void displacements(int cell, Cubic* passing, Cubic* own) const {
    const double* const c = cells_.shapes_of(cell);
    Cubic along[groups];
    sum_modes(Body::resonator, c, along);
    sum_modes(Body::slider, c, own);
    for (int g = 0; g < groups; ++g) shift_cubic(along[g].c, offset_[g], passing[g].c);
  }

  /// Moments of f, of eta^j, as those of (x + eta)^j.
  KOKKOS_FORCEINLINE_FUNCTION static void shift_moments(const Real* f, const Real& x, Real* about) {
    about[0] = f[0];
    about[1] = multiply_add(x, f[0], f[1]);
    about[2] = multiply_add(x, f[1] + about[1], f[2]);
    about[3] = multiply_add(x, multiply_add(x, f[1] + f[1] + about[1], Real(3.0) * f[2]), f[3]);
  }

  /// Listed cells beside one another that share their sums over the modes: those of `cell`, whose
  /// shapes hold in the cells beside it, too, where CollocationTables says so.
  struct Neighbours {
    int first, end, cell;
  };
  KOKKOS_FORCEINLINE_FUNCTION Neighbours neighbours(const int* cells, int first, int count) const {
    int end = first + 1, cell = cells[first];
    if (cells_share_ && end < count && cells[end] == cell + 1) {
      cell = cells[end++];
      if (end < count && cells[end] == cell + 1) ++end;
    }
    return {first, end, cell};
  }

  /// Contact in these cells: adds its modal forces and its work, and keeps its spring.
  RA2D_FUNCTION void add_contact(const int* cells, const Neighbours& joint, bool again) {
    const double* const c = cells_.shapes_of(joint.cell);
    // displacements in the shapes' own terms: along the path, and along the slider
    Cubic d[groups], own[groups], on_path[groups], on_slider[groups];
    sum_modes(Body::resonator, c, d);
    sum_modes(Body::slider, c, own);
    bool any = false;
    for (int g = 0; g < groups; ++g)
      any |= add_contact(cells, joint, g, again, d[g].c, own[g].c, on_path[g].c, on_slider[g].c);
    if (!any) return;
    add_modal_forces(Body::resonator, c, on_path);
    add_modal_forces(Body::slider, c, on_slider);
    contact_acts_ = true;
  }
  /// At the points of a group, given the displacements in the cell whose shapes hold: its moments
  /// along the path and along the slider. Whether any force acts.
  KOKKOS_FORCEINLINE_FUNCTION bool add_contact(const int* cells, const Neighbours& joint, int g,
                                               bool again, const Real* d, const Real* own,
                                               Real* on_path, Real* on_slider) {
    const Real spring(contact_.node_stiffness);  // of a whole cell
    Real length(0.0);
    for (int j = 0; j < 4; ++j) on_path[j] = on_slider[j] = Real(0.0);
    bool any = false;
    for (int e = joint.first; e < joint.end; ++e) {
      const int cell = cells[e];
      const CellFaces faces = cells_.faces(cell);
      const Real away(static_cast<double>(cell - joint.cell)), x = offset_[g] + away;
      Real passing[4], moving[4];
      shift_cubic(d, x, passing);
      shift_cubic(own, away, moving);
      for (int j = 0; j < 4; ++j) moving[j] = (Real(faces.own.c[j]) + passing[j]) + moving[j];
      const Contact found =
          contact(faces, theta_[g], moving, buffers_.ends + e * (4 * pitch) + g * width, again);
      const int first = e * (1 + pitch) + 1 + g * width;
      double *const force = buffers_.force + first, *const moment = buffers_.moment + first;
      if (!found.any) {
        lanes_.store(force, Real(0.0));
        lanes_.store(moment, Real(0.0));
        continue;
      }
      any = true;
      Real f[4], moments[4];
      for (int j = 0; j < 4; ++j) f[j] = spring * found.moment[j];
      lanes_.store(force, f[0]);
      lanes_.store(moment, multiply_add(Real(along_row(faces_, cell) + 0.5), f[0], f[1]));
      length = length + found.length;
      square_[g] = square_[g] + found.square;
      work_[g] = multiply_add(spring, found.face_work, work_[g]);
      work_[g] = work_[g] + multiply_add(passing[1], f[0],
                                         multiply_add(Real(2.0) * passing[2], f[1],
                                                      Real(3.0) * passing[3] * f[2]));
      shift_moments(f, x, moments);
      for (int j = 0; j < 4; ++j) on_path[j] = on_path[j] + moments[j];
      shift_moments(f, away, moments);
      for (int j = 0; j < 4; ++j) on_slider[j] = on_slider[j] + moments[j];
    }
    keep_spring(joint.cell, spring * length, d[0] + own[0], g);
    return any;
  }

  /// Keeps a spring of contact: its stiffness [N/m] and the displacement in the middle of its cell.
  KOKKOS_FORCEINLINE_FUNCTION void keep_spring(int cell, const Real& stiffness,
                                               const Real& displacement, int g) const {
    double* const spring = buffers_.springs + springs_ * (2 * pitch) + g * width;
    lanes_.store(spring, stiffness);
    lanes_.store(spring + pitch, displacement);
    if (lanes_.leader()) buffers_.spring_cells[springs_] = cell;
  }
  /// The change of a spring's force, and the modes' shapes where it stands; null: it carries none.
  struct Spring {
    const double* shape = nullptr;
    Real force[groups];
  };
  KOKKOS_FORCEINLINE_FUNCTION Spring compressed(int i) const {
    const double* const spring = buffers_.springs + i * (2 * pitch);
    const double* const phi = cells_.shapes_of(buffers_.spring_cells[i]);
    Spring found;
    for (int g = 0; g < groups; ++g)
      if (lanes_.at_least(lanes_.load(spring + g * width), 1e-300) != 0) found.shape = phi;
    if (found.shape == nullptr) return found;
    Real even[groups], odd[groups];
    for (int g = 0; g < groups; ++g) even[g] = odd[g] = Real(0.0);
    int m = 0;
    for (const int modes = modes_.count - 1; m < modes; m += 2) {
      const Real here(phi[m]), next(phi[m + 1]);
      for (int g = 0; g < groups; ++g) {
        even[g] = multiply_add(here, load(buffers_.u_at, m, g), even[g]);
        odd[g] = multiply_add(next, load(buffers_.u_at, m + 1, g), odd[g]);
      }
    }
    for (int g = 0; g < groups; ++g) {
      if (m < modes_.count)
        even[g] = multiply_add(Real(phi[m]), load(buffers_.u_at, m, g), even[g]);
      const Real stiffness = lanes_.load(spring + g * width),
                 displacement = lanes_.load(spring + pitch + g * width);
      found.force[g] = stiffness * ((even[g] + odd[g]) - displacement);
    }
    return found;
  }
  KOKKOS_FORCEINLINE_FUNCTION void add_spring(const Spring& spring) const {
    for (int m = 0, modes = modes_.count; m < modes; ++m) {
      const Real shape(-spring.shape[m]);
      for (int g = 0; g < groups; ++g)
        store(buffers_.contact_at, m, g,
              multiply_add(shape, spring.force[g], load(buffers_.contact_at, m, g)));
    }
  }
};

}  // namespace ra2d
