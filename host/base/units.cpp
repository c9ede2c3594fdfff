// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "host/base/text.hpp"

namespace ra2d {
namespace {

constexpr std::size_t longest_quantity = 100;  // bytes
constexpr int largest_power = 9;
constexpr int largest_exponent = 100'000;  // of ten; a double ends long before

/// Powers of metre, kilogram and second.
struct Dimension {
  int length = 0, mass = 0, time = 0;
  bool operator==(const Dimension&) const = default;
};

/// A unit is `rest` times a power of ten times SI units.
struct Unit {
  Dimension dimension;
  int exponent = 0;
  long double rest = 1;
};

struct NamedUnit {
  std::string_view name;
  Unit unit;
  bool takes_prefix;
};
constexpr NamedUnit named_units[] = {
    {"m", {{1, 0, 0}, 0, 1}, true},      {"g", {{0, 1, 0}, -3, 1}, true},
    {"s", {{0, 0, 1}, 0, 1}, true},      {"N", {{1, 1, -2}, 0, 1}, true},
    {"Pa", {{-1, 1, -2}, 0, 1}, true},   {"Hz", {{0, 0, -1}, 0, 1}, true},
    {"min", {{0, 0, 1}, 0, 60}, false},  {"h", {{0, 0, 1}, 2, 36}, false},
    {"t", {{0, 1, 0}, 3, 1}, false},     {"bar", {{-1, 1, -2}, 5, 1}, false},
    {"in", {{1, 0, 0}, -4, 254}, false},
};

struct Prefix {
  char letter;
  int exponent;
};
constexpr Prefix prefixes[] = {{'p', -12}, {'n', -9}, {'u', -6}, {'m', -3}, {'c', -2}, {'d', -1},
                               {'h', 2},   {'k', 3},  {'M', 6},  {'G', 9},  {'T', 12}};

/// A kind of quantity: what messages call it, and what its keys usually stand in.
struct Kind {
  Dimension dimension;
  const char* noun;
  const char* example;
  std::vector<std::string> usual;
};
const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {
      {{1, 0, 0}, "a length", "500 mm", {"mm", "um", "nm", "cm", "m"}},
      {{0, 0, 1}, "a time", "10 ms", {"ms", "us", "ns", "s", "min"}},
      {{1, 0, -1}, "a speed", "100 mm/s", {"mm/s", "um/s", "m/s", "km/h"}},
      {{0, 0, -1}, "a frequency", "100 kHz", {"kHz", "Hz", "MHz"}},
      {{1, 1, -2}, "a force", "5 N", {"N", "kN", "mN"}},
      {{-1, 1, -2}, "a pressure", "210 GPa", {"GPa", "MPa", "kPa", "Pa", "N/mm^2"}},
      {{-3, 1, 0}, "a density", "7.85 g/cm^3", {"g/cm^3", "kg/m^3", "kg/dm^3", "t/m^3"}},
      {{-2, 1, -2}, "a pressure by length", "1 GPa/um", {"GPa/um", "MPa/um", "Pa/m", "N/mm^3"}},
      {{0, 1, 0}, "a mass", "5 g", {"g", "kg"}},
      {{2, 0, 0}, "an area", "5 mm^2", {"mm^2", "m^2"}},
      {{3, 0, 0}, "a volume", "5 mm^3", {"mm^3", "m^3"}},
      {{1, 0, -2}, "an acceleration", "9.81 m/s^2", {"m/s^2"}},
      {{0, 1, -2}, "a force by length", "5 N/mm", {"N/mm", "N/m"}},
  };
  return all;
}

const Kind* kind_of(const Dimension& dimension) {
  const auto at = std::find_if(kinds().begin(), kinds().end(),
                               [&](const Kind& kind) { return kind.dimension == dimension; });
  return at == kinds().end() ? nullptr : &*at;
}

/// "a length", or "m^2 s^-3" of a quantity without a name here.
std::string noun_of(const Dimension& dimension) {
  if (dimension == Dimension{}) return "a plain number";
  if (const Kind* kind = kind_of(dimension)) return kind->noun;
  std::string text = "in";
  for (const auto& [name, power] :
       {std::pair{"kg", dimension.mass}, {"m", dimension.length}, {"s", dimension.time}})
    if (power != 0)
      text += power == 1 ? fmt::format(" {}", name) : fmt::format(" {}^{}", name, power);
  return text;
}

/// Units as they are said, spelt wrong or written in another way, and what is meant.
constexpr std::pair<const char*, const char*> other_names[] = {
    {"micron", "um"}, {"microns", "um"},  {"meter", "m"},      {"meters", "m"},
    {"metre", "m"},   {"metres", "m"},    {"inch", "in"},      {"inches", "in"},
    {"sec", "s"},     {"second", "s"},    {"seconds", "s"},    {"hour", "h"},
    {"hours", "h"},   {"minute", "min"},  {"minutes", "min"},  {"newton", "N"},
    {"newtons", "N"}, {"pascal", "Pa"},   {"hertz", "Hz"},     {"kmh", "km/h"},
    {"kph", "km/h"},  {"g/cc", "g/cm^3"}, {"g/ccm", "g/cm^3"}, {"gcc", "g/cm^3"}};

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// The unit that a mistyped one most likely meant; empty for none.
std::string meant(const std::string& given, const Dimension& wanted) {
  for (const auto& [name, unit] : other_names)
    if (lower(given) == name) return unit;
  const Kind* kind = kind_of(wanted);
  if (kind == nullptr) return {};
  for (const std::string& usual : kind->usual)
    if (lower(usual) == lower(given)) return usual;
  return nearest(given, kind->usual).value_or("");
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// In ASCII: the signs that people and documents have for micro, powers, products and blanks.
std::string in_ascii(std::string_view text) {
  constexpr std::pair<std::string_view, std::string_view> signs[] = {
      {"\u00B5", "u"}, {"\u03BC", "u"}, {"\u00B9", "1"}, {"\u00B2", "2"}, {"\u00B3", "3"},
      {"\u207B", "-"}, {"\u2212", "-"}, {"\u00B7", "*"}, {"\u22C5", "*"}, {"\u00A0", " "},
      {"\u2009", " "}, {"\u202F", " "}, {"**", "^"}};
  std::string out;
  while (!text.empty()) {
    const auto* const sign = std::find_if(std::begin(signs), std::end(signs), [&](const auto& one) {
      return text.starts_with(one.first);
    });
    const bool found = sign != std::end(signs);
    out += found ? sign->second : text.substr(0, 1);
    text.remove_prefix(found ? sign->first.size() : 1);
  }
  return std::string(trimmed(out));
}

/// Takes characters off the front of a text.
class Cursor {
 public:
  explicit Cursor(std::string_view text) : text_{text} {}
  bool at_end() const { return text_.empty(); }
  char next() const { return text_.empty() ? '\0' : text_[0]; }
  char after_next() const { return text_.size() < 2 ? '\0' : text_[1]; }
  std::string_view rest() const { return text_; }
  char take() {
    const char c = text_[0];
    text_.remove_prefix(1);
    return c;
  }
  bool take(char c) {
    if (next() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  bool skip_blanks() {
    const std::size_t before = text_.size();
    text_ = text_.substr(std::min(text_.find_first_not_of(" \t"), text_.size()));
    return text_.size() < before;
  }
  /// Digits, with single "_" between them as TOML has them, without the "_".
  std::string digits() {
    std::string out;
    while (is_digit(next()) || (next() == '_' && !out.empty() && is_digit(after_next())))
      if (const char c = take(); c != '_') out += c;
    return out;
  }

 private:
  std::string_view text_;
};

/// A whole number with a sign, kept from becoming too large.
int whole(const std::string& digits, bool is_negative, int most) {
  int value = 0;
  for (const char c : digits) value = std::min(most, 10 * value + (c - '0'));
  return is_negative ? -value : value;
}

/// A decimal number, as its digits and the power of ten behind them.
struct Decimal {
  std::string digits;  // with a sign
  int exponent = 0;

  /// The nearest double to this number times a power of ten.
  double times_ten_to(int power) const {
    const std::string text = fmt::format("{}e{}", digits, exponent + power);
    double value = 0;
    const auto fault = std::from_chars(text.data(), text.data() + text.size(), value).ec;
    if (fault != std::errc::result_out_of_range) return value;
    const std::size_t first = std::min(digits.find_first_not_of("-0"), digits.size());
    const bool is_large = static_cast<int>(digits.size() - first) + exponent + power > 0;
    return std::copysign(is_large ? std::numeric_limits<double>::infinity() : 0.0,
                         digits[0] == '-' ? -1.0 : 1.0);
  }
};

std::optional<Decimal> take_decimal(Cursor& in) {
  Decimal number;
  if (in.take('-'))
    number.digits = "-";
  else
    in.take('+');
  const std::string before = in.digits();
  std::string behind;
  if (in.next() == '.' && (!before.empty() || is_digit(in.after_next()))) {
    in.take();
    behind = in.digits();
  }
  if (before.empty() && behind.empty()) return std::nullopt;
  number.digits += before + behind;
  number.exponent = -static_cast<int>(behind.size());
  if (lower({in.next()}) == "e") {
    Cursor power = in;
    power.take();
    const bool is_negative = power.next() == '-';
    if (is_negative || power.next() == '+') power.take();
    if (const std::string digits = power.digits(); !digits.empty()) {
      number.exponent += whole(digits, is_negative, largest_exponent);
      in = power;
    }
  }
  return number;
}

std::optional<Unit> find_unit(std::string_view name) {
  for (const NamedUnit& one : named_units)
    if (one.name == name) return one.unit;
  for (const NamedUnit& one : named_units)
    for (const Prefix& prefix : prefixes)
      if (one.takes_prefix && name.size() == one.name.size() + 1 && name[0] == prefix.letter &&
          name.substr(1) == one.name) {
        Unit unit = one.unit;
        unit.exponent += prefix.exponent;
        return unit;
      }
  return std::nullopt;
}

void multiply(Unit& product, const Unit& unit, int power) {
  product.dimension.length += power * unit.dimension.length;
  product.dimension.mass += power * unit.dimension.mass;
  product.dimension.time += power * unit.dimension.time;
  product.exponent += power * unit.exponent;
  for (int i = 0; i < std::abs(power); ++i)
    product.rest = power > 0 ? product.rest * unit.rest : product.rest / unit.rest;
}

/// Products, quotients and powers, from left to right: "kg/m^3", "kg m-3", "1/s".
std::optional<Unit> find_product(std::string_view text) {
  Cursor in(text);
  Unit product;
  if (in.next() == '1' && in.after_next() == '/') in.take();
  bool is_divided = in.take('/');
  for (;;) {
    in.skip_blanks();
    std::string name;
    while (is_letter(in.next())) name += in.take();
    const std::optional<Unit> unit = find_unit(name);
    if (!unit) return std::nullopt;
    int power = 1;
    const bool has_power = in.take('^');
    const bool is_negative = in.next() == '-' && is_digit(in.after_next());
    if (is_negative) in.take();
    if (const std::string digits = in.digits(); !digits.empty())
      power = whole(digits, is_negative, largest_power + 1);
    else if (has_power)
      return std::nullopt;
    if (std::abs(power) > largest_power) return std::nullopt;
    multiply(product, *unit, is_divided ? -power : power);
    const bool has_blank = in.skip_blanks();
    if (in.at_end()) return product;
    is_divided = in.take('/');
    if (!is_divided && !in.take('*') && !in.take('.') && !has_blank) return std::nullopt;
  }
}

bool begins_in_another_base(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of("+-"), text.size()));
  return text.size() > 1 && text[0] == '0' && std::string_view("xXoObB").find(text[1]) != text.npos;
}

}  // namespace

NumberWithUnit read_quantity(std::string_view text, const std::string& unit) {
  if (text.size() > longest_quantity) return {{}, "is too long for a number with a unit"};
  const std::string ascii = in_ascii(text);
  if (begins_in_another_base(ascii)) return {{}, "is not in decimals"};
  Cursor in(ascii);
  const std::optional<Decimal> number = take_decimal(in);
  if (!number) return {};
  if (in.next() == ',') return {{}, "has a comma: decimals stand behind a point"};
  in.skip_blanks();
  const std::string name(in.rest());
  if (name.empty()) return {{}, unit.empty() ? "is a text, no number" : "is a text without a unit"};
  if (name == "%" && unit.empty())
    return {{}, fmt::format("is in per cent: write {}", number->times_ten_to(-2))};
  if (!is_letter(name[0]) && !name.starts_with("1/")) return {};
  const std::optional<Unit> given = find_product(name), wanted = find_product(unit);
  if (!wanted) return {{}, "has a unit, and this number has none"};
  if (!given) {
    const std::string near = meant(name, wanted->dimension);
    return {{},
            fmt::format("has the unknown unit {}{}", toml_string(shortened(name)),
                        near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near))};
  }
  if (given->dimension != wanted->dimension)
    return {{},
            fmt::format("is {}, not {}", noun_of(given->dimension), noun_of(wanted->dimension))};
  const int exponent = given->exponent - wanted->exponent;
  if (given->rest == wanted->rest) return {number->times_ten_to(exponent), {}};
  // rounded once, to many digits, before it becomes a double
  const long double factor = std::pow(10.0L, std::abs(exponent));
  const long double value = number->times_ten_to(0) * (given->rest / wanted->rest);
  return {static_cast<double>(exponent < 0 ? value / factor : value * factor), {}};
}

std::string quantity_examples(const std::string& unit) {
  const std::optional<Unit> found = find_product(unit);
  const Kind* kind = found ? kind_of(found->dimension) : nullptr;
  if (kind == nullptr) return fmt::format("such as \"1 {}\"", unit);
  return fmt::format("such as \"{}\" ({})", kind->example, fmt::join(kind->usual, ", "));
}

std::optional<double> multiple_of(std::string_view text, std::string_view word) {
  if (text == word) return 1;
  if (text.size() > longest_quantity) return std::nullopt;
  const std::string ascii = in_ascii(text);
  Cursor in(ascii);
  const std::optional<Decimal> number = take_decimal(in);
  in.skip_blanks();
  if (!number || (in.rest() != word && in.rest() != std::string(word) + 's')) return std::nullopt;
  return number->times_ten_to(0);
}

}  // namespace ra2d
