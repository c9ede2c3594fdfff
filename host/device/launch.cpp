// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/launch.hpp"

#include <Kokkos_Core.hpp>
#include <stdexcept>

namespace ra2d {
namespace {

/// Calls `use` with the form and the shape as constants.
template <Form form, class Use, TeamShape... S>
void choose_shape(const TeamShape& shape, const Use& use, ShapeList<S...>) {
  if (!((S == shape && (use.template operator()<form, S>(), true)) || ...))
    throw std::logic_error("no march was compiled for such a team");
}
template <class Use>
void choose_form(Form form, const Use& use) {
  switch (form) {
    case Form::semi_implicit:
      return use.template operator()<Form::semi_implicit>();
    case Form::staged:
      return use.template operator()<Form::staged>();
    case Form::implicit:
      return use.template operator()<Form::implicit>();
    case Form::adaptive:
      return use.template operator()<Form::adaptive>();
  }
}
template <class Use>
void choose(Form form, const TeamShape& shape, const Use& use) {
  choose_form(form, [&]<Form f>() { choose_shape<f>(shape, use, Shapes<f>{}); });
}

}  // namespace

TeamShape compiled_shape(Form form, int modes) {
  TeamShape shape;
  choose_form(form, [&]<Form f>() { shape = Shapes<f>::smallest(modes); });
  return shape;
}

#if defined(RA2D_WARPS)
void launch_march(const Space& space, const ScenesToMarch& scenes) {
  choose(scenes.form, scenes.shape,
         [&]<Form f, TeamShape S>() { march_listed<f, S>(space, scenes); });
}
MarchScene march_of(Form, const TeamShape&) {
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
                       HostMarch{march_of(scenes.form, scenes.shape), scenes});
}
MarchScene march_of(Form form, const TeamShape& shape) {
  MarchScene march = nullptr;
  choose(form, shape, [&]<Form f, TeamShape S>() { march = march_one<f, S>; });
  return march;
}
#endif

}  // namespace ra2d
