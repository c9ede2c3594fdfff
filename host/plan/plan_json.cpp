// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>

#include <algorithm>

#include "host/base/quiet_nan.hpp"
#include "host/plan/plan.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite

Json unless_zero(double value) { return value == 0 ? Json() : Json(value); }

Json body_json(const Scene& scene, const BodySpec& spec, const BodyPlan& plan) {
  const bool has_error = plan.highest > 0 && !is_adaptive(scene);
  return {{"support", supports.name(spec.support)},
          {"length", spec.length},
          {"thickness", unless_zero(spec.thickness)},
          {"rigid_modes", plan.rigid_modes},
          {"elastic_modes", plan.elastic_modes},
          {"highest_frequency", unless_zero(plan.highest)},
          {"next_frequency", unless_zero(plan.next)},
          {"nodes", plan.nodes},
          {"nodes_to_shortest_wave", unless_zero(plan.wavelength_nodes)},
          {"damping_error", has_error ? plan.error.damping : quiet_nan},
          {"period_error", has_error ? plan.error.period : quiet_nan}};
}

Json limits_json(const Scene& scene, const SchemePlan& plan, const TimeSettings& own) {
  const StepLimits& limits = plan.limits;
  const bool spring = scene.contact.law == ContactLaw::penalty;
  const bool has_choice = spring && plan.choice.scheme == SchemeKind::backward_euler;
  return {
      {"scheme", schemes.name(plan.choice.scheme)},
      {"contact_force", has_choice ? Json(force_times.name(plan.choice.contact_force)) : Json()},
      {"is_chosen", plan.choice == own},
      {"holds_every_step", std::isinf(limits.holds())},
      {"holds_up_to", limits.holds()},
      {"free_modes_up_to", limits.modes},
      {"binding_frequency", unless_zero(limits.binding_frequency)},
      {"one_node_up_to", spring ? limits.contact_one : quiet_nan},
      {"many_nodes_up_to", spring ? limits.contact_many : quiet_nan},
      {"many_nodes", limits.many}};
}

Json contact_json(const AsperityContact& contact) {
  return {{"stiffness", unless_zero(contact.stiffness)},
          {"shock_stiffness", unless_zero(contact.shock)},
          {"shock_force", unless_zero(contact.peak)},
          {"shock_duration", unless_zero(contact.duration)}};
}

Json asperities_json(const Scene& scene, const Asperities& a) {
  if (a.radius == 0 || std::isinf(a.modulus)) return {};
  return {{"modulus", a.modulus},
          {"radius", a.radius},
          {"load", unless_zero(a.load)},
          {"hertz_stiffness", a.hertz},
          {"by_material", contact_json(a.material)},
          {"by_contact_stiffness",
           scene.contact.law == ContactLaw::penalty ? contact_json(a.springs) : Json()}};
}

Json points_json(const PointContacts& points) {
  if (points.radius == 0) return {};
  return {{"modulus", points.modulus},
          {"radius", points.radius},
          {"contacts", points.contacts},
          {"load", points.load},
          {"hertz_width", 2 * points.hertz.half_width},
          {"hertz_contact_stiffness", points.hertz.stiffness},
          {"hertz_stiffness", points.hertz.kappa},
          {"width", points.width},
          {"width_in_spacings", points.nodes},
          {"shock_error", points.shock_error}};
}

Json choice_json(const FaceChoice& choice) {
  return {{"faces", face_choices.name(choice.faces)},
          {"spacing", choice.spacing},
          {"errors",
           {{"v_rms", choice.errors.level},
            {"shock_rate", choice.errors.rate},
            {"shock_duration_median", choice.errors.duration}}},
          {"seconds", choice.seconds},
          {"is_chosen", choice.is_own}};
}

Json faces_json(const Scene& scene, const Plan& plan) {
  if (plan.faces.list.empty()) return {};
  const bool spring = scene.contact.law == ContactLaw::penalty;
  Json json{{"contact_width", spring ? plan.asperities.width : quiet_nan},
            {"contact_depth", spring ? plan.asperities.depth : quiet_nan},
            {"accuracy", face_accuracy},
            {"choices", Json::array()},
            {"cheapest", Json()},
            {"set", Json()}};
  for (const FaceChoice& choice : plan.faces.list) json["choices"].push_back(choice_json(choice));
  if (plan.faces.best) {
    json["cheapest"] = choice_json(*plan.faces.best);
    json["set"] = set_words(*plan.faces.best);
  }
  return json;
}

Json time_json(const Scene& scene, const Plan& plan) {
  const bool adaptive = is_adaptive(scene);
  Json json{{"scheme", schemes.name(scene.time.scheme)},
            {"step", adaptive ? quiet_nan : scene.time.step},
            {"steps", adaptive ? Json() : Json(plan.steps)},
            {"steps_to_a_node", adaptive ? Json() : unless_zero(plan.steps_per_node)},
            {"tolerance", adaptive ? scene.time.tolerance.value_or(usual_tolerance) : quiet_nan},
            {"limits", Json::array()}};
  for (const SchemePlan& one : plan.schemes)
    json["limits"].push_back(limits_json(scene, one, plan.own.choice));
  return json;
}

Json sound_json(const SoundPlan& plan) {
  if (plan.microphones == 0) return {};
  return {
      {"microphones", plan.microphones}, {"seconds", plan.seconds}, {"memory_bytes", plan.memory}};
}

}  // namespace

std::string plan_json(const Model& model, const Plan& plan) {
  const Scene& scene = model.scene;
  const bool spring = scene.contact.law == ContactLaw::penalty;
  const SlowestMode& slowest = plan.slowest;
  const Json json{
      {"file", scene.file.string()},
      {"title", title(scene)},
      {"scene", echo(scene)},
      {"resonator", body_json(scene, scene.resonator, plan.resonator)},
      {"slider", body_json(scene, scene.slider, plan.slider)},
      {"kind", scene_kinds.name(scene.kind)},
      {"spacing", scene.spacing},
      {"spacing_y", model.is_areal ? Json(model.spacing_y) : Json()},
      {"side", model.is_areal ? Json(model.side) : Json()},
      {"rows", model.rows},
      {"gap", plan.delta},
      {"contact",
       {{"law", contact_laws.name(scene.contact.law)},
        {"node_stiffness", spring ? model.node_stiffness : quiet_nan},
        {"shock_duration", unless_zero(plan.contact_period)}}},
      {"asperities", asperities_json(scene, plan.asperities)},
      {"point_contacts", points_json(plan.points)},
      {"faces", faces_json(scene, plan)},
      {"time", time_json(scene, plan)},
      {"ringing",
       {{"body", *slowest.body == '\0' ? Json() : Json(slowest.body)},
        {"frequency", unless_zero(slowest.frequency)},
        {"decay_60_db", unless_zero(slowest.decay)},
        {"duration", scene.duration},
        {"from", scene.output.from},
        {"initial", initial_states.name(scene.initial)}}},
      {"cost",
       {{"seconds_without_contact", plan.seconds_free},
        {"seconds_with_a_node_in_contact", plan.seconds_one},
        {"seconds_with_many_nodes", plan.many_nodes > 1 ? plan.seconds_many : quiet_nan},
        {"many_nodes", plan.many_nodes},
        {"touching_at_start", plan.touching}}},
      {"memory_bytes", plan.memory},
      {"file_bytes", plan.file},
      {"sound", sound_json(plan.sound)},
      {"samples", plan.samples},
      {"rate", scene.output.rate},
      {"notes", plan.notes}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace ra2d
