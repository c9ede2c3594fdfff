// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <exception>
#include <functional>
#include <thread>

namespace ra2d {

/// Does one thing after the other beside who hands them over and can go on: a march, while its
/// samples are written. One is under way at most, on a thread that ends with it. Where the system
/// starts no thread, start() does it itself.
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
  /// ... or keeps it to itself.
  void finish() noexcept;
  /// Whether something was thrown that nobody has heard of yet.
  bool has_failed() const { return failed_; }

 private:
  void run(const std::function<void()>& task) noexcept;

  std::thread thread_;
  std::exception_ptr fault_;  // of the thread, until it is waited for
  std::atomic<bool> failed_{false};
};

}  // namespace ra2d
