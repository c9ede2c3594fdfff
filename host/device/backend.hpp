// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <string>

/// Where scenes are marched.
namespace ra2d {

/// Starts Kokkos, once in a program and for as long as anything here is used. `threads` = 0 leaves
/// their number to the machine; `device` is the number of the GPU to use, less than 0 leaves it to
/// Kokkos (KOKKOS_VISIBLE_DEVICES, or the first). Throws RequestError where there is no such GPU.
class Backend {
 public:
  explicit Backend(int threads = 0, int device = -1);
  ~Backend();
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
};

/// The name of Kokkos' default execution space, and how many threads of the host work side by side.
std::string backend_name();
int backend_threads();

/// The GPU in words, as "GPU 0, NVIDIA H200"; empty where scenes are marched on the CPU.
std::string backend_device();

/// Memory that scenes may take together [bytes]: nine tenths of what a GPU has free now; 0 on a
/// CPU, where nothing is set aside.
std::size_t backend_memory();

/// Scenes that are marched at one moment: as many as there are threads, on a GPU as its registers
/// hold.
int scenes_at_once();

/// Calls `work` for 0, ..., count - 1 on the host's threads (host/system/host_threads.hpp): who is
/// done takes the next. Rethrows the first exception once all that were begun have ended.
void side_by_side(int count, const std::function<void(int)>& work);

/// The arithmetic of a build, as far as the bits of its answers depend on it: "avx512", "avx2",
/// "x86-64", "cuda", and the number of lanes.
std::string arithmetic();

/// Values that a team computes side by side: of a SIMD register, or the threads of a warp.
int backend_lanes();

}  // namespace ra2d
