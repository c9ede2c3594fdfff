// SPDX-License-Identifier: BSD-3-Clause
// Profiles in SDF (ISO 25178-71): what is read, and as what; what is refused, and why.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/profile.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"

namespace {

using namespace ra2d;
using testing::AllOf;
using testing::HasSubstr;

using test::nan;

/// The bytes of a number, the lowest first, whatever this machine does.
template <class T>
std::string bytes_of(T value) {
  std::uint64_t bits = 0;
  if constexpr (sizeof(T) == 8)
    std::memcpy(&bits, &value, 8);
  else if constexpr (std::is_floating_point_v<T>) {
    std::uint32_t half = 0;
    std::memcpy(&half, &value, 4);
    bits = half;
  } else
    bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
  std::string bytes;
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes += static_cast<char>(bits >> (8 * i) & 0xff);
  return bytes;
}

struct Binary {
  std::string version = "bISO-1.0";
  std::uint16_t points = 4, profiles = 1;
  double x = 5e-7, y = 2e-6, z = 1e-9;
  std::uint8_t compression = 0, type = 7, check = 0;
  std::string data;

  template <class T>
  Binary& with(std::uint8_t number, const std::vector<T>& values) {
    type = number;
    data.clear();
    for (const T value : values) data += bytes_of(value);
    return *this;
  }
  std::string text() const {
    return version + "us        " + "211120260000" + "211120260000" + bytes_of(points) +
           bytes_of(profiles) + bytes_of(x) + bytes_of(y) + bytes_of(z) + bytes_of(1e-10) +
           bytes_of(compression) + bytes_of(type) + bytes_of(check) + data;
  }
};

std::string ascii(const std::string& data, const std::string& points = "4",
                  const std::string& profiles = "1", const std::string& more = "") {
  return "aISO-1.0\r\nManufacID   = us\r\nCreateDate  = 211120260000\r\nNumPoints = " + points +
         " ; along x\r\nNumProfiles = " + profiles +
         "\r\nXscale = 5.0E-07\r\nYscale = 2e-6\r\nZscale = 1E-9\r\nZresolution = 1e-10\r\n"
         "Compression = 0\r\nDataType = 7\r\nCheckType = 0\r\n" +
         more + "*\r\n" + data;
}

struct ProfileSdf : testing::Test {
  const ra2d::test::Folder folder;
  const std::filesystem::path file = folder.path() / "profile.txt";  // the name says nothing

