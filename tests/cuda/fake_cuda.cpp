// SPDX-License-Identifier: BSD-3-Clause
// The functions of CUDA that Kokkos and ra2d call, on a machine without a card: so what a build for
// a GPU does on the host is tested, in bad luck, too. Work of a stream is done by a thread of its
// own. Memory of the card can be touched by such work alone; any other access ends the program. A
// launch of ra2d's march goes to the marches of pack_marches.cpp.
//
// RA2D_FAKE_CARD, words with spaces between them:
//
//   memory=BYTES   that the card has (256 MB)
//   seed=N         each piece of work waits for up to 0.3 ms before it begins; 0: it does not
//   fail=N         the N-th call fails, and none after it
//   fault=N        the N-th march touches what it may not: from there on all calls fail
//   calls=FILE     writes their names there, at the end, a line each
#include <cuda.h>
#include <cuda_runtime_api.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "kernels/state.hpp"
#include "kernels/tables.hpp"

extern "C" bool ra2d_march_on_pack(const ra2d::SceneTables& tables, ra2d::SceneState& state,
                                   std::int64_t target);

namespace {

constexpr int multiprocessors = 2;
constexpr int anything = 0xFF;  // not a number, not a place

[[noreturn]] void end_program(const std::string& why) {
  std::fprintf(stderr, "the fake card: %s\n", why.c_str());
  std::_Exit(99);
}

struct Wishes {
  std::size_t memory = std::size_t{256} << 20;
  unsigned seed = 0;
  long fail = 0, fault = 0;
  std::string calls;

  Wishes() {
    const char* const text = std::getenv("RA2D_FAKE_CARD");
    std::istringstream words(text == nullptr ? "" : text);
    for (std::string word; words >> word;) {
      const auto value = word.substr(word.find('=') + 1);
      if (word.starts_with("memory="))
        memory = std::stoull(value);
      else if (word.starts_with("seed="))
        seed = static_cast<unsigned>(std::stoul(value));
      else if (word.starts_with("fail="))
        fail = std::stol(value);
      else if (word.starts_with("fault="))
        fault = std::stol(value);
      else if (word.starts_with("calls="))
        calls = value;
      else
        end_program("RA2D_FAKE_CARD: what is '" + word + "'?");
    }
  }
};

/// All calls share it.
struct Card {
  const Wishes wishes;
  std::mutex mutex;
  std::vector<std::string> calls;  // their names
  cudaError_t fault = cudaSuccess;
  long marches = 0;
  std::map<char*, std::size_t> device, host;  // blocks, with their lengths
  std::size_t taken = 0;                      // of the card's memory
  int at_work = 0;                            // pieces of work that may touch it
  std::map<const void*, std::string> kernels;
  std::map<const void*, std::vector<char>> symbols;
  std::set<cudaStream_t> streams;

  ~Card() {
    if (wishes.calls.empty()) return;
    std::ofstream file(wishes.calls);
    for (const std::string& call : calls) file << call << '\n';
  }
  void protect(int how) {
    for (const auto& [block, bytes] : device) mprotect(block, bytes, how);
  }
};

Card& card() {
  static Card the_card;
  return the_card;
}

thread_local cudaError_t last_error = cudaSuccess;

cudaError_t returned(cudaError_t error) {
  if (error != cudaSuccess) last_error = error;
  return error;
}

/// Success: the call is to be done.
cudaError_t fate_of(const char* name, cudaError_t if_it_fails = cudaErrorUnknown) {
  const std::lock_guard lock(card().mutex);
  if (card().fault != cudaSuccess) return returned(card().fault);
  card().calls.emplace_back(name);
  return std::ssize(card().calls) == card().wishes.fail ? returned(if_it_fails) : cudaSuccess;
}

/// Does a piece of work, while which the card's memory can be touched.
void do_work(const std::function<void()>& work) {
  {
    const std::lock_guard lock(card().mutex);
    if (card().fault != cudaSuccess) return;
    if (card().at_work++ == 0) card().protect(PROT_READ | PROT_WRITE);
  }
  work();
  const std::lock_guard lock(card().mutex);
  if (--card().at_work == 0) card().protect(PROT_NONE);
}

}  // namespace

