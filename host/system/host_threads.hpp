// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <functional>

/// Threads of the host.
namespace ra2d {

/// Threads that the caller may keep busy: as many as there are processors for this process, or as
/// limit_host_threads said. One of several that work side by side has its share of them.
int host_threads();

/// Allows at most so many threads from now on; 0: as many as there are processors.
void limit_host_threads(int most);

/// As long as it lives, the thread that made it has the share of one of `workers` in what its maker
/// had.
class ShareOfThreads {
 public:
  ShareOfThreads(int of_all, int workers);
  ~ShareOfThreads();
  ShareOfThreads(const ShareOfThreads&) = delete;
  ShareOfThreads& operator=(const ShareOfThreads&) = delete;

 private:
  int before_;
};

/// Calls work(0), ..., work(count - 1) on up to `most` threads, the caller among them: a thread
/// that is done takes the next. After a fault none is taken; rethrows the first one at the end.
void on_threads(int most, std::size_t count, const std::function<void(std::size_t)>& work);

}  // namespace ra2d
