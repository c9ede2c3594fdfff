// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "host/chart/accuracy_chart.hpp"
#include "host/chart/peers.hpp"
#include "host/run/timed_run.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/partial_file.hpp"
#include "tests/child.hpp"
#include "tests/csv.hpp"
#include "tests/outcomes.hpp"
#include "tests/places.hpp"
#include "tests/schemes.hpp"

/// The chart of accuracy: its errors against what theory says of them, and the files that it
/// leaves.
namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A program of so many lines of shell.
fs::path script(const Folder& folder, const std::string& name, const std::string& text) {
  const fs::path file = folder.path() / name;
  write_text(file, "#!/bin/sh\n" + text);
  fs::permissions(file, fs::perms::owner_all);
  return file;
}

TEST(StateError, IsThatOfTheEnergy) {
  Model model;
  model.resonator.modes = {{{.omega = 10.0, .zeta = 0, .mass = 4.0}, nullptr}};
  model.slider.modes = {{{.omega = 0, .zeta = 0, .mass = 1.0}, nullptr}};  // without stiffness
  const ra2d::State reference{{0.3}, {4.0}, {7.0}, {0.0}};                 // 4 (16 + 9)
  EXPECT_EQ(state_error(model, reference, reference), 0.0);
  EXPECT_NEAR(state_error(model, {{0.3}, {4.5}, {7.0}, {0.0}}, reference), 0.1, 1e-15);
  EXPECT_NEAR(state_error(model, {{0.35}, {4.0}, {7.0}, {0.0}}, reference), 0.1, 1e-15);
  EXPECT_NEAR(state_error(model, {{0.3}, {4.0}, {99.0}, {1.0}}, reference), 0.1, 1e-15);
  EXPECT_TRUE(std::isnan(state_error(model, reference, {{0.0}, {0.0}, {7.0}, {0.0}})));
  EXPECT_TRUE(fits(model, reference));
  EXPECT_FALSE(fits(model, {{0.3}, {4.0}, {}, {}}));
}

/// A chart of the adaptive scheme: every tolerance within 1e-3 of the state, with these timings.
AccuracyChart timed_chart(const std::vector<std::pair<double, std::vector<double>>>& timings) {
  AccuracyChart chart;
  chart.instants = {{"state-5", "the state", 1e-3}};
  chart.reference_error = {1e-12};
  for (const auto& [tolerance, wall] : timings) {
    Measured point;
    point.name = {.scheme = "adaptive", .law = "penalty", .text = "adaptive"};
    point.setting.time.scheme = SchemeKind::adaptive;
    point.setting.time.tolerance = tolerance;
    point.states = {{.error = tolerance}};
    point.energy_closure = tolerance;
    point.wall = wall;
    chart.points.push_back(point);
  }
  return chart;
}

TEST(AccuracyChart, SaysWhatABudgetHasNoTimeFor) {
  Scene s = read_scene(scene_file("peaks"), {"scene.duration=0.02"});
  const AccuracyChart chart = measure_accuracy(s, {.budget = 0.2, .repetitions = 3});
  // outside the budget one model is made for each setting, and for each surface of the long runs
  EXPECT_LT(chart.seconds, 20);
  const auto unsaid =
      std::count_if(chart.points.begin(), chart.points.end(),
                    [](const Measured& p) { return p.wall.empty() && p.left_out.empty(); });
  EXPECT_EQ(unsaid, 0);
  EXPECT_THAT(points_csv(chart, {}), HasSubstr("--budget"));
}

