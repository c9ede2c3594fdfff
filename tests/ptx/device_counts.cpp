// SPDX-License-Identifier: BSD-3-Clause
// The marches of the paper's scenes, and of areal scenes, which have many packs of modes: what they
// take of a GPU, counted. bench/device_counts.py compares it with what it was. Prints JSON; with
// LINES_FOLDER how often each line of the PTX was issued, too, as NAME.lines, "LINE TIMES" each.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/device/backend.hpp"
#include "host/device/layout.hpp"
#include "host/model/model.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/ptx/march_program.hpp"
#include "tests/ptx/pack_march.hpp"

namespace ra2d::test {
namespace {

/// A stretch of a scene: so long from the start on a CPU, then counted, for so long or for so many
/// meetings of the lanes. Where scenes share a warp it holds others of other surfaces, too, and
/// meetings end all of them at one time, as a GPU's clock does.
struct Stretch {
  const char* name;
  const char* scene;
  SchemeKind scheme;
  double settle, counted;  // s
  std::uint64_t meetings = std::numeric_limits<std::uint64_t>::max();
};
// both schemes sampled alike, adaptive with the same tolerance as in bench_throughput's scenes
constexpr double rate = 1e4, tolerance = 1e-6;
constexpr Stretch plane_stretches[] = {
    {"adaptive_free", "dang2012.toml", SchemeKind::adaptive, 1e-2, 2e-2},
    {"adaptive_pinned", "dang2012-pinned.toml", SchemeKind::adaptive, 1e-2, 4e-2},
    {"backward_euler_free", "dang2012.toml", SchemeKind::backward_euler, 1e-2, 1.0, 2'000'000},
    {"backward_euler_pinned", "dang2012-pinned.toml", SchemeKind::backward_euler, 1e-2, 1.0,
     2'000'000}};
// as long as a list of the coarse search holds: over 32 nodes (kernels/candidate_groups.hpp)
constexpr Stretch areal_stretches[] = {
    {"areal_adaptive", "areal.toml", SchemeKind::adaptive, 1e-3, 1.024e-2},
    {"areal_backward_euler", "areal.toml", SchemeKind::backward_euler, 1e-3, 1.024e-2}};
std::span<const Stretch> stretches() {
  if constexpr (RA2D_TEST_PACKS > 1) return areal_stretches;
  return plane_stretches;
}
constexpr double areal_step = 1e-7, areal_spacing = 32e-6;  // s, m
constexpr int scenes_in_step = 16;  // in a block of `adaptive` (kernels/march.hpp)

/// Instructions that so many scenes in step take for a step on `scenes_in_step` warps, for as many
/// scenes as warps, of steps drawn at random. In every phase each warp takes the next scene, and
/// waits for the warp with most to do.
double issued_in_step(const std::vector<std::uint64_t>& stretches, std::size_t phases, int scenes) {
  constexpr int draws = 2000;
  std::mt19937 random{1};
  std::uniform_int_distribution<std::size_t> step(0, stretches.size() / phases - 1);
  double sum = 0;
  for (int draw = 0; draw < draws; ++draw) {
    std::vector<std::size_t> begins(static_cast<std::size_t>(scenes));
    for (std::size_t& begin : begins) begin = phases * step(random);
    for (std::size_t phase = 0; phase < phases; ++phase) {
      std::array<std::uint64_t, scenes_in_step> warps{};
      for (const std::size_t begin : begins)
        *std::min_element(warps.begin(), warps.end()) += stretches[begin + phase];
      sum += static_cast<double>(*std::max_element(warps.begin(), warps.end()));
    }
  }
  return sum / draws * scenes_in_step / scenes;
}

/// Of all scenes together.
struct Progress {
  double ticks = 0, adaptive_steps = 0, contact_steps = 0;
};
Progress progress_of(const TeamScenes& scenes) {
  Progress sum;
  for (SceneOnLanes* const scene : scenes) {
    const CarriedState& carried = scene->state().carried;
    sum.ticks += static_cast<double>(carried.step);
    sum.adaptive_steps += static_cast<double>(carried.adaptive_steps);
    sum.contact_steps += static_cast<double>(carried.sums.contact_steps);
  }
  return sum;
}

nlohmann::ordered_json count(const Stretch& stretch, MarchPrograms& programs,
                             const std::filesystem::path& scenes, const char* lines_folder) {
  Scene scene = read_scene(scenes / stretch.scene);
  scene.time.scheme = stretch.scheme;
  if (scene.kind == SceneKind::areal) {
    scene.spacing = areal_spacing;
    scene.spacing_y = areal_spacing;
  }
  if (stretch.scheme == SchemeKind::adaptive)
    scene.time.tolerance = tolerance;
  else if (scene.kind == SceneKind::areal)
    scene.time.step = areal_step;
  scene.output.rate = rate;
  std::vector<std::unique_ptr<SceneOnLanes>> scenes_there;
  TeamScenes teams;
  std::int64_t begin = 0, end = 0;
  do {
    const Model model = make_model(scene);
    const TeamShape shape = shape_of(form_of(scene));
    teams.push_back(
        scenes_there.emplace_back(std::make_unique<SceneOnLanes>(model, make_start(model), shape))
            .get());
    // where scenes wait for one another, no line through two counts tells how they depend on the
    // motion (bench/device_counts.py): so it is the same everywhere
    if (shape.width < warp_width) teams.back()->round_numbers();
    SceneState& state = teams.back()->state();
    begin = std::llround(stretch.settle / model.tick);
    end = begin + std::llround(stretch.counted / model.tick);
    while (state.carried.step < begin && state.carried.status == Status::running) {
      march_on_pack(*teams.back(), begin);
      state.out.samples.count = state.out.ended_shocks.count = 0;
    }
    scene.resonator.surface.seed += 2;
    scene.slider.surface.seed += 2;
  } while (teams.size() * static_cast<std::size_t>(teams.back()->shape().width) < warp_width);
  const Progress before = progress_of(teams);
  const Form form = form_of(scene);
  const Program& program = programs.of(form);
  PtxWarp warp = warp_for(program, teams, PtxWarp::Order::in_step);
  warp.check_races(false);
  // what one of 1056 scenes has of an H100's caches, about; and one of 132
  ModelCache cache64{64 << 10}, cache512{512 << 10};
  if (scene.kind == SceneKind::areal) {
    warp.add_cache(cache64);
    warp.add_cache(cache512);
  }
  march(warp, teams, end, stretch.meetings);
  const Progress after = progress_of(teams);
  const double ticks = after.ticks - before.ticks;
  const double steps =
      form == Form::adaptive ? after.adaptive_steps - before.adaptive_steps : ticks;
  std::ofstream lines;
  if (lines_folder != nullptr)
    lines.open(std::filesystem::path(lines_folder) / (std::string(stretch.name) + ".lines"));
  double all = 0, loads = 0, distinct = 0, at_work = 0;
  for (std::size_t k = 0; k < warp.counts().size(); ++k) {
    const auto times = static_cast<double>(warp.counts()[k]);
    all += times;
    at_work += static_cast<double>(warp.lanes()[k]) / warp_width;
    distinct += 1.0 - std::pow(1.0 - std::min(1.0, times / steps), scenes_in_step);
    if (program.instructions()[k].kind == Instruction::Kind::load) loads += times;
    if (lines.is_open()) lines << program.instructions()[k].line << ' ' << warp.counts()[k] << '\n';
  }
  if (lines_folder != nullptr && !lines.flush())
    throw std::runtime_error(fmt::format("{} cannot be written to", lines_folder));
  nlohmann::ordered_json counts = {
      {"march", MarchPrograms::name(form)},
      {"counted", steps},
      {"in_contact", (after.contact_steps - before.contact_steps) / ticks},
      {"ptx_instructions", all / steps},
      {"distinct_instructions", distinct},
      {"lanes_at_work", at_work / all},
      {"loads", loads / steps},
      {"sums", static_cast<double>(warp.reductions()) / steps},
      {"local_bytes", program.local_bytes()}};
  if (const auto phases = std::llround(static_cast<double>(warp.stretches().size()) / steps);
      phases > 0)
    for (const int times : {1, 2, 4})
      counts[times == 1 ? "in_step_instructions" : fmt::format("in_step_instructions_{}", times)] =
          issued_in_step(warp.stretches(), static_cast<std::size_t>(phases),
                         times * scenes_in_step);
  if (scene.kind == SceneKind::areal) {
    counts["bytes_beyond_64_kB"] = static_cast<double>(cache64.missed_bytes()) / steps;
    counts["bytes_beyond_512_kB"] = static_cast<double>(cache512.missed_bytes()) / steps;
  }
  return counts;
}

}  // namespace
}  // namespace ra2d::test

int main(int argc, char** argv) try {
  if (argc != 3 && argc != 4) {
    std::fputs("usage: device_counts PTX_FOLDER SCENES_FOLDER [LINES_FOLDER]\n", stderr);
    return 2;
  }
  const ra2d::Backend backend(1);
  ra2d::test::MarchPrograms programs(argv[1]);
  nlohmann::ordered_json counts;
  for (const auto& stretch : ra2d::test::stretches())
    counts[stretch.name] =
        ra2d::test::count(stretch, programs, argv[2], argc == 4 ? argv[3] : nullptr);
  std::puts(counts.dump(2).c_str());
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "device_counts: %s\n", e.what());
  return 1;
}
