// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/straight_line.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "host/analysis/distributions.hpp"
#include "host/analysis/means.hpp"
#include "host/base/decompositions.hpp"
#include "host/study/clusters.hpp"

namespace ra2d {
namespace {

using Place = std::vector<std::size_t>;

/// The logarithm of the amplitude, point by point and draw by draw, where every draw has every
/// point. A draw is mostly a seed.
struct Grid {
  std::vector<Place> points;  // values of the fitted dimensions
  Eigen::MatrixXd y;          // (point, seed)
  bool is_whole = true;       // no point is left out
};

Grid complete_grid(const StudyAnswers& answers, const std::vector<double>& amplitude,
                   const std::vector<std::size_t>& fitted, const Draws& draws) {
  struct Sum {
    double sum = 0;
    std::size_t count = 0;
  };
  const std::size_t seeds = draws.count;
  std::map<Place, std::vector<Sum>> points;
  std::size_t combinations = amplitude.size() / seeds;  // combinations that are averaged
  for (const std::size_t axis : fitted) combinations /= answers.axes[axis].size();
  for (std::size_t run = 0; run < amplitude.size(); ++run) {
    const double value = amplitude[run];
    const Place place = place_of_run(answers.axes, run);
    Place point;
    for (const std::size_t axis : fitted) point.push_back(place[axis]);
    std::vector<Sum>& sums = points.try_emplace(std::move(point), seeds).first->second;
    if (!(value > 0 && std::isfinite(value))) continue;
    Sum& sum = sums[draws.of_run[run]];
    sum.sum += std::log10(value) / static_cast<double>(combinations);
    ++sum.count;
  }
  const auto is_there = [&](const Sum& sum) { return sum.count == combinations; };
  const std::size_t left_out = std::erase_if(points, [&](const auto& point) {
    return 3 * std::count_if(point.second.begin(), point.second.end(), is_there) <
           2 * static_cast<std::ptrdiff_t>(seeds);
  });
  std::vector<std::size_t> complete;
  for (std::size_t seed = 0; seed < seeds; ++seed)
    if (std::all_of(points.begin(), points.end(),
                    [&](const auto& point) { return is_there(point.second[seed]); }))
      complete.push_back(seed);
  Grid grid;
  grid.is_whole = left_out == 0;
  grid.y.resize(static_cast<Eigen::Index>(points.size()),
                static_cast<Eigen::Index>(complete.size()));
  for (const auto& [point, sums] : points) {
    const auto row = static_cast<Eigen::Index>(grid.points.size());
    for (std::size_t s = 0; s < complete.size(); ++s)
      grid.y(row, static_cast<Eigen::Index>(s)) = sums[complete[s]].sum;
    grid.points.push_back(point);
  }
  return grid;
}

/// Logarithms of the points' values, about their means, which `middle` takes.
Eigen::MatrixXd logarithms(const StudyAnswers& answers, const std::vector<std::size_t>& fitted,
                           const std::vector<Place>& points, Eigen::RowVectorXd& middle) {
  Eigen::MatrixXd x(static_cast<Eigen::Index>(points.size()),
                    static_cast<Eigen::Index>(fitted.size()));
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < fitted.size(); ++k)
      x(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          std::log10(answers.axes[fitted[k]].numbers[points[i][k]]);
  middle = x.colwise().mean();
  x.rowwise() -= middle;
  return x;
}

Eigen::MatrixXd with_constant(const Eigen::MatrixXd& x) {
  Eigen::MatrixXd all(x.rows(), x.cols() + 1);
  all << Eigen::VectorXd::Ones(x.rows()), x;
  return all;
}

/// Where the exponents change, by the parabola of each seed: all squares and products of two
/// dimensions.
std::vector<LocalExponent> changes_of(const StudyAnswers& answers,
                                      const std::vector<std::size_t>& fitted, const Grid& grid,
                                      const Eigen::MatrixXd& x, const Eigen::RowVectorXd& middle) {
  struct Term {
    std::size_t of, along;
  };
  std::vector<Term> terms;
  for (std::size_t i = 0; i < fitted.size(); ++i)
    for (std::size_t j = i; j < fitted.size(); ++j)
      if (i != j || answers.axes[fitted[i]].size() > 2) terms.push_back({i, j});
  const Eigen::Index linear = 1 + x.cols();
  Eigen::MatrixXd curved(x.rows(), linear + static_cast<Eigen::Index>(terms.size()));
  curved.leftCols(linear) = with_constant(x);
  for (std::size_t t = 0; t < terms.size(); ++t)
    curved.col(linear + static_cast<Eigen::Index>(t)) =
        x.col(static_cast<Eigen::Index>(terms[t].of))
            .cwiseProduct(x.col(static_cast<Eigen::Index>(terms[t].along)));
  const LeastSquares decomposed(curved);
  if (curved.rows() < curved.cols() || decomposed.rank() < curved.cols()) return {};
  const Eigen::MatrixXd of_seeds = decomposed.solve(grid.y);  // (term, seed)
  const Eigen::VectorXd mean = of_seeds.rowwise().mean();

  std::vector<LocalExponent> changes;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const Eigen::Index row = linear + static_cast<Eigen::Index>(t);
    const std::vector<double> coefficients(of_seeds.row(row).begin(), of_seeds.row(row).end());
    const MeanOfRuns curvature = mean_of_runs(coefficients);
    const auto seeds = static_cast<double>(curvature.count);
    const double p =
        curvature.mean == 0
            ? 1.0
            : student_tail(curvature.mean * std::sqrt(seeds) / curvature.deviation, seeds - 1);
    const auto add = [&](std::size_t of, std::size_t along) {
      const std::vector<double>& values = answers.axes[fitted[along]].numbers;
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      const auto exponent = [&](double value) {
        return mean(1 + static_cast<Eigen::Index>(of)) +
               (of == along ? 2 : 1) * mean(row) *
                   (std::log10(value) - middle(static_cast<Eigen::Index>(along)));
      };
      changes.push_back({answers.axes[fitted[of]].name, answers.axes[fitted[along]].name, *low,
                         *high, exponent(*low), exponent(*high), p});
    };
    add(terms[t].of, terms[t].along);
    if (terms[t].of != terms[t].along) add(terms[t].along, terms[t].of);
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const LocalExponent& a, const LocalExponent& b) { return a.p < b.p; });
  // that any one of all these comparisons errs
  const double chance = (1 - confidence_of_means) / static_cast<double>(terms.size());
  while (changes.size() > 1 && !(changes.back().p < chance)) changes.pop_back();
  return changes;
}

}  // namespace

