// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <thread>

#include "host/base/errors.hpp"
#include "host/device/backend.hpp"
#include "host/ensemble/ensemble.hpp"
#include "host/run/samples.hpp"
#include "host/run/v_rms.hpp"
#include "host/savings/face_search.hpp"
#include "host/savings/savings.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/interruption.hpp"
#include "tests/child.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Movement, IsTheRatioOfTheMeans) {
  const Movement m = movement({1, 2, 3}, {1.1, 2.2, 3.3});
  EXPECT_NEAR(m.relative, 0.1, 1e-15);
  EXPECT_NEAR(m.error, 0, 1e-15);  // all pairs moved alike
  EXPECT_EQ(m.pairs, 3);
}

TEST(Movement, ErrorIsThatOfTheMeanOfWhatTheRatioLeaves) {
  // means 10 and 11, ratio 1.1: left are 1, -1, 1, -1, of standard deviation sqrt(4/3)
  const Movement m = movement({10, 10, 10, 10}, {12, 10, 12, 10});
  EXPECT_NEAR(m.relative, 0.1, 1e-15);
  EXPECT_NEAR(m.error, std::sqrt(4.0 / 3) / std::sqrt(4.0) / 10, 1e-15);
  // Student's t, 95.45 %, three degrees of freedom: 3.31
  EXPECT_NEAR(m.margin() / m.error, 3.31, 0.05);
}

TEST(Movement, PairingTakesOutWhatBothShare) {
  // surfaces differ by tens of per cent, the two settings on one of them by 0.1
  std::vector<double> a, b;
  for (int i = 0; i < 32; ++i) {
    a.push_back(1 + 0.3 * std::sin(1.7 * i));
    b.push_back(a.back() * (1.02 + (i % 2 == 0 ? 1e-3 : -1e-3)));
  }
  const Movement m = movement(a, b);
  EXPECT_NEAR(m.relative, 0.02, 3e-4);
  EXPECT_LT(m.error, 3e-4);
}

TEST(Movement, OfNothingIsNone) {
  EXPECT_EQ(movement({0, 0}, {0, 0}).relative, 0);
  EXPECT_EQ(movement({0, 0}, {0, 1}).relative, infinity);
  EXPECT_EQ(movement({1, 2}, {0, 0}).relative, -1);
  EXPECT_EQ(movement({nan, nan}, {nan, 1}).pairs, 0);
  EXPECT_EQ(judge(movement({nan}, {nan}), 0.01), Verdict::kept);
  const Movement m = movement({1, nan, 2, 3}, {1, 5, nan, 3});
  EXPECT_EQ(m.pairs, 2);
  EXPECT_EQ(m.relative, 0);
}

TEST(Judge, WeighsTheMarginOnBothSides) {
  const auto moved = [](double relative, double error) { return Movement{relative, error, 1000}; };
  EXPECT_EQ(judge(moved(0.004, 0.002), 0.01), Verdict::kept);
  EXPECT_EQ(judge(moved(-0.004, 0.002), 0.01), Verdict::kept);
  EXPECT_EQ(judge(moved(0.004, 0.004), 0.01), Verdict::open);
  EXPECT_EQ(judge(moved(0.02, 0.006), 0.01), Verdict::open);
  EXPECT_EQ(judge(moved(-0.02, 0.004), 0.01), Verdict::moved);
  EXPECT_EQ(judge(moved(infinity, 0), 0.01), Verdict::moved);
  // few pairs promise less
  EXPECT_EQ(judge({0.004, 0.002, 4}, 0.01), Verdict::open);
}

TEST(Judge, SaysHowManyPairsWouldDo) {
  // half a per cent of room takes a standard error of a quarter: four times smaller, 16 times as
  // many
  const Movement m{0.005, 0.01, 20};
  ASSERT_EQ(judge(m, 0.01), Verdict::open);
  EXPECT_NEAR(pairs_needed(m, 0.01), 20 * 16, 1e-6);
  EXPECT_EQ(pairs_needed({0.001, 0.001, 20}, 0.01), 20);
  EXPECT_EQ(pairs_needed({0.01, 0.01, 20}, 0.01), infinity);
}

