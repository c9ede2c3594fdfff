// SPDX-License-Identifier: BSD-3-Clause
#include "tests/warm_python.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/places.hpp"

namespace ra2d::test {
namespace {

/// The server. It ends when its standard input does.
class Server {
 public:
  Server() {
    if (python().empty()) return;
    const std::string script = source_folder() / "tests/host/warm_python.py";
    int input[2], output[2];
    // no other child may hold the server's input open
    if (pipe2(input, O_CLOEXEC) != 0 || pipe2(output, O_CLOEXEC) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      dup2(input[0], 0);
      dup2(output[1], 1);
      execlp(python().c_str(), python().c_str(), script.c_str(), nullptr);
      _exit(126);
    }
    close(input[0]);
    close(output[1]);
    input_ = input[1];
    for (char c; read(output[0], &c, 1) == 1 && c != '\n';) path_ += c;
    close(output[0]);
  }
  ~Server() {
    if (pid_ <= 0) return;
    close(input_);
    waitpid(pid_, nullptr, 0);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The PATH with its `python3`; empty where there is none.
  const std::string& path() const { return path_; }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
  std::string path_;
};

}  // namespace

WarmPython::WarmPython() : before_{std::getenv("PATH") ? std::getenv("PATH") : ""} {
  static const Server server;
  if (!server.path().empty()) setenv("PATH", server.path().c_str(), 1);
}

WarmPython::~WarmPython() { setenv("PATH", before_.c_str(), 1); }

}  // namespace ra2d::test
