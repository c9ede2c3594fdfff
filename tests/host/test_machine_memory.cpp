// SPDX-License-Identifier: BSD-3-Clause
// Limits of memory that a job or a container has.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "host/system/machine_memory.hpp"
#include "tests/child.hpp"

namespace {

namespace fs = std::filesystem;
using namespace ra2d;

class GroupMemory : public testing::Test {
 protected:
  void write(const fs::path& file, const std::string& text) const {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text << '\n';
  }
  std::int64_t limit() const { return group_memory(folder_ / "groups", folder_ / "root"); }

  test::Folder own_;
  fs::path folder_ = own_.path();
};
constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();

TEST_F(GroupMemory, IsTheLeastOfAGroupAndThoseAboveIt) {
  write("groups", "0::/system.slice/slurm/job_7/step_0");
  EXPECT_EQ(limit(), none);
  write("root/system.slice/slurm/job_7/memory.max", "3000000000");
  write("root/system.slice/slurm/job_7/step_0/memory.max", "max");
  write("root/system.slice/slurm/job_8/memory.max", "1000");  // another's
  EXPECT_EQ(limit(), 3'000'000'000);
  write("root/system.slice/slurm/job_7/step_0/memory.max", "2000000000");
  EXPECT_EQ(limit(), 2'000'000'000);
  write("root/memory.max", "1000000000");
  EXPECT_EQ(limit(), 1'000'000'000);
}

TEST_F(GroupMemory, OfTheFirstVersionHasAFolderOfItsOwn) {
  write("groups", "9:cpu,cpuacct:/slurm/job_7\n8:memory:/slurm/uid_0/job_7\n0::/user.slice");
  write("root/memory/slurm/uid_0/memory.limit_in_bytes", "5000000000");
  EXPECT_EQ(limit(), 5'000'000'000);
  write("root/memory/slurm/uid_0/job_7/memory.limit_in_bytes", "4000000000");
  EXPECT_EQ(limit(), 4'000'000'000);
}

TEST_F(GroupMemory, OfAContainerStandsAtTheRoot) {
  write("groups", "0::/docker/0123");  // as the machine calls it
  write("root/memory.max", "6000000000");
  EXPECT_EQ(limit(), 6'000'000'000);
}

TEST_F(GroupMemory, WithoutGroupsThereIsNone) {
  EXPECT_EQ(limit(), none);
  write("groups", "no group\n0::\n:\n0:://\n0:://a//b");
  EXPECT_EQ(limit(), none);
}

}  // namespace