struct CUstream_st {
 public:
  CUstream_st() : dice_{card().wishes.seed}, thread_{[this] { run(); }} {}
  ~CUstream_st() {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  void add(std::function<void()> work) {
    const std::lock_guard lock(mutex_);
    work_.push_back(std::move(work));
    changed_.notify_all();
  }
  bool is_idle() {
    const std::lock_guard lock(mutex_);
    return work_.empty();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return work_.empty(); });
  }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [&] { return ends_ || !work_.empty(); });
      if (work_.empty()) return;
      const std::function<void()> work = work_.front();
      lock.unlock();
      if (card().wishes.seed > 0)
        std::this_thread::sleep_for(std::chrono::microseconds(dice_() % 300));
      do_work(work);
      lock.lock();
      work_.pop_front();
      changed_.notify_all();
    }
  }
  std::minstd_rand dice_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> work_;  // the first is being done
  bool ends_ = false;
  std::thread thread_;
};

namespace {

/// On the default stream work waits for that of all others, and the caller for it.
void give(cudaStream_t stream, std::function<void()> work) {
  if (stream != nullptr) return stream->add(std::move(work));
  std::set<cudaStream_t> all;
  {
    const std::lock_guard lock(card().mutex);
    all = card().streams;
  }
  for (cudaStream_t one : all) one->wait();
  do_work(work);
}

cudaError_t fault_of_card() {
  const std::lock_guard lock(card().mutex);
  return returned(card().fault);
}

std::size_t whole_pages(std::size_t bytes) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return (bytes + page - 1) / page * page;
}

cudaError_t allocate(const char* name, void** to, std::size_t bytes, bool on_device) {
  *to = nullptr;
  if (const auto e = fate_of(name, cudaErrorMemoryAllocation); e != cudaSuccess) return e;
  if (bytes == 0) return cudaSuccess;
  const std::lock_guard lock(card().mutex);
  bytes = whole_pages(bytes);
  if (on_device && card().taken + bytes > card().wishes.memory)
    return returned(cudaErrorMemoryAllocation);
  void* const block =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (block == MAP_FAILED) return returned(cudaErrorMemoryAllocation);
  std::memset(block, anything, bytes);
  if (on_device) {
    if (card().at_work == 0) mprotect(block, bytes, PROT_NONE);
    card().taken += bytes;
  }
  (on_device ? card().device : card().host)[static_cast<char*>(block)] = bytes;
  *to = block;
  return cudaSuccess;
}

/// Waits for all work, as the driver does.
cudaError_t release(const char* name, void* block, bool on_device) {
  if (block == nullptr) return cudaSuccess;
  if (const auto e = fate_of(name); e != cudaSuccess) return e;
  give(nullptr, [] {});
  const std::lock_guard lock(card().mutex);
  auto& blocks = on_device ? card().device : card().host;
  const auto found = blocks.find(static_cast<char*>(block));
  if (found == blocks.end()) return returned(cudaErrorInvalidValue);
  if (on_device) card().taken -= found->second;
  munmap(block, found->second);
  blocks.erase(found);
  return cudaSuccess;
}

cudaError_t work(const char* name, cudaStream_t stream, std::function<void()> task) {
  if (const auto e = fate_of(name); e != cudaSuccess) return e;
  give(stream, std::move(task));
  return cudaSuccess;
}

/// How Kokkos hands a march to its kernel: the functor (kernels/march.hpp) comes first.
struct LaunchedMarch {
  const ra2d::SceneTables* tables;
  ra2d::SceneState* states;
  const int* scenes;
  int count;
  const std::int64_t* targets;
  std::uint64_t most;
  double tick;
  double* seconds;

  void operator()() const {
    {
      const std::lock_guard lock(card().mutex);
      if (++card().marches == card().wishes.fault) card().fault = cudaErrorIllegalAddress;
      if (card().fault != cudaSuccess) return;
    }
    for (int i = 0; i < count; ++i) {
      const int scene = scenes[i];
      const auto begin = std::chrono::steady_clock::now();
      if (!ra2d_march_on_pack(tables[scene], states[scene], targets[scene]))
        end_program("no march of this form was compiled");
      seconds[scene] =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
  }
};

struct Configuration {
  dim3 grid, block;
  std::size_t shared = 0;
  cudaStream_t stream = nullptr;
};
thread_local std::vector<Configuration> configurations;

}  // namespace

