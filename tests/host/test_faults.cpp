// SPDX-License-Identifier: BSD-3-Clause
// Runs onto a disk on which every call in turn fails: nothing is lost and nothing is swallowed. The small
// scene passes through the same calls as the paper's, of which therefore every fourth or fifth fails here;
// all of them do with RA2D_TEST_LONG.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "tests/child.hpp"
#include "tests/effort.hpp"
#include "tests/places.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// What a result file holds: every dataset's size, numbers and hash, and whether it says that it is
/// complete. Empty for a file that is none.
using Content = std::map<std::string, std::string>;

std::string text_attribute(hid_t object, const char* name) {
  const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT), type = H5Aget_type(attribute);
  char* characters = nullptr;
  H5Aread(attribute, type, &characters);
  const std::string text = characters != nullptr ? characters : "";
  H5free_memory(characters);
  H5Tclose(type);
  H5Aclose(attribute);
  return text;
}

herr_t add_dataset(hid_t file, const char* name, const H5O_info_t* info, void* content) {
  if (info->type != H5O_TYPE_DATASET) return 0;
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(dataset);
  std::vector<hsize_t> extent(H5Sget_simple_extent_ndims(space));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  std::string bytes(H5Sget_simple_extent_npoints(space) * sizeof(double), '\0');
  const bool read =
      H5Dread(dataset, H5T_IEEE_F64LE, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) >= 0;
  (*static_cast<Content*>(content))[name] =
      fmt::format("{} {}: {}{}", read ? "" : "unreadable", fmt::join(extent, " x "),
                  text_attribute(dataset, "xxh3_128"), bytes);
  H5Sclose(space);
  H5Dclose(dataset);
  return 0;
}

Content content_of(const fs::path& path) {
  Content content;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) return content;
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, add_dataset, &content, H5O_INFO_BASIC);
  for (const char* timed : {"summary/step_seconds", "summary/wall_seconds"})
    if (content.erase(timed) == 0) content[timed] = "missing";
  content["ended"] = text_attribute(file, "ended");
  H5Fclose(file);
  return content;
}

struct Trial {
  std::string name;
  std::vector<std::string> words;  // of ra2d run
  int error;
  bool from_then_on;
  int stride;  // of the calls that fail; 1 where there is time (test.sh --long)
};

void PrintTo(const Trial& trial, std::ostream* out) { *out << trial.name; }

class Faults : public testing::TestWithParam<Trial> {};

TEST_P(Faults, EveryCallThatFailsIsReportedOrDoesNoHarm) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const Trial& trial = GetParam();
  const Folder disk, aside;
  const fs::path folder = fs::canonical(disk.path()), out = folder / "out.h5",
                 told = aside.path() / "told";
  const std::string earlier = "an earlier result";
  std::vector<std::string> words{program(), "run"};
  words.insert(words.end(), trial.words.begin(), trial.words.end());
  words.insert(words.end(), {"-o", out.string()});
  const Ended untouched = run_program(aside.path(), words);
  ASSERT_EQ(untouched.status, 0) << untouched.err;
  const Content expected = content_of(out);
  ASSERT_EQ(expected.at("ended"), "complete");

  std::vector<std::string> faulty{"env",
                                  "LD_PRELOAD=" + faulty_disk(),
                                  "FAULTY_FOLDER=" + folder.string(),
                                  "FAULTY_TOLD=" + told.string(),
                                  fmt::format("FAULTY_ERROR={}", trial.error),
                                  "FAULTY_CALL="};
  if (trial.from_then_on) faulty.emplace_back("FAULTY_FROM_THEN_ON=1");
  faulty.insert(faulty.end(), words.begin(), words.end());
  int reported = 0, harmless = 0;
  for (int call = 1;; call += draws(1) > 1 ? 1 : trial.stride) {
    faulty[5] = fmt::format("FAULTY_CALL={}", call);
    std::ofstream(out) << earlier;
    fs::remove(told);
    const Ended run = run_program(aside.path(), faulty);
    const bool failed = fs::exists(told);
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

const std::vector<std::string> paper{scene_file("dang2012"), "--set", "scene.duration=1e-3",
                                     "--set", "output.rate=4e6"};
// the first of its shocks
const std::vector<std::string> peaks{scene_file("peaks"),   "--set", "scene.start=0.10485", "--set",
                                     "scene.duration=4e-4", "--set", "scene.spacing=1e-4"};
INSTANTIATE_TEST_SUITE_P(Disk, Faults,
                         testing::Values(Trial{"PaperOnce", paper, EIO, false, 4},
                                         Trial{"PaperFromThenOn", paper, ENOSPC, true, 5},
                                         Trial{"PeaksOnce", peaks, ENOSPC, false, 1},
                                         Trial{"PeaksFromThenOn", peaks, EIO, true, 2}),
                         [](const auto& trial) { return trial.param.name; });

}  // namespace
}  // namespace ra2d::test
