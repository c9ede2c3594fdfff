// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Quantiles that confidence intervals need, to about 1e-12, relative.
namespace ra2d {

/// The value that a chi-square variable stays below with probability p; degrees of freedom need not be
/// whole.
double chi_square_quantile(double p, double degrees_of_freedom);

/// The same of Student's t.
double student_quantile(double p, double degrees_of_freedom);

}  // namespace ra2d
