// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/peers.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/process.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

/// Paths in a scene are relative to its file, and this one moves.
void anchor(SurfaceSpec& surface, const fs::path& folder) {
  if (surface.kind == SurfaceKind::file) surface.path = fs::absolute(folder / surface.path);
}

}  // namespace

fs::path find_peers() {
  const fs::path built = program_folder() / "bench" / "peers" / "ra2d_peers";
  return access(built.c_str(), X_OK) == 0 ? built : fs::path{};
}

Peers::Peers(fs::path program, const Scene& scene) : program_{std::move(program)} {
  Scene moved = scene;
  anchor(moved.resonator.surface, scene.file.parent_path());
  anchor(moved.slider.surface, scene.file.parent_path());
  const std::string text = echo(moved);
  scene_ = memfd_create("ra2d-scene", MFD_CLOEXEC);
  if (scene_ < 0 || write(scene_, text.data(), text.size()) != std::ssize(text)) {
    const int why = errno;
    if (scene_ >= 0) close(scene_);
    throw FileError(
        fmt::format("the peers' scene cannot be written to memory: {}", std::strerror(why)));
  }
}

Peers::~Peers() { close(scene_); }

PeerRun Peers::run(const Peer& peer, double until, double limit) const {
  const ProgramRun ended = run_program(
      {program_.string(), "/dev/stdin", "--integrator", peer.integrator, "--nodes", peer.nodes,
       "--tolerance", toml_number(peer.tolerance), "--until", toml_number(until)},
      Output::kept, limit, scene_);
  PeerRun run;
  if (ended.late) {
    run.failure = fmt::format("given up after {:.3g} s", limit);
  } else if (ended.status != 0) {
    run.failure = ended.status < 0 ? fmt::format("'{}' could not be started", program_.string())
                                   : fmt::format("ra2d_peers ended with status {}", ended.status);
  } else {
    try {
      const auto result = nlohmann::json::parse(ended.out);
      const auto take = [&](const char* key, auto& to) { result.at(key).get_to(to); };
      take("march_seconds", run.seconds);
      take("resonator_displacement", run.state.resonator_u);
      take("resonator_velocity", run.state.resonator_v);
      take("slider_displacement", run.state.slider_u);
      take("slider_velocity", run.state.slider_v);
      take("shock_start", run.shock_start);
    } catch (const nlohmann::json::exception& fault) {
      run.failure = fmt::format("the answer of ra2d_peers cannot be read: {}", fault.what());
    }
  }
  return run;
}

}  // namespace ra2d
