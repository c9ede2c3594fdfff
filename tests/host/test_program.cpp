// SPDX-License-Identifier: BSD-3-Clause
// The program as its users meet it: what it prints, what it writes, how it ends.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/device/backend.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

namespace {

namespace fs = std::filesystem;
using ra2d::test::Child;
using ra2d::test::Folder;
using ra2d::test::scene_file;
using ra2d::test::wait_until;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Program : public testing::Test {
 protected:
  Child start(std::vector<std::string> words) const {
    words.insert(words.begin(), ra2d::test::program());
    return {folder_, words};
  }
  int run(std::vector<std::string> words) {
    Child child = start(std::move(words));
    const int status = child.wait();
    out_ = child.out();
    err_ = child.err();
    return status;
  }
  int python(std::vector<std::string> words) {
    words[0] = ra2d::test::source_folder() / "tests/host" / words[0];
    words.insert(words.begin(), ra2d::test::python());
    Child child(folder_, words);
    const int status = child.wait();
    out_ = child.out();
    err_ = child.err();
    return status;
  }
  /// Waits until the run has opened its file under the temporary name, and has then worked for
  /// longer than it takes to make the march ready: by the processor's clock, for other programs may
  /// keep it waiting.
  void wait_until_it_marches(const Child& run) const {
    constexpr double ready = 0.3;  // s
    double opened = HUGE_VAL;
    const bool begun = wait_until([&] {
      for (const auto& entry : fs::directory_iterator(folder_))
        if (entry.path().string().find(".h5.partial") != std::string::npos)
          opened = std::min(opened, run.processor_seconds());
      return run.processor_seconds() > opened + ready;
    });
    ASSERT_TRUE(begun) << "no run began";
  }
  const Folder temporary_;
  const fs::path folder_ = temporary_.path();
  std::string out_, err_;
};

TEST_F(Program, HelpAndVersionSucceed) {
  EXPECT_EQ(run({"--help"}), 0);
  EXPECT_THAT(out_, AllOf(HasSubstr("run"), HasSubstr("plan"), HasSubstr("Exit status")));
  EXPECT_EQ(run({"run", "--help"}), 0);
  EXPECT_THAT(out_, AllOf(HasSubstr("--set"), HasSubstr("--threads"), HasSubstr("--quiet"),
                          HasSubstr("--output")));
  const std::string of_run = out_;
  EXPECT_EQ(run({"help", "run"}), 0);
  EXPECT_EQ(out_, of_run);
  EXPECT_EQ(run({"help"}), 0);
  EXPECT_THAT(out_, AllOf(HasSubstr("chart"), HasSubstr("Exit status")));
  EXPECT_EQ(run({"help", "chrt"}), 2);
  EXPECT_THAT(err_, HasSubstr("did you mean 'chart'?"));
  EXPECT_EQ(run({"--version"}), 0);
  EXPECT_THAT(out_, HasSubstr("ra2d 0."));
}

TEST_F(Program, ARunThatTheDiskHasNoRoomForIsNotBegun) {
  // 1e10 samples of some 50 numbers: four terabytes
  const fs::space_info disk = fs::space(folder_);
  if (disk.available > 3'000'000'000'000) GTEST_SKIP() << "this disk has room for it";
  EXPECT_EQ(run({"run", scene_file("dang2012"), "-o", "o.h5", "--set", "time.scheme=adaptive",
                 "--set", "output.rate=1e10"}),
            4);
  EXPECT_THAT(err_, AllOf(HasSubstr("'o.h5'"), HasSubstr("TB"), HasSubstr("free on its disk"),
                          HasSubstr("output.rate")));
  EXPECT_FALSE(fs::exists(folder_ / "o.h5"));
  // what no disk holds is refused as a request, and plan says what it would take
  EXPECT_EQ(run({"run", scene_file("dang2012"), "--set", "time.scheme=adaptive", "--set",
                 "output.rate=1e15"}),
            2);
  EXPECT_THAT(err_, HasSubstr("output.rate: 1000000000000000 Hz takes 1e+15 samples in 1 s"));
  EXPECT_EQ(run({"plan", scene_file("dang2012"), "--set", "time.scheme=adaptive", "--set",
                 "output.rate=1e10"}),
            0);
  EXPECT_THAT(out_, HasSubstr(" TB, 10000000001 samples"));
}

/// A file has whole chunks: short runs take far more than their samples.
TEST_F(Program, PlanTellsTheSizeOfTheFile) {
  for (const char* rate : {"1e3", "1e5", "1e6"})
    for (const char* precision : {"double", "float"}) {
      const std::vector<std::string> words{scene_file("dang2012"),
                                           "--set",
                                           "scene.duration=0.03",
                                           "--set",
                                           "time.scheme=adaptive",
                                           "--set",
                                           std::string("output.rate=") + rate,
                                           "--set",
                                           std::string("output.precision=") + precision};
      const auto with = [&](std::vector<std::string> all) {
        all.insert(all.end(), words.begin(), words.end());
        return all;
      };
      ASSERT_EQ(run(with({"plan", "--json"})), 0) << err_;
      const double planned = nlohmann::json::parse(out_)["file_bytes"];
      ASSERT_EQ(run(with({"run", "-o", "s.h5", "--force"})), 0) << err_;
      EXPECT_NEAR(planned / static_cast<double>(fs::file_size(folder_ / "s.h5")), 1, 0.1) << rate;
    }
}

TEST_F(Program, AnInterruptIsObeyedWithinAStepOfThousandsOfNodes) {
  // flat on flat, pressed 10 nm into one another: 5001 nodes carry force at once
  std::ofstream(folder_ / "flat.toml") << R"([scene]
duration = 1.0
speed = 0.0
start = 0.1
spacing = 4e-6
gap = -1e-8
initial = "rest"
[resonator]
support = "pinned"
length = 0.3
thickness = 2e-3
width = 2e-2
young = 210e9
density = 7800
damping = 0.02
max_frequency = 20e3
[slider]
support = "free"
length = 2e-2
thickness = 5e-3
width = 2e-2
young = 210e9
density = 7800
damping = 0.02
modes = 0
load = "weight"
[contact]
stiffness = 1e15
[time]
scheme = "backward-euler"
contact_force = "new"
step = 1e-7
)";
  Child child = start({"run", "flat.toml", "-o", "flat.h5", "--quiet"});
  wait_until_it_marches(child);
  const auto signalled = std::chrono::steady_clock::now();
  child.send(SIGINT);
  EXPECT_EQ(child.wait(), 130) << child.err();
  // a step took 37 s; generous, for machines that do other things as well
  EXPECT_LT(std::chrono::steady_clock::now() - signalled, std::chrono::seconds(20));
}

