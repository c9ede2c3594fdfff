// SPDX-License-Identifier: BSD-3-Clause
// Areal scenes from their files: keys, faces, refusals, and what the commands make of them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/body/plate.hpp"
#include "host/model/model.hpp"
#include "host/model/point_contacts.hpp"
#include "host/plan/stability.hpp"
#include "host/run/run_key.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/hdf5.hpp"
#include "host/study/study_table.hpp"
#include "host/surface/random_map.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;
using Changes = std::vector<std::string>;

/// A block of 11 x 6 nodes, 0.1 mm by 0.2 mm apart, on a plate.
constexpr auto areal_text = R"([scene]
kind = "areal"
duration = 1e-3
speed = 1.0
start = 0.02
spacing = 1e-4
spacing_y = 2e-4
initial = "rest"
[resonator]
support = "pinned"
length = 0.06
thickness = 0.001
width = 0.04
young = 210e9
density = 7800
damping = 0.02
modes = 20
[slider]
support = "free"
length = 1e-3
thickness = 0.005
width = 1.2e-3
density = 7800
load = 1.0
[contact]
stiffness = 1e14
[time]
scheme = "midpoint"
step = 1e-6
nodes = "all"
[output]
rate = 1e5
)";

constexpr auto gaussian_face =
    "resonator.surface={kind=\"gaussian\",rq=2e-6,rsm=1e-3,rsm_y=2e-3,seed=5}";
constexpr auto gaussian_block = "slider.surface={kind=\"gaussian\",rq=1e-6,rsm=8e-4,seed=6}";

Scene areal(const Changes& changes = {}, const fs::path& file = "areal.toml") {
  return parse_scene(areal_text, file, changes);
}

/// The message of a scene that is refused, when it is read or made ready; else "taken".
std::string refusal_of(const Changes& changes, const fs::path& file = "areal.toml") {
  try {
    make_model(areal(changes, file));
  } catch (const RequestError& fault) {
    return fault.what();
  }
  return "taken";
}

TEST(ArealScene, HasDefaults) {
  const Scene s = areal();
  EXPECT_EQ(s.kind, SceneKind::areal);
  EXPECT_EQ(s.resonator.kind, BodyKind::plate);
  EXPECT_EQ(s.slider.kind, BodyKind::block);
  EXPECT_EQ(s.spacing_y, 2e-4);
  EXPECT_EQ(s.side, 0.5 * (0.04 - 1.2e-3));
  EXPECT_EQ(s.faces, Faces::linear);
  EXPECT_EQ(s.resonator.poisson, 0.3);
  const Model m = make_model(s);
  EXPECT_TRUE(m.is_areal);
  EXPECT_EQ(m.rows, 6);
  EXPECT_EQ(m.row_nodes(), 11);
  EXPECT_EQ(m.row_heights(), 200 + 10 + 11);  // up to where the slider comes
  EXPECT_EQ(m.resonator.modes.size(), 20);
  EXPECT_EQ(m.slider.modes.size(), 3);
  EXPECT_EQ(m.node_stiffness, 1e14 * 1e-4 * 2e-4);
  EXPECT_EQ(m.delta, 0);

  const Scene plane = parse_scene(test::read_file(test::scene_file("peaks")), "peaks.toml");
  EXPECT_EQ(plane.kind, SceneKind::plane);
  EXPECT_FALSE(plane.spacing_y || plane.side);
  EXPECT_THAT(echo(plane), Not(AllOf(HasSubstr("kind = \"plane\""), HasSubstr("side"))));
  // a pinned plate's default spacing of rows is that of its nodes
  EXPECT_EQ(areal({"scene.spacing_y=1e-4"}).spacing_y, 1e-4);
  EXPECT_EQ(
      *parse_scene(std::string(areal_text).erase(std::string(areal_text).find("spacing_y"), 17),
                   "a.toml", {"scene.spacing=2e-4"})
           .spacing_y,
      2e-4);
}

TEST(ArealScene, ReadsBackToTheSameBits) {
  for (const Changes& changes :
       {Changes{gaussian_face, gaussian_block}, Changes{"scene.side=0.0031", "scene.gap=1e-6"},
        Changes{"resonator.surface={kind=\"gaussian\",rq=2e-6,rsm=1e-3,rsm_y=\"inf\",seed=5}"},
        Changes{"resonator.poisson=0.1", "slider.load=\"2 weight\"", "scene.initial=static",
                "scene.gap=touching"}}) {
    const Scene one = areal(changes), other = parse_scene(echo(one), "other.toml");
    EXPECT_EQ(echo(one), echo(other));
    const Model a = make_model(one), b = make_model(other);
    EXPECT_EQ(run_key(a), run_key(b));
    EXPECT_EQ(a.resonator_height, b.resonator_height);
    EXPECT_EQ(a.slider_height, b.slider_height);
    EXPECT_EQ(a.delta, b.delta);
  }
}

TEST(ArealScene, EveryKeyThatMovesSomethingMakesAnotherRun) {
  const auto key = [](const Changes& changes) {
    Changes all{gaussian_face, gaussian_block};
    all.insert(all.end(), changes.begin(), changes.end());
    return run_key(make_model(areal(all)));
  };
  const std::string own = key({});
  for (const char* change : {"scene.spacing_y=1e-4", "scene.side=0.01", "resonator.poisson=0.29",
                             "resonator.surface.rsm_y=1.9e-3"})
    EXPECT_NE(key({change}), own) << change;
  for (const char* change : {"scene.kind=areal", "resonator.poisson=0.3", "scene.name=other"})
    EXPECT_EQ(key({change}), own) << change;
}

/// rho h, D and the numbers of half waves of a plate: docs/model.md.
TEST(ArealScene, PoissonStiffensThePlate) {
  for (const double nu : {0.0, 0.3, -0.9, 0.49}) {
    const Model m = make_model(areal({"resonator.poisson=" + std::to_string(nu)}));
    const double stiffness = 210e9 * 1e-9 / (12 * (1 - nu * nu)), mu = 7800 * 0.001;
    const double lowest =
        std::sqrt(stiffness / mu) * M_PI * M_PI * (1 / (0.06 * 0.06) + 1 / (0.04 * 0.04));
    EXPECT_NEAR(m.resonator.modes[0].omega, lowest, 1e-14 * lowest);
  }
}

/// One mode has its largest square in the middle, 4/(a b); a block yields most at its corners, by
/// 1 + 3 + 3 times 1/A.
TEST(ArealScene, LimitsAreThoseOfThePlaceThatYieldsMost) {
  const JoinedModes one = most_compliant(make_model(areal({"resonator.modes=1"})));
  ASSERT_EQ(one.square.size(), 2);
  EXPECT_NEAR(one.square[0], 4 / (0.06 * 0.04), 1e-12 / (0.06 * 0.04));
  EXPECT_NEAR(one.square[1], 7 / (1e-3 * 1.2e-3), 1e-12 / (1e-3 * 1.2e-3));
  // of more modes: no node of a grid of its own yields more, and none of the modes is over its most
  const Model m = make_model(areal({"resonator.modes=12"}));
  const JoinedModes many = most_compliant(m);
  double most = 0, sum = 0;
  for (int i = 0; i <= 300; ++i)
    for (int j = 0; j <= 200; ++j) {
      double here = 0;
      for (const BodyMode& mode : m.resonator.modes)
        here += std::pow(shape_at(mode, 0.06 * i / 300, 0.04 * j / 200), 2);
      most = std::max(most, here);
    }
  for (int k = 0; k < 12; ++k) {
    sum += many.square[static_cast<std::size_t>(k)];
    EXPECT_LE(many.square[static_cast<std::size_t>(k)], 4 / (0.06 * 0.04) * (1 + 1e-14));
  }
  EXPECT_NEAR(sum, most, 0.01 * most);
}

