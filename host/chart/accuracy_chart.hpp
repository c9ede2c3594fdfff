// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/chart/methods.hpp"
#include "host/result/energy.hpp"

/// Speed against accuracy: the cost and the error of every scheme under every contact law.
///
/// The motion is chaotic, so the error is measured in three ways:
/// - the state just before the 5th and the 20th shock, in the norm of the energy (state_error),
///   against a reference much finer than all that is compared;
/// - the closure of the energy over a stretch as long as the time given allows, and no shorter than
///   to the last of these states (EnergyBalance);
/// - level, rate of shocks and their median duration over a long stretch, as means over other
///   surfaces of the same kind, with their standard errors.
///
/// Multipliers are another model of an impact, and each scheme makes its own of it: there a state
/// is measured against the same scheme's own finest run, at the same instant.
namespace ra2d {

/// A time at which states are compared.
struct Instant {
  std::string kind;  // "state-5", "state-20", or "state-end" where there are not so many shocks
  std::string text;  // for people
  double time = 0;   // s
};

/// A state that was compared, or why it was not.
struct StateError {
  double error = quiet_nan;  // relative
  double step = 0;           // s, the whole part of the instant's time that was taken; 0: none
  std::string note;
};

/// The name of a row.
struct Name {
  std::string program = "ra2d", scheme, law, contact_force, nodes;
  std::string text;  // for people
};

/// One setting of one method, or of a peer.
struct Measured {
  Name name;
  Method setting;
  std::string left_out;               // why nothing was measured
  std::vector<StateError> states;     // one an instant
  std::string against;                // the reference of the states
  double energy_closure = quiet_nan;  // of the energy, relative
  double stretch = 0;                 // s simulated, of each repetition
  double took = 0;                    // s of wall time, the first one with all that belongs to it
  std::vector<double> wall;  // s of march per simulated second, one a repetition; of its thread
  double slowed = 1;         // by the clock it took so many times as long: other programs ran, too
  double wall_median() const;  // NaN without any
};

/// Mean over the seeds, its standard error (NaN of a single run), and how far it is from that of
/// the reference on the same surfaces.
struct Statistic {
  double mean = quiet_nan, error = quiet_nan, difference = quiet_nan, difference_error = quiet_nan;
};

enum Quantity { level_quantity, shock_rate, shock_duration, quantities };
inline constexpr std::array<const char*, quantities> quantity_names{"level", "shock-rate",
                                                                    "shock-duration"};

struct LongRun {
  Name name;
  Method setting;
  bool reference = false;
  double wall = quiet_nan;                       // s of march per simulated second
  std::string note;                              // what went wrong
  std::array<Statistic, quantities> statistics;  // dB, 1/s, s
};

struct AccuracyChart {
  std::vector<Instant> instants;
  std::string reference;  // the setting that the penalty's states are measured against
  std::vector<double> reference_error;  // of it, one an instant: from a coarser one
  std::string reference_check;          // which
  std::string confirmed;                // what the peers say of it
  std::vector<Measured> points;
  std::vector<LongRun> long_runs;
  int seeds = 0;           // surfaces of each long run
  double long_time = 0;    // s simulated, of each
  std::string long_notes;  // why there is only one, or none
  double seconds = 0;      // that all of it took
};

struct AccuracyOptions {
  double budget =
      150;  // s of wall time; a run that is not expected to fit is not begun, and listed as such
  int repetitions = 3;  // of each timing
  int seeds = 8;        // of the long runs
  std::vector<double> steps{1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9};  // s
  std::vector<double> tolerances{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
  std::filesystem::path peers;                       // ra2d_peers; none: not confirmed
  std::function<void(const std::string&)> progress;  // is given the step that begins
};

/// Measures everything, repetitions alternating between all that is compared. Throws RequestError
/// where the scene itself cannot be run.
AccuracyChart measure_accuracy(const Scene& scene, const AccuracyOptions& options = {});

/// The chart for people: for each method the cheapest setting within a few errors; at the end what
/// to choose.
std::string describe(const AccuracyChart& chart);

using Context = std::vector<std::pair<std::string, std::string>>;

/// The lines before the first row of the files: the machine (timing_context) and the references.
Context chart_context(const Scene& scene, const AccuracyChart& chart);

/// The chart for programs, a row for each setting and measure of its error. Lines of `context` come
/// first, each after a #.
std::string points_csv(const AccuracyChart& chart, const Context& context);

/// The long runs for programs, a row for each setting and quantity.
std::string long_runs_csv(const AccuracyChart& chart, const Context& context);

}  // namespace ra2d
