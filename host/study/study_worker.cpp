// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_worker.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <future>
#include <limits>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <thread>

#include "host/analysis/sound_power.hpp"
#include "host/base/clock.hpp"
#include "host/base/errors.hpp"
#include "host/device/backend.hpp"
#include "host/model/areal_size.hpp"
#include "host/model/doubts.hpp"
#include "host/model/model.hpp"
#include "host/plan/plan.hpp"
#include "host/run/disk_room.hpp"
#include "host/run/result_header.hpp"
#include "host/run/run_files.hpp"
#include "host/run/run_key.hpp"
#include "host/run/run_report.hpp"
#include "host/run/simulation.hpp"
#include "host/run/v_rms.hpp"
#include "host/study/run_memory.hpp"
#include "host/system/interruption.hpp"
#include "host/system/machine_memory.hpp"
#include "kernels/limits.hpp"

namespace ra2d {
namespace {

// two crews, each with as many as an H100 or H200 marches at a moment; memory may be for fewer
constexpr int slots_of_a_gpu = 2 * 2112;
constexpr std::chrono::milliseconds tick_time{200};
constexpr double progress_time = 0.2;  // s
constexpr std::size_t most_failures_reported = 10;
constexpr const char* no_memory =
    "out of memory: fewer nodes or modes are needed (see 'ra2d plan')";

/// Lets this process open as many files as it may: each run on its way has its result's and a lock.
void open_more_files() {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);  // if refused, the file that cannot be opened says so
}

/// The dearest first; of equals in their order.
void sort_by_cost(std::vector<std::size_t>& points, const PointCensus& census) {
  std::stable_sort(points.begin(), points.end(),
                   [&](std::size_t a, std::size_t b) { return census.costs[a] > census.costs[b]; });
}

/// One run on its way.
class PointRun : public SceneRun {
 public:
  PointRun(Model model, ModalStart start, std::size_t point_, Key128 key_, double setup_,
           std::unique_ptr<RunFiles> files_, bool keeps_result_, RunMemory::Part memory_)
      : SceneRun(std::move(model), std::move(start), {}, files_->sink()),
        files{std::move(files_)},
        point{point_},
        key{key_},
        setup{setup_},
        keeps_result{keeps_result_},
        memory{std::move(memory_)} {}
  const std::unique_ptr<RunFiles> files;
  const std::size_t point;
  const Key128 key;         // run_key
  const double setup;       // s
  const bool keeps_result;  // else it goes once the ledger has the run
  const RunMemory::Part memory;
};

/// Means over the nodes of the modes' squares: equal resonators share them, for they take as long
/// to find as a short run.
class SharedMeanSquares {
 public:
  std::vector<double> of(const Model& model) {
    if (model.is_areal) return mean_squares(model);  // in closed form
    const BodySpec& body = model.scene.resonator;
    const Key key{static_cast<double>(body.support), body.length, model.scene.spacing,
                  static_cast<double>(model.resonator_height.size()),
                  static_cast<double>(model.resonator.modes.size())};
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [recent, values] : recent_)
        if (recent == key) return values;
    }
    const std::vector<double> values = mean_squares(model);
    const std::lock_guard lock(mutex_);
    recent_.emplace_front(key, values);
    if (recent_.size() > 64) recent_.pop_back();
    return values;
  }

 private:
  using Key = std::array<double, 5>;  // all that the shapes of modes and their places depend on
  std::mutex mutex_;
  std::list<std::pair<Key, std::vector<double>>> recent_;
};

/// Calls `tick` until it is destroyed, on a thread of its own; keeps what it throws.
class Clerk {
 public:
  explicit Clerk(std::function<void()> tick)
      : tick_{std::move(tick)}, thread_{[this] { work(); }} {}
  ~Clerk() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    wake_.notify_all();
    thread_.join();
  }
  Clerk(const Clerk&) = delete;
  Clerk& operator=(const Clerk&) = delete;
  void rethrow() {
    const std::lock_guard lock(mutex_);
    if (fault_) std::rethrow_exception(fault_);
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, tick_time, [&] { return over_; })) {
      lock.unlock();
      std::exception_ptr fault;
      try {
        tick_();
      } catch (...) {
        fault = std::current_exception();
      }
      lock.lock();
      if (!fault) continue;
      fault_ = fault;
      return;
    }
  }
  std::function<void()> tick_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool over_ = false;
  std::exception_ptr fault_;
  std::thread thread_;
};