// ---- faces

double mean_of(const std::vector<double>& heights) {
  double sum = 0;
  for (const double h : heights) sum += h;
  return sum / static_cast<double>(heights.size());
}

TEST(ArealFaces, RandomOnesAreTheMapsOfTheSeed) {
  const Model m = make_model(areal({gaussian_face, gaussian_block}));
  const HeightMap plate = random_map({2e-6, 1e-3, 2e-3, true, 5}, 0.06, 1.2e-3, 1e-4, 2e-4);
  const HeightMap block = random_map({1e-6, 8e-4, 8e-4, true, 6}, 1e-3, 1.2e-3, 1e-4, 2e-4);
  EXPECT_EQ(m.slider_height, block.heights);
  for (int row = 0; row < m.rows; ++row)
    for (int n = 0; n < m.row_heights(); ++n)
      ASSERT_EQ(m.resonator_height[static_cast<std::size_t>(row * m.row_heights() + n)],
                plate.at(static_cast<std::size_t>(n), static_cast<std::size_t>(row)));
}

TEST(ArealFaces, OtherSpacingsSeeOtherPointsOfTheSameMap) {
  const auto at = [](const char* spacing, const char* spacing_y) {
    return make_model(areal({gaussian_face, gaussian_block, std::string("scene.spacing=") + spacing,
                             std::string("scene.spacing_y=") + spacing_y, "slider.length=1e-3"}));
  };
  // rows in the middle of three others
  const Model coarse = at("1e-4", "2e-4"), fine = at("5e-5", "6.666666666666667e-5");
  ASSERT_EQ(fine.rows, 3 * coarse.rows);
  for (int row = 0; row < coarse.rows; ++row)
    for (int n = 0; n < coarse.row_nodes(); ++n)
      EXPECT_NEAR(
          coarse.slider_height[static_cast<std::size_t>(row * coarse.row_nodes() + n)],
          fine.slider_height[static_cast<std::size_t>((3 * row + 1) * fine.row_nodes() + 2 * n)],
          1e-15);
}

TEST(ArealFaces, EqualRowsAreTheProfileOfThePlaneScene) {
  const std::string face = "surface={kind=\"gaussian\",rq=2e-6,rsm=1e-3,rsm_y=\"inf\",seed=5}";
  const Model m = make_model(areal({"resonator." + face, "slider." + face}));
  std::string plane = areal_text;
  for (const char* line : {"kind = \"areal\"\n", "spacing_y = 2e-4\n"})
    plane.erase(plane.find(line), std::string(line).size());
  const std::string profile = "surface={kind=\"gaussian\",rq=2e-6,rsm=1e-3,seed=5}";
  const Model beam =
      make_model(parse_scene(plane, "plane.toml",
                             {"resonator." + profile, "slider." + profile, "slider.young=210e9",
                              "slider.damping=0", "slider.modes=0"}));
  for (int row = 0; row < m.rows; ++row) {
    for (int n = 0; n < m.row_nodes(); ++n)
      EXPECT_EQ(m.slider_height[static_cast<std::size_t>(row * m.row_nodes() + n)],
                beam.slider_height[static_cast<std::size_t>(n)]);
    for (int n = 0; n < m.row_heights(); ++n)
      EXPECT_EQ(m.resonator_height[static_cast<std::size_t>(row * m.row_heights() + n)],
                beam.resonator_height[static_cast<std::size_t>(n)]);
  }
}

/// A text matrix: a row of constant y in each line, in metres.
class MeasuredMaps : public testing::Test {
 protected:
  using Height = std::function<double(int i, int j)>;
  void write(const std::string& name, int nx, int ny, const Height& height) const {
    std::ofstream out(folder_.path() / name);
    out.precision(17);
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) out << height(i, j) << (i + 1 < nx ? ' ' : '\n');
  }
  Scene scene(const std::string& slider, const std::string& resonator = {}) const {
    return areal(changes(slider, resonator), folder_.path() / "s.toml");
  }
  std::string refused(const std::string& slider, const std::string& resonator = {}) const {
    return refusal_of(changes(slider, resonator), folder_.path() / "s.toml");
  }
  Changes changes(const std::string& slider, const std::string& resonator) const {
    Changes all;
    for (const auto& [body, words] : {std::pair{"slider", slider}, {"resonator", resonator}})
      if (!words.empty())
        all.push_back(std::string(body) + ".surface={kind=\"file\",spacing=1e-4,spacing_y=2e-4," +
                      words + "}");
    return all;
  }
  const test::Folder folder_;
};

/// No two of a few thousand points are alike.
double odd_height(int i, int j) { return 1e-7 * std::sin(1.7 * i + 0.3 * i * j + 2.9 * j); }

TEST_F(MeasuredMaps, StandAsTheyAreLessTheirMean) {
  write("block.txt", 11, 6, odd_height);
  const Model m = make_model(scene("path=\"block.txt\""));
  double mean = 0;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 11; ++i) mean += odd_height(i, j) / 66;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 11; ++i)
      EXPECT_NEAR(m.slider_height[static_cast<std::size_t>(11 * j + i)], odd_height(i, j) - mean,
                  1e-21);
  EXPECT_NEAR(mean_of(m.slider_height), 0, 1e-21);
}

TEST_F(MeasuredMaps, BeginWhereTheirOffsetsSay) {
  write("plate.txt", 300, 20, odd_height);
  const auto height = [](const Model& m, int n, int row) {
    return m.resonator_height[static_cast<std::size_t>(row * m.row_heights() + n)];
  };
  const Model own = make_model(scene("", "path=\"plate.txt\""));
  const double mean = odd_height(0, 0) - height(own, 0, 0);
  for (const int n : {0, 17, 220})
    for (const int row : {0, 5}) EXPECT_NEAR(height(own, n, row), odd_height(n, row) - mean, 1e-20);
  // from x = 0 and the slider's side on, unless an offset says otherwise
  Changes far = changes("", "path=\"plate.txt\",offset_x=-0.003,offset_y=0.0162");
  far.emplace_back("scene.side=0.017");
  const Model moved = make_model(areal(far, folder_.path() / "s.toml"));
  for (const int n : {0, 17, 220})
    for (const int row : {0, 5})
      EXPECT_NEAR(height(moved, n, row), odd_height(n + 30, row + 4) - mean, 1e-20);
  // where it begins in front of the slider alone, it is level before
  const Model late = make_model(scene("", "path=\"plate.txt\",offset_x=0.0199"));
  EXPECT_NEAR(height(late, 205, 2), odd_height(6, 2) - mean, 1e-20);
  EXPECT_EQ(height(late, 3, 2), height(late, 199, 2));
}

