// SPDX-License-Identifier: BSD-3-Clause
// Studies whose runs last longer than the time between two checkpoints, cut off in every way: each
// run goes on where it was, and the table has the bytes of a study that was left alone.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/device/backend.hpp"
#include "host/run/checkpoint.hpp"
#include "host/store/output_names.hpp"
#include "host/study/study_checkpoints.hpp"
#include "tests/child.hpp"
#include "tests/effort.hpp"
#include "tests/hdf5_content.hpp"
#include "tests/places.hpp"
#include "tests/studies.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

class StudyCrash : public testing::Test {
 protected:
  StudyCrash() { write_study(0.07, false); }
  /// Three schemes and both laws, two seeds: of 0.07 s of sliding the dearest takes some 30 ms.
  void write_study(double duration, bool keep_results, int seeds = 2) const {
    std::ofstream(folder_ / "base.toml") << quick_scene;
    std::ofstream(folder_ / "study.toml")
        << fmt::format(R"(
base = "base.toml"
seeds = {}
{}
[set]
"scene.duration" = {}
[vary]
scheme = {{ keys = ["time.scheme", "contact.law"], values = [["heun", "penalty"], ["adaptive", "penalty"], ["backward-euler", "multiplier"]] }}
)",
                       seeds, keep_results ? "keep = [\"level\", \"files\"]" : "", duration);
  }
  std::vector<std::string> line(const std::string& name, std::vector<std::string> more = {}) const {
    std::vector<std::string> words{program(), "study", "study.toml", "-o", name};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  Ended run(const std::string& name, const std::vector<std::string>& more = {}) const {
    return run_program(folder_, line(name, more));
  }
  std::vector<fs::path> checkpoints(const std::string& name) const {
    return study_checkpoints(StudyFolder{folder_ / name});
  }
  /// Waits until a study that runs has left a checkpoint.
  bool wait_for_checkpoint(const std::string& name) const {
    return wait_until([&] { return !checkpoints(name).empty(); });
  }
  /// Ends a study with a checkpoint of the run on its way.
  void cut_off(const std::string& name) const {
    const Ended ended = run(name, {"--threads", "1", "--checkpoint", "1e-5", "--max-wall", "0.01"});
    ASSERT_EQ(ended.status, 5) << ended.err;
    ASSERT_THAT(ended.err, HasSubstr("stopped by --max-wall: 0 of 6 runs are finished"));
    ASSERT_FALSE(checkpoints(name).empty());
  }
  fs::path only_checkpoint(const std::string& name) const {
    for (const fs::path& file : checkpoints(name))
      if (file.extension() == ".checkpoint") return file;
    return {};
  }
  /// The results that are kept, by their names. Compare with ==: gtest would print them, and takes
  /// all memory.
  std::map<std::string, Content> results(const std::string& name) const {
    std::map<std::string, Content> found;
    for (const auto& entry : fs::directory_iterator(folder_ / name / "runs"))
      found[entry.path().filename()] = content_of(entry.path());
    return found;
  }
  const Folder temporary_;
  const fs::path folder_ = fs::canonical(temporary_.path());
};

TEST_F(StudyCrash, CutThreeTimesItEqualsOneThatWasLeftAlone) {
  for (const bool keep_results : {false, true}) {
    const std::string threads = keep_results ? "2" : "1";
    SCOPED_TRACE(threads + " threads");
    write_study(0.3, keep_results);
    const std::string whole = "whole" + threads, cut = "cut" + threads;
    ASSERT_EQ(run(whole, {"--threads", threads}).status, 0);
    const std::vector<std::string> often{"--threads", threads, "--checkpoint", "1e-4"};
    {
      Child child(folder_, line(cut, often));
      ASSERT_TRUE(wait_for_checkpoint(cut));
      child.send(SIGTERM);
      ASSERT_EQ(child.wait(), 128 + SIGTERM) << child.err();
      EXPECT_THAT(child.err(), HasSubstr("the same command continues"));
      EXPECT_FALSE(checkpoints(cut).empty());
    }
    do {
      Child child(folder_, line(cut, often));
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
      ASSERT_TRUE(wait_for_checkpoint(cut));
      child.send(SIGKILL);
      ASSERT_EQ(child.wait(), 1000 + SIGKILL);
    } while (checkpoints(cut).empty());  // it came between two runs
    EXPECT_EQ(run_program(folder_, {program(), "check", cut}).status, 0);
    std::vector<std::string> brief = often;
    brief.insert(brief.end(), {"--max-wall", "0.1"});
    Ended timed = run(cut, brief);
    EXPECT_THAT(timed.out, HasSubstr("from checkpoints, ")) << "of before the kill";
    while (timed.status == 5 && checkpoints(cut).empty())  // it ended between two runs
      timed = run(cut, brief);
    ASSERT_EQ(timed.status, 5) << timed.err;
    const Ended last = run(cut, {"--threads", threads});
    ASSERT_EQ(last.status, 0) << last.err;
    EXPECT_THAT(last.out, HasSubstr("from checkpoints, "));
    EXPECT_TRUE(timeless_table(folder_ / cut) == timeless_table(folder_ / whole));
    EXPECT_TRUE(checkpoints(cut).empty());
    if (keep_results) {
      EXPECT_TRUE(results(cut) == results(whole)) << "and nothing else stands there";
    } else {
      EXPECT_TRUE(fs::is_empty(folder_ / cut / "runs"));
    }
  }
}

