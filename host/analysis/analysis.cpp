// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "host/analysis/bands.hpp"
#include "host/analysis/stretch.hpp"
#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/result/level.hpp"
#include "host/store/result_reader.hpp"

namespace ra2d {
namespace {

constexpr std::size_t columns_at_once = 32 << 20;  // bytes, of samples that are read together
constexpr std::size_t most_samples = std::size_t{1} << 30;  // that a transform takes

/// The part that is analysed; notes it in `a`.
Stretch analysed_stretch(const ResultContents& contents, const std::optional<Scene>& scene,
                         const AnalysisOptions& options, Analysis& a) {
  const Stretch stretch = choose_stretch(contents, scene, a.file, options.from, options.to);
  a.from = stretch.from;
  a.to = stretch.to;
  a.whole = stretch.whole;
  // one sample alone has no rate, and is not analysed
  a.samples =
      std::isnan(contents.rate) && a.from <= contents.start ? contents.samples : stretch.count;
  if (stretch.count > most_samples)
    throw RequestError(
        fmt::format("{}: {} samples are more than can be transformed at once ({}): "
                    "take a shorter stretch with --from and --to",
                    a.file.string(), stretch.count, most_samples));
  return stretch;
}

/// How long the segments of the spectrum are; 0 where the stretch is too short for one.
std::size_t choose_segment(const AnalysisOptions& options, std::size_t samples, const Analysis& a) {
  if (!options.segment && !options.resolution) return usual_segment(samples);
  const double wanted = options.segment ? static_cast<double>(*options.segment)
                                        : std::round(a.rate / *options.resolution);
  if (wanted >= 4 && wanted <= static_cast<double>(samples))
    return static_cast<std::size_t>(wanted);
  throw RequestError(fmt::format(
      "{}: {}: a segment of {:.0f} samples, expected 4 to {}, as many as the stretch has ({:g} Hz "
      "apart or more)",
      a.file.string(),
      options.segment ? fmt::format("--segment {}", *options.segment)
                      : fmt::format("--resolution {:g}", *options.resolution),
      wanted, samples, samples > 0 ? a.rate / static_cast<double>(samples) : quiet_nan));
}

void add_weighted(const std::vector<double>& values, double weight, std::vector<double>& sum) {
  sum.resize(values.size());
  for (std::size_t j = 0; j < values.size(); ++j) sum[j] += weight * values[j];
}

double mean_square(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
         static_cast<double>(values.size());
}

/// The number in its run, from t = 0 on, of a sample of the file.
std::size_t sample_of_run(const ResultContents& contents, std::size_t sample) {
  return sample + static_cast<std::size_t>(std::llround(contents.start * contents.rate));
}

/// Analyses the sampled velocities, mode by mode and probe by probe.
class VelocityAnalysis {
 public:
  VelocityAnalysis(const ResultReader& reader, const Stretch& stretch, std::size_t segment,
                   Analysis& analysis)
      : reader_{reader},
        stretch_{stretch},
        a_{analysis},
        whole_{stretch.count, analysis.rate},
        parts_{sample_of_run(reader.contents(), stretch.first), stretch.count, analysis.rate,
               reader.contents().mean_square.size()} {
    if (segment > 0) welch_.emplace(half_overlapping(analysis.rate, segment));
  }

  /// The mean over the resonator is exact, mode by mode, as that of the level is
  /// (host/result/level.hpp): sum_k mean(psi_k^2) density(V_k).
  void run(bool a_weighting) {
    const std::vector<double>& weights = reader_.contents().mean_square;
    if (a_.has_modes)
      run_modes(weights, a_weighting);
    else
      leave_out_modes(a_weighting);
    each_column("probes/velocity", a_.probe_position.size(),
                [&](std::size_t, const auto& velocity) {
                  if (welch_) a_.spectrum.probe.push_back(welch_->density(velocity));
                  std::vector<double> of_probe;
                  whole_.add(velocity, 1, of_probe);
                  a_.bands.level_probe.push_back(levels(of_probe));
                });
    if (!welch_) return;
    each_column("slider_probes/velocity", a_.slider_probe_position.size(),
                [&](std::size_t, const auto& velocity) {
                  a_.spectrum.slider_probe.push_back(welch_->density(velocity));
                });
    finish_spectrum();
  }

 private:
  void run_modes(const std::vector<double>& weights, bool a_weighting) {
    std::vector<double> power;
    double square = 0;
    half_power_.resize(weights.size());
    each_column("resonator/velocity", weights.size(), [&](std::size_t k, const auto& velocity) {
      if (weights[k] == 0) return;
      square += weights[k] * mean_square(velocity);
      parts_.add_column(k, velocity);
      if (welch_) add_weighted(welch_->density(velocity), weights[k], a_.spectrum.mean);
      std::vector<double> lines;
      whole_.add(velocity, 1, lines);
      add_weighted(lines, weights[k], power);
      half_power_[k] =
          half_power({whole_.frequency(1), lines, whole_.independent()},
                     place_of_mode(reader_.contents().resonator_frequency, k, a_.modal_damping));
    });
    if (!a_.whole) a_.v_rms = std::sqrt(square);
    for (const Shock& shock : reader_.contents().shocks) parts_.add_shock(shock.start);
    a_.history = parts_.history(weights);
    power.resize(whole_.lines());
    choose_bands();
    a_.bands.level = levels(power);
    if (a_weighting) weigh(power);
  }

