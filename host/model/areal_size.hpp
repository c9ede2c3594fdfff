// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/base/errors.hpp"
#include "host/scene/scene.hpp"

/// How large an areal scene is, from its keys alone.
namespace ra2d {

/// Nodes beyond which a spline feels a height by less than roundings: (2 - sqrt 3)^28 is 1e-16.
inline constexpr int spline_reach = 28;

/// Bytes of memory: the program, samples on their way to the file.
inline constexpr double program_memory = 100e6;

/// Nodes of the slider in a row of an areal scene.
double nodes_along(const Scene& scene);

/// The last node of the resonator that the slider comes to.
double last_node(const Scene& scene);

/// Memory that a run of an areal scene takes at its peak [bytes], about: maps, their tables, lists
/// of nodes.
double areal_memory(const Scene& scene);

/// A run would take more memory than is free.
struct MemoryShortage : RequestError {
  MemoryShortage(const std::string& message, double needed_bytes)
      : RequestError(message), needed{needed_bytes} {}
  double needed;  // bytes
};

/// Throws MemoryShortage where a run would take more than `available` bytes, with the spacing that
/// would do.
void require_areal_memory(const Scene& scene, double available);

}  // namespace ra2d
