// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/CLI.hpp>
#include <vector>

#include "host/surface/measure.hpp"
#include "host/surface/profile.hpp"

namespace ra2d {

/// How a measured profile is read and measured: the same options for all commands.
struct ProfileOptions {
  ProfileQuery query;
  MeasureOptions measure;
  bool has_filter = false;  // given by --filter or --cutoff
};

/// Adds the options that fill `options` in; returns them.
std::vector<CLI::Option*> add_profile_options(CLI::App& command, ProfileOptions& options);

}  // namespace ra2d
