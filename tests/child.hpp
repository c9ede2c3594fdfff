// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

/// Programs started by tests, in a folder of their own.
namespace ra2d::test {

inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// An empty folder, removed with everything in it.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "ra2d_test_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A child process with its output in files.
class Child {
 public:
  Child(const std::filesystem::path& folder, std::vector<std::string> words) : folder_{folder} {
    pid_ = fork();
    if (pid_ != 0) return;
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    if (chdir(folder.c_str()) != 0) _exit(125);
    dup2(open((folder / "stdout").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 1);
    dup2(open((folder / "stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
    execvp(argv[0], argv.data());
    _exit(126);
  }
  /// Exit status, or 1000 + the signal that ended it.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  void send(int signal) const { kill(pid_, signal); }
  std::string out() const { return read_file(folder_ / "stdout"); }
  std::string err() const { return read_file(folder_ / "stderr"); }

 private:
  std::filesystem::path folder_;
  pid_t pid_ = -1;
};

struct Ended {
  int status;  // as of Child::wait
  std::string out, err;
};

/// Runs a program to its end.
inline Ended run_program(const std::filesystem::path& folder, std::vector<std::string> words) {
  Child child(folder, std::move(words));
  const int status = child.wait();
  return {status, child.out(), child.err()};
}

}  // namespace ra2d::test
