// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace ra2d {

/// The tone that linear faces make: a node of the slider passes one of the resonator.
struct MeshTone {
  double frequency = 0;  // Hz, mesh_tone_frequency; NaN where there is none, or no scene is known
  bool in_spectrum = false;  // below half the rate of the samples
  double rise = 0;           // dB, above the spectrum around it; NaN where that cannot be found
  double by_chance = 0;  // dB, that it may rise without any tone (rise_by_chance); NaN with rise

  bool stands_out() const { return rise > by_chance; }
};

/// How far the highest of five lines rises above the median of those around by chance [dB]: once in
/// a thousand spectra of Gaussian noise without a tone, or in fewer. A density is chi-square of
/// `degrees_of_freedom`.
double rise_by_chance(double degrees_of_freedom);

/// How far a mode's own peak may rise there [dB], should it stand at the tone; 0 where no natural
/// frequency [Hz] is among the lines around it. Contact moves modes, so that its place is not
/// believed.
double rise_of_a_mode(const std::vector<double>& natural, double damping, double tone,
                      double resolution);

/// Finds the tone's rise while samples come, as the spectrum of the whole stretch (usual_segment)
/// has it to within 0.05 dB, from the lines around it alone: the velocities are shifted by the
/// tone's frequency and averaged under cubic splines so that some 128 values of a segment are left.
class MeshToneWatch {
 public:
  /// Watches the frequency, if it is over 0, in the samples `first` to `first + count` of a run at
  /// `rate` [Hz].
  MeshToneWatch(double frequency, std::size_t first, std::size_t count, double rate,
                std::size_t modes);

  /// Velocities of all modes, sample by sample in order; the first of them is sample `at` of the
  /// run.
  void add_rows(std::size_t at, std::span<const double> rows);

  /// As far as it went. `weights`: means of psi_k^2 over the resonator.
  MeshTone tone(const std::vector<double>& weights, const std::vector<double>& natural,
                double damping) const;

  /// All that it has added up, to be kept and gone on from.
  struct Sums {
    std::vector<double> block;                   // (part, mode), of the present block
    std::size_t rows = 0;                        // of the stretch
    std::vector<std::complex<double>> averages;  // (block, mode)
  };
  const Sums& sums() const { return sums_; }
  /// Throws std::invalid_argument where they are of another stretch or other modes.
  void go_on(Sums sums);

 private:
  void end_block();

  double frequency_, rate_;
  std::size_t first_, count_, modes_, segment_, line_ = 0, block_ = 0;  // samples of a block
  std::vector<double>
      kernel_;  // (sample of a block, part): real and imaginary parts of four splines
  Sums sums_;
};

}  // namespace ra2d