  /// Where the file does not have the modes, the resonator as a whole has no numbers.
  void leave_out_modes(bool a_weighting) {
    choose_bands();
    a_.bands.level.assign(a_.bands.number.size(), quiet_nan);
    if (a_weighting) a_.bands.level_a = a_.bands.level;
    if (welch_) a_.spectrum.mean.assign(welch_->frequencies().size(), quiet_nan);
  }

  /// Calls `body` with each column's number and samples; several are read at a time.
  template <class Body>
  void each_column(const char* dataset, std::size_t count, Body body) {
    const std::size_t at_once =
        std::max<std::size_t>(1, columns_at_once / (stretch_.count * sizeof(double)));
    for (std::size_t first = 0; first < count; first += at_once) {
      const std::size_t now = std::min(at_once, count - first);
      const auto columns = reader_.columns(dataset, stretch_.first, stretch_.count, first, now);
      for (std::size_t k = 0; k < now; ++k) body(first + k, columns[k]);
    }
  }

  void choose_bands() {
    const double seconds = static_cast<double>(stretch_.count) / a_.rate;
    a_.bands.number = carried_bands(a_.rate, seconds);
    for (const int number : a_.bands.number)
      a_.bands.spread.push_back(band_spread(number, seconds));
  }

  std::vector<double> levels(const std::vector<double>& power) const {
    std::vector<double> found = band_powers(a_.bands.number, whole_, power);
    for (double& value : found) value = level(std::sqrt(value));
    return found;
  }

  void weigh(const std::vector<double>& power) {
    const std::vector<double> weighted = a_weighted(whole_, power);
    a_.bands.level_a = levels(weighted);
    const double seconds = static_cast<double>(stretch_.count) / a_.rate;
    if (seconds >= shortest_stretch(last_mode(a_.natural_frequencies), a_.rate))
      a_.lv_a = level(std::sqrt(std::accumulate(weighted.begin(), weighted.end(), 0.0)));
  }

  void finish_spectrum() {
    VelocitySpectrum& s = a_.spectrum;
    s.frequency = welch_->frequencies();
    s.resolution = s.frequency[1];
    s.mean.resize(s.frequency.size());  // zeros, of a resonator that does not bend
    std::vector<double> force = reader_.column("contact/force", stretch_.first, stretch_.count);
    const double mean =
        std::accumulate(force.begin(), force.end(), 0.0) / static_cast<double>(force.size());
    for (double& value : force) value -= mean;
    s.force = welch_->density(force);
    s.segments = welch_->segments().count(stretch_.count);
    s.degrees_of_freedom = welch_->degrees_of_freedom(stretch_.count);
    s.confidence = confidence_of_density(s.degrees_of_freedom);
    if (!a_.has_modes) return;
    a_.peaks = find_peaks({s.resolution, s.mean}, reader_.contents().resonator_frequency,
                          a_.modal_damping);
    for (SpectralPeak& peak : a_.peaks) peak.half_power = half_power_[peak.mode];
  }

