// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/result/energy.hpp"
#include "host/run/timed_run.hpp"
#include "host/scene/scene.hpp"

/// Level and shocks of a scene as means over runs that differ by chance alone. The motion is
/// chaotic: two settings are compared by these statistics on the same surfaces, pair by pair.
namespace ra2d {

/// The answer of one run.
struct Answer {
  double v_rms = 0;                  // m/s
  double shock_rate = 0;             // 1/s
  double shock_duration_median = 0;  // s, the median; NaN without shocks
  double first_duration = 0;  // s, of the first shock that begins after t = 0; NaN without one
  double energy_closure = 0;  // of the energy, relative (EnergyBalance)
  std::string failure;        // why there is no answer; empty when there is
};

/// The quantities that are compared, in this order.
inline constexpr std::array<double Answer::*, 3> quantities_of_answer{
    &Answer::v_rms, &Answer::shock_rate, &Answer::shock_duration_median};

/// How far a mean is from another, relative to that one, from pairs of values.
struct Movement {
  double relative = 0;  // infinite where the other is 0 and this one is not
  double error = 0;     // its standard error; 0 where a single pair leaves it unknown
  int pairs = 0;
  /// Half the width of the interval that holds the truth in 95 of 100 cases (Student's t).
  double margin() const;
};

/// Ratio of the means of `values` and `reference`, less 1. Its standard error is that of the mean
/// of values - ratio reference. Pairs of which one is no number are left out; without any the
/// movement is 0.
Movement movement(const std::vector<double>& reference, const std::vector<double>& values);

/// The movement of one of the answers' quantities; failed runs are left out.
Movement movement(const std::vector<Answer>& reference, const std::vector<Answer>& values,
                  double Answer::*quantity);

enum class Verdict {
  kept,   // within the accuracy, margin included
  moved,  // beyond it, also after the margin is taken off
  open    // neither can be shown
};
Verdict judge(const Movement& movement, double accuracy);

/// About how many pairs it takes until such a movement is judged, should it stay as it is.
double pairs_needed(const Movement& movement, double accuracy);

/// Run number `index` of a scene: 0 is the scene itself, the others have other seeds, or where no
/// surface has one, start elsewhere by some 1e-10 of the way (or speed).
Scene variant(const Scene& scene, int index);

/// The difference between the variants, for people; empty when there is nothing to vary.
std::string varied(const Scene& scene);

/// Whether a surface of the scene has a seed.
bool has_seeds(const Scene& scene);

/// The answer of a run from a time [s] on. `mean_squares`: those of its model's modes.
Answer answer_of(const std::vector<double>& mean_squares, const TimedRun& run, double from = 0);

/// The variants of one scene, run in memory side by side, as many as are needed.
class Ensemble {
 public:
  explicit Ensemble(const Scene& scene);

  /// Runs on until there are so many, or for so many seconds of wall time: runs that are not over
  /// by then are given up. Throws RequestError when the scene cannot be marched, Interrupted.
  void extend(int runs, double seconds = std::numeric_limits<double>::infinity());
  const std::vector<Answer>& answers() const { return answers_; }
  int runs() const { return static_cast<int>(answers_.size()); }
  const Scene& scene() const { return scene_; }
  /// Why the first run that failed did so; empty while none has.
  std::string failure() const;
  /// Processor time of the march for a simulated second; NaN while it was too short to be measured.
  double cost() const { return march_seconds_ > 0.02 ? march_seconds_ / time_ : quiet_nan; }
  /// Wall time of a run with all that belongs to it.
  double seconds_per_run() const { return answers_.empty() ? 0.0 : seconds_ / runs(); }

 private:
  /// Whether all of them came to their end within the time.
  bool run(int first, int count, double seconds);
  Scene scene_;
  std::vector<Answer> answers_;
  std::vector<double> mean_squares_;                   // of the resonator's modes
  double march_seconds_ = 0, time_ = 0, seconds_ = 0;  // of the processor; simulated; of wall time
};

/// Cost as of Ensemble, measured on the beginning of one run for about so much wall time.
double measure_cost(const Scene& scene, double enough);
/// Cost in wall time. It counts where runs have to end in time also on a busy machine.
double measure_wall_cost(const Scene& scene, double enough);

}  // namespace ra2d
