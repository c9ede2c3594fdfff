// SPDX-License-Identifier: BSD-3-Clause
// ra2d new and ra2d scenes, as a user has them.
#include "host/scene_file/new_scene.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/units.hpp"
#include "host/model/model.hpp"
#include "host/scene_file/installed_scenes.hpp"
#include "host/scene_file/materials.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/child.hpp"
#include "tests/effort.hpp"
#include "tests/places.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using Words = std::vector<std::string>;

/// Runs the program on a terminal of its own, on which `typed` is typed; status as of Child::wait.
Ended run_on_terminal(const fs::path& folder, Words words, const std::string& typed) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0) return {-1, "", "no pty"};
  const std::string name = ptsname(terminal);
  words.insert(words.begin(), program());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    setsid();
    const int side = open(name.c_str(), O_RDWR);  // becomes the terminal of the session
    ioctl(side, TIOCSCTTY, 0);
    for (int file = 0; file < 3; ++file) dup2(side, file);
    if (chdir(folder.c_str()) == 0) execv(arguments[0], arguments.data());
    _exit(127);
  }
  Ended ended{-1, "", ""};
  std::size_t sent = 0;
  char block[4096];
  // a line for each prompt: what is typed early would be taken by the terminal, Ctrl-C first
  for (ssize_t count; (count = read(terminal, block, sizeof block)) > 0;) {
    ended.out.append(block, static_cast<std::size_t>(count));
    if (!ended.out.ends_with("]: ") || sent == typed.size()) continue;
    const std::size_t end = std::min(typed.find('\n', sent), typed.size() - 1) + 1;
    if (write(terminal, typed.data() + sent, end - sent) < 0) break;
    sent = end;
  }
  int status = 0;
  waitpid(child, &status, 0);
  close(terminal);
  ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  return ended;
}

Ended run_ra2d(const fs::path& folder, Words words) {
  words.insert(words.begin(), program());
  return run_program(folder, words);
}

std::string text_of(const std::vector<std::pair<std::string, std::string>>& answers) {
  NewScene scene = usual_new_scene();
  for (const auto& [option, answer] : answers)
    for (const NewSceneQuestion& question : new_scene_questions())
      if (question.option == option) question.take(scene, answer);
  return new_scene_text(scene, "case.toml");
}

std::string refusal_of_answer(const std::string& option, const std::string& answer) {
  NewScene scene = usual_new_scene();
  const std::string before = new_scene_text(scene, "case.toml");
  for (const NewSceneQuestion& question : new_scene_questions()) try {
      if (question.option == option) question.take(scene, answer);
    } catch (const RequestError& fault) {
      EXPECT_EQ(new_scene_text(scene, "case.toml"), before) << "half of " << answer;
      return fault.what();
    }
  return "taken";
}

TEST(NewScene, OfUsualAnswersRunsWithoutADoubt) {
  const Model model = make_model(parse_scene(text_of({}), "case.toml"));
  EXPECT_THAT(model.doubts, IsEmpty());
  const Scene& scene = model.scene;
  EXPECT_EQ(scene.resonator.length, 0.3);
  EXPECT_EQ(scene.resonator.width, 0.2);
  EXPECT_EQ(scene.resonator.thickness, 2e-3);
  EXPECT_EQ(scene.resonator.young, 210e9);
  EXPECT_EQ(scene.resonator.density, 7850);
  EXPECT_EQ(scene.resonator.surface.rq, 8e-6);
  EXPECT_EQ(scene.speed, 0.1);
  EXPECT_EQ(scene.duration, 2);
  EXPECT_TRUE(scene.slider.load_is_weight);
  EXPECT_TRUE(scene.contact.is_hertz);
  EXPECT_EQ(scene.time.scheme, SchemeKind::adaptive);
  EXPECT_EQ(scene.time.tolerance, 1e-6);
}

