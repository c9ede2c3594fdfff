// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <unordered_set>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/commands/study_ranks.hpp"
#include "host/commands/threads.hpp"
#include "host/device/backend.hpp"
#include "host/store/result_reader.hpp"
#include "host/study/law.hpp"
#include "host/study/study_advice.hpp"
#include "host/study/study_checkpoints.hpp"
#include "host/study/study_outputs.hpp"
#include "host/study/study_status.hpp"
#include "host/study/study_table.hpp"
#include "host/study/study_worker.hpp"
#include "host/system/interruption.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t most_named = 5;        // points in a message
constexpr std::size_t most_means = 24;       // combinations at the end
constexpr std::size_t longest_reason = 300;  // bytes of a failure, on a line of its own

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

std::string clock_text(double seconds) {
  if (!(seconds < 360000)) return "long";
  const int s = static_cast<int>(std::ceil(seconds));
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string runs_text(std::size_t count) {
  return fmt::format("{} run{}", count, count == 1 ? "" : "s");
}

std::string first_of(std::string reason) {
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return shortened(reason, longest_reason);
}

/// Says how many runs of the study are known; nothing where nobody looks.
std::function<void(std::size_t)> counter(bool shown) {
  if (!shown) return {};
  return
      [](std::size_t points) { show(fmt::format("the study's scenes: {} runs listed ", points)); };
}

/// A study with all that is known of its runs.
struct Known {
  StudyPoints points;
  PointCensus census;
  FinishedRuns finished;

  explicit Known(Study study, bool shown = false)
      : points{std::move(study)}, census{points, counter(shown)} {
    if (shown) show({});
  }
  const FinishedRun* run(std::size_t point) const { return finished.find(census.keys[point]); }
};

/// Reads what is finished; of a million runs that takes seconds.
void add_finished(Known& known, const StudyFolder& folder, bool shown) {
  if (shown) show("reading what is finished ");
  known.finished.add(folder);
  if (shown) show({});
}

/// "A, B and 3 more"
std::string some_of(const StudyPoints& points, const std::vector<std::size_t>& chosen) {
  std::string text;
  for (std::size_t i = 0; i < std::min(most_named, chosen.size()); ++i)
    text += (i > 0 ? "; " : "") + points.name(chosen[i]);
  if (chosen.size() > most_named) text += fmt::format("; and {} more", chosen.size() - most_named);
  return text;
}

std::string state_of(const FinishedRun* run) {
  if (run == nullptr) return "missing";
  if (run->status == RunStatus::done)
    return fmt::format("done     Lv {:.2f} dB", run->figures.level);
  return fmt::format("{}  {}", run->status == RunStatus::refused ? "refused" : "failed ",
                     first_of(run->message));
}

int list_runs(const Known& known) {
  for (std::size_t i = 0; i < known.points.size(); ++i)
    print("{}  {}\n", known.points.name(i), state_of(known.run(i)));
  return done;
}

int dry_run(const Known& known, const StudyWork& work, int threads) {
  for (const std::size_t point : work.jobs)
    print("{}  about {}\n", known.points.name(point),
          seconds_text(work.correction * static_cast<double>(known.census.costs[point])));
  print("{} of {} to do, {} done, {} failed: about {} on {} thread{}{}\n", work.jobs.size(),
        runs_text(work.runs), work.done, work.failed,
        seconds_text(
            work.cost /
            std::min<double>(threads, std::max<double>(1, static_cast<double>(work.jobs.size())))),
        threads, threads == 1 ? "" : "s",
        work.measured > 0 ? fmt::format(", by the {} finished", runs_text(work.measured))
                          : ", within a factor of three: no run has been measured yet");
  return done;
}

/// What the folder holds that the study, as it is now, does not ask for.
void say_unasked(const Known& known, const StudyFolder& folder) {
  const std::unordered_set<Key128> asked(known.census.keys.begin(), known.census.keys.end());
  std::vector<std::string> names;
  for (const auto& [key, run] : known.finished.runs)
    if (!asked.contains(key)) names.push_back(run.point);
  if (names.empty()) return;
  std::sort(names.begin(), names.end());
  std::string some;
  for (std::size_t i = 0; i < std::min(most_named, names.size()); ++i)
    some += (i > 0 ? "; " : "") + names[i];
  if (names.size() > most_named) some += fmt::format("; and {} more", names.size() - most_named);
  say(
      fmt::format("'{}' holds {} that the study does not ask for as it is now, or that another "
                  "build made: they are kept, but are not in the table: {}",
                  folder.path.string(), runs_text(names.size()), some));
}

/// Whether a run's own result is there, whole and of this run. Damage is said.
bool has_its_result(const FinishedRun& run, const StudyFolder& folder, bool quiet) {
  const std::string key = key_text(run.run);
  const fs::path file = folder.path / StudyFolder::result(key);
  try {
    const std::optional<ResultStamp> stamp = stamp_of(file);
    return stamp && stamp->key == key;
  } catch (const FileError&) {
    if (!quiet)
      say(fmt::format("'{}' is damaged, or another program has changed it: its run is made again",
                      file.string()));
    return false;
  }
}

/// Whether a run's own result is to be kept and is not there.
std::function<bool(const FinishedRun&)> lacks_its_result(const Known& known,
                                                         const StudyFolder& folder, bool quiet) {
  if (!known.points.study().keep_files) return {};
  return [folder, quiet](const FinishedRun& run) {
    return run.status != RunStatus::refused && !has_its_result(run, folder, quiet);
  };
}

/// Everything that all who share the folder have finished goes into its table.
void write_table(Known& known, const StudyFolder& folder, const fs::path& table) {
  const TableLock alone(folder);
  known.finished.add(folder);
  write_study_table(table, known.points, known.census, known.finished);
}

double now() { return static_cast<double>(std::time(nullptr)); }

/// The latest progress, written to the folder about once a second.
class StatusFile {
 public:
  StatusFile(fs::path file, StudyStatus status) : file_{std::move(file)}, status_{status} {
    write();
  }
  /// Who looks at the file must not wait for a study that an error has ended.
  ~StatusFile() {
    if (status_.end != StudyEnd::running) return;
    status_.end = StudyEnd::failed;
    try {
      write();
    } catch (const std::exception&) {  // likely for the reason that ended it
    }
  }
  StatusFile(const StatusFile&) = delete;
  StatusFile& operator=(const StatusFile&) = delete;
  void take(const StudyProgress& progress) {
    const std::lock_guard lock(mutex_);
    status_.progress = progress;
  }
  void write_now_and_then() {
    const Clock::time_point now = Clock::now();
    if (now - written_ < std::chrono::milliseconds(900)) return;
    written_ = now;
    write();
  }
  void end(const StudyProgress& progress, StudyEnd end) {
    take(progress);
    status_.end = end;
    write();
  }

 private:
  void write() {
    StudyStatus status;
    {
      const std::lock_guard lock(mutex_);
      status = status_;
    }
    status.now = now();
    write_text(file_, status_json(status));
  }
  fs::path file_;
  std::mutex mutex_;
  StudyStatus status_;
  Clock::time_point written_ = Clock::now();
};

/// All failed runs of this part, by name.
std::vector<std::size_t> failed_points(const Known& known) {
  std::vector<std::size_t> failed;
  for (const std::size_t point : known.census.different())
    if (const FinishedRun* run = known.run(point); run != nullptr && run->status != RunStatus::done)
      failed.push_back(point);
  return failed;
}

void say_failed(const Known& known, const std::vector<std::size_t>& failed) {
  if (failed.empty()) return;
  std::string text =
      fmt::format("{} failed (--retry-failed runs them again):", runs_text(failed.size()));
  for (std::size_t i = 0; i < std::min(most_named, failed.size()); ++i)
    text += fmt::format("\n  {}: {}", known.points.name(failed[i]),
                        first_of(known.run(failed[i])->message));
  if (failed.size() > most_named)
    text += fmt::format("\n  and {} more (--list names all)", failed.size() - most_named);
  say(text);
}

StudyProgress progress_after(const StudyWork& work, const StudyOutcome& outcome) {
  StudyProgress progress;
  progress.runs = work.runs;
  progress.done = work.done + outcome.done;
  progress.failed = work.failed + outcome.failed;
  progress.elapsed = outcome.elapsed;
  if (progress.done + progress.failed >= progress.runs) progress.left = 0;
  return progress;
}

void show_progress(const StudyProgress& p) {
  show(fmt::format("{} of {} runs   {} failed   {} running   {} left ", p.done + p.failed, p.runs,
                   p.failed, p.running, std::isnan(p.left) ? "?" : clock_text(p.left)));
}

int march_study(Known& known, const StudyFolder& folder, const Shard& shard,
                const StudyRequest& request, int threads) {
  const bool keep_files = known.points.study().keep_files;
  require_study_folder(folder, shard, inputs_of(known.points.study(), known.census.profiles));
  folder.make(keep_files);
  LedgerWriter ledger(folder.ledger(shard));  // before all reading: nobody else writes this part
  add_finished(known, folder, isatty(STDERR_FILENO) != 0 && !request.quiet);
  if (!request.quiet) say_unasked(known, folder);
  write_text(folder.snapshot(), snapshot_text(known.points.study()));
  StudyCheckpoints checkpoints(folder, 60 * request.checkpoint, [&](const std::string& text) {
    if (!request.quiet) say(text);
  });
  checkpoints.remove_those_of(known.finished);
  const StudyWork work = find_work(known.census, known.finished, shard, request.retry_failed,
                                   lacks_its_result(known, folder, request.quiet));
  if (!work.jobs.empty()) say_doubts(study_doubts(known.points), request.quiet);

  StatusFile status(folder.status(shard),
                    {.shard = shard, .progress = progress_after(work, {}), .started = now()});
  StudyOptions options;
  const bool terminal = isatty(STDERR_FILENO) != 0 && !request.quiet;
  Ranks* const ranks = joined_ranks();
  double left = StudyProgress{}.left;  // s, when it was last looked at
  options.progress = [&](StudyProgress progress) {
    if (ranks != nullptr) add_others(*ranks, progress);
    left = progress.left;
    status.take(progress);
    if (terminal) show_progress(progress);
  };
  options.keep_results = keep_files;
  options.folder = folder.path;
  options.checkpoints = &checkpoints;
  options.most_wall = request.most_wall;
  options.tick = [&] { status.write_now_and_then(); };

  const OrderlyEnd orderly;
  StudyOutcome own;
  std::string device;
  if (ranks != nullptr) {
    hand_out(*ranks, known.points.study(), known.census, work);
    options.next_job = [ranks] { return ranks->next_number(); };
  }
  if (!work.jobs.empty()) {
    const Backend backend(threads, request.device);
    device = backend_device();
    own = run_study(known.points, known.census, work, ledger, options);
  }
  SharedOutcome all{own, threads, interruption(), checkpoints.went_on(), checkpoints.steps_saved()};
  if (ranks != nullptr) {
    const double left_here = left;
    double waited = 0;
    wait_for_others(*ranks, [&](double seconds) {
      waited = seconds;
      StudyProgress now = progress_after(work, own);
      now.elapsed += waited;
      now.left = std::max(left_here - waited, 0.0);  // of NaN NaN
      options.progress(now);
      if (interruption() != 0)  // mpirun gives its ranks a second to end in
        status.end(now, StudyEnd::interrupted);
      else
        status.write_now_and_then();
    });
    all.signal = interruption();
    add_others(*ranks, all);
    all.outcome.elapsed += waited;
  }
  const StudyOutcome& outcome = all.outcome;
  if (terminal && !work.jobs.empty()) show({});
  write_table(known, folder, folder.table());
  const bool cut = outcome.done + outcome.failed < work.jobs.size();
  StudyProgress end = progress_after(work, outcome);
  if (cut) end.left = left;
  status.end(end, cut ? StudyEnd::interrupted : StudyEnd::complete);

  const std::vector<std::size_t> failed_now = failed_points(known);
  const std::size_t finished = outcome.done + outcome.failed;
  if (!request.quiet) {
    if (work.jobs.empty())
      print("all {} are finished already\n", runs_text(work.runs));
    else
      print("{} finished in {}, {} were finished before\n", runs_text(finished),
            seconds_text(outcome.elapsed), work.done + work.failed);
    if (all.went_on > 0)
      print("  {:<17}{} from checkpoints, {} steps into them\n", "went on", runs_text(all.went_on),
            all.steps_saved);
    if (outcome.elapsed > 1)
      print("  {:<17}{:.0f} % of {} thread{}; the march alone is {:.0f} % of that\n", "busy",
            100 * outcome.busy / (outcome.elapsed * all.threads), all.threads,
            all.threads == 1 ? "" : "s", 100 * outcome.marched / std::max(outcome.busy, 1e-9));
    if (!device.empty())
      print("  {:<17}{}, up to {} side by side\n", "device", device, runs_text(own.most_at_once));
    print("  {:<17}{}\n", "table", printable(folder.table().string()));
    print_text(describe_study(read_study_table(folder.table()), folder.path.string(), most_means));
  }
  say_failed(known, failed_now);
  if (cut && all.signal != 0) {
    say(fmt::format("interrupted: {} of {} are finished and kept; the same line goes on",
                    work.done + work.failed + finished, runs_text(work.runs)));
    return interrupted + all.signal;
  }
  if (cut && outcome.out_of_time) {
    say(fmt::format("stopped by --max-wall: {} of {} are finished and kept; the same line goes on",
                    work.done + work.failed + finished, runs_text(work.runs)));
    return out_of_time;
  }
  return failed_now.empty() ? done : run_failed;
}

int study_command(const StudyRequest& request) {
  const CheckpointKeeper keeper;  // from here on SIGUSR1 ends nothing
  const Shard shard = to_shard(request.shard);
  if (request.list || request.dry_run) require_one_process();
  Ranks* const ranks = join_ranks();
  const bool helps = ranks != nullptr && ranks->rank() > 0;
  std::string lowered;
  const int threads = usable_threads(request.threads > 0 ? request.threads
                                     : ranks != nullptr  ? ranks->threads()
                                                         : std::numeric_limits<int>::max(),
                                     lowered);
  const StudyFolder folder{request.output.empty() ? request.study.stem() : request.output};
  if (helps) {
    help_with_study(*ranks, folder, shard,
                    {.threads = threads,
                     .device = request.device,
                     .checkpoint = 60 * request.checkpoint,
                     .most_wall = request.most_wall});
    return done;
  }
  const bool shown = isatty(STDERR_FILENO) != 0 && !request.quiet;
  if (shown) show("reading the study ");
  Known known(read_study(request.study, request.overrides), shown);
  if (request.threads > 0 && !lowered.empty() && !request.quiet)
    say(fmt::format("{} thread{}: {}", threads, threads == 1 ? "" : "s", lowered));
  if (!request.list) require_other_seeds(known.points, known.census);
  if (request.list || request.dry_run) {
    add_finished(known, folder, shown);
    if (request.list) return list_runs(known);
    const StudyWork work = find_work(known.census, known.finished, shard, request.retry_failed,
                                     lacks_its_result(known, folder, request.quiet));
    if (!work.jobs.empty()) say_doubts(study_doubts(known.points), request.quiet);
    return dry_run(known, work, threads);
  }
  return march_study(known, folder, shard, request, threads);
}

int status_command(const fs::path& path) {
  const StudyFolder folder{path};
  Known known(study_of(folder));
  known.finished.add(folder);
  const StudyWork work = find_work(known.census, known.finished, {}, false);
  const std::vector<std::size_t> bad = failed_points(known);
  print("{}: {}, {} done, {} failed, {} missing\n", printable(path.string()), runs_text(work.runs),
        work.done, work.failed, work.jobs.size());
  if (work.done + work.failed == 0 && !known.finished.runs.empty())
    print("  {:<17}{} of another version or build of ra2d\n", "kept",
          runs_text(known.finished.runs.size()));
  if (!work.jobs.empty())
    print("  {:<17}about {} of one thread{}\n", "left", seconds_text(work.cost),
          work.measured > 0 ? "" : ", within a factor of three: no run has been measured yet");
  if (!work.jobs.empty()) {
    std::vector<std::size_t> missing = work.jobs;
    std::sort(missing.begin(), missing.end());
    print("  {:<17}{}\n", "missing", some_of(known.points, missing));
  }
  for (std::size_t i = 0; i < std::min(most_named, bad.size()); ++i)
    print("  {:<17}{}: {}\n", i == 0 ? "failed" : "", known.points.name(bad[i]),
          first_of(known.run(bad[i])->message));
  if (bad.size() > most_named) print("  {:<17}and {} more\n", "", bad.size() - most_named);
  return done;
}

int merge_command(const std::vector<fs::path>& folders, fs::path output, bool quiet) {
  Known known(study_of(StudyFolder{folders.front()}));
  const Study& study = known.points.study();
  for (const fs::path& folder : folders) {
    const Study other = study_of(StudyFolder{folder});
    const char* const what = other.text != study.text             ? "study"
                             : other.base_text != study.base_text ? "base scene"
                             : other.given != study.given         ? "--set"
                                                                  : nullptr;
    if (what != nullptr)
      throw RequestError(
          fmt::format("'{}' and '{}' are of two studies, their {} differs: expected parts of one. "
                      "Run one of them again with the other's",
                      folders.front().string(), folder.string(), what));
    known.finished.add(StudyFolder{folder});
  }
  std::vector<std::size_t> missing;
  for (const std::size_t point : known.census.different())
    if (known.run(point) == nullptr) missing.push_back(point);
  if (!missing.empty())
    throw RequestError(fmt::format(
        "cannot merge: {} of {} {} missing: {}. Run them (ra2d study {} -o {}), or name the folder "
        "that has them",
        missing.size(), runs_text(known.census.different().size()),
        missing.size() == 1 ? "is" : "are", some_of(known.points, missing), study.file.string(),
        folders.front().string()));
  const StudyFolder home{folders.front()};
  if (output.empty()) output = home.table();
  require_merged_table(output, study, folders, inputs_of(study, known.census.profiles));
  write_table(known, home, output);
  const std::vector<std::size_t> bad = failed_points(known);
  if (!quiet)
    print("{} of {} folder{}\n  {:<17}{}\n", runs_text(known.census.different().size()),
          folders.size(), folders.size() == 1 ? "" : "s", "table", printable(output.string()));
  say_failed(known, bad);
  return bad.empty() ? done : run_failed;
}

}  // namespace

