// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Kokkos_Core.hpp>

/// RA2D_CHECK(condition): ends the program where a kernel is about to leave an array. In debug
/// builds alone: what comes from outside was checked before, so a fault here is one of ours.
#if defined(NDEBUG)
#define RA2D_CHECK(condition) static_cast<void>(0)
#else
#define RA2D_CHECK(condition)         \
  ((condition) ? static_cast<void>(0) \
               : Kokkos::abort("ra2d: a kernel leaves an array: " #condition))
#endif
