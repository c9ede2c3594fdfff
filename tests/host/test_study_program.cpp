// SPDX-License-Identifier: BSD-3-Clause
// Studies as their users meet them: the command, its folder, and what happens when it is cut off.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "host/analysis/analysis.hpp"
#include "host/result/level.hpp"
#include "host/study/law.hpp"
#include "host/study/ledger.hpp"
#include "host/study/study_points.hpp"
#include "host/study/study_table.hpp"
#include "tests/child.hpp"
#include "tests/effort.hpp"
#include "tests/places.hpp"
#include "tests/studies.hpp"
#include "tests/warm_python.hpp"

namespace {

namespace fs = std::filesystem;
using namespace ra2d;
using test::Child;
using test::Folder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class StudyProgram : public testing::Test {
 protected:
  StudyProgram() {
    std::ofstream(folder_ / "base.toml") << test::quick_scene;
    write_study(6);
  }
  void write_study(int seeds, const std::string& more = {}) const {
    std::ofstream(folder_ / "study.toml") << fmt::format(R"(
base = "base.toml"
seeds = {}
{}
[vary]
speed = {{ key = "scene.speed", values = [0.1, 0.2] }}
load = {{ key = "slider.load", values = [0.25, 0.5] }}
)",
                                                         seeds, more);
  }
  Child start(std::vector<std::string> words) const {
    words.insert(words.begin(), {test::program(), "study"});
    return {folder_, words};
  }
  int run(std::vector<std::string> words) {
    Child child = start(std::move(words));
    const int status = child.wait();
    out_ = child.out();
    err_ = child.err();
    return status;
  }
  std::string table(const std::string& name) const { return test::timeless_table(folder_ / name); }
  nlohmann::json status_of(const std::string& name) const {
    return nlohmann::json::parse(test::read_file(folder_ / name / "status.json"));
  }
  const Folder temporary_;
  const fs::path folder_ = temporary_.path();
  std::string out_, err_;
};

TEST_F(StudyProgram, RunsWhatIsNewAndSaysWhereItStands) {
  EXPECT_EQ(run({"study.toml", "-o", "out", "--dry-run"}), 0) << err_;
  EXPECT_THAT(out_, AllOf(HasSubstr("24 of 24 runs to do, 0 done"),
                          HasSubstr("speed = 0.2, load = 0.5, seed 3  about")));
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "nothing is made by a dry run";
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("24 runs finished in"));
  const auto status = status_of("out");
  EXPECT_EQ(status["runs"], 24);
  EXPECT_EQ(status["done"], 24);
  EXPECT_EQ(status["failed"], 0);
  EXPECT_EQ(status["running"], 0);
  EXPECT_EQ(status["state"], "complete");
  EXPECT_EQ(status["seconds_left"], 0);
  EXPECT_TRUE(status["finished"].is_string());

  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0);
  EXPECT_THAT(out_, HasSubstr("all 24 runs are finished already"));
  EXPECT_EQ(run({"study.toml", "-o", "out", "--list"}), 0);
  EXPECT_EQ(std::count(out_.begin(), out_.end(), '\n'), 24);
  EXPECT_THAT(out_, Not(HasSubstr("missing")));
  EXPECT_EQ(run({"status", "out"}), 0);
  EXPECT_THAT(out_, HasSubstr("out: 24 runs, 24 done, 0 failed, 0 missing"));

  // an edited study keeps what is done, and says what it no longer asks for
  write_study(7);
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0);
  EXPECT_THAT(out_, HasSubstr("4 runs finished in"));
  EXPECT_EQ(err_, "");
  write_study(5);
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0);
  EXPECT_THAT(err_, AllOf(HasSubstr("holds 8 runs that the study does not ask for"),
                          HasSubstr("load = 0.25, seed 6")));
  EXPECT_EQ(run({"study.toml", "-o", "out", "--quiet"}), 0);
  EXPECT_EQ(out_ + err_, "");
}

/// Memory that other programs hold for a while costs no run.
TEST_F(StudyProgram, WaitsForMemoryThatOtherProgramsHold) {
  if (test::faulty_disk().empty()) GTEST_SKIP() << "nothing can be loaded before sanitizers";
  fs::copy_file(test::scene_file("areal"), folder_ / "areal.toml");
  std::ofstream(folder_ / "study.toml") << R"(
base = "areal.toml"
seeds = 3
[set.scene]
duration = 5e-4
spacing = 2e-5
[set.slider]
length = 2e-3
width = 2e-3
)";
  ASSERT_EQ(run({"study.toml", "-o", "calm"}), 0) << err_;
  const fs::path memory = temporary_.path() / "meminfo";
  const auto free_memory = [&](double gigabytes) {
    std::ofstream(temporary_.path() / "new")
        << fmt::format("MemTotal: 8000000 kB\nMemAvailable: {:.0f} kB\n", gigabytes * 1e6);
    fs::rename(temporary_.path() / "new", memory);
  };
  const auto start_short = [&](const std::vector<std::string>& more) {
    free_memory(0.05);
    fs::remove(folder_ / "stderr");  // of the child before
    std::vector<std::string> words{"env",
                                   "LD_PRELOAD=" + test::faulty_disk(),
                                   "FAULTY_MEMORY=" + memory.string(),
                                   test::program(),
                                   "study",
                                   "study.toml"};
    words.insert(words.end(), more.begin(), more.end());
    return Child(folder_, words);
  };
  const auto waits = [](const Child& child) {
    return test::wait_until(
        [&] { return child.err().find("waits for memory") != std::string::npos; });
  };
  Child cut = start_short({"-o", "short"});
  ASSERT_TRUE(waits(cut)) << cut.err();
  cut.send(SIGINT);
  EXPECT_EQ(cut.wait(), 128 + SIGINT) << cut.err();
  EXPECT_THAT(cut.err(), AllOf(HasSubstr("0.05"), HasSubstr("0 of 3 runs are finished")));
  EXPECT_EQ(status_of("short")["failed"], 0);
  EXPECT_EQ(start_short({"-o", "short", "--max-wall", "0:0:1"}).wait(), 5);
  Child whole = start_short({"-o", "short"});
  ASSERT_TRUE(waits(whole)) << whole.err();
  free_memory(4);
  EXPECT_EQ(whole.wait(), 0) << whole.err();
  EXPECT_TRUE(table("short") == table("calm"));
}

