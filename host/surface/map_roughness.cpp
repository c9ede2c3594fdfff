// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_roughness.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/surface/roughness.hpp"
#include "host/surface/sum.hpp"
#include "host/system/blocks.hpp"

namespace ra2d {
namespace {

constexpr double counted_share =
    0.1;  // of the highest and of the lowest, as a profile's RSm has it

/// RSm of a profile from its mean.
double own_spacing(std::vector<double>& profile, double spacing) {
  subtract_mean(profile);
  const auto [low, high] = std::minmax_element(profile.begin(), profile.end());
  return mean_spacing(profile, spacing, {counted_share * *high, -counted_share * *low});
}

/// Mean of the spacings of `lines` lines; line k is made of heights first(k), first(k) + stride,
/// ...
template <class First>
double mean_over_lines(const HeightMap& map, std::size_t lines, std::size_t points,
                       std::size_t stride, double spacing, const First& first) {
  std::vector<double> all(lines);
  in_blocks(lines, 64, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<double> line(points);
    for (std::size_t k = begin; k < end; ++k) {
      for (std::size_t i = 0; i < points; ++i) line[i] = map.heights[first(k) + i * stride];
      all[k] = own_spacing(line, spacing);
    }
  });
  std::erase_if(all, [](double value) { return std::isnan(value); });
  if (all.empty()) return quiet_nan;
  return compensated_sum(all.size(), [&](std::size_t k) { return all[k]; }) /
         static_cast<double>(all.size());
}

}  // namespace

MapRoughness map_roughness(const HeightMap& map) {
  const std::vector<double>& z = map.heights;
  const auto count = static_cast<double>(z.size());
  const double mean = compensated_sum(z.size(), [&](std::size_t i) { return z[i]; }) / count;
  const auto moment = [&](double unit, int power) {  // z^4 alone may be no double
    return compensated_sum(z.size(),
                           [&](std::size_t i) {
                             const double part = (z[i] - mean) / unit;
                             return power == 2   ? part * part
                                    : power == 3 ? part * part * part
                                                 : part * part * part * part;
                           }) /
           count;
  };
  MapRoughness r{};
  const auto [low, high] = std::minmax_element(z.begin(), z.end());
  r.sz = *high - *low;
  r.sq = r.sz > 0 ? r.sz * std::sqrt(moment(r.sz, 2)) : 0;
  r.ssk = r.sq > 0 ? moment(r.sq, 3) : quiet_nan;
  r.sku = r.sq > 0 ? moment(r.sq, 4) : quiet_nan;
  r.rsm = mean_over_lines(map, map.ny, map.nx, 1, map.spacing,
                          [&](std::size_t j) { return j * map.nx; });
  r.rsm_y =
      mean_over_lines(map, map.nx, map.ny, map.nx, map.spacing_y, [](std::size_t i) { return i; });
  return r;
}

}  // namespace ra2d
