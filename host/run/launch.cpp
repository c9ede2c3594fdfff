// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/launch.hpp"

namespace ra2d {
namespace {

template <int... K>
void launch(int packs, const TablesView& tables, const StatesView& states, std::int64_t target,
            PackList<K...>) {
  (void)((K == packs && (march<K>(tables, states, target), true)) || ...);
}

}  // namespace

int compiled_packs(int needed) { return Packs::smallest(needed); }

void launch_march(int packs, const TablesView& tables, const StatesView& states,
                  std::int64_t target) {
  launch(packs, tables, states, target, Packs{});
}

}  // namespace ra2d
