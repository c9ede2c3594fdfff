// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

/// Statistics of regressions whose rows come in clusters: runs of one seed share their surfaces, so
/// that their deviations are alike. Rows of different clusters are independent.
namespace ra2d {

/// How far a coefficient may be off by chance: Student's t of these degrees of freedom times
/// `error`.
struct CoefficientError {
  double error = 0, degrees_of_freedom = 0;
};

/// Of least squares with the columns of `x` (of full rank), which left the residuals; `cluster`: of
/// each row. The sandwich of Bell and McCaffrey (2002, "CR2"): residuals are as correlated within a
/// cluster as they happen to be, and are corrected for the fit that they have gone through; degrees
/// of freedom by Satterthwaite. Where all clusters have the same rows this is Student's t of the
/// coefficients that each cluster has by itself, with clusters - 1 degrees of freedom. Needs two
/// clusters or more.
std::vector<CoefficientError> clustered_errors(const Eigen::MatrixXd& x,
                                               const Eigen::VectorXd& residuals,
                                               const std::vector<std::size_t>& cluster);

/// Whether what a line leaves is more than chance.
struct LackOfFit {
  double f = 0;  // mean square of the common deviation of all clusters, over that of the rest
  double above = 0, below = 0;  // degrees of freedom
  double p = 0;                 // that chance gives as much
};

/// Of `y` (point, cluster), each cluster with a line of its own in the columns of `x` (point, term;
/// of full rank, fewer terms than points); two clusters or more. Classical where deviations are
/// independent of each other. Neighbouring points of a cluster deviate alike, so the degrees of
/// freedom are reduced as for repeated measurements (Box 1954; estimated as Huynh and Feldt 1976,
/// corrected by Lecoutre 1991).
LackOfFit lack_of_fit(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y);

}  // namespace ra2d
