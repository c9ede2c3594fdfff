// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "host/base/quiet_nan.hpp"
#include "host/result/record.hpp"

/// Whether the energy of a run closes.
namespace ra2d {

/// How well the energy closes between the first sample of a run and one of its samples.
struct EnergyBalance {
  double residual =
      0;  // J: kinetic + elastic + contact + damping loss - sliding work - load work - start
  double turnover = 0;  // J: its largest term, which it is measured against
  int samples = 0;      // that it was taken between, no more than 2 counted
  /// Whether all terms are so small that roundings remain: 1e-30 J bend a beam of 1e5 N/m by 4e-18
  /// m, and doubles next to a height of 10 um are 2e-21 m apart.
  bool is_of_roundings() const { return turnover > 0 && turnover < 1e-30; }
  /// NaN where there were no two samples to take it between, and of roundings.
  double relative() const {
    if (samples < 2 || is_of_roundings()) return quiet_nan;
    return turnover > 0 ? residual / turnover : 0.0;
  }
  /// Its size.
  double closure() const { return std::abs(relative()); }
};

/// Follows the energy through a run from a time [s] on, block after block.
class EnergyAccount {
 public:
  explicit EnergyAccount(double from = 0) : from_{from} {}
  void add(const SampleBlock& block);
  EnergyBalance balance() const { return balance_; }
  /// Energy of the contact springs over that of both bodies, means over the samples in contact; NaN
  /// where there are none.
  double contact_share_of_energy() const { return bodies_ > 0 ? contact_ / bodies_ : quiet_nan; }
  /// Shows all that has to be saved to an archive.
  template <class Archive>
  void visit(Archive& archive) {
    archive(from_, begun_, start_, damping_loss_, sliding_work_, load_work_, balance_.residual,
            balance_.turnover, balance_.samples, contact_, bodies_);
  }

 private:
  double from_;
  bool begun_ = false;
  double start_ = 0, damping_loss_ = 0, sliding_work_ = 0, load_work_ = 0;  // at the first sample
  EnergyBalance balance_;
  double contact_ = 0, bodies_ = 0;  // J: sums over the samples in contact
};

}  // namespace ra2d
