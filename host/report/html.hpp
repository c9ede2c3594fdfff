// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <string_view>

/// Pieces of a page.
namespace ra2d {

/// A text from outside as a page may have it, of one line: nothing in it is markup, in an
/// attribute's quotes neither, and control characters are written out.
std::string html(std::string_view text);

/// As html(), of several lines.
std::string html_lines(std::string_view text);

/// Bytes as a data: address has them (RFC 4648).
std::string base64(std::string_view bytes);

/// A number with so many significant digits, and the times sign where it has a power of ten.
std::string html_number(double value, int digits = 3);

}  // namespace ra2d