bool StraightLine::bends() const { return why_not_tested.empty() && p < 1 - confidence_of_means; }

StraightLine test_straight_line(const StudyAnswers& answers, const std::vector<double>& amplitude,
                                const std::vector<std::size_t>& fitted, const Draws& draws) {
  StraightLine line;
  const Grid grid = complete_grid(answers, amplitude, fitted, draws);
  const std::string drawn = draws.axes == std::vector<std::string>{"seed"}
                                ? "seeds"
                                : fmt::format("values of {}", fmt::join(draws.axes, " and "));
  const auto seeds = grid.y.cols();
  if (seeds < 2) {
    line.why_not_tested = fmt::format("it takes two {} that have all points, there {}", drawn,
                                      seeds == 1 ? "is one" : "are none");
    return line;
  }
  const std::size_t points = grid.points.size(), unknowns = fitted.size() + 1;
  Eigen::RowVectorXd middle;
  Eigen::MatrixXd x;
  if (points > unknowns) x = logarithms(answers, fitted, grid.points, middle);
  if (points <= unknowns || LeastSquares(with_constant(x)).rank() <= x.cols()) {
    line.why_not_tested =
        fmt::format("it takes more than {} points{}, so that one is left over, there {}", unknowns,
                    grid.is_whole ? "" : " with two thirds of the " + drawn,
                    points > 1   ? fmt::format("are {}", points)
                    : points > 0 ? "is one"
                                 : "are none");
    return line;
  }
  const LackOfFit test = lack_of_fit(with_constant(x), grid.y);
  line.p = test.p;
  line.f = test.f;
  line.above = test.above;
  line.below = test.below;
  if (line.bends()) line.changes = changes_of(answers, fitted, grid, x, middle);
  return line;
}

std::string describe(const StraightLine& line) {
  if (!line.why_not_tested.empty())
    return fmt::format("whether a straight line fits cannot be tested: {}", line.why_not_tested);
  if (!line.bends())
    return fmt::format("nothing speaks against a straight line (lack of fit: p = {:.2g})", line.p);
  return fmt::format(
      "a straight line does not fit (lack of fit: p = {:.2g}): the exponents are means over these "
      "values, and do not hold beyond them",
      line.p);
}

std::string describe(const LocalExponent& c) {
  return fmt::format("the exponent of {} {} from {:.3f} at {} = {:g} to {:.3f} at {:g}", c.of,
                     c.exponent_to < c.exponent_from ? "falls" : "rises", c.exponent_from, c.along,
                     c.from, c.exponent_to, c.to);
}

}  // namespace ra2d