TEST(AccuracyChart, OneNoisyTimingChoosesNoTightTolerance) {
  // 1e-10 has the lowest median by chance; its range is that of all others
  EXPECT_THAT(
      describe(timed_chart(
          {{1e-4, {0.31, 0.36, 0.40}}, {1e-7, {0.33, 0.34, 0.45}}, {1e-10, {0.29, 0.30, 0.39}}})),
      HasSubstr("to 0.001 adaptive at tol 0.0001"));
  // of single timings nobody knows how they scatter
  EXPECT_THAT(describe(timed_chart({{1e-4, {0.35}}, {1e-10, {0.30}}})),
              HasSubstr("to 0.001 adaptive at tol 0.0001"));
  // what is dearer by more than that is not chosen
  EXPECT_THAT(describe(timed_chart({{1e-4, {0.60, 0.61, 0.62}}, {1e-10, {0.29, 0.30, 0.31}}})),
              HasSubstr("to 0.001 adaptive at tol 1e-10"));
}

TEST(AccuracyChart, ATableIsNoWiderThanAScreen) {
  for (const double seconds : {2.345e-5, 5.37e-4, 0.005370, 0.0537, 0.999, 99.96, 999.4, 54321.0}) {
    std::istringstream lines(describe(timed_chart({{1e-4, {seconds}}, {1e-7, {seconds}}})));
    for (std::string line; std::getline(lines, line);)
      EXPECT_LE(line.size(), 120u) << seconds << '\n' << line;
  }
}

/// A load crosses a damped plate; nothing touches.
Scene crossed_plate() {
  Scene s = lone_beam(4, 0.02);
  s.resonator.moving_forces.push_back({.force = 10.0, .speed = 20.0, .start = 0.1});
  s.duration = 2e-3;
  s.output.rate = 1e4;
  s.time.step = 4e-6;
  s.contact.stiffness = 1e6;  // binds no step
  return s;
}

TEST(Accuracy, PeersAreNotAskedForSmoothFaces) {
  Scene s = crossed_plate();
  s.faces = Faces::smooth;
  s.spacing = 1e-4;
  const AccuracyChart chart = measure_accuracy(s, {.budget = 10,
                                                   .repetitions = 1,
                                                   .steps = {1.6e-5},
                                                   .tolerances = {1e-5},
                                                   .peers = "/no/such"});
  EXPECT_EQ(chart.confirmed, "not confirmed: the peers know linear faces alone");
}

TEST(Accuracy, ErrorsOfASmoothMotionFallAtTheOrders) {
  const AccuracyChart chart =
      measure_accuracy(crossed_plate(), {.budget = 1000,
                                         .repetitions = 1,
                                         .steps = {1.6e-5, 8e-6, 4e-6, 2e-6},
                                         .tolerances = {1e-5, 1e-10}});
  ASSERT_EQ(chart.instants.size(), 1u);
  EXPECT_EQ(chart.instants[0].kind, "state-end");
  EXPECT_EQ(chart.instants[0].time, 2e-3);
  EXPECT_LT(chart.reference_error[0], 1e-11);
  EXPECT_EQ(chart.confirmed, "not confirmed: no peers");
  int compared = 0;
  const Measured* coarser = nullptr;
  for (const Measured& point : chart.points) {
    SCOPED_TRACE(point.name.text + ", " + size_text(point.setting));
    const auto error = [](const Measured& p) {
      return p.states.empty() ? quiet_nan : p.states[0].error;
    };
    // multipliers are measured against their own scheme's run at a quarter of the finest step
    const bool own = point.name.law == "multiplier";
    if (is_adaptive(point.setting.time)) {
      EXPECT_LT(error(point), 10 * point.setting.time.tolerance.value());
      continue;
    }
    const double least = own ? 0.0 : 100 * chart.reference_error[0];
    if (coarser != nullptr && coarser->name.text == point.name.text && error(*coarser) < 0.1 &&
        error(point) > least && error(point) > 1e-11 && !(own && point.setting.time.step < 8e-6)) {
      const int order = scheme_table(point.setting.time.scheme).order;
      EXPECT_NEAR(std::log2(error(*coarser) / error(point)), order, own ? 0.35 : 0.25);
      ++compared;
    }
    coarser = &point;
  }
  EXPECT_GE(compared, 20);
}

