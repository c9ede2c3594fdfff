// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "host/format.hpp"

namespace ra2d {
namespace {

/// Wall time of a step on one core of a server processor of 2023, in ns: in free flight, and in
/// contact at a few nodes (bench/bench_march.cpp). Every node at every step costs 0.7 ns a node.
constexpr double flight_ns = 5.0, contact_ns = 50.0, node_ns = 0.7;

/// Largest value over the length of a beam of sum_k weight(k) psi_k^2.
double largest(const Beam& beam, const std::function<double(const ModeShape&)>& weight) {
  if (beam.modes.empty()) return 0.0;
  const int places =
      40 * static_cast<int>(beam.modes.size()) + 1;  // tens to a wavelength, and both ends
  double most = 0.0;
  for (int i = 0; i < places; ++i) {
    double sum = 0.0;
    for (const ModeShape& mode : beam.modes) {
      double psi = 0.0;
      evaluate(mode, beam.length, beam.length * i / (places - 1), 1, &psi);
      sum += weight(mode) * psi * psi;
    }
    most = std::max(most, sum);
  }
  return most;
}

/// The left side of backward Euler's condition for one node of stiffness 1 N/m: stable while it is
/// below 1/stiffness.
double yielding(const Model& model, double tau) {
  const auto part = [&](const Beam& beam) {
    return largest(beam, [&](const ModeShape& mode) {
      const double turn = mode.omega * tau;
      return tau * tau / (beam.mass_per_length * (4.0 + 4.0 * beam.zeta * turn + turn * turn));
    });
  };
  return part(model.resonator) + part(model.slider);
}

BodyPlan plan_body(const Beam& beam, const BodySpec& spec, int nodes, double spacing, double tau) {
  BodyPlan plan;
  plan.nodes = nodes;
  double beta = 0;
  for (const ModeShape& mode : beam.modes) {
    (mode.omega > 0 ? plan.elastic_modes : plan.rigid_modes)++;
    plan.highest = std::max(plan.highest, mode.omega / (2 * M_PI));
    beta = std::max(beta, mode.beta);
  }
  plan.next = spec.support == Support::rigid ? 0.0 : elastic_frequency(spec, plan.elastic_modes);
  plan.wavelength_nodes = beta > 0 ? 2 * M_PI / beta / spacing : 0.0;
  plan.numerical_damping = M_PI * plan.highest * tau;
  return plan;
}

std::string support_text(Support support) {
  return support == Support::pinned ? "pinned" : support == Support::free ? "free" : "rigid";
}

std::string body_text(const char* name, const BodySpec& spec, const BodyPlan& plan, double zeta) {
  std::string text = fmt::format("{:<11}{}, {:g} x {:g} mm", name, support_text(spec.support),
                                 spec.length * 1e3, spec.thickness * 1e3);
  if (spec.support == Support::rigid) return text + ": follows its path, no mode\n";
  text += fmt::format(": {} modes", plan.rigid_modes + plan.elastic_modes);
  if (plan.rigid_modes > 0) text += fmt::format(", {} of them rigid", plan.rigid_modes);
  if (plan.elastic_modes > 0)
    text += fmt::format(", the highest at {:.0f} Hz ({:.0f} nodes to its wave)", plan.highest,
                        plan.wavelength_nodes);
  text += fmt::format("; the next would be at {:.0f} Hz\n", plan.next);
  if (plan.elastic_modes > 0)
    text += fmt::format(
        "           the step damps its highest mode by {:.2g} (numerical), the material by "
        "{:.2g}\n",
        plan.numerical_damping, zeta);
  return text;
}

}  // namespace

double contact_step_limit(const Model& model, int nodes) {
  const double target = 1.0 / (model.node_stiffness * nodes);
  double low = 1e-15, high = 1e3;
  if (yielding(model, high) < target) return std::numeric_limits<double>::infinity();
  if (yielding(model, low) > target) return 0.0;
  while (high / low > 1.0 + 1e-6) {
    const double middle = std::sqrt(low * high);
    (yielding(model, middle) < target ? low : high) = middle;
  }
  return low;
}

double contact_frequency(const Model& model) {
  const auto part = [](const Beam& beam) {
    return largest(beam, [&](const ModeShape&) { return 1.0 / beam.mass_per_length; });
  };
  return std::sqrt(model.node_stiffness * (part(model.resonator) + part(model.slider)));
}

Plan make_plan(const Model& model, std::size_t memory) {
  const Scene& scene = model.scene;
  Plan plan;
  plan.resonator =
      plan_body(model.resonator, scene.resonator, static_cast<int>(model.resonator_height.size()),
                scene.spacing, scene.step);
  plan.slider = plan_body(model.slider, scene.slider, model.nodes(), scene.spacing, scene.step);
  plan.delta = model.delta;
  plan.limit_one = contact_step_limit(model, 1);
  plan.limit_many = contact_step_limit(model, plan.many);
  const double omega_c = contact_frequency(model);
  plan.contact_period = omega_c > 0 ? M_PI / omega_c : 0.0;
  plan.steps_per_node = model.advance > 0 ? 1.0 / model.advance : 0.0;
  plan.steps = model.steps;
  plan.samples = model.samples;
  const double steps = static_cast<double>(model.steps);
  if (scene.nodes == Nodes::all) {
    plan.seconds_low = plan.seconds_high = steps * node_ns * model.nodes() * 1e-9;
  } else {
    plan.seconds_low = steps * flight_ns * 1e-9;
    plan.seconds_high = steps * contact_ns * 1e-9;
  }
  plan.memory = memory;
  const std::size_t columns = 1 + 2 * (model.resonator.modes.size() + model.slider.modes.size()) +
                              2 + 2 * scene.probes.size() + 6;
  plan.file = 8 * (columns * static_cast<std::size_t>(model.samples) +
                   2 * (model.resonator_height.size() + model.slider_height.size())) +
              60000;

  if (model.slider.modes.empty() && model.slider.load_force != 0.0)
    plan.notes.push_back(fmt::format(
        "the slider's load of {:.4g} N moves nothing: the slider keeps no mode (the first is at "
        "{:.0f} Hz, "
        "slider.max_frequency = {:g} Hz)",
        model.slider.load_force, plan.slider.next, scene.slider.max_frequency.value_or(0.0)));
  if (model.resonator.modes.empty())
    plan.notes.push_back("the resonator keeps no mode: nothing vibrates and there is no level");
  if (scene.step > plan.limit_one)
    plan.notes.push_back(
        fmt::format("time.step = {:g} s is beyond what the contact spring of a single node allows, "
                    "{:.3g} s: the "
                    "run will stop as unstable",
                    scene.step, plan.limit_one));
  else if (scene.step > plan.limit_many)
    plan.notes.push_back(
        fmt::format("time.step = {:g} s holds for a node in contact, not for {} at once ({:.3g} s)",
                    scene.step, plan.many, plan.limit_many));
  if (plan.contact_period > 0 && scene.step > plan.contact_period / 20)
    plan.notes.push_back(fmt::format("a shock lasts about {}, {:.1f} steps: too few to follow it",
                                     seconds_text(plan.contact_period),
                                     plan.contact_period / scene.step));
  return plan;
}

std::string describe(const Model& model, const Plan& plan) {
  const Scene& scene = model.scene;
  std::string text;
  text += body_text("resonator", scene.resonator, plan.resonator, scene.resonator.damping);
  text += body_text("slider", scene.slider, plan.slider, scene.slider.damping);
  text += fmt::format(
      "nodes      {} of the slider over {} of the resonator, {:g} um apart; delta = {:.6g} um\n",
      plan.slider.nodes, plan.resonator.nodes, scene.spacing * 1e6, plan.delta * 1e6);
  text +=
      fmt::format("contact    penalty, {:.3g} N/m a node: a shock of one node lasts {} or longer\n",
                  model.node_stiffness, seconds_text(plan.contact_period));
  text += fmt::format("scheme     backward Euler, force at the old time: {} steps of {}",
                      plan.steps, seconds_text(scene.step));
  if (plan.steps_per_node > 0) text += fmt::format(", {:.4g} to a node", plan.steps_per_node);
  text += "\n";
  text += "stability  the modes alone hold at every step; the contact spring binds: ";
  text += std::isinf(plan.limit_one)
              ? std::string("it holds at every step too\n")
              : fmt::format("up to {} for one node, {} for {} at one place\n",
                            seconds_text(plan.limit_one), seconds_text(plan.limit_many), plan.many);
  text += fmt::format("looked at  {}\n",
                      scene.nodes == Nodes::all
                          ? "every node at every step"
                          : "the nodes that can touch, by proof (time.nodes = \"candidates\")");
  text += plan.seconds_low == plan.seconds_high
              ? fmt::format("cost       about {}", seconds_text(plan.seconds_low))
              : fmt::format("cost       {} (all flight) to {} (all contact)",
                            seconds_text(plan.seconds_low), seconds_text(plan.seconds_high));
  text += " of wall time on one core, an estimate\n";
  text += fmt::format("memory     {}, whatever the duration; file {}, {} samples\n",
                      bytes_text(plan.memory), bytes_text(plan.file), plan.samples);
  for (const std::string& note : plan.notes) text += "note       " + note + "\n";
  return text;
}

}  // namespace ra2d
