// SPDX-License-Identifier: BSD-3-Clause
// Studies under mpirun: one list of runs for all ranks, one table, and how all of them end.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/study/ledger.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"
#include "tests/studies.hpp"

namespace {

namespace fs = std::filesystem;
using namespace ra2d;
using test::Child;
using test::Ended;
using test::Folder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

#define SKIP_WITHOUT_MPIRUN() \
  if (test::mpirun().empty()) GTEST_SKIP() << "ra2d was built without MPI, or there is no mpirun"

class StudyRanks : public testing::Test {
 protected:
  StudyRanks() {
    std::ofstream(folder_ / "base.toml") << test::quick_scene;
    write_study(30);
  }
  void write_study(int seeds) const {
    std::ofstream(folder_ / "study.toml") << fmt::format(
        "base = \"base.toml\"\nseeds = {}\n[vary]\n"
        "speed = {{ key = \"scene.speed\", values = [0.1, 0.2] }}\n",
        seeds);
  }
  /// mpirun of so many ranks of a line. Each rank writes the number of its process to pid-RANK, and
  /// does what is to be done `before`.
  Child start(int ranks, const std::string& line, const std::string& before = "") const {
    const std::string rank = "RANK=${OMPI_COMM_WORLD_RANK:-$PMI_RANK}; echo $$ > pid-$RANK; " +
                             before + " exec " + test::program() + " " + line;
    // more ranks than processors, and as root; what MPI leaves behind is not ours
    return {folder_,
            {"/usr/bin/env", "OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
             "OMPI_MCA_rmaps_base_oversubscribe=1",
             fmt::format("OMPI_MCA_odls_base_sigkill_timeout={}", time_to_end_), "sh", "-c",
             "export ASAN_OPTIONS=$ASAN_OPTIONS:detect_leaks=0; exec \"$@\"", "sh", test::mpirun(),
             "-n", std::to_string(ranks), "sh", "-c", rank}};
  }
  Ended mpirun(int ranks, const std::string& line, const std::string& before = "") const {
    Child child = start(ranks, line, before);
    const int status = child.wait();
    return {status, child.out(), child.err()};
  }
  Ended alone(const std::string& line) const {
    return test::run_program(folder_, {"sh", "-c", "exec " + test::program() + " " + line});
  }
  std::string table(const std::string& name) const { return test::timeless_table(folder_ / name); }
  /// Runs in the ledger of a rank.
  std::size_t runs_of(const std::string& name, int rank) const {
    const fs::path file = StudyFolder{folder_ / name}.ledger({}, rank);
    return fs::exists(file) ? parse_ledger(test::read_file(file), file).runs.size() : 0;
  }
  /// Waits until each of two ranks has finished some runs.
  void wait_for_runs(const std::string& name) const {
    ASSERT_TRUE(test::wait_until([&] { return runs_of(name, 0) >= 5 && runs_of(name, 1) >= 5; }));
  }
  nlohmann::json status_of(const std::string& name) const {
    return nlohmann::json::parse(test::read_file(folder_ / name / "status.json"));
  }
  const Folder temporary_;
  const fs::path folder_ = temporary_.path();
  int time_to_end_ = 1;  // s, of ranks that Open MPI ends; it waits as long in any case, twice
};

TEST_F(StudyRanks, ATableIsTheSameForAnyRanks) {
  SKIP_WITHOUT_MPIRUN();
  ASSERT_EQ(alone("study study.toml -o alone").status, 0);
  const std::string whole = table("alone");
  struct Case {
    int ranks, threads;
  };
  for (const auto [ranks, threads] : {Case{1, 2}, {2, 1}, {3, 2}, {4, 1}}) {
    const std::string name = fmt::format("ranks-{}", ranks);
    const Ended ended =
        mpirun(ranks, fmt::format("study study.toml -o {} --threads {}", name, threads));
    ASSERT_EQ(ended.status, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("60 runs finished in"));
    EXPECT_EQ(ended.out.find("finished in"), ended.out.rfind("finished in")) << "said once";
    EXPECT_TRUE(table(name) == whole) << name;
    std::size_t runs = 0;
    for (int rank = 0; rank < ranks; ++rank) runs += runs_of(name, rank);
    EXPECT_EQ(runs, 60u) << "each ran once";
    EXPECT_EQ(status_of(name)["done"], 60);
    EXPECT_EQ(status_of(name)["state"], "complete");
  }
  // parts of it, each on two ranks; all processors of theirs, as without --threads
  for (const char* part : {"2/2", "1/2"})
    ASSERT_EQ(mpirun(2, fmt::format("study study.toml -o parts --shard {}", part)).status, 0);
  EXPECT_TRUE(table("parts") == whole);
  // and one process finds it done
  EXPECT_THAT(alone("study study.toml -o ranks-3").out, HasSubstr("all 60 runs are finished"));
}

TEST_F(StudyRanks, ARankThatIsKilledCostsTheRunsItHadBegun) {
  SKIP_WITHOUT_MPIRUN();
  write_study(400);  // 800 runs: two seconds
  ASSERT_EQ(alone("study study.toml -o whole --quiet").status, 0);
  Child child = start(3, "study study.toml -o cut --threads 1");
  wait_for_runs("cut");
  kill(std::stoi(test::read_file(folder_ / "pid-1")), SIGKILL);
  EXPECT_NE(child.wait(), 0);
  const std::size_t kept = runs_of("cut", 0) + runs_of("cut", 1) + runs_of("cut", 2);
  const Ended again = mpirun(3, "study study.toml -o cut --threads 1");
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr(fmt::format("{} were finished before", kept)));
  EXPECT_TRUE(table("cut") == table("whole"));
}

