// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/footprint_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace ra2d {
namespace {

constexpr int highest_degree = highest_footprint_degree;
/// More would make large tables: of a path many times as long as the slider, places are longer.
constexpr int most_places = 256;
/// Of the sum of all shapes, what polynomials may leave out.
constexpr double bearable_share = 0.03;
/// Roundings of coefficients and sums, over a shape's size: far more than there can be.
constexpr double roundings = 0x1p-40;

using Coefficients = std::array<double, highest_degree + 1>;

/// Of the polynomial that goes through f(xi) at the zeros of T_n, n = degree + 1.
template <class Function>
Coefficients interpolate(int degree, const Function& f) {
  const int n = degree + 1;
  Coefficients c{};
  for (int i = 0; i < n; ++i) {
    const double angle = std::numbers::pi * (i + 0.5) / n, value = f(std::cos(angle));
    for (int a = 0; a < n; ++a) c[a] += (a == 0 ? 1.0 : 2.0) / n * std::cos(a * angle) * value;
  }
  return c;
}

/// Bound on what it leaves out of a function on [-1, 1] whose derivative of order n is at most
/// largest rate^n.
double left_out(int degree, double largest, double rate) {
  const int n = degree + 1;
  return largest * std::pow(rate, n) / (std::exp2(n - 1) * std::tgamma(n + 1.0));
}

/// The rectangle of nodes that are met from a place of the path on, and two spacings more: lists of
/// nodes hold for a little more than a spacing.
class Rectangle {
 public:
  Rectangle(const Model& model, const FootprintShape& shape, int place)
      : half_{0.5 * (model.row_nodes() - 1 + shape.nodes) + 2.0},
        spacing_{model.scene.spacing},
        middle_{(std::floor(model.position) + (place + 0.5) * shape.nodes +
                 0.5 * (model.row_nodes() - 1)) *
                spacing_},
        half_across_{0.5 * (model.eta(model.rows - 1) - model.eta(0))},
        middle_across_{model.side + model.eta(0) + half_across_} {}

  double half() const { return half_ * spacing_; }
  double half_across() const { return half_across_; }
  double x(double xi) const { return middle_ + xi * half(); }
  double y(double eta) const { return middle_across_ + eta * half_across_; }
  /// How far it reaches beyond an end of the body.
  double beyond(double length) const {
    return std::max({0.0, middle_ + half() - length, half() - middle_});
  }

 private:
  double half_, spacing_, middle_, half_across_, middle_across_;  // half_: nodes
};

Coefficients along(const ModeShape& mode, int degree, const Rectangle& at) {
  return interpolate(degree, [&](double xi) {
    double psi;
    mode.evaluate(at.x(xi), 1, &psi);
    return psi;
  });
}
Coefficients across(const ModeShape& mode, int degree, const Rectangle& at) {
  return interpolate(degree, [&](double eta) {
    double psi;
    mode.evaluate_across(at.y(eta), 1, &psi);
    return psi;
  });
}

/// Bound on what the polynomials leave out of a mode of the resonator, at all places: of the
/// product of psi(x) and across(y), the remainders of both and the terms of a higher degree.
double remainder(const Model& model, const FootprintShape& shape, const ModeShape& mode) {
  const Coefficients b = across(mode, shape.degree, Rectangle(model, shape, 0));
  double most = 0;
  for (int place = 0; place < shape.places; ++place) {
    const Rectangle at(model, shape, place);
    const double largest = mode.size() * mode.growth(at.beyond(model.resonator.length));
    const double of_x = left_out(shape.degree, largest, mode.wave_number() * at.half()),
                 of_y = left_out(shape.degree, 1.0, mode.across_rate() * at.half_across());
    const Coefficients a = along(mode, shape.degree, at);
    double dropped = 0;
    for (int i = 0; i <= shape.degree; ++i)
      for (int j = shape.degree + 1 - i; j <= shape.degree; ++j) dropped += std::abs(a[i] * b[j]);
    most = std::max(most, of_x + (largest + of_x) * of_y + dropped + roundings * largest);
  }
  return most;
}

std::vector<double> remainders(const Model& model, const FootprintShape& shape) {
  std::vector<double> out;
  for (const BodyMode& mode : model.resonator.modes)
    out.push_back(remainder(model, shape, *mode.shape));
  return out;
}

/// The places along the path; the degree is still open.
FootprintShape on_path(const Model& model) {
  const double path =
      std::floor(model.position + model.advance * static_cast<double>(model.steps)) -
      std::floor(model.position);
  FootprintShape shape;
  shape.nodes = static_cast<int>(
      std::max({1.0, std::floor(model.row_nodes() / 4.0), std::ceil((path + 2) / most_places)}));
  shape.places = static_cast<int>(std::floor((path + 1) / shape.nodes)) + 1;
  return shape;
}

}  // namespace

