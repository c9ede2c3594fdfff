// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_file.hpp"
#include "host/surface/map_output.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/map_npy.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"

/// Maps in .npy and in text: what is read, and as what; what is refused, and why. Those in SDF and
/// X3P are beside the profiles of these formats.
namespace ra2d {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using test::nan;

/// Bytes of numbers, the lowest of each first, or the highest.
template <class T>
std::string bytes_of(const std::vector<T>& values, bool big = false) {
  std::string all;
  for (const T value : values) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (big) std::reverse(bytes, bytes + sizeof(T));
    all.append(bytes, sizeof(T));
  }
  return all;
}

/// An .npy of version 1.0 or another, with this dictionary.
std::string npy(const std::string& dictionary, const std::string& data, char version = 1) {
  std::string text = std::string("\x93NUMPY") + version + '\0';
  const auto length = dictionary.size() + 1;
  for (std::size_t i = 0; i < (version == 1 ? 2 : 4); ++i)
    text += static_cast<char>(length >> (8 * i) & 0xff);
  return text + dictionary + '\n' + data;
}
std::string dictionary(const std::string& type, bool fortran, const std::string& shape) {
  return fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}", type,
                     fortran ? "True" : "False", shape);
}

struct MapFile : testing::Test {
  const test::Folder folder;
  const std::filesystem::path file = folder.path() / "map.dat";  // the name says nothing

  MapQuery spaced(double spacing = 1e-6, std::optional<double> spacing_y = {}) const {
    MapQuery query;
    query.spacing = spacing;
    query.spacing_y = spacing_y;
    return query;
  }
  HeightMap read(const std::string& content, const MapQuery& query) {
    std::ofstream(file, std::ios::binary) << content;
    return read_height_map(file, query);
  }
  std::string fault(const std::string& content, const MapQuery& query) {
    try {
      read(content, query);
    } catch (const RequestError& error) {
      return error.what();
    }
    return "no error";
  }
  std::string fault(const std::string& content) { return fault(content, spaced()); }
  void expect_read(const std::string& content, std::size_t nx, const std::vector<double>& heights,
                   const MapQuery& query) {
    try {
      const HeightMap map = read(content, query);
      EXPECT_EQ(map.nx, nx);
      ASSERT_EQ(map.heights.size(), heights.size());
      EXPECT_EQ(map.ny * map.nx, heights.size());
      for (std::size_t i = 0; i < heights.size(); ++i)
        if (std::isnan(heights[i]))
          EXPECT_TRUE(std::isnan(map.heights[i])) << i;
        else
          EXPECT_DOUBLE_EQ(map.heights[i], heights[i]) << i;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
};

// ---- .npy

TEST_F(MapFile, NpyOfEveryTypeOrderAndVersion) {
  const std::vector<double> rows{1e-7, 2e-7, -3e-7, 4e-7, 5e-7, 0},
      columns{1e-7, 4e-7, 2e-7, 5e-7, -3e-7, 0};
  const std::vector<float> rows_4{1e-7F, 2e-7F, -3e-7F, 4e-7F, 5e-7F, 0};
  std::vector<double> from_4(rows_4.begin(), rows_4.end());
  for (const char version : {1, 2, 3}) {
    expect_read(npy(dictionary("<f8", false, "(2, 3)"), bytes_of(rows), version), 3, rows,
                spaced());
    expect_read(npy(dictionary(">f8", false, "(2, 3)"), bytes_of(rows, true), version), 3, rows,
                spaced());
  }
  expect_read(npy(dictionary("<f8", true, "(2, 3)"), bytes_of(columns)), 3, rows, spaced());
  expect_read(npy(dictionary(">f8", true, "(2, 3)"), bytes_of(columns, true)), 3, rows, spaced());
  expect_read(npy(dictionary("<f4", false, "(2, 3)"), bytes_of(rows_4)), 3, from_4, spaced());
  expect_read(npy(dictionary(">f4", false, "(2, 3)"), bytes_of(rows_4, true)), 3, from_4, spaced());
  // as other writers have the dictionary
  expect_read(npy(R"({"shape":(2,3),"descr":"<f8","fortran_order":False})", bytes_of(rows)), 3,
              rows, spaced());
}

TEST_F(MapFile, NpySpacingsUnitsAndMissingPoints) {
  const std::vector<double> um{0.1, nan, 0.3, 0.4, 0.5, 0.6};
  const std::string text = npy(dictionary("<f8", false, "(3, 2)"), bytes_of(um));
  MapQuery query = spaced(2e-6, 3e-6);
  query.z_unit = to_unit("um");
  const HeightMap map = read(text, query);
  EXPECT_EQ(map.spacing, 2e-6);
  EXPECT_EQ(map.spacing_y, 3e-6);
  EXPECT_EQ(map.missing(), 1U);
  EXPECT_DOUBLE_EQ(map.at(0, 2), 0.5e-6);
  EXPECT_EQ(read(text,
                 [&] {
                   MapQuery same = query;
                   same.spacing_y.reset();
                   return same;
                 }())
                .spacing_y,
            2e-6);
  EXPECT_THAT(fault(text), AllOf(HasSubstr("too much for metres"), HasSubstr("--z-unit")));
  EXPECT_THAT(fault(text, {}), HasSubstr("--spacing"));
  query.decimal = DecimalMark::comma;
  EXPECT_THAT(fault(text, query), HasSubstr("--decimal"));
}

TEST_F(MapFile, NpyThatLiesAboutItsSize) {
  const std::string data = bytes_of<double>({0, 0, 0, 0});
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(2, 3)"), data)),
              AllOf(HasSubstr("2 by 3 elements"), HasSubstr("cut off")));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(2, 2)"), data + "x")),
              HasSubstr("the header is wrong"));
  EXPECT_THAT(fault(npy(dictionary("<f4", false, "(2, 2)"), data)),
              HasSubstr("the header is wrong"));
  // before any memory is taken: 1e9 points, and more than 64 bits count
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(31623, 31623)"), data)),
              HasSubstr("expected at most 1e+08"));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(4294967296, 4294967296)"), data)),
              HasSubstr("expected at most 1e+08"));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(18446744073709551616, 2)"), data)),
              HasSubstr("not one that NumPy writes"));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(-2, 2)"), data)),
              HasSubstr("not one that NumPy writes"));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(0, 4)"), "")), HasSubstr("at least two rows"));
}

