// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

/// Rules for outputs: only regular files are replaced, and never one that was read. `option` is the
/// one that names the output: messages say that it takes another name.
namespace ra2d {

/// The file that is replaced when `path` is written: `path` itself, or what it leads to where it is
/// a symbolic link, so that the link stays. It need not be there yet. Throws FileError for anything
/// that is there and no regular file (a folder, a device, a pipe, a socket), for an open file that
/// has lost its name (/dev/stdout may lead to one), and for links in a ring.
std::filesystem::path replaced_file(const std::filesystem::path& path, const char* option = "-o");

/// To be asked before the work whose outcome goes to `output`. Throws RequestError when that is one
/// of `inputs`, by whatever name, no regular file, where this program prints to, or among the
/// ledgers of a study; FileError when it leads in a ring, when its folder cannot be written to, or
/// when the file that is there may not be replaced.
void require_output(const std::filesystem::path& output,
                    const std::vector<std::filesystem::path>& inputs, const char* option = "-o");

/// As require_output, of an output that is made from files at hand: a picture, a table, a page, a
/// sound. An earlier one is replaced. Throws RequestError also where a file stands that cannot be
/// made again so easily: a result, a checkpoint, a scene, a study's own, or anything that its name
/// does not tell, as a scene called x.wav.
void require_derived_output(const std::filesystem::path& output,
                            const std::vector<std::filesystem::path>& inputs,
                            const char* option = "-o");

/// Throws FileError where a file stands that this process may not replace: another user's in a
/// folder like /tmp, a write-protected one, one that is mounted there.
void require_replaceable(const std::filesystem::path& file, const char* option = "-o");

/// The folder that a file stands in: "." of a name alone.
std::filesystem::path folder_of(const std::filesystem::path& file);

/// Whether two names lead to one file that is there.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace ra2d
