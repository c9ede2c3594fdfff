// SPDX-License-Identifier: BSD-3-Clause
// Runs that are cut off at every call that writes, by an error or by a kill, and go on: to the same
// bits as a run that was left alone. That they also go on from kills at any other instant,
// tests/hostile shows.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "host/base/errors.hpp"
#include "host/run/checkpoint.hpp"
#include "host/store/result_reader.hpp"
#include "host/store/sealed_file.hpp"
#include "tests/child.hpp"
#include "tests/effort.hpp"
#include "tests/hdf5_content.hpp"
#include "tests/places.hpp"
#include "tests/reseal.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AnyOf;
using testing::HasSubstr;

class Crash : public testing::Test {
 protected:
  Crash() : folder_{fs::canonical(disk_.path())}, out_{folder_ / "out.h5"} {}

  std::vector<std::string> line(std::vector<std::string> more = {}) const {
    std::vector<std::string> words{
        program(),        "run", scene_file("dang2012"), "--set", "scene.duration=2e-2", "--set",
        "time.step=1e-7", "-o",  out_.string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  Ended run(std::vector<std::string> more = {}) { return run_program(aside_.path(), line(more)); }
  /// Ends a run with two checkpoints, soon after its start; a slow machine makes one at a time.
  void cut_off() {
    for (int i = 0; i < 5 && !fs::exists(previous()); ++i) {
      const Ended ended = run({"--checkpoint", "1e-5", "--max-wall", "0.02"});
      ASSERT_EQ(ended.status, 5) << ended.err;
    }
  }
  std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
  fs::path checkpoint() const { return folder_ / "out.h5.checkpoint"; }
  fs::path previous() const { return folder_ / "out.h5.checkpoint.previous"; }

  Folder disk_, aside_;
  fs::path folder_, out_;
};

const std::vector<std::string> only_result{"out.h5"};

TEST_F(Crash, ARunThatIsCutOffAnywhereGoesOnToTheSameBits) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const std::vector<std::string> brief{"--set", "scene.duration=5e-3", "--checkpoint", "1e-5"};
  ASSERT_EQ(run(brief).status, 0);
  const Content expected = content_of(out_);
  ASSERT_EQ(expected.at("ended"), "complete");
  const fs::path report = aside_.path() / "report";
  int cut = 0;
  for (const char* how :
       {"FAULTY_ERROR=5", "FAULTY_ERROR=28", "FAULTY_SHORT=28", "FAULTY_KILL=1"}) {
    // every call with RA2D_TEST_LONG; else some of each kind, others for each way to fail
    const int stride = draws(1) > 1 ? 1 : 71;
    for (int call = 1 + (cut % stride);; call += stride) {
      SCOPED_TRACE(fmt::format("{} at call {}", how, call));
      fs::remove(out_);
      fs::remove(report);
      std::vector<std::string> words{"env",
                                     "LD_PRELOAD=" + faulty_disk(),
                                     "FAULTY_FOLDER=" + folder_.string(),
                                     "FAULTY_TOLD=" + report.string(),
                                     fmt::format("FAULTY_CALL={}", call),
                                     how};
      const std::vector<std::string> rest = line(brief);
      words.insert(words.end(), rest.begin(), rest.end());
      const Ended broken = run_program(aside_.path(), words);
      if (!fs::exists(report)) {
        EXPECT_EQ(broken.status, 0) << broken.err;
        EXPECT_EQ(content_of(out_), expected);
        break;
      }
      ++cut;
      ASSERT_THAT(broken.status, AnyOf(0, 4, 1000 + SIGKILL)) << broken.err;
      const Ended again = run(brief);
      ASSERT_EQ(again.status, 0) << broken.err << again.err;
      EXPECT_EQ(content_of(out_), expected);
      EXPECT_EQ(entries(), only_result);
      ASSERT_LT(call, 5000);
    }
  }
  RecordProperty("cut", cut);
  EXPECT_GT(cut, 20);
}

/// Makes a folder as its inode stood on the disk, by what was synced of it
/// (tests/faults/faulty_disk.c).
void restore(const fs::path& durable, const std::string& inode, const fs::path& folder) {
  fs::create_directory(folder);
  std::ifstream list(durable / ("LIST-" + inode));
  for (std::string kind, number, name; list >> kind >> number >> name;) {
    if (kind == "d")
      restore(durable, number, folder / name);
    else
      std::ofstream(folder / name, std::ios::binary) << read_file(durable / number);  // none: empty
  }
}

TEST_F(Crash, ASignalAsAFileIsMadeLeavesACheckpointOrNothing) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const std::vector<std::string> brief{"--set", "scene.duration=5e-3", "--checkpoint", "1e-5"};
  int ended = 0, without_checkpoint = 0;
  for (int made = 1;; ++made) {
    SCOPED_TRACE(fmt::format("at file or folder {}", made));
    std::vector<std::string> words{"env", "LD_PRELOAD=" + faulty_disk(),
                                   "FAULTY_FOLDER=" + folder_.string(),
                                   fmt::format("FAULTY_TERM_AT={}", made)};
    const std::vector<std::string> rest = line(brief);
    words.insert(words.end(), rest.begin(), rest.end());
    const Ended broken = run_program(aside_.path(), words);
    if (broken.status == 0) break;
    ++ended;
    ASSERT_EQ(broken.status, 128 + SIGTERM) << broken.err;
    for (const std::string& name : entries())
      EXPECT_THAT(name, testing::Not(HasSubstr(".partial")));
    if (!fs::exists(checkpoint())) {
      ++without_checkpoint;
      EXPECT_EQ(entries(), std::vector<std::string>{});
    }
    ASSERT_EQ(run(brief).status, 0);
    EXPECT_EQ(entries(), only_result);
    fs::remove(out_);
    ASSERT_LT(made, 100);
  }
  EXPECT_GE(without_checkpoint, 2);  // the folder of segments, the first file
  EXPECT_GT(ended, without_checkpoint);
}

