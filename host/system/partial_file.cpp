// SPDX-License-Identifier: BSD-3-Clause
#include "host/system/partial_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/system/output_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

// ---- what a signal handler finds ---------------------------------------------------------------

/// One path in fixed storage, of a file or of a folder. `owner`: 0, nobody's; -1, being filled;
/// else the process, since a fork copies this but not what it stands for.
struct Place {
  std::atomic<pid_t> owner{0};
  bool is_folder;
  char path[PATH_MAX];
};
constexpr std::size_t most_places = 64, nowhere = most_places;
constinit std::array<Place, most_places> places{};
static_assert(std::atomic<pid_t>::is_always_lock_free, "a signal handler reads it");

std::size_t take_place(const char* path, bool is_folder) {
  for (std::size_t i = 0; i < most_places; ++i) {
    pid_t nobody = 0;
    if (std::strlen(path) >= PATH_MAX || !places[i].owner.compare_exchange_strong(nobody, -1))
      continue;
    std::strcpy(places[i].path, path);
    places[i].is_folder = is_folder;
    places[i].owner.store(getpid(), std::memory_order_release);
    return i;
  }
  return nowhere;
}

void leave_place(std::size_t place) noexcept {
  if (place < most_places) places[place].owner = 0;
}

// ---- names and locks ---------------------------------------------------------------------------

std::string host_name() {
  char name[HOST_NAME_MAX + 1] = "";
  gethostname(name, sizeof name - 1);
  std::string host = *name != '\0' ? name : "localhost";
  std::replace(host.begin(), host.end(), '/', '_');
  return host;
}

/// ".NAME.partial-HOST-PID", with a number behind it from the second attempt on; of a long NAME the
/// beginning.
std::string partial_name(const std::string& name, const std::string& host, int attempt,
                         std::size_t longest) {
  std::string tail = fmt::format(".partial-{}-{}", host, getpid());
  if (attempt > 0) tail += fmt::format(".{}", attempt);
  std::size_t kept = std::min(name.size(), longest - std::min(longest, tail.size() + 1));
  while (kept > 0 && kept < name.size() && (name[kept] & 0xC0) == 0x80)
    --kept;  // within a character
  return fmt::format(".{}{}", std::string_view(name).substr(0, kept), tail);
}

/// Whether a file of this name is one that a process of `host` writes.
bool is_partial(const std::string& name, const std::string& host) {
  const std::string mark = ".partial-" + host + "-";
  const std::size_t at = name.rfind(mark);
  if (name[0] != '.' || at == std::string::npos) return false;
  const std::string_view number = std::string_view(name).substr(at + mark.size());
  // another host's name may begin like this one's and go on with '-'
  return !number.empty() && number.find_first_not_of("0123456789.") == number.npos;
}

/// 0, or why not. Locks of this kind belong to the open file, not to the process, and HDF5's own
/// (flock), where a user asks for them, do not meet them.
int lock(int descriptor) {
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  return fcntl(descriptor, F_OFD_SETLK, &whole) == 0 ? 0 : errno;
}

/// stands_at, where it is enough not to know.
bool has_name(int descriptor, const fs::path& path) noexcept {
  try {
    return stands_at(descriptor, path);
  } catch (const FileError&) {
    return false;
  }
}

/// Removes the partial files in a folder whose processes are gone: whose lock can be had.
void remove_leftovers(const fs::path& folder, const std::string& host) {
  int removed = 0;
  double bytes = 0;
  std::error_code none;
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end;
       entry.increment(none)) {
    const fs::path& path = entry->path();
    if (!is_partial(path.filename().string(), host)) continue;
    const int descriptor = open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) continue;
    struct stat status;
    if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && lock(descriptor) == 0 &&
        has_name(descriptor, path) && unlink(path.c_str()) == 0 &&
        status.st_size > 0) {  // an empty one may be new: its process makes it again
      ++removed;
      bytes += 512.0 * static_cast<double>(status.st_blocks);
    }
    close(descriptor);
  }
  if (removed > 0)  // a message that cannot be printed is no failure
    std::fputs(fmt::format("ra2d: removed {} partial file{} ({:.1f} MB) that killed runs had left "
                           "beside the output\n",
                           removed, removed == 1 ? "" : "s", bytes * 1e-6)
                   .c_str(),
               stderr);
}

constexpr int most_attempts = 1000;  // to find a name

std::string cure(int error, const std::string& smaller, const char* option) {
  const std::string or_smaller = smaller.empty() ? "" : ", or " + smaller;
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return fmt::format("Free some space, write to another disk with {}{}", option, or_smaller);
    case EFBIG:
      return "Raise the limit on file sizes (ulimit -f)" + or_smaller;
    case EACCES:
    case EPERM:
    case EROFS:
      return fmt::format("Choose a folder that you may write to with {}", option);
    case ENOENT:
    case ENOTDIR:
      return fmt::format("Create the folder first, or choose another with {}", option);
    case ENAMETOOLONG:
      return fmt::format("Choose a shorter name with {}", option);
    default:
      return fmt::format("Check that disk, or write to another with {}", option);
  }
}

}  // namespace

bool is_partial_name(const fs::path& file) {
  const std::string name = file.filename().string();
  return !name.empty() && is_partial(name, host_name());
}