TEST_F(Program, WrongRequestsEndWithTwoAndSayWhy) {
  EXPECT_EQ(run({}), 2);
  EXPECT_EQ(run({"run"}), 2);
  EXPECT_THAT(err_, HasSubstr("SCENE"));
  EXPECT_EQ(run({"rnu", scene_file("peaks")}), 2);
  EXPECT_THAT(err_, HasSubstr("'ra2d' has no command 'rnu' (did you mean 'run'?)"));
  EXPECT_EQ(run({"chart", "stabilty"}), 2);
  EXPECT_THAT(err_,
              HasSubstr("'ra2d chart' has no command 'stabilty' (did you mean 'stability'?)"));
  EXPECT_EQ(run({"run", scene_file("peaks"), "--treads", "2"}), 2);
  EXPECT_THAT(err_, HasSubstr("'ra2d run' has no option '--treads' (did you mean '--threads'?)"));
  EXPECT_EQ(run({"chart", "accuracy", "--buget=3"}), 2);
  EXPECT_THAT(err_, HasSubstr("has no option '--buget' (did you mean '--budget'?)"));
  EXPECT_EQ(run({"analyse", "x.h5"}), 2);
  EXPECT_THAT(err_, HasSubstr("(did you mean 'analyze'?)"));
  EXPECT_EQ(run({"chek", "x.toml"}), 2);
  EXPECT_THAT(err_, HasSubstr("(did you mean 'check'?)"));
  EXPECT_EQ(run({"studdy", "x.toml"}), 2);
  EXPECT_THAT(err_, HasSubstr("(did you mean 'study'?)"));
  EXPECT_EQ(run({"run", scene_file("fig5")}), 2);
  EXPECT_THAT(err_, HasSubstr("run it with 'ra2d study'"));
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"run", scene_file("drop"), "-o", ""},
           {"run", scene_file("drop"), "--output="},
           {"run", ""},
           {"plan", scene_file("drop"), "--accuracy", "0.1", "-o", ""},
           {"chart", "stability", "-o", ""},
           {"chart", "stability", ""},
           {"chart", "accuracy", "--peers", ""}}) {
    EXPECT_EQ(run(words), 2) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_NE(err_, "");
    EXPECT_EQ(out_, "");
  }
  EXPECT_FALSE(fs::exists(folder_ / "drop.h5"));
  EXPECT_EQ(run({"run", scene_file("peaks"), "--set", "scene.sped=1", "--set", "time.step=-1"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("2 faults"), HasSubstr("scene.sped"), HasSubstr("`speed`"),
                          HasSubstr("time.step")));
  EXPECT_FALSE(fs::exists(folder_ / "peaks.h5"));
}

TEST_F(Program, TheSceneMayFollowAnOptionThatMayBeRepeated) {
  const std::string scene = scene_file("drop");
  EXPECT_EQ(run({"run", "--set", "scene.duration=1e-4", scene, "-o", "o.h5"}), 0) << err_;
  EXPECT_EQ(run({"run", "--set", "scene.duration=1e-4", "--zoom", "0,1e-5", scene, "-o", "z.h5"}),
            0)
      << err_;
  EXPECT_EQ(run({"run", scene, "--set", "scene.duration=1e-4", "scene.speed=1", "-o", "p.h5"}), 2);
}

TEST_F(Program, NumbersOfTheCommandLineAreRefusedBeforeAnythingRuns) {
  for (const char* budget : {"nan", "inf", "0", "-3", "1e300", "", "1e", "x"}) {
    EXPECT_EQ(run({"chart", "accuracy", "--budget", budget}), 2) << budget;
    EXPECT_THAT(err_, HasSubstr("--budget")) << budget;
    EXPECT_EQ(run({"plan", scene_file("peaks"), "--accuracy", "0.1", "--budget", budget}), 2);
    EXPECT_THAT(err_, HasSubstr("--budget")) << budget;
  }
  for (const char* accuracy : {"nan", "inf", "0", "1", "-0.1", "x"}) {
    EXPECT_EQ(run({"plan", scene_file("peaks"), "--accuracy", accuracy}), 2) << accuracy;
    EXPECT_THAT(err_, HasSubstr("--accuracy"));
  }
  for (const char* threads : {"nan", "inf", "0", "-1", "1.5", "1e9", "1e300", "x", ""}) {
    EXPECT_EQ(run({"plan", scene_file("peaks"), "--threads", threads}), 2) << threads;
    EXPECT_THAT(err_, AllOf(HasSubstr("--threads"), HasSubstr("whole number in digits")));
  }
  // a number is one in decimals
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"chart", "accuracy", "--budget", "0x10"},
           {"plan", scene_file("peaks"), "--accuracy", "0x1p-3"},
           {"run", scene_file("peaks"), "--checkpoint", "0x1p3"},
           {"run", scene_file("peaks"), "--max-wall", "0x10"},
           {"run", scene_file("peaks"), "--max-wall", "1:0x10"},
           {"run", scene_file("peaks"), "--device", "0x1"},
           {"sound", "x.h5", "--slow", "0x2"},
           {"sound", "x.h5", "--rate", "0xbb80"},
           {"analyze", "x.h5", "--from", "0x1"},
           {"surface", "generate", "-o", "p", "--length", "0x1p-3", "--spacing", "1e-4", "--rq",
            "1e-6", "--rsm", "1e-3"},
           {"surface", "generate", "-o", "p", "--length", "0.1", "--spacing", "1e-4", "--rq",
            "1e-6", "--rsm", "1e-3", "--seed", "0x10"}}) {
    EXPECT_EQ(run(words), 2) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_THAT(err_, HasSubstr("0x")) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_THAT(err_, HasSubstr("expected")) << fmt::format("{}", fmt::join(words, " "));
  }
  for (const char* seed : {"10", "010"})  // no octal one
    ASSERT_EQ(
        run({"surface", "generate", "-o", fmt::format("of-{}.csv", seed), "--length", "0.01",
             "--spacing", "1e-4", "--rq", "1e-6", "--rsm", "1e-3", "--seed", seed, "--quiet"}),
        0)
        << err_;
  EXPECT_EQ(ra2d::test::read_file(folder_ / "of-010.csv"),
            ra2d::test::read_file(folder_ / "of-10.csv"));
  for (const char* wall : {"-1", "-0:0:1", "1:-0", "0:0:0", "1:60", "1:99", "1:59:60", "1:2:3:4",
                           "1:", ":1", "1:30.5.1", "nan"}) {
    EXPECT_EQ(run({"run", scene_file("peaks"), fmt::format("--max-wall={}", wall)}), 2) << wall;
    EXPECT_THAT(err_, AllOf(HasSubstr("--max-wall"), HasSubstr("M:S or H:M:S"))) << wall;
  }
  for (const char* wall : {"90:00", "100", "1:30.5", "0:01:30", "72:00:00"})
    EXPECT_EQ(run({"run", scene_file("drop"), "--set", "scene.duration=1e-4", "--fresh",
                   fmt::format("--max-wall={}", wall)}),
              0)
        << wall << err_;
  EXPECT_EQ(run({"chart", "stability", "--set", "resonator.max_frequency=1e9"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("resonator.max_frequency"), HasSubstr("at most 256")));
}

TEST_F(Program, MoreThreadsThanThereAreAreLowered) {
  for (const char* threads : {"513", "100000", "99999999999999999999"}) {
    EXPECT_EQ(run({"plan", scene_file("peaks"), "--threads", threads}), 0) << err_;
    EXPECT_THAT(err_, AllOf(testing::StartsWith("ra2d: "), HasSubstr(" thread"),
                            HasSubstr(std::thread::hardware_concurrency() < 512
                                          ? " here"
                                          : "a march takes at most")));
  }
  EXPECT_EQ(run({"plan", scene_file("peaks"), "--threads", "513", "--quiet"}), 0);
  EXPECT_EQ(err_, "");
}

TEST_F(Program, TheVariablesOfKokkosEndNothing) {
  for (const char* variable : {"KOKKOS_NUM_THREADS=0", "KOKKOS_NUM_THREADS=abc",
                               "KOKKOS_DEVICE_ID=-1", "KOKKOS_MAP_DEVICE_ID_BY=foo",
                               "KOKKOS_DISABLE_WARNINGS=foo", "KOKKOS_TUNE_INTERNALS=foo"}) {
    Child child(folder_, {"env", variable, ra2d::test::program(), "run", scene_file("drop"),
                          "--set", "scene.duration=1e-4", "--fresh", "-o", "o.h5"});
    EXPECT_EQ(child.wait(), 0) << variable << child.err();
  }
}