TEST_F(Crash, WhatAPowerCutLeavesIsGoneOnFromToTheSameBits) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const std::vector<std::string> brief{"--set", "scene.duration=5e-3", "--checkpoint", "1e-5"};
  ASSERT_EQ(run(brief).status, 0);
  const Content expected = content_of(out_);
  const fs::path report = aside_.path() / "report", durable = aside_.path() / "durable";
  struct stat status {};
  ASSERT_EQ(stat(folder_.c_str(), &status), 0);
  const std::string inode = std::to_string(status.st_ino);
  int cuts = 0, went_on = 0;
  const int stride = draws(1) > 1 ? 1 : 41;
  for (int call = 1;; call += stride) {
    SCOPED_TRACE(fmt::format("power cut at call {}", call));
    for (const auto& entry : fs::directory_iterator(folder_)) fs::remove_all(entry.path());
    for (const fs::path& old : {report, durable}) fs::remove_all(old);
    fs::create_directory(durable);
    std::vector<std::string> words{"env",
                                   "LD_PRELOAD=" + faulty_disk(),
                                   "FAULTY_FOLDER=" + folder_.string(),
                                   "FAULTY_TOLD=" + report.string(),
                                   "FAULTY_DURABLE=" + durable.string(),
                                   "FAULTY_KILL=1",
                                   fmt::format("FAULTY_CALL={}", call)};
    const std::vector<std::string> rest = line(brief);
    words.insert(words.end(), rest.begin(), rest.end());
    const Ended broken = run_program(aside_.path(), words);
    const bool cut = fs::exists(report);
    ASSERT_EQ(broken.status, cut ? 1000 + SIGKILL : 0) << broken.err;
    ++cuts;
    const Folder after;
    const fs::path left = fs::canonical(after.path()) / "left";
    restore(durable, inode, left);
    std::vector<std::string> again = line(brief);
    *std::find(again.begin(), again.end(), out_.string()) = (left / "out.h5").string();
    const Ended ended = run_program(aside_.path(), again);
    EXPECT_EQ(ended.status, 0) << ended.err;
    EXPECT_EQ(content_of(left / "out.h5"), expected);
    EXPECT_EQ(std::distance(fs::directory_iterator(left), {}), 1);
    went_on += ended.err.find("goes on from t") != std::string::npos;
    if (!cut) {
      EXPECT_THAT(ended.out, HasSubstr("has this run already"));
      break;
    }
    ASSERT_LT(call, 5000);
  }
  RecordProperty("cuts", cuts);
  EXPECT_GT(cuts, 6);
  EXPECT_GT(went_on, cuts / 4);
}