TEST(Accuracy, OfSixShocks) {
  const Scene peaks = read_scene(scene_file("peaks"), {"time.step=3e-7"});
  const AccuracyChart chart = measure_accuracy(
      peaks, {.budget = 1000, .repetitions = 2, .steps = {1e-6, 3e-7}, .tolerances = {1e-4, 1e-6}});
  ASSERT_EQ(chart.instants.size(), 2u);
  EXPECT_EQ(chart.instants[0].kind, "state-5");
  EXPECT_GT(chart.instants[0].time, 0.058);
  EXPECT_LT(chart.instants[0].time, 0.05994);  // where the fifth begins
  EXPECT_EQ(chart.instants[1].kind, "state-end");
  EXPECT_THAT(chart.instants[1].text, HasSubstr("6 shocks, the end"));
  EXPECT_EQ(chart.instants[1].time, peaks.duration);
  EXPECT_EQ(chart.points.size(), 17u * 2);
  const auto at = [&](SchemeKind scheme, ContactLaw law, double step) -> const Measured& {
    const Method setting = sized({{scheme}, law}, step);
    return *std::find_if(chart.points.begin(), chart.points.end(),
                         [&](const Measured& point) { return point.setting == setting; });
  };
  const Measured& beyond = at(SchemeKind::explicit_euler, ContactLaw::penalty, 1e-6);
  EXPECT_THAT(beyond.left_out, HasSubstr("beyond its limit"));
  EXPECT_TRUE(beyond.wall.empty());
  for (const Measured& point : chart.points) {
    if (!point.left_out.empty()) continue;
    SCOPED_TRACE(point.name.text + ", " + size_text(point.setting));
    EXPECT_EQ(point.wall.size(), 2u);
    EXPECT_GT(point.wall_median(), 0.0);
    ASSERT_EQ(point.states.size(), 2u);
    for (const StateError& state : point.states)
      EXPECT_NE(std::isnan(state.error), state.note.empty()) << state.note;
  }
  const Measured& midpoint = at(SchemeKind::midpoint, ContactLaw::penalty, 3e-7);
  EXPECT_LT(midpoint.states[0].error, 1e-3);
  EXPECT_LT(midpoint.energy_closure, 3e-2);
  EXPECT_LT(midpoint.states[0].error,
            at(SchemeKind::backward_euler, ContactLaw::penalty, 3e-7).states[0].error);
  EXPECT_THAT(at(SchemeKind::midpoint, ContactLaw::multiplier, 1e-6).against,
              HasSubstr("its own finest"));
  EXPECT_EQ(chart.seeds, 1);
  ASSERT_GE(chart.long_runs.size(), 3u);
  EXPECT_TRUE(chart.long_runs.front().reference);
  EXPECT_TRUE(std::isnan(chart.long_runs.front().statistics[shock_rate].error));
}

TEST(Accuracy, LongRunsAreMeansOverSurfaces) {
  const AccuracyChart chart = measure_accuracy(
      rough_scene(Support::pinned),
      {.budget = 1000, .repetitions = 1, .seeds = 3, .steps = {1e-6, 3e-7, 1e-7, 3e-8}});
  EXPECT_EQ(chart.seeds, 3);
  EXPECT_EQ(chart.long_time, rough_scene(Support::pinned).duration);
  EXPECT_GE(chart.long_runs.size(), 4u);
  for (const LongRun& run : chart.long_runs) {
    const Statistic& level = run.statistics[level_quantity];
    EXPECT_GT(level.mean, 50.0);
    EXPECT_GT(level.error, 0.0);
    EXPECT_EQ(std::isnan(level.difference), run.reference);
    // the mean of differences is the difference of means: each sum rounds a few times
    const double reference = chart.long_runs.front().statistics[level_quantity].mean;
    if (!run.reference) {
      EXPECT_NEAR(level.difference, level.mean - reference, 0x1p-48 * reference);
    }
  }
}

constexpr const char* answer =
    R"({"integrator": "x", "march_seconds": 0.25, "steps": 7, "resonator_displacement": [1, 2.5],
"resonator_velocity": [3, 4], "slider_displacement": [], "slider_velocity": [],
"shock_start": [1e-3], "shock_duration": [1e-5]})";