TEST_F(StudyProgram, ATableIsTheSameForAnyThreadsAndShards) {
  ASSERT_EQ(run({"study.toml", "-o", "one", "--threads", "1"}), 0) << err_;
  ASSERT_EQ(run({"study.toml", "-o", "two", "--threads", "2"}), 0) << err_;
  const std::string whole = table("one");
  EXPECT_TRUE(table("two") == whole);
  // parts that share a folder, and parts that have their own
  for (const char* part : {"2/3", "3/3", "1/3"})
    ASSERT_EQ(run({"study.toml", "-o", "shared", "--shard", part}), 0) << err_;
  EXPECT_TRUE(table("shared") == whole);
  ASSERT_EQ(run({"study.toml", "-o", "a", "--shard", "1/2"}), 0) << err_;
  EXPECT_EQ(run({"merge", "a", "-o", "all.h5"}), 2);
  EXPECT_THAT(err_, AllOf(HasSubstr("cannot merge: 12 of 24 runs are missing: speed ="),
                          HasSubstr("and 7 more")));
  EXPECT_FALSE(fs::exists(folder_ / "all.h5"));
  ASSERT_EQ(run({"study.toml", "-o", "b", "--shard", "2/2"}), 0) << err_;
  const StudyAnswers there = read_study_table(folder_ / "one/results.h5");
  EXPECT_EQ(run({"merge", "a", "b", "-o", "all.h5"}), 0) << err_;
  EXPECT_EQ(read_study_table(folder_ / "all.h5").v_rms, there.v_rms);
}

/// The variable `file` of a table.
std::vector<std::string> files_of(const fs::path& table) {
  const hid_t file = H5Fopen(table.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT),
              dataset = H5Dopen2(file, "file", H5P_DEFAULT), type = H5Dget_type(dataset),
              space = H5Dget_space(dataset);
  std::vector<char*> texts(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()), 0);
  std::vector<std::string> files(texts.begin(), texts.end());
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, texts.data());
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(dataset);
  H5Fclose(file);
  return files;
}

/// The table in a folder is of that folder's runs: its own command makes it again.
TEST_F(StudyProgram, ATableOfTwoFoldersIsInNeither) {
  write_study(2, "keep = [\"level\", \"files\"]");
  const std::string change = "scene.duration=1e-3";
  ASSERT_EQ(run({"study.toml", "-o", "a", "--shard", "1/2", "--set", change}), 0) << err_;
  EXPECT_EQ(run({"merge", "a"}), 2);
  EXPECT_THAT(err_, HasSubstr("-o a --set " + change + ")"));
  fs::create_directory(folder_ / "far");
  ASSERT_EQ(run({"study.toml", "-o", "far/b", "--shard", "2/2", "--set", change}), 0) << err_;
  const std::string before = test::read_file(folder_ / "a/results.h5");
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {"-o", "a/results.h5"}, {"-o", "far/b/results.h5"}}) {
    std::vector<std::string> words{"merge", "a", "far/b"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run(words), 2);
    EXPECT_THAT(err_, AllOf(HasSubstr("results.h5' is the table of the runs in its folder alone"),
                            HasSubstr("-o all.h5")));
  }
  EXPECT_TRUE(test::read_file(folder_ / "a/results.h5") == before);
  // results of both are found from where the table is
  fs::create_directory(folder_ / "tables");
  ASSERT_EQ(run({"merge", "a", "far/b", "-o", "tables/all.h5"}), 0) << err_;
  const std::vector<std::string> files = files_of(folder_ / "tables/all.h5");
  ASSERT_EQ(files.size(), 8u);
  for (const std::string& file : files) EXPECT_TRUE(fs::exists(folder_ / "tables" / file)) << file;
  EXPECT_EQ(files_of(folder_ / "a/results.h5").front().substr(0, 5), "runs/");
  for (const char* folder : {"a", "far/b"})
    EXPECT_EQ(test::run_program(folder_, {test::program(), "check", folder}).status, 0) << folder;
}

TEST_F(StudyProgram, FoldersOfTwoStudiesAndOtherNumbersAreNotMerged) {
  ASSERT_EQ(run({"study.toml", "-o", "a"}), 0) << err_;
  ASSERT_EQ(run({"study.toml", "-o", "b", "--set", "scene.duration=1e-3"}), 0) << err_;
  EXPECT_EQ(run({"merge", "a", "b"}), 2);
  EXPECT_THAT(err_, HasSubstr("are of two studies, their --set differs"));
  EXPECT_EQ(run({"merge", "a", "nowhere"}), 4);
  EXPECT_THAT(err_, HasSubstr("'nowhere' is no folder of a study"));

  fs::copy(folder_ / "a", folder_ / "c", fs::copy_options::recursive);
  const fs::path ledger = folder_ / "c/ledger/all.log";
  std::vector<FinishedRun> runs = parse_ledger(test::read_file(ledger), ledger).runs;
  runs[3].figures.v_rms *= 1.5;
  std::string text = ledger_head();
  for (const FinishedRun& run : runs) text += record_of(run);
  std::ofstream(ledger, std::ios::binary) << text;
  EXPECT_EQ(run({"merge", "a", "c"}), 4);
  EXPECT_THAT(err_, AllOf(HasSubstr("other numbers"), HasSubstr(runs[3].point)));
}

TEST_F(StudyProgram, FailedRunsAreNamedAndStopNothing) {
  std::ofstream(folder_ / "failing.toml") << R"(
base = "base.toml"
[set]
"time.scheme" = "heun"
"output.rate" = 1e3
[vary]
step = { key = "time.step", values = [1e-7, 1e-4, 2e-7] }
)";
  EXPECT_EQ(run({"failing.toml"}), 3);
  EXPECT_THAT(
      err_, AllOf(HasSubstr("1 run failed"),
                  HasSubstr("step = 0.0001, seed 0: the study's time.step=0.0001: time.step: heun"),
                  Not(HasSubstr(folder_.string()))));
  EXPECT_EQ(status_of("failing")["failed"], 1);
  EXPECT_EQ(run({"failing.toml"}), 3) << "it still has a failed run";
  EXPECT_THAT(out_, HasSubstr("all 3 runs are finished already"));
  EXPECT_EQ(run({"failing.toml", "--retry-failed", "--dry-run"}), 0);
  EXPECT_THAT(out_, HasSubstr("1 of 3 runs to do"));
  EXPECT_EQ(run({"failing.toml", "--retry-failed"}), 3);
  EXPECT_THAT(out_, HasSubstr("1 run finished"));
  EXPECT_EQ(run({"failing.toml", "--list"}), 0);
  EXPECT_THAT(out_, HasSubstr("seed 0  refused"));
  EXPECT_EQ(run({"status", "failing"}), 0);
  EXPECT_THAT(out_, HasSubstr("3 runs, 2 done, 1 failed, 0 missing"));
}