TEST_F(MapFile, NpyOfOtherShapesAndTypes) {
  const std::string data = bytes_of<double>({0, 0, 0, 0});
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(4,)"), data)),
              AllOf(HasSubstr("1 dimension,"), HasSubstr("one row is a profile")));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "()"), data)), HasSubstr("0 dimensions"));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(1, 2, 2)"), data)), HasSubstr("3 dimensions"));
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(1, 4)"), data)),
              HasSubstr("one row is a profile"));
  for (const char* type : {"<i4", "|O", "<c16", "<f2", "=f8", "|S8"})
    EXPECT_THAT(fault(npy(dictionary(type, false, "(2, 2)"), data)),
                AllOf(HasSubstr(type), HasSubstr("expected float32 or float64")));
  EXPECT_THAT(
      fault(npy("{'descr': [('z', '<f8')], 'fortran_order': False, 'shape': (2, 2), }", data)),
      HasSubstr("records"));
}

TEST_F(MapFile, NpyWithABrokenHeader) {
  const std::string data = bytes_of<double>({0, 0, 0, 0});
  const std::string whole = npy(dictionary("<f8", false, "(2, 2)"), data);
  for (std::size_t bytes = 6; bytes < whole.size(); ++bytes)
    EXPECT_NE(fault(whole.substr(0, bytes)), "no error") << bytes;
  for (const char* wrong :
       {"", "{", "{}", "{'shape': (2, 2)}", "{'descr': '<f8', 'descr': '<f8', }",
        "{'descr': '<f8', 'fortran_order': 0, 'shape': (2, 2)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), 'more': 1}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2)} x",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2 2)}", "{'descr': '<f8"})
    EXPECT_THAT(fault(npy(wrong, data)), HasSubstr(".npy: ")) << wrong;
  EXPECT_THAT(fault(npy(dictionary("<f8", false, "(2, 2)"), data, 4)), HasSubstr("version 4.0"));
  EXPECT_THAT(fault(npy(std::string(10001, ' '), data)), HasSubstr("expected at most 10000"));
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_THAT(fault(npy(dictionary("<f8", true, "(2, 2)"), bytes_of<double>({0, 0, inf, 0}))),
              HasSubstr("row 1, point 2: a height that is not a finite number"));
  EXPECT_THAT(
      fault(npy(dictionary("<f8", false, "(2, 2)"), bytes_of<double>({nan, nan, nan, nan}))),
      HasSubstr("every height is missing"));
}

// ---- text

TEST_F(MapFile, TextWithEverySeparator) {
  const std::vector<double> heights{1e-7, 2e-7, 3e-7, 4e-7, 5e-7, 6e-7};
  for (const char* text :
       {"1e-7 2e-7 3e-7\n4e-7 5e-7 6e-7\n", "1e-7\t2e-7\t3e-7\r\n4e-7\t5e-7\t6e-7\r\n",
        "1.0e-7,2.0e-7,3.0e-7\n4.0e-7,5.0e-7,6.0e-7", "1e-7, 2e-7, 3e-7\n\n4e-7, 5e-7, 6e-7\n",
        "1,0e-7;2,0e-7;3,0e-7;\n4,0e-7;5,0e-7;6,0e-7;\n", "1,0e-7 2,0e-7 3,0e-7\n4e-7 5e-7 6e-7\n",
        "\xef\xbb\xbf# a comment\nHeights\n 1e-7 2e-7 3e-7 # row 1\n 4e-7 5e-7 6e-7\n"})
    expect_read(text, 3, heights, spaced());
}

TEST_F(MapFile, TextUnitsAndSpacingsOfTheHeader) {
  const HeightMap map =
      read("# z [nm]\n# spacing = 2e-06 m, spacing_y = 5e-06 m\n100 200\n300 400\n500 NaN\n", {});
  EXPECT_EQ(map.spacing, 2e-6);
  EXPECT_EQ(map.spacing_y, 5e-6);
  EXPECT_DOUBLE_EQ(map.at(1, 1), 400e-9);
  EXPECT_EQ(map.missing(), 1U);
  MapQuery other = spaced(3e-6);
  const std::string text = "# spacing = 2e-06 m\n1e-7 2e-7\n3e-7 4e-7\n";
  EXPECT_THAT(fault(text, other), AllOf(HasSubstr("2e-06"), HasSubstr("3e-06")));
  other = {};
  other.z_unit = to_unit("um");
  EXPECT_THAT(fault("z [nm]\nspacing = 1e-6 m\n1 2\n3 4\n", other), HasSubstr("mend the header"));
  EXPECT_THAT(fault("x [mm], z [um]\n1 2\n3 4\n"), HasSubstr("expected one unit"));
  EXPECT_THAT(fault("1 2\n3 4\n"), HasSubstr("too much for metres"));
  EXPECT_THAT(fault("1e-7 2e-7\n3e-7 4e-7\n", {}), HasSubstr("--spacing"));
}

TEST_F(MapFile, TextSpacingsOfTheHeaderInEveryUnit) {
  const std::string rows = "1e-7 2e-7\n3e-7 4e-7\n";
  for (const char* header :
       {"# spacing = 50 um\n", "# z [m], spacing = 0.05 mm, spacing_y = 50 um\n",
        "% Spacing: 5e-5m; other = 3\n", "\"spacing\" = \"50 um\"\n"}) {
    const HeightMap map = read(header + rows, {});
    EXPECT_EQ(map.spacing, 5e-5) << header;
    EXPECT_EQ(map.spacing_y, 5e-5) << header;
  }
  EXPECT_EQ(read("# spacing_y = 2 mm, spacing = 1 mm\n" + rows, {}).spacing_y, 2e-3);
  EXPECT_EQ(read("# spacing_x = 1 mm, spacing_y = 2 mm\n" + rows, {}).spacing, 1e-3);
  // said, and not understood
  for (const char* header : {"spacing = 5e-5", "spacing = 50 furlongs", "spacing = -1 um",
                             "spacing = 0 m", "spacing = nan m", "spacing = 1e999 m", "spacing =",
                             "spacing_y = 1e999 m", "spacing = 3 kg", "spacing = 0,05 mm"})
    EXPECT_THAT(fault("# line\n# spacing = 2 um\n# " + std::string(header) + "\n" + rows, {}),
                AllOf(HasSubstr(":3: spacing"), HasSubstr("expected a length")))
        << header;
  EXPECT_THAT(fault("# spacing = 2 um, spacing = 3 um\n" + rows, {}), HasSubstr("expected one"));
  // of something else
  EXPECT_EQ(read("# spacing = 1 um, line spacing = 3 m\n" + rows, {}).spacing_y, 1e-6);
}

TEST_F(MapFile, ProfilesAndListsOfPointsAreNoMaps) {
  EXPECT_THAT(fault("x [mm]; z [um]\n1; 2\n3; 4\n"), HasSubstr("a profile"));
  EXPECT_THAT(fault("1e-7\n2e-7\n"), HasSubstr("a profile is no map"));
}

TEST_F(MapFile, TextWhoseRowsDiffer) {
  EXPECT_THAT(fault("1e-7 2e-7 3e-7\n4e-7 5e-7\n1e-7 2e-7 3e-7 4e-7\n"),
              AllOf(HasSubstr("map.dat:2: 2 heights, and 3 in the rows before"),
                    HasSubstr("map.dat:3: 4 heights")));
  EXPECT_THAT(fault("1e-7 2e-7 3e-7\n4e-7 5e-"), HasSubstr("was the file cut off here?"));
  EXPECT_THAT(fault("1e-7 2e-7 3e-7\n"), HasSubstr("one row is a profile"));
  EXPECT_THAT(fault("1e-7\n2e-7\n3e-7\n"), HasSubstr("expected a row of heights"));
  EXPECT_THAT(fault("1e-7 2e-7\n3e-7 four\n"), HasSubstr("height 2: \"four\" is not a number"));
  EXPECT_THAT(fault("1e-7 2e-7\n3e-7 1e999\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(fault("1e-7 2e-7\n3e-7 inf\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(fault("nothing\n"), HasSubstr("no line of numbers"));
  EXPECT_THAT(fault(""), HasSubstr("no line of numbers"));
  EXPECT_THAT(fault("1,2,3\n4,5,6\n"), HasSubstr("--decimal point"));
  EXPECT_THAT(fault("nan nan 1\nnan nan nan\n" + std::string(4, '\0')), HasSubstr("binary"));
  EXPECT_THAT(fault(std::string("\xff\xfe") + "1"), HasSubstr("UTF-16"));
}

TEST_F(MapFile, TextMissingPoints) {
  expect_read("1e-7;;3e-7\nNaN;n/a;NA\n", 3, {1e-7, nan, 3e-7, nan, nan, nan}, spaced());
}

/// Some programs write the places of the points around the heights.
TEST_F(MapFile, TextWithPlacesInItsFirstRowOrColumnIsDoubted) {
  const auto doubt = [&](bool has_x, bool has_y, double tilt = 0) {
    std::string text = "z [um], spacing = 8 um\n";
    if (has_x) {
      text += has_y ? "0" : "";
      for (int i = 0; i < 15; ++i) text += fmt::format(" {:.3f}", 0.0083 * i);
      text += '\n';
    }
    for (int j = 0; j < 12; ++j) {
      text += has_y ? fmt::format("{:.3f}", 0.0083 * j) : "";
      for (int i = 0; i < 15; ++i)
        text +=
            i == 14 && j == 0
                ? std::string(" nan")
                : fmt::format(" {:.3f}", tilt * (i + 2 * j) + std::sin(1.7 * i * j + i + 2.9 * j));
      text += '\n';
    }
    return read(text, {}).doubt;
  };
  EXPECT_EQ(doubt(false, false), "");
  EXPECT_EQ(doubt(false, false, 10), "");  // all rows and columns are even
  EXPECT_THAT(doubt(true, false), HasSubstr("its first row go in even steps, as places along x"));
  EXPECT_THAT(doubt(false, true),
              HasSubstr("its first column go in even steps, as places along y"));
  EXPECT_THAT(doubt(true, true), HasSubstr("its first row"));
}

// ---- round trips

TEST_F(MapFile, WhatIsWrittenIsReadBackToTheBit) {
  HeightMap map{5, 300, 0.1e-6, 1.0 / 3 * 1e-6, {}};
  for (int k = 0; k < 1500; ++k) map.heights.push_back(std::sin(k * 1.7) * 1e-8 / 3);
  map.heights[7] = nan;
  for (const char* name : {"map.txt", "map.npy"}) {
    const auto written = folder.path() / name;
    write_height_map(written, map, "made of a, spacing = 3.txt");
    const bool npy_name = is_npy_name(written);
    const HeightMap back =
        read_height_map(written, npy_name ? spaced(map.spacing, map.spacing_y) : MapQuery{});
    EXPECT_EQ(back.nx, map.nx);
    EXPECT_EQ(back.ny, map.ny);
    EXPECT_EQ(back.spacing, map.spacing);
    EXPECT_EQ(back.spacing_y, map.spacing_y);
    ASSERT_EQ(back.heights.size(), map.heights.size());
    for (std::size_t k = 0; k < map.heights.size(); ++k)
      if (k == 7)
        EXPECT_TRUE(std::isnan(back.heights[k]));
      else
        EXPECT_EQ(back.heights[k], map.heights[k]) << k;
  }
  EXPECT_EQ(npy_header(300, 5).size() % 64, 0U);
}

}  // namespace
}  // namespace ra2d
