// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/csv.hpp"

namespace ra2d {

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == text.npos) return std::string(text);
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

}  // namespace ra2d
