// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/march_study.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/device/backend.hpp"
#include "host/study/study_advice.hpp"
#include "host/study/study_checkpoints.hpp"
#include "host/study/study_outputs.hpp"
#include "host/study/study_status.hpp"
#include "host/system/interruption.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_named = 5;

void tell_foreign_runs(const StudyRuns& runs, const StudyFolder& folder,
                       const StudyListener& listener) {
  const std::vector<std::string> names = runs.foreign_runs();
  if (names.empty() || !listener.tell) return;
  std::string some;
  for (std::size_t i = 0; i < std::min(most_named, names.size()); ++i)
    some += (i > 0 ? "; " : "") + names[i];
  if (names.size() > most_named) some += fmt::format("; and {} more", names.size() - most_named);
  listener.tell(
      fmt::format("'{}' holds {} run{} that the study does not ask for as it is now, or that "
                  "another build made: they are kept, but are not in the table: {}",
                  folder.path.string(), names.size(), names.size() == 1 ? "" : "s", some));
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

/// Takes progress on to the status file and to the listener.
class Progress {
 public:
  Progress(const StudyMarch& march, const StudyWork& work, const StudyListener& listener)
      : ranks_{march.ranks},
        listener_{listener},
        file_{march.folder.status(march.shard), march.shard, progress_after(work, {})} {}

  void take(StudyProgress progress) {
    if (ranks_ != nullptr) add_others(*ranks_, progress);
    left_ = progress.left;
    file_.take(progress);
    if (listener_.progress) listener_.progress(progress);
  }
  double left() const { return left_; }
  StatusFile& file() { return file_; }

 private:
  Ranks* ranks_;
  const StudyListener& listener_;
  double left_ = StudyProgress{}.left;  // s, by the latest progress
  StatusFile file_;
};

/// Waits for the other ranks and adds what they have done.
void wait_and_add_others(Ranks& ranks, const StudyWork& work, const StudyOutcome& own,
                         Progress& progress, SharedOutcome& all) {
  const double left_here = progress.left();
  double waited = 0;
  wait_for_others(ranks, [&](double seconds) {
    waited = seconds;
    StudyProgress now = progress_after(work, own);
    now.elapsed += waited;
    now.left = std::max(left_here - waited, 0.0);  // NaN stays NaN
    progress.take(now);
    if (interruption() != 0)  // mpirun gives its ranks a second to end in
      progress.file().end(now, StudyEnd::interrupted);
    else
      progress.file().write_now_and_then();
  });
  all.signal = interruption();
  add_others(ranks, all);
  all.outcome.elapsed += waited;
}

/// Runs the jobs, here and on the other ranks.
void run_jobs(const StudyRuns& runs, const StudyMarch& march, LedgerWriter& ledger,
              StudyCheckpoints& checkpoints, Progress& progress, const StudyListener& listener,
              MarchedStudy& marched) {
  const StudyWork& work = marched.work;
  StudyOptions options;
  options.tell = listener.tell;
  options.progress = [&](const StudyProgress& now) { progress.take(now); };
  options.keep_results = runs.points.study().keep_files;
  options.keep_sound = runs.points.study().keep_sound;
  options.folder = march.folder.path;
  options.checkpoints = &checkpoints;
  options.most_wall = march.most_wall;
  options.tick = [&] { progress.file().write_now_and_then(); };

  StudyOutcome own;
  if (march.ranks != nullptr) {
    give_work(*march.ranks, march.folder, runs.points.study(), runs.census, work);
    options.next_job = [&] { return march.ranks->next_number(); };
    options.processes = march.ranks->neighbours();
  }
  if (!work.jobs.empty()) {
    const Backend backend(march.threads, march.device);
    marched.device = backend_device();
    own = run_study(runs.points, runs.census, work, ledger, options);
  }
  marched.most_at_once = own.most_at_once;
  marched.all = {own, march.threads, interruption(), checkpoints.went_on(),
                 checkpoints.steps_saved()};
  if (march.ranks != nullptr) wait_and_add_others(*march.ranks, work, own, progress, marched.all);
}

}  // namespace

MarchedStudy march_study(StudyRuns& runs, const StudyMarch& march, const StudyListener& listener) {
  const Study& study = runs.points.study();
  const StudyFolder& folder = march.folder;
  const auto stage = [&](const char* text) {
    if (listener.stage) listener.stage(text);
  };
  require_study_folder(folder, march.shard, inputs_of(study, runs.census.profiles));
  folder.make(study.keep_files || study.keep_sound);
  LedgerWriter ledger(folder.ledger(march.shard));  // before reading: no other writes this part
  stage("reading what is finished ");
  runs.finished.add(folder);
  stage("");
  tell_foreign_runs(runs, folder, listener);
  write_text(folder.snapshot(), snapshot_text(study));
  StudyCheckpoints checkpoints(folder, march.checkpoint, listener.tell);
  checkpoints.remove_those_of(runs.finished);

  MarchedStudy marched;
  marched.work = find_work(runs.census, runs.finished, march.shard, march.retry_failed,
                           lacks_what_is_kept(study, folder, listener.tell));
  const StudyWork& work = marched.work;
  if (!work.jobs.empty() && listener.doubts)
    listener.doubts(study_doubts(runs.points, runs.census));
  Progress progress(march, work, listener);
  const OrderlyEnd orderly;
  run_jobs(runs, march, ledger, checkpoints, progress, listener, marched);
  if (!work.jobs.empty()) stage("");
  write_table(runs, folder, folder.table());
  marched.was_cut = marched.finished() < work.jobs.size();
  StudyProgress end = progress_after(work, marched.all.outcome);
  if (marched.was_cut) end.left = progress.left();
  progress.file().end(end, marched.was_cut ? StudyEnd::interrupted : StudyEnd::complete);
  return marched;
}

}  // namespace ra2d