extern "C" {

// ---- what a program says of its kernels before it begins

void** __cudaRegisterFatBinary(void*) {
  static void* handle = nullptr;
  return &handle;
}
void __cudaRegisterFatBinaryEnd(void**) {}
void __cudaUnregisterFatBinary(void**) {}
char __cudaInitModule(void**) { return 0; }
void __cudaRegisterVar(void**, char* variable, char*, const char*, int, std::size_t size, int,
                       int) {
  card().symbols[variable].resize(size);
}
void __cudaRegisterFunction(void**, const char* function, char*, const char* name, int, uint3*,
                            uint3*, dim3*, dim3*, int*) {
  card().kernels[function] = name;
}

// ---- launches

unsigned __cudaPushCallConfiguration(dim3 grid, dim3 block, std::size_t shared,
                                     cudaStream_t stream) {
  configurations.push_back({grid, block, shared, stream});
  return 0;
}
cudaError_t __cudaPopCallConfiguration(dim3* grid, dim3* block, std::size_t* shared, void* stream) {
  const Configuration& last = configurations.back();
  *grid = last.grid, *block = last.block, *shared = last.shared;
  *static_cast<cudaStream_t*>(stream) = last.stream;
  configurations.pop_back();
  return cudaSuccess;
}
cudaError_t __cudaGetKernel(cudaKernel_t* kernel, const void* function) {
  std::memcpy(kernel, &function, sizeof function);
  return cudaSuccess;
}
cudaError_t __cudaLaunchKernel(cudaKernel_t kernel, dim3, dim3, void** arguments, std::size_t,
                               cudaStream_t stream) {
  const void* function = nullptr;
  std::memcpy(&function, &kernel, sizeof function);
  const std::string& name = card().kernels.at(function);
  if (name.find("MarchI") != std::string::npos) {
    LaunchedMarch march;
    std::memcpy(&march, arguments[0], sizeof march);
    return work("a launch", stream, march);
  }
  if (name.find("query_cuda_kernel_arch") != std::string::npos) {
    int* to = nullptr;
    std::memcpy(&to, arguments[0], sizeof to);
    return work("a launch", stream, [to] { *to = 900; });
  }
  if (name.find("init_lock_array") != std::string::npos) return work("a launch", stream, [] {});
  end_program("a kernel that it does not have: " + name);
}

// ---- memory

cudaError_t cudaMalloc(void** to, std::size_t bytes) {
  return allocate("cudaMalloc", to, bytes, true);
}
cudaError_t cudaMallocManaged(void** to, std::size_t bytes, unsigned) {
  return allocate("cudaMallocManaged", to, bytes, false);
}
cudaError_t cudaMallocHost(void** to, std::size_t bytes) {
  return allocate("cudaMallocHost", to, bytes, false);
}
cudaError_t cudaHostAlloc(void** to, std::size_t bytes, unsigned) {
  return allocate("cudaHostAlloc", to, bytes, false);
}
cudaError_t cudaFree(void* block) { return release("cudaFree", block, true); }
cudaError_t cudaFreeHost(void* block) { return release("cudaFreeHost", block, false); }

cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind,
                            cudaStream_t stream) {
  return work("cudaMemcpyAsync", stream, [=] { std::memcpy(to, from, bytes); });
}
cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind) {
  return work("cudaMemcpy", nullptr, [=] { std::memcpy(to, from, bytes); });
}
cudaError_t cudaMemsetAsync(void* to, int value, std::size_t bytes, cudaStream_t stream) {
  return work("cudaMemsetAsync", stream, [=] { std::memset(to, value, bytes); });
}
cudaError_t cudaMemset(void* to, int value, std::size_t bytes) {
  return work("cudaMemset", nullptr, [=] { std::memset(to, value, bytes); });
}
cudaError_t cudaMemcpyToSymbol(const void* symbol, const void* from, std::size_t bytes,
                               std::size_t offset, cudaMemcpyKind) {
  return work("cudaMemcpyToSymbol", nullptr,
              [=] { std::memcpy(card().symbols.at(symbol).data() + offset, from, bytes); });
}
cudaError_t cudaMemPrefetchAsync(const void*, std::size_t, cudaMemLocation, unsigned,
                                 cudaStream_t) {
  return fate_of("cudaMemPrefetchAsync");
}
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total) {
  if (const auto e = fate_of("cudaMemGetInfo"); e != cudaSuccess) return e;
  const std::lock_guard lock(card().mutex);
  *total = card().wishes.memory;
  *free = *total - card().taken;
  return cudaSuccess;
}
cudaError_t cudaPointerGetAttributes(cudaPointerAttributes* attributes, const void*) {
  *attributes = {};
  return fate_of("cudaPointerGetAttributes");
}

