// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/clips.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>

#include "host/base/errors.hpp"
#include "host/report/html.hpp"
#include "host/sound/sound.hpp"

namespace ra2d {
namespace {

constexpr double most_seconds = 5, most_slow_seconds = 20;  // of a clip
constexpr double slower = 20;
constexpr std::size_t most_results = 8;  // that have sounds: some 1.1 MB each

/// One of the two sounds, and how much of it there would be.
struct Cut {
  SoundOptions options;
  double whole = 0;  // s
};

/// The lowest rate that carries all that the samples have.
int rate_for(double highest) {
  for (const int rate : {8'000, 16'000, 24'000})
    if (highest < 0.45 * rate) return rate;
  return 48'000;
}

Cut cut(const SoundFacts& whole, double slow) {
  Cut c;
  const double most = slow > 1 ? most_slow_seconds : most_seconds;
  c.whole = (whole.to - whole.from) * slow;
  c.options.slow = slow;
  c.options.from = whole.from;
  c.options.to = c.whole > most ? whole.from + most / slow : whole.to;
  if (slow > 1) c.options.rate = rate_for(whole.source_rate / 2 / slow);
  return c;
}

std::string caption_of(const SoundFacts& f, const Cut& c) {
  std::string text = fmt::format(
      "<b>{}</b>, at {} m: {} s to {} s of the run. Full scale is {} m/s.",
      f.slow > 1 ? fmt::format("{:g} times slower", f.slow) : std::string("As it is"),
      html_number(f.position), html_number(f.from), html_number(f.to), html_number(f.full_scale));
  if (f.seconds() < 0.999 * c.whole)
    text += fmt::format(" Shortened: all of it would last {} s.", html_number(c.whole));
  if (f.slow > 1) text += fmt::format(" What is heard at 1 kHz moves at {:g} kHz.", f.slow);
  return text;
}

Clip make_clip(const std::filesystem::path& result, Cut c, double full_scale) {
  c.options.full_scale = full_scale;
  const ProbeSound sound(result, c.options);
  MemoryStore store;
  AudioWriter writer(store, AudioFormat::wav_16, sound.facts().rate, notes_of(sound.facts()),
                     result);
  sound.play([&](std::span<const double> samples) { writer.write(samples); });
  writer.close();
  return {caption_of(sound.facts(), c), "data:audio/wav;base64," + base64(store.bytes())};
}

/// The parts of a result that the page plays, and the largest full scale that they need.
struct Choice {
  std::vector<Cut> cuts;
  double full_scale = 0;
  std::string why_none;
};

Choice choose(const std::filesystem::path& result) try {
  Choice chosen;
  const SoundFacts whole = ProbeSound(result, {}).facts();
  if (!(whole.peak > 0)) {
    chosen.why_none = fmt::format("The probe at {} m does not move: there is nothing to hear.",
                                  html_number(whole.position));
    return chosen;
  }
  for (const double slow : {1.0, slower}) {
    chosen.cuts.push_back(cut(whole, slow));
    chosen.full_scale = std::max(chosen.full_scale,
                                 ProbeSound(result, chosen.cuts.back().options).facts().full_scale);
  }
  return chosen;
} catch (const RequestError&) {
  return {{}, 0, "No sound: the result has no probe, or too few samples (output.probes)."};
}

}  // namespace

std::vector<Clips> clips_of(const std::vector<std::filesystem::path>& results) {
  std::vector<Choice> chosen;
  double full_scale = 0;
  for (std::size_t i = 0; i < std::min(results.size(), most_results); ++i) {
    chosen.push_back(choose(results[i]));
    full_scale = std::max(full_scale, chosen.back().full_scale);
  }
  std::vector<Clips> all(results.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (i >= chosen.size()) {
      all[i].why_none = fmt::format(
          "Of many results the first {} alone have their sounds here; <code>ra2d sound</code> "
          "makes "
          "them of any.",
          most_results);
      continue;
    }
    all[i].why_none = chosen[i].why_none;
    for (const Cut& c : chosen[i].cuts)
      all[i].clips.push_back(make_clip(results[i], c, full_scale));
  }
  return all;
}

}  // namespace ra2d