TEST_F(MeasuredMaps, GoOnRepeatedOrMirrored) {
  write("small.txt", 8, 4, odd_height);
  const Model mirrored = make_model(scene("path=\"small.txt\",short=\"mirror\""));
  const auto at = [](const Model& m, int i, int j) {
    return m.slider_height[static_cast<std::size_t>(11 * j + i)];
  };
  EXPECT_EQ(at(mirrored, 8, 1), at(mirrored, 6, 1));
  EXPECT_EQ(at(mirrored, 3, 5), at(mirrored, 3, 1));
  EXPECT_EQ(at(mirrored, 10, 4), at(mirrored, 4, 2));
  const Model repeated = make_model(scene("path=\"small.txt\",short=\"repeat\""));
  EXPECT_EQ(at(repeated, 8, 1), at(repeated, 0, 1));  // a seam of one step
  EXPECT_THAT(repeated.doubts,
              testing::Contains(HasSubstr("8 by 4 points, fewer than are touched: repeated")));
  EXPECT_THAT(
      refused("path=\"small.txt\""),
      AllOf(HasSubstr("8 by 4 points"), HasSubstr("11 by 6"), HasSubstr("short = \"repeat\""),
            HasSubstr("s.toml"), HasSubstr("slider.surface")));
}

TEST_F(MeasuredMaps, LoseTheirForm) {
  write("bent.txt", 11, 6, [](int i, int j) { return odd_height(i, j) + 1e-6 * i + 2e-6 * j; });
  write("level.txt", 11, 6, odd_height);
  const auto heights = [&](const std::string& words) {
    return make_model(scene(words)).slider_height;
  };
  const std::vector<double> a = heights("path=\"bent.txt\",form=\"plane\""),
                            b = heights("path=\"level.txt\",form=\"plane\"");
  for (std::size_t n = 0; n < a.size(); ++n) EXPECT_NEAR(a[n], b[n], 1e-19);
  EXPECT_THAT(make_model(scene("path=\"bent.txt\"")).doubts,
              testing::Contains(HasSubstr("most of the height is tilt: try form = \"plane\"")));
}

TEST_F(MeasuredMaps, AreRefusedWithTheCure) {
  write("block.txt", 11, 6, odd_height);
  write("row.txt", 11, 1, odd_height);
  std::ofstream(folder_.path() / "ragged.txt") << "0 0 0\n0 0 0 0\n0 0 0\n";
  std::ofstream(folder_.path() / "gap.txt") << "0 0 0\n0 nan 0\n0 0 0\n";
  const auto expect = [&](const std::string& words, const std::vector<std::string>& says) {
    const std::string all = refused(words), key = "slider.surface: ";
    ASSERT_THAT(all, HasSubstr(key)) << words;
    const std::string why = all.substr(all.rfind(key));
    EXPECT_THAT(why, Not(HasSubstr("--"))) << words;  // words of the command
    for (const std::string& part : says) EXPECT_THAT(why, HasSubstr(part)) << words;
  };
  EXPECT_EQ(refused("path=\"block.txt\""), "taken");
  write("high.txt", 11, 6, [](int i, int j) { return 1e3 * odd_height(i, j); });
  write("deep.txt", 11, 6, [](int i, int) { return i < 5 ? 0.0 : 3e-3; });
  expect("path=\"row.txt\"", {"one row is a profile"});
  expect("path=\"high.txt\",z_unit=\"m\"", {"slopes have a root mean square of", "z_unit"});
  write("steep.txt", 11, 6, [](int, int j) { return j % 2 == 0 ? 2e-4 : -2e-4; });
  expect("path=\"steep.txt\",z_unit=\"m\"", {"slopes have a root mean square of 2", "spacing_y"});
  expect("path=\"deep.txt\",z_unit=\"m\"", {"the heights span 0.003 m on a body 0.005 m thick"});
  expect("path=\"ragged.txt\"", {"ragged.txt"});
  expect("path=\"gap.txt\"", {"row 2, point 2", "fill linear:WIDTH"});
  expect("path=\"block.txt\",offset_x=1e-4", {"offset_x", "0.0001 m behind the first node"});
  EXPECT_EQ(refused("path=\"block.txt\",offset_x=5e-5"), "taken");
  expect("path=\"block.txt\",offset_x=6e-5", {"offset_x", "1e-05 m behind the first node"});
  expect("path=\"block.txt\",offset_y=2e-4", {"offset_y", "0.0002 m behind the first node"});
  EXPECT_THAT(
      refusal_of({"slider.surface={kind=\"file\",path=\"block.txt\"}"}, folder_.path() / "s.toml"),
      AllOf(HasSubstr("give that along x with spacing"), HasSubstr("spacing_y")));
  EXPECT_THAT(
      refusal_of({"slider.surface={kind=\"file\",path=\"block.txt\",spacing=9e-5,spacing_y=1e-4}"},
                 folder_.path() / "s.toml"),
      AllOf(HasSubstr("11 by 6 points, and up to 12 by 11 are touched"),
            HasSubstr("short = \"repeat\"")));
}

/// Between its points a map is its bicubic spline, and that of a cubic is the cubic.
TEST_F(MeasuredMaps, OfOtherSpacingsAreSplines) {
  const double dx = 2.3e-4, dy = 1.7e-4, left = -1e-4, below = -3.1e-4;  // of the map's points
  const auto cubic = [](double x, double y) {
    x /= 1e-3, y /= 1e-3;
    return 1e-6 * (x * x * x - x * x * y + 0.5 * y * y * y + 2 * x * y * y - y);
  };
  const auto point = [&](int i, int j) { return cubic(left + dx * i, below + dy * (j + 0.5)); };
  const int nx = 7, ny = 12;
  write("cubic.txt", nx, ny, point);
  double mean = 0;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) mean += point(i, j) / (nx * ny);
  const Model m = make_model(
      areal({"slider.surface={kind=\"file\",path=\"cubic.txt\",spacing=2.3e-4,spacing_y=1.7e-4,"
             "offset_x=-1e-4,offset_y=-3.1e-4}"},
            folder_.path() / "s.toml"));
  // splines of so few points: some ten roundings of the largest height, and of places that are
  // known to some roundings of the distance of two points
  for (int j = 0; j < m.rows; ++j)
    for (int i = 0; i < m.row_nodes(); ++i)
      EXPECT_NEAR(m.slider_height[static_cast<std::size_t>(m.row_nodes() * j + i)],
                  cubic(1e-4 * i, 2e-4 * (j + 0.5)) - mean, 200 * test::eps * 5e-6)
          << i << ' ' << j;
}

/// Where a map goes on, the height at a place does not depend on how much of the face is touched.
TEST_F(MeasuredMaps, GoOnBetweenTheirPointsBehindWhatIsTouched) {
  write("map.txt", 40, 9, odd_height);
  for (const char* words : {"short=\"mirror\"", "short=\"repeat\""})
    for (const char* faces : {"scene.faces=linear", "scene.faces=smooth"}) {
      const auto model = [&](double duration, double width) {
        return make_model(areal(
            {fmt::format("resonator.surface={{kind=\"file\",path=\"map.txt\",spacing=1.3e-4,"
                         "spacing_y=1.7e-4,{}}}",
                         words),
             fmt::format("scene.duration={}", duration), fmt::format("slider.width={}", width),
             "scene.side=0.01", "scene.start=0.002", faces},
            folder_.path() / "s.toml"));
      };
      // 1.4 mm: within half a row behind the map's last one
      const Model few = model(1e-3, 1.4e-3), many = model(8e-3, 4e-3);
      for (int row = 0; row < few.rows; ++row)
        for (int n = 0; n < few.row_heights(); ++n) {
          const auto at = [&](const std::vector<double>& heights, const Model& m) {
            return heights[static_cast<std::size_t>(row * m.row_heights() + n)];
          };
          // what lies further away weighs less than a rounding
          ASSERT_NEAR(at(few.resonator_height, few), at(many.resonator_height, many),
                      100 * test::eps * 1e-7)
              << words << ' ' << faces << ' ' << row << ' ' << n;
        }
    }
}

