// SPDX-License-Identifier: BSD-3-Clause
// --json of run, plan and study status.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/child.hpp"
#include "tests/places.hpp"
#include "tests/studies.hpp"

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ra2d::test::Ended;
using ra2d::test::scene_file;
using testing::HasSubstr;

class ProgramJson : public testing::Test {
 protected:
  Ended run(std::vector<std::string> words) const {
    words.insert(words.begin(), ra2d::test::program());
    return ra2d::test::run_program(folder_.path(), words);
  }
  /// All that the program prints is one object, in one line.
  Json json(const std::vector<std::string>& words, int status = 0) const {
    const Ended ended = run(words);
    EXPECT_EQ(ended.status, status) << ended.err;
    EXPECT_EQ(std::count(ended.out.begin(), ended.out.end(), '\n'), 1);
    return Json::parse(ended.out);  // which throws for NaN and for anything more
  }
  void write(const char* name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }
  const ra2d::test::Folder folder_;
};

/// The figures that both have agree.
TEST_F(ProgramJson, OfARunSaysWhatItsAnalysisSays) {
  const Json made = json({"run", scene_file("dang2012"), "--set", "time.scheme=adaptive", "--set",
                          "time.tolerance=1e-6", "--quiet", "--json", "-o", "r.h5"});
  const Json analysed = json({"analyze", "r.h5", "--json"});
  for (const char* name : {"file", "title", "complete", "ended", "lv_interval", "no_interval",
                           "contact_share", "from"})
    EXPECT_EQ(made[name], analysed[name]) << name;
  EXPECT_NEAR(made["lv"], analysed["lv"], 1e-9);
  EXPECT_NEAR(made["shocks"]["rate"], analysed["shocks"]["rate"], 1e-9);
  EXPECT_NEAR(made["shocks"]["duration"]["median"], analysed["shocks"]["duration"]["median"],
              2e-3 * double(analysed["shocks"]["duration"]["median"]));
  EXPECT_EQ(made["shocks"]["rate_interval"], analysed["shocks"]["rate_interval"]);
  EXPECT_EQ(made["exit_status"], 0);
  EXPECT_EQ(made["was_there"], false);
  EXPECT_EQ(made["to"], 1.0);
  EXPECT_GT(made["steps"], 1000);
  EXPECT_GT(made["wall_seconds"], made["march_seconds"]);
  EXPECT_TRUE(made["beyond_limit"].is_null());

  // the same run again is found, with the same answer
  const Json found = json({"run", scene_file("dang2012"), "--set", "time.scheme=adaptive", "--set",
                           "time.tolerance=1e-6", "--json", "-o", "r.h5"});
  EXPECT_EQ(found["was_there"], true);
  for (const char* name : {"complete", "ended", "lv", "lv_interval", "v_rms", "shocks", "steps",
                           "energy", "contact_share", "nodes_evaluated"})
    EXPECT_EQ(found[name], made[name]) << name;
  EXPECT_NEAR(found["to"], made["to"], 1e-9);
}

/// Also where the run was there already.
TEST_F(ProgramJson, OfARunHasItsWarnings) {
  std::vector<std::string> words{"run", scene_file("dang2012"), "--json", "-o", "r.h5"};
  for (const char* set :
       {"scene.duration=0.02", "resonator.max_frequency=2000", "time.scheme=adaptive",
        "time.tolerance=1e-3", "output.microphones=[{ x = 0.15, y = 0.1, z = 0.5 }]"})
    words.insert(words.end(), {"--set", set});
  for (const bool was_there : {false, true}) {
    const Json made = json(words);
    EXPECT_EQ(made["was_there"], was_there);
    const std::vector<std::string> warnings = made["warnings"];
    ASSERT_GE(warnings.size(), 2u);
    EXPECT_THAT(warnings.front(), HasSubstr("contact.stiffness = 1e+15 Pa/m: "));
    EXPECT_EQ(warnings.back(),
              "microphone 1: " + made["microphones"][0]["warning"].get<std::string>());
    EXPECT_THAT(warnings.back(), HasSubstr("above the last mode that was kept"));
    EXPECT_EQ(json({"analyze", "r.h5", "--json"})["microphones"][0]["warning"],
              made["microphones"][0]["warning"]);
  }
  words.insert(words.end(), {"--fresh"});
  const Ended said = run(words);
  for (const std::string warning : Json::parse(said.out)["warnings"])
    EXPECT_THAT(said.err, HasSubstr(warning));
  EXPECT_EQ(json({"run", scene_file("drop"), "--set", "scene.duration=1e-4", "--json"})["warnings"],
            Json::array());
}

