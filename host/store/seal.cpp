// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/seal.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>

#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr std::string_view seal_begins = "ra2d seal ";
constexpr std::string_view hdf5_begins = "\x89HDF\r\n\x1a\n";
// read at once: whole blocks that stay in the processor's cache until they are hashed
constexpr std::size_t bytes_at_once = 64 * sealed_block;

enum class SealFormat { whole = 1, blocks = 2 };  // whole: one hash of all bytes, by older programs

std::string seal_line(SealFormat format, std::uint64_t size, const Digest& digest) {
  return fmt::format("{}{} {:018} {}\n", seal_begins, static_cast<int>(format), size,
                     hexadecimal(digest));
}

std::uint64_t size_of(int descriptor) {
  struct stat status;
  if (fstat(descriptor, &status) != 0) throw Unreadable(std::strerror(errno));
  return static_cast<std::uint64_t>(status.st_size);
}

/// `size` bytes from `at` on, fewer where the file ends before. Throws Unreadable.
std::string_view read_part(int descriptor, char* to, std::size_t size, std::uint64_t at) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = pread(descriptor, to + done, size - done, static_cast<off_t>(at + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw Unreadable(std::strerror(errno));
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return {to, done};
}

void append_digest(std::string& table, std::string_view block) {
  const Digest digest = digest_of(block);
  table.append(digest.data(), digest.size());
}

void append_digests(std::string& table, std::string_view bytes) {
  for (; !bytes.empty(); bytes.remove_prefix(std::min(sealed_block, bytes.size())))
    append_digest(table, bytes.substr(0, sealed_block));
}

std::string seal_with(const std::string& table, std::uint64_t size) {
  return table + seal_line(SealFormat::blocks, size, digest_of(table));
}

/// The first bytes of a file, and what is made of them.
struct HashedBytes {
  std::string table;  // a Digest each block
  Hash whole;
};

/// None where the file has fewer bytes.
std::optional<HashedBytes> hash_bytes(int descriptor, std::uint64_t size, bool also_whole) {
  HashedBytes found;
  std::string part(bytes_at_once, '\0');
  for (std::uint64_t done = 0; done < size; done += bytes_at_once) {
    const auto now = static_cast<std::size_t>(std::min<std::uint64_t>(bytes_at_once, size - done));
    const std::string_view bytes = read_part(descriptor, part.data(), now, done);
    if (bytes.size() < now) return std::nullopt;
    append_digests(found.table, bytes);
    if (also_whole) found.whole.add(bytes);
  }
  return found;
}

/// Throws Unreadable where it is no HDF5 file at all.
Unsealed without_seal(int descriptor) {
  std::array<char, hdf5_begins.size()> begin;
  if (read_part(descriptor, begin.data(), begin.size(), 0) != hdf5_begins)
    throw Unreadable("it is no HDF5 file: expected one that ra2d wrote");
  return Unsealed(
      "it has no seal at its end: it was cut short, or another program (h5py, h5repack, an "
      "editor) has changed it since ra2d wrote it, or an older ra2d wrote it");
}

/// The number of sealed bytes that a line states; none where it is no number.
std::optional<std::uint64_t> stated_size(std::string_view line) {
  constexpr std::size_t at = seal_begins.size() + 2, digits = 18;
  if (line.size() != seal_line_size) return std::nullopt;
  std::uint64_t size = 0;
  const char* const end = line.data() + at + digits;
  const auto [stop, error] = std::from_chars(line.data() + at, end, size);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return size;
}

}  // namespace

std::string seal_of(std::string_view bytes) {
  std::string table;
  append_digests(table, bytes);
  return seal_with(table, bytes.size());
}

