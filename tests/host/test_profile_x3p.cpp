// SPDX-License-Identifier: BSD-3-Clause
// Profiles in X3P (ISO 25178-72): what is read, and as what; what is refused, and why.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <zip.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
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

std::string md5_of(const std::string& bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_md5(), nullptr);
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

/// Bytes of numbers, the lowest of each first (the machines that tests run on do the same).
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

const std::string even_x =
    "<CX><AxisType>I</AxisType><Increment>5e-7</Increment><Offset>1</Offset></CX>";
const std::string even_y = "<CY><AxisType>I</AxisType><Increment>2e-6</Increment></CY>";

std::string z_axis(const std::string& type, const std::string& more = "") {
  return "<CZ><AxisType>A</AxisType><DataType>" + type + "</DataType>" + more + "</CZ>";
}
const std::string in_nm = "<Increment>1e-9</Increment>";

std::string document(const std::string& axes, const std::string& record3) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\"><Record1><Revision>ISO5436 "
         "- 2000</Revision><FeatureType>PRF</FeatureType><Axes>" +
         axes + "</Axes></Record1><Record3>" + record3 +
         "</Record3><Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4></p:ISO5436_2>";
}

std::string matrix(int x, int y = 1, int z = 1) {
  return fmt::format(
      "<MatrixDimension><SizeX>{}</SizeX><SizeY>{}</SizeY><SizeZ>{}</SizeZ></MatrixDimension>", x,
      y, z);
}

std::string link(const std::string& data, const std::string& more = "") {
  return "<DataLink><PointDataLink>bindata/data.bin</PointDataLink><MD5ChecksumPointData>" +
         md5_of(data) + "</MD5ChecksumPointData>" + more + "</DataLink>";
}

using Files = std::vector<std::pair<std::string, std::string>>;

struct ProfileX3p : testing::Test {
  const ra2d::test::Folder folder;
  const std::filesystem::path file = folder.path() / "profile.csv";  // the name says nothing

