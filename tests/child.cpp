// SPDX-License-Identifier: BSD-3-Clause
#include "tests/child.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>
#include <utility>

namespace ra2d::test {

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

Folder::Folder() {
  std::string name = (std::filesystem::temp_directory_path() / "ra2d_test_XXXXXX").string();
  path_ = mkdtemp(name.data());
}

Folder::~Folder() { std::filesystem::remove_all(path_); }

Child::Child(const std::filesystem::path& folder, std::vector<std::string> words)
    : folder_{folder} {
  pid_ = fork();
  if (pid_ != 0) return;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  // the signals as a shell hands them on, also where the tests run under nohup
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE}) std::signal(signal, SIG_DFL);
  if (chdir(folder.c_str()) != 0) _exit(125);
  dup2(open((folder / "stdout").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 1);
  dup2(open((folder / "stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
  execvp(argv[0], argv.data());
  _exit(126);
}

int Child::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

namespace {

/// Whether a line of /proc/PID/status, a mask in hexadecimal digits, has the signal.
bool has_signal(pid_t process, const std::string& line, int signal) {
  const std::string status = read_file("/proc/" + std::to_string(process) + "/status");
  const std::size_t at = status.find("\n" + line + ":");
  return at != std::string::npos &&
         (std::stoull(status.substr(at + line.size() + 2), nullptr, 16) >> (signal - 1) & 1) != 0;
}

}  // namespace

bool Child::wait_until_it_catches(int signal) const {
  while (!has_signal(pid_, "SigCgt", signal)) {
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT);
    if (ended.si_pid != 0) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

bool Child::ignores(int signal) const { return has_signal(pid_, "SigIgn", signal); }

void Child::send(int signal) const { kill(pid_, signal); }

int Child::threads() const {
  const std::filesystem::directory_iterator tasks("/proc/" + std::to_string(pid_) + "/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

double Child::processor_seconds() const {
  std::string stat = read_file("/proc/" + std::to_string(pid_) + "/stat");
  std::istringstream fields(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
  std::string skipped;
  for (int i = 3; i < 14; ++i) fields >> skipped;  // proc(5): utime and stime are numbers 14 and 15
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

Ended run_program(const std::filesystem::path& folder, std::vector<std::string> words) {
  Child child(folder, std::move(words));
  const int status = child.wait();
  return {status, child.out(), child.err()};
}

}  // namespace ra2d::test