TEST(Peers, AreAskedAndUnderstood) {
  const Folder folder;
  Scene moved = read_scene(scene_file("peaks"));
  moved.slider.surface = {.kind = SurfaceKind::file, .path = "profile.csv"};
  const Peers peers(
      script(folder, "peers",
             std::string("echo \"$@\" > ") + (folder.path() / "words").string() + "\ncp \"$1\" " +
                 (folder.path() / "copy.toml").string() + "\ncat << EOF\n" + answer + "\nEOF\n"),
      moved);
  const PeerRun run = peers.run({"cvode-adams", "all", 1e-8}, 2e-3, 10);
  EXPECT_EQ(run.failure, "");
  EXPECT_EQ(run.seconds, 0.25);
  EXPECT_EQ(run.state.resonator_u, (std::vector<double>{1, 2.5}));
  EXPECT_EQ(run.state.resonator_v, (std::vector<double>{3, 4}));
  EXPECT_TRUE(run.state.slider_u.empty());
  EXPECT_EQ(run.shock_start, std::vector<double>{1e-3});
  EXPECT_THAT(read_file(folder.path() / "words"),
              HasSubstr("--integrator cvode-adams --nodes all --tolerance 1e-08 --until 0.002"));
  EXPECT_EQ(read_scene(folder.path() / "copy.toml").slider.surface.path,
            source_folder() / "scenes" / "profile.csv");
}

TEST(Peers, OfArealScenesAreThoseThatSolveThem) {
  const Folder folder;
  Scene s = read_scene(scene_file("areal"));
  s.duration = 5e-4;
  s.spacing = 1e-4;
  s.slider.length = s.slider.width = 4e-3;
  s.resonator.max_frequency = 3e3;
  const fs::path words_file = folder.path() / "words";
  const AccuracyChart chart = measure_accuracy(
      s, {.budget = 30,
          .repetitions = 1,
          .steps = {},
          .tolerances = {1e-5},
          .peers = script(folder, "peers", "echo $3 >> " + words_file.string() + "\nexit 3\n")});
  EXPECT_THAT(chart.confirmed, HasSubstr("status 3"));
  std::istringstream words(read_file(words_file));
  int times = 0;
  for (std::string word; words >> word; ++times) EXPECT_EQ(word, "dopri5");
  EXPECT_GT(times, 5);
}

TEST(Peers, ThatFailSaySo) {
  const Folder folder;
  const Scene peaks = read_scene(scene_file("peaks"));
  const auto failure = [&](const std::string& text, double limit = 10) {
    return Peers(script(folder, "peers", text), peaks)
        .run({"dopri5", "all", 1e-3}, 1.0, limit)
        .failure;
  };
  EXPECT_THAT(failure("exit 3\n"), HasSubstr("status 3"));
  EXPECT_THAT(failure("echo nonsense\n"), HasSubstr("cannot be read"));
  EXPECT_THAT(failure("echo '{}'\n"), HasSubstr("march_seconds"));
  EXPECT_THAT(failure("exec sleep 20\n", 0.1), HasSubstr("given up after 0.1 s"));
  EXPECT_THAT(Peers("/no/such", peaks).run({"dopri5", "all", 1e-3}, 1.0, 1).failure,
              HasSubstr("/no/such"));
}

/// Whether a process is gone, or waits for its parent to notice.
bool is_gone(const std::string& process) {
  const std::string status = read_file("/proc/" + process + "/status");
  return status.empty() || status.find("State:\tZ") != std::string::npos;
}

/// Waits until a script has written the file, and returns its text.
std::string await(const fs::path& file) {
  std::string text;
  while (text.empty() || text.back() != '\n') {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    text = read_file(file);
  }
  text.pop_back();
  return text;
}

void await_end(const std::string& process) {
  EXPECT_TRUE(test::wait_until([&] { return is_gone(process); }));
}

