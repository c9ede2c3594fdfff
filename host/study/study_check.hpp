// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/study/study_folder.hpp"

namespace ra2d {

/// The result of a check of every byte in a study's folder.
struct CheckedStudy {
  std::vector<std::string> faults;  // a sentence each; none: it is whole
  std::string what;                 // "a study of 12 runs: 12 done, ..."
};

/// Reads the ledgers, the table, the results that are kept and the checkpoints, and compares them
/// with their hashes and with one another. Faults are found, not thrown; runs that have not been
/// made yet are none.
CheckedStudy check_study(const StudyFolder& folder);

}  // namespace ra2d
