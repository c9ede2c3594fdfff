// SPDX-License-Identifier: BSD-3-Clause
// Makes calls fail that write to one folder, as a faulty or a full disk does. LD_PRELOAD this, with in the
// environment
//   FAULTY_FOLDER        the folder, an absolute path without links
//   FAULTY_CALL          the call that fails: 1, 2, ...; without it none by its number
//   FAULTY_FROM_THEN_ON  if set, all calls after that one, too
//   FAULTY_ERROR         the errno that they fail with; or
//   FAULTY_SHORT         the same, but a write writes half of what it is given, as it may; or
//   FAULTY_KILL          if set, the process is killed at that call, before it does anything
//   FAULTY_TERM_AT       1, 2, ...: as soon as so many files and folders are made, SIGTERM comes
//   FAULTY_TOLD          a file elsewhere that is made when a call has failed
//   FAULTY_ROOM          bytes: a file has no room beyond (ENOSPC)
//   FAULTY_FSTAT         the errno that every fstat of a file fails with
//   FAULTY_INODES        if set, each call tells another number of an inode, of whatever file
//   FAULTY_USR1_FIRST    if set, SIGUSR1 comes before the program begins
//   FAULTY_DURABLE       a folder elsewhere on the same disk that is told what a power cut would leave: for each file
//                        that was synced INODE, its content then, and for each folder LIST-INODE, a line for each
//                        entry then: d or f, its inode, its name
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static atomic_long calls;

static int in_folder(const char* path) {
  const char* folder = getenv("FAULTY_FOLDER");
  if (folder == NULL) return 0;
  const size_t length = strlen(folder);
  return strncmp(path, folder, length) == 0 && (path[length] == '\0' || path[length] == '/');
}

static int concerns(int file) {
  char link[64], path[PATH_MAX];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = '\0';
  return in_folder(path);
}

/// Whether it is this call's turn.
static int fails(void) {
  const char* call = getenv("FAULTY_CALL");
  if (call == NULL) return 0;
  const long turn = atol(call), now = ++calls;
  if (now < turn || (now > turn && getenv("FAULTY_FROM_THEN_ON") == NULL)) return 0;
  const long told = syscall(SYS_openat, AT_FDCWD, getenv("FAULTY_TOLD"), O_WRONLY | O_CREAT, 0600);
  if (told >= 0) syscall(SYS_close, told);
  if (getenv("FAULTY_KILL") != NULL) kill(getpid(), SIGKILL);
  const char* error = getenv("FAULTY_ERROR");
  errno = atoi(error != NULL ? error : getenv("FAULTY_SHORT"));
  return 1;
}

/// Of a call that writes and whose turn it is: whether it writes half.
static int half(size_t count) { return getenv("FAULTY_SHORT") != NULL && count > 1; }

/// After a file or folder is made.
static void told_to_end(void) {
  static atomic_long made;
  const char* at = getenv("FAULTY_TERM_AT");
  if (at != NULL && ++made == atol(at)) raise(SIGTERM);
}

static int beyond_room(off_t end) {
  const char* room = getenv("FAULTY_ROOM");
  if (room == NULL || end <= atol(room)) return 0;
  errno = ENOSPC;
  return 1;
}

#define REAL(name)                                                   \
  static __typeof__(&name) real;                                     \
  if (real == NULL) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

#define OPENS(name)                                                         \
  int name(const char* path, int flags, ...) {                              \
    REAL(name);                                                             \
    va_list more;                                                           \
    va_start(more, flags);                                                  \
    const int mode = flags & O_CREAT ? va_arg(more, int) : 0;               \
    va_end(more);                                                           \
    const int file = real(path, flags, mode);                               \
    if (file >= 0 && flags & O_CREAT && in_folder(path)) told_to_end();     \
    return file;                                                            \
  }