/// Cases of the field, from a pin on a strip to a rail, run without a doubt.
TEST(NewScene, OfSensibleAnswersRunsWithoutADoubt) {
  const std::vector<std::vector<std::pair<std::string, std::string>>> cases{
      {{"--resonator", "aluminium, 500x20x3mm"}, {"--load", "5 N"}},
      {{"--resonator", "steel, 1 m x 70 mm x 40 mm"}, {"--slider", "cast-iron, 100 x 60 x 30 mm"}},
      {{"--resonator", "glass, 100 x 25 x 1 mm"},
       {"--resonator-face", "0.2 um, 100 um"},
       {"--slider", "pmma, 10x10x5 mm"},
       {"--slider-face", "2 um, 300 um"},
       {"--speed", "5 mm/s"}},
      {{"--resonator", "brass, 80 x 20 x 10 mm"}, {"--slider", "steel, 8 x 8 x 8 mm"}},
      {{"--resonator", "concrete, 2 x 0.3 x 0.1 m"}, {"--slider", "steel, 50 x 50 x 50 mm"}},
      {{"--resonator-face", "flat"}, {"--load", "2 weight"}, {"--duration", "20 ms"}},
      {{"--speed", "36 km/h"}, {"--damping", "0.001"}}};
  for (const auto& answers : cases) {
    const std::string text = text_of(answers);
    try {
      EXPECT_THAT(make_model(parse_scene(text, "case.toml")).doubts, IsEmpty()) << text;
    } catch (const RequestError& fault) {
      ADD_FAILURE() << fault.what() << '\n' << text;
    }
  }
}

TEST(NewScene, AnswersArriveWhereTheyBelong) {
  const Scene scene = parse_scene(text_of({{"--resonator", "brass, 40cm \u00D7 30mm \u00D7 2.5 mm"},
                                           {"--resonator-face", "3 um, 0.4 mm"},
                                           {"--slider", "30x20x10mm"},
                                           {"--slider-face", "1.5\u00B5m, 200 um"},
                                           {"--speed", "50 mm/s"},
                                           {"--load", "5 N"},
                                           {"--damping", "0.005"},
                                           {"--duration", "0.5 s"}}),
                                  "case.toml");
  EXPECT_EQ(scene.resonator.length, 0.4);
  EXPECT_EQ(scene.resonator.width, 0.03);
  EXPECT_EQ(scene.resonator.thickness, 2.5e-3);
  EXPECT_EQ(scene.resonator.young, find_material("brass")->young);
  EXPECT_EQ(scene.resonator.surface.rq, 3e-6);
  EXPECT_EQ(scene.resonator.surface.rsm, 4e-4);
  EXPECT_EQ(scene.resonator.damping, 0.005);
  EXPECT_EQ(scene.slider.length, 0.03);
  EXPECT_EQ(scene.slider.width, 0.02);
  EXPECT_EQ(scene.slider.thickness, 0.01);
  EXPECT_EQ(scene.slider.young, 210e9);  // the usual material
  EXPECT_EQ(scene.slider.surface.rq, 1.5e-6);
  EXPECT_EQ(scene.slider.load, 5);
  EXPECT_EQ(scene.slider.damping, 0.005);
  EXPECT_EQ(scene.speed, 0.05);
  EXPECT_EQ(scene.duration, 0.5);
}

TEST(NewScene, TakesAMaterialAndASizeAsTheyAreTyped) {
  const std::string usual = text_of({{"--resonator", "cast-iron, 500 x 20 x 3 mm"}});
  for (const char* answer : {"cast iron,500x20x3mm", "Cast iron 500 x 20 x 3 mm",
                             "grey-iron 500mm x 20mm x 3mm", " cast_iron , 500*20*3 mm "}) {
    const Scene scene = parse_scene(text_of({{"--resonator", answer}}), "case.toml");
    EXPECT_EQ(echo(scene), echo(parse_scene(usual, "case.toml"))) << answer;
  }
}

