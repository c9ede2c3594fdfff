// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/analysis/sound_pressure.hpp"
#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/python.hpp"
#include "host/store/result_reader.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr double least_rate = 8e3, most_rate = 384e3, most_slow = 1e4;
constexpr int most_flac_rate = 65'535, flac_rate_step = 10;  // Hz; above the one multiples alone

struct Wanted {
  fs::path result, output;
  std::string bits = "24";
  std::size_t probe = 1;
  bool of_slider = false, normalize = false, quiet = false;
  double slow = 1;
  int rate = 48'000;
  std::optional<double> full_scale, from, to;
  SoundRequest sound;
};

constexpr std::size_t most_channels = 2;

/// The encoding by the ending of the name and the bits that are asked for.
std::string encoding_of(const Wanted& wanted, bool bits_given) {
  std::string ending = wanted.output.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".wav") return "wav-" + wanted.bits;
  if (ending != ".flac")
    throw RequestError(
        fmt::format("'{}': expected a name that ends in .wav or .flac", wanted.output.string()));
  if (bits_given && wanted.bits != "24")
    throw RequestError(fmt::format("--bits {}: a FLAC has 24 bits", wanted.bits));
  if (wanted.rate > most_flac_rate && wanted.rate % flac_rate_step != 0)
    throw RequestError(
        fmt::format("--rate {}: above {} Hz a FLAC has multiples of {} Hz alone: take {}, or a WAV",
                    wanted.rate, most_flac_rate, flac_rate_step,
                    (wanted.rate + flac_rate_step / 2) / flac_rate_step * flac_rate_step));
  return "flac-24";
}

/// By the result and by what is heard.
std::string usual_name(const Wanted& wanted) {
  std::string name = wanted.result.stem().string();
  for (const Position& at : wanted.sound.microphones)
    name += fmt::format("-at-{},{},{}", at[0], at[1], at[2]);
  if (wanted.of_slider || wanted.probe != 1)
    name += fmt::format("{}-probe-{}", wanted.of_slider ? "-slider" : "", wanted.probe);
  return name + ".wav";
}

/// Where it is said what the values of a sound stand for: NAME.wav.json.
fs::path sidecar_of(const fs::path& sound) {
  fs::path file = sound;
  return file += ".json";
}

/// Throws FileError where the file does not hold together, or where the probe's velocity is none
/// that a run can have come to: what its seal does not tell.
void require_velocity(const Wanted& wanted) {
  constexpr std::size_t rows_at_once = 1 << 16;
  const ResultReader reader(wanted.result);
  const ResultContents& contents = reader.contents();
  const auto& probes = wanted.of_slider ? contents.slider_probe_position : contents.probe_position;
  if (wanted.probe < 1 || wanted.probe > probes.size()) return;  // which Python refuses
  for (std::size_t first = 0; first < contents.samples; first += rows_at_once)
    reader.columns(wanted.of_slider ? "slider_probes/velocity" : "probes/velocity", first,
                   std::min(rows_at_once, contents.samples - first), wanted.probe - 1, 1);
}

/// Writes the pressure at each microphone, one after the other, as numbers of eight bytes. Returns
/// the description of it for Python.
nlohmann::ordered_json write_pressure(const Wanted& wanted, PartialFile& file) {
  const ResultReader reader(wanted.result);
  const ResultContents& contents = reader.contents();
  const std::optional<Scene> scene = scene_of(contents, wanted.result);
  const SoundRequest request = scene ? wanted.sound.completed(*scene) : wanted.sound;
  const SoundingResonator resonator = sounding_resonator(reader, scene, wanted.result, request);
  const Stretch stretch = choose_stretch(contents, scene, wanted.result, wanted.from, wanted.to);
  std::vector<HeardSound> heard =
      hear(reader, resonator, stretch, wanted.result, request, Silence::heard);
  // both channels play the same time
  std::size_t first = 0, beyond = std::numeric_limits<std::size_t>::max();
  for (const HeardSound& sound : heard) {
    first = std::max(first, sound.first);
    beyond = std::min(beyond, sound.first + sound.pressure.size());
  }
  if (beyond < first + 2)
    throw RequestError(fmt::format(
        "{}: there is no time at which both microphones hear the record: take a longer stretch",
        wanted.result.string()));
  nlohmann::ordered_json places = nlohmann::ordered_json::array();
  for (const HeardSound& sound : heard) {
    const double* samples = sound.pressure.data() + (first - sound.first);
    file.write({reinterpret_cast<const char*>(samples), (beyond - first) * sizeof(double)});
    places.push_back(sound.position);
  }
  return {{"microphones", places},
          {"sound_speed", resonator.air.sound_speed},
          {"air_density", resonator.air.density},
          {"from", static_cast<double>(first) / contents.rate},
          {"to", static_cast<double>(beyond - 1) / contents.rate}};
}

/// Puts the sound and the text about it in place: both or neither.
void publish(PartialFile& sound, PartialFile& sidecar, const fs::path& sidecar_name) {
  sound.sync();
  sidecar.sync();
  sidecar.publish();
  try {
    sound.publish();
  } catch (const FileError&) {
    unlink(sidecar_name.c_str());
    throw;
  }
}