class Worker {
 public:
  Worker(const StudyPoints& points, const PointCensus& census, const StudyWork& work,
         LedgerWriter& ledger, const StudyOptions& options)
      : points_{points},
        census_{census},
        work_{work},
        ledger_{ledger},
        options_{options},
        memory_{options.processes} {
    left_.resize(work.jobs.size() + 1);  // estimates of the jobs from each on
    for (std::size_t i = work.jobs.size(); i-- > 0;)
      left_[i] = left_[i + 1] + static_cast<double>(census.costs[work.jobs[i]]);
  }

  StudyOutcome run() {
    if (work_.jobs.empty()) return outcome_;
    {
      Clerk clerk([&] {
        ledger_.sync();
        if (options_.tick) options_.tick();
      });
      clerk_ = &clerk;
      const int jobs = static_cast<int>(work_.jobs.size());
      if (!backend_device().empty()) {
        open_more_files();
        march_on_a_gpu(jobs);
      } else  // each thread by itself: none waits for another before the end
        side_by_side(std::min(jobs, backend_threads()), [&](int thread) { march(thread, 1, {}); });
      clerk.rethrow();
    }
    ledger_.sync();
    outcome_.elapsed = seconds_since(begun_);
    return outcome_;
  }

 private:
  /// Two crews of slots: the host drains and refills one with all its threads while the GPU marches
  /// the runs of the other.
  void march_on_a_gpu(int jobs) {
    const int crews = std::min(2, jobs);
    const BatchOptions batch{.capacity = capacity_on_a_gpu,
                             .memory = backend_memory() / static_cast<std::size_t>(crews)};
    const auto begin = [&](int crew) {
      march(crew, std::min((jobs + crews - 1) / crews, slots_of_a_gpu / crews), batch);
    };
    std::future<void> other;
    if (crews > 1) other = std::async(std::launch::async, begin, 1);
    begin(0);
    if (crews > 1) other.get();
  }

  /// Takes runs until there are no more. `crew`: the number of a thread, or of half of a GPU.
  void march(int crew, int slots, const BatchOptions& batch) {
    SimulationOptions options;
    options.slots = slots;
    options.batch = batch;
    options.seconds = launch_seconds(checkpoint_seconds(), options_.most_wall);
    Simulation simulation(options);
    int answered = checkpoint_requests_;  // checkpoint requests that this crew has followed
    try {
      simulation.run([&](std::size_t) { return make(crew); },
                     [&](SceneRun& run) { take(static_cast<PointRun&>(run)); },
                     [&] {
                       update_progress(crew);
                       if (out_of_time()) simulation.stop();
                       if (take_checkpoint_request()) ++checkpoint_requests_;
                       const int requests = checkpoint_requests_;
                       keep(crew, simulation, requests != answered || !simulation.goes_on());
                       answered = requests;
                     },
                     [&](SceneRun& run) { refuse(static_cast<PointRun&>(run)); });
    } catch (const GivenUp&) {  // the fault is another's
    } catch (const std::invalid_argument& fault) {
      given_up_ = true;
      throw FileError(
          fmt::format("cannot go on from a checkpoint of the study: its state does not fit its "
                      "scene: {}. Remove the files that end in .checkpoint from its folder 'runs'",
                      fault.what()));
    } catch (...) {
      given_up_ = true;
      throw;
    }
    const std::lock_guard lock(mutex_);
    outcome_.busy += simulation.busy_seconds();
    outcome_.marched += simulation.marched_seconds();
    outcome_.most_at_once += simulation.most_at_once();
  }