TEST_F(StudyCrash, ShortRunsLeaveNoTrace) {
  ASSERT_EQ(run("out").status, 0);
  EXPECT_FALSE(fs::exists(folder_ / "out" / "runs"));
}

TEST_F(StudyCrash, ASignalOfABatchSystemLeavesCheckpointsAndTheStudyGoesOn) {
  Child child(folder_, line("out", {"--threads", "2", "--set", "time.step=1e-9"}));
  // before it has begun, the signal would end it
  ASSERT_TRUE(wait_until([&] { return fs::exists(folder_ / "out" / "status.json"); }));
  const std::size_t on_their_way =
      backend_name() == "Serial" || std::thread::hardware_concurrency() == 1 ? 1 : 2;
  EXPECT_TRUE(wait_until([&] {
    child.send(SIGUSR1);
    return checkpoints("out").size() >= on_their_way;
  })) << "one of each run on its way";
  const auto status = nlohmann::json::parse(read_file(folder_ / "out" / "status.json"));
  EXPECT_EQ(status["state"], "running");
  child.send(SIGHUP);
  EXPECT_EQ(child.wait(), 128 + SIGHUP);
}

TEST_F(StudyCrash, WhatCannotBeGoneOnFromIsSaidAndStopsNothing) {
  ASSERT_EQ(run("whole").status, 0);
  std::string whole = timeless_table(folder_ / "whole");
  const auto goes_on_all_the_same = [&](const std::string& name, const std::string& word) {
    const Ended ended = run(name);
    EXPECT_EQ(ended.status, 0) << ended.err;
    EXPECT_THAT(ended.err, AllOf(HasSubstr(word), HasSubstr("run scheme = \"adaptive\", seed 0")));
    EXPECT_TRUE(timeless_table(folder_ / name) == whole) << name;
    EXPECT_TRUE(checkpoints(name).empty());
    return ended.err;
  };
  // damaged, the one before too or not; of another program
  for (const std::string name : {"newer", "both", "version"}) {
    cut_off(name);
    const fs::path file = only_checkpoint(name), previous = file.string() + ".previous";
    std::string bytes = read_file(file);
    if (!fs::exists(previous)) std::ofstream(previous, std::ios::binary) << bytes;
    if (name == "version") {
      Checkpoint changed = checkpoint_of(bytes);
      changed.identity.program += "x";
      bytes = bytes_of(changed);
    } else {
      bytes[bytes.size() / 2] ^= 1;
    }
    std::ofstream(file, std::ios::binary) << bytes;
    if (name == "both") std::ofstream(previous, std::ios::binary) << bytes.substr(0, 100);
    EXPECT_EQ(run_program(folder_, {program(), "check", name}).status, name == "version" ? 0 : 4);
  }
  EXPECT_THAT(goes_on_all_the_same("newer", "is damaged in"), HasSubstr("which is older"));
  EXPECT_THAT(goes_on_all_the_same("both", "is damaged in"), HasSubstr("starts anew"));
  EXPECT_THAT(goes_on_all_the_same("version", "another version: "), HasSubstr("starts anew"));
  // a segment that is gone; and a study that keeps its results only now
  write_study(0.07, true);
  ASSERT_EQ(run("kept").status, 0);
  const std::string without = std::exchange(whole, timeless_table(folder_ / "kept"));
  cut_off("segment");
  fs::remove(segments_of(only_checkpoint("segment")) / segment_name(1));
  goes_on_all_the_same("segment", "000001.h5");
  EXPECT_TRUE(results("segment") == results("kept"));
  write_study(0.07, false);
  cut_off("later");
  write_study(0.07, true);
  goes_on_all_the_same("later", "its outputs and its accounts do not agree");
  EXPECT_TRUE(results("later") == results("kept"));
  // and the other way round: the state is enough
  cut_off("no_more");
  write_study(0.07, false);
  const Ended ended = run("no_more");
  EXPECT_EQ(ended.err, "");
  EXPECT_THAT(ended.out, HasSubstr("1 run from checkpoints"));
  EXPECT_TRUE(timeless_table(folder_ / "no_more") == without);
}

