// SPDX-License-Identifier: BSD-3-Clause
// Marches the first steps of a scene, and says what a penalty spring of its stiffness makes of a
// micron.
#include <cstdio>

#include "host/device/backend.hpp"
#include "host/device/batch.hpp"
#include "host/model/model.hpp"
#include "host/scene_file/scene_file.hpp"
#include "kernels/contact/penalty.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const ra2d::Backend backend(1);
  const ra2d::Model model = ra2d::make_model(ra2d::read_scene(argv[1]));
  ra2d::Batch batch({model}, {ra2d::make_start(model)});
  batch.march(1000);
  const double force = ra2d::Penalty{model.node_stiffness}.force(1e-6);
  std::printf("%lld steps, %g N\n", static_cast<long long>(batch.snapshot(0).step), force);
  return batch.snapshot(0).step == 1000 && force > 0 ? 0 : 1;
}
