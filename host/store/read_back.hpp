// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <hdf5.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "host/store/attributes.hpp"
#include "host/store/entries.hpp"

namespace ra2d {

/// The attributes and datasets that a finished file must hold.
struct GivenContent {
  struct Dataset {
    const Entry* entry;
    Stored stored;
    std::vector<hsize_t> extent;
    std::vector<h5::GivenAttribute> attributes;  // among them the hash of its numbers
  };
  std::vector<h5::GivenAttribute> attributes;                         // of the file
  std::vector<std::pair<std::string, h5::GivenAttribute>> of_groups;  // by path
  std::vector<Dataset> datasets;
};

/// Throws h5::Failure where something is not as it was given.
void require_as_given(bool right);

/// Opens a sealed file, of an open descriptor, as a reader would: all that was given must be in it,
/// and its seal fit every byte. Each is read once. Throws h5::Failure.
void read_back(const std::filesystem::path& file, int descriptor, const GivenContent& given);

}  // namespace ra2d
