// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/analysis/bands.hpp"
#include "host/analysis/level_history.hpp"
#include "host/analysis/stretch.hpp"
#include "host/radiation/pressure.hpp"
#include "host/store/result_reader.hpp"

/// The sound of a result's resonator in a rigid baffle: the pressure at microphones
/// (docs/sound.md).
namespace ra2d {

/// The sound that is asked for.
struct SoundRequest {
  std::vector<Position> microphones;  // m: from the resonator's left end, its edge, its plane
  bool power = false;
  std::optional<double> celsius, pascal;  // of the air; none: the usual ones

  bool asks() const { return power || !microphones.empty(); }
  /// Throws RequestError where it names an air, and no sound. `has_power`: of a command that finds
  /// the sound power, too.
  void require_sense(bool has_power = false) const;
  /// With the scene's microphones, where it has none of its own, and its air.
  SoundRequest completed(const Scene& scene) const;
};

/// The resonator of a result as it radiates. Throws RequestError where the file does not have what
/// it takes, FileError where its scene is not that of its modes.
struct SoundingResonator {
  Body body;
  Radiator face;
  Air air;
  double mass_per_area = 0;  // kg/m^2
  double extent = 0;         // over which a squared shape has the integral 1: m, of a plate m^2
  double squared_shape = 0;  // integral of one over the face: m, of a plate 1
};
SoundingResonator sounding_resonator(const ResultReader& reader, const std::optional<Scene>& scene,
                                     const std::filesystem::path& file,
                                     const SoundRequest& request);

/// Throws RequestError for a microphone in the plane of the baffle, or nearly.
void require_height(const Position& at);

/// Why so many microphones are too many for a record of so many samples: they would take hours, or
/// more memory than there is. Empty where they are not.
std::string too_many_microphones(const Radiator& face, const Air& air, std::size_t microphones,
                                 double rate, std::size_t samples);

/// The samples of all modes' velocities.
VelocityRecord velocity_record(const ResultReader& reader);

/// Sound pressure at a microphone.
struct HeardSound {
  Position position{};
  Distances distances;           // m, from the face
  double from = 0, to = 0;       // s, what is heard
  std::size_t first = 0;         // its first sample's number in the run
  std::vector<double> pressure;  // Pa
};

/// Whether the silence before the sound of a run comes to a microphone is heard, too. In a level it
/// would count as noise that is not there.
enum class Silence { heard, left_out };

/// At each microphone of the request, what of the stretch the record carries. Throws RequestError
/// where a microphone cannot stand, or nothing of it is heard.
std::vector<HeardSound> hear(const ResultReader& reader, const SoundingResonator& resonator,
                             const Stretch& stretch, const std::filesystem::path& file,
                             const SoundRequest& request, Silence silence = Silence::left_out);

/// The level of a sound pressure [dB re 20 uPa].
double pressure_level(double rms);

/// Why a stretch that is shorter (shortest_stretch) has neither sound power nor dB(A): for people.
std::string too_short_text(double shortest);

/// The frequency of the last mode [Hz]; NaN where there is none that is elastic.
double last_mode(const std::vector<double>& frequencies);

/// Where much of a level, A-weighted or not, comes from above the last mode: what to say of it.
/// Empty where little does.
std::string above_modes_text(const SharesAbove& shares, double last_mode);

/// Levels at a microphone.
struct MicrophoneLevels {
  Position position{};
  double distance = 0;                         // m, the least one from the face
  double arrives = 0;                          // s, that the sound takes from there
  double from = 0, to = 0;                     // s, what is heard
  double rms = 0, peak = 0;                    // Pa
  double lp = 0, lp_a = 0;                     // dB re 20 uPa; A-weighted, NaN: too short
  double shortest = 0;                         // s, of a stretch with lp_a
  SharesAbove above;                           // of the power, above the band of last_mode
  double last_mode = 0;                        // Hz
  IntervalsOfRun intervals;                    // of lp
  std::vector<int> number;                     // of third octaves
  std::vector<double> level, level_a, spread;  // dB
  LevelHistory history;                        // of the pressure, in Pa^2
};

/// The sound of a result at the microphones of its scene.
struct SceneSound {
  std::vector<MicrophoneLevels> microphones;
  std::string why_none;  // empty where there are some, or none in the scene
};
SceneSound sound_of_scene(const Scene& scene, const std::filesystem::path& file);

/// "63.15 dB re 20 uPa, 61.57 dB(A) at 0.15, 0.1, 0.5 m".
std::string level_text(const MicrophoneLevels& microphone);
/// A warning for a reader of these levels; mostly empty.
std::string warning_of(const MicrophoneLevels& microphone);

/// `frequencies` [Hz] and `damping` of the resonator's modes; without damping there is no interval.
MicrophoneLevels levels_of(const HeardSound& sound, double rate,
                           const std::vector<double>& frequencies, double damping);

}  // namespace ra2d
