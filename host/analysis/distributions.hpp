// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Quantiles and tails that intervals and tests need, to about 1e-12, relative.
namespace ra2d {

/// The value that a chi-square variable stays below with probability p; degrees of freedom need not
/// be whole.
double chi_square_quantile(double p, double degrees_of_freedom);

/// The quantile of Student's t.
double student_quantile(double p, double degrees_of_freedom);

/// The probability that a variable of Fisher's F exceeds `f`; degrees of freedom of the mean
/// squares above and below, which need not be whole. NaN for NaN.
double fisher_tail(double f, double above, double below);

/// The probability that Student's t is farther from 0 than `t`.
double student_tail(double t, double degrees_of_freedom);

}  // namespace ra2d
