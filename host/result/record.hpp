// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

/// The samples and shocks of a run: plain numbers, which need nothing of the device.
namespace ra2d {

/// Samples, any number at a time; every vector is row-major, one row a sample.
struct SampleBlock {
  std::vector<double> time;                                        // T, s
  std::vector<double> resonator_displacement, resonator_velocity;  // T x M2
  std::vector<double> slider_displacement, slider_velocity;        // T x M1
  std::vector<double> force, nodes;                                // T: N, count
  std::vector<double> probe_displacement, probe_velocity;          // T x P: m, m/s
  std::vector<double> slider_probe_displacement, slider_probe_velocity;
  std::vector<double> kinetic, elastic, contact, damping_loss, sliding_work, load_work;  // T, J
};

/// One shock: a connected piece of contact in space and time.
struct Shock {
  long serial = 0;      // number of the shock in order of start, from 0; merged shocks leave holes
  double start = 0;     // s
  double duration = 0;  // s
  double peak_force = 0;  // N
  double impulse = 0;     // N s
  double position = 0;    // m on the resonator, mean weighted by force
  double y = 0;           // m, areal scenes: the same across
};

/// Whether all values of the samples are numbers.
bool is_finite(const SampleBlock& block);

}  // namespace ra2d
