// SPDX-License-Identifier: BSD-3-Clause
// The march for a few packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

template void march<Packs::at(0)>(const TablesView&, const StatesView&, std::int64_t);
template void march<Packs::at(1)>(const TablesView&, const StatesView&, std::int64_t);
template void march<Packs::at(2)>(const TablesView&, const StatesView&, std::int64_t);

}  // namespace ra2d