  /// The next run that can be marched; none: there are no more.
  SceneRun* make(int crew) {
    for (;;) {
      const std::size_t job = next_job();
      if (job >= work_.jobs.size() || ends()) return nullptr;
      const std::size_t point = work_.jobs[job];
      FinishedRun refused{census_.keys[point], {}, RunStatus::refused, no_figures,
                          points_.name(point), {}};
      const Clock::time_point begin = Clock::now();
      try {
        return make(crew, point, refused, begin);
      } catch (const MemoryShortage& shortage) {
        if (memory_.may_have_room(shortage.needed)) {
          put_back(job);
          if (has_runs(crew)) throw std::bad_alloc();  // until one of them is over
          wait_for_memory(shortage.needed, points_.name(point));
          continue;
        }
        refused.message = points_.in_words_of_the_study(shortage.what(), point);
      } catch (const RequestError& fault) {
        refused.message = points_.in_words_of_the_study(fault.what(), point);
      } catch (const std::bad_alloc&) {
        refused.message = no_memory;
      }
      refused.figures.wall_seconds = seconds_since(begin);
      record(std::move(refused));
    }
  }

  /// Whether no new run begins any more.
  bool ends() const { return interruption() != 0 || out_of_time() || given_up_; }

  bool has_runs(int crew) {
    const std::lock_guard lock(mutex_);
    return std::any_of(running_.begin(), running_.end(),
                       [&](const auto& run) { return run.second.crew == crew; });
  }

  /// Sleeps until there is memory [bytes] for a run, there never will be, or no run begins any
  /// more.
  void wait_for_memory(double needed, const std::string& name) {
    while (!ends() && !memory_.has_room(needed) && memory_.may_have_room(needed)) {
      if (!memory_.in_use() && options_.tell && !told_of_memory_.exchange(true))
        options_.tell(fmt::format(
            "the run {} waits for memory that other programs hold: it takes {:.3g} GB, and {:.3g} "
            "GB are free. Ctrl-C ends the study, and the same command continues it",
            name, needed * 1e-9, static_cast<double>(available_memory()) * 1e-9));
      std::this_thread::sleep_for(tick_time);
    }
  }

  /// A job that could not be begun, for whoever asks next.
  void put_back(std::size_t job) {
    const std::lock_guard lock(mutex_);
    put_back_.push_back(job);
  }

  std::size_t next_job() {
    {
      const std::lock_guard lock(mutex_);
      if (!put_back_.empty()) {
        const std::size_t job = put_back_.back();
        put_back_.pop_back();
        return job;
      }
    }
    if (!options_.next_job) return next_++;
    const std::size_t job = options_.next_job();
    next_ = job + 1;  // as far as this process has seen: for the time left
    return job;
  }

  /// `refused` learns what is known of the run until it is.
  SceneRun* make(int crew, std::size_t point, FinishedRun& refused, Clock::time_point begin) {
    const Scene scene = points_.scene(point);
    RunMemory::Part memory = memory_.part_for(scene);
    Model model = make_model(scene);
    refused.run =
        to_key(points_.study().keeps_microphones() ? run_key_with_sound(model) : run_key(model));
    const std::string beyond_limit = checked_limit(model);
    if (const std::string overlap = overlap_at_start(model); !overlap.empty())
      throw refusal(scene, "scene.gap", overlap);
    const std::size_t modes = model.resonator.modes.size() + model.slider.modes.size();
    if (modes > most_modes)
      throw RequestError(
          fmt::format("{} modes in both bodies together, at the most {} can be "
                      "marched: lower max_frequency or modes",
                      modes, most_modes));
    const std::string key = key_text(refused.run);
    const bool records = options_.keep_results || options_.keep_sound;
    const std::filesystem::path result = options_.folder / StudyFolder::result(key);
    const bool keeps_result = options_.keep_results || std::filesystem::exists(result);
    auto files = std::make_unique<RunFiles>(result, key);
    std::optional<Checkpoint> before;
    if (options_.checkpoints != nullptr)
      before = options_.checkpoints->last(
          *files, key, model, records ? Outputs::kept : Outputs::not_kept, points_.name(point));
    ModalStart start = make_start(model);
    if (records) {
      if (!before) require_disk_room(model, result);
      ResultHeader header = result_header(model, key);
      header.beyond_limit = beyond_limit;
      files->record(std::move(header), before);
    }
    auto run = std::make_unique<PointRun>(std::move(model), std::move(start), point, refused.run,
                                          seconds_since(begin), std::move(files), keeps_result,
                                          std::move(memory));
    if (before) run->go_on(std::move(before->state), std::move(before->accounts));
    const std::lock_guard lock(mutex_);
    SceneRun* const scene_run = run.get();
    running_.emplace(scene_run, Running{crew, 0, std::move(run)});
    return scene_run;
  }

