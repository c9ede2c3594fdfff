// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

/// The key of a run of a study, before its surfaces are made.
namespace ra2d {

/// 128 bits of a hash.
struct Key128 {
  std::uint64_t high = 0, low = 0;
  bool operator==(const Key128&) const = default;
  auto operator<=>(const Key128&) const = default;
};
/// From 32 hexadecimal digits, and back.
Key128 to_key(const std::string& digits);
std::string key_text(const Key128& key);

/// Hashes of files by what is in them, each read once. Threads may share it.
class FileHashes {
 public:
  /// Throws FileError.
  const std::string& of(const std::filesystem::path& file);
  /// The files that were read.
  std::vector<std::filesystem::path> names() const;

 private:
  std::mutex mutex_;
  std::map<std::filesystem::path, std::string> hashes_;
};

/// XXH3-128 of all that decides the bits of a run: the scene with the keys that it uses, the
/// contents of its profiles' files, the version of the numerics and the build's arithmetic. Names
/// and places do not count. run_key() hashes the heights themselves, which take milliseconds to
/// make. Two scenes with one scene key have one run key, too, as long as `numerics_version` is
/// raised when heights change. `with_sound`: of which what microphones hear is kept, too
/// (run_key_with_sound).
Key128 scene_key(const Scene& scene, FileHashes& files, bool with_sound = false);

}  // namespace ra2d

template <>
struct std::hash<ra2d::Key128> {
  std::size_t operator()(const ra2d::Key128& key) const noexcept { return key.low; }
};