int FootprintShape::terms() const {
  const int sums = degree == 0 ? 0 : (degree + 1) * (degree + 2) / 2;
  return (sums + footprint_side_by_side - 1) / footprint_side_by_side * footprint_side_by_side;
}

FootprintShape choose_footprint(const Model& model) {
  if (!model.is_areal) return {};
  FootprintShape shape = on_path(model);
  double all = 0;
  for (const BodyMode& mode : model.resonator.modes) all += mode.shape->size();
  for (shape.degree = 2; shape.degree <= highest_degree; ++shape.degree) {
    double left = 0;
    for (const double one : remainders(model, shape)) left += one;
    if (left <= bearable_share * all) return shape;
  }
  return {};
}

void fill_footprint(MotionLimits& bounds, const Model& model, const Extents& n,
                    const HostCopy& host) {
  FootprintTables& tables = bounds.footprint;
  FootprintShape shape = on_path(model);
  while (shape.terms() < n.footprint_terms) ++shape.degree;
  tables.degree = shape.degree;
  tables.terms = n.footprint_terms;
  tables.first = static_cast<int>(model.position);
  tables.nodes = shape.nodes;
  tables.places = n.footprint_places;
  tables.inverse_half = model.scene.spacing / Rectangle(model, shape, 0).half();
  double* const rows = host(tables.rows);
  std::fill_n(rows, static_cast<std::size_t>(n.footprint_places) * n.footprint_terms * n.lanes,
              0.0);
  double* const remainder = host(tables.remainder);
  double* const in_group = host(tables.remainder_in_group);
  double* const alike = host(tables.alike);
  std::fill_n(remainder, n.lanes, 0.0);
  std::fill_n(alike, n.lanes, 0.0);
  std::ranges::copy(remainders(model, shape), remainder);
  std::copy_n(remainder, n.lanes, in_group);
  double* const in_tile = host(bounds.tile_variation);
  for (std::size_t k = 0; k < model.resonator.modes.size(); ++k) in_tile[k] += remainder[k];
  for (std::size_t k = 0; k < model.slider.modes.size(); ++k) {
    const std::size_t lane = model.resonator.modes.size() + k;
    const ModeShape& mode = *model.slider.modes[k].shape;
    remainder[lane] = (1.0 + roundings) * mode.size();
    in_group[lane] =
        mode.largest_slope(0) * 0.5 * n.width * model.scene.spacing + roundings * mode.size();
    if (mode.change_rate() == 0 && mode.across_rate() == 0) mode.evaluate(0, 1, &alike[lane]);
  }
  for (std::size_t k = 0; k < model.resonator.modes.size(); ++k) {
    const ModeShape& mode = *model.resonator.modes[k].shape;
    const Coefficients b = across(mode, shape.degree, Rectangle(model, shape, 0));
    double* to = rows + k;
    for (int place = 0; place < n.footprint_places; ++place) {
      const Coefficients a = along(mode, shape.degree, Rectangle(model, shape, place));
      double* term = to;
      for (int sum = 0; sum <= shape.degree; ++sum)
        for (int j = 0; j <= sum; ++j, term += n.lanes) *term = a[sum - j] * b[j];
      to += static_cast<std::size_t>(n.footprint_terms) * n.lanes;
    }
  }
}

}  // namespace ra2d