  RunReport report_of(const PointRun& run) {
    RunReport report = report_on(run, squares_.of(run.model()));
    report.wall_seconds = run.setup + report.march_seconds;
    return report;
  }

  void take(PointRun& run) {
    const RunReport report = report_of(run);
    const Clock::time_point over = Clock::now();
    if (run.files->records())
      run.files->close(summary_of(report));  // before the ledger says it is there
    FinishedRun finished{census_.keys[run.point], run.key,       RunStatus::done, no_figures,
                         points_.name(run.point), report.failure};
    if (report.ending == Ending::failed) {
      finished.status = RunStatus::failed;
    } else {
      finished.figures = {.v_rms = report.v_rms,
                          .lv = report.lv,
                          .shock_rate = report.shock_rate,
                          .shock_duration_median = report.shock_duration_median,
                          .peak_force_median = report.peak_force_median,
                          .contact_share = report.contact_share,
                          .energy_closure = report.energy.closure(),
                          .wall_seconds = 0};
      std::vector<std::string> warnings = warnings_of_run(run, report);
      if (options_.keep_sound) add_sound(run, finished, warnings);
      finished.message = fmt::format("{}", fmt::join(warnings, "\n"));
    }
    finished.figures.wall_seconds = report.wall_seconds + seconds_since(over);
    record(std::move(finished));
    if (run.files->is_claimed()) run.files->remove();  // after it
    if (run.files->records() && !run.keeps_result) {
      std::error_code none;  // at worst a file stays
      std::filesystem::remove(result_of(run), none);
    }
    let_go_of(run);
  }

  std::filesystem::path result_of(const PointRun& run) const {
    return options_.folder / StudyFolder::result(key_text(run.key));
  }

  /// From the run's result, which is written even where it is not kept.
  void add_sound(const PointRun& run, FinishedRun& finished,
                 std::vector<std::string>& warnings) const {
    const SoundLevels levels = sound_levels(run.model().scene, result_of(run));
    finished.sound = {levels.lp, levels.lp_a, levels.lw, levels.lw_a};
    warnings.insert(warnings.end(), levels.warnings.begin(), levels.warnings.end());
    if (!levels.why_none.empty()) warnings.push_back(levels.why_none);
  }

  /// Without doubts of its keys, which the study has said before.
  static std::vector<std::string> warnings_of_run(const PointRun& run, const RunReport& report) {
    const Model& model = run.model();
    const std::vector<std::string> of_keys = scene_doubts(model.scene);
    std::vector<std::string> warnings = model.doubts;
    std::erase_if(warnings, [&](const std::string& doubt) {
      return std::find(of_keys.begin(), of_keys.end(), doubt) != of_keys.end();
    });
    warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
    return warnings;
  }

  /// There is no memory for it where runs are marched, even alone.
  void refuse(PointRun& run) {
    record({census_.keys[run.point], run.key, RunStatus::refused, no_figures,
            points_.name(run.point), no_memory});
    let_go_of(run);
  }

  void let_go_of(PointRun& run) {
    std::unique_ptr<PointRun> over;  // outside the lock
    const std::lock_guard lock(mutex_);
    const auto found = running_.find(&run);
    over = std::move(found->second.run);
    running_.erase(found);
  }

  void record(FinishedRun finished) {
    ledger_.append(finished);
    const std::lock_guard lock(mutex_);
    if (finished.status == RunStatus::done) {
      ++outcome_.done;
      return;
    }
    ++outcome_.failed;
    if (outcome_.failures.size() < most_failures_reported)
      outcome_.failures.emplace_back(std::move(finished.point), std::move(finished.message));
  }

  double checkpoint_seconds() const {
    return options_.checkpoints != nullptr ? options_.checkpoints->seconds()
                                           : std::numeric_limits<double>::infinity();
  }
  bool out_of_time() const { return seconds_since(begun_) >= options_.most_wall; }

