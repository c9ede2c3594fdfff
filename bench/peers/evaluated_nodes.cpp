// SPDX-License-Identifier: BSD-3-Clause
#include "bench/peers/evaluated_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace ra2d::peers {
namespace {

/// Longest path that a list is made for: with a longer one, more nodes are listed than left out.
constexpr int most_windows = 32;
/// Longest time that a list is made for, in periods of the fastest mode.
constexpr double periods = 2;

}  // namespace

EvaluatedNodes::EvaluatedNodes(ContactEquations& equations, Nodes nodes)
    : equations_{equations}, nodes_{nodes} {
  const double fastest = equations.modes() > 0 ? equations.omega.maxCoeff() : 0;
  horizon_ = fastest > 0 ? periods * 2 * std::numbers::pi / fastest : 1e-3;
  if (all()) {
    list_.resize(equations.nodes());
    std::iota(list_.begin(), list_.end(), 0);
    end_ = std::numeric_limits<double>::infinity();
  }
}

double EvaluatedNodes::rate_bound(const double* y) const {
  const Eigen::Map<const Eigen::ArrayXd> v(y + equations_.modes(), equations_.modes());
  return (equations_.largest * v.abs()).sum();
}

double EvaluatedNodes::moved(const double* y) const {
  const Eigen::Map<const Eigen::ArrayXd> u(y, equations_.modes());
  return (equations_.largest * (u - reference_).abs()).sum();
}

bool EvaluatedNodes::prepare(double t, const double* y, double time) {
  if (all()) return false;
  const double travel = 1.5 * time * rate_bound(y);
  if (t + time <= end_ && moved(y) + travel <= range_) return false;
  make(t, y, time, 2 * travel);
  return true;
}

bool EvaluatedNodes::covered(double t, const double* y, double t_end, const double* y_end) {
  if (all() || (t_end <= end_ && moved(y_end) <= range_)) return true;
  reference_ = Eigen::Map<const Eigen::ArrayXd>(y, equations_.modes());
  make(t, y, t_end - t, 2 * moved(y_end));
  return false;
}

void EvaluatedNodes::make(double t, const double* y, double time, double range) {
  const int modes = equations_.modes();
  const Eigen::Map<const Eigen::ArrayXd> u(y, modes), v(y + modes, modes);
  const double position = equations_.position(t), base = std::floor(position);
  const double rate = equations_.rate();
  double lasting = std::max(horizon_, time);
  int windows = 1;
  end_ = std::numeric_limits<double>::infinity();
  if (rate > 0) {
    // at least those of the time that was asked for, and one more for its roundings
    const double needed = std::floor((position - base) + time * rate) + 2;
    const double wanted =
        std::min<double>(std::ceil((position - base) + lasting * rate), most_windows);
    windows = static_cast<int>(std::max(needed, wanted));
    end_ = equations_.time_at(static_cast<std::int64_t>(base) + windows);
    lasting = std::min(lasting, end_ - t);
  }
  // what the modes do on their own in that time, and as much again for the contact forces
  const Eigen::ArrayXd energy_norm = (v.square() + (equations_.omega * u).square()).sqrt();
  const Eigen::ArrayXd most = energy_norm * (2 / equations_.omega).min(lasting);
  range_ = std::max({1.25 * (equations_.largest * most).sum(), range, 1e-4 * equations_.roughness});
  reference_ = u;
  const double rise = windows * equations_.spacing * (equations_.steepest * u.abs()).sum();
  equations_.list_above(t, static_cast<std::int64_t>(base), windows, y, -(range_ + rise), list_);
}

}  // namespace ra2d::peers
