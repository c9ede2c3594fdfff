// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>

#include "host/device/launch.hpp"

/// All that Kokkos cannot say of a GPU or do with it: of NVIDIA's and AMD's in card_gpu.cpp;
/// card_default.cpp serves all others, and the CPU.
namespace ra2d::card {

/// Throws RequestError where there is no GPU of this number. A number less than 0 stands for any.
/// Before Kokkos is started.
void require(int device);
/// Once it has been.
void begin();

/// The command that shows what its memory is used for; empty where it is not known.
std::string monitor();
/// How it is called in reports.
std::string name();
/// Bytes that are free now; 0 where nobody can say.
std::size_t free_memory();
/// Processors with caches of their own that it has; 1 where nobody can say.
int multiprocessors();
/// s, of the clock that its threads read (warp::clock); 1 where they have none.
double tick();
/// Scenes, a team as wide as LanesOf each, that it marches at one moment.
int scenes_at_once();
/// Returns when all work of an instance is done, without a core of the host in the meantime if it
/// can. Throws std::runtime_error with what the driver says.
void wait(const Space& instance);
/// Returns when an instance does nothing any more, whatever has failed: memory of the host that its
/// work reads or writes is not to be given back before.
void settle(const Space& instance) noexcept;
/// The driver's words on work that has failed; empty where none has. After a fault Kokkos would
/// end the program: it is not to be called any more.
std::string fault(const Space& instance = Space());

}  // namespace ra2d::card
