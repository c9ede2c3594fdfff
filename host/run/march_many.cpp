// SPDX-License-Identifier: BSD-3-Clause
// The march for as many modes as are taken.
#include "host/run/march_instance.hpp"

namespace ra2d {

template void march<Packs::at(5)>(const TablesView&, const StatesView&, std::int64_t);

}  // namespace ra2d
