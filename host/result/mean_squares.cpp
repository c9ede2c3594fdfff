// SPDX-License-Identifier: BSD-3-Clause
#include "host/result/mean_squares.hpp"

#include <utility>

namespace ra2d {

MeanSquares::MeanSquares(std::vector<double> values) {
  std::promise<std::vector<double>> promise;
  promise.set_value(std::move(values));
  found_ = promise.get_future().share();
}

MeanSquares::MeanSquares(std::function<std::vector<double>()> find, bool on_a_thread) {
  // with both, a system that starts no more threads leaves the work to get()
  const std::launch how =
      on_a_thread ? std::launch::async | std::launch::deferred : std::launch::deferred;
  found_ = std::async(how, std::move(find)).share();
}

}  // namespace ra2d
