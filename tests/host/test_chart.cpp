// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/chart/growth.hpp"
#include "host/chart/stability_chart.hpp"
#include "host/system/partial_file.hpp"
#include "tests/child.hpp"
#include "tests/csv.hpp"
#include "tests/places.hpp"

/// The chart of stability: the march against the theory, and the files that it leaves.
namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr TimeSettings midpoint{SchemeKind::midpoint}, heun{SchemeKind::heun},
    backward_euler{SchemeKind::backward_euler}, rk8{SchemeKind::rk8};

TEST(MeasuredGrowth, OfAFreeModeIsThatOfTheFormulas) {
  // Heun without damping: |R|^2 = 1 + x^4/4; midpoint: 1, though its energy swings; backward Euler:
  // 1/(1 + x^2)
  const std::vector<double> growth = measure_growth(
      {{heun, false, 0.0, 0.01}, {midpoint, false, 0.0, 1.9}, {backward_euler, false, 0.0, 0.5}},
      4096);
  EXPECT_NEAR(growth[0], 0.5 * std::log1p(1e-8 / 4), 1e-14);
  EXPECT_NEAR(growth[1], 0.0, 1e-13);
  EXPECT_NEAR(growth[2], -0.5 * std::log1p(0.25), 1e-12);
}

TEST(MeasuredGrowth, InContactIsThatOfTheTheory) {
  const TrialMode mode(true);
  std::vector<GrowthTrial> trials;
  for (const TimeSettings& choice : chart_schemes())
    for (const double zeta : {0.0, 0.3})
      for (const double x : {0.05, 0.7}) trials.push_back({choice, true, zeta, x});
  const std::vector<double> growth = measure_growth(trials, 4096);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const double theory = std::log(amplification(trials[i].choice, mode.joined(trials[i].zeta),
                                                 mode.stiffness, trials[i].x / mode.omega));
    EXPECT_NEAR(growth[i], theory, 1e-11 + 1e-7 * std::abs(theory)) << "trial " << i;
  }
}

TEST(MeasuredGrowth, OfOneDoesNotReachTheOthersOfItsBatch) {
  // RK8 at x = 10 grows beyond 1e30 m within a few steps, where even the nodes that only fill up a
  // group would touch
  const std::vector<double> growth = measure_growth({{rk8, false, 0.0, 10.0},
                                                     {backward_euler, false, 0.0, 0.01},
                                                     {rk8, true, 0.0, 10.0},
                                                     {backward_euler, true, 0.0, 0.01}},
                                                    4096);
  EXPECT_GT(growth[0], 5.0);
  EXPECT_NEAR(growth[1], -0.5 * std::log1p(1e-4), 1e-12);
  EXPECT_GT(growth[2], 5.0);
  EXPECT_NEAR(growth[3], -0.5 * std::log1p(1e-7), 1e-11);
}

TEST(Chart, TheMarchShowsTheLimitsOfTheTheory) {
  const ChartOptions options{.zetas = {0.0, 0.02, 0.7}, .steps = 1024, .precision = 1e-3};
  const std::vector<Limit> limits = make_limits(options);
  EXPECT_EQ(limits.size(), 2 * chart_schemes().size() * options.zetas.size());
  int found = 0;
  for (const Limit& limit : limits) {
    SCOPED_TRACE(testing::Message()
                 << "scheme " << static_cast<int>(limit.choice.scheme) << ", force "
                 << static_cast<int>(limit.choice.contact_force) << ", contact " << limit.contact
                 << ", zeta " << limit.zeta << ": theory " << limit.theory);
    if (limit.theory == 0 || std::isinf(limit.theory)) {
      EXPECT_EQ(limit.low == 0, limit.theory == 0) << limit.low;
      EXPECT_EQ(std::isinf(limit.high), std::isinf(limit.theory)) << limit.high;
    } else {
      ++found;
      EXPECT_LE(limit.high - limit.low, options.precision * limit.high);
      EXPECT_LT(limit.low, 1.0005 * limit.theory);
      EXPECT_GT(limit.high, 0.9995 * limit.theory);
    }
    EXPECT_NEAR(limit.growth_measured, limit.growth_theory,
                1e-11 + 1e-6 * std::abs(limit.growth_theory));
  }
  // of each zeta; without damping three of them hold at no step
  EXPECT_EQ(found, 2 * (5 + 8) + (3 + 5));
}

