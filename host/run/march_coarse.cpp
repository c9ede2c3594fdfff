// SPDX-License-Identifier: BSD-3-Clause
// The march for scenes with few nodes to a wavelength.
#include "host/run/march_instance.hpp"

namespace ra2d {

template void march<LongPacks::at(0), long_series>(const TablesView&, const StatesView&, std::int64_t);
template void march<LongPacks::at(1), long_series>(const TablesView&, const StatesView&, std::int64_t);

}  // namespace ra2d
