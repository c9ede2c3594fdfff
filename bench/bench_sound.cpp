// SPDX-License-Identifier: BSD-3-Clause
// Sound at ten microphones, what it costs: filters and pressure of a second at 100 kHz, from the
// paper's plate with all modes up to 20 kHz and with 174 of them. quadrature/: its errors over the
// points of a panel.
//
//   bench_sound --benchmark_repetitions=5
//
// Predicted, for the paper's 19 modes: ten times 36 000 points of the face, spread over 13 samples
// each, 60 ms; transforms of 60 blocks of 2048 samples, 20 ms; 13 million products of lines, 30 ms.
// Came out, in processor time: 0.16 s; with 174 modes 0.78 s. Errors of 4, 6, 8, 10, 12 and 16
// points, half a metre away: 2e-3, 2e-6, 9e-10, 1e-13, 3e-14, 2e-14; 1 mm away from the face: 4,
// 0.3, 6e-3, 3e-5, 8e-8, 6e-14; of the resistance: 3, 0.03, 3e-5, 3e-6, 1e-6, 1e-9.
#include <benchmark/benchmark.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/program.hpp"
#include "bench/timing.hpp"
#include "host/body/beam.hpp"
#include "host/radiation/pressure.hpp"
#include "host/radiation/resistance.hpp"

namespace ra2d::bench {
namespace {

constexpr double rate = 100e3;

/// The paper's plate with so many modes.
Radiator plate(int modes) {
  BodySpec spec;
  spec.length = 0.3;
  spec.thickness = 0.002;
  spec.width = 0.2;
  spec.young = 210e9;
  spec.density = 7800;
  spec.modes = modes;
  return strip(make_beam(spec), spec.width);
}

/// The largest difference, over the largest value.
template <class Numbers>
double difference(const Numbers& a, const Numbers& b) {
  double apart = 0, size = 0;
  for (std::size_t k = 0; k < b.size(); ++k) {
    apart = std::max(apart, std::abs(a[k] - b[k]));
    size = std::max(size, std::abs(b[k]));
  }
  return apart / size;
}

/// Errors of the quadratures with so many points a panel, at 45 kHz, against finer panels of 24.
void add_convergence_case(int points) {
  add(fmt::format("quadrature/points:{}", points), 1, [=](benchmark::State& state) {
    constexpr double frequency = 45e3;
    const Radiator face = plate(19);
    const Air air = air_of(usual_celsius, usual_pascal);
    Fineness fineness, finest{24, 6, 0.4};
    fineness.points = points;
    for (auto _ : state) {
      for (const auto& [name, at] : {std::pair{"far", Position{0.15, 0.1, 0.5}},
                                     {"1_mm", Position{0.077, 0.13, 0.001}},
                                     {"beside", Position{-0.5, 0.4, 0.001}}})
        state.counters[name] = difference(transfer(face, air, at, frequency, fineness),
                                          transfer(face, air, at, frequency, finest));
      state.counters["resistance"] =
          difference(RadiationResistance(face, air, frequency, fineness).lower_half(frequency),
                     RadiationResistance(face, air, frequency, finest).lower_half(frequency));
      state.SetIterationTime(1e-3);
    }
  });
}

void add_sound_case(const std::string& name, int modes, std::size_t microphones,
                    std::size_t samples) {
  add(name, 1, [=](benchmark::State& state) {
    const Radiator face = plate(modes);
    const VelocityRecord record{
        samples, true, [&](std::size_t first, std::size_t count) {
          std::vector<std::vector<double>> found(face.modes.size(), std::vector<double>(count));
          for (std::size_t k = 0; k < found.size(); ++k)
            for (std::size_t n = 0; n < count; ++n)
              found[k][n] = static_cast<double>((first + n) * (2 * k + 1) % 1009) - 504;
          return found;
        }};
    std::vector<Position> places;
    for (std::size_t i = 0; i < microphones; ++i)
      places.push_back({0.15, 0.1, 0.1 * static_cast<double>(i + 1)});
    for (auto _ : state) {
      const auto begun = std::chrono::steady_clock::now();
      const PressureFilters filters(face, air_of(usual_celsius, usual_pascal), places, rate);
      std::vector<PressureFilters::Range> ranges;
      for (std::size_t i = 0; i < places.size(); ++i) {
        ranges.push_back(filters.carried(i, record));
        ranges.back().end = std::min(ranges.back().end, samples);
      }
      const auto pressures = filters.pressures(record, ranges);
      benchmark::DoNotOptimize(pressures.data());
      state.SetIterationTime(
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    }
  });
}

void add_cases() {
  add_sound_case("sound/small", 4, 1, 2000);
  add_sound_case("sound/paper", 19, 10, 100'001);
  add_sound_case("sound/174_modes", 174, 10, 100'001);
  for (const int points : {4, 6, 8, 10, 12, 16}) add_convergence_case(points);
}

const Added added({"sound", add_cases});

}  // namespace
}  // namespace ra2d::bench
