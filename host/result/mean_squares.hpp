// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <future>
#include <vector>

namespace ra2d {

/// Means of psi_k^2 over a body's nodes [1/m], one for each mode: 0 for a rigid mode. They may be
/// found beside the march, for they take as long as a good part of a short run.
class MeanSquares {
 public:
  MeanSquares(std::vector<double> values = {});
  /// `find` runs on a thread of its own if `on_a_thread` and the system starts one, else in get().
  MeanSquares(std::function<std::vector<double>()> find, bool on_a_thread);
  const std::vector<double>& get() const { return found_.get(); }

 private:
  std::shared_future<std::vector<double>> found_;
};

}  // namespace ra2d
