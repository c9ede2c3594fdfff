// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

/// The subcommands of the program, one file each. They return the exit status (docs/results.md).
namespace ra2d {

enum ExitStatus : int {
  done = 0,
  wrong_request = 2,
  run_failed = 3,
  wrong_file = 4,
  out_of_time = 5,
  interrupted = 128  // and the signal's number
};

struct CommonOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  int threads = 1;
  int device = -1;  // less than 0: left to Kokkos
  bool quiet = false;
};

struct RunChoices {
  std::filesystem::path output;
  bool fresh = false, force = false;
  double checkpoint = 10;                                      // min between two checkpoints
  double most_wall = std::numeric_limits<double>::infinity();  // s
};

/// `ra2d run SCENE [-o OUT.h5]`
int run_command(const CommonOptions& common, RunChoices choices);

/// `ra2d plan SCENE`
int plan_command(const CommonOptions& common);

/// `ra2d plan --accuracy A SCENE [-o OUT.toml]`: what the scene could do without; writes the scene
/// with those choices. `budget`: s of wall time.
int plan_accuracy_command(const CommonOptions& common, double accuracy, double budget,
                          std::filesystem::path output);

/// `ra2d chart stability [SCENE] [-o PREFIX]`; without a scene, the paper's own. Writes PREFIX.csv,
/// PREFIX-regions.csv, PREFIX-modes.csv and, unless `plot` is false, PREFIX.png. A picture that was
/// asked for and cannot be drawn is a file that cannot be written: a script must not go on without
/// it.
int chart_stability_command(const CommonOptions& common, const std::string& prefix, bool plot);

/// `ra2d chart accuracy [SCENE] [-o PREFIX]`: the same for PREFIX.csv, PREFIX-long.csv and
/// PREFIX.png. Takes about `budget` seconds. `peers`: the program ra2d_peers; empty: the one that
/// was built beside this one, if there is one.
int chart_accuracy_command(const CommonOptions& common, const std::string& prefix, bool plot,
                           double budget, const std::filesystem::path& peers);

}  // namespace ra2d