TEST_F(Crash, TheWallTimeEndsARunWithACheckpointThatTheSameLineGoesOnFrom) {
  ASSERT_EQ(run().status, 0);
  const Content expected = content_of(out_);
  fs::remove(out_);
  cut_off();
  EXPECT_EQ(content_of(out_).at("ended"), "stopped by --max-wall");
  EXPECT_THAT(entries(), testing::IsSupersetOf({"out.h5", "out.h5.checkpoint", "out.h5.parts"}));
  const Ended again = run();
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.err, HasSubstr("goes on from t = "));
  EXPECT_EQ(content_of(out_), expected);
  EXPECT_EQ(entries(), only_result);
  // and once more: it is there
  const Ended third = run();
  EXPECT_EQ(third.status, 0);
  EXPECT_THAT(third.out, HasSubstr("has this run already"));
  EXPECT_EQ(content_of(out_), expected);
}

TEST_F(Crash, FreshStartsTheSameRunAnew) {
  EXPECT_EQ(run().status, 0);
  const std::string before = read_file(out_);
  EXPECT_EQ(run().status, 0);
  EXPECT_EQ(read_file(out_), before);
  EXPECT_EQ(run({"--fresh"}).status, 0);
  EXPECT_NE(read_file(out_), before) << "the time at which it was made is in it";
}

