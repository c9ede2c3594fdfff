// SPDX-License-Identifier: BSD-3-Clause
// Measured profiles in text: what is read, and as what; what is refused, and why.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/profile.hpp"
#include "tests/child.hpp"

namespace {

using namespace ra2d;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr LengthUnit m{"m", 1}, mm{"mm", 1e-3}, um{"um", 1e-6};

struct ProfileText : testing::Test {
  const ra2d::test::Folder folder;
  const std::filesystem::path file = folder.path() / "profile.txt";

  Profile read(const std::string& text, const ProfileQuery& query = {.x_unit = m, .z_unit = m}) {
    std::ofstream(file, std::ios::binary) << text;
    return read_measured_profile(file, query);
  }
  std::string fault(const std::string& text,
                    const ProfileQuery& query = {.x_unit = m, .z_unit = m}) {
    try {
      read(text, query);
    } catch (const RequestError& error) {
      return error.what();
    }
    return "no error";
  }
  void expect_read(const std::string& text, double spacing, const std::vector<double>& heights,
                   const ProfileQuery& query = {.x_unit = m, .z_unit = m}) {
    try {
      const Profile profile = read(text, query);
      EXPECT_DOUBLE_EQ(profile.spacing, spacing) << text;
      ASSERT_EQ(profile.heights.size(), heights.size()) << text;
      for (std::size_t i = 0; i < heights.size(); ++i)
        if (std::isnan(heights[i]))
          EXPECT_TRUE(std::isnan(profile.heights[i])) << text << i;
        else
          EXPECT_DOUBLE_EQ(profile.heights[i], heights[i]) << text << i;
    } catch (const std::exception& error) {
      ADD_FAILURE() << text << error.what();
    }
  }
};

TEST_F(ProfileText, SeparatorsAndDecimalMarks) {
  const std::vector<double> z = {1.5, -2.5, 3};
  for (const char* text : {
           "0 1.5\n0.5 -2.5\n1 3\n",
           "0,1.5\n0.5,-2.5\n1,3\n",
           "0, 1.5\n0.5 ,-2.5\n1\t,\t3\n",
           "0;1.5\n0.5;-2.5\n1;3\n",
           "0\t1.5\r\n0.5\t-2.5\r\n1\t3\r\n",
           "  0 \t 1.5  \n 0.5\t-2.5\n1\t3",
           "0;1,5\n0,5;-2,5\n1;3\n",
           "0\t1,5\n0,5\t-2,5\n1\t3\n",
           "0 1,5\n0,5 -2,5\n1 3\n",
           "0,0  1,5e0\n0,5  -2,5\n1,0  3\n",
           "\xef\xbb\xbf"
           "0;1.5;\n0.5;-2.5;\n1;3;\n",
           "# by us\n0 +1.5 # first\n\n# more\n0.5 -25e-1\n1 3\n",
       })
    expect_read(text, 0.5, z);
}

TEST_F(ProfileText, WholeNumbersPartedByCommasAreTwoColumns) {
  expect_read("0,1\n1,2\n2,3\n", 1, {1, 2, 3});  // one column would have no x
  EXPECT_THAT(fault("0,1\n1,2\n2,3\n", {.z_unit = m, .spacing = 1}),
              AllOf(HasSubstr("profile.txt:1: commas between digits"), HasSubstr("--decimal")));
  expect_read("0,1\n1,2\n2,3\n", 2, {0.1, 1.2, 2.3},
              {.z_unit = m, .spacing = 2, .decimal = DecimalMark::comma});
  expect_read("0,1\n1,2\n2,3\n", 2, {1, 2, 3},
              {.z_unit = m, .spacing = 2, .column = 2, .decimal = DecimalMark::point});
}

TEST_F(ProfileText, CommasThatMayBeBothAreRefused) {
  EXPECT_THAT(fault("0,5,1,5\n1,5,2,5\n"), HasSubstr("--decimal point"));
  EXPECT_THAT(fault("0,5 1.5\n1,5 2.5\n"), HasSubstr("points, commas and blanks"));
  EXPECT_THAT(fault("0,5;1.5\n1,5;2.5\n"), HasSubstr("numbers with points and with commas"));
  EXPECT_THAT(fault("0;1.234,5\n1;2\n"), HasSubstr("no groups of thousands"));
  EXPECT_THAT(fault("0;1.5\n1;2.5\n", {.x_unit = m, .z_unit = m, .decimal = DecimalMark::comma}),
              HasSubstr(":1: \"1.5\" is not a number"));  // fifteen, or one and a half
  EXPECT_THAT(fault("0;1,234,567\n1;2\n"), HasSubstr(":1: \"1,234,567\" is not a number"));
}

TEST_F(ProfileText, HeadersOfAnyLanguageAndTheUnitsInThem) {
  const std::vector<double> z = {1e-6, 2e-6, 3e-6};
  const std::string rows = "0;1\n1;2\n2;3\n";
  for (const char* header :
       {"x [mm]; z [\xc2\xb5m]\n", "x [mm]; z [\xce\xbcm]\n", "x [mm]; z [\xb5m]\n",
        "# x [mm] z [um]\n", "Profil 7\nWeg (mm);H\xc3\xb6he (\xc2\xb5m)\n", "mm;um\n",
        "\"x_mm\";\"z_um\"\n", "x/mm;z/um\n", "x mm;z um\n", "% x in mm; z in um\n",
        "Lage;Hauteur\n[mm];[um]\n", "x [mm]; z [um]\nx [mm]; z\n",
        "\xef\xbb\xbfx [mm];z [um]\r\n"})
    expect_read(header + rows, 1e-3, z, {});
  expect_read("x [mm]; z [um]\n" + rows, 1e-3, z, {.x_unit = mm, .z_unit = um});  // agrees
  expect_read("x [mm]; z\n" + rows, 1e-3, z, {.z_unit = um});
  expect_read("z [um]\n1\n2\n3\n", 4e-6, z, {.spacing = 4e-6});
  expect_read("\xe9\xab\x98\xe3\x81\x95\n" + rows, 1e-3, z, {.x_unit = mm, .z_unit = um});
}

TEST_F(ProfileText, UnitsThatDisagreeOrAreNotKnownAreRefused) {
  const std::string rows = "0;1\n1;2\n2;3\n";
  EXPECT_THAT(fault("x [mm]; z [um]\n" + rows, {.z_unit = m}),
              HasSubstr("profile.txt:1: z is in um by the header, and in m by --z-unit"));
  EXPECT_THAT(fault("x [mm]; z [um]\n" + rows, {.x_unit = um}), HasSubstr(":1: x is in mm"));
  EXPECT_THAT(fault("a\nx [mm]; z [inch]\n" + rows, {}),
              HasSubstr(":2: z is in \"inch\", which is none of m, mm, um and nm"));
  expect_read("x [mm]; z [inch]\n" + rows, 1e-3, {1e-6, 2e-6, 3e-6}, {.z_unit = um});
  EXPECT_THAT(fault("all lengths [mm]\n" + rows, {}),
              HasSubstr(":1: the header names \"mm\", and not of which column"));
  EXPECT_THAT(fault("x [mm]; z [um]\nx [um]; z [um]\n" + rows, {}),
              HasSubstr(":2: column 1 is in um here and in mm in line 1"));
  EXPECT_THAT(fault("1\n2\n", {.x_unit = mm, .spacing = 1}), HasSubstr("no x to act on"));
}

TEST_F(ProfileText, WithoutUnitsNumbersMustLookLikeMetres) {
  expect_read("0 1e-6\n5e-6 2e-6\n1e-5 1.5e-6\n", 5e-6, {1e-6, 2e-6, 1.5e-6}, {});
  EXPECT_THAT(fault("0 1e-6\n0.5 2e-6\n1 3e-6\n", {}), HasSubstr("--x-unit"));
  EXPECT_THAT(fault("0 1\n1e-6 2\n2e-6 3\n", {}), HasSubstr("--z-unit"));
  EXPECT_THAT(fault("0 0\n1e-6 1e-4\n2e-6 0\n", {}), HasSubstr("slopes of 100"));
  expect_read("0 1\n1e-6 2\n2e-6 3\n", 1e-6, {1, 2, 3}, {.z_unit = m});  // said, not guessed
}

TEST_F(ProfileText, ColumnsAreChosen) {
  const std::string three = "0 1 7\n1 2 8\n2 3 9\n";
  expect_read(three, 1, {7, 8, 9}, {.x_unit = m, .z_unit = m, .column = 3});
  expect_read(three, 0.5, {0, 1, 2}, {.z_unit = m, .spacing = 0.5, .column = 1});
  EXPECT_THAT(fault(three), HasSubstr(":1: 3 columns, expected x and z; say with --column"));
  EXPECT_THAT(fault(three, {.column = 4}), HasSubstr("--column 4: there are 3 columns"));
  EXPECT_THAT(fault(three, {.column = 1}), HasSubstr("the first is x"));
  EXPECT_THAT(fault("1\n2\n3\n"), HasSubstr("one column, expected x and z"));
  EXPECT_THAT(fault("1 2\n2 3\n", {.z_unit = m, .spacing = 1}), HasSubstr("say with --column"));
}

TEST_F(ProfileText, MissingPointsAreFilledOnlyWhereAsked) {
  const double gap = std::nan("");
  expect_read("0;1\n1;\n2;nan\n3;4\n4;NA\n5;6\n", 1, {1, gap, gap, 4, gap, 6});
  expect_read("0,1\n1,\n2,3.5\n", 1, {1, gap, 3.5});
  Profile profile = read("0;1\n1;\n2;NaN\n3;4\n4;n/a\n5;6\n");
  EXPECT_EQ(profile.missing(), 3);
  EXPECT_THAT(profile.first_missing, HasSubstr("profile.txt:2"));
  const auto fault_of_filling = [&](double width) {
    try {
      Profile copy = profile;
      fill_gaps(copy, width);
    } catch (const RequestError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(fault_of_filling(0),
              AllOf(HasSubstr("profile.txt:2: a height is missing, the first of 3"),
                    HasSubstr("--fill linear:WIDTH")));
  EXPECT_THAT(fault_of_filling(1.99), HasSubstr("a gap of 2 m"));
  fill_gaps(profile, 2);
  EXPECT_EQ(profile.heights, (std::vector<double>{1, 2, 3, 4, 5, 6}));
  for (const char* text : {"0;nan\n1;1\n2;2\n", "0;1\n1;1\n2;nan\n"}) {
    profile = read(text);
    EXPECT_THAT(fault_of_filling(9), HasSubstr("begins or ends with missing points"));
  }
  EXPECT_THAT(fault("0;nan\n1;\n"), HasSubstr("every height is missing"));
  EXPECT_THAT(fault("0;1\n;2\n2;3\n"), HasSubstr(":2: x is missing"));
}

TEST_F(ProfileText, HostileTextsAreRefusedWithTheirLine) {
  EXPECT_THAT(fault(""), HasSubstr("no line of numbers"));
  EXPECT_THAT(fault("only\nwords\n"), HasSubstr("no line of numbers"));
  EXPECT_THAT(fault("0 1\n"), HasSubstr("expected at least 2"));
  EXPECT_THAT(fault("0 1\n1 1e400\n2 1\n"), HasSubstr(":2: \"1e400\" is not a finite number"));
  EXPECT_THAT(fault("0 1\n1 inf\n2 1\n"), HasSubstr(":2: \"inf\" is not a finite number"));
  EXPECT_THAT(fault("0 1\nnan 1\n2 1\n"), HasSubstr(":2: \"nan\" is not a finite number"));
  EXPECT_THAT(fault("0 1\n1 0x10\n"), HasSubstr(":2: \"0x10\" is not a number"));
  EXPECT_THAT(fault("0 1\n1 2\n2\n"), HasSubstr(":3: 1 columns, and 2 in the lines before"));
  EXPECT_THAT(fault("0 1\n1 2\n2 3e-"), HasSubstr("was the file cut off here?"));
  EXPECT_THAT(fault("0 1\n1 1\n3 1\n4 1\n"), HasSubstr(":3: x steps by 2 m, expected an even"));
  EXPECT_THAT(fault("0 1\n1 1\n1 1\n2 1\n"), HasSubstr(":3: x = 1 m does not increase"));
  EXPECT_THAT(fault("x [mm] z [mm]\n0 1\n1 1\n3 1\n4 1\n", {}),
              HasSubstr(":4: x steps by 2 mm, expected"));
  std::string columns = "1";
  for (int i = 1; i < 1'000'000; ++i) columns += " 1";
  EXPECT_THAT(fault(columns), HasSubstr(":1: a line of more than 65536 bytes"));
  EXPECT_THAT(fault("0 1\n1 2\n" + columns), HasSubstr(":3: a line of more than 65536 bytes"));
  EXPECT_THAT(fault(std::string(70'000, 'x')), HasSubstr(":1: a line of more than"));
  std::string header;
  for (int i = 0; i < 1002; ++i) header += "word\n";
  EXPECT_THAT(fault(header + "0 1\n1 2\n"), HasSubstr("no line of numbers in the first 1000"));
  std::string bad = "0 1\n";
  for (int i = 0; i < 20; ++i) bad += "oops 1\n";
  const std::string message = fault(bad);
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 10) << message;
}

TEST_F(ProfileText, OtherFormatsAreRefusedByName) {
  EXPECT_THAT(fault(std::string("0 1\n\0 2\n", 8)), HasSubstr("binary"));
  EXPECT_THAT(fault("\xff\xfe"
                    "0\0"),
              HasSubstr("UTF-16"));
  EXPECT_THROW(read_measured_profile(folder.path() / "none.txt", {}), FileError);
  EXPECT_THROW(read_measured_profile(folder.path(), {}), FileError);
}

TEST_F(ProfileText, EverySpoiltByteIsReadOrRefused) {
  // Whatever a byte becomes: a profile or one of the two errors, and nothing else.
  const std::string text = "x [mm]; z [um]\n0,1;1,5\n0,2;-2,5\n0,3;nan\n0,4;3e-1\n";
  for (std::size_t i = 0; i <= text.size(); ++i)
    for (const int byte : {0, 10, 44, 59, 93, 255}) {
      std::string spoilt = text.substr(0, i);
      EXPECT_NO_THROW(fault(spoilt, {})) << i;  // cut off
      spoilt += static_cast<char>(byte);
      if (i < text.size()) spoilt += text.substr(i + 1);
      EXPECT_NO_THROW(fault(spoilt, {})) << i << ' ' << byte;
    }
}

TEST_F(ProfileText, IsReadInAnyLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"})
    if (std::setlocale(LC_ALL, name) != nullptr) expect_read("0 1.5\n0.5 2.5\n", 0.5, {1.5, 2.5});
  std::setlocale(LC_ALL, before.c_str());
}

}  // namespace