bool stands_at(int descriptor, const fs::path& path) {
  struct stat opened, named;
  if (fstat(descriptor, &opened) != 0)
    throw write_failure("create", path, std::strerror(errno), errno);
  if (lstat(path.c_str(), &named) != 0) return false;
  // Some file systems give another inode number each time. A process that removes it takes its last
  // link away.
  return (opened.st_dev == named.st_dev && opened.st_ino == named.st_ino) || opened.st_nlink > 0;
}

void sync_folder_of(const fs::path& file) {
  const int descriptor = open(folder_of(file).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  int error = descriptor < 0 || fsync(descriptor) != 0 ? errno : 0;
  if (descriptor >= 0) close(descriptor);
  if (error == EINVAL || error == ENOTSUP || error == EACCES) error = 0;
  if (error != 0)
    throw FileError(fmt::format(
        "'{}' is written and whole, but its folder could not be brought to the disk: {}. "
        "After a power cut it may be missing",
        file.string(), std::strerror(error)));
}

void drop_partials() noexcept {
  const int error = errno;
  for (const Place& place : places)
    if (place.owner.load(std::memory_order_acquire) == getpid())
      (place.is_folder ? rmdir : unlink)(place.path);
  errno = error;
}

PartialFolder::PartialFolder(const fs::path& folder) : place_{take_place(folder.c_str(), true)} {}
PartialFolder::~PartialFolder() { leave_place(place_); }

FileError write_failure(const std::string& doing, const fs::path& file, const std::string& reason,
                        int error, const std::string& smaller, const char* option) {
  return FileError(fmt::format("cannot {} '{}': {}. {}", doing, file.string(), reason,
                               cure(error, smaller, option)));
}

PartialFile::PartialFile(const fs::path& target, const char* option)
    : target_{replaced_file(target, option)}, option_{option}, place_{nowhere} {
  const auto fail = [&](int error) {
    drop();
    throw failure("create", target_, error);
  };
  const fs::path folder = folder_of(target_);
  const std::string host = host_name(), name = target_.filename().string();
  const long limit = pathconf(folder.c_str(), _PC_NAME_MAX);
  const std::size_t longest = limit > 0 ? static_cast<std::size_t>(limit) : NAME_MAX;
  if (name.size() > longest) fail(ENAMETOOLONG);  // not only at the end
  remove_leftovers(folder, host);
  std::error_code none;
  // Process numbers come back, a process may write several files of one name, and somebody who
  // cleans up may come between the making and the lock: hence more than one attempt.
  for (int attempt = 0; descriptor_ < 0; ++attempt) {
    if (attempt == most_attempts)
      throw FileError(
          fmt::format("cannot create '{}': its folder has {} files like '{}' already, or takes "
                      "away what is made "
                      "there. Remove them, or choose another folder with {}",
                      target_.string(), most_attempts, path_.filename().string(), option_));
    path_ = target_;
    path_.replace_filename(partial_name(name, host, attempt, longest));
    if (fs::exists(fs::symlink_status(path_, none))) continue;  // not ours to remove
    // before the file: a signal may come as soon as it is there
    place_ = take_place(path_.c_str(), false);
    descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
      const int error = errno;
      leave_place(std::exchange(place_, nowhere));
      if (error != EEXIST) fail(error);
      continue;
    }
    try {
      const int held = lock(descriptor_);  // without locks no process cleans up either
      if (held == EAGAIN || held == EACCES || !stands_at(descriptor_, path_)) drop();
    } catch (const FileError&) {
      unlink(path_.c_str());  // it was made just now, under a name of this process
      drop();
      throw;
    }
  }
}

FileError PartialFile::failure(const char* doing, const fs::path& file, int error) const {
  return write_failure(doing, file, std::strerror(error), error, {}, option_);
}

void PartialFile::begin_sync() const noexcept {
  sync_file_range(descriptor_, 0, 0, SYNC_FILE_RANGE_WRITE);
}

void PartialFile::sync() {
  struct stat status;
  // The same size again gives back what was set aside beyond it.
  if (fstat(descriptor_, &status) != 0 || ftruncate(descriptor_, status.st_size) != 0 ||
      fsync(descriptor_) != 0)
    throw failure("finish", target_, errno);
  posix_fadvise(descriptor_, 0, 0, POSIX_FADV_DONTNEED);
}

void PartialFile::publish(const fs::path& name) {
  if (rename(path_.c_str(), name.c_str()) != 0) throw failure("finish", name, errno);
  leave_place(std::exchange(place_, nowhere));
  close(std::exchange(descriptor_, -1));  // synced: it has nothing more to say
  sync_folder_of(name);
}

void PartialFile::drop() noexcept {
  if (descriptor_ < 0) return;
  if (has_name(descriptor_, path_)) unlink(path_.c_str());
  leave_place(std::exchange(place_, nowhere));
  close(std::exchange(descriptor_, -1));
}

void PartialFile::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor_, text.data(), text.size());
    const int error = count == 0 ? EIO : errno;
    if (count > 0)
      text.remove_prefix(static_cast<std::size_t>(count));
    else if (error != EINTR)
      throw failure("write", target_, error);
  }
}

void write_text(const fs::path& path, const std::string& text, const char* option) {
  PartialFile file(path, option);
  file.write(text);
  file.sync();
  file.publish();
}

}  // namespace ra2d
