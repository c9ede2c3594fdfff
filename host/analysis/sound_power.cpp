// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/sound_power.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numeric>
#include <span>

#include "host/analysis/bands.hpp"
#include "host/base/errors.hpp"
#include "host/base/fourier.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/radiation/resistance.hpp"

namespace ra2d {
namespace {

constexpr double most_line_bytes = 256e6;  // of the lines of all modes in one piece
constexpr double matters = 0.1;            // of the damping
constexpr long half_order = 5;             // points of the polynomial to either side of a frequency
constexpr double turn = 0.72;  // rad from grid to grid: the polynomial is then right to 1e-5
constexpr std::size_t least_piece = 1 << 14;  // samples

/// Resistances at any frequency, by Lagrange's polynomial through ten of an even grid. R has no
/// component faster than the way over the face, and is even in frequency.
class ResistanceBetween {
 public:
  ResistanceBetween(const RadiationResistance& resistance, double apart)
      : resistance_{resistance}, apart_{apart} {}

  /// Of all groups. Frequencies rise from call to call: what is behind is forgotten.
  const std::vector<double>& operator()(double frequency) {
    const double place = frequency / apart_;
    const long cell = static_cast<long>(std::floor(place));
    const long first = cell + 1 - half_order, last = cell + half_order;
    std::erase_if(cached_, [&](const auto& entry) { return entry.first < first; });
    std::fill(found_.begin(), found_.end(), 0.0);
    for (long i = first; i <= last; ++i) {
      double weight = 1;
      for (long j = first; j <= last; ++j)
        if (j != i) weight *= (place - static_cast<double>(j)) / static_cast<double>(i - j);
      const std::vector<double>& values = at(std::abs(i));
      found_.resize(values.size());
      for (std::size_t k = 0; k < values.size(); ++k) found_[k] += weight * values[k];
    }
    return found_;
  }

 private:
  const std::vector<double>& at(long i) {
    const auto old = cached_.find(i);
    if (old != cached_.end()) return old->second;
    constexpr long at_once = 16;
    const long first = i / at_once * at_once;
    std::vector<double> frequencies;
    for (long n = first; n < first + at_once; ++n)
      frequencies.push_back(std::min(static_cast<double>(n) * apart_, resistance_.highest()));
    auto values = resistance_.of_groups(frequencies);
    for (long n = first; n < first + at_once; ++n)
      cached_[n] = std::move(values[static_cast<std::size_t>(n - first)]);
    return cached_[i];
  }

  const RadiationResistance& resistance_;
  double apart_;  // Hz
  std::map<long, std::vector<double>> cached_;
  std::vector<double> found_;
};

/// The line from a velocity's first sample to its last, which is taken off before it is
/// transformed. Only acceleration radiates: a velocity that is cut off would add that of two blows,
/// which a body that drifts or falls makes louder than all.
struct EndLine {
  double first = 0, slope = 0;  // m/s; a sample

  explicit EndLine(const std::vector<double>& values)
      : first{values.front()},
        slope{(values.back() - first) / static_cast<double>(values.size() - 1)} {}
  double at(std::size_t n) const { return first + slope * static_cast<double>(n); }
};

/// The lines of f(n), n from 0 to before `length`.
template <class F>
std::vector<std::complex<double>> lines_of(Fourier& fourier, std::size_t length, F f) {
  const auto input = fourier.input();
  std::fill(input.begin(), input.end(), 0.0);
  for (std::size_t n = 0; n < length; ++n) input[n] = f(n);
  fourier.transform();
  std::vector<std::complex<double>> lines(fourier.lines());
  for (std::size_t j = 0; j < lines.size(); ++j) lines[j] = fourier.line(j);
  return lines;
}

/// The lines of a piece of the modes' velocities, without their end lines: (line, mode).
struct PieceSpectrum {
  std::vector<std::complex<double>> lines;
  std::vector<EndLine> ends;  // of each mode

