// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/sound_pressure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host/analysis/bands.hpp"
#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"

namespace ra2d {
namespace {

constexpr double most_bytes = 2e9;   // of filters and pressures
constexpr double most_points = 2e8;  // of the face, for one microphone
constexpr double much_above = 0.2;   // of a power: 1 dB of its level

std::string place_text(const Position& at) {
  return fmt::format("{:g},{:g},{:g}", at[0], at[1], at[2]);
}

void require_place(const Position& at, const Distances& ways) {
  require_height(at);
  if (!(ways.least <= farthest_microphone))
    throw RequestError(fmt::format(
        "a microphone at {}: it is {:.4g} m away from the resonator. Expected {:g} m at the most: "
        "farther off the air absorbs sound, which is not in here",
        place_text(at), ways.least, farthest_microphone));
}

double mean_square_of(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
         static_cast<double>(values.size());
}

}  // namespace

void require_height(const Position& at) {
  if (!(std::abs(at[2]) >= nearest_microphone))
    throw RequestError(fmt::format(
        "a microphone at {}: z is the height over the resonator's plane, of which the baffle is a "
        "part: expected {:g} m or more above it, or below it with z < 0",
        place_text(at), nearest_microphone));
}

std::string too_many_microphones(const Radiator& face, const Air& air, std::size_t microphones,
                                 double rate, std::size_t samples) {
  const double bytes = PressureFilters::bytes(face, air, microphones, rate, samples);
  if (bytes > most_bytes)
    return fmt::format(
        "{} microphone{} would take {:.1f} GB of memory, and {:g} GB is the most: take fewer at a "
        "time, or a shorter stretch with --from and --to",
        microphones, microphones == 1 ? "" : "s", bytes * 1e-9, most_bytes * 1e-9);
  const double points = face_points(face, air, rate);
  if (points > most_points)
    return fmt::format(
        "at a rate of {:g} Hz the resonator is {:.0f} wavelengths long: its integral takes {:.1g} "
        "points, and {:g} is the most. Sample with a lower output.rate",
        rate, face.length * rate / (2 * air.sound_speed), points, most_points);
  return {};
}

void SoundRequest::require_sense(bool has_power) const {
  if ((celsius || pascal) && !asks())
    throw RequestError(fmt::format(
        "--temperature and --pressure are those of the air: name a microphone with --at x,y,z{}",
        has_power ? ", or ask for --power" : ""));
}

SoundRequest SoundRequest::completed(const Scene& scene) const {
  SoundRequest found = *this;
  if (microphones.empty())
    for (const MicrophonePlace& at : scene.output.microphones)
      found.microphones.push_back({at.x, at.y, at.z});
  found.celsius = celsius.value_or(scene.air.celsius);
  found.pascal = pascal.value_or(scene.air.pascal);
  return found;
}

SceneSound sound_of_scene(const Scene& scene, const std::filesystem::path& file) try {
  SceneSound found;
  const SoundRequest request = SoundRequest{}.completed(scene);
  if (!request.asks()) return found;
  const ResultReader reader(file);
  const ResultContents& contents = reader.contents();
  const SoundingResonator resonator = sounding_resonator(reader, scene, file, request);
  const Stretch stretch = choose_stretch(contents, scene, file, {}, {});
  for (const HeardSound& sound : hear(reader, resonator, stretch, file, request))
    found.microphones.push_back(
        levels_of(sound, contents.rate, contents.resonator_frequency, scene.resonator.damping));
  return found;
} catch (const RequestError& fault) {
  return {{}, fault.what()};
}

std::string level_text(const MicrophoneLevels& m) {
  if (!(m.rms > 0)) return "silence at " + place_text(m.position);
  const bool weighted = !std::isnan(m.lp_a);
  return fmt::format("{:.2f} dB re 20 uPa{} at {:g}, {:g}, {:g} m{}", m.lp,
                     weighted ? fmt::format(", {:.2f} dB(A)", m.lp_a) : "", m.position[0],
                     m.position[1], m.position[2],
                     weighted ? "" : "; dB(A) not known: " + too_short_text(m.shortest));
}

std::string warning_of(const MicrophoneLevels& m) { return above_modes_text(m.above, m.last_mode); }

SoundingResonator sounding_resonator(const ResultReader& reader, const std::optional<Scene>& scene,
                                     const std::filesystem::path& file,
                                     const SoundRequest& request) {
  const ResultContents& contents = reader.contents();
  reader.require_modes();
  if (!scene)
    throw RequestError(fmt::format(
        "{}: its scene is one that this program does not understand, so that the resonator's "
        "shapes are not known: take the program that made it ({})",
        file.string(), contents.origin));
  const BodySpec& spec = scene->resonator;
  SoundingResonator found{
      make_body(spec),
      {},
      air_of(request.celsius.value_or(usual_celsius), request.pascal.value_or(usual_pascal)),
      spec.density * spec.thickness};
  const std::vector<BodyMode>& modes = found.body.modes;
  if (modes.empty() && contents.resonator_frequency.empty())
    throw RequestError(
        fmt::format("{}: its resonator has no modes, and makes no sound", file.string()));
  bool same = modes.size() == contents.resonator_frequency.size();
  for (std::size_t k = 0; same && k < modes.size(); ++k) {
    const double frequency = modes[k].omega / (2 * M_PI);
    same = std::abs(frequency - contents.resonator_frequency[k]) <= 1e-6 * frequency;
  }
  if (!same)
    throw FileError(fmt::format("{}: its modes are not those of its scene: was the file changed?",
                                file.string()));
  found.face = face_of(found.body, spec);
  const bool is_plate = spec.kind == BodyKind::plate;
  found.extent = is_plate ? found.face.area() : found.face.length;
  found.squared_shape = is_plate ? 1 : found.face.width;
  return found;
}

VelocityRecord velocity_record(const ResultReader& reader) {
  const ResultContents& contents = reader.contents();
  return {contents.samples, contents.start == 0, [&](std::size_t first, std::size_t count) {
            return reader.columns("resonator/velocity", first, count, 0,
                                  contents.resonator_frequency.size());
          }};
}

std::vector<HeardSound> hear(const ResultReader& reader, const SoundingResonator& resonator,
                             const Stretch& stretch, const std::filesystem::path& file,
                             const SoundRequest& request, Silence silence) {
  const ResultContents& contents = reader.contents();
  std::vector<HeardSound> heard;
  for (const Position& at : request.microphones) {
    heard.push_back({at, distances(resonator.face, at), 0, 0, 0, {}});
    require_place(at, heard.back().distances);
  }
  if (heard.empty()) return heard;
  const VelocityRecord record = velocity_record(reader);
  if (!(contents.rate > 0) || stretch.count == 0)
    throw RequestError(fmt::format("{}: it has no samples to hear", file.string()));
  if (const std::string fault = too_many_microphones(resonator.face, resonator.air, heard.size(),
                                                     contents.rate, stretch.count);
      !fault.empty())
    throw RequestError(fmt::format("{}: {}", file.string(), fault));
  const PressureFilters filters(resonator.face, resonator.air, request.microphones, contents.rate);
  std::vector<PressureFilters::Range> ranges;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    HeardSound& sound = heard[i];
    const PressureFilters::Range carried = filters.carried(i, record);
    const double arrives = sound.distances.least / resonator.air.sound_speed;
    const auto silent = contents.start == 0
                            ? static_cast<std::size_t>(std::ceil(arrives * contents.rate))
                            : std::size_t{0};
    const std::size_t begin = std::max(carried.begin, stretch.first);
    ranges.push_back({silence == Silence::left_out ? std::max(begin, silent) : begin,
                      std::min(carried.end, stretch.first + stretch.count)});
    const PressureFilters::Range& range = ranges.back();
    if (range.end < range.begin + 2 || range.end <= silent)
      throw RequestError(fmt::format(
          "{}: at {} there is nothing to hear from {:g} s to {:g} s: the sound takes {:.4g} s to "
          "{:.4g} s to come there, and the record's last {:.2g} s are needed to filter it. Take a "
          "longer stretch, a nearer microphone or a higher output.rate",
          file.string(), place_text(sound.position), stretch.from, stretch.to, arrives,
          sound.distances.largest / resonator.air.sound_speed,
          static_cast<double>(filter_half_length) / contents.rate));
    sound.first =
        range.begin + static_cast<std::size_t>(std::llround(contents.start * contents.rate));
    sound.from = contents.start + static_cast<double>(range.begin) / contents.rate;
    sound.to = contents.start + static_cast<double>(range.end - 1) / contents.rate;
  }
  auto pressures = filters.pressures(record, ranges);
  for (std::size_t i = 0; i < heard.size(); ++i) heard[i].pressure = std::move(pressures[i]);
  return heard;
}

