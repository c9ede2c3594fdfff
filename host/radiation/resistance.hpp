// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/radiation/air.hpp"
#include "host/radiation/quadrature.hpp"
#include "host/radiation/radiator.hpp"

/// Power that a face radiates to one side of its baffle.
namespace ra2d {

/// Radiation resistances of a face's modes: at one frequency the mean power is
/// sum_kl R_kl <v_k v_l>, with v the modes' velocities. R_kl [kg/s, per unit of psi_k psi_l] is
///   omega density/(2 pi) integral integral psi_k psi_l sin(k r)/r dA dA
/// and is found in wave numbers, where psi has the transforms a(p) along and b(q) across:
///   omega density/(4 pi^2) integral over p^2 + q^2 < k^2 of a_k a_l* b_k b_l* / sqrt(k^2 - p^2 -
///   q^2).
class RadiationResistance {
 public:
  /// For frequencies up to `highest` [Hz].
  RadiationResistance(const Radiator& radiator, const Air& air, double highest,
                      const Fineness& fineness = {});

  /// R_kl of k >= l, row by row: (0, 0), (1, 0), (1, 1), (2, 0), ...
  std::vector<double> lower_half(double frequency) const;
  /// R_kk.
  double of_mode(std::size_t mode, double frequency) const;

 private:
  /// Transforms of all shapes along at one wave number, from the middle of the face.
  struct Transforms {
    std::vector<double> re, im;  // of each mode
  };
  template <class Add>
  void each_point(double wave_number, Add add) const;
  /// Of all pairs of shapes across, lower half.
  void across(double rest, std::vector<double>& of_pair) const;

  const Air air_;
  double highest_ = 0;  // wave number, rad/m
  double turning_ = 0;  // of the transforms' products, m
  Fineness fineness_;
  std::vector<std::size_t> across_of_;  // of each mode
  std::size_t across_count_ = 0;
  Interpolation along_, across_;             // over the wave number
  std::vector<Transforms> transforms_;       // at along_'s points
  std::vector<std::vector<double>> tables_;  // of (across, across), lower half: at across_'s points
};

/// Bound on the share by which the inertia of the air on both sides lowers a mode's frequency, for
/// a face of this mass [kg/m^2]: from the norm of 1/r on the face.
double inertia_of_air(const Radiator& radiator, const Air& air, double mass_per_area);

}  // namespace ra2d
