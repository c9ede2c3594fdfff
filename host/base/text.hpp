// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Small pieces of text that the reader and the echo of scenes share.
namespace ra2d {

/// A TOML basic string, quoted and escaped.
std::string toml_string(std::string_view text);

/// A TOML float: the shortest text that reads back as the same double.
std::string toml_number(double value);

/// A text from outside as a terminal may have it: control characters, those that end a line or turn
/// the direction of writing, and bytes that are no UTF-8, escaped.
std::string printable(std::string_view text);

/// As printable(), line by line: line ends stay.
std::string printable_lines(std::string_view text);

/// `text`, or its beginning with "..." when it has more than `most` bytes.
std::string shortened(std::string_view text, std::size_t most = 60);

/// Without the blanks at both ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r\n\v\f");

/// A word as a POSIX shell takes it.
std::string shell_word(const std::string& word);

/// "a, b or c", each between `quote`s.
std::string any_of(const std::vector<std::string>& words, std::string_view quote);

/// The candidate that a mistyped word most likely meant (few insertions, deletions, substitutions
/// and swaps of neighbours away), if one is near enough.
std::optional<std::string> nearest(std::string_view word,
                                   const std::vector<std::string>& candidates);

}  // namespace ra2d