/// Also those of figures that the file does not have.
TEST_F(ProgramJson, OfARunThatIsThereHasTheWarningsOfItsMaking) {
  std::vector<std::string> words{"run", scene_file("dang2012"), "--json", "-o", "r.h5"};
  for (const char* set : {"scene.duration=0.02", "time.scheme=adaptive", "time.tolerance=1e-3",
                          "resonator.moving_force=[{ force = 4000.0, speed = 1.0, start = 0.1 }]"})
    words.insert(words.end(), {"--set", set});
  const Json made = json(words), found = json(words);
  EXPECT_THAT(made["warnings"].dump(), testing::AllOf(HasSubstr("says little about them"),
                                                      HasSubstr("the resonator vibrates by some")));
  EXPECT_EQ(found["was_there"], true);
  EXPECT_EQ(found["warnings"], made["warnings"]);
  EXPECT_EQ(run({"check", "r.h5"}).status, 0);
}

/// A slow slider under a load: the plate is bent far more than it vibrates. The warning's tolerance
/// makes the level right.
TEST_F(ProgramJson, ALevelBelowTheErrorsOfTheStepsIsDoubted) {
  const auto made = [&](const char* tolerance, const char* faces,
                        const char* speed = "scene.speed=1e-4") {
    std::vector<std::string> words{"run", scene_file("dang2012"), "--json", "--force"};
    for (const std::string set :
         {"scene.duration=0.01", speed, "slider.load=100", "contact.stiffness=4e12",
          "time.scheme=adaptive", tolerance, faces})
      words.insert(words.end(), {"--set", set});
    return json(words);
  };
  const auto doubt = HasSubstr("says little about it: the level may be");
  const char* const linear = "scene.faces=linear";
  const Json coarse = made("time.tolerance=1e-6", linear),
             fine = made("time.tolerance=1e-9", linear),
             smooth = made("time.tolerance=1e-6", "scene.faces=smooth");
  EXPECT_THAT(coarse["warnings"].dump(), testing::AllOf(doubt, HasSubstr("Try 1e-09")));
  EXPECT_GT(coarse["lv"], fine["lv"].get<double>() + 1);
  EXPECT_THAT(fine["warnings"].dump(), testing::Not(doubt));
  EXPECT_THAT(smooth["warnings"].dump(), testing::Not(doubt));
  EXPECT_NEAR(smooth["lv"], made("time.tolerance=1e-9", "scene.faces=smooth")["lv"], 1e-3);
  const char* const slow = "scene.speed=1e-6";
  const Json coarse_smooth = made("time.tolerance=1e-4", "scene.faces=smooth", slow),
             fine_smooth = made("time.tolerance=1e-8", "scene.faces=smooth", slow);
  EXPECT_THAT(coarse_smooth["warnings"].dump(), testing::AllOf(doubt, HasSubstr("Try 1e-08")));
  EXPECT_GT(coarse_smooth["lv"], fine_smooth["lv"].get<double>() + 1);
  EXPECT_THAT(fine_smooth["warnings"].dump(), testing::Not(doubt));
}