  void pack(const Files& files) {
    std::filesystem::remove(file);
    int error = 0;
    zip_t* archive = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
    ASSERT_NE(archive, nullptr);
    for (const auto& [name, text] : files)
      ASSERT_GE(zip_file_add(archive, name.c_str(),
                             zip_source_buffer(archive, text.data(), text.size(), 0), 0),
                0);
    ASSERT_EQ(zip_close(archive), 0);
  }
  void pack(const std::string& main, const std::string& data) {
    pack({{"main.xml", main},
          {"md5checksum.hex", md5_of(main) + " *main.xml\n"},
          {"bindata/data.bin", data}});
  }
  std::string fault(const ProfileQuery& query = {}) {
    try {
      read_measured_profile(file, query);
    } catch (const RequestError& error) {
      return error.what();
    }
    return "no error";
  }
  std::string fault_of(const std::string& main, const std::string& data) {
    pack(main, data);
    return fault();
  }
  /// Heights in nm.
  void expect_read(const std::vector<double>& nm, double spacing = 5e-7,
                   const ProfileQuery& query = {}) {
    try {
      const Profile profile = read_measured_profile(file, query);
      EXPECT_NEAR(profile.spacing, spacing, 1e-9 * spacing);  // places at 1 m tell no more
      ASSERT_EQ(profile.heights.size(), nm.size());
      for (std::size_t i = 0; i < nm.size(); ++i)
        if (std::isnan(nm[i]))
          EXPECT_TRUE(std::isnan(profile.heights[i])) << i;
        else
          EXPECT_NEAR(profile.heights[i], nm[i] * 1e-9, 1e-15 * std::abs(nm[i]) * 1e-9 + 1e-24)
              << i;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
  void expect_binary(const std::string& axes, const std::string& data,
                     const std::vector<double>& nm) {
    pack(document(axes, matrix(static_cast<int>(nm.size())) + link(data)), data);
    expect_read(nm);
  }
};

TEST_F(ProfileX3p, EveryTypeOfHeights) {
  const std::string axes = even_x + even_y;
  expect_binary(axes + z_axis("I", in_nm), bytes_of<std::int16_t>({0, -2, 258, 32767}),
                {0, -2, 258, 32767});
  expect_binary(axes + z_axis("L", in_nm), bytes_of<std::int32_t>({0, -2, 16909060, 2147483647}),
                {0, -2, 16909060, 2147483647});
  expect_binary(axes + z_axis("F", in_nm), bytes_of<float>({0, 1.5F, -2.25F, 3e4F}),
                {0, 1.5, -2.25, 3e4F});
  expect_binary(axes + z_axis("D", in_nm), bytes_of<double>({0, 1.5, nan, 3e4}),
                {0, 1.5, nan, 3e4});
  expect_binary(axes + z_axis("D"), bytes_of<double>({0, 1e-9, -2e-9}), {0, 1, -2});
  expect_binary(axes + z_axis("I", in_nm + "<Offset>5e-9</Offset>"),
                bytes_of<std::int16_t>({0, -2}), {5, 3});
}

TEST_F(ProfileX3p, AxesThatListTheirPlaces) {
  const auto x = [](const char* type, const std::string& more = "") {
    return fmt::format("<CX><AxisType>A</AxisType><DataType>{}</DataType>{}</CX>", type, more);
  };
  const auto both = [](auto first, auto second) {
    std::string bytes;
    for (std::size_t i = 0; i < first.size(); ++i)
      bytes += bytes_of<typename decltype(first)::value_type>({first[i]}) +
               bytes_of<typename decltype(second)::value_type>({second[i]});
    return bytes;
  };
  const std::vector<std::int16_t> z = {1, -2, 3};
  const std::string tail = even_y + z_axis("I", in_nm);
  expect_binary(x("D") + tail, both(std::vector<double>{1, 1 + 5e-7, 1 + 1e-6}, z), {1, -2, 3});
  expect_binary(x("L", "<Increment>1e-7</Increment>") + tail,
                both(std::vector<std::int32_t>{-5, 0, 5}, z), {1, -2, 3});
  std::string data = both(std::vector<double>{0, 5e-7, 2e-6}, z);
  EXPECT_THAT(fault_of(document(x("D") + tail, matrix(3) + link(data)), data),
              HasSubstr("expected an even spacing of 1e-06 m"));
  data = both(std::vector<double>{0, -5e-7, -1e-6}, z);
  EXPECT_THAT(fault_of(document(x("D") + tail, matrix(3) + link(data)), data),
              HasSubstr("do not increase"));
}

TEST_F(ProfileX3p, PointsInTheDocument) {
  const auto list = [](const std::string& points) { return "<DataList>" + points + "</DataList>"; };
  const std::string axes = even_x + even_y + z_axis("D");
  pack(document(axes, matrix(3) + list("<Datum>1e-9</Datum><Datum/><Datum> -3E-9 </Datum>")), "");
  expect_read({1, nan, -3});
  const std::string absolute =
      "<CX><AxisType>A</AxisType><DataType>D</DataType></CX>" + even_y + z_axis("D");
  pack(document(absolute, "<ListDimension>2</ListDimension>" +
                              list("<Datum>1e-3;1e-9</Datum><Datum>2e-3; 2e-9</Datum>")),
       "");
  expect_read({1, 2}, 1e-3);
  const std::string few = list("<Datum>1e-9</Datum><Datum>1e-9</Datum>");
  EXPECT_THAT(fault_of(document(axes, matrix(3) + few), ""), HasSubstr("and 2 in its list"));
  EXPECT_THAT(fault_of(document(axes, matrix(1) + few), ""), HasSubstr("and 2 in its list"));
  for (const char* point : {"1;2", "x", "1e400", "1;"})
    EXPECT_THAT(
        fault_of(document(axes, matrix(2) +
                                    list(fmt::format("<Datum>0</Datum><Datum>{}</Datum>", point))),
                 ""),
        HasSubstr("point 2: \"" + std::string(point) + "\" is not a point"));
}

TEST_F(ProfileX3p, TheMaskMakesPointsMissing) {
  const std::string data = bytes_of<std::int16_t>({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  const std::string mask = "\xfb\x01";  // all but the third and the tenth
  const std::string valid = "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>";
  const auto pack_masked = [&](const std::string& more, const std::string& bits, int rows) {
    const std::string main = document(even_x + even_y + z_axis("I", in_nm),
                                      matrix(10 / rows, rows) + link(data, valid + more));
    pack({{"main.xml", main},
          {"md5checksum.hex", md5_of(main)},
          {"bindata/data.bin", data},
          {"bindata/valid.bin", bits}});
  };
  const auto sum = [](const std::string& md5) {
    return "<MD5ChecksumValidPoints>" + md5 + "</MD5ChecksumValidPoints>";
  };
  for (const std::string& more : {std::string(), sum(md5_of(mask))}) {
    pack_masked(more, mask, 1);
    expect_read({0, 1, nan, 3, 4, 5, 6, 7, 8, nan});
  }
  ProfileQuery row2, column5;
  row2.row = 2;
  column5.column = 5;
  pack_masked("", mask, 2);
  expect_read({5, 6, 7, 8, nan}, 5e-7, row2);
  expect_read({4, nan}, 2e-6, column5);
  pack_masked(sum(md5_of("other")), mask, 1);
  EXPECT_THAT(fault(), HasSubstr("the checksum of bindata/valid.bin"));
  pack_masked("", mask + "x", 1);
  EXPECT_THAT(fault(), HasSubstr("\"bindata/valid.bin\" has 3 bytes, expected 2"));
}

TEST_F(ProfileX3p, RowsAndColumnsOfAnArealFile) {
  const std::string data = bytes_of<std::int16_t>({11, 12, 13, 21, 22, 23});
  pack(document(even_x + even_y + z_axis("I", in_nm), matrix(3, 2) + link(data)), data);
  ProfileQuery row2, column3, row3, mm;
  row2.row = 2;
  column3.column = 3;
  row3.row = 3;
  mm.row = 1;
  mm.z_unit = to_unit("mm");
  expect_read({21, 22, 23}, 5e-7, row2);
  expect_read({13, 23}, 2e-6, column3);
  EXPECT_THAT(fault(), AllOf(HasSubstr("--row (1 to 2,"), HasSubstr("--column (1 to 3,")));
  EXPECT_THAT(fault(row3), HasSubstr("--row 3: the file has the rows 1 to 2"));
  EXPECT_THAT(fault(mm), HasSubstr("z is in m, as in every X3P file, and in mm by --z-unit"));
  pack(document(even_x + z_axis("I", in_nm), matrix(3, 2) + link(data)), data);
  EXPECT_THAT(fault(column3), HasSubstr("has no CY"));
}

TEST_F(ProfileX3p, ChecksumsAreVerified) {
  const std::string data = bytes_of<std::int16_t>({1, 2, 3});
  const std::string main = document(even_x + even_y + z_axis("I", in_nm), matrix(3) + link(data));
  pack({{"main.xml", main}, {"md5checksum.hex", md5_of("other")}, {"bindata/data.bin", data}});
  EXPECT_THAT(fault(), HasSubstr("the checksum of main.xml is " + md5_of(main)));
  pack({{"main.xml", main}, {"md5checksum.hex", ""}, {"bindata/data.bin", data}});
  EXPECT_THAT(fault(), HasSubstr("the checksum of main.xml"));
  pack({{"main.xml", main}, {"bindata/data.bin", data}});
  EXPECT_THAT(fault(), HasSubstr("there is no \"md5checksum.hex\""));
  pack(main, bytes_of<std::int16_t>({1, 2, 4}));
  EXPECT_THAT(fault(), HasSubstr("the checksum of bindata/data.bin"));
  std::string loud = md5_of(main);
  for (char& c : loud) c = static_cast<char>(std::toupper(c));
  pack({{"main.xml", main}, {"md5checksum.hex", loud}, {"bindata/data.bin", data}});
  expect_read({1, 2, 3});
}

TEST_F(ProfileX3p, DocumentsAtFault) {
  const std::string data = bytes_of<std::int16_t>({1, 2, 3});
  const std::string axes = even_x + even_y + z_axis("I", in_nm);
  const auto with = [&](const std::string& main) { return fault_of(main, data); };
  EXPECT_THAT(with("<a"), HasSubstr("main.xml, byte"));
  EXPECT_THAT(with("<a/>"), HasSubstr("begins with \"a\", expected ISO5436_2"));
  EXPECT_THAT(with(document("", matrix(3) + link(data))),
              HasSubstr("has no p:ISO5436_2/Record1/Axes/CX"));
  EXPECT_THAT(with(document(axes, link(data))), HasSubstr("Record3/ListDimension"));
  EXPECT_THAT(with(document(axes, matrix(3))), HasSubstr("Record3/DataList"));
  EXPECT_THAT(with(document(axes, matrix(3, 1, 2) + link(data))), HasSubstr("several layers"));
  EXPECT_THAT(with(document(axes, matrix(0) + link(data))), HasSubstr("a whole number from 1"));
  EXPECT_THAT(with(document(axes, matrix(2000000000) + link(data))),
              HasSubstr("expected from 1 to 50000000"));
  EXPECT_THAT(with(document(axes, matrix(40000000) + link(data))),
              HasSubstr("\"bindata/data.bin\" has 6 bytes, expected 80000000"));
  EXPECT_THAT(with(document(axes, matrix(2) + link(data))), HasSubstr("has 6 bytes, expected 4"));
  EXPECT_THAT(with(document(even_x + even_y + z_axis("X"), matrix(3) + link(data))),
              HasSubstr("CZ/DataType = \"X\": expected I, L, F or D"));
  EXPECT_THAT(with(document(even_x + even_y + z_axis("I", "<Increment>1e400</Increment>"),
                            matrix(3) + link(data))),
              HasSubstr("CZ/Increment = \"1e400\": expected a number"));
  EXPECT_THAT(with(document(
                  "<CX><AxisType>I</AxisType><Increment>0</Increment></CX>" + even_y + z_axis("I"),
                  matrix(3) + link(data))),
              HasSubstr("CX/Increment = \"0\": expected a length"));
  EXPECT_THAT(
      with(document("<CX><AxisType>I</AxisType><Increment/></CX>" + even_y + z_axis("I", in_nm),
                    matrix(3) + link(data))),
      HasSubstr("CX/Increment = \"\": expected a number"));
  EXPECT_THAT(with(document(axes + "<Rotation><r11>0</r11></Rotation>", matrix(3) + link(data))),
              HasSubstr("rotated"));
  const std::string infinite = bytes_of<double>({1, std::numeric_limits<double>::infinity(), 3});
  EXPECT_THAT(
      fault_of(document(even_x + even_y + z_axis("D"), matrix(3) + link(infinite)), infinite),
      HasSubstr("point 2: a height that is not a finite number"));
}

TEST_F(ProfileX3p, EntitiesAreNotExpanded) {
  std::string bomb = "<?xml version=\"1.0\"?><!DOCTYPE b [<!ENTITY a \"aaaaaaaaaa\">";
  for (char c = 'b'; c < 'k'; ++c) {
    bomb += fmt::format("<!ENTITY {} \"", c);
    for (int i = 0; i < 10; ++i) bomb += fmt::format("&{};", static_cast<char>(c - 1));
    bomb += "\">";
  }
  pack(bomb + "]><ISO5436_2>&j;</ISO5436_2>", "");
  EXPECT_THAT(fault(), HasSubstr("document type"));
  std::string tags = "<ISO5436_2>";
  for (int i = 0; i < 300'000; ++i) tags += "<a>";
  pack(tags, "");
  EXPECT_THAT(fault(), HasSubstr("more than 250000 tags"));
}

TEST_F(ProfileX3p, ArchivesAtFault) {
  const std::string data = bytes_of<std::int16_t>({1, 2, 3});
  const std::string main = document(even_x + even_y + z_axis("I", in_nm), matrix(3) + link(data));
  pack({{"a.txt", "no profile"}});
  EXPECT_THAT(fault(), HasSubstr("there is no main.xml in it"));
  pack({{"inner/main.xml", main}});
  EXPECT_THAT(fault(), HasSubstr("there is no main.xml in it"));
  pack({{"main.xml", main}, {"md5checksum.hex", md5_of(main)}});
  EXPECT_THAT(fault(), HasSubstr("there is no \"bindata/data.bin\""));
  pack({{"main.xml", std::string(9u << 20, ' ')}});
  EXPECT_THAT(fault(), HasSubstr("has 9437184 bytes, expected at most 8388608"));

  const std::string bomb(64u << 20, '\0');  // of 64 KiB
  const std::string large =
      document(even_x + even_y + z_axis("I", in_nm), matrix(1 << 25) + link(bomb));
  pack(large, bomb);
  EXPECT_THAT(fault(), HasSubstr("which no measurement does"));

  Files many{{"main.xml", main}};
  for (int i = 0; i < 120; ++i) many.emplace_back(fmt::format("{}", i), "");
  pack(many);
  EXPECT_THAT(fault(), HasSubstr("more files than any profile has"));

  // a path that leads away names nothing but an entry
  const std::string away = folder.path() / "outside.bin";
  std::ofstream(away, std::ios::binary) << data;
  std::string led = main;
  for (const std::string& name : {away, std::string("../outside.bin")}) {
    led = main;
    led.replace(led.find("bindata/data.bin"), 16, name);
    pack(led, data);
    EXPECT_THAT(fault(), HasSubstr("there is no "));
  }
}

TEST_F(ProfileX3p, CutOffAndSpoiltArchives) {
  const std::string data = bytes_of<std::int16_t>({1, 2, 3});
  pack(document(even_x + even_y + z_axis("I", in_nm), matrix(3) + link(data)), data);
  expect_read({1, 2, 3});
  const std::string whole = ra2d::test::read_file(file);
  std::size_t read = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::ofstream(file, std::ios::binary) << whole.substr(0, i);
    EXPECT_NE(fault(), "no error") << i;
    std::string spoilt = whole;
    spoilt[i] = static_cast<char>(spoilt[i] ^ 0xff);
    std::ofstream(file, std::ios::binary) << spoilt;
    std::string said;
    EXPECT_NO_THROW(said = fault()) << i;
    if (said == "no error") {
      ++read;  // a date, say: then the heights are the same
      expect_read({1, 2, 3});
    }
  }
  EXPECT_LT(read, whole.size() / 2);
}

// ---- whole maps

TEST_F(ProfileX3p, AWholeMapRowAfterRow) {
  const std::string data = bytes_of<std::int16_t>({11, 12, 13, 21, 22, 23});
  const std::string main =
      document(even_x + even_y + z_axis("I", in_nm),
               matrix(3, 2) + link(data, "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>"));
  pack({{"main.xml", main},
        {"md5checksum.hex", md5_of(main)},
        {"bindata/data.bin", data},
        {"bindata/valid.bin", "\x2f"}});  // all but the fifth
  const HeightMap map = read_height_map(file, {});
  EXPECT_EQ(map.nx, 3U);
  EXPECT_EQ(map.ny, 2U);
  EXPECT_EQ(map.spacing, 5e-7);
  EXPECT_EQ(map.spacing_y, 2e-6);
  ASSERT_EQ(map.heights.size(), 6U);
  EXPECT_DOUBLE_EQ(map.at(2, 0), 13e-9);
  EXPECT_DOUBLE_EQ(map.at(0, 1), 21e-9);
  EXPECT_EQ(map.missing(), 1U);
  EXPECT_TRUE(std::isnan(map.at(1, 1)));
}

TEST_F(ProfileX3p, WhatIsNoWholeMap) {
  const std::string data = bytes_of<std::int16_t>({11, 12, 13, 21, 22, 23});
  const auto map_fault = [&](const std::string& axes, const std::string& size) {
    pack(document(axes + z_axis("I", in_nm), size + link(data)), data);
    try {
      read_height_map(file, {});
    } catch (const RequestError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(map_fault(even_x + even_y, matrix(3, 2)), "no error");
  EXPECT_THAT(map_fault(even_x + even_y, matrix(6, 1)), HasSubstr("one row is a profile"));
  EXPECT_THAT(map_fault(even_x, matrix(3, 2)), HasSubstr("no CY"));
  EXPECT_THAT(map_fault(even_x + even_y, matrix(31623, 31623)), HasSubstr("at most 1e+08"));
  EXPECT_THAT(map_fault(even_x + even_y, matrix(9000, 9000)), HasSubstr("has 12 bytes"));
  EXPECT_THAT(
      map_fault("<CX><AxisType>A</AxisType><DataType>D</DataType></CX>" + even_y, matrix(3, 2)),
      HasSubstr("x stands at every point"));
}

}  // namespace