int make_sound(Wanted& wanted, bool bits_given) {
  if (wanted.sound.microphones.size() > most_channels)
    throw RequestError(
        fmt::format("{} microphones (--at): a sound has one channel or two; "
                    "'ra2d analyze' takes more",
                    wanted.sound.microphones.size()));
  if (wanted.output.empty()) wanted.output = usual_name(wanted);
  const std::string encoding = encoding_of(wanted, bits_given);
  const fs::path sidecar_name = sidecar_of(wanted.output);
  for (const fs::path& file : {wanted.output, sidecar_name})
    require_derived_output(file, {wanted.result});
  const ResultStamp stamp = read_stamp(wanted.result);
  wanted.sound.require_sense();
  const bool at_microphones = wanted.sound.asks();
  if (!at_microphones) require_velocity(wanted);
  if (!stamp.complete && !wanted.quiet)
    say(fmt::format("{}: the run was cut short: {}", wanted.result.string(), stamp.ended));
  PartialFile sound(wanted.output), sidecar(sidecar_name);
  nlohmann::ordered_json options{
      {"slow", wanted.slow}, {"rate", wanted.rate}, {"normalize", wanted.normalize}};
  if (wanted.full_scale) options["full_scale"] = *wanted.full_scale;
  nlohmann::ordered_json request{{"command", "sound"},
                                 {"quiet", wanted.quiet},
                                 {"made", path_text(wanted.output)},
                                 {"file", path_text(wanted.result)},
                                 {"output", path_text(sound.path())},
                                 {"sidecar", path_text(sidecar.path())},
                                 {"encoding", encoding}};
  std::optional<PartialFile> pressure;  // for Python alone: it never gets a name
  if (at_microphones) {
    pressure.emplace(fs::path(wanted.output) += ".pressure");
    request["heard"] = write_pressure(wanted, *pressure);
    pressure->sync();
    request["pressure"] = path_text(pressure->path());
  } else {
    options["probe"] = wanted.probe;
    options["body"] = wanted.of_slider ? "slider" : "resonator";
    if (wanted.from) options["start"] = *wanted.from;
    if (wanted.to) options["stop"] = *wanted.to;
  }
  request["options"] = options;
  const int status = ask_python(request);
  if (status == exit_status::done) publish(sound, sidecar, sidecar_name);
  return status;
}

/// Where the sound comes from: a probe of either body, or microphones.
void add_sources(CLI::App& sound, Wanted& options) {
  CLI::Option* probe =
      sound
          .add_option("--probe", options.probe,
                      "plays the velocity of a probe, which is no sound pressure: which of "
                      "output.probes, from 1")
          ->type_name("N")
          ->transform(count())
          ->capture_default_str();
  CLI::Option* slider_probe = sound
                                  .add_option_function<std::size_t>(
                                      "--slider-probe",
                                      [&options](std::size_t number) {
                                        options.probe = number;
                                        options.of_slider = true;
                                      },
                                      "instead of it: which of output.slider_probes, from 1")
                                  ->type_name("N")
                                  ->transform(count())
                                  ->excludes(probe);
  CLI::Option* at = add_microphones(sound, options.sound);
  at->description(at->get_description() + ": two make a stereo sound");
  at->excludes(probe);
  at->excludes(slider_probe);
}

}  // namespace

void add_sound(CLI::App& app, ChosenCommand& chosen) {
  const auto wanted = std::make_shared<Wanted>();
  Wanted& options = *wanted;
  CLI::App* sound = app.add_subcommand(
      "sound",
      "the sound pressure at a microphone (--at), or the velocity of a probe, as WAV or FLAC; "
      "NAME.json beside it says what the values stand for; needs Python");
  sound->add_option("OUT.h5", wanted->result, "result of 'ra2d run'")->required()->check(path());
  sound
      ->add_option("-o,--output", wanted->output,
                   "sound file, .wav or .flac (24 bit) [OUT's name and what is heard, with .wav, "
                   "in the current folder]")
      ->type_name("NOISE.wav")
      ->check(path());
  CLI::Option* bits = sound->add_option("--bits", options.bits, "of a WAV's samples")
                          ->type_name("N")
                          ->check(CLI::IsMember({"16", "24", "32", "float"}))
                          ->capture_default_str();
  add_sources(*sound, options);
  sound->add_option("--slow", options.slow, "how many times longer it lasts, and lower it sounds")
      ->type_name("N")
      ->check(number_from(1, most_slow, "from 1 to 10000"))
      ->capture_default_str();
  sound->add_option("--rate", options.rate, "samples a second of the sound")
      ->type_name("HZ")
      ->transform(count().description(""))
      ->check(number_from(least_rate, most_rate, "from 8000 to 384000"))
      ->capture_default_str();
  CLI::Option* normalize =
      sound->add_flag("--normalize", options.normalize, "the loudest sample is full scale");
  sound
      ->add_option("--full-scale", options.full_scale,
                   "velocity (m/s), with --at pressure (Pa), that full scale stands for [1, 2 or 5 "
                   "times a power of ten, the next above the peak]")
      ->type_name("VALUE")
      ->check(positive_number())
      ->excludes(normalize);
  add_stretch(*sound, options.from, options.to);
  sound->add_flag("--quiet", wanted->quiet, "print nothing but errors");
  sound->callback([wanted, bits, &chosen] {
    chosen.run = [wanted, given = bits->count() > 0] { return make_sound(*wanted, given); };
  });
}

}  // namespace ra2d
