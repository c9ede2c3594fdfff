// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/sealed_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "host/base/errors.hpp"
#include "host/base/hash.hpp"
#include "host/system/input_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t kind_bytes = 24, hash_text_bytes = 32;

template <class Number>
void put(std::string& out, Number number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  out.append(bytes, sizeof number);
}

void put_hashed(std::string& out, std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  out += hash.text();
}

std::string padded(std::string kind) {
  kind.resize(kind_bytes, '\0');
  return kind;
}

/// Reads from the front of what is left.
class Cursor {
 public:
  explicit Cursor(std::string_view rest) : rest_{rest} {}
  std::string_view take(std::uint64_t count) {
    if (count > rest_.size()) throw CorruptFile("cut short");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  template <class Number>
  Number number() {
    Number value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  /// Takes a hash, and asks whether it is that of `bytes`.
  bool has_hash_of(std::string_view bytes) {
    Hash hash;
    hash.add(bytes);
    return take(hash_text_bytes) == hash.text();
  }

 private:
  std::string_view rest_;
};

bool reads_back(int descriptor, std::string_view rest) {
  char block[65536];
  for (off_t at = 0; !rest.empty();) {
    const ssize_t count = pread(descriptor, block, std::min(sizeof block, rest.size()), at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0 || rest.substr(0, static_cast<std::size_t>(count)) !=
                          std::string_view(block, static_cast<std::size_t>(count)))
      return false;
    rest.remove_prefix(static_cast<std::size_t>(count));
    at += count;
  }
  return true;
}

}  // namespace

std::string seal(const std::string& kind, std::uint32_t format,
                 const std::vector<Section>& sections) {
  std::string out = padded(kind);
  put(out, format);
  put(out, static_cast<std::uint32_t>(sections.size()));
  for (const Section& section : sections) {
    put(out, static_cast<std::uint64_t>(section.name.size()));
    put(out, static_cast<std::uint64_t>(section.bytes.size()));
    out += section.name;
    out += section.bytes;
    put_hashed(out, section.bytes);
  }
  put_hashed(out, out);
  return out;
}

std::vector<Section> unseal(const std::string& kind, std::uint32_t format,
                            const std::string& bytes) {
  Cursor cursor(bytes);
  if (cursor.take(kind_bytes) != padded(kind)) throw CorruptFile(fmt::format("no {}", kind));
  if (const auto found = cursor.number<std::uint32_t>(); found != format)
    throw CorruptFile(fmt::format("of format {}, and this program writes {}", found, format));
  std::vector<Section> sections;
  const auto count = cursor.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto name_size = cursor.number<std::uint64_t>(), size = cursor.number<std::uint64_t>();
    Section section;
    section.name = cursor.take(name_size);
    section.bytes = cursor.take(size);
    if (!cursor.has_hash_of(section.bytes))
      throw CorruptFile(fmt::format("damaged in its section '{}'", section.name.substr(0, 40)));
    sections.push_back(std::move(section));
  }
  const std::size_t hashed = bytes.size() - std::min(bytes.size(), hash_text_bytes);
  if (!cursor.has_hash_of(std::string_view(bytes).substr(0, hashed))) throw CorruptFile("damaged");
  return sections;
}

void write_sealed(const std::filesystem::path& path, const std::string& bytes,
                  const std::filesystem::path& previous) {
  PartialFile file(path);
  file.write(bytes);
  file.sync();
  if (!reads_back(file.descriptor(), bytes))
    throw write_failure("write", path, "what was written does not read back", EIO);
  if (!previous.empty() && rename(path.c_str(), previous.c_str()) != 0 && errno != ENOENT)
    throw write_failure("keep", path, std::strerror(errno), errno);
  file.publish();
}

std::string read_whole(const std::filesystem::path& path, std::size_t most) {
  const InputFile file(path);
  if (file.size() > most) throw file.unreadable("it is too large");
  return file.beginning(most);
}

}  // namespace ra2d
