// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/writer_thread.hpp"

#include <signal.h>

#include <system_error>
#include <utility>

namespace ra2d {
namespace {

/// While there is one, threads that are started leave the signals that end programs to the others:
/// there, a second one waits until the handler has done with the first.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t most;
    sigfillset(&most);
    for (const int own : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS, SIGPROF})
      sigdelset(&most, own);
    pthread_sigmask(SIG_BLOCK, &most, &before_);
  }
  ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  sigset_t before_;
};

}  // namespace

void WriterThread::start(std::function<void()> task) {
  wait();
  try {
    const SignalsHeld held;
    thread_ = std::thread([this, task] { run(task); });
  } catch (const std::system_error&) {  // there is none to be had
    task();
  }
}

void WriterThread::run(const std::function<void()>& task) noexcept {
  try {
    task();
  } catch (...) {
    fault_ = std::current_exception();
    failed_ = true;
  }
}

void WriterThread::wait() {
  finish();
  failed_ = false;
  if (fault_) std::rethrow_exception(std::exchange(fault_, nullptr));
}

void WriterThread::finish() noexcept {
  if (thread_.joinable()) thread_.join();
}

}  // namespace ra2d
