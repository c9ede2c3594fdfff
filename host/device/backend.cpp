// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/backend.hpp"

#include <Kokkos_Core.hpp>
#include <exception>
#include <limits>
#include <mutex>
#if defined(KOKKOS_ENABLE_OPENMP)
#include <omp.h>
#endif

#include "host/device/arena.hpp"
#include "kernels/lanes.hpp"

namespace ra2d {

Backend::Backend(int threads) {
  Kokkos::InitializationSettings settings;
  settings.set_disable_warnings(true);  // about thread binding: one scene runs on one thread
  if (threads > 0) settings.set_num_threads(threads);
#if defined(KOKKOS_ENABLE_OPENMP)
  // before it heeds that number, Kokkos starts a thread on every processor, and where the system
  // starts no more, that ends the program
  if (threads > 0) omp_set_num_threads(threads);
#endif
  Kokkos::initialize(settings);
}
Backend::~Backend() { Kokkos::finalize(); }

std::string backend_name() { return Space::name(); }
int backend_threads() { return Space().concurrency(); }
int scenes_at_once() { return on_host ? backend_threads() : std::numeric_limits<int>::max(); }

void side_by_side(int count, const std::function<void(int)>& work) {
  if (count == 1) return work(0);
  std::exception_ptr fault;
  std::mutex one_fault;
  using HostSpace = Kokkos::DefaultHostExecutionSpace;
  Kokkos::parallel_for("ra2d::side_by_side",
                       Kokkos::RangePolicy<HostSpace, Kokkos::Schedule<Kokkos::Dynamic>>(
                           0, count, Kokkos::ChunkSize(1)),
                       [&](int i) {
                         try {
                           work(i);
                         } catch (...) {
                           const std::lock_guard lock(one_fault);
                           if (!fault) fault = std::current_exception();
                         }
                       });
  HostSpace{}.fence();
  if (fault) std::rethrow_exception(fault);
}

std::string arithmetic() {
#if defined(__CUDACC__)
  const std::string set = "cuda";
#elif defined(__AVX512F__)
  const std::string set = "avx512";
#elif defined(__AVX2__) && defined(__FMA__)
  const std::string set = "avx2";
#elif defined(__x86_64__)
  const std::string set = "x86-64";
#elif defined(__aarch64__)
  const std::string set = "aarch64";
#else
  const std::string set = "other";
#endif
  return set + ", " + std::to_string(backend_lanes()) + " lanes";
}

int backend_lanes() { return LanesOf<Space>::width; }

}  // namespace ra2d
