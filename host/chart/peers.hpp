// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/run/timed_run.hpp"

/// Integrators of other libraries on the same equations, run by the program ra2d_peers
/// (bench/peers).
namespace ra2d {

/// One of them, as ra2d_peers calls it.
struct Peer {
  std::string integrator;  // "cvode-adams", "cvode-bdf", "dopri5"
  std::string nodes;       // "candidates", "all"
  double tolerance = 0;
};

struct PeerRun {
  std::string failure;  // what went wrong; empty when nothing did
  State state;
  double seconds = 0;               // of the integration alone
  std::vector<double> shock_start;  // s, in order
};

/// The program ra2d_peers of the build that this program is from; empty where there is none.
std::filesystem::path find_peers();

/// A scene that ra2d_peers runs.
class Peers {
 public:
  /// Throws FileError.
  Peers(std::filesystem::path program, const Scene& scene);
  ~Peers();
  Peers(const Peers&) = delete;
  Peers& operator=(const Peers&) = delete;

  /// From t = 0 to `until` [s]; given up after `limit` seconds of wall time.
  PeerRun run(const Peer& peer, double until, double limit) const;

 private:
  std::filesystem::path program_;
  int scene_;  // a file without a name, which the system removes
};

}  // namespace ra2d
