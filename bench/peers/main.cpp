// SPDX-License-Identifier: BSD-3-Clause
// Solves a scene by a general-purpose integrator and prints one JSON object (peers.hpp).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/peers/peers.hpp"
#include "host/base/errors.hpp"
#include "host/scene_file/scene_file.hpp"

namespace {

using namespace ra2d;
using peers::Integrator;

const std::map<std::string, Integrator> integrators = {{"cvode-adams", Integrator::cvode_adams},
                                                       {"cvode-bdf", Integrator::cvode_bdf},
                                                       {"dopri5", Integrator::dopri5}};
const std::map<std::string, Nodes> searched = {{"all", Nodes::all},
                                               {"candidates", Nodes::candidates}};

template <class Value>
std::vector<std::string> names(const std::map<std::string, Value>& map) {
  std::vector<std::string> out;
  for (const auto& [name, value] : map) out.push_back(name);
  return out;
}

std::string list(const std::vector<double>& values) {
  std::string out = "[";
  for (const double x : values) out += fmt::format("{}{:.17g}", out.size() > 1 ? ", " : "", x);
  return out + "]";
}

int run(int argc, char** argv) {
  CLI::App app{
      "Solves a scene by CVODE or by Boost.Odeint's dopri5 and prints its end and its shocks as "
      "JSON.",
      "ra2d_peers"};
  std::filesystem::path file;
  std::string integrator = "cvode-adams", nodes = "candidates";
  std::vector<std::string> overrides;
  peers::PeerOptions options;
  app.add_option("SCENE", file, "scene file (TOML)")->required();
  app.add_option("--integrator", integrator)
      ->check(CLI::IsMember(names(integrators)))
      ->capture_default_str();
  app.add_option("--nodes", nodes, "which nodes are evaluated")
      ->check(CLI::IsMember(names(searched)))
      ->capture_default_str();
  app.add_option("--tolerance", options.tolerance, "relative tolerance")->capture_default_str();
  app.add_option("--until", options.until, "s [scene.duration]");
  app.add_option("--set", overrides, "overrides one value of the scene; repeatable")
      ->type_name("SECTION.KEY=VALUE")
      ->take_all()
      ->expected(1);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& request) {
    return app.exit(request) == 0 ? 0 : 2;
  }
  options.integrator = integrators.at(integrator);
  options.nodes = searched.at(nodes);

  const Model model = make_model(read_scene(file, overrides));
  if (app.count("--until") == 0) options.until = model.scene.duration;
  const peers::PeerResult r = march_peer(model, make_start(model), options);
  std::vector<double> start, duration, peak;
  for (const Shock& shock : r.shocks) {
    start.push_back(shock.start);
    duration.push_back(shock.duration);
    peak.push_back(shock.peak_force);
  }
  fmt::print(
      "{{\"integrator\": \"{}\", \"nodes\": \"{}\", \"tolerance\": {:.17g}, \"until\": {:.17g}, "
      "\"march_seconds\": {:.17g}, \"steps\": {}, \"evaluations\": {}, \"displacement_sums\": {}, "
      "\"resonator_displacement\": {}, \"resonator_velocity\": {}, "
      "\"slider_displacement\": {}, \"slider_velocity\": {}, "
      "\"shock_start\": {}, \"shock_duration\": {}, \"shock_peak_force\": {}}}\n",
      integrator, nodes, options.tolerance, options.until, r.march_seconds, r.steps, r.evaluations,
      r.displacement_sums, list(r.resonator_u), list(r.resonator_v), list(r.slider_u),
      list(r.slider_v), list(start), list(duration), list(peak));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const RequestError& fault) {
    fmt::print(stderr, "ra2d_peers: {}\n", fault.what());
    return 2;
  } catch (const FileError& fault) {
    fmt::print(stderr, "ra2d_peers: {}\n", fault.what());
    return 4;
  } catch (const std::exception& fault) {
    fmt::print(stderr, "ra2d_peers: {}\n", fault.what());
    return 3;
  }
}
