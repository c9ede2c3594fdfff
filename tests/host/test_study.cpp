// SPDX-License-Identifier: BSD-3-Clause
// Studies: the file, the ledger, and the results.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "host/analysis/distributions.hpp"
#include "host/base/errors.hpp"
#include "host/plan/expected_work.hpp"
#include "host/run/run_key.hpp"
#include "host/run/run_report.hpp"
#include "host/run/simulation.hpp"
#include "host/run/v_rms.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/study/law.hpp"
#include "host/study/study_advice.hpp"
#include "host/study/study_status.hpp"
#include "host/study/study_table.hpp"
#include "host/study/study_warnings.hpp"
#include "host/study/study_worker.hpp"
#include "host/system/partial_file.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"
#include "tests/reseal.hpp"
#include "tests/studies.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

template <class Call>
std::string refusal_of(Call call) {
  try {
    call();
  } catch (const RequestError& fault) {
    return fault.what();
  } catch (const FileError& fault) {
    return std::string("file: ") + fault.what();
  }
  return "nothing was refused";
}

Study study_of(const std::string& text, const std::vector<std::string>& given = {}) {
  Study study = parse_study(text, "study.toml", given);
  study.base_text = test::quick_scene;
  return study;
}

const std::string two_by_three = R"(
base = "base.toml"
seeds = 2
[vary]
speed = { key = "scene.speed", values = [0.1, 0.2, 0.4] }
rq = { keys = ["resonator.surface.rq", "slider.surface.rq"], values = [[3e-6, 4e-6], 5e-6] }
)";

// ---- the file ----------------------------------------------------------------------------------

TEST(StudyFile, DimensionsStandInTheOrderOfTheFile) {
  const Study study = parse_study(two_by_three, "/there/study.toml");
  EXPECT_EQ(study.base, "/there/base.toml");
  EXPECT_THAT(study.seeds, ElementsAre(0, 1));
  ASSERT_EQ(study.dimensions.size(), 2u);
  EXPECT_EQ(study.dimensions[0].name, "speed");
  EXPECT_THAT(study.dimensions[0].numbers, ElementsAre(0.1, 0.2, 0.4));
  EXPECT_EQ(study.dimensions[1].name, "rq");
  // the first of a list is the coordinate; one value stands for all keys
  EXPECT_THAT(study.dimensions[1].numbers, ElementsAre(3e-6, 5e-6));
  EXPECT_THAT(study.dimensions[1].values[0], ElementsAre("3e-06", "4e-06"));
  EXPECT_THAT(study.dimensions[1].values[1], ElementsAre("5e-06", "5e-06"));
}

TEST(StudyFile, SetTakesKeysWithDotsAndSections) {
  const Study study = parse_study(R"(
base = "b.toml"
[set]
"time.scheme" = "heun"
scene.speed = 0.3
[set.contact]
stiffness = 1e12
[set.slider]
surface = { kind = "flat" }
)",
                                  "s.toml");
  EXPECT_THAT(study.set, testing::UnorderedElementsAre("time.scheme=\"heun\"", "scene.speed=0.3",
                                                       "contact.stiffness=1e12",
                                                       "slider.surface={ kind = \"flat\" }"));
  EXPECT_THAT(study.seeds, ElementsAre(0));
}

TEST(StudyFile, EveryFaultIsNamedAtOnceWithItsLine) {
  const std::string fault = refusal_of([] {
    parse_study(R"(bas = "b.toml"
seeds = 0
keep = ["levels"]
[set]
"time.scheme" = "rk4"
speed = 3
[vary]
level = { key = "scene.speed", values = [1] }
a = { key = "scene.start", values = [] }
b = { key = "scene.gap", values = [1e-6, 1e-6] }
c = { key = "time.scheme", values = ["heun"] }
d = { key = "scene.speed", values = [2] }
e = { keys = ["contact.stiffness"], values = [1, true] }
"f-g" = { key = "slider.load", values = [1] }
h = { keys = ["slider.young", "resonator.young"], values = [[1, 2, 3]] }
i = { key = "slider.density", value = [1] }
j = { key = "slider.damping", values = [nan] }
)",
                "s.toml");
  });
  EXPECT_THAT(fault, HasSubstr("s.toml:1: bas: unknown key (did you mean `base`?)"));
  EXPECT_THAT(fault, HasSubstr("base: missing"));
  EXPECT_THAT(fault, HasSubstr("s.toml:2: seeds: 0 is not allowed"));
  EXPECT_THAT(fault, HasSubstr("s.toml:3: keep: [\"levels\"] is not allowed"));
  EXPECT_THAT(fault, HasSubstr("s.toml:6: set.speed: names no key"));
  EXPECT_THAT(fault, HasSubstr("s.toml:8: vary.level: is a name that the table has for itself"));
  EXPECT_THAT(fault, HasSubstr("s.toml:9: vary.a.values: [] is not allowed"));
  EXPECT_THAT(fault, HasSubstr("s.toml:10: vary.b.values: 1e-06 stands twice"));
  EXPECT_THAT(fault, HasSubstr("s.toml:11: vary.c.key: time.scheme is set by [set] already"));
  EXPECT_THAT(fault, HasSubstr("s.toml:12: vary.d.key: scene.speed is set by vary.level already"));
  EXPECT_THAT(fault, HasSubstr("s.toml:13: vary.e.values: true is not allowed: expected finite"));
  EXPECT_THAT(fault, HasSubstr("s.toml:14: vary.f-g: is no name of a dimension"));
  EXPECT_THAT(fault, HasSubstr("s.toml:15: vary.h.values: [1, 2, 3] has 3 values: expected 2"));
  EXPECT_THAT(fault, HasSubstr("vary.i.value: unknown key (did you mean `values`?)"));
  EXPECT_THAT(fault, HasSubstr("s.toml:17: vary.j.values: nan is not allowed"));
}

/// A name of the table's own columns; those of sound where it has them.
TEST(StudyFile, NamesOfColumnsAreTaken) {
  const std::string vary =
      "base = \"b.toml\"\n{}\n[vary]\n{} = {{ key = \"scene.speed\", values = [1, 2] }}\n";
  const auto study = [&](const std::string& keep, const std::string& name) {
    return parse_study(fmt::format(fmt::runtime(vary), keep, name), "s.toml");
  };
  EXPECT_EQ(study("", "lp").dimensions.size(), 1u);
  EXPECT_EQ(study("", "level_of_noise").dimensions.size(), 1u);
  for (const char* name : {"v_rms", "runs", "lv", "level_low", "level_mean_dB"})
    EXPECT_THROW(study("", name), RequestError) << name;
  for (const char* name : {"lp", "lwa_high_dB"})
    EXPECT_THROW(study("keep = [\"sound\"]", name), RequestError) << name;
}

/// HDF5 would cut it there.
TEST(StudyFile, ATextWithTheEndOfTextsIsRefused) {
  const std::string vary =
      "base = \"b.toml\"\n[vary]\nf = {{ key = \"slider.surface.path\", values = [{}] }}\n";
  for (const char* values : {R"("a\u0000b")", R"("a", "\u0000")", R"(["b", "a\u0000"])"})
    EXPECT_THAT(refusal_of([&] { parse_study(fmt::format(fmt::runtime(vary), values), "s.toml"); }),
                HasSubstr("s.toml:3: vary.f.values: \""))
        << values;
  EXPECT_THAT(
      refusal_of([&] { parse_study(fmt::format(fmt::runtime(vary), R"("a\u0000b")"), "s.toml"); }),
      HasSubstr("1 fault\ns.toml:3: vary.f.values: \"a\\u0000b\" holds U+0000"));
}

TEST(StudyFile, AnEmptyBaseIsRefused) {
  EXPECT_THAT(refusal_of([] { parse_study("base = \"\"", ""); }),
              HasSubstr("base: is empty: expected the scene's file"));
}

