// SPDX-License-Identifier: BSD-3-Clause
// Hertz's contacts and the beds of springs that match them (docs/schemes.md, "What kappa?"), from
// the elastic half-space up, by quadrature. Unit sizes: a = 1, E* = 1, largest pressure 1.
#include "host/scene/hertz.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "host/plan/asperities.hpp"
#include "host/plan/plan.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"

namespace ra2d::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Displacement of a half-space at a distance r < 1 from the middle of the pressure sqrt(1 - r^2):
/// the integral of p/(pi E* distance), in polar coordinates about the point. Along each ray the
/// pressure is half an ellipse.
double half_space_displacement(double r) {
  constexpr int turns = 400;
  double sum = 0;
  for (int i = 0; i < turns; ++i) {  // periodic: the trapezoidal rule converges as a power
    const double along = r * std::cos(pi * i / turns);
    const double half = std::sqrt(1 - r * r + along * along);  // of the chord through the point
    sum += pi * half * half / 2;                               // integral of sqrt(half^2 - s^2)
  }
  return sum / turns;
}

/// How far the middle of a strip under the pressure sqrt(1 - x^2) lies deeper than x: 2/(pi E*)
/// times the integral of p(s) ln|(x - s)/s|.
double line_depth(double x) {
  constexpr int points = 200'000;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const double angle = pi * (i + 0.5) / points, s = std::cos(angle), p = std::sin(angle);
    sum += p * p * std::log(std::abs((x - s) / s));
  }
  return 2 / pi * sum * pi / points;
}

/// Load of a bed of unit stiffness below a parabola of radius R that touches over the
/// half-width a: depth (a^2 - x^2)/(2 R), of a unit width or of a round contact.
double carried(double a, double radius, bool is_round) {
  constexpr int points = 100'000;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const double x = a * (i + 0.5) / points;
    sum += (a * a - x * x) / (2 * radius) * (is_round ? 2 * pi * x : 2.0);
  }
  return sum * a / points;
}

TEST(Hertz, APointContactFollowsFromTheHalfSpace) {
  const double depth = half_space_displacement(0), force = 2 * pi / 3;  // of the pressure
  const double radius = 1 / depth;                                      // a^2 = R d
  for (const double r : {0.1, 0.5, 0.9})
    EXPECT_NEAR(depth - half_space_displacement(r), r * r / (2 * radius), 1e-12);
  EXPECT_NEAR(force, 4.0 / 3 * std::sqrt(radius) * std::pow(depth, 1.5), 1e-12);
}

TEST(Hertz, ALineContactFollowsFromTheHalfSpace) {
  const double force = pi / 2, radius = pi / (4 * force);  // a^2 = 4 F R/(pi E*)
  for (const double x : {0.25, 0.5, 0.75})
    EXPECT_NEAR(line_depth(x), x * x / (2 * radius), 1e-4);  // the rule's error at the logarithm
}

/// The bed of the half-width that Hertz's contact has under the same load, kappa a/E*.
TEST(Hertz, BedsOfTheSameWidthAreThoseOfJohnson) {
  for (const double a : {0.1, 1.0, 3.0})
    for (const double radius : {10.0, 500.0}) {
      const double line = pi * a * a / (4 * radius), point = 4 * a * a * a / (3 * radius);
      EXPECT_NEAR(line / carried(a, radius, false) * a, 1.18, 0.005);
      EXPECT_NEAR(point / carried(a, radius, true) * a, 1.70, 0.005);
      EXPECT_NEAR(line / carried(a, radius, false) * a, 3 * pi / 8, 1e-8);
      EXPECT_NEAR(point / carried(a, radius, true) * a, 16 / (3 * pi), 1e-8);
    }
}

Scene paper_with(const std::vector<std::string>& changes) {
  return read_scene(scene_file("dang2012"), changes);
}

