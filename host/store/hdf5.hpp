// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <hdf5.h>
#include <hdf5_hl.h>

#include <cstring>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

/// The HDF5 C API with handles that close themselves and failures that have a reason. Data that was
/// written may reach the file only when its handle is closed: close those with h5::close, which
/// throws where that fails. The destructor is for handles that were only read, that are in memory,
/// or whose writing has failed before.
namespace ra2d::h5 {

/// Owns one HDF5 identifier.
template <herr_t (*Close)(hid_t)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_{id} {}
  Handle(Handle&& other) noexcept : id_{std::exchange(other.id_, H5I_INVALID_HID)} {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle() { close(); }

  operator hid_t() const { return id_; }
  bool is_open() const { return id_ >= 0; }
  /// Gives the identifier up; negative when HDF5 could not close it.
  herr_t close() { return is_open() ? Close(std::exchange(id_, H5I_INVALID_HID)) : 0; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

using File = Handle<H5Fclose>;
using Object = Handle<H5Oclose>;
using Group = Handle<H5Gclose>;
using Dataset = Handle<H5Dclose>;
using Space = Handle<H5Sclose>;
using Type = Handle<H5Tclose>;
using Attribute = Handle<H5Aclose>;
using Properties = Handle<H5Pclose>;

/// One call that did not succeed.
struct Failure {
  std::string reason;
  int error = 0;  // errno, 0 where HDF5 knows none
};

inline Failure system_failure(int error) { return {std::strerror(error), error}; }

/// Throws what the last call of HDF5 failed for: Unsealed where it needed a damaged byte of a
/// sealed file, else Failure. Of the entries on HDF5's error stack it takes the deepest, or the one
/// with an errno.
[[noreturn]] void throw_failure();

/// Throws Unsealed where the last call of HDF5, which failed, needed a damaged byte.
void require_undamaged();

/// Passes a result of HDF5 on, or calls throw_failure() when it is negative.
template <class Result>
Result check(Result result) {
  if (result < 0) throw_failure();
  return result;
}

/// Closes a handle, or throws Failure.
template <herr_t (*Close)(hid_t)>
void close(Handle<Close>& handle) {
  check(handle.close());
}

/// Takes the library, which need not be built thread safe: a program may write several files at
/// once. Whoever calls it holds this.
std::unique_lock<std::mutex> take_library();

/// How files are opened, to be written and to be read back.
Properties file_access();

/// Whether the numbers of a dataset stand in other files, of which no seal says anything.
bool is_elsewhere(hid_t dataset);

/// Whether `room` bytes of a file can hold so many numbers of a dataset. Takes theirs from it.
/// Throws Failure.
bool takes_room(hid_t dataset, double numbers, double& room);

/// Properties for the creation of files, groups or datasets (H5P_FILE_CREATE, ...) whose parts are
/// listed in the order in which they were made.
Properties ordered(hid_t kind);

}  // namespace ra2d::h5