TEST_F(Crash, ACheckpointOfAnotherRunIsRefusedByNameAndLeftAlone) {
  cut_off();
  const std::string kept = read_file(checkpoint()), result = read_file(out_);
  const std::string words = "'speed = 0.1' there, 'speed = 0.2' here";
  Ended other = run({"--set", "scene.speed=0.2"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, testing::AllOf(HasSubstr(words), HasSubstr("--force")));
  EXPECT_EQ(read_file(checkpoint()), kept);
  EXPECT_EQ(read_file(out_), result);
  // as a kill leaves it, without a result
  fs::remove(out_);
  other = run({"--set", "scene.speed=0.2"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err,
              testing::AllOf(HasSubstr("another scene: " + words), HasSubstr("--fresh")));
  EXPECT_EQ(read_file(checkpoint()), kept);

  // what a program of another version, build or backend has written
  const Checkpoint own = checkpoint_of(kept);
  for (const auto& [member, word] : {std::pair{&Identity::program, "version"},
                                     {&Identity::arithmetic, "build"},
                                     {&Identity::backend, "backend"}}) {
    Checkpoint changed = own;
    changed.identity.*member += "x";
    const std::string bytes = bytes_of(changed);
    std::ofstream(checkpoint(), std::ios::binary) << bytes;
    const Ended ended = run();
    EXPECT_EQ(ended.status, 2) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(fmt::format("another {}:", word)));
    EXPECT_EQ(read_file(checkpoint()), bytes);
  }
}

TEST_F(Crash, OfADamagedCheckpointTheOneBeforeIsTaken) {
  ASSERT_EQ(run().status, 0);
  const Content expected = content_of(out_);
  fs::remove(out_);
  cut_off();
  ASSERT_TRUE(fs::exists(previous()));
  std::string bytes = read_file(checkpoint());
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(checkpoint(), std::ios::binary) << bytes;
  const std::string older = read_file(previous());
  const Ended cut = run({"--checkpoint", "1e6", "--max-wall", "1e-3"});
  EXPECT_EQ(cut.status, 5) << cut.err;
  EXPECT_THAT(cut.err, HasSubstr("out.h5.checkpoint' is damaged"));
  EXPECT_THAT(cut.err, HasSubstr("out.h5.checkpoint.previous', which is older"));
  // its own checkpoint takes the place of the damaged one, not that of the one that is whole
  EXPECT_EQ(read_file(previous()), older);
  const Ended again = run();
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(content_of(out_), expected);
  EXPECT_EQ(entries(), only_result);
}

TEST_F(Crash, APartWhoseCheckpointIsLostIsNotReplacedUnasked) {
  cut_off();
  const std::string part = read_file(out_);
  fs::remove(checkpoint());
  fs::remove(previous());
  const Ended again = run();
  EXPECT_EQ(again.status, 4);
  EXPECT_THAT(again.err, AllOf(HasSubstr("out.h5.checkpoint' is missing"), HasSubstr("--fresh")));
  EXPECT_EQ(read_file(out_), part);
  EXPECT_EQ(run({"--fresh"}).status, 0);
  EXPECT_EQ(entries(), only_result);
}

TEST_F(Crash, WhatWasCutOffBeforeItsFirstStepHasNothingToLose) {
  // a run that was told to end as it began has no checkpoint; it is made by hand: such a signal
  // would have to come within some milliseconds
  cut_off();
  fs::remove(checkpoint());
  fs::remove(previous());
  const std::int64_t none = 0;
  const hid_t file = H5Fopen(out_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t steps = H5Aopen(file, "steps", H5P_DEFAULT);
  H5Awrite(steps, H5T_NATIVE_INT64, &none);
  H5Aclose(steps);
  H5Fclose(file);
  reseal(out_);
  EXPECT_EQ(run().status, 0);
  EXPECT_EQ(entries(), only_result);
}

TEST_F(Crash, WithoutAnyWholeCheckpointTheRunIsRefusedAndNothingIsTouched) {
  cut_off();
  fs::remove(previous());
  const std::string kept = read_file(checkpoint());
  // a segment that it vouches for
  const fs::path segment = folder_ / "out.h5.parts" / "000001.h5";
  const std::string recorded = read_file(segment);
  std::string damaged = recorded;
  damaged[damaged.size() / 3] ^= 4;
  std::ofstream(segment, std::ios::binary) << damaged;
  Ended ended = run();
  EXPECT_EQ(ended.status, 4);
  EXPECT_THAT(ended.err, HasSubstr("000001.h5' is damaged"));
  fs::remove(segment);
  EXPECT_EQ(run().status, 4);
  std::ofstream(segment, std::ios::binary) << recorded;
  std::ofstream(checkpoint(), std::ios::binary) << kept.substr(0, kept.size() - 1);
  ended = run();
  EXPECT_EQ(ended.status, 4);
  EXPECT_THAT(ended.err, HasSubstr("--fresh"));
  EXPECT_EQ(read_file(checkpoint()).size(), kept.size() - 1);
  EXPECT_EQ(run({"--fresh"}).status, 0);
  EXPECT_EQ(entries(), only_result);
}

TEST_F(Crash, EveryTruncationAndEveryFlippedBitOfACheckpointIsRefused) {
  cut_off();
  const std::string bytes = read_file(checkpoint());
  EXPECT_NO_THROW(checkpoint_of(bytes));
  // the histograms are zeros for the most part: of them some
  const std::size_t stride = std::max<std::size_t>(1, bytes.size() / (4000 * draws(1)));
  for (std::size_t length = 0; length < bytes.size(); length += length < 4096 ? 7 : stride)
    EXPECT_THROW(checkpoint_of(bytes.substr(0, length)), CorruptFile) << length;
  EXPECT_THROW(checkpoint_of(bytes.substr(0, bytes.size() - 1)), CorruptFile);
  EXPECT_THROW(checkpoint_of(bytes + "x"), CorruptFile);
  for (std::size_t at = 0; at < bytes.size(); at += at < 4096 ? 3 : stride) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
    EXPECT_THROW(checkpoint_of(flipped), CorruptFile) << at;
  }
}

TEST_F(Crash, AStateThatDoesNotFitItsSceneIsRefused) {
  cut_off();
  fs::remove(previous());
  const Checkpoint own = checkpoint_of(read_file(checkpoint()));
  const auto refused = [&](auto change, const char* why) {
    Checkpoint changed = own;
    change(changed);
    std::ofstream(checkpoint(), std::ios::binary) << bytes_of(changed);
    const Ended ended = run();
    EXPECT_EQ(ended.status == 4 || ended.status == 2, true) << why << ended.status << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(why));
  };
  refused([](Checkpoint& c) { c.state.values.shocks.open_count = 1 << 30; }, "different times");
  refused([](Checkpoint& c) { c.state.values.shocks.run_count = -1; }, "shocks do not fit");
  refused([](Checkpoint& c) { c.state.values.latest_contact.pair[1] = -5; },
          "none of the slider's");
  refused([](Checkpoint& c) { c.state.values.contacts.count = 7; }, "closed nodes");
  refused([](Checkpoint& c) { c.state.values.control.flight_level = 61; }, "flight");
  refused([](Checkpoint& c) { c.state.values.control.shape_terms = 9; }, "terms");
  refused([](Checkpoint& c) { c.state.values.control.raised = 1; }, "order");
  refused([](Checkpoint& c) { c.state.values.control.used_share = std::nan(""); }, "order");
  refused([](Checkpoint& c) { c.state.values.control.series_scale = -1; }, "next step");
  refused([](Checkpoint& c) { c.state.values.control.expected_onset = std::nan(""); }, "next step");
  refused([](Checkpoint& c) { c.state.values.control.expected_release = -1; }, "next step");
  refused([](Checkpoint& c) { c.state.values.sampling.next = -1; }, "next sample");
  refused([](Checkpoint& c) { c.state.arrays[0].pop_back(); }, "another length");
  refused([](Checkpoint& c) { c.state.arrays.pop_back(); }, "another length");
  refused([](Checkpoint& c) { c.state.arrays.emplace_back(); }, "more arrays");
  refused([](Checkpoint& c) { c.state.values.step += 1; }, "different times");
  refused([](Checkpoint& c) { c.accounts.now.resonator_u.pop_back(); }, "another scene");
  refused([](Checkpoint& c) { c.accounts.samples += 1; }, "do not agree");
  refused([](Checkpoint& c) { c.accounts.now.shocks_begun += 1; }, "different times");
  refused([](Checkpoint& c) { c.accounts.now.open_shocks.emplace_back(); }, "different times");
  refused([](Checkpoint& c) { c.segments.at(0).samples = -1; }, "more samples than the run");
  refused([](Checkpoint& c) { c.segments.at(0).samples = std::int64_t{1} << 62; },
          "more samples than the run");
  std::ofstream(checkpoint(), std::ios::binary) << bytes_of(own);
  EXPECT_EQ(run().status, 0);
}

