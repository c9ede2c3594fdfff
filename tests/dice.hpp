// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace ra2d::test {

/// Numbers that are the same everywhere: the standard's engine, but not its distributions.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_{seed} {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  double ratio(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
  int pick(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  bool one_in(int count) { return pick(count) == 0; }
  std::vector<int> order(int count) {
    std::vector<int> out(count);
    std::iota(out.begin(), out.end(), 0);
    for (int i = count - 1; i > 0; --i) std::swap(out[i], out[pick(i + 1)]);
    return out;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace ra2d::test
