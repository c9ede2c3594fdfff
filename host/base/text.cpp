// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ra2d {
namespace {

/// Optimal string alignment distance: a swap of neighbours counts as one change.
std::size_t distance(std::string_view a, std::string_view b) {
  const std::size_t columns = b.size() + 1;
  std::vector<std::size_t> d((a.size() + 1) * columns);
  for (std::size_t i = 0; i <= a.size(); ++i) d[i * columns] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      std::size_t& here = d[i * columns + j];
      here = std::min({d[(i - 1) * columns + j] + 1, d[i * columns + j - 1] + 1,
                       d[(i - 1) * columns + j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        here = std::min(here, d[(i - 2) * columns + j - 2] + 1);
    }
  }
  return d.back();
}

unsigned char byte(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

/// Bytes of the first character; 0 where it is no UTF-8.
std::size_t character_size(std::string_view text) {
  const unsigned char first = byte(text, 0);
  const std::size_t size = first < 0x80   ? 1
                           : first < 0xC2 ? 0
                           : first < 0xE0 ? 2
                           : first < 0xF0 ? 3
                           : first < 0xF5 ? 4
                                          : 0;
  if (size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i)
    if ((byte(text, i) & 0xC0U) != 0x80) return 0;
  return size;
}

/// The first character. It has `size` bytes.
char32_t code_point(std::string_view text, std::size_t size) {
  char32_t code = size == 1 ? byte(text, 0) : byte(text, 0) & (0xFFU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) code = code << 6U | (byte(text, i) & 0x3FU);
  return code;
}

/// Whether a terminal would obey it: C0, DEL and C1, line ends, marks that turn the direction of
/// writing, and the byte-order mark, which is not seen.
bool is_control(char32_t c) {
  return c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x61C || c == 0x200E || c == 0x200F ||
         (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069) || c == 0xFEFF;
}

/// Takes the first character off the text and gives it back, escaped where a terminal would obey
/// it.
std::string take_character(std::string_view& text) {
  const std::size_t size = character_size(text);
  std::string out;
  if (size == 0)
    out = fmt::format("\\x{:02X}", byte(text, 0));
  else if (const char32_t code = code_point(text, size); is_control(code))
    out = fmt::format("\\u{:04X}", static_cast<std::uint32_t>(code));
  else
    out = text.substr(0, size);
  text.remove_prefix(std::max<std::size_t>(1, size));
  return out;
}

}  // namespace

std::string toml_string(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const char c = text[0];
    const std::string printed = take_character(text);
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (c == '\n')
      out += "\\n";
    else if (c == '\t')
      out += "\\t";
    else
      out += printed;
  }
  return out + '"';
}

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) out += take_character(text);
  return out;
}

std::string printable_lines(std::string_view text) {
  std::string out;
  while (true) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    out += printable(text.substr(0, end));
    if (end == text.size()) return out;
    out += '\n';
    text.remove_prefix(end + 1);
  }
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  if (!std::isfinite(value) || text.find_first_of(".e") != std::string::npos) return text;
  // a whole number would read as an integer
  const std::size_t digits = text.find_last_not_of('0') + 1;
  const std::size_t zeros = text.size() - digits;
  if (zeros < 6 || digits == 0) return text + ".0";
  return fmt::format("{}e{}", text.substr(0, digits), zeros);
}

std::string shortened(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80) --end;  // inside UTF-8
  return std::string(text.substr(0, end)) + "...";
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

std::string shell_word(const std::string& word) {
  const bool plain = std::all_of(word.begin(), word.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("./_-+=:,@%").find(c) != std::string_view::npos;
  });
  if (plain && !word.empty()) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + '\'';
}

std::string any_of(const std::vector<std::string>& words, std::string_view quote) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) out += i + 1 < words.size() ? ", " : " or ";
    out += fmt::format("{}{}{}", quote, words[i], quote);
  }
  return out;
}

std::optional<std::string> nearest(std::string_view word,
                                   const std::vector<std::string>& candidates) {
  if (word.size() > 60) return std::nullopt;
  std::optional<std::string> best;
  std::size_t least = 0;
  for (const std::string& candidate : candidates) {
    const std::size_t d = distance(word, candidate);
    const std::size_t near = std::max<std::size_t>(1, std::max(word.size(), candidate.size()) / 3);
    if (d <= near && (!best || d < least)) {
      best = candidate;
      least = d;
    }
  }
  return best;
}

}  // namespace ra2d