TEST(Judge, IsWrongAboutNoMoreThanOneInTwenty) {
  // a level that moves by exactly the limit is called kept, or moved, by chance alone
  Dice dice(7);
  const auto normal = [&] {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += dice.uniform(0, 1);
    return sum - 6;
  };
  int wrong = 0;
  constexpr int tries = 4000;
  for (int i = 0; i < tries; ++i) {
    std::vector<double> a(6), b(6);
    for (std::size_t k = 0; k < a.size(); ++k) {
      a[k] = 10;
      b[k] = 10 * (1.01 + 0.01 * normal());
    }
    wrong += judge(movement(a, b), 0.01) != Verdict::open;
  }
  EXPECT_LT(wrong, 0.06 * tries);
}

TEST(Variant, ZeroIsTheSceneAndTheOthersDifferBySeedsAlone) {
  Scene s = plate_scene(4, 0.004, 1e-3);
  s.contact.stiffness = 1e12;
  s.resonator.surface = gaussian(1e-6, 1e-3, 7);
  EXPECT_EQ(echo(variant(s, 0)), echo(s));
  Scene other = variant(s, 3);
  EXPECT_NE(other.resonator.surface.seed, 7);
  EXPECT_NE(other.resonator.surface.seed, variant(s, 2).resonator.surface.seed);
  other.resonator.surface.seed = 7;
  EXPECT_EQ(echo(other), echo(s));
  s.resonator.surface.seed = std::numeric_limits<std::int64_t>::max();
  EXPECT_NO_THROW(parse_scene(echo(variant(s, 1)), "s.toml"));
  EXPECT_THAT(varied(s), HasSubstr("seeds"));
}

TEST(Variant, WithoutSeedsTheStartDiffersALittle) {
  Scene s = plate_scene(4, 0.004, 1e-3);
  EXPECT_NE(variant(s, 1).start, s.start);
  EXPECT_NEAR(variant(s, 1).start, s.start, 1e-9 * s.start);
  s.start = 0;
  EXPECT_EQ(varied(s), "");
  s.speed = 1;
  EXPECT_LT(variant(s, 1).speed, 1);
  EXPECT_THAT(varied(s), HasSubstr("scene.speed"));
}

/// A rigid slider with a rough face rubs a plate.
Scene rubbing() {
  Scene s = plate_scene(4, 0.004, 1e-3);
  s.duration = 4e-3;
  s.speed = 1;
  s.gap = 2e-6;
  s.contact.stiffness = 1e12;
  s.output.rate = 1e4;
  s.resonator.surface = gaussian(1e-6, 1e-3, 7);
  s.slider.surface = gaussian(1e-6, 1e-3, 8);
  return s;
}

TEST(Ensemble, AnswersAreThoseOfTheRuns) {
  const Scene s = rubbing();
  Ensemble runs(s);
  runs.extend(3);
  ASSERT_EQ(runs.runs(), 3);
  EXPECT_EQ(runs.failure(), "");
  for (int i = 0; i < 3; ++i) {
    const Recording one = simulate(variant(s, i));
    const Answer& a = runs.answers()[i];
    EXPECT_EQ(a.v_rms, v_rms(one.model, one.end));
    const auto shocks = make_shocks(one.model, one.shocks);
    EXPECT_EQ(a.shock_rate * s.duration,
              static_cast<double>(shocks.size() + one.end.open_shocks.size()));
    EXPECT_NEAR(a.energy_closure, std::abs(one.energy.relative()), 1e-15);
    double first = nan, begin = infinity;
    for (const Shock& shock : shocks)
      if (shock.start > 0 && shock.start < begin) begin = shock.start, first = shock.duration;
    EXPECT_EQ(a.first_duration, first);
  }
  // the way in which they are requested does not matter
  Ensemble others(s);
  for (int n = 1; n <= 3; ++n) others.extend(n);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(others.answers()[i].v_rms, runs.answers()[i].v_rms);
}

TEST(Ensemble, EndsWhereItIsInterrupted) {
  Ensemble runs(rubbing());
  interrupt(SIGINT);
  EXPECT_THROW(runs.extend(1), Interrupted);
  interrupt(0);
  runs.extend(1);
  EXPECT_EQ(runs.runs(), 1);
}

