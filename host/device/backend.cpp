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
#include "host/errors.hpp"
#include "kernels/lanes.hpp"

namespace ra2d {

#if defined(KOKKOS_ENABLE_CUDA)
namespace {

/// What the driver says of a call, if it is no success.
std::string fault_of(cudaError_t status) {
  return status == cudaSuccess
             ? std::string()
             : std::string(cudaGetErrorName(status)) + ": " + cudaGetErrorString(status);
}

void require_device(int device) {
  int count = 0;
  if (const std::string fault = fault_of(cudaGetDeviceCount(&count)); !fault.empty())
    throw RequestError("this build of ra2d marches on a GPU, and the driver has none to offer (" +
                       fault + "). Is 'nvidia-smi' content? A build for the CPU: docs/building.md");
  if (device >= count)
    throw RequestError("--device " + std::to_string(device) + ": there " +
                       (count == 1 ? "is one GPU here, number 0"
                                   : "are " + std::to_string(count) + " GPUs here, from 0 on"));
}

}  // namespace

std::string backend_device() {
  cudaDeviceProp properties;
  const int device = Kokkos::device_id();
  const bool known = cudaGetDeviceProperties(&properties, device) == cudaSuccess;
  return "GPU " + std::to_string(device) + (known ? std::string(", ") + properties.name : "");
}
std::size_t backend_room() {
  std::size_t free = 0, all = 0;
  return cudaMemGetInfo(&free, &all) == cudaSuccess ? free / 10 * 9 : 0;
}
#else
namespace {

void require_device(int device) {
  if (device >= 0)
    throw RequestError("--device " + std::to_string(device) +
                       ": this build of ra2d marches on the "
                       "CPU (" +
                       backend_name() + "); docs/building.md says how to build for a GPU");
}

}  // namespace

std::string backend_device() { return {}; }
std::size_t backend_room() { return 0; }
#endif

Backend::Backend(int threads, int device) {
  require_device(device);
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