TEST(NewScene, WrongAnswersAreExplained) {
  EXPECT_EQ(refusal_of_answer("--resonator", "steel, 5e-1 x 2e-2 x 3e-3 m"), "taken");
  EXPECT_THAT(refusal_of_answer("--resonator", "steel, 20xx3mm"),
              HasSubstr("'' is not understood"));
  EXPECT_THAT(refusal_of_answer("--resonator", "stel, 500x20x3mm"),
              HasSubstr("did you mean 'steel'"));
  EXPECT_THAT(refusal_of_answer("--resonator", "unobtainium"), HasSubstr("there are steel, "));
  EXPECT_THAT(refusal_of_answer("--resonator", "steel, 500x20mm"), HasSubstr("500 x 20 x 3 mm"));
  EXPECT_THAT(refusal_of_answer("--resonator", "steel, 500x20x3"), HasSubstr("without a unit"));
  EXPECT_THAT(refusal_of_answer("--resonator", "steel, 500x20x3kg"), HasSubstr("is a mass"));
  EXPECT_THAT(refusal_of_answer("--resonator", "steel, 500x-20x3mm"), HasSubstr("-20 mm"));
  EXPECT_THAT(refusal_of_answer("--resonator", "steel, 0x20x3mm"),
              HasSubstr("'0 mm' is not allowed"));
  EXPECT_THAT(refusal_of_answer("--resonator", "steel, 1e999x20x3mm"), Not("taken"));
  EXPECT_THAT(refusal_of_answer("--resonator", "steel,500x20x3mm,5"), HasSubstr("not understood"));
  EXPECT_THAT(
      refusal_of_answer("--resonator", std::string(static_cast<std::size_t>(draws(16)) << 16, 'x')),
      testing::SizeIs(testing::Lt(1000u)));
  EXPECT_THAT(refusal_of_answer("--resonator", "\x1b[31m"), Not(HasSubstr("\x1b")));
  EXPECT_THAT(refusal_of_answer("--slider", "400x20x20mm"),
              HasSubstr("shorter than the resonator"));
  EXPECT_THAT(refusal_of_answer("--slider-face", "8 um"), HasSubstr("expected Rq and RSm"));
  EXPECT_THAT(refusal_of_answer("--slider-face", "8, 1.55"), HasSubstr("without a unit"));
  EXPECT_THAT(refusal_of_answer("--slider-face", "1.55 mm, 8 um"),
              HasSubstr("Rq that is not smaller"));
  EXPECT_THAT(refusal_of_answer("--slider-face", "nowhere.csv"), HasSubstr("is no file"));
  EXPECT_THAT(refusal_of_answer("--slider-face", std::string("a\0b", 3)), HasSubstr("is no file"));
  EXPECT_THAT(refusal_of_answer("--speed", "100"), HasSubstr("without a unit"));
  EXPECT_THAT(refusal_of_answer("--speed", "0 m/s"), HasSubstr("expected a number > 0"));
  EXPECT_THAT(refusal_of_answer("--load", "0 weight"), HasSubstr("number > 0 of weights"));
  EXPECT_THAT(refusal_of_answer("--load", "5 kg"), HasSubstr("is a mass, not a force"));
  EXPECT_THAT(refusal_of_answer("--damping", "2 %"), HasSubstr("0.01 for 1 per cent"));
  EXPECT_THAT(refusal_of_answer("--damping", "nan"), HasSubstr("is not allowed"));
  EXPECT_THAT(refusal_of_answer("--duration", "10 s"), HasSubstr("at most 2.8 s at this speed"));
}

TEST(NewScene, TakesAMeasuredProfile) {
  const Folder folder;
  std::ofstream profile(folder.path() / "profile.csv");
  for (int i = 0; i <= 4000; ++i)
    profile << fmt::format("{:.6f} {:.6f}\n", i * 2e-3,
                           2 * std::sin(i * 0.05) + std::sin(i * 0.017));
  profile.close();
  const Words line{"new",        "sub/case.toml", "--slider-face", "profile.csv, mm, um",
                   "--duration", "1 ms"};
  fs::create_directory(folder.path() / "sub");
  const Ended made = run_ra2d(folder.path(), line);
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string text = read_file(folder.path() / "sub/case.toml");
  EXPECT_THAT(text, HasSubstr("path = \"../profile.csv\", x_unit = \"mm\", z_unit = \"um\""));
  EXPECT_THAT(text, HasSubstr("short = \"repeat\""));
  const Ended ran = run_ra2d(folder.path(), {"run", "sub/case.toml"});
  EXPECT_EQ(ran.status, 0) << ran.err;
  // nodes stand as wide as the profile's shape allows, on its points
  EXPECT_THAT(text, HasSubstr("spacing  = \"4 um\""));
  std::ofstream fine(folder.path() / "fine.csv");
  for (int i = 0; i <= 40000; ++i)
    fine << fmt::format("{:.6f} {:.6f}\n", i * 2e-4, 2 * std::sin(i * 0.005));
  fine.close();
  ASSERT_EQ(
      run_ra2d(folder.path(), {"new", "fine.toml", "--slider-face", "fine.csv, mm, um"}).status, 0);
  EXPECT_THAT(read_file(folder.path() / "fine.toml"), HasSubstr("spacing  = \"4 um\""));
  // a file without units
  EXPECT_THAT(run_ra2d(folder.path(), {"new", "b.toml", "--slider-face", "profile.csv"}).err,
              HasSubstr("FILE, mm, um"));
}

