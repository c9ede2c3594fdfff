// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/launch.hpp"

namespace ra2d {
namespace {

template <int Q, int... K>
void launch(int packs, const TablesView& tables, const StatesView& states, std::int64_t target,
            PackList<K...>) {
  (void)((K == packs && (march<K, Q>(tables, states, target), true)) || ...);
}

}  // namespace

Shape compiled_shape(const Shape& needed) {
  if (needed.quads == short_series) return {ShortPacks::smallest(needed.packs), short_series};
  return {LongPacks::smallest(needed.packs), long_series};
}

void launch_march(const Shape& shape, const TablesView& tables, const StatesView& states,
                  std::int64_t target) {
  if (shape.quads == short_series)
    launch<short_series>(shape.packs, tables, states, target, ShortPacks{});
  else
    launch<long_series>(shape.packs, tables, states, target, LongPacks{});
}

}  // namespace ra2d
