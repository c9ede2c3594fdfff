// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/study_print.hpp"
#include "host/commands/threads.hpp"
#include "host/study/law.hpp"
#include "host/study/march_study.hpp"
#include "host/study/study_advice.hpp"
#include "host/study/study_table.hpp"
#include "host/system/interruption.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_means = 24;  // combinations at the end

struct StudyRequest {
  fs::path study;
  fs::path output;
  std::vector<std::string> overrides;
  std::string shard = "1/1";
  int threads = 0;  // none given: all processors
  int device = -1;
  double checkpoint = 10;                                      // min between two of a run
  double most_wall = std::numeric_limits<double>::infinity();  // s
  bool dry_run = false, list = false, retry_failed = false, quiet = false;
};

/// "I/N" with 1 <= I <= N.
Shard to_shard(const std::string& text) {
  Shard shard;
  const char *at = text.data(), *const end = at + text.size();
  const auto first = std::from_chars(at, end, shard.index);
  const bool has_stroke = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
  const auto second = has_stroke ? std::from_chars(first.ptr + 1, end, shard.count) : first;
  if (!has_stroke || second.ec != std::errc() || second.ptr != end || shard.index < 1 ||
      shard.index > shard.count || shard.count > 1'000'000)
    throw RequestError(fmt::format(
        "--shard {}: expected I/N, part I of N with I from 1 to N, like 2/8", shortened(text)));
  return shard;
}

/// The words that say which runs are to be made.
std::string words_of(const StudyRequest& request) {
  std::string words = "--shard " + request.shard;
  if (request.retry_failed) words += " --retry-failed";
  for (const std::string& change : request.overrides) words += " --set " + change;
  return words;
}

std::string state_of(const FinishedRun* run) {
  if (run == nullptr) return "missing";
  if (run->status == RunStatus::done) return fmt::format("done     Lv {:.2f} dB", run->figures.lv);
  return fmt::format("{}  {}", run->status == RunStatus::refused ? "refused" : "failed ",
                     reason_of(*run));
}

int print_list(const StudyRuns& runs) {
  for (std::size_t i = 0; i < runs.points.size(); ++i)
    print("{}  {}\n", runs.points.name(i), state_of(runs.find(i)));
  return exit_status::done;
}

int print_jobs(const StudyRuns& runs, const StudyWork& work, int threads) {
  for (const std::size_t point : work.jobs)
    print("{}  about {}\n", runs.points.name(point),
          seconds_text(work.correction * static_cast<double>(runs.census.costs[point])));
  print("{} of {} to do, {} done, {} failed: about {} on {} thread{}{}\n", work.jobs.size(),
        runs_text(work.runs), work.done, work.failed,
        seconds_text(
            work.cost /
            std::min<double>(threads, std::max<double>(1, static_cast<double>(work.jobs.size())))),
        threads, threads == 1 ? "" : "s",
        work.measured > 0 ? fmt::format(", by the {} finished", runs_text(work.measured))
                          : ", within a factor of three: no run has been measured yet");
  return exit_status::done;
}

void show_study_progress(const StudyProgress& p) {
  show(fmt::format("{} of {} runs   {} failed   {} running   {} left ", p.done + p.failed, p.runs,
                   p.failed, p.running, clock_text(p.left)));
}

StudyListener listener_of(const StudyRequest& request) {
  StudyListener listener;
  if (!request.quiet) listener.tell = [](const std::string& text) { say(text); };
  listener.doubts = [quiet = request.quiet](const std::vector<std::string>& doubts) {
    say_doubts(doubts, quiet);
  };
  if (!shows_progress(request.quiet)) return listener;
  listener.stage = [](const std::string& text) { show(text); };
  listener.progress = show_study_progress;
  return listener;
}

void print_marched(const MarchedStudy& marched, const StudyFolder& folder) {
  const StudyWork& work = marched.work;
  const SharedOutcome& all = marched.all;
  const StudyOutcome& outcome = all.outcome;
  if (work.jobs.empty())
    print("all {} are finished already\n", runs_text(work.runs));
  else
    print("{} finished in {}, {} were finished before\n", runs_text(marched.finished()),
          seconds_text(outcome.elapsed), work.done + work.failed);
  if (all.went_on > 0)
    print_line("went on", fmt::format("{} from checkpoints, {} steps into them",
                                      runs_text(all.went_on), all.steps_saved));
  if (outcome.elapsed > 1)
    print_line("busy", fmt::format("{:.0f} % of {} thread{}; the march alone is {:.0f} % of that",
                                   100 * outcome.busy / (outcome.elapsed * all.threads),
                                   all.threads, all.threads == 1 ? "" : "s",
                                   100 * outcome.marched / std::max(outcome.busy, 1e-9)));
  if (!marched.device.empty())
    print_line("device", fmt::format("{}, up to {} side by side", marched.device,
                                     runs_text(marched.most_at_once)));
  print_line("table", printable(folder.table().string()));
  print_text(describe_study(read_study_table(folder.table()), folder.path.string(), most_means));
}

/// Says what is left to do; returns the exit status.
int say_study_ending(const StudyRuns& runs, const MarchedStudy& marched) {
  const std::vector<std::size_t> failed = runs.failed_points();
  say_failed(runs, failed);
  const StudyWork& work = marched.work;
  const std::string kept =
      fmt::format("{} of {} are finished and kept; the same command continues",
                  work.done + work.failed + marched.finished(), runs_text(work.runs));
  if (marched.was_cut && marched.all.signal != 0) {
    say("interrupted: " + kept);
    return exit_status::interrupted + marched.all.signal;
  }
  if (marched.was_cut) {
    say("stopped by --max-wall: " + kept);
    return exit_status::out_of_time;
  }
  return failed.empty() ? exit_status::done : exit_status::failed;
}