TEST(StudyFile, TooManyRunsAreRefusedBeforeTheyAreCounted) {
  std::string values = "1";
  for (int i = 2; i <= 1001; ++i) values += fmt::format(", {}", i);
  EXPECT_THAT(refusal_of([&] {
                parse_study(
                    fmt::format("base = \"b\"\n[vary]\na = {{ key = \"scene.speed\", values = "
                                "[{0}] }}\nb = {{ key = \"scene.start\", values = [{0}] }}\n",
                                values),
                    "s.toml");
              }),
              HasSubstr("asks for 1e+06 runs: expected at most 1000000"));
}

TEST(StudyFile, WhatItVariesCannotBeSetBeside) {
  EXPECT_THAT(refusal_of([] { parse_study(two_by_three, "s.toml", {"scene.speed = 1"}); }),
              AllOf(HasSubstr("vary.speed varies this key"), HasSubstr("--set scene.speed")));
  EXPECT_NO_THROW(parse_study(two_by_three, "s.toml", {"scene.duration=1"}));
}

TEST(StudyFile, ASnapshotReadsAsTheSameStudy) {
  const Study study = study_of(two_by_three, {"scene.duration=1e-3"});
  const Study again = parse_snapshot(snapshot_text(study), "study.json");
  EXPECT_EQ(again.text, study.text);
  EXPECT_EQ(again.base, study.base);
  EXPECT_EQ(again.base_text, study.base_text);
  EXPECT_EQ(again.given, study.given);
  EXPECT_EQ(PointCensus(StudyPoints(again)).keys, PointCensus(StudyPoints(study)).keys);
  const std::string text = snapshot_text(study);
  for (std::size_t size = 0; size + 2 < text.size(); size += 7)  // whole up to the last line end
    EXPECT_THAT(refusal_of([&] { parse_snapshot(text.substr(0, size), "study.json"); }),
                HasSubstr("file: 'study.json' is damaged"));
}

TEST(StudyFile, WhateverIsTypedIsReadOrRefused) {
  const std::string fine = two_by_three + "[set]\ntime.scheme = \"heun\"\n";
  std::mt19937_64 dice(3);
  const std::string pieces[] = {"[",  "]",    "{",     "}",  "\"", "=",      ".",          "\n",
                                "#",  "-1",   "nan",   "''", ",",  "values", "1e400",      "key",
                                "[[", "\xff", "seeds", "\0", "0x", "inf",    "[vary.a]\n", "keys"};
  int read = 0, refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string text = fine;
    for (std::uint64_t edits = 1 + dice() % 3; edits > 0; --edits) {
      const std::size_t at = dice() % text.size();
      const std::size_t cut = dice() % 3 == 0 ? dice() % 30 : dice() % 2;
      text.replace(at, cut, pieces[dice() % std::size(pieces)]);
    }
    try {
      const StudyPoints points(parse_study(text, "s.toml"));
      EXPECT_GE(points.size(), 1u);
      points.name(points.size() - 1);
      ++read;
    } catch (const RequestError& fault) {
      EXPECT_THAT(fault.what(), testing::StartsWith("s.toml: "));
      ++refused;
    }
  }
  EXPECT_GT(read, 200);
  EXPECT_GT(refused, 200);
  for (const char* part : {"[", "{a=", "[["}) {
    std::string deep = "base = \"b\"\n[set]\nx.y = ";
    for (int i = 0; i < 100'000; ++i) deep += part;
    EXPECT_THAT(refusal_of([&] { parse_study(deep, "s.toml"); }), HasSubstr("s.toml: "));
  }
}

TEST(StudyFile, OfTheScenesFolderAreAllFine) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(test::source_folder() / "scenes")) {
    if (entry.path().extension() != ".toml" ||
        test::read_file(entry.path()).find("\nbase ") == std::string::npos)
      continue;
    SCOPED_TRACE(entry.path().filename());
    const StudyPoints points(read_study(entry.path()));
    EXPECT_EQ(PointCensus(points).different().size(), points.size());
    ++count;
  }
  EXPECT_GE(count, 2);
}

// ---- the points --------------------------------------------------------------------------------

TEST(StudyPoints, EveryCombinationStandsOnceInCOrderWithTheSeedLast) {
  const StudyPoints points(study_of(two_by_three));
  ASSERT_EQ(points.size(), 12u);
  std::size_t point = 0;
  for (const double speed : {0.1, 0.2, 0.4})
    for (const auto& [resonator, slider] : {std::pair{3e-6, 4e-6}, std::pair{5e-6, 5e-6}})
      for (const std::uint64_t k : {0, 1}) {
        const Scene scene = points.scene(point++);
        EXPECT_EQ(scene.speed, speed);
        EXPECT_EQ(scene.resonator.surface.rq, resonator);
        EXPECT_EQ(scene.slider.surface.rq, slider);
        EXPECT_EQ(scene.resonator.surface.seed, 2 + 1000 * k);
        EXPECT_EQ(scene.slider.surface.seed, 1 + 1000 * k);
      }
  EXPECT_EQ(points.name(3), "speed = 0.1, rq = 5e-06, seed 1");
}

TEST(StudyPoints, ACensusOnAllThreadsIsThatOfEachPoint) {
  std::string values;
  for (int i = 0; i < 300; ++i) values += fmt::format("{}{}", i > 0 ? ", " : "", 1e-6 * (i + 1));
  const StudyPoints points(
      study_of("base = \"b\"\nseeds = 3\n[vary]\nrq = { key = "
               "\"slider.surface.rq\", values = [" +
               values + "] }\n"));
  const PointCensus census(points);
  FileHashes files;
  ASSERT_EQ(census.keys.size(), 900u);
  for (std::size_t i = 0; i < points.size(); i += 7) {
    EXPECT_EQ(census.keys[i], scene_key(points.scene(i), files)) << points.name(i);
    EXPECT_EQ(census.costs[i], static_cast<float>(expected_work(points.scene(i)).seconds()));
  }
  EXPECT_EQ(census.different().size(), 900u);
}

TEST(StudyPoints, TheLastWordIsTheCommandLines) {
  const std::string text = "base = \"b\"\n[set]\nscene.speed = 0.3\n";
  EXPECT_EQ(StudyPoints(study_of(text)).scene(0).speed, 0.3);
  EXPECT_EQ(StudyPoints(study_of(text, {"scene.speed=0.7"})).scene(0).speed, 0.7);
}

