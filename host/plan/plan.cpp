// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "host/analysis/sound_pressure.hpp"
#include "host/base/format.hpp"
#include "host/device/footprint_tables.hpp"
#include "host/device/layout.hpp"
#include "host/model/areal_size.hpp"
#include "host/model/bounds.hpp"
#include "host/plan/expected_work.hpp"
#include "host/plan/step_costs.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/store/table.hpp"
#include "host/surface/spline.hpp"

namespace ra2d {
namespace {

/// Nodes at once that an adaptive run may meet: this many, or so many times those that touch at the
/// start. Fixed steps may come to look at all of them, where bodies are thrown about or lie flat on
/// one another.
constexpr int usual_many = 32, touching_factor = 4;

/// Of areal scenes with a start in contact, as many as touch there: the more of them there are, the
/// less do they vary.
int many_nodes_of(const Model& model, int touching) {
  if (model.is_areal && touching > 0) return touching;
  if (!is_adaptive(model.scene)) return model.nodes();
  return std::min(model.nodes(), std::max(usual_many, touching_factor * touching));
}

/// Of so many nodes at the start of an areal scene those that touch on average.
double usual_of(const Model& model, int nodes) {
  return std::max(1.0, (model.is_areal ? step_costs::row_contacts : 1.0) * nodes);
}

int modes_of(const Model& model) {
  return static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
}

/// The times above are of 21 modes; fewer are hardly quicker, more take longer in proportion.
double width_of(const Model& model) {
  return std::max(1.0, modes_of(model) / step_costs::counted_modes);
}

BodyPlan plan_body(const Body& body, const BodySpec& spec, int nodes, const Scene& scene) {
  BodyPlan plan;
  plan.nodes = nodes;
  double zeta = 0;  // of the highest mode
  for (const BodyMode& mode : body.modes) {
    (mode.omega > 0 ? plan.elastic_modes : plan.rigid_modes)++;
    const double frequency = mode.omega / (2 * M_PI);
    if (frequency > plan.highest) plan.highest = frequency, zeta = mode.zeta;
  }
  const double beta = highest_wave_number(body);
  plan.next = spec.support == Support::rigid ? 0.0 : elastic_frequency(spec, plan.elastic_modes);
  plan.wavelength_nodes = beta > 0 ? 2 * M_PI / beta / scene.spacing : 0.0;
  if (plan.highest > 0 && !is_adaptive(scene))
    plan.error = step_error(scene.time.scheme, zeta, 2 * M_PI * plan.highest * scene.time.step);
  return plan;
}

/// The error of the step in a body's highest mode.
std::string error_text(const Scene& scene, const StepError& error, double zeta) {
  if (scene.time.scheme == SchemeKind::exact || scene.time.scheme == SchemeKind::gautschi)
    return "the step is exact for free modes";
  if (is_adaptive(scene)) return "free modes move in closed form";
  const auto shift = [](double value) {
    return std::abs(value) < 1e-9 ? "under 1e-9" : fmt::format("{:+.1e}", value);
  };
  return fmt::format("the step shifts that one's damping ratio, {:g}, by {}, its period by {}",
                     zeta, shift(error.damping), shift(error.period));
}

std::string body_text(const char* name, const Scene& scene, const BodySpec& spec,
                      const BodyPlan& plan) {
  const bool is_areal = scene.kind == SceneKind::areal;
  std::string text =
      fmt::format("{:<11}{}, {:g} ", name, supports.name(spec.support), spec.length * 1e3) +
      (is_areal ? fmt::format("x {:g} ", spec.width * 1e3) : "") +
      (spec.thickness > 0 ? fmt::format("x {:g} mm", spec.thickness * 1e3)
       : is_areal         ? "mm"
                          : "mm long");
  if (spec.support == Support::rigid) return text + ": follows its path, no mode\n";
  text += fmt::format(": {} modes", plan.rigid_modes + plan.elastic_modes);
  if (plan.rigid_modes > 0) text += fmt::format(", {} of them rigid", plan.rigid_modes);
  if (plan.elastic_modes > 0)
    text += fmt::format(", the highest at {:.0f} Hz ({:.0f} nodes per wavelength)", plan.highest,
                        plan.wavelength_nodes);
  text += '\n';
  if (plan.elastic_modes > 0)
    text += fmt::format("           {}\n", error_text(scene, plan.error, spec.damping));
  if (spec.kind == BodyKind::block) return text + "           a block does not bend\n";
  text += fmt::format("           the next mode would be at {:.0f} Hz\n", plan.next);
  return text;
}

/// Nanoseconds of a step whose forces are found at so many nodes, without their evaluation.
double solving_ns(const Model& model, int nodes) {
  const double n = nodes, modes = modes_of(model);
  if (model.scene.contact.law == ContactLaw::multiplier)  // no more than there are modes push
    return std::min(n, modes) * (step_costs::pressed * std::pow(std::min(n, modes), 2) +
                                 n * step_costs::more_nodes * std::max(8.0, modes));
  if (model.has_smooth_faces())  // each cell twice a step, and four products
    return step_costs::cells_newton_steps *
           (n * (2 * step_costs::cell + 4 * step_costs::newton_square * modes * modes) +
            step_costs::newton_cube * modes * modes * modes);
  if (n <= step_costs::pressed_at_most) return step_costs::pressed * n * n * n;
  return step_costs::newton_steps *
         (n * (step_costs::newton_node + step_costs::newton_square * modes * modes) +
          step_costs::newton_cube * modes * modes * modes);
}

/// Nanoseconds that the forces which travel take, each time that they are evaluated.
double travelling_forces_ns(const Model& model) {
  return width_of(model) * step_costs::travelling_force *
         static_cast<double>(model.scene.resonator.moving_forces.size());
}

/// Nanoseconds of the evaluation of a node where every node is.
double node_ns_of(const Model& model) {
  return model.is_areal ? step_costs::row_node + step_costs::row_node_mode * modes_of(model)
                        : step_costs::node;
}

/// Of a scheme of fixed steps: what holds, how many there are, and what they cost.
void plan_steps(const Model& model, const JoinedModes& place, Plan& plan) {
  const Scene& scene = model.scene;
  for (const TimeSettings& choice : choices_under(scene.contact.law)) {
    plan.schemes.push_back({choice, step_limits(model, choice, place)});
    if (choice == plan.own.choice) plan.own = plan.schemes.back();
  }
  plan.steps_per_node = model.advance > 0 ? 1.0 / model.advance : 0.0;
  plan.steps = model.steps;
  const double seconds = 1e-9 * static_cast<double>(model.steps);
  const bool held = holds_forces(scene);
  const int stages = scheme_table(scene.time.scheme).stages;
  const int evaluations = held ? 2 : stages;  // held: without and with the contact's force
  const double evaluation_ns =
      scene.time.nodes == Nodes::all ? evaluations * node_ns_of(model) * model.nodes() : 0.0;
  const bool springs = scene.contact.law == ContactLaw::penalty;
  const double one_ns = model.has_smooth_faces()              ? (!held     ? stages * step_costs::cells
                                                                 : springs ? step_costs::new_cells
                                                                           : step_costs::cells)
                        : model.is_areal                      ? stages * step_costs::row_stage
                        : held                                ? step_costs::held
                        : is_semi_implicit(scene.time.scheme) ? step_costs::contact
                                                              : stages * step_costs::stage;
  const double wide = width_of(model);
  const double each_ns = model.has_smooth_faces() ? wide * step_costs::cell
                                                  : (model.is_areal ? step_costs::row_more_nodes
                                                                    : step_costs::more_nodes) *
                                                        std::max(8, modes_of(model));
  const double moved_ns = stages * travelling_forces_ns(model);
  const double solved_ns = held ? solving_ns(model, plan.many_nodes) : 0.0;
  plan.seconds_free = seconds * (std::max(wide * step_costs::flight, evaluation_ns) + moved_ns);
  const double searching =
      wide * search_seconds(scene, static_cast<double>(model.steps), scene.duration);
  plan.seconds_one = seconds * (wide * one_ns + evaluation_ns + moved_ns) + searching;
  plan.seconds_many =
      seconds * (wide * one_ns + (usual_of(model, plan.many_nodes) - 1) * evaluations * each_ns +
                 evaluation_ns + moved_ns + solved_ns) +
      searching;
}

/// Of the adaptive scheme: what can be said of its steps before it has made them. One ends where a
/// node passes another; where forces act, before the fastest motion has turned by the theta at
/// which the last terms of its velocity, about theta^(n-2)/(n-2)!, are the tolerance; and where a
/// node touches or lets go, each once in half a period of the contact spring (`omega_c`) at the
/// most.
void plan_adaptive_steps(const Model& model, double omega_c, Plan& plan) {
  const Scene& scene = model.scene;
  const double tolerance = scene.time.tolerance.value_or(usual_tolerance);
  const int n = series_order(tolerance);
  const auto turn = [&](int order) {
    return std::exp((std::lgamma(order - 1.0) + std::log(tolerance)) / (order - 2));
  };
  const double theta = turn(n);
  double fastest = 0;
  for (const Body* body : {&model.resonator, &model.slider})
    for (const BodyMode& mode : body->modes) fastest = std::max(fastest, fastest_rate(mode));
  const double crossings = scene.speed / scene.spacing;  // a second
  // overlaps and their rates, at the end of a step and often at its beginning
  const double evaluation_ns =
      scene.time.nodes == Nodes::all ? 4 * node_ns_of(model) * model.nodes() : 0.0;
  const double wide = width_of(model), order = wide * step_costs::order;
  const double flight = wide * step_costs::leap + evaluation_ns,
               drive = (order + travelling_forces_ns(model)) * n + evaluation_ns;
  const double alone = scene.resonator.moving_forces.empty()
                           ? crossings * flight
                           : (crossings + fastest / theta) * drive;
  const bool smooth = model.has_smooth_faces();
  const double step = smooth ? wide * step_costs::smooth_step : order * n;
  const double groups_ns =
      step_costs::row_groups * std::sqrt(scene.slider.length * scene.slider.width);
  const int higher = higher_orders(scene, choose_footprint(model));
  const double turns = higher > 0 ? step_costs::row_raised_turns / turn(n + 2 * higher)
                                  : step_costs::row_turns / theta;
  const auto pressed = [&](int nodes) {
    // their springs side by side
    const double touching = usual_of(model, nodes), omega = omega_c * std::sqrt(touching),
                 rate = std::max(fastest, omega);
    if (model.is_areal && smooth)
      return map_steps_a_second(scene, rate, touching) *
             (step_costs::row_smooth_groups +
              step * (step_costs::row_step + step_costs::row_smooth_more_share * touching) +
              evaluation_ns);
    if (model.is_areal)
      return (turns * rate + step_costs::row_touches * 2 * omega / M_PI +
              step_costs::row_crossings * crossings * touching) *
             (groups_ns + step * (step_costs::row_step + step_costs::row_more_share * touching) +
              evaluation_ns);
    return ((smooth ? 0.0 : crossings) + rate / theta + 2 * omega / M_PI) *
           (step + travelling_forces_ns(model) * n + evaluation_ns +
            (nodes - 1) * step_costs::more_share * step);
  };
  const auto wall = [&](double nanoseconds) {
    return 1e-9 * (nanoseconds * scene.duration +
                   step_costs::sample * static_cast<double>(model.kept_samples()));
  };
  plan.seconds_free = wall(alone);
  plan.seconds_one = wall(std::max(alone, pressed(1)));
  plan.seconds_many = wall(std::max(alone, pressed(plan.many_nodes)));
}

/// Adds notes on the scene's step.
void note_step(const Model& model, Plan& plan) {
  const Scene& scene = model.scene;
  const StepLimits& limits = plan.own.limits;
  if (const std::string beyond = beyond_limit(model, limits); !beyond.empty())
    plan.notes.push_back(
        scene.time.force ? fmt::format("{}; 'ra2d run' takes it, for time.force = true", beyond)
                         : fmt::format("{}; 'ra2d run' refuses it, unless time.force = true. {}",
                                       beyond, step_cure(scene, limits.holds())));
  else if (scene.time.step > limits.contact_many)
    plan.notes.push_back(
        fmt::format("time.step = {:g} s holds for a node in contact, not for {} at once ({:.3g} s)",
                    scene.time.step, limits.many, limits.contact_many));
  if (scene.contact.law == ContactLaw::multiplier && !is_semi_implicit(scene.time.scheme))
    plan.notes.push_back(fmt::format(
        "under multipliers {} bounces off at every step what should rest; backward-euler and "
        "midpoint let it rest",
        schemes.name(scene.time.scheme)));
  if (plan.contact_period > 0 && scene.time.step > plan.contact_period / 20)
    plan.notes.push_back(fmt::format("a shock lasts about {}, {:.1f} steps: too few to follow it",
                                     seconds_text(plan.contact_period),
                                     plan.contact_period / scene.time.step));
}

/// Adds a note on the tone that linear faces make.
void note_mesh(const Scene& scene, Plan& plan) {
  const double tone = mesh_tone_frequency(scene);
  const double highest = std::max(plan.resonator.highest, plan.slider.highest);
  if (!(tone > 0 && tone < highest)) return;
  plan.notes.push_back(fmt::format(
      "the mesh makes a tone of its own at scene.speed / scene.spacing = {:.5g} Hz and "
      "its multiples, "
      "below the highest mode ({:.0f} Hz); beyond it with scene.spacing = {}, none with "
      "scene.faces = \"smooth\"",
      tone, highest, rounded_down(scene.speed / highest)));
}

/// Adds notes on peaks beside which splines ring; of rough faces commands warn (doubt_faces). Peaks
/// touch at their tops, and ring at their feet.
void note_splines(const Model& model, Plan& plan) {
  if (!model.has_smooth_faces()) return;
  const Scene& scene = model.scene;
  for (const auto& [name, body, heights] :
       {std::tuple{"resonator", &scene.resonator, &model.resonator_height},
        std::tuple{"slider", &scene.slider, &model.slider_height}})
    if (body->surface.kind == SurfaceKind::peaks && spline_error(*heights) > most_spline_error)
      plan.notes.push_back(fmt::format(
          "{}.surface: between nodes {:g} m apart its spline may be off by some {:.2g} m beside "
          "its peaks; less so with a finer scene.spacing",
          name, scene.spacing, spline_off(*heights)));
}

/// A step [s] as the table and the messages give it: what holds, or how much of it.
std::string limit_text(double limit) {
  return std::isinf(limit) ? "every step" : limit == 0 ? "no step" : seconds_text(limit);
}

/// A line a scheme: the largest steps that hold.
std::string stability_text(const Scene& scene, const Plan& plan) {
  const bool spring = scene.contact.law == ContactLaw::penalty;
  std::string text =
      fmt::format("stability  the largest steps that hold{}:\n",
                  spring ? ", in contact at the softest place" : "; there is no contact spring");
  const auto line = [&](const std::string& name, const std::string& modes, const std::string& one,
                        const std::string& many, const std::string& holds) {
    text += fmt::format("           {:<28}{:<19} ", name, modes);
    if (spring) text += fmt::format("{:<12}{:<12}{}", one, many, holds);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  };
  line("  scheme", "free modes", "one node", fmt::format("{} nodes", plan.own.limits.many),
       "holds up to");
  for (const auto& [choice, limits] : plan.schemes) {
    std::string modes = limit_text(limits.modes), holds = limit_text(limits.holds());
    if (limits.binding_frequency > 0)
      modes += fmt::format(" ({:.4g} kHz)", limits.binding_frequency * 1e-3);
    if (!std::isinf(limits.holds())) holds += limits.modes_bind() ? ", modes" : ", contact";
    line(fmt::format("{} {}", choice == plan.own.choice ? '>' : ' ', short_text(choice)), modes,
         limit_text(limits.contact_one), limit_text(limits.contact_many), holds);
  }
  return text;
}

std::string steps_text(const Scene& scene, const Plan& plan) {
  std::string text =
      fmt::format("scheme     {}: {} steps of {}", scheme_text(scene, plan.own.choice), plan.steps,
                  seconds_text(scene.time.step));
  if (plan.steps_per_node > 0) text += fmt::format(", {:.4g} to a node", plan.steps_per_node);
  return text + '\n';
}

std::string adaptive_text(const Scene& scene) {
  const char* const contacts =
      scene.faces == Faces::smooth
          ? "           collocation of order 16, in steps as long as that allows\n"
          : "           Taylor series as long as that allows, from where each begins to where it "
            "ends\n";
  return fmt::format(
      "scheme     adaptive, to a relative error of {:g} a step: flights in closed form, contacts "
      "by\n{}"
      "stability  no limit: no step is fixed beforehand\n",
      scene.time.tolerance.value_or(usual_tolerance), contacts);
}

SlowestMode slowest_mode(const Model& model) {
  double slowest = std::numeric_limits<double>::infinity();  // 1/s
  SlowestMode found;
  for (const auto& [name, body] :
       {std::pair{"resonator", &model.resonator}, std::pair{"slider", &model.slider}})
    for (const BodyMode& mode : body->modes)
      if (mode.omega > 0 && mode.zeta * mode.omega < slowest) {
        slowest = mode.zeta * mode.omega;
        found = {name, mode.omega / (2 * M_PI), std::log(1e3) / slowest};
      }
  return found;
}

/// How long the start is heard, compared with the run.
std::string ringing_text(const Scene& scene, const SlowestMode& slowest) {
  if (*slowest.body == '\0') return {};
  std::string text =
      fmt::format("ringing    the {}'s mode at {:.4g} Hz {}; the run takes {}\n", slowest.body,
                  slowest.frequency,
                  std::isinf(slowest.decay)
                      ? std::string("never dies away")
                      : fmt::format("dies away by 60 dB in {}", seconds_text(slowest.decay)),
                  seconds_text(scene.duration));
  return text +
         fmt::format("           it starts {}; level and shocks count from {} on (output.from)\n",
                     scene.initial == Initial::statics ? "in equilibrium" : "from rest, and rings",
                     scene.output.from > 0 ? seconds_text(scene.output.from) : "t = 0");
}

/// The asperities that the materials would give, and those that the scene has.
std::string asperities_text(const Scene& scene, const Asperities& a) {
  if (a.radius == 0 || std::isinf(a.modulus)) return {};
  const auto contact = [&](const AsperityContact& c) {
    std::vector<std::string> parts;
    if (c.stiffness > 0)
      parts.push_back(fmt::format("{:.2g} N/m under {:.2g} N", c.stiffness, a.load));
    if (c.shock > 0)
      parts.push_back(fmt::format("{:.2g} N/m in a shock of {:.2g} N, {}", c.shock, c.peak,
                                  seconds_text(c.duration)));
    return parts.empty() ? "" : fmt::format(":\n           {}", fmt::join(parts, "; "));
  };
  std::string text = fmt::format(
      "asperity   of the material (E* = {:.3g} GPa, summits of {:.2g} mm radius), by Hertz{}\n",
      a.modulus * 1e-9, a.radius * 1e3, contact(a.material));
  const bool spring = scene.contact.law == ContactLaw::penalty;
  if (spring && !scene.contact.is_hertz && !contact(a.springs).empty())
    text += fmt::format("           of contact.stiffness = {:.3g} Pa/m{}\n",
                        scene.contact.stiffness, contact(a.springs));
  return text + fmt::format(
                    "           contact.stiffness = \"hertz\"{} {:.3g} Pa/m, makes it that of the "
                    "material\n",
                    scene.contact.is_hertz ? ", as here," : ",", a.hertz);
}

/// The contacts of an areal scene, by Hertz and on the scene's springs.
std::string points_text(const Model& model, const Plan& plan) {
  const PointContacts& p = plan.points;
  if (p.radius == 0) return {};
  const Scene& scene = model.scene;
  constexpr double large = 0.1, small = 0.05;
  std::string text = fmt::format(
      "contacts   {} at the start, {:.2g} N each, on summits of {:.2g} mm radius (E* = {:.3g} "
      "GPa); "
      "by\n           Hertz {:.2g} N/m and {:.2g} um wide: contact.stiffness = {:.2g} makes it as "
      "stiff\n           on contact.stiffness = {:.2g} Pa/m they are {:.2g} um wide, {:.2g} "
      "{}:\n           rates of shocks and their durations are off by {}\n",
      p.contacts, p.load, p.radius * 1e3, p.modulus * 1e-9, p.hertz.stiffness,
      2e6 * p.hertz.half_width, p.hertz.kappa, scene.contact.stiffness, p.width * 1e6, p.nodes,
      model.has_smooth_faces() ? "rows" : "spacings",
      p.shock_error > 1
          ? std::string("more than 100 %")
          : fmt::format("some {:.{}f} %", 100 * p.shock_error, p.shock_error < 0.01 ? 1 : 0));
  if (!(p.shock_error > large)) return text;
  const auto spacing = [&](Faces faces) { return rounded_down(p.width / nodes_for(small, faces)); };
  return text +
         fmt::format(
             "           {0:g} % takes --set scene.faces=smooth --set scene.spacing_y={2}, or\n"
             "           --set scene.faces=linear --set scene.spacing={1} --set "
             "scene.spacing_y={1}\n",
             100 * small, spacing(Faces::linear), spacing(Faces::smooth));
}

/// A line a choice: how far off it makes the answer, and what it costs.
std::string choices_text(const Scene& scene, const Plan& plan) {
  if (plan.faces.list.empty()) return {};
  const auto percent = [](double error) {
    return std::isinf(error) ? std::string("not known")
           : error < 1e-4    ? std::string("under 0.01 %")
                             : fmt::format("{:.{}f} %", 100 * error,
                                        error < 0.01  ? 2
                                           : error < 0.1 ? 1
                                                         : 0);
  };
  std::string text =
      scene.contact.law == ContactLaw::penalty
          ? fmt::format(
                "faces      a contact in a shock is some {:.2g} um wide; each choice is off "
                "by about, at the most:\n",
                plan.asperities.width * 1e6)
          : "faces      between linear ones shocks go with the spacing; off by about, at the "
            "most:\n";
  text += fmt::format("           {:<20}{:<14}{:<14}{:<14}{}\n", "  faces", "level", "rate",
                      "duration", "wall time");
  for (const FaceChoice& choice : plan.faces.list)
    text += fmt::format("           {} {:<18}{:<14}{:<14}{:<14}{}\n", choice.is_own ? '>' : ' ',
                        faces_text(choice.faces, choice.spacing), percent(choice.errors.level),
                        percent(choice.errors.rate), percent(choice.errors.duration),
                        seconds_text(choice.seconds));
  const std::optional<FaceChoice>& best = plan.faces.best;
  const std::string within = fmt::format("{:g} %", 100 * face_accuracy);
  return text + (!best ? fmt::format("           none of these is sure to hold {}\n", within)
                 : best->is_own
                     ? fmt::format("           the scene has the cheapest that holds {}\n", within)
                     : fmt::format("           the cheapest that holds {}: {}\n", within,
                                   set_words(*best)));
}

std::string cost_text(const Model& model, const Plan& plan) {
  std::string text =
      fmt::format("cost       {} without contact to {} with a node always in contact",
                  seconds_text(plan.seconds_free), seconds_text(plan.seconds_one));
  if (plan.many_nodes > 1)
    text += fmt::format(",\n           {} {} with {} at once",
                        model.is_areal && plan.many_nodes == plan.touching ? "about" : "at worst",
                        seconds_text(plan.seconds_many), plan.many_nodes);
  return text + fmt::format(" ({} touch{} at the start); of one core, estimated\n", plan.touching,
                            plan.touching == 1 ? "es" : "");
}

/// The sound at the scene's microphones; notes that there will be none.
SoundPlan plan_sound(const Model& model, std::vector<std::string>& notes) {
  const Scene& scene = model.scene;
  SoundPlan plan;
  plan.microphones = scene.output.microphones.size();
  if (plan.microphones == 0) return plan;
  const Radiator face = face_of(model.resonator, scene.resonator);
  const Air air = air_of(scene.air.celsius, scene.air.pascal);
  const auto samples = static_cast<std::size_t>(model.kept_samples());
  const double rate = scene.output.rate;
  const auto of_modes = static_cast<double>(samples * face.modes.size());
  const double one = step_costs::face_point * face_points(face, air, rate) +
                     step_costs::heard * static_cast<double>(samples) +
                     step_costs::heard_mode * of_modes;
  plan.seconds =
      1e-9 * (one * static_cast<double>(plan.microphones) + step_costs::read_mode * of_modes);
  plan.memory = PressureFilters::bytes(face, air, plan.microphones, rate, samples);
  if (const auto fault = too_many_microphones(face, air, plan.microphones, rate, samples);
      !fault.empty())
    notes.push_back("the report will have no sound: " + fault);
  return plan;
}

std::string sound_text(const SoundPlan& plan) {
  if (plan.microphones == 0) return {};
  return fmt::format("sound      {} microphone{}: {} and {} when the run has ended, estimated\n",
                     plan.microphones, plan.microphones == 1 ? "" : "s", seconds_text(plan.seconds),
                     size_text(plan.memory));
}

}  // namespace

std::string scheme_text(const Scene& scene, const TimeSettings& choice) {
  std::string text = schemes.name(choice.scheme);
  if (scene.contact.law == ContactLaw::penalty && choice.scheme == SchemeKind::backward_euler)
    text += fmt::format(" with the contact force of the {} time",
                        force_times.name(choice.contact_force));
  return text;
}

std::string short_text(const TimeSettings& choice) {
  return fmt::format("{}{}", schemes.name(choice.scheme),
                     choice.contact_force == ForceTime::new_time ? ", new force" : "");
}

std::vector<TimeSettings> choices_under(ContactLaw law) {
  std::vector<TimeSettings> choices;
  for (const auto& [name, scheme] : schemes.words) {
    if (scheme == SchemeKind::adaptive) continue;
    if (law == ContactLaw::multiplier && !takes_multipliers(scheme)) continue;
    choices.push_back({scheme, ForceTime::old_time});
    // the others take the force in one way only
    if (law == ContactLaw::penalty && scheme == SchemeKind::backward_euler)
      choices.push_back({scheme, ForceTime::new_time});
  }
  return choices;
}

TimeSettings choice_of(const Scene& scene) {
  // the others take the force in one way only
  const bool has_choice =
      scene.time.scheme == SchemeKind::backward_euler && scene.contact.law == ContactLaw::penalty;
  return {scene.time.scheme, has_choice ? scene.time.contact_force : ForceTime::old_time};
}

std::string beyond_limit(const Model& model, const StepLimits& limits) {
  const Scene& scene = model.scene;
  if (!(scene.time.step > limits.holds())) return {};
  const TimeSettings choice = choice_of(scene);
  const bool modes = limits.modes_bind();
  const JoinedModes place = most_compliant(model);
  // its limit promises no more than can be said of all smaller steps
  if (choice.scheme == SchemeKind::exact && holds_in_contact(model, choice, place, scene.time.step))
    return {};
  const double growth = modes ? mode_growth(model, choice.scheme, scene.time.step)
                              : contact_growth(model, choice, place, scene.time.step);
  const std::string what = modes ? fmt::format("a free mode at {:.0f} Hz", limits.binding_frequency)
                                 : "a node in contact";
  std::string text =
      limits.holds() == 0
          ? fmt::format("at no step does {} hold {}", scheme_text(scene, choice), what)
          : fmt::format("{} holds {} up to {} s, and time.step is {:g} s",
                        scheme_text(scene, choice), what, rounded_down(limits.holds()),
                        scene.time.step);
  if (growth > 0)
    text += fmt::format("; at {:g} s {} grows e-fold in {}", scene.time.step,
                        modes ? "it" : "such a contact, while closed,", seconds_text(1 / growth));
  return text;
}

std::string overlap_at_start(const Model& model) {
  const Scene& scene = model.scene;
  if (scene.contact.law != ContactLaw::multiplier || scene.initial != Initial::rest) return {};
  const double most = rest_overlap(model);
  if (most == 0) return {};
  return fmt::format(
      "the faces overlap by {:.3g} m at t = 0, which multipliers would undo in a single step, as a "
      "blow: expected scene.gap = \"touching\" or at least {:.6g} m{}",
      most, model.delta + most * (1 + 1e-6),
      has_equilibrium(scene) ? ", or scene.initial = \"static\"" : "");
}

std::string step_cure(const Scene& scene, double holds) {
  std::vector<std::string> keys;
  if (scene.time.scheme != SchemeKind::backward_euler)
    keys.emplace_back("time.scheme = \"backward-euler\"");
  if (scene.contact.law == ContactLaw::penalty) keys.emplace_back("time.contact_force = \"new\"");
  return fmt::format(
      "Take {}{} (holds at every step)",
      holds > 0 ? fmt::format("time.step = {} or less, or ", rounded_down(holds)) : std::string{},
      fmt::join(keys, " with "));
}

std::string size_text(double bytes) {
  if (bytes < 1e9) return bytes_text(static_cast<std::size_t>(bytes));
  return bytes < 1e12 ? fmt::format("{:.3g} GB", bytes / 1e9)
                      : fmt::format("{:.4g} TB", bytes / 1e12);
}

double result_bytes(const Model& model) {
  constexpr double fixed_part = 170000;  // bytes: attributes, texts, the library's own
  constexpr double most_places = 1001, usual_places = 500;  // of a mode's shape; of a plate's
  constexpr int energies_and_force = 7, of_shocks = 7;      // columns
  const Scene& scene = model.scene;
  const double real = scene.output.precision == Precision::real32 ? 4 : 8;  // bytes
  const auto table = [](double rows, std::size_t width, double number) {
    if (width == 0) return 0.0;
    const auto chunk = static_cast<double>(chunk_rows(width));
    return std::ceil(rows / chunk) * chunk * static_cast<double>(width) * number;
  };
  const auto samples = static_cast<double>(model.kept_samples());
  double bytes = fixed_part + 2 * table(samples, 1, 8) +  // times, and nodes in contact
                 energies_and_force * table(samples, 1, real) + of_shocks * table(1, 1, 8);
  std::vector<std::size_t> moving{scene.output.probes.size(), scene.output.slider_probes.size()};
  if (scene.output.modes == KeptModes::all)
    moving.insert(moving.end(), {model.resonator.modes.size(), model.slider.modes.size()});
  for (const std::size_t width : moving) bytes += 2 * table(samples, width, real);
  const auto heights =
      static_cast<double>(model.resonator_height.size() + model.slider_height.size());
  const double places =
      model.is_areal ? model.row_heights() + model.row_nodes() + 2.0 * model.rows : heights;
  const auto shapes = [&](const Body& body, const std::vector<double>& nodes) {
    return static_cast<double>(body.modes.size()) *
           (model.is_areal ? usual_places
                           : std::min(most_places, static_cast<double>(nodes.size())));
  };
  return bytes + 8 * (heights + places + shapes(model.resonator, model.resonator_height) +
                      shapes(model.slider, model.slider_height));
}

Plan make_plan(const Model& model, std::size_t memory, const ModalStart& start) {
  const Scene& scene = model.scene;
  const auto touching = static_cast<int>(start.loaded_nodes.size());
  Plan plan;
  plan.touching = touching;
  plan.asperities = asperities_of(model, start);
  plan.points = point_contacts_of(model, start);
  plan.faces = choose_faces(model, plan.asperities);
  plan.many_nodes = many_nodes_of(model, touching);
  plan.resonator = plan_body(model.resonator, scene.resonator,
                             static_cast<int>(model.resonator_height.size()), scene);
  plan.slider = plan_body(model.slider, scene.slider, model.nodes(), scene);
  plan.slowest = slowest_mode(model);
  plan.delta = model.delta;
  const JoinedModes place = most_compliant(model);
  const bool spring = scene.contact.law == ContactLaw::penalty;
  const double omega_c = spring ? contact_frequency(model, place) : 0.0;
  plan.contact_period = omega_c > 0 ? M_PI / omega_c : 0.0;
  plan.own.choice = choice_of(scene);
  plan.samples = model.kept_samples();
  if (is_adaptive(scene))
    plan_adaptive_steps(model, omega_c, plan);
  else
    plan_steps(model, place, plan);
  plan.memory = memory;
  if (model.is_areal) plan.memory = std::max(memory, static_cast<std::size_t>(areal_memory(scene)));
  plan.file = result_bytes(model);

  if (model.slider.modes.empty() && model.slider.load_force != 0.0)
    plan.notes.push_back(fmt::format(
        "the slider's load of {:.4g} N moves nothing: the slider keeps no mode (the first is at "
        "{:.0f} Hz, "
        "slider.max_frequency = {:g} Hz)",
        model.slider.load_force, plan.slider.next, scene.slider.max_frequency.value_or(0.0)));
  if (model.resonator.modes.empty())
    plan.notes.push_back("the resonator keeps no mode: nothing vibrates and there is no level");
  if (!is_adaptive(scene)) note_step(model, plan);
  note_mesh(scene, plan);
  note_splines(model, plan);
  plan.sound = plan_sound(model, plan.notes);
  if (const std::string overlap = overlap_at_start(model); !overlap.empty())
    plan.notes.push_back("'ra2d run' refuses this scene: " + overlap);
  return plan;
}

std::string describe(const Model& model, const Plan& plan) {
  const Scene& scene = model.scene;
  std::string text;
  text += body_text("resonator", scene, scene.resonator, plan.resonator);
  text += body_text("slider", scene, scene.slider, plan.slider);
  if (model.is_areal)
    text += fmt::format(
        "nodes      {} of the slider in {} rows of {}, over rows of {} of the resonator up to "
        "where "
        "it\n           comes; {:g} um apart along, {:g} um across; mean planes {:.6g} um apart\n",
        plan.slider.nodes, model.rows, model.row_nodes(), model.row_heights(), scene.spacing * 1e6,
        model.spacing_y * 1e6, plan.delta * 1e6);
  else
    text += fmt::format(
        "nodes      {} of the slider over {} of the resonator, {:g} um apart; mean lines {:.6g} um "
        "apart\n",
        plan.slider.nodes, plan.resonator.nodes, scene.spacing * 1e6, plan.delta * 1e6);
  if (scene.contact.law == ContactLaw::penalty)
    text += fmt::format(
        "contact    penalty, {:.3g} N/m a {}; half a period of {} spring: {}\n"
        "           (shocks are shorter where the slider passes on)\n",
        model.node_stiffness, model.has_smooth_faces() ? "cell" : "node",
        model.has_smooth_faces() ? "a whole cell's" : "a node's",
        seconds_text(plan.contact_period));
  else
    text += "contact    multiplier: each step ends without penetration; no spring\n";
  text += asperities_text(scene, plan.asperities) + points_text(model, plan);
  text += choices_text(scene, plan);
  const bool adaptive = is_adaptive(scene);
  text += adaptive ? adaptive_text(scene) : steps_text(scene, plan) + stability_text(scene, plan);
  text += fmt::format("evaluated  {}\n",
                      scene.time.nodes == Nodes::all
                          ? "every node at every step"
                          : "the nodes that can touch; the others are proven apart (time.nodes = "
                            "\"candidates\")");
  text += ringing_text(scene, plan.slowest);
  text += cost_text(model, plan);
  text += fmt::format("memory     {}{}; file {}, {} samples\n",
                      size_text(static_cast<double>(plan.memory)),
                      model.is_areal ? ", with both maps" : ", whatever the duration",
                      size_text(plan.file), plan.samples);
  text += sound_text(plan.sound);
  for (const std::string& note : plan.notes) text += "note       " + note + "\n";
  return text;
}

}  // namespace ra2d