TEST_F(Program, WhatCannotBePrintedEndsWithFourAndIsWrittenAllTheSame) {
  const auto shell = [&](const std::string& command) {
    Child child(folder_, {"/bin/sh", "-c", command});
    const int status = child.wait();
    err_ = child.err();
    return status;
  };
  const std::string p = '\'' + ra2d::test::program() + "' ",
                    drop = '\'' + scene_file("drop") + "' --set scene.duration=1e-4";
  ASSERT_EQ(shell(p + "run -o s.h5 " + drop), 0);
  for (const char* broken : {" >/dev/full", " >&-"}) {
    for (const std::string& words :
         {std::string("--help"), std::string("--version"), std::string("help run"), "plan " + drop,
          "run -o r.h5 " + drop}) {
      EXPECT_EQ(shell(p + words + broken), 4) << words << broken;
      EXPECT_THAT(err_, HasSubstr("cannot write to the standard output: "));
    }
    ASSERT_TRUE(fs::exists(folder_ / "r.h5"));
    EXPECT_EQ(fs::file_size(folder_ / "r.h5"), fs::file_size(folder_ / "s.h5"));
    fs::remove(folder_ / "r.h5");
    // nothing was to be printed
    EXPECT_EQ(shell(p + "run --quiet -o r.h5 " + drop + broken), 0) << err_;
  }
  // a fault keeps its own status wherever there is one
  EXPECT_EQ(shell(p + "run nowhere.toml >/dev/full 2>/dev/full"), 4);
  EXPECT_EQ(shell(p + "runn >&- 2>&-"), 2);
  // a reader who has seen enough
  EXPECT_EQ(shell(p + "plan " + drop + " | head -n 1"), 0);
  EXPECT_EQ(err_, "");
}

TEST_F(Program, AReaderThatHasGoneEndsItQuietly) {
  const std::string p = '\'' + ra2d::test::program() + "' ",
                    drop = '\'' + scene_file("drop") + "' --set scene.duration=1e-4";
  // The program begins when nobody reads any more.
  const auto status_of = [&](const std::string& words) {
    fs::remove(folder_ / "gone");
    Child child(folder_, {"/bin/sh", "-c",
                          "(until [ -e gone ]; do sleep 0.01; done; " + p + words +
                              "; echo $? >status) | (exec <&-; touch gone)"});
    child.wait();
    err_ = child.err();
    return ra2d::test::read_file(folder_ / "status");
  };
  for (const std::string& words : {std::string("--help"), "plan " + drop, "run -o r.h5 " + drop,
                                   std::string("analyze r.h5 --json")}) {
    EXPECT_EQ(status_of(words), "141\n") << words;  // as of a program that SIGPIPE ends
    EXPECT_EQ(err_, "") << words;
  }
  EXPECT_EQ(run({"check", "r.h5"}), 0) << err_;  // what is written is finished all the same
  EXPECT_EQ(status_of("run --quiet -o q.h5 " + drop), "0\n");
  EXPECT_EQ(status_of("run nowhere.toml"), "4\n");
}

TEST_F(Program, ALimitOfFileSizesIsAFault) {
  // HDF5 forgets the names of what it could not write, which only the leak sanitizer minds
  Child child(folder_, {"/bin/sh", "-c",
                        "ulimit -f 8; exec env ASAN_OPTIONS=detect_leaks=0 '" +
                            ra2d::test::program() + "' run '" + scene_file("drop") + "'"});
  EXPECT_EQ(child.wait(), 4);
  EXPECT_THAT(child.err(), HasSubstr("drop.h5"));
  EXPECT_FALSE(fs::exists(folder_ / "drop.h5"));
}

TEST_F(Program, ControlCharactersAreNotPrinted) {
  const std::string scene = "e\x1b[31m\xc2\x9b.toml";
  fs::copy_file(scene_file("drop"), folder_ / scene);
  // those that end a line, turn the direction of writing, or are not seen, too
  const std::vector<std::string> controls{"\x1b",   "\xc2\x9b", "\u2028", "\u202e",
                                          "\u2066", "\u200f",   "\ufeff"};
  const auto is_raw = [&](const std::string& text) {
    return std::any_of(controls.begin(), controls.end(), [&](const std::string& control) {
      return text.find(control) != std::string::npos;
    });
  };
  const std::vector<std::vector<std::string>> requests{
      {"run", scene, "--set", "scene.duration=1e-4", "--set", "scene.name=\"a\\u001b[31mb\""},
      {"run", scene, "--set", "scene.duration=1e-4", "--set",
       "scene.name=\u2028 \u202e \u2066 \u200f \ufeff"},
      {"run", scene, "--set", "scene.duration=1e-4", "-o", "o\x1b[31m.h5"},
      {"plan", scene, "--set", "scene.name=\x1b[31m"},
      {"run", scene, "--set", "scene.\x1b=1", "--set", "time.step=\x1b"},
      {"run", scene, "--set", "slider.surface={kind=\"file\", path=\"\\u001b\"}"},
      {"run", "no\x1b.toml"},
      {"\x1b"},
      {"run", scene, "--\x1b"},
      {"run", scene, "\x1b"}};
  for (const std::vector<std::string>& words : requests) {
    EXPECT_LE(run(words), 4);
    EXPECT_NE(out_ + err_, "");
    EXPECT_FALSE(is_raw(out_ + err_)) << fmt::format("{}", fmt::join(words, " "));
  }
}

TEST_F(Program, AdaptiveWithMultipliersIsRefusedWithTheReason) {
  EXPECT_EQ(run({"run", scene_file("peaks"), "--set", "time.scheme=adaptive", "--set",
                 "contact.law=multiplier"}),
            2);
  EXPECT_THAT(err_, AllOf(HasSubstr("contact.law"), HasSubstr("what an impact gives back"),
                          HasSubstr("expected \"penalty\"")));
  EXPECT_FALSE(fs::exists(folder_ / "peaks.h5"));
}

TEST_F(Program, FilesThatCannotBeReadOrWrittenEndWithFour) {
  EXPECT_EQ(run({"run", "nowhere.toml"}), 4);
  EXPECT_THAT(err_, HasSubstr("nowhere.toml"));
  EXPECT_EQ(run({"run", scene_file("peaks"), "-o", "no/such/folder/out.h5"}), 4);
  EXPECT_THAT(err_, HasSubstr("no/such/folder"));
  EXPECT_EQ(run({"run", scene_file("peaks"), "--set",
                 "resonator.surface={ kind = \"file\", path = \"missing.csv\" }"}),
            4);
  EXPECT_THAT(err_, AllOf(HasSubstr("resonator.surface"), HasSubstr("missing.csv")));
}

