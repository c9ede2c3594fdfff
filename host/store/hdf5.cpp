// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/hdf5.hpp"

namespace ra2d::h5 {

std::unique_lock<std::mutex> take_library() {
  static std::mutex mutex;
  std::unique_lock lock{mutex};
  // Before all other calls: a file that a failed flush has spoilt must not crash the program's
  // exit.
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
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

Properties ordered(hid_t kind) {
  Properties properties{check(H5Pcreate(kind))};
  constexpr unsigned order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
  if (kind != H5P_DATASET_CREATE) check(H5Pset_link_creation_order(properties, order));
  check(H5Pset_attr_creation_order(properties, order));
  return properties;
}

}  // namespace ra2d::h5
