// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <Kokkos_SIMD.hpp>
#include <array>
#include <cmath>
#include <cstdint>

#include "kernels/function.hpp"
#include "tests/reductions.hpp"

/// Lanes on one thread that are nothing but doubles. To be included before any kernel: these call
/// Kokkos' functions by their full names.
namespace ra2d::test {

#if defined(RA2D_TEST_PACK_WIDTH)
inline constexpr int pack_width = RA2D_TEST_PACK_WIDTH;
#elif defined(RA2D_WARPS)  // as wide as those that march here
inline constexpr int pack_width = warp_width;
#else
inline constexpr int pack_width = static_cast<int>(Kokkos::Experimental::simd<double>::size());
#endif

/// So many values, each computed as a double is.
template <int width>
struct PackOf {
  std::array<double, width> x;
  using Pack = PackOf;

  PackOf() = default;
  PackOf(double value) { x.fill(value); }  // as implicit as that of Kokkos' packs

  template <class Function>
  static Pack of(const Function& function) {
    Pack result;
    for (int lane = 0; lane < width; ++lane) result.x[lane] = function(lane);
    return result;
  }
  friend Pack operator+(const Pack& a, const Pack& b) {
    return of([&](int i) { return a.x[i] + b.x[i]; });
  }
  friend Pack operator-(const Pack& a, const Pack& b) {
    return of([&](int i) { return a.x[i] - b.x[i]; });
  }
  friend Pack operator*(const Pack& a, const Pack& b) {
    return of([&](int i) { return a.x[i] * b.x[i]; });
  }
  friend Pack operator/(const Pack& a, const Pack& b) {
    return of([&](int i) { return a.x[i] / b.x[i]; });
  }
  friend Pack operator-(const Pack& a) {
    return of([&](int i) { return -a.x[i]; });
  }
  friend Pack if_positive(const Pack& test, const Pack& a, const Pack& b) {
    return of([&](int i) { return test.x[i] > 0 ? a.x[i] : b.x[i]; });
  }
};
using Pack = PackOf<pack_width>;

}  // namespace ra2d::test

namespace Kokkos {

template <int width>
ra2d::test::PackOf<width> fma(const ra2d::test::PackOf<width>& a,
                              const ra2d::test::PackOf<width>& b,
                              const ra2d::test::PackOf<width>& c) {
  return ra2d::test::PackOf<width>::of([&](int i) { return std::fma(a.x[i], b.x[i], c.x[i]); });
}
template <int width>
ra2d::test::PackOf<width> abs(const ra2d::test::PackOf<width>& a) {
  return ra2d::test::PackOf<width>::of([&](int i) { return std::abs(a.x[i]); });
}
template <int width>
ra2d::test::PackOf<width> sqrt(const ra2d::test::PackOf<width>& a) {
  return ra2d::test::PackOf<width>::of([&](int i) { return std::sqrt(a.x[i]); });
}
// as Kokkos' own for doubles: the first where they are equal
template <int width>
ra2d::test::PackOf<width> max(const ra2d::test::PackOf<width>& a,
                              const ra2d::test::PackOf<width>& b) {
  return ra2d::test::PackOf<width>::of([&](int i) { return a.x[i] < b.x[i] ? b.x[i] : a.x[i]; });
}
template <int width>
ra2d::test::PackOf<width> min(const ra2d::test::PackOf<width>& a,
                              const ra2d::test::PackOf<width>& b) {
  return ra2d::test::PackOf<width>::of([&](int i) { return b.x[i] < a.x[i] ? b.x[i] : a.x[i]; });
}

}  // namespace Kokkos

#include "kernels/lanes.hpp"

namespace ra2d::test {

/// The interface of kernels/lanes.hpp with such packs.
template <int width_>
struct PackLanesOf {
  using Real = PackOf<width_>;
  static constexpr int width = width_;
  static constexpr bool on_gpu = width == warp_width;

  static Real load(const double* p) {
    return Real::of([&](int lane) { return p[lane]; });
  }
  static void store(double* p, const Real& x) {
    for (int lane = 0; lane < width; ++lane) p[lane] = x.x[lane];
  }
  static Real index() {
    return Real::of([](int lane) { return static_cast<double>(lane); });
  }
  static double sum(const Real& x) { return tree_sum(x.x); }
  static void sum(const Real& x, const Real& y, double& of_x, double& of_y) {
#if defined(RA2D_AVX512) && !defined(RA2D_TEST_PACK_WIDTH)
    if constexpr (width == 8) {  // each lane with its neighbour first, as HostLanes does there
      of_x = tree_sum(neighbours(x));
      of_y = tree_sum(neighbours(y));
      return;
    }
#endif
    of_x = sum(x);
    of_y = sum(y);
  }
  static double min(const Real& x) { return smallest(x.x); }
  static double max(const Real& x) { return -min(-x); }
  static Real next(const Real& x) {
    const auto next = next_lanes(x.x);
    return Real::of([&](int lane) { return next[lane]; });
  }
  static std::uint32_t at_least(const Real& x, double level) { return lanes_at_least(x.x, level); }
  static constexpr bool leader() { return true; }
  static void prefetch(const double*) {}
  static void sync() {}
  static void meet_scenes() {}
  static void meet_in_warp() {}
  static constexpr bool time_is_up() { return false; }

 private:
  static std::array<double, width / 2> neighbours(const Real& x) {
    std::array<double, width / 2> pairs;
    for (int i = 0; i < width / 2; ++i) pairs[i] = x.x[2 * i] + x.x[2 * i + 1];
    return pairs;
  }
};
using PackLanes = PackLanesOf<pack_width>;

}  // namespace ra2d::test
