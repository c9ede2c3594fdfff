// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>

struct evp_md_ctx_st;  // of OpenSSL

namespace ra2d {

/// MD5 of bytes that come in parts. X3P names files by it; it tells slips, not forgeries.
class Md5 {
 public:
  Md5();
  ~Md5();
  Md5(const Md5&) = delete;
  Md5& operator=(const Md5&) = delete;
  void add(const char* bytes, std::size_t count);
  /// 32 hexadecimal digits, in small letters. Nothing may be added afterwards.
  std::string hex();

 private:
  evp_md_ctx_st* context_;
};

}  // namespace ra2d
