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

/// NVIDIA's GPUs.
namespace ra2d::card {
namespace {

/// The driver's words on a call that failed; empty after a success.
std::string words(cudaError_t status) {
  return status == cudaSuccess
             ? std::string()
             : std::string(cudaGetErrorName(status)) + ": " + cudaGetErrorString(status);
}

void check(cudaError_t status, const char* what) {
  if (status == cudaSuccess) return;
  cudaGetLastError();  // or the next launch would find it
  throw std::runtime_error(std::string("the GPU's driver failed to ") + what + ": " +
                           words(status));
}

/// A thread of the host begins with GPU 0.
void use() { check(cudaSetDevice(Kokkos::device_id()), "take the GPU"); }

const cudaDeviceProp& properties() {
  static const cudaDeviceProp found = [] {
    cudaDeviceProp p{};
    check(cudaGetDeviceProperties(&p, Kokkos::device_id()), "name itself");
    return p;
  }();
  return found;
}

}  // namespace

void require(int device) {
  int count = 0;
  if (const std::string fault = words(cudaGetDeviceCount(&count)); !fault.empty())
    throw RequestError("this build of ra2d marches on a GPU, and the driver has none to offer (" +
                       fault + "). Is 'nvidia-smi' content? A build for the CPU: docs/building.md");
  if (device >= count)
    throw RequestError("--device " + std::to_string(device) + ": there " +
                       (count == 1 ? "is one GPU here, number 0"
                                   : "are " + std::to_string(count) + " GPUs here, from 0 on"));
}

void begin() {
  use();
  // waiting threads sleep, so that their cores can prepare scenes
  check(cudaSetDeviceFlags(cudaDeviceScheduleBlockingSync), "let threads sleep");
}

std::string name() {
  return "GPU " + std::to_string(Kokkos::device_id()) + ", " + properties().name;
}

std::size_t free_memory() {
  std::size_t free = 0, all = 0;
  use();
  return cudaMemGetInfo(&free, &all) == cudaSuccess ? free : 0;
}

int multiprocessors() { return properties().multiProcessorCount; }

/// Most marches take all registers that a thread can have (docs/gpu.md), and a warp for each scene.
int scenes_at_once() {
  constexpr int registers = 256 * LanesOf<Kokkos::Cuda>::width;
  return multiprocessors() * std::max(1, properties().regsPerMultiprocessor / registers);
}

void wait(const Space& instance) {
  const cudaError_t card = cudaSetDevice(Kokkos::device_id()),
                    work = cudaStreamSynchronize(instance.cuda_stream());
  if (work != cudaSuccess) settle(instance);
  check(card, "take the GPU");
  check(work, "finish its work");
}

void settle(const Space& instance) noexcept {
  while (cudaStreamQuery(instance.cuda_stream()) == cudaErrorNotReady)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

std::string fault(const Space& instance) {
  use();
  const cudaError_t work = cudaStreamQuery(instance.cuda_stream()), call = cudaGetLastError();
  return words(work != cudaErrorNotReady ? work : call != cudaErrorNotReady ? call : cudaSuccess);
}

}  // namespace ra2d::card