TEST(StudyPoints, ScenesThatAreWrongAreNamedBeforeAnythingRuns) {
  const StudyPoints points(study_of(R"(base = "b"
[vary]
speed = { key = "scene.speed", values = [0.1, -1, 0.2, -2] }
)"));
  const std::string fault = refusal_of([&] { PointCensus{points}; });
  EXPECT_THAT(fault, AllOf(HasSubstr("2 of 4 scenes are wrong"), HasSubstr("with speed = -1:"),
                           HasSubstr("with speed = -2:"), Not(HasSubstr("0.2")),
                           HasSubstr("the study's scene.speed=-1"), Not(HasSubstr("--set"))));
  EXPECT_THAT(refusal_of([] {
                PointCensus{StudyPoints(study_of("base = \"b\"\n[set]\ntime.schem = 1\n"))};
              }),
              HasSubstr("did you mean `scheme`?"));
}

TEST(SceneKey, KnowsWhatDecidesTheBitsAndNothingElse) {
  const test::Folder folder;
  FileHashes files;
  const Scene scene = parse_scene(test::quick_scene, folder.path() / "a.toml");
  const Key128 key = scene_key(scene, files);
  EXPECT_EQ(to_key(key_text(key)), key);
  const auto changed = [&](auto change) {
    Scene other = scene;
    change(other);
    FileHashes read_anew;
    return scene_key(other, read_anew) != key;
  };
  EXPECT_FALSE(changed([](Scene& s) { s.name = "another"; }));
  EXPECT_FALSE(changed([](Scene& s) { s.file = "/elsewhere/b.toml"; }));
  EXPECT_FALSE(changed([](Scene& s) { s.time.step *= 2; }));  // adaptive takes none
  EXPECT_TRUE(changed([](Scene& s) { s.time.tolerance = 1e-7; }));
  EXPECT_TRUE(changed([](Scene& s) { s.speed = std::nextafter(s.speed, 1.0); }));
  EXPECT_TRUE(changed([](Scene& s) { s.slider.surface.seed ^= 1; }));
  EXPECT_TRUE(changed([](Scene& s) { std::swap(s.slider.surface, s.resonator.surface); }));
  EXPECT_TRUE(changed([](Scene& s) { s.slider.load_is_weight = false; }));
  EXPECT_FALSE(changed([](Scene& s) { s.air.celsius = 0; }));

  // what microphones hear is kept, too
  const auto with_sound = [&](auto change) {
    Scene other = scene;
    change(other);
    return scene_key(other, files, true);
  };
  const auto hears = [](double z) {
    return [z](Scene& s) { s.output.microphones = {{0.1, 0.05, z}}; };
  };
  EXPECT_EQ(with_sound([](Scene&) {}), key);
  EXPECT_NE(with_sound([](Scene& s) { s.air.celsius = 0; }), key);
  EXPECT_NE(with_sound([](Scene& s) { s.air.pascal = 5e4; }), key);
  EXPECT_EQ(with_sound(hears(0.5)), with_sound(hears(0.5)));
  EXPECT_NE(with_sound(hears(0.5)), with_sound(hears(0.25)));

  const auto write = [&](const char* name, const char* text) {
    std::ofstream(folder.path() / name) << text;
  };
  const auto of_file = [&](const char* name) {
    Scene other = scene;
    other.slider.surface.kind = SurfaceKind::file;
    other.slider.surface.path = name;
    FileHashes read_anew;
    return scene_key(other, read_anew);
  };
  write("one.csv", "0,0\n1e-3,1e-6\n");
  write("two.csv", "0,0\n1e-3,1e-6\n");
  const Key128 first = of_file("one.csv");
  EXPECT_EQ(of_file("two.csv"), first) << "its numbers count, not its name";
  write("two.csv", "0,0\n1e-3,2e-6\n");
  EXPECT_NE(of_file("two.csv"), first);
  EXPECT_THAT(refusal_of([&] { of_file("none.csv"); }), HasSubstr("cannot read the profile"));
}

TEST(SceneKey, KeysThatAreNotUsedChangeNoBit) {
  const Scene scene = parse_scene(test::quick_scene, "a.toml");
  Scene other = scene;
  other.time.step *= 3;  // adaptive finds its own
  const Model a = make_model(scene), b = make_model(other);
  EXPECT_EQ(a.tick, b.tick);
  EXPECT_EQ(a.steps, b.steps);
}

/// Where a stiffness comes from changes no bit: its number does.
TEST(SceneKey, HertzIsTheNumberThatItTakes) {
  FileHashes files;
  const auto key = [&](const std::vector<std::string>& changes) {
    return scene_key(parse_scene(test::quick_scene, "a.toml", changes), files);
  };
  const Scene hertz = parse_scene(test::quick_scene, "a.toml", {"contact.stiffness=hertz"});
  const std::string number = fmt::format("contact.stiffness={:.17g}", hertz.contact.stiffness);
  EXPECT_EQ(key({"contact.stiffness=hertz"}), key({number}));
  EXPECT_EQ(key({number}), key({number, "slider.poisson=0.2"}));
  EXPECT_NE(key({"contact.stiffness=hertz"}),
            key({"contact.stiffness=hertz", "slider.poisson=0.2"}));
  const auto run = [](const std::string& change) {
    return run_key(make_model(parse_scene(test::quick_scene, "a.toml", {change})));
  };
  EXPECT_EQ(run("contact.stiffness=hertz"), run(number));
}

TEST(StudyPoints, SeedsThatChangeNothingAreRefused) {
  const auto refused = [](const std::string& text) {
    const StudyPoints points(study_of(text));
    return refusal_of([&] { require_other_seeds(points, PointCensus(points)); });
  };
  const std::string flat = "slider.surface = { kind = \"flat\" }\n";
  // one random face is enough, and so is one seed
  EXPECT_EQ(refused("base = \"b\"\nseeds = 5\n[set]\n" + flat), "nothing was refused");
  EXPECT_EQ(refused("base = \"b\"\nseeds = 1\n[set]\n" + flat + "resonator" + flat.substr(6)),
            "nothing was refused");
  // of several combinations the one without
  EXPECT_THAT(refused("base = \"b\"\nseeds = 5\n[set]\n" + flat +
                      "[vary]\nkind = { key = \"resonator.surface.kind\", values = [\"gaussian\", "
                      "\"flat\"] }\n"),
              AllOf(HasSubstr("of the scene with kind = \"flat\": neither face is random"),
                    HasSubstr("Expected seeds = 1")));
}

TEST(StudyPoints, ADimensionThatChangesNothingIsDoubted) {
  const auto said = [](const std::string& vary, const std::string& set = "") {
    const StudyPoints points(
        study_of("base = \"b\"\n[set]\ncontact.stiffness = \"hertz\"\n" + set + "[vary]\n" + vary));
    return study_doubts(points, PointCensus(points));
  };
  const std::string step = "step = { key = \"time.step\", values = [1e-8, 1e-7] }\n",
                    speed = "speed = { key = \"scene.speed\", values = [0.1, 0.2, 0.3] }\n";
  for (const std::string& vary : {step, step + speed, speed + step})
    EXPECT_THAT(said(vary, "time.scheme = \"adaptive\"\n"),
                ElementsAre(AllOf(HasSubstr("vary.step: time.step changes nothing"),
                                  HasSubstr("one run"))));
  EXPECT_THAT(said(speed), testing::IsEmpty());
  // some of the combinations are enough
  EXPECT_THAT(
      said("scheme = { key = \"time.scheme\", values = [\"adaptive\", \"midpoint\"] }\n" + step),
      testing::IsEmpty());
}

TEST(StudyPoints, DoubtsAreSaidOnceForAllScenes) {
  const auto said = [](const std::string& text) {
    const StudyPoints points(study_of(text));
    return study_doubts(points, PointCensus(points));
  };
  const std::vector<std::string> one = said(
      "base = \"b\"\nseeds = 3\n[set]\nslider.density = 8.5\ncontact.stiffness = \"hertz\"\n"
      "[vary]\nspeed = { key = \"scene.speed\", values = [0.1, 0.2] }\n");
  ASSERT_EQ(one.size(), 1u) << fmt::format("{}", fmt::join(one, "\n"));
  EXPECT_THAT(one[0], HasSubstr("slider.density = 8.5"));
  EXPECT_THAT(said("base = \"b\"\n[set]\ncontact.stiffness = \"hertz\"\n[vary]\n"
                   "rho = { key = \"slider.density\", values = [7800, 7.8] }\n"),
              ElementsAre(HasSubstr("slider.density = 7.8")));
}

TEST(StudyPoints, ScenesWithoutASeedAreOneRunForAllSeeds) {
  const PointCensus census(
      StudyPoints(study_of("base = \"b\"\nseeds = 5\n[set]\nslider.surface = { kind = \"flat\" }\n"
                           "resonator.surface = { kind = \"flat\" }\n")));
  EXPECT_FALSE(census.has_seeds);
  EXPECT_THAT(census.different(), ElementsAre(0));
  EXPECT_THAT(refusal_of([&] {
                require_other_seeds(StudyPoints(study_of(
                                        "base = \"b\"\nseeds = 5\n[set]\nslider.surface = { kind = "
                                        "\"flat\" }\nresonator.surface = { kind = \"flat\" }\n")),
                                    census);
              }),
              AllOf(HasSubstr("seeds: 5 runs of each combination"), HasSubstr("Expected seeds = 1"),
                    HasSubstr("slider.surface.path")));
  EXPECT_TRUE(PointCensus(StudyPoints(study_of(two_by_three))).has_seeds);
}

// ---- the ledger --------------------------------------------------------------------------------

FinishedRun some_run(std::uint64_t number) {
  FinishedRun run;
  run.scene = {number, ~number};
  run.run = {7 * number, 11};
  run.figures.v_rms = 1e-3 * static_cast<double>(number);
  run.figures.wall_seconds = 0.25;
  run.point = fmt::format("speed = {}", number);
  if (number % 3 == 0) {
    run.status = RunStatus::refused;
    run.message = "no\nreason";
  }
  return run;
}

bool same_run(const FinishedRun& a, const FinishedRun& b) {
  return agree(a, b) && a.figures.wall_seconds == b.figures.wall_seconds && a.point == b.point &&
         a.message == b.message;
}

TEST(Ledger, WhatIsAppendedIsReadBack) {
  const test::Folder folder;
  const fs::path file = folder.path() / "all.log";
  {
    LedgerWriter ledger(file);
    for (std::uint64_t i = 1; i <= 5; ++i) ledger.append(some_run(i));
    ledger.sync();
  }
  {
    LedgerWriter ledger(file);
    ledger.append(some_run(6));
  }
  const ParsedLedger parsed = parse_ledger(test::read_file(file), file);
  ASSERT_EQ(parsed.runs.size(), 6u);
  EXPECT_EQ(parsed.whole, fs::file_size(file));
  for (std::uint64_t i = 1; i <= 6; ++i) EXPECT_TRUE(same_run(parsed.runs[i - 1], some_run(i)));
}

/// A record without sound has the bytes of older programs; of two records of a run the one with
/// its sound counts, in either order.
TEST(Ledger, SoundIsAddedToARun) {
  const test::Folder folder;
  const FinishedRun silent = some_run(1);
  FinishedRun heard = silent;
  heard.sound = {60, 58.5, 70, quiet_nan};
  EXPECT_EQ(record_of(heard).size(), record_of(silent).size() + 32);
  for (const bool first : {true, false}) {
    const std::string bytes =
        ledger_head() + record_of(first ? heard : silent) + record_of(first ? silent : heard);
    FinishedRuns finished;
    for (FinishedRun& run : parse_ledger(bytes, "x.log").runs) finished.add(run, "x.log");
    const FinishedRun* found = finished.find(silent.scene);
    ASSERT_TRUE(found != nullptr && found->sound);
    EXPECT_EQ(found->sound->lp_a, 58.5);
    EXPECT_TRUE(std::isnan(found->sound->lw_a));
  }
}

TEST(Ledger, EveryTruncationKeepsTheWholeRecordsBeforeIt) {
  const test::Folder folder;
  const fs::path file = folder.path() / "all.log";
  std::string bytes = ledger_head();
  std::vector<std::size_t> ends;
  for (std::uint64_t i = 1; i <= 3; ++i) {
    bytes += record_of(some_run(i));
    ends.push_back(bytes.size());
  }
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const auto whole = static_cast<std::size_t>(
        std::count_if(ends.begin(), ends.end(), [&](std::size_t end) { return end <= size; }));
    for (const std::size_t zeros : {0, 1, 100}) {  // as a power cut may leave them
      const std::string torn = bytes.substr(0, size) + std::string(zeros, '\0');
      // a head of the file that is torn and followed by zeros is no beginning that we know
      if (zeros > 0 && size > 0 && size < ledger_head().size()) continue;
      if (zeros > 0 && std::find(ends.begin(), ends.end(), size) == ends.end() && size > 16 &&
          std::string_view(bytes).substr(size, zeros) != std::string(zeros, '\0') &&
          size + zeros <= bytes.size())
        continue;  // these are other bytes, not fewer: the next test's
      std::size_t found = 99;
      try {
        found = parse_ledger(torn, "x").runs.size();
      } catch (const FileError&) {
        // a record's head that is torn and filled with zeros is taken for damage, and said
        const std::size_t begun = size - (whole == 0 ? 16 : ends[whole - 1]);
        if (zeros > 0 && begun > 0) continue;
      }
      EXPECT_EQ(found, whole) << size << " bytes and " << zeros << " zeros";
    }
  }
  // the next writer cuts it off, and goes on behind it
  for (const std::size_t size : {std::size_t{3}, ends[0] + 1, ends[1] - 1, ends[2] - 17}) {
    std::ofstream(file, std::ios::binary) << bytes.substr(0, size);
    LedgerWriter(file).append(some_run(9));
    const ParsedLedger parsed = parse_ledger(test::read_file(file), file);
    ASSERT_FALSE(parsed.runs.empty());
    EXPECT_TRUE(same_run(parsed.runs.back(), some_run(9)));
    EXPECT_EQ(parsed.whole, fs::file_size(file));
  }
}