TEST_F(Crash, AnotherNumberOfThreadsGoesOnToTheSameBits) {
  ASSERT_EQ(run({"--threads", "1"}).status, 0);
  const Content expected = content_of(out_);
  for (const auto& [before, after] : {std::pair{"1", "2"}, {"2", "1"}}) {
    fs::remove(out_);
    const Ended cut = run({"--threads", before, "--checkpoint", "1e-5", "--max-wall", "0.02"});
    ASSERT_EQ(cut.status, 5) << cut.err;
    const Ended again = run({"--threads", after});
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_THAT(again.err, HasSubstr("goes on from t = "));
    EXPECT_EQ(content_of(out_), expected) << before << " threads, then " << after;
  }
}

TEST_F(Crash, AWallClockThatIsSetForthAndBackChangesNothing) {
  if (faulty_disk().empty()) GTEST_SKIP() << "nothing can be loaded before sanitizers";
  ASSERT_EQ(run().status, 0);
  const Content expected = content_of(out_);
  for (const char* jump : {"7200", "-7200", "1000000000"}) {  // s: two hours; thirty years
    SCOPED_TRACE(jump);
    fs::remove(out_);
    const auto run_meanwhile = [&](const std::vector<std::string>& more) {
      std::vector<std::string> words{"env", "LD_PRELOAD=" + faulty_disk(),
                                     std::string("FAULTY_CLOCK=") + jump};
      for (const std::string& word : line(more)) words.push_back(word);
      return run_program(aside_.path(), words);
    };
    // neither too early nor too late: a checkpoint every ten minutes is none in this run ...
    const Ended none = run_meanwhile({"--max-wall", "1:00:00"});
    EXPECT_EQ(none.status, 0) << none.err;
    EXPECT_EQ(content_of(out_), expected);
    const double wall = ResultReader(out_).contents().summary.wall_seconds;
    EXPECT_TRUE(wall > 0 && wall < 60) << wall;
    // and the requested ones are there in time
    fs::remove(out_);
    const Ended cut = run_meanwhile({"--checkpoint", "1e-5", "--max-wall", "0.02"});
    EXPECT_EQ(cut.status, 5) << cut.err;
    EXPECT_TRUE(fs::exists(checkpoint()));
    const Ended again = run_meanwhile({});
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_THAT(again.err, HasSubstr("goes on from t = "));
    EXPECT_EQ(content_of(out_), expected);
    EXPECT_EQ(entries(), only_result);
  }
}

