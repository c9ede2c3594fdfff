// SPDX-License-Identifier: BSD-3-Clause
// What 'ra2d plan' says of areal scenes: contacts by Hertz, and memory.
#include "host/model/point_contacts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/errors.hpp"
#include "host/model/areal_size.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/scenes.hpp"

namespace ra2d {
namespace {

constexpr double steel = 1.15e11, ball = 2e-3, weight = 0.2;  // Pa, m, N

/// Force [N] of springs under a sphere that is pressed in by `depth`, ring by ring.
double spring_force(double kappa, double radius, double depth) {
  constexpr int rings = 100000;
  const double edge = std::sqrt(2 * radius * depth), width = edge / rings;
  double sum = 0;
  for (int i = 0; i < rings; ++i) {
    const double r = (i + 0.5) * width;
    sum += kappa * (depth - r * r / (2 * radius)) * 2 * std::numbers::pi * r * width;
  }
  return sum;
}

TEST(PointContact, IsThatOfASphereOnAPlane) {
  const PointContact contact = point_contact(steel, ball, weight);
  const auto force = [](double depth) {
    return 4.0 / 3 * steel * std::sqrt(ball) * std::pow(depth, 1.5);
  };
  const double depth = contact.half_width * contact.half_width / ball, step = 1e-4 * depth;
  EXPECT_NEAR(force(depth), weight, 1e-12 * weight);
  EXPECT_NEAR((force(depth + step) - force(depth - step)) / (2 * step), contact.stiffness,
              1e-7 * contact.stiffness);
}

TEST(PointContact, SpringsAreAsStiffUnderTheSameForce) {
  const PointContact contact = point_contact(steel, ball, weight);
  const double width = width_on_springs(contact.kappa, ball, weight);
  const double depth = width * width / (8 * ball), step = 1e-3 * depth;  // of a sphere's cap
  const auto force = [&](double d) { return spring_force(contact.kappa, ball, d); };
  EXPECT_NEAR(force(depth), weight, 1e-6 * weight);
  EXPECT_NEAR((force(depth + step) - force(depth - step)) / (2 * step), contact.stiffness,
              1e-6 * contact.stiffness);
}

TEST(PointContact, SummitsHaveTheRadiusOfTheirParaboloid) {
  // turned against the rows, on nodes that are not as far apart along as across
  const double k1 = 1 / 1e-3, k2 = 1 / 4e-3, turn = 0.6, dx = 8e-6, dy = 13e-6;
  for (const int half : {1, 2, 7}) {
    std::vector<double> up, saddle;
    for (int j = -half; j <= half; ++j)
      for (int i = -half; i <= half; ++i) {
        const double x = i * dx, y = j * dy;
        const double a = std::cos(turn) * x + std::sin(turn) * y,
                     b = std::cos(turn) * y - std::sin(turn) * x;
        up.push_back(3e-6 - (k1 * a * a + k2 * b * b) / 2);
        saddle.push_back((k2 * b * b - k1 * a * a) / 2);
      }
    EXPECT_NEAR(summit_radius(up, dx, dy), 2e-3, 1e-11) << half;
    EXPECT_EQ(summit_radius(saddle, dx, dy), 0) << half;
    for (double& z : up) z = -z;
    EXPECT_EQ(summit_radius(up, dx, dy), 0) << half;
  }
}

/// A block on three equal paraboloids of radius `ball`.
Model three_balls() {
  const char* const text = R"([scene]
kind = "areal"
duration = 1e-3
speed = 0.1
start = 0.02
spacing = 5e-5
gap = "touching"
[resonator]
support = "pinned"
length = 0.06
width = 0.04
thickness = 2e-3
young = 210e9
density = 7800
damping = 0.02
modes = 20
surface = { kind = "flat" }
[slider]
support = "free"
length = 4e-3
width = 4e-3
thickness = 4e-3
density = 7800
load = 0.6
surface = { kind = "flat" }
[contact]
stiffness = 1e15
[time]
scheme = "adaptive"
[output]
rate = 1e5
)";
  const Scene scene = parse_scene(text, "balls.toml");
  constexpr int rows = 80, along = 81, below = 400 + 2 + along;
  HeightMaps maps{rows, 5e-5, *scene.side, std::vector<double>(rows * below, 0.0), {}};
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < along; ++i) {
      double height = -2e-5;
      for (const auto& [row, node] : {std::pair{20, 20}, {20, 60}, {60, 40}}) {
        const double x = (i - node) * 5e-5, y = (j - row) * 5e-5;
        height = std::max(height, -(x * x + y * y) / (2 * ball));
      }
      maps.slider.push_back(height);
    }
  return make_model(scene, maps);
}

