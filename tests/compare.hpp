// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <bit>
#include <cstdint>
#include <vector>

/// Comparison to the last bit: also of zeros' signs, and of what is no number.
namespace ra2d::test {

using Bits = std::vector<std::uint64_t>;

inline std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

inline void put(Bits& to, const std::vector<double>& values) {
  for (const double x : values) to.push_back(bits(x));
}

/// What ended and open shocks have in common.
template <class Shock>
void put_shocks(Bits& to, const std::vector<Shock>& shocks) {
  for (const Shock& s : shocks) {
    for (const std::int64_t i : {s.serial, s.start, s.last})
      to.push_back(static_cast<std::uint64_t>(i));
    put(to, {s.peak, s.impulse, s.moment});
  }
}

inline Bits bits(const std::vector<double>& values) {
  Bits out;
  put(out, values);
  return out;
}

template <class Shock>
Bits shock_bits(const std::vector<Shock>& shocks) {
  Bits out;
  put_shocks(out, shocks);
  return out;
}

}  // namespace ra2d::test
