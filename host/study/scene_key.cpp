// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/scene_key.hpp"

#include <fmt/format.h>

#include <charconv>
#include <string_view>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/hash.hpp"
#include "host/device/backend.hpp"
#include "host/run/run_key.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

/// The echo without the keys that the scene's choices do not use: they change no bit. A surface's
/// line stays whole, for only some of its keys may be unused.
std::string used_keys(const std::string& echoed) {
  std::string used;
  for (std::size_t at = 0; at < echoed.size();) {
    const std::size_t end = std::min(echoed.find('\n', at), echoed.size() - 1) + 1;
    const std::string_view line(echoed.data() + at, end - at);
    if (line.starts_with("surface =") || line.starts_with("[") ||
        line.find("  # not used: ") == line.npos)
      used += line;
    at = end;
  }
  return used;
}

}  // namespace

Key128 to_key(const std::string& digits) {
  Key128 key;
  const char* const begin = digits.data();
  std::from_chars(begin, begin + 16, key.high, 16);
  std::from_chars(begin + 16, begin + 32, key.low, 16);
  return key;
}

std::string key_text(const Key128& key) { return fmt::format("{:016x}{:016x}", key.high, key.low); }

const std::string& FileHashes::of(const std::filesystem::path& file) {
  const std::lock_guard lock(mutex_);  // also while it is read: the others want the same file
  const auto [found, is_new] = hashes_.try_emplace(file);
  if (!is_new) return found->second;
  try {
    const InputFile in(file, "the profile");
    std::vector<char> part(1 << 20);
    Hash hash;
    for (std::uint64_t at = 0; const std::size_t count = in.read(at, part.data(), part.size());
         at += count)
      hash.add(std::string_view(part.data(), count));
    return found->second = hash.text();
  } catch (...) {
    hashes_.erase(found);
    throw;
  }
}

std::vector<std::filesystem::path> FileHashes::names() const {
  std::vector<std::filesystem::path> names;
  for (const auto& [file, hash] : hashes_) names.push_back(file);
  return names;
}

Key128 scene_key(const Scene& scene, FileHashes& files, bool with_sound) {
  Scene bare = without_origins(scene);
  Hash hash;
  hash.add(fmt::format("numerics {}\n{}\n", numerics_version_of(scene), arithmetic()));
  for (BodySpec* body : {&bare.resonator, &bare.slider}) {
    const bool from_file = body->surface.kind == SurfaceKind::file;
    hash.add(from_file ? files.of(scene.file.parent_path() / body->surface.path) : "none");
    hash.add("\n");
    body->surface.path.clear();
  }
  hash.add(used_keys(echo(bare)));
  if (with_sound) hash.add(sound_settings(scene));
  return to_key(hash.text());
}

}  // namespace ra2d
