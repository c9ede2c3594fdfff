// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/plan.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "host/base/format.hpp"
#include "host/plan/expected_work.hpp"
#include "host/run/timed_run.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"
#include "tests/simulate.hpp"

namespace ra2d::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// A plate under one peak of a rigid slider.
Scene pressed_plate() {
  Scene s = plate_scene(6, 0.004, 1e-3);
  s.gap = 5e-6;
  s.contact.stiffness = 1e13;
  s.slider.surface = peaks({{.at = 0.002, .height = 1e-5, .half_width = 3e-5}});
  return s;
}

std::string text_of(const Scene& scene) {
  const Model model = make_model(scene);
  return describe(model, make_plan(model, 0));
}

/// The line of a scheme in the table, from its mark on.
std::string line_of(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (line.find(fmt::format(" {}  ", name)) != std::string::npos) return line.substr(11);
  return "";
}

TEST(Plan, NamesEverySchemeAndMarksTheScenes) {
  Scene s = pressed_plate();
  const std::vector<std::string> names{
      "explicit-euler", "midpoint", "backward-euler", "heun", "rk4", "rk8", "exact", "gautschi"};
  const std::vector<SchemeKind> kinds{
      SchemeKind::explicit_euler, SchemeKind::midpoint, SchemeKind::backward_euler,
      SchemeKind::heun,           SchemeKind::rk4,      SchemeKind::rk8,
      SchemeKind::exact,          SchemeKind::gautschi};
  for (std::size_t own = 0; own < kinds.size(); ++own) {
    s.time.scheme = kinds[own];
    const std::string text = text_of(s);
    SCOPED_TRACE(text);
    EXPECT_THAT(text, HasSubstr("scheme     " + names[own]));
    for (std::size_t i = 0; i < names.size(); ++i)
      EXPECT_THAT(line_of(text, names[i]), StartsWith(i == own ? "> " : "  "));
  }
  s.time.scheme = SchemeKind::backward_euler;
  s.time.contact_force = ForceTime::new_time;
  const std::string text = text_of(s);
  EXPECT_THAT(text, HasSubstr("\n           > backward-euler, new force "));
  EXPECT_THAT(text, HasSubstr("\n             backward-euler  "));
  EXPECT_THAT(text, HasSubstr("contact force of the new time"));
}

TEST(Plan, SaysWhatBinds) {
  // the contact spring of a node at a peak: far stiffer than the modes
  const std::string stiff = text_of(pressed_plate());
  SCOPED_TRACE(stiff);
  EXPECT_THAT(line_of(stiff, "midpoint"), EndsWith(", contact"));
  EXPECT_THAT(line_of(stiff, "backward-euler"),
              AllOf(HasSubstr("every step"), EndsWith(", contact")));
  EXPECT_THAT(stiff,
              HasSubstr("backward-euler, new force every step          every step  every step"));
  // one so soft that it adds nothing
  Scene soft = pressed_plate();
  soft.contact.stiffness = 1e3;
  EXPECT_THAT(line_of(text_of(soft), "backward-euler"), EndsWith("every step"));
  // without damping some hold at no step
  soft.resonator.damping = 0;
  const std::string undamped = text_of(soft);
  SCOPED_TRACE(undamped);
  EXPECT_THAT(line_of(undamped, "explicit-euler"), EndsWith("no step, modes"));
  EXPECT_THAT(line_of(undamped, "heun"), EndsWith("no step, modes"));
  EXPECT_THAT(line_of(undamped, "exact"),
              AllOf(HasSubstr("every step"), EndsWith("no step, contact")));
}

TEST(Plan, OfMultipliersKnowsNoSpring) {
  Scene s = pressed_plate();
  s.contact.law = ContactLaw::multiplier;
  for (const double stiffness : {0.0, 1e13}) {
    s.contact.stiffness = stiffness;
    const std::string text = text_of(s);
    SCOPED_TRACE(text);
    EXPECT_THAT(text,
                AllOf(HasSubstr("contact    multiplier"), HasSubstr("no contact spring"),
                      Not(HasSubstr("N/m")), Not(HasSubstr("one node")), Not(HasSubstr("nan")),
                      Not(HasSubstr("inf")), Not(HasSubstr("explicit-euler"))));
    EXPECT_THAT(line_of(text, "backward-euler"), AllOf(StartsWith("> "), EndsWith("every step")));
    EXPECT_THAT(line_of(text, "midpoint"), EndsWith(" kHz)"));
  }
}

