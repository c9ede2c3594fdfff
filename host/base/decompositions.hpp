// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <memory>

/// Eigen's decompositions of matrices of any size. They stand behind functions because each takes
/// the compiler seconds, wherever it is used.
namespace ra2d {

struct SymmetricEigen {
  Eigen::VectorXd values;   // ascending
  Eigen::MatrixXd vectors;  // columns, of length 1
};
/// Of a symmetric matrix; only its lower triangle is read.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);

/// a^(-1/2) of a symmetric, positive definite matrix.
Eigen::MatrixXd inverse_square_root(const Eigen::MatrixXd& a);

/// Of any real square matrix, in no order.
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& a);

/// a x = b for a symmetric matrix that is positive or negative semidefinite, by LDL^T.
class SymmetricSolver {
 public:
  explicit SymmetricSolver(const Eigen::MatrixXd& a);
  ~SymmetricSolver();
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
  struct Decomposed;
  std::unique_ptr<const Decomposed> decomposed_;
};
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Least squares |a x - b|, by QR with column pivoting.
class LeastSquares {
 public:
  explicit LeastSquares(const Eigen::MatrixXd& a);
  ~LeastSquares();
  Eigen::Index rank() const;  // of a
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;  // of each column

 private:
  struct Decomposed;
  std::unique_ptr<const Decomposed> decomposed_;
};

}  // namespace ra2d