TEST_F(StudyProgram, KilledAtAnyInstantItLosesNoFinishedRun) {
  const int seeds = test::draws(60);  // 240 runs: a second
  const unsigned slower = test::draws_enough() ? 1 : 8;
  write_study(seeds);
  ASSERT_EQ(run({"study.toml", "-o", "whole"}), 0) << err_;
  const std::string whole = table("whole");
  std::mt19937_64 dice(7);
  std::size_t before = 0;
  const fs::path ledger = folder_ / "killed/ledger/all.log";
  for (int i = 0; i < 12; ++i) {
    Child child = start({"study.toml", "-o", "killed", "--threads", "2"});
    std::this_thread::sleep_for(std::chrono::milliseconds(slower * (10 + dice() % 150)));
    child.send(SIGKILL);
    child.wait();
    if (!fs::exists(ledger)) continue;
    const std::size_t now = parse_ledger(test::read_file(ledger), ledger).runs.size();
    EXPECT_GE(now, before) << "kill " << i;
    before = now;
  }
  EXPECT_EQ(run({"study.toml", "-o", "killed"}), 0) << err_;
  EXPECT_TRUE(table("killed") == whole);
  EXPECT_EQ(parse_ledger(test::read_file(ledger), ledger).runs.size(), 4u * seeds)
      << "each ran once";
}

TEST_F(StudyProgram, GnuParallelRunsItsPartsAndGoesOnWithThoseThatFailed) {
  if (std::system("command -v parallel > /dev/null 2>&1") != 0) GTEST_SKIP() << "no GNU parallel";
  write_study(60);
  ASSERT_EQ(run({"study.toml", "-o", "whole"}), 0) << err_;
  // the line of docs/studies.md, with each part killed after a while, and then as it is
  const auto parallel = [&](const std::string& program, const std::string& more) {
    const test::Ended ended = test::run_program(
        folder_,
        {"sh", "-c",
         "export HOME=$PWD; mkdir -p .parallel; touch .parallel/will-cite; parallel -j2 --joblog "
         "parts.log " +
             more + program +
             " study study.toml -o parts --threads 1 --quiet --shard {}/8 ::: 1 2 3 4 5 6 7 8"});
    err_ = ended.err;
    return ended.status;
  };
  EXPECT_NE(parallel("timeout -s KILL 0.06 " + test::program(), ""), 0) << "parts that failed";
  EXPECT_EQ(parallel(test::program(), "--resume-failed "), 0) << err_;
  EXPECT_EQ(run({"merge", "parts", "--quiet"}), 0) << err_;
  EXPECT_TRUE(table("parts") == table("whole"));
}

TEST_F(StudyProgram, InterruptedItKeepsWhatIsFinished) {
  write_study(4000);
  Child child = start({"study.toml", "-o", "out", "--threads", "1"});
  ASSERT_TRUE(child.wait_until_it_catches(SIGTERM));
  EXPECT_TRUE(test::wait_until([&] {
    const fs::path ledger = folder_ / "out/ledger/all.log";
    return fs::exists(ledger) && fs::file_size(ledger) > 2000;
  }));
  child.send(SIGTERM);
  EXPECT_EQ(child.wait(), 128 + SIGTERM);
  EXPECT_THAT(child.err(), HasSubstr("are finished and kept; the same command continues"));
  EXPECT_EQ(status_of("out")["state"], "interrupted");
  const StudyAnswers answers = read_study_table(folder_ / "out/results.h5");
  const auto done = std::count(answers.status.begin(), answers.status.end(), 0.0);
  EXPECT_GT(done, 0);
  EXPECT_EQ(std::count(answers.status.begin(), answers.status.end(), 1.0), 16'000 - done);
  EXPECT_EQ(status_of("out")["done"], done);
}

TEST_F(StudyProgram, WhileItRunsItSaysHowFarItIs) {
  write_study(4000, "[set]\n\"slider.density\" = 8.5");  // which is doubted
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(child, 0);
  if (child == 0) {
    const std::string program = test::program();
    if (chdir(folder_.c_str()) == 0)
      execl(program.c_str(), program.c_str(), "study", "study.toml", "-o", "out", nullptr);
    _exit(126);
  }
  std::string shown;
  const auto read_on = [&] {
    char part[4096];
    const ssize_t count = read(terminal, part, sizeof part);
    if (count > 0) shown.append(part, static_cast<std::size_t>(count));
    return count > 0;  // not: the program is gone
  };
  const auto has_begun = [&] {
    return fs::exists(folder_ / "out/status.json") && status_of("out")["done"] > 0;
  };
  while (!(has_begun() && shown.find(" left ") != std::string::npos) && read_on()) continue;
  const auto status = status_of("out");
  EXPECT_EQ(status["state"], "running");
  EXPECT_EQ(status["runs"], 16'000);
  EXPECT_TRUE(status["finished"].is_null());
  EXPECT_GT(status["running"], 0);
  EXPECT_GT(status["seconds_left"], 0);
  kill(child, SIGTERM);
  while (read_on()) continue;
  close(terminal);
  int ended = 0;
  waitpid(child, &ended, 0);
  EXPECT_EQ(WEXITSTATUS(ended), 128 + SIGTERM);
  // "12 of 16000 runs   0 failed   2 running   0:31 left", over itself, and gone at the end; on a
  // slow machine "4.5 days left"
  EXPECT_THAT(
      shown, testing::ContainsRegex("[0-9]+ of 16000 runs   0 failed   [0-9]+ running   "
                                    "([0-9]+:[0-9][0-9](:[0-9][0-9])?|[0-9][0-9.e+]* days) left "));
  const std::size_t last = shown.rfind(" left "), cleared = shown.find("\r\033[K", last);
  ASSERT_NE(cleared, std::string::npos);
  EXPECT_NE(shown.find(" finished in ", cleared), std::string::npos);
  // a message takes the place of the progress instead of its end
  EXPECT_THAT(shown, HasSubstr("\r\033[Kra2d: slider.density = 8.5"));
}

TEST_F(StudyProgram, ASecondWriterIsRefused) {
  fs::create_directories(folder_ / "out/ledger");
  const LedgerWriter held(folder_ / "out/ledger/all.log");
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 4);
  EXPECT_THAT(err_, HasSubstr("another process runs this part of the study"));
  EXPECT_EQ(run({"study.toml", "-o", "out", "--list"}), 0) << "looking is free";
  EXPECT_EQ(run({"study.toml", "-o", "out", "--shard", "1/2"}), 0) << "another part is not held";
}

TEST_F(StudyProgram, FilesThatCannotBeWrittenAreSaid) {
  std::ofstream(folder_ / "file") << "x";
  EXPECT_EQ(run({"study.toml", "-o", "file"}), 2);
  EXPECT_THAT(err_, HasSubstr("this is no folder"));
  EXPECT_EQ(run({"study.toml", "-o", "no/where"}), 4);
  EXPECT_THAT(err_, HasSubstr("cannot create the folder 'no/where'"));
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0);
  const fs::path ledger = folder_ / "out/ledger/all.log";
  std::string bytes = test::read_file(ledger);
  bytes[40] = static_cast<char>(bytes[40] ^ 4);
  std::ofstream(ledger, std::ios::binary) << bytes;
  for (const std::vector<std::string>& words : {std::vector<std::string>{"study.toml", "-o", "out"},
                                                {"status", "out"},
                                                {"merge", "out"},
                                                {"study.toml", "-o", "out", "--list"}}) {
    EXPECT_EQ(run(words), 4) << words[0];
    EXPECT_THAT(err_, AllOf(HasSubstr("damaged at byte 16"), HasSubstr("truncate -s 16")));
  }
  EXPECT_EQ(test::read_file(ledger), bytes) << "left as it was found";
}

