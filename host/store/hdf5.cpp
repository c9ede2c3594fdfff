// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/hdf5.hpp"

#include <cstdlib>
#include <string_view>

#include "host/store/seal.hpp"

namespace ra2d::h5 {

namespace {

Failure last_failure() {
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

}  // namespace

void require_undamaged() {
  if (last_failure().reason == damaged_text) throw Unsealed(damaged_text);
}

void throw_failure() {
  require_undamaged();
  throw last_failure();
}

std::unique_lock<std::mutex> take_library() {
  static std::mutex mutex;
  std::unique_lock lock{mutex};
  // Before all other calls: a file that a failed flush has spoilt must not crash the program's
  // exit.
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
  // no seal covers what a link to another file leads to, and a pipe would never end
  [[maybe_unused]] static const herr_t no_links = H5Lunregister(H5L_TYPE_EXTERNAL);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its stack goes into our own messages
  return lock;
}

Properties file_access() {
  Properties access{check(H5Pcreate(H5P_FILE_ACCESS))};
  check(H5Pset_fapl_sec2(access));
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && H5_VERSION_LE(1, 10, 99))
  // The temporary name is ours alone, and locks fail on many network disks.
  check(H5Pset_file_locking(access, false, true));
#endif
  return access;
}

bool is_elsewhere(hid_t dataset) {
  const Properties creation{check(H5Dget_create_plist(dataset))};
  return check(H5Pget_external_count(creation)) > 0 || H5Pget_layout(creation) == H5D_VIRTUAL;
}

bool takes_room(hid_t dataset, double numbers, double& room) {
  constexpr double most_deflated = 1032;  // bytes from one: no more can be had of deflate
  const Properties creation{check(H5Dget_create_plist(dataset))};
  const Type type{check(H5Dget_type(dataset))};
  const double bytes = numbers * static_cast<double>(H5Tget_size(type));
  const bool is_packed = check(H5Pget_nfilters(creation)) > 0;
  const double stored = is_packed ? static_cast<double>(H5Dget_storage_size(dataset)) : bytes;
  room -= stored;
  return room >= 0 && (!is_packed || bytes <= most_deflated * stored);
}

Properties ordered(hid_t kind) {
  Properties properties{check(H5Pcreate(kind))};
  constexpr unsigned order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
  if (kind != H5P_DATASET_CREATE) check(H5Pset_link_creation_order(properties, order));
  check(H5Pset_attr_creation_order(properties, order));
  return properties;
}

}  // namespace ra2d::h5
