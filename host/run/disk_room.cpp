// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/disk_room.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/plan/plan.hpp"

namespace ra2d {

void require_disk_room(const Model& model, const std::filesystem::path& result, double done) {
  std::error_code fault;
  const std::filesystem::path folder =
      std::filesystem::absolute(result, fault).lexically_normal().parent_path();
  const std::filesystem::space_info disk = std::filesystem::space(folder, fault);
  if (fault || disk.capacity == 0 || disk.capacity == static_cast<std::uintmax_t>(-1)) return;
  const double needed = result_bytes(model) * (1 - std::clamp(done, 0.0, 1.0));
  const auto free = static_cast<double>(disk.available);
  if (needed <= free) return;
  throw FileError(
      fmt::format("cannot write '{}': {} samples (output.rate = {:g} Hz over {:g} s) would take "
                  "{}, and {} are free "
                  "on its disk: lower output.rate or scene.duration, or write elsewhere with -o",
                  result.string(), model.kept_samples(), model.scene.output.rate,
                  model.scene.output.window.empty()
                      ? model.scene.duration
                      : model.scene.output.window[1] - model.scene.output.window[0],
                  size_text(needed), size_text(free)));
}

}  // namespace ra2d
