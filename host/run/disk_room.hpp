// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "host/model/model.hpp"

namespace ra2d {

/// Before a run begins: throws FileError where its result, of which the share `done` is on the disk
/// already, would take more than is free there. A disk that does not say what is free is believed
/// to have room.
void require_disk_room(const Model& model, const std::filesystem::path& result, double done = 0);

}  // namespace ra2d