TEST_F(Crash, ASecondProcessOnOneOutputIsRefused) {
  std::vector<std::string> words = line({"--set", "time.step=1e-9", "--set", "scene.duration=0.9"});
  Child first(aside_.path(), words);
  ASSERT_TRUE(wait_until([&] { return fs::exists(folder_ / "out.h5.parts"); }));
  const Folder other;
  const Ended second = run_program(other.path(), words);
  EXPECT_EQ(second.status, 4);
  EXPECT_THAT(second.err, HasSubstr("another process writes"));
  first.send(SIGTERM);
  EXPECT_EQ(first.wait(), 128 + SIGTERM);
}

TEST_F(Crash, ASignalOfABatchSystemLeavesACheckpointAndTheRunGoesOn) {
  Child child(aside_.path(), line({"--set", "time.step=1e-9", "--set", "scene.duration=0.9"}));
  ASSERT_TRUE(wait_until([&] { return fs::exists(folder_ / "out.h5.parts"); }));
  EXPECT_TRUE(wait_until([&] {
    child.send(SIGUSR1);
    return fs::exists(checkpoint());
  }));
  EXPECT_FALSE(fs::exists(out_)) << "it goes on";
  child.send(SIGHUP);
  EXPECT_EQ(child.wait(), 128 + SIGHUP);
  EXPECT_THAT(child.err(), HasSubstr("The same command continues from here"));
}