TEST(PointContacts, AreThoseOfTheSummitsAndTheLoad) {
  const Model model = three_balls();
  const PointContacts found = point_contacts_of(model, make_start(model));
  EXPECT_EQ(found.contacts, 3);
  EXPECT_NEAR(found.load, 0.2, 1e-12);
  EXPECT_NEAR(found.radius, ball, 1e-9 * ball);
  // both sides of the plate's material
  EXPECT_NEAR(found.modulus, 210e9 / (1 - 0.09) / 2, 1);
  EXPECT_NEAR(found.hertz.kappa, point_contact(found.modulus, ball, 0.2).kappa,
              1e-6 * found.hertz.kappa);
  EXPECT_NEAR(found.width, width_on_springs(1e15, ball, 0.2), 1e-6 * found.width);
}

TEST(PointContacts, AMeshTooCoarseForThemIsDoubted) {
  // contacts are some 28 um wide: 0.57 and 1.4 spacings, 0.35 and 0.55 rows
  const auto doubts = [](Faces faces, double spacing) {
    Scene scene = read_scene(test::scene_file("areal"));
    scene.faces = faces;
    scene.spacing = spacing;
    scene.spacing_y = spacing;
    return make_model(scene).doubts;
  };
  const auto says = [](const char* width) {
    return testing::Contains(testing::AllOf(testing::HasSubstr("may be off by more than half"),
                                            testing::HasSubstr(width)));
  };
  EXPECT_THAT(doubts(Faces::linear, 5e-5), says("um wide, 0.57 spacings"));
  EXPECT_THAT(doubts(Faces::smooth, 8e-5), says("um wide, 0.35 rows"));
  EXPECT_THAT(doubts(Faces::linear, 2e-5), testing::Not(says("wide")));
  EXPECT_THAT(doubts(Faces::smooth, 5e-5), testing::Not(says("wide")));
}

TEST(PointContacts, PiecesAreNodesBesideOneAnother) {
  const Model model = three_balls();
  const int row = model.row_nodes();
  EXPECT_EQ(pieces_of(model, {}), 0);
  EXPECT_EQ(pieces_of(model, {5, 6, 6 + row}), 1);
  EXPECT_EQ(pieces_of(model, {5, 6 + row, 5 + 2 * row, 7 + 2 * row}), 1);  // by corners
  EXPECT_EQ(pieces_of(model, {row - 1, row}), 2);  // the last of a row, the first of the next
  EXPECT_EQ(pieces_of(model, {5, 5 + 2 * row, 9}), 3);
}

/// Rates and durations beside those of smooth faces in rows 8 um apart, 4 to 8 pairs of maps, in
/// per cent: the 20 mm block of scenes/areal.toml (docs/accuracy.md) and one of 10 mm (0.5 s).
TEST(PointContacts, ErrorsOfShocksAreAboutThoseOfRuns) {
  struct Runs {
    Faces faces;
    double nodes, rate, duration;
  };
  for (const Runs& r :
       {Runs{Faces::linear, 27.3 / 32, 52, 42}, Runs{Faces::linear, 27.3 / 16, 14, 14},
        Runs{Faces::smooth, 27.3 / 32, 12, 14}, Runs{Faces::smooth, 27.3 / 16, 3.7, 4},
        Runs{Faces::linear, 20.05 / 32, 77, 52}, Runs{Faces::linear, 20.05 / 16, 28, 18}}) {
    const double estimated = 100 * shock_error_of(r.nodes, r.faces);
    EXPECT_NEAR(std::log(estimated / std::max(r.rate, r.duration)), 0, std::log(1.4)) << r.rate;
    EXPECT_NEAR(nodes_for(0.01 * estimated, r.faces), r.nodes, 1e-9);
  }
}

TEST(ArealMemory, IsThatOfTheMapsAndRefusedWithASpacingThatDoes) {
  Scene scene = read_scene(test::scene_file("areal"));
  scene.spacing = 8e-6;
  scene.spacing_y = 8e-6;
  const double needed = areal_memory(scene);
  // maps of 2501 and 21251 nodes in 2500 rows; tables of the first, and of 15001 and more
  EXPECT_GT(needed, 8 * 2500.0 * (2 * 2501 + 21251 + 15001));
  EXPECT_LT(needed, 1.5e9);
  EXPECT_NO_THROW(require_areal_memory(scene, needed));
  try {
    require_areal_memory(scene, 0.4e9);
    FAIL() << "not refused";
  } catch (const RequestError& fault) {
    const std::string message = fault.what();
    EXPECT_THAT(message, testing::AllOf(testing::HasSubstr("scene.spacing"),
                                        testing::HasSubstr("0.4 GB"), testing::HasSubstr("1.")));
    const std::string key = "scene.spacing = ";
    scene.spacing = std::stod(message.substr(message.find(key) + key.size()));
    scene.spacing_y = scene.spacing;
    EXPECT_LT(scene.spacing, 20e-6);
    EXPECT_NO_THROW(require_areal_memory(scene, 0.4e9)) << message;
  }
}

}  // namespace
}  // namespace ra2d