OPENS(open)
OPENS(open64)
int mkdir(const char* path, mode_t mode) {
  REAL(mkdir);
  const int result = real(path, mode);
  if (result == 0 && in_folder(path)) told_to_end();
  return result;
}
ssize_t write(int file, const void* data, size_t count) {
  REAL(write);
  if (concerns(file)) {
    if (fails()) return half(count) ? real(file, data, count / 2) : -1;
    if (beyond_room(lseek(file, 0, SEEK_CUR) + (off_t)count)) return -1;
  }
  return real(file, data, count);
}
ssize_t pwrite(int file, const void* data, size_t count, off_t at) {
  REAL(pwrite);
  if (concerns(file)) {
    if (fails()) return half(count) ? real(file, data, count / 2, at) : -1;
    if (beyond_room(at + (off_t)count)) return -1;
  }
  return real(file, data, count, at);
}
ssize_t pwrite64(int file, const void* data, size_t count, off64_t at) {
  REAL(pwrite64);
  if (concerns(file)) {
    if (fails()) return half(count) ? real(file, data, count / 2, at) : -1;
    if (beyond_room(at + (off_t)count)) return -1;
  }
  return real(file, data, count, at);
}
int fallocate(int file, int mode, off_t from, off_t length) {
  REAL(fallocate);
  if (concerns(file) && (fails() || beyond_room(from + length))) return -1;
  return real(file, mode, from, length);
}
int fallocate64(int file, int mode, off64_t from, off64_t length) {
  REAL(fallocate64);
  if (concerns(file) && (fails() || beyond_room(from + length))) return -1;
  return real(file, mode, from, length);
}
int ftruncate(int file, off_t length) {
  REAL(ftruncate);
  if (concerns(file) && fails()) return -1;
  return real(file, length);
}
int ftruncate64(int file, off64_t length) {
  REAL(ftruncate64);
  if (concerns(file) && fails()) return -1;
  return real(file, length);
}

static void change_inode(struct stat* status) {
  static atomic_long calls_for_inodes;
  if (getenv("FAULTY_INODES") != NULL) status->st_ino += (ino_t)(7919 * ++calls_for_inodes);
}

int fstat(int file, struct stat* status) {
  REAL(fstat);
  const int result = real(file, status);
  const char* error = getenv("FAULTY_FSTAT");
  if (error != NULL && result == 0 && S_ISREG(status->st_mode) && concerns(file)) {
    errno = atoi(error);
    return -1;
  }
  if (result == 0) change_inode(status);
  return result;
}
int stat(const char* path, struct stat* status) {
  REAL(stat);
  const int result = real(path, status);
  if (result == 0) change_inode(status);
  return result;
}
int lstat(const char* path, struct stat* status) {
  REAL(lstat);
  const int result = real(path, status);
  if (result == 0) change_inode(status);
  return result;
}

__attribute__((constructor)) static void signal_first(void) {
  if (getenv("FAULTY_USR1_FIRST") != NULL) raise(SIGUSR1);
}

static void copy_content(int file, const char* to) {
  char block[65536];
  const int out = open(to, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  off_t at = 0;
  for (ssize_t count; (count = pread(file, block, sizeof block, at)) > 0; at += count)
    if (syscall(SYS_write, out, block, count) != count) abort();
  syscall(SYS_close, out);
}

static void list_entries(const char* folder, const char* to) {
  FILE* out = fopen(to, "w");
  DIR* entries = opendir(folder);
  for (struct dirent* entry; (entry = readdir(entries)) != NULL;)
    if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
      fprintf(out, "%c %lu %s\n", entry->d_type == DT_DIR ? 'd' : 'f', entry->d_ino, entry->d_name);
  closedir(entries);
  fclose(out);
}

/// Keeps what is on the disk now for good, whatever becomes of its name.
static void keep_durable(int file) {
  const char* durable = getenv("FAULTY_DURABLE");
  struct stat status;
  if (durable == NULL || !concerns(file) || fstat(file, &status) != 0) return;
  char link[64], to[PATH_MAX], pin[PATH_MAX];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  snprintf(to, sizeof to, "%s/%s%lu", durable, S_ISDIR(status.st_mode) ? "LIST-" : "", status.st_ino);
  if (S_ISDIR(status.st_mode)) return list_entries(link, to);
  snprintf(pin, sizeof pin, "%s/pin-%lu", durable, status.st_ino);  // so that its number stays its own
  linkat(AT_FDCWD, link, AT_FDCWD, pin, AT_SYMLINK_FOLLOW);
  copy_content(file, to);
}

int fsync(int file) {
  REAL(fsync);
  if (concerns(file) && fails()) return -1;
  const int result = real(file);
  if (result == 0) keep_durable(file);
  return result;
}
int fdatasync(int file) {
  REAL(fdatasync);
  if (concerns(file) && fails()) return -1;
  const int result = real(file);
  if (result == 0) keep_durable(file);
  return result;
}
int close(int file) {  // a file is closed even where that fails
  REAL(close);
  const int failing = concerns(file) && fails(), error = errno;
  const int result = real(file);
  if (!failing) return result;
  errno = error;
  return -1;
}
int rename(const char* from, const char* to) {
  REAL(rename);
  char path[PATH_MAX];
  if (realpath(from, path) != NULL && in_folder(path) && fails()) return -1;
  return real(from, to);
}