/// The only mode moves by its velocity over its angular frequency. The gap makes the corner of the
/// plate give way to the block.
TEST_F(ProgramJson, APlateThatMovesByItsThicknessIsDoubted) {
  const double length = 0.06, width = 0.04, thickness = 1e-3, young = 3e9, density = 7800;
  std::ofstream(folder_.path() / "corner.toml") << R"(
[scene]
kind = "areal"
duration = 2e-4
speed = 0.5
start = 0.05
side = 0.035
spacing = 5e-5
gap = 5e-6
[slider]
support = "rigid"
length = 0.005
width = 0.0045
[contact]
law = "multiplier"
[time]
scheme = "exact"
step = 1e-6
[output]
rate = 1e5
[resonator]
support = "pinned"
length = 0.06
width = 0.04
thickness = 1e-3
young = 3e9
density = 7800
modes = 1
damping = 0.02
surface = { kind = "gaussian", rq = 3e-6, rsm = 4e-4, seed = 3 }
)";
  const Json made = json({"run", "corner.toml", "--json"});
  const double stiffness = young * std::pow(thickness, 3) / (12 * (1 - 0.3 * 0.3)),
               omega = M_PI * M_PI * (1 / (length * length) + 1 / (width * width)) *
                       std::sqrt(stiffness / (density * thickness));
  EXPECT_THAT(
      made["warnings"].dump(),
      HasSubstr(fmt::format("vibrates by some {:.2g} m (root mean square), and its thickness is "
                            "0.001 m",
                            made["v_rms"].get<double>() / omega)));
}

TEST_F(ProgramJson, OfARunThatWasCutShortSaysSo) {
  const Json cut = json({"run", scene_file("dang2012"), "--set", "scene.duration=1.8", "--json",
                         "--max-wall", "0.05", "-o", "r.h5"},
                        5);
  EXPECT_EQ(cut["complete"], false);
  EXPECT_EQ(cut["ended"], "stopped by --max-wall");
  EXPECT_EQ(cut["exit_status"], 5);
  EXPECT_EQ(cut["resumable"], true);
  EXPECT_LT(cut["to"], 1.8);
  EXPECT_EQ(cut["duration"], 1.8);
}

TEST_F(ProgramJson, OfARunHasNullForWhatThereIsNot) {
  // a slider that never touches: no level, no shock, no interval
  const Json still =
      json({"run", scene_file("dang2012-pinned"), "--set", "scene.gap=1e-3", "--set",
            "scene.duration=1e-3", "--set", "time.step=1e-6", "--json", "-o", "s.h5"});
  EXPECT_TRUE(still["lv"].is_null());  // -inf
  EXPECT_EQ(still["v_rms"], 0);
  EXPECT_EQ(still["shocks"]["rate"], 0);
  EXPECT_TRUE(still["shocks"]["duration"]["median"].is_null());
  EXPECT_TRUE(still["lv_interval"]["low"].is_null());
  EXPECT_NE(still["no_interval"], "");
  // too few samples for an energy balance, and for an analysis
  const std::vector<std::string> words{"run",   scene_file("drop"), "--set",  "scene.duration=1e-4",
                                       "--set", "output.rate=1",    "--json", "-o",
                                       "d.h5"};
  for (const bool was_there : {false, true}) {
    const Json few = json(words);
    EXPECT_EQ(few["was_there"], was_there);
    for (const char* name : {"closure", "residual", "turnover"})
      EXPECT_TRUE(few["energy"][name].is_null()) << name << few;
    EXPECT_NE(few["no_interval"], "");
  }
}

