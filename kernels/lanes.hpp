// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <Kokkos_SIMD.hpp>
#include <cstdint>

#include "kernels/function.hpp"
#include "kernels/limits.hpp"
#include "kernels/warp.hpp"

// for a GPU Kokkos' packs hold one value
#if defined(__AVX512F__) && defined(KOKKOS_ARCH_AVX512XEON) && !defined(RA2D_WARPS)
#define RA2D_AVX512
#endif

/// Lanes: how the one team that marches a scene spreads its modes and nodes.
///
/// The formulas are written once, for a pack `Real` that holds one value a lane. On a CPU a pack is
/// a SIMD register of one thread; on a GPU it is one double in each thread of a warp, or of a part
/// of one, beside teams with other scenes. A sum over lanes adds in one fixed tree, so a result
/// does not depend on threads, batch or launch.
///
/// Each lane of a warp runs a kernel by itself. Kernels keep these rules so that the lanes come to
/// the bits of a pack (tests/warp checks them):
///
///   Branches  The condition of an `if` or a loop is the same in all lanes: it comes from the
///             tables, the state or a reduction, never from a `Real`. So all lanes come to the same
///             reductions and syncs in the same order.
///   Rows      A row of lanes (`load`, `store`) is written by all, each its own place. A lane may
///             read its own place back at any time, and another's after a sync.
///   Scalars   Any other value of the state is written by the leader alone.
///   Syncs     One stands between a write and the reads of other lanes, and one between these reads
///             and the next write: a lane may be late. A condition counts as a read, too.
///   Sums      A reduction synchronizes the lanes, but orders no memory: it is no sync.
///   Scenes    A GPU may march several scenes in a block. They share nothing but instructions. Of
///             warps with a scene each, `meet_scenes` waits until all have come to one, so that
///             what they do next is fetched once for all. Of scenes that share a warp,
///             `meet_in_warp` does the same, so that it is issued once. An answer never depends on
///             it.
///   Time      On a GPU each scene of a launch has the same time, and `time_is_up` says when it is
///             over: else all would wait for the one with most to do. An answer never depends on
///             where a launch ends.
namespace ra2d {

/// Lanes of a CPU thread: the SIMD register of the instruction set that Kokkos was built for.
struct HostLanes {
  using Real = Kokkos::Experimental::simd<double>;
  using Mask = typename Real::mask_type;
  static constexpr int width = static_cast<int>(Real::size());
  static constexpr bool on_gpu = false;

  int filled_packs = most_modes;  // that have modes in them; at least one: sums begin with it

  HostLanes() = default;
  explicit HostLanes(int modes) : filled_packs{modes > width ? (modes + width - 1) / width : 1} {}

  static Real load(const double* p) {
    return Kokkos::Experimental::simd_unchecked_load<Real>(p,
                                                           Kokkos::Experimental::simd_flag_default);
  }
  static void store(double* p, const Real& x) {
    Kokkos::Experimental::simd_unchecked_store(x, p, Kokkos::Experimental::simd_flag_default);
  }
  /// 0, 1, ..., width - 1
  static Real index() {
    return Real([](std::size_t lane) { return static_cast<double>(lane); });
  }
  static double sum(const Real& x) {
#if defined(RA2D_AVX512)
    return _mm512_reduce_add_pd(static_cast<__m512d>(x));
#else
    double part[width];
    store(part, x);
    for (int half = width / 2; half > 0; half /= 2)
      for (int lane = 0; lane < half; ++lane) part[lane] += part[lane + half];
    return part[0];
#endif
  }
  /// The sums of two packs, in little more than the time of one.
  static void sum(const Real& x, const Real& y, double& of_x, double& of_y) {
#if defined(RA2D_AVX512)
    const auto a = static_cast<__m512d>(x), b = static_cast<__m512d>(y);
    const __m512d pairs = _mm512_add_pd(_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
    const __m256d quarter =
        _mm256_add_pd(_mm512_castpd512_pd256(pairs), _mm512_extractf64x4_pd(pairs, 1));
    const __m128d both =
        _mm_add_pd(_mm256_castpd256_pd128(quarter), _mm256_extractf128_pd(quarter, 1));
    of_x = _mm_cvtsd_f64(both);
    of_y = _mm_cvtsd_f64(_mm_unpackhi_pd(both, both));
#else
    of_x = sum(x);
    of_y = sum(y);
#endif
  }
  static double min(const Real& x) {
#if defined(RA2D_AVX512)
    return _mm512_reduce_min_pd(static_cast<__m512d>(x));
#else
    double part[width];
    store(part, x);
    double least = part[0];
    for (int lane = 1; lane < width; ++lane) least = part[lane] < least ? part[lane] : least;
    return least;
#endif
  }
  static double max(const Real& x) { return -min(-x); }
  /// Each lane that of the next one; the last keeps its own.
  static Real next(const Real& x) {
#if defined(RA2D_AVX512)
    const auto a = static_cast<__m512d>(x);
    return Real(_mm512_permutexvar_pd(_mm512_setr_epi64(1, 2, 3, 4, 5, 6, 7, 7), a));
#else
    double part[width + 1];
    store(part, x);
    part[width] = part[width - 1];
    return load(part + 1);
#endif
  }
  /// One bit for each lane whose x is at least `level`.
  static std::uint32_t at_least(const Real& x, double level) {
    // written with <=: in Kokkos 5.0 the AVX-512 operators >= and > compare the wrong way round
    const Mask mask = Real(level) <= x;
#if defined(RA2D_AVX512)
    return static_cast<std::uint32_t>(static_cast<__mmask8>(mask));
#else
    std::uint32_t word = 0;
    for (int lane = 0; lane < width; ++lane)
      if (mask[lane]) word |= 1u << lane;
    return word;
#endif
  }
  static constexpr bool leader() { return true; }
  static void sync() {}
  static void meet_scenes() {}
  static void meet_in_warp() {}
  static constexpr bool time_is_up() { return false; }
  /// Has what stands there brought near, to be read soon.
  static void prefetch(const double* p) { __builtin_prefetch(p); }
};

#if defined(RA2D_WARPS)
/// Lanes of a GPU team: the threads of a warp, or of a half, quarter or eighth of one. Kokkos' own
/// reductions over them are loops of as many rounds as a launch says, with branches in them; these
/// are a shuffle a round. On the host it compiles and is never called.
template <int width_>
struct WarpLanes {
  using Real = double;
  static constexpr int width = width_;
  static constexpr bool on_gpu = true;

