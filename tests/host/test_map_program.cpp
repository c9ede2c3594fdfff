// SPDX-License-Identifier: BSD-3-Clause
// 'ra2d surface generate --width' and 'ra2d surface map'.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/surface/map_file.hpp"
#include "host/surface/random_map.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ra2d::test::Ended;
using testing::AllOf;
using testing::HasSubstr;
using Words = std::vector<std::string>;

class MapProgram : public testing::Test {
 protected:
  Ended run(const Words& words, const Words& more = {}) const {
    Words all{ra2d::test::program(), "surface"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), more.begin(), more.end());
    return ra2d::test::run_program(folder_.path(), all);
  }
  Words generate(const std::string& file) const {
    return {"generate", "-o",        file,   "--length", "0.002", "--width",
            "0.001",    "--spacing", "1e-5", "--rq",     "1e-6",  "--rsm",
            "2.5e-4",   "--rsm-y",   "4e-4", "--seed",   "7"};
  }
  const ra2d::test::Folder folder_;
};

TEST_F(MapProgram, GeneratesAMapThatMapReads) {
  const ra2d::HeightMap map =
      ra2d::random_map({1e-6, 2.5e-4, 4e-4, true, 7}, 0.002, 0.001, 1e-5, 2e-5);
  ra2d::MapQuery spacings;
  spacings.spacing = 1e-5;
  spacings.spacing_y = 2e-5;
  for (const std::string name : {"m.txt", "m.npy"}) {
    const Ended made = run(generate(name), {"--spacing-y", "2e-5"});
    ASSERT_EQ(made.status, 0) << made.err;
    EXPECT_THAT(made.out, AllOf(HasSubstr("heights in metres"), HasSubstr("201 by 50 points"),
                                HasSubstr("RSm along y")));
    const bool npy = name == "m.npy";
    const ra2d::HeightMap back =
        ra2d::read_height_map(folder_.path() / name, npy ? spacings : ra2d::MapQuery{});
    EXPECT_EQ(back.heights, map.heights);
    EXPECT_EQ(back.spacing_y, 2e-5);
    const Ended read =
        npy ? run({"map", name, "--spacing", "1e-5", "--spacing-y", "2e-5", "--json"})
            : run({"map", name, "--json"});
    ASSERT_EQ(read.status, 0) << read.err;
    const Json json = Json::parse(read.out);
    EXPECT_EQ(json["nodes"]["x"], 201);
    EXPECT_EQ(json["nodes"]["y"], 50);
    EXPECT_EQ(json["spacing_y"], 2e-5);
    EXPECT_EQ(json["missing"], 0);
    // Rq is exact over the area; the sum over its points is off by the ends, (pi spacing/l)^2/12
    EXPECT_NEAR(double(json["parameters"]["Sq"]), 1e-6, 0.03e-6);
    EXPECT_GT(double(json["parameters"]["RSm_y"]), double(json["parameters"]["RSm"]));
  }
}

TEST_F(MapProgram, AnInfiniteRsmYMakesGrooves) {
  const Ended made =
      run({"generate", "-o", "g.txt", "--length", "0.002", "--width", "1e-4", "--spacing", "1e-5",
           "--rq", "1e-6", "--rsm", "2.5e-4", "--rsm-y", "inf", "--json"});
  ASSERT_EQ(made.status, 0) << made.err;
  const Json json = Json::parse(made.out);
  EXPECT_TRUE(json["parameters"]["RSm_y"].is_null());
  const ra2d::HeightMap map = ra2d::read_height_map(folder_.path() / "g.txt", {});
  for (std::size_t i = 0; i < map.nx; ++i) ASSERT_EQ(map.at(i, 9), map.at(i, 0));
}

TEST_F(MapProgram, PreparesAMeasuredMap) {
  std::ofstream(folder_.path() / "tilted.csv") << "z [um]\n0;1;2;3\n1;2;;4\n2;3;4;5\n3;4;5;6.5\n";
  const Words map{"map", "tilted.csv", "--spacing", "1e-6"};
  EXPECT_THAT(run(map).err, AllOf(HasSubstr("row 2, point 3"), HasSubstr("--fill")));
  const Ended tilted = run(map, {"--fill", "linear:1e-6"});
  EXPECT_EQ(tilted.status, 0);
  EXPECT_THAT(tilted.err, HasSubstr("try --form plane"));
  EXPECT_THAT(tilted.out, HasSubstr("1 missing points filled"));
  const Ended level = run(map, {"--fill", "linear:1e-6", "--form", "plane", "--length", "5e-6",
                                "--width", "7e-6", "--extend", "mirror", "-o", "out.npy"});
  ASSERT_EQ(level.status, 0) << level.err;
  EXPECT_EQ(level.err, "");
  ra2d::MapQuery query;
  query.spacing = 1e-6;
  const ra2d::HeightMap out = ra2d::read_height_map(folder_.path() / "out.npy", query);
  EXPECT_EQ(out.nx, 6U);
  EXPECT_EQ(out.ny, 7U);
  for (std::size_t j = 0; j < 7; ++j) EXPECT_EQ(out.at(4, j), out.at(2, j));
  for (const double z : out.heights) EXPECT_LT(std::abs(z), 0.5e-6);  // no tilt is left
}