TEST_F(ProgramJson, AFaultPrintsNoJson) {
  const Ended refused = run({"run", scene_file("drop"), "--set", "time.step=-1", "--json"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(refused.out, "");
  EXPECT_THAT(refused.err, HasSubstr("time.step"));
}

TEST_F(ProgramJson, OfAPlanHasItsFigures) {
  const Json plan = json({"plan", scene_file("dang2012"), "--json"});
  EXPECT_EQ(plan["title"], "roughness noise");
  EXPECT_EQ(plan["resonator"]["elastic_modes"], 19);
  EXPECT_EQ(plan["slider"]["rigid_modes"], 2);
  EXPECT_TRUE(plan["slider"]["highest_frequency"].is_null());
  EXPECT_EQ(plan["time"]["steps"], 100'000'000);
  EXPECT_EQ(plan["samples"], 100'001);
  // pinned: f_k goes as k^2
  const double highest = plan["resonator"]["highest_frequency"],
               next = plan["resonator"]["next_frequency"];
  EXPECT_NEAR(next / highest, 400.0 / 361.0, 1e-9);
  EXPECT_NEAR(plan["resonator"]["nodes_to_shortest_wave"], 2 * 0.3 / 19 / 8e-6, 1e-6);
  // kappa chi w, and half a period of it
  EXPECT_NEAR(plan["contact"]["node_stiffness"], 1e15 * 8e-6 * 0.02, 1.0);
  // the first mode rings longest, and dies away by 60 dB in ln(1000) / (zeta omega)
  const double first = highest / 361;
  EXPECT_NEAR(plan["ringing"]["frequency"], first, 1e-9 * first);
  EXPECT_NEAR(plan["ringing"]["decay_60_db"], std::log(1e3) / (0.02 * 2 * M_PI * first), 1e-9);
  int chosen = 0;
  for (const Json& limit : plan["time"]["limits"]) {
    EXPECT_EQ(limit["holds_every_step"], limit["holds_up_to"].is_null());
    if (!limit["is_chosen"]) continue;
    ++chosen;
    EXPECT_EQ(limit["scheme"], "backward-euler");
    EXPECT_EQ(limit["contact_force"], "old");
  }
  EXPECT_EQ(chosen, 1);
  // the scene is whole: it runs
  write("again.toml", plan["scene"]);
  EXPECT_EQ(json({"plan", "again.toml", "--json"})["gap"], plan["gap"]);
  const Json adaptive =
      json({"plan", scene_file("dang2012"), "--set", "time.scheme=adaptive", "--json"});
  EXPECT_TRUE(adaptive["time"]["step"].is_null());
  EXPECT_TRUE(adaptive["time"]["steps"].is_null());
  EXPECT_EQ(adaptive["time"]["tolerance"], 1e-8);
  EXPECT_TRUE(adaptive["time"]["limits"].empty());
}

TEST_F(ProgramJson, OfASearchForSavingsHasItsTrials) {
  const Json plan = json({"plan", scene_file("peaks"), "--accuracy", "0.05", "--budget", "1",
                          "--json", "-o", "cheap.toml"});
  EXPECT_EQ(plan["accuracy"], 0.05);
  EXPECT_EQ(plan["output"], "cheap.toml");
  EXPECT_TRUE(fs::exists(folder_.path() / "cheap.toml"));
  ASSERT_FALSE(plan["trials"].empty());
  for (const Json& trial : plan["trials"]) {
    EXPECT_THAT(std::string(trial["verdict"]), testing::AnyOf("kept", "moved", "open"));
    EXPECT_TRUE(trial["moved"].contains("shock_rate"));
  }
  EXPECT_LE(plan["cost"], plan["cost_as_written"]);
}

TEST_F(ProgramJson, OfAStudysStatusCountsItsRuns) {
  write("base.toml", ra2d::test::quick_scene);
  write("s.toml",
        "base = \"base.toml\"\nseeds = 2\n"
        "[set]\n\"time.scheme\" = \"explicit-euler\"\n\"time.force\" = true\n"
        "[vary]\nstep = { key = \"time.step\", values = [1e-8, 2e-8, 1e-5] }\n");
  run({"study", "s.toml", "--quiet", "--shard", "1/2"});  // the longest step is unstable
  const Json half = json({"study", "status", "s", "--json"});
  EXPECT_EQ(half["folder"], "s");
  EXPECT_EQ(half["runs"], 6);
  EXPECT_EQ(int(half["done"]) + int(half["failed"]) + int(half["missing"]), 6);
  EXPECT_EQ(half["missing"], half["missing_runs"].size());
  EXPECT_EQ(half["failed"], half["failed_runs"].size());
  EXPECT_GT(half["missing"], 0);
  run({"study", "s.toml", "--quiet"});
  const Json all = json({"study", "status", "s", "--json"});
  EXPECT_EQ(all["missing"], 0);
  EXPECT_EQ(all["seconds_left"], 0);
  EXPECT_EQ(all["done"], 4);
  ASSERT_EQ(all["failed_runs"].size(), 2);
  EXPECT_THAT(std::string(all["failed_runs"][0]["message"]), HasSubstr("unstable"));
}

}  // namespace