TEST_F(Program, NoInputIsOverwrittenByAnyName) {
  const std::string text = ra2d::test::read_file(scene_file("peaks"));
  const std::string profile = "x,z\n0,0\n1,0\n";
  const auto write = [&](const char* name, const std::string& what) {
    std::ofstream(folder_ / name) << what;
  };
  for (const char* name : {"s.toml", "s.h5"}) write(name, text);
  write("q.csv", "#!/bin/sh\n");
  fs::permissions(folder_ / "q.csv", fs::perms::owner_exec, fs::perm_options::add);
  // a profile that has the name of each file that a command writes
  for (const char* name : {"p.csv", "p-regions.csv", "p-long.csv", "p.png"}) write(name, profile);
  fs::create_symlink("s.toml", folder_ / "soft.toml");
  fs::create_hard_link(folder_ / "s.toml", folder_ / "hard.toml");
  fs::create_directory(folder_ / "sub");
  const auto slider = [&](const char* name) {
    return std::string("slider.surface={ kind = \"file\", path = \"") + name + "\" }";
  };
  const std::vector<std::vector<std::string>> requests = {
      {"run", "s.toml", "-o", "s.toml"},
      {"run", "s.toml", "-o", "sub/../s.toml"},
      {"run", "s.toml", "-o", (folder_ / "s.toml").string()},
      {"run", "s.toml", "-o", "soft.toml"},
      {"run", "soft.toml", "-o", "s.toml"},
      {"run", "s.toml", "-o", "hard.toml"},
      {"run", "s.h5"},  // goes to s.h5
      {"run", "s.toml", "--set", slider("p.csv"), "-o", "p.csv"},
      {"plan", "--accuracy", "0.1", "s.toml", "-o", "soft.toml"},
      {"plan", "--accuracy", "0.1", "s.toml", "--set", slider("p.csv"), "-o", "p.csv"},
      {"chart", "stability", "s.toml", "--set", slider("p-regions.csv"), "-o", "p"},
      {"chart", "accuracy", "s.toml", "--set", slider("p-long.csv"), "-o", "p"},
      {"chart", "accuracy", "s.toml", "--set", slider("p.png"), "-o", "p"},
      {"chart", "accuracy", "s.toml", "--peers", "./q.csv", "-o", "q", "--no-plot"}};
  for (const std::vector<std::string>& words : requests) {
    EXPECT_EQ(run(words), 2) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_THAT(err_, AllOf(HasSubstr("would be overwritten"), HasSubstr("-o")));
    EXPECT_EQ(out_, "");
    for (const char* name : {"s.toml", "s.h5", "soft.toml", "hard.toml"})
      EXPECT_EQ(ra2d::test::read_file(folder_ / name), text) << name;
    for (const char* name : {"p.csv", "p-regions.csv", "p-long.csv", "p.png"})
      EXPECT_EQ(ra2d::test::read_file(folder_ / name), profile) << name;
    EXPECT_EQ(ra2d::test::read_file(folder_ / "q.csv"), "#!/bin/sh\n");
  }
}

TEST_F(Program, OnlyRegularFilesAreReplaced) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", folder_ / "link");
  fs::create_symlink("pipe", folder_ / "link.csv");
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);  // what /dev/stdout is in a pipeline: no link names it
  fs::create_symlink(fmt::format("/proc/{}/fd/{}", getpid(), ends[1]), folder_ / "piped");
  std::vector<std::vector<std::string>> requests = {
      {"run", scene_file("peaks"), "-o", "pipe"},
      {"run", scene_file("peaks"), "-o", "link"},
      {"run", scene_file("peaks"), "-o", "piped"},
      {"run", scene_file("peaks"), "-o", "."},
      {"plan", "--accuracy", "0.1", scene_file("peaks"), "-o", "link"},
      {"chart", "stability", scene_file("peaks"), "-o", "link"}};
  // a null device of our own: a program at fault must not replace the system's
  if (mknod((folder_ / "device").c_str(), S_IFCHR | 0600, makedev(1, 3)) == 0)
    requests.push_back({"run", scene_file("peaks"), "-o", "device"});
  for (const std::vector<std::string>& words : requests) {
    EXPECT_EQ(run(words), 2) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_THAT(err_, HasSubstr("cannot write to"));
    EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
    EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  }
  EXPECT_EQ(fs::exists(folder_ / "device"), fs::is_character_file(folder_ / "device"));
  // a link to a file is followed, and stays
  std::ofstream(folder_ / "old.h5") << "an earlier result";
  fs::create_symlink("old.h5", folder_ / "latest.h5");
  ASSERT_EQ(run({"run", scene_file("drop"), "-o", "latest.h5", "--force"}), 0) << err_;
  EXPECT_TRUE(fs::is_symlink(folder_ / "latest.h5"));
  EXPECT_GT(fs::file_size(folder_ / "old.h5"), 1000u);
}

TEST_F(Program, AProfileThatIsTooShortNamesTheBody) {
  std::ofstream(folder_ / "short.csv") << "x,z\n0,0\n1e-3,1e-6\n2e-3,0\n";
  EXPECT_EQ(run({"run", scene_file("peaks"), "--set",
                 fmt::format("slider.surface={{ kind = \"file\", path = \"{}\" }}",
                             (folder_ / "short.csv").string())}),
            2);
  EXPECT_THAT(err_, AllOf(HasSubstr("--set slider.surface={"), HasSubstr(": slider.surface: "),
                          HasSubstr("short.csv:4: the profile is 0.002 m long")));
}

/// Multipliers part faces that overlap by the roundings of their heights: at steps of 10 ns with up
/// to 1e-23 J, far more than so light a load supplies.
TEST_F(Program, EnergiesThatAreRoundingsAreNotUnstable) {
  for (const char* step : {"1e-8", "1e-7"})
    EXPECT_EQ(run({"run", scene_file("dang2012"), "--force", "--set", "contact.law=multiplier",
                   "--set", "slider.load=1e-9", "--set", "scene.speed=0", "--set",
                   "scene.initial=rest", "--set", "scene.duration=1e-4", "--set",
                   "time.scheme=exact", "--set", std::string("time.step=") + step}),
              0)
        << err_;
}

TEST_F(Program, WhatLooksOddInAProfileIsSaid) {
  std::ofstream(folder_ / "cut.csv") << "x,z\n0,0.0e-00\n0.1,1.5e-06\n0.2,2.5e-06\n0.3,1e-06";
  const std::string face =
      "resonator.surface={ kind = \"file\", path = \"" + (folder_ / "cut.csv").string() + "\" }";
  for (const char* command : {"plan", "run"}) {
    EXPECT_EQ(run({command, scene_file("drop"), "--set", face, "--set", "scene.duration=1e-5"}), 0);
    EXPECT_THAT(err_, HasSubstr("cut.csv:5: the last line has no end")) << command;
  }
}