TEST(Ledger, NoFlippedBitIsBelieved) {
  std::string bytes = ledger_head();
  constexpr std::uint64_t runs = 3;
  for (std::uint64_t i = 1; i <= runs; ++i) bytes += record_of(some_run(i));
  int refused = 0, torn = 0;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string flipped = bytes;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    try {
      const ParsedLedger parsed = parse_ledger(flipped, "x");
      // only the last record can be taken for one that was written in part
      ASSERT_EQ(parsed.runs.size(), runs - 1) << "bit " << bit;
      for (std::uint64_t i = 1; i < runs; ++i)
        ASSERT_TRUE(same_run(parsed.runs[i - 1], some_run(i))) << "bit " << bit;
      ++torn;
    } catch (const FileError& fault) {
      EXPECT_THAT(fault.what(), HasSubstr("'x' is"));
      ++refused;
    }
  }
  const std::size_t last = record_of(some_run(runs)).size() - 16;  // its head is checked by itself
  EXPECT_EQ(torn, static_cast<int>(8 * last));
  EXPECT_GT(refused, torn);
}

TEST(Ledger, DamageInTheMiddleNamesItsPlaceAndACure) {
  std::string bytes = ledger_head();
  for (std::uint64_t i = 1; i <= 3; ++i) bytes += record_of(some_run(i));
  const std::size_t second = ledger_head().size() + record_of(some_run(1)).size();
  bytes[second + 30] ^= 1;
  EXPECT_THAT(refusal_of([&] { parse_ledger(bytes, "d/all.log"); }),
              AllOf(HasSubstr(fmt::format("'d/all.log' is damaged at byte {}", second)),
                    HasSubstr(fmt::format("truncate -s {} 'd/all.log'", second))));
  EXPECT_EQ(parse_ledger(bytes.substr(0, second), "d/all.log").runs.size(), 1u);
}

TEST(Ledger, HasOneWriter) {
  const test::Folder folder;
  const fs::path file = folder.path() / "all.log";
  const LedgerWriter first(file);
  EXPECT_THAT(refusal_of([&] { LedgerWriter second(file); }),
              HasSubstr("file: another process runs this part of the study"));
  EXPECT_NO_THROW(LedgerWriter(folder.path() / "shard-1-of-2.log"));
}

TEST(Ledger, WritesOnlyToARegularFileOfItsOwn) {
  const test::Folder folder;
  const fs::path text = folder.path() / "text.log", pipe = folder.path() / "pipe.log",
                 link = folder.path() / "link.log";
  std::ofstream(text) << "what somebody wrote, and would like to keep";
  EXPECT_THAT(refusal_of([&] { LedgerWriter{text}; }), HasSubstr("is no ledger of a study"));
  EXPECT_EQ(test::read_file(text), "what somebody wrote, and would like to keep");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(refusal_of([&] { LedgerWriter{pipe}; }), HasSubstr("is no regular file"));
  fs::create_symlink(text, link);
  EXPECT_THAT(refusal_of([&] { LedgerWriter{link}; }), HasSubstr("cannot write to"));
}