/// 3e-4/1e-4 is less than 3. Pairs of runs differ by 1e-10 in their start.
TEST_F(MeasuredMaps, MayBeginWhereTheSliderStarts) {
  write("plate.txt", 30, 6, odd_height);
  for (const char* start : {"scene.start=3e-4", "scene.start=2.99999999e-4"}) {
    Changes all = changes("", "path=\"plate.txt\",offset_x=3e-4");
    all.emplace_back(start);
    const Model m = make_model(areal(all, folder_.path() / "s.toml"));
    const auto height = [&](int n) { return m.resonator_height[static_cast<std::size_t>(n)]; };
    EXPECT_NEAR(height(5) - height(3), odd_height(2, 0) - odd_height(0, 0), 1e-20) << start;
    EXPECT_EQ(height(2), height(3)) << start;
  }
}

TEST_F(MeasuredMaps, OfOtherSpacingsAreDoubted) {
  const auto doubts = [&](const char* name, double spacing, double length) {
    const int nx = static_cast<int>(1e-3 / spacing) + 2,
              ny = static_cast<int>(1.2e-3 / spacing) + 2;
    write(name, nx, ny, [&](int i, int j) {
      return 1e-6 * std::cos(6.283 * spacing * i / length) * std::cos(6.283 * spacing * j / length);
    });
    const std::string face =
        fmt::format(R"(slider.surface={{kind="file",path="{}",spacing={}}})", name, spacing);
    return make_model(areal({face}, folder_.path() / "s.toml")).doubts;
  };
  using testing::Contains;
  EXPECT_THAT(doubts("smooth.txt", 1.5e-4, 4e-3), Not(Contains(HasSubstr("spline"))));
  EXPECT_THAT(doubts("rough.txt", 1.5e-4, 4e-4),
              Contains(AllOf(HasSubstr("rough.txt"), HasSubstr("this face is little known"))));
  EXPECT_THAT(doubts("fine.txt", 2e-5, 3e-4),
              Contains(AllOf(HasSubstr("fine.txt"), HasSubstr("nodes 0.0001 m apart along x show"),
                             HasSubstr("A scene.spacing nearer to the points"))));
  EXPECT_THAT(doubts("fine.txt", 2e-5, 3e-4),
              Contains(AllOf(HasSubstr("nodes 0.0002 m apart along y show"),
                             HasSubstr("A scene.spacing_y nearer to the points"))));
  EXPECT_THAT(doubts("wide.txt", 5e-3, 1e-1),
              AllOf(Contains(HasSubstr("points along x are 0.005 m apart, 50 nodes")),
                    Contains(HasSubstr("rows are 0.005 m apart, 25 nodes")),
                    Contains(HasSubstr("in metres?"))));
}

/// Slopes of nodes and points are compared where both are: not with steeper points beside the
/// slider, nor with the level rows in front of the map.
TEST_F(MeasuredMaps, AreNotDoubtedForSlopesElsewhere) {
  const double spacing = 9e-5;
  const auto wave = [&](int i, int j) {
    const double steeper = i < 20 && j < 16 ? 1 : 3;
    return 1e-6 * steeper * std::sin(6.283e3 * spacing * i) * std::cos(6.283e3 * spacing * j);
  };
  write("steeper.txt", 60, 40, wave);
  write("late.txt", 60, 40, [&](int i, int j) { return wave(i % 10, j % 10); });
  const auto doubts = [&](const char* body, const char* words) {
    return make_model(areal({fmt::format("{}.surface={{kind=\"file\",spacing={},{}}}", body,
                                         spacing, words),
                             "scene.spacing_y=1e-4"},
                            folder_.path() / "s.toml"))
        .doubts;
  };
  using testing::Contains;
  EXPECT_THAT(doubts("slider", "path=\"steeper.txt\""), Not(Contains(HasSubstr("slope"))));
  EXPECT_THAT(doubts("resonator", "path=\"late.txt\",offset_x=0.0199"),
              Not(Contains(HasSubstr("slope"))));
}

// ---- what is refused

struct ArealRefused {
  std::string name;
  Changes changes;
  std::vector<std::string> says;
};
void PrintTo(const ArealRefused& refused, std::ostream* out) { *out << refused.name; }

class ArealRefuses : public testing::TestWithParam<ArealRefused> {};

TEST_P(ArealRefuses, WithTheCure) {
  const std::string message = refusal_of(GetParam().changes);
  EXPECT_THAT(message, testing::StartsWith("areal.toml: 1 fault\n"));
  for (const std::string& part : GetParam().says) EXPECT_THAT(message, HasSubstr(part));
}

