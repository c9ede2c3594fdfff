// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <exception>
#include <functional>
#include <thread>

namespace ra2d {

/// Runs one task after the other beside the caller: samples are written while the march goes on. At
/// most one task runs at a time, on a thread that ends with it. Where the system starts no thread,
/// start() runs the task itself.
class WriterThread {
 public:
  WriterThread() = default;
  ~WriterThread() { finish(); }
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  /// Begins with `task` when what is under way is done; throws what that has thrown, and then
  /// `task` is not begun.
  void start(std::function<void()> task);
  /// Waits until nothing is under way, and throws what that has thrown.
  void wait();
  /// Waits, and keeps what was thrown for a later wait().
  void finish() noexcept;
  /// Whether a task has thrown something that wait() has not rethrown yet.
  bool has_failed() const { return failed_; }

 private:
  void run(const std::function<void()>& task) noexcept;

  std::thread thread_;
  std::exception_ptr fault_;  // of the thread, until it is waited for
  std::atomic<bool> failed_{false};
};

}  // namespace ra2d
