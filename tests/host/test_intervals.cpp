// SPDX-License-Identifier: BSD-3-Clause
/// Error bars: of one run, of several, of a study's law; and what a law does where it bends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <random>

#include "host/analysis/distributions.hpp"
#include "host/analysis/level_history.hpp"
#include "host/analysis/means.hpp"
#include "host/analysis/mesh_tone.hpp"
#include "host/analysis/peaks.hpp"
#include "host/analysis/spectrum.hpp"
#include "host/base/decompositions.hpp"
#include "host/study/clusters.hpp"
#include "host/study/law.hpp"
#include "host/study/study_csv.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"

namespace ra2d {
namespace {

using test::nan;
using testing::HasSubstr;

/// Four standard deviations of a share of so many trials.
double chance_of_share(double share, int trials) {
  return 4 * std::sqrt(share * (1 - share) / trials);
}

// ---- several runs
// --------------------------------------------------------------------------------

TEST(MeanOfPositive, IsStudentsOfTheLogarithm) {
  const MeanOfRuns m = mean_of_runs({1, 2, 3}, Values::positive);
  EXPECT_DOUBLE_EQ(m.mean, 2);
  const double half = 4.302652729911275 / std::sqrt(3.0) / 2;  // t of 2 degrees; deviation 1
  EXPECT_NEAR(m.low, 2 * std::exp(-half), 1e-9);
  EXPECT_NEAR(m.high, 2 * std::exp(half), 1e-9);
  for (const Values kind : {Values::any, Values::positive, Values::share})  // no scatter
    for (const double value : {0.0, 0.3, 1.0})
      EXPECT_TRUE(std::isnan(mean_of_runs({value, value, value}, kind).low));
  // shares stay between 0 and 1, and those of the rest are the rest of theirs
  for (const std::vector<double>& shares :
       {std::vector<double>{0.5, 0.9}, {0.01, 0.99}, {1e-9, 0.3, 0.2}, {0.999, 1, 1}}) {
    std::vector<double> rest = shares;
    for (double& share : rest) share = 1 - share;
    const MeanOfRuns of = mean_of_runs(shares, Values::share),
                     other = mean_of_runs(rest, Values::share);
    EXPECT_GE(of.low, 0);
    EXPECT_LE(of.low, of.mean);
    EXPECT_GE(of.high, of.mean);
    EXPECT_LE(of.high, 1);
    EXPECT_NEAR(other.low, 1 - of.high, 1e-12);
  }
  EXPECT_GT(mean_of_runs({0, 0, 1}, Values::positive).low, 0);
}

TEST(MeanOfPositive, OfSkewedRatesHoldsTheTruthMoreOftenThanStudents) {
  std::mt19937_64 dice(1);
  std::lognormal_distribution<double> rate(0, 0.55);  // as at 0.02 m/s
  const double truth = std::exp(0.55 * 0.55 / 2);
  constexpr int trials = 4000;
  int plain = 0, positive = 0;
  for (int i = 0; i < trials; ++i) {
    std::vector<double> values(5);
    for (double& value : values) value = rate(dice);
    const auto holds = [&](const MeanOfRuns& m) { return m.low <= truth && truth <= m.high; };
    plain += holds(mean_of_runs(values)) ? 1 : 0;
    positive += holds(mean_of_runs(values, Values::positive)) ? 1 : 0;
  }
  EXPECT_GT(positive, plain + trials / 100);
  EXPECT_GT(positive, 0.92 * trials);
}

// ---- one run
// -------------------------------------------------------------------------------------

/// The mean square of an oscillator that noise drives, in 200 parts: it forgets within 1/(2 zeta
/// omega).
LevelHistory ringing_history(std::mt19937_64& dice, double seconds, double ringing) {
  std::normal_distribution<double> normal;
  constexpr int steps_of_part = 10;
  const double step = seconds / (200 * steps_of_part), keep = std::exp(-step / (2 * ringing));
  const double drive = std::sqrt(1 - keep * keep);
  double a = normal(dice), b = normal(dice);  // the envelope: power forgets twice as fast
  LevelHistory history{0, seconds / 200, {}, {}};
  for (int part = 0; part < 200; ++part) {
    double sum = 0;
    for (int i = 0; i < steps_of_part; ++i) {
      a = keep * a + drive * normal(dice);
      b = keep * b + drive * normal(dice);
      sum += (a * a + b * b) / 2;
    }
    history.mean_square.push_back(sum / steps_of_part);
    history.shocks.push_back(1 + part % 2);
  }
  return history;
}

TEST(IntervalsOfRun, HoldTheTruthThoughAModeRingsOn) {
  std::mt19937_64 dice(2);
  constexpr int trials = 1500;
  for (const double lengths : {12.0, 100.0}) {
    int held = 0;
    for (int i = 0; i < trials; ++i) {
      const LevelHistory history = ringing_history(dice, lengths, 1);
      const double mean =
          std::accumulate(history.mean_square.begin(), history.mean_square.end(), 0.0) / 200;
      const Interval found = intervals_of_run(history, 10 * std::log10(mean), 1.5, 1).level;
      held += found.low <= 0 && 0 <= found.high ? 1 : 0;
    }
    // of powers as skewed as these Student's t holds a little less than it promises
    EXPECT_GT(held, (0.95 - 0.035) * trials - chance_of_share(0.95, trials) * trials) << lengths;
    EXPECT_LT(held, 0.985 * trials) << lengths;
  }
}

TEST(IntervalsOfRun, OfPartsWithoutMemoryIsStudentsOfTen) {
  LevelHistory history{0, 0.01, std::vector<double>(200), std::vector<double>(200, 100.0)};
  for (std::size_t i = 0; i < 200; ++i) history.mean_square[i] = i / 20 % 2 == 0 ? 1 : 3;
  const IntervalsOfRun found = intervals_of_run(history, 90, 100, 0);
  const double half = 2.2621571628 * std::sqrt(10.0 / 9) / std::sqrt(10.0) / 2;
  EXPECT_NEAR(found.level.high - 90, 10 * std::log10(std::numbers::e) * half, 1e-8);
  EXPECT_NEAR(90 - found.level.low, 10 * std::log10(std::numbers::e) * half, 1e-8);
  EXPECT_TRUE(std::isnan(found.shock_rate.low)) << "equal parts show no chance";
  EXPECT_EQ(found.why_none, "");
}

TEST(IntervalsOfRun, SayWhyThereIsNone) {
  const LevelHistory history{0, 0.01, std::vector<double>(200, 1.0), std::vector<double>(200, 1.0)};
  for (const auto& [found, why] :
       {std::pair{intervals_of_run(history, 90, 1, 0.3), "3 s or more are needed"},
        {intervals_of_run(history, 90, 1, HUGE_VAL), "never forgets"},
        {intervals_of_run(history, 90, 1, nan), "scene is not known"},
        {intervals_of_run(history, -HUGE_VAL, 1, 0), "there is no level"},
        {intervals_of_run({0, 0.01, {1, 2}, {1, 2}}, 90, 1, 0), "too few samples"}}) {
    EXPECT_THAT(found.why_none, HasSubstr(why));
    EXPECT_TRUE(std::isnan(found.level.low) && std::isnan(found.shock_rate.high)) << why;
  }
  EXPECT_NEAR(ringing_of({0, 0, 80, 300}, 0.02), 1 / (2 * 0.02 * 2 * M_PI * 80), 1e-15);
  EXPECT_EQ(ringing_of({0, 0}, 0.02), 0);
  EXPECT_TRUE(std::isinf(ringing_of({80}, 0)));
}

TEST(LevelParts, OfRowsAndOfColumnsAreTheSameBits) {
  constexpr std::size_t first = 7, count = 1003, modes = 3;
  std::mt19937_64 dice(3);
  std::normal_distribution<double> normal;
  std::vector<double> rows((first + count) * modes);
  for (double& value : rows) value = normal(dice);
  LevelParts by_rows(first, count, 1e3, modes), by_columns(first, count, 1e3, modes);
  for (std::size_t at = 0; at < first + count; at += 100) {
    const std::size_t now = std::min<std::size_t>(100, first + count - at);
    by_rows.add_rows(at, {rows.data() + at * modes, now * modes});
  }
  for (std::size_t k = 0; k < modes; ++k) {
    std::vector<double> column;
    for (std::size_t i = 0; i < count; ++i) column.push_back(rows[(first + i) * modes + k]);
    by_columns.add_column(k, column);
  }
  for (LevelParts* parts : {&by_rows, &by_columns})
    for (const double start : {0.0069, 0.0071, 0.0119, 0.5}) parts->add_shock(start);
  const LevelHistory a = by_rows.history({1, 0, 2}), b = by_columns.history({1, 0, 2});
  EXPECT_EQ(a.mean_square, b.mean_square);
  EXPECT_EQ(a.shocks, b.shocks);
  ASSERT_EQ(a.mean_square.size(), 200u);
  EXPECT_DOUBLE_EQ(a.part_seconds, 0.005);
  EXPECT_NEAR(a.shocks[0], 2 / 0.005, 1e-9);  // the first began before
  double sum = 0;
  for (std::size_t i = first; i < first + 5; ++i)
    sum += rows[i * modes] * rows[i * modes] + 2 * rows[i * modes + 2] * rows[i * modes + 2];
  EXPECT_NEAR(a.mean_square[0], sum / 5, 1e-14 * sum);
}

// ---- the mesh's tone
// -------------------------------------------------------------------------------

struct Signal {
  std::vector<double> rows;  // of two modes
  double welch = 0;          // the tone's rise by the spectrum of all lines
};

/// Coloured noise, far stronger at low frequencies, with a tone of an amplitude in mode 1.
Signal signal_with_tone(std::mt19937_64& dice, std::size_t samples, double rate, double tone,
                        double amplitude) {
  std::normal_distribution<double> normal;
  std::vector<double> one(samples), two(samples);
  Signal signal;
  double slow = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    slow = 0.999 * slow + normal(dice);
    one[i] = slow + normal(dice);
    two[i] = normal(dice) + amplitude * std::cos(2 * M_PI * tone * static_cast<double>(i) / rate);
    signal.rows.insert(signal.rows.end(), {one[i], two[i]});
  }
  Welch welch(half_overlapping(rate, usual_segment(samples)));
  std::vector<double> density = welch.density(one), other = welch.density(two);
  for (std::size_t j = 0; j < density.size(); ++j) density[j] += 3 * other[j];
  signal.welch = rise_at({welch.frequencies()[1], density}, tone);
  return signal;
}

TEST(MeshToneWatch, RisesAsTheWholeSpectrumHasIt) {
  std::mt19937_64 dice(4);
  for (const std::size_t samples : {3000, 20'000, 100'001})
    for (const double tone : {12'500.0, 21'234.5}) {
      const Signal signal = signal_with_tone(dice, samples, 100e3, tone, 0.2);
      MeshToneWatch watch(tone, 0, samples, 100e3, 2);
      for (std::size_t at = 0; at < samples; at += 777)
        watch.add_rows(at,
                       {signal.rows.data() + 2 * at, 2 * std::min<std::size_t>(777, samples - at)});
      const MeshTone found = watch.tone({1, 3}, {}, 0.02);
      EXPECT_NEAR(found.rise, signal.welch, 0.05) << samples << ' ' << tone;
      EXPECT_TRUE(found.in_spectrum);
    }
}

TEST(MeshToneWatch, WithoutAToneNothingStandsOutAndAStrongOneDoes) {
  std::mt19937_64 dice(5);
  std::normal_distribution<double> normal;
  constexpr std::size_t samples = 4000;
  constexpr int trials = 1500;
  int false_alarms = 0;
  for (int i = 0; i < trials; ++i) {
    std::vector<double> rows(samples);
    for (double& value : rows) value = normal(dice);
    MeshToneWatch watch(12.5e3, 0, samples, 100e3, 1);
    watch.add_rows(0, rows);
    false_alarms += watch.tone({1}, {}, 0.02).stands_out() ? 1 : 0;
  }
  EXPECT_LE(false_alarms, 1e-3 * trials + 4 * std::sqrt(1e-3 * trials));
  const Signal strong = signal_with_tone(dice, samples, 100e3, 12.5e3, 1);
  MeshToneWatch watch(12.5e3, 0, samples, 100e3, 2);
  watch.add_rows(0, strong.rows);
  EXPECT_TRUE(watch.tone({1, 3}, {}, 0.02).stands_out());
}

TEST(MeshToneWatch, AModeOfItsOwnIsNoTone) {
  // lines of 97.7 Hz: a peak of 500 Hz at half its height is as narrow as a tone
  EXPECT_EQ(rise_of_a_mode({3e3, 20e3}, 0.02, 12.5e3, 97.7), 0);
  const double coarse = rise_of_a_mode({12.2e3}, 0.02, 12.5e3, 97.7),
               fine = rise_of_a_mode({12.4e3}, 0.02, 12.5e3, 12.2);
  // lines 11 and 12 away are the middle ones: half widths of 250 Hz
  const auto lorentz = [](double away) { return 1 / (1 + away * away / 250 / 250); };
  EXPECT_NEAR(coarse, -10 * std::log10((lorentz(11 * 97.7) + lorentz(12 * 97.7)) / 2), 1e-9);
  EXPECT_TRUE(std::isinf(rise_of_a_mode({12.2e3}, 0, 12.5e3, 97.7)));  // a line of its own
  EXPECT_GT(coarse, 10);
  EXPECT_LT(fine, 2);
}

TEST(MeshToneWatch, BeyondTheSpectrumOrInTooShortARunHasNone) {
  for (const auto& [tone, samples] : {std::pair{60e3, 10'000}, {12.5e3, 10}, {100.0, 1000}}) {
    MeshToneWatch watch(tone, 0, static_cast<std::size_t>(samples), 100e3, 1);
    watch.add_rows(0, std::vector<double>(static_cast<std::size_t>(samples), 1.0));
    EXPECT_TRUE(std::isnan(watch.tone({1}, {}, 0.02).rise)) << tone;
    EXPECT_FALSE(watch.tone({1}, {}, 0.02).stands_out());
  }
}

// ---- what the program prints
// ---------------------------------------------------------------------

std::string line_with(const std::string& text, const std::string& what, const std::string& from) {
  const std::size_t at = text.find(from, text.find(what));
  return at == text.npos ? "none" : text.substr(at, text.find_first_of(";\n", at + 2) - at);
}

/// The report of a run, also of one that went on from a checkpoint, the analysis and the page say
/// the same.
TEST(ErrorBars, OfOneRunAreTheSameWhereverTheyStand) {
  const test::Folder folder;
  const auto ra2d = [&](std::vector<std::string> words) {
    words.insert(words.begin(), test::program());
    return test::run_program(folder.path(), words);
  };
  const auto simulate = [&](const std::string& file, const std::string& most_wall) {
    std::vector<std::string> words{"run",          test::scene_file("dang2012"),
                                   "-o",           file,
                                   "--threads",    "1",
                                   "--max-wall",   most_wall,
                                   "--checkpoint", "0.001"};
    for (const char* set : {"time.scheme=adaptive", "time.tolerance=1e-4", "scene.duration=0.9",
                            "output.rate=4e4", "output.from=0.05"})
      words.insert(words.end(), {"--set", set});
    return ra2d(words);
  };
  const test::Ended whole = simulate("whole.h5", "600");
  ASSERT_EQ(whole.status, 0) << whole.err;
  simulate("cut.h5", "0.1");
  const test::Ended cut = simulate("cut.h5", "600");
  ASSERT_EQ(cut.status, 0) << cut.err;
  const test::Ended said = ra2d({"analyze", "whole.h5"});
  const std::string level = line_with(whole.out, "level Lv", "; 95 %"),
                    rate = line_with(whole.out, "shocks", "; 95 %");
  EXPECT_THAT(level, HasSubstr(" dB, with these surfaces"));
  EXPECT_NE(rate, "none");
  const std::string tone = line_with(whole.out, "mesh tone", "12500 Hz");
  EXPECT_THAT(tone, HasSubstr("linear faces make it"));
  for (const std::string& text : {cut.out, said.out}) {
    EXPECT_EQ(line_with(text, "level Lv", "; 95 %"), level);
    EXPECT_EQ(line_with(text, "shocks", "; 95 %"), rate);
  }
  EXPECT_EQ(line_with(cut.out, "mesh tone", "12500 Hz"), tone);
  EXPECT_EQ(line_with(said.out, "mesh tone", "12500 Hz").substr(0, 34), tone.substr(0, 34));
  ASSERT_EQ(ra2d({"report", "whole.h5"}).status, 0);
  EXPECT_THAT(test::read_file(folder.path() / "whole.html"), HasSubstr(level));
  ASSERT_EQ(ra2d({"analyze", "whole.h5", "--csv", "x"}).status, 0);
  EXPECT_THAT(test::read_file(folder.path() / "x-figures.csv"),
              testing::StartsWith("of,level_dB,level_low_dB,level_high_dB,shocks_1/s"));
}

TEST(MeshToneWatch, HasNothingToWatchBetweenSmoothFaces) {
  const test::Folder folder;
  const auto said = [&](const char* faces) {
    const auto ra2d = [&](std::vector<std::string> words) {
      words.insert(words.begin(), test::program());
      return test::run_program(folder.path(), words);
    };
    std::vector<std::string> run{"run",   test::scene_file("dang2012"), "-o", "a.h5", "--force",
                                 "--json"};
    for (const std::string& set :
         {std::string("scene.faces=") + faces, std::string("time.scheme=adaptive"),
          std::string("scene.duration=0.01")})
      run.insert(run.end(), {"--set", set});
    const test::Ended ran = ra2d(run), analyzed = ra2d({"analyze", "a.h5"}),
                      plan = ra2d({"plan", test::scene_file("dang2012"), "--set", run[7]});
    return std::array{nlohmann::json::parse(ran.out)["mesh_tone"]["frequency"].dump(),
                      line_with(analyzed.out, "mesh tone", "12500 Hz"),
                      line_with(plan.out, "note", "12500 Hz")};
  };
  const auto [of_run, of_analysis, of_plan] = said("linear");
  EXPECT_DOUBLE_EQ(std::stod(of_run), 12.5e3);
  EXPECT_NE(of_analysis, "none");
  EXPECT_NE(of_plan, "none");
  EXPECT_THAT(said("smooth"), testing::ElementsAre("null", "none", "none"));
}

// ---- clusters
// --------------------------------------------------------------------------------------

TEST(Tails, AreThoseOfTheTables) {
  // Abramowitz and Stegun, table 26.9: its last digit is rounded
  EXPECT_NEAR(fisher_tail(3.33, 5, 10), 0.05, 0.005 * 0.06);
  EXPECT_NEAR(fisher_tail(5.64, 5, 10), 0.01, 0.005 * 0.01);
  for (const double f : {0.3, 4.74, 50.0})  // in closed form
    EXPECT_NEAR(fisher_tail(f, 2, 7) / std::pow(1 + 2 * f / 7, -3.5), 1, 1e-12) << f;
  EXPECT_NEAR(fisher_tail(3, 2, 2), 1 / (1 + 3.0), 1e-14);  // closed form
  EXPECT_EQ(fisher_tail(0, 2, 2), 1);
  EXPECT_EQ(fisher_tail(HUGE_VAL, 2, 2), 0);
  EXPECT_NEAR(student_tail(2.77645, 4), 0.05, 1e-6);
  EXPECT_NEAR(student_tail(-2.77645, 4), 0.05, 1e-6);
}

TEST(ClusteredErrors, OfEqualClustersAreStudentsOfTheirSlopes) {
  std::mt19937_64 dice(6);
  std::normal_distribution<double> normal;
  constexpr int points = 5, seeds = 4;
  Eigen::MatrixXd x(points * seeds, 2);
  Eigen::VectorXd y(points * seeds);
  std::vector<std::size_t> cluster;
  std::vector<double> slopes;
  for (int s = 0; s < seeds; ++s) {
    const double shift = normal(dice), turn = normal(dice);
    double product = 0;
    for (int p = 0; p < points; ++p) {
      const double at = p - 2.0;
      x.row(s * points + p) << 1, at;
      y(s * points + p) = shift + turn * at + 0.1 * normal(dice);
      product += at * y(s * points + p) / 10;
      cluster.push_back(static_cast<std::size_t>(s));
    }
    slopes.push_back(product);
  }
  const Eigen::VectorXd residuals = y - x * LeastSquares(x).solve(y);
  const std::vector<CoefficientError> errors = clustered_errors(x, residuals, cluster);
  EXPECT_NEAR(errors[1].error, mean_of_runs(slopes).deviation / 2, 1e-12);
  EXPECT_NEAR(errors[1].degrees_of_freedom, 3, 1e-9);
}

/// log10 v_rms of a grid of three loads and four speeds: a plane, plus what a seed adds to it.
struct GridOfRuns {
  std::vector<StudyAxis> axes = {
      {"speed", {0.05, 0.1, 0.2, 0.4}, {}}, {"load", {0.15, 0.6, 2.4}, {}}, {"seed", {}, {}}};
  std::mt19937_64 dice{7};
  double own = 0.02, shift = 0.08, turn = 0.05, curvature = 0, lost = 0;
  StudyAnswers answers(std::size_t seeds) {
    std::normal_distribution<double> normal;
    axes[2].numbers.resize(seeds);
    std::iota(axes[2].numbers.begin(), axes[2].numbers.end(), 0.0);
    StudyAnswers made;
    made.axes = axes;
    std::vector<double> shifts(seeds), turns(seeds);
    for (double& value : shifts) value = shift * normal(dice);
    for (double& value : turns) value = turn * normal(dice);
    for (const double speed : axes[0].numbers)
      for (const double load : axes[1].numbers)
        for (std::size_t s = 0; s < seeds; ++s) {
          const double v = std::log10(speed), l = std::log10(load / 0.6);
          const double y = 1.1 * v + 0.1 * l + curvature * l * l + shifts[s] +
                           turns[s] * (v + 0.85) + own * normal(dice);
          const bool gone = std::uniform_real_distribution<>()(dice) < lost;
          made.v_rms.push_back(gone ? std::nan("") : std::pow(10.0, y));
          made.status.push_back(gone ? 3 : 0);
        }
    return made;
  }
};

TEST(StudyLaw, IntervalsBySeedsHoldTheTruthThoughRunsOfASeedAreAlike) {
  constexpr int trials = 1200;
  for (const double lost : {0.0, 0.1})
    for (const std::size_t seeds : {3, 8}) {
      GridOfRuns grid;
      grid.lost = lost;
      int held = 0;
      for (int i = 0; i < trials; ++i) {
        const Exponent speed = fit_law(grid.answers(seeds)).exponents[0];
        held += speed.low <= 1.1 && 1.1 <= speed.high ? 1 : 0;
      }
      EXPECT_NEAR(held / static_cast<double>(trials), 0.95, 0.01 + chance_of_share(0.95, trials))
          << seeds << " seeds, " << lost << " lost";
    }
}

TEST(StudyLaw, RaisesAFalseAlarmOverAStraightLineInOneOfTwenty) {
  constexpr int trials = 2000;
  for (const std::size_t seeds : {3, 5, 10}) {
    GridOfRuns grid;
    int alarms = 0;
    for (int i = 0; i < trials; ++i) alarms += fit_law(grid.answers(seeds)).line.bends() ? 1 : 0;
    const double share = alarms / static_cast<double>(trials);
    EXPECT_LT(share, 0.06 + chance_of_share(0.05, trials)) << seeds;
    EXPECT_GT(share, seeds > 3 ? 0.02 : 0.005) << seeds;
  }
}

TEST(StudyLaw, SaysWhereAnExponentBends) {
  GridOfRuns grid;
  grid.curvature = -0.08;  // slope 0.1 - 0.16 log10(load/0.6): from 0.196 to 0.004
  int found = 0;
  constexpr int trials = 100;
  for (int i = 0; i < trials; ++i) {
    const StudyLaw law = fit_law(grid.answers(5));
    if (!law.line.bends() || law.line.changes.empty()) continue;
    const LocalExponent& first = law.line.changes.front();
    found += first.of == "load" && first.along == "load" ? 1 : 0;
    if (first.of != "load" || first.along != "load") continue;
    EXPECT_EQ(first.from, 0.15);
    EXPECT_EQ(first.to, 2.4);
    EXPECT_NEAR(first.exponent_from, 0.1 + 0.16 * std::log10(4.0), 0.09);
    EXPECT_NEAR(first.exponent_to, 0.1 - 0.16 * std::log10(4.0), 0.09);
  }
  EXPECT_GT(found, 0.9 * trials);  // power
  const StudyAnswers answers = grid.answers(5);
  const std::string text = describe_study(answers, "x");
  EXPECT_THAT(text, testing::AllOf(HasSubstr("a straight line does not fit (lack of fit: p = "),
                                   HasSubstr("the exponent of load falls from 0."),
                                   HasSubstr("intervals by the 5 seeds")));
  const auto json = nlohmann::json::parse(study_json(answers));
  EXPECT_EQ(json["law"]["straight_line"]["fits"], false);
  EXPECT_EQ(json["law"]["straight_line"]["changes"][0]["of"], "load");
}

TEST(StudyLaw, SaysWhyAStraightLineCannotBeTested) {
  GridOfRuns grid;
  EXPECT_THAT(fit_law(grid.answers(1)).line.why_not_tested, HasSubstr("two seeds or more"));
  grid.own = grid.shift = grid.turn = 0;  // no surface has a seed
  const StudyLaw same = fit_law(grid.answers(4));
  EXPECT_EQ(same.seeds, 1u);
  EXPECT_THAT(same.line.why_not_tested, HasSubstr("two seeds or more that differ"));
  GridOfRuns two;
  two.axes = {{"speed", {0.1, 0.2}, {}}, {"load", {1}, {}}, {"seed", {}, {}}};
  EXPECT_EQ(fit_law(two.answers(3)).line.why_not_tested,
            "it takes more than 2 points, so that one is left over, there are 2");
  StudyAnswers shard = GridOfRuns{}.answers(4);  // of each point two seeds have run
  for (std::size_t run = 0; run < shard.v_rms.size(); ++run)
    if ((run + run / 4) % 4 < 2) shard.v_rms[run] = std::nan("");
  EXPECT_EQ(fit_law(shard).line.why_not_tested,
            "it takes more than 3 points with two thirds of the seeds, so that one is left over, "
            "there are none");
  two.lost = 0.999;
  EXPECT_THAT(describe_study(two.answers(3), "x"), HasSubstr("no law yet"));
}

/// numpy finds the same by the definitions, with matrices as large as the table.
TEST(StudyLaw, AgreesWithNumpy) {
  RA2D_SKIP_WITHOUT_PYTHON();
  const test::Folder folder;
  for (const double lost : {0.0, 0.05}) {
    GridOfRuns grid;
    grid.curvature = -0.08;
    grid.lost = lost;
    const StudyAnswers answers = grid.answers(12);
    nlohmann::json table{{"axes", nlohmann::json::array()}, {"v_rms", answers.v_rms}};
    for (const StudyAxis& axis : answers.axes) table["axes"].push_back(axis.numbers);
    std::ofstream(folder.path() / "table.json") << table;
    std::ofstream(folder.path() / "said.json") << study_json(answers);
    const test::Ended checked = test::run_program(
        folder.path(), {test::python(), test::source_folder() / "tests/host/check_law.py",
                        "table.json", "said.json"});
    EXPECT_EQ(checked.status, 0) << lost << ": " << checked.out << checked.err;
  }
}

TEST(StudyMeans, HaveTheRateWithItsInterval) {
  StudyAnswers answers;
  answers.axes = {{"speed", {0.1, 0.2}, {}}, {"a, b", {}, {"x\"y"}}, {"seed", {0, 1, 2}, {}}};
  answers.v_rms = {1e-4, 2e-4, 4e-4, 1e-3, 1e-3, std::nan("")};
  answers.shock_rate = {10, 20, 30, 0, 0, std::nan("")};
  answers.status = {0, 0, 0, 0, 0, 3};
  const MeanOfRuns rate = combination_means(answers)[0].shock_rate;
  EXPECT_DOUBLE_EQ(rate.mean, 20);
  EXPECT_EQ(rate.low, mean_of_runs({10, 20, 30}, Values::positive).low);
  EXPECT_THAT(describe_study(answers, "x"), HasSubstr("shocks [1/s]  95 %"));
  EXPECT_THAT(describe_study(answers, "x", 1), HasSubstr("and 1 more:"));
  const std::string csv = means_csv(answers);
  EXPECT_THAT(csv, testing::StartsWith("speed,\"a, b\",runs,v_rms_mean_m/s,"));
  EXPECT_THAT(csv, HasSubstr("\n0.1,\"x\"\"y\",3,"));
  EXPECT_THAT(csv, testing::EndsWith(",0,0,,\n"));  // no shock in any run: no interval
  EXPECT_EQ(nlohmann::json::parse(study_json(answers))["points"][0]["shock_rate"]["mean"], 20.0);
}

}  // namespace
}  // namespace ra2d
