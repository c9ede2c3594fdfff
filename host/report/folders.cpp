// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/folders.hpp"

#include <algorithm>

namespace ra2d {
namespace {

/// Where the text that begins at `begin` ends: at its quote, or before the end of the line.
std::size_t end_of(std::string_view toml, std::size_t begin, char quote) {
  std::size_t at = begin;
  while (at < toml.size() && toml[at] != quote && toml[at] != '\n')
    at += quote == '"' && toml[at] == '\\' ? 2 : 1;
  return std::min(at, toml.size());
}

}  // namespace

std::string without_folders(std::string_view toml) {
  std::string out;
  for (std::size_t at = 0; at < toml.size();) {
    const char c = toml[at++];
    out += c;
    if (c != '"' && c != '\'') continue;
    const std::size_t end = end_of(toml, at, c);
    std::string_view text = toml.substr(at, end - at);
    const std::size_t slash = text.starts_with('/') ? text.find_last_of('/') : text.npos;
    if (slash != text.npos && slash + 1 < text.size()) text.remove_prefix(slash + 1);
    out += text;
    if (end < toml.size()) out += toml[end];
    at = end + 1;
  }
  return out;
}

}  // namespace ra2d