TEST(Hertz, TheWordIsANumberOfTheMaterials) {
  const double steel = 210e9 / (1 - 0.09) / 2;
  EXPECT_DOUBLE_EQ(contact_modulus(paper_with({})), steel);
  EXPECT_DOUBLE_EQ(paper_with({"contact.stiffness=hertz"}).contact.stiffness,
                   steel / (std::sqrt(2.0) * 0.02));
  // the narrower body is the strip; the softer one yields
  const Scene other =
      paper_with({"contact.stiffness=hertz", "slider.width=0.01", "slider.young=70e9",
                  "slider.poisson=0.35", "resonator.poisson=0"});
  EXPECT_DOUBLE_EQ(other.contact.stiffness,
                   1 / (1 / 210e9 + (1 - 0.35 * 0.35) / 70e9) / (std::sqrt(2.0) * 0.01));
  // a rigid body without a modulus does not yield, one with a modulus does
  const auto rigid = [](const std::string& young) {
    return paper_with({"contact.stiffness=hertz", "slider.support=rigid", "slider.young=" + young,
                       "slider.load=0"})
        .contact.stiffness;
  };
  EXPECT_DOUBLE_EQ(rigid("1e30"), 2 * steel / (std::sqrt(2.0) * 0.02));
  EXPECT_DOUBLE_EQ(rigid("210e9"), steel / (std::sqrt(2.0) * 0.02));
}

/// The program's own springs below a ridge carry what Hertz gives a round asperity of the same
/// radius, under any load. The ridge is a raised cosine: against the parabola (pi a/b)^2/12 of a
/// depth at the edge of the contact, and nodes see a sum for an integral: (chi/a)^2 together at the
/// most.
TEST(Hertz, ARidgeOnItsBedIsARoundAsperity) {
  Scene s = plate_scene(1, 0.0045, 1e-3);
  s.spacing = 1e-6;
  constexpr double height = 1e-5, half_width = 2e-3;
  s.slider.surface = peaks({{.at = 0.00225, .height = height, .half_width = half_width}});
  const double radius = 2 * half_width * half_width / (pi * pi * height);
  s.contact.is_hertz = true;
  s.contact.stiffness = hertz_stiffness(s);
  for (const double depth : {2e-9, 8e-9, 3e-8}) {
    s.gap = height - depth;
    const Model model = make_model(s);
    double force = 0;
    for (const double overlap : overlaps(model, {}, {}))
      force += model.node_stiffness * std::max(0.0, overlap);
    const double a = std::sqrt(2 * radius * depth);
    EXPECT_NEAR(force / (4.0 / 3 * contact_modulus(s) * std::sqrt(radius) * std::pow(depth, 1.5)),
                1, std::pow(pi * a / half_width, 2) / 12 + std::pow(s.spacing / a, 2))
        << depth;
  }
}

Asperities asperities(const Scene& scene) {
  const Model model = make_model(scene);
  return asperities_of(model, make_start(model));
}

TEST(Asperities, OfThePapersSceneAreSoft) {
  const Asperities a = asperities(paper_with({}));
  // two contacts carry the weight; shocks are harder, and stiffer
  EXPECT_EQ(a.contacts, 2);
  EXPECT_NEAR(a.load, 0.02 * 0.02 * 0.02 * 7800 * 9.80665 / 2, 1e-12);
  EXPECT_GT(a.material.stiffness, 3.5e6);
  EXPECT_LT(a.material.shock, 10e6);
  EXPECT_GT(a.material.shock, a.material.stiffness);
  EXPECT_NEAR(a.material.duration, 0.2e-3, 0.05e-3);
  EXPECT_NEAR(a.springs.stiffness, 1.6e8, 0.05e8);  // a node: 1e15 x 8 um x 20 mm
  EXPECT_LT(a.springs.duration, 0.2 * a.material.duration);
  // highest summits of two Gaussian faces: their mean curvature is sqrt(pi/2 m4) and more, m4 = 12
  // rq^2/l^4 of each
  const double l = 1.55e-3 / (std::sqrt(2.0) * pi);
  const double mean = std::sqrt(pi / 2 * 2 * 12) * 8e-6 / (l * l);
  EXPECT_GT(1 / a.radius, mean);
  EXPECT_LT(1 / a.radius, 1.5 * mean);
}

