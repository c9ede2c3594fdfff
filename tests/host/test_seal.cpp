// SPDX-License-Identifier: BSD-3-Clause
// The seal of result files, and who asks for it. That no reader takes a file that was damaged,
// tests/hostile shows (readers).
#include "host/store/seal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/system/asked_child.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"
#include "tests/reseal.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// The XXH3-128 of no bytes is the one in xxHash's own tests.
TEST(Seal, IsTheLineOfTheDocuments) {
  EXPECT_EQ(seal_of(""), "ra2d seal 1 000000000000000000 99aa06d3014798d86001c324468d497f\n");
  EXPECT_EQ(seal_of("").size(), seal_size);
  EXPECT_EQ(seal_of(std::string(1'000'000, 'x')).size(), seal_size);
  EXPECT_THAT(seal_of(std::string(1'000'000, 'x')), HasSubstr("ra2d seal 1 000000000001000000 "));
}

TEST(Seal, WaitsForNoPipeAndReadsNoDevice) {
  const test::Folder folder;
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const fs::path& file : {pipe, fs::path("/dev/zero"), folder.path()})
    EXPECT_THROW(require_seal(file), FileError) << file;
}

// ---- the child that HDF5 may crash
// ---------------------------------------------------------------

constexpr double much = 1e9, long_enough = 60;  // bytes, s

TEST(AskedChild, Answers) {
  const std::string text(1 << 20, 'x');  // more than a pipe holds
  const ChildAnswer found = ask_in_child([&] { return text; }, much, long_enough);
  EXPECT_EQ(found.fault, "");
  EXPECT_TRUE(found.text == text);
}

TEST(AskedChild, MayComeToAnyEnd) {
  const auto fault = [](const std::function<std::string()>& ask) {
    const ChildAnswer found = ask_in_child(ask, 1e8, 1);
    EXPECT_EQ(found.text, "");
    return found.fault;
  };
  const auto raises = [](int signal) {
    return [signal]() -> std::string {
      raise(signal);
      return "still there";
    };
  };
  EXPECT_THAT(fault(raises(SIGSEGV)), HasSubstr("ended by signal 11"));
  EXPECT_THAT(fault(raises(SIGABRT)), HasSubstr("ended by signal 6"));
  EXPECT_THAT(fault([]() -> std::string {
                for (volatile bool for_ever = true; for_ever;) continue;
                return {};
              }),
              HasSubstr("did not end within 1 s"));
  EXPECT_NE(fault([] { return std::string(1'000'000'000, 'x'); }), "");  // sanitizers abort
  EXPECT_THAT(fault([]() -> std::string { throw std::runtime_error("why"); }),
              HasSubstr("gave no answer"));
}

// ---- who asks for the seal
// -----------------------------------------------------------------------

class SealedResult : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(ra2d({"run", scene_, "-o", "out.h5"}).status, 0);
    whole_ = test::read_file(path_);
  }
  test::Ended ra2d(std::vector<std::string> words) const {
    words.insert(words.begin(), test::program());
    return test::run_program(folder_.path(), words);
  }
  void put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }

  const test::Folder folder_;
  const fs::path path_ = folder_.path() / "out.h5";
  const std::string scene_ = test::scene_file("drop");
  std::string whole_;
};

TEST_F(SealedResult, OfADamagedOneTheSameLineSaysNotThatItIsComplete) {
  EXPECT_THAT(ra2d({"run", scene_, "-o", "out.h5"}).out, HasSubstr("complete: nothing to do"));
  std::string bit = whole_;
  bit[bit.size() / 3] ^= 4;
  for (const std::string& bytes : {bit, whole_.substr(0, 5000), whole_ + "x"}) {
    put(bytes);
    const test::Ended ended = ra2d({"run", scene_, "-o", "out.h5"});
    EXPECT_EQ(ended.status, 2);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("out.h5"), HasSubstr("--force")));
    EXPECT_THAT(ended.out, Not(HasSubstr("complete")));
    EXPECT_TRUE(test::read_file(path_) == bytes) << "it is not lost without being asked";
    EXPECT_FALSE(fs::exists(folder_.path() / "out.h5.parts"));
  }
  EXPECT_EQ(ra2d({"run", scene_, "-o", "out.h5", "--fresh"}).status, 2);
  EXPECT_EQ(ra2d({"run", scene_, "-o", "out.h5", "--force"}).status, 0);
  EXPECT_EQ(ra2d({"check", "out.h5"}).status, 0);
}

/// A text of an attribute stands behind its length in a heap. HDF5 1.10.8 crashes on a length
/// beyond the heap's end; a forger's seal says that all is well.
TEST_F(SealedResult, CheckOutlivesHdf5OnAForgersBytes) {
  const std::size_t heap = whole_.find("GCOL");
  ASSERT_NE(heap, whole_.npos);
  constexpr std::size_t head = 16, last_byte_of_a_length = 15;
  std::string bytes = whole_;
  bytes[heap + head + last_byte_of_a_length] =
      '\x80';  // of the first text, which is the file's creator
  put(bytes);
  test::reseal(path_);
  const test::Ended ended = ra2d({"check", "out.h5"});
  EXPECT_EQ(ended.status, 4);
  // the address sanitizer ends a process that crashes by itself
  EXPECT_THAT(ended.err, testing::AnyOf(HasSubstr("HDF5 cannot read it: it ended by signal"),
                                        HasSubstr("HDF5 cannot read it: it gave no answer")));
}

}  // namespace
}  // namespace ra2d