TEST_F(StudyProgram, ASnapshotThatIsNoneIsMovedAwayAsItIsSaid) {
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  const fs::path snapshot = folder_ / "out/study.json";
  for (const char* text : {"{\n", "{}\n", "no study"}) {
    std::ofstream(snapshot) << text;
    EXPECT_EQ(run({"status", "out"}), 4) << text;
    EXPECT_THAT(err_, HasSubstr("move it away and run the study's line again")) << text;
    EXPECT_EQ(run({"study.toml", "-o", "out"}), 2) << text;
    fs::rename(snapshot, folder_ / "moved.json");
    EXPECT_EQ(run({"study.toml", "-o", "out"}), 0) << text << err_;
    EXPECT_EQ(run({"status", "out"}), 0) << text << err_;
  }
}

TEST_F(StudyProgram, ABaseThatIsNotThereIsNamedWithTheCure) {
  std::ofstream(folder_ / "study.toml") << "base = \"areal\"\nseeds = 1\n";
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 4);
  EXPECT_THAT(err_, AllOf(HasSubstr("areal'"), HasSubstr("expected a scene"),
                          HasSubstr("'ra2d scenes NAME > base.toml'")));
}

TEST_F(StudyProgram, ASnapshotOfAnotherVersionIsMovedAwayAsItIsSaid) {
  write_study(1);
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  std::ofstream(folder_ / "out/study.json") << "{\"study\": {}, \"format\": 7}\n";
  const std::vector<std::string> status{test::program(), "study", "status", "out"};
  EXPECT_THAT(test::run_program(folder_, status).err,
              AllOf(HasSubstr("another version of ra2d"), HasSubstr("move it away")));
  fs::rename(folder_ / "out/study.json", folder_ / "old.json");
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("finished already"));
  EXPECT_EQ(test::run_program(folder_, status).status, 0);
}

TEST_F(StudyProgram, ATextOfTwoLinesStaysInItsRow) {
  std::ofstream(folder_ / "named.toml") << R"(
base = "base.toml"
[vary]
name = { key = "scene.name", values = ["of\ntwo", "of one"] }
)";
  ASSERT_EQ(run({"named.toml", "-o", "out"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("\n  of\\u000Atwo "));
  Child analysis(folder_, {test::program(), "analyze", "out"});
  EXPECT_EQ(analysis.wait(), 0);
  EXPECT_THAT(analysis.out(), HasSubstr("\n  of\\u000Atwo "));
}

TEST_F(StudyProgram, ADiskThatFillsUpLeavesWhatIsFinished) {
  // a limit on the size of files stands for a full disk
  write_study(60);
  const std::string line =
      fmt::format("ulimit -f 8; exec {} study study.toml -o out --threads 2", test::program());
  Child child(folder_, {"/bin/bash", "-c", line});
  EXPECT_EQ(child.wait(), 4);
  EXPECT_THAT(child.err(),
              AllOf(HasSubstr("cannot write to 'out/ledger/all.log'"), HasSubstr("ulimit -f")));
  EXPECT_EQ(status_of("out")["state"], "failed");
  EXPECT_TRUE(status_of("out")["finished"].is_string());
  const fs::path ledger = folder_ / "out/ledger/all.log";
  const ParsedLedger kept = parse_ledger(test::read_file(ledger), ledger);
  EXPECT_GT(kept.runs.size(), 10u);
  EXPECT_EQ(kept.whole, fs::file_size(ledger)) << "the part that was written is taken back";
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_EQ(parse_ledger(test::read_file(ledger), ledger).runs.size(), 240u);
}

TEST_F(StudyProgram, WhicheverCallToTheDiskFailsNothingIsLost) {
  if (test::faulty_disk().empty()) GTEST_SKIP() << "nothing can be loaded before sanitizers";
  write_study(1);
  ASSERT_EQ(run({"study.toml", "-o", "whole"}), 0) << err_;
  const std::string whole = table("whole");
  const fs::path report = folder_ / "report", out = fs::canonical(folder_) / "out";
  int failed = 0;
  for (int call = 1; call < 200; ++call) {
    fs::remove_all(out);
    fs::remove(report);
    Child child(folder_, {"/usr/bin/env", "LD_PRELOAD=" + test::faulty_disk(),
                          "FAULTY_FOLDER=" + out.string(), fmt::format("FAULTY_CALL={}", call),
                          "FAULTY_ERROR=28", "FAULTY_TOLD=" + report.string(), test::program(),
                          "study", "study.toml", "-o", "out", "--threads", "1"});
    const int status = child.wait();
    if (!fs::exists(report)) break;  // all calls have had their turn
    EXPECT_TRUE(status == 0 || status == 4) << "call " << call << ": " << child.err();
    EXPECT_EQ(status == 4, child.err().find("'out") != std::string::npos) << child.err();
    failed += status == 4 ? 1 : 0;
    EXPECT_EQ(run({"study.toml", "-o", "out"}), 0) << "after call " << call << ": " << err_;
    EXPECT_TRUE(table("out") == whole) << "after call " << call;
  }
  EXPECT_GT(failed, 10);
}

TEST_F(StudyProgram, AFolderThatGoesAwayEndsIt) {
  write_study(4000);
  Child child = start({"study.toml", "-o", "out", "--threads", "1"});
  ASSERT_TRUE(test::wait_until([&] { return fs::exists(folder_ / "out/status.json"); }));
  fs::rename(folder_ / "out", folder_ / "gone");
  EXPECT_EQ(child.wait(), 4);
  EXPECT_THAT(child.err(), HasSubstr("status.json'"));
}

TEST_F(StudyProgram, XarrayOpensTheTableAsItIs) {
  RA2D_SKIP_WITHOUT_PYTHON();
  std::ofstream(folder_ / "words.toml") << R"(
base = "base.toml"
seeds = 2
[vary]
scheme = { keys = ["time.scheme", "time.step"], values = [["adaptive", 1e-6], ["heun", 1e-7], ["heun-", 1]] }
)";
  EXPECT_EQ(run({"words.toml"}), 2) << "a word that is none";
  EXPECT_THAT(err_, HasSubstr("\"heun-\" is unknown"));
  std::ofstream(folder_ / "words.toml") << R"(
base = "base.toml"
seeds = [0, 3]
[vary]
scheme = { keys = ["time.scheme", "time.step"], values = [["adaptive", 1e-6], ["heun", 1e-7], ["rk4", 9e-6]] }
speed = { key = "scene.speed", values = [0.1, 0.3] }
)";
  EXPECT_EQ(run({"words.toml"}), 3) << err_;
  Child child(folder_, {test::python(), test::source_folder() / "tests/host/check_study.py",
                        "words/results.h5"});
  EXPECT_EQ(child.wait(), 0) << child.out() << child.err();
}