const std::vector<ArealRefused> areal_refused{
    // not built
    {"Hertz", {"contact.stiffness=hertz"}, {"contact.stiffness", "a number in Pa/m"}},
    // places across
    {"ForceWithoutY",
     {"resonator.moving_force=[{force=1,speed=1,start=0}]"},
     {"resonator.moving_force[0].y", "missing: expected a place from 0 to 0.04 m"}},
    {"ForceBesideThePlate",
     {"resonator.moving_force=[{force=1,speed=1,start=0,y=0.041}]"},
     {"resonator.moving_force[0].y", "0.041 m is off the resonator"}},
    {"ForceNowhere",
     {"resonator.moving_force=[{force=1,speed=1,start=0,y=nan}]"},
     {"resonator.moving_force[0].y", "expected a number"}},
    {"ProbeWithoutY", {"output.probes=[[0.01,0.01],0.01]"}, {"output.probes[1]", "a pair, [x, y]"}},
    {"ProbeBesideThePlate",
     {"output.probes=[[0.01,-1e-3]]"},
     {"output.probes[0]: y = -0.001 m is off the resonator", "from 0 to 0.04 m"}},
    {"ProbeBehindThePlate",
     {"output.probes=[[0.07,0.01]]"},
     {"output.probes[0]: 0.07 m is off the resonator"}},
    {"ProbeOfThree",
     {"output.probes=[[0.01,0.01,0.01]]"},
     {"output.probes[0]", "a number, or two in brackets"}},
    {"ProbeOfWords", {"output.probes=[[0.01,\"a\"]]"}, {"output.probes[0]"}},
    {"SliderProbeBesideTheBlock",
     {"output.slider_probes=[[1e-4,1.3e-3]]"},
     {"output.slider_probes[0]: y = 0.0013 m is off the slider"}},
    // bodies
    {"PinnedBlock", {"slider.support=pinned"}, {"slider.support", "\"free\" or \"rigid\""}},
    {"BendingBlock", {"slider.modes=2"}, {"slider.modes", "expected 0"}},
    {"FreePlate",
     {"resonator.support=free", "scene.initial=rest"},
     {"resonator.support", "\"pinned\""}},
    {"PoissonTooLarge", {"resonator.poisson=0.5"}, {"resonator.poisson", "below 0.5"}},
    {"PoissonTooSmall", {"resonator.poisson=-1"}, {"resonator.poisson", "over -1"}},
    {"Strip",
     {"resonator.length=4e3", "resonator.width=2e-3"},
     {"resonator.length: ", "make no plate"}},
    // places
    {"BesideThePlate",
     {"scene.side=0.0389"},
     {"areal.toml", "scene.side", "by 0.0001 m", "from 0 to 0.0388 m"}},
    {"BeforeThePlate", {"scene.side=-1e-3"}, {"scene.side", "by 0.001 m"}},
    {"BehindThePlate", {"scene.start=0.059"}, {"scene.start", "right end"}},
    {"WideBlock", {"slider.width=0.05"}, {"slider.width", "wider than the resonator"}},
    {"OneRow", {"scene.spacing_y=1e-3"}, {"scene.spacing_y", "1 rows", "at least 2"}},
    {"NoRow", {"scene.spacing_y=1"}, {"scene.spacing_y", "at least 2"}},
    {"ManyRows", {"scene.spacing_y=1e-10"}, {"scene.spacing_y", "expected at most 1e+08"}},
    {"Negative", {"scene.spacing_y=-1e-4"}, {"scene.spacing_y", "a number > 0"}},
    // faces
    {"Peaks",
     {"slider.surface={kind=\"peaks\",peaks=[{at=0,height=1e-6,half_width=1e-3}]}"},
     {"slider.surface.kind", "ridges", "\"file\""}},
    {"Correlation",
     {"slider.surface={kind=\"gaussian\",rq=1e-6,rsm=1e-3,seed=1,correlation=\"exponential\"}"},
     {"slider.surface.correlation", "drop the key"}},
    {"Skewness",
     {"slider.surface={kind=\"gaussian\",rq=1e-6,rsm=1e-3,seed=1,skewness=1}"},
     {"slider.surface.skewness"}},
    {"Kurtosis",
     {"slider.surface={kind=\"gaussian\",rq=1e-6,rsm=1e-3,seed=1,kurtosis=4}"},
     {"slider.surface.kurtosis"}},
    {"ExactRsm",
     {"slider.surface={kind=\"gaussian\",rq=1e-6,rsm=1e-3,seed=1,exact=\"rq+rsm\"}"},
     {"slider.surface.exact", "\"rq\" or \"none\""}},
    {"RsmAcross",
     {"slider.surface={kind=\"gaussian\",rq=1e-6,rsm=1e-3,rsm_y=7e-4,seed=1}"},
     {"slider.surface.rsm_y", "scene.spacing_y <= 0.000175 m"}},
    {"RsmOfBoth",
     {"slider.surface={kind=\"gaussian\",rq=1e-6,rsm=7e-4,seed=1}"},
     {"slider.surface.rsm:", "spacing of rows"}},
    {"RowOfAProfile",
     {"slider.surface={kind=\"file\",path=\"a\",row=1}"},
     {"slider.surface.row", "all rows"}},
    {"ColumnOfAProfile",
     {"slider.surface={kind=\"file\",path=\"a\",column=1}"},
     {"slider.surface.column"}},
    {"XUnit",
     {"slider.surface={kind=\"file\",path=\"a\",x_unit=\"mm\"}"},
     {"slider.surface.x_unit"}},
    {"Filter",
     {"slider.surface={kind=\"file\",path=\"a\",filter=\"gaussian\"}"},
     {"slider.surface.filter"}},
    {"CutoffS",
     {"slider.surface={kind=\"file\",path=\"a\",cutoff_s=1e-5}"},
     {"slider.surface.cutoff_s"}},
    {"LineOfAProfile",
     {"slider.surface={kind=\"file\",path=\"a\",form=\"line\"}"},
     {"slider.surface.form", "plane"}},
};
INSTANTIATE_TEST_SUITE_P(Each, ArealRefuses, testing::ValuesIn(areal_refused),
                         [](const auto& info) { return info.param.name; });

TEST(ArealScene, AMistypedKindIsTheOnlyFault) {
  for (const char* kind : {"arial", "Areal", ""})
    EXPECT_THAT(refusal_of({std::string("scene.kind=\"") + kind + '"'}),
                AllOf(testing::StartsWith("areal.toml: 1 fault\n"), HasSubstr("scene.kind"),
                      HasSubstr("\"plane\" or \"areal\"")))
        << kind;
  EXPECT_THAT(refusal_of({"scene.kind=3"}), testing::StartsWith("areal.toml: 1 fault\n"));
}

/// Keys of areal scenes in a plane one.
TEST(ArealScene, PlaneScenesRefuseItsKeys) {
  const auto refused = [](const std::string& change) -> std::string {
    try {
      read_scene(test::scene_file("dang2012"), {change});
    } catch (const RequestError& fault) {
      return fault.what();
    }
    return "taken";
  };
  EXPECT_THAT(refused("output.probes=[[0.1,0.01]]"), HasSubstr("expected x alone, 0.1"));
  EXPECT_THAT(refused("resonator.moving_force=[{force=1,speed=1,start=0,y=0.1}]"),
              HasSubstr("expected scene.kind = \"areal\""));
  for (const std::string key : {"scene.spacing_y=1e-5", "scene.side=0.01",
                                "slider.surface.rsm_y=1e-3", "slider.surface.rsm_y=inf"})
    EXPECT_THAT(refused(key), AllOf(HasSubstr(key.substr(0, key.find('='))),
                                    HasSubstr("expected scene.kind = \"areal\"")));
  const std::string file = "slider.surface={kind=\"file\",path=\"a\",";
  for (const std::string key : {"spacing_y=1e-5", "offset_x=0", "offset_y=0"})
    EXPECT_THAT(refused(file + key + "}"), HasSubstr("expected scene.kind = \"areal\""));
  EXPECT_THAT(refused(file + "short=\"mirror\"}"), HasSubstr("only maps are mirrored"));
  EXPECT_THAT(refused(file + "form=\"plane\"}"),
              HasSubstr("is of maps: expected none, mean, line"));
  EXPECT_EQ(refused("scene.kind=plane"), "taken");
}

// ---- the program

/// All numbers of a dataset.
std::vector<double> numbers_in(const fs::path& path, const char* name) {
  const auto library = h5::take_library();
  const h5::Properties access = h5::file_access();
  const h5::File file{h5::check(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access))};
  const h5::Dataset dataset{h5::check(H5Dopen2(file, name, H5P_DEFAULT))};
  const h5::Space space{h5::check(H5Dget_space(dataset))};
  std::vector<double> data(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  h5::check(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()));
  return data;
}

class ArealProgram : public testing::Test {
 protected:
  ArealProgram() { std::ofstream(folder_.path() / "s.toml") << areal_text; }
  test::Ended run(std::vector<std::string> words) const {
    words.insert(words.begin(), test::program());
    return test::run_program(folder_.path(), words);
  }
  std::vector<std::string> rough(std::vector<std::string> words) const {
    for (const char* change : {gaussian_face, gaussian_block, "scene.initial=static"})
      words.insert(words.end(), {"--set", change});
    return words;
  }
  const test::Folder folder_;
};

