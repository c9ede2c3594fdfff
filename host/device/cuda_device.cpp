// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/cuda_device.hpp"

#include <Kokkos_Core.hpp>

#include <string>

#include "host/base/errors.hpp"

#if defined(KOKKOS_ENABLE_CUDA)
#include <algorithm>
#include <mutex>
#include <new>
#include <stdexcept>

#include "host/device/launch.hpp"

namespace ra2d {
namespace {

/// The driver's words on a call that failed; empty after a success.
std::string fault_of(cudaError_t status) {
  return status == cudaSuccess
             ? std::string()
             : std::string(cudaGetErrorName(status)) + ": " + cudaGetErrorString(status);
}

void check(cudaError_t status, const char* what) {
  if (status == cudaSuccess) return;
  cudaGetLastError();  // or the next launch would find it
  if (status == cudaErrorMemoryAllocation) throw std::bad_alloc();
  throw std::runtime_error(std::string("the GPU's driver failed to ") + what + ": " +
                           fault_of(status));
}

/// A thread of the host begins with GPU 0.
void use_device() { check(cudaSetDevice(Kokkos::device_id()), "take the GPU"); }

class CudaQueue : public DeviceQueue {
 public:
  CudaQueue() {
    use_device();
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "make a stream");
    // waiting threads sleep, so that their cores can prepare scenes
    check(cudaEventCreateWithFlags(&done_, cudaEventBlockingSync | cudaEventDisableTiming),
          "make an event");
  }
  ~CudaQueue() override {
    // after an error of the GPU Kokkos would end the program, and its message would be lost
    if (cudaStreamSynchronize(stream_) != cudaSuccess) {
      static_cast<void>(space_.release());
      return;
    }
    space_.reset();
    cudaEventDestroy(done_);
    cudaStreamDestroy(stream_);
  }
  CudaQueue(const CudaQueue&) = delete;
  CudaQueue& operator=(const CudaQueue&) = delete;

  void zero(char* device, std::size_t bytes) override {
    use_device();
    check(cudaMemsetAsync(device, 0, bytes, stream_), "clear memory");
  }
  void upload(char* device, const void* host, std::size_t bytes) override {
    use_device();
    check(cudaMemcpyAsync(device, host, bytes, cudaMemcpyHostToDevice, stream_), "copy to it");
  }
  void fetch(void* host, const char* device, std::size_t bytes) override {
    use_device();
    check(cudaMemcpyAsync(host, device, bytes, cudaMemcpyDeviceToHost, stream_), "copy from it");
  }
  void march(const ScenesToMarch& scenes) override {
    use_device();
    static std::mutex one_at_a_time;  // what Kokkos knows of a kernel it writes down without a lock
    const std::lock_guard lock(one_at_a_time);
    if (!space_) space_ = std::make_unique<Kokkos::Cuda>(stream_);
    launch_march(*space_, scenes);
    // Kokkos does not ask. Memory that a launch lacks is none that fewer scenes would leave.
    if (const cudaError_t status = cudaGetLastError(); status != cudaSuccess)
      throw std::runtime_error("the GPU's driver failed to begin a launch: " + fault_of(status));
  }
  void wait() override {
    use_device();
    check(cudaEventRecord(done_, stream_), "finish a launch");
    check(cudaEventSynchronize(done_), "finish a launch");
  }

 private:
  cudaStream_t stream_ = nullptr;
  cudaEvent_t done_ = nullptr;
  std::unique_ptr<Kokkos::Cuda> space_;
};

class CudaDevice : public Device {
 public:
  CudaDevice() { check(cudaGetDeviceProperties(&properties_, Kokkos::device_id()), "name itself"); }
  char* allocate(std::size_t bytes) override {
    use_device();
    void* block = nullptr;
    check(cudaMalloc(&block, bytes), "give memory");
    return static_cast<char*>(block);
  }
  void release(char* block) noexcept override {
    cudaSetDevice(Kokkos::device_id());  // the thread that used the device has reported faults
    cudaFree(block);
  }
  char* allocate_on_host(std::size_t bytes) override {
    use_device();
    void* block = nullptr;
    check(cudaHostAlloc(&block, bytes, cudaHostAllocPortable), "give memory of the host");
    return static_cast<char*>(block);
  }
  void release_on_host(char* block) noexcept override {
    cudaSetDevice(Kokkos::device_id());
    cudaFreeHost(block);
  }
  std::unique_ptr<DeviceQueue> make_queue() override { return std::make_unique<CudaQueue>(); }
  /// A march takes all registers that a thread can have (docs/gpu.md), and each scene is a warp.
  int scenes_at_once() const override {
    constexpr int registers = 256 * LanesOf<Kokkos::Cuda>::width;
    return properties_.multiProcessorCount *
           std::max(1, properties_.regsPerMultiprocessor / registers);
  }
  std::string name() const override {
    return "GPU " + std::to_string(Kokkos::device_id()) + ", " + properties_.name;
  }
  std::size_t free_memory() const override {
    std::size_t free = 0, all = 0;
    use_device();
    return cudaMemGetInfo(&free, &all) == cudaSuccess ? free : 0;
  }

 private:
  cudaDeviceProp properties_{};
};

}  // namespace

void require_gpu(int device) {
  int count = 0;
  if (const std::string fault = fault_of(cudaGetDeviceCount(&count)); !fault.empty())
    throw RequestError("this build of ra2d marches on a GPU, and the driver has none to offer (" +
                       fault + "). Is 'nvidia-smi' content? A build for the CPU: docs/building.md");
  if (device >= count)
    throw RequestError("--device " + std::to_string(device) + ": there " +
                       (count == 1 ? "is one GPU here, number 0"
                                   : "are " + std::to_string(count) + " GPUs here, from 0 on"));
}

bool cuda_device_works() { return cudaDeviceSynchronize() == cudaSuccess; }

std::unique_ptr<Device> make_cuda_device() { return std::make_unique<CudaDevice>(); }

}  // namespace ra2d
#else

namespace ra2d {

void require_gpu(int device) {
  if (device >= 0)
    throw RequestError(
        "--device " + std::to_string(device) + ": this build of ra2d marches on the CPU (" +
        Kokkos::DefaultExecutionSpace::name() + "); docs/building.md says how to build for a GPU");
}

}  // namespace ra2d
#endif
