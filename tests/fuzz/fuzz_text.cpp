// SPDX-License-Identifier: BSD-3-Clause
// Profiles in text, whatever stands in them. Run by run.sh.
#include "host/surface/profile_text.hpp"
#include "tests/fuzz/fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ra2d;
  const auto file = fuzz::file_of(bytes, size);
  ProfileQuery units, heights, comma;
  units.x_unit = to_unit("mm");
  units.z_unit = to_unit("nm");
  heights.spacing = 1e-6;
  comma.decimal = DecimalMark::comma;
  comma.column = 2;
  for (const ProfileQuery& query : {ProfileQuery{}, units, heights, comma})
    fuzz::expect_profile_or_error(read_profile_text, file, query);
  return 0;
}
