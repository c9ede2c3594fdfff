// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/plan.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/print.hpp"
#include "host/device/backend.hpp"
#include "host/device/batch.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {

int plan_command(const CommonOptions& common) {
  const Scene scene = read_scene(common.scene, common.overrides);
  const Backend backend(common.threads, common.device);
  const Model model = make_model(scene);
  const ModalStart start = make_start(model);
  const Batch batch({model}, {start});
  const Plan plan = make_plan(model, batch.bytes(), start);
  say_doubts(model.doubts, common.quiet);
  if (!common.quiet) print("# {}, complete:\n{}\n", printable(common.scene.string()), echo(scene));
  print_text(describe(model, plan));
  return done;
}

}  // namespace ra2d
