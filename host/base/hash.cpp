// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/hash.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <new>

namespace ra2d {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are hashed as they stand in the file: little-endian");

XXH3_state_t& state_in(std::byte* bytes) {
  return *std::launder(reinterpret_cast<XXH3_state_t*>(bytes));
}
const XXH3_state_t& state_in(const std::byte* bytes) {
  return *std::launder(reinterpret_cast<const XXH3_state_t*>(bytes));
}

Digest canonical(const XXH128_hash_t& hash) {
  XXH128_canonical_t bytes;
  XXH128_canonicalFromHash(&bytes, hash);
  Digest digest;
  std::copy(std::begin(bytes.digest), std::end(bytes.digest), digest.begin());
  return digest;
}

}  // namespace

Digest digest_of(std::string_view bytes) {
  return canonical(XXH3_128bits(bytes.data(), bytes.size()));
}

std::uint64_t short_hash(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string hexadecimal(const Digest& digest) {
  std::string out;
  for (const char byte : digest)
    for (const int digit : {static_cast<unsigned char>(byte) >> 4, byte & 15})
      out += "0123456789abcdef"[digit];
  return out;
}

Hash::Hash() {
  static_assert(sizeof(XXH3_state_t) <= state_size && alignof(XXH3_state_t) <= state_alignment);
  XXH3_128bits_reset(::new (state_.data()) XXH3_state_t);
}

void Hash::add(const double* data, std::size_t count) {
  if (count > 0) XXH3_128bits_update(&state_in(state_.data()), data, count * sizeof(double));
}

void Hash::add(std::string_view text) {
  XXH3_128bits_update(&state_in(state_.data()), text.data(), text.size());
}

Digest Hash::digest() const { return canonical(XXH3_128bits_digest(&state_in(state_.data()))); }

HashSum::Number HashSum::hash(const double* data, std::size_t count) {
  const XXH128_hash_t h = XXH3_128bits(data, count * sizeof(double));
  return Number{h.high64} << 64 | h.low64;
}

}  // namespace ra2d
