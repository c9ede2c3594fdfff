// SPDX-License-Identifier: BSD-3-Clause
#include "tests/kernels/plain_march.hpp"

namespace ra2d::test {

template void plain_march<Form::staged>(const SceneTables&, SceneState&, std::int64_t);

}  // namespace ra2d::test