TEST(Plan, OfAnAdaptiveSceneKnowsNoStep) {
  Scene s = pressed_plate();
  s.time.scheme = SchemeKind::adaptive;
  s.time.tolerance = 1e-9;
  s.speed = 0.1;
  std::string texts[3];
  for (int i = 0; i < 3; ++i) {
    s.time.step = i == 0 ? 0.0 : i == 1 ? 1e-7 : 1.0;
    texts[i] = text_of(s);
  }
  SCOPED_TRACE(texts[0]);
  EXPECT_THAT(texts[0],
              AllOf(HasSubstr("scheme     adaptive, to a relative error of 1e-09 a step"),
                    HasSubstr("closed form"), HasSubstr("stability  no limit"), HasSubstr("memory"),
                    HasSubstr("2001 samples"), HasSubstr("without contact to "),
                    Not(HasSubstr("steps of")), Not(HasSubstr("holds up to")),
                    Not(HasSubstr("time.step")), Not(HasSubstr("nan")), Not(HasSubstr("inf"))));
  EXPECT_EQ(texts[1], texts[0]);
  EXPECT_EQ(texts[2], texts[0]);
  // and the others' table is of steps
  EXPECT_THAT(text_of(pressed_plate()), Not(HasSubstr("adaptive")));
}

TEST(Plan, AnAdaptiveScenesCostGoesWithItsEvents) {
  Scene s = pressed_plate();
  s.time.scheme = SchemeKind::adaptive;
  s.time.tolerance = 1e-6;
  s.speed = 0.01;
  s.output.rate = 100;  // few samples
  s.contact.stiffness = 1e17;
  const auto cost = [](const Scene& scene) {
    const Plan plan = make_plan(make_model(scene), 0);
    EXPECT_LE(plan.seconds_free, plan.seconds_one);
    EXPECT_LE(plan.seconds_one, plan.seconds_many);
    EXPECT_GT(plan.seconds_free, 0);
    return plan;
  };
  const Plan plan = cost(s);
  Scene other = s;
  other.contact.stiffness = 1e4 * s.contact.stiffness;  // the spring is by far the fastest in both
  EXPECT_NEAR(cost(other).seconds_one / plan.seconds_one, 100, 10);
  EXPECT_EQ(cost(other).seconds_free, plan.seconds_free);
  other = s;
  other.speed = 2 * s.speed;  // twice as many nodes are passed
  EXPECT_NEAR(cost(other).seconds_free / plan.seconds_free, 2, 0.2);
  other = s;
  other.time.nodes = Nodes::all;
  EXPECT_GT(cost(other).seconds_free, plan.seconds_free);
  other = s;
  other.time.tolerance = 1e-12;
  EXPECT_GT(cost(other).seconds_one, plan.seconds_one);
  other = s;
  other.speed = 0;  // nothing is passed: but for its samples a flight costs nothing
  EXPECT_LT(cost(other).seconds_free, 0.2 * plan.seconds_free);
  EXPECT_GT(cost(other).seconds_one, 0.5 * plan.seconds_one);
  other = s;
  other.resonator.moving_forces = {{1.0, 0.0, 0.1}};  // the force keeps the modes busy all the time
  EXPECT_GT(cost(other).seconds_free, 3 * plan.seconds_free);
}

TEST(Plan, AnAdaptiveScenesCostIsOfTheRightSize) {
  // A node is passed every 10 us and costs a flight, 0.6 us; pressed, the spring (half a period of
  // `contact_period`) touches and lets go once each in that time, and theta = (8! 1e-5)^(1/8)
  // = 0.893 of its turning are a step: 2 + pi/0.893 = 5.52 steps of 10 orders, 1.3 us.
  Scene s = pressed_plate();
  s.time.scheme = SchemeKind::adaptive;
  s.time.tolerance = 1e-5;
  s.speed = 1e5 * s.spacing;
  s.duration = 1e-3;
  s.output.rate = 1e3;
  s.contact.stiffness = 1e17;
  const Plan plan = make_plan(make_model(s), 0);
  EXPECT_NEAR(plan.seconds_free, 100 * 0.6e-6, 1e-6);
  const double steps = 100 + 5.52 * s.duration / plan.contact_period;
  EXPECT_NEAR(plan.seconds_one / (steps * 1.3e-6), 1, 2e-3);  // the figures are of three digits
}

