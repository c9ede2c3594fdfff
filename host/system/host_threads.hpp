// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <functional>

/// Threads of the host.
namespace ra2d {

/// Threads that the caller may keep busy: as many as there are processors for this process, or as
/// limit_host_threads said. Who is one of several that work side by side has its share of them.
int host_threads();

/// From here on no more than these; 0: as many as there are processors.
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

/// Calls work(0), ..., work(count - 1) on up to `most` threads, the caller among them: who is done
/// takes the next. After a fault nothing new is begun; rethrows the first once all have ended.
void on_threads(int most, std::size_t count, const std::function<void(std::size_t)>& work);

}  // namespace ra2d
