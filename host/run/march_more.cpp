// SPDX-License-Identifier: BSD-3-Clause
// The march for more packs of modes.
#include "host/run/march_instance.hpp"

namespace ra2d {

template void march<Packs::at(3)>(const TablesView&, const StatesView&, std::int64_t);
template void march<Packs::at(4)>(const TablesView&, const StatesView&, std::int64_t);

}  // namespace ra2d
