// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/ensemble/ensemble.hpp"
#include "host/scene/scene.hpp"

/// Finds how little of a scene will do: the cheapest scheme and step, the fewest modes and the
/// cheapest faces and spacing that keep level, rate of shocks and their median duration within an
/// accuracy.
///
/// The reference is the scene as written, marched by the adaptive scheme to a tolerance of 1e-10.
/// Multipliers have no adaptive scheme: there it is the scene's own at a tenth of its step. Its
/// faces are smooth where the scene does not say which it has (host/savings/face_search.hpp). One
/// thing is changed at a time and compared with the reference on the same surfaces. Then all
/// changes that will do are made at once and compared again. A change is chosen
/// - where all three quantities stay within the accuracy with 95 % confidence, or
/// - of schemes and steps alone, which change no model: where chance leaves that open, but the
///   energy closes within the accuracy and the first shock of the runs, before chaos parts them,
///   lasts as long within it. The text says so.
/// A change that stays open otherwise is not chosen.
namespace ra2d {

struct SavingsOptions {
  double accuracy = 1e-3;                            // relative, of v_rms, shock rate and duration
  double budget = 60;                                // s of wall time, roughly
  std::function<void(const std::string&)> progress;  // is given the step that begins
};

/// One change of the scene, and its effect.
struct Trial {
  std::string key;   // that it changes, e.g. "resonator.modes"
  std::string what;  // the new value, for people
  Scene scene;
  std::array<Movement, 3> moved;  // of quantities_of_answer
  Movement first;                 // of the first shock's duration
  double energy_closure = 0;      // of the energy, relative, the mean over the runs
  double cheaper = quiet_nan;     // than the scene that it is compared with
  Verdict verdict = Verdict::open;
  std::string why;          // why it could not be run, or stayed open
  bool by_balance = false;  // chosen although chance leaves it open
  bool taken = false;
  bool checked = false;  // no saving: how the scene as written stands
  std::function<void(Scene&)> change;
};

struct Savings {
  double accuracy = 0;
  Scene written, reference, chosen;
  double duration = 0;              // s, of each run
  int runs = 0;                     // of the reference
  Answer mean;                      // of the reference over its runs
  std::array<double, 3> spread;     // standard deviation of one run, relative
  double energy_closure = 0;        // of the reference
  std::vector<Trial> trials;        // in the order of the tables
  std::vector<Trial> combinations;  // of all savings; more than one where some had to be given up
  double cost_written = 0, cost_chosen = 0;  // as of Ensemble
  std::vector<std::string> notes;
  double seconds = 0;  // that it took
};

/// Throws RequestError where the scene cannot be run, Interrupted.
Savings find_savings(const Scene& scene, const SavingsOptions& options);

/// All trials and the result, for people.
std::string describe(const Savings& savings);

/// The changes as words of a command line: "--set", "scene.faces=smooth", ... They make the chosen
/// scene of the written one.
std::vector<std::string> set_words(const Savings& savings);

/// All of it as one JSON object, a line. `output` is where the scene is written.
std::string savings_json(const Savings& savings, const std::filesystem::path& output);

/// The scene with the choices in it, each with where it comes from. Reading it, from any folder,
/// gives savings.chosen.
std::string planned_scene(const Savings& savings);

}  // namespace ra2d
