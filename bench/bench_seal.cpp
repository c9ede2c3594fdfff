// SPDX-License-Identifier: BSD-3-Clause
// Cost of the seal for readers of a result (host/store/seal.hpp):
//
//   bench_seal --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
//
// The file has a second of samples at 100 kHz (45 MB, in memory if it lies on a tmpfs) of 19 and 2
// modes. Cases: `velocities`, the datasets that `ra2d analyze` reads; `probe`, those of `ra2d
// sound`; each with a seal (`sealed`), and as HDF5 alone reads them (`plain`). `whole` compares
// every byte with the seal, as `ra2d check` does. `analysis` is all of `ra2d analyze`: the seal is
// to take less than 5 % of it.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bench/program.hpp"
#include "host/analysis/analysis.hpp"
#include "host/store/result_reader.hpp"
#include "host/store/seal.hpp"
#include "host/store/store.hpp"

namespace ra2d::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t modes = 19, slider_modes = 2;
constexpr double rate = 100e3;  // Hz

ModesHeader modes_header(std::size_t count) {
  ModesHeader header;
  for (std::size_t k = 0; k < count; ++k)
    header.frequency.push_back(50.0 * static_cast<double>((k + 1) * (k + 1)));
  header.position = {0, 0.3};
  header.shape.resize(2 * count);
  header.mean_square = std::vector<double>(count, 3.0);
  return header;
}

/// A result of so many samples of noise, removed at the program's end.
class File {
 public:
  explicit File(std::size_t samples)
      : path_{fs::temp_directory_path() /
              fmt::format("ra2d-bench-seal-{}-{}.h5", getpid(), samples)} {
    ResultHeader header;
    header.scene = "[scene]\n";
    header.started = "2026-01-01T00:00:00Z";
    header.spacing = 8e-6;
    header.resonator = modes_header(modes);
    header.slider = modes_header(slider_modes);
    header.probe_position = {0.15};
    ResultFile file(path_, header);
    std::mt19937_64 dice(1);
    std::normal_distribution<double> normal(0, 1e-3);
    constexpr std::size_t at_once = 1000;
    for (std::size_t first = 0; first < samples; first += at_once) {
      SampleBlock b;
      const auto fill = [&](std::vector<double>& values, std::size_t width) {
        for (std::size_t i = 0; i < at_once * width; ++i) values.push_back(normal(dice));
      };
      for (std::size_t i = 0; i < at_once; ++i)
        b.time.push_back(static_cast<double>(first + i) / rate);
      for (auto* values : {&b.resonator_displacement, &b.resonator_velocity}) fill(*values, modes);
      for (auto* values : {&b.slider_displacement, &b.slider_velocity}) fill(*values, slider_modes);
      for (auto* values : {&b.force, &b.nodes, &b.probe_displacement, &b.probe_velocity, &b.kinetic,
                           &b.elastic, &b.contact, &b.damping_loss, &b.sliding_work, &b.load_work})
        fill(*values, 1);
      file.append(b);
    }
    ResultSummary summary;
    summary.v_rms = 1e-3;
    summary.lv = 120;
    summary.steps = static_cast<long>(samples);
    summary.ended = "complete";
    file.close(summary);
  }
  ~File() { fs::remove(path_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

const fs::path& file_of(std::size_t samples) {
  static const File large(100'000), small(2000);
  return samples == 100'000 ? large.path() : small.path();
}

void read_velocities(const fs::path& file, Bytes bytes) {
  const ResultReader reader(file, bytes);
  const std::size_t count = reader.contents().samples;
  for (const auto& [dataset, columns] :
       {std::pair<const char*, std::size_t>{"resonator/velocity", modes},
        {"probes/velocity", 1},
        {"contact/force", 1},
        {"energy/kinetic", 1},
        {"energy/elastic", 1},
        {"energy/contact", 1},
        {"energy/damping_loss", 1},
        {"energy/sliding_work", 1},
        {"energy/load_work", 1}})
    benchmark::DoNotOptimize(reader.columns(dataset, 0, count, 0, columns));
}

void read_probe(const fs::path& file, Bytes bytes) {
  const ResultReader reader(file, bytes);
  benchmark::DoNotOptimize(reader.columns("probes/velocity", 0, reader.contents().samples, 0, 1));
}

template <class Body>
void add_case(const std::string& name, std::size_t samples, Body body) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [=](benchmark::State& state) {
                                 const fs::path& file = file_of(samples);
                                 for (auto _ : state) body(file);
                               })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

void add_cases() {
  for (const std::size_t samples : {100'000, 2000}) {
    const std::string end = samples == 2000 ? "/small" : "";
    for (const Bytes bytes : {Bytes::hostile, Bytes::sealed}) {
      const std::string how = bytes == Bytes::sealed ? "sealed" : "plain";
      add_case("velocities/" + how + end, samples,
               [=](const fs::path& file) { read_velocities(file, bytes); });
      add_case("probe/" + how + end, samples,
               [=](const fs::path& file) { read_probe(file, bytes); });
    }
    add_case("whole" + end, samples, [](const fs::path& file) { require_seal(file); });
    add_case("analysis" + end, samples,
             [](const fs::path& file) { benchmark::DoNotOptimize(analyze(file, {})); });
  }
}

const Added added({"seal", add_cases});

}  // namespace
}  // namespace ra2d::bench