/// A plate and a block, with random maps and with measured ones of other spacings.
TEST(NewScene, OfMapsIsAreal) {
  const Folder folder;
  const auto make = [&](Words words) {
    words.insert(words.begin(), {"new", "case.toml", "--areal", "--force"});
    return run_ra2d(folder.path(), words);
  };
  const Words small{"--resonator", "120 x 80 x 2 mm", "--slider", "6 x 6 x 10 mm"};
  const Ended usual = make(small);
  ASSERT_EQ(usual.status, 0) << usual.err;
  EXPECT_EQ(usual.err, "");
  const Scene scene = read_scene(folder.path() / "case.toml");
  EXPECT_EQ(scene.kind, SceneKind::areal);
  EXPECT_EQ(scene.spacing, 2e-5);  // a fiftieth of RSm, rounded down
  EXPECT_EQ(scene.faces, Faces::smooth);
  const Ended planned = run_ra2d(folder.path(), {"plan", "case.toml", "--json"});
  EXPECT_LT(nlohmann::json::parse(planned.out)["point_contacts"]["shock_error"], 0.06)
      << planned.out;
  EXPECT_EQ(scene.slider.density, 7850);
  EXPECT_EQ(scene.resonator.max_frequency, 20e3);
  // rows that are too far apart: with the words that the plan names they are not
  const std::string coarse =
      run_ra2d(folder.path(), {"plan", "case.toml", "--set", "scene.spacing_y=2e-4"}).out;
  EXPECT_THAT(coarse, HasSubstr("off by more than 100 %"));
  const std::string words = "--set scene.faces=smooth --set ";
  ASSERT_THAT(coarse, HasSubstr(words + "scene.spacing_y="));
  const std::size_t begin = coarse.find(words) + words.size();
  const Ended finer =
      run_ra2d(folder.path(), {"plan", "case.toml", "--json", "--set", "scene.faces=smooth",
                               "--set", coarse.substr(begin, coarse.find(',', begin) - begin)});
  EXPECT_LT(nlohmann::json::parse(finer.out)["point_contacts"]["shock_error"], 0.06);
  // as stiff as Hertz's point contacts: E*/a with contacts some 20 um wide
  EXPECT_GT(scene.contact.stiffness, 1e15);
  EXPECT_LT(scene.contact.stiffness, 1e16);

  const auto generate = [&](const char* name, const char* spacing, const char* side) {
    return run_ra2d(folder.path(),
                    {"surface", "generate", "-o", name, "--length", side, "--width", side,
                     "--spacing", spacing, "--rq", "2e-6", "--rsm", "1e-3", "--seed", "1"})
        .status;
  };
  ASSERT_EQ(generate("block.npy", "3e-5", "0.0061"), 0);
  ASSERT_EQ(generate("plate.npy", "7e-5", "0.02"), 0);
  Words faces = small;
  faces.insert(faces.end(), {"--slider-face", "block.npy, 30 um", "--resonator-face",
                             "plate.npy, 70 um, m", "--duration", "1 ms"});
  const Ended made = make(faces);
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string text = read_file(folder.path() / "case.toml");
  EXPECT_THAT(text, HasSubstr("path = \"block.npy\", spacing = \"30 um\", form = \"plane\" }"));
  EXPECT_THAT(text, HasSubstr("spacing = \"70 um\", z_unit = \"m\", form = \"plane\", short = "
                              "\"mirror\" }"));
  const Ended ran = run_ra2d(folder.path(), {"run", "case.toml"});
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("level Lv"));

  EXPECT_THAT(make({"--slider-face", "block.npy"}).err,
              AllOf(HasSubstr("the file has no spacing"), HasSubstr("FILE, 5 um, um")));
  EXPECT_THAT(make({"--slider-face", "block.npy, 30 um, km"}).err, HasSubstr("Z_UNIT"));
  EXPECT_THAT(make({"--slider-face", "nowhere.npy"}).err, HasSubstr("the file of a height map"));
  EXPECT_THAT(run_ra2d(folder.path(), {"new", "b.toml", "--slider-face", "block.npy"}).err,
              HasSubstr("a height map: --areal"));
}