/// Steps that lie on one another all the time: what a step costs at the worst [s].
double worst_step(Scene s) {
  const Model model = make_model(s);
  const Plan plan = make_plan(model, 0);
  return plan.seconds_many / static_cast<double>(plan.steps);
}

TEST(Plan, ForeseesWhatTheForcesOfManyNodesTake) {
  Scene s = plate_scene(6, 0.004, 1e-3);
  s.gap = 0;
  s.contact.stiffness = 1e13;
  s.time.contact_force = ForceTime::new_time;
  const auto with_nodes = [&](double nodes) {
    Scene out = s;
    out.spacing = s.slider.length / (nodes - 1);
    return worst_step(out);
  };
  // one after the other: eight times as long for twice as many
  EXPECT_NEAR(with_nodes(241) / with_nodes(121), 8, 4);
  EXPECT_GT(with_nodes(241), 240.0 * 240 * 240 * 0.1e-9);  // a tenth of a nanosecond for each pivot
  // Newton's method: as many nodes, as long
  EXPECT_NEAR(with_nodes(8001) / with_nodes(4001), 2, 0.2);
  EXPECT_LT(with_nodes(5001), 0.1);  // s; it was 37 s
}

TEST(Plan, ForcesThatTravelAreInTheCost) {
  Scene s = plate_scene(6, 0.004, 1e-3);
  s.contact.stiffness = 1e13;
  const Model few = make_model(s);
  s.resonator.moving_forces.assign(1000, {.force = 1, .speed = 0, .start = 0});
  const Model many = make_model(s);
  const double seconds = make_plan(many, 0).seconds_free - make_plan(few, 0).seconds_free;
  // each is a sum over the modes: some 10 ns, not a tenth and not ten times as much
  EXPECT_NEAR(std::log10(seconds / (1000.0 * static_cast<double>(many.steps)) / 20e-9), 0, 0.5);
}

TEST(ExpectedWork, IsWithinAFactorOfThreeOfTheStridesMade) {
  const Scene paper =
      read_scene(scene_file("dang2012"), {"time.scheme=adaptive", "scene.duration=0.01"});
  const auto check = [&](const std::string& what, const auto& change) {
    Scene s = paper;
    change(s);
    const auto made = static_cast<double>(simulate(s).end.steps_made);
    const double expected = expected_work(s).steps;
    EXPECT_GT(expected, made / 3) << what << ": " << made << " made";
    EXPECT_LT(expected, made * 3) << what << ": " << made << " made";
    EXPECT_GT(expected_work(s).march, 0.3e-6 * made) << what;  // s: a step takes some microseconds
    EXPECT_LT(expected_work(s).march, 30e-6 * made) << what;
  };
  check("as it is", [](Scene&) {});
  for (const double speed : {0.0, 0.005, 0.02, 0.5})
    check(fmt::format("{} m/s", speed), [&](Scene& s) { s.speed = speed; });
  check("soft", [](Scene& s) { s.contact.stiffness = 1e13; });
  check("loose", [](Scene& s) { s.time.tolerance = 1e-4; });
  check("loaded", [](Scene& s) {
    s.slider.load_is_weight = false;
    s.slider.load = 10;
  });
  check("fine", [](Scene& s) { s.spacing = 2e-6; });
}

Scene block_on_plate(const std::string& side, const std::string& spacing) {
  return read_scene(scene_file("areal"), {"slider.length=" + side, "slider.width=" + side,
                                          "scene.spacing=" + spacing, "scene.duration=0.01"});
}

TEST(ExpectedWork, OnMapsIsWithinAFactorOfThreeOfTheStepsMade) {
  for (const auto& [side, spacing] : {std::pair{"0.005", "50e-6"}, std::pair{"0.005", "16e-6"},
                                      std::pair{"0.02", "64e-6"}, std::pair{"0.04", "1e-4"}}) {
    const Scene s = block_on_plate(side, spacing);
    const Model model = make_model(s);
    const auto made = static_cast<double>(timed_run(model, make_start(model)).end.steps_made);
    EXPECT_NEAR(std::log(expected_work(s).steps / made), 0, std::log(3))
        << side << " m at " << spacing << " m: " << made << " made";
  }
}

/// More of a larger block's nodes come near contact. Where the order of the series is not raised
/// (host/device/layout.hpp), there are more steps, too.
TEST(Plan, LargerBlocksOnMapsTakeLonger) {
  const auto seconds = [](const std::string& side) {
    return make_plan(make_model(block_on_plate(side, "1e-4")), 1).seconds_one;
  };
  EXPECT_GT(seconds("0.04"), 2 * seconds("0.02"));
  EXPECT_GT(seconds("0.08"), 1.2 * seconds("0.04"));
}

