// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/model/point_contacts.hpp"
#include "host/plan/asperities.hpp"
#include "host/plan/face_choices.hpp"
#include "host/plan/stability.hpp"

/// The model of a scene before it is run: modes, nodes, step, limits of stability, cost.
namespace ra2d {

struct BodyPlan {
  int rigid_modes = 0, elastic_modes = 0;
  double highest = 0;  // Hz, of the modes that are kept; 0 without any
  double next = 0;     // Hz, of the first that is left out
  int nodes = 0;
  double wavelength_nodes = 0;  // nodes to the shortest wavelength; 0 without any
  StepError error;              // of the highest mode
};

struct SchemePlan {
  TimeSettings choice;
  StepLimits limits;
};

/// The elastic mode that rings longest.
struct SlowestMode {
  const char* body = "";  // "resonator" or "slider"; empty where no mode is elastic
  double frequency = 0;   // Hz
  double decay = 0;       // s, in which it dies away by 60 dB; infinite without damping
};

/// Estimated cost of the sound at the scene's microphones, when the run has ended.
struct SoundPlan {
  std::size_t microphones = 0;
  double seconds = 0, memory = 0;  // of one core; bytes
};

struct Plan {
  BodyPlan resonator, slider;
  SlowestMode slowest;
  double delta = 0;                 // m
  std::vector<SchemePlan> schemes;  // of fixed steps, all that the scene's contact law can take
  SchemePlan own;                   // the scene's choice
  double contact_period = 0;  // s, half a period of the contact spring: about a shock's length
  std::int64_t samples = 0;
  // of fixed steps; an adaptive scheme finds its own
  double steps_per_node = 0;  // steps while the slider moves on by one node
  std::int64_t steps = 0;
  // of wall time, estimates (see plan.cpp): without contact, with a node in contact all the time,
  // with `many_nodes` of them; and how many touch at the start
  double seconds_free = 0, seconds_one = 0, seconds_many = 0;
  int many_nodes = 0, touching = 0;
  Asperities asperities;
  PointContacts points;  // of areal scenes
  FaceChoices faces;
  // bytes on the device, for tables and buffers; of areal scenes on a CPU all that a run takes
  std::size_t memory = 0;
  double file = 0;  // bytes (result_bytes)
  SoundPlan sound;
  std::vector<std::string> notes;  // what a user may not expect
};

/// Runs nothing; `memory` is what the march would take (Batch::bytes), `start` where the scene
/// starts.
Plan make_plan(const Model& model, std::size_t memory, const ModalStart& start = {});

/// The size of a result's file, with room for the first 8192 shocks [bytes].
double result_bytes(const Model& model);

/// For people: so many bytes, up to terabytes.
std::string size_text(double bytes);

/// The plan as text, a line a fact.
std::string describe(const Model& model, const Plan& plan);

/// The plan and the complete scene as one JSON object, a line. Null stands for what there is not;
/// as a limit of the step it says that every step holds.
std::string plan_json(const Model& model, const Plan& plan);

/// A scheme as messages call it, e.g. "backward-euler with the contact force of the old time".
std::string scheme_text(const Scene& scene, const TimeSettings& choice);

/// A scheme and its contact force for tables, e.g. "backward-euler, new force".
std::string short_text(const TimeSettings& choice);

/// All schemes of fixed steps that a contact law can take, each with the times of its contact
/// force.
std::vector<TimeSettings> choices_under(ContactLaw law);

/// The scene's own, of fixed steps or not, without its step.
TimeSettings choice_of(const Scene& scene);

/// The limit that the scene's step exceeds, and how fast the motion grows then; empty while it
/// holds.
std::string beyond_limit(const Model& model, const StepLimits& limits);

/// The step to write into the scene instead of one that does not hold.
std::string step_cure(const Scene& scene, double holds);

/// The fault of a start at rest whose faces overlap, under multipliers; empty where there is none.
std::string overlap_at_start(const Model& model);

}  // namespace ra2d
