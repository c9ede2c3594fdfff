// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/roughness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

constexpr double core_share = 0.4;       // of the material ratio curve
constexpr std::size_t few_heights = 10;  // too few for a core
constexpr double same_slope = 1e-9;      // of secants: the first of them is taken

template <class Term>
double mean(std::span<const double> heights, const Term& term) {
  return compensated_sum(heights.size(), [&](std::size_t i) { return term(heights[i]); }) /
         static_cast<double>(heights.size());
}

/// Adds the parameters of the distribution of heights, each divided by `share`.
void add_moments(Roughness& r, std::span<const double> heights, double share) {
  const double rq = std::sqrt(mean(heights, [](double z) { return z * z; }));
  const auto power = [&](double z) { return z / rq; };  // z^4 alone may be no double
  r.ra += mean(heights, [](double z) { return std::abs(z); }) / share;
  r.rq += rq / share;
  r.rsk += mean(heights, [&](double z) { return power(z) * power(z) * power(z); }) / share;
  r.rku += mean(heights,
                [&](double z) {
                  const double square = power(z) * power(z);
                  return square * square;
                }) /
           share;
}

/// Part of a profile between two crossings of the mean line. Positions in points.
struct ProfileElement {
  double begin, end;
  double height;  // furthest from the mean line; its sign says on which side
};

/// A zero belongs to no side: a crossing is in the middle of the zeros between two sides.
std::vector<ProfileElement> cut_at_mean_line(std::span<const double> heights) {
  std::vector<ProfileElement> parts;
  std::size_t last = heights.size();  // nonzero height
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const double z = heights[i];
    if (z == 0) continue;
    if (last == heights.size()) {
      parts.push_back({0, 0, z});
    } else if ((z > 0) != (heights[last] > 0)) {
      const double zeros = 0.5 * static_cast<double>(last + i);
      const double crossing =
          i > last + 1 ? zeros : static_cast<double>(last) + heights[last] / (heights[last] - z);
      parts.back().end = crossing;
      parts.push_back({crossing, 0, z});
    } else if (std::abs(z) > std::abs(parts.back().height)) {
      parts.back().height = z;
    }
    last = i;
  }
  if (!parts.empty()) parts.back().end = static_cast<double>(heights.size() - 1);
  return parts;
}

struct Elements {
  double length = 0;  // of all, in points
  std::size_t count = 0;
};

/// A part that does not count belongs to what came before it. So do parts of the same side.
template <class Iterator, class Counts, class Begin>
Elements find_elements(Iterator part, Iterator end, const Counts& counts, const Begin& begin) {
  Elements found;
  std::size_t crossings = 0;
  double side = 0, first = 0;
  for (; part != end; ++part) {
    if (!counts(*part)) continue;
    if (side * part->height < 0) {
      // The first crossing opens an element, every second one after it closes one and opens the
      // next.
      const double crossing = begin(*part);
      if (crossings == 0)
        first = crossing;
      else if (crossings % 2 == 0)
        found = {std::abs(crossing - first), found.count + 1};
      ++crossings;
    }
    side = part->height > 0 ? 1 : -1;
  }
  return found;
}

/// Derivative at a point of the polynomial through seven, times 60 steps; the first row for the
/// first point, the last for the one in the middle.
constexpr std::array<std::array<double, 7>, 4> slope_weights{{{-147, 360, -450, 400, -225, 72, -10},
                                                              {-10, -77, 150, -100, 50, -15, 2},
                                                              {2, -24, -35, 80, -30, 8, -1},
                                                              {-1, 9, -45, 0, 45, -9, 1}}};

}  // namespace

const char* name_of(RoughnessStandard standard) {
  return standard == RoughnessStandard::iso4287 ? "ISO 4287, ISO 13565-2" : "ISO 21920-2";
}

double mean_spacing(std::span<const double> heights, double spacing,
                    const ElementThresholds& thresholds, bool both_directions) {
  const std::vector<ProfileElement> parts = cut_at_mean_line(heights);
  const auto counts = [&](const ProfileElement& part) {
    const bool far =
        part.height > 0 ? part.height >= thresholds.up : -part.height >= thresholds.down;
    return far && (part.end - part.begin) * spacing >= thresholds.width;
  };
  Elements found = find_elements(parts.begin(), parts.end(), counts,
                                 [](const ProfileElement& p) { return p.begin; });
  if (both_directions) {
    const Elements back = find_elements(parts.rbegin(), parts.rend(), counts,
                                        [](const ProfileElement& p) { return p.end; });
    found = {found.length + back.length, found.count + back.count};
  }
  return found.count > 0 ? found.length / static_cast<double>(found.count) * spacing : quiet_nan;
}

double rms_slope(std::span<const double> heights, double spacing, std::size_t begin,
                 std::size_t end) {
  const std::size_t count = heights.size();
  if (count < 7) return quiet_nan;
  const auto slope = [&](std::size_t i) {
    const bool right = i + 3 >= count;
    const auto& weights = slope_weights[std::min({i, count - 1 - i, std::size_t{3}})];
    const std::size_t first = right ? count - 1 : i - std::min<std::size_t>(i, 3);
    double sum = 0;
    for (std::size_t k = 0; k < 7; ++k) sum += weights[k] * heights[right ? first - k : first + k];
    return sum;  // at the right end mirrored: another sign, which its square does not see
  };
  const double squares = compensated_sum(
      end - begin, [&](std::size_t i) { return slope(begin + i) * slope(begin + i); });
  return std::sqrt(squares / static_cast<double>(end - begin)) / (60 * spacing);
}