TEST_F(StudyRanks, InterruptedTheyKeepWhatIsFinished) {
  SKIP_WITHOUT_MPIRUN();
  write_study(5000);
  time_to_end_ = 4;  // also where the machine is busy
  Child child = start(2, "study study.toml -o cut --threads 1");
  wait_for_runs("cut");
  EXPECT_TRUE(test::wait_until([&] { return status_of("cut")["done"] != 0; }));
  const auto running = status_of("cut");
  EXPECT_EQ(running["state"], "running");
  EXPECT_GE(running["done"], 5);
  child.send(SIGTERM);
  EXPECT_NE(child.wait(), 0);
  EXPECT_EQ(status_of("cut")["state"], "interrupted");
  EXPECT_EQ(status_of("cut")["done"], runs_of("cut", 0) + runs_of("cut", 1)) << "of both ranks";
  EXPECT_THAT(alone("study status cut").out,
              HasSubstr(fmt::format("{} done", runs_of("cut", 0) + runs_of("cut", 1))));
}

TEST_F(StudyRanks, AnErrorOnOneRankEndsAll) {
  SKIP_WITHOUT_MPIRUN();
  write_study(5000);
  time_to_end_ = 4;  // also where the machine is busy
  fs::create_directories(folder_ / "out/ledger");
  const LedgerWriter held(StudyFolder{folder_ / "out"}.ledger({}, 1));
  const Ended ended = mpirun(3, "study study.toml -o out --threads 1");
  EXPECT_EQ(ended.status, 4) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("ra2d: rank 1: another process runs this part of the study"));
  EXPECT_EQ(status_of("out")["state"], "failed");
  // a wrong request: rank 0 reports it, once
  time_to_end_ = 1;
  const Ended wrong = mpirun(3, "study base.toml -o out");
  EXPECT_EQ(wrong.status, 2) << wrong.err;
  EXPECT_THAT(wrong.err, HasSubstr("ra2d: base.toml:"));
  EXPECT_EQ(wrong.err.find("ra2d: "), wrong.err.rfind("ra2d: ")) << wrong.err;
}

TEST_F(StudyRanks, ARankThatSeesOtherFilesEndsAll) {
  SKIP_WITHOUT_MPIRUN();
  const std::string elsewhere = "[ $RANK = 0 ] || cd other;";
  fs::create_directories(folder_ / "other/out");
  std::ofstream(folder_ / "other/out/study.json") << "of another study";
  const Ended folder = mpirun(2, "study study.toml -o out", elsewhere);
  EXPECT_EQ(folder.status, 4) << folder.err;
  EXPECT_THAT(folder.err, HasSubstr("rank 1: 'out' is not the folder that rank 0 sees"));

  // a copy of the folder, as it was left: the same study, but not the same place
  fs::remove_all(folder_ / "out");
  fs::remove_all(folder_ / "other/out");
  ASSERT_EQ(mpirun(2, "study study.toml -o out").status, 0);
  for (int rank = 0; rank < 2; ++rank) fs::remove(StudyFolder{folder_ / "out"}.ledger({}, rank));
  fs::copy(folder_ / "out", folder_ / "other/out", fs::copy_options::recursive);
  const Ended copy = mpirun(2, "study study.toml -o out", elsewhere);
  EXPECT_EQ(copy.status, 4) << copy.err;
  EXPECT_THAT(copy.err, HasSubstr("rank 1: 'out' is not the folder that rank 0 sees"));

  // a profile that is another one for each rank: by a link to where the process is
  fs::create_directory_symlink("/proc/self/cwd", folder_ / "here");
  for (const auto& [place, height] :
       {std::pair{"profile.csv", 1e-6}, {"other/profile.csv", 2e-6}}) {
    std::ofstream profile(folder_ / place);
    for (int i = 0; i < 520; ++i)
      profile << fmt::format("{} {}\n", 2e-5 * i, i % 50 == 25 ? height : 0.0);
  }
  std::ofstream(folder_ / "measured.toml") << fmt::format(R"(
base = "base.toml"
[set]
slider.surface = {{ kind = "file", path = "{}" }}
)",
                                                          (folder_ / "here/profile.csv").string());
  const std::string line = fmt::format("study measured.toml -o {}", (folder_ / "out").string());
  const Ended profile = mpirun(2, line, elsewhere);
  EXPECT_EQ(profile.status, 4) << profile.err;
  EXPECT_THAT(profile.err, HasSubstr("rank 1: this machine would not run the scenes of rank 0"));
}