TEST(NewScene, WhatIsWrittenRunsAtOnce) {
  const Folder folder;
  const Ended made = run_ra2d(folder.path(), {"new", "plate.toml", "--resonator",
                                              "steel,500x20x3mm", "--duration", "2 ms"});
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.err, "");
  const Ended ran = run_ra2d(folder.path(), {"run", "plate.toml"});
  EXPECT_EQ(ran.status, 0);
  EXPECT_EQ(ran.err, "");
  EXPECT_THAT(ran.out, HasSubstr("level Lv"));
}

TEST(NewScene, NeverReplacesAFileUnasked) {
  const Folder folder;
  std::ofstream(folder.path() / "mine.toml") << "mine";
  fs::create_symlink("nowhere", folder.path() / "link.toml");
  for (const char* name : {"mine.toml", "link.toml"}) {
    const Ended kept = run_ra2d(folder.path(), {"new", name, "--speed", "1 m/s"});
    EXPECT_EQ(kept.status, 2);
    EXPECT_THAT(kept.err, HasSubstr("is there already"));
  }
  EXPECT_EQ(read_file(folder.path() / "mine.toml"), "mine");
  EXPECT_EQ(run_ra2d(folder.path(), {"new", "mine.toml", "--speed", "1 m/s", "--force"}).status, 0);
  EXPECT_THAT(read_file(folder.path() / "mine.toml"), HasSubstr("speed    = \"1 m/s\""));
}