/// A peer that never answers, and says which process it is.
fs::path silent_peer(const Folder& folder, const std::string& more) {
  const std::string own = folder.path() / "peer";
  return script(folder, "peers", "echo $$ > " + own + "\n" + more + "exec sleep 1000\n");
}

TEST(Peers, GoWithTheProgramThatIsKilled) {
  const Folder folder, temporary;
  const fs::path peer = silent_peer(folder, "");
  const pid_t program = fork();
  if (program == 0) {
    setenv("TMPDIR", temporary.path().c_str(), 1);
    const Peers peers(peer, read_scene(scene_file("peaks")));
    peers.run({"dopri5", "all", 1e-3}, 1.0, 1000);
    _exit(0);
  }
  const std::string own = await(folder.path() / "peer");
  EXPECT_FALSE(is_gone(own));
  kill(program, SIGKILL);
  waitpid(program, nullptr, 0);
  await_end(own);
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST(Peers, EndWithAllThatTheyStartedWhenTheProgramIsInterrupted) {
  const Folder folder, temporary;
  const fs::path peer =
      silent_peer(folder, "sleep 1000 &\necho $! > " + (folder.path() / "helper").string() + "\n");
  // the chart of a scene of one shock comes to its peers soon; nothing is left in a temporary
  // folder
  Child child(folder.path(),
              {"env", "TMPDIR=" + temporary.path().string(), program(), "chart", "accuracy",
               scene_file("peaks"), "--set", "scene.start=0.10485", "--set", "scene.duration=5e-4",
               "--set", "scene.spacing=1e-4", "--budget", "100", "--no-plot", "--peers", peer});
  const std::string own = await(folder.path() / "peer"), helper = await(folder.path() / "helper");
  child.send(SIGTERM);
  EXPECT_EQ(child.wait(), 128 + SIGTERM) << child.err();
  await_end(own);
  await_end(helper);
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

/// A peer that answers at first and then never again costs no more than its part of the budget.
TEST(Peers, ThatFallSilentKeepTheBudget) {
  const Folder folder;
  const std::string count = folder.path() / "count";
  const fs::path peer =
      script(folder, "peers",
             "echo x >> " + count + "\n[ $(wc -l < " + count +
                 ") -gt 2 ] && exec sleep 1000\ncat << EOF\n" + answer + "\nEOF\n");
  Scene peaks = read_scene(scene_file("peaks"),
                           {"scene.start=0.10485", "scene.duration=5e-4", "scene.spacing=1e-4"});
  // On a slow machine a small budget is used up before a peer falls silent, or by the chart's own
  // marches: then a larger one has to do.
  bool fell_silent = false, kept = false;
  for (double budget = 3; !(fell_silent && kept) && budget < 100; budget *= 2) {
    fs::remove(count);
    const AccuracyChart chart =
        measure_accuracy(peaks, {.budget = budget, .repetitions = 2, .peers = peer});
    const std::string runs = read_file(count);
    fell_silent = std::count(runs.begin(), runs.end(), '\n') > 2;
    kept = chart.seconds < 1.5 * budget;
  }
  EXPECT_TRUE(fell_silent);
  EXPECT_TRUE(kept);
}

TEST(Peers, NeedNoTemporaryFolder) {
  const Folder folder;
  const std::string before = fs::temp_directory_path();
  setenv("TMPDIR", "/no/such", 1);
  const PeerRun run =
      Peers(script(folder, "peers", std::string("cat << EOF\n") + answer + "\nEOF\n"),
            read_scene(scene_file("peaks")))
          .run({"dopri5", "all", 1e-3}, 1.0, 10);
  setenv("TMPDIR", before.c_str(), 1);
  EXPECT_EQ(run.failure, "");
}

TEST(Accuracy, TheProgramPrintsTheTableAndWritesItsFiles) {
  const Folder folder;
  const bool can_draw =
      run_program(folder.path(), {python(), "-c", "import matplotlib"}).status == 0;
  // one that answers, with the state of another scene
  const fs::path peers = script(folder, "peers", std::string("cat << EOF\n") + answer + "\nEOF\n");
  // the first shock alone
  std::vector<std::string> words{program(), "chart", "accuracy", scene_file("peaks")};
  for (const char* value : {"scene.start=0.10485", "scene.duration=5e-4", "scene.spacing=1e-4",
                            "scene.name=six $x^$ shocks\n\x1b"})
    words.insert(words.end(), {"--set", value});
  words.insert(words.end(), {"--budget", "100", "--peers", peers.string(), "-o", "out"});
  if (!can_draw) words.emplace_back("--no-plot");
  const Ended run = run_program(folder.path(), words);
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("the state at 500 us (1 shock, the end)"), HasSubstr("closure"),
                    HasSubstr("midpoint, multiplier"), HasSubstr("To choose"),
                    HasSubstr("not one of this scene"), HasSubstr("out-long.csv")));
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120u) << line;

  std::string header;
  const std::vector<Row> points = read_csv(folder.path() / "out.csv", header);
  EXPECT_EQ(header,
            "program,scheme,law,contact_force,nodes,step,tolerance,kind,error,against,wall_median,"
            "wall_min,wall_max,repetitions,stretch,how");
  for (const Row& row : points) {
    if (row.at("wall_median").empty()) {
      EXPECT_THAT(row.at("how"), HasSubstr("left out: "));
      continue;
    }
    EXPECT_LE(number(row, "wall_min"), number(row, "wall_median"));
    EXPECT_LE(number(row, "wall_median"), number(row, "wall_max"));
    EXPECT_EQ(number(row, "repetitions"), 3);
  }
  EXPECT_THAT(read_file(folder.path() / "out.csv"),
              AllOf(HasSubstr("# ra2d: "), HasSubstr("# compiler: "), HasSubstr("# processor: "),
                    HasSubstr("# backend: "), HasSubstr("# date: "),
                    HasSubstr("# scene: six $x^$ shocks\\u000A\\u001B\n"),
                    HasSubstr("# reference: "), HasSubstr("# confirmed: ")));
  const std::vector<Row> long_runs = read_csv(folder.path() / "out-long.csv", header);
  EXPECT_EQ(header,
            "program,scheme,law,contact_force,nodes,step,tolerance,quantity,mean,standard_error,"
            "difference,difference_error,seeds,duration,wall,how");
  EXPECT_GE(long_runs.size(), 3u);
  EXPECT_EQ(fs::exists(folder.path() / "out.png"), can_draw);
  for (const auto& entry : fs::directory_iterator(folder.path()))
    EXPECT_THAT(entry.path().string(), Not(HasSubstr("partial")));
}

