// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/v_rms.hpp"

#include <cmath>

#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

std::vector<double> find_mean_squares(const Body& body, int nodes, double spacing) {
  std::vector<double> means;
  for (const BodyMode& mode : body.modes)
    means.push_back(mode.omega > 0 ? mode.shape->mean_square(nodes, spacing) : 0.0);
  return means;
}

/// Root of the mean over the steps of the squared velocities of so many modes, each times
/// `weight(k)`.
template <class Weight>
double rms_of_modes(std::size_t modes, const Snapshot& end, const Snapshot& begin,
                    const Weight& weight) {
  if (!(end.step > begin.step)) return quiet_nan;
  double sum = 0;
  for (std::size_t k = 0; k < modes; ++k) {
    const double before = begin.resonator_square.empty() ? 0.0 : begin.resonator_square[k];
    sum += weight(k) * (end.resonator_square[k] - before);
  }
  return std::sqrt(sum / static_cast<double>(end.step - begin.step));
}

}  // namespace

MeanSquares mean_squares(const Body& body, int nodes, double spacing) {
  constexpr double few =
      20'000;  // shapes at nodes: about the time that the start of a thread takes
  const bool on_a_thread = static_cast<double>(body.modes.size()) * nodes > few;
  return {[=] { return find_mean_squares(body, nodes, spacing); }, on_a_thread};
}

std::vector<double> mean_squares(const Model& model) {
  return find_mean_squares(model.resonator, static_cast<int>(model.resonator_height.size()),
                           model.scene.spacing);
}

double v_rms(const std::vector<double>& mean_squares, const Snapshot& end, const Snapshot& begin) {
  return rms_of_modes(mean_squares.size(), end, begin,
                      [&](std::size_t k) { return mean_squares[k]; });
}

double v_rms(const Model& model, const Snapshot& end, const Snapshot& begin) {
  return v_rms(mean_squares(model), end, begin);
}

double displacement_rms(const Model& model, const std::vector<double>& mean_squares,
                        const Snapshot& end, const Snapshot& begin) {
  return rms_of_modes(mean_squares.size(), end, begin, [&](std::size_t k) {
    const double omega = model.resonator.modes[k].omega;
    return omega > 0 ? mean_squares[k] / (omega * omega) : 0.0;
  });
}

}  // namespace ra2d
