// SPDX-License-Identifier: BSD-3-Clause
#include "host/sound/sound.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "host/base/exit_status.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr double least_rate = 8e3, most_rate = 384e3, most_slow = 1e4;

struct Wanted {
  fs::path result, output;
  SoundOptions options;
  bool quiet = false;
};

void print_facts(const SoundFacts& f, const fs::path& file) {
  print("velocity of {}, from {:g} s to {:g} s{}\n", f.place(), f.from, f.to,
        f.slow == 1 ? "" : fmt::format(", {:g} times slower", f.slow));
  print_line("length",
             fmt::format("{}, {} samples at {} Hz", seconds_text(f.seconds()), f.frames, f.rate));
  print_line("full scale", fmt::format("1.0 in the file is {:g} m/s", f.full_scale));
  if (f.peak > 0)
    print_line("peak", fmt::format("{:.4g} m/s, {:.1f} dB of full scale", f.peak,
                                   20 * std::log10(f.peak / f.full_scale)));
  print_line("file", printable(file.string()));
  print_line("beside it", printable(sidecar_of(file).string()));
}

int make_sound(Wanted& wanted) {
  if (wanted.output.empty()) wanted.output = wanted.result.stem().string() + ".wav";
  sound_format(wanted.output);
  for (const fs::path& file : {wanted.output, sidecar_of(wanted.output)})
    require_derived_output(file, {wanted.result});
  const ProbeSound sound(wanted.result, wanted.options);
  const SoundFacts& facts = sound.facts();
  if (!facts.complete && !wanted.quiet)
    say(fmt::format("{}: the run was cut short: {}", wanted.result.string(), facts.ended));
  write_sound(sound, wanted.output);
  say_doubts(facts.doubts, wanted.quiet);
  if (!wanted.quiet) print_facts(facts, wanted.output);
  return exit_status::done;
}

}  // namespace

void add_sound(CLI::App& app, ChosenCommand& chosen) {
  const auto wanted = std::make_shared<Wanted>();
  SoundOptions& options = wanted->options;
  CLI::App* sound = app.add_subcommand(
      "sound",
      "the velocity of a probe as WAV or FLAC, to listen to; NAME.json beside it says what the "
      "values stand for");
  sound->add_option("OUT.h5", wanted->result, "result of 'ra2d run'")->required()->check(path());
  sound
      ->add_option(
          "-o,--output", wanted->output,
          "sound file, .wav (32 bit, floating) or .flac (24 bit) [OUT's name with .wav, in "
          "the current folder]")
      ->type_name("NOISE.wav")
      ->check(path());
  CLI::Option* probe = sound->add_option("--probe", options.probe, "which of output.probes, from 1")
                           ->type_name("N")
                           ->transform(count())
                           ->capture_default_str();
  sound
      ->add_option_function<std::size_t>(
          "--slider-probe",
          [&options](std::size_t number) {
            options.probe = number;
            options.body = ProbeOf::slider;
          },
          "instead of it: which of output.slider_probes, from 1")
      ->type_name("N")
      ->transform(count())
      ->excludes(probe);
  sound->add_option("--slow", options.slow, "how many times longer it lasts, and lower it sounds")
      ->type_name("N")
      ->check(number_from(1, most_slow, "from 1 to 10000"))
      ->capture_default_str();
  sound->add_option("--rate", options.rate, "samples a second of the sound")
      ->type_name("HZ")
      ->transform(count())
      ->check(number_from(least_rate, most_rate, "from 8000 to 384000"))
      ->capture_default_str();
  CLI::Option* normalize =
      sound->add_flag("--normalize", options.normalize, "the loudest sample is full scale");
  sound
      ->add_option("--full-scale", options.full_scale,
                   "velocity that full scale stands for [1, 2 or 5 times a power of ten, the next "
                   "above the peak]")
      ->type_name("M_PER_S")
      ->check(positive_number())
      ->excludes(normalize);
  add_stretch(*sound, options.from, options.to);
  sound->add_flag("--quiet", wanted->quiet, "print nothing but errors");
  sound->callback([wanted, &chosen] { chosen.run = [wanted] { return make_sound(*wanted); }; });
}

}  // namespace ra2d
