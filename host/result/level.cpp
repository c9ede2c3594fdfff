// SPDX-License-Identifier: BSD-3-Clause
#include "host/result/level.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace ra2d {
namespace {

std::vector<double> find_mean_squares(const Body& body, int nodes, double spacing) {
  std::vector<double> means;
  for (const BodyMode& mode : body.modes)
    means.push_back(mode.omega > 0 ? mode.shape->mean_square(nodes, spacing) : 0.0);
  return means;
}

std::shared_future<std::vector<double>> known_already(std::vector<double> values) {
  std::promise<std::vector<double>> promise;
  promise.set_value(std::move(values));
  return promise.get_future().share();
}

}  // namespace

MeanSquares::MeanSquares(std::vector<double> known) : found_{known_already(std::move(known))} {}

MeanSquares::MeanSquares(const Body& body, int nodes, double spacing) {
  constexpr double few = 20'000;  // shapes at nodes: as long as it takes to start a thread, or so
  const bool worth_it = static_cast<double>(body.modes.size()) * nodes > few;
  // with both, a system that starts no more threads leaves it to who asks
  const std::launch how =
      worth_it ? std::launch::async | std::launch::deferred : std::launch::deferred;
  found_ = std::async(how, find_mean_squares, body, nodes, spacing).share();
}

std::vector<double> mean_squares(const Model& model) {
  return find_mean_squares(model.resonator, static_cast<int>(model.resonator_height.size()),
                           model.scene.spacing);
}

double v_rms(const std::vector<double>& mean_squares, const Snapshot& end, const Snapshot& begin) {
  if (!(end.step > begin.step)) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (std::size_t k = 0; k < mean_squares.size(); ++k) {
    const double before = begin.resonator_square.empty() ? 0.0 : begin.resonator_square[k];
    sum += mean_squares[k] * (end.resonator_square[k] - before);
  }
  return std::sqrt(sum / static_cast<double>(end.step - begin.step));
}

double v_rms(const Model& model, const Snapshot& end, const Snapshot& begin) {
  return v_rms(mean_squares(model), end, begin);
}

double level(double v_rms) { return 20.0 * std::log10(v_rms / 1e-9); }

}  // namespace ra2d
