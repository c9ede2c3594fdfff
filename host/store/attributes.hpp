// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <hdf5.h>

#include <cstdint>
#include <string>
#include <variant>

/// Attributes of HDF5 objects.
namespace ra2d::h5 {

/// One as it was given; a text is of any length.
struct GivenAttribute {
  std::string name;
  std::variant<std::string, double, std::int64_t> value;
};

/// Throws Failure, as everything here does.
void set_attribute(hid_t object, const GivenAttribute& given);

/// Whether the object's attribute of that name reads as the value.
bool holds(hid_t object, const GivenAttribute& given);

}  // namespace ra2d::h5