TEST_F(MapProgram, DoubtsSlopesThatNoFaceHas) {
  std::ofstream points(folder_.path() / "points.txt"), rows(folder_.path() / "rows.txt");
  rows << "z [um] spacing = 10 um, spacing_y = 0.02 mm\n";
  for (int i = 0; i < 100; ++i) {
    points << fmt::format("{:.6f} {}\n", 1e-5 * i, 1e-7 * (i % 7));
    for (int j = 0; j < 50; ++j) rows << (i + j) % 7 << (j < 49 ? ' ' : '\n');
  }
  points.close();
  rows.close();
  const Ended list = run({"map", "points.txt", "--spacing", "1e-6", "--z-unit", "m"});
  EXPECT_EQ(list.status, 0);
  EXPECT_THAT(list.err, AllOf(HasSubstr("steeper than any face"), HasSubstr("list of points")));
  const Ended map = run({"map", "rows.txt", "--json"});
  EXPECT_EQ(map.err, "");
  EXPECT_EQ(Json::parse(map.out)["spacing"], 1e-5);
  EXPECT_EQ(Json::parse(map.out)["spacing_y"], 2e-5);
  std::ofstream(folder_.path() / "narrow.txt") << "# z [um], spacing = 10 um, spacing_y = 10 nm\n"
                                                  "1 2 1\n2 3 2\n1 2 1\n";
  const Ended narrow = run({"map", "narrow.txt"});
  EXPECT_EQ(narrow.status, 0);
  EXPECT_THAT(narrow.err, AllOf(HasSubstr("its slopes have a root mean square of 100 along y,"),
                                testing::Not(HasSubstr("along x"))));
  std::ofstream(folder_.path() / "both.txt") << "# z [mm], spacing = 10 um\n1 2 1\n2 3 2\n1 2 1\n";
  const Ended both = run({"map", "both.txt"});
  EXPECT_THAT(both.err, HasSubstr("of 100 along x and 100 along y, steeper than any face"));
  EXPECT_EQ(std::count(both.err.begin(), both.err.end(), '\n'), 1);
}

TEST_F(MapProgram, DoubtsAFileThatMayBeCutOffInItsLastNumber) {
  const std::string text = "# z [um], spacing = 10 um\n1.25 2.5 1.25\n2.5 1.25 2.25\n1.25 2.5 1.2";
  for (const std::string rest : {"", "\n", "5"}) {
    std::ofstream(folder_.path() / "m.txt") << text << rest;
    const Ended map = run({"map", "m.txt"});
    EXPECT_EQ(map.status, 0);
    EXPECT_EQ(map.err.find("m.txt: the last line has no end") != map.err.npos, rest.empty())
        << map.err;
  }
}

TEST_F(MapProgram, AConvertedMapIsReadWhateverItsFileWasCalled) {
  std::ofstream(folder_.path() / "scan [nm], (mm).txt") << "# z [um], spacing = 10 um\n1 2\n2 1\n";
  const Ended made = run({"map", "scan [nm], (mm).txt", "-o", "m.txt"});
  ASSERT_EQ(made.status, 0) << made.err;
  const Ended read = run({"map", "m.txt", "--json"});
  ASSERT_EQ(read.status, 0) << read.err;
  EXPECT_EQ(Json::parse(read.out)["spacing"], 1e-5);
  EXPECT_DOUBLE_EQ(double(Json::parse(read.out)["parameters"]["Sq"]), 0.5e-6);
}

TEST_F(MapProgram, RefusesWithTheCure) {
  std::ofstream(folder_.path() / "m.csv") << "1e-7 2e-7\n3e-7 4e-7\n";
  std::ofstream(folder_.path() / "mine.npy") << "not ra2d's";
  std::ofstream(folder_.path() / "mine.txt") << "not ra2d's";
  const Words map{"map", "m.csv", "--spacing", "1e-6"};
  const std::vector<std::pair<Ended, std::string>> cases{
      {run({"map", "m.csv"}), "--spacing-y"},
      {run(map, {"--length", "5e-6"}), "--extend"},
      {run(map, {"--extend", "mirror"}), "without --length or --width"},
      {run(map, {"--length", "1", "--width", "1", "--extend", "mirror"}), "expected at most 1e+08"},
      {run(map, {"--form", "line"}), "plane"},
      {run(map, {"-o", "m.csv"}), "m.csv"},
      {run(map, {"-o", "mine.npy"}), "left as it is"},
      {run(map, {"-o", "mine.txt"}), "left as it is"},
      {run({"measure", "m.csv", "--row", "1"}), "--row"},
      {run(generate("mine.npy")), "left as it is"},
      {run(generate("new.txt"), {"--skewness", "1"}), "--skewness is of profiles"},
      {run(generate("new.txt"), {"--exact", "rq+rsm"}), "rq+rsm"},
      {run(generate("new.txt"), {"--correlation", "exponential"}), "gaussian"},
      {run(generate("new.txt"), {"--spacing-y", "2e-4"}), "not resolved"},
      {run({"generate", "-o", "new.txt", "--length", "0.02", "--width", "1e-5", "--spacing", "2e-5",
            "--rq", "1e-6", "--rsm", "1e-4"}),
       "the random map: 1001 by 1 points"},
      {run({"generate", "-o", "new.npy", "--length", "0.002", "--spacing", "1e-5", "--rq", "1e-6",
            "--rsm", "2.5e-4"}),
       "--width"},
      {run({"generate", "-o", "new.txt", "--length", "0.002", "--spacing", "1e-5", "--rq", "1e-6",
            "--rsm", "2.5e-4", "--rsm-y", "1e-3"}),
       "--width"}};
  for (const auto& [ended, says] : cases) {
    EXPECT_EQ(ended.status, 2) << says;
    EXPECT_THAT(ended.err, HasSubstr(says));
  }
  EXPECT_EQ(ra2d::test::read_file(folder_.path() / "mine.npy"), "not ra2d's");
  EXPECT_FALSE(fs::exists(folder_.path() / "new.txt"));
}

}  // namespace
