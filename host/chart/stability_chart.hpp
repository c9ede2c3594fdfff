// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/plan/stability.hpp"

/// The paper's Table 1, corrected: limits of stability from theory beside those of the march.
namespace ra2d {

/// Where growth itself is compared, x = omega tau: also of what grows at every step.
inline constexpr double growth_at = 0.1;

/// One limit: the largest x = omega tau up to which a mode of damping ratio zeta stays bounded, or,
/// in contact, the largest omega_c tau of the spring that holds such a mode (TrialMode).
struct Limit {
  TimeSettings choice;
  bool contact = false;
  double zeta = 0;
  double theory = 0;                              // 0: grows at every step; infinity: at none
  double low = 0, high = 0;                       // what the march says: it lies in between
  double growth_theory = 0, growth_measured = 0;  // ln of the factor of a step of growth_at
};

struct ChartOptions {
  std::vector<double> zetas{0.0, 0.02, 0.2, 0.7};
  int steps = 4096;         // of each march
  double precision = 1e-4;  // (high - low)/high of a limit that was found
};

/// The schemes of the chart, in its order.
std::vector<TimeSettings> chart_schemes();

/// Every scheme, free and in contact, for every zeta. Steps are tried from x = 0.01 to 10, and more
/// of them next to the theory's limit; then the first change from no growth to growth is narrowed
/// down.
std::vector<Limit> make_limits(const ChartOptions& options = {});

/// The chart for people.
std::string describe(const std::vector<Limit>& limits);

/// The limits for programs, a row for each. motion_zeta is the damping ratio of the motion that x
/// counts: in contact, the mode's damping relative to the spring.
std::string limits_csv(const std::vector<Limit>& limits);

/// Boundaries of the stability regions: for damping ratios from 0 to 1, z = x (-zeta + i sqrt(1 -
/// zeta^2)) at the limit x; and the same of a contact spring much stiffer than the mode that it
/// holds, zeta then being the spring's, what the mode's damping is to it.
std::string regions_csv();

/// Eigenvalues times the step of a scene: of its free modes, and under penalty with one node closed
/// where the bodies yield most. Comments name the scene and the step.
std::string modes_csv(const Model& model);

}  // namespace ra2d
