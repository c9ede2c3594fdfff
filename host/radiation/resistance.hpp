// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "host/radiation/air.hpp"
#include "host/radiation/line_transforms.hpp"
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
/// Modes of different parity, along or across, have R_kl = 0.
class RadiationResistance {
 public:
  /// For frequencies up to `highest` [Hz].
  RadiationResistance(const Radiator& radiator, const Air& air, double highest,
                      const Fineness& fineness = {});

  /// Hz.
  double highest() const { return highest_ * air_.sound_speed / (2 * M_PI); }
  /// Modes that couple: each mode is in one group, and R_kl is zero between two groups.
  const std::vector<std::vector<std::size_t>>& groups() const { return groups_; }
  /// R_kl of all groups at frequencies that rise, one group after another: of its k >= l, row by
  /// row. Several frequencies together take less time.
  std::vector<std::vector<double>> of_groups(std::span<const double> frequencies) const;
  /// R_kl of k >= l, row by row: (0, 0), (1, 0), (1, 1), (2, 0), ...
  std::vector<double> lower_half(double frequency) const;
  /// R_kk.
  double of_mode(std::size_t mode, double frequency) const;

 private:
  /// Two modes of a group.
  struct Couple {
    std::size_t k = 0, l = 0, place = 0;  // in of_groups()
  };
  struct Lanes;
  void make_groups(const Radiator& radiator);
  void make_tables(const Radiator& radiator);
  /// Of all pairs of shapes across that couple.
  void across(double rest, double* of_pair) const;
  double wave_number(double frequency) const;
  std::size_t whole_panels(double wave_number) const;
  Points last_points(double wave_number) const;
  void add_whole_panels(Lanes& lanes) const;
  void add_last_panel(Lanes& lanes, std::size_t lane) const;

  const Air air_;
  double highest_ = 0;  // wave number, rad/m
  Fineness fineness_;
  std::vector<std::size_t> across_of_;  // of each mode
  LineTransforms along_, across_;
  std::vector<std::vector<std::size_t>> groups_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;  // of shapes across that couple
  std::vector<std::vector<Couple>> couples_;                // of each of these pairs
  std::size_t couple_count_ = 0;
  Interpolation between_;       // of the tables, over what is left across
  std::vector<double> tables_;  // (point of between_, pair)
  Points points_;               // of whole panels, along
  double panel_ = 0;            // their width, rad/m
  std::vector<double> whole_;   // transforms along: (panel, part, mode, point)
};

/// Bound on the share by which the inertia of the air on both sides lowers a mode's frequency, for
/// a face of this mass [kg/m^2]: from the norm of 1/r on the face.
double inertia_of_air(const Radiator& radiator, const Air& air, double mass_per_area);

}  // namespace ra2d