TEST_F(Program, ThatAProfileIsRepeatedIsSaidOnceAndNotWhereNothingRuns) {
  std::string text = "x [mm]; z [um]\n";
  for (int i = 0; i <= 400; ++i)
    text += fmt::format("{:.2f};{:.6f}\n", 0.01 * i, std::sin(0.05 * i));
  std::ofstream(folder_ / "short.csv") << text;
  std::vector<std::string> words{"run", scene_file("dang2012"), "-o", "r.h5"};
  for (const char* body : {"slider", "resonator"})
    words.insert(words.end(), {"--set", fmt::format("{}.surface={{ kind = \"file\", path = \"{}\", "
                                                    "short = \"repeat\" }}",
                                                    body, (folder_ / "short.csv").string())});
  for (const char* set : {"scene.duration=1e-4", "scene.spacing=4e-5", "time.scheme=adaptive",
                          "contact.stiffness=1e12"})
    words.insert(words.end(), {"--set", set});
  EXPECT_EQ(run(words), 0) << err_;
  const auto times = [&](const std::string& what) {
    std::size_t count = 0;
    for (std::size_t at = err_.find(what); at != err_.npos; at = err_.find(what, at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(times("repeated every"), 1) << err_;
  EXPECT_THAT(err_,
              HasSubstr("short.csv: 0.004 m long, less than the beam: repeated every 0.0044 m"));
  EXPECT_EQ(run(words), 0);
  EXPECT_THAT(out_, HasSubstr("nothing to do"));
  EXPECT_EQ(times("repeated every"), 0) << err_;
  words.insert(words.end(), {"--fresh", "--quiet"});
  EXPECT_EQ(run(words), 0);
  EXPECT_EQ(err_, "");
}

TEST_F(Program, RefusalsAfterTheReadingNameFileLineAndKey) {
  EXPECT_EQ(run({"run", scene_file("drop"), "--set", "scene.spacing=1e-2"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("--set scene.spacing=1e-2: scene.spacing: "),
                          HasSubstr("nodes to a wavelength")));
}

TEST_F(Program, ARunPrintsWhatItFoundAndWritesAFileThatOpensEverywhere) {
  RA2D_SKIP_WITHOUT_PYTHON();
  ASSERT_EQ(run({"run", scene_file("peaks")}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("level Lv"), HasSubstr("dB"), HasSubstr("shocks"),
                          HasSubstr("duration"), HasSubstr("peak force"), HasSubstr("in contact"),
                          HasSubstr("nodes evaluated"), HasSubstr("energy"), HasSubstr("s a step"),
                          HasSubstr("peaks.h5")));
  EXPECT_EQ(err_, "") << "progress goes to a terminal only";
  ASSERT_TRUE(fs::exists(folder_ / "peaks.h5"));
  EXPECT_EQ(python({"check_result.py", "peaks.h5"}), 0) << out_ << err_;
}

TEST_F(Program, TheEchoInTheFileRunsAgainToTheSameResult) {
  RA2D_SKIP_WITHOUT_PYTHON();
  ASSERT_EQ(
      run({"run", scene_file("drop"), "--quiet", "--set", "contact.stiffness=5e14", "-o", "a.h5"}),
      0)
      << err_;
  EXPECT_EQ(out_, "");
  std::ofstream(folder_ / "get.py")
      << "import h5py\nopen('again.toml','w').write(h5py.File('a.h5').attrs['scene'])\n";
  Child get(folder_, {ra2d::test::python(), "get.py"});
  ASSERT_EQ(get.wait(), 0) << get.err();
  EXPECT_THAT(ra2d::test::read_file(folder_ / "again.toml"), HasSubstr("stiffness = 5e14"));
  ASSERT_EQ(run({"run", "again.toml", "-o", "b.h5"}), 0) << err_;
  EXPECT_EQ(python({"same_result.py", "a.h5", "b.h5"}), 0) << out_ << err_;
}

TEST_F(Program, TheResultDoesNotDependOnThreadsOrOnWhatIsLookedAt) {
  RA2D_SKIP_WITHOUT_PYTHON();
  const std::vector<std::string> common{"run", scene_file("dang2012"), "--set",
                                        "scene.duration=0.001"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), common.begin(), common.end());
    return run(more);
  };
  ASSERT_EQ(with({"--threads", "1", "-o", "one.h5"}), 0) << err_;
  ASSERT_EQ(with({"--threads", "2", "-o", "two.h5"}), 0) << err_;
  EXPECT_EQ(python({"same_result.py", "one.h5", "two.h5"}), 0) << out_ << err_;
  ASSERT_EQ(with({"--set", "time.nodes=all", "-o", "all.h5"}), 0) << err_;
  EXPECT_EQ(python({"same_result.py", "one.h5", "all.h5"}), 0) << out_ << err_;
}

TEST_F(Program, ABuildForTheCpuHasNoDevices) {
  if (!ra2d::backend_device().empty()) GTEST_SKIP() << "marches on " << ra2d::backend_device();
  EXPECT_EQ(run({"run", scene_file("drop"), "--device", "0", "-o", "x.h5"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("--device 0"), HasSubstr("docs/building.md")));
  EXPECT_FALSE(fs::exists(folder_ / "x.h5"));
  EXPECT_EQ(run({"run", scene_file("drop"), "--device", "-1", "-o", "x.h5"}), 2);
}

TEST_F(Program, GeneratesTheProfileThatASceneHas) {
  const std::vector<std::string> words{
      "surface",       "generate",    "-o",         "rough.csv", "--length",   "0.02",
      "--spacing",     "2e-5",        "--rq",       "1e-6",      "--rsm",      "4e-4",
      "--correlation", "exponential", "--shortest", "1e-4",      "--skewness", "-0.5",
      "--kurtosis",    "4",           "--seed",     "3"};
  ASSERT_EQ(run(words), 0) << err_;
  const std::string words_of_surface =
      "surface = { kind = \"gaussian\", rq = 1e-06, rsm = 0.0004, correlation = \"exponential\", "
      "shortest = "
      "0.0001, skewness = -0.5, kurtosis = 4.0, seed = 3 }";
  EXPECT_THAT(out_,
              AllOf(HasSubstr("1001 nodes, 2e-05 m apart"), HasSubstr("Rq                  0.999"),
                    HasSubstr(words_of_surface), HasSubstr("rough.csv")));
  std::ifstream file(folder_ / "rough.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_THAT(line, HasSubstr(words_of_surface));
  std::getline(file, line);
  EXPECT_EQ(line, "x [m],z [m]");
  int lines = 0;
  for (; std::getline(file, line); ++lines)
    if (lines == 1) {
      EXPECT_TRUE(line.starts_with("0.00002,")) << line;
    }
  EXPECT_EQ(lines, 1001);

  // a scene takes either, and comes to the same
  const auto scene_with = [&](const std::string& surface) {
    return run({"run", "--force", scene_file("drop"), "-o", "x.h5", "--set", "slider." + surface,
                "--set", "scene.duration=1e-4", "--set", "scene.gap=touching"});
  };
  EXPECT_EQ(scene_with("surface={ kind = \"file\", path = \"" + (folder_ / "rough.csv").string() +
                       "\" }"),
            0)
      << err_;
  const std::string by_file = out_.substr(out_.find("level"), 60);
  EXPECT_EQ(scene_with(words_of_surface), 0) << err_;
  EXPECT_EQ(out_.substr(out_.find("level"), 60), by_file);
}

// In decimals where they are short, as doubles where they are not, a place is n times the spacing
// to a rounding each.
TEST_F(Program, GeneratesPlacesAsInstrumentsWriteThem) {
  for (const auto& [spacing, third] :
       std::vector<std::pair<std::string, std::string>>{{"2e-5", "0.00006"},
                                                        {"1.25e-5", "0.0000375"},
                                                        {"0.001", "0.003"},
                                                        {"1", "3"},
                                                        {"1.0000000000000001e-05", ""}}) {
    const double apart = std::stod(spacing);
    const auto number = [](double value) { return fmt::format("{}", value); };
    ASSERT_EQ(run({"surface", "generate", "-o", "rough.csv", "--length", number(20 * apart),
                   "--spacing", spacing, "--rq", number(apart / 10), "--rsm", number(10 * apart)}),
              0)
        << err_;
    std::ifstream file(folder_ / "rough.csv");
    std::string line;
    for (int header = 0; header < 2; ++header) std::getline(file, line);
    for (int n = 0; n <= 20; ++n) {
      ASSERT_TRUE(std::getline(file, line));
      const std::string place = line.substr(0, line.find(','));
      if (n == 3 && !third.empty()) {
        EXPECT_EQ(place, third);
      }
      EXPECT_NEAR(std::stod(place), n * apart, n * apart * 0x1p-52);
    }
  }
}

TEST_F(Program, DescribesAGeneratedProfileOfAnyHeight) {
  const auto moments_of = [&](const char* rq) {
    EXPECT_EQ(run({"surface", "generate", "-o", "rough.csv", "--length", "0.02", "--spacing",
                   "2e-5", "--rq", rq, "--rsm", "1e-3"}),
              0)
        << err_;
    const std::size_t at = out_.find("skewness");
    return out_.substr(at, out_.find('\n', at) - at);
  };
  const std::string usual = moments_of("1e-6");
  EXPECT_EQ(moments_of("1e-300"), usual);  // of which no square is a double
  EXPECT_THAT(out_, HasSubstr("Rq                  1e-294 um"));
}

TEST_F(Program, GeneratesNothingThatDoesNotFitTogether) {
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"surface", "generate",  "-o",   "rough.csv", "--length",
                                   "0.02",    "--spacing", "2e-5", "--rq",      "1e-6"};
    words.insert(words.end(), more.begin(), more.end());
    const int status = run(words);
    EXPECT_FALSE(fs::exists(folder_ / "rough.csv"));
    return status;
  };
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{}, "rsm or correlation_length"},
      {{"--rsm", "5e-5"}, "not resolved by --spacing"},
      {{"--rsm", "nan"}, "expected a number > 0"},
      {{"--rsm", "-1"}, "expected a number > 0"},
      {{"--rsm", "1e-3", "--correlation-length", "1e-3"}, "excludes"},
      {{"--rsm", "1e-3", "--kurtosis", "1"}, "expected a kurtosis from skewness^2"},
      {{"--rsm", "1e-3", "--correlation", "self-affine"}, "hurst"},
      {{"--rsm", "1e-3", "--hurst", "0.8"}, "--hurst is of --correlation self-affine"},
      {{"--rsm", "1e-3", "--correlation", "exponential", "--longest", "1e-2"}, "--longest is of"},
      {{"--rsm", "1e-3", "--shortest", "1e-4"}, "--shortest is of --correlation exponential"},
      {{"--correlation", "fractal"}, "fractal"},
      {{"--correlation-length", "1e-3", "--exact", "rq+rsm"}, "needs --rsm"},
      {{"--rsm", "1e-3", "--seed", "9223372036854775808"}, "as in a scene"},
      {{"--rsm", "1e-3", "--spacing", "1e-12"}, "spacing"}};
  for (const auto& [more, says] : cases) {
    EXPECT_EQ(with(more), 2) << says;
    EXPECT_THAT(err_, testing::HasSubstr(says));
  }
  EXPECT_EQ(run({"surface", "generate", "-o", "no/such/folder.csv", "--length", "0.02", "--spacing",
                 "2e-5", "--rq", "1e-6", "--rsm", "1e-3"}),
            4);
  EXPECT_THAT(err_, HasSubstr("no/such"));
}

