// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/face_choices.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/plan/expected_work.hpp"
#include "host/plan/plan.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/surface/spline.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"

namespace ra2d::test {
namespace {

using testing::HasSubstr;
using testing::Not;

Scene paper(std::vector<std::string> overrides = {}) {
  overrides.emplace_back("time.scheme=adaptive");
  return read_scene(scene_file("dang2012"), overrides);
}

Plan plan_of(const Scene& scene) { return make_plan(make_model(scene), 0); }

TEST(FaceErrors, OfLinearFacesAreThoseOfTheRuns) {
  // the rate of shocks beside smooth faces of 4 um: docs/accuracy.md, "Errors of the mesh"
  struct Measured {
    const char* stiffness;
    double spacing, rate;
  };
  for (const auto& [stiffness, spacing, rate] : {Measured{"1e15", 4e-6, 0.175},
                                                 {"1e15", 2e-6, 0.027},
                                                 {"1e16", 4e-6, 0.40},
                                                 {"1e16", 2e-6, 0.245},
                                                 {"1e16", 1e-6, 0.034},
                                                 {"1e17", 1e-6, 0.09}}) {
    const Scene scene = paper({fmt::format("contact.stiffness={}", stiffness)});
    const Asperities a = plan_of(scene).asperities;
    const double found = linear_errors(spacing, a.width, scene.speed * a.springs.duration).rate;
    EXPECT_NEAR(std::log(found / rate), 0, std::log(2.2)) << stiffness << " " << spacing;
  }
}

TEST(FaceErrors, GrowWithTheSpacingAndAverageOutInLongShocks) {
  const FaceErrors coarse = linear_errors(2e-6, 2e-5, 1e-6), fine = linear_errors(1e-6, 2e-5, 1e-6);
  EXPECT_NEAR(coarse.rate / fine.rate, 4, 1e-9);
  EXPECT_NEAR(coarse.level / fine.level, 4, 1e-9);
  EXPECT_NEAR(linear_errors(1e-6, 2e-5, 1e-5).rate, 0.1 * fine.rate, 1e-12);
  EXPECT_LE(linear_errors(1, 1e-6, 0).most(), 1);
  EXPECT_LE(smooth_errors(10).most(), 1);
  EXPECT_TRUE(std::isinf(linear_errors(1e-6, 0, 0).most()));  // under multipliers
}

TEST(SplineError, OfAWaveIsTheFourthPowerOfTheSpacing) {
  // between nodes that are h apart a spline is off by h^4/384 of the fourth derivative; the wave
  // fades towards the ends, where splines are off by more
  constexpr double k = 2 * M_PI / 1e-3, length = 0.04;
  for (const double h : {2e-5, 4e-5}) {
    std::vector<double> height;
    double square = 0;
    for (double x = 0; x < length; x += h) {
      height.push_back(std::pow(std::sin(M_PI * x / length), 4) * std::sin(k * x));
      square += std::pow(height.back(), 2);
    }
    const double rms = std::sqrt(square / static_cast<double>(height.size()));
    EXPECT_NEAR(spline_error(height) * rms / (std::pow(k * h, 4) / 384), 1, 0.15);
  }
  EXPECT_EQ(spline_error(std::vector<double>(100, 0.0)), 0);
}

TEST(SplineError, RingsBesideSteps) {
  std::vector<double> step(200, 0.0), hill(200);
  for (std::size_t i = 100; i < step.size(); ++i) step[i] = 1;
  for (std::size_t i = 0; i < hill.size(); ++i) hill[i] = std::cos(0.1 * static_cast<double>(i));
  EXPECT_GT(spline_error(step), most_spline_error);
  EXPECT_NEAR(spline_off(step), 0.5, 0.1);  // as far as between two nodes that stand apart by 1
  // a corner: no fourth power
  std::vector<double> corner(401);
  for (std::size_t i = 0; i < corner.size(); ++i)
    corner[i] = std::abs(static_cast<double>(i) - 201.0);
  EXPECT_GT(spline_off(corner), 0.25 * spline_miss(corner));
  EXPECT_LT(spline_error(hill), most_spline_error);
}

/// A cosine's foot has a corner in its slope; of rough faces Doubts.SplinesThatRing.
TEST(SplineError, BesidePeaksIsANoteOfThePlan) {
  const auto notes = [](const std::vector<std::string>& overrides) {
    return plan_of(read_scene(scene_file("drop"), overrides)).notes;
  };
  const auto rings = testing::Contains(HasSubstr("slider.surface: between nodes 2e-05 m apart"));
  EXPECT_THAT(notes({}), rings);
  EXPECT_THAT(notes({"scene.faces=linear"}), Not(rings));
  EXPECT_THAT(notes({"scene.spacing=5e-6"}), Not(testing::Contains(HasSubstr("its spline"))));
}

TEST(ChooseFaces, NamesTheCheapestThatHolds) {
  const Scene scene = paper();
  const FaceChoices found = plan_of(scene).faces;
  ASSERT_TRUE(found.best);
  EXPECT_EQ(std::count_if(found.list.begin(), found.list.end(),
                          [](const FaceChoice& c) { return c.is_own; }),
            1);
  EXPECT_EQ(found.best->faces, Faces::smooth);  // linear ones of 8 um are off by 84 %
  EXPECT_LE(found.best->errors.most(), face_accuracy);
  for (const FaceChoice& c : found.list)
    if (c.errors.most() <= face_accuracy) {
      EXPECT_LE(found.best->seconds, 1.05 * c.seconds);
    }
  // its words make a scene that has the cheapest
  const std::string words = set_words(*found.best);
  const auto second = words.find(" --set ");
  const Scene chosen = paper({words.substr(6, second - 6), words.substr(second + 7)});
  EXPECT_EQ(chosen.faces, found.best->faces);
  EXPECT_EQ(chosen.spacing, found.best->spacing);
  const FaceChoices again = plan_of(chosen).faces;
  ASSERT_TRUE(again.best);
  EXPECT_TRUE(again.best->is_own) << set_words(*again.best);
}

TEST(ChooseFaces, TakesLinearOnesWhereContactsAreWideAndSplinesRing) {
  const auto best = [](const std::vector<std::string>& overrides) {
    return plan_of(paper(overrides)).faces.best.value_or(FaceChoice{});
  };
  const FaceChoice wide = best({"contact.stiffness=1e12"});
  EXPECT_EQ(wide.faces, Faces::smooth);
  EXPECT_GE(wide.spacing, 32e-6);
  const std::string fractal =
      "surface={kind=\"gaussian\", correlation=\"self-affine\", rq=8e-6, "
      "hurst=0.7, longest=3e-3, shortest=16e-6, seed=1}";
  const FaceChoice rough =
      best({"contact.stiffness=1e11", "resonator." + fractal, "slider." + fractal});
  EXPECT_EQ(rough.faces, Faces::linear);
  EXPECT_EQ(rough.spacing, 8e-6);
}

TEST(ChooseFaces, UnderMultipliersTakesSmoothOnes) {
  const Scene scene =
      read_scene(scene_file("dang2012"), {"contact.law=multiplier", "time.step=1e-7"});
  const Plan plan = plan_of(scene);
  ASSERT_TRUE(plan.faces.best);
  EXPECT_EQ(plan.faces.best->faces, Faces::smooth);
  const std::string text = describe(make_model(scene), plan);
  EXPECT_THAT(text, HasSubstr("not known"));
  const auto json = nlohmann::json::parse(plan_json(make_model(scene), plan));
  EXPECT_TRUE(json["faces"]["choices"][0]["errors"]["shock_rate"].is_null());
  EXPECT_EQ(json["faces"]["cheapest"]["faces"], "smooth");
}

TEST(ChooseFaces, SaysNothingWhereNothingIsKnownOfContacts) {
  EXPECT_TRUE(plan_of(paper({"scene.speed=0"})).faces.list.empty());
  const Scene flat = read_scene(scene_file("moving-force"));
  const Plan plan = plan_of(flat);
  EXPECT_TRUE(plan.faces.list.empty());
  EXPECT_THAT(describe(make_model(flat), plan), Not(HasSubstr("\nfaces")));
  EXPECT_TRUE(nlohmann::json::parse(plan_json(make_model(flat), plan))["faces"].is_null());
}

TEST(ChooseFaces, AreInTheTextAndInTheJson) {
  const Scene scene = paper();
  const Model model = make_model(scene);
  const Plan plan = make_plan(model, 0);
  const std::string text = describe(model, plan);
  EXPECT_THAT(text, HasSubstr("> linear, 8 um"));
  EXPECT_THAT(text, HasSubstr("the cheapest that holds 2 %: " + set_words(*plan.faces.best)));
  std::istringstream in(text.substr(text.find("\nfaces "), 1000));
  for (std::string line; std::getline(in, line);) EXPECT_LE(line.size(), 100) << line;
  const auto json = nlohmann::json::parse(plan_json(model, plan))["faces"];
  EXPECT_EQ(json["set"], set_words(*plan.faces.best));
  EXPECT_EQ(json["choices"].size(), plan.faces.list.size());
  EXPECT_EQ(json["accuracy"], face_accuracy);
}

TEST(ExpectedWork, GrowsWithTheNodesInAContact) {
  // processor time of a simulated second of the paper's scene, of one core, beside 0.14 s between
  // linear faces of 8 um: ratios say more of another machine
  struct Measured {
    Faces faces;
    double spacing, tolerance, ratio;
  };
  Scene s = paper();
  const auto march = [&](const Measured& m) {
    s.faces = m.faces;
    s.spacing = m.spacing;
    s.time.tolerance = m.tolerance;
    return expected_work(s, {.width = 25e-6, .duration = 25e-6}).march;
  };
  const double one = march({Faces::linear, 8e-6, 1e-6, 1});
  for (const Measured& m : {Measured{Faces::linear, 4e-6, 1e-6, 2.3},
                            {Faces::linear, 2e-6, 1e-6, 4.6},
                            {Faces::linear, 1e-6, 1e-6, 14.3},
                            {Faces::smooth, 4e-6, 1e-6, 4.1},
                            {Faces::smooth, 8e-6, 1e-6, 2.7},
                            {Faces::smooth, 32e-6, 1e-6, 2.0},
                            {Faces::smooth, 32e-6, 1e-8, 2.5}})
    EXPECT_NEAR(std::log(march(m) / one / m.ratio), 0, std::log(1.4))
        << m.spacing << " " << m.tolerance;
}

}  // namespace
}  // namespace ra2d::test