TEST_F(StudyProgram, KeepsWhatItIsAskedToKeep) {
  write_study(1, "keep = [\"shocks\", \"files\"]");
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_TRUE(read_study_table(folder_ / "out/results.h5").v_rms.empty()) << "no level";
  std::vector<fs::path> results;
  for (const auto& entry : fs::directory_iterator(folder_ / "out/runs"))
    results.push_back(entry.path());
  ASSERT_EQ(results.size(), 4u);
  // each is what `ra2d run` writes of its scene
  ASSERT_EQ(Child(folder_, {test::program(), "run", "base.toml", "--set", "scene.speed=0.2",
                            "--set", "slider.load=0.5", "-o", "alone.h5"})
                .wait(),
            0);
  if (!test::python().empty()) {
    int same = 0;
    for (const fs::path& result : results)
      same += Child(folder_, {test::python(), test::source_folder() / "tests/host/same_result.py",
                              result, "alone.h5"})
                          .wait() == 0
                  ? 1
                  : 0;
    EXPECT_EQ(same, 1);
  }
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0);
  EXPECT_THAT(out_, HasSubstr("all 4 runs are finished already"));
  fs::remove(results[2]);
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0);
  EXPECT_THAT(out_, HasSubstr("1 run finished in"));
  EXPECT_TRUE(fs::exists(results[2]));
  // nor does a check miss the levels that are not in the table
  const test::Ended checked = test::run_program(folder_, {test::program(), "check", "out"});
  EXPECT_EQ(checked.status, 0) << checked.err;
}

/// Each run's sound is that of its result, which need not stay.
TEST_F(StudyProgram, KeepsTheSoundWithoutTheFiles) {
  const std::string set =
      "[set]\n\"scene.duration\" = 4e-3\n\"output.microphones\" = [{ x = 0.1, y = 0.05, z = 0.2 }, "
      "{ x = 0, y = 0, z = -0.3 }]\n";
  write_study(2, set);
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_TRUE(read_study_table(folder_ / "out/results.h5").lp_a.empty());
  write_study(2, "keep = [\"level\", \"sound\"]\n" + set);  // the finished runs lack their sound
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("8 runs finished in"));
  EXPECT_TRUE(fs::is_empty(folder_ / "out/runs"));
  EXPECT_EQ(run({"study.toml", "-o", "out"}), 0);
  EXPECT_THAT(out_, HasSubstr("all 8 runs are finished already"));
  const StudyAnswers answers = read_study_table(folder_ / "out/results.h5");
  ASSERT_EQ(answers.lp_a.size(), 8u);
  ASSERT_EQ(
      Child(folder_, {test::program(), "run", "base.toml", "--set", "scene.speed=0.2", "--set",
                      "slider.load=0.5", "--set", "scene.duration=4e-3", "-o", "alone.h5"})
          .wait(),
      0);
  AnalysisOptions options;
  options.sound.power = true;
  options.sound.microphones = {{0.1, 0.05, 0.2}, {0, 0, -0.3}};
  const Analysis alone = analyze(folder_ / "alone.h5", options);
  double square = 0;
  for (const MicrophoneLevels& m : alone.microphones) square += std::pow(10, m.lp_a / 10) / 2;
  EXPECT_NEAR(answers.lp_a[6], 10 * std::log10(square), 1e-9);
  EXPECT_NEAR(answers.lw[6], alone.power->lw, 1e-9);
  EXPECT_NEAR(answers.lw_a[6], alone.power->lw_a, 1e-9);
  const test::Ended said =
      test::run_program(folder_, {test::program(), "analyze", "out", "--json"});
  const auto json = nlohmann::json::parse(said.out);
  EXPECT_EQ(json["sound_laws"]["lpa"]["exponents"]["speed"]["value"],
            fit_law(answers, sounds[1]).exponents[0].value);
  EXPECT_TRUE(json["points"][3]["lw"]["mean"].is_number());
  EXPECT_EQ(test::run_program(folder_, {test::program(), "check", "out"}).status, 0);

  // without microphones there is the power alone, and it is said why
  write_study(1, "keep = [\"sound\"]");
  ASSERT_EQ(run({"study.toml", "-o", "power"}), 0) << err_;
  const StudyAnswers power = read_study_table(folder_ / "power/results.h5");
  EXPECT_TRUE(std::isnan(power.lp[0]) && std::isfinite(power.lw[0]));
  EXPECT_THAT(test::run_program(folder_, {test::program(), "analyze", "power"}).out,
              AllOf(HasSubstr("Lp: no law yet"), HasSubstr("Lw = ")));
}

