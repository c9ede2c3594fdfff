// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/seal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "host/base/hash.hpp"
#include "host/system/asked_child.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr std::string_view seal_begins = "ra2d seal ";
constexpr std::string_view hdf5_begins = "\x89HDF\r\n\x1a\n";
constexpr std::size_t bytes_at_once =
    1 << 18;  // which the cache near the processor keeps until they are hashed

std::string seal_line(std::uint64_t size, const Hash& hash) {
  return fmt::format("{}1 {:018} {}\n", seal_begins, size, hash.text());
}

struct stat status_of(int descriptor) {
  struct stat status;
  if (fstat(descriptor, &status) != 0) throw Unreadable(std::strerror(errno));
  return status;
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

/// The first so many bytes of a file, hashed; none where it has fewer.
std::optional<Hash> hash_of(int descriptor, std::uint64_t size) {
  Hash hash;
  std::string block(bytes_at_once, '\0');
  for (std::uint64_t done = 0; done < size;) {
    const auto now = static_cast<std::size_t>(std::min<std::uint64_t>(bytes_at_once, size - done));
    const std::string_view part = read_part(descriptor, block.data(), now, done);
    if (part.size() < now) return std::nullopt;
    hash.add(part);
    done += now;
  }
  return hash;
}

enum class Fit { fits, no_seal, differs };

Fit fit_of(int descriptor) {
  const auto size = static_cast<std::uint64_t>(status_of(descriptor).st_size);
  if (size < seal_size) return Fit::no_seal;
  std::array<char, seal_size> line;
  const std::uint64_t before = size - seal_size;
  if (!read_part(descriptor, line.data(), line.size(), before).starts_with(seal_begins))
    return Fit::no_seal;
  const std::optional<Hash> hash = hash_of(descriptor, before);
  return hash && std::string_view(line.data(), line.size()) == seal_line(before, *hash)
             ? Fit::fits
             : Fit::differs;
}

/// What tells a file from all others, and from itself once its bytes were changed.
using Mark = std::array<std::int64_t, 5>;

Mark mark_of(const struct stat& s) {
  return {static_cast<std::int64_t>(s.st_dev), static_cast<std::int64_t>(s.st_ino), s.st_size,
          s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
}

/// The clock of a file system ticks slowly: what was written within the same tick shows no change.
bool is_settled(const struct stat& s) {
  constexpr double tick = 0.05;  // s
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<double>(now.tv_sec - s.st_ctim.tv_sec) +
             1e-9 * static_cast<double>(now.tv_nsec - s.st_ctim.tv_nsec) >
         tick;
}

void require_fit(int descriptor) {
  static std::mutex mutex;
  // files that fit, with the time of their last change of any kind: nobody can set that one back
  static std::set<std::pair<Mark, std::pair<time_t, long>>> known;
  const struct stat before = status_of(descriptor);
  const bool settled = is_settled(before);
  const std::pair look{mark_of(before), std::pair{before.st_ctim.tv_sec, before.st_ctim.tv_nsec}};
  if (settled) {
    const std::lock_guard lock(mutex);
    if (known.contains(look)) return;
  }
  switch (fit_of(descriptor)) {
    case Fit::no_seal: {
      std::array<char, hdf5_begins.size()> begin;
      if (read_part(descriptor, begin.data(), begin.size(), 0) != hdf5_begins)
        throw Unreadable("it is no HDF5 file: expected one that ra2d wrote");
      throw Unsealed(
          "it has no seal at its end: it was cut short, or another program (h5py, h5repack, an "
          "editor) has changed it since ra2d wrote it, or an older ra2d wrote it");
    }
    case Fit::differs:
      throw Unsealed("it is damaged: its bytes are not those that ra2d sealed");
    case Fit::fits:
      break;
  }
  if (mark_of(status_of(descriptor)) != mark_of(before))
    throw Unsealed("it is being changed while it is read");
  if (!settled) return;
  const std::lock_guard lock(mutex);
  known.insert(look);
}

}  // namespace

std::string seal_of(std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  return seal_line(bytes.size(), hash);
}

int append_seal(int descriptor) try {
  const auto size = static_cast<std::uint64_t>(status_of(descriptor).st_size);
  const std::optional<Hash> hash = hash_of(descriptor, size);
  if (!hash) return EIO;
  const std::string line = seal_line(size, *hash);
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t count =
        pwrite(descriptor, line.data() + done, line.size() - done, static_cast<off_t>(size + done));
    if (count < 0 && errno != EINTR) return errno;
    done += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  return 0;
} catch (const Unreadable&) {
  return errno;
}

bool has_fitting_seal(int descriptor) try {
  return fit_of(descriptor) == Fit::fits;
} catch (const Unreadable&) {
  return false;
}

bool looks_like_hdf5(const std::filesystem::path& file) {
  const InputFile input(file);
  std::array<char, seal_size> part;
  if (read_part(input.descriptor(), part.data(), part.size(), 0).starts_with(hdf5_begins))
    return true;
  return input.size() >= seal_size &&
         read_part(input.descriptor(), part.data(), part.size(), input.size() - seal_size)
             .starts_with(seal_begins);
}

bool is_damaged_with(const std::filesystem::path& file, const char* attribute) {
  const InputFile input(file);
  if (!looks_like_hdf5(file) || has_fitting_seal(input.descriptor())) return false;
  if (input.beginning(hdf5_begins.size()) != hdf5_begins) return true;  // it had a seal
  constexpr double memory = 256e6, seconds = 5;                         // bytes, s
  const ChildAnswer answer = ask_in_child(
      [&] {
        const h5::Properties how = h5::file_access();
        const h5::File opened{H5Fopen(file.c_str(), H5F_ACC_RDONLY, how)};
        return std::string(opened.is_open() && H5Aexists(opened, attribute) <= 0 ? "foreign" : "");
      },
      memory, seconds);
  return answer.text != "foreign";
}

void require_seal(const std::filesystem::path& file) { require_fit(InputFile(file).descriptor()); }

h5::File open_sealed(const std::filesystem::path& file) {
  const InputFile input(file);
  require_fit(input.descriptor());
  // HDF5 opens by names alone. It may not come to another file than the one that was looked at.
  std::string name = fmt::format("/proc/self/fd/{}", input.descriptor());
  if (access(name.c_str(), R_OK) != 0) name = file.string();
  const h5::Properties how = h5::file_access();
  h5::File opened{h5::check(H5Fopen(name.c_str(), H5F_ACC_RDONLY, how))};
  void* handle = nullptr;
  h5::check(H5Fget_vfd_handle(opened, H5P_DEFAULT, &handle));
  if (mark_of(status_of(*static_cast<int*>(handle))) != mark_of(status_of(input.descriptor())))
    throw Unsealed("another file took its place while it was read");
  return opened;
}

}  // namespace ra2d
