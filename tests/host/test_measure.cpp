// SPDX-License-Identifier: BSD-3-Clause
// From a profile to its parameters, and the command that prints them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/measure.hpp"
#include "host/surface/surface.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"

namespace {

using namespace ra2d;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using test::pi;

/// Points 1 um apart; a sine of 1 um and wavelength 100 um.
Profile sine(std::size_t count, double tilt = 0) {
  Profile profile;
  profile.spacing = 1e-6;
  for (std::size_t i = 0; i < count; ++i)
    profile.heights.push_back(1e-6 * std::sin(2 * pi * (static_cast<double>(i) + 0.5) / 100) +
                              tilt * static_cast<double>(i));
  return profile;
}

std::string fault(const Profile& profile, const MeasureOptions& options) {
  try {
    measure_profile(profile, options, "NAME");
  } catch (const RequestError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Measure, DoubtsSlopesThatNoFaceHas) {
  Profile profile = sine(5000);
  const MeasureOptions options{.filter = ProfileFilter::none};
  EXPECT_TRUE(measure_profile(profile, options, "NAME").doubts.empty());
  // a height that stands for a missing one
  Profile spike = profile;
  spike.heights[1000] = -9999e-6;
  EXPECT_THAT(measure_profile(spike, options, "NAME").doubts,
              testing::Contains(HasSubstr("NAME: its slopes have a root mean square of")));
  for (double& z : profile.heights) z *= 1e3;  // in mm
  EXPECT_THAT(measure_profile(profile, options, "NAME").doubts,
              testing::Contains(HasSubstr("steeper than any face")));
}

TEST(Measure, DropsHalfACutoffAtEachEndAndTakesFiveSamplingLengths) {
  const MeasureOptions options{.cutoff = 800e-6};
  for (const auto& [count, fitting] : {std::pair{1600, 1},
                                       {2399, 2},
                                       {2400, 2},
                                       {4800, 5},
                                       {4801, 5},
                                       {5599, 6},
                                       {5600, 6},
                                       {16000, 19}}) {
    const Measurement m = measure_profile(sine(count), options, "");
    EXPECT_EQ(m.fitting, fitting) << count;
    EXPECT_EQ(m.sampling_lengths, std::min(fitting, 5)) << count;
    EXPECT_EQ(m.nodes, count);
    EXPECT_DOUBLE_EQ(m.length, (count - 1) * 1e-6);
    EXPECT_EQ(m.cutoff, 800e-6);
  }
  EXPECT_THAT(fault(sine(1599), options),
              AllOf(HasSubstr("NAME: the profile is 0.001598 m long"), HasSubstr("needs 0.0016 m"),
                    HasSubstr("--filter none")));
  MeasureOptions more = options;
  more.sampling_lengths = 0;
  EXPECT_EQ(measure_profile(sine(16000), more, "").sampling_lengths, 19);
  more.sampling_lengths = 7;
  EXPECT_EQ(measure_profile(sine(16000), more, "").sampling_lengths, 7);
  more.sampling_lengths = 20;
  EXPECT_THAT(fault(sine(16000), more), HasSubstr("--sampling-lengths 20: 19 of 0.0008 m fit"));
}

TEST(Measure, SamplingLengthsMayBeShortByLessThanAThousandth) {
  EXPECT_EQ(fitting_lengths(6664, 2.5e-3 / 1.5e-6), 4);  // 1666 points each: short by 0.04 %
  EXPECT_EQ(fitting_lengths(1666, 2.5e-3 / 1.5e-6), 1);
  EXPECT_EQ(fitting_lengths(6659, 2.5e-3 / 1.5e-6), 3);  // 6660 would be short by 0.1 %
  EXPECT_EQ(fitting_lengths(6661, 2.5e-3 / 1.5e-6), 4);
  for (const std::size_t n : {1, 5, 400}) {
    EXPECT_EQ(fitting_lengths(1000 * n, 1000), n);
    EXPECT_EQ(fitting_lengths(999 * n - 1, 1000), n - 1);
    EXPECT_EQ(fitting_lengths(999 * n + 1, 1000), n);
  }
  EXPECT_EQ(fitting_lengths(2'000'000, 1000), 2000);  // 0.1 % of them would be two more
  EXPECT_EQ(fitting_lengths(0, 1000), 0);
  EXPECT_EQ(fitting_filtered(6664 + 1666, 1.5e-6, 2.5e-3), 4);
  EXPECT_EQ(fitting_filtered(1666, 1.5e-6, 2.5e-3), 0);
  EXPECT_EQ(fitting_filtered(1000, 1.5e-6, 2.5e-3), 0);
}

/// Four sampling lengths of whole periods, of other amplitudes [um], as an instrument exports them.
Profile exported() {
  Profile profile;
  profile.spacing = 1.5e-6;
  for (const double amplitude : {1, 2, 4, 5})
    for (int i = 0; i < 1666; ++i)
      profile.heights.push_back(amplitude * 1e-6 * std::sin(2 * pi * (i + 0.5) * 7 / 1666));
  return profile;
}

TEST(Measure, WhatTheInstrumentHasFilteredIsOnlyDivided) {
  const double root = std::sqrt(0.5);
  for (const std::optional<std::size_t> lengths :
       {std::optional<std::size_t>{}, std::optional<std::size_t>{0},
        std::optional<std::size_t>{4}}) {
    MeasureOptions options{.filter = ProfileFilter::done, .sampling_lengths = lengths};
    options.standard = RoughnessStandard::iso4287;
    const Measurement m = measure_profile(exported(), options, "");
    EXPECT_EQ(m.cutoff, 2.5e-3);
    EXPECT_EQ(m.fitting, 4);
    EXPECT_EQ(m.sampling_lengths, 4);
    EXPECT_EQ(m.dropped, 0);
    EXPECT_EQ(m.heights, exported().heights);
    EXPECT_TRUE(m.doubts.empty());
    EXPECT_NEAR(m.parameters.rq, 3e-6 * root, 1e-18);
    EXPECT_NEAR(m.parameters.rku, 1.5, 1e-11);
    options.standard = RoughnessStandard::iso21920;
    const Roughness whole = measure_profile(exported(), options, "").parameters;
    EXPECT_NEAR(whole.rq, 1e-6 * std::sqrt(46.0 / 4) * root, 1e-18);
    EXPECT_NEAR(whole.rku, 1.5 * (898.0 / 4) / std::pow(46.0 / 4, 2), 1e-11);
  }
  EXPECT_THAT(fault(exported(), {.filter = ProfileFilter::done, .cutoff = 12e-3}),
              AllOf(HasSubstr("a cut-off of 0.012 m needs 0.012 m"), Not(HasSubstr("dropped"))));
}

TEST(Measure, WhatNoFilterLeavesIsDoubted) {
  const auto doubts = [](Profile profile, int degree = ProfileForm::none) {
    return measure_profile(profile, {.form = {degree}, .filter = ProfileFilter::done}, "NAME")
        .doubts;
  };
  Profile profile = exported();
  for (double& z : profile.heights) z += 0.1e-6;  // of an Rq of 2.4 um
  EXPECT_TRUE(doubts(profile).empty());
  for (double& z : profile.heights) z += 1e-6;
  EXPECT_THAT(doubts(profile),
              testing::ElementsAre(AllOf(HasSubstr("NAME: the mean of the heights is 1.1e-06 m"),
                                         HasSubstr("--form mean"))));
  EXPECT_TRUE(doubts(profile, 0).empty());
  for (std::size_t i = 0; i < profile.heights.size(); ++i)
    profile.heights[i] += 1e-8 * static_cast<double>(i);
  EXPECT_THAT(doubts(profile), testing::ElementsAre(HasSubstr("is tilt, which no filter leaves")));
}

TEST(Measure, Iso4287TakesRkOfAProfileWhoseValleysDoNotPullTheMeanLine) {
  // Plateaus of a triangle wave 1 um high, a core alone, and valleys of 50 um that are 20 um deep.
  Profile profile;
  profile.spacing = 1e-6;
  for (int i = 0; i < 20'000; ++i) {
    const double x = (i % 50 + 0.5) / 50;
    const double wave = x < 0.5 ? 2 * x - 0.5 : 1.5 - 2 * x;
    profile.heights.push_back(1e-6 * (i % 4000 >= 2000 && i % 4000 < 2050 ? -20 : wave));
  }
  const auto measured = [&](RoughnessStandard standard, ProfileFilter filter) {
    MeasureOptions options{.filter = filter, .cutoff = 800e-6, .sampling_lengths = 0};
    options.standard = standard;
    return measure_profile(profile, options, "").parameters;
  };
  const Roughness older = measured(RoughnessStandard::iso4287, ProfileFilter::gaussian);
  const Roughness newer = measured(RoughnessStandard::iso21920, ProfileFilter::gaussian);
  EXPECT_GT(newer.rk, 1.1e-6);  // the plateaus next to the valleys are lifted
  EXPECT_GT(newer.rpk, 1.5e-6);
  EXPECT_NEAR(older.rk, 1e-6, 0.03e-6);
  EXPECT_LT(older.rpk, 0.5e-6);
  EXPECT_EQ(older.rt, newer.rt);  // of the roughness profile all the same
  // Filtered before, or not at all, the profile is taken as it is.
  for (const ProfileFilter filter : {ProfileFilter::done, ProfileFilter::none})
    EXPECT_EQ(measured(RoughnessStandard::iso4287, filter).rk,
              measured(RoughnessStandard::iso21920, filter).rk);
}

TEST(Measure, FilterTakesOffWhatItsFormulaSays) {
  // Of wavelengths that are the cutoff, half is left; heights outside are of another sine.
  Profile profile = sine(20000);
  const double left = 1 - std::exp2(-1);
  const Measurement m = measure_profile(profile, {.cutoff = 100e-6, .sampling_lengths = 150}, "");
  // The ends, which the filter does not see whole, reach three cutoffs in: 3 of 150.
  EXPECT_NEAR(m.parameters.rq, left * 1e-6 * std::sqrt(0.5), 2e-3 * 1e-6);
  EXPECT_NEAR(m.parameters.ra, left * 1e-6 * 2 / pi, 2e-3 * 1e-6);
  // The filter against short waves lets as much through.
  const Measurement s =
      measure_profile(profile, {.cutoff = 2000e-6, .cutoff_s = 100e-6, .sampling_lengths = 8}, "");
  EXPECT_NEAR(s.parameters.rq, 0.5e-6 * std::sqrt(0.5), 5e-3 * 1e-6);
}

TEST(Measure, WithoutAFilterIsThePrimaryProfile) {
  const Measurement m = measure_profile(sine(10000), {.filter = ProfileFilter::none}, "");
  EXPECT_EQ(m.sampling_lengths, 1);
  EXPECT_FALSE(m.cutoff);
  EXPECT_NEAR(m.parameters.rq, 1e-6 * std::sqrt(0.5), 1e-19);
  EXPECT_DOUBLE_EQ(m.sampling_length, 0.01);
  // What an instrument has filtered already is divided alone.
  EXPECT_EQ(measure_profile(sine(10000), {.filter = ProfileFilter::none, .cutoff = 2e-3}, "")
                .sampling_lengths,
            5);
  // Heights count from their mean, whatever they are counted from in the file.
  Profile far = sine(10000);
  for (double& z : far.heights) z += 5e-3;
  EXPECT_NEAR(measure_profile(far, {.filter = ProfileFilter::none}, "").parameters.rq,
              1e-6 * std::sqrt(0.5), 1e-17);
}

TEST(Measure, FormIsTakenOffAndTiltIsDoubtedWhereItIsNot) {
  const Profile tilted = sine(10000, 1e-8);
  const Measurement off = measure_profile(tilted, {.form = {1}, .filter = ProfileFilter::none}, "");
  EXPECT_TRUE(off.doubts.empty());
  // The sine itself has a slope over 100 periods: 6/(pi 100) of its height at the ends.
  EXPECT_NEAR(off.parameters.rq, 1e-6 * std::sqrt(0.5), 1e-6 * std::pow(6 / (pi * 100), 2));
  const Measurement on = measure_profile(tilted, {.filter = ProfileFilter::none}, "NAME");
  EXPECT_GT(on.parameters.rq, 10e-6);
  ASSERT_EQ(on.doubts.size(), 1);
  EXPECT_THAT(on.doubts[0], HasSubstr("NAME: most of the height is tilt"));
  // The filter takes a line off, to the ends: no doubt is left.
  const MeasureOptions filtered{.cutoff = 800e-6};
  const Measurement a = measure_profile(tilted, filtered, "");
  const Measurement b = measure_profile(sine(10000), filtered, "");
  EXPECT_TRUE(a.doubts.empty());
  EXPECT_NEAR(a.parameters.rt, b.parameters.rt, 1e-12 * 1e-4);
}

TEST(Measure, GapsAreCountedAndFilled) {
  Profile profile = sine(10000);
  profile.first_missing = "NAME:7";
  for (const int i : {100, 101, 102, 5000}) profile.heights[i] = std::nan("");
  EXPECT_THAT(fault(profile, {}), HasSubstr("NAME:7: a height is missing, the first of 4"));
  const Measurement m = measure_profile(profile, {.cutoff = 800e-6, .fill = 3e-6}, "");
  EXPECT_EQ(m.missing, 4);
  EXPECT_NEAR(m.parameters.rq, 1e-6 * std::sqrt(0.5), 1e-9);
}

TEST(Measure, LengthsThatFitNothingAreRefused) {
  EXPECT_THAT(fault(sine(10000), {.cutoff = 4e-6}), HasSubstr("at least 5 steps"));
  EXPECT_THAT(fault(sine(10000), {.cutoff = 8e-4, .cutoff_s = 8e-4}), HasSubstr("--cutoff-s"));
  EXPECT_THAT(fault(sine(10000), {.filter = ProfileFilter::none, .cutoff_s = 6e-3}),
              HasSubstr("--cutoff-s"));
  EXPECT_THAT(fault(sine(10000), {.cutoff = 1e300}), HasSubstr("give a smaller --cutoff"));
  EXPECT_EQ(measure_profile(sine(10000), {.cutoff = 8e-4, .cutoff_s = 1e-7}, "").doubts.size(), 1);
}

TEST(Measure, MaterialRatioAtAHeight) {
  const auto ratio = [](double level) {
    return measure_profile(sine(10000), {.filter = ProfileFilter::none, .level = level}, "")
        .material_ratio;
  };
  EXPECT_EQ(ratio(0), 0.5);
  EXPECT_EQ(ratio(2e-6), 0);
  EXPECT_EQ(ratio(-2e-6), 1);
  EXPECT_NEAR(ratio(0.5e-6), 1.0 / 3, 0.01);  // a sine is above its half for a third of the time
}

// ---- the face of a scene

struct MeasuredFace : testing::Test {
  const ra2d::test::Folder folder;
  SurfaceSpec spec;

  void SetUp() override {
    spec.kind = SurfaceKind::file;
    spec.path = "sine.txt";
    std::ofstream file(folder.path() / spec.path);
    file << "x [mm]; tilted [um]; z [um]\n";
    for (int i = 0; i < 20000; ++i) {
      const double z = std::sin(2 * pi * (i + 0.5) / 100);
      file << fmt::format("{:.3f};{:.9f};{:.9f}\n", i * 1e-3, z + 0.01 * i, z);
    }
  }
  std::vector<double> heights(double length, double spacing = 1e-6, double thickness = 0) const {
    return make_surface(spec, length, spacing, folder.path() / "scene.toml", thickness);
  }
};

TEST_F(MeasuredFace, IsReadAndShapedAsTheSceneSays) {
  spec.prepared.column = 3;
  for (int n = 0; const double height : heights(0.01))
    ASSERT_NEAR(height, 1e-6 * std::sin(2 * pi * (n++ + 0.5) / 100), 1e-6 * 2e-4) << n;
  // Between the points it is straight.
  const auto finer = heights(0.01, 0.5e-6);
  for (std::size_t n = 2; n + 2 < finer.size(); n += 2)
    ASSERT_NEAR(finer[n + 1], (finer[n] + finer[n + 2]) / 2, 1e-18);
  spec.prepared.column = 2;
  const auto tilted = heights(0.01);  // by 100 um: its mean over the nodes is taken off
  EXPECT_NEAR(tilted.front(), -50e-6, 1e-6);
  EXPECT_NEAR(tilted.back(), 50e-6, 1e-6);
  spec.prepared.form = "line";
  for (int n = 0; const double height : heights(0.01))
    ASSERT_NEAR(height, 1e-6 * std::sin(2 * pi * (n++ + 0.5) / 100), 1e-6 * 2e-2) << n;
  spec.prepared.form = {};
  spec.prepared.filter = FaceFilter::gaussian;
  spec.prepared.cutoff = 800e-6;  // takes the tilt off as well, and 400 points, four periods
  for (int n = 0; const double height : heights(0.01))
    ASSERT_NEAR(height, 1e-6 * std::sin(2 * pi * (n++ + 0.5) / 100), 1e-6 * 2e-2) << n;
}

// ---- the command

struct SurfaceMeasure : testing::Test {
  const ra2d::test::Folder folder;
  std::string out, err;

  void SetUp() override {
    std::ofstream file(folder.path() / "sine.txt");
    file << "x [mm]; z [um]\n";
    for (int i = 0; i < 20000; ++i)
      file << fmt::format("{:.3f};{:.9f}\n", i * 1e-3, std::sin(2 * pi * (i + 0.5) / 100));
  }
  int run(std::vector<std::string> words) {
    words.insert(words.begin(), {ra2d::test::program(), "surface", "measure"});
    ra2d::test::Child child(folder.path(), words);
    const int status = child.wait();
    out = child.out();
    err = child.err();
    return status;
  }
};

TEST_F(SurfaceMeasure, PrintsATable) {
  EXPECT_EQ(run({"sine.txt"}), 0);
  EXPECT_THAT(out, AllOf(HasSubstr("20000 points, 1 um apart: 20 mm"),
                         HasSubstr("Gaussian, cut-off 2.5 mm; half of it dropped at each end"),
                         HasSubstr("5 sampling lengths of 2.5 mm; 7 would fit"),
                         HasSubstr("\n  standard   ISO 21920-2\n"),
                         HasSubstr("\n  Rq         0.7071 um\n"), HasSubstr("\n  Mr2        "),
                         HasSubstr("\n  RSm        100 um\n"), HasSubstr("\n  Rku        1.5\n")));
  EXPECT_EQ(err, "");
  EXPECT_EQ(run({"sine.txt", "--filter", "none", "--rmr", "0"}), 0);
  EXPECT_THAT(out, AllOf(HasSubstr("none: parameters of the primary profile"),
                         HasSubstr("\n  Pq         0.7071 um\n"), HasSubstr("Pmr(0 um)"),
                         HasSubstr("50 %"), Not(HasSubstr("Rq"))));
}

TEST_F(SurfaceMeasure, SaysWhichFilterAndWhichStandard) {
  EXPECT_EQ(run({"sine.txt", "--filter", "done", "--standard", "iso4287"}), 0);
  EXPECT_THAT(out, AllOf(HasSubstr("done before, cut-off 2.5 mm: nothing is filtered or dropped"),
                         HasSubstr("5 sampling lengths of 2.5 mm; 8 would fit"),
                         HasSubstr("\n  standard   ISO 4287, ISO 13565-2\n"),
                         HasSubstr("\n  Rq         0.7071 um\n")));
  EXPECT_EQ(err, "");
  EXPECT_EQ(run({"sine.txt", "--filter", "done", "--standard", "iso4287", "--json"}), 0);
  EXPECT_THAT(out, AllOf(HasSubstr("\"filter\": \"done\",\n  \"cutoff\": 0.0025,\n"),
                         HasSubstr("\"standard\": \"iso4287\""), HasSubstr("\"Mr1\": ")));
  EXPECT_EQ(run({"sine.txt", "--rsm", "iso4287"}), 2);
  EXPECT_THAT(err, HasSubstr("--standard"));
}

TEST_F(SurfaceMeasure, PrintsJsonInMetres) {
  std::ofstream(folder.path() / "flat.txt") << "0 0\n1e-6 0\n2e-6 0\n3e-6 0\n";
  EXPECT_EQ(run({"sine.txt", "--json", "--cutoff", "8e-4"}), 0);
  EXPECT_THAT(out, AllOf(testing::StartsWith("{\n  \"file\": \"sine.txt\",\n  \"nodes\": 20000,\n"
                                             "  \"spacing\": 1e-06,\n  \"length\": 0.019"),
                         HasSubstr("\"missing\": 0,\n  \"filter\": \"gaussian\",\n  \"cutoff\": "
                                   "0.0008,\n  \"sampling_lengths\": 5,\n  \"parameters\": {\n"
                                   "    \"Ra\": 6.36"),
                         HasSubstr("\"Rvk\": "), Not(HasSubstr("Rmr"))));
  EXPECT_EQ(run({"sine.txt", "flat.txt", "--json", "--filter", "none"}), 0);  // several: a list
  EXPECT_THAT(out, AllOf(testing::StartsWith("[\n"), HasSubstr("\"file\": \"flat.txt\""),
                         HasSubstr("\"cutoff\": null"), HasSubstr("\"Rsk\": null"),
                         HasSubstr("\"sampling_lengths\": 1")));
}

TEST_F(SurfaceMeasure, DoubtsAFileThatMayBeCutOffInItsLastNumber) {
  const std::string text = "x [mm]; z [um]\n0;1.25\n0.1;2.50\n0.2;1";
  for (const char* rest : {"", ".", ".2", "\n", ".25", ".250"}) {
    std::ofstream(folder.path() / "cut.txt") << text << rest;
    EXPECT_EQ(run({"cut.txt", "--filter", "none"}), 0);
    const bool is_cut = std::string(rest).size() < 3 && *rest != '\n';
    EXPECT_EQ(err.find("cut.txt: the last line has no end") != err.npos, is_cut) << rest << err;
  }
}

/// Inside an exponent a cut is off by powers of ten: that is no matter of units.
TEST_F(SurfaceMeasure, RefusesAFileThatIsCutOffInsideAnExponent) {
  for (const char* unit : {"", "x [mm] z [mm]\n"})
    for (const char* last : {"3.1e-0", "3.1e-", "3.1e", "3", "3.1e-08"}) {
      std::ofstream(folder.path() / "cut.txt")
          << unit << "0 1.2e-08\n1e-6 -2.5e-08\n2e-6 0.7e-08\n3e-6 " << last;
      const bool is_whole = last == std::string("3.1e-08");
      EXPECT_EQ(run({"cut.txt", "--filter", "none"}), is_whole ? 0 : 2) << last;
      EXPECT_EQ(err.find("cut off ") == err.npos, is_whole) << last << err;
      EXPECT_THAT(err, Not(HasSubstr("unit")));
    }
}

/// Neither of numbers without a mark nor where their digits vary.
TEST_F(SurfaceMeasure, DoubtsNoFileForAMissingLineEndAlone) {
  for (const char* text :
       {"x [mm]; z [um]\n0;1\n0.1;23\n0.2;2", "x [mm]; z [um]\n0;1.2\n0.1;2.25\n0.2;2.5",
        "x [mm]; z [mm]\n0;1e-3\n0.1;2e-3\n0.2;1.5e-3",
        "x [mm]; z [um]\n0;1,25\n0.1;2,5\n0.2;1,3"}) {
    std::ofstream(folder.path() / "open.txt") << text;
    run({"open.txt", "--filter", "none"});
    EXPECT_THAT(err, Not(HasSubstr("has no end"))) << text;
  }
}

TEST_F(SurfaceMeasure, EndsWithWhatIsWrong) {
  EXPECT_EQ(run({}), 2);
  EXPECT_THAT(err, HasSubstr("FILE"));
  EXPECT_EQ(run({""}), 2);
  EXPECT_EQ(run({"none.txt"}), 4);
  EXPECT_THAT(err, HasSubstr("none.txt"));
  EXPECT_EQ(run({"sine.txt", "none.txt"}), 4);
  EXPECT_EQ(out, "");
  EXPECT_EQ(run({"sine.txt", "--z-unit", "nm"}), 2);
  EXPECT_THAT(err, HasSubstr("sine.txt:1: z is in um by the header"));
  for (const auto& [option, value] : {std::pair{"--x-unit", "inch"},
                                      {"--z-unit", ""},
                                      {"--spacing", "0"},
                                      {"--spacing", "x"},
                                      {"--column", "0"},
                                      {"--column", "1.5"},
                                      {"--decimal", "dot"},
                                      {"--form", "poly:99"},
                                      {"--filter", "robust"},
                                      {"--cutoff", "nan"},
                                      {"--cutoff", "-1"},
                                      {"--cutoff-s", "1e999"},
                                      {"--sampling-lengths", "0"},
                                      {"--sampling-lengths", "many"},
                                      {"--fill", "1e-6"},
                                      {"--fill", "linear:"},
                                      {"--fill", "linear:-1"},
                                      {"--standard", "4287"},
                                      {"--rmr", "inf"}}) {
    EXPECT_EQ(run({"sine.txt", fmt::format("{}={}", option, value)}), 2) << option << value;
    EXPECT_THAT(err, HasSubstr(std::string(option).substr(2))) << value;
    EXPECT_EQ(out, "");
  }
}

TEST_F(SurfaceMeasure, IsHelpedWith) {
  ra2d::test::Child help(folder.path(), {ra2d::test::program(), "help", "surface", "measure"});
  EXPECT_EQ(help.wait(), 0);
  EXPECT_THAT(help.out(), AllOf(HasSubstr("--cutoff-s"), HasSubstr("2.5e-3"), HasSubstr("--fill")));
  EXPECT_EQ(run({"sine.txt", "--cutof", "1"}), 2);
  EXPECT_THAT(err, HasSubstr("did you mean '--cutoff'?"));
}

}  // namespace
