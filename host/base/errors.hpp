// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <stdexcept>
#include <string>

namespace ra2d {

/// The request is wrong: a scene, a profile or an option. Exit status 2.
/// `what()` names every fault, one a line, each with where it is, what was expected and the cure.
struct RequestError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The simulation failed: unstable or not finite. Exit status 3.
struct SimulationError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A file could not be read or written. Exit status 4.
struct FileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace ra2d