double rms_slope(std::span<const double> heights, double spacing) {
  return rms_slope(heights, spacing, 0, heights.size());
}

Core core(std::span<const double> heights) {
  const std::size_t count = heights.size();
  if (count < few_heights) return {quiet_nan, quiet_nan, quiet_nan, quiet_nan, quiet_nan};
  std::vector<double> curve(heights.begin(), heights.end());
  std::sort(curve.begin(), curve.end(), std::greater<>());
  const auto all = static_cast<double>(count);
  const auto height = [&](double at) {  // at 0 the highest point, at a material ratio of 0.5/count
    const std::size_t i = std::min(static_cast<std::size_t>(at), count - 2);
    return std::lerp(curve[i], curve[i + 1], at - static_cast<double>(i));
  };

  // The flattest secant has one end at a point of the curve.
  const double width = core_share * all, over = std::ceil(width) - width;
  double flattest = std::numeric_limits<double>::infinity(), begin = 0;
  const auto try_secant = [&](double at) {
    if (at + width > all - 1) return;
    const double drop = height(at) - height(at + width);
    if (drop < flattest * (1 - same_slope)) flattest = drop, begin = at;
  };
  for (std::size_t i = 0; static_cast<double>(i) + width <= all; ++i) {
    try_secant(static_cast<double>(i));
    if (over > 0) try_secant(static_cast<double>(i) + over);
  }

  // Least squares through the points that it spans.
  const auto from = static_cast<std::size_t>(std::ceil(begin));
  const auto to = static_cast<std::size_t>(std::floor(begin + width));
  const double middle = 0.5 * static_cast<double>(from + to);
  double sum = 0, along = 0, square = 0;
  for (std::size_t i = from; i <= to; ++i) {
    const double x = static_cast<double>(i) - middle;
    const double z = curve[i] - curve[from];  // of a plateau 0: no rounding tilts it
    sum += z;
    along += x * z;
    square += x * x;
  }
  const double slope = along / square;
  const double level = curve[from] + sum / static_cast<double>(to - from + 1);
  const double top = level - slope * (middle + 0.5), bottom = top + slope * all;

  // Triangles of the same area on the same share of the length.
  Core found{top - bottom, 0, 0, 0, 0};
  std::size_t above = 0, below = 0;
  double peaks = 0, valleys = 0;
  while (above < count && curve[above] > top) peaks += curve[above++] - top;
  while (below < count && curve[count - 1 - below] < bottom)
    valleys += bottom - curve[count - 1 - below++];
  if (above > 0) found.rpk = 2 * peaks / static_cast<double>(above);
  if (below > 0) found.rvk = 2 * valleys / static_cast<double>(below);
  found.peaks = static_cast<double>(above) / all;
  found.valleys = static_cast<double>(below) / all;
  return found;
}

double material_ratio(std::span<const double> heights, double level) {
  const auto above =
      std::count_if(heights.begin(), heights.end(), [&](double height) { return height >= level; });
  return static_cast<double>(above) / static_cast<double>(heights.size());
}

void set_core(Roughness& parameters, const Core& parts) {
  parameters.rk = parts.rk;
  parameters.rpk = parts.rpk;
  parameters.rvk = parts.rvk;
  parameters.mr1 = parts.peaks;
  parameters.mr2 = 1 - parts.valleys;
}

Roughness roughness(std::span<const double> heights, double spacing, std::size_t sections,
                    RoughnessStandard standard) {
  const bool by_section = standard == RoughnessStandard::iso4287;
  const auto share = static_cast<double>(sections);
  Roughness r{};
  if (!by_section) {
    add_moments(r, heights, 1);
    r.rdq = rms_slope(heights, spacing);
  }
  const auto [lowest, highest] = std::minmax_element(heights.begin(), heights.end());
  r.rt = *highest - *lowest;
  for (std::size_t k = 0; k < sections; ++k) {
    const std::size_t begin = heights.size() * k / sections;
    const std::size_t end = heights.size() * (k + 1) / sections;
    const auto part = heights.subspan(begin, end - begin);
    const auto [low, high] = std::minmax_element(part.begin(), part.end());
    r.rp += *high / share;
    r.rv -= *low / share;
    if (!by_section) continue;
    add_moments(r, part, share);
    r.rdq += rms_slope(heights, spacing, begin, end) / share;
  }
  r.rz = r.rp + r.rv;
  const double section = static_cast<double>(heights.size()) * spacing / share;
  r.rsm = by_section
              ? mean_spacing(heights, spacing, {0.1 * r.rz, 0.1 * r.rz, 0.01 * section}, false)
              : mean_spacing(heights, spacing, {0.1 * r.rp, 0.1 * r.rv});
  set_core(r, core(heights));
  return r;
}

}  // namespace ra2d
