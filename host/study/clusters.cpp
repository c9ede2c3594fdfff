// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/clusters.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/analysis/distributions.hpp"
#include "host/base/decompositions.hpp"

namespace ra2d {
namespace {

/// The trace of the square of d d^T.
double square_of_products(const Eigen::MatrixXd& d) {
  return d.rows() < d.cols() ? (d * d.transpose()).squaredNorm()
                             : (d.transpose() * d).squaredNorm();
}

/// Huynh and Feldt's share of the degrees of freedom, from that of Box and Greenhouse and Geisser.
double share_of_freedom(double box, double terms, double clusters_less_1) {
  const double rank = terms * box, freedom = clusters_less_1 - rank;
  const double share = freedom > 0 ? ((clusters_less_1 + 1) * rank - 2) / (terms * freedom) : 1.0;
  return clusters_less_1 < 2 ? 1 / terms : std::clamp(share, 1 / terms, 1.0);
}

}  // namespace

std::vector<CoefficientError> clustered_errors(const Eigen::MatrixXd& x,
                                               const Eigen::VectorXd& residuals,
                                               const std::vector<std::size_t>& cluster) {
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;
  const Eigen::Index terms = x.cols();
  const std::size_t clusters = 1 + *std::max_element(cluster.begin(), cluster.end());
  std::vector<Matrix> gram(clusters, Matrix::Zero(terms, terms));
  std::vector<Vector> score(clusters, Vector::Zero(terms));
  for (Eigen::Index row = 0; row < x.rows(); ++row) {
    const std::size_t c = cluster[static_cast<std::size_t>(row)];
    gram[c] += x.row(row).transpose() * x.row(row);
    score[c] += x.row(row).transpose() * residuals(row);
  }
  const Matrix root =  // of (x^T x)^-1
      inverse_square_root(x.transpose() * x);
  // With A = (1 - x_c (x^T x)^-1 x_c^T)^-1/2 of a cluster, whose eigenvalues are those of `part`:
  Matrix variance = Matrix::Zero(terms, terms);
  Vector trace = Vector::Zero(terms), square = Vector::Zero(terms);  // of the form in the errors
  std::vector<Matrix> products(static_cast<std::size_t>(terms), Matrix::Zero(terms, terms));
  for (std::size_t c = 0; c < clusters; ++c) {
    const SymmetricEigen part = symmetric_eigen(root * gram[c] * root);
    const Vector taken = part.values.cwiseMax(0.0);
    // if this cluster alone determines a direction, its residual there is zero
    const Vector inverse = (1 - taken.array() > 1e-9).select((1 - taken.array()).inverse(), 0.0);
    const Matrix& directions = part.vectors;
    const Vector off = root * (directions * (inverse.cwiseSqrt().asDiagonal() *
                                             (directions.transpose() * (root * score[c]))));
    variance += off * off.transpose();
    for (Eigen::Index k = 0; k < terms; ++k) {
      const Vector along = directions.transpose() * root.col(k);
      const double size = (along.array().square() * taken.array() * inverse.array()).sum();
      const Vector fitted =
          directions * (along.array() * taken.array() * inverse.array().sqrt()).matrix();
      trace(k) += size - fitted.squaredNorm();
      square(k) += size * size - 2 * size * fitted.squaredNorm();
      products[static_cast<std::size_t>(k)] += fitted * fitted.transpose();
    }
  }
  std::vector<CoefficientError> errors;
  for (Eigen::Index k = 0; k < terms; ++k)
    errors.push_back(
        {std::sqrt(variance(k, k)),
         trace(k) * trace(k) / (square(k) + products[static_cast<std::size_t>(k)].squaredNorm())});
  return errors;
}

LackOfFit lack_of_fit(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
  const Eigen::MatrixXd left = y - x * LeastSquares(x).solve(y);
  const Eigen::VectorXd alike = left.rowwise().mean();
  const Eigen::MatrixXd differing = left.colwise() - alike;
  const auto terms = static_cast<double>(x.rows() - x.cols()),
             clusters = static_cast<double>(y.cols());
  const double chance = differing.squaredNorm(), products = square_of_products(differing);
  const double share =
      products > 0 ? share_of_freedom(chance * chance / (terms * products), terms, clusters - 1)
                   : 1 / terms;
  LackOfFit test;
  test.f = clusters * (clusters - 1) * alike.squaredNorm() / chance;
  test.above = share * terms;
  test.below = test.above * (clusters - 1);
  test.p = fisher_tail(test.f, test.above, test.below);
  return test;
}

}  // namespace ra2d