TEST(Ledger, RunsOfOneSceneWithOtherNumbersAreNamed) {
  FinishedRuns finished;
  FinishedRun run = some_run(1);
  finished.add(run, "a.log");
  run.figures.wall_seconds *= 2;
  EXPECT_NO_THROW(finished.add(run, "b.log"));
  run.figures.v_rms = std::nextafter(run.figures.v_rms, 1.0);
  EXPECT_THAT(refusal_of([&] { finished.add(run, "b.log"); }),
              AllOf(HasSubstr("other numbers: speed = 1"), HasSubstr("'b.log'")));
  // a failed one gives way to one that is done, and never the other way round
  FinishedRun failed = some_run(3), retried = some_run(3);
  retried.status = RunStatus::done;
  finished.add(failed, "a.log");
  finished.add(retried, "a.log");
  finished.add(failed, "b.log");
  EXPECT_EQ(finished.find(failed.scene)->status, RunStatus::done);
  EXPECT_EQ(finished.find(some_run(8).scene), nullptr);
}

// ---- the work ----------------------------------------------------------------------------------

/// A folder in which studies are run within the test.
class StudyRuns : public testing::Test {
 protected:
  StudyOutcome run(const Study& study, const Shard& shard = {}, bool retry_failed = false) {
    const StudyPoints points(study);
    const PointCensus census(points);
    where_.make();
    LedgerWriter ledger(where_.ledger(shard));
    FinishedRuns finished;
    finished.add(where_);
    const StudyWork work = find_work(census, finished, shard, retry_failed);
    return run_study(points, census, work, ledger);
  }
  /// The table's bytes, the times set to nothing.
  std::string table(const Study& study) {
    const StudyPoints points(study);
    FinishedRuns finished;
    finished.add(where_);
    for (auto& [key, run] : finished.runs) run.figures.wall_seconds = 0;
    write_study_table(where_.table(), points, PointCensus(points), finished);
    return test::read_file(where_.table());
  }
  const test::Folder temporary_;
  StudyFolder where_{temporary_.path() / "study"};
};

TEST_F(StudyRuns, AreThoseOfTheirScenesByThemselves) {
  const Study study = study_of(two_by_three);
  EXPECT_EQ(run(study).done, 12u);
  table(study);
  const StudyAnswers answers = read_study_table(where_.table());
  const StudyPoints points(study);
  for (const std::size_t point : {0, 5, 11}) {
    SceneRun alone(make_model(points.scene(point)), make_start(make_model(points.scene(point))));
    Simulation().run({&alone});
    EXPECT_EQ(answers.v_rms[point], report_on(alone, mean_squares(alone.model())).v_rms);
    EXPECT_GT(answers.v_rms[point], 0.0);
    FinishedRuns finished;
    finished.add(where_);
    EXPECT_EQ(key_text(finished.find(PointCensus(points).keys[point])->run),
              run_key(alone.model()));
  }
  EXPECT_EQ(run(study).done, 0u) << "they are done already";
}

TEST_F(StudyRuns, ATableKnowsNoShardsAndNoOrder) {
  const Study study = study_of(two_by_three);
  run(study);
  const std::string whole = table(study);
  where_.path = temporary_.path() / "shards";
  std::size_t done = 0;
  for (const int index : {3, 1, 2}) done += run(study, {index, 3}).done;
  EXPECT_EQ(done, 12u);
  EXPECT_TRUE(table(study) == whole);
  // one after the other, by hand
  const StudyPoints points(study);
  const PointCensus census(points);
  where_.path = temporary_.path() / "reversed";
  where_.make();
  LedgerWriter ledger(where_.ledger({}));
  for (std::size_t i = points.size(); i-- > 0;)
    run_study(points, census, {.jobs = {i}, .runs = 1}, ledger);
  EXPECT_TRUE(table(study) == whole);
}

TEST_F(StudyRuns, AnotherOrderOfValuesGivesTheSameNumbersAtTheSamePlaces) {
  run(study_of(two_by_three));
  table(study_of(two_by_three));
  const StudyAnswers there = read_study_table(where_.table());
  const Study turned = study_of(R"(
base = "base.toml"
seeds = [1, 0]
[vary]
rq = { keys = ["resonator.surface.rq", "slider.surface.rq"], values = [5e-6, [3e-6, 4e-6]] }
speed = { key = "scene.speed", values = [0.4, 0.1, 0.2] }
)");
  EXPECT_EQ(run(turned).done, 0u) << "an edited study runs what is new, and here nothing is";
  table(turned);
  const StudyAnswers here = read_study_table(where_.table());
  for (std::size_t rq = 0; rq < 2; ++rq)
    for (std::size_t speed = 0; speed < 3; ++speed)
      for (std::size_t seed = 0; seed < 2; ++seed)
        EXPECT_EQ(here.v_rms[(rq * 3 + speed) * 2 + seed],
                  there.v_rms[((speed + 2) % 3 * 2 + 1 - rq) * 2 + 1 - seed]);
}

TEST_F(StudyRuns, AnEditedStudyRunsWhatIsNewAlone) {
  run(study_of(two_by_three));
  const Study more =
      study_of(std::string(two_by_three).replace(two_by_three.find("0.4]"), 4, "0.3, 0.4]"));
  EXPECT_EQ(run(more).done, 4u);
  EXPECT_EQ(run(more).done, 0u);
}

TEST_F(StudyRuns, OneThatFailsIsRecordedAndStopsNothing) {
  // a step beyond the limit is refused; with force = true it is marched, and fails
  const Study study = study_of(R"(
base = "base.toml"
[vary]
how = { keys = ["time.scheme", "time.step", "time.force"], values = [["adaptive", 1, "x"]] }
)");
  EXPECT_THAT(refusal_of([&] { run(study); }), HasSubstr("time.force"));
  const Study failing = study_of(R"(
base = "base.toml"
[set]
time.scheme = "heun"
output.rate = 1e3
[vary]
step = { key = "time.step", values = [1e-7, 1e-4, 2e-7] }
)");
  const StudyOutcome outcome = run(failing);
  EXPECT_EQ(outcome.done, 2u);
  EXPECT_EQ(outcome.failed, 1u);
  ASSERT_EQ(outcome.failures.size(), 1u);
  EXPECT_EQ(outcome.failures[0].first, "step = 0.0001, seed 0");
  table(failing);
  StudyAnswers answers = read_study_table(where_.table());
  EXPECT_THAT(answers.status, ElementsAre(0, 2, 0));
  EXPECT_TRUE(std::isnan(answers.v_rms[1]));
  EXPECT_GT(answers.v_rms[2], 0);
  // it is not run again unless that is requested
  EXPECT_EQ(run(failing).failed, 0u);
  EXPECT_EQ(run(failing, {}, true).failed, 1u);

  Study forced = failing;
  forced.given = {"time.force=true"};
  EXPECT_EQ(run(forced).failed, 1u);
  table(forced);
  answers = read_study_table(where_.table());
  EXPECT_THAT(answers.status, ElementsAre(0, 3, 0));
  EXPECT_TRUE(std::isnan(answers.v_rms[1]));
}

