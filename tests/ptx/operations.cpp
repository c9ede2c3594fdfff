// SPDX-License-Identifier: BSD-3-Clause
// Instructions that compute, each by its name.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "tests/ptx/program.hpp"

namespace ra2d::test {
namespace {

template <std::size_t bytes>
using BitsOf = std::conditional_t<bytes == 8, std::uint64_t, std::uint32_t>;

template <class T>
T from_bits(std::uint64_t bits) {
  if constexpr (std::is_same_v<T, bool>)
    return (bits & 1) != 0;
  else if constexpr (std::is_floating_point_v<T>)
    return std::bit_cast<T>(static_cast<BitsOf<sizeof(T)>>(bits));
  else
    return static_cast<T>(bits);
}
template <class T>
std::uint64_t to_bits(T value) {
  if constexpr (std::is_same_v<T, bool>)
    return value ? 1 : 0;
  else if constexpr (std::is_floating_point_v<T>)
    return std::bit_cast<BitsOf<sizeof(T)>>(value);
  else
    return static_cast<std::make_unsigned_t<T>>(value);
}

/// Calls `function` in each lane of `mask`.
template <class Function>
void in_lanes(std::uint32_t mask, const Function& function) {
  if (mask == 0xFFFFFFFF) {
    for (int lane = 0; lane < warp_width; ++lane) function(lane);
    return;
  }
  for (; mask != 0; mask &= mask - 1) function(std::countr_zero(mask));
}

template <auto function, class Result, class... Operands>
struct EachLane {
  static void run(LaneBits* registers, const Instruction& i, std::uint32_t mask) {
    run(registers, i, mask, std::index_sequence_for<Operands...>());
  }
  template <std::size_t... k>
  static void run(LaneBits* registers, const Instruction& i, std::uint32_t mask,
                  std::index_sequence<k...>) {
    LaneBits& result = registers[i.result[0]];
    in_lanes(mask, [&](int lane) {
      result[lane] =
          to_bits<Result>(function(from_bits<Operands>(registers[i.operand[k]][lane])...));
    });
  }
};
template <auto function, class Result, class... Operands>
constexpr Compute lanes_of(Result (*)(Operands...)) {
  return &EachLane<function, Result, Operands...>::run;
}
/// A function of values, such as [](double a, double b) { return a + b; }, in each lane.
template <auto function>
constexpr Compute compute = lanes_of<function>(+function);

/// `mov.b64 {low, high}, from` and `mov.b64 to, {low, high}`.
void unpack(LaneBits* registers, const Instruction& i, std::uint32_t mask) {
  in_lanes(mask, [&](int lane) {
    const std::uint64_t from = registers[i.operand[0]][lane];
    registers[i.result[0]][lane] = from & 0xFFFFFFFF;
    registers[i.result[1]][lane] = from >> 32;
  });
}
void pack(LaneBits* registers, const Instruction& i, std::uint32_t mask) {
  in_lanes(mask, [&](int lane) {
    registers[i.result[0]][lane] =
        (registers[i.operand[0]][lane] & 0xFFFFFFFF) | registers[i.operand[1]][lane] << 32;
  });
}

/// A real value as a whole one: what is too large becomes the nearest, what is no number 0 or, of
/// 64 bits, the least.
template <class Whole>
Whole to_whole(double x) {
  using Limits = std::numeric_limits<Whole>;
  if (std::isnan(x)) return sizeof(Whole) == 8 ? Limits::min() : 0;
  if (x <= static_cast<double>(Limits::min())) return Limits::min();
  // the largest may round up to what is none any more
  if (x >= static_cast<double>(Limits::max())) return Limits::max();
  return static_cast<Whole>(x);
}

using Table = std::unordered_map<std::string, Compute>;

template <class T>
void add_comparisons(Table& table, const std::string& type) {
  const auto name = [&](const char* word) { return std::string("setp.") + word + "." + type; };
  table[name("eq")] = compute<[](T a, T b) { return a == b; }>;
  table[name("ne")] = compute<[](T a, T b) { return a < b || b < a; }>;  // not for no numbers
  table[name("lt")] = compute<[](T a, T b) { return a < b; }>;
  table[name("le")] = compute<[](T a, T b) { return a <= b; }>;
  table[name("gt")] = compute<[](T a, T b) { return b < a; }>;
  table[name("ge")] = compute<[](T a, T b) { return a >= b; }>;
  if constexpr (std::is_floating_point_v<T>) {
    table[name("equ")] = compute<[](T a, T b) { return !(a < b || b < a); }>;
    table[name("neu")] = compute<[](T a, T b) { return a != b; }>;
    table[name("ltu")] = compute<[](T a, T b) { return !(a >= b); }>;
    table[name("leu")] = compute<[](T a, T b) { return !(b < a); }>;
    table[name("gtu")] = compute<[](T a, T b) { return !(a <= b); }>;
    table[name("geu")] = compute<[](T a, T b) { return !(a < b); }>;
    table[name("num")] = compute<[](T a, T b) { return a == a && b == b; }>;
    table[name("nan")] = compute<[](T a, T b) { return a != a || b != b; }>;
  }
}

template <class T>
void add_moves(Table& table, const std::string& type) {
  table["mov." + type] = compute<[](T a) { return a; }>;
  table["selp." + type] = compute<[](T a, T b, bool first) { return first ? a : b; }>;
}

/// Operations on words of either sign.
template <class T>
void add_words(Table& table, const std::string& type) {
  using U = std::make_unsigned_t<T>;
  static_assert(sizeof(T) >= 2);
  table["add." + type] = compute<[](U a, U b) { return static_cast<U>(a + b); }>;
  table["sub." + type] = compute<[](U a, U b) { return static_cast<U>(a - b); }>;
  table["mul.lo." + type] = compute<[](U a, U b) { return static_cast<U>(std::uint64_t{a} * b); }>;
  table["mad.lo." + type] =
      compute<[](U a, U b, U c) { return static_cast<U>(std::uint64_t{a} * b + c); }>;
  table["neg." + type] = compute<[](U a) { return static_cast<U>(-std::uint64_t{a}); }>;
}

template <class T>
void add_whole_numbers(Table& table, const std::string& type) {
  add_words<T>(table, type);
  add_comparisons<T>(table, type);
  add_moves<T>(table, type);
  table["div." + type] = compute<[](T a, T b) { return static_cast<T>(a / b); }>;
  table["rem." + type] = compute<[](T a, T b) { return static_cast<T>(a % b); }>;
  table["min." + type] = compute<[](T a, T b) { return std::min(a, b); }>;
  table["max." + type] = compute<[](T a, T b) { return std::max(a, b); }>;
  if constexpr (std::is_signed_v<T>)
    table["abs." + type] = compute<[](T a) { return static_cast<T>(a < 0 ? 0 - a : a); }>;
  constexpr auto width = static_cast<std::uint32_t>(8 * sizeof(T));
  table["shr." + type] = compute<[](T a, std::uint32_t by) {
    if (by < width) return static_cast<T>((a >> by));
    if constexpr (std::is_signed_v<T>) return static_cast<T>(a < 0 ? -1 : 0);
    return T{0};
  }>;
}

template <class T>
void add_bits(Table& table, const std::string& type) {
  add_comparisons<T>(table, type);
  add_moves<T>(table, type);
  table["and." + type] = compute<[](T a, T b) { return static_cast<T>(a & b); }>;
  table["or." + type] = compute<[](T a, T b) { return static_cast<T>(a | b); }>;
  table["xor." + type] = compute<[](T a, T b) { return static_cast<T>(a ^ b); }>;
  table["not." + type] = compute<[](T a) { return static_cast<T>(~a); }>;
  constexpr auto width = static_cast<std::uint32_t>(8 * sizeof(T));
  table["shl." + type] = compute<[](T a, std::uint32_t by) {
    return static_cast<T>(by < width ? std::uint64_t{a} << by : 0);
  }>;
  if constexpr (sizeof(T) >= 4) {
    table["popc." + type] = compute<[](T a) { return std::popcount(a); }>;
    // `length` bits of a, in place of those of b from `begin` on
    table["bfi." + type] = compute<[](T a, T b, std::uint32_t begin, std::uint32_t length) {
      constexpr std::uint32_t bits = 8 * sizeof(T);
      begin &= 0xFF;
      length &= 0xFF;
      if (begin >= bits || length == 0) return b;
      const T mask = (length >= bits ? ~T(0) : (T(1) << length) - 1) << begin;
      return (b & ~mask) | (a << begin & mask);
    }>;
    table["clz." + type] = compute<[](T a) { return std::countl_zero(a); }>;
    table["brev." + type] = compute<[](T a) {
      T reversed = 0;
      for (std::uint32_t k = 0; k < width; ++k)
        reversed = static_cast<T>(reversed << 1 | ((a >> k) & 1));
      return reversed;
    }>;
  }
}

/// Conversions to a type from whole numbers.
template <class To, class From>
void add_conversion(Table& table, const std::string& to, const std::string& from) {
  const std::string round = std::is_floating_point_v<To> ? "rn." : "";
  table["cvt." + round + to + "." + from] = compute<[](From a) { return static_cast<To>(a); }>;
}
template <class From>
void add_conversions(Table& table, const std::string& from) {
  add_conversion<std::uint8_t, From>(table, "u8", from);
  add_conversion<std::int8_t, From>(table, "s8", from);
  add_conversion<std::uint16_t, From>(table, "u16", from);
  add_conversion<std::int16_t, From>(table, "s16", from);
  add_conversion<std::uint32_t, From>(table, "u32", from);
  add_conversion<std::int32_t, From>(table, "s32", from);
  add_conversion<std::uint64_t, From>(table, "u64", from);
  add_conversion<std::int64_t, From>(table, "s64", from);
  add_conversion<double, From>(table, "f64", from);
}
/// Conversions of a double to a whole number, rounded as a word says.
template <auto round>
void add_rounding(Table& table, const std::string& word) {
  table["cvt." + word + ".f64.f64"] = compute<[](double x) { return round(x); }>;
  table["cvt." + word + ".s32.f64"] =
      compute<[](double x) { return to_whole<std::int32_t>(round(x)); }>;
  table["cvt." + word + ".s64.f64"] =
      compute<[](double x) { return to_whole<std::int64_t>(round(x)); }>;
}

void add_doubles(Table& table) {
  add_comparisons<double>(table, "f64");
  add_moves<double>(table, "f64");
  table["add.rn.f64"] = compute<[](double a, double b) { return a + b; }>;
  table["sub.rn.f64"] = compute<[](double a, double b) { return a - b; }>;
  table["mul.rn.f64"] = compute<[](double a, double b) { return a * b; }>;
  table["div.rn.f64"] = compute<[](double a, double b) { return a / b; }>;
  table["fma.rn.f64"] = compute<[](double a, double b, double c) { return std::fma(a, b, c); }>;
  table["rcp.rn.f64"] = compute<[](double a) { return 1.0 / a; }>;
  table["sqrt.rn.f64"] = compute<[](double a) { return std::sqrt(a); }>;
  table["neg.f64"] = compute<[](double a) { return -a; }>;
  table["abs.f64"] = compute<[](double a) { return std::abs(a); }>;
  table["copysign.f64"] = compute<[](double sign, double of) { return std::copysign(of, sign); }>;
  // of a number and none the number; -0 is less than 0
  table["min.f64"] = compute<[](double a, double b) {
    if (a == b) return std::signbit(a) ? a : b;
    return b != b || a < b ? a : b;
  }>;
  table["max.f64"] = compute<[](double a, double b) {
    if (a == b) return std::signbit(a) ? b : a;
    return b != b || b < a ? a : b;
  }>;
  add_rounding<[](double x) { return std::nearbyint(x); }>(table, "rni");
  add_rounding<[](double x) { return std::trunc(x); }>(table, "rzi");
  add_rounding<[](double x) { return std::floor(x); }>(table, "rmi");
  add_rounding<[](double x) { return std::ceil(x); }>(table, "rpi");
}

Table make_table() {
  Table table;
  add_doubles(table);
  add_whole_numbers<std::int16_t>(table, "s16");
  add_whole_numbers<std::uint16_t>(table, "u16");
  add_whole_numbers<std::int32_t>(table, "s32");
  add_whole_numbers<std::uint32_t>(table, "u32");
  add_whole_numbers<std::int64_t>(table, "s64");
  add_whole_numbers<std::uint64_t>(table, "u64");
  add_bits<std::uint16_t>(table, "b16");
  add_bits<std::uint32_t>(table, "b32");
  add_bits<std::uint64_t>(table, "b64");
  add_conversions<std::uint8_t>(table, "u8");
  add_conversions<std::int8_t>(table, "s8");
  add_conversions<std::uint16_t>(table, "u16");
  add_conversions<std::int16_t>(table, "s16");
  add_conversions<std::uint32_t>(table, "u32");
  add_conversions<std::int32_t>(table, "s32");
  add_conversions<std::uint64_t>(table, "u64");
  add_conversions<std::int64_t>(table, "s64");
  table["mul.wide.s32"] =
      compute<[](std::int32_t a, std::int32_t b) { return std::int64_t{a} * b; }>;
  table["mul.wide.u32"] =
      compute<[](std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} * b; }>;
  // how far left the highest bit must go
  table["bfind.shiftamt.u32"] = compute<[](std::uint32_t a) {
    return a == 0 ? 0xFFFFFFFF : static_cast<std::uint32_t>(std::countl_zero(a));
  }>;
  table["mov.pred"] = compute<[](bool a) { return a; }>;
  table["not.pred"] = compute<[](bool a) { return !a; }>;
  table["and.pred"] = compute<[](bool a, bool b) { return a && b; }>;
  table["or.pred"] = compute<[](bool a, bool b) { return a || b; }>;
  table["xor.pred"] = compute<[](bool a, bool b) { return a != b; }>;
  // generic addresses are those of global memory and, here, of local memory too
  table["cvta.to.global.u64"] = table["cvta.to.local.u64"] = table["cvta.local.u64"] =
      table["cvta.global.u64"] = table["mov.u64"];
  table["pack"] = pack;
  table["unpack"] = unpack;
  return table;
}

}  // namespace

Compute find_compute(std::string_view opcode) {
  static const Table table = make_table();
  const auto found = table.find(std::string(opcode));
  return found == table.end() ? nullptr : found->second;
}

}  // namespace ra2d::test