  const ResultReader& reader_;
  Stretch stretch_;
  Analysis& a_;
  WholeSpectrum whole_;
  LevelParts parts_;
  std::optional<Welch> welch_;
  std::vector<HalfPower> half_power_;  // of each mode
};

PowerBalance powers_of(const ResultReader& reader, const Stretch& stretch, double rate,
                       ContactLaw law) {
  const auto read = [&](const char* dataset) {
    return reader.column(dataset, stretch.first, stretch.count);
  };
  const auto kinetic = read("energy/kinetic"), elastic = read("energy/elastic"),
             contact = read("energy/contact"), loss = read("energy/damping_loss"),
             sliding = read("energy/sliding_work"), load = read("energy/load_work");
  return power_balance({kinetic, elastic, contact, loss, sliding, load},
                       (static_cast<double>(stretch.count) - 1) / rate, law);
}

MeshTone mesh_tone(const std::optional<Scene>& scene, const Analysis& a) {
  MeshTone tone{quiet_nan, false, quiet_nan, quiet_nan};
  const double frequency = scene ? mesh_tone_frequency(*scene) : 0.0;
  if (!(frequency > 0)) return tone;
  tone.frequency = frequency;
  tone.in_spectrum = tone.frequency < a.rate / 2;
  if (!tone.in_spectrum || a.spectrum.mean.empty() || !a.has_modes) return tone;
  tone.rise = rise_at({a.spectrum.resolution, a.spectrum.mean}, tone.frequency);
  if (std::isfinite(tone.rise))
    tone.by_chance = rise_by_chance(a.spectrum.degrees_of_freedom) +
                     rise_of_a_mode(a.natural_frequencies, a.modal_damping, tone.frequency,
                                    a.spectrum.resolution);
  return tone;
}

/// Takes the figures of the whole run from the file, which counted every step.
void take_summary(const ResultSummary& summary, Analysis& a) {
  a.v_rms = summary.v_rms;
  a.contact_share = summary.contact_share;
  a.energy_closure = summary.energy_closure;
}

/// Those of the whole run, which saw the modes that the file does not have.
void take_intervals(const ResultSummary& summary, double ringing, Analysis& a) {
  if (!a.whole) {
    a.intervals.why_none = "the file has no motion of the modes (output.modes)";
  } else if (!std::isnan(summary.lv_low)) {
    a.intervals = {
        {summary.lv_low, summary.lv_high}, {summary.shock_rate_low, summary.shock_rate_high}, {}};
  } else {
    a.intervals.why_none = why_no_interval(a.lv, a.samples / 2, a.to - a.from, ringing);
    if (a.intervals.why_none.empty())
      a.intervals.why_none =
          "the file has neither the motion of the modes (output.modes) nor an interval";
  }
}

void add_sound_levels(const ResultReader& reader, const std::optional<Scene>& scene,
                      const Stretch& stretch, const SoundRequest& request, Analysis& a) {
  const SoundingResonator resonator = sounding_resonator(reader, scene, a.file, request);
  a.air = resonator.air;
  for (const HeardSound& sound : hear(reader, resonator, stretch, a.file, request)) {
    a.microphones.push_back(levels_of(sound, a.rate, a.natural_frequencies, a.modal_damping));
    a.microphones.back().arrives = sound.distances.least / a.air.sound_speed;
  }
  if (!request.power) return;
  if (stretch.count < 2)
    throw RequestError(
        fmt::format("{}: it has no samples to find a sound power of", a.file.string()));
  a.power = radiated_power(reader, resonator, stretch);
}

}  // namespace

std::vector<bool> bands_above_modes(const Analysis& a, const std::vector<int>& numbers) {
  const double last = last_mode(a.natural_frequencies);
  std::vector<bool> above;
  for (const int number : numbers) above.push_back(third_octave_low(number) > last);
  return above;
}

Analysis analyze(const std::filesystem::path& file, const AnalysisOptions& options) {
  const ResultReader reader(file);
  const ResultContents& contents = reader.contents();
  const std::optional<Scene> scene = scene_of(contents, file);
  Analysis a;
  a.file = file;
  a.title = scene ? title(*scene) : file.stem().string();
  a.scene = scene;
  a.key = contents.key;
  a.complete = contents.summary.complete;
  a.ended = contents.summary.ended;
  a.rate = contents.rate;
  a.has_modes = contents.has_modes;
  a.lv_a = a.contact_share = a.energy_closure = quiet_nan;
  a.modal_damping = scene ? scene->resonator.damping : quiet_nan;
  a.probe_position = contents.probe_position;
  a.slider_probe_position = contents.slider_probe_position;
  a.probe_y = contents.probe_y;
  a.slider_probe_y = contents.slider_probe_y;
  std::copy_if(contents.resonator_frequency.begin(), contents.resonator_frequency.end(),
               std::back_inserter(a.natural_frequencies), [](double f) { return f > 0; });
  a.aliased_modes = static_cast<std::size_t>(
      std::count_if(a.natural_frequencies.begin(), a.natural_frequencies.end(),
                    [&](double f) { return f > a.rate / 2; }));

  const Stretch stretch = analysed_stretch(contents, scene, options, a);
  a.v_rms = quiet_nan;
  if (a.whole) take_summary(contents.summary, a);
  const std::size_t segment = choose_segment(options, stretch.count, a);
  if (stretch.count > 0) VelocityAnalysis(reader, stretch, segment, a).run(options.a_weighting);
  a.lv = level(a.v_rms);
  a.shocks = shock_statistics(contents.shocks, a.from, a.to);
  if (a.whole) a.shocks.rate = contents.summary.shock_rate;  // by the time that was counted
  const double ringing = ringing_of(a.natural_frequencies, a.modal_damping);
  a.intervals = intervals_of_run(a.history, a.lv, a.shocks.rate, ringing);
  if (!a.has_modes) take_intervals(contents.summary, ringing, a);
  a.energy = powers_of(reader, stretch, a.rate, scene ? scene->contact.law : ContactLaw::penalty);
  a.energy_per_shock = a.shocks.rate > 0 ? a.energy.given / a.shocks.rate : quiet_nan;
  a.mesh = mesh_tone(scene, a);
  mark_mesh(a.peaks, a.mesh.frequency, a.spectrum.resolution);
  const SoundRequest sound = scene ? options.sound.completed(*scene) : options.sound;
  if (options.sound.asks()) {
    add_sound_levels(reader, scene, stretch, sound, a);
  } else if (sound.asks()) {  // as the scene has it
    try {
      add_sound_levels(reader, scene, stretch, sound, a);
    } catch (const RequestError& fault) {
      a.no_sound = fault.what();
    }
  }
  return a;
}

}  // namespace ra2d