TEST_F(Program, PlanRunsNothingAndSaysWhatWouldBeModelled) {
  ASSERT_EQ(run({"plan", scene_file("dang2012")}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("19 modes"), HasSubstr("2501"), HasSubstr("100000000 steps"),
                          HasSubstr("stability"), HasSubstr("memory"), HasSubstr("rsm = 0.00155")));
  EXPECT_FALSE(fs::exists(folder_ / "dang2012.h5"));
  ASSERT_EQ(run({"plan", scene_file("dang2012"), "--set", "time.tolerance=1e-6", "--set",
                 "time.step=1e-4", "--set", "output.rate=1e3"}),
            0)
      << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("not used"), HasSubstr("'ra2d run' refuses it")));
}

const std::vector<std::string> long_run{
    "run", scene_file("dang2012"), "--set", "scene.duration=0.9", "--set", "time.step=2e-10"};

TEST_F(Program, ASignalEndsTheRunCleanlyWithWhatThereIs) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    Child child = start(long_run);
    wait_until_it_marches(child);
    if (ra2d::backend_device().empty()) {  // a GPU's driver has some of its own
      // the thread that writes the file's beginning ends by itself
      EXPECT_TRUE(wait_until([&] { return child.threads() == 1; }))
          << "there may be no more to be had (ulimit -u)";
    }
    child.send(signal);
    EXPECT_EQ(child.wait(), 128 + signal) << child.err();
    EXPECT_THAT(child.err(), HasSubstr("interrupted at t ="));
    ASSERT_TRUE(fs::exists(folder_ / "dang2012.h5"));
    if (signal == SIGINT && !ra2d::test::python().empty()) {
      EXPECT_EQ(python({"check_result.py", "dang2012.h5"}), 0) << out_ << err_;
      std::ofstream(folder_ / "cut.py")
          << "import h5py\nf = h5py.File('dang2012.h5')\n"
             "assert f.attrs['complete'] == 0 and f.attrs['ended'] == 'interrupted'\n"
             "assert f.attrs['steps'] > 0\n";
      Child cut(folder_, {ra2d::test::python(), "cut.py"});
      EXPECT_EQ(cut.wait(), 0) << cut.err();
    }
    fs::remove(folder_ / "dang2012.h5");
  }
}

TEST_F(Program, ASecondSignalEndsTheRunAtOnceWithoutAWreck) {
  Child child = start(long_run);
  wait_until_it_marches(child);
  child.send(SIGSTOP);  // so that both are there when it goes on
  child.send(SIGINT);
  child.send(SIGTERM);
  child.send(SIGCONT);
  EXPECT_EQ(child.wait(), 128 + SIGTERM) << child.err();
  EXPECT_THAT(child.err(), HasSubstr("only what a checkpoint holds is kept"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);  // what it printed
}

TEST_F(Program, ASignalEndsEverythingElseAtOnce) {
  // with far too much to do before the first step
  const std::string scene = scene_file("dang2012"), set = "scene.spacing=2e-8";
  const std::vector<std::vector<std::string>> requests = {
      {"run", scene, "--set", set},
      {"plan", scene, "--set", set},
      {"plan", "--accuracy", "0.1", scene, "--set", set},
      {"chart", "stability"},
      {"chart", "accuracy", scene, "--set", set},
      {"run", scene, "--set", set},
      {"plan", scene, "--set", set},
      {"chart", "stability"}};
  int turn = 0;
  for (const auto& request : requests) {
    const int signal = std::array{SIGINT,  SIGTERM, SIGHUP,    SIGUSR1,
                                  SIGQUIT, SIGALRM, SIGVTALRM, SIGPROF}[turn++ % 8];
    Child child = start(request);
    ASSERT_TRUE(child.wait_until_it_catches(SIGUSR1)) << child.err();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    child.send(signal);
    EXPECT_EQ(child.wait(), 128 + signal) << request[0] << " " << request[1] << child.err();
    EXPECT_THAT(child.err(), HasSubstr("ra2d: interrupted"));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);  // what it printed
  }
}

TEST_F(Program, WhatNohupIgnoresStaysIgnoredAndAClosedPipeEndsNothing) {
  Child child(folder_, {"sh", "-c", "trap '' HUP; exec \"$0\" plan \"$1\" --set scene.spacing=2e-8",
                        ra2d::test::program(), scene_file("dang2012")});
  ASSERT_TRUE(child.wait_until_it_catches(SIGUSR1));
  EXPECT_TRUE(child.ignores(SIGHUP));
  EXPECT_TRUE(child.ignores(SIGPIPE));
  EXPECT_FALSE(child.ignores(SIGINT));
  child.send(SIGHUP);
  child.send(SIGTERM);
  EXPECT_EQ(child.wait(), 128 + SIGTERM);
}

