// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/study/study_folder.hpp"
#include "host/study/study_worker.hpp"

/// How far a study is, for programs that look at its folder.
namespace ra2d {

enum class StudyEnd { running, complete, interrupted, failed };

/// What DIR/status.json holds. `started` and `now`: seconds since 1970.
struct StudyStatus {
  Shard shard;
  StudyProgress progress;
  double started = 0, now = 0;
  StudyEnd end = StudyEnd::running;
};
std::string status_json(const StudyStatus& status);

}  // namespace ra2d
