// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/height_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "host/base/errors.hpp"
#include "host/surface/repeated_place.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {
namespace {

constexpr double share_of_memory = 0.4;  // for a map: another may be made of it
constexpr double whole_spacings = 1e-9;  // of a spacing: a width that is a whole number of them

/// The gap of a missing point along one direction.
struct MapGap {
  double points = std::numeric_limits<double>::infinity();  // infinite: it reaches the edge
  double height = 0;                                        // of its line at the point
};

/// Gaps of a row or a column: point k is heights[first + k stride].
void find_gaps(const std::vector<double>& z, std::size_t first, std::size_t stride,
               std::size_t count, std::vector<MapGap>& gaps) {
  gaps.assign(count, {});
  for (std::size_t k = 0; k < count; ++k) {
    if (!std::isnan(z[first + k * stride])) continue;
    std::size_t end = k;
    while (end < count && std::isnan(z[first + end * stride])) ++end;
    if (k > 0 && end < count) {
      const auto points = static_cast<double>(end - k);
      const double before = z[first + (k - 1) * stride], after = z[first + end * stride];
      for (std::size_t i = k; i < end; ++i)
        gaps[i] = {points, std::lerp(before, after, static_cast<double>(i - k + 1) / (points + 1))};
    }
    k = end;
  }
}

/// Values of polynomials 0 ... degree at `count` even places, orthogonal over them and of length 1.
std::vector<std::vector<double>> orthonormal(std::size_t count, std::size_t degree) {
  std::vector<std::vector<double>> all;
  const double middle = 0.5 * static_cast<double>(count - 1);
  std::vector<double> before(count, 0.0), now(count, 1.0);
  double square_before = 1, square = static_cast<double>(count);
  for (std::size_t k = 0; k <= degree && k < count; ++k) {
    if (k > 0) {
      const double ratio = k == 1 ? 0 : square / square_before;
      square_before = square;
      square = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const double x = (static_cast<double>(i) - middle) / middle;
        const double next = x * now[i] - ratio * before[i];
        before[i] = now[i];
        now[i] = next;
        square += next * next;
      }
    }
    all.push_back(now);
    for (double& value : all.back()) value /= std::sqrt(square);
  }
  return all;
}

/// A point of an extended line: up to two points of the line, with their weights.
struct Mixed {
  std::size_t a, b;
  double of_a, of_b;
};

std::vector<Mixed> extended_line(std::size_t have, std::size_t want, MapExtension how) {
  std::vector<Mixed> line;
  line.reserve(want);
  const std::size_t last = have - 1;
  for (std::size_t k = 0; k < want; ++k)
    if (how == MapExtension::mirror) {
      const std::size_t at = k % (2 * last), point = at <= last ? at : 2 * last - at;
      line.push_back({point, point, 1, 0});
    } else {
      const RepeatedPlace place(have, k);
      line.push_back({place.point, place.other, place.share, place.other_share});
    }
  return line;
}

}  // namespace

std::size_t HeightMap::missing() const {
  return static_cast<std::size_t>(
      std::count_if(heights.begin(), heights.end(), [](double z) { return std::isnan(z); }));
}

void require_map_size(const std::string& name, double nx, double ny, std::int64_t most_memory) {
  if (!(nx >= 2) || !(ny >= 2))
    throw RequestError(fmt::format(
        "{}: {} by {} points: a map has at least two rows of two points each; one row is a profile",
        name, nx, ny));
  if (!(nx * ny <= most_map_points))
    throw RequestError(fmt::format(
        "{}: {:.10g} by {:.10g} points: expected at most {:g} of them. Take larger spacings, "
        "or a part of it",
        name, nx, ny, most_map_points));
  const double bytes = nx * ny * sizeof(double), memory = static_cast<double>(most_memory);
  if (bytes > share_of_memory * memory)
    throw RequestError(fmt::format(
        "{}: {:.10g} by {:.10g} points take {:.3g} GB of memory, and this machine has {:.3g} GB. "
        "Take larger spacings, or a part of it",
        name, nx, ny, bytes * 1e-9, memory * 1e-9));
}

double subtract_map_mean(HeightMap& map) { return subtract_mean(map.heights); }

