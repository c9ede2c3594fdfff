// SPDX-License-Identifier: BSD-3-Clause
// Runs onto a disk on which every call in turn fails: nothing is lost and nothing is swallowed. The
// small scene passes through the same calls as the paper's, of which therefore every fourth or
// fifth fails here; all of them do with RA2D_TEST_LONG.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "tests/child.hpp"
#include "tests/effort.hpp"
#include "tests/hdf5_content.hpp"
#include "tests/places.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

struct FailingCall {
  std::string name;
  std::vector<std::string> words;  // of ra2d run
  int error;
  bool from_then_on;
  int stride;  // of the calls that fail; 1 where there is time (test.sh --long)
};

void PrintTo(const FailingCall& trial, std::ostream* out) { *out << trial.name; }

class Faults : public testing::TestWithParam<FailingCall> {};

TEST_P(Faults, EveryCallThatFailsIsReportedOrDoesNoHarm) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const FailingCall& trial = GetParam();
  const Folder disk, aside;
  const fs::path folder = fs::canonical(disk.path()), out = folder / "out.h5",
                 message = aside.path() / "message";
  const std::string earlier = "an earlier result";
  std::vector<std::string> words{program(), "run"};
  words.insert(words.end(), trial.words.begin(), trial.words.end());
  words.insert(words.end(), {"-o", out.string(), "--force"});
  const Ended untouched = run_program(aside.path(), words);
  ASSERT_EQ(untouched.status, 0) << untouched.err;
  const Content expected = content_of(out);
  ASSERT_EQ(expected.at("ended"), "complete");

  std::vector<std::string> faulty{"env",
                                  "LD_PRELOAD=" + faulty_disk(),
                                  "FAULTY_FOLDER=" + folder.string(),
                                  "FAULTY_TOLD=" + message.string(),
                                  fmt::format("FAULTY_ERROR={}", trial.error),
                                  "FAULTY_CALL="};
  if (trial.from_then_on) faulty.emplace_back("FAULTY_FROM_THEN_ON=1");
  faulty.insert(faulty.end(), words.begin(), words.end());
  int reported = 0, harmless = 0;
  for (int call = 1;; call += draws(1) > 1 ? 1 : trial.stride) {
    faulty[5] = fmt::format("FAULTY_CALL={}", call);
    std::ofstream(out) << earlier;
    fs::remove(message);
    const Ended run = run_program(aside.path(), faulty);
    const bool failed = fs::exists(message);
    const std::string what = fmt::format("call {}: {}", call, run.err);
    if (run.status == 4 && read_file(out) == earlier) {
      EXPECT_THAT(run.err, HasSubstr(std::strerror(trial.error))) << what;
      ++reported;
    } else {
      EXPECT_TRUE(content_of(out) == expected) << what;
      if (run.status == 4)
        EXPECT_THAT(run.err, HasSubstr("is written and whole")) << what;
      else
        EXPECT_EQ(run.status, 0) << what;
      ++harmless;
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << what;
    if (!failed) {
      EXPECT_EQ(run.status, 0) << what;
      break;
    }
    ASSERT_LT(call, 1000);
  }
  RecordProperty("reported", reported);
  RecordProperty("harmless", harmless);
  EXPECT_GT(reported, 10);
}

const std::vector<std::string> paper_run{scene_file("dang2012"), "--set", "scene.duration=1e-3",
                                         "--set", "output.rate=4e6"};
// the first of its shocks
const std::vector<std::string> peaks_run{
    scene_file("peaks"),   "--set", "scene.start=0.10485", "--set",
    "scene.duration=4e-4", "--set", "scene.spacing=1e-4"};
INSTANTIATE_TEST_SUITE_P(Disk, Faults,
                         testing::Values(FailingCall{"PaperOnce", paper_run, EIO, false, 4},
                                         FailingCall{"PaperFromThenOn", paper_run, ENOSPC, true, 5},
                                         FailingCall{"PeaksOnce", peaks_run, ENOSPC, false, 1},
                                         FailingCall{"PeaksFromThenOn", peaks_run, EIO, true, 2}),
                         [](const auto& trial) { return trial.param.name; });

}  // namespace
}  // namespace ra2d::test