TEST_F(ArealProgram, PlansWhatItWouldModel) {
  const test::Ended text = run(rough({"plan", "s.toml"}));
  ASSERT_EQ(text.status, 0) << text.err;
  EXPECT_THAT(text.out, AllOf(HasSubstr("pinned, 60 x 40 x 1 mm: 20 modes"),
                              HasSubstr("free, 1 x 1.2 x 5 mm: 3 modes, 3 of them rigid"),
                              HasSubstr("66 of the slider in 6 rows of 11, over rows of 221"),
                              HasSubstr("every node at every step"),
                              HasSubstr("100 um apart along, 200 um")));
  // nothing that is of ridges
  EXPECT_THAT(text.out, AllOf(Not(HasSubstr("asperity")), Not(HasSubstr("hertz")),
                              Not(HasSubstr("\nfaces   ")), Not(HasSubstr("inf"))));
  const test::Ended ended = run(rough({"plan", "s.toml", "--json"}));
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json plan = Json::parse(ended.out);
  EXPECT_EQ(plan["kind"], "areal");
  EXPECT_EQ(plan["rows"], 6);
  EXPECT_EQ(plan["spacing_y"], 2e-4);
  EXPECT_EQ(plan["side"], 0.5 * (0.04 - 1.2e-3));
  EXPECT_EQ(plan["slider"]["nodes"], 66);
  EXPECT_TRUE(plan["slider"]["next_frequency"].is_null());
  EXPECT_TRUE(plan["asperities"].is_null());
  EXPECT_TRUE(plan["faces"].is_null());
  const Json& points = plan["point_contacts"];
  EXPECT_NEAR(points["load"].get<double>() * points["contacts"].get<double>(), 1.0, 1e-12);
  EXPECT_GT(points["hertz_stiffness"], 0);
  EXPECT_NEAR(points["width_in_spacings"], points["width"].get<double>() / 2e-4, 1e-9);
  EXPECT_EQ(points["shock_error"], shock_error_of(points["width_in_spacings"], Faces::linear));
  EXPECT_GT(plan["memory_bytes"], 1e8);
  EXPECT_GE(plan["cost"]["touching_at_start"], 3);  // a free block stands on three
}

/// A measured face, too, whatever part of it a run touches: a spline knows the points before and
/// behind that.
TEST_F(MeasuredMaps, AreSmoothBeyondWhatIsTouched) {
  const auto waves = [](int i, int j) {
    return 1e-6 * std::cos(1.1 * i + j) + 1e-7 * std::cos(2.9 * i * (j + 1));
  };
  write("long.txt", 300, 6, waves);
  write("short.txt", 215, 6, waves);
  const auto model = [&](const std::string& words, const char* start, const char* duration) {
    return make_model(
        areal({"resonator.surface={kind=\"file\",spacing=1e-4,spacing_y=2e-4," + words + "}",
               "scene.faces=smooth", std::string("scene.start=") + start,
               std::string("scene.duration=") + duration},
              folder_.path() / "s.toml"));
  };
  const auto expect_same = [](const Model& a, const Model& b, int first) {
    double largest = 0;
    for (const double c : a.resonator_curvature) largest = std::max(largest, std::abs(c));
    ASSERT_GT(largest, 1e-7);
    for (int row = 0; row < a.rows; ++row)
      for (int i = first; i < std::min(a.row_heights(), b.row_heights()); ++i)
        EXPECT_NEAR(a.resonator_curvature[row * a.row_heights() + i],
                    b.resonator_curvature[row * b.row_heights() + i], 1e-14 * largest)
            << row << ' ' << i;
  };
  for (const char* words : {"path=\"long.txt\"", "path=\"short.txt\",short=\"mirror\""}) {
    const Model run = model(words, "0.02", "1e-3");
    ASSERT_EQ(run.row_heights(), 221);
    expect_same(run, model(words, "0.02", "2e-3"), 0);
    expect_same(run, model(words, "0.018", "1e-2"), 0);
  }
  // and where the map begins under the slider, its own spline begins
  const Model begins = model("path=\"long.txt\",offset_x=0.02", "0.02", "1e-3");
  const Model whole = model("path=\"long.txt\"", "0", "2e-2");
  for (int row = 0; row < begins.rows; ++row)
    for (int i = 0; i < begins.row_heights(); ++i) {
      const double c = begins.resonator_curvature[row * begins.row_heights() + i];
      if (i < 200)
        EXPECT_EQ(c, 0);
      else
        EXPECT_NEAR(c, whole.resonator_curvature[row * whole.row_heights() + i - 200], 1e-20);
    }
}

/// A face is the scene's own, whatever part of it a run needs.
TEST(ArealSmoothFaces, AreNotTheRuns) {
  for (const char* rsm_y : {"1e-3", "inf"}) {
    const std::string face =
        fmt::format("resonator.surface={{kind=\"gaussian\",rq=2e-6,rsm=1e-3,rsm_y={},seed=5}}",
                    rsm_y[0] == 'i' ? "\"inf\"" : rsm_y);
    const auto model = [&](const char* faces, const char* start, const char* duration) {
      return make_model(
          areal({face, gaussian_block, std::string("scene.faces=") + faces,
                 std::string("scene.start=") + start, std::string("scene.duration=") + duration}));
    };
    const Model linear = model("linear", "0.02", "1e-3"), smooth = model("smooth", "0.02", "1e-3"),
                longer = model("smooth", "0.02", "2e-3");
    EXPECT_EQ(linear.resonator_height, smooth.resonator_height) << rsm_y;
    double largest = 0;
    for (const double c : smooth.resonator_curvature) largest = std::max(largest, std::abs(c));
    for (int row = 0; row < smooth.rows; ++row)
      for (int i = 0; i < smooth.row_heights(); ++i)
        EXPECT_NEAR(smooth.resonator_curvature[row * smooth.row_heights() + i],
                    longer.resonator_curvature[row * longer.row_heights() + i], 1e-14 * largest);
    // up to the plate's end
    const Model last = model("smooth", "0.058", "1e-3");
    for (const double c : last.resonator_curvature) EXPECT_LT(std::abs(c), 1e-5);
  }
}

TEST_F(ArealProgram, PlansSmoothFacesByTheirRows) {
  std::vector<std::string> words = rough({"plan", "s.toml", "--json"});
  words.insert(words.end(), {"--set", "scene.faces=smooth", "--set", "scene.spacing=2e-5", "--set",
                             "scene.spacing_y=5e-5", "--set", "time.scheme=adaptive"});
  const test::Ended ended = run(words);
  ASSERT_EQ(ended.status, 0) << ended.err;
  const Json plan = Json::parse(ended.out), &points = plan["point_contacts"];
  EXPECT_NEAR(points["width_in_spacings"], points["width"].get<double>() / 5e-5, 1e-9);
  // the face of a row is smooth, whatever the next row's is
  for (const Json& note : plan["notes"])
    EXPECT_THAT(note.get<std::string>(),
                AllOf(Not(HasSubstr("spline")), Not(HasSubstr("tone")), Not(HasSubstr("cubic"))));
  words.insert(words.end(), {"--set", "time.tolerance=1e-13"});
  const test::Ended strict = run(words);
  EXPECT_THAT(strict.err, AllOf(HasSubstr("taken for a cubic"), HasSubstr("time.tolerance")));
}