void fill_map_gaps(HeightMap& map, double width, const std::string& name) {
  const std::size_t missing = map.missing();
  if (missing == 0) return;
  std::vector<double>& z = map.heights;
  const auto refuse_at = [&](std::size_t at, const std::string& why) {
    throw RequestError(fmt::format("{}: row {}, point {}: a height is missing, {} of {}: {}", name,
                                   at / map.nx + 1, at % map.nx + 1,
                                   width > 0 ? "one" : "the first", missing, why));
  };
  if (!(width > 0)) {
    const auto first = std::find_if(z.begin(), z.end(), [](double h) { return std::isnan(h); });
    refuse_at(static_cast<std::size_t>(first - z.begin()),
              "--fill linear:WIDTH puts straight lines through gaps of at most WIDTH metres");
  }
  struct Filled {
    std::size_t at;
    double width, height;  // m
  };
  std::vector<Filled> filled;  // kept apart: lines go from measured to measured points
  filled.reserve(missing);
  std::vector<MapGap> gaps;
  for (std::size_t j = 0; j < map.ny; ++j) {
    find_gaps(z, j * map.nx, 1, map.nx, gaps);
    for (std::size_t i = 0; i < map.nx; ++i)
      if (std::isnan(map.at(i, j)))
        filled.push_back({j * map.nx + i, gaps[i].points * map.spacing, gaps[i].height});
  }
  std::sort(filled.begin(), filled.end(), [&](const Filled& a, const Filled& b) {
    return std::pair(a.at % map.nx, a.at) < std::pair(b.at % map.nx, b.at);  // column by column
  });
  std::size_t column = map.nx;
  for (Filled& point : filled) {
    if (point.at % map.nx != column) {
      column = point.at % map.nx;
      find_gaps(z, column, map.nx, map.ny, gaps);
    }
    const MapGap& along_y = gaps[point.at / map.nx];
    if (along_y.points * map.spacing_y < point.width)
      point = {point.at, along_y.points * map.spacing_y, along_y.height};
  }
  const double most = width + whole_spacings * std::min(map.spacing, map.spacing_y);
  for (const Filled& point : filled)
    if (!(point.width <= most))
      refuse_at(point.at,
                std::isinf(point.width)
                    ? std::string("its gap reaches the map's edges, and nothing can fill it: cut "
                                  "the edge off the file")
                    : fmt::format("its gap is {:.6g} m wide, --fill allows {:.6g} m", point.width,
                                  width));
  for (const Filled& point : filled) z[point.at] = point.height;
}

std::optional<MapForm> understand_map_form(std::string_view text) {
  if (text == "none") return MapForm{MapForm::none};
  if (text == "mean") return MapForm{0};
  if (text == "plane") return MapForm{1};
  if (!text.starts_with("poly:")) return {};
  text.remove_prefix(5);
  int degree = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), degree);
  if (error != std::errc{} || end != text.data() + text.size() || degree < 0 ||
      degree > MapForm::highest)
    return {};
  return MapForm{degree};
}

/// Products of polynomials that are orthogonal along x and along y are orthogonal over the grid: no
/// system is solved.
void remove_map_form(HeightMap& map, MapForm form) {
  if (form.degree < 0 || map.heights.empty()) return;
  subtract_map_mean(map);  // first: a height far from 0 would cost digits
  const auto degree = static_cast<std::size_t>(form.degree);
  const auto p = orthonormal(map.nx, degree), q = orthonormal(map.ny, degree);
  std::vector<double> share(p.size() * q.size(), 0.0), along(p.size());
  for (std::size_t j = 0; j < map.ny; ++j) {
    const double* const row = &map.heights[j * map.nx];
    for (std::size_t a = 0; a < p.size(); ++a) {
      along[a] = 0;
      for (std::size_t i = 0; i < map.nx; ++i) along[a] += p[a][i] * row[i];
      for (std::size_t b = 0; b < q.size() && a + b <= degree; ++b)
        share[a * q.size() + b] += along[a] * q[b][j];
    }
  }
  for (std::size_t j = 0; j < map.ny; ++j) {
    double* const row = &map.heights[j * map.nx];
    for (std::size_t a = 0; a < p.size(); ++a) {
      double of_row = 0;
      for (std::size_t b = 0; b < q.size() && a + b <= degree; ++b)
        of_row += share[a * q.size() + b] * q[b][j];
      for (std::size_t i = 0; i < map.nx; ++i) row[i] -= of_row * p[a][i];
    }
  }
}

HeightMap extended_map(const HeightMap& map, MapExtension how, std::size_t nx, std::size_t ny,
                       const std::string& name) {
  require_map_size(name, static_cast<double>(nx), static_cast<double>(ny));
  const std::vector<Mixed> along_x = extended_line(map.nx, nx, how);
  const std::vector<Mixed> along_y = extended_line(map.ny, ny, how);
  HeightMap made{nx, ny, map.spacing, map.spacing_y, {}};
  made.heights.reserve(nx * ny);
  std::vector<double> row(map.nx);
  for (const Mixed& y : along_y) {
    for (std::size_t i = 0; i < map.nx; ++i)
      row[i] = y.of_b == 0 ? map.at(i, y.a) : y.of_a * map.at(i, y.a) + y.of_b * map.at(i, y.b);
    for (const Mixed& x : along_x)
      made.heights.push_back(x.of_b == 0 ? row[x.a] : x.of_a * row[x.a] + x.of_b * row[x.b]);
  }
  return made;
}

}  // namespace ra2d
