// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string_view>
#include <vector>

#include "host/surface/map_npy.hpp"
#include "host/surface/numbers_in_bytes.hpp"
#include "host/system/blocks.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

/// The numbers of rows first ... last - 1.
void write_rows(const HeightMap& map, bool as_npy, std::size_t first, std::size_t last,
                std::string& out) {
  constexpr std::size_t longest = 25;  // bytes of a double and what parts it from the next
  out.resize((last - first) * map.nx * (as_npy ? sizeof(double) : longest));
  char* at = out.data();
  for (std::size_t j = first; j < last; ++j)
    for (std::size_t i = 0; i < map.nx; ++i) {
      const double z = map.at(i, j);
      if (as_npy) {
        const double turned = little_endian<double>(reinterpret_cast<const char*>(&z));
        at = std::copy_n(reinterpret_cast<const char*>(&turned), sizeof z, at);
      } else {
        at = std::to_chars(at, at + longest, z).ptr;
        *at++ = i + 1 < map.nx ? ' ' : '\n';
      }
    }
  out.resize(static_cast<std::size_t>(at - out.data()));
}

}  // namespace

bool is_npy_name(const std::filesystem::path& file) { return file.extension() == ".npy"; }

void write_height_map(const std::filesystem::path& file, const HeightMap& map,
                      const std::string& title) {
  const bool as_npy = is_npy_name(file);
  std::string comment = title;  // without what makes entries and units of a header
  std::ranges::replace_if(
      comment, [](char c) { return std::string_view(",;=()[]").find(c) != std::string_view::npos; },
      ' ');
  PartialFile out(file);
  out.write(as_npy ? npy_header(map.ny, map.nx)
                   : fmt::format("# {}\n# z [m], a row of constant y in each line; spacing = {} m, "
                                 "spacing_y = {} m\n",
                                 comment, map.spacing, map.spacing_y));
  // parts of a few megabytes, made side by side
  const std::size_t a_part = std::max<std::size_t>(1, (std::size_t{1} << 17) / map.nx);
  std::vector<std::string> parts(8);
  for (std::size_t begin = 0; begin < map.ny; begin += parts.size() * a_part) {
    const std::size_t end = std::min(map.ny, begin + parts.size() * a_part);
    for (std::string& part : parts) part.clear();
    in_blocks(end - begin, a_part, [&](std::size_t part, std::size_t first, std::size_t last) {
      write_rows(map, as_npy, begin + first, begin + last, parts[part]);
    });
    for (const std::string& part : parts) out.write(part);
  }
  out.sync();
  out.publish();
}

}  // namespace ra2d
