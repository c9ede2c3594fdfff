// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "host/base/errors.hpp"
#include "host/surface/profile.hpp"

/// The common parts of the fuzzers: a file in memory, and a check of every answer about it.
namespace ra2d::fuzz {

/// The path of a file with this content, until the next one. It lies in memory: nothing is written.
inline std::filesystem::path file_of(const std::uint8_t* bytes, std::size_t size) {
  static int handle = -1;
  if (handle >= 0) close(handle);
  handle = memfd_create("profile", 0);
  if (handle < 0 || write(handle, bytes, size) != static_cast<ssize_t>(size)) std::abort();
  return "/proc/self/fd/" + std::to_string(handle);
}

/// A profile that can be measured, or one of the two errors; anything else ends the fuzzer.
template <class Read>
void expect_profile_or_error(const Read& read, const std::filesystem::path& file,
                             const ProfileQuery& query) {
  try {
    const Profile profile = read(file, query);
    if (!(profile.spacing > 0) || !std::isfinite(profile.spacing)) std::abort();
    if (profile.heights.size() < 2 || profile.missing() == profile.heights.size()) std::abort();
    if ((profile.missing() > 0) == profile.first_missing.empty()) std::abort();
    for (const double z : profile.heights)
      if (std::isinf(z)) std::abort();
  } catch (const RequestError& error) {
    if (std::string(error.what()).empty()) std::abort();
  } catch (const FileError&) {
  }
}

}  // namespace ra2d::fuzz
