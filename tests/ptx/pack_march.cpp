// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ptx/pack_march.hpp"

namespace ra2d::test {

void march_on_pack(SceneOnLanes& scene, std::int64_t target) {
  switch (scene.tables().scheme.form) {
    case Form::semi_implicit:
      return march_form<Form::semi_implicit>(scene, target);
    case Form::staged:
      return march_form<Form::staged>(scene, target);
    case Form::implicit:
      return march_form<Form::implicit>(scene, target);
    case Form::adaptive:
      return march_form<Form::adaptive>(scene, target);
  }
}

}  // namespace ra2d::test
