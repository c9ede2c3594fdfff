// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

/// Small files that are read whole or not at all: named sections of bytes, each with its XXH3-128,
/// and the hash of the whole.
namespace ra2d {

struct Section {
  std::string name;
  std::string bytes;
};

/// Why a file cannot be used: "cut short", "damaged in its section 'state'".
struct CorruptFile : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The bytes of the file. `kind` says what it is, e.g. "ra2d checkpoint"; `format` is of that kind.
std::string seal(const std::string& kind, std::uint32_t format,
                 const std::vector<Section>& sections);

/// The sections of a sealed file. Throws CorruptFile where a byte has changed, or the file is of
/// another kind or format.
std::vector<Section> unseal(const std::string& kind, std::uint32_t format,
                            const std::string& bytes);

/// Writes a file aside, brings it to the disk, reads it back, and gives it its name; what had that
/// name is then called `previous`, unless that is empty. Whatever happens on the way, one of the
/// two is there and whole. Throws FileError.
void write_sealed(const std::filesystem::path& path, const std::string& bytes,
                  const std::filesystem::path& previous = {});

/// Throws FileError where a file cannot be read, or is larger than `most` bytes.
std::string read_whole(const std::filesystem::path& path, std::size_t most);

}  // namespace ra2d