TEST_F(Crash, SegmentsThatSomebodyRemovesAreWrittenOnceMore) {
  const std::vector<std::string> more{"--set", "scene.duration=5e-2", "--checkpoint", "1e-4"};
  ASSERT_EQ(run(more).status, 0);
  const Content expected = content_of(out_);
  fs::remove(out_);
  Child child(aside_.path(), line(more));
  const fs::path parts = folder_ / "out.h5.parts";
  std::error_code none;
  bool removed = false;
  for (int i = 0; i < 20000 && !removed && !fs::exists(out_); ++i) {
    removed = fs::exists(parts / "000002.h5") && fs::remove_all(parts, none) > 2;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(child.wait(), 0) << child.err();
  EXPECT_TRUE(removed);
  EXPECT_EQ(content_of(out_), expected);
  EXPECT_EQ(entries(), only_result);
}

TEST_F(Crash, SegmentsOfARunningResultCanBeRead) {
  cut_off();
  std::int64_t samples = 0;
  double last = -1;
  for (int i = 1;; ++i) {
    const fs::path segment = folder_ / "out.h5.parts" / fmt::format("{:06}.h5", i);
    if (!fs::exists(segment)) break;
    const ResultReader reader(segment);
    const SampleBlock block = reader.samples(0, reader.contents().samples);
    for (const double time : block.time) {
      EXPECT_GT(time, last);
      last = time;
    }
    samples += static_cast<std::int64_t>(block.time.size());
    EXPECT_FALSE(reader.contents().summary.complete);
  }
  EXPECT_GT(samples, 0);
  if (!python().empty()) {
    std::ofstream(aside_.path() / "open.py")
        << "import glob, sys, xarray\n"
           "parts = sorted(glob.glob(sys.argv[1] + '/*.h5'))\n"
           "for group in ('contact', 'probes', 'energy', 'resonator'):\n"
           "    with xarray.open_mfdataset(parts, group=group, combine='nested', "
           "concat_dim='time',\n"
           "                               data_vars='minimal', coords='minimal', "
           "compat='override') as data:\n"
           "        assert data.sizes['time'] == int(sys.argv[2]), data.sizes\n"
           "        assert (data.time.diff('time') > 0).all()\n";
    const Ended opened = run_program(
        aside_.path(),
        {python(), "open.py", (folder_ / "out.h5.parts").string(), std::to_string(samples)});
    EXPECT_EQ(opened.status, 0) << opened.err;
  }
}

TEST_F(Crash, CheckFindsEveryDamageAndNothingElse) {
  cut_off();
  const auto check = [&](const fs::path& file) {
    return run_program(aside_.path(), {program(), "check", file.string()});
  };
  const fs::path segment = folder_ / "out.h5.parts" / "000001.h5";
  for (const fs::path& file : {out_, checkpoint(), previous(), segment}) {
    const Ended whole = check(file);
    EXPECT_EQ(whole.status, 0) << whole.err;
    EXPECT_THAT(whole.out, HasSubstr("all with their hashes"));
  }
  // a number of a dataset
  const std::string kept = read_file(out_);
  {
    const hid_t file = H5Fopen(out_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t force = H5Dopen2(file, "contact/force", H5P_DEFAULT);
    const hsize_t row = 3, one = 1;
    const hid_t place = H5Dget_space(force), memory = H5Screate_simple(1, &one, nullptr);
    H5Sselect_hyperslab(place, H5S_SELECT_SET, &row, nullptr, &one, nullptr);
    const double other = 1e-30;
    H5Dwrite(force, H5T_NATIVE_DOUBLE, memory, place, H5P_DEFAULT, &other);
    for (const hid_t handle : {memory, place}) H5Sclose(handle);
    H5Dclose(force);
    H5Ldelete(file, "energy/elastic", H5P_DEFAULT);
    H5Fclose(file);
  }
  Ended found = check(out_);
  EXPECT_EQ(found.status, 4);
  EXPECT_THAT(found.err, HasSubstr("it has no seal at its end"));
  EXPECT_THAT(found.err, HasSubstr("/contact/force is damaged"));
  EXPECT_THAT(found.err, HasSubstr("/energy/elastic is missing"));
  for (const double part : {0.0, 0.1, 0.5, 0.999}) {
    std::ofstream(out_, std::ios::binary)
        << kept.substr(0, static_cast<std::size_t>(part * static_cast<double>(kept.size())));
    EXPECT_EQ(check(out_).status, 4) << part;
  }
  std::ofstream(out_, std::ios::binary) << kept;
  EXPECT_THAT(check(out_).out, HasSubstr("beside it a checkpoint of"));
  fs::remove(segment);
  for (const fs::path& file : {checkpoint(), previous(), out_}) {
    found = check(file);
    EXPECT_EQ(found.status, 4);
    EXPECT_THAT(found.err, HasSubstr("000001.h5"));
  }
  EXPECT_EQ(check(folder_ / "none.h5").status, 4);
}

}  // namespace
}  // namespace ra2d::test