// ---- streams

cudaError_t cudaStreamCreate(cudaStream_t* stream) {
  if (const auto e = fate_of("cudaStreamCreate"); e != cudaSuccess) return e;
  *stream = new CUstream_st;
  const std::lock_guard lock(card().mutex);
  card().streams.insert(*stream);
  return cudaSuccess;
}
cudaError_t cudaStreamDestroy(cudaStream_t stream) {
  if (const auto e = fate_of("cudaStreamDestroy"); e != cudaSuccess) return e;
  {
    const std::lock_guard lock(card().mutex);
    card().streams.erase(stream);
  }
  delete stream;
  return cudaSuccess;
}
cudaError_t cudaStreamQuery(cudaStream_t stream) {
  if (const auto e = fate_of("cudaStreamQuery"); e != cudaSuccess) return e;
  return stream == nullptr || stream->is_idle() ? cudaSuccess : returned(cudaErrorNotReady);
}
cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
  if (const auto e = fate_of("cudaStreamSynchronize"); e != cudaSuccess) return e;
  stream == nullptr ? give(nullptr, [] {}) : stream->wait();
  return fault_of_card();
}
cudaError_t cudaDeviceSynchronize() {
  if (const auto e = fate_of("cudaDeviceSynchronize"); e != cudaSuccess) return e;
  give(nullptr, [] {});
  return fault_of_card();
}
cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned) {
  *event = nullptr;
  return fate_of("cudaEventCreateWithFlags");
}
cudaError_t cudaEventDestroy(cudaEvent_t) { return fate_of("cudaEventDestroy"); }
CUresult cuStreamGetCtx(CUstream, CUcontext* context) {
  *context = nullptr;
  return static_cast<CUresult>(fate_of("cuStreamGetCtx"));
}
CUresult cuCtxPushCurrent(CUcontext) { return static_cast<CUresult>(fate_of("cuCtxPushCurrent")); }
CUresult cuCtxGetDevice(CUdevice* device) {
  *device = 0;
  return static_cast<CUresult>(fate_of("cuCtxGetDevice"));
}

// ---- the card, and what it says

cudaError_t cudaGetDeviceCount(int* count) {
  *count = 1;
  return fate_of("cudaGetDeviceCount");
}
cudaError_t cudaSetDevice(int device) {
  if (device != 0) return returned(cudaErrorInvalidDevice);
  return fate_of("cudaSetDevice");
}
cudaError_t cudaSetDeviceFlags(unsigned) { return fate_of("cudaSetDeviceFlags"); }
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* to, int) {
  *to = {};
  std::strcpy(to->name, "a fake card");
  to->major = 9;
  to->totalGlobalMem = card().wishes.memory;
  to->multiProcessorCount = multiprocessors;
  to->regsPerBlock = to->regsPerMultiprocessor = 65536;
  to->warpSize = 32;
  to->maxThreadsPerBlock = 1024;
  to->maxThreadsPerMultiProcessor = 2048;
  to->maxBlocksPerMultiProcessor = 32;
  to->sharedMemPerBlock = 48 << 10;
  to->sharedMemPerMultiprocessor = 228 << 10;
  for (int i = 0; i < 3; ++i) to->maxThreadsDim[i] = 1024, to->maxGridSize[i] = 65535;
  to->maxGridSize[0] = 0x7FFFFFFF;
  return fate_of("cudaGetDeviceProperties");
}
cudaError_t cudaFuncGetAttributes(cudaFuncAttributes* to, const void*) {
  *to = {};
  to->numRegs = 255;
  to->maxThreadsPerBlock = 256;
  to->maxDynamicSharedSizeBytes = 48 << 10;
  to->binaryVersion = to->ptxVersion = 90;
  return fate_of("cudaFuncGetAttributes");
}
cudaError_t cudaGetLastError() {
  const std::lock_guard lock(card().mutex);
  return card().fault != cudaSuccess ? card().fault : std::exchange(last_error, cudaSuccess);
}
const char* cudaGetErrorName(cudaError_t error) {
  switch (error) {
    case cudaSuccess:
      return "cudaSuccess";
    case cudaErrorMemoryAllocation:
      return "cudaErrorMemoryAllocation";
    case cudaErrorIllegalAddress:
      return "cudaErrorIllegalAddress";
    default:
      return "cudaErrorUnknown";
  }
}
const char* cudaGetErrorString(cudaError_t) { return "in words"; }

}  // extern "C"
