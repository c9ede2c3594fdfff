// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

/// A build for a GPU whose threads work in warps (kernels/warp.hpp).
#if defined(KOKKOS_ENABLE_CUDA) || defined(KOKKOS_ENABLE_HIP)
#define RA2D_WARPS
#endif

/// Marks a member function of a march, or a function template that one calls: a KOKKOS_FUNCTION
/// that device compilers always inline. Inlining keeps the parts of a march in registers. If a
/// single call is handed the address of one, all of it stays in memory, and each access to a table
/// needs two loads. The compiler of a CPU may choose, since its stack is in the nearest cache. So
/// may nvcc where it compiles without optimising (-G), and with RA2D_COMPILER_INLINES: the march of
/// Form::implicit is so large when all is inlined that ptxas takes over half an hour for it.
#if !defined(RA2D_COMPILER_INLINES) && ((defined(__CUDACC__) && !defined(__CUDACC_DEBUG__)) || \
                                        defined(__HIPCC__) || defined(SYCL_LANGUAGE_VERSION))
#define RA2D_FUNCTION KOKKOS_FORCEINLINE_FUNCTION
#else
#define RA2D_FUNCTION KOKKOS_FUNCTION
#endif

/// Before a loop that the compiler of a GPU is to leave as one: unrolled it is more code, and
/// fetching code is what `adaptive` waits for there (docs/gpu.md).
#if defined(__CUDA_ARCH__) || defined(__HIP_DEVICE_COMPILE__) || defined(__SYCL_DEVICE_ONLY__)
#define RA2D_KEEP_LOOP _Pragma("unroll 1")
#define RA2D_UNROLL
#else
#define RA2D_KEEP_LOOP
/// Before a loop that the compiler of a CPU is to unroll whole.
#define RA2D_UNROLL _Pragma("GCC unroll 32")
#endif
