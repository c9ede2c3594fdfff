// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/peaks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/result/statistics.hpp"

namespace ra2d {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Lines in which a mode's peak is looked for.
struct Reach {
  std::size_t first = 0, last = 0;
};

/// Half way to the neighbours, and no further than a tenth of its frequency or two lines.
Reach reach_of(const Lines& lines, double below, double natural, double above) {
  const double far = std::max(natural / 10, 2 * lines.resolution);
  const double low = std::max(natural - far, (below + natural) / 2);
  const double high = std::min(natural + far, (natural + above) / 2);
  const double last = std::floor(high / lines.resolution);
  return {static_cast<std::size_t>(std::max(1.0, std::ceil(low / lines.resolution))),
          static_cast<std::size_t>(
              std::min(static_cast<double>(lines.density.size()) - 2, std::max(0.0, last)))};
}

/// The means of so many lines, an odd number; the outermost stay as they are.
std::vector<double> smoothed(std::span<const double> density, std::size_t together) {
  std::vector<double> means(density.begin(), density.end());
  const std::size_t aside = together / 2;
  for (std::size_t j = aside; aside > 0 && j + aside < density.size(); ++j) {
    double sum = 0;
    for (std::size_t i = j - aside; i <= j + aside; ++i) sum += density[i];
    means[j] = sum / static_cast<double>(together);
  }
  return means;
}

/// How many lines from a peak its density falls to a half, in steps of +1 or -1; NaN where the spectrum
/// ends before.
double half_width(std::span<const double> density, std::size_t peak, int step) {
  const double half = density[peak] / 2;
  std::size_t j = peak;
  while (density[j] > half) {
    if (j == 0 || j + 1 == density.size()) return nan;
    j = step > 0 ? j + 1 : j - 1;
  }
  const double inner = density[step > 0 ? j - 1 : j + 1];
  const double beyond = (inner - half) / (inner - density[j]);  // of the last step
  return std::abs(static_cast<double>(j) - static_cast<double>(peak)) - 1 + beyond;
}

/// The peak of a mode with neighbours at `below` and `above`; `width`: how wide it should be, in lines.
SpectralPeak find_peak(const Lines& lines, double below, double natural, double above,
                       double width) {
  SpectralPeak peak{0, natural, nan, nan, nan};
  const double apart = std::min(below > 0 ? natural - below : natural, above - natural);
  if (!(apart >= least_apart * lines.resolution)) return peak;
  const Reach reach = reach_of(lines, below, natural, above);
  if (reach.first > reach.last) return peak;
  const std::size_t together = width >= 15 ? 2 * static_cast<std::size_t>(width / 10) + 1 : 1;
  const std::vector<double> density = smoothed(lines.density, together);
  const auto highest =
      std::max_element(density.begin() + static_cast<std::ptrdiff_t>(reach.first),
                       density.begin() + static_cast<std::ptrdiff_t>(reach.last) + 1);
  if (!(*highest > highest[-1] && *highest > highest[1])) return peak;  // the slope of another
  const auto line = static_cast<std::size_t>(highest - density.begin());
  peak.frequency = static_cast<double>(line) * lines.resolution;
  peak.density = *highest;

  const bool alone = apart >= least_distance * width * lines.resolution;
  const double degrees = lines.degrees_of_freedom * static_cast<double>(together);
  const double found = half_width(density, line, -1) + half_width(density, line, 1);
  if (alone && degrees >= least_degrees && found >= least_width)
    peak.damping = found * lines.resolution / (2 * peak.frequency);
  return peak;
}

}  // namespace

std::vector<SpectralPeak> find_peaks(const Lines& lines, const std::vector<double>& natural,
                                     double zeta) {
  std::vector<SpectralPeak> peaks;
  const double top = lines.resolution * (static_cast<double>(lines.density.size()) - 1);
  for (std::size_t k = 0; k < natural.size(); ++k) {
    const double f = natural[k];
    if (!(f > 0) || lines.density.size() < 5 || f > top) continue;
    const double below = k > 0 ? natural[k - 1] : 0.0;
    const double above =
        k + 1 < natural.size() ? natural[k + 1] : std::numeric_limits<double>::infinity();
    peaks.push_back(find_peak(lines, below, f, above, 2 * zeta * f / lines.resolution));
    peaks.back().mode = k;
  }
  return peaks;
}

void mark_mesh(std::vector<SpectralPeak>& peaks, double tone, double resolution) {
  if (!(tone > 10 * resolution)) return;  // multiples are everywhere
  for (SpectralPeak& peak : peaks) {
    const double away = std::abs(std::remainder(peak.frequency, tone));
    peak.of_mesh = peak.frequency > tone / 2 && away <= 2.5 * resolution;
    if (peak.of_mesh) peak.damping = nan;
  }
}

double rise_at(const Lines& lines, double frequency) {
  constexpr std::size_t near = 2, far = 20;
  const auto line =
      static_cast<std::size_t>(std::lround(std::max(0.0, frequency) / lines.resolution));
  if (line <= far || line + far >= lines.density.size()) return nan;
  double highest = 0;
  std::vector<double> around;
  for (std::size_t j = line - far; j <= line + far; ++j) {
    if (!std::isfinite(lines.density[j])) return nan;
    if (j + near >= line && j <= line + near)
      highest = std::max(highest, lines.density[j]);
    else
      around.push_back(lines.density[j]);
  }
  return 10 * std::log10(highest / median(std::move(around)));
}

}  // namespace ra2d