TEST(Accuracy, WrongRequestsEndWithTwoAndSayWhy) {
  const Folder folder;
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {program(), "chart", "accuracy"});
    return run_program(folder.path(), words);
  };
  EXPECT_EQ(run({"--bugdet", "3"}).status, 2);
  EXPECT_EQ(run({"--budget", "-3"}).status, 2);
  const Ended nobody = run({"--peers", "no/such/peers"});
  EXPECT_EQ(nobody.status, 2);
  EXPECT_THAT(nobody.err, HasSubstr("no/such/peers"));
  const Ended into_folder = run({"-o", folder.path().string()});
  EXPECT_EQ(into_folder.status, 2);
  EXPECT_THAT(into_folder.err, HasSubstr("a folder"));
  EXPECT_EQ(run({"-o", "no/such/out"}).status, 4);
  EXPECT_EQ(run({"nowhere.toml"}).status, 4);
  const Ended faulty = run({"--set", "time.stp=1"});
  EXPECT_EQ(faulty.status, 2);
  EXPECT_THAT(faulty.err, AllOf(HasSubstr("time.stp"), HasSubstr("dang2012.toml")));
  const Ended help = run({"--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("--budget"), HasSubstr("--peers"), HasSubstr("--no-plot"),
                              HasSubstr("PREFIX"), HasSubstr("--threads")));
}

}  // namespace
}  // namespace ra2d::test