TEST_F(Program, AKilledRunLeavesNothingUnderTheFinalName) {
  Child child = start({"run", scene_file("dang2012"), "--set", "time.step=2e-10"});
  wait_until_it_marches(child);
  child.send(SIGKILL);
  EXPECT_EQ(child.wait(), 1000 + SIGKILL);
  EXPECT_FALSE(fs::exists(folder_ / "dang2012.h5"));
}

const std::vector<std::string> too_long{"--set", "time.step=1e-4", "--set", "output.rate=1e3"};
std::vector<std::string> with(std::vector<std::string> words,
                              const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST_F(Program, AStepBeyondTheLimitIsRefusedAndTheStepThatIsNamedHolds) {
  RA2D_SKIP_WITHOUT_PYTHON();
  ASSERT_EQ(run(with({"run", "--force", scene_file("drop")}, too_long)), 2);
  EXPECT_THAT(err_,
              AllOf(HasSubstr("time.step:"), HasSubstr("a node in contact up to"),
                    HasSubstr("grows e-fold in"), HasSubstr("Take time.step = "),
                    HasSubstr("time.contact_force = \"new\""), HasSubstr("time.force = true")));
  EXPECT_FALSE(fs::exists(folder_ / "drop.h5"));
  const std::size_t at = err_.find("Take time.step = ") + 17;
  const std::string step = err_.substr(at, err_.find(' ', at) - at);
  EXPECT_EQ(run({"run", "--force", scene_file("drop"), "--set", "time.step=" + step, "--set",
                 "output.rate=1e3"}),
            0)
      << err_;
  EXPECT_THAT(out_, Not(HasSubstr("beyond limit")));
  EXPECT_EQ(python({"check_result.py", "drop.h5"}), 0) << out_ << err_;
  EXPECT_EQ(run(with({"run", "--force", scene_file("drop"), "--set", "time.contact_force=new"},
                     too_long)),
            0)
      << err_;
}

TEST_F(Program, ASchemeThatGrowsAtEveryStepIsRefusedWithItsRate) {
  for (const std::string scheme : {"explicit-euler", "heun"}) {
    EXPECT_EQ(run({"run", scene_file("moving-force"), "--set", "time.scheme=" + scheme}), 2);
    EXPECT_THAT(err_, AllOf(HasSubstr("at no step does " + scheme), HasSubstr("Hz"),
                            HasSubstr("grows e-fold in"), Not(HasSubstr("Take time.step"))));
  }
  // undamped, the held force feeds the spring at every step; there is none with multipliers
  EXPECT_EQ(run({"run", scene_file("moving-force"), "--set", "time.scheme=exact"}), 2);
  EXPECT_THAT(err_, HasSubstr("at no step does exact hold a node in contact"));
  EXPECT_EQ(run({"run", scene_file("moving-force"), "--set", "time.scheme=exact", "--set",
                 "contact.law=multiplier"}),
            0)
      << err_;
}

TEST_F(Program, AForcedStepRunsAndTheFileSaysSo) {
  RA2D_SKIP_WITHOUT_PYTHON();
  // Heun's undamped modes grow e-fold in 8/(omega^4 tau^3), 40 s here
  ASSERT_EQ(run({"run", scene_file("moving-force"), "--set", "time.scheme=heun", "--set",
                 "time.force=true", "-o", "forced.h5"}),
            0)
      << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("beyond limit"), HasSubstr("at no step does heun")));
  ASSERT_EQ(run({"run", scene_file("moving-force"), "-o", "fine.h5"}), 0) << err_;
  std::ofstream(folder_ / "check.py")
      << "import h5py\n"
         "assert 'at no step does heun' in h5py.File('forced.h5').attrs['beyond_limit']\n"
         "assert 'beyond_limit' not in h5py.File('fine.h5').attrs\n";
  Child check(folder_, {ra2d::test::python(), "check.py"});
  EXPECT_EQ(check.wait(), 0) << check.err();
}

TEST_F(Program, TheFileKeepsTheDoubtsOfItsScene) {
  RA2D_SKIP_WITHOUT_PYTHON();
  ASSERT_EQ(run({"run", scene_file("dang2012"), "--set", "scene.duration=1e-3", "-o", "stiff.h5"}),
            0);
  std::ofstream(folder_ / "said.txt") << err_;
  ASSERT_EQ(run({"run", scene_file("moving-force"), "-o", "fine.h5"}), 0) << err_;
  EXPECT_EQ(err_, "");
  std::ofstream(folder_ / "check.py")
      << "import h5py\n"
         "doubts = h5py.File('stiff.h5').attrs['doubts'].splitlines()\n"
         "assert ['ra2d: ' + doubt for doubt in doubts] == open('said.txt').read().splitlines()\n"
         "assert 'contact.stiffness' in doubts[0], doubts\n"
         "assert 'doubts' not in h5py.File('fine.h5').attrs\n";
  Child check(folder_, {ra2d::test::python(), "check.py"});
  EXPECT_EQ(check.wait(), 0) << check.err();
}

TEST_F(Program, EveryFigureIsWhatItsDefinitionSays) {
  RA2D_SKIP_WITHOUT_PYTHON();
  const std::string scene = ra2d::test::source_folder() / "tests/host/figures.toml";
  const std::vector<std::vector<std::string>> variants = {
      {},
      {"output.from=1e-3"},
      {"time.nodes=\"all\"", "output.from=1.05e-3"},
      {"slider.load=0.7", "slider.modes=0"},
      {"time.scheme=rk4", "slider.modes=0"},
      {"time.scheme=adaptive", "time.tolerance=1e-9"},
      {"time.scheme=adaptive", "output.from=1.05e-3", "slider.load=0.7"}};
  for (const std::vector<std::string>& changes : variants) {
    std::vector<std::string> command{"run", scene, "-o", "figures.h5", "--force"};
    for (const std::string& change : changes) command.insert(command.end(), {"--set", change});
    EXPECT_EQ(run(command), 0) << err_;
    EXPECT_EQ(python({"check_figures.py", "figures.h5"}), 0) << out_ << err_;
  }
  EXPECT_EQ(python({"check_result.py", "figures.h5"}), 0) << out_ << err_;
}

TEST_F(Program, AnEnergyThatDoesNotCloseIsWarnedOf) {
  EXPECT_EQ(run({"run", "--force", scene_file("drop")}), 0) << err_;
  EXPECT_THAT(out_, Not(HasSubstr("warning")));
  EXPECT_EQ(run({"run", "--force", scene_file("drop"), "--set", "time.step=5e-6"}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("warning"), HasSubstr("of the energy is unaccounted for"),
                          HasSubstr("steps of 5e-06 s are too long here")));
  EXPECT_EQ(run({"run", "--force", scene_file("drop"), "--set", "contact.law=multiplier"}), 0)
      << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("warning"), HasSubstr("under multipliers each impact takes")));
  const std::vector<std::string> json{"run",    "--force", scene_file("drop"),
                                      "--json", "--set",   "time.step=5e-6"};
  EXPECT_EQ(run(json), 0);
  EXPECT_THAT(err_, HasSubstr("of the energy is unaccounted for"));
  EXPECT_EQ(run({"run", "--force", scene_file("drop"), "--quiet", "--set", "time.step=6e-6"}), 0);
  EXPECT_EQ(err_, "");
}