/// Sound and results that are kept are those of the study's microphones and air as they stand.
TEST_F(StudyProgram, OtherMicrophonesAndOtherAirAreOtherRuns) {
  const auto write = [&](const char* keep, const std::string& set, const std::string& vary = "") {
    write_study(1, fmt::format("keep = [\"level\", \"{}\"]\n[set]\n\"scene.duration\" = 4e-3\n{}",
                               keep, set));
    std::ofstream(folder_ / "study.toml", std::ios::app) << vary;
  };
  const auto microphone = [](double z) {
    return fmt::format("\"output.microphones\" = [{{ x = 0.1, y = 0.05, z = {} }}]\n", z);
  };
  const auto lp = [&] { return read_study_table(folder_ / "out/results.h5").lp; };
  write("sound", microphone(0.2));
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  const std::vector<double> near = lp();
  write("sound", microphone(0.1));
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("4 runs finished in"));
  const std::vector<double> nearer = lp();
  for (std::size_t i = 0; i < near.size(); ++i) EXPECT_GT(nearer[i], near[i] + 1) << i;
  write("sound", microphone(0.2));
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("all 4 runs are finished already"));
  EXPECT_EQ(lp(), near);

  write("sound", microphone(0.2), "air = { key = \"air.temperature\", values = [0, 90] }\n");
  ASSERT_EQ(run({"study.toml", "-o", "air"}), 0) << err_;
  EXPECT_THAT(err_, Not(HasSubstr("changes nothing")));
  const std::vector<double> of_air = read_study_table(folder_ / "air/results.h5").lp;
  ASSERT_EQ(of_air.size(), 8u);
  for (std::size_t i = 0; i < 8; i += 2) EXPECT_GT(of_air[i], of_air[i + 1] + 0.5) << i;

  write("files", microphone(0.2));
  ASSERT_EQ(run({"study.toml", "-o", "files"}), 0) << err_;
  write("files", microphone(0.1));
  ASSERT_EQ(run({"study.toml", "-o", "files"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("4 runs finished in"));
  EXPECT_EQ(test::run_program(folder_, {test::program(), "check", "files"}).status, 0);
  const fs::directory_iterator files(folder_ / "files/runs");
  EXPECT_EQ(std::distance(begin(files), end(files)), 8);  // each with its own microphone
}

TEST_F(StudyProgram, SaysHowManyRunsWarnOfWhat) {
  write_study(2,
              "keep = [\"level\", \"sound\"]\n[set]\n\"scene.duration\" = 0.03\n"
              "\"output.microphones\" = [{ x = 0.1, y = 0.05, z = 0.2 }]\n"
              "\"resonator.modes\" = 1\n");
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("8 of 8 runs (the first: speed = 0.1, load = 0.25, seed 0): sound "
                              "pressure: "));
  const auto json = nlohmann::json::parse(
      test::run_program(folder_, {test::program(), "analyze", "out", "--json"}).out);
  ASSERT_EQ(json["warnings"].size(), 2) << json["warnings"];
  EXPECT_EQ(json["warnings"][0]["runs"], 8);
  EXPECT_THAT(std::string(json["warnings"][1]["text"]), HasSubstr("above the last mode"));
  EXPECT_EQ(json["warnings"][1]["first"], "speed = 0.1, load = 0.25, seed 0");
}

TEST_F(StudyProgram, CheckFindsEveryDamageOfAFolder) {
  write_study(1, "keep = [\"level\", \"files\"]");
  ASSERT_EQ(run({"study.toml", "-o", "out", "--quiet"}), 0) << err_;
  const auto check = [&] {
    const test::Ended ended = test::run_program(folder_, {test::program(), "check", "out"});
    err_ = ended.err;
    out_ = ended.out;
    return ended.status;
  };
  EXPECT_EQ(check(), 0) << err_;
  EXPECT_THAT(out_,
              HasSubstr("4 done, 0 failed, 0 not run yet; all hashes agree, also of 4 results"));
  const auto flip = [](const fs::path& file, std::size_t from_the_end) {
    std::string bytes = test::read_file(file);
    bytes.at(bytes.size() - from_the_end) ^= 1;
    std::ofstream(file, std::ios::binary) << bytes;
  };
  const fs::path folder = folder_ / "out", kept = fs::directory_iterator(folder / "runs")->path();
  const std::string result = test::read_file(kept), table = test::read_file(folder / "results.h5"),
                    ledger = test::read_file(folder / "ledger" / "all.log");
  const auto put_back = [&] {
    std::ofstream(kept, std::ios::binary) << result;
    std::ofstream(folder / "results.h5", std::ios::binary) << table;
    std::ofstream(folder / "ledger" / "all.log", std::ios::binary) << ledger;
    ASSERT_EQ(check(), 0) << err_;
  };
  std::ofstream(kept, std::ios::binary) << result.substr(0, result.size() / 2);
  EXPECT_EQ(check(), 4);
  EXPECT_THAT(err_, HasSubstr(kept.filename().string()));
  fs::remove(kept);
  EXPECT_EQ(check(), 4);
  EXPECT_THAT(err_, HasSubstr("is missing, the result of the run"));
  put_back();
  flip(folder / "ledger" / "all.log", ledger.size() / 2);
  EXPECT_EQ(check(), 4);
  EXPECT_THAT(err_, HasSubstr("all.log"));
  put_back();
  fs::remove(folder / "results.h5");
  EXPECT_EQ(check(), 4);
  EXPECT_THAT(err_, HasSubstr("'ra2d study merge' makes it anew"));
  put_back();
  // a number of the table that no run had, with its hash
  FinishedRuns finished;
  finished.add(StudyFolder{folder});
  finished.runs.begin()->second.figures.v_rms *= 2;
  const StudyPoints points(study_of(StudyFolder{folder}));
  write_study_table(folder / "results.h5", points, PointCensus(points), finished);
  EXPECT_EQ(check(), 4);
  EXPECT_THAT(err_, HasSubstr("and the ledgers differ in the run"));
  // results of an earlier version of the study
  put_back();
  write_study(1, "keep = [\"level\", \"files\"]\n[set]\n\"scene.gap\" = 2e-4");
  ASSERT_EQ(run({"study.toml", "-o", "out", "--quiet"}), 0) << err_;
  EXPECT_EQ(check(), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("also of 4 results, and of 4 results that no ledger has"));
  flip(kept, result.size() / 2);
  EXPECT_EQ(check(), 4);
  EXPECT_THAT(err_, HasSubstr(kept.filename().string()));
  std::ofstream(kept, std::ios::binary) << result;
  // runs that are still to come are no damage
  write_study(2, "keep = [\"level\", \"files\"]");
  ASSERT_EQ(run({"study.toml", "-o", "out", "--quiet", "--shard", "1/4"}), 0) << err_;
  EXPECT_EQ(check(), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("not run yet"));
}

