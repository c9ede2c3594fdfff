// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_status.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

std::string time_text(double seconds) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

double seconds_since_1970() { return static_cast<double>(std::time(nullptr)); }

}  // namespace

std::string status_json(const StudyStatus& status) {
  const StudyProgress& p = status.progress;
  nlohmann::ordered_json json;
  json["shard"] = fmt::format("{}/{}", status.shard.index, status.shard.count);
  json["runs"] = p.runs;
  json["done"] = p.done;
  json["failed"] = p.failed;
  json["running"] = p.running;
  json["seconds_elapsed"] = p.elapsed;
  json["seconds_left"] = p.left;
  json["started"] = time_text(status.started);
  json["updated"] = time_text(status.now);
  const bool over = status.end != StudyEnd::running;
  json["finished"] =
      over ? nlohmann::ordered_json(time_text(status.now)) : nlohmann::ordered_json();
  json["state"] = !over                                 ? "running"
                  : status.end == StudyEnd::interrupted ? "interrupted"
                  : status.end == StudyEnd::failed      ? "failed"
                                                        : "complete";
  return json.dump(1) + '\n';
}

StatusFile::StatusFile(std::filesystem::path file, const Shard& shard,
                       const StudyProgress& progress)
    : file_{std::move(file)},
      status_{.shard = shard, .progress = progress, .started = seconds_since_1970()} {
  write();
}

StatusFile::~StatusFile() {
  if (status_.end != StudyEnd::running) return;
  status_.end = StudyEnd::failed;
  try {
    write();
  } catch (const std::exception&) {  // likely for the reason that ended it
  }
}

void StatusFile::take(const StudyProgress& progress) {
  const std::lock_guard lock(mutex_);
  status_.progress = progress;
}

void StatusFile::write_now_and_then() {
  const Clock::time_point now = Clock::now();
  if (now - written_ < std::chrono::milliseconds(900)) return;
  written_ = now;
  write();
}

void StatusFile::end(const StudyProgress& progress, StudyEnd end) {
  take(progress);
  status_.end = end;
  write();
}

void StatusFile::write() {
  StudyStatus status;
  {
    const std::lock_guard lock(mutex_);
    status = status_;
  }
  status.now = seconds_since_1970();
  write_text(file_, status_json(status));
}

}  // namespace ra2d
