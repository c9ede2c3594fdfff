// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/launch.hpp"

#include <Kokkos_Core.hpp>
#include <stdexcept>

namespace ra2d {
namespace {

/// Calls `use` with the form and the number of packs as constants.
template <Form form, class Use, int... K>
void choose_packs(int packs, const Use& use, PackList<K...>) {
  if (!((K == packs && (use.template operator()<form, K>(), true)) || ...))
    throw std::logic_error("no march was compiled for that many packs");
}
template <class Use>
void choose(Form form, int packs, const Use& use) {
  switch (form) {
    case Form::semi_implicit:
      return choose_packs<Form::semi_implicit>(packs, use, Packs{});
    case Form::staged:
      return choose_packs<Form::staged>(packs, use, Packs{});
    case Form::implicit:
      return choose_packs<Form::implicit>(packs, use, Packs{});
    case Form::adaptive:
      return choose_packs<Form::adaptive>(packs, use, Packs{});
  }
}

}  // namespace

int compiled_packs(int needed) { return Packs::smallest(needed); }

#if defined(KOKKOS_ENABLE_CUDA)
void launch_march(const Space& space, const ScenesToMarch& scenes) {
  choose(scenes.form, scenes.packs, [&]<Form f, int K>() { march_listed<f, K>(space, scenes); });
}
MarchScene march_of(Form, int) {
  throw std::logic_error("a build for a GPU has no marches for the host");
}
#else
namespace {

/// A launch on the CPU: of marches that were compiled for one scene.
struct HostMarch {
  MarchScene march;
  ScenesToMarch scenes;

  void operator()(const Kokkos::TeamPolicy<Space>::member_type& member) const {
    const int scene = scenes.scenes[member.league_rank()];
    const Kokkos::Timer timer;
    march(scenes.tables[scene], scenes.states[scene], scenes.targets[scene]);
    scenes.seconds[scene] = timer.seconds();
  }
};

}  // namespace

void launch_march(const Space& space, const ScenesToMarch& scenes) {
  Kokkos::parallel_for("ra2d::march", Kokkos::TeamPolicy<Space>(space, scenes.count, 1),
                       HostMarch{march_of(scenes.form, scenes.packs), scenes});
}
MarchScene march_of(Form form, int packs) {
  MarchScene march = nullptr;
  choose(form, packs, [&]<Form f, int K>() { march = march_one<f, K>; });
  return march;
}
#endif

}  // namespace ra2d
