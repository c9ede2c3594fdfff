// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/form.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstddef>
#include <string>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/surface/sum.hpp"

namespace ra2d {

std::optional<ProfileForm> understand_form(std::string_view text) {
  if (text == "none") return ProfileForm{ProfileForm::none};
  if (text == "mean") return ProfileForm{0};
  if (text == "line") return ProfileForm{1};
  if (text.starts_with("poly:")) {
    const std::string_view number = text.substr(5);
    int degree = -1;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), degree);
    if (error == std::errc{} && end == number.data() + number.size() && degree >= 0 &&
        degree <= ProfileForm::highest)
      return ProfileForm{degree};
  }
  return {};
}

ProfileForm to_form(std::string_view text) {
  if (const auto form = understand_form(text)) return *form;
  throw RequestError(
      fmt::format("form '{}': expected none, mean, line or poly:N with N from 0 to {}",
                  shortened(std::string(text)), ProfileForm::highest));
}

void remove_form(std::vector<double>& heights, ProfileForm form) {
  const std::size_t count = heights.size();
  if (form.degree < 0 || count == 0) return;
  subtract_mean(heights);
  // Polynomials that are orthogonal over the points themselves: no system is solved, and none is
  // ill-conditioned. On a grid that is symmetric about 0 their recurrence is
  // p[k+1] = x p[k] - |p[k]|^2/|p[k-1]|^2 p[k-1].
  const double middle = 0.5 * static_cast<double>(count - 1);
  const auto x = [&](std::size_t i) { return (static_cast<double>(i) - middle) / middle; };
  std::vector<double> before(count, 0.0), now(count, 1.0);
  double square_before = 1, square = static_cast<double>(count);
  const auto degree = static_cast<std::size_t>(form.degree);
  for (std::size_t k = 1; k <= degree && k < count;
       ++k) {  // no more than the points can tell apart
    const double ratio = k == 1 ? 0 : square / square_before;
    square_before = square;
    square = 0;
    double along = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double next = x(i) * now[i] - ratio * before[i];
      before[i] = now[i];
      now[i] = next;
      square += next * next;
      along += next * heights[i];
    }
    for (std::size_t i = 0; i < count; ++i) heights[i] -= along / square * now[i];
  }
}

}  // namespace ra2d
