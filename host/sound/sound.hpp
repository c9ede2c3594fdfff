// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/analysis/stretch.hpp"
#include "host/sound/audio_file.hpp"
#include "host/sound/resampler.hpp"
#include "host/store/result_reader.hpp"

/// The velocity of a probe, to listen to (docs/sound.md).
namespace ra2d {

enum class ProbeOf { resonator, slider };

struct SoundOptions {
  std::size_t probe = 1;  // its number among those of its body, from 1
  ProbeOf body = ProbeOf::resonator;
  double slow = 1;                   // how many times longer it lasts
  int rate = 48'000;                 // Hz, of the sound
  bool normalize = false;            // the peak is full scale
  std::optional<double> full_scale;  // m/s that the value 1 stands for; else the next round one
  std::optional<double> from, to;    // s; else output.from, and the end of the run
};

/// Facts about a sound: its source, its scale, its limits.
struct SoundFacts {
  std::filesystem::path source;  // the result
  std::string title;
  bool complete = true;
  std::string ended;
  std::size_t probe = 1;
  ProbeOf body = ProbeOf::resonator;
  double position = 0;     // m, of the probe, on its body
  double full_scale = 1;   // m/s that the value 1 stands for
  double peak = 0;         // m/s, of the sound
  std::size_t beyond = 0;  // samples beyond full scale
  int rate = 0;            // Hz
  double slow = 1;
  double from = 0, to = 0;  // s, of the run
  std::size_t frames = 0;   // samples of the sound
  double source_rate = 0;   // Hz, of the result's samples
  std::vector<std::string> doubts;

  double seconds() const { return static_cast<double>(frames) / rate; }  // of the sound
  std::string place() const;                                             // "probe 1 at 0.15 m"
};

/// The smallest of 1, 2, 5 times a power of ten that is not below; 1 for 0.
double round_full_scale(double peak);

/// The sound of a probe, found and scaled; its samples are read and resampled anew each time they
/// are asked for, some at a time. Throws RequestError where the result has no such probe or
/// stretch.
class ProbeSound {
 public:
  ProbeSound(const std::filesystem::path& result, const SoundOptions& options);

  const SoundFacts& facts() const { return facts_; }
  /// Calls `take` with all samples, full scale at 1.
  void play(const TakeSamples& take) const;

 private:
  void each_sample(const TakeSamples& take) const;  // m/s
  void choose_probe(const SoundOptions& options);
  void find_peak(const SoundOptions& options);
  void doubt_silence();
  void doubt_rate();
  void doubt_clipping();

  ResultReader reader_;
  std::optional<Scene> scene_;
  Stretch stretch_;
  SoundFacts facts_;
};

/// The texts that players show.
AudioNotes notes_of(const SoundFacts& facts);

/// The format that a name asks for by its ending. Throws RequestError.
AudioFormat sound_format(const std::filesystem::path& file);

/// Where it is said what the values of a sound stand for: NAME.wav.json.
std::filesystem::path sidecar_of(const std::filesystem::path& sound);

/// Writes both; both appear whole, or none.
void write_sound(const ProbeSound& sound, const std::filesystem::path& file);

}  // namespace ra2d
