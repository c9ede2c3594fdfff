// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string_view>
#include <vector>

namespace ra2d {

/// The shape that a profile loses before its roughness is measured: a polynomial of this degree,
/// fitted by least squares. 0 is the mean, 1 a line.
struct ProfileForm {
  static constexpr int none = -1, highest = 10;
  int degree = none;
};

/// Of `none`, `mean`, `line` or `poly:N`; nothing for anything else.
std::optional<ProfileForm> understand_form(std::string_view text);
/// Of `none`, `mean`, `line` or `poly:N`. Throws RequestError for anything else.
ProfileForm to_form(std::string_view text);

/// Takes the form off heights at even steps. Exact to roundings for a polynomial of its degree.
void remove_form(std::vector<double>& heights, ProfileForm form);

}  // namespace ra2d
