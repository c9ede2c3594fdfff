// SPDX-License-Identifier: BSD-3-Clause
// The seal of result files, and the commands that compare with it. tests/hostile (readers) shows
// that no reader uses a damaged byte.
#include "host/store/seal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/system/child_answer.hpp"
#include "host/system/crash_message.hpp"
#include "host/system/input_file.hpp"
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
  EXPECT_EQ(seal_of(""), "ra2d seal 2 000000000000000000 99aa06d3014798d86001c324468d497f\n");
  EXPECT_EQ(seal_of("").size(), seal_line_size);
  const std::string seal = seal_of(std::string(1'000'000, 'x'));
  EXPECT_EQ(seal.size(), 245 * sizeof(Digest) + seal_line_size);  // 245 blocks of 4096
  EXPECT_THAT(seal, HasSubstr("ra2d seal 2 000000000001000000 "));
}

/// A sealed file, and its bytes as SealedBytes reads them.
class SealedFile : public testing::Test {
 protected:
  static constexpr std::size_t size = 100'000;  // 24 blocks and a part of one
  void SetUp() override {
    std::mt19937 dice(1);
    for (std::size_t i = 0; i < size; ++i) bytes_ += static_cast<char>(dice());
    put(bytes_ + seal_of(bytes_));
  }
  void put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
  /// Whether a part of the file reads, and then as it was written.
  bool reads(std::size_t at, std::size_t count) const {
    const InputFile input(path_);
    SealedBytes sealed(input.descriptor());
    std::string found(count, '?');
    try {
      sealed.read(at, found.data(), count);
    } catch (const Unsealed&) {
      return false;
    }
    EXPECT_TRUE(found == bytes_.substr(at, count)) << at << ' ' << count;
    return true;
  }
  bool opens() const {
    try {
      const InputFile input(path_);
      EXPECT_EQ(SealedBytes(input.descriptor()).size(), size);
    } catch (const Unreadable&) {
      return false;
    }
    return true;
  }

  const test::Folder folder_;
  const fs::path path_ = folder_.path() / "sealed";
  std::string bytes_;
};

TEST_F(SealedFile, ReadsWhatWasSealedFromAnyByteOn) {
  std::mt19937 dice(2);
  std::vector<std::pair<std::size_t, std::size_t>> parts = {
      {0, size}, {0, 0}, {size, 0}, {4095, 2}, {4096, 4096}, {1, 3 * 4096}, {size - 1, 1}};
  for (int i = 0; i < 200; ++i) {
    const std::size_t at = dice() % size;
    parts.emplace_back(at, dice() % (size - at));
  }
  for (const auto& [at, count] : parts) EXPECT_TRUE(reads(at, count)) << at << ' ' << count;
  // one after the other, as HDF5 asks for them
  const InputFile input(path_);
  SealedBytes sealed(input.descriptor());
  for (const auto& [at, count] : parts) {
    std::string found(count, '?');
    sealed.read(at, found.data(), count);
    EXPECT_TRUE(found == bytes_.substr(at, count));
  }
}

TEST_F(SealedFile, OfADamagedBlockNoByteIsRead) {
  for (const std::size_t at : {std::size_t{0}, std::size_t{5000}, size - 1}) {
    std::string damaged = bytes_;
    damaged[at] ^= 1;
    put(damaged + seal_of(bytes_));
    EXPECT_TRUE(opens());
    EXPECT_THROW(require_seal(path_), Unsealed);
    const std::size_t block = at / sealed_block * sealed_block;
    const std::size_t end = std::min(size, block + sealed_block);
    for (const std::size_t place : {block, (block + end) / 2, end - 1})
      EXPECT_FALSE(reads(place, 1)) << place;
    EXPECT_FALSE(reads(0, size));
    if (block > 0) {
      EXPECT_TRUE(reads(0, block));
    }
    if (end < size) {
      EXPECT_TRUE(reads(end, size - end));
    }
  }
}

