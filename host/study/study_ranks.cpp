// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_ranks.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "host/base/clock.hpp"
#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/device/backend.hpp"
#include "host/system/interruption.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

/// Gives all ranks the sequence of rank 0.
template <class Sequence>
void share(Ranks& ranks, Sequence& sequence) {
  std::uint64_t size = sequence.size();
  ranks.broadcast(&size, sizeof size);
  sequence.resize(size);
  ranks.broadcast(sequence.data(), size * sizeof *sequence.data());
}

std::int64_t microseconds(double seconds) { return static_cast<std::int64_t>(1e6 * seconds); }

/// Ends this rank where another one has given up. MPI ends all ranks then, but mpirun first asks
/// them to end (SIGTERM), and a rank that waits would go on waiting.
void end_if_another_gave_up(Ranks& ranks) {
  const auto gave_up = [&](int rank) { return ranks.report_of(rank).ended == RankReport::fault; };
  if (ranks.rank() > 0) {
    if (gave_up(0)) ranks.abort(exit_status::wrong_file);
    return;
  }
  for (int rank = 1; rank < ranks.size(); ++rank)
    if (gave_up(rank))
      throw FileError(fmt::format("rank {} has given up; what is finished is kept", rank));
}

/// A number that no other launch has, as text.
std::string name_of_launch() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}\n", random(), random(), random(), random());
}

/// Whether there is such a file with this text.
bool has_text(const std::filesystem::path& file, const std::string& text) {
  try {
    return read_text(file, "the study's folder", text.size() + 1) == text;
  } catch (const FileError&) {
    return false;
  }
}

/// The runs that this rank takes from the list. `name`, `text` and `keys`: of the launch, the study
/// and the keys of its points, as rank 0 has them.
RankReport run_own_part(Ranks& ranks, const StudyFolder& folder, const Shard& shard,
                        const RankOptions& choices, const std::string& name,
                        const std::string& text, const std::vector<Key128>& keys,
                        const StudyWork& work) {
  // a copy of the folder may have the same study
  if (!has_text(folder.snapshot(), text) || !has_text(folder.launch(), name))
    throw FileError(
        fmt::format("'{}' is not the folder that rank 0 sees: all ranks need one that "
                    "they share, by the same name",
                    folder.path.string()));
  const StudyPoints points(parse_snapshot(text, folder.snapshot()));
  const PointCensus census(points);
  if (census.keys != keys)
    throw FileError(
        "this machine would not run the scenes of rank 0: its processor computes with "
        "other instructions, or it has another ra2d or other profiles. Take machines "
        "that are alike, with one ra2d");
  LedgerWriter ledger(folder.ledger(shard, ranks.rank()));
  StudyCheckpoints checkpoints(folder, choices.checkpoint, choices.tell);
  StudyOptions options;
  options.processes = ranks.neighbours();
  options.tell = choices.tell;
  options.checkpoints = &checkpoints;
  options.most_wall = choices.most_wall;
  options.keep_results = points.study().keep_files;
  options.keep_sound = points.study().keep_sound;
  options.folder = folder.path;
  options.next_job = [&] { return ranks.next_number(); };
  options.progress = [&](const StudyProgress& now) {
    ranks.report({.done = static_cast<std::int64_t>(now.done),
                  .failed = static_cast<std::int64_t>(now.failed),
                  .running = static_cast<std::int64_t>(now.running)});
  };
  const Backend backend(choices.threads, choices.device);
  const StudyOutcome outcome = run_study(points, census, work, ledger, options);
  return {.done = static_cast<std::int64_t>(outcome.done),
          .failed = static_cast<std::int64_t>(outcome.failed),
          .went_on = static_cast<std::int64_t>(checkpoints.went_on()),
          .steps_saved = checkpoints.steps_saved(),
          .busy = microseconds(outcome.busy),
          .marched = microseconds(outcome.marched)};
}

}  // namespace

void require_one_request(Ranks& ranks, const std::string& words) {
  std::string first = words;
  share(ranks, first);
  if (first != words)
    throw RequestError(
        fmt::format("it was started with '{}', rank 0 with '{}'. The ranks of a launch share one "
                    "study: give all the same words. Parts of a study (--shard) each have a launch "
                    "of their own (with srun: --mpi=none)",
                    words, first));
}

void give_work(Ranks& ranks, const StudyFolder& folder, const Study& study,
               const PointCensus& census, const StudyWork& work) {
  std::string name = name_of_launch(), text = snapshot_text(study);
  std::vector<Key128> keys = census.keys;
  std::vector<std::size_t> jobs = work.jobs;
  write_text(folder.launch(), name);
  share(ranks, name);
  share(ranks, text);
  share(ranks, keys);
  share(ranks, jobs);
}

void help_with_study(Ranks& ranks, const StudyFolder& folder, const Shard& shard,
                     const RankOptions& choices) {
  std::string name, text;
  std::vector<Key128> keys;
  StudyWork work;
  share(ranks, name);
  share(ranks, text);
  share(ranks, keys);
  share(ranks, work.jobs);
  const OrderlyEnd orderly;
  RankReport report;
  if (!work.jobs.empty())
    report = run_own_part(ranks, folder, shard, choices, name, text, keys, work);
  report.ended = interruption();
  report.threads = choices.threads;
  ranks.report(report);
  wait_for_others(ranks, [](double) {});
}

void add_others(Ranks& ranks, StudyProgress& progress) {
  for (int rank = 1; rank < ranks.size(); ++rank) {
    const RankReport report = ranks.report_of(rank);
    progress.done += static_cast<std::size_t>(report.done);
    progress.failed += static_cast<std::size_t>(report.failed);
    progress.running += static_cast<std::size_t>(report.running);
  }
}

void add_others(Ranks& ranks, SharedOutcome& all) {
  for (int rank = 1; rank < ranks.size(); ++rank) {
    const RankReport report = ranks.report_of(rank);
    all.outcome.done += static_cast<std::size_t>(report.done);
    all.outcome.failed += static_cast<std::size_t>(report.failed);
    all.outcome.busy += 1e-6 * static_cast<double>(report.busy);
    all.outcome.marched += 1e-6 * static_cast<double>(report.marched);
    all.threads += static_cast<int>(report.threads);
    if (report.ended > 0) all.signal = static_cast<int>(report.ended);
    all.went_on += static_cast<std::size_t>(report.went_on);
    all.steps_saved += report.steps_saved;
  }
}

void wait_for_others(Ranks& ranks, const std::function<void(double waited)>& on_wait) {
  const Clock::time_point begun = Clock::now();
  for (int i = 0; !ranks.all_are_here(); ++i) {
    if (i % 100 == 0) {
      end_if_another_gave_up(ranks);
      on_wait(seconds_since(begun));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace ra2d
