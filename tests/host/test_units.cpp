// SPDX-License-Identifier: BSD-3-Clause
// Numbers with a unit, in texts, scenes and studies.
#include "host/base/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/run/run_key.hpp"
#include "host/scene_file/key_facts.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/study/study_points.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"
#include "tests/studies.hpp"

namespace ra2d::test {
namespace {

using testing::AllOf;
using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::Optional;

std::optional<double> in(const std::string& unit, const std::string& text) {
  return read_quantity(text, unit).value;
}

std::string fault_in(const std::string& unit, const std::string& text) {
  const NumberWithUnit quantity = read_quantity(text, unit);
  return quantity.value ? fmt::format("read as {}", *quantity.value) : quantity.fault;
}

TEST(Units, ATextIsTheNumberThatTomlWouldRead) {
  EXPECT_EQ(in("m", "500 mm"), 0.5);
  EXPECT_EQ(in("m", "8 um"), 8e-6);
  EXPECT_EQ(in("m", "8 \u00B5m"), 8e-6);  // the micro sign
  EXPECT_EQ(in("m", "8 \u03BCm"), 8e-6);  // the Greek letter
  EXPECT_EQ(in("s", "10 ms"), 10e-3);
  EXPECT_EQ(in("s", "1.5 min"), 90.0);
  EXPECT_EQ(in("s", "2 h"), 7200.0);
  EXPECT_EQ(in("Pa", "210 GPa"), 210e9);
  EXPECT_EQ(in("Pa", "210e3 N/mm^2"), 210e9);
  EXPECT_EQ(in("Pa", "3 bar"), 3e5);
  EXPECT_EQ(in("kg/m^3", "7.85 g/cm^3"), 7850.0);
  EXPECT_EQ(in("kg/m^3", "7.85 g/cm\u00B3"), 7850.0);
  EXPECT_EQ(in("kg/m^3", "7.85 t/m^3"), 7850.0);
  EXPECT_EQ(in("kg/m^3", "7850 kg m-3"), 7850.0);  // as the files of results have it
  EXPECT_EQ(in("kg/m^3", "7850 kg\u00B7m\u207B\u00B3"), 7850.0);
  EXPECT_EQ(in("kg/m^3", "7850 kg*m**-3"), 7850.0);
  EXPECT_EQ(in("Hz", "100 kHz"), 1e5);
  EXPECT_EQ(in("Hz", "100 1/s"), 100.0);
  EXPECT_EQ(in("Hz", "100 s^-1"), 100.0);
  EXPECT_EQ(in("Pa/m", "1e15 Pa/m"), 1e15);
  EXPECT_EQ(in("Pa/m", "1 GPa/um"), 1e15);
  EXPECT_EQ(in("Pa/m", "1e6 N/mm^3"), 1e15);
  EXPECT_EQ(in("N", "5 N"), 5.0);
  EXPECT_EQ(in("N", "5 kg m/s^2"), 5.0);
  EXPECT_EQ(in("m/s", "0.1 m s^-1"), 0.1);
  EXPECT_EQ(in("m/s", "100 um/ms"), 0.1);
  EXPECT_EQ(in("m", "1 in"), 0.0254);
  EXPECT_THAT(in("m/s", "36 km/h"), Optional(DoubleEq(10)));
}

TEST(Units, BlanksAndSignsAreAsPeopleWriteThem) {
  EXPECT_EQ(in("m", " 5 mm "), 5e-3);
  EXPECT_EQ(in("m", "5mm"), 5e-3);
  EXPECT_EQ(in("m", "5\u00A0mm"), 5e-3);
  EXPECT_EQ(in("m", "-3 mm"), -3e-3);
  EXPECT_EQ(in("m", "\u22123 mm"), -3e-3);
  EXPECT_EQ(in("m", "+3 mm"), 3e-3);
  EXPECT_EQ(in("m", "1_000 mm"), 1.0);
  EXPECT_EQ(in("m", ".5 mm"), 5e-4);
  EXPECT_EQ(in("m", "5. mm"), 5e-3);
  EXPECT_EQ(in("m", "5e-1mm"), 5e-4);
  EXPECT_EQ(in("m", "005 mm"), 5e-3);
}

/// The bits of the plain number, over all magnitudes of the prefixes.
TEST(Units, APrefixMovesTheDecimalPointAlone) {
  std::mt19937_64 dice(7);
  constexpr std::pair<const char*, int> prefixes[] = {{"p", -12}, {"n", -9}, {"u", -6}, {"m", -3},
                                                      {"c", -2},  {"d", -1}, {"", 0},   {"h", 2},
                                                      {"k", 3},   {"M", 6},  {"G", 9},  {"T", 12}};
  for (int i = 0; i < 20'000; ++i) {
    const std::uint64_t digits = dice() % (std::uint64_t{1} << (1 + dice() % 63));
    const int exponent = static_cast<int>(dice() % 41) - 20;
    for (const auto& [prefix, power] : prefixes) {
      const std::string plain = fmt::format("{}e{}", digits, exponent + power);
      const std::string text = fmt::format("{}e{} {}m", digits, exponent, prefix);
      ASSERT_EQ(in("m", text), std::strtod(plain.c_str(), nullptr)) << text;
    }
  }
  for (int thousandths = 1; thousandths < 20'000; ++thousandths) {
    const std::string text = fmt::format("{}.{:03} um", thousandths / 1000, thousandths % 1000);
    ASSERT_EQ(in("m", text), std::strtod(fmt::format("{}e-9", thousandths).c_str(), nullptr));
  }
}

TEST(Units, AWrongDimensionIsNamed) {
  EXPECT_EQ(fault_in("m", "5 kg"), "is a mass, not a length");
  EXPECT_EQ(fault_in("m/s", "5 m"), "is a length, not a speed");
  EXPECT_EQ(fault_in("Hz", "5 ms"), "is a time, not a frequency");
  EXPECT_EQ(fault_in("Pa/m", "5 GPa"), "is a pressure, not a pressure by length");
  EXPECT_EQ(fault_in("m", "5 m^4/s"), "is in m^4 s^-1, not a length");
  EXPECT_EQ(fault_in("m", "5 m/m"), "is a plain number, not a length");
}

TEST(Units, AnUnknownUnitIsSaidWithTheLikelyOne) {
  const auto meant = [](const std::string& unit, const std::string& text) {
    return fault_in(unit, text);
  };
  EXPECT_EQ(meant("Pa", "210 Gpa"), "has the unknown unit \"Gpa\" (did you mean \"GPa\"?)");
  EXPECT_THAT(meant("Pa", "210 gpa"), HasSubstr("\"GPa\""));
  EXPECT_THAT(meant("Hz", "20 khz"), HasSubstr("\"kHz\""));
  EXPECT_THAT(meant("m", "20 microns"), HasSubstr("\"um\""));
  EXPECT_THAT(meant("m", "20 metres"), HasSubstr("\"m\""));
  EXPECT_THAT(meant("m", "20 MM"), HasSubstr("\"mm\""));
  EXPECT_THAT(meant("kg/m^3", "7.8 g/cc"), HasSubstr("\"g/cm^3\""));
  EXPECT_THAT(meant("m/s", "5 kmh"), HasSubstr("\"km/h\""));
  EXPECT_EQ(meant("m", "20 furlongs"), "has the unknown unit \"furlongs\"");
}

TEST(Units, HostileTextsAreNoNumbers) {
  for (const char* text : {"", " ", "mm", "nan m", "inf m", "-inf m", "m 5", "-", ".", "e5 m",
                           "--5 mm", "five mm", "5 5", "5 $", "5 \"", "5 1", "+-5 mm"})
    EXPECT_EQ(fault_in("m", text), "") << text;
  EXPECT_EQ(fault_in("m", "5"), "is a text without a unit");
  EXPECT_EQ(fault_in("", "5"), "is a text, no number");
  EXPECT_EQ(fault_in("", "5 mm"), "has a unit, and this number has none");
  EXPECT_EQ(fault_in("", "2 %"), "is in per cent: write 0.02");
  EXPECT_EQ(fault_in("m", "2 %"), "");
  EXPECT_THAT(fault_in("m", "0,5 mm"), HasSubstr("has a comma"));
  for (const char* text : {"0x10 m", "0X10 m", "-0b1 m", "0o7 m"})
    EXPECT_EQ(fault_in("m", text), "is not in decimals") << text;
  for (const char* text :
       {"5 m/", "5 m//s", "5 m^", "5 m^^2", "5 m^99999999999", "5 /", "5 m$", "5 1/", "5 kkm",
        "5 mmin", "1__0 mm", "1_ mm", "5 e3 m", "5 m m!", "5 m(s)", "5 k"})
    EXPECT_FALSE(in("m", text)) << text;
  EXPECT_EQ(fault_in("m", "5 m" + std::string(1 << 20, 'm')),
            "is too long for a number with a unit");
  EXPECT_EQ(fault_in("m", std::string(1 << 20, '9') + " m"),
            "is too long for a number with a unit");
  EXPECT_FALSE(in("m", std::string("5 m\0m", 5)));
  EXPECT_FALSE(in("m", std::string("5\0 mm", 5)));
  EXPECT_FALSE(in("m", "5 \xff\xfe"));
}

TEST(Units, NumbersBeyondADoubleAreInfiniteOrZero) {
  EXPECT_EQ(in("m", "1e400 m"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(in("m", "-1e99999999999999999999 mm"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(in("m", "1e-400 m"), 0.0);
  EXPECT_EQ(in("m", "0e99999999999999999999 km"), 0.0);
  EXPECT_EQ(in("m", "0.000e400 km"), 0.0);
  EXPECT_EQ(in("m", "1e310 pm"), 1e298);
}

// ---- scenes

Scene scene_with(const std::vector<std::string>& changes) {
  return parse_scene(quick_scene, "s.toml", changes);
}

std::string refusal_with(const std::string& change) {
  try {
    scene_with({change});
  } catch (const RequestError& fault) {
    const std::string text = fault.what(), one = "s.toml: 1 fault\n--set " + change + ": ";
    return text.starts_with(one) ? text.substr(one.size()) : text;
  }
  return "nothing was refused";
}

/// All keys with a unit, by their paths.
void find_units(const std::vector<KeyFacts>& keys, const std::string& path,
                std::vector<std::pair<std::string, std::string>>& found) {
  for (const KeyFacts& key : keys) {
    const std::string here = path.empty() ? key.name : path + "." + key.name;
    if (!key.unit.empty()) found.emplace_back(here, key.unit);
    find_units(key.inner, here, found);
  }
}

TEST(SceneUnits, EveryUnitOfAKeyHasAnExampleThatReads) {
  std::vector<std::pair<std::string, std::string>> found;
  find_units(scene_sections(), "", found);
  EXPECT_GT(found.size(), 40u);
  for (const auto& [path, unit] : found) {
    const std::string examples = quantity_examples(unit);
    const std::size_t begin = examples.find('"') + 1, end = examples.find('"', begin);
    EXPECT_THAT(fault_in(unit, examples.substr(begin, end - begin)), HasSubstr("read as")) << path;
    EXPECT_THAT(examples, HasSubstr("(")) << path << ": " << unit << " is of no known kind";
    EXPECT_EQ(in(unit, "1 " + unit), 1.0) << path;
  }
}

/// A scene in other units is the same run: its text, which a result keeps, and its key.
TEST(SceneUnits, AreTheSameRun) {
  const Scene plain = scene_with({});
  const Scene units = scene_with(
      {"scene.duration=2 ms", "scene.speed=\"100 mm/s\"", "scene.start=2 cm", "scene.spacing=20 um",
       "resonator.length=60 mm", "resonator.thickness=1mm", "resonator.width=2 cm",
       "resonator.young=210 GPa", "resonator.density=7.8 g/cm^3", "slider.young=210e3 N/mm^2",
       "resonator.surface={ kind = \"gaussian\", rq = \"3 um\", rsm = \"0.5 mm\", seed = 2 }",
       "slider.surface.rq=3 \u00B5m", "slider.surface.rsm=500 \u03BCm", "slider.load=1 weight",
       "contact.stiffness=10 MPa/um", "time.step=200 ns", "output.rate=100 kHz"});
  EXPECT_EQ(echo(units), echo(plain));
  EXPECT_EQ(run_key(make_model(units)), run_key(make_model(plain)));
  EXPECT_EQ(echo(scene_with({"output.probes=[\"10 mm\", 0.02, \"3 cm\"]"})),
            echo(scene_with({"output.probes=[0.01, 0.02, 0.03]"})));
}

TEST(SceneUnits, TheProgramKnowsTheResultOfTheOtherUnit) {
  const Folder folder;
  std::ofstream(folder.path() / "quick.toml") << quick_scene;
  ASSERT_EQ(run_program(folder.path(), {program(), "run", "quick.toml"}).status, 0);
  const Ended again = run_program(
      folder.path(), {program(), "run", "quick.toml", "--set", "scene.speed=100 mm/s", "--set",
                      "resonator.young=210 GPa", "--set", "slider.surface.rq=3 \u00B5m"});
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.out, HasSubstr("has this run already, complete"));
}

TEST(SceneUnits, AFaultSaysWhatStandsAndWhatIsExpected) {
  EXPECT_EQ(refusal_with("resonator.length=500 kg"),
            "resonator.length: \"500 kg\" is a mass, not a length: expected a number > 0 (m), or "
            "with its unit, such as \"500 mm\" (mm, um, nm, cm, m)");
  EXPECT_EQ(refusal_with("resonator.young=210 Gpa"),
            "resonator.young: \"210 Gpa\" has the unknown unit \"Gpa\" (did you mean \"GPa\"?): "
            "expected a number > 0 (Pa), or with its unit, such as \"210 GPa\" (GPa, MPa, kPa, Pa, "
            "N/mm^2)");
  EXPECT_EQ(refusal_with("resonator.damping=2 %"),
            "resonator.damping: \"2 %\" is in per cent: write 0.02: expected a number in [0, 1)");
  EXPECT_EQ(refusal_with("time.tolerance=1e-6 m"),
            "time.tolerance: \"1e-6 m\" has a unit, and this number has none: expected a number > "
            "0");
  EXPECT_EQ(refusal_with("resonator.thickness=-3 mm"),
            "resonator.thickness: \"-3 mm\" is not allowed: expected a number > 0 (m)");
  EXPECT_EQ(refusal_with("resonator.length=nan m"),
            "resonator.length: \"nan m\" is not allowed: expected a number > 0 (m)");
  EXPECT_THAT(refusal_with("resonator.length=1e400 m"), HasSubstr("is too large to compute with"));
  EXPECT_THAT(refusal_with("resonator.length=1e-400 m"), HasSubstr("expected a number > 0 (m)"));
  EXPECT_THAT(refusal_with("resonator.length=\"5\""), HasSubstr("is a text without a unit"));
  EXPECT_THAT(refusal_with("scene.gap=touchin"),
              HasSubstr("\"touchin\" is not allowed: expected a number (m) or \"touching\""));
  EXPECT_THAT(refusal_with("output.probes=[\"3 kg\"]"),
              HasSubstr("output.probes[0]: \"3 kg\" is a"));
  EXPECT_THAT(refusal_with("resonator.modes=3 m"), HasSubstr("expected an integer"));
  EXPECT_THAT(refusal_with("resonator.length=" + std::string(1 << 20, '5') + " mm"),
              AllOf(HasSubstr("is too long"), testing::SizeIs(testing::Lt(1000u))));
  EXPECT_THAT(refusal_with("resonator.length=\"5 m\\u0000m\""), HasSubstr("unknown unit"));
}

/// TOML has other bases for integers alone, and "_" between digits for both.
TEST(SceneUnits, ANumberStandsInDecimals) {
  EXPECT_EQ(refusal_with("scene.speed=0x10"),
            "scene.speed: 0x10 is not allowed: expected a number >= 0 (m/s), in decimals");
  EXPECT_THAT(refusal_with("scene.speed=0o17"), HasSubstr("0o17 is not allowed"));
  EXPECT_THAT(refusal_with("scene.speed=0b11"), HasSubstr("0b11 is not allowed"));
  EXPECT_THAT(refusal_with("scene.speed=0x10 m/s"), HasSubstr("is not in decimals"));
  EXPECT_EQ(scene_with({"contact.stiffness=1_000_000"}).contact.stiffness, 1e6);
  EXPECT_EQ(scene_with({"resonator.surface.seed=0x10"}).resonator.surface.seed, 16u);
}

TEST(SceneUnits, ALoadIsInNewtonsOrWeights) {
  EXPECT_EQ(scene_with({"slider.load=5 N"}).slider.load, 5.0);
  EXPECT_FALSE(scene_with({"slider.load=5 N"}).slider.load_is_weight);
  const Scene one = scene_with({}), two = scene_with({"slider.load=2 weight"});
  EXPECT_TRUE(two.slider.load_is_weight);
  EXPECT_EQ(make_model(two).slider.load_force, 2 * make_model(one).slider.load_force);
  EXPECT_NEAR(make_model(two).slider.load_force, 2 * 7800 * 0.01 * 4e-3 * 0.02 * 9.80665, 1e-12);
  EXPECT_THAT(echo(two), HasSubstr("load = \"2 weight\"\n"));
  EXPECT_EQ(echo(parse_scene(echo(two), "s.toml", {})), echo(two));
  EXPECT_EQ(echo(scene_with({"slider.load=1 weights"})), echo(one));
  for (const char* wrong : {"0 weight", "-1 weight", "1e400 weight"})
    EXPECT_THAT(refusal_with(std::string("slider.load=") + wrong), HasSubstr("slider.load: "))
        << wrong;
  EXPECT_THAT(refusal_with("slider.load=2 wieght"), HasSubstr("unknown unit"));
  EXPECT_THAT(refusal_with("scene.speed=2 weight"), HasSubstr("unknown unit"));
  EXPECT_THAT(refusal_with("scene.gap=2 touching"), HasSubstr("unknown unit"));
}

TEST(SceneUnits, OfAMemberThatIsDoubtedStandInTheCure) {
  const std::vector<std::string> doubts =
      make_model(scene_with({"slider.density=8.5 kg/m^3", "resonator.thickness=3 m"})).doubts;
  EXPECT_THAT(doubts, testing::Contains(AllOf(HasSubstr("slider.density = 8.5 kg/m^3"),
                                              HasSubstr("Then write \"8.5 g/cm^3\""))));
  EXPECT_THAT(doubts, testing::Contains(AllOf(HasSubstr("resonator.thickness = 3 m"),
                                              HasSubstr("Then write \"3 mm\""))));
}

// ---- studies

TEST(StudyUnits, AnAxisKeepsSiNumbers) {
  const std::string head = "base = \"base.toml\"\n";
  Study units = parse_study(head +
                                "[set]\n\"scene.duration\" = \"1 ms\"\n[vary]\n"
                                "speed = { key = \"scene.speed\", values = [\"50 mm/s\", 0.1] }\n"
                                "rq = { keys = [\"slider.surface.rq\", \"slider.load\"], "
                                "values = [[\"3 um\", \"1 N\"], [\"4 um\", \"2 weight\"]] }\n",
                            "study.toml");
  ASSERT_EQ(units.dimensions.size(), 2u);
  EXPECT_FALSE(units.dimensions[0].is_text);
  EXPECT_THAT(units.dimensions[0].numbers, ElementsAre(0.05, 0.1));
  EXPECT_THAT(units.dimensions[1].numbers, ElementsAre(3e-6, 4e-6));
  Study plain = parse_study(head +
                                "[set]\n\"scene.duration\" = 1e-3\n[vary]\n"
                                "speed = { key = \"scene.speed\", values = [0.05, 0.1] }\n"
                                "rq = { keys = [\"slider.surface.rq\", \"slider.load\"], "
                                "values = [[3e-6, 1.0], [4e-6, \"2 weight\"]] }\n",
                            "study.toml");
  for (Study* study : {&units, &plain}) study->base_text = quick_scene;
  EXPECT_EQ(PointCensus(StudyPoints(units)).keys, PointCensus(StudyPoints(plain)).keys);
}

/// Loads in weights are numbers of the table, for the law; beside newtons they are texts.
TEST(StudyUnits, AnAxisMayCountWeights) {
  const auto axis = [](const std::string& values) {
    return parse_study("base = \"b.toml\"\n[vary]\nload = { key = \"slider.load\", values = [" +
                           values + "] }\n",
                       "study.toml")
        .dimensions.at(0);
  };
  const StudyDimension weights = axis("\"0.5 weight\", \"weight\", \"2 weights\"");
  EXPECT_TRUE(weights.in_weights);
  EXPECT_FALSE(weights.is_text);
  EXPECT_THAT(weights.numbers, ElementsAre(0.5, 1, 2));
  EXPECT_THAT(weights.texts, IsEmpty());
  EXPECT_EQ(weights.values[2][0], "\"2 weight\"");
  const StudyDimension mixed = axis("\"2 weight\", \"5 N\"");
  EXPECT_TRUE(mixed.is_text);
  EXPECT_THAT(mixed.texts, ElementsAre("2 weight", "5.0"));
  EXPECT_THAT(axis("\"weight\"").texts, ElementsAre("weight"));
  EXPECT_THROW(axis("\"weight\", \"1 weight\""), RequestError);
}

TEST(StudyUnits, OneNumberInTwoUnitsStandsTwice) {
  try {
    parse_study(
        "base = \"b.toml\"\n[vary]\n"
        "speed = { key = \"scene.speed\", values = [\"50 mm/s\", 0.05] }\n",
        "study.toml");
    FAIL();
  } catch (const RequestError& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("0.05 stands twice"));
  }
}

TEST(StudyUnits, AWrongUnitIsRefusedWithTheScene) {
  for (const auto& [value, fault] :
       {std::pair{"\"50 mm\"", "\"50 mm\" is a length, not a speed"},
        {"0x10", "0x10 is not allowed: expected a number >= 0 (m/s), in decimals"}}) {
    Study study = parse_study(fmt::format("base = \"b.toml\"\n[vary]\n"
                                          "speed = {{ key = \"scene.speed\", values = [{}] }}\n",
                                          value),
                              "study.toml");
    study.base_text = quick_scene;
    try {
      PointCensus census{StudyPoints(study)};
      FAIL() << value;
    } catch (const RequestError& refused) {
      EXPECT_THAT(refused.what(), HasSubstr(fault));
    }
  }
}

TEST(SecondsText, IsInTheUnitThatSuits) {
  for (const auto& [seconds, text] : {std::pair{2.5e-13, "0.25 ps"},
                                      {4e-8, "40 ns"},
                                      {0.25, "250 ms"},
                                      {119.0, "119 s"},
                                      {5400.0, "90 min"},
                                      {90 * 3600.0, "90 h"},
                                      {4.25 * 86400, "4.25 days"}})
    EXPECT_EQ(seconds_text(seconds), text);
}

}  // namespace
}  // namespace ra2d::test
