// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "host/commands/commands.hpp"
#include "host/plan/plan.hpp"
#include "host/run/batch.hpp"

namespace ra2d {

int plan_command(const CommonOptions& common) {
  const Scene scene = read_scene(common.scene, common.overrides);
  const Backend backend(common.threads);
  const Model model = make_model(scene);
  const ModalStart start = make_start(model);
  const Batch batch({model}, {start});
  const Plan plan = make_plan(model, batch.bytes(), static_cast<int>(start.loaded_nodes.size()));
  if (!common.quiet) fmt::print("# {}, complete:\n{}\n", common.scene.string(), echo(scene));
  fmt::print("{}", describe(model, plan));
  return done;
}

}  // namespace ra2d
