// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/backend.hpp"

#include <Kokkos_Core.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <memory>
#include <mutex>
#include <utility>
#if defined(KOKKOS_ENABLE_OPENMP)
#include <omp.h>
#endif

#include "host/base/errors.hpp"
#include "host/device/card.hpp"
#include "host/device/device.hpp"
#include "host/device/kokkos_device.hpp"
#include "host/device/launch.hpp"
#include "host/system/host_threads.hpp"
#include "kernels/lanes.hpp"

namespace ra2d {

namespace {

Device* where = nullptr;
int threads_of_all = 1;  // whatever the share of the one that asks
std::unique_ptr<Device> gpu;

}  // namespace

Device* march_device() { return where; }
Device* march_on(Device* device) { return std::exchange(where, device); }

std::string backend_device() { return where != nullptr ? where->name() : std::string(); }
std::size_t backend_memory() { return where != nullptr ? where->free_memory() / 10 * 9 : 0; }

namespace {

/// `threads` and `device` decide. Of a wrong value Kokkos would end the program.
void forget_variables_of_kokkos() {
  for (const char* name : {"KOKKOS_NUM_THREADS", "KOKKOS_DISABLE_WARNINGS",
                           "KOKKOS_PRINT_CONFIGURATION", "KOKKOS_TUNE_INTERNALS"})
    unsetenv(name);
  if constexpr (!marches_on_gpu)
    for (const char* name : {"KOKKOS_DEVICE_ID", "KOKKOS_MAP_DEVICE_ID_BY"}) unsetenv(name);
}

}  // namespace

Backend::Backend(int threads, int device) {
  forget_variables_of_kokkos();
  card::require(device);
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
  limit_host_threads(marches_on_gpu ? threads : Space().concurrency());
  if (marches_on_gpu) gpu = make_kokkos_device();
  where = gpu.get();
  threads_of_all = host_threads();
}
Backend::~Backend() {
  limit_host_threads(0);
  where = nullptr;
  gpu.reset();
  try {
    if (!card::fault().empty()) return;  // Kokkos would end the program, before its fault was told
    Kokkos::finalize();
  } catch (const std::exception&) {  // all work is done
  }
}

std::string backend_name() { return Space::name(); }
int backend_threads() { return threads_of_all; }
int scenes_at_once() { return where != nullptr ? where->scenes_at_once() : backend_threads(); }

// Not by Kokkos: a launch on its host space keeps that space to itself, and the work gives to it.
void side_by_side(int count, const std::function<void(int)>& work) {
  on_threads(host_threads(), static_cast<std::size_t>(count),
             [&](std::size_t i) { work(static_cast<int>(i)); });
}

std::string arithmetic() {
#if defined(KOKKOS_ENABLE_CUDA)
  const std::string set = "cuda";
#elif defined(KOKKOS_ENABLE_HIP)
  const std::string set = "hip";
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
