// SPDX-License-Identifier: BSD-3-Clause
// The march for a few packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

template void march<ShortPacks::at(0), short_series>(const TablesView&, const StatesView&, std::int64_t);
template void march<ShortPacks::at(1), short_series>(const TablesView&, const StatesView&, std::int64_t);
template void march<ShortPacks::at(2), short_series>(const TablesView&, const StatesView&, std::int64_t);

}  // namespace ra2d
