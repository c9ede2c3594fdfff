// SPDX-License-Identifier: BSD-3-Clause
#include "host/sound/sound.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t rows_together = 1 << 16;
constexpr double audible = 20e3;       // Hz, that the young hear
constexpr double passed_share = 0.91;  // of half the rate of the sound (Resampler)

/// Words for the probes of a body in messages, and its dataset.
struct ProbeWords {
  const char *body, *key, *option, *name, *velocity;
};
const ProbeWords& words_of(ProbeOf body) {
  static constexpr ProbeWords resonator{"resonator", "output.probes", "--probe", "probe",
                                        "probes/velocity"};
  static constexpr ProbeWords slider{"slider", "output.slider_probes", "--slider-probe",
                                     "slider probe", "slider_probes/velocity"};
  return body == ProbeOf::slider ? slider : resonator;
}

std::string places_text(const std::vector<double>& positions) {
  constexpr std::size_t most = 10;
  const std::vector<double> shown(
      positions.begin(),
      positions.begin() + static_cast<std::ptrdiff_t>(std::min(positions.size(), most)));
  return fmt::format("{:g}{} m", fmt::join(shown, ", "), positions.size() > most ? ", ..." : "");
}

/// How many modes ring from `low` to `high` Hz.
std::size_t modes_between(const std::vector<double>& frequencies, double low, double high) {
  return static_cast<std::size_t>(
      std::count_if(frequencies.begin(), frequencies.end(),
                    [&](double frequency) { return frequency > low && frequency <= high; }));
}

std::string ending_of(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return ending;
}

void require_room(const SoundFacts& facts, AudioFormat format, const fs::path& file) {
  if (static_cast<double>(facts.frames) <= most_frames(format)) return;
  throw RequestError(fmt::format(
      "'{}': a sound of {:.3g} s has more samples than such a file holds: take a part of it with "
      "--from and --to{}",
      file.string(), facts.seconds(),
      format == AudioFormat::flac_24 ? "" : ", or a name that ends in .flac"));
}