/// A run that is cut off does not count; later it is run as if it had not been.
TEST(Ensemble, KeepsToItsTime) {
  Scene s = rubbing();
  s.duration = 0.2;
  s.speed = 0.02;
  const auto begun = std::chrono::steady_clock::now();
  Ensemble runs(s);
  runs.extend(4, 0);
  EXPECT_EQ(runs.runs(), 0);
  runs.extend(1'000'000, 0.3);
  EXPECT_LT(runs.runs(), 1'000'000);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20));
  s.duration = 4e-3;
  Ensemble whole(s), hurried(s);
  whole.extend(4);
  for (int tries = 0; hurried.runs() < 4 && tries < 1000; ++tries) hurried.extend(4, 1e-4 * tries);
  ASSERT_EQ(hurried.runs(), 4);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(hurried.answers()[i].v_rms, whole.answers()[i].v_rms);
}

/// The budget holds also where the machine becomes slower than the first measurements promised.
TEST(Savings, KeepToTheBudgetUnderLoad) {
  SavingsOptions options;
  options.accuracy = 1e-3;  // which no number of runs can show in that time
  options.budget = 4;
  std::atomic<bool> over = false;
  std::vector<std::thread> load;
  options.progress = [&](const std::string& text) {
    if (!load.empty() || text == "the reference") return;
    for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency(); ++i)
      load.emplace_back([&] {
        while (!over) continue;
      });
  };
  Scene s = rubbing();
  s.duration = 0.1;
  s.speed = 0.04;
  const auto begun = std::chrono::steady_clock::now();
  const Savings found = find_savings(s, options);
  const double took =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  over = true;
  for (std::thread& thread : load) thread.join();
  SCOPED_TRACE(describe(found));
  EXPECT_FALSE(load.empty());
  EXPECT_LT(took, 1.15 * options.budget);
}

/// A force crosses an undamped strip that nothing touches: its modes are independent, so that
/// v_rms^2 of the first M of them is the sum of their parts.
Scene crossing() {
  Scene s = strip_scene(8, 0, 0.14, 0.02);
  s.duration = 0.015;
  s.spacing = 1e-4;
  s.gap = 1e-3;
  s.contact.stiffness = 1e15;
  s.time.step = 1e-7;
  s.output.rate = 1e5;
  s.time.scheme = SchemeKind::backward_euler;
  s.resonator.moving_forces = {{10, 20, 0}};
  return s;
}

TEST(Savings, WhatModesMoveIsWhatTheyCarry) {
  Scene s = crossing();
  s.time.scheme = SchemeKind::adaptive;
  s.time.tolerance = 1e-10;
  const Recording all = simulate(s);
  const double exact = v_rms(all.model, all.end);
  const auto share = [&](int modes) {
    Snapshot first = all.end;
    for (std::size_t k = modes; k < first.resonator_square.size(); ++k)
      first.resonator_square[k] = 0;
    return v_rms(all.model, first) / exact;
  };
  for (const double accuracy : {0.1, 1e-3}) {
    SavingsOptions options;
    options.accuracy = accuracy;
    options.budget = 100;
    const Savings found = find_savings(crossing(), options);
    SCOPED_TRACE(describe(found));
    EXPECT_NEAR(found.mean.v_rms, exact, 1e-6 * exact);
    int fewest = 8;
    for (const Trial& trial : found.trials) {
      if (trial.key != "resonator.modes") continue;
      ASSERT_TRUE(trial.scene.resonator.modes);
      const int modes = *trial.scene.resonator.modes;
      // steps of the scheme that was chosen shift each mode a little differently
      EXPECT_NEAR(trial.moved[0].relative, share(modes) - 1, 0.25 * accuracy);
      if (trial.verdict == Verdict::kept) fewest = std::min(fewest, modes);
    }
    // halving the interval finds where the accuracy is crossed
    EXPECT_LT(fewest, 8);
    EXPECT_LT(1 - share(fewest), 1.25 * accuracy);
    EXPECT_GT(1 - share(fewest - 1), 0.75 * accuracy);
    // savings that are combined hold in combination
    const Scene& chosen = found.chosen;
    EXPECT_GE(*chosen.resonator.modes, fewest);
    const Recording again = simulate(chosen);
    EXPECT_NEAR(v_rms(again.model, again.end), exact, 1.01 * accuracy * exact);
  }
}

