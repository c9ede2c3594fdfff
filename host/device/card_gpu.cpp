// SPDX-License-Identifier: BSD-3-Clause
#include <Kokkos_Core.hpp>
#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#include "host/base/errors.hpp"
#include "host/device/card.hpp"
#include "kernels/lanes.hpp"
#include "kernels/warp.hpp"

// HIP has CUDA's calls, under the same names.
#if defined(KOKKOS_ENABLE_HIP)
#define RA2D_DRIVER(name) hip##name
#else
#define RA2D_DRIVER(name) cuda##name
#endif

/// NVIDIA's GPUs, and AMD's.
namespace ra2d::card {
namespace {

#if defined(KOKKOS_ENABLE_HIP)
using Properties = hipDeviceProp_t;
/// A compute unit has four processors, each with room for one warp that takes all registers.
int warps_at_once(const Properties&) { return 4; }
auto stream(const Space& instance) { return instance.hip_stream(); }
#else
using Properties = cudaDeviceProp;
/// Most marches take all registers that a thread can have (docs/gpu.md).
int warps_at_once(const Properties& of) {
  constexpr int registers = 256 * warp::size;
  return std::max(1, of.regsPerMultiprocessor / registers);
}
auto stream(const Space& instance) { return instance.cuda_stream(); }
#endif
using Error = RA2D_DRIVER(Error_t);
constexpr Error success = RA2D_DRIVER(Success), not_ready = RA2D_DRIVER(ErrorNotReady);

/// The driver's words on a call that failed; empty after a success.
std::string words(Error status) {
  return status == success ? std::string()
                           : std::string(RA2D_DRIVER(GetErrorName)(status)) + ": " +
                                 RA2D_DRIVER(GetErrorString)(status);
}

void check(Error status, const char* what) {
  if (status == success) return;
  static_cast<void>(RA2D_DRIVER(GetLastError)());  // or the next launch would find it
  throw std::runtime_error(std::string("the GPU's driver failed to ") + what + ": " +
                           words(status));
}

/// A thread of the host begins with GPU 0.
void use() { check(RA2D_DRIVER(SetDevice)(Kokkos::device_id()), "take the GPU"); }

const Properties& properties() {
  static const Properties found = [] {
    Properties p{};
    check(RA2D_DRIVER(GetDeviceProperties)(&p, Kokkos::device_id()), "name itself");
    return p;
  }();
  return found;
}

}  // namespace

void require(int device) {
  int count = 0;
  if (const std::string fault = words(RA2D_DRIVER(GetDeviceCount)(&count)); !fault.empty())
    throw RequestError("this build of ra2d marches on a GPU, and the driver has none to offer (" +
                       fault + "). Is '" + monitor() +
                       "' content? A build for the CPU: docs/building.md");
  if (device >= count)
    throw RequestError("--device " + std::to_string(device) + ": there " +
                       (count == 1 ? "is one GPU here, number 0"
                                   : "are " + std::to_string(count) + " GPUs here, from 0 on"));
}

std::string monitor() {
#if defined(KOKKOS_ENABLE_HIP)
  return "rocm-smi";
#else
  return "nvidia-smi";
#endif
}

void begin() {
  use();
  // waiting threads sleep, so that their cores can prepare scenes
  check(RA2D_DRIVER(SetDeviceFlags)(RA2D_DRIVER(DeviceScheduleBlockingSync)), "let threads sleep");
}

std::string name() {
  return "GPU " + std::to_string(Kokkos::device_id()) + ", " + properties().name;
}

std::size_t free_memory() {
  std::size_t free = 0, all = 0;
  use();
  return RA2D_DRIVER(MemGetInfo)(&free, &all) == success ? free : 0;
}

int multiprocessors() { return properties().multiProcessorCount; }

double tick() {
#if defined(KOKKOS_ENABLE_HIP)
  int kilohertz = 0;
  check(hipDeviceGetAttribute(&kilohertz, hipDeviceAttributeWallClockRate, Kokkos::device_id()),
        "tell the rate of its clock");
  return 1e-3 / kilohertz;
#else
  return 1e-9;
#endif
}

int scenes_at_once() {
  return multiprocessors() * warps_at_once(properties()) * (warp::size / LanesOf<Space>::width);
}

void wait(const Space& instance) {
  const Error card = RA2D_DRIVER(SetDevice)(Kokkos::device_id()),
              work = RA2D_DRIVER(StreamSynchronize)(stream(instance));
  if (work != success) settle(instance);
  check(card, "take the GPU");
  check(work, "finish its work");
}

void settle(const Space& instance) noexcept {
  while (RA2D_DRIVER(StreamQuery)(stream(instance)) == not_ready)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

std::string fault(const Space& instance) {
  use();
  const Error work = RA2D_DRIVER(StreamQuery)(stream(instance)), call = RA2D_DRIVER(GetLastError)();
  return words(work != not_ready ? work : call != not_ready ? call : success);
}

}  // namespace ra2d::card