TEST_F(StudyRanks, RanksWithOtherWordsEndAll) {
  SKIP_WITHOUT_MPIRUN();
  for (const auto& [words, own] :
       {std::pair{"--shard $((RANK + 1))/2", "--shard 2/2"},
        {"--set scene.duration=0.00$((RANK + 1))", "--shard 1/1 --set scene.duration=0.002"}}) {
    const Ended ended = mpirun(2, fmt::format("study study.toml -o out {}", words));
    EXPECT_EQ(ended.status, 2) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(fmt::format("rank 1: it was started with '{}'", own)));
  }
  EXPECT_FALSE(fs::exists(folder_ / "out/results.h5"));
  // wrong on one rank alone
  const Ended wrong = mpirun(2, "study study.toml -o out --threads $((1 - RANK))");
  EXPECT_EQ(wrong.status, 2) << wrong.err;
  EXPECT_THAT(wrong.err, HasSubstr("rank 1: "));
}

TEST_F(StudyRanks, WhatSharesNothingIsRefused) {
  // as mpirun and srun start a process, without them
  for (const std::string variables : {"OMPI_COMM_WORLD_SIZE=3 OMPI_COMM_WORLD_RANK=",
                                      "PMI_SIZE=3 PMI_RANK=", "SLURM_STEP_NUM_TASKS=3 PMIX_RANK="})
    for (const std::string line :
         {"run base.toml", "study study.toml --list", "study study.toml --dry-run",
          "study status out", "study merge out", "plan base.toml"}) {
      const auto as_rank = [&](int rank) {
        return test::run_program(
            folder_,
            {"sh", "-c", fmt::format("{}{} exec {} {}", variables, rank, test::program(), line)});
      };
      const Ended first = as_rank(0), second = as_rank(1);
      EXPECT_EQ(first.status, 2) << variables << line;
      EXPECT_THAT(first.err, HasSubstr("mpirun started 3 processes, but they share nothing"));
      // the others, too: rank 0 may run something else
      EXPECT_EQ(second.status, 2) << variables << line;
      EXPECT_THAT(second.err, HasSubstr("rank 1: mpirun started 3 processes"));
    }
  // one process is alone, whatever started it; so are those that srun starts without MPI
  for (const std::string one : {"OMPI_COMM_WORLD_SIZE=1 OMPI_COMM_WORLD_RANK=0",
                                "PMI_SIZE=x PMI_RANK=0", "SLURM_STEP_NUM_TASKS=3 SLURM_PROCID=1"})
    EXPECT_EQ(
        test::run_program(
            folder_, {"sh", "-c", one + " exec " + test::program() + " study study.toml --dry-run"})
            .status,
        0)
        << one;
}

TEST_F(StudyRanks, WithoutItsMpiItSaysSo) {
  const auto as_one_of_two = [&](const std::string& program) {
    return test::run_program(folder_, {"sh", "-c",
                                       "export ASAN_OPTIONS=$ASAN_OPTIONS:detect_leaks=0; "
                                       "OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0 exec " +
                                           program + " study study.toml -o out"});
  };
  if (!fs::exists(fs::path(test::program()).parent_path() / "libra2d_mpi.so")) {
    const Ended none = as_one_of_two(test::program());  // of a bundle, say
    EXPECT_EQ(none.status, 2);
    EXPECT_THAT(none.err, HasSubstr("but this ra2d was built without MPI"));
    return;
  }
  fs::create_directory(folder_ / "bin");
  const fs::path copy = folder_ / "bin/ra2d", library = folder_ / "bin/libra2d_mpi.so";
  fs::copy_file(test::program(), copy);
  const Ended none = as_one_of_two(copy);
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, AllOf(HasSubstr("mpirun started 2 processes, but this ra2d was built "
                                        "without MPI"),
                              HasSubstr("--shard I/N")));
  std::ofstream(library) << "no library";
  const Ended broken = as_one_of_two(copy);
  EXPECT_EQ(broken.status, 4);
  EXPECT_THAT(broken.err, HasSubstr("cannot load MPI: "));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  if (test::mpirun().empty()) return;
  // an mpirun of another MPI: each process is alone for the one that ra2d has
  const Ended other = as_one_of_two(test::program());
  EXPECT_EQ(other.status, 4);
  EXPECT_THAT(other.err,
              AllOf(HasSubstr("it started 2 processes, of which "), HasSubstr("sees 1")));
}

}  // namespace