/// A node's spring, or a contact that is narrower than a cell.
TEST(Asperities, SpacingStiffensContactsOfLinearFacesAlone) {
  const auto shock = [](const std::string& faces, double spacing) {
    const Scene s = paper_with({"scene.faces=" + faces, fmt::format("scene.spacing={}", spacing)});
    return asperities(s).springs.shock / make_model(s).node_stiffness;
  };
  EXPECT_EQ(shock("linear", 32e-6), 1);
  EXPECT_EQ(shock("linear", 64e-6), 1);
  EXPECT_LT(shock("smooth", 32e-6), 1);
  EXPECT_NEAR(shock("smooth", 64e-6) / shock("smooth", 32e-6), 0.5, 0.01);  // over twice the cell
}

TEST(Asperities, TheWordGivesTheSceneWhatTheMaterialHas) {
  const Asperities a = asperities(paper_with({"contact.stiffness=hertz"}));
  EXPECT_NEAR(a.springs.stiffness, a.material.stiffness, 1e-12 * a.material.stiffness);
  EXPECT_NEAR(a.springs.duration, a.material.duration, 1e-12 * a.material.duration);
}

/// dF/dd, and the duration of an impact, against the motion itself.
TEST(Asperities, AShockIsHertzsImpact) {
  const Asperities a = asperities(paper_with({"contact.stiffness=hertz"}));
  const double law = 4.0 / 3 * a.modulus * std::sqrt(a.radius);
  const double step = a.material.duration / 1e5;
  double x = 0, v = a.closing, t = 0, most = 0;
  while (x >= 0) {  // leapfrog: an error of 1e-10
    v -= step * law * std::pow(std::max(x, 0.0), 1.5) / a.inertia;
    x += step * v;
    t += step;
    most = std::max(most, x);
  }
  EXPECT_NEAR(t, a.material.duration, 1e-4 * t);
  EXPECT_NEAR(law * std::pow(most, 1.5), a.material.peak, 1e-4 * a.material.peak);
  EXPECT_NEAR(1.5 * law * std::sqrt(most), a.material.shock, 1e-4 * a.material.shock);
}

TEST(Asperities, TheRadiusIsThatOfTheSummitsThatMeet) {
  Scene s = plate_scene(1, 0.0045, 1e-3);
  s.spacing = 1e-6;
  s.speed = 0.1;
  s.duration = 1e-4;
  s.slider.surface = peaks({{.at = 0.00225, .height = 1e-5, .half_width = 1e-3}});
  const double curvature = pi * pi * 1e-5 / (2 * 1e-6);
  EXPECT_NEAR(1 / asperities(s).radius, curvature, 2e-3 * curvature);
  // a summit below another: the curvatures add
  s.speed = 0;
  s.resonator.surface = peaks({{.at = s.start + 0.00225, .height = 1e-5, .half_width = 1e-3}});
  EXPECT_NEAR(1 / asperities(s).radius, 2 * curvature, 4e-3 * curvature);
  // flat faces have none
  s.resonator.surface = s.slider.surface = {};
  EXPECT_EQ(asperities(s).radius, 0);
}

