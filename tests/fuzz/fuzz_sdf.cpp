// SPDX-License-Identifier: BSD-3-Clause
// Profiles in SDF, text and binary. Run by run.sh.
#include "host/surface/profile_sdf.hpp"
#include "tests/fuzz/fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ra2d;
  const auto file = fuzz::file_of(bytes, size);
  ProfileQuery row, column;
  row.row = 2;
  column.column = 2;
  for (const ProfileQuery& query : {ProfileQuery{}, row, column})
    fuzz::expect_profile_or_error(read_profile_sdf, file, query);
  return 0;
}
