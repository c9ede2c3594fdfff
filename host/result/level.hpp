// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <future>
#include <vector>

#include "host/device/batch.hpp"
#include "host/model/model.hpp"

/// The level of the resonator's noise.
namespace ra2d {

/// Root mean square velocity of the resonator's elastic motion [m/s] (paper, equation 13): over its
/// nodes, and over the steps from `begin` (none: t = 0) to `end`; NaN where there is none. What a
/// free body does as a whole is no noise. The mean over nodes is taken mode by mode; cross terms
/// between modes vanish for pinned modes on a whole number of spacings, and are of the order of
/// spacing/length otherwise.
double v_rms(const Model& model, const Snapshot& end, const Snapshot& begin = {});

/// Means of psi_k^2 over a body's nodes, of each elastic mode [1/m], 0 of a rigid one. They are
/// needed at the end of a run and take as long as a good part of a short one: they are found on a
/// thread of their own, beside the march, where the system gives one, and else when somebody asks.
class MeanSquares {
 public:
  MeanSquares(std::vector<double> known = {});
  MeanSquares(const Body& body, int nodes, double spacing);
  const std::vector<double>& get() const { return found_.get(); }

 private:
  std::shared_future<std::vector<double>> found_;
};
inline MeanSquares mean_squares(const Body& body, int nodes, double spacing) {
  return {body, nodes, spacing};
}
/// Those of the resonator, at once ...
std::vector<double> mean_squares(const Model& model);
/// ... and v_rms with them at hand, for many runs of bodies that are alike.
double v_rms(const std::vector<double>& mean_squares, const Snapshot& end,
             const Snapshot& begin = {});
inline double v_rms(const MeanSquares& mean_squares, const Snapshot& end,
                    const Snapshot& begin = {}) {
  return v_rms(mean_squares.get(), end, begin);
}

/// 20 log10(v_rms / 1e-9 m/s) (paper, equation 12); -inf at rest.
double level(double v_rms);

}  // namespace ra2d