/// Noise between two nodes is far more curved than any summit. It must not count.
TEST(Asperities, NoiseBetweenNodesIsNoSummit) {
  const Folder folder;
  const auto radius = [&](double noise) {
    std::ofstream out(folder.path() / "profile.csv");
    for (int i = 0; i <= 20'000; ++i) {
      const double x = i * 1e-6;
      out << fmt::format("{:.9g},{:.12g}\n", x,
                         1e-5 * std::sin(2 * pi * x / 1.5e-3) + noise * std::cos(2.4 * i));
    }
    out.close();
    Scene s = read_scene(scene_file("dang2012"),
                         {"scene.spacing=1e-6", "resonator.surface={kind=\"flat\"}",
                          fmt::format("slider.surface={{kind=\"file\",path=\"{}\"}}",
                                      (folder.path() / "profile.csv").string())});
    return asperities(s).radius;
  };
  const double smooth = radius(0);
  EXPECT_NEAR(smooth, 1 / (1e-5 * std::pow(2 * pi / 1.5e-3, 2)), 0.02 * smooth);
  EXPECT_NEAR(radius(5e-9), smooth, 0.2 * smooth);
}

std::string refusal_of(const std::vector<std::string>& changes) {
  try {
    paper_with(changes);
  } catch (const RequestError& fault) {
    return fault.what();
  }
  return "accepted";
}

TEST(Hertz, IsRefusedWhereThereIsNoAsperityOrNoMaterial) {
  const std::string word = "contact.stiffness=hertz";
  EXPECT_THAT(
      refusal_of({word, "slider.surface={kind=\"flat\"}", "resonator.surface={kind=\"flat\"}"}),
      HasSubstr("contact.stiffness: \"hertz\" between two flat faces"));
  EXPECT_EQ(refusal_of({word, "slider.surface={kind=\"flat\"}"}), "accepted");
  EXPECT_THAT(refusal_of({"contact.stiffness=herz"}),
              HasSubstr("expected a number > 0 (Pa/m) or \"hertz\""));
  EXPECT_THAT(
      refusal_of({word, "slider.poisson=0.6"}),
      HasSubstr("slider.poisson: 0.6 is not allowed: expected a number over -1, at most 0.5"));
  EXPECT_EQ(refusal_of({word, "slider.poisson=0.5"}), "accepted");
  EXPECT_EQ(refusal_of({word, "contact.law=multiplier"}), "accepted");  // and not used
}

TEST(Hertz, NeitherBodyYields) {
  const std::string rigid = R"([scene]
duration = 0.1
speed = 0.5
start = 0.1
spacing = 1e-4
[resonator]
support = "rigid"
length = 0.3
width = 0.2
surface = { kind = "gaussian", rq = 8e-6, rsm = 1.5e-3, seed = 2 }
[slider]
support = "rigid"
length = 0.02
width = 0.02
[contact]
stiffness = "hertz"
[time]
step = 1e-6
)";
  try {
    parse_scene(rigid, "s.toml");
    FAIL();
  } catch (const RequestError& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("s.toml:16: contact.stiffness: \"hertz\", and neither body "
                                        "has a Young's modulus"));
  }
}

TEST(Hertz, APlanShowsWhatTheMaterialsGive) {
  const auto plan = [](const std::vector<std::string>& changes) {
    const Model model = make_model(paper_with(changes));
    return describe(model, make_plan(model, 0, make_start(model)));
  };
  const std::string text = plan({});
  EXPECT_THAT(text, HasSubstr("E* = 115 GPa"));
  EXPECT_THAT(
      text,
      HasSubstr("contact.stiffness = \"hertz\", 4.08e+12 Pa/m, makes it that of the material"));
  EXPECT_THAT(text, HasSubstr("of contact.stiffness = 1e+15 Pa/m:"));
  EXPECT_THAT(plan({"contact.stiffness=hertz"}), HasSubstr("\"hertz\", as here, 4.08e+12 Pa/m"));
  EXPECT_THAT(plan({"contact.law=multiplier"}), Not(HasSubstr("of contact.stiffness =")));
  EXPECT_THAT(plan({"slider.surface={kind=\"flat\"}", "resonator.surface={kind=\"flat\"}"}),
              Not(HasSubstr("asperity")));
}

}  // namespace
}  // namespace ra2d::test