TEST_F(StudyRuns, TheDearestComeFirstAndShardsShareThemOut) {
  const StudyPoints points(study_of(R"(
base = "base.toml"
seeds = 3
[vary]
duration = { key = "scene.duration", values = [1e-3, 3e-3, 2e-3, 4e-3] }
)"));
  const PointCensus census(points);
  const StudyWork all = find_work(census, {}, {}, false);
  EXPECT_THAT(all.jobs, ElementsAre(9, 10, 11, 3, 4, 5, 6, 7, 8, 0, 1, 2));
  std::set<std::size_t> seen;
  double least = 1e9, most = 0;
  for (int i = 1; i <= 3; ++i) {
    const StudyWork part = find_work(census, {}, {i, 3}, false);
    EXPECT_EQ(part.runs, 4u);
    seen.insert(part.jobs.begin(), part.jobs.end());
    least = std::min(least, part.cost);
    most = std::max(most, part.cost);
  }
  EXPECT_EQ(seen.size(), 12u);
  EXPECT_NEAR(most, least, 1e-9);
}

TEST_F(StudyRuns, KnowHowLongTheOthersWillTakeFromThoseThatAreDone) {
  const StudyPoints points(study_of(two_by_three));
  const PointCensus census(points);
  FinishedRuns finished;
  const double cost = static_cast<double>(census.costs[0]);
  finished.add({.scene = census.keys[0],
                .run = {},
                .status = RunStatus::done,
                .figures = {.v_rms = 1, .wall_seconds = 7 * cost},
                .point = {},
                .message = {}},
               "x");
  const StudyWork work = find_work(census, finished, {}, false);
  EXPECT_EQ(work.measured, 1u);
  EXPECT_EQ(work.done, 1u);
  EXPECT_NEAR(work.correction, 7, 1e-6);
  double left = 0;
  for (std::size_t i = 1; i < points.size(); ++i) left += 7 * static_cast<double>(census.costs[i]);
  EXPECT_NEAR(work.cost, left, 1e-6 * left);
}

TEST_F(StudyRuns, TenThousandAreReadAndPassedQuickly) {
  std::string values;
  for (int i = 0; i < 1000; ++i) values += fmt::format("{}{}", i > 0 ? ", " : "", 0.1 + 1e-5 * i);
  const Study study = study_of(fmt::format(
      "base = \"b\"\nseeds = 10\n[vary]\nspeed = {{ key = \"scene.speed\", values = [{}] }}\n",
      values));
  const StudyPoints points(study);
  where_.make();
  const auto begin = std::chrono::steady_clock::now();
  const PointCensus census(points);
  ASSERT_EQ(points.size(), 10'000u);
  {
    LedgerWriter ledger(where_.ledger({}));
    for (std::size_t i = 0; i < points.size(); ++i) {
      FinishedRun run = some_run(1);
      run.scene = census.keys[i];
      run.point = points.name(i);
      ledger.append(run);
    }
  }
  EXPECT_LT(fs::file_size(where_.ledger({})), 10'000u * 300);
  FinishedRuns finished;
  finished.add(where_);
  EXPECT_TRUE(find_work(census, finished, {}, false).jobs.empty());
  write_study_table(where_.table(), points, census, finished);
  const StudyAnswers answers = read_study_table(where_.table());
  EXPECT_EQ(std::count(answers.status.begin(), answers.status.end(), 0.0), 10'000);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(took.count(), 30) << "a second or two, unless something is done for all pairs";
}

TEST_F(StudyRuns, AnyTableThatIsNoneIsRefused) {
  where_.make();
  EXPECT_THAT(refusal_of([&] { read_study_table(where_.table()); }), HasSubstr("no such file"));
  std::ofstream(where_.table()) << "no HDF5";
  EXPECT_THAT(refusal_of([&] { read_study_table(where_.table()); }), HasSubstr("cannot read"));
  EXPECT_FALSE(is_study_table(where_.table()));
}

/// Forged: with a seal that fits.
TEST_F(StudyRuns, ATableOfAnotherFormatOrOfSenselessRatesIsRefused) {
  const Study study = study_of(
      "base = \"b\"\n[vary]\nspeed = { key = \"scene.speed\", values = [0.1, "
      "0.2] }\n");
  run(study);
  const std::string whole = table(study);
  const auto refusal_after = [&](const std::function<void(hid_t)>& change) {
    std::ofstream(where_.table(), std::ios::binary) << test::without_seal(whole);
    const hid_t file = H5Fopen(where_.table().c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    change(file);
    H5Fclose(file);
    test::reseal(where_.table());
    return refusal_of([&] { read_study_table(where_.table()); });
  };
  EXPECT_EQ(refusal_after([](hid_t) {}), "nothing was refused");
  EXPECT_THAT(refusal_after([](hid_t file) {
                const hid_t format = H5Aopen(file, "study_format", H5P_DEFAULT);
                const std::int64_t next = study_format + 1;
                H5Awrite(format, H5T_NATIVE_INT64, &next);
                H5Aclose(format);
              }),
              HasSubstr("it has format 2, and this program reads 1"));
  for (const double senseless : {HUGE_VAL, 2e100, -1.0})  // squares of 1e200 have no end
    for (const auto& [name, words] :
         {std::pair{"shock_rate", " shocks a second"}, {"v_rms", " m/s"}})
      EXPECT_THAT(refusal_after([&](hid_t file) {
                    const hid_t column = H5Dopen2(file, name, H5P_DEFAULT);
                    const double values[] = {1e3, senseless};
                    H5Dwrite(column, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
                    H5Dclose(column);
                  }),
                  HasSubstr(fmt::format("/{} has {}{}", name, senseless, words)));
}

// ---- the law -----------------------------------------------------------------------------------

StudyAnswers answers_of(const std::vector<StudyAxis>& axes,
                        const std::function<double(const std::vector<double>&)>& v_rms) {
  StudyAnswers answers{axes, {}, {}};
  std::vector<std::size_t> place(axes.size(), 0);
  for (;;) {
    std::vector<double> at;
    for (std::size_t a = 0; a < axes.size(); ++a)
      at.push_back(axes[a].texts.empty() ? axes[a].numbers[place[a]] : 0.0);
    answers.v_rms.push_back(v_rms(at));
    answers.status.push_back(std::isnan(answers.v_rms.back()) ? 3 : 0);
    std::size_t axis = axes.size();
    while (axis > 0 && ++place[axis - 1] == axes[axis - 1].size()) place[--axis] = 0;
    if (axis == 0) return answers;
  }
}

const std::vector<StudyAxis> two_axes = {{"speed", {0.02, 0.05, 0.1, 0.5}, {}},
                                         {"rq", {2e-6, 4e-6, 20e-6}, {}},
                                         {"seed", {0, 1, 2}, {}}};

TEST(StudyLaw, OfAPowerLawHasItsExponents) {
  const StudyLaw law = fit_law(answers_of(two_axes, [](const std::vector<double>& x) {
    return 40 * std::pow(x[0], 0.75) * std::pow(x[1], 1.1);
  }));
  ASSERT_EQ(law.exponents.size(), 2u);
  EXPECT_EQ(law.exponents[0].name, "speed");
  EXPECT_NEAR(law.exponents[0].value, 0.75, 1e-12);
  EXPECT_NEAR(law.exponents[1].value, 1.1, 1e-12);
  EXPECT_NEAR(law.factor, 40, 1e-9);
  EXPECT_NEAR(law.explained, 1, 1e-12);
  EXPECT_NEAR(law.deviation, 0, 1e-11);
  EXPECT_NEAR(law.exponents[0].high - law.exponents[0].low, 0, 1e-11);
  EXPECT_EQ(law.runs, 36u);
  EXPECT_EQ(law.left_out, 0u);
}

TEST(StudyLaw, OfSoundIsThatOfItsPressure) {
  StudyAnswers answers = answers_of(two_axes, [](const std::vector<double>& x) { return x[0]; });
  EXPECT_TRUE(sounds_of(answers).empty());
  EXPECT_THROW(fit_law(answers, sounds[1]), RequestError);
  for (std::size_t run = 0; run < answers.v_rms.size(); ++run) {
    const auto place = place_of_run(answers.axes, run);
    const double speed = two_axes[0].numbers[place[0]], rq = two_axes[1].numbers[place[1]];
    answers.lp_a.push_back(20 * (0.7 * std::log10(speed) + 0.9 * std::log10(rq)) + 150);
    answers.lw.push_back(-std::numeric_limits<double>::infinity());  // at rest
  }
  ASSERT_EQ(sounds_of(answers).size(), 2u);
  const StudyLaw law = fit_law(answers, sounds_of(answers)[0]);
  EXPECT_STREQ(law.of.name, "lpa");
  EXPECT_NEAR(law.exponents[0].value, 0.7, 1e-12);
  EXPECT_NEAR(law.exponents[1].value, 0.9, 1e-12);
  EXPECT_NEAR(law.constant, 150, 1e-9);
  EXPECT_NEAR(law_level(law, answers.axes, {1, 2}), answers.lp_a[3 * (3 * 1 + 2)], 1e-9);
  EXPECT_THROW(fit_law(answers, sounds_of(answers)[1]), RequestError);
  EXPECT_THAT(describe_study(answers, "x"), AllOf(HasSubstr("LpA = 20 x 0.700 log10(speed)"),
                                                  HasSubstr("Lw: no law yet"), HasSubstr("none")));
}

TEST(StudyLaw, OfOneDimensionIsTheTextbooksLine) {
  // y = 1, 2, 2, 3 (of log10) at x = 0, 1, 2, 3: slope 0.6, residual sum 0.2, of 2 degrees of
  // freedom
  const std::vector<double> y = {1, 2, 2, 3};
  const StudyLaw law = fit_law(answers_of(
      {{"x", {1, 10, 100, 1000}, {}}, {"seed", {0}, {}}}, [&](const std::vector<double>& at) {
        return std::pow(10.0, y[static_cast<std::size_t>(std::lround(std::log10(at[0])))]);
      }));
  const double error = std::sqrt(0.2 / 2 / 5);  // sum of (x - 1.5)^2 = 5
  const double t = student_quantile(0.975, 2);
  EXPECT_NEAR(law.exponents[0].value, 0.6, 1e-12);
  EXPECT_NEAR(law.exponents[0].high, 0.6 + t * error, 1e-12);
  EXPECT_NEAR(law.exponents[0].low, 0.6 - t * error, 1e-12);
  EXPECT_NEAR(law.explained, 1 - 0.2 / 2.0, 1e-12);  // of a total of 2
  EXPECT_NEAR(law.deviation, 20 * std::sqrt(0.1), 1e-11);
  EXPECT_NEAR(std::log10(law.factor), 1.1, 1e-12);
}

TEST(StudyLaw, ItsIntervalsHoldTheTruthInNinetyFiveOfAHundredCases) {
  std::mt19937_64 dice(1);
  std::normal_distribution<double> noise(0, 0.1);
  constexpr int studies = 2000;
  int held = 0;
  for (int i = 0; i < studies; ++i) {
    const StudyLaw law = fit_law(answers_of(two_axes, [&](const std::vector<double>& x) {
      return std::pow(x[0], 0.8) * x[1] * std::pow(10.0, noise(dice));
    }));
    held += law.exponents[0].low <= 0.8 && 0.8 <= law.exponents[0].high ? 1 : 0;
  }
  // four standard deviations of a count of 95 %
  EXPECT_NEAR(held, 0.95 * studies, 4 * std::sqrt(studies * 0.95 * 0.05));
}

TEST(StudyLaw, LeavesOutWhatHasNoNumberAndPoolsWords) {
  std::vector<StudyAxis> axes = two_axes;
  axes.insert(axes.begin() + 1, {"scheme", {}, {"heun", "rk4"}});
  axes.insert(axes.begin() + 2, {"start", {0.0, 0.1}, {}});
  int count = 0;
  const StudyLaw law = fit_law(answers_of(axes, [&](const std::vector<double>& x) {
    return ++count % 5 == 0 ? std::nan("") : x[0] * x[3];
  }));
  EXPECT_THAT(law.pooled, ElementsAre("scheme", "start"));
  EXPECT_EQ(law.left_out, 144u / 5);
  EXPECT_NEAR(law.exponents[0].value, 1, 1e-12);
}

TEST(StudyLaw, PoolsNumbersThatChooseAFace) {
  for (const char* keys :
       {"slider.surface.seed", "resonator.surface.row", "slider.surface.column, scene.spacing"}) {
    std::vector<StudyAxis> axes = two_axes;
    axes.insert(axes.begin(), {"face", {1, 2, 3}, {}, "1", keys});
    const StudyLaw law =
        fit_law(answers_of(axes, [](const std::vector<double>& x) { return x[0] * x[1] * x[2]; }));
    EXPECT_THAT(law.pooled, ElementsAre("face")) << keys;
    EXPECT_EQ(law.exponents.size(), 2u);
  }
}

TEST(StudyLaw, HasNoExponentOfAnOffset) {
  for (const char* keys : {"scene.start", "scene.gap", "slider.surface.skewness",
                           "scene.side, scene.start", "slider.surface.offset_x"}) {
    std::vector<StudyAxis> axes = two_axes;
    axes.insert(axes.begin(), {"place", {0.1, 0.2}, {}, "1", keys});
    const StudyLaw law =
        fit_law(answers_of(axes, [](const std::vector<double>& x) { return x[0] * x[1] * x[2]; }));
    EXPECT_THAT(law.pooled, ElementsAre("place")) << keys;
  }
}

/// Its numbers are those of its first key.
TEST(StudyLaw, FitsNumbersThatAFaceIsTiedTo) {
  for (const char* keys : {"scene.speed, scene.start", "slider.surface.rq, slider.surface.path"}) {
    const StudyLaw law =
        fit_law(answers_of({{"x", {0.1, 0.2, 0.4}, {}, "1", keys}, {"seed", {0, 1}, {}}},
                           [](const std::vector<double>& x) { return x[0] * (1 + 0.1 * x[1]); }));
    ASSERT_EQ(law.exponents.size(), 1u) << keys;
    EXPECT_NEAR(law.exponents[0].value, 1, 1e-12);
  }
}

/// Values of an axis that chooses a face are draws as seeds are: equal answers, equal law.
TEST(StudyLaw, RunsOfOneFaceAreNoIndependentDraws) {
  std::mt19937_64 dice{3};
  std::normal_distribution<double> normal;
  std::map<double, double> shift;
  for (double face = 0; face < 4; ++face) shift[face] = 0.3 * normal(dice);
  const auto v_rms = [&](double speed, double load, double face) {
    return std::pow(speed, 1.1) * std::pow(10, shift[face] * (1 + speed)) * std::pow(load, 0.1) *
           (1 + 0.001 * std::fmod(speed * load * 1e7 + face, 7));
  };
  const StudyAxis speed{"speed", {0.1, 0.2, 0.4}, {}}, load{"load", {1, 2, 3}, {}};
  const StudyLaw by_seeds =
      fit_law(answers_of({speed, load, {"seed", {0, 1, 2, 3}, {}}},
                         [&](const std::vector<double>& x) { return v_rms(x[0], x[1], x[2]); }));
  for (const char* keys : {"slider.surface.seed", "resonator.surface.path", "scene.start",
                           "resonator.surface.row, slider.surface.row"}) {
    const StudyAnswers answers =
        answers_of({{"face", {0, 1, 2, 3}, {}, "1", keys}, speed, load, {"seed", {0}, {}}},
                   [&](const std::vector<double>& x) { return v_rms(x[1], x[2], x[0]); });
    const StudyLaw by_faces = fit_law(answers);
    EXPECT_EQ(by_faces.seeds, 4u);
    EXPECT_THAT(by_faces.drawn_by, ElementsAre("face"));
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(by_faces.exponents[k].value, by_seeds.exponents[k].value, 1e-12);
      EXPECT_NEAR(by_faces.exponents[k].low, by_seeds.exponents[k].low, 1e-9);
    }
    EXPECT_NEAR(by_faces.line.p, by_seeds.line.p, 1e-9);
    StudyAnswers part = answers;
    for (std::size_t run = 0; run < part.v_rms.size(); run += 10) part.v_rms[run] = std::nan("");
    EXPECT_EQ(fit_law(part).line.why_not_tested,
              "it takes two values of face that have all points, there are none");
    EXPECT_THAT(describe_study(answers, "x"),
                HasSubstr("intervals by the 4 values of face: runs of one value share a face"));
  }
}

/// The slider is 10 mm long and slides up to 0.4 mm.
TEST(StudyLaw, HasNoIntervalsWhereStartsLieOnOneStretch) {
  const auto law_of = [](double third, const std::string& given = {}) {
    const StudyAxis start{"start", {0.02, 0.031, third}, {}, "1", "scene.start"};
    StudyAnswers answers = answers_of(
        {start, {"speed", {0.1, 0.2}, {}, "1", "scene.speed"}, {"seed", {0}, {}}},
        [](const std::vector<double>& x) { return x[1] * (1 + x[0] + 0.1 * x[0] * x[1]); });
    answers.base = test::quick_scene;
    answers.given = given;
    answers.study = fmt::format(
        "base = \"b.toml\"\n[vary]\nstart = {{ key = \"scene.start\", values = [0.02, 0.031, {}] "
        "}}\n"
        "speed = {{ key = \"scene.speed\", values = [0.1, 0.2] }}\n",
        third);
    return fit_law(answers);
  };
  EXPECT_EQ(law_of(0.0414).dependent, "");
  EXPECT_FALSE(std::isnan(law_of(0.0414).exponents[0].low));
  const StudyLaw near = law_of(0.0413);
  EXPECT_THAT(near.dependent,
              HasSubstr("values of start lie so close that runs touch a part of the "
                        "same faces: each takes up to 0.0104 m along x, "));
  EXPECT_TRUE(std::isnan(near.exponents[0].low) && std::isnan(near.exponents[0].high));
  EXPECT_THAT(near.line.why_not_tested, HasSubstr("two seeds or more that differ"));
  EXPECT_EQ(law_of(0.0413, "slider.length=9e-3").dependent, "");
}

/// Each run shares its slider's face with some runs and its resonator's with others.
TEST(StudyLaw, HasNoIntervalsWhereFacesOfBothBodiesAreVaried) {
  const StudyAnswers answers = answers_of(
      {{"speed", {0.1, 0.2, 0.4}, {}},
       {"a", {1, 2}, {}, "1", "slider.surface.seed"},
       {"b", {1, 2}, {}, "1", "resonator.surface.seed"},
       {"seed", {0}, {}}},
      [](const std::vector<double>& x) { return x[0] * (1 + 0.1 * x[1] + 0.2 * x[2] * x[1]); });
  const StudyLaw law = fit_law(answers);
  EXPECT_NEAR(law.exponents[0].value, 1, 1e-12);
  EXPECT_TRUE(!law.dependent.empty() && std::isnan(law.exponents[0].low));
  EXPECT_THAT(describe_study(answers, "x"),
              HasSubstr("no intervals: a and b choose faces of different bodies"));
}

TEST(StudyLaw, LeavesOutAKeyWithoutEffect) {
  for (const int idle : {0, 1, 2}) {
    std::vector<StudyAxis> axes = two_axes;
    axes.insert(axes.begin() + idle, {"step", {1e-8, 1e-7, 1e-6}, {}});
    const auto speed = static_cast<std::size_t>(idle > 0 ? 0 : 1);
    const StudyLaw law = fit_law(answers_of(axes, [&](const std::vector<double>& x) {
      return std::pow(x[speed], 0.75) * (1 + 0.1 * x[3]) * (x[idle > 1 ? 1 : 2] > 3e-6 ? 2 : 1);
    }));
    EXPECT_THAT(law.pooled, ElementsAre("step")) << idle;
    ASSERT_EQ(law.exponents.size(), 2u);
    EXPECT_NEAR(law.exponents[0].value, 0.75, 1e-12);
  }
  EXPECT_THAT(refusal_of([&] { fit_law(answers_of(two_axes, [](const auto&) { return 1.0; })); }),
              HasSubstr("changes the answers"));
}

TEST(StudyLaw, SaysWhyThereIsNone) {
  const auto one = [](const std::vector<double>&) { return 1.0; };
  EXPECT_THAT(refusal_of([&] {
                fit_law(answers_of({{"scheme", {}, {"a", "b"}}, {"seed", {0}, {}}}, one));
              }),
              HasSubstr("no key that the study varies can have an exponent"));
  EXPECT_THAT(refusal_of([&] {
                fit_law(answers_of({{"seed", {0, 1}, {}}}, one));
              }),
              HasSubstr("no law: no key is varied"));
  EXPECT_THAT(
      refusal_of([&] {
        fit_law(answers_of(two_axes, [](const std::vector<double>&) { return std::nan(""); }));
      }),
      HasSubstr("the 0 runs with a v_rms above 0 do not"));
  // speed varies with rq alone
  EXPECT_THAT(refusal_of([&] {
                fit_law(answers_of(two_axes, [](const std::vector<double>& x) {
                  return (x[0] == 0.02 && x[1] == 2e-6) || (x[0] == 0.5 && x[1] == 20e-6)
                             ? 1.0
                             : std::nan("");
                }));
              }),
              HasSubstr("do not vary all of the dimensions by themselves"));
}

/// Warnings that differ in their numbers alone are one, counted once a run; failures are none.
TEST(StudyWarnings, AreCountedByTheirKind) {
  StudyAnswers answers = answers_of(
      {{"speed", {0.1, 0.2}, {}}, {"seed", {0, 5}, {}}},
      [](const std::vector<double>& x) { return x[0] > 0.15 && x[1] > 0 ? std::nan("") : 1.0; });
  answers.messages = {"", "12 % are lost at 1e-05 s\n3 % are lost at 2 s",
                      "8 % are lost at 4 s\nanother one", "12 % are lost at 1 s"};
  const std::vector<SharedWarning> found = shared_warnings(answers);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].text, "12 % are lost at 1e-05 s");
  EXPECT_EQ(found[0].runs, 2u);
  EXPECT_EQ(found[0].first, "speed = 0.1, seed 5");
  EXPECT_EQ(found[1].runs, 1u);
  EXPECT_THAT(describe_study(answers, "x"),
              HasSubstr("warning          2 of 3 runs (the first: speed = 0.1, seed 5): 12 %"));
  answers.messages.clear();
  EXPECT_TRUE(shared_warnings(answers).empty());
}

TEST(StudyLaw, MeansAreOverTheSeeds) {
  const StudyAnswers answers = answers_of(two_axes, [](const std::vector<double>& x) {
    return x[0] == 0.05 && x[1] == 4e-6 ? 1 + x[2] : 7.0;
  });
  const std::vector<CombinationMean> means = combination_means(answers);
  ASSERT_EQ(means.size(), 12u);
  EXPECT_THAT(means[4].place, ElementsAre(1, 1));
  EXPECT_NEAR(means[4].v_rms.mean, 2, 1e-15);
  EXPECT_EQ(means[4].v_rms.count, 3u);
  EXPECT_NEAR(means[4].v_rms.deviation, 1, 1e-15);
  EXPECT_EQ(means[5].v_rms.mean, 7.0);
}

/// They are no runs at rest, and the user can do something about them.
TEST(StudyLaw, SaysOfRunsThatAreMissingWhatRunsThem) {
  StudyAnswers answers = answers_of(two_axes, [](const std::vector<double>& x) {
    return x[2] == 2 && x[0] > 0.05 ? std::nan("") : x[0] * x[1];
  });
  EXPECT_THAT(describe_study(answers, "out"),
              AllOf(HasSubstr("; 6 without a v_rms above 0 left out"), Not(HasSubstr("not run"))));
  const auto wait = [&](std::size_t first) {
    for (std::size_t run = first; run < answers.status.size(); ++run) {
      answers.v_rms[run] = std::nan("");
      answers.status[run] = static_cast<double>(RunStatus::missing);
    }
    return describe_study(answers, "out");
  };
  EXPECT_THAT(
      wait(26),  // of the six that failed two are left
      AllOf(HasSubstr("; 2 without a v_rms above 0 left out\n    10 of the runs have not run "
                      "yet: the same 'ra2d study' command continues, or those of other shards\n")));
  EXPECT_THAT(
      wait(1),
      HasSubstr(
          "do not vary all of the dimensions by themselves. 35 of the runs "
          "have not run yet: the same 'ra2d study' command continues, or those of other shards\n"));
}

TEST(StudyLaw, OfRunsAtRestTheLevelIsInfinite) {
  const StudyAnswers answers = answers_of(
      two_axes, [](const std::vector<double>& x) { return x[0] > 0.02 ? x[0] * x[1] : 0.0; });
  const std::string text = describe_study(answers, "out", 1);
  EXPECT_THAT(text, HasSubstr("    3     0.000e+00       -inf\n"));
  EXPECT_THAT(text, HasSubstr("without a v_rms above 0 left out"));
}

}  // namespace
}  // namespace ra2d
