// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/base/exit_status.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/study_print.hpp"
#include "host/study/study_worker.hpp"

namespace ra2d {
namespace {

struct StatusRequest {
  std::filesystem::path folder;
  bool json = false;
};

void print_status_json(const std::filesystem::path& path, const StudyRuns& runs,
                       const StudyWork& work, const std::vector<std::size_t>& failed) {
  using Json = nlohmann::ordered_json;
  Json json{{"folder", path.string()},
            {"runs", work.runs},
            {"done", work.done},
            {"failed", work.failed},
            {"missing", work.jobs.size()},
            {"kept", runs.finished.runs.size()},
            {"seconds_left", work.cost},
            {"measured", work.measured},
            {"missing_runs", Json::array()},
            {"failed_runs", Json::array()}};
  std::vector<std::size_t> missing = work.jobs;
  std::sort(missing.begin(), missing.end());
  for (const std::size_t point : missing) json["missing_runs"].push_back(runs.points.name(point));
  for (const std::size_t point : failed)
    json["failed_runs"].push_back(
        {{"run", runs.points.name(point)}, {"message", runs.find(point)->message}});
  print_text(json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n');
}

int print_study_status(const StatusRequest& request) {
  const std::filesystem::path& path = request.folder;
  const StudyFolder folder{path};
  StudyRuns runs(study_of(folder));
  runs.finished.add(folder);
  const StudyWork work = find_work(runs.census, runs.finished, {}, false);
  const std::vector<std::size_t> bad = runs.failed_points();
  if (request.json) {
    print_status_json(path, runs, work, bad);
    return exit_status::done;
  }
  print("{}: {}, {} done, {} failed, {} missing\n", printable(path.string()), runs_text(work.runs),
        work.done, work.failed, work.jobs.size());
  if (work.done + work.failed == 0 && !runs.finished.runs.empty())
    print_line("kept", fmt::format("{} of another version or build of ra2d",
                                   runs_text(runs.finished.runs.size())));
  if (!work.jobs.empty()) {
    print_line(
        "left",
        fmt::format(
            "about {} of one thread{}", seconds_text(work.cost),
            work.measured > 0 ? "" : ", within a factor of three: no run has been measured yet"));
    std::vector<std::size_t> missing = work.jobs;
    std::sort(missing.begin(), missing.end());
    print_line("missing", names_of(runs.points, missing));
  }
  for (std::size_t i = 0; i < std::min(most_named, bad.size()); ++i)
    print_line(i == 0 ? "failed" : "",
               fmt::format("{}: {}", runs.points.name(bad[i]), reason_of(*runs.find(bad[i]))));
  if (bad.size() > most_named) print_line("", fmt::format("and {} more", bad.size() - most_named));
  return exit_status::done;
}

}  // namespace

void add_study_status(CLI::App& study, ChosenCommand& chosen) {
  CLI::App* status = study.add_subcommand("status", "says how far a study is");
  const auto request = std::make_shared<StatusRequest>();
  status->add_option("DIR", request->folder, "folder of a study")->required()->check(path());
  status->add_flag("--json", request->json, "prints it as one JSON object");
  status->callback([request, &chosen] {
    chosen.takes_checkpoints = true;
    chosen.run = [request] { return print_study_status(*request); };
  });
}

}  // namespace ra2d
