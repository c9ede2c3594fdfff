// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

/// Marks a member function of a march, or a function template that one calls: a KOKKOS_FUNCTION
/// that device compilers always inline. A march is an object made of others. Where all their
/// functions are inlined they are locals of the launch, in registers. One call that is handed the
/// address of such an object keeps all of it in memory, and each field of a table then costs two
/// loads. A CPU keeps its stack in the nearest cache: its compiler may choose. So may nvcc where it
/// compiles without optimising (-G).
#if (defined(__CUDACC__) && !defined(__CUDACC_DEBUG__)) || defined(__HIPCC__) || \
    defined(SYCL_LANGUAGE_VERSION)
#define RA2D_FUNCTION KOKKOS_FORCEINLINE_FUNCTION
#else
#define RA2D_FUNCTION KOKKOS_FUNCTION
#endif
