// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>

namespace ra2d {

/// A time [s] for people, in the unit that suits it.
inline std::string seconds_text(double s) {
  if (s < 0.9995e-9) return fmt::format("{:.3g} ps", s * 1e12);
  if (s < 0.9995e-6) return fmt::format("{:.3g} ns", s * 1e9);
  if (s < 1e-3) return fmt::format("{:.3g} us", s * 1e6);
  if (s < 1) return fmt::format("{:.3g} ms", s * 1e3);
  if (s < 120) return fmt::format("{:.3g} s", s);
  if (s < 7200) return fmt::format("{:.3g} min", s / 60);
  if (s < 360000) return fmt::format("{:.3g} h", s / 3600);
  return fmt::format("{:.3g} days", s / 86400);
}

/// Three digits, rounded down: what is copied into a scene still holds.
inline std::string rounded_down(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  return fmt::format("{:.3g}", std::floor(value / unit) * unit);
}

inline std::string bytes_text(std::size_t bytes) {
  const auto b = static_cast<double>(bytes);
  return b < 1e6 ? fmt::format("{:.3g} kB", b / 1e3) : fmt::format("{:.3g} MB", b / 1e6);
}

}  // namespace ra2d