/// A slider of 37 mg stands on a plate that a force bends. On such a scene a run at 1e-6 has three
/// times as many shocks as at 1e-8 and at 1e-10.
TEST_F(Program, AContactWithNextToNothingOfTheEnergyIsWarnedOf) {
  const auto said = [&](const std::string& tolerance) {
    EXPECT_EQ(run({"run",
                   "--force",
                   scene_file("areal"),
                   "--set",
                   "scene.duration=3e-4",
                   "--set",
                   "scene.speed=0",
                   "--set",
                   "scene.spacing=50e-6",
                   "--set",
                   "resonator.max_frequency=1500",
                   "--set",
                   "resonator.moving_force=[{force=-1,speed=0,start=0.25,y=0.05}]",
                   "--set",
                   "slider.length=1.5e-3",
                   "--set",
                   "slider.width=0.8e-3",
                   "--set",
                   "slider.thickness=4e-3",
                   "--set",
                   "time.tolerance=" + tolerance}),
              0)
        << err_;
    return out_;
  };
  EXPECT_THAT(said("1e-6"), AllOf(HasSubstr("warning"), HasSubstr("of the energy, beside which"),
                                  HasSubstr("Try 1e-0")));
  EXPECT_THAT(said("1e-10"), Not(HasSubstr("warning")));
}

TEST_F(Program, WhatIsCountedBeginsAtTheAskedTimeUnderAdaptiveToo) {
  // a plate that rings free after one touch: steps are long, and none goes beyond output.from
  const auto level_of = [&](const char* scheme, const char* from) {
    EXPECT_EQ(
        run({"run", "--force", scene_file("drop"), "--set", "scene.gap=9.9e-6", "--set",
             "slider.load=0.0", "--set", "scene.duration=0.1", "--set", "time.step=1e-7", "--set",
             std::string("time.scheme=") + scheme, "--set", std::string("output.from=") + from}),
        0)
        << err_;
    double level = 0;
    EXPECT_EQ(std::sscanf(out_.c_str() + out_.find("level Lv"), "level Lv %lf", &level), 1) << out_;
    EXPECT_EQ(out_.find(fmt::format("m/s), from {} s on", from)) != out_.npos,
              std::string_view(from) != "0.0");
    return level;
  };
  for (const char* from : {"0.0", "0.0313", "0.0999"})
    EXPECT_NEAR(level_of("adaptive", from), level_of("rk8", from), 0.011) << from;
}

TEST_F(Program, AWindowThatEndsBeforeWhatIsCountedIsRefused) {
  EXPECT_EQ(run({"run", scene_file("drop"), "--set", "output.window=[1e-3, 2e-3]", "--set",
                 "output.from=2e-3"}),
            2);
  EXPECT_THAT(err_, HasSubstr("output.from: 0.002 s is not before the end of output.window"));
  // but windows of --zoom are kept as they are, and their scenes are read again
  EXPECT_EQ(run({"run", scene_file("drop"), "--set", "output.from=5e-3", "--zoom", "1e-3,3e-3",
                 "-o", "z.h5"}),
            0)
      << err_;
  EXPECT_EQ(run({"analyze", "z.zoom-1.h5", "--at", "0.1,0.1,0.05"}), 0) << err_;
}

TEST_F(Program, ABalanceOfOneSampleIsNotKnown) {
  EXPECT_EQ(run({"run", scene_file("drop"), "--set", "output.rate=10"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("not known: fewer than two samples"));
  EXPECT_THAT(err_, HasSubstr("output.rate = 10 Hz: the run ends after 0.02 s, before a second "
                              "sample: its file has the state at t = 0 alone. Take 50 Hz or more"));
  const auto plan = [&](const std::string& rate) {
    run({"plan", scene_file("drop"), "--set", "scene.duration=0.03", "--set",
         "output.rate=" + rate});
    return err_;
  };
  EXPECT_THAT(plan("33.3"), HasSubstr("Take 33.4 Hz or more"));
  EXPECT_THAT(plan("33.4"), testing::Not(HasSubstr("second sample")));
}

TEST_F(Program, FacesThatOverlapAtRestAreSaid) {
  EXPECT_EQ(
      run({"run", scene_file("drop"), "--set", "scene.gap=5e-6", "--set", "scene.duration=1e-4"}),
      0);
  EXPECT_THAT(err_, AllOf(HasSubstr("the faces overlap by 5e-06 m at t = 0"),
                          HasSubstr("or scene.initial = \"static\"")));
}

TEST_F(Program, ALoadThatNothingHoldsIsSaidBeforeTheRun) {
  EXPECT_EQ(run({"run", "--force", scene_file("moving-force"), "--set", "resonator.support=free",
                 "--set", "scene.duration=1e-4"}),
            0);
  EXPECT_THAT(err_, HasSubstr("nothing holds the free resonator against its moving force"));
  EXPECT_EQ(run({"run", "--force", scene_file("moving-force"), "--set", "scene.duration=1e-4"}), 0);
  EXPECT_THAT(err_, Not(HasSubstr("nothing holds")));
}

TEST_F(Program, MultipliersDoNotStartFromFacesThatOverlap) {
  // a peak in the pinned end, where no mode could move anything, either
  std::ofstream(folder_ / "blocked.toml") << R"(
[scene]
duration = 1e-3
speed    = 0.0
start    = 0.0
gap      = 0.0
spacing  = 1e-4
faces    = "linear"
initial  = "rest"
[resonator]
support = "pinned"
length = 0.06
thickness = 1e-3
width = 0.02
young = 210e9
density = 7800
damping = 0.02
modes = 3
[slider]
support = "rigid"
length = 0.01
width = 0.02
surface = { kind = "peaks", peaks = [{ at = 0.0, height = 1e-6, half_width = 5e-5 }] }
[contact]
law = "multiplier"
[time]
step = 1e-7
)";
  EXPECT_EQ(run({"run", "blocked.toml"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("scene.gap: the faces overlap by 1e-06 m at t = 0"),
                          HasSubstr("\"touching\" or at least 1e-06 m")));
  EXPECT_FALSE(fs::exists(folder_ / "blocked.h5"));
  // and the plan says so
  EXPECT_EQ(run({"plan", "blocked.toml"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("the faces overlap by 1e-06 m"));
  // nor can any displacement of the modes part them
  EXPECT_EQ(run({"run", "blocked.toml", "--set", "scene.initial=static"}), 2);
  EXPECT_THAT(err_, HasSubstr("no displacement of the kept modes keeps the faces apart"));
  // the gap that is named will do
  EXPECT_EQ(run({"run", "blocked.toml", "--set", "scene.gap=1e-06"}), 0) << err_;
}

TEST_F(Program, AnUnstableRunEndsWithThreeAndSaysWhichLimitItCrossed) {
  RA2D_SKIP_WITHOUT_PYTHON();
  EXPECT_EQ(run(with({"run", scene_file("drop"), "--set", "time.force=true"}, too_long)), 3);
  EXPECT_THAT(err_, AllOf(HasSubstr("unstable"), HasSubstr("t ="), HasSubstr("contact spring of"),
                          HasSubstr("up to time.step ="), HasSubstr("Take time.step =")));
  EXPECT_EQ(python({"check_result.py", "drop.h5"}), 0) << out_ << err_;
}

}  // namespace
