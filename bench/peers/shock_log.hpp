// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "host/store/store.hpp"

/// Shocks from the onsets and releases of nodes: pieces of contact connected in space (neighbouring
/// nodes) and time. Two that meet become one, under the older's number.
namespace ra2d::peers {

class ShockLog {
 public:
  void onset(int node, double t);
  void release(int node, double t);
  /// The number of a touching node's shock.
  std::int64_t shock_of(int node) const;
  /// The largest force [N] that a shock has had.
  void peak(std::int64_t shock, double force);
  /// Ends what goes on. All shocks in order of their start.
  std::vector<Shock> finish(double t);

 private:
  struct Open {
    Shock shock;
    int nodes = 0;
  };
  Open& open(std::int64_t serial);
  void end(std::int64_t serial, double t);

  std::vector<std::pair<int, std::int64_t>> touching_;  // node, shock
  std::vector<Open> open_;
  std::vector<Shock> ended_;
  std::int64_t begun_ = 0;
};

}  // namespace ra2d::peers
