// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/backend.hpp"

#include <Kokkos_Core.hpp>
#include <algorithm>
#include <exception>
#include <memory>
#include <mutex>
#include <utility>
#if defined(KOKKOS_ENABLE_OPENMP)
#include <omp.h>
#endif

#include "host/base/errors.hpp"
#include "host/device/cuda_device.hpp"
#include "host/device/device.hpp"
#include "host/device/launch.hpp"
#include "host/system/host_threads.hpp"
#include "kernels/lanes.hpp"

namespace ra2d {

namespace {

Device* where = nullptr;
int threads_of_all = 1;  // whatever the share of the one that asks

#if defined(KOKKOS_ENABLE_CUDA)
std::unique_ptr<Device> gpu;
#endif

}  // namespace

Device* march_device() { return where; }
Device* march_on(Device* device) { return std::exchange(where, device); }

std::string backend_device() { return where != nullptr ? where->name() : std::string(); }
std::size_t backend_memory() { return where != nullptr ? where->free_memory() / 10 * 9 : 0; }

Backend::Backend(int threads, int device) {
  require_gpu(device);
  Kokkos::InitializationSettings settings;
  settings.set_disable_warnings(true);  // about thread binding: one scene runs on one thread
  if (threads > 0) settings.set_num_threads(threads);
  if (device >= 0) settings.set_device_id(device);
#if defined(KOKKOS_ENABLE_OPENMP)
  // before it heeds that number, Kokkos starts a thread on every processor, and where the system
  // starts no more, that ends the program
  if (threads > 0) omp_set_num_threads(threads);
#endif
  Kokkos::initialize(settings);
#if defined(KOKKOS_ENABLE_CUDA)
  limit_host_threads(threads);
  gpu = make_cuda_device();
  where = gpu.get();
#else
  limit_host_threads(Space().concurrency());
#endif
  threads_of_all = host_threads();
}
Backend::~Backend() {
  limit_host_threads(0);
#if defined(KOKKOS_ENABLE_CUDA)
  where = nullptr;
  gpu.reset();
  if (!cuda_device_works()) return;  // Kokkos would end the program, before its fault was told
#endif
  Kokkos::finalize();
}

std::string backend_name() { return Space::name(); }
int backend_threads() { return threads_of_all; }
int scenes_at_once() { return where != nullptr ? where->scenes_at_once() : backend_threads(); }

#if defined(KOKKOS_ENABLE_OPENMP)
void side_by_side(int count, const std::function<void(int)>& work) {
  if (count == 1) return work(0);
  const int all = host_threads();
  std::exception_ptr fault;
  std::mutex one_fault;
  using HostSpace = Kokkos::DefaultHostExecutionSpace;
  Kokkos::parallel_for("ra2d::side_by_side",
                       Kokkos::RangePolicy<HostSpace, Kokkos::Schedule<Kokkos::Dynamic>>(
                           0, count, Kokkos::ChunkSize(1)),
                       [&](int i) {
                         const ShareOfThreads share(all, std::min(count, all));
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
#else
void side_by_side(int count, const std::function<void(int)>& work) {
  on_threads(host_threads(), static_cast<std::size_t>(count),
             [&](std::size_t i) { work(static_cast<int>(i)); });
}
#endif

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
