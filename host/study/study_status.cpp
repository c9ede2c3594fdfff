// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_status.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <nlohmann/json.hpp>

namespace ra2d {
namespace {

std::string time_text(double seconds) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

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

}  // namespace ra2d