/// Between smooth faces, too, the contact spring makes the steps where it is faster than any mode:
/// of a block on a rigid plate there is nothing else that does.
TEST(Plan, TheSpringOfABlockOnARigidPlateTakesSteps) {
  const auto seconds = [](const std::string& faces, const std::string& stiffness) {
    const Scene s =
        read_scene(scene_file("areal"),
                   {"resonator.support=rigid", "slider.length=0.002", "slider.width=0.002",
                    "scene.spacing=1e-4", "scene.faces=" + faces, "scene.initial=rest",
                    "scene.duration=0.01", "contact.stiffness=" + stiffness, "output.rate=1000"});
    const Plan plan = make_plan(make_model(s), 0);
    EXPECT_LT(plan.seconds_free, 0.1 * plan.seconds_one) << faces;
    return std::pair{plan.seconds_many, expected_work(s).march};
  };
  for (const char* faces : {"linear", "smooth"}) {
    const auto [planned, expected] = seconds(faces, "1e18");
    const auto [soft_planned, soft_expected] = seconds(faces, "1e16");
    EXPECT_NEAR(planned / soft_planned, 10, 1) << faces;
    EXPECT_GT(expected / soft_expected, 3) << faces;  // fewer nodes touch, too
  }
}

TEST(ExpectedWork, OfFixedStepsIsTheirNumber) {
  Scene s = pressed_plate();
  s.duration = 1e-3;
  s.time.step = 1e-8;
  EXPECT_NEAR(expected_work(s).steps, 1e5, 1e-6);
  const double once = expected_work(s).march;
  s.time.scheme = SchemeKind::rk4;
  EXPECT_GT(expected_work(s).march, 3 * once);  // four stages
  // a hundredth of the steps: less than a tenth of the time, for nodes are searched as often
  const double all = expected_work(s).march;
  s.time.step = 1e-6;
  EXPECT_LT(expected_work(s).march, 0.1 * all);
  EXPECT_GT(expected_work(s).march, 0.02 * all);
}

TEST(Plan, SaysWhatTheStepMakesOfTheHighestMode) {
  Scene s = pressed_plate();
  const Model model = make_model(s);
  const double x = model.resonator.modes[5].omega * s.time.step;
  EXPECT_THAT(text_of(s), HasSubstr(fmt::format("damping ratio, 0.02, by {:+.1e}, its period by",
                                                step_error(s.time.scheme, 0.02, x).damping)));
  EXPECT_GT(step_error(s.time.scheme, 0.02, x).damping, 0);
  s.time.scheme = SchemeKind::explicit_euler;
  EXPECT_THAT(text_of(s), HasSubstr("damping ratio, 0.02, by -"));
  s.time.scheme = SchemeKind::exact;
  EXPECT_THAT(text_of(s), HasSubstr("exact for free modes"));
}

TEST(Plan, SaysHowLongTheStartRings) {
  // 60 dB are ln(1000)/(zeta omega) of the slowest mode
  Scene s = pressed_plate();
  const double omega = make_model(s).resonator.modes[0].omega;
  EXPECT_THAT(text_of(s), HasSubstr(fmt::format(
                              "the resonator's mode at {:.4g} Hz dies away by 60 dB in {}; the "
                              "run takes 2 ms",
                              omega / (2 * M_PI), seconds_text(std::log(1e3) / (0.02 * omega)))));
  EXPECT_THAT(text_of(s),
              HasSubstr("it starts from rest, and rings; level and shocks count from t = 0"));
  s.initial = Initial::statics;
  s.output.from = 1e-3;
  EXPECT_THAT(text_of(s),
              HasSubstr("it starts in equilibrium; level and shocks count from 1 ms on"));
  s.resonator.damping = 0;
  EXPECT_THAT(text_of(s), HasSubstr("never dies away"));
}

TEST(Plan, WarnsOfTheMeshsOwnToneBelowTheHighestMode) {
  Scene s = pressed_plate();
  s.speed = 0;
  const char* const warning = "the mesh makes a tone of its own at scene.speed / scene.spacing = ";
  EXPECT_THAT(text_of(s), Not(HasSubstr(warning)));
  const Model model = make_model(s);
  const double highest = make_plan(model, 0).resonator.highest;
  s.speed = 1.01 * highest * s.spacing;
  EXPECT_THAT(text_of(s), Not(HasSubstr(warning)));
  s.speed = 0.99 * highest * s.spacing;
  EXPECT_THAT(text_of(s), AllOf(HasSubstr(warning), HasSubstr("scene.spacing = ")));
}

