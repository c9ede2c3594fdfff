// SPDX-License-Identifier: BSD-3-Clause
// Faces from files that a scene has prepared: units, lines of areal files, form, filters, repeats.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/prepared_face.hpp"
#include "host/surface/surface.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"

namespace {

using namespace ra2d;
using testing::HasSubstr;
using testing::IsEmpty;

using test::pi;

struct PreparedFace : testing::Test {
  const ra2d::test::Folder folder;
  SurfaceSpec spec;
  std::vector<std::string> doubts;

  PreparedFace() {
    spec.kind = SurfaceKind::file;
    spec.path = "profile";
  }
  FilePreparation& how() { return spec.prepared; }
  void write(const std::string& text) const {
    std::ofstream(folder.path() / "profile", std::ios::binary) << text;
  }
  /// x in mm, z in um, from a function of x [mm].
  template <class Height>
  void write_mm_um(int points, double step, const Height& height) {
    std::string text;
    for (int i = 0; i < points; ++i)
      text += fmt::format("{:.17g};{:.17g}\n", i * step, height(i * step));
    write(text);
    how().x_unit = FileUnit::mm;
    how().z_unit = FileUnit::um;
  }
  std::vector<double> face(double length, double spacing, double thickness = 0.01) {
    doubts.clear();
    return make_surface(spec, length, spacing, folder.path() / "scene.toml", thickness, &doubts);
  }
  std::string fault(double length, double spacing, double thickness = 0.01) {
    try {
      face(length, spacing, thickness);
    } catch (const RequestError& error) {
      return error.what();
    }
    return "no error";
  }
};

double rq_of(const std::vector<double>& z) {
  double mean = 0, squares = 0;
  for (const double height : z) mean += height / static_cast<double>(z.size());
  for (const double height : z) squares += std::pow(height - mean, 2);
  return std::sqrt(squares / static_cast<double>(z.size()));
}

TEST_F(PreparedFace, UnitsAreTakenAndNodesAreInterpolated) {
  write_mm_um(5, 0.5, [](double x) { return x == 1 ? 4.0 : 0.0; });  // a triangle, 2 mm long
  const std::vector<double> z = face(2e-3, 0.25e-3);
  ASSERT_EQ(z.size(), 9);
  const double mean = (2 + 4 + 2) * 1e-6 / 9;
  const double expected[] = {0, 0, 0, 2e-6, 4e-6, 2e-6, 0, 0, 0};
  for (std::size_t n = 0; n < 9; ++n) EXPECT_NEAR(z[n], expected[n] - mean, 1e-18) << n;
  EXPECT_THAT(doubts, IsEmpty());
  const std::vector<double> points = face(2e-3, 0.5e-3);  // the points themselves
  EXPECT_NEAR(points[2] - points[1], 4e-6, 1e-20);
}

TEST_F(PreparedFace, WithoutKeysATextIsReadAsBefore) {
  write("0 0\n1 2e-6\n2 0\n");
  EXPECT_FALSE(needs_preparation(spec, folder.path() / "profile"));
  const std::vector<double> plain = face(2, 0.5);
  how().z_unit = FileUnit::m;
  how().x_unit = FileUnit::m;
  EXPECT_TRUE(needs_preparation(spec, folder.path() / "profile"));
  const std::vector<double> with_units = face(2, 0.5);
  ASSERT_EQ(plain.size(), with_units.size());
  for (std::size_t n = 0; n < plain.size(); ++n) EXPECT_NEAR(plain[n], with_units[n], 1e-20);
}

TEST_F(PreparedFace, ATextWithUnitsOrMarksOfItsOwnIsReadAsMeasuredOnesAre) {
  const std::vector<double> expected = [&] {
    write("0 0\n1e-4 2e-6\n2e-4 0\n");
    return face(2e-4, 0.5e-4);
  }();
  const auto is_plain = [&] { return !needs_preparation(spec, folder.path() / "profile"); };
  for (const char* text :
       {"x [m],z [um]\n0,0\n1e-4,2\n2e-4,0\n", "x [mm] z [m]\n0 0\n0.1 2e-6\n0.2 0\n",
        "# x_mm z_um\n0 0\n0.1 2\n0.2 0\n", "0;0\n0,0001;2e-6\n0,0002;0\n",
        "a name\nx, z\n0 0\n1e-4 2e-6\n2e-4 0\n"}) {
    write(text);
    EXPECT_FALSE(is_plain()) << text;
    const std::vector<double> read = face(2e-4, 0.5e-4);
    ASSERT_EQ(read.size(), expected.size());
    for (std::size_t n = 0; n < read.size(); ++n) EXPECT_NEAR(read[n], expected[n], 1e-20) << text;
  }
  for (const char* text :
       {"0 0\n1 2e-6\n2 0\n", "x [m],z [m]\n0,0\n1,2e-6\n2,0\n", "x z\n0\t0\n1\t2e-6\n2\t0\n",
        "# a comment\n# another one\nx z\n0, 0\n1, 2e-6\n2, 0\n", "\t0\t\t0\n1 2e-6\n2\t0\t\n",
        "# Profile of plate (A2), measured (2024)\nx z\n0 0\n1 2e-6\n2 0\n",
        "# made with Rq = 2 (um)\n0 0\n1 2e-6\n2 0\n", "x [m] z [m]\n0 0\n1 two\n2 0\n",
        "0 0x1\n1 2e-6\n2 0\n"}) {
    write(text);
    EXPECT_TRUE(is_plain()) << text;
  }
  write("x [m] z [in]\n0 0\n1e-4 2e-6\n2e-4 0\n");
  EXPECT_THAT(fault(2e-4, 0.5e-4), HasSubstr("z is in \"in\", which is none of m, mm, um and nm"));
}

TEST_F(PreparedFace, ALineOfAnArealFileByItsContent) {
  write(
      "aISO-1.0\nNumPoints = 3\nNumProfiles = 2\nXscale = 1e-3\nYscale = 2e-3\nZscale = 1e-6\n"
      "DataType = 5\n*\n1 2 3\n4 5 9\n*\n");
  EXPECT_THAT(fault(1e-3, 1e-3), HasSubstr("say with row (1 to 2, along x) or column (1 to 3,"));
  how().row = 2;
  const std::vector<double> row = face(2e-3, 1e-3);
  ASSERT_EQ(row.size(), 3);
  EXPECT_NEAR(row[2] - row[0], 5e-6, 1e-18);
  how().row.reset();
  how().column = 3;
  const std::vector<double> column = face(2e-3, 2e-3);
  ASSERT_EQ(column.size(), 2);
  EXPECT_NEAR(column[1] - column[0], 6e-6, 1e-18);
  how().x_unit = FileUnit::mm;
  EXPECT_THAT(fault(2e-3, 2e-3), HasSubstr("in mm by x_unit: drop the key"));
}

TEST_F(PreparedFace, MessagesSpeakOfKeysAndNotOfOptions) {
  how().form = "line";
  for (const char* text : {"1\n2\n", "0 1 2\n1 2 3\n", "0,5,1,5\n1,0,2,5\n", "0 1\n1 nan\n2 3\n",
                           "0 0\n1 1\n2 0\n", "x [in] z [um]\n0 1\n1 2\n"}) {
    write(text);
    const std::string said = fault(1, 1);
    EXPECT_THAT(said, HasSubstr("profile")) << text;
    EXPECT_THAT(said, testing::Not(HasSubstr("--"))) << text;
  }
}

TEST_F(PreparedFace, ASpacingAndADecimalMarkMakeUpForWhatTheFileLeavesOpen) {
  write("0\n1e-6\n3e-6\n");
  how().z_unit = FileUnit::m;
  EXPECT_THAT(fault(2e-3, 1e-3), HasSubstr("of heights alone give the spacing with spacing"));
  how().spacing = 1e-3;
  const std::vector<double> heights = face(2e-3, 1e-3);
  ASSERT_EQ(heights.size(), 3u);
  EXPECT_NEAR(heights[2] - heights[0], 3e-6, 1e-20);
  how().x_unit = FileUnit::m;
  EXPECT_THAT(fault(2e-3, 1e-3), HasSubstr("x_unit has no x to act on: spacing is in metres"));

  how().x_unit.reset();
  how().z_unit = FileUnit::um;
  write("0,5\n1,5\n2,0\n");  // heights, or two columns
  EXPECT_THAT(fault(2e-3, 1e-3), HasSubstr("Say decimal = \"point\", where commas part"));
  how().decimal = FileDecimal::comma;
  const std::vector<double> german = face(2e-3, 1e-3);
  ASSERT_EQ(german.size(), 3u);
  EXPECT_NEAR(german[1] - german[0], 1e-6, 1e-20);

  write(
      "aISO-1.0\nNumPoints = 3\nNumProfiles = 1\nXscale = 1e-3\nYscale = 2e-3\nZscale = 1e-6\n"
      "DataType = 5\n*\n1 2 3\n*\n");
  how() = {};
  how().spacing = 1e-3;
  EXPECT_THAT(fault(2e-3, 1e-3), HasSubstr("spacing is of texts without x"));
  how() = {};
  how().decimal = FileDecimal::comma;
  EXPECT_THAT(fault(2e-3, 1e-3), HasSubstr("decimal is of texts"));
}

TEST_F(PreparedFace, GapsAndForm) {
  write("0;0\n1;1\n2;nan\n3;3\n4;4\n");
  how().x_unit = FileUnit::mm;
  how().z_unit = FileUnit::um;
  EXPECT_THAT(fault(4e-3, 1e-3), HasSubstr("a height is missing"));
  how().fill = "linear:1e-3";
  const std::vector<double> filled = face(4e-3, 1e-3);
  EXPECT_NEAR(filled[3] - filled[2], 1e-6, 1e-18);
  how().form = "line";
  for (const double z : face(4e-3, 1e-3)) EXPECT_NEAR(z, 0, 1e-18);
}

TEST_F(PreparedFace, TheFilterTakesLongWavesOffAndHalfACutOffAtEachEnd) {
  // 0.1 mm within 8 mm: the cut-off of 0.8 mm takes the long wave off and leaves the short one
  write_mm_um(4001, 2e-3,
              [](double x) { return std::sin(2 * pi * x / 0.1) + 50 * std::sin(2 * pi * x / 8); });
  EXPECT_GT(rq_of(face(7e-3, 2e-6)), 20e-6);
  how().filter = FaceFilter::gaussian;
  how().cutoff = 0.8e-3;
  const std::vector<double> z = face(7e-3, 2e-6);
  const double long_wave = 1 - std::exp(-std::log(2.0) * std::pow(0.8 / 8, 2));  // what is left
  for (std::size_t n = 0; n < z.size(); ++n) {
    const double x = 0.4 + 2e-3 * static_cast<double>(n);
    ASSERT_NEAR(z[n],
                1e-6 * (std::sin(2 * pi * x / 0.1) + 50 * long_wave * std::sin(2 * pi * x / 8)),
                0.05e-6)
        << n;
  }
  EXPECT_THAT(fault(7.3e-3, 2e-6), HasSubstr("the profile is 0.0072 m long"));
  how().cutoff = 9e-3;
  EXPECT_THAT(fault(1e-3, 2e-6), HasSubstr("half of it is dropped at each end"));
  how().cutoff = 5e-6;
  EXPECT_THAT(fault(1e-3, 2e-6), HasSubstr("at least 5 steps"));
  how().filter = FaceFilter::none;
  how().cutoff.reset();
  how().cutoff_s = 0.4e-3;  // the short wave goes
  EXPECT_LT(std::abs(face(7e-3, 25e-6)[2] - face(7e-3, 25e-6)[0]), 2.5e-6);
}

TEST_F(PreparedFace, AShortProfileIsRefusedOrRepeated) {
  const auto wave = [](double x) { return 2 * std::sin(2 * pi * x / 0.11 + 1) + 0.7 * x; };
  write_mm_um(1001, 1e-3, wave);
  EXPECT_THAT(fault(3.5e-3, 1e-6),
              HasSubstr("the profile is 0.001 m long and the beam 0.0035 m; give a longer profile, "
                        "or say short = \"repeat\""));
  how().when_short = ShortProfile::repeat;
  const std::vector<double> z = face(3.5e-3, 1e-6);
  ASSERT_EQ(z.size(), 3501);
  double steepest = 0;
  for (std::size_t n = 1; n <= 1000; ++n) steepest = std::max(steepest, std::abs(z[n] - z[n - 1]));
  for (std::size_t n = 1; n < z.size(); ++n)  // no seam jumps
    ASSERT_LE(std::abs(z[n] - z[n - 1]), 2.5 * steepest) << n;
  for (std::size_t n = 0; n <= 1000; ++n) {  // the copies are the profile
    ASSERT_NEAR(z[n] - z[0], 1e-6 * (wave(1e-3 * static_cast<double>(n)) - wave(0)), 1e-15);
    ASSERT_EQ(z[n], z[n + 1100]);
    ASSERT_EQ(z[n], z[n + 2200]);
  }
  ASSERT_EQ(doubts.size(), 1);
  EXPECT_THAT(doubts[0], HasSubstr("0.001 m long, less than the beam: repeated every 0.0011 m"));
  how().when_short = ShortProfile::repeat;
  EXPECT_THAT(fault(0.11, 1e-6), HasSubstr("more than 100 times"));
  EXPECT_EQ(fault(0.9e-3, 1e-6), "no error");  // long enough: nothing to repeat
  EXPECT_THAT(doubts, IsEmpty());
}

/// Straight lines keep sin(pi d/L)/(pi d/L) of the slope of a wave L where points are d apart.
TEST_F(PreparedFace, SaysWhatSlopeIsLostBetweenItsNodes) {
  constexpr double wave = 20e-6, step = 1e-6;
  const auto kept = [](double d) { return std::sin(pi * d / wave) / (pi * d / wave); };
  std::string text;
  for (int i = 0; i <= 8000; ++i)
    text += fmt::format("{:.9g} {:.17g}\n", i * step, 0.1e-6 * std::sin(2 * pi * i * step / wave));
  for (const bool as_it_stands : {true, false}) {
    write(text);
    how() = {};
    if (!as_it_stands) how().x_unit = how().z_unit = FileUnit::m;
    face(8e-3, 8e-6);
    ASSERT_EQ(doubts.size(), 1u);
    const std::size_t at = doubts[0].find(" % less than the points");
    ASSERT_NE(at, std::string::npos) << doubts[0];
    EXPECT_NEAR(std::stod(doubts[0].substr(doubts[0].rfind(' ', at - 1))),
                100 * (1 - kept(8e-6) / kept(step)), 0.6);
    face(8e-3, 2e-6);  // keeps 99 %
    EXPECT_THAT(doubts, IsEmpty());
    face(8e-3, 1e-6);
    EXPECT_THAT(doubts, IsEmpty());
  }
}

TEST_F(PreparedFace, TiltIsDoubtedWhereNothingTakesItOff) {
  const auto tilted = [](double x) { return 20 * x + std::sin(40 * x); };  // um, of mm
  const auto says_tilt =
      testing::ElementsAre(HasSubstr("profile: most of the height is tilt: try form = \"line\""));
  write_mm_um(801, 0.01, tilted);
  face(6e-3, 1e-5);
  EXPECT_THAT(doubts, says_tilt);
  how().form = "mean";
  face(6e-3, 1e-5);
  EXPECT_THAT(doubts, says_tilt);
  how().form = "line";
  face(6e-3, 1e-5);
  EXPECT_THAT(doubts, IsEmpty());
  how().form = {};
  how().filter = FaceFilter::gaussian;
  how().cutoff = 0.8e-3;
  face(6e-3, 1e-5);
  EXPECT_THAT(doubts, IsEmpty());
  how() = {};  // two columns in metres
  std::string metres;
  for (int i = 0; i <= 800; ++i)
    metres += fmt::format("{:.6f} {:.10f}\n", i * 1e-5, 1e-6 * tilted(i * 0.01));
  write(metres);
  face(6e-3, 1e-5);
  EXPECT_THAT(doubts, says_tilt);
}

TEST_F(PreparedFace, AFilterThatChangesNothingIsDoubted) {
  write_mm_um(801, 0.01, [](double x) { return std::sin(40 * x); });
  how().cutoff_s = 1e-5;
  face(6e-3, 1e-5);
  EXPECT_THAT(doubts, IsEmpty());
  how().cutoff_s = 8e-9;
  face(6e-3, 1e-5);
  EXPECT_THAT(doubts, testing::ElementsAre(HasSubstr("cutoff_s = 8e-09 is less than a step")));
}

TEST_F(PreparedFace, AFileThatMayBeCutOffInItsLastNumberIsDoubted) {
  const std::string text = "x [mm]; z [um]\n0;1.25\n0.1;2.50\n0.2;1.2";
  write(text);
  face(2e-4, 1e-4);
  EXPECT_THAT(doubts, testing::ElementsAre(HasSubstr("profile: the last line has no end")));
  write(text + '5');
  face(2e-4, 1e-4);
  EXPECT_THAT(doubts, IsEmpty());
}

TEST(RepeatedProfileSeam, GoesFromTheLastHeightToTheFirst) {
  std::vector<double> z(101);
  for (std::size_t i = 0; i < z.size(); ++i) z[i] = i < 50 ? -1 : 1;
  const RepeatedProfile repeated(z);
  ASSERT_EQ(repeated.seam(), 10);
  EXPECT_EQ(repeated.at(100), 1);
  EXPECT_EQ(repeated.at(110), -1);
  for (std::size_t i = 101; i < 110; ++i) {  // flat on both sides: the weights alone
    const double turn = pi / 2 * static_cast<double>(i - 100) / 10;
    EXPECT_NEAR(repeated.at(i), std::cos(turn) - std::sin(turn), 1e-15) << i;
  }
  const std::vector<double> two = {-1, 1};
  const RepeatedProfile least(two);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(least.at(i), two[i % 2]) << i;
}

TEST_F(PreparedFace, WhatNoFaceIsIsRefused) {
  write_mm_um(3, 1, [](double x) { return x == 1 ? 3e5 : 0.0; });
  EXPECT_THAT(fault(2e-3, 1e-3), HasSubstr("the heights span 0.3 m on a beam 0.01 m thick"));
  write_mm_um(3, 1, [](double x) { return x == 1 ? 3e3 : 0.0; });
  EXPECT_THAT(fault(2e-3, 1e-3), HasSubstr("steeper than any face"));
  write_mm_um(3, 1, [](double x) { return x == 1 ? 3e2 : 0.0; });
  EXPECT_EQ(fault(2e-3, 1e-3), "no error");
  ASSERT_EQ(doubts.size(), 1);
  EXPECT_THAT(doubts[0], HasSubstr("few faces are so steep"));
  write_mm_um(3, 1, [](double x) { return x == 1 ? 0.05 : 0.0; });  // nm that are taken for um
  EXPECT_EQ(fault(2e-3, 1e-3), "no error");
  ASSERT_EQ(doubts.size(), 1);
  EXPECT_THAT(doubts[0], HasSubstr("smoother than faces are"));
}

}  // namespace
