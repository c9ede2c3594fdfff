// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace ra2d {

/// An XXH3-128, most significant byte first, as xxHash writes it.
using Digest = std::array<char, 16>;

/// The hash of these bytes.
Digest digest_of(std::string_view bytes);

/// Their XXH3-64, which is another hash.
std::uint64_t short_hash(std::string_view bytes);

/// 32 hexadecimal digits in lower case, as xxhsum prints them.
std::string hexadecimal(const Digest& digest);

/// XXH3-128 of numbers or text that are given piece by piece.
class Hash {
 public:
  Hash();
  void add(const double* data, std::size_t count);
  void add(std::string_view text);
  Digest digest() const;
  std::string text() const { return hexadecimal(digest()); }

 private:
  static constexpr std::size_t state_size = 576, state_alignment = 64;  // bytes, of xxHash's own
  alignas(state_alignment) std::array<std::byte, state_size> state_;
};

/// A sum of hashes. It does not depend on the order of what was hashed.
class HashSum {
 public:
  void add(const double* data, std::size_t count) { sum_ += hash(data, count); }
  void take_back(const double* data, std::size_t count) { sum_ -= hash(data, count); }
  bool operator==(const HashSum&) const = default;

 private:
  __extension__ using Number = unsigned __int128;
  static Number hash(const double* data, std::size_t count);
  Number sum_ = 0;
};

}  // namespace ra2d
