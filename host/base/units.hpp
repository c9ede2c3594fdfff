// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <string_view>

/// Numbers with a unit, as people write them: "500 mm", "7.85 g/cm^3", "8 um".
namespace ra2d {

/// The number that a text stands for in a given unit, or why it stands for none.
struct NumberWithUnit {
  std::optional<double> value;  // infinite: more than a double holds
  std::string fault;  // follows the text in a message: "is a mass, not a length"; empty where there
                      // is a value, and for a text that is nothing like a number with a unit
};

/// Reads `text` as a number with a unit; the answer is in `unit`, "m" or "kg/m^3". Where the factor
/// between the two units is a power of ten, the decimal point is moved before the text becomes a
/// double: "8 um" is the double nearest to 8e-6.
NumberWithUnit read_quantity(std::string_view text, const std::string& unit);

/// "such as "500 mm" (mm, um, nm, cm, m)": an example and the usual units, for a message about a
/// number in `unit`.
std::string quantity_examples(const std::string& unit);

/// How often a text says the word: 2 for "2 weight", 1 for "weight"; nothing for another text.
std::optional<double> multiple_of(std::string_view text, std::string_view word);

}  // namespace ra2d