  Profile read(const std::string& content, const ProfileQuery& query = {}) {
    std::ofstream(file, std::ios::binary) << content;
    return read_measured_profile(file, query);
  }
  std::string fault(const std::string& content, const ProfileQuery& query = {}) {
    try {
      read(content, query);
    } catch (const RequestError& error) {
      return error.what();
    }
    return "no error";
  }
  /// Heights in nm.
  void expect_read(const std::string& content, const std::vector<double>& nm, double spacing = 5e-7,
                   const ProfileQuery& query = {}) {
    try {
      const Profile profile = read(content, query);
      EXPECT_EQ(profile.spacing, spacing);
      ASSERT_EQ(profile.heights.size(), nm.size());
      for (std::size_t i = 0; i < nm.size(); ++i)
        if (std::isnan(nm[i]))
          EXPECT_TRUE(std::isnan(profile.heights[i])) << i;
        else
          EXPECT_DOUBLE_EQ(profile.heights[i], nm[i] * 1e-9) << i;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
};

TEST_F(ProfileSdf, EveryTypeInBinary) {
  Binary b;
  expect_read(b.with<std::uint8_t>(0, {0, 1, 128, 255}).text(), {0, 1, 128, 255});
  expect_read(b.with<std::uint16_t>(1, {0, 1, 258, 65535}).text(), {0, 1, 258, 65535});
  expect_read(b.with<std::uint32_t>(2, {0, 1, 16909060, 4294967295}).text(),
              {0, 1, 16909060, 4294967295});
  expect_read(b.with<float>(3, {0, 1.5F, -2.25F, 3e4F}).text(), {0, 1.5, -2.25, 3e4F});
  expect_read(b.with<std::int8_t>(4, {0, 1, -127, 127}).text(), {0, 1, -127, 127});
  expect_read(b.with<std::int16_t>(5, {0, -2, 258, 32767}).text(), {0, -2, 258, 32767});
  expect_read(b.with<std::int32_t>(6, {0, -2, 16909060, 2147483647}).text(),
              {0, -2, 16909060, 2147483647});
  expect_read(b.with<double>(7, {0, -2.125, 1e-3, 1e5}).text(), {0, -2.125, 1e-3, 1e5});
  b.version = "bBCR-1.0";
  expect_read(b.text(), {0, -2.125, 1e-3, 1e5});
}

TEST_F(ProfileSdf, TheMostNegativeNumberAndNanAreMissing) {
  Binary b;
  expect_read(b.with<std::int8_t>(4, {0, -128, 1, -127}).text(), {0, nan, 1, -127});
  expect_read(b.with<std::int16_t>(5, {0, -32768, 1, -32767}).text(), {0, nan, 1, -32767});
  expect_read(b.with<std::int32_t>(6, {0, std::numeric_limits<int>::min(), 1, 2}).text(),
              {0, nan, 1, 2});
  expect_read(b.with<float>(3, {0, std::numeric_limits<float>::quiet_NaN(), 1, 2}).text(),
              {0, nan, 1, 2});
  expect_read(b.with<double>(7, {0, nan, std::numeric_limits<double>::lowest(), 2}).text(),
              {0, nan, nan, 2});
  EXPECT_EQ(read(b.text()).first_missing, file.string() + ": point 2");
  EXPECT_THAT(fault(b.with<double>(7, {nan, nan, nan, nan}).text()),
              HasSubstr("every height is missing"));
}

TEST_F(ProfileSdf, Text) {
  expect_read(ascii("1 2.5\r\n-3e0 4\r\n*\r\nwhat else is told\r\n*\r\n"), {1, 2.5, -3, 4});
  expect_read(ascii("1 BAD 3 4"), {1, nan, 3, 4});
  expect_read(ascii("+1\n2\n3\n4\n*"), {1, 2, 3, 4});
}

TEST_F(ProfileSdf, RowsAndColumnsOfAnArealFile) {
  ProfileQuery row2, column3, both, row4, column5, row0;
  row2.row = 2;
  column3.column = 3;
  both.row = both.column = 1;
  row4.row = 4;
  row0.row = 0;
  column5.column = 5;
  Binary b;
  b.profiles = 3;
  b.with<std::int16_t>(5, {11, 12, 13, 14, 21, 22, 23, 24, 31, 32, -32768, 34});
  for (const std::string& content :
       {b.text(), ascii("11 12 13 14\n21 22 23 24\n31 32 BAD 34\n*", "4", "3")}) {
    expect_read(content, {21, 22, 23, 24}, 5e-7, row2);
    expect_read(content, {13, 23, nan}, 2e-6, column3);
    EXPECT_THAT(fault(content),
                AllOf(HasSubstr("--row (1 to 3, along x)"), HasSubstr("--column (1 to 4,")));
    EXPECT_THAT(fault(content, both), HasSubstr("expected one of them"));
    EXPECT_THAT(fault(content, row4), HasSubstr("--row 4: the file has the rows 1 to 3"));
    EXPECT_THAT(fault(content, row0), HasSubstr("--row 0: the file has the rows 1 to 3"));
    EXPECT_THAT(fault(content, column5), HasSubstr("--column 5: the file has the columns 1 to 4"));
  }
  expect_read(Binary().with<double>(7, {1, 2, 3, 4}).text(), {1, 2, 3, 4}, 5e-7, [] {
    ProfileQuery q;
    q.row = 1;
    return q;
  }());
  EXPECT_THAT(fault(ascii("1 2 3 4"), column3), HasSubstr("the file is one profile"));
  EXPECT_THAT(fault("0 1\n1e-6 2e-9\n", row2), HasSubstr("a text has columns and no rows"));
}

TEST_F(ProfileSdf, WhatDisagreesWithTheNormIsRefused) {
  ProfileQuery mm, um, metres, spacing, comma;
  mm.x_unit = to_unit("mm");
  um.z_unit = to_unit("um");
  metres.x_unit = metres.z_unit = to_unit("m");
  spacing.spacing = 1e-6;
  comma.decimal = DecimalMark::comma;
  const std::string text = ascii("1 2 3 4");
  EXPECT_THAT(fault(text, mm), HasSubstr("x is in m, as in every SDF file, and in mm by --x-unit"));
  EXPECT_THAT(fault(text, um), HasSubstr("z is in m, as in every SDF file, and in um by --z-unit"));
  expect_read(text, {1, 2, 3, 4}, 5e-7, metres);
  EXPECT_THAT(fault(text, spacing), HasSubstr("--spacing is of texts"));
  EXPECT_THAT(fault(text, comma), HasSubstr("no decimal comma"));
}

TEST_F(ProfileSdf, LyingHeaders) {
  const Binary good = Binary().with<double>(7, {1, 2, 3, 4});
  const auto changed = [&](auto change) {
    Binary b = good;
    change(b);
    return fault(b.text());
  };
  EXPECT_THAT(changed([](Binary& b) { b.points = 65535; }),
              HasSubstr("65535 by 1 points need 524361 bytes, and the file has 113"));
  EXPECT_THAT(changed([](Binary& b) { b.data.pop_back(); }), HasSubstr("need 113 bytes"));
  EXPECT_THAT(changed([](Binary& b) { b.points = b.profiles = 65535; }),
              HasSubstr("expected from 1 to 50000000"));
  EXPECT_THAT(changed([](Binary& b) { b.points = 0; }), HasSubstr("0 by 1 points"));
  EXPECT_THAT(changed([](Binary& b) { b.points = 1; }), HasSubstr("1 point"));
  EXPECT_THAT(changed([](Binary& b) { b.x = 0; }), HasSubstr("Xscale = 0"));
  EXPECT_THAT(changed([](Binary& b) { b.x = nan; }), HasSubstr("Xscale = nan"));
  EXPECT_THAT(changed([](Binary& b) { b.z = -1; }), HasSubstr("Zscale = -1"));
  EXPECT_THAT(changed([](Binary& b) { b.z = 1e308; }), HasSubstr("point 2: a height that is not"));
  EXPECT_THAT(changed([](Binary& b) { b.compression = 1; }), HasSubstr("compressed"));
  EXPECT_THAT(changed([](Binary& b) { b.check = 1; }), HasSubstr("checksum"));
  EXPECT_THAT(changed([](Binary& b) { b.type = 8; }), HasSubstr("DataType = 8"));
  EXPECT_THAT(changed([](Binary& b) { b.version = "bISO-2.0"; }), HasSubstr("\"bISO-2.0\", which"));
  EXPECT_THAT(fault(good.text().substr(0, 80)), HasSubstr("cut off in its header"));
  EXPECT_THAT(fault("bBCR-1.0"), HasSubstr("cut off in its header"));
}

TEST_F(ProfileSdf, TextsAtFault) {
  EXPECT_THAT(fault(ascii("1 2 3")), HasSubstr("4 by 1 points by the header, and 3 heights"));
  EXPECT_THAT(fault(ascii("1 2 3 4 5")), HasSubstr("and more heights"));
  EXPECT_THAT(fault(ascii("1 2 3 4", "4000000000")), HasSubstr("4000000000 by 1 points"));
  EXPECT_THAT(fault(ascii("1 2 3 4", "40000000")), HasSubstr("and 4 heights"));
  EXPECT_THAT(fault(ascii("1 2 3 4", "-4")), HasSubstr("\"-4\": expected a whole number"));
  EXPECT_THAT(fault(ascii("1 2 3 4", "4.5")), HasSubstr("expected a whole number"));
  EXPECT_THAT(fault(ascii("1 2 3 4", "")), HasSubstr("NumPoints"));
  EXPECT_THAT(fault(ascii("1 1e400 3 4")), HasSubstr("point 2: \"1e400\" is not a finite number"));
  EXPECT_THAT(fault(ascii("1 inf 3 4")), HasSubstr("not a finite number"));
  EXPECT_THAT(fault(ascii("1 2,5 3 4")), HasSubstr("point 2: \"2,5\" is not a number"));
  EXPECT_THAT(fault(ascii("1 2 3 4", "4", "1", "Xscale = 1\n")), HasSubstr("Xscale stands twice"));
  EXPECT_THAT(fault("aISO-1.0\nNumPoints = 4\n"), HasSubstr("no line * ends the header"));
  EXPECT_THAT(fault("aISO-1.0\nNumPoints = 4\n*\n1 2 3 4\n"), HasSubstr("NumProfiles is missing"));
  EXPECT_THAT(fault("aISO-1.0\n" + std::string(5000, 'x')), HasSubstr("more than 4096 bytes"));
  EXPECT_THAT(fault("aNIST-1.0\n"), HasSubstr("which is not read"));
}

TEST_F(ProfileSdf, EverySpoiltByteIsReadOrRefused) {
  for (const std::string& text :
       {ascii("1 2 BAD 4\n*\n"), Binary().with<std::int16_t>(5, {1, 2, -32768, 4}).text()})
    for (std::size_t i = 0; i <= text.size(); ++i)
      for (const int byte : {0, 42, 255}) {
        std::string spoilt = text.substr(0, i);
        EXPECT_NO_THROW(fault(spoilt)) << i;
        spoilt += static_cast<char>(byte);
        if (i < text.size()) spoilt += text.substr(i + 1);
        EXPECT_NO_THROW(fault(spoilt)) << i << ' ' << byte;
      }
}

TEST_F(ProfileSdf, WhatFollowsTheHeightsIsATextOrDoubted) {
  Binary b;
  const std::string whole = b.with<std::int16_t>(5, {1, 2, 3, 4, 300, 6}).text();  // 4 are counted
  EXPECT_THAT(read(whole).doubt,
              HasSubstr("profile.txt: 4 bytes that are no text follow the 4 by 1 heights"));
  b.points = 6;
  EXPECT_EQ(read(b.text()).doubt, "");
  EXPECT_EQ(read(b.text() + "by us, 2026\r\n").doubt, "");
  EXPECT_EQ(read(b.text() + std::string(100, '\0')).doubt, "");
  b.points = 2;
  b.profiles = 2;
  std::ofstream(file, std::ios::binary) << b.text();
  EXPECT_THAT(read_height_map(file, {}).doubt, HasSubstr("no text follow the 2 by 2 heights"));
  EXPECT_THAT(read(ascii("1 2 3 42")).doubt, HasSubstr("the last line has no end"));
  for (const char* end : {"\n", " ", "\r\n*\r\n", " *"})
    EXPECT_EQ(read(ascii("1 2 3 42") + end).doubt, "");
}

TEST_F(ProfileSdf, HeightsThatNoFaceHasAreRefused) {
  Binary b;
  EXPECT_EQ(fault(b.with<double>(7, {0, 1e12 - 1, nan, 1}).text()), "no error");
  std::string turned = b.with<double>(7, {0, 123.456, 654.321, 1}).text();  // to the other order
  for (std::size_t i = turned.size() - 32; i < turned.size(); i += 8)
    std::reverse(turned.begin() + static_cast<std::ptrdiff_t>(i),
                 turned.begin() + static_cast<std::ptrdiff_t>(i + 8));
  EXPECT_THAT(fault(turned), AllOf(HasSubstr("profile.txt: the heights span"),
                                   HasSubstr("m, which no face does: the file is damaged")));
  b.points = b.profiles = 2;
  std::ofstream(file, std::ios::binary) << b.with<double>(7, {0, 1e200, nan, 1}).text();
  try {
    read_height_map(file, {});
    ADD_FAILURE();
  } catch (const RequestError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the heights span 1e+191 m, which no face does"));
  }
}

// ---- whole maps

TEST_F(ProfileSdf, AWholeMapRowAfterRow) {
  Binary b;
  b.points = 3;
  b.profiles = 2;
  for (const std::string& text : {b.with<std::int16_t>(5, {1, 2, 3, 4, -32768, 6}).text(),
                                  ascii("1 2 3\r\n4 BAD 6\r\n*\r\n", "3", "2")}) {
    std::ofstream(file, std::ios::binary) << text;
    const HeightMap map = read_height_map(file, {});
    EXPECT_EQ(map.nx, 3U);
    EXPECT_EQ(map.ny, 2U);
    EXPECT_EQ(map.spacing, 5e-7);
    EXPECT_EQ(map.spacing_y, 2e-6);
    ASSERT_EQ(map.heights.size(), 6U);
    EXPECT_DOUBLE_EQ(map.at(2, 0), 3e-9);
    EXPECT_DOUBLE_EQ(map.at(0, 1), 4e-9);
    EXPECT_EQ(map.missing(), 1U);
    EXPECT_TRUE(std::isnan(map.at(1, 1)));
  }
}

TEST_F(ProfileSdf, WhatIsNoWholeMap) {
  const auto map_fault = [&](const std::string& text, const MapQuery& query = {}) {
    std::ofstream(file, std::ios::binary) << text;
    try {
      read_height_map(file, query);
    } catch (const RequestError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  Binary b;
  b.with<std::int16_t>(5, {1, 2, 3, 4});
  EXPECT_THAT(map_fault(b.text()), HasSubstr("one row is a profile"));
  b.points = b.profiles = 2;
  EXPECT_EQ(map_fault(b.text()), "no error");
  EXPECT_THAT(fault(b.text()), HasSubstr("'ra2d surface map'"));
  b.points = b.profiles = 65535;
  EXPECT_THAT(map_fault(b.text()), HasSubstr("expected at most 1e+08"));
  b.points = b.profiles = 9000;
  EXPECT_THAT(map_fault(b.text()), HasSubstr("cut off"));
  b.points = b.profiles = 2;
  b.y = 0;
  EXPECT_THAT(map_fault(b.text()), HasSubstr("Yscale"));
  EXPECT_THAT(map_fault(ascii("1 2 3 4", "1000000000000000", "1000000000000000")),
              HasSubstr("expected at most 1e+08"));
  EXPECT_THAT(map_fault(ascii("BAD BAD BAD BAD", "2", "2")), HasSubstr("every height is missing"));
  MapQuery query;
  query.spacing_y = 1e-6;
  EXPECT_THAT(map_fault(ascii("1 2 3 4", "2", "2"), query), HasSubstr("tells its own"));
}

}  // namespace