  PieceSpectrum(Fourier& fourier, const std::vector<std::vector<double>>& velocity)
      : lines(fourier.lines() * velocity.size()) {
    for (std::size_t k = 0; k < velocity.size(); ++k) {
      const EndLine& end = ends.emplace_back(velocity[k]);
      const auto of_mode = lines_of(fourier, velocity[k].size(),
                                    [&](std::size_t n) { return velocity[k][n] - end.at(n); });
      for (std::size_t j = 0; j < of_mode.size(); ++j) lines[j * velocity.size() + k] = of_mode[j];
    }
  }
};

/// v^H R v, R symmetric and real, of groups of modes that couple: the groups' rows up to the
/// diagonal, one after another.
double form_of(const std::vector<double>& r, const std::vector<std::vector<std::size_t>>& groups,
               const std::complex<double>* v) {
  const double* row = r.data();
  double sum = 0;
  std::vector<double> real, imaginary;
  for (const std::vector<std::size_t>& group : groups) {
    real.clear();
    imaginary.clear();
    for (std::size_t k = 0; k < group.size(); row += ++k) {
      double re = 0, im = 0;
      for (std::size_t l = 0; l < k; ++l) {
        re += row[l] * real[l];
        im += row[l] * imaginary[l];
      }
      real.push_back(v[group[k]].real());
      imaginary.push_back(v[group[k]].imag());
      re = 2 * re + row[k] * real[k];
      im = 2 * im + row[k] * imaginary[k];
      sum += re * real[k] + im * imaginary[k];
    }
  }
  return sum;
}

/// Levels, efficiencies and spread of the bands that `piece` seconds at `rate` hold. `lines`: of
/// power, A-weighted power and mean square velocity; `flow`: rho c S; `span`: s, of all pieces.
void add_bands(RadiatedPower& found, const WholeSpectrum& whole,
               const std::vector<std::span<const double>>& lines, double flow, double rate,
               double piece, double span) {
  found.number = carried_bands(rate, piece);
  const auto of_bands = band_powers(found.number, whole, lines);
  for (std::size_t i = 0; i < found.number.size(); ++i) {
    found.level.push_back(power_level(of_bands[0][i]));
    found.level_a.push_back(power_level(of_bands[1][i]));
    found.band_efficiency.push_back(of_bands[0][i] / (flow * of_bands[2][i]));
    found.spread.push_back(band_spread(found.number[i], span));
  }
}

/// Efficiency of each elastic mode at its frequency, and the damping ratio that the air adds; NaN
/// above `highest` Hz.
void add_modes(RadiatedPower& found, const SoundingResonator& resonator,
               const RadiationResistance& resistance, double highest) {
  const std::vector<BodyMode>& modes = resonator.body.modes;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const double frequency = modes[k].omega / (2 * M_PI);
    if (!(frequency > 0)) continue;
    const double r = frequency <= highest ? resistance.of_mode(k, frequency) : quiet_nan;
    found.mode_frequency.push_back(frequency);
    found.mode_efficiency.push_back(
        r / (resonator.air.density * resonator.air.sound_speed * resonator.squared_shape));
    found.mode_damping.push_back(r / (modes[k].mass * modes[k].omega));
  }
}

}  // namespace

double power_level(double watts) { return 10 * std::log10(watts / 1e-12); }

bool RadiatedPower::air_matters() const { return share_of_damping > matters; }

