// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>
#include <cstdint>

#include "kernels/function.hpp"

#if defined(RA2D_WARPS)
/// Operations of the threads of a warp together, as each make of GPU writes them. A team is `width`
/// threads side by side: a warp or a part of one, of blocks of (width, teams) threads. On the host
/// all of it compiles and is never called.
namespace ra2d::warp {

#if defined(KOKKOS_ENABLE_CUDA)
inline constexpr int size = 32;
/// Whether teams may wait for others of their block. NVIDIA's threads each have a place of their
/// own in the code.
inline constexpr bool teams_may_wait = true;
#else
/// AMD's wavefront. Of some GPUs it has 32 threads: there two teams of 32 have one each.
inline constexpr int size = 64;
/// Its threads have one place in the code: teams that part go on one after the other, and one that
/// waits for another waits for ever.
inline constexpr bool teams_may_wait = false;
#endif

/// One bit for each lane of a team.
template <int width>
inline constexpr std::uint32_t lanes = width == 32 ? 0xFFFFFFFFu : (1u << width) - 1u;

/// The first lane of the calling team in its warp.
template <int width>
RA2D_FUNCTION std::uint32_t first() {
#if defined(KOKKOS_ENABLE_CUDA)
  if constexpr (width < size) KOKKOS_IF_ON_DEVICE((return threadIdx.y * width % size;))
#else
  KOKKOS_IF_ON_DEVICE((return threadIdx.y * width % warpSize;))
#endif
  return 0;
}

#if defined(KOKKOS_ENABLE_CUDA)
/// One bit for each lane of the warp that is of this team.
template <int width>
RA2D_FUNCTION std::uint32_t members() {
  return lanes<width> << first<width>();
}
template <int width>
RA2D_FUNCTION double across(double x, [[maybe_unused]] int distance) {
  KOKKOS_IF_ON_DEVICE((return __shfl_xor_sync(members<width>(), x, distance, width);))
  KOKKOS_IF_ON_HOST((return x;))
}
template <int width>
RA2D_FUNCTION double of_lane([[maybe_unused]] int from, double x) {
  KOKKOS_IF_ON_DEVICE((return __shfl_sync(members<width>(), x, from, width);))
  KOKKOS_IF_ON_HOST((return x;))
}
template <int width>
RA2D_FUNCTION double of_next(double x) {
  KOKKOS_IF_ON_DEVICE((return __shfl_down_sync(members<width>(), x, 1, width);))
  KOKKOS_IF_ON_HOST((return x;))
}
template <int width>
RA2D_FUNCTION std::uint32_t ballot([[maybe_unused]] bool yes) {
  KOKKOS_IF_ON_DEVICE(
      (return (__ballot_sync(members<width>(), yes) & members<width>()) >> first<width>();))
  KOKKOS_IF_ON_HOST((return 0;))
}
template <int width>
RA2D_FUNCTION void sync() {
  KOKKOS_IF_ON_DEVICE((__syncwarp(members<width>());))
}
#else
template <int width>
RA2D_FUNCTION double across(double x, [[maybe_unused]] int distance) {
  KOKKOS_IF_ON_DEVICE((return __shfl_xor(x, distance, width);))
  KOKKOS_IF_ON_HOST((return x;))
}
template <int width>
RA2D_FUNCTION double of_lane([[maybe_unused]] int from, double x) {
  KOKKOS_IF_ON_DEVICE((return __shfl(x, from, width);))
  KOKKOS_IF_ON_HOST((return x;))
}
template <int width>
RA2D_FUNCTION double of_next(double x) {
  KOKKOS_IF_ON_DEVICE((return __shfl_down(x, 1, width);))
  KOKKOS_IF_ON_HOST((return x;))
}
template <int width>
RA2D_FUNCTION std::uint32_t ballot([[maybe_unused]] bool yes) {
  KOKKOS_IF_ON_DEVICE(
      (return static_cast<std::uint32_t>(__ballot(yes) >> first<width>()) & lanes<width>;))
  KOKKOS_IF_ON_HOST((return 0;))
}
/// The threads keep step by themselves: the compiler alone must not move accesses past it.
template <int width>
RA2D_FUNCTION void sync() {
  KOKKOS_IF_ON_DEVICE(
      (__builtin_amdgcn_fence(__ATOMIC_ACQ_REL, "wavefront"); __builtin_amdgcn_wave_barrier();))
}
#endif

/// All warps of the block that march on.
KOKKOS_FORCEINLINE_FUNCTION void wait_for_block() {
  if constexpr (teams_may_wait) KOKKOS_IF_ON_DEVICE((__syncthreads();))
}

/// The GPU's clock, in ticks: nanoseconds on NVIDIA's.
KOKKOS_FORCEINLINE_FUNCTION std::uint64_t clock() {
  std::uint64_t now = 0;
#if defined(__CUDA_ARCH__)
  asm volatile("mov.u64 %0, %globaltimer;" : "=l"(now)::"memory");
#elif defined(__HIP_DEVICE_COMPILE__)
  now = static_cast<std::uint64_t>(wall_clock64());
#endif
  return now;
}

}  // namespace ra2d::warp
#endif