std::string sidecar_text(const SoundFacts& f, const fs::path& file) {
  nlohmann::ordered_json json{{"file", file.filename().string()},
                              {"body", words_of(f.body).body},
                              {"probe", f.probe},
                              {"position", f.position},
                              {"quantity", "velocity"},
                              {"full_scale_m_per_s", f.full_scale},
                              {"peak_m_per_s", f.peak},
                              {"beyond_full_scale", f.beyond},
                              {"rate", f.rate},
                              {"samples", f.frames},
                              {"slow", f.slow},
                              {"from", f.from},
                              {"to", f.to},
                              {"source", f.source.string()},
                              {"source_rate", f.source_rate},
                              {"title", f.title},
                              {"complete", f.complete},
                              {"ended", f.ended},
                              {"creator", "ra2d"},
                              {"version", version()},
                              {"commit", commit()}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

void write_all(int descriptor, std::string_view rest, const fs::path& path) {
  DescriptorStore store(descriptor);
  const auto count = static_cast<std::int64_t>(rest.size());
  if (store.write(rest.data(), count, 0) != count)
    throw write_failure("write", path, std::strerror(store.error()), store.error());
}

}  // namespace

double round_full_scale(double peak) {
  if (!(peak > 0)) return 1;
  const int decade = static_cast<int>(std::floor(std::log10(peak)));
  for (int power = decade - 1; power <= std::numeric_limits<double>::max_exponent10; ++power)
    for (const int digit : {1, 2, 5}) {
      const std::string text = fmt::format("{}e{}", digit, power);
      double scale = 0;
      std::from_chars(text.data(), text.data() + text.size(), scale);
      if (scale >= peak) return scale;
    }
  return peak;  // no double is rounder
}

std::string SoundFacts::place() const {
  return fmt::format("{} {} at {} m", words_of(body).name, probe, position);
}

// ---- the sound of a probe ----------------------------------------------------------------------

ProbeSound::ProbeSound(const fs::path& result, const SoundOptions& options) : reader_{result} {
  const ResultContents& contents = reader_.contents();
  scene_ = scene_of(contents, result);
  facts_.source = result;
  facts_.title = scene_ ? title(*scene_) : result.stem().string();
  facts_.complete = contents.summary.complete;
  facts_.ended = contents.summary.ended;
  facts_.rate = options.rate;
  facts_.slow = options.slow;
  facts_.source_rate = contents.rate;
  choose_probe(options);
  stretch_ = choose_stretch(contents, scene_, result, options.from, options.to);
  if (stretch_.count < 2)
    throw RequestError(fmt::format(
        "{}: there is nothing to listen to: {} sample{} from {:g} s to {:g} s", result.string(),
        stretch_.count, stretch_.count == 1 ? "" : "s", stretch_.from, stretch_.to));
  facts_.from = static_cast<double>(stretch_.first) / contents.rate;
  facts_.to = static_cast<double>(stretch_.first + stretch_.count - 1) / contents.rate;
  facts_.frames = resampled_count(stretch_.count, contents.rate / facts_.slow, facts_.rate);
  find_peak(options);
  doubt_silence();
  doubt_rate();
  doubt_clipping();
}

void ProbeSound::choose_probe(const SoundOptions& options) {
  const ProbeWords& words = words_of(options.body);
  const ResultContents& contents = reader_.contents();
  const bool slider = options.body == ProbeOf::slider;
  const std::vector<double>& positions =
      slider ? contents.slider_probe_position : contents.probe_position;
  const std::size_t others =
      (slider ? contents.probe_position : contents.slider_probe_position).size();
  const ProbeWords& other = words_of(slider ? ProbeOf::resonator : ProbeOf::slider);
  if (positions.empty())
    throw RequestError(fmt::format(
        "{}: it has no {} to listen to: name a place on the {} in the scene, as {} = [{}], and run "
        "it again{}",
        facts_.source.string(), words.name, words.body, words.key, slider ? "0.01" : "0.15",
        others > 0 ? fmt::format(" (there {} {} of the {}: {} 1)", others == 1 ? "is" : "are",
                                 others, other.body, other.option)
                   : ""));
  if (options.probe < 1 || options.probe > positions.size())
    throw RequestError(fmt::format("{}: {} {}: expected 1 to {} (at {})", facts_.source.string(),
                                   words.option, options.probe, positions.size(),
                                   places_text(positions)));
  facts_.body = options.body;
  facts_.probe = options.probe;
  facts_.position = positions[options.probe - 1];
}

void ProbeSound::each_sample(const TakeSamples& take) const {
  Resampler resampler(facts_.source_rate / facts_.slow, facts_.rate);
  for (std::size_t done = 0; done < stretch_.count; done += rows_together) {
    const std::size_t now = std::min(rows_together, stretch_.count - done);
    const auto columns = reader_.columns(words_of(facts_.body).velocity, stretch_.first + done, now,
                                         facts_.probe - 1, 1);
    resampler.feed(columns.front(), take);
  }
  resampler.finish(take);
}

/// The peak of what is heard: between samples there may be more than in any.
void ProbeSound::find_peak(const SoundOptions& options) {
  const double wanted = options.full_scale.value_or(0);
  each_sample([&](std::span<const double> samples) {
    for (const double v : samples) {
      facts_.peak = std::max(facts_.peak, std::abs(v));
      facts_.beyond += wanted > 0 && std::abs(v) > wanted;
    }
  });
  facts_.full_scale = options.full_scale                     ? wanted
                      : options.normalize && facts_.peak > 0 ? facts_.peak
                                                             : round_full_scale(facts_.peak);
  if (!(facts_.peak > 0)) return;
  // a WAV holds floats, and nothing beyond them
  const double share = facts_.peak / facts_.full_scale;
  constexpr double most = std::numeric_limits<float>::max(),
                   least = std::numeric_limits<float>::min();
  if (share >= least && share <= most) return;
  throw RequestError(
      fmt::format("--full-scale {:g}: the peak is {:.4g} m/s, {:.3g} times that, and the numbers "
                  "of a sound file "
                  "go from {:.3g} to {:.3g}: expected a velocity near the peak",
                  wanted, facts_.peak, share, least, most));
}

void ProbeSound::play(const TakeSamples& take) const {
  std::vector<double> scaled;
  each_sample([&](std::span<const double> samples) {
    scaled.assign(samples.begin(), samples.end());
    for (double& value : scaled) value /= facts_.full_scale;
    take(scaled);
  });
}

// ---- what a listener should know ---------------------------------------------------------------

void ProbeSound::doubt_silence() {
  if (facts_.peak > 0) return;
  facts_.doubts.push_back(
      fmt::format("silence: the {} at {:g} m does not move from {:g} s to {:g} s{}",
                  words_of(facts_.body).name, facts_.position, facts_.from, facts_.to,
                  facts_.position == 0 && facts_.body == ProbeOf::resonator
                      ? "; at a support there is nothing to hear"
                      : ""));
}

void ProbeSound::doubt_rate() {
  const ResultContents& contents = reader_.contents();
  const std::vector<double>& modes =
      facts_.body == ProbeOf::slider ? contents.slider_frequency : contents.resonator_frequency;
  const char* const body = words_of(facts_.body).body;
  const double carried = facts_.source_rate / 2,
               heard = std::min(carried, passed_share * facts_.rate / 2 * facts_.slow);
  const double highest = modes.empty() ? 0.0 : *std::max_element(modes.begin(), modes.end());
  if (const std::size_t above = modes_between(modes, carried, HUGE_VAL); above > 0)
    facts_.doubts.push_back(fmt::format(
        "output.rate is too low: {} of the {}'s modes ring above {:g} Hz, half the rate of "
        "the samples, the highest at {:.4g} Hz. They are heard at frequencies that are not theirs. "
        "Run with output.rate above {:.3g}",
        above, body, carried, highest, 2 * highest));
  else if (carried < audible)
    facts_.doubts.push_back(fmt::format(
        "output.rate is low: nothing above {:g} Hz, half the rate of the samples, can be in this "
        "sound, and ears go to {:g} Hz. Run with output.rate = {:g} or more",
        carried, audible, 2 * audible));
  if (const std::size_t lost = modes_between(modes, heard, std::min(carried, audible)); lost > 0)
    facts_.doubts.push_back(
        fmt::format("--rate {} passes what is below {:.4g} Hz: {} of the {}'s modes are "
                    "left out. Take --rate 48000",
                    facts_.rate, heard, lost, body));
}

void ProbeSound::doubt_clipping() {
  constexpr double smallest = 0x1p-23;  // that a FLAC of 24 bits tells from 0
  if (facts_.peak > 0 && facts_.peak < smallest * facts_.full_scale)
    facts_.doubts.push_back(fmt::format(
        "the peak, {:.4g} m/s, is {:.3g} of --full-scale {:g} m/s: a FLAC, whose 24 bits "
        "hold nothing below {:.2g}, is silent, and a WAV is too soft to hear",
        facts_.peak, facts_.peak / facts_.full_scale, facts_.full_scale, smallest));
  if (facts_.beyond == 0) return;
  facts_.doubts.push_back(fmt::format(
      "{} of {} samples are beyond --full-scale {:g} m/s, the peak is {:.4g} m/s: FLAC clips them, "
      "in WAV they stand, and players clip them",
      facts_.beyond, facts_.frames, facts_.full_scale, facts_.peak));
}

// ---- files -------------------------------------------------------------------------------------

AudioNotes notes_of(const SoundFacts& f) {
  std::string comment = fmt::format("velocity of {}, the value 1.0 is {} m/s; {} s to {} s",
                                    f.place(), f.full_scale, f.from, f.to);
  if (f.slow != 1) comment += fmt::format("; {} times slower", f.slow);
  return {printable(f.title), comment, program_text()};
}

AudioFormat sound_format(const fs::path& file) {
  const std::string ending = ending_of(file);
  if (ending == ".wav") return AudioFormat::wav_float;
  if (ending == ".flac") return AudioFormat::flac_24;
  throw RequestError(
      fmt::format("'{}': expected a name that ends in .wav or .flac", file.string()));
}

fs::path sidecar_of(const fs::path& sound) {
  fs::path file = sound;
  return file += ".json";
}

void write_sound(const ProbeSound& sound, const fs::path& file) {
  const SoundFacts& facts = sound.facts();
  const AudioFormat format = sound_format(file);
  require_room(facts, format, file);
  const fs::path sidecar_file = sidecar_of(file);
  PartialFile audio(file), sidecar(sidecar_file);
  DescriptorStore store(audio.descriptor());
  AudioWriter writer(store, format, facts.rate, notes_of(facts), file);
  sound.play([&](std::span<const double> samples) { writer.write(samples); });
  writer.close();
  write_all(sidecar.descriptor(), sidecar_text(facts, file), sidecar_file);
  audio.sync();
  sidecar.sync();
  sidecar.publish();
  try {
    audio.publish();
  } catch (const FileError&) {
    unlink(sidecar_file.c_str());
    throw;
  }
}

}  // namespace ra2d