TEST(Savings, OfARubbingSceneHoldForIt) {
  SavingsOptions options;
  options.accuracy = 0.1;
  options.budget = 100;
  const Scene s = rubbing();
  const Savings found = find_savings(s, options);
  const std::string text = describe(found);
  SCOPED_TRACE(text);
  EXPECT_THAT(text, AllOf(HasSubstr("other seeds"), HasSubstr("scheme and step"),
                          HasSubstr("modes of the resonator"), HasSubstr("spacing"),
                          HasSubstr("beyond the scene as written"), HasSubstr("\n  resonator: "),
                          HasSubstr("needed"), Not(HasSubstr("nan"))));
  // the written scene says where its choices come from, and is the chosen one
  const std::string planned = planned_scene(found);
  const Scene read = parse_scene(planned, "planned.toml");
  EXPECT_EQ(echo(read), echo(found.chosen));
  EXPECT_THAT(planned, HasSubstr("--accuracy 0.1"));
  // each verdict follows from what moved
  for (const Trial& trial : found.trials) {
    if (!trial.why.empty() || trial.moved[0].pairs == 0) continue;
    bool kept = true, moved = false;
    for (const Movement& m : trial.moved) {
      kept = kept && judge(m, options.accuracy) == Verdict::kept;
      moved = moved || judge(m, options.accuracy) == Verdict::moved;
    }
    EXPECT_EQ(trial.verdict, moved ? Verdict::moved : kept ? Verdict::kept : Verdict::open);
    EXPECT_TRUE(kept || trial.by_balance || !trial.taken);
  }
}

/// A scene read with the words that find_savings gives.
Scene with_words(const Savings& found) {
  const std::vector<std::string> words = set_words(found);
  std::vector<std::string> overrides;
  for (std::size_t i = 0; i < words.size(); i += 2) {
    EXPECT_EQ(words[i], "--set");
    overrides.push_back(words[i + 1]);
  }
  return parse_scene(echo(found.written), "s.toml", overrides);
}

TEST(Savings, CompareLinearFacesWithSmoothOnes) {
  SavingsOptions options;
  options.accuracy = 0.1;
  options.budget = 100;
  const Savings found = find_savings(rubbing(), options);
  const std::string text = describe(found);
  SCOPED_TRACE(text);
  EXPECT_EQ(found.reference.faces, Faces::smooth);
  EXPECT_THAT(text, AllOf(HasSubstr("the scene as written with smooth faces"),
                          HasSubstr("\nfaces and spacing"), HasSubstr("linear, 40 um, as written"),
                          HasSubstr("           faces: ")));
  // linear faces stay only where they hold, or that stays open
  const auto own = std::find_if(found.trials.begin(), found.trials.end(),
                                [](const Trial& trial) { return trial.key == "scene.faces"; });
  ASSERT_NE(own, found.trials.end());
  EXPECT_EQ(own->scene.faces, Faces::linear);
  const bool as_written =
      found.chosen.faces == Faces::linear && found.chosen.spacing == found.written.spacing;
  EXPECT_FALSE(as_written && own->verdict == Verdict::moved);
  const Scene read = with_words(found);
  EXPECT_EQ(read.faces, found.chosen.faces);
  EXPECT_EQ(read.spacing, found.chosen.spacing);
  EXPECT_EQ(read.time, found.chosen.time);
  EXPECT_EQ(echo(parse_scene(planned_scene(found), "planned.toml")), echo(found.chosen));
}

