// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/surface/profile_sdf.hpp"
#include "host/surface/profile_text.hpp"
#include "host/surface/profile_x3p.hpp"
#include "host/surface/usual_faces.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr double whole = 1e-9;  // of a spacing: a width that is a whole number of them

/// Format of a file that cannot be read here, from its first bytes; empty for others.
std::string_view other_format(std::string_view bytes) {
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff"))
    return "text in UTF-16: save it as UTF-8";
  if (bytes.starts_with("\x93NUMPY"))
    return "an array of NumPy, a height map: 'ra2d surface map' reads it";
  if (bytes.find('\0') != bytes.npos) return "binary, and in no format that is read";
  return {};
}

/// The first bytes. Throws FileError.
std::string beginning(const std::filesystem::path& file) {
  return InputFile(file, "the profile").beginning(4096);
}

Profile read_any_profile(const std::filesystem::path& file, const ProfileQuery& query) {
  switch (format_of(file)) {
    case ProfileFormat::sdf:
      return read_profile_sdf(file, query);
    case ProfileFormat::x3p:
      return read_profile_x3p(file, query);
    case ProfileFormat::text:
      break;
  }
  require_text(file);
  if (query.row)
    throw RequestError(fmt::format("{}: --row {}: a text has columns and no rows: drop the option",
                                   file.string(), *query.row));
  return read_profile_text(file, query);
}

}  // namespace

std::size_t Profile::missing() const {
  return static_cast<std::size_t>(
      std::count_if(heights.begin(), heights.end(), [](double z) { return std::isnan(z); }));
}

std::optional<LengthUnit> to_unit(std::string_view word) {
  if (word == "m") return LengthUnit{"m", 1};
  if (word == "mm") return LengthUnit{"mm", 1e-3};
  if (word == "nm") return LengthUnit{"nm", 1e-9};
  // micro sign, Greek mu, and the micro sign of Latin-1
  for (const char* micro : {"um", "\xc2\xb5m", "\xce\xbcm", "\xb5m"})
    if (word == micro) return LengthUnit{"um", 1e-6};
  return {};
}

ProfileFormat format_of(const std::filesystem::path& file) {
  const std::string begin = beginning(file);
  if (begins_as_sdf(begin)) return ProfileFormat::sdf;
  if (begin.starts_with("PK\x03\x04")) return ProfileFormat::x3p;
  return ProfileFormat::text;
}

void require_text(const std::filesystem::path& file) {
  if (const auto format = other_format(beginning(file)); !format.empty())
    throw RequestError(fmt::format("{}: the file is {}", file.string(), format));
}

void require_possible_heights(const std::filesystem::path& file,
                              const std::vector<double>& heights) {
  double low = quiet_nan, high = quiet_nan;
  for (const double z : heights) {
    low = std::fmin(low, z);
    high = std::fmax(high, z);
  }
  if (high - low > usual_faces::tallest)
    throw RequestError(
        fmt::format("{}: the heights span {:.3g} m, which no face does: the file is damaged, its "
                    "bytes are in another order, or its unit or scale of z is wrong",
                    file.string(), high - low));
}

Profile read_measured_profile(const std::filesystem::path& file, const ProfileQuery& query) {
  Profile profile = read_any_profile(file, query);
  require_possible_heights(file, profile.heights);
  return profile;
}

void doubt_lost_slope(const std::filesystem::path& file, double slope_of_points, double step,
                      double slope_of_nodes, double spacing, std::vector<std::string>* doubts) {
  if (doubts == nullptr || !(slope_of_nodes < (1 - most_slope_lost) * slope_of_points)) return;
  doubts->push_back(fmt::format(
      "{}: nodes {:.4g} m apart show a root mean square slope of {:.3g}, {:.0f} % less than the "
      "points, {:.4g} m apart: shorter waves are cut. A scene.spacing nearer to the points shows "
      "them, cutoff_s takes them off on purpose",
      file.string(), spacing, slope_of_nodes, 100 * (1 - slope_of_nodes / slope_of_points), step));
}

std::string doubt_of_last_line(const std::filesystem::path& file) {
  return file.string() +
         ": the last line has no end: if the file was cut off there, its height is wrong";
}

std::optional<double> to_fill_width(std::string_view text) {
  constexpr std::string_view kind = "linear:";
  if (!text.starts_with(kind)) return {};
  const auto width = to_number(text.substr(kind.size()));
  if (!width || !(*width > 0) || !std::isfinite(*width)) return {};
  return width;
}

void fill_gaps(Profile& profile, double width) {
  std::vector<double>& z = profile.heights;
  const std::size_t missing = profile.missing();
  if (missing == 0) return;
  const auto refuse_with = [&](const std::string& why) {
    throw RequestError(fmt::format("{}: a height is missing, the first of {}: {}",
                                   profile.first_missing, missing, why));
  };
  if (!(width > 0))
    refuse_with("--fill linear:WIDTH puts straight lines through gaps of at most WIDTH metres");
  if (std::isnan(z.front()) || std::isnan(z.back()))
    refuse_with(
        "the profile begins or ends with missing points, which nothing can fill: cut them "
        "off the file");
  for (std::size_t i = 1; i < z.size(); ++i) {
    if (!std::isnan(z[i])) continue;
    std::size_t end = i;
    while (std::isnan(z[end])) ++end;
    const auto points = static_cast<double>(end - i);
    if (points > width / profile.spacing + whole)
      refuse_with(
          fmt::format("a gap of {:.6g} m begins {:.6g} m behind the first point, --fill "
                      "allows {:.6g} m",
                      points * profile.spacing, static_cast<double>(i) * profile.spacing, width));
    const double left = z[i - 1];
    for (std::size_t k = i; k < end; ++k)
      z[k] = std::lerp(left, z[end], static_cast<double>(k - i + 1) / (points + 1));
    i = end;
  }
}

}  // namespace ra2d
