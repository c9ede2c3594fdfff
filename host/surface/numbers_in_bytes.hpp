// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

namespace ra2d {

/// A number that a file stores with the lowest byte first, on any machine.
template <class T>
T little_endian(const char* bytes) {
  unsigned char own[sizeof(T)];
  std::memcpy(own, bytes, sizeof(T));
  if constexpr (std::endian::native == std::endian::big)
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) {
      const unsigned char low = own[i];
      own[i] = own[sizeof(T) - 1 - i];
      own[sizeof(T) - 1 - i] = low;
    }
  T value;
  std::memcpy(&value, own, sizeof(T));
  return value;
}

/// A number that a file stores with the highest byte first.
template <class T>
T big_endian(const char* bytes) {
  char turned[sizeof(T)];
  std::reverse_copy(bytes, bytes + sizeof(T), turned);
  return little_endian<T>(turned);
}

/// As a double, whatever its type.
template <class T>
double little_endian_value(const char* bytes) {
  return static_cast<double>(little_endian<T>(bytes));
}
template <class T>
double big_endian_value(const char* bytes) {
  return static_cast<double>(big_endian<T>(bytes));
}

}  // namespace ra2d