TEST_F(ArealProgram, RunsAndKeepsMapsAndModes) {
  const test::Ended ran = run(rough({"run", "s.toml", "-o", "a.h5"}));
  ASSERT_EQ(ran.status, 0) << ran.err;
  const test::Ended checked = run({"check", "a.h5"});
  EXPECT_EQ(checked.status, 0) << checked.err;
  const fs::path file = folder_.path() / "a.h5";
  const Model m = make_model(areal({gaussian_face, gaussian_block, "scene.initial=static"}));
  EXPECT_EQ(numbers_in(file, "/surface/slider/height"), m.slider_height);
  EXPECT_EQ(numbers_in(file, "/surface/resonator/height"), m.resonator_height);
  EXPECT_EQ(numbers_in(file, "/surface/slider/position").size(), 11);
  const std::vector<double> y = numbers_in(file, "/surface/slider/y");
  ASSERT_EQ(y.size(), 6);
  EXPECT_DOUBLE_EQ(y[2], 2.5 * 2e-4);
  EXPECT_DOUBLE_EQ(numbers_in(file, "/surface/resonator/y")[0], m.side + 1e-4);
  const std::vector<PinnedPlateMode> modes = plate_modes(m.scene.resonator, 20);
  const std::vector<double> mode_x = numbers_in(file, "/resonator/mode_x"),
                            mode_y = numbers_in(file, "/resonator/mode_y"),
                            frequency = numbers_in(file, "/resonator/frequency");
  ASSERT_EQ(mode_x.size(), 20);
  for (std::size_t k = 0; k < 20; ++k) {
    EXPECT_EQ(mode_x[k], modes[k].m);
    EXPECT_EQ(mode_y[k], modes[k].n);
    EXPECT_EQ(frequency[k], modes[k].omega / (2 * M_PI));
    EXPECT_GE(frequency[k], frequency[k > 0 ? k - 1 : 0] * (1 - 1e-15));
  }
  for (const double square : numbers_in(file, "/resonator/mean_square"))
    EXPECT_NEAR(square, 1 / (0.06 * 0.04), 1e-12 / (0.06 * 0.04));
}

/// v_rms^2 is the mean over the plate's area: sum <V_k^2>/(a b).
TEST_F(ArealProgram, TheLevelIsThatOfThePlatesArea) {
  const test::Ended ran = run(rough({"run", "s.toml", "-o", "a.h5", "--json", "--set",
                                     "output.rate=1e6", "--set", "time.scheme=rk4"}));
  ASSERT_EQ(ran.status, 0) << ran.err;
  const std::vector<double> v = numbers_in(folder_.path() / "a.h5", "/resonator/velocity");
  double sum = 0;  // a sample a step, the first one at t = 0
  for (std::size_t i = 20; i < v.size(); ++i) sum += v[i] * v[i];
  const double expected = std::sqrt(sum / 1000 / (0.06 * 0.04));
  EXPECT_GT(expected, 0);
  EXPECT_NEAR(double(Json::parse(ran.out)["v_rms"]), expected, 1e-12 * expected);
}

/// Sums over psi_mn = 2/sqrt(a b) sin(m pi x/a) sin(n pi y/b).
TEST_F(ArealProgram, ProbesAreSumsOfTheModes) {
  const test::Ended ran = run(rough({"run", "s.toml", "-o", "a.h5", "--set",
                                     "output.probes=[[0.013, 0.007], [0.03, 0.02], [0.02, 0]]",
                                     "--set", "output.slider_probes=[[0, 1.2e-3]]"}));
  ASSERT_EQ(ran.status, 0) << ran.err;
  const fs::path file = folder_.path() / "a.h5";
  EXPECT_THAT(numbers_in(file, "/probes/position"), ElementsAre(0.013, 0.03, 0.02));
  EXPECT_THAT(numbers_in(file, "/probes/y"), ElementsAre(0.007, 0.02, 0));
  const std::vector<PinnedPlateMode> modes = plate_modes(areal().resonator, 20);
  for (const char* what : {"displacement", "velocity"}) {
    const std::string name = what;
    const std::vector<double> u = numbers_in(file, ("/resonator/" + name).c_str()),
                              w = numbers_in(file, ("/slider/" + name).c_str()),
                              read = numbers_in(file, ("/probes/" + name).c_str()),
                              ridden = numbers_in(file, ("/slider_probes/" + name).c_str());
    const std::size_t last = u.size() / 20 - 1;
    for (const std::size_t p : {0, 1, 2}) {
      const double x[] = {0.013, 0.03, 0.02}, y[] = {0.007, 0.02, 0};
      double sum = 0, size = 0;
      for (std::size_t k = 0; k < 20; ++k) {
        const double part = u[last * 20 + k] * 2 / std::sqrt(0.06 * 0.04) *
                            std::sin(modes[k].m * M_PI * x[p] / 0.06) *
                            std::sin(modes[k].n * M_PI * y[p] / 0.04);
        sum += part;
        size += std::abs(part);
      }
      EXPECT_NEAR(read[last * 3 + p], sum, 1e-13 * size + 1e-30) << what << " of probe " << p;
    }
    EXPECT_EQ(read[last * 3 + 2], 0) << "on the plate's edge";
    // at the corner: heave, less pitch, and roll
    const double area = 1e-3 * 1.2e-3;
    const double corner =
        (w[last * 3] + std::sqrt(3) * (w[last * 3 + 2] - w[last * 3 + 1])) / std::sqrt(area);
    EXPECT_NEAR(ridden[last], corner, 1e-12 * std::abs(w[last * 3]) / std::sqrt(area));
  }
}

TEST_F(ArealProgram, ShapesStandOnAGrid) {
  ASSERT_EQ(run(rough({"run", "s.toml", "-o", "a.h5"})).status, 0);
  const fs::path file = folder_.path() / "a.h5";
  const std::vector<double> x = numbers_in(file, "/resonator/position"),
                            y = numbers_in(file, "/resonator/y"),
                            of_x = numbers_in(file, "/resonator/shape_x"),
                            of_y = numbers_in(file, "/resonator/shape_y");
  ASSERT_EQ(of_x.size(), 20 * x.size());
  ASSERT_EQ(of_y.size(), 20 * y.size());
  EXPECT_EQ(x.back(), 0.06);
  EXPECT_EQ(y.back(), 0.04);
  const std::vector<PinnedPlateMode> modes = plate_modes(areal().resonator, 20);
  for (std::size_t k = 0; k < 20; ++k)
    for (const std::size_t i : {std::size_t{0}, x.size() / 3, x.size() - 1})
      for (const std::size_t j : {std::size_t{0}, y.size() / 5, y.size() - 1})
        EXPECT_NEAR(of_x[k * x.size() + i] * of_y[k * y.size() + j],
                    2 / std::sqrt(0.06 * 0.04) * std::sin(modes[k].m * M_PI * x[i] / 0.06) *
                        std::sin(modes[k].n * M_PI * y[j] / 0.04),
                    1e-11);
}

/// Radiation efficiency: W over rho c times the area times the mean square of the velocity on it.
TEST_F(ArealProgram, SoundIsThatOfThePlate) {
  ASSERT_EQ(run(rough({"run", "s.toml", "-o", "a.h5", "--set", "output.rate=1e6", "--set",
                       "time.scheme=rk4"}))
                .status,
            0);
  const test::Ended heard = run({"analyze", "a.h5", "--power", "--at", "0.03,0.02,0.05", "--json"});
  ASSERT_EQ(heard.status, 0) << heard.err;
  const Json found = Json::parse(heard.out);
  EXPECT_GT(double(found["microphones"][0]["p_rms"]), 0);
  const std::vector<double> v = numbers_in(folder_.path() / "a.h5", "/resonator/velocity");
  double sum = 0;
  for (const double value : v) sum += value * value;
  const double mean_square = sum / (static_cast<double>(v.size()) / 20) / (0.06 * 0.04);
  const double flow = double(found["air"]["density"]) * double(found["air"]["sound_speed"]);
  const double expected = double(found["power"]["watts"]) / (flow * 0.06 * 0.04 * mean_square);
  EXPECT_NEAR(double(found["power"]["efficiency"]), expected, 0.01 * expected);
}