TEST_F(SealedFile, EveryByteOfTheSealCounts) {
  const std::string seal = seal_of(bytes_);
  for (std::size_t i = 0; i < seal.size(); ++i) {
    std::string damaged = seal;
    damaged[i] ^= 1;
    put(bytes_ + damaged);
    EXPECT_FALSE(opens()) << i;
  }
  for (const std::string& whole :
       {bytes_ + seal.substr(1), bytes_ + seal + "x", bytes_ + "x" + seal, bytes_.substr(1) + seal,
        bytes_ + seal + seal, bytes_ + seal.substr(seal.size() - seal_line_size), seal}) {
    put(whole);
    EXPECT_FALSE(opens()) << whole.size();
  }
  put(bytes_ + seal);
  EXPECT_TRUE(opens());
}

/// Results of the programs before this seal: one hash of all bytes.
TEST_F(SealedFile, TheSealOfOlderProgramsIsReadToo) {
  Hash hash;
  hash.add(bytes_);
  const std::string line = "ra2d seal 1 000000000000100000 " + hash.text() + "\n";
  put(bytes_ + line);
  EXPECT_TRUE(opens());
  EXPECT_TRUE(reads(4000, 50'000));
  std::string damaged = bytes_ + line;
  damaged[5] ^= 1;
  put(damaged);
  EXPECT_FALSE(opens());
  put(bytes_ + "x" + line);
  EXPECT_FALSE(opens());
}

TEST_F(SealedFile, WhatChangesAfterTheOpeningIsNotRead) {
  const InputFile input(path_);
  SealedBytes sealed(input.descriptor());
  std::string found(size, '?');
  sealed.read(0, found.data(), 5000);
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(9000).put(static_cast<char>(bytes_[9000] ^ 1)).flush();
  EXPECT_THROW(sealed.read(0, found.data(), size), Unsealed);
  fs::resize_file(path_, 20'000);
  EXPECT_THROW(sealed.read(19'000, found.data(), 2000), Unsealed);
}

TEST_F(SealedFile, TheRestIsReadOnceAndWhole) {
  const auto spoil = [&](std::size_t at) {
    std::string damaged = bytes_;
    damaged[at] ^= 1;
    put(damaged + seal_of(bytes_));
  };
  // blocks 1 to 4, and 10
  const auto rest_fits = [&](std::size_t damaged_at) {
    put(bytes_ + seal_of(bytes_));
    const InputFile input(path_);
    SealedBytes sealed(input.descriptor());
    std::string found(size, '?');
    sealed.read(4096, found.data(), 13'000);
    sealed.read(41'000, found.data(), 100);
    spoil(damaged_at);
    try {
      sealed.check_rest();
    } catch (const Unsealed&) {
      return false;
    }
    return true;
  };
  for (std::size_t block = 0; block * sealed_block < size; ++block) {
    const bool was_read = (block >= 1 && block <= 4) || block == 10;
    EXPECT_EQ(rest_fits(std::min(block * sealed_block + 4000, size - 1)), was_read) << block;
  }
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

// ---- readers that ask for the seal
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
  const std::vector<std::vector<std::string>> readers_{{"analyze", "out.h5"},
                                                       {"sound", "out.h5", "-o", "out.wav"},
                                                       {"report", "out.h5", "-o", "out.html"},
                                                       {"plot", "out.h5", "-o", "out.png"}};
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

TEST_F(SealedResult, ARunSaysWhyItDoesNotReplaceAForeignFile) {
  put("notes of a year\n");
  const test::Ended ended = ra2d({"run", scene_, "-o", "out.h5"});
  EXPECT_EQ(ended.status, 2);
  EXPECT_THAT(ended.err, HasSubstr("'out.h5' is there already, a file that cannot be read as a "
                                   "result: it is no HDF5 file: expected one that ra2d wrote. It "
                                   "is left as it is"));
}

/// A text of an attribute stands behind its length in a heap. HDF5 1.10.8 crashes on a length
/// beyond the heap's end; a forger's seal says that all is well. `check` lets HDF5 crash in a child
/// process; readers look at the lengths before HDF5 does.
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
  for (const std::vector<std::string>& words : readers_) {
    const test::Ended reader = ra2d(words);
    EXPECT_EQ(reader.status, 4) << words.front();
    EXPECT_THAT(reader.err, HasSubstr("cannot read 'out.h5': the lengths of its texts do not fit "
                                      "their global heap"));
    EXPECT_FALSE(fs::exists(folder_.path() / words.back()) && words.size() > 2);
  }
}

#if !defined(__SANITIZE_ADDRESS__)  // which ends a process that crashes by itself
/// HDF5 calls itself for each level of a type, and here its stack ends before the levels do.
TEST_F(SealedResult, AReaderOutlivesACrashOfHdf5) {
  constexpr int levels = 3000;
  put(test::without_seal(whole_));
  const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  hid_t type = H5Tcopy(H5T_C_S1);
  for (int level = 0; level < levels; ++level) {
    const hid_t next = H5Tvlen_create(type);
    H5Tclose(type);
    type = next;
  }
  const hid_t scalar = H5Screate(H5S_SCALAR);
  ASSERT_GE(H5Adelete(file, "creator"), 0);
  const hid_t attribute = H5Acreate2(file, "creator", type, scalar, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(attribute, 0);
  H5Aclose(attribute);
  H5Sclose(scalar);
  H5Tclose(type);
  H5Fclose(file);
  test::reseal(path_);
  for (const std::vector<std::string>& words : readers_) {
    std::string command = "ulimit -s 512; exec " + test::program();  // kB
    for (const std::string& word : words) command += " " + word;
    const test::Ended reader = test::run_program(folder_.path(), {"/bin/sh", "-c", command});
    EXPECT_EQ(reader.status, 4) << words.front();
    EXPECT_THAT(reader.err, AllOf(HasSubstr("cannot read 'out.h5': HDF5 crashed on it"),
                                  HasSubstr("ra2d check out.h5")));
    EXPECT_FALSE(fs::exists(folder_.path() / words.back()) && words.size() > 2);
  }
}
#endif

// ---- crashes ------------------------------------------------------------------------------------

/// Runs `body` while a message lives.
void crash(const std::function<void()>& body) {
  const CrashMessage message("ra2d: cannot read 'x'\n");
  body();
}

TEST(CrashMessage, ACrashEndsAsAFileThatCannotBeRead) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto ends = testing::ExitedWithCode(4);
  EXPECT_EXIT(crash([] { raise(SIGSEGV); }), ends, "ra2d: cannot read 'x'");
  EXPECT_EXIT(crash([] { std::abort(); }), ends, "ra2d: cannot read 'x'");
  // the stack itself
  EXPECT_EXIT(crash([] {
                static const std::function<int(int)> deeper = [](int n) {
                  std::array<volatile char, 4096> much{};
                  much[static_cast<std::size_t>(n) % much.size()] = 1;
                  return deeper(n + 1) + much[0];
                };
                deeper(0);
              }),
              ends, "ra2d: cannot read 'x'");
}

TEST(CrashMessage, OtherCrashesStayWhatTheyAre) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto after = [] {
    std::signal(SIGSEGV, SIG_DFL);  // sanitizers have a handler of their own
    crash([] {});
    raise(SIGSEGV);
  };
  const auto other_thread = [] { crash([] { std::thread([] { raise(SIGABRT); }).join(); }); };
  EXPECT_EXIT(after(), testing::KilledBySignal(SIGSEGV), "");
  EXPECT_EXIT(other_thread(), testing::KilledBySignal(SIGABRT), "");
}

TEST(CrashMessage, GivesHandlersAndStackBack) {
  struct sigaction own {
  }, found{};
  own.sa_handler = [](int) {};
  struct sigaction before {};
  ASSERT_EQ(sigaction(SIGFPE, &own, &before), 0);
  stack_t stack_before{}, stack_after{};
  ASSERT_EQ(sigaltstack(nullptr, &stack_before), 0);
  crash([&] {
    ASSERT_EQ(sigaction(SIGFPE, nullptr, &found), 0);
    EXPECT_NE(found.sa_handler, own.sa_handler);
  });
  ASSERT_EQ(sigaction(SIGFPE, &before, &found), 0);
  EXPECT_EQ(found.sa_handler, own.sa_handler);
  ASSERT_EQ(sigaltstack(nullptr, &stack_after), 0);
  EXPECT_EQ(stack_after.ss_sp, stack_before.ss_sp);
  EXPECT_EQ(stack_after.ss_flags, stack_before.ss_flags);
}

}  // namespace
}  // namespace ra2d