TEST_F(StudyProgram, PlotDrawsTheLevelsAndTheLaw) {
  if (test::python().empty()) GTEST_SKIP() << "no Python";
  const test::WarmPython warm;
  ASSERT_EQ(run({"study.toml", "-o", "out", "--quiet"}), 0) << err_;
  const auto plot = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {test::program(), "plot"});
    const test::Ended ended = test::run_program(folder_, words);
    err_ = ended.err;
    return ended.status;
  };
  ASSERT_EQ(plot({"out", "-o", "law.svg"}), 0) << err_;
  const std::string svg = test::read_file(folder_ / "law.svg");
  const StudyLaw law = fit_law(read_study_table(folder_ / "out" / "results.h5"));
  for (const std::string& text :
       {fmt::format("speed^{:.3f}", law.exponents[0].value),
        fmt::format("load^{:.3f}", law.exponents[1].value), std::string("speed [m/s]"),
        std::string("load [N]"), std::string("0.25"), std::string("24 of 24 runs done")})
    EXPECT_THAT(svg, HasSubstr(text));
  EXPECT_EQ(plot({"out/results.h5", "-o", "law.png"}), 0) << err_;
  EXPECT_EQ(plot({"out", "--what", "spectrum"}), 2);
  EXPECT_THAT(err_, HasSubstr("of a study there is only 'overview'"));
  EXPECT_EQ(plot({"out", "--form", "line"}), 2);
  EXPECT_THAT(err_, HasSubstr("--form is of profiles"));
  // words, a dimension of one value, no levels, nothing but seeds
  std::ofstream(folder_ / "words.toml") << R"(
base = "base.toml"
[vary]
scheme = { key = "time.scheme", values = ["backward-euler", "exact"] }
only = { key = "scene.speed", values = [0.1] }
)";
  std::ofstream(folder_ / "none.toml")
      << "base = \"base.toml\"\nkeep = [\"shocks\"]\n"
         "[vary]\nspeed = { key = \"scene.speed\", values = [0.1, 0.2] }\n";
  std::ofstream(folder_ / "seeds.toml") << "base = \"base.toml\"\nseeds = 2\n";
  for (const std::string name : {"words", "none", "seeds"}) {
    ASSERT_EQ(run({name + ".toml", "-o", name, "--quiet"}), 0) << err_;
    EXPECT_EQ(plot({name, "-o", name + ".svg"}), 0) << err_;
  }
  EXPECT_THAT(test::read_file(folder_ / "words.svg"), HasSubstr("backward-euler"));
  EXPECT_THAT(test::read_file(folder_ / "none.svg"), HasSubstr("no levels"));
  EXPECT_THAT(test::read_file(folder_ / "seeds.svg"), HasSubstr(">seed<"));
}

TEST_F(StudyProgram, ReportMakesAPage) {
  const test::WarmPython warm;
  write_study(6, "# </pre><script>alert(1)</script>");
  ASSERT_EQ(run({"study.toml", "-o", "out", "--quiet", "--set", "slider.damping=0.03"}), 0) << err_;
  const test::Ended ended = test::run_program(folder_, {test::program(), "report", "out/"});
  ASSERT_EQ(ended.status, 0) << ended.err;
  const std::string page = test::read_file(folder_ / "out.html");
  const StudyAnswers answers = read_study_table(folder_ / "out" / "results.h5");
  const StudyLaw law = fit_law(answers);
  for (const Exponent& e : law.exponents)  // host/python/tests/test_pages.py has the rest
    EXPECT_THAT(page, HasSubstr(fmt::format("{:.3f} to {:.3f}", e.low, e.high)));
  for (const CombinationMean& mean : combination_means(answers))
    EXPECT_THAT(page, HasSubstr(fmt::format("{:.2f} to {:.2f}", mean.level.low, mean.level.high)));
  EXPECT_THAT(page, HasSubstr("slider.damping=0.03"));
  EXPECT_THAT(page, HasSubstr("&lt;/pre&gt;&lt;script&gt;alert"));
  EXPECT_THAT(page, testing::Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("<code>ra2d report out/ -o out.html</code>"));
  // the levels of the law are those of its formula
  std::vector<std::size_t> place{1, 0};
  EXPECT_NEAR(law_level(law, answers.axes, place),
              level(law.factor * std::pow(0.2, law.exponents[0].value) *
                    std::pow(0.25, law.exponents[1].value)),
              1e-9);
  // a study is alone on its page
  EXPECT_EQ(test::run_program(folder_, {test::program(), "report", "out", "out"}).status, 4);
}

TEST_F(StudyProgram, AnalyzeFitsTheLaw) {
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  Child words(folder_, {test::program(), "analyze", "out"});
  EXPECT_EQ(words.wait(), 0) << words.err();
  EXPECT_THAT(words.out(), AllOf(HasSubstr("24 runs, 24 done"), HasSubstr("log10(speed)"),
                                 HasSubstr("log10(load)"), HasSubstr("95 % from"),
                                 HasSubstr("shocks [1/s]"), HasSubstr("straight line")));
  Child json(folder_, {test::program(), "analyze", "out/results.h5", "--json"});
  EXPECT_EQ(json.wait(), 0) << json.err();
  const auto answer = nlohmann::json::parse(json.out());
  EXPECT_EQ(answer["points"].size(), 4u);
  EXPECT_EQ(answer["law"]["runs"], 24);
  EXPECT_LT(answer["law"]["exponents"]["speed"]["low"],
            answer["law"]["exponents"]["speed"]["high"]);
  Child two(folder_, {test::program(), "analyze", "out", "out"});
  EXPECT_EQ(two.wait(), 2);
  for (const char* option : {"--from=0", "--a-weighting", "--segment=8"})
    EXPECT_EQ(Child(folder_, {test::program(), "analyze", "out", option}).wait(), 2) << option;
  Child none(folder_, {test::program(), "analyze", "."});
  EXPECT_EQ(none.wait(), 4);
  EXPECT_THAT(none.err(), HasSubstr("'ra2d study' writes it"));
}

