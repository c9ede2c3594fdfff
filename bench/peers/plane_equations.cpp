// SPDX-License-Identifier: BSD-3-Clause
#include "bench/peers/plane_equations.hpp"

#include <algorithm>
#include <cmath>

namespace ra2d::peers {
namespace {

using Eigen::Index;

/// The waves that these equations are made of are those of beams.
std::vector<BeamShape> beam_shapes(const Body& body) {
  std::vector<BeamShape> shapes;
  for (const BodyMode& mode : body.modes) shapes.push_back(beam_shape(mode));
  return shapes;
}

/// Columns that start on a cache line.
Index padded(Index rows) { return (rows + 7) / 8 * 8; }

}  // namespace

PlaneEquations::PlaneEquations(const Model& model)
    : ContactEquations{model},
      shapes_{beam_shapes(model.resonator)},
      length_{model.resonator.length} {
  for (const BeamShape& mode : shapes_) hyperbolic_ += mode.left != 0 || mode.right != 0;
  const Index waves = modes2_ + hyperbolic_;
  kappa_.resize(waves);
  for (Index w = 0; w < modes2_; ++w) kappa_[w] = -shapes_[w].beta * shapes_[w].beta;
  kappa_.tail(hyperbolic_) = -kappa_.segment(modes2_ - hyperbolic_, hyperbolic_);
  const double widest = waves > 0 ? kappa_.abs().maxCoeff() * spacing * spacing : 0;
  for (double left_out = widest / 2; left_out > 1e-17;
       left_out *= widest / ((2 * terms_ + 1) * (2 * terms_ + 2)), ++terms_) {
  }

  const int count = model.nodes();
  half_ = (count + 1) / 2;
  half_length_ = 0.5 * (count - 1) * spacing;
  even_ = odd_ = Eigen::MatrixXd::Zero(padded(half_), waves + modes1_);
  for (Index i = 0; i < half_; ++i) {
    const double d = (static_cast<double>(i) + (count % 2 == 0 ? 0.5 : 0)) * spacing;
    for (Index w = 0; w < waves; ++w) {
      const double beta = std::sqrt(std::abs(kappa_[w]));
      if (kappa_[w] <= 0) {
        even_(i, w) = std::cos(beta * d);
        odd_(i, w) = beta > 0 ? std::sin(beta * d) / beta : d;
      } else {  // times exp(-beta reach), which locate() makes up for: nothing overflows
        const double rising = std::exp(beta * (d - half_length_));
        const double falling = std::exp(-beta * (d + half_length_));
        even_(i, w) = 0.5 * (rising + falling);
        odd_(i, w) = 0.5 * (rising - falling) / beta;
      }
    }
    for (Index m = 0; m < modes1_; ++m) {
      const BodyMode& mode = model.slider.modes[m];
      const double right = shape_at(mode, static_cast<double>(count / 2 + i) * spacing);
      const double left = shape_at(mode, static_cast<double>((count - 1) / 2 - i) * spacing);
      even_(i, waves + m) = 0.5 * (right + left);
      odd_(i, waves + m) = 0.5 * (right - left);
    }
  }

  height1_ = Eigen::Map<const Eigen::ArrayXd>(model.slider_height.data(), count) - model.delta;
  const Index nodes2 = static_cast<Index>(model.resonator_height.size());
  height2_.resize(nodes2 + count + 1);
  height2_.head(nodes2) = Eigen::Map<const Eigen::ArrayXd>(model.resonator_height.data(), nodes2);
  height2_.tail(count + 1) = model.resonator_height.back();
  face_rate =
      rate_ *
      (height2_.tail(height2_.size() - 1) - height2_.head(height2_.size() - 1)).abs().maxCoeff();

  place_.value = place_.slope = place_.cosine = place_.sine = Eigen::ArrayXd::Zero(waves);
  place_.value_there = place_.slope_there = place_.value;
  even_u_ = odd_u_ = Eigen::VectorXd::Zero(waves + modes1_);
  sum_even_ = sum_odd_ = Eigen::VectorXd::Zero(even_.rows());
  u_waves_ = v_waves_ = Eigen::ArrayXd::Zero(waves);
  with_value_ = with_slope_ = Eigen::VectorXd::Zero(waves);
}

PlaneEquations::Half PlaneEquations::half_of(int node) const {
  const Index middle = nodes() / 2;
  return node >= middle ? Half{node - middle, 1.0} : Half{(nodes() - 1) / 2 - node, -1.0};
}

void PlaneEquations::locate(Place& place) const {
  const double x = static_cast<double>(place.base) * spacing + half_length_;
  for (Index w = 0; w < kappa_.size(); ++w) {
    const BeamShape& mode = shapes_[w < modes2_ ? w : w - hyperbolic_];
    const double beta = mode.beta;
    if (kappa_[w] > 0) {
      const double left = mode.left * std::exp(-beta * (x - half_length_));
      const double right = mode.right * std::exp(-beta * (length_ - x - half_length_));
      place.value[w] = left + right;
      place.slope[w] = beta * (right - left);
    } else if (beta > 0) {
      const double sine = std::sin(beta * x), cosine = std::cos(beta * x);
      place.value[w] = mode.sine * sine + mode.cosine * cosine;
      place.slope[w] = beta * (mode.sine * cosine - mode.cosine * sine);
    } else {
      place.value[w] = mode.constant + mode.slope * x;
      place.slope[w] = mode.slope;
    }
  }
}

const Place& PlaneEquations::place(double t) {
  const double at = position(t);
  const double within = at - static_cast<double>(place_.base);
  const bool same = within >= 0 && within <= 1;
  return place(t, same ? place_.base : static_cast<std::int64_t>(std::floor(at)));
}

const Place& PlaneEquations::place(double t, std::int64_t base) {
  const bool same = base == place_.base;
  if (same && t == place_.time) return place_;
  place_.base = base;
  place_.time = t;
  if (!same) locate(place_);
  // rounded by its own size, not by the position's
  place_.theta = std::fma(t, rate_, position_ - static_cast<double>(base)) + lag * rate_;
  const double d = place_.theta * spacing;
  // c = sum (kappa d^2)^j/(2j)!, s = d sum (kappa d^2)^j/(2j + 1)!, by Horner
  const Index waves = kappa_.size();
  double *cosine = place_.cosine.data(), *sine = place_.sine.data();
  const double square = d * d;
  for (Index w = 0; w < waves; ++w) cosine[w] = sine[w] = 1;
  for (int j = terms_; j > 0; --j) {
    const double even = square / ((2 * j - 1) * (2 * j)), odd = square / (2 * j * (2 * j + 1));
    for (Index w = 0; w < waves; ++w) {
      cosine[w] = 1 + even * kappa_[w] * cosine[w];
      sine[w] = 1 + odd * kappa_[w] * sine[w];
    }
  }
  for (Index w = 0; w < waves; ++w) {
    sine[w] *= d;
    place_.value_there[w] = place_.value[w] * cosine[w] + place_.slope[w] * sine[w];
    place_.slope_there[w] = place_.slope[w] * cosine[w] + kappa_[w] * place_.value[w] * sine[w];
  }
  return place_;
}

void PlaneEquations::spread(const double* modes, Eigen::ArrayXd& waves) const {
  waves.head(modes2_) = Eigen::Map<const Eigen::ArrayXd>(modes, modes2_);
  if (hyperbolic_ > 0)
    waves.tail(hyperbolic_) =
        Eigen::Map<const Eigen::ArrayXd>(modes + modes2_ - hyperbolic_, hyperbolic_);
}

void PlaneEquations::displace(const Place& place, const double* u) {
  ++displacement_sums;
  const Index waves = kappa_.size();
  spread(u, u_waves_);
  even_u_.head(waves) = place.value_there * u_waves_;
  odd_u_.head(waves) = place.slope_there * u_waves_;
  const Eigen::Map<const Eigen::VectorXd> u1(u + modes2_, modes1_);
  even_u_.tail(modes1_) = u1;
  odd_u_.tail(modes1_) = u1;
  sum_even_.noalias() = even_ * even_u_;
  sum_odd_.noalias() = odd_ * odd_u_;
}

void PlaneEquations::overlaps(const Place& place, const double* u, Eigen::ArrayXd& out) {
  displace(place, u);
  const Index count = nodes(), other = count - half_;
  const double theta = place.theta;
  out.resize(count);
  const auto left = height2_.segment(place.base, count);
  const auto right = height2_.segment(place.base + 1, count);
  out.tail(half_) = sum_even_.head(half_).array() + sum_odd_.head(half_).array();
  out.head(other) = (sum_even_.segment(half_ - other, other).array() -
                     sum_odd_.segment(half_ - other, other).array())
                        .reverse();
  out += height1_ + (1 - theta) * left + theta * right;
}

void PlaneEquations::list_above(double t, std::int64_t base, int windows, const double* u,
                                double level, std::vector<int>& out) {
  displace(place(t, base), u);
  const Index count = nodes(), other = count - half_;
  Eigen::ArrayXd& highest = overlap_;
  highest = height2_.segment(base, count);
  for (int i = 1; i <= windows; ++i) {
    // beyond the resonator's end its last height repeats, as often as there are slider nodes
    const Index from = std::min<Index>(base + i, height2_.size() - count);
    highest = highest.max(height2_.segment(from, count));
  }
  highest += height1_;
  highest.tail(half_) += sum_even_.head(half_).array() + sum_odd_.head(half_).array();
  highest.head(other) += (sum_even_.segment(half_ - other, other).array() -
                          sum_odd_.segment(half_ - other, other).array())
                             .reverse();
  out.resize(count);
  std::size_t listed = 0;
  for (Index n = 0; n < count; ++n) {
    out[listed] = static_cast<int>(n);
    listed += highest[n] >= level;
  }
  out.resize(listed);
}

void PlaneEquations::evaluate_only(const std::vector<int>& nodes) {
  evaluates_all_ = false;
  evaluated_.list = nodes;
  evaluated_.base = nowhere;
}

void PlaneEquations::contact(double t, const double* u, double* force) {
  if (evaluates_all_) {
    const Place& here = place(t);
    overlaps(here, u, overlap_);
    // listed first: a loop that does nothing else is the faster one
    touching_.resize(overlap_.size());
    int count = 0;
    for (Index n = 0; n < overlap_.size(); ++n) {
      touching_[count] = static_cast<int>(n);
      count += overlap_[n] > 0;
    }
    for (int i = 0; i < count; ++i)
      project(here, touching_[i], node_stiffness * overlap_[touching_[i]], force);
  } else if (!evaluated_.list.empty()) {
    const Place& here = place(t);
    overlaps(here, evaluated_, u, some_);
    if (some_.maxCoeff() > 0) {
      some_ = node_stiffness * some_.cwiseMax(0.0);
      project(here, evaluated_, some_, force);
    }
  }
}

void PlaneEquations::project(const Place& place, int node, double node_force, double* force) {
  const auto [row, side] = half_of(node);
  const Index waves = kappa_.size();
  const auto even = even_.row(row).transpose().array(), odd = odd_.row(row).transpose().array();
  u_waves_ = place.value_there * even.head(waves) + side * place.slope_there * odd.head(waves);
  Eigen::Map<Eigen::ArrayXd> f2(force, modes2_), f1(force + modes2_, modes1_);
  f2 -= node_force * u_waves_.head(modes2_);
  f2.tail(hyperbolic_) -= node_force * u_waves_.tail(hyperbolic_);
  f1 -= node_force * (even.tail(modes1_) + side * odd.tail(modes1_));
}

void PlaneEquations::prepare(const Place& place, SomeNodes& nodes) const {
  const Index count = static_cast<Index>(nodes.list.size()), waves = kappa_.size();
  if (nodes.base == place.base && nodes.height.size() == count) return;
  nodes.base = place.base;
  nodes.value.resize(count, waves);
  nodes.slope.resize(count, waves);
  nodes.slider.resize(count, modes1_);
  nodes.height.resize(count);
  nodes.rise.resize(count);
  for (Index i = 0; i < count; ++i) {
    const int node = nodes.list[i];
    const auto [row, side] = half_of(node);
    for (Index w = 0; w < waves; ++w) {
      const double even = even_(row, w), odd = side * odd_(row, w);
      nodes.value(i, w) = place.value[w] * even + place.slope[w] * odd;
      nodes.slope(i, w) = place.slope[w] * even + kappa_[w] * place.value[w] * odd;
    }
    for (Index m = 0; m < modes1_; ++m)
      nodes.slider(i, m) = even_(row, waves + m) + side * odd_(row, waves + m);
    nodes.height[i] = height1_[node] + height2_[place.base + node];
    nodes.rise[i] = height2_[place.base + node + 1] - height2_[place.base + node];
  }
}

void PlaneEquations::overlaps(const Place& place, SomeNodes& nodes, const double* u,
                              Eigen::VectorXd& out) {
  prepare(place, nodes);
  spread(u, u_waves_);
  with_value_ = place.cosine * u_waves_;
  with_slope_ = place.sine * u_waves_;
  const Eigen::Map<const Eigen::VectorXd> u1(u + modes2_, modes1_);
  const Index count = nodes.height.size();
  out.resize(count);
  for (Index i = 0; i < count; ++i)
    out[i] = nodes.height[i] + place.theta * nodes.rise[i] + nodes.value.row(i).dot(with_value_) +
             nodes.slope.row(i).dot(with_slope_) + nodes.slider.row(i).dot(u1);
}

void PlaneEquations::rates(const Place& place, SomeNodes& nodes, const double* u, const double* v,
                           Eigen::VectorXd& out) {
  prepare(place, nodes);
  spread(u, u_waves_);
  spread(v, v_waves_);
  with_value_ = place.cosine * v_waves_ + speed * kappa_ * place.sine * u_waves_;
  with_slope_ = place.sine * v_waves_ + speed * place.cosine * u_waves_;
  const Eigen::Map<const Eigen::VectorXd> v1(v + modes2_, modes1_);
  const Index count = nodes.height.size();
  out.resize(count);
  for (Index i = 0; i < count; ++i)
    out[i] = rate_ * nodes.rise[i] + nodes.value.row(i).dot(with_value_) +
             nodes.slope.row(i).dot(with_slope_) + nodes.slider.row(i).dot(v1);
}

void PlaneEquations::project(const Place& place, SomeNodes& nodes,
                             const Eigen::VectorXd& node_force, double* force) {
  prepare(place, nodes);
  with_value_.setZero();
  with_slope_.setZero();
  Eigen::Map<Eigen::VectorXd> f2(force, modes2_), f1(force + modes2_, modes1_);
  for (Index i = 0; i < node_force.size(); ++i) {
    with_value_ += node_force[i] * nodes.value.row(i).transpose();
    with_slope_ += node_force[i] * nodes.slope.row(i).transpose();
    f1 -= node_force[i] * nodes.slider.row(i).transpose();
  }
  u_waves_ = place.cosine * with_value_.array() + place.sine * with_slope_.array();
  f2 -= u_waves_.head(modes2_).matrix();
  f2.tail(hyperbolic_) -= u_waves_.tail(hyperbolic_).matrix();
}

void PlaneEquations::shapes(const Place& place, SomeNodes& nodes, Rows& out) const {
  prepare(place, nodes);
  const Index count = static_cast<Index>(nodes.list.size());
  out.resize(count, modes2_ + modes1_);
  const Rows waves = nodes.value * place.cosine.matrix().asDiagonal() +
                     nodes.slope * place.sine.matrix().asDiagonal();
  out.leftCols(modes2_) = waves.leftCols(modes2_);
  out.middleCols(modes2_ - hyperbolic_, hyperbolic_) += waves.rightCols(hyperbolic_);
  out.rightCols(modes1_) = nodes.slider;
}

void PlaneEquations::outer_force(double t, double* force) const {
  for (Index k = 0; k < load_.size(); ++k) force[k] = load_[k];
  for (const MovingForce& each : moving_) {
    const double x = each.start + each.speed * (t + lag);
    if (x < 0 || x > length_) continue;
    double psi;
    for (Index k = 0; k < modes2_; ++k) {
      shapes_[k].evaluate(x, 1, &psi);
      force[k] += each.force * psi;
    }
  }
}

std::vector<double> PlaneEquations::force_jumps() const {
  std::vector<double> out;
  for (const MovingForce& each : moving_)
    for (const double end : {0.0, length_})
      if (each.speed != 0 && (end - each.start) / each.speed > 0)
        out.push_back((end - each.start) / each.speed);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace ra2d::peers
