// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/analysis/level_history.hpp"
#include "host/analysis/mesh_tone.hpp"
#include "host/analysis/peaks.hpp"
#include "host/analysis/power_balance.hpp"
#include "host/analysis/shock_statistics.hpp"
#include "host/analysis/sound_power.hpp"
#include "host/analysis/sound_pressure.hpp"
#include "host/analysis/spectrum.hpp"
#include "host/scene/scene.hpp"

/// The analysis of a result (docs/analysis.md): level, spectrum, bands, shocks, powers.
namespace ra2d {

struct AnalysisOptions {
  std::optional<double> resolution;    // Hz, between the lines of the spectrum ...
  std::optional<std::size_t> segment;  // ... or samples of a segment; else usual_segment()
  std::optional<double> from, to;      // s; else output.from, and the end of the run
  bool a_weighting = false;
  SoundRequest sound;
};

/// Densities; of the velocity in (m/s)^2/Hz, of the contact force less its mean in N^2/Hz. Empty
/// where the stretch is too short for a segment.
struct VelocitySpectrum {
  double resolution = 0;  // Hz
  std::vector<double> frequency;
  std::vector<double> mean;                // over the resonator, of its elastic motion
  std::vector<std::vector<double>> probe;  // of each, on the resonator
  std::vector<std::vector<double>> slider_probe;
  std::vector<double> force;
  std::size_t segments = 0;
  double degrees_of_freedom = 0;
  Confidence confidence;
};

/// Levels in dB re 1 nm/s.
struct BandLevels {
  std::vector<int> number;                       // of third octaves (third_octave_centre)
  std::vector<double> level;                     // over the resonator, of its elastic motion
  std::vector<double> spread;                    // dB, of stationary noise (band_spread)
  std::vector<double> level_a;                   // A-weighted; empty unless it was asked for
  std::vector<std::vector<double>> level_probe;  // of each probe, not weighted
};

struct Analysis {
  std::filesystem::path file;
  std::string title;
  std::optional<Scene> scene;  // none: the file's is not understood
  std::string key;             // of the run; empty in files of older programs
  bool complete = true;
  std::string ended;
  double rate = 0;            // Hz, of the samples
  double from = 0, to = 0;    // s, the stretch
  std::size_t samples = 0;    // in it
  bool whole = true;          // all that the file's own summary counts
  bool has_modes = true;      // false: of the resonator as a whole the file tells no spectrum
  double v_rms = 0, lv = 0;   // m/s, dB; NaN where there is none
  LevelHistory history;       // of the stretch, in 200 parts or fewer
  IntervalsOfRun intervals;   // of lv and shocks.rate, by chance within this run
  double lv_a = 0;            // dB, A-weighted; NaN unless it was asked for
  double contact_share = 0;   // of the time; NaN unless the stretch is whole
  double energy_closure = 0;  // of the file's summary; NaN unless the stretch is whole
  double modal_damping = 0;   // of the resonator; NaN where the scene is not known
  ShockStatistics shocks;
  PowerBalance energy;
  double energy_per_shock = 0;  // J, given to both bodies; NaN without shocks or without a balance
  VelocitySpectrum spectrum;
  BandLevels bands;
  std::vector<double> probe_position;           // m, on the resonator
  std::vector<double> slider_probe_position;    // m, on the slider
  std::vector<double> probe_y, slider_probe_y;  // m, across them, of an areal scene
  std::vector<double> natural_frequencies;      // Hz, of the resonator's elastic modes
  /// Elastic modes of the resonator above half the rate of the samples: their power stands in
  /// spectrum and bands at frequencies that are not theirs.
  std::size_t aliased_modes = 0;
  std::vector<SpectralPeak> peaks;
  MeshTone mesh;
  Air air;  // of the sound, where some was asked for
  std::vector<MicrophoneLevels> microphones;
  std::optional<RadiatedPower> power;
  std::string no_sound;  // why the scene's own microphones hear nothing; empty: they do
};

/// For each third octave, whether it lies above that mode: its level is that of the flank of lower
/// modes, and would differ with more modes.
std::vector<bool> bands_above_modes(const Analysis& analysis, const std::vector<int>& numbers);

/// Reads and analyses a result. Throws FileError of the file, and RequestError where the options
/// ask for what it does not have.
Analysis analyze(const std::filesystem::path& file, const AnalysisOptions& options);

}  // namespace ra2d
