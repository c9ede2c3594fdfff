// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/checked_checkpoint.hpp"

#include <fmt/format.h>

#include "host/base/errors.hpp"
#include "host/run/checkpoint.hpp"
#include "host/store/checked_file.hpp"
#include "host/store/sealed_file.hpp"

namespace ra2d {

CheckedCheckpoint check_checkpoint(const std::filesystem::path& file) {
  CheckedCheckpoint found;
  try {
    const Checkpoint checkpoint = read_checkpoint(file);
    const std::filesystem::path folder = segments_of(file);
    double bytes = 0;
    for (std::size_t i = 0; i < checkpoint.segments.size(); ++i) {
      const std::filesystem::path segment = folder / segment_name(i + 1);
      bytes += static_cast<double>(checkpoint.segments[i].bytes);
      try {
        require_segment(segment, checkpoint.segments[i]);
        for (const std::string& fault : check_result(segment).faults)
          found.faults.push_back(fmt::format("'{}': {}", segment.string(), fault));
      } catch (const FileError& fault) {
        found.faults.emplace_back(fault.what());
      }
    }
    found.what = fmt::format(
        "a checkpoint of {}, {} steps into its run; {} segment{} of its outputs, {:.1f} MB, all "
        "with their hashes",
        checkpoint.identity.program, checkpoint.accounts.now.steps_made, checkpoint.segments.size(),
        checkpoint.segments.size() == 1 ? "" : "s", bytes * 1e-6);
  } catch (const CorruptFile& fault) {
    found.faults.push_back(fmt::format("it is {}", fault.what()));
  }
  return found;
}

}  // namespace ra2d