int append_seal(int descriptor) try {
  const std::uint64_t size = size_of(descriptor);
  const std::optional<HashedBytes> hashed = hash_bytes(descriptor, size, false);
  if (!hashed) return EIO;
  const std::string seal = seal_with(hashed->table, size);
  for (std::size_t done = 0; done < seal.size();) {
    const ssize_t count =
        pwrite(descriptor, seal.data() + done, seal.size() - done, static_cast<off_t>(size + done));
    if (count < 0 && errno != EINTR) return errno;
    done += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  return 0;
} catch (const Unreadable&) {
  return errno;
}

bool has_fitting_seal(int descriptor) try {
  SealedBytes(descriptor).check_rest();
  return true;
} catch (const Unreadable&) {
  return false;
}

// ---- reading ------------------------------------------------------------------------------------

SealedBytes::SealedBytes(int descriptor) : descriptor_{descriptor} {
  const std::uint64_t file_size = size_of(descriptor);
  if (file_size < seal_line_size) throw without_seal(descriptor);
  std::array<char, seal_line_size> text;
  const std::string_view line =
      read_part(descriptor, text.data(), text.size(), file_size - seal_line_size);
  if (!line.starts_with(seal_begins)) throw without_seal(descriptor);
  const std::uint64_t before = file_size - seal_line_size;  // bytes
  const std::optional<std::uint64_t> stated = stated_size(line);
  if (!stated || *stated > before) throw Unsealed(damaged_text);
  size_ = *stated;
  std::string expected;
  if (line[seal_begins.size()] == '1' && size_ == before) {
    if (std::optional<HashedBytes> hashed = hash_bytes(descriptor, size_, true)) {
      expected = seal_line(SealFormat::whole, size_, hashed->whole.digest());
      table_ = std::move(hashed->table);
    }
  } else {
    const std::uint64_t table_size = (size_ + sealed_block - 1) / sealed_block * sizeof(Digest);
    if (table_size != before - size_) throw Unsealed(damaged_text);
    table_.resize(table_size);
    if (read_part(descriptor, table_.data(), table_.size(), size_).size() == table_.size())
      expected = seal_line(SealFormat::blocks, size_, digest_of(table_));
  }
  if (line != expected) throw Unsealed(damaged_text);
  checked_.resize(table_.size() / sizeof(Digest));
}

/// Reads whole blocks, or up to the end, and compares them with the table.
void SealedBytes::read_blocks(std::uint64_t at, char* to, std::size_t count) {
  std::string_view bytes = read_part(descriptor_, to, count, at);
  if (bytes.size() < count) throw Unsealed(damaged_text);  // it was cut short meanwhile
  std::size_t number = at / sealed_block;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(sealed_block, bytes.size()))) {
    const Digest found = digest_of(bytes.substr(0, sealed_block));
    if (std::memcmp(table_.data() + number * sizeof(Digest), found.data(), found.size()) != 0)
      throw Unsealed(damaged_text);
    checked_[number++] = true;
  }
}

void SealedBytes::read(std::uint64_t at, char* to, std::size_t count) {
  if (at > size_ || count > size_ - at) throw Unreadable("there is nothing behind its end");
  const std::uint64_t end = at + count;
  // where the last whole block ends
  const std::uint64_t whole_end = end == size_ ? end : end - end % sealed_block;
  while (at < end) {
    const std::size_t skipped = at % sealed_block;
    std::uint64_t taken = 0;
    if (skipped == 0 && at < whole_end) {
      taken = std::min<std::uint64_t>(whole_end - at, bytes_at_once);
      read_blocks(at, to, taken);
    } else {
      const std::uint64_t number = at / sealed_block, first = number * sealed_block;
      const auto length =
          static_cast<std::size_t>(std::min<std::uint64_t>(sealed_block, size_ - first));
      if (held_ != number) {
        held_ = no_block;
        read_blocks(first, block_.data(), length);
        held_ = number;
      }
      taken = std::min<std::uint64_t>(end - at, length - skipped);
      std::memcpy(to, block_.data() + skipped, taken);
    }
    at += taken;
    to += taken;
  }
}

void SealedBytes::check_rest() {
  std::string part(bytes_at_once, '\0');
  const auto next = [&](std::size_t from, bool checked) {
    return static_cast<std::size_t>(
        std::find(checked_.begin() + static_cast<std::ptrdiff_t>(from), checked_.end(), checked) -
        checked_.begin());
  };
  for (std::size_t first = 0; (first = next(first, false)) < checked_.size();) {
    const std::uint64_t at = first * sealed_block;
    const std::uint64_t left =
        std::min<std::uint64_t>(next(first, true) * sealed_block, size_) - at;
    read_blocks(at, part.data(),
                static_cast<std::size_t>(std::min<std::uint64_t>(left, part.size())));
  }
}

bool looks_like_hdf5(const std::filesystem::path& file) {
  const InputFile input(file);
  std::array<char, seal_line_size> part;
  if (read_part(input.descriptor(), part.data(), part.size(), 0).starts_with(hdf5_begins))
    return true;
  return input.size() >= seal_line_size &&
         read_part(input.descriptor(), part.data(), part.size(), input.size() - seal_line_size)
             .starts_with(seal_begins);
}

void require_seal(const std::filesystem::path& file) {
  const InputFile input(file);
  SealedBytes(input.descriptor()).check_rest();
}

}  // namespace ra2d