TEST_F(ArealProgram, PlansFindWhatItCanDoWithout) {
  const test::Ended planned =
      run(rough({"plan", "s.toml", "--accuracy", "0.5", "--budget", "2", "--json"}));
  ASSERT_EQ(planned.status, 0) << planned.err;
  bool finer = false;
  const Json found = Json::parse(planned.out);
  for (const Json& trial : found["trials"]) {
    EXPECT_NE(trial["key"], "slider.modes") << "a block does not bend";
    finer = finer || (trial["key"] == "scene.spacing" && trial["value"] == "50 um");
  }
  EXPECT_TRUE(finer);
  const Scene scene = read_scene(folder_.path() / "s-planned.toml");
  EXPECT_EQ(scene.kind, SceneKind::areal);
  EXPECT_EQ(scene.spacing_y.value(), 2 * scene.spacing);
}

/// Flat faces of 364 x 364 nodes, pressed together.
TEST(ArealScene, StartsWhereMoreNodesTouchThanCanBeFollowedAreRefused) {
  const Changes flat{"scene.spacing=1e-5",   "scene.spacing_y=1e-5",      "slider.length=3.63e-3",
                     "slider.width=3.64e-3", "time.nodes=\"candidates\"", "resonator.modes=3"};
  const auto start_of = [&](Changes changes) {
    changes.insert(changes.begin(), flat.begin(), flat.end());
    try {
      return fmt::format("{} nodes", make_start(make_model(areal(changes))).loaded_nodes.size());
    } catch (const RequestError& fault) {
      return std::string(fault.what());
    }
  };
  const auto refused = HasSubstr(
      "scene.spacing: at the start 132496 nodes touch at once, and 65536 can be followed");
  EXPECT_THAT(start_of({"scene.gap=1e-9"}), "0 nodes");
  EXPECT_THAT(start_of({"scene.gap=-1e-9"}), refused);
  EXPECT_THAT(start_of({"scene.initial=\"static\"", "slider.load=100", "contact.stiffness=1e10"}),
              refused);
}

TEST(ArealScene, AnotherSpacingKeepsTheRatioOfBoth) {
  Scene s = areal();
  set_spacing(s, 5e-5);
  EXPECT_EQ(s.spacing, 5e-5);
  EXPECT_EQ(s.spacing_y, 1e-4);
  Scene plane = parse_scene(test::read_file(test::scene_file("peaks")), "peaks.toml");
  set_spacing(plane, 1e-6);
  EXPECT_EQ(plane.spacing, 1e-6);
  EXPECT_FALSE(plane.spacing_y);
}

/// Flat faces of 320 x 321 nodes fall on one another.
TEST_F(ArealProgram, ARunEndsWhereMoreNodesTouchThanCanBeFollowed) {
  std::vector<std::string> words{"run", "s.toml", "-o", "crowded.h5"};
  for (const char* change : {"scene.spacing=1e-5", "scene.spacing_y=1e-5", "slider.length=3.19e-3",
                             "slider.width=3.21e-3", "time.nodes=candidates", "resonator.modes=3",
                             "scene.gap=1e-6", "scene.speed=0"})
    words.insert(words.end(), {"--set", change});
  const test::Ended ended = run(words);
  EXPECT_EQ(ended.status, 3);
  EXPECT_THAT(ended.err,
              AllOf(HasSubstr("more nodes touch at once"), HasSubstr("or than the 65536"),
                    HasSubstr("Coarser nodes (scene.spacing, scene.spacing_y)"),
                    HasSubstr("What was computed until then is in crowded.h5")));
  EXPECT_THAT(run({"check", "crowded.h5"}).out, HasSubstr("cut short"));
}

TEST_F(ArealProgram, ChartsOfStabilityMeetTheTheory) {
  const test::Ended chart = run(rough({"chart", "stability", "s.toml", "--no-plot", "-o", "c"}));
  ASSERT_EQ(chart.status, 0) << chart.err;
  EXPECT_THAT(chart.out, HasSubstr("midpoint                      1.999 | 1.999"));
}

TEST_F(ArealProgram, IsRefusedWhereLimitedMemoryIsTooLittle) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "sanitizers reserve addresses without end";
#endif
  // 6.25 million nodes: the run itself takes some 940 MB of addresses
  const std::string line =
      fmt::format("ulimit -v 900000; exec '{}' run '{}' -o m.h5 --set {}", test::program(),
                  test::scene_file("areal"), "scene.spacing=8e-6 --set scene.duration=1e-3");
  const test::Ended ended = test::run_program(folder_.path(), {"/bin/bash", "-c", line});
  EXPECT_EQ(ended.status, 2) << ended.out;
  EXPECT_THAT(ended.err, HasSubstr("GB are free"));
  EXPECT_FALSE(fs::exists(folder_.path() / "m.h5"));
}

TEST_F(ArealProgram, AnalyzesItsResults) {
  ASSERT_EQ(run(rough({"run", "s.toml", "-o", "a.h5"})).status, 0);
  EXPECT_EQ(run({"analyze", "a.h5"}).status, 0);
}

TEST_F(ArealProgram, LibrariesOpenItsResultAndItIsDrawn) {
  RA2D_SKIP_WITHOUT_PYTHON();
  ASSERT_EQ(run(rough({"run", "s.toml", "-o", "a.h5"})).status, 0);
  const fs::path script = test::source_folder() / "tests/host/check_result.py";
  const test::Ended opened =
      test::run_program(folder_.path(), {test::python(), script.string(), "a.h5"});
  EXPECT_EQ(opened.status, 0) << opened.out << opened.err;
  const test::Ended plot = run({"plot", "a.h5", "-o", "a.png"});
  EXPECT_EQ(plot.status, 0) << plot.err;
  const test::Ended report = run({"report", "a.h5", "-o", "a.html"});
  EXPECT_EQ(report.status, 0) << report.err;
}

TEST_F(ArealProgram, StudiesHaveTheNumbersOfRuns) {
  std::ofstream(folder_.path() / "study.toml")
      << "base = \"s.toml\"\n[set]\n\"scene.initial\" = \"static\"\n"
         "[vary]\nwidth = { key = \"resonator.width\", values = [0.04, 0.05] }\n";
  std::ofstream(folder_.path() / "s.toml") << echo(areal({gaussian_face, gaussian_block}));
  const test::Ended studied = run({"study", "study.toml", "-o", "out"});
  ASSERT_EQ(studied.status, 0) << studied.err;
  std::vector<double> alone;
  for (const char* width : {"0.04", "0.05"}) {
    const test::Ended ran =
        run({"run", "s.toml", "--json", "-o", std::string(width) + ".h5", "--set",
             "scene.initial=static", "--set", std::string("resonator.width=") + width});
    ASSERT_EQ(ran.status, 0) << ran.err;
    alone.push_back(Json::parse(ran.out)["v_rms"]);
  }
  EXPECT_THAT(read_study_table(folder_.path() / "out/results.h5").v_rms,
              testing::ElementsAreArray(alone));
}

}  // namespace
}  // namespace ra2d
