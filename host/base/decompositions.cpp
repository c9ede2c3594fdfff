// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace ra2d {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

MatrixXd inverse_square_root(const MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(a).operatorInverseSqrt();
}

Eigen::VectorXcd eigenvalues(const MatrixXd& a) {
  return Eigen::EigenSolver<MatrixXd>(a, false).eigenvalues();
}

struct SymmetricSolver::Decomposed {
  Eigen::LDLT<MatrixXd> ldlt;
};

SymmetricSolver::SymmetricSolver(const MatrixXd& a)
    : decomposed_{std::make_unique<Decomposed>(Decomposed{a.ldlt()})} {}
SymmetricSolver::~SymmetricSolver() = default;
VectorXd SymmetricSolver::solve(const VectorXd& b) const { return decomposed_->ldlt.solve(b); }

VectorXd solve_symmetric(const MatrixXd& a, const VectorXd& b) { return a.ldlt().solve(b); }
MatrixXd solve_symmetric(const MatrixXd& a, const MatrixXd& b) { return a.ldlt().solve(b); }

struct LeastSquares::Decomposed {
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
};

LeastSquares::LeastSquares(const MatrixXd& a)
    : decomposed_{
          std::make_unique<Decomposed>(Decomposed{Eigen::ColPivHouseholderQR<MatrixXd>(a)})} {}
LeastSquares::~LeastSquares() = default;
Eigen::Index LeastSquares::rank() const { return decomposed_->qr.rank(); }
VectorXd LeastSquares::solve(const VectorXd& b) const { return decomposed_->qr.solve(b); }
MatrixXd LeastSquares::solve(const MatrixXd& b) const { return decomposed_->qr.solve(b); }

}  // namespace ra2d
