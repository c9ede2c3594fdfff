// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "host/device/device.hpp"

/// The GPU that Kokkos was started with.
namespace ra2d {

/// Throws RequestError where there is no GPU of this number. In builds for CUDA, a number less than
/// 0 stands for any; in the others for none.
void require_gpu(int device);

// In builds for CUDA, once Kokkos has been started:
std::unique_ptr<Device> make_cuda_device();
/// Whether none of its work has failed.
bool cuda_device_works();

}  // namespace ra2d