  int lane = 0;           // of the team
  std::uint64_t end = 0;  // of warp::clock()

  /// For a march that is to end by then, of a block of (width, teams) threads.
  RA2D_FUNCTION explicit WarpLanes(std::uint64_t end_) : end{end_} {
    KOKKOS_IF_ON_DEVICE((lane = static_cast<int>(threadIdx.x);))
  }
  RA2D_FUNCTION Real load(const double* p) const { return p[lane]; }
  RA2D_FUNCTION void store(double* p, Real x) const { p[lane] = x; }
  RA2D_FUNCTION Real index() const { return lane; }
  /// Lane i with lane i + width/2, then i + width/4, ...: a + b is b + a, so each lane comes to the
  /// same bits.
  RA2D_FUNCTION double sum(Real x) const {
    return joined<width / 2>(x, [](double a, double b) { return a + b; });
  }
  /// Both in the same tree, x in the first half of the lanes and y in the second: of 32, six
  /// exchanges instead of ten.
  RA2D_FUNCTION void sum(Real x, Real y, double& of_x, double& of_y) const {
    const bool second = lane >= width / 2;
    const double given = warp::across<width>(second ? x : y, width / 2);
    const double half =
        joined<width / 4>((second ? y : x) + given, [](double a, double b) { return a + b; });
    const double other = warp::across<width>(half, width / 2);
    of_x = second ? other : half;
    of_y = second ? half : other;
  }
  /// Four in the same tree, its last steps a quarter of the lanes each: of 32, ten exchanges
  /// instead of twenty.
  RA2D_FUNCTION void sums(const Real (&x)[4], double (&of)[4]) const {
    spread(x, of, [](double a, double b) { return a + b; });
  }
  /// The smallest of four, of each in the same way; of 0 and -0 either.
  RA2D_FUNCTION void minima(const Real (&x)[4], double (&of)[4]) const { spread(x, of, less); }
  RA2D_FUNCTION double min(Real x) const {
    return warp::of_lane<width>(0, joined<width / 2>(x, less));  // of 0 and -0 each has its own
  }
  RA2D_FUNCTION double max(Real x) const { return -min(-x); }
  RA2D_FUNCTION Real next(Real x) const { return warp::of_next<width>(x); }
  RA2D_FUNCTION std::uint32_t at_least(Real x, double level) const {
    return warp::ballot<width>(level <= x);
  }
  RA2D_FUNCTION bool leader() const { return lane == 0; }
  RA2D_FUNCTION static void prefetch(const double*) {}
  RA2D_FUNCTION void meet_scenes() const { warp::wait_for_block(); }
  RA2D_FUNCTION void meet_in_warp() const {
    if constexpr (width < warp::size) warp::wait_for_block();
  }
  RA2D_FUNCTION void sync() const { warp::sync<width>(); }
  RA2D_FUNCTION bool time_is_up() const { return warp::ballot<width>(end <= warp::clock()) != 0; }

