// SPDX-License-Identifier: BSD-3-Clause
#include "tests/hdf5_content.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <vector>

namespace ra2d::test {
namespace {

std::string text_attribute(hid_t object, const char* name) {
  const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT), type = H5Aget_type(attribute);
  char* characters = nullptr;
  H5Aread(attribute, type, &characters);
  const std::string text = characters != nullptr ? characters : "";
  H5free_memory(characters);
  H5Tclose(type);
  H5Aclose(attribute);
  return text;
}

herr_t add_dataset(hid_t file, const char* name, const H5O_info_t* info, void* content) {
  if (info->type != H5O_TYPE_DATASET) return 0;
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(dataset);
  std::vector<hsize_t> extent(H5Sget_simple_extent_ndims(space));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  std::string bytes(H5Sget_simple_extent_npoints(space) * sizeof(double), '\0');
  const bool read =
      H5Dread(dataset, H5T_IEEE_F64LE, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) >= 0;
  (*static_cast<Content*>(content))[name] =
      fmt::format("{} {}: {}{}", read ? "" : "unreadable", fmt::join(extent, " x "),
                  text_attribute(dataset, "xxh3_128"), bytes);
  H5Sclose(space);
  H5Dclose(dataset);
  return 0;
}

// As the program has it (host/store/hdf5.cpp). The first call of HDF5 decides, which may be any
// test's: hence before main.
[[maybe_unused]] const herr_t before_all_tests = H5dont_atexit();

}  // namespace

Content content_of(const std::filesystem::path& path) {
  Content content;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) return content;
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, add_dataset, &content, H5O_INFO_BASIC);
  for (const char* timed :
       {"summary/step_seconds", "summary/wall_seconds", "summary/nodes_evaluated"})
    if (content.erase(timed) == 0) content[timed] = "missing";
  content["ended"] = text_attribute(file, "ended");
  H5Fclose(file);
  return content;
}

}  // namespace ra2d::test
