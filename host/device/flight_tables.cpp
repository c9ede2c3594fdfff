// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/flight_tables.hpp"

#include <Eigen/Core>
#include <cmath>

#include "host/device/gauss.hpp"
#include "kernels/schemes/exact.hpp"

namespace ra2d {
namespace {

/// The matrix that a flight of this step applies to (U - rest, V, 1).
Eigen::Matrix3d transition(const Mode& mode, double load, const ModeStep& step) {
  const bool falls = mode.omega == 0.0;  // the others ring about where the load holds them
  Eigen::Matrix3d m;
  m << 1.0 + step.u_u, step.u_v, falls ? step.u_f[0] * load : 0.0,  //
      step.v_u, step.v_v, falls ? step.v_f[0] * load : 0.0,         //
      0.0, 0.0, 1.0;
  return m;
}

}  // namespace

std::vector<std::array<double, flight_rows>> flight_tables(const Mode& mode, double load,
                                                           double tick, int first_level,
                                                           int levels) {
  double time = std::ldexp(tick, first_level);
  // the integral of V^2 as a quadratic form; over the first level by a Gauss rule that is far
  // beyond the roundings there, then doubled: all its parts are positive, so nothing cancels
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (int g = 0; g < gauss_points; ++g) {
    const Eigen::RowVector3d v =
        transition(mode, load, Exact::prepare(mode, gauss_place[g] * time)).row(1);
    square += gauss_weight[g] * std::ldexp(1.0, first_level) * v.transpose() * v;
  }
  std::vector<std::array<double, flight_rows>> rows(levels);
  for (int level = 0; level < levels; ++level, time *= 2.0) {
    const ModeStep step = Exact::prepare(mode, time);
    const Eigen::Matrix3d m = transition(mode, load, step);
    auto& row = rows[level];
    row[flight_u_u] = step.u_u;  // without the 1, whose rounding would be added at every leap
    row[flight_u_v] = m(0, 1);
    row[flight_u] = m(0, 2);
    row[flight_v_u] = m(1, 0);
    row[flight_v_v] = m(1, 1);
    row[flight_v] = m(1, 2);
    row[flight_s_uu] = square(0, 0);
    row[flight_s_uv] = 2.0 * square(0, 1);
    row[flight_s_vv] = square(1, 1);
    row[flight_s_v] = 2.0 * square(1, 2);
    row[flight_s] = square(2, 2);
    square += (m.transpose() * square * m).eval();
  }
  return rows;
}

}  // namespace ra2d