TEST(Savings, CompareSmoothFacesWithLinearOnes) {
  SavingsOptions options;
  options.accuracy = 0.1;
  options.budget = 100;
  Scene s = rubbing();
  s.faces = Faces::smooth;
  s.spacing = 1e-5;  // many cells to a contact: wider ones cost less
  const Savings found = find_savings(s, options);
  const std::string text = describe(found);
  SCOPED_TRACE(text);
  EXPECT_EQ(found.reference.faces, Faces::smooth);
  EXPECT_EQ(faces_as_written(found), nullptr);  // they are the reference's
  EXPECT_THAT(text,
              AllOf(HasSubstr("reference  the scene as written, adaptive"),
                    HasSubstr("\nfaces and spacing"), HasSubstr("  smooth, 20 um"),
                    HasSubstr("           faces: "), Not(HasSubstr("smooth, 10 um, as written "))));
  const Scene read = with_words(found);
  EXPECT_EQ(read.faces, found.chosen.faces);
  EXPECT_EQ(read.spacing, found.chosen.spacing);
  EXPECT_EQ(echo(parse_scene(planned_scene(found), "planned.toml")), echo(found.chosen));
}

/// Splines ring on faces with corners: there the scene's own are the reference.
TEST(Savings, CompareLinearFacesWhereSplinesRing) {
  Scene s = rubbing();
  EXPECT_EQ(with_faces_of_reference(s).faces, Faces::smooth);
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 6e-5}});
  EXPECT_EQ(with_faces_of_reference(s).faces, Faces::linear);
  EXPECT_EQ(with_faces_of_reference(crossing()).faces, Faces::linear);  // flat
  s.faces = Faces::smooth;
  EXPECT_EQ(with_faces_of_reference(s).faces, Faces::smooth);
}

TEST(Savings, AreNeverDearerThanTheSceneAndHaveItsOwnTolerance) {
  Scene s = rubbing();
  s.time.scheme = SchemeKind::adaptive;
  s.time.tolerance = 3e-4;  // loose: all that is tighter is dearer
  SavingsOptions options;
  options.accuracy = 0.2;
  options.budget = 100;
  const Savings found = find_savings(s, options);
  SCOPED_TRACE(describe(found));
  EXPECT_LE(found.cost_chosen, found.cost_written);
  EXPECT_TRUE(std::any_of(found.trials.begin(), found.trials.end(), [](const Trial& trial) {
    return trial.key == "time" && trial.scene.time.tolerance == 3e-4;
  }));
  // what the answer hangs on has been looked at before the cheap things were refined
  const auto place = [&](const std::string& key, bool checked) {
    return std::find_if(found.trials.begin(), found.trials.end(), [&](const Trial& trial) {
      return trial.key == key && trial.checked == checked;
    });
  };
  EXPECT_LT(place("scene.faces", false), place("scene.spacing", true));
  EXPECT_LT(place("scene.spacing", true), place("resonator.modes", false));
  EXPECT_GT(place("scene.spacing", true)->moved[0].pairs, 0);
}

TEST(Savings, ProcessorTimeIsThatOfTheThreads) {
  if (!backend_device().empty()) GTEST_SKIP() << "marches on " << backend_device();
  // the process cannot have used more than it says of the whole
  const Scene s = rubbing();
  const Model model = make_model(s);
  timespec before{}, after{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &before);
  const TimedRun one = timed_run(model, make_start(model));
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &after);
  const double process = static_cast<double>(after.tv_sec - before.tv_sec) +
                         1e-9 * static_cast<double>(after.tv_nsec - before.tv_nsec);
  EXPECT_GT(one.processor, 0);
  EXPECT_LE(one.processor, process);
  EXPECT_LE(one.processor, one.seconds * 1.05 + 1e-3);  // a thread has no more than the clock
}

TEST(Savings, UnderMultipliersTheReferenceIsTheOwnSchemeAtATenthOfTheStep) {
  Scene s = rubbing();
  s.contact.law = ContactLaw::multiplier;
  s.gap.reset();
  s.duration = 1e-3;
  s.time.step = 1e-6;
  SavingsOptions options;
  options.accuracy = 0.3;
  options.budget = 4;
  const Savings found = find_savings(s, options);
  EXPECT_EQ(found.reference.time.scheme, SchemeKind::backward_euler);
  EXPECT_DOUBLE_EQ(found.reference.time.step, 1e-7);
  for (const Trial& trial : found.trials)
    EXPECT_TRUE(is_semi_implicit(trial.scene.time.scheme)) << trial.what;
}