  /// Between the launches of a crew, while its runs stand still: writes checkpoints of those for
  /// which it is time, or of all.
  void keep(int crew, const Simulation& simulation, bool all) {
    if (options_.checkpoints == nullptr) return;
    std::vector<PointRun*> due;
    {
      const std::lock_guard lock(mutex_);
      for (auto& [scene_run, running] : running_)
        if (running.crew == crew && simulation.holds(*running.run) &&
            (all || options_.checkpoints->is_due(*running.run->files)))
          due.push_back(running.run.get());
    }
    if (due.empty()) return;
    side_by_side(static_cast<int>(due.size()), [&](int i) {
      PointRun& run = *due[static_cast<std::size_t>(i)];
      options_.checkpoints->keep(*run.files, run, simulation.save(run),
                                 run.setup + run.accounts().march_seconds,
                                 [&] { return summary_of(report_of(run)); });
    });
  }

  /// Between the launches of a crew, while its runs stand still.
  void update_progress(int crew) {
    if (given_up_) throw GivenUp();
    clerk_->rethrow();
    if (!options_.progress) return;
    const std::lock_guard lock(mutex_);
    for (auto& [scene_run, running] : running_)
      if (running.crew == crew)
        running.share = running.run->time() / running.run->model().scene.duration;
    if (seconds_since(shown_) < progress_time) return;
    shown_ = Clock::now();
    StudyProgress now;
    now.runs = work_.runs;
    now.done = work_.done + outcome_.done;
    now.failed = work_.failed + outcome_.failed;
    now.running = running_.size();
    now.elapsed = seconds_since(begun_);
    double estimate = left_[std::min(next_.load(), work_.jobs.size())];
    for (const auto& [scene_run, running] : running_)
      estimate += static_cast<double>(census_.costs[running.run->point]) * (1 - running.share);
    const double spent = left_[0] - estimate;
    // by what this study's estimates have come to so far, runs on their way among them
    now.left = spent > 0 ? now.elapsed * estimate / spent
                         : estimate * work_.correction / backend_threads();
    options_.progress(now);
  }

  struct GivenUp {};
  struct Running {
    int crew;
    double share;  // that is done
    std::unique_ptr<PointRun> run;
  };

  const StudyPoints& points_;
  const PointCensus& census_;
  const StudyWork& work_;
  LedgerWriter& ledger_;
  const StudyOptions& options_;
  const Clock::time_point begun_ = Clock::now();
  std::vector<double> left_;
  SharedMeanSquares squares_;
  RunMemory memory_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> given_up_ = false, told_of_memory_ = false;
  std::atomic<int> checkpoint_requests_ = 0;
  Clerk* clerk_ = nullptr;
  std::mutex mutex_;  // of all below
  std::map<const SceneRun*, Running> running_;
  std::vector<std::size_t> put_back_;  // jobs
  Clock::time_point shown_ = begun_;
  StudyOutcome outcome_;
};

}  // namespace

StudyWork find_work(const PointCensus& census, const FinishedRuns& finished, const Shard& shard,
                    bool retry_failed, const std::function<bool(const FinishedRun&)>& lacks) {
  StudyWork work;
  std::vector<std::size_t> all = census.different();
  sort_by_cost(all, census);
  double estimated = 0, measured = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const FinishedRun* run = finished.find(census.keys[all[i]]);
    if (run != nullptr && run->status == RunStatus::done) {
      estimated += static_cast<double>(census.costs[all[i]]);
      measured += run->figures.wall_seconds;
      ++work.measured;
    }
    if (i % static_cast<std::size_t>(shard.count) != static_cast<std::size_t>(shard.index - 1))
      continue;
    ++work.runs;
    const bool failed = run != nullptr && run->status != RunStatus::done;
    const bool lacking = run != nullptr && lacks && lacks(*run);
    if (run != nullptr && !(failed && retry_failed) && !lacking) {
      ++(failed ? work.failed : work.done);
      continue;
    }
    work.jobs.push_back(all[i]);
    work.cost += static_cast<double>(census.costs[all[i]]);
  }
  if (estimated > 0) work.correction = measured / estimated;
  work.cost *= work.correction;
  return work;
}

StudyOutcome run_study(const StudyPoints& points, const PointCensus& census, const StudyWork& work,
                       LedgerWriter& ledger, const StudyOptions& options) {
  return Worker(points, census, work, ledger, options).run();
}

}  // namespace ra2d