TEST_F(StudyProgram, AnalyzeWritesTheMeansAndTheLawAsTables) {
  write_study(2);
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  fs::create_directory(folder_ / "tables");
  for (const auto& [given, prefix, study] :
       {std::tuple{"x", "x-", "out"}, {"tables", "tables/out-", "out/"}}) {
    const test::Ended said =
        test::run_program(folder_, {test::program(), "analyze", study, "--csv", given});
    ASSERT_EQ(said.status, 0) << said.err;
    EXPECT_THAT(said.out, HasSubstr(fmt::format("written          {}{{means,law}}.csv", prefix)));
    const StudyAnswers answers = read_study_table(folder_ / "out/results.h5");
    const std::string means = test::read_file(folder_ / fmt::format("{}means.csv", prefix));
    EXPECT_THAT(means, testing::StartsWith("speed,load,runs,v_rms_mean_m/s,v_rms_deviation_m/s,"));
    EXPECT_EQ(std::count(means.begin(), means.end(), '\n'), 5);
    const CombinationMean last = combination_means(answers).back();
    EXPECT_THAT(
        means, HasSubstr(fmt::format("\n0.2,0.5,2,{},{},", last.v_rms.mean, last.v_rms.deviation)));
    EXPECT_THAT(means, HasSubstr(fmt::format(",{},{},{},{},", last.level.mean, last.level.deviation,
                                             last.level.low, last.level.high)));
    const StudyLaw law = fit_law(answers);
    const std::string table = test::read_file(folder_ / fmt::format("{}law.csv", prefix));
    EXPECT_THAT(table, testing::StartsWith("quantity,value,low,high\n"));
    EXPECT_THAT(
        table,
        AllOf(HasSubstr(fmt::format("\nexponent_load,{},{},{}\n", law.exponents[1].value,
                                    law.exponents[1].low, law.exponents[1].high)),
              HasSubstr(fmt::format("\nfactor,{},,\n", law.factor)), HasSubstr("\nruns,8,,\n")));
  }
  // never over the study's own table
  fs::copy(folder_ / "out/results.h5", folder_ / "y-means.csv");
  EXPECT_EQ(
      test::run_program(folder_, {test::program(), "analyze", "y-means.csv", "--csv", "y"}).status,
      2);
}

/// A dimension of such a name would stand twice, or in the place of a figure.
TEST_F(StudyProgram, WhatTheTableAndTheMeansHaveIsNoNameOfADimension) {
  const std::string keep = "keep = [\"level\", \"shocks\", \"sound\", \"files\"]\n";
  write_study(1, keep);
  ASSERT_EQ(run({"study.toml", "-o", "out", "--quiet"}), 0) << err_;
  std::set<std::string> names;
  const auto json = nlohmann::json::parse(
      test::run_program(folder_, {test::program(), "analyze", "out", "--json"}).out);
  for (const auto& [name, value] : json["points"][0].items()) names.insert(name);
  test::run_program(folder_, {test::program(), "analyze", "out", "--csv", "x"});
  std::istringstream head(test::read_file(folder_ / "x-means.csv"));
  std::string line;
  std::getline(head, line);
  std::istringstream columns(line);
  for (std::string name; std::getline(columns, name, ',');) names.insert(name);
  const hid_t table = H5Fopen((folder_ / "out/results.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(table, 0);
  H5Literate(
      table, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* all) -> herr_t {
        static_cast<std::set<std::string>*>(all)->insert(name);
        return 0;
      },
      &names);
  H5Fclose(table);
  EXPECT_GT(names.size(), 40u);
  names.erase("speed");
  names.erase("load");
  for (const std::string& name : names)
    EXPECT_THROW(parse_study("base = \"b.toml\"\n" + keep + "[vary]\n\"" + name +
                                 "\" = { key = \"scene.speed\", values = [1, 2] }\n",
                             "s.toml"),
                 RequestError)
        << name;
}

TEST_F(StudyProgram, AKeyThatTakesAWordOrANumberMayHaveBoth) {
  std::ofstream(folder_ / "study.toml") << R"(
base = "base.toml"
[vary]
load = { key = "slider.load", values = ["weight", 0.5, 2] }
gap = { key = "scene.gap", values = [1e-5, "touching"] }
)";
  ASSERT_EQ(run({"study.toml", "-o", "out"}), 0) << err_;
  EXPECT_EQ(status_of("out")["done"], 6);
  const StudyAnswers answers = read_study_table(folder_ / "out/results.h5");
  EXPECT_THAT(answers.axes[0].texts, testing::ElementsAre("weight", "0.5", "2"));
  EXPECT_THAT(answers.axes[1].texts, testing::ElementsAre("1e-05", "touching"));
  const test::Ended said =
      test::run_program(folder_, {test::program(), "analyze", "out", "--csv", "x"});
  ASSERT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, AllOf(HasSubstr("no law"), HasSubstr("x-means.csv")));
  EXPECT_THAT(test::read_file(folder_ / "x-means.csv"), HasSubstr("\nweight,touching,1,"));
  EXPECT_EQ(test::read_file(folder_ / "x-law.csv"), "quantity,value,low,high\n");
  // what is given twice, is
  std::ofstream(folder_ / "study.toml") << R"(
base = "base.toml"
[vary]
load = { key = "slider.load", values = ["weight", 0.5, 0.50] }
)";
  EXPECT_EQ(run({"study.toml", "-o", "twice"}), 2);
  EXPECT_THAT(err_, HasSubstr("stands twice"));
}

TEST_F(StudyProgram, OfAnInterruptedStudyNoTimeIsMadeUp) {
  write_study(500);
  EXPECT_EQ(run({"study.toml", "-o", "out", "--max-wall", "1e-9"}), 5) << err_;
  const auto status = status_of("out");
  EXPECT_EQ(status["state"], "interrupted");
  EXPECT_TRUE(status["seconds_left"].is_null() || status["seconds_left"] > 0) << status;
}

TEST_F(StudyProgram, LinesThatAreWrongAreRefused) {
  EXPECT_EQ(run({}), 2);
  EXPECT_THAT(err_, HasSubstr("STUDY.toml is required"));
  for (const char* shard : {"0/2", "3/2", "1", "1/2/3", "a/b", "/", "1/"}) {
    EXPECT_EQ(run({"study.toml", "--shard", shard}), 2) << shard;
    EXPECT_THAT(err_, HasSubstr("expected I/N"));
  }
  EXPECT_EQ(run({"study.toml", "--shards", "1/2"}), 2);
  EXPECT_THAT(err_, HasSubstr("did you mean '--shard'?"));
  for (const char* other : {"--dry-run", "--retry-failed", "--shard=1/2"})
    EXPECT_EQ(run({"study.toml", "--list", other}), 2) << other;
  for (const char* looking : {"--dry-run", "--list"})
    for (const char* other : {"--checkpoint=1", "--max-wall=1"})
      EXPECT_EQ(run({"study.toml", looking, other}), 2) << looking << other;
  EXPECT_EQ(run({"none.toml"}), 4);
  EXPECT_EQ(run({"study.toml", "--set", "scene.speed=1"}), 2);
  EXPECT_THAT(err_, HasSubstr("vary.speed varies this key"));
  EXPECT_FALSE(fs::exists(folder_ / "study")) << "nothing is made for a wrong request";
}

}  // namespace
