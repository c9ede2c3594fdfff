// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <vector>

/// Where files are written: only regular files are replaced, and never one that was read.
namespace ra2d {

/// The file that is replaced when `path` is written: `path` itself, or what it leads to where it is a
/// symbolic link, so that the link stays. It need not be there yet. Throws FileError for anything
/// that is there and no regular file (a folder, a device, a pipe, a socket), and for links in a ring.
std::filesystem::path replaced_file(const std::filesystem::path& path);

/// To be asked before the work whose outcome goes to `output`. Throws RequestError when that is one of
/// `inputs`, by whatever name, or no regular file; FileError when its folder cannot be written to.
void require_output(const std::filesystem::path& output,
                    const std::vector<std::filesystem::path>& inputs);

}  // namespace ra2d
