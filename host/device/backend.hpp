// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <string>

/// Where scenes are marched.
namespace ra2d {

/// Starts Kokkos, once in a program and for as long as anything here is used. `threads` = 0 leaves
/// their number to the machine.
class Backend {
 public:
  explicit Backend(int threads = 0);
  ~Backend();
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
};

/// The name of Kokkos' default execution space, and how many threads it has.
std::string backend_name();
int backend_threads();

/// Scenes that are marched at one moment: as many as there are threads, on a GPU all.
int scenes_at_once();

/// Calls `work` for 0, ..., count - 1 on the host's threads: who is done takes the next. Rethrows the
/// first exception once all have ended.
void side_by_side(int count, const std::function<void(int)>& work);

/// What a build computes with, as far as the bits of its answers know it: "avx512", "avx2", "x86-64",
/// "cuda", and the number of lanes.
std::string arithmetic();

/// Values that a team computes side by side: of a SIMD register, or the threads of a warp.
int backend_lanes();

}  // namespace ra2d
