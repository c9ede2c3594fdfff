// SPDX-License-Identifier: BSD-3-Clause
#include <Kokkos_Core.hpp>
#include <algorithm>
#include <string>

#include "host/base/errors.hpp"
#include "host/device/card.hpp"
#include "kernels/lanes.hpp"

/// As far as Kokkos knows. It ends the program itself where work fails.
namespace ra2d::card {

void require(int device) {
  if (!marches_on_gpu && device >= 0)
    throw RequestError("--device " + std::to_string(device) +
                       ": this build of ra2d marches on the CPU (" + Space::name() +
                       "); docs/building.md says how to build for a GPU");
}

void begin() {}

std::string monitor() { return {}; }

std::string name() {
  return std::string(Space::name()) +
         (marches_on_gpu ? " " + std::to_string(Kokkos::device_id()) : "");
}

std::size_t free_memory() { return 0; }

int multiprocessors() { return 1; }
double tick() { return 1.0; }

int scenes_at_once() { return std::max(1, Space().concurrency() / LanesOf<Space>::vector_length); }

void wait(const Space& instance) { instance.fence("ra2d: wait"); }
void settle(const Space& instance) noexcept { instance.fence("ra2d: settle"); }

std::string fault(const Space&) { return {}; }

}  // namespace ra2d::card
