// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/quadrature.hpp"

#include <algorithm>
#include <cmath>

namespace ra2d {
namespace {

/// Appends a panel.
void add_panel(double low, double high, const Points& rule, Points& points) {
  const double middle = (low + high) / 2, half = (high - low) / 2;
  for (std::size_t i = 0; i < rule.size(); ++i) {
    points.at.push_back(middle + half * rule.at[i]);
    points.weight.push_back(half * rule.weight[i]);
  }
}

/// Halves a panel until it is short against its distance from the pole.
void add_halved(double low, double high, const Pole& pole, double near, const Points& rule,
                Points& points) {
  const double along = std::max({low - pole.at, pole.at - high, 0.0});
  const double distance = std::hypot(along, pole.distance);
  const double middle = (low + high) / 2;
  if (high - low <= 2 * near * distance || !(low < middle && middle < high)) {
    add_panel(low, high, rule, points);
    return;
  }
  add_halved(low, middle, pole, near, rule, points);
  add_halved(middle, high, pole, near, rule, points);
}

template <class Add>
void each_panel(double low, double high, double turning, double phase, Add add) {
  const double least = std::ceil((high - low) * turning / (2 * phase));
  const auto panels = static_cast<std::size_t>(std::max(1.0, least));
  const double width = (high - low) / static_cast<double>(panels);
  for (std::size_t i = 0; i < panels; ++i) {
    const double begin = low + static_cast<double>(i) * width;
    add(begin, i + 1 == panels ? high : begin + width);
  }
}

}  // namespace

namespace {

Points find_gauss_rule(int points) {
  Points rule;
  rule.at.resize(static_cast<std::size_t>(points));
  rule.weight.resize(rule.at.size());
  for (int i = 0; i < points; ++i) {
    double x = std::cos(M_PI * (i + 0.75) / (points + 0.5)), slope = 0;
    for (int step = 0; step < 8; ++step) {  // Newton
      double before = 1, here = x;
      for (int n = 2; n <= points; ++n) {
        const double next = ((2 * n - 1) * x * here - (n - 1) * before) / n;
        before = here;
        here = next;
      }
      slope = points * (x * here - before) / (x * x - 1);
      x -= here / slope;
    }
    const auto place = static_cast<std::size_t>(points - 1 - i);
    rule.at[place] = x;
    rule.weight[place] = 2 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

}  // namespace

const Points& gauss_rule(int points) {
  static const std::vector<Points> rules = [] {
    std::vector<Points> found;
    for (int n = 1; n <= most_points_of_rule; ++n) found.push_back(find_gauss_rule(n));
    return found;
  }();
  return rules.at(static_cast<std::size_t>(points - 1));
}

Points graded_points(double low, double high, double turning, const Pole& pole,
                     const Fineness& fineness) {
  const Points& rule = gauss_rule(fineness.points);
  Points points;
  each_panel(low, high, turning, fineness.phase, [&](double begin, double end) {
    add_halved(begin, end, pole, fineness.near, rule, points);
  });
  return points;
}

Points even_points(double low, double high, double turning, const Fineness& fineness) {
  const Points& rule = gauss_rule(fineness.points);
  Points points;
  each_panel(low, high, turning, fineness.phase,
             [&](double begin, double end) { add_panel(begin, end, rule, points); });
  return points;
}

Interpolation::Interpolation(double high, double turning, const Fineness& fineness)
    : points_{even_points(0, high, 5 * turning, fineness)},
      panel_{high * fineness.points / static_cast<double>(points_.size())} {
  const Points& rule = gauss_rule(fineness.points);
  for (std::size_t i = 0; i < rule.size(); ++i) {
    const double size = std::sqrt((1 - rule.at[i] * rule.at[i]) * rule.weight[i]);
    barycentric_.push_back(i % 2 == 0 ? size : -size);
  }
}

std::size_t Interpolation::weigh(double place, double* weights) const {
  const std::size_t panels = points_.size() / order();
  const auto panel =
      std::min(panels - 1, static_cast<std::size_t>(std::max(0.0, std::floor(place / panel_))));
  const std::size_t first = panel * order();
  double sum = 0;
  for (std::size_t i = 0; i < order(); ++i) {
    const double apart = place - points_.at[first + i];
    if (apart == 0) {
      std::fill_n(weights, order(), 0.0);
      weights[i] = 1;
      return first;
    }
    weights[i] = barycentric_[i] / apart;
    sum += weights[i];
  }
  for (std::size_t i = 0; i < order(); ++i) weights[i] /= sum;
  return first;
}

}  // namespace ra2d