 private:
  RA2D_FUNCTION static double less(double x, double y) { return y < x ? y : x; }
  /// x of each lane with that of the lane `distance` away, then half as far away, down to one.
  template <int distance, class Operation>
  RA2D_FUNCTION static double joined(double x, const Operation& join) {
    if constexpr (distance > 0) {
      return joined<distance / 2>(join(x, warp::across<width>(x, distance)), join);
    } else {
      return x;
    }
  }
  template <class Operation>
  RA2D_FUNCTION void spread(const Real (&x)[4], double (&of)[4], const Operation& join) const {
    constexpr int half = width / 2, quarter = width / 4;
    const bool in_half = (lane & half) != 0, in_quarter = (lane & quarter) != 0;
    const double a = join(in_half ? x[1] : x[0], warp::across<width>(in_half ? x[0] : x[1], half)),
                 b = join(in_half ? x[3] : x[2], warp::across<width>(in_half ? x[2] : x[3], half));
    const double part = joined<width / 8>(
        join(in_quarter ? b : a, warp::across<width>(in_quarter ? a : b, quarter)), join);
    of[0] = warp::of_lane<width>(0, part);
    of[1] = warp::of_lane<width>(half, part);
    of[2] = warp::of_lane<width>(quarter, part);
    of[3] = warp::of_lane<width>(half + quarter, part);
  }
};
#endif

template <class Space>
struct LanesOf {
  template <int>
  using type = HostLanes;
  static constexpr int width = HostLanes::width;
  static constexpr int vector_length = 1;
};
#if defined(RA2D_WARPS)
/// A build for a GPU has no marches on its host's spaces.
template <>
struct LanesOf<Kokkos::DefaultExecutionSpace> {
  template <int width_>
  using type = WarpLanes<width_>;
  static constexpr int width = 32;
  static constexpr int vector_length = 32;
};
#endif

/// Four sums, each to the bits of lanes.sum(x). Where the lanes have none at once, one by one.
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION void four_sums(const Lanes& lanes, const typename Lanes::Real (&x)[4],
                                           double (&of)[4]) {
  if constexpr (requires { lanes.sums(x, of); })
    lanes.sums(x, of);
  else
    for (int i = 0; i < 4; ++i) of[i] = lanes.sum(x[i]);
}
/// Four sums to the bits of two of two, lanes.sum(x, y, of_x, of_y).
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION void four_sums_in_pairs(const Lanes& lanes,
                                                    const typename Lanes::Real (&x)[4],
                                                    double (&of)[4]) {
  if constexpr (requires { lanes.sums(x, of); }) {
    lanes.sums(x, of);
  } else {
    lanes.sum(x[0], x[1], of[0], of[1]);
    lanes.sum(x[2], x[3], of[2], of[3]);
  }
}
/// The smallest of each of four packs.
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION void four_minima(const Lanes& lanes, const typename Lanes::Real (&x)[4],
                                             double (&of)[4]) {
  if constexpr (requires { lanes.minima(x, of); })
    lanes.minima(x, of);
  else
    for (int i = 0; i < 4; ++i) of[i] = lanes.min(x[i]);
}

/// a b + c with one rounding, for packs and scalars alike.
template <class Real>
KOKKOS_FORCEINLINE_FUNCTION Real multiply_add(const Real& a, const Real& b, const Real& c) {
  return Kokkos::fma(a, b, c);
}
template <class Real>
requires(!std::is_same_v<Real, double>) KOKKOS_FORCEINLINE_FUNCTION Real
    multiply_add(double a, const Real& b, const Real& c) {
  return Kokkos::fma(Real(a), b, c);
}

/// a where `test` is positive, else b.
KOKKOS_FORCEINLINE_FUNCTION double if_positive(double test, double a, double b) {
  return test > 0.0 ? a : b;
}
inline HostLanes::Real if_positive(const HostLanes::Real& test, const HostLanes::Real& a,
                                   const HostLanes::Real& b) {
  // of the comparisons that Kokkos 5.0 has right for AVX-512 (see at_least)
  return Kokkos::Experimental::condition(HostLanes::Real(0.0) < test, a, b);
}

/// Packs to go through: all, for loops of a known length.
template <int packs, class Lanes>
KOKKOS_FORCEINLINE_FUNCTION constexpr int filled(const Lanes&) {
  return packs;
}
/// Whether packs are so many that a CPU keeps them in memory. Few, and those of a GPU's lane, are
/// in registers.
template <class Lanes, int packs>
inline constexpr bool has_many_packs = packs > 3 && !Lanes::on_gpu;
/// On a CPU, of many packs those with modes in them. What is beyond these stays as it was: zeros in
/// the state, nothing in a kernel's own arrays.
template <int packs>
KOKKOS_FORCEINLINE_FUNCTION int filled(const HostLanes& lanes) {
  if constexpr (has_many_packs<HostLanes, packs>)
    return lanes.filled_packs < packs ? lanes.filled_packs : packs;
  else
    return packs;
}

/// Calls use<count>(first) for all packs, `at_once` of them at a time, then one by one: of many
/// packs, as many as stay in registers while a polynomial of each is summed up.
template <int packs, int at_once, class Lanes, class Use>
KOKKOS_FORCEINLINE_FUNCTION void for_packs(const Lanes& lanes, const Use& use) {
  const int all = filled<packs>(lanes);
  int p = 0;
  for (; p + at_once <= all; p += at_once) use.template operator()<at_once>(p);
  if constexpr (packs % at_once != 0 || has_many_packs<Lanes, packs>)
    for (; p < all; ++p) use.template operator()<1>(p);
}

/// Pack number `pack` of a row of lanes.
template <class Lanes>
KOKKOS_FORCEINLINE_FUNCTION typename Lanes::Real load_pack(const Lanes& lanes, const double* row,
                                                           int pack) {
  return lanes.load(row + pack * Lanes::width);
}

}  // namespace ra2d
