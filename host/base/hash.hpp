// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <bit>
#include <cstddef>
#include <string>
#include <string_view>

namespace ra2d {

static_assert(std::endian::native == std::endian::little,
              "numbers are hashed as they stand in the file: little-endian");

/// XXH3-128 of what is given piece by piece: the numbers of a dataset in the order of its rows, or
/// text.
class Hash {
 public:
  Hash() { XXH3_128bits_reset(&state_); }
  void add(const double* data, std::size_t count) {
    if (count > 0) XXH3_128bits_update(&state_, data, count * sizeof(double));
  }
  void add(std::string_view text) { XXH3_128bits_update(&state_, text.data(), text.size()); }
  /// As xxhsum prints it: 32 hexadecimal digits, lower case, the most significant first.
  std::string text() const {
    XXH128_canonical_t bytes;
    XXH128_canonicalFromHash(&bytes, XXH3_128bits_digest(&state_));
    std::string out;
    for (const unsigned char byte : bytes.digest)
      for (const int digit : {byte >> 4, byte & 15}) out += "0123456789abcdef"[digit];
    return out;
  }

 private:
  XXH3_state_t state_;
};

/// A sum of hashes, which does not depend on the order of what was hashed.
class HashSum {
 public:
  void add(const double* data, std::size_t count) { sum_ += hash(data, count); }
  void take_back(const double* data, std::size_t count) { sum_ -= hash(data, count); }
  bool operator==(const HashSum&) const = default;

 private:
  __extension__ using Number = unsigned __int128;
  static Number hash(const double* data, std::size_t count) {
    const XXH128_hash_t h = XXH3_128bits(data, count * sizeof(double));
    return Number{h.high64} << 64 | h.low64;
  }
  Number sum_ = 0;
};

}  // namespace ra2d
