// SPDX-License-Identifier: BSD-3-Clause
// The key that tells one run from another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/run/run_key.hpp"
#include "tests/scenes.hpp"

namespace ra2d {
namespace {

using ::testing::MatchesRegex;

TEST(RunKey, IsOfTheSceneAndItsHeightsAlone) {
  Scene scene = test::plate_scene(3, 0.01, 1e-3);
  scene.resonator.surface = test::gaussian(3e-6, 1e-3, 1);
  scene.slider.surface = test::gaussian(3e-6, 1e-3, 2);
  const Model model = make_model(scene);
  const std::string key = run_key(model);
  EXPECT_THAT(key, MatchesRegex("[0-9a-f]{32}"));
  EXPECT_EQ(run_key(make_model(scene)), key);

  const auto changed = [&](auto change) {
    Model other = model;
    change(other);
    return run_key(other) != key;
  };
  EXPECT_FALSE(changed([](Model& m) { m.scene.name = "another"; }));
  EXPECT_FALSE(changed([](Model& m) { m.scene.file = "elsewhere.toml"; }));
  EXPECT_FALSE(changed([](Model& m) { m.scene.slider.surface.path = "profile.csv"; }));
  EXPECT_TRUE(changed([](Model& m) { m.scene.speed = std::nextafter(m.scene.speed, 1.0); }));
  EXPECT_TRUE(changed([](Model& m) { m.scene.slider.surface.seed ^= 1; }));
  EXPECT_TRUE(changed([](Model& m) { m.scene.output.rate *= 2; }));
  for (auto heights : {&Model::resonator_height, &Model::slider_height})
    EXPECT_TRUE(changed([&](Model& m) {
      double& last = (m.*heights).edit().back();
      last = std::nextafter(last, std::numeric_limits<double>::infinity());
    }));
  // a height that goes from one body to the other
  EXPECT_TRUE(changed([](Model& m) {
    std::vector<double>& own = m.slider_height.edit();
    own.insert(own.begin(), m.resonator_height.back());
    m.resonator_height.edit().pop_back();
  }));
}

/// A study knows a run by its scene and files: not by the heights that a newer program makes of a
/// map.
TEST(RunKey, ScenesWithAMapThatGoesOnHaveAnotherVersion) {
  Scene scene;
  scene.kind = SceneKind::areal;
  const int usual = numerics_version_of(scene);
  for (BodySpec* body : {&scene.resonator, &scene.slider}) {
    const SurfaceSpec before = body->surface;
    body->surface.kind = SurfaceKind::file;
    EXPECT_EQ(numerics_version_of(scene), usual);
    for (const ShortProfile how : {ShortProfile::repeat, ShortProfile::mirror}) {
      body->surface.prepared.when_short = how;
      EXPECT_NE(numerics_version_of(scene), usual);
    }
    body->surface = before;
  }
}

}  // namespace
}  // namespace ra2d
