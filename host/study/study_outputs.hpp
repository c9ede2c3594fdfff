// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <vector>

#include "host/study/study_file.hpp"
#include "host/study/study_folder.hpp"

/// The files that a study may write to: none of its inputs, and no file that another program made.
namespace ra2d {

/// Files that a study reads: its own, its base, and `profiles`, those of its scenes.
std::vector<std::filesystem::path> inputs_of(const Study& study,
                                             std::vector<std::filesystem::path> profiles);

/// Checks a study's folder, which need not exist, before anything is written to it. Throws
/// RequestError where its table, its snapshot or its status would replace an input, or what no
/// study has written; FileError where one of them cannot be replaced.
void require_study_folder(const StudyFolder& folder, const Shard& shard,
                          const std::vector<std::filesystem::path>& inputs);

/// Checks the table that is made of several folders of one study. Throws RequestError where
/// something else stands there than an earlier table of this study: an input, a file of one of the
/// folders, somebody else's.
void require_merged_table(const std::filesystem::path& output, const Study& study,
                          const std::vector<std::filesystem::path>& folders,
                          std::vector<std::filesystem::path> inputs);

}  // namespace ra2d