/// Says how many points of the study have been read.
void show_points(std::size_t points) {
  show(fmt::format("the study's scenes: {} runs listed ", points));
}

StudyRuns read_runs(const StudyRequest& request) {
  if (!shows_progress(request.quiet))
    return StudyRuns(read_study(request.study, request.overrides));
  show("reading the study ");
  StudyRuns runs(read_study(request.study, request.overrides), show_points);
  show({});
  return runs;
}

int preview_study(StudyRuns& runs, const StudyRequest& request, const StudyFolder& folder,
                  const Shard& shard, int threads) {
  const StudyListener listener = listener_of(request);
  if (listener.stage) listener.stage("reading what is finished ");
  runs.finished.add(folder);
  if (listener.stage) listener.stage("");
  if (request.list) return print_list(runs);
  const StudyWork work = find_work(runs.census, runs.finished, shard, request.retry_failed,
                                   lacks_what_is_kept(runs.points.study(), folder, listener.tell));
  if (!work.jobs.empty()) listener.doubts(study_doubts(runs.points, runs.census));
  return print_jobs(runs, work, threads);
}

int run_study_file(const StudyRequest& request) {
  const CheckpointKeeper keeper;  // from here on SIGUSR1 ends nothing
  const Shard shard = to_shard(request.shard);
  if (request.list || request.dry_run) require_one_process();
  Ranks* const ranks = join_ranks();
  if (ranks != nullptr) require_one_request(*ranks, words_of(request));
  std::string why_fewer;
  const int threads = usable_threads(request.threads > 0 ? request.threads
                                     : ranks != nullptr  ? ranks->threads()
                                                         : std::numeric_limits<int>::max(),
                                     why_fewer);
  const StudyFolder folder{request.output.empty() ? request.study.stem() : request.output};
  if (ranks != nullptr && ranks->rank() > 0) {
    help_with_study(*ranks, folder, shard,
                    {.threads = threads,
                     .device = request.device,
                     .checkpoint = 60 * request.checkpoint,
                     .most_wall = request.most_wall,
                     .tell = [](const std::string& text) { say(text); }});
    return exit_status::done;
  }
  StudyRuns runs = read_runs(request);
  if (request.threads > 0 && !why_fewer.empty() && !request.quiet)
    say(fmt::format("{} thread{}: {}", threads, threads == 1 ? "" : "s", why_fewer));
  if (!request.list) require_other_seeds(runs.points, runs.census);
  if (request.list || request.dry_run) return preview_study(runs, request, folder, shard, threads);
  const MarchedStudy marched = march_study(runs,
                                           {.folder = folder,
                                            .shard = shard,
                                            .retry_failed = request.retry_failed,
                                            .threads = threads,
                                            .device = request.device,
                                            .checkpoint = 60 * request.checkpoint,
                                            .most_wall = request.most_wall,
                                            .ranks = ranks},
                                           listener_of(request));
  if (!request.quiet) print_marched(marched, folder);
  return say_study_ending(runs, marched);
}

/// Options on which runs are made, and how.
void add_run_options(CLI::App& study, StudyRequest& request) {
  CLI::Option* dry = study.add_flag(
      "--dry-run", request.dry_run,
      "lists the runs that are to be done, the longest first, and what they will cost");
  CLI::Option* list = study.add_flag("--list", request.list, "lists all runs and how each stands");
  CLI::Option* shard =
      study
          .add_option("--shard", request.shard,
                      "runs one part of N, I from 1; parts may share DIR or have their own")
          ->type_name("I/N")
          ->capture_default_str();
  CLI::Option* retry =
      study.add_flag("--retry-failed", request.retry_failed, "runs failed ones again");
  for (CLI::Option* other : {dry, shard, retry}) list->excludes(other);
  study
      .add_option("--threads", request.threads,
                  "how many threads to use, at most one for each processor [all of them]")
      ->type_name("N")
      ->transform(thread_count());
  add_device(study, request.device);
  add_overrides(study, request.overrides, "the base and of [set]");
  add_checkpoints(study, request.checkpoint, request.most_wall);
  for (const char* of_runs : {"--checkpoint", "--max-wall"})
    for (CLI::Option* runs_nothing : {list, dry}) runs_nothing->excludes(study.get_option(of_runs));
}

}  // namespace

void add_study(CLI::App& app, ChosenCommand& chosen) {
  const auto request = std::make_shared<StudyRequest>();
  CLI::App* study =
      app.add_subcommand("study",
                         "runs every combination of a study once, in parallel (under mpirun all "
                         "ranks share them), and makes one table of them "
                         "(DIR/results.h5); the same command continues it");
  study->require_subcommand(0, 1);
  CLI::Option* file = study->add_option(
      "STUDY.toml", request->study, "study: a base scene, keys to set, keys to vary, seeds (TOML)");
  file->check(path())->transform(scene_or_name());
  study
      ->add_option("-o,--output", request->output,
                   "folder of the study [STUDY's name without .toml, in the current folder]")
      ->type_name("DIR")
      ->check(path());
  add_run_options(*study, *request);
  study->add_flag("--quiet", request->quiet, "print nothing but errors");
  add_study_status(*study, chosen);
  add_study_merge(*study, chosen);
  study->final_callback([request, study, file, &chosen] {
    if (!study->get_subcommands().empty()) return;
    if (file->count() == 0) throw CLI::RequiredError("STUDY.toml");
    chosen.takes_checkpoints = chosen.takes_ranks = true;
    chosen.run = [request] { return run_study_file(*request); };
  });
}

}  // namespace ra2d