RadiatedPower radiated_power(const ResultReader& reader, const SoundingResonator& resonator,
                             const Stretch& stretch) {
  const double rate = reader.contents().rate;
  const std::vector<BodyMode>& modes = resonator.body.modes;
  const VelocityRecord record = velocity_record(reader);
  // as many pieces as the memory asks for, each transformed as a whole
  const double line_bytes = 8.0 * static_cast<double>(modes.size() * stretch.count);
  const auto pieces = std::max<std::size_t>(
      1, std::min(static_cast<std::size_t>(std::ceil(line_bytes / most_line_bytes)),
                  stretch.count / least_piece));
  const std::size_t length = stretch.count / pieces;
  WholeSpectrum whole(length, rate);
  Fourier fourier(quick_length(std::max<std::size_t>(2, length)));
  const std::size_t lines = fourier.lines();
  const double scale =
      2 / (static_cast<double>(length) * static_cast<double>(fourier.length() * pieces));

  RadiatedPower found;
  const double highest = rate / 2;
  const double apart = turn * resonator.air.sound_speed /
                       (2 * M_PI * std::hypot(resonator.face.length, resonator.face.width));
  const RadiationResistance resistance(resonator.face, resonator.air,
                                       highest + (half_order + 1) * apart);
  const auto ones = lines_of(fourier, length, [](std::size_t) { return 1.0; });
  const auto ramp = lines_of(fourier, length, [](std::size_t n) { return static_cast<double>(n); });
  std::vector<double> power(lines), square(lines);
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    ResistanceBetween between(resistance, apart);
    const auto velocity = record.read(stretch.first + piece * length, length);
    const PieceSpectrum spectrum(fourier, velocity);
    const std::vector<EndLine>& ends = spectrum.ends;
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const double mean =
          std::inner_product(velocity[k].begin(), velocity[k].end(), velocity[k].begin(), 0.0) /
          static_cast<double>(length * pieces);
      found.damping_power += 2 * modes[k].zeta * modes[k].mass * modes[k].omega * mean;
    }
    for (std::size_t j = 1; j < lines; ++j) {
      const std::complex<double>* v = &spectrum.lines[j * modes.size()];
      double squares = 0;  // <v^2> is that of the whole elastic motion
      for (std::size_t k = 0; k < modes.size(); ++k) {
        const bool bends = modes[k].omega > 0;
        squares +=
            std::norm(bends ? v[k] + ends[k].first * ones[j] + ends[k].slope * ramp[j] : v[k]);
      }
      const double own = 2 * j == fourier.length() ? scale / 2 : scale;
      power[j] += own * form_of(between(whole.frequency(j)), resistance.groups(), v);
      square[j] += own * squares / resonator.extent;
    }
  }

  const double flow = resonator.air.density * resonator.air.sound_speed * resonator.face.area();
  const double last = last_mode(reader.contents().resonator_frequency);
  const double seconds = static_cast<double>(length) / rate;
  found.shortest = shortest_stretch(last, rate);
  const bool is_long = seconds >= found.shortest;
  found.watts = is_long ? std::accumulate(power.begin(), power.end(), 0.0) : quiet_nan;
  found.lw = power_level(found.watts);
  found.efficiency = found.watts / (flow * std::accumulate(square.begin(), square.end(), 0.0));
  const std::vector<double> weighted = a_weighted(whole, power);
  found.lw_a =
      is_long ? power_level(std::accumulate(weighted.begin(), weighted.end(), 0.0)) : quiet_nan;
  add_bands(found, whole, {power, weighted, square}, flow, rate, seconds,
            seconds * static_cast<double>(pieces));
  if (is_long) found.above = shares_above(whole, power, weighted, last);
  add_modes(found, resonator, resistance, highest);
  found.share_of_damping = 2 * found.watts / found.damping_power;
  found.inertia = inertia_of_air(resonator.face, resonator.air, resonator.mass_per_area);
  return found;
}

SoundLevels sound_levels(const Scene& scene, const std::filesystem::path& file) {
  SoundLevels found{quiet_nan, quiet_nan, quiet_nan, quiet_nan, {}, {}};
  try {
    const SoundRequest request = SoundRequest{}.completed(scene);
    const ResultReader reader(file);
    const SoundingResonator resonator = sounding_resonator(reader, scene, file, request);
    const Stretch stretch = choose_stretch(reader.contents(), scene, file, {}, {});
    if (stretch.count < 2) throw RequestError("it has no samples to find a sound power of");
    const RadiatedPower power = radiated_power(reader, resonator, stretch);
    found.lw = power.lw;
    found.lw_a = power.lw_a;
    double square = 0, square_a = 0;  // relative to 20 uPa
    double shortest = power.shortest;
    for (const HeardSound& sound : hear(reader, resonator, stretch, file, request)) {
      const MicrophoneLevels levels = levels_of(sound, reader.contents().rate,
                                                reader.contents().resonator_frequency, quiet_nan);
      const std::string warning = warning_of(levels);
      if (!warning.empty() && found.warnings.empty())
        found.warnings.push_back("sound pressure: " + warning);
      square += std::pow(10, levels.lp / 10);
      square_a += std::pow(10, levels.lp_a / 10);
      shortest = std::max(shortest, levels.shortest);
    }
    if (const std::string warning =
            above_modes_text(power.above, last_mode(reader.contents().resonator_frequency));
        !warning.empty())
      found.warnings.push_back("sound power: " + warning);
    if (std::isnan(power.watts) || std::isnan(square_a))
      found.why_none = (std::isnan(power.watts) ? "no sound power and no dB(A): "
                                                : "no dB(A) at the microphones: ") +
                       too_short_text(shortest);
    if (request.microphones.empty()) {
      found.why_none += found.why_none.empty() ? "" : "; ";
      found.why_none += "no sound pressure: the scene names no microphones (output.microphones)";
    } else {
      const auto count = static_cast<double>(request.microphones.size());
      found.lp = 10 * std::log10(square / count);
      found.lp_a = 10 * std::log10(square_a / count);
    }
  } catch (const RequestError& fault) {
    found.why_none = fmt::format("no sound: {}", fault.what());
  }
  return found;
}

}  // namespace ra2d
