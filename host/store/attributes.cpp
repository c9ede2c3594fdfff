// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/attributes.hpp"

#include <cstring>

#include "host/store/hdf5.hpp"

namespace ra2d::h5 {
namespace {

/// Text of any length: one of a fixed length ends at 64 KiB.
Type text_type() {
  Type text{check(H5Tcopy(H5T_C_S1))};
  check(H5Tset_size(text, H5T_VARIABLE));
  check(H5Tset_cset(text, H5T_CSET_UTF8));
  return text;
}

}  // namespace

void set_attribute(hid_t object, const GivenAttribute& given) {
  const Space scalar{check(H5Screate(H5S_SCALAR))};
  const auto set = [&](hid_t type, const void* data) {
    Attribute attribute{
        check(H5Acreate2(object, given.name.c_str(), type, scalar, H5P_DEFAULT, H5P_DEFAULT))};
    check(H5Awrite(attribute, type, data));
    close(attribute);
  };
  if (const auto* text = std::get_if<std::string>(&given.value)) {
    const char* characters = text->c_str();
    set(text_type(), &characters);
  } else if (const auto* number = std::get_if<double>(&given.value)) {
    set(H5T_NATIVE_DOUBLE, number);
  } else {
    set(H5T_NATIVE_INT64, &std::get<std::int64_t>(given.value));
  }
}

bool holds(hid_t object, const GivenAttribute& given) {
  const Attribute attribute{check(H5Aopen(object, given.name.c_str(), H5P_DEFAULT))};
  if (const auto* text = std::get_if<std::string>(&given.value)) {
    char* characters = nullptr;
    check(H5Aread(attribute, text_type(), &characters));
    const bool same = characters != nullptr && *text == characters;
    H5free_memory(characters);
    return same;
  }
  const auto reads = [&](hid_t type, auto number, auto read) {
    check(H5Aread(attribute, type, &read));
    return std::memcmp(&read, &number, sizeof read) == 0;  // NaN is NaN
  };
  if (const auto* number = std::get_if<double>(&given.value))
    return reads(H5T_NATIVE_DOUBLE, *number, 0.0);
  return reads(H5T_NATIVE_INT64, std::get<std::int64_t>(given.value), std::int64_t{0});
}

}  // namespace ra2d::h5
