// SPDX-License-Identifier: BSD-3-Clause
// Height maps: .npy and matrices in text, and whole SDF and X3P. Run by run.sh.
#include "host/surface/map_file.hpp"
#include "tests/fuzz/fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ra2d;
  const auto file = fuzz::file_of(bytes, size);
  MapQuery spaced;
  spaced.spacing = 1e-6;
  spaced.z_unit = to_unit("nm");
  for (const MapQuery& query : {MapQuery{}, spaced}) try {
      HeightMap map = read_height_map(file, query);
      if (!(map.spacing > 0) || !(map.spacing_y > 0)) std::abort();
      if (map.nx < 2 || map.ny < 2 || map.heights.size() != map.nx * map.ny) std::abort();
      for (const double z : map.heights)
        if (std::isinf(z)) std::abort();
      prepare_map(map, {1e-5, {1}}, "map", nullptr);
      if (map.missing() > 0) std::abort();
    } catch (const RequestError& error) {
      if (std::string(error.what()).empty()) std::abort();
    } catch (const FileError&) {
    }
  return 0;
}
