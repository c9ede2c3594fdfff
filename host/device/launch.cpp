// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/launch.hpp"

namespace ra2d {
namespace {

template <Form form, int... K>
void launch(int packs, const TablesView& tables, const StatesView& states, const ScenesView& scenes,
            std::int64_t target, PackList<K...>) {
  (void)((K == packs && (march<form, K>(tables, states, scenes, target), true)) || ...);
}

}  // namespace

int compiled_packs(int needed) { return Packs::smallest(needed); }

void launch_march(Form form, int packs, const TablesView& tables, const StatesView& states,
                  const ScenesView& scenes, std::int64_t target) {
  switch (form) {
    case Form::semi_implicit:
      return launch<Form::semi_implicit>(packs, tables, states, scenes, target, Packs{});
    case Form::staged:
      return launch<Form::staged>(packs, tables, states, scenes, target, Packs{});
    case Form::held:
      return launch<Form::held>(packs, tables, states, scenes, target, Packs{});
    case Form::adaptive:
      return launch<Form::adaptive>(packs, tables, states, scenes, target, Packs{});
  }
}

}  // namespace ra2d