TEST(PlannedScene, FindsItsProfilesFromWhereItIsWritten) {
  const Folder folder;
  fs::create_directory(folder.path() / "profiles");
  fs::create_directory(folder.path() / "out");
  std::ofstream(folder.path() / "profiles" / "flat.csv") << "0,0\n1,0\n";
  Savings s;
  s.accuracy = 0.01;
  s.chosen = s.written = crossing();
  s.chosen.file = s.written.file = folder.path() / "scene.toml";
  s.chosen.resonator.surface.kind = SurfaceKind::file;
  s.chosen.resonator.surface.path = "profiles/flat.csv";
  const fs::path file = folder.path() / "out" / "planned.toml";
  const Scene read = parse_scene(planned_scene(s), file);
  EXPECT_EQ(read.resonator.surface.path, folder.path() / "profiles/flat.csv");
  EXPECT_NO_THROW(make_model(read));
}

class PlanAccuracy : public testing::Test {
 protected:
  Ended run(std::vector<std::string> words) const {
    words.insert(words.begin(), program());
    return run_program(folder_.path(), words);
  }
  const Folder folder_;
};

TEST_F(PlanAccuracy, WritesASceneThatRuns) {
  const Ended planned =
      run({"plan", "--accuracy", "0.01", "--budget", "100", scene_file("moving-force")});
  ASSERT_EQ(planned.status, 0) << planned.err;
  EXPECT_THAT(planned.out, AllOf(HasSubstr("resonator.modes"), HasSubstr("needed"),
                                 HasSubstr("written    moving-force-planned.toml")));
  const fs::path file = folder_.path() / "moving-force-planned.toml";
  EXPECT_THAT(read_file(file),
              AllOf(HasSubstr("# was backward-euler"), HasSubstr("alone it moves")));
  const Ended ran = run({"run", file.string()});
  EXPECT_EQ(ran.status, 0) << ran.err;
}

TEST_F(PlanAccuracy, WrongRequestsAreRefusedBeforeAnythingRuns) {
  std::ofstream(folder_.path() / "own.toml") << read_file(scene_file("moving-force"));
  const auto refused = [&](const std::vector<std::string>& words, const std::string& why,
                           int status = 2) {
    std::vector<std::string> all{"plan", "own.toml"};
    all.insert(all.end(), words.begin(), words.end());
    const Ended ended = run(all);
    EXPECT_EQ(ended.status, status) << fmt::format("{}", fmt::join(all, " "));
    EXPECT_THAT(ended.err, HasSubstr(why));
    EXPECT_EQ(ended.out, "");
  };
  for (const char* accuracy : {"0", "-1", "1", "2", "nan"})
    refused({"--accuracy", accuracy}, "--accuracy");
  refused({"--accuracy", "much"}, "--accuracy");
  for (const char* budget : {"0", "-5", "nan", "inf"})
    refused({"--accuracy", "0.1", "--budget", budget}, "--budget");
  refused({"--budget", "5"}, "--accuracy");
  refused({"-o", "x.toml"}, "--accuracy");
  refused({"--accuracy", "0.1", "-o", "own.toml"}, "would be overwritten");
  refused({"--accuracy", "0.1", "-o", "./"}, "a folder");
  refused({"--accuracy", "0.1", "-o", "no/such/x.toml"}, "no/such", 4);
  // without an adaptive reference the scene's own scheme must hold
  refused({"--accuracy", "0.1", "--set", "contact.law=multiplier", "--set", "time.scheme=heun"},
          "Take time.scheme");
  EXPECT_EQ(read_file(folder_.path() / "own.toml"), read_file(scene_file("moving-force")));
}

TEST_F(PlanAccuracy, ASignalEndsItWithNothingWritten) {
  Child child(folder_.path(),
              {program(), "plan", "--accuracy", "1e-4", "--budget", "1e6", scene_file("dang2012")});
  ASSERT_TRUE(child.wait_until_it_catches(SIGINT));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  child.send(SIGINT);
  EXPECT_EQ(child.wait(), 130) << child.err();
  EXPECT_THAT(child.err(), HasSubstr("interrupted"));
  EXPECT_FALSE(fs::exists(folder_.path() / "dang2012-planned.toml"));
}

}  // namespace
}  // namespace ra2d::test