TEST(Chart, TheProgramPrintsTheTableAndWritesItsFiles) {
  const Folder folder;
  const bool can_draw =
      run_program(folder.path(), {python(), "-c", "import matplotlib"}).status == 0;
  // a name that is no formula, and no line of its own
  std::vector<std::string> words{program(),   "chart",
                                 "stability", scene_file("peaks"),
                                 "--set",     "time.step=2e-8",
                                 "--set",     "scene.name=$x^$ \\frac\n\x1b",
                                 "-o",        "out"};
  if (!can_draw) words.emplace_back("--no-plot");
  const Ended run = run_program(folder.path(), words);
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out, AllOf(HasSubstr("backward Euler, new force"), HasSubstr("O(tau^9)"),
                             HasSubstr("tau < sqrt(2)/omega"), HasSubstr("2.828 | 2.828("),
                             HasSubstr("zeta = 0.7"), HasSubstr("out-regions.csv")));
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120u) << line;

  std::string header;
  const std::vector<Row> limits = read_csv(folder.path() / "out.csv", header);
  EXPECT_EQ(header,
            "scheme,contact_force,order,stages,contact,zeta,motion_zeta,theory,measured_low,"
            "measured_high,growth_x,growth_theory,growth_measured");
  EXPECT_EQ(limits.size(), 9u * 2 * 4);
  for (const Row& row : limits)
    EXPECT_LT(number(row, "measured_low"), number(row, "measured_high"));

  const std::vector<Row> regions = read_csv(folder.path() / "out-regions.csv", header);
  EXPECT_EQ(header, "scheme,contact_force,contact,zeta,limit,re,im");
  for (const Row& row : regions) {
    if (row.at("re").empty()) {
      EXPECT_TRUE(std::isinf(number(row, "limit")));
      continue;
    }
    const double limit = number(row, "limit");
    EXPECT_NEAR(std::hypot(number(row, "re"), number(row, "im")), limit, 1e-6 * limit);
    if (row.at("scheme") == "explicit-euler" && row.at("contact") == "open") {
      EXPECT_NEAR(limit, 2 * number(row, "zeta"), 1e-6 * limit);
    }
  }

  const std::vector<Row> modes = read_csv(folder.path() / "out-modes.csv", header);
  EXPECT_EQ(header, "contact,body,mode,frequency,zeta,re,im");
  const auto of = [&](const char* contact) {
    return std::count_if(modes.begin(), modes.end(),
                         [&](const Row& row) { return row.at("contact") == contact; });
  };
  EXPECT_GT(of("open"), 0);
  EXPECT_GT(of("closed"), 0);
  for (const Row& row : modes)
    EXPECT_NEAR(std::hypot(number(row, "re"), number(row, "im")),
                2 * M_PI * 2e-8 * number(row, "frequency"), 1e-10);

  EXPECT_EQ(fs::exists(folder.path() / "out.png"), can_draw);
  if (can_draw) {
    EXPECT_THAT(read_file(folder.path() / "out.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
  }
  for (const auto& entry : fs::directory_iterator(folder.path()))
    EXPECT_THAT(entry.path().string(), Not(HasSubstr("partial")));
}

constexpr auto stepless = R"([scene]
duration = 1e-3
speed = 0.0
start = 0.0
spacing = 1e-3
[resonator]
support = "pinned"
length = 0.3
thickness = 0.002
width = 0.2
young = 210e9
density = 7800
damping = 0.02
modes = 3
[slider]
support = "rigid"
length = 0.1
width = 0.2
[contact]
stiffness = 1e13
[time]
scheme = "adaptive"
)";

TEST(Chart, WrongRequestsEndWithTwoAndSayWhy) {
  const Folder folder;
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {program(), "chart"});
    return run_program(folder.path(), words);
  };
  EXPECT_EQ(run({}).status, 2);
  const Ended unknown = run({"stabilty"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err,
              AllOf(HasSubstr("'stabilty'"), HasSubstr("'stability'"), HasSubstr("'accuracy'")));
  const Ended faulty = run({"stability", "--set", "time.stp=1"});
  EXPECT_EQ(faulty.status, 2);
  EXPECT_THAT(faulty.err, AllOf(HasSubstr("time.stp"), HasSubstr("dang2012.toml")));
  write_text(folder.path() / "stepless.toml", stepless);
  const Ended without_step = run({"stability", "stepless.toml"});
  EXPECT_EQ(without_step.status, 2);
  EXPECT_THAT(without_step.err, AllOf(HasSubstr("stepless.toml:21: time.step: missing"),
                                      HasSubstr("--set time.step=1e-8")));
  EXPECT_EQ(run({"stability", "nowhere.toml"}).status, 4);
  const Ended help = run({"stability", "--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("--no-plot"), HasSubstr("PREFIX"), HasSubstr("--threads"),
                              HasSubstr("--set"), HasSubstr("--quiet")));
}

TEST(Chart, FilesThatCannotBeWrittenAreFileErrors) {
  const Folder folder;
  EXPECT_THROW(write_text(folder.path() / "no" / "such.csv", "x"), FileError);
  write_text(folder.path() / "a.csv", "one\n");
  write_text(folder.path() / "a.csv", "two\n");
  EXPECT_EQ(read_file(folder.path() / "a.csv"), "two\n");
}

}  // namespace
}  // namespace ra2d::test
