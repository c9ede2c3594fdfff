// SPDX-License-Identifier: BSD-3-Clause
#include "bench/peers/shock_log.hpp"

#include <algorithm>

namespace ra2d::peers {

ShockLog::Open& ShockLog::open(std::int64_t serial) {
  return *std::find_if(open_.begin(), open_.end(),
                       [&](const Open& each) { return each.shock.serial == serial; });
}

std::int64_t ShockLog::shock_of(int node) const {
  return std::find_if(touching_.begin(), touching_.end(),
                      [&](const auto& each) { return each.first == node; })
      ->second;
}

void ShockLog::onset(int node, double t) {
  std::int64_t found = -1;
  for (const auto& [other, serial] : touching_)
    if (other == node - 1 || other == node + 1)
      found = found < 0 ? serial : std::min(found, serial);
  if (found < 0) {
    found = begun_++;
    open_.push_back({Shock{.serial = static_cast<long>(found), .start = t}, 0});
  }
  for (const int neighbour : {node - 1, node + 1}) {
    const auto at = std::find_if(touching_.begin(), touching_.end(),
                                 [&](const auto& each) { return each.first == neighbour; });
    if (at == touching_.end() || at->second == found) continue;
    const std::int64_t younger = at->second;
    Open& kept = open(found);
    const Open& lost = open(younger);
    kept.shock.peak_force = std::max(kept.shock.peak_force, lost.shock.peak_force);
    kept.nodes += lost.nodes;
    for (auto& each : touching_)
      if (each.second == younger) each.second = found;
    std::erase_if(open_, [&](const Open& each) { return each.shock.serial == younger; });
  }
  touching_.emplace_back(node, found);
  ++open(found).nodes;
}

void ShockLog::release(int node, double t) {
  const std::int64_t serial = shock_of(node);
  std::erase_if(touching_, [&](const auto& each) { return each.first == node; });
  if (--open(serial).nodes == 0) end(serial, t);
}

void ShockLog::end(std::int64_t serial, double t) {
  Shock shock = open(serial).shock;
  shock.duration = t - shock.start;
  ended_.push_back(shock);
  std::erase_if(open_, [&](const Open& each) { return each.shock.serial == serial; });
}

void ShockLog::peak(std::int64_t shock, double force) {
  double& peak = open(shock).shock.peak_force;
  peak = std::max(peak, force);
}

std::vector<Shock> ShockLog::finish(double t) {
  while (!open_.empty()) end(open_.front().shock.serial, t);
  std::sort(ended_.begin(), ended_.end(),
            [](const Shock& a, const Shock& b) { return a.serial < b.serial; });
  return std::move(ended_);
}

}  // namespace ra2d::peers