TEST_F(StudyCrash, NobodyTouchesACheckpointOfARunThatAnotherProcessRuns) {
  for (const bool keep_results : {false, true}) {
    write_study(0.07, keep_results);
    ASSERT_EQ(run("whole").status, 0);
    const std::string name = keep_results ? "kept" : "out";
    cut_off(name);
    const fs::path file = only_checkpoint(name);
    const std::string bytes = read_file(file);
    std::string result = file.string();
    result.resize(result.size() - std::string(".checkpoint").size());
    {
      const ClaimedOutput other(result);
      const Ended ended = run(name, {"--checkpoint", "1e-3"});
      EXPECT_EQ(ended.status, 0) << ended.err;
      EXPECT_EQ(ended.err, "");
      EXPECT_TRUE(timeless_table(folder_ / name) == timeless_table(folder_ / "whole"));
      EXPECT_EQ(read_file(file), bytes);
      EXPECT_EQ(only_checkpoint(name), file) << "the other runs' own are gone";
    }
    // what a process leaves that is killed after its run was finished
    EXPECT_EQ(run(name).status, 0);
    EXPECT_TRUE(checkpoints(name).empty());
    EXPECT_EQ(fs::exists(segments_of(file)), false);
  }
}

TEST_F(StudyCrash, AWallClockThatIsSetForthAndBackChangesNothing) {
  if (faulty_disk().empty()) GTEST_SKIP() << "nothing can be loaded before sanitizers";
  write_study(0.3, false);
  ASSERT_EQ(run("whole").status, 0);
  const auto run_meanwhile = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"env", "LD_PRELOAD=" + faulty_disk(), "FAULTY_CLOCK=-86400"};
    for (const std::string& word : line("out", more)) words.push_back(word);
    return run_program(folder_, words);
  };
  // on a busy machine the first of these may end before any run has begun
  for (const char* wall : {"0.02", "0.05", "0.1", "0.2", "0.5", "1", "2"}) {
    const Ended cut = run_meanwhile({"--checkpoint", "1e-3", "--max-wall", wall, "--threads", "1"});
    ASSERT_EQ(cut.status, 5) << cut.err;
    if (!checkpoints("out").empty()) break;
  }
  ASSERT_FALSE(checkpoints("out").empty());
  const Ended again = run_meanwhile({"--max-wall", "1:00:00"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_TRUE(timeless_table(folder_ / "out") == timeless_table(folder_ / "whole"));
  const auto status = nlohmann::json::parse(read_file(folder_ / "out" / "status.json"));
  EXPECT_EQ(status["state"], "complete");
  EXPECT_TRUE(status["seconds_elapsed"] >= 0 && status["seconds_elapsed"] < 60) << status;
  EXPECT_EQ(status["seconds_left"], 0);
}

TEST_F(StudyCrash, CutOffAtAnyCallItGoesOnToTheSameTable) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const std::vector<std::string> often{"--threads", "1", "--checkpoint", "1e-5"};
  const fs::path report = folder_ / "report", out = folder_ / "out";
  int cut = 0, went_on = 0, kind = 0;
  for (const bool keep_results : {false, true}) {
    write_study(4e-3, keep_results, 1);
    const std::string whole = keep_results ? "kept" : "whole";
    ASSERT_EQ(run(whole, {"--threads", "1"}).status, 0);
    const std::string expected = timeless_table(folder_ / whole);
    for (const char* how :
         {"FAULTY_ERROR=5", "FAULTY_ERROR=28", "FAULTY_SHORT=28", "FAULTY_KILL=1"}) {
      // every call with RA2D_TEST_LONG; else some of each kind, others for each way to fail
      const int stride = draws(1) > 1 ? 1 : keep_results ? 797 : 43;
      for (int call = 1 + 29 * kind++ % stride;; call += stride) {
        SCOPED_TRACE(fmt::format("{} at call {}, results {}", how, call, keep_results));
        fs::remove_all(out);
        fs::remove(report);
        std::vector<std::string> words{"env",
                                       "LD_PRELOAD=" + faulty_disk(),
                                       "FAULTY_FOLDER=" + out.string(),
                                       "FAULTY_TOLD=" + report.string(),
                                       fmt::format("FAULTY_CALL={}", call),
                                       how};
        for (const std::string& word : line("out", often)) words.push_back(word);
        const Ended broken = run_program(folder_, words);
        if (!fs::exists(report)) {
          EXPECT_EQ(broken.status, 0) << broken.err;
          break;
        }
        ++cut;
        ASSERT_THAT(broken.status, AnyOf(0, 4, 1000 + SIGKILL)) << broken.err;
        const Ended again = run("out", often);
        ASSERT_EQ(again.status, 0) << broken.err << again.err;
        EXPECT_EQ(again.err.find("starts anew"), std::string::npos) << "no valid file was damaged";
        went_on += again.out.find("from checkpoints, ") != std::string::npos;
        EXPECT_TRUE(timeless_table(out) == expected);
        EXPECT_TRUE(checkpoints("out").empty());
        if (keep_results) {
          EXPECT_TRUE(results("out") == results(whole));
        }
        ASSERT_LT(call, 5000);
      }
    }
  }
  RecordProperty("cut", cut);
  RecordProperty("went_on", went_on);
  EXPECT_GT(cut, 12);
  EXPECT_GT(went_on, cut / 8);
}

}  // namespace
}  // namespace ra2d::test