std::string too_short_text(double shortest) {
  const double no_less = 1.005 * shortest;  // when it is rounded to three digits
  const int band = carried_bands(std::numeric_limits<double>::infinity(), no_less).front();
  return fmt::format(
      "the stretch is too short: the third octave of {} Hz, the highest that modes "
      "and samples reach, takes {:.3g} s or more",
      third_octave_name(band), no_less);
}

double last_mode(const std::vector<double>& frequencies) {
  const auto last = std::max_element(frequencies.begin(), frequencies.end());
  return last == frequencies.end() || !(*last > 0) ? quiet_nan : *last;
}

std::string above_modes_text(const SharesAbove& shares, double last_mode) {
  const bool is_weighted = shares.a_weighted > much_above;
  if (!is_weighted && !(shares.all > much_above)) return {};
  return fmt::format(
      "{:.0f} % of the {} power lies above the last mode that was kept, at {:.4g} kHz, "
      "where more modes would give another level: raise resonator.max_frequency",
      100 * (is_weighted ? shares.a_weighted : shares.all),
      is_weighted ? "A-weighted" : "unweighted", 1e-3 * last_mode);
}

double pressure_level(double rms) { return 20 * std::log10(rms / 20e-6); }

MicrophoneLevels levels_of(const HeardSound& sound, double rate,
                           const std::vector<double>& frequencies, double damping) {
  MicrophoneLevels m;
  m.position = sound.position;
  m.distance = sound.distances.least;
  m.from = sound.from;
  m.to = sound.to;
  const std::vector<double>& p = sound.pressure;
  m.rms = std::sqrt(mean_square_of(p));
  for (const double value : p) m.peak = std::max(m.peak, std::abs(value));
  m.lp = pressure_level(m.rms);
  WholeSpectrum whole(p.size(), rate);
  std::vector<double> power;
  whole.add(p, 1, power);
  const std::vector<double> weighted = a_weighted(whole, power);
  const double seconds = static_cast<double>(p.size()) / rate;
  m.last_mode = last_mode(frequencies);
  m.shortest = shortest_stretch(m.last_mode, passed * rate);
  const bool is_long = seconds >= m.shortest;
  m.lp_a = is_long
               ? pressure_level(std::sqrt(std::accumulate(weighted.begin(), weighted.end(), 0.0)))
               : quiet_nan;
  m.number = carried_bands(passed * rate, seconds);
  const auto of_bands = band_powers(m.number, whole, {power, weighted});
  for (const double value : of_bands[0]) m.level.push_back(pressure_level(std::sqrt(value)));
  for (const double value : of_bands[1]) m.level_a.push_back(pressure_level(std::sqrt(value)));
  if (is_long) m.above = shares_above(whole, power, weighted, m.last_mode);
  for (const int number : m.number) m.spread.push_back(band_spread(number, seconds));
  LevelParts parts(sound.first, p.size(), rate, 1);
  parts.add_column(0, p);
  m.history = parts.history({1.0});
  m.intervals = intervals_of_run(m.history, m.lp, quiet_nan, ringing_of(frequencies, damping));
  return m;
}

}  // namespace ra2d
