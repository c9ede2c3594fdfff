// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/md5.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>

#include "host/base/errors.hpp"

namespace ra2d {
namespace {

void require(bool done) {
  if (!done) throw FileError("MD5 cannot be computed on this machine");
}

}  // namespace

Md5::Md5() : context_(EVP_MD_CTX_new()) {
  require(context_ != nullptr && EVP_DigestInit_ex(context_, EVP_md5(), nullptr) == 1);
}

Md5::~Md5() { EVP_MD_CTX_free(context_); }

void Md5::add(const char* bytes, std::size_t count) {
  require(EVP_DigestUpdate(context_, bytes, count) == 1);
}

std::string Md5::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  require(EVP_DigestFinal_ex(context_, digest.data(), &size) == 1 && size == 16);
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

}  // namespace ra2d
