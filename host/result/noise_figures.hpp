// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// The figures of a run from output.from on. Those of shocks are NaN where there was no shock.
struct NoiseFigures {
  double v_rms = 0;                                         // m/s
  double lv = 0;                                            // dB re 1e-9 m/s; -inf at rest
  double shock_rate = 0;                                    // per simulated second
  double shock_duration_median = 0, shock_duration_90 = 0;  // s
  double peak_force_median = 0, peak_force_90 = 0;          // N
  double contact_share = 0;                                 // of the time
  double nodes_evaluated = 0;                               // a step, over the whole run
};

}  // namespace ra2d
