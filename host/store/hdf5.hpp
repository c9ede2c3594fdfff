// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <hdf5.h>
#include <hdf5_hl.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

/// What the result file needs around the HDF5 C API: handles that close themselves, failures with
/// the reason that HDF5 or the system gives. What was written may reach the file with the close of
/// its handle alone: there, close() is asked whether it succeeded (h5::close). Destructors are for
/// what was only read, for handles in memory, and for what failed before.
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

/// The deepest entry on HDF5's error stack; one that carries an errno is preferred.
inline Failure hdf5_failure() {
  const auto collect = [](unsigned, const H5E_error2_t* entry, void* data) -> herr_t {
    auto& failure = *static_cast<Failure*>(data);
    const std::string_view text = entry->desc ? entry->desc : "";
    constexpr std::string_view number = "errno = ";
    if (const auto at = text.find(number); failure.error == 0 && at != text.npos) {
      failure.error = std::atoi(text.data() + at + number.size());
      failure.reason = std::strerror(failure.error);
    } else if (failure.reason.empty()) {
      failure.reason = text;
    }
    return 0;
  };
  Failure failure;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, collect, &failure);
  if (failure.reason.empty()) failure.reason = "HDF5 gives no reason";
  return failure;
}

/// Passes a result of HDF5 on, or throws Failure when it is negative.
template <class Result>
Result check(Result result) {
  if (result < 0) throw hdf5_failure();
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

/// Properties for the creation of files, groups or datasets (H5P_FILE_CREATE, ...) whose parts are
/// listed in the order in which they were made.
Properties ordered(hid_t kind);

}  // namespace ra2d::h5
