// SPDX-License-Identifier: BSD-3-Clause
// Numbers that are likely to be in another unit are doubted aloud, others are not.
#include "host/model/doubts.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/places.hpp"

namespace ra2d::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using Texts = std::vector<std::string>;

/// Doubts of a scene, or the reason why it is refused.
Texts said(const std::string& name, Texts changes) {
  changes.insert(changes.begin(), "contact.stiffness=4e12");  // of the material, not of a doubt
  try {
    return make_model(read_scene(scene_file(name), changes)).doubts;
  } catch (const RequestError& fault) {
    return {fault.what()};
  }
}

/// A key of the paper's scene, its value there, and what else must change for the scene to hold it.
struct Key {
  std::string name;
  double value;
  Texts along;
  bool small = true;  // whether a thousandth is odd
};

void PrintTo(const Key& key, std::ostream* out) { *out << key.name; }

struct ADoubt : testing::TestWithParam<Key> {};

/// Off by a factor of a thousand, either way, is said with the key's name.
TEST_P(ADoubt, NamesWhatIsOffByAThousand) {
  const Key& key = GetParam();
  const std::string scene = key.name == "scene.gap" ? "dang2012-pinned" : "dang2012";
  const auto changed = [&](double factor) {
    Texts changes = key.along;
    changes.push_back(fmt::format("{}={}", key.name, key.value * factor));
    return said(scene, changes);
  };
  EXPECT_THAT(changed(1), IsEmpty());
  EXPECT_THAT(changed(1e3), Contains(HasSubstr(key.name)));
  if (key.small) {
    EXPECT_THAT(changed(1e-3), Contains(HasSubstr(key.name)));
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfThePapersScene, ADoubt,
    testing::Values(Key{"resonator.length", 0.3, {"scene.speed=0", "scene.start=0.1"}},
                    Key{"resonator.thickness", 0.002, {}}, Key{"resonator.width", 0.2, {}},
                    Key{"resonator.young", 210e9, {}}, Key{"resonator.density", 7800, {}},
                    // a little damping is a fine number: bare steel has 1e-4
                    Key{"resonator.damping", 0.02, {}, false},
                    Key{"resonator.max_frequency", 20e3, {}},
                    Key{"slider.length", 0.02, {"scene.speed=0"}},
                    Key{"slider.thickness", 0.02, {}}, Key{"slider.width", 0.02, {}},
                    Key{"slider.young", 210e9, {}}, Key{"slider.density", 7800, {}},
                    Key{"slider.damping", 0.02, {}, false}, Key{"slider.load", 10, {}},
                    Key{"slider.surface.rq", 8e-6, {}}, Key{"resonator.surface.rq", 8e-6, {}},
                    Key{"resonator.surface.rsm", 1.55e-3, {}},
                    Key{"slider.surface.rsm", 1.55e-3, {}}, Key{"scene.speed", 0.1, {}},
                    Key{"scene.spacing", 8e-6, {}}, Key{"scene.gap", 20e-6, {}}),
    [](const auto& info) {
      std::string name = info.param.name;
      for (char& c : name)
        if (c == '.') c = '_';
      return name;
    });

TEST(Doubts, TheIssuesOwnSlips) {
  EXPECT_THAT(said("dang2012", {"resonator.thickness=3"}),
              Contains(AllOf(HasSubstr("resonator.thickness = 3 m"), HasSubstr("out of proportion"),
                             HasSubstr("is it in mm (0.003 m)?"))));
  EXPECT_THAT(said("dang2012", {"slider.density=8.5"}),
              Contains(HasSubstr("slider.density = 8.5 kg/m^3: lighter than foam: is it in g/cm^3 "
                                 "(8500 kg/m^3)?")));
}

/// 250 mm taken for metres: the thickness of 2 mm is right.
TEST(Doubts, ALengthThatIsOddMakesNoOtherOdd) {
  const Texts doubts = said("dang2012", {"resonator.length=250"});
  EXPECT_THAT(doubts, Contains(HasSubstr("resonator.length = 250 m")));
  EXPECT_THAT(doubts, Not(Contains(HasSubstr("resonator.thickness = "))));
}

TEST(Doubts, SayWhichUnitWasMeant) {
  const auto of = [&](const std::string& change) { return said("dang2012", {change}); };
  EXPECT_THAT(of("resonator.young=210"), Contains(HasSubstr("is it in GPa (2.1e+11 Pa)?")));
  EXPECT_THAT(of("resonator.young=210e3"), Contains(HasSubstr("is it in MPa (2.1e+11 Pa)?")));
  EXPECT_THAT(of("slider.density=19.3"), Contains(HasSubstr("is it in g/cm^3 (1.93e+04 kg/m^3)?")));
  EXPECT_THAT(of("resonator.max_frequency=20"), Contains(HasSubstr("is it in kHz (2e+04 Hz)?")));
  EXPECT_THAT(of("slider.thickness=20"), Contains(HasSubstr("is it in mm (0.02 m)?")));
  EXPECT_THAT(of("slider.damping=0.9"), Contains(HasSubstr("is it in per cent (0.009)?")));
  EXPECT_THAT(said("moving-force", {"resonator.moving_force=[{force=1e5,speed=20,start=0}]"}),
              Contains(HasSubstr("resonator.moving_force[0].force = 100000 N: it bends")));
  const auto force_from = [&](const std::string& start) {
    return said("moving-force",
                {"resonator.moving_force=[{force=1,speed=20,start=" + start + "}]"});
  };
  EXPECT_THAT(force_from("5"), Contains(AllOf(HasSubstr("moving_force[0].start = 5 m: at 20 m/s it "
                                                        "is never on the resonator"),
                                              HasSubstr("is it in mm (0.005 m)?"))));
  EXPECT_THAT(force_from("-0.1"), Not(Contains(HasSubstr("never on"))));
  EXPECT_THAT(said("drop", {"scene.gap=0.02"}), Contains(HasSubstr("is it in mm (2e-05 m)?")));
  EXPECT_THAT(
      said("drop", {"slider.surface.peaks=[{at=0.01,height=0.01,half_width=2e-4}]", "scene.gap=1"}),
      Contains(HasSubstr("slider.surface.peaks[0].height = 0.01 m")));
  EXPECT_THAT(said("drop", {"slider.surface.peaks=[{at=0.01,height=1e-5,half_width=0.2}]"}),
              Contains(HasSubstr(
                  "slider.surface.peaks[0].half_width = 0.2 m: wider than the body is long")));
  EXPECT_THAT(said("drop", {"slider.surface.peaks=[{at=0.01,height=1e-5,half_width=2e-5}]"}),
              Contains(HasSubstr("falls between nodes")));
}

/// By its first mode 4 F/(m omega^2): 200 N bend the plate of 300 x 200 x 2 mm by 0.68 mm, 600 N
/// by 2.05 mm.
TEST(Doubts, APlateIsStretchedWhereItIsBentByMoreThanItsThickness) {
  const auto of = [](const std::string& load) {
    return said("areal", {"scene.spacing=1e-4", "slider.load=" + load});
  };
  EXPECT_THAT(of("200"), Not(Contains(HasSubstr("slider.load"))));
  EXPECT_THAT(of("600"), Contains(AllOf(HasSubstr("slider.load = 600 N: it bends the plate by"),
                                        HasSubstr("stretched"))));
  EXPECT_THAT(of("'1e3 weight'"), Contains(HasSubstr("it bends the plate by")));
}

TEST(Doubts, AnArealContactAgainstItsMaterial) {
  const auto of = [&](const std::string& kappa, const std::string& other = "time.nodes='all'") {
    return said("areal", {"contact.stiffness=" + kappa, "scene.spacing=1e-4", other});
  };
  // a spot as wide as a cell of 100 um has a = 100 um/sqrt(pi), E* = 115.4 GPa: 1.3e15 Pa/m
  EXPECT_THAT(of("5.1e15"), Not(Contains(HasSubstr("contact.stiffness"))));
  EXPECT_THAT(of("5.3e15"),
              Contains(AllOf(HasSubstr("contact.stiffness = 5.3e+15 Pa/m: a node's spring is 4.1 "
                                       "times as stiff"),
                             HasSubstr("E* = 115 GPa, at most 1.3e+15 Pa/m"))));
  // rows closer than that: of smooth faces their distance counts
  EXPECT_THAT(of("5.3e15", "scene.spacing_y=2.5e-5"),
              Not(Contains(HasSubstr("contact.stiffness"))));
  EXPECT_THAT(said("areal", {"contact.stiffness=5.3e15", "scene.spacing=1e-5", "slider.length=1e-3",
                             "slider.width=4e-3", "scene.spacing_y=1e-4", "scene.faces='smooth'"}),
              Contains(HasSubstr("a node's spring")));
  EXPECT_THAT(of("1e16", "contact.law='multiplier'"),
              Not(Contains(HasSubstr("contact.stiffness"))));
  EXPECT_THAT(of("1e7"), Contains(HasSubstr("is it in MPa/mm (1e+16 Pa/m)?")));
  // under all of the slider, a = 10 mm: 3 E*/(4 pi a) = 2.8e12 Pa/m
  EXPECT_THAT(of("1e11"), Contains(AllOf(HasSubstr("far softer"), HasSubstr("2.8e+12 Pa/m"),
                                         HasSubstr("too wide and too long"))));
  EXPECT_THAT(of("1e12"), Not(Contains(HasSubstr("contact.stiffness"))));
}

TEST(Doubts, AGapThatPressesTheFacesFarIntoOneAnother) {
  const auto of = [](const std::string& gap) {
    return said("areal", {"scene.spacing=1e-4", "slider.support='rigid'", "slider.load=0",
                          "scene.initial='rest'", "scene.gap=" + gap});
  };
  EXPECT_THAT(of("-0.1"), Contains(AllOf(HasSubstr("scene.gap = -0.1 m"), HasSubstr("overlap"),
                                         HasSubstr("is it in mm (-0.0001 m)?"))));
  EXPECT_THAT(of("-1e-4"), Not(Contains(HasSubstr("scene.gap = -"))));
}

/// In millimetres 8 um would be a face that no sheet metal has.
TEST(Doubts, OrdinaryRoughnessOfThinSheetIsNone) {
  EXPECT_THAT(said("dang2012", {"resonator.thickness=1e-3"}),
              Not(Contains(HasSubstr("resonator.surface.rq"))));
  EXPECT_THAT(said("dang2012", {"resonator.surface.rq=2e-4"}),
              Contains(HasSubstr("resonator.surface.rq")));
}

TEST(Doubts, OfTheRepositorysScenesThereIsNoneButTheStiffness) {
  for (const std::string name :
       {"dang2012", "dang2012-pinned", "drop", "peaks", "moving-force", "areal"}) {
    const Texts doubts = make_model(read_scene(scene_file(name))).doubts;
    for (const std::string& doubt : doubts) EXPECT_THAT(doubt, HasSubstr("contact.stiffness"));
    EXPECT_EQ(doubts.size(), name.starts_with("dang2012") ? 1u : 0u) << name;
  }
}

/// From micromachines to bridges, from rubber to diamond.
TEST(Doubts, NoneOfWhatIsBuiltAndRubbed) {
  struct Beam {
    std::string what;
    double length, thickness, width, young, density, rq, rsm;
  };
  for (const Beam& b : std::vector<Beam>{{"MEMS", 3e-4, 2e-6, 3e-5, 160e9, 2330, 5e-9, 5e-6},
                                         {"rubber", 0.1, 0.01, 0.02, 2e6, 1100, 10e-6, 1e-3},
                                         {"foam", 0.3, 0.03, 0.1, 5e6, 30, 50e-6, 3e-3},
                                         {"lead", 0.3, 0.003, 0.1, 16e9, 11340, 5e-6, 1e-3},
                                         {"diamond", 0.01, 0.5e-3, 5e-3, 1.2e12, 3520, 1e-7, 1e-4},
                                         {"wood", 2, 0.03, 0.2, 11e9, 450, 30e-6, 3e-3},
                                         {"brake lining", 0.1, 0.01, 0.05, 300e6, 2400, 8e-6, 1e-3},
                                         {"tungsten", 0.2, 0.002, 0.02, 400e9, 19300, 1e-6, 2e-4},
                                         {"rail", 10, 0.15, 0.07, 210e9, 7800, 20e-6, 0.05},
                                         {"foil", 0.2, 2e-5, 0.05, 70e9, 2700, 1e-7, 1e-4}}) {
    const auto body = [&](double length, const char* more) {
      return fmt::format(
          "length = {}\nthickness = {}\nwidth = {}\nyoung = {}\ndensity = {}\ndamping = 0.02\n"
          "modes = 5\nsurface = {{ kind = \"gaussian\", rq = {}, rsm = {}, seed = 1 }}\n{}\n",
          length, b.thickness, b.width, b.young, b.density, b.rq, b.rsm, more);
    };
    const std::string text = fmt::format(
        "[scene]\nduration = 0.1\nspeed = {}\nstart = {}\nspacing = {}\n[resonator]\n"
        "support = \"pinned\"\n{}[slider]\nsupport = \"free\"\n{}[contact]\n"
        "stiffness = \"hertz\"\n[time]\nscheme = \"adaptive\"\n",
        b.length, b.length / 10, b.rsm / 40, body(b.length, ""),
        body(b.length / 5, "load = \"weight\""));
    const Texts doubts = make_model(parse_scene(text, "s.toml")).doubts;
    EXPECT_THAT(doubts, IsEmpty()) << b.what;
  }
}

TEST(Doubts, AMicrophoneThatHearsModesAtFalseFrequencies) {
  const auto of = [](const std::string& rate) {
    return make_model(read_scene(scene_file("drop"),
                                 {"output.rate=" + rate, "resonator.max_frequency=20e3",
                                  "output.microphones=[{ x = 0.15, y = 0.1, z = 0.5 }]"}))
        .doubts;
  };
  EXPECT_THAT(of("100e3"), IsEmpty());
  EXPECT_THAT(of("20e3"), Contains(HasSubstr("frequencies that are not theirs")));
}

TEST(Doubts, CellsTooWideForTheModesShapes) {
  // beta of the highest mode is 193 / m: (beta 5e-4 m)^4/4! = 3.6e-6
  const auto with = [](const std::string& time) {
    return said("dang2012", {"scene.faces=smooth", "scene.spacing=1e-3", time,
                             "resonator.surface.rsm=2e-2", "slider.surface.rsm=2e-2"});
  };
  const auto adaptive = [&](const char* tolerance) {
    return with(fmt::format("time={{scheme=\"adaptive\",tolerance={}}}", tolerance));
  };
  EXPECT_THAT(adaptive("1e-8"),
              Contains(AllOf(HasSubstr("scene.spacing = 0.001 m"), HasSubstr("off by 4e-06"),
                             HasSubstr("scene.spacing = 0.000222 it is 1e-08"))));
  EXPECT_THAT(adaptive("1e-5"), Not(Contains(HasSubstr("cubic"))));
  EXPECT_THAT(with("time.step=1e-8"), Contains(HasSubstr("it is 1e-06")));
}

TEST(Doubts, SplinesThatRing) {
  const auto of = [](const std::string& faces, double spacing) {
    const std::string fractal =
        "surface={kind=\"gaussian\", correlation=\"self-affine\", "
        "rq=8e-6, hurst=0.7, longest=3e-3, shortest=16e-6, seed=1}";
    return said("dang2012",
                {"scene.faces=" + faces, fmt::format("scene.spacing={}", spacing),
                 "contact.stiffness=hertz", "resonator." + fractal, "slider." + fractal});
  };
  const auto rings = AllOf(HasSubstr("between nodes 8e-06 m apart its spline may be off by up to"),
                           HasSubstr(" % of its root mean square height"));
  const Texts said_of_both = of("smooth", 8e-6);
  EXPECT_THAT(said_of_both, Contains(AllOf(HasSubstr("resonator.surface: "), rings)));
  EXPECT_THAT(said_of_both, Contains(AllOf(HasSubstr("slider.surface: "), rings)));
  EXPECT_THAT(of("smooth", 2e-6), Not(Contains(HasSubstr("spline"))));
  EXPECT_THAT(of("linear", 8e-6), Not(Contains(HasSubstr("spline"))));
}

/// Between smooth faces an asperity touches over its own width, however far apart nodes are.
TEST(Doubts, AStiffnessBetweenSmoothFacesHasNoSpacing) {
  const auto at = [](const std::string& faces) {
    return said("dang2012", {"scene.spacing=32e-6", "contact.stiffness=1e16", faces});
  };
  EXPECT_THAT(at("scene.faces=linear"), Contains(HasSubstr("on this spacing")));
  EXPECT_THAT(at("scene.faces=smooth"), Contains(HasSubstr("times as stiff as their material")));
}

TEST(Doubts, AStiffnessBeyondTheHalfSpace) {
  const auto of = [](const std::string& name, const std::string& value) {
    Texts found;
    for (const std::string& doubt :
         make_model(read_scene(scene_file(name), {"contact.stiffness=" + value})).doubts)
      if (doubt.find("contact.stiffness") != doubt.npos) found.push_back(doubt);
    return found;
  };
  // the paper's material: 4.08e12 Pa/m for round asperities, 3.4e16 for a ridge of half a node
  for (const char* fine : {"hertz", "1e11", "1e12", "4e12", "1e13"})
    EXPECT_THAT(of("dang2012", fine), IsEmpty()) << fine;
  EXPECT_THAT(of("dang2012", "1e15"), Contains(AllOf(HasSubstr("asperities are 39 times as stiff"),
                                                     HasSubstr("4.08e+12"))));
  EXPECT_THAT(of("dang2012", "1e17"), Contains(AllOf(HasSubstr("stiffer than the bodies' material"),
                                                     HasSubstr("3.4e+16"))));
  EXPECT_THAT(of("dang2012", "1e6"), Contains(HasSubstr("is it in MPa/mm (1e+15 Pa/m)?")));
  // peaks are ridges on purpose
  EXPECT_THAT(of("peaks", "1e15"), IsEmpty());
  EXPECT_THAT(of("peaks", "1e18"), Contains(HasSubstr("stiffer than the bodies' material")));
  // flat on flat no contact is narrow
  EXPECT_THAT(of("moving-force", "1e18"), IsEmpty());
}

}  // namespace
}  // namespace ra2d::test
