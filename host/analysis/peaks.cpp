// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/peaks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/quiet_nan.hpp"
#include "host/result/statistics.hpp"

namespace ra2d {
namespace {

/// Lines in which a mode's peak is searched for.
struct LineRange {
  std::size_t first = 0, last = 0;
};

/// Half way to the neighbours, and no further than a tenth of its frequency or two lines.
LineRange range_of(const Lines& lines, double below, double natural, double above) {
  const double far = std::max(natural / 10, 2 * lines.resolution);
  const double low = std::max(natural - far, (below + natural) / 2);
  const double high = std::min(natural + far, (natural + above) / 2);
  const double last = std::floor(high / lines.resolution);
  return {static_cast<std::size_t>(std::max(1.0, std::ceil(low / lines.resolution))),
          static_cast<std::size_t>(
              std::min(static_cast<double>(lines.density.size()) - 2, std::max(0.0, last)))};
}

/// The means of so many lines, an odd number; the outermost stay as they are.
std::vector<double> smoothed(std::span<const double> density, std::size_t width_of_mean) {
  std::vector<double> means(density.begin(), density.end());
  const std::size_t aside = width_of_mean / 2;
  for (std::size_t j = aside; aside > 0 && j + aside < density.size(); ++j) {
    double sum = 0;
    for (std::size_t i = j - aside; i <= j + aside; ++i) sum += density[i];
    means[j] = sum / static_cast<double>(width_of_mean);
  }
  return means;
}

/// The peak of a mode with neighbours at `below` and `above`; `width`: how wide it should be, in
/// lines.
SpectralPeak find_peak(const Lines& lines, double below, double natural, double above,
                       double width) {
  SpectralPeak peak{
      0, natural, quiet_nan, quiet_nan, {quiet_nan, quiet_nan, quiet_nan, NoDamping::lost}};
  const double apart = std::min(below > 0 ? natural - below : natural, above - natural);
  if (!(apart >= least_apart * lines.resolution)) return peak;
  const LineRange range = range_of(lines, below, natural, above);
  if (range.first > range.last) return peak;
  const std::size_t width_of_mean = width >= 15 ? 2 * static_cast<std::size_t>(width / 10) + 1 : 1;
  const std::vector<double> density = smoothed(lines.density, width_of_mean);
  const auto highest =
      std::max_element(density.begin() + static_cast<std::ptrdiff_t>(range.first),
                       density.begin() + static_cast<std::ptrdiff_t>(range.last) + 1);
  if (!(*highest > highest[-1] && *highest > highest[1])) return peak;  // the slope of another
  const auto line = static_cast<std::size_t>(highest - density.begin());
  peak.frequency = static_cast<double>(line) * lines.resolution;
  peak.density = *highest;
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
    if (peak.of_mesh) peak.half_power = {quiet_nan, quiet_nan, quiet_nan, NoDamping::mesh};
  }
}

double rise_at(const Lines& lines, double frequency) {
  const auto line =
      static_cast<std::size_t>(std::lround(std::max(0.0, frequency) / lines.resolution));
  if (line <= lines_around_tone || line + lines_around_tone >= lines.density.size())
    return quiet_nan;
  return rise_of(lines.density.subspan(line - lines_around_tone, 2 * lines_around_tone + 1));
}

double rise_of(std::span<const double> densities) {
  double highest = 0;
  std::vector<double> around;
  for (std::size_t j = 0; j < densities.size(); ++j) {
    if (!std::isfinite(densities[j])) return quiet_nan;
    if (j + lines_of_tone >= lines_around_tone && j <= lines_around_tone + lines_of_tone)
      highest = std::max(highest, densities[j]);
    else
      around.push_back(densities[j]);
  }
  return 10 * std::log10(highest / median(std::move(around)));
}

}  // namespace ra2d