/// The sound at microphones stands in the plan, in proportion to them, and why there is none.
TEST(Plan, CountsTheSoundAtMicrophones) {
  const auto with_microphones = [](int count) {
    Scene s = read_scene(scene_file("dang2012"));
    s.output.microphones.assign(static_cast<std::size_t>(count), {.x = 0.15, .y = 0.1, .z = 0.5});
    return s;
  };
  EXPECT_THAT(text_of(with_microphones(0)), Not(HasSubstr("\nsound ")));
  EXPECT_THAT(text_of(with_microphones(1)), HasSubstr("\nsound      1 microphone: "));
  const Model model = make_model(with_microphones(10));
  const Plan ten = make_plan(model, 0), five = make_plan(make_model(with_microphones(5)), 0);
  EXPECT_THAT(describe(model, ten), HasSubstr("\nsound      10 microphones: "));
  const nlohmann::json said = nlohmann::json::parse(plan_json(model, ten))["sound"];
  EXPECT_EQ(said["microphones"], 10);
  EXPECT_EQ(said["seconds"], ten.sound.seconds);
  // bench_sound and 'ra2d analyze' take 0.2 s for these ten; what is read is read once
  EXPECT_NEAR(std::log10(ten.sound.seconds / 0.2), 0, 0.5);
  EXPECT_NEAR(ten.sound.seconds / five.sound.seconds, 2, 0.2);
  // at the least the samples of each pressure
  EXPECT_GT(ten.sound.memory, 10 * 8 * 100'001);
  EXPECT_LT(ten.sound.memory, 50e6);
  EXPECT_THAT(ten.notes, Each(Not(HasSubstr("no sound"))));
  EXPECT_THAT(make_plan(make_model(with_microphones(2000)), 0).notes,
              Contains(AllOf(HasSubstr("the report will have no sound"), HasSubstr("2 GB"))));
}

TEST(Plan, IsReadableAtAHundredColumns) {
  for (const SchemeKind scheme :
       {SchemeKind::backward_euler, SchemeKind::rk8, SchemeKind::adaptive}) {
    Scene s = pressed_plate();
    s.time.scheme = scheme;
    std::istringstream in(text_of(s));
    for (std::string line; std::getline(in, line);) EXPECT_LE(line.size(), 100) << line;
  }
}

TEST(BeyondLimit, IsSaidFromTheLimitOn) {
  Scene s = pressed_plate();
  const double limit = step_limits(make_model(s), choice_of(s)).holds();
  s.time.step = limit;
  Model model = make_model(s);
  EXPECT_THAT(beyond_limit(model, step_limits(model, choice_of(s))), IsEmpty());
  s.time.step = 1.01 * limit;
  model = make_model(s);
  const std::string beyond = beyond_limit(model, step_limits(model, choice_of(s)));
  EXPECT_THAT(beyond, AllOf(HasSubstr("backward-euler"), HasSubstr("a node in contact"),
                            HasSubstr("grows e-fold")));
  EXPECT_THAT(text_of(s), HasSubstr("'ra2d run' refuses it"));
  s.time.force = true;
  EXPECT_THAT(text_of(s), HasSubstr("'ra2d run' takes it"));
  s.time.contact_force = ForceTime::new_time;
  EXPECT_THAT(text_of(s), Not(HasSubstr("'ra2d run'")));
}

TEST(StepCure, NamesAStepThatHolds) {
  Scene s = pressed_plate();
  EXPECT_THAT(step_cure(s, 1.23999e-6), HasSubstr("time.step = 1.23e-06 or less"));
  EXPECT_THAT(step_cure(s, 0), Not(HasSubstr("time.step")));
  EXPECT_THAT(step_cure(s, 0), HasSubstr("time.contact_force = \"new\" (holds at every step)"));
  s.time.scheme = SchemeKind::heun;
  EXPECT_THAT(step_cure(s, 0),
              HasSubstr("time.scheme = \"backward-euler\" with time.contact_force"));
  s.contact.law = ContactLaw::multiplier;
  EXPECT_THAT(step_cure(s, 0), Not(HasSubstr("contact_force")));
}

}  // namespace
}  // namespace ra2d::test
