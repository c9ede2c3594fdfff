// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <mutex>
#include <string>

#include "host/base/clock.hpp"
#include "host/study/study_folder.hpp"
#include "host/study/study_worker.hpp"

/// How far a study is, for programs that look at its folder.
namespace ra2d {

enum class StudyEnd { running, complete, interrupted, failed };

/// The contents of DIR/status.json. `started` and `now`: seconds since 1970.
struct StudyStatus {
  Shard shard;
  StudyProgress progress;
  double started = 0, now = 0;
  StudyEnd end = StudyEnd::running;
};
std::string status_json(const StudyStatus& status);

/// DIR/status.json, written about once a second with the latest progress.
class StatusFile {
 public:
  StatusFile(std::filesystem::path file, const Shard& shard, const StudyProgress& progress);
  /// Programs that look at the file must not wait for a study that an error has ended.
  ~StatusFile();
  StatusFile(const StatusFile&) = delete;
  StatusFile& operator=(const StatusFile&) = delete;

  /// Any thread may call it.
  void take(const StudyProgress& progress);
  void write_now_and_then();
  void end(const StudyProgress& progress, StudyEnd end);

 private:
  void write();
  std::filesystem::path file_;
  std::mutex mutex_;
  StudyStatus status_;
  Clock::time_point written_ = Clock::now();
};

}  // namespace ra2d
