// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/expected_work.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/body/body.hpp"
#include "host/model/areal_size.hpp"
#include "host/model/model.hpp"
#include "host/model/point_contacts.hpp"
#include "host/plan/step_costs.hpp"
#include "host/scene/schemes.hpp"
#include "host/surface/random_profile.hpp"

namespace ra2d {
namespace {

/// Angular frequency [rad/s] of the springs of one node of an areal scene against the bodies'
/// inertia, where every mode yields most (contact_frequency, host/plan/stability.hpp): of a pinned
/// plate psi^2/m is up to 4 over its mass, of a free block 1, 3 and 3.
double areal_contact_frequency(const Scene& scene, int plate_modes) {
  if (scene.contact.law != ContactLaw::penalty) return 0;
  const auto mass = [](const BodySpec& body) {
    return body.density * body.length * body.width * body.thickness;
  };
  const double spring =
      scene.contact.stiffness * scene.spacing * scene.spacing_y.value_or(scene.spacing);
  return std::sqrt(spring * ((plate_modes > 0 ? 4 * plate_modes / mass(scene.resonator) : 0.0) +
                             (rigid_mode_count(scene.slider) > 0 ? 7 / mass(scene.slider) : 0.0)));
}

double smooth_steps_of_tolerance(const Scene& scene) {
  return std::pow(1e-6 / scene.time.tolerance.value_or(usual_tolerance),
                  1.0 / step_costs::smooth_order);
}

/// Steps of the adaptive scheme in a second. Between linear faces one ends where a node passes
/// another. Otherwise the fastest motion (`radians` a second) and the contacts set them: each
/// begins and ends a step.
double steps_a_second(const Scene& scene, double radians, double nodes_in_contact,
                      double contact_duration) {
  if (scene.kind == SceneKind::areal && scene.faces == Faces::smooth)
    return map_steps_a_second(scene, radians, nodes_in_contact);
  if (scene.faces == Faces::smooth) {
    double steps = step_costs::smooth_steps_a_radian * radians;
    if (contact_duration > 0)
      steps = step_costs::smooth_steps_a_free_radian * radians +
              step_costs::smooth_steps_a_contact / contact_duration + scene.speed / scene.spacing;
    return steps * smooth_steps_of_tolerance(scene);
  }
  if (scene.kind == SceneKind::areal)
    return step_costs::row_crossings * nodes_in_contact * scene.speed / scene.spacing +
           step_costs::row_steps_a_radian * radians;
  const double a_crossing =
      nodes_in_contact > 1 ? step_costs::steps_a_wide_crossing : step_costs::steps_a_crossing;
  return a_crossing * scene.speed / scene.spacing + step_costs::steps_a_radian * radians;
}

/// Nodes or cells in contact between random maps that share the load in three places; three without
/// a load.
double touching_on_maps(const Scene& scene) {
  constexpr double contacts = 3;
  const BodySpec& slider = scene.slider;
  double square = 0;  // 1/m^2, of the curvatures of both faces: 12 rq^2/l^4 along each axis
  for (const BodySpec* body : {&scene.resonator, &slider})
    if (body->surface.kind == SurfaceKind::gaussian)
      square +=
          12 * std::pow(body->surface.rq, 2) *
          std::pow(M_PI * std::numbers::sqrt2 / resolve_random(body->surface, body->length).rsm, 4);
  const double mass = slider.density * slider.length * slider.width * slider.thickness;
  const double load = load_force(slider, mass);
  if (!(square > 0) || !(load > 0) || scene.contact.law != ContactLaw::penalty) return contacts;
  const double width =
      width_on_springs(scene.contact.stiffness, 1 / std::sqrt(square), load / contacts);
  const double across = scene.spacing_y.value_or(scene.spacing);
  if (scene.faces == Faces::smooth)  // in each row the cells at both ends, too
    return contacts * std::max(1.0, width / across) * (1 + M_PI / 4 * width / scene.spacing);
  return contacts * std::max(1.0, M_PI / 4 * width * width / (scene.spacing * across));
}

/// Numbers of a scene on which its cost depends.
struct SceneCount {
  double modes = 0, wide = 1;  // of both bodies; the same over counted_modes, at least 1
  double nodes = 0, node = 0;  // of the slider; ns to evaluate one
  double touching = 1;         // nodes, or cells, in contact at once
  double lasts = 0;            // s, a contact; 0: not known
  double forces = 0;           // that travel
  bool areal = false, smooth = false;
};

constexpr double ns = 1e-9;

/// Sets steps and march of a scene with `adaptive`; `radians`: a second, of its fastest motion.
void estimate_adaptive(const Scene& scene, const SceneCount& count, double radians,
                       ExpectedWork& work) {
  const int terms = series_order(scene.time.tolerance.value_or(usual_tolerance));
  work.steps = 1 + scene.duration * steps_a_second(scene, radians, count.touching, count.lasts);
  const double groups =
      !count.areal   ? 0.0
      : count.smooth ? step_costs::row_smooth_groups
                     : step_costs::row_groups * std::sqrt(scene.slider.length * scene.slider.width);
  const double all_nodes =
      (scene.time.nodes == Nodes::all ? 4 * count.node * count.nodes : 0.0) + groups;
  const double step =
      (count.smooth ? step_costs::smooth_step : terms * step_costs::order) *
      (count.areal ? step_costs::row_step + (count.smooth ? step_costs::row_smooth_more_share
                                                          : step_costs::row_more_share) *
                                                count.touching
                   : 1 + step_costs::usual_more_share * (count.touching - 1));
  work.march =
      ns *
      (work.steps *
           (count.wide * (step + terms * count.forces * step_costs::travelling_force) + all_nodes) +
       scene.duration * scene.speed / scene.spacing * step_costs::leap);
}

/// Sets steps and march of a scene with fixed steps.
void estimate_fixed(const Scene& scene, const SceneCount& count, ExpectedWork& work) {
  work.steps = scene.duration / scene.time.step;
  const bool held = holds_forces(scene);
  const int stages = scheme_table(scene.time.scheme).stages;
  const int evaluations = held ? 2 : stages;  // held: without and with the contact's force
  const double all_nodes =
      scene.time.nodes == Nodes::all ? evaluations * count.node * count.nodes : 0.0;
  const bool new_force = held && scene.contact.law == ContactLaw::penalty;
  const double in_contact =
      count.smooth ? (new_force ? step_costs::new_cells : (held ? 1 : stages) * step_costs::cells)
      : held       ? evaluations * step_costs::held
                   : stages * step_costs::contact;
  // on average a contact is half as wide as at the peak of a shock
  const double more =
      0.5 * (count.touching - 1) * evaluations *
      (count.smooth ? step_costs::cell
                    : step_costs::more_nodes * std::max(8.0, count.modes) / count.wide);
  const double solved =
      new_force && !count.smooth && count.touching > 1
          ? step_costs::pressed * std::pow(std::min(count.touching, step_costs::pressed_at_most), 3)
          : 0.0;
  // in contact half of the time
  work.march = ns * work.steps *
                   (count.wide * (0.5 * (step_costs::flight + in_contact + more + solved) +
                                  stages * count.forces * step_costs::travelling_force) +
                    all_nodes) +
               count.wide * search_seconds(scene, work.steps, scene.duration);
}

}  // namespace

double map_steps_a_second(const Scene& scene, double fastest, double touching) {
  return step_costs::smooth_steps_a_radian * fastest * smooth_steps_of_tolerance(scene) *
         (step_costs::row_smooth_steps + step_costs::row_smooth_steps_more * touching);
}

double search_seconds(const Scene& scene, double steps, double duration) {
  if (scene.kind == SceneKind::areal || scene.time.nodes == Nodes::all) return 0;
  return ns * std::min(step_costs::search * steps, step_costs::searches_a_second * duration);
}

ExpectedWork expected_work(const Scene& scene, const UsualContact& contact) {
  constexpr int most_counted = 2000;  // modes
  const auto modes_of = [](const BodySpec& body) { return mode_count(body, most_counted); };
  const auto highest_of = [&](const BodySpec& body) {
    const int elastic = modes_of(body) - rigid_mode_count(body);
    return elastic > 0 ? elastic_frequency(body, elastic - 1) : 0.0;
  };
  const double modes = modes_of(scene.resonator) + modes_of(scene.slider);
  const bool areal = scene.kind == SceneKind::areal;
  const double rows = areal ? scene.slider.width / scene.spacing_y.value_or(scene.spacing) : 1;
  const double nodes = rows * scene.slider.length / scene.spacing;
  const bool smooth = scene.faces == Faces::smooth;
  // nodes, or cells, that a contact is wide
  const double touching = areal
                              ? step_costs::row_contacts * touching_on_maps(scene)
                              : std::max(1.0, contact.width / scene.spacing + (smooth ? 1.0 : 0.0));

  ExpectedWork work;
  work.readiness =
      ns * (step_costs::readiness +
            step_costs::surface_node *
                (areal ? rows * last_node(scene) : scene.resonator.length / scene.spacing) +
            step_costs::surface_node * nodes);
  if (scene.initial == Initial::statics)
    work.readiness += ns * (areal ? step_costs::balanced_pair * modes * modes
                                  : step_costs::balanced_node * nodes * std::max(8.0, modes));
  const SceneCount count{
      .modes = modes,
      .wide = std::max(1.0, modes / step_costs::counted_modes),
      .nodes = nodes,
      .node = areal ? step_costs::row_node + step_costs::row_node_mode * modes : step_costs::node,
      .touching = touching,
      .lasts = contact.duration,
      .forces = static_cast<double>(scene.resonator.moving_forces.size()),
      .areal = areal,
      .smooth = smooth};
  if (is_adaptive(scene)) {
    const double highest = std::max(highest_of(scene.resonator), highest_of(scene.slider));
    const double omega_c = areal ? areal_contact_frequency(scene, modes_of(scene.resonator)) : 0.0;
    // springs side by side
    estimate_adaptive(scene, count, std::max(2 * M_PI * highest, omega_c * std::sqrt(touching)),
                      work);
  } else {
    estimate_fixed(scene, count, work);
  }
  return work;
}

}  // namespace ra2d