void add_study(CLI::App& app, Chosen& chosen) {
  const auto asked = std::make_shared<StudyRequest>();
  StudyRequest& request = *asked;
  CLI::App* study =
      app.add_subcommand("study",
                         "runs every combination of a study once, in parallel (under mpirun all "
                         "ranks share them), and makes one table of them "
                         "(DIR/results.h5); the same line again goes on where it was cut off");
  study->require_subcommand(0, 1);
  CLI::Option* file = study->add_option(
      "STUDY.toml", request.study, "study: a base scene, keys to set, keys to vary, seeds (TOML)");
  file->check(path());
  study
      ->add_option("-o,--output", request.output,
                   "folder of the study [STUDY's name without .toml, in the current folder]")
      ->type_name("DIR")
      ->check(path());
  CLI::Option* dry = study->add_flag(
      "--dry-run", request.dry_run,
      "lists the runs that are to be done, the dearest first, and what they will cost");
  CLI::Option* list = study->add_flag("--list", request.list, "lists all runs and how each stands");
  CLI::Option* shard =
      study
          ->add_option("--shard", request.shard,
                       "runs one part of N, I from 1; parts may share DIR or have their own")
          ->type_name("I/N")
          ->capture_default_str();
  CLI::Option* retry =
      study->add_flag("--retry-failed", request.retry_failed, "runs those that failed once more");
  for (CLI::Option* other : {dry, shard, retry}) list->excludes(other);
  study
      ->add_option("--threads", request.threads,
                   "how many threads to use, at most one for each processor [all of them]")
      ->type_name("N")
      ->transform(thread_count());
  add_device(*study, request.device);
  study
      ->add_option("--set", request.overrides,
                   "overrides one value of the base and of [set], e.g. --set time.tolerance=1e-7; "
                   "repeatable")
      ->type_name("SECTION.KEY=VALUE")
      ->take_all()
      ->expected(1);
  add_checkpoints(*study, request.checkpoint, request.most_wall);
  for (const char* of_runs : {"--checkpoint", "--max-wall"})
    for (CLI::Option* looking : {list, dry}) looking->excludes(study->get_option(of_runs));
  study->add_flag("--quiet", request.quiet, "print nothing but what was asked for and errors");

  CLI::App* status = study->add_subcommand("status", "says how far a study is");
  const auto looked_at = std::make_shared<fs::path>();
  status->add_option("DIR", *looked_at, "folder of a study")->required()->check(path());
  status->callback(
      [looked_at, &chosen] { chosen = [looked_at] { return status_command(*looked_at); }; });

  struct Merge {
    std::vector<fs::path> folders;
    fs::path output;
    bool quiet = false;
  };
  CLI::App* merge = study->add_subcommand(
      "merge",
      "makes one table of all that folders of one study hold; refuses gaps, and runs of "
      "one scene with other numbers");
  const auto parts = std::make_shared<Merge>();
  merge->add_option("DIR", parts->folders, "folders of one study")->required()->check(path());
  merge->add_option("-o,--output", parts->output, "the table [results.h5 in the first folder]")
      ->type_name("OUT.h5")
      ->check(path());
  merge->add_flag("--quiet", parts->quiet, "print nothing but errors");
  merge->callback([parts, &chosen] {
    chosen = [parts] { return merge_command(parts->folders, parts->output, parts->quiet); };
  });

  study->final_callback([asked, study, file, &chosen] {
    if (!study->get_subcommands().empty()) return;
    if (file->count() == 0) throw CLI::RequiredError("STUDY.toml");
    chosen = [asked] { return study_command(*asked); };
  });
}

}  // namespace ra2d
