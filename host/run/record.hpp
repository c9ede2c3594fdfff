// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "host/run/batch.hpp"
#include "host/run/model.hpp"
#include "host/store/store.hpp"

/// From what the march hands out to what a file holds.
namespace ra2d {

/// The samples that were drained, the first of them being sample `first` of the run.
SampleBlock make_samples(const Model& model, const ModalStart& start, const Drained& drained,
                         std::int64_t first);

/// Shocks in SI units.
std::vector<Shock> make_shocks(const Model& model, const std::vector<ShockRow>& rows);

/// The shocks that are still going on: as long as they have lasted.
std::vector<Shock> make_shocks(const Model& model, const std::vector<OpenShock>& open);

/// Root mean square velocity of the resonator's elastic motion [m/s]: over its nodes, and over the
/// steps from `begin` (none: t = 0) to `end`; NaN where there is none. What a free body does as a whole is no noise.
/// The mean over nodes is taken mode by mode; cross terms between modes vanish for pinned modes on
/// a whole number of spacings, and are of the order of spacing/length otherwise.
double v_rms(const Model& model, const Snapshot& end, const Snapshot& begin = {});

/// Mean of psi_k^2 over a body's nodes, of each elastic mode [1/m], 0 of a rigid one.
std::vector<double> mean_squares(const Beam& beam, int nodes, double spacing);
/// Those of the resonator ...
std::vector<double> mean_squares(const Model& model);
/// ... and v_rms with them at hand, for many runs of bodies that are alike.
double v_rms(const std::vector<double>& mean_squares, const Snapshot& end,
             const Snapshot& begin = {});

/// 20 log10(v_rms / 1e-9 m/s) (paper, equation 12); -inf at rest.
double level(double v_rms);

/// How well the energy closes between the first sample of a run and one of its samples.
struct EnergyBalance {
  double residual =
      0;  // J: kinetic + elastic + contact + damping loss - sliding work - load work - start
  double turnover = 0;  // J: what it is measured against: the energy that went through
  int samples = 0;      // that it was taken between, no more than 2 counted
  /// NaN where there were no two samples to take it between.
  double relative() const {
    if (samples < 2) return std::numeric_limits<double>::quiet_NaN();
    return turnover > 0 ? residual / turnover : 0.0;
  }
};

/// Follows the energy through a run from a time [s] on, block after block.
class EnergyAccount {
 public:
  explicit EnergyAccount(double from = 0) : from_{from} {}
  void add(const SampleBlock& block);
  EnergyBalance balance() const { return balance_; }

 private:
  double from_;
  bool begun_ = false;
  double start_ = 0, damping_loss_ = 0, sliding_work_ = 0, load_work_ = 0;  // at the first sample
  EnergyBalance balance_;
};

}  // namespace ra2d
