// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

/// Programs started by tests, in a folder of their own.
namespace ra2d::test {

std::string read_file(const std::filesystem::path& file);

/// An empty folder, removed with everything in it.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A child process with its output in files.
class Child {
 public:
  Child(const std::filesystem::path& folder, std::vector<std::string> words);
  /// Exit status, or 1000 + the signal that ended it.
  int wait();
  void send(int signal) const;
  /// Waits until the process has a handler of its own for the signal; false when it has ended
  /// before.
  bool wait_until_it_catches(int signal) const;
  /// Whether it ignores the signal.
  bool ignores(int signal) const;
  /// Threads that it has now.
  int threads() const;
  /// Processor time that it has taken so far [s].
  double processor_seconds() const;
  std::string out() const { return read_file(folder_ / "stdout"); }
  std::string err() const { return read_file(folder_ / "stderr"); }

 private:
  std::filesystem::path folder_;
  pid_t pid_ = -1;
};

/// Waits until something holds, but no more than two minutes: machines may be busy. Returns whether
/// it does.
template <class Holds>
bool wait_until(const Holds& holds) {
  for (int i = 0; i < 12'000; ++i) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

struct Ended {
  int status;  // as of Child::wait
  std::string out, err;
};

/// Runs a program to its end.
Ended run_program(const std::filesystem::path& folder, std::vector<std::string> words);

}  // namespace ra2d::test