TEST(NewScene, WithoutATerminalSaysWhatToType) {
  const Folder folder;
  for (const Words& line : {Words{"new", "plate.toml"}, Words{"new"}}) {
    const Ended ended = run_ra2d(folder.path(), line);
    EXPECT_EQ(ended.status, 2);
    EXPECT_THAT(ended.err, HasSubstr("ra2d new plate.toml --resonator"));
  }
  EXPECT_THAT(run_ra2d(folder.path(), {"new", "plate.h5", "--speed", "1 m/s"}).err,
              HasSubstr("ends in .toml"));
  const Ended wrong = run_ra2d(folder.path(), {"new", "plate.toml", "--speed", "1 kg"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--speed: '1 kg' is a mass, not a speed"));
  EXPECT_FALSE(fs::exists(folder.path() / "plate.toml"));
}

TEST(NewScene, AsksOnATerminal) {
  const Folder folder;
  const Ended made =
      run_on_terminal(folder.path(), {"new", "plate.toml"},
                      "aluminum, 40x2x0.3 cm\n\n\nflatt\n4 um, 1 mm\n5\n50 mm/s\n\n\n20 ms\n");
  ASSERT_EQ(made.status, 0) << made.out;
  EXPECT_THAT(made.out,
              AllOf(HasSubstr("[steel, 300 x 200 x 2 mm]: "), HasSubstr("'flatt' is no file here"),
                    HasSubstr("'5' is a text without a unit"), HasSubstr("\rmaking the faces"),
                    HasSubstr("\r\033[K")));
  const Scene scene = read_scene(folder.path() / "plate.toml");
  EXPECT_EQ(scene.resonator.length, 0.4);
  EXPECT_EQ(scene.resonator.young, 70e9);
  EXPECT_EQ(scene.slider.surface.rq, 4e-6);
  EXPECT_EQ(scene.resonator.surface.rq, 8e-6);
  EXPECT_EQ(scene.speed, 0.05);
}

TEST(NewScene, CutOffAnswersWriteNothing) {
  const Folder folder;
  const Ended ended = run_on_terminal(folder.path(), {"new", "plate.toml"}, "\n\n\x04");
  EXPECT_EQ(ended.status, 2);
  EXPECT_THAT(ended.out, HasSubstr("nothing was written"));
  const Ended cut = run_on_terminal(folder.path(), {"new", "plate.toml"}, "\n\n\x03");
  EXPECT_EQ(cut.status, 130);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(NewScene, MaterialsHaveSourcesAndSensibleNumbers) {
  for (const Material& one : materials()) {
    EXPECT_GT(one.young, 1e9) << one.name;
    EXPECT_LT(std::sqrt(one.young / one.density), 6500) << one.name;  // m/s, a bar's sound
    EXPECT_GT(std::sqrt(one.young / one.density), 1000) << one.name;
    EXPECT_GT(one.poisson, 0.15) << one.name;
    EXPECT_LT(one.poisson, 0.4) << one.name;
    EXPECT_LE(one.least_loss, one.most_loss) << one.name;
    EXPECT_FALSE(one.source.empty()) << one.name;
    EXPECT_EQ(find_material(one.name), &one);
  }
  EXPECT_EQ(find_material("Aluminum")->name, "aluminium");
  EXPECT_EQ(find_material("cast iron")->name, "cast-iron");
  EXPECT_EQ(find_material(""), nullptr);
  EXPECT_EQ(find_material("s"), nullptr);
  const Folder folder;
  const Ended listed = run_ra2d(folder.path(), {"new", "--materials"});
  EXPECT_EQ(listed.status, 0);
  EXPECT_THAT(listed.out,
              AllOf(HasSubstr("steel "), HasSubstr("EN 1993-1-1"), HasSubstr("Beranek")));
}

// ---- ra2d scenes

TEST(Scenes, AreListedAndPrinted) {
  const Folder folder;
  const Ended list = run_ra2d(folder.path(), {"scenes"});
  EXPECT_EQ(list.status, 0);
  for (const InstalledScene& scene : installed_scenes()) {
    EXPECT_THAT(list.out, AllOf(HasSubstr("  " + scene.name), HasSubstr(scene.about)));
    EXPECT_FALSE(scene.about.empty()) << scene.name;
    EXPECT_EQ(scene.is_study, read_file(scene.file).find("[resonator]") == std::string::npos);
    EXPECT_EQ(run_ra2d(folder.path(), {"scenes", scene.name}).out, read_file(scene.file));
  }
  const Ended unknown = run_ra2d(folder.path(), {"scenes", "dang2021"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean 'dang2012'"));
  EXPECT_EQ(run_ra2d(folder.path(), {"scenes", "../secret"}).status, 2);
}

TEST(Scenes, AreRunByNameWhereNoFileHasIt) {
  const Folder folder;
  EXPECT_EQ(run_ra2d(folder.path(), {"run", "peaks", "--set", "scene.duration=1 ms"}).status, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "peaks.h5"));
  EXPECT_THAT(run_ra2d(folder.path(), {"plan", "drop"}).out, HasSubstr("[resonator]"));
  EXPECT_EQ(run_ra2d(folder.path(), {"study", "study-small", "--list"}).status, 0);
  const Ended unknown = run_ra2d(folder.path(), {"run", "peeks"});
  EXPECT_EQ(unknown.status, 4);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("there is no such file"), HasSubstr("'peaks'")));
  const Ended with_ending = run_ra2d(folder.path(), {"run", "peaks.toml"});
  EXPECT_EQ(with_ending.status, 4);
  EXPECT_THAT(with_ending.err, AllOf(HasSubstr("there is no such file"), HasSubstr("'peaks',")));
  EXPECT_THAT(run_ra2d(folder.path(), {"run", "mine.toml"}).err, HasSubstr("No such file"));
  std::ofstream(folder.path() / "drop") << "mine";
  EXPECT_THAT(run_ra2d(folder.path(), {"plan", "drop"}).err, HasSubstr("not TOML"));
}

}  // namespace
}  // namespace ra2d::test
