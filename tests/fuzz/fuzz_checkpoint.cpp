// SPDX-License-Identifier: BSD-3-Clause
// Checkpoints. Run by run.sh. No fuzzer would get past their hashes: the input is the sections'
// bytes, each after two bytes that tell how many, and is sealed with hashes that are right. A state
// that is believed must be one that the kernels could index with.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "host/run/checkpoint.hpp"
#include "host/store/sealed_file.hpp"

namespace {

/// Lengths of the arrays of a small scene.
ra2d::Extents small_extents(bool adaptive) {
  ra2d::Extents n;
  n.width = n.lanes = 8;
  n.nodes = 16;
  n.groups = 2;
  if (adaptive)
    n.flight_levels = 3, n.contacts = 4;
  else
    n.active = 4;
  return n;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ra2d;
  std::vector<Section> sections;
  for (const char* name : {"identity", "state", "accounts", "time", "outputs"}) {
    std::size_t length = size >= 2 ? bytes[0] | std::size_t{bytes[1]} << 8 : 0;
    if (size >= 2) bytes += 2, size -= 2;
    length = std::min(length, size);
    sections.push_back({name, std::string(reinterpret_cast<const char*>(bytes), length)});
    bytes += length;
    size -= length;
  }
  try {
    const Checkpoint checkpoint = checkpoint_of(seal("ra2d checkpoint", 1, sections));
    if (checkpoint_of(bytes_of(checkpoint)).identity.scene != checkpoint.identity.scene)
      std::abort();
    for (const bool adaptive : {false, true})
      if (fault_of(checkpoint.state, small_extents(adaptive), 1000, 100).empty() &&
          (checkpoint.state.values.contacts.count > 4 ||
           checkpoint.state.values.shocks.open_count > 20))
        std::abort();
  } catch (const CorruptFile& fault) {
    if (std::string(fault.what()).empty()) std::abort();
  }
  return 0;
}
