// SPDX-License-Identifier: BSD-3-Clause
// Studies as their users write them, and the snapshots that their folders keep. Run by run.sh. A
// text that begins with a brace is taken as a snapshot.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "host/base/errors.hpp"
#include "host/study/study_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ra2d;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const Study study = text.starts_with('{') ? parse_snapshot(text, "study.json")
                                              : parse_study(text, "study.toml");
    std::size_t runs = study.seeds.size();
    for (const StudyDimension& dimension : study.dimensions) {
      if (dimension.size() == 0 || dimension.keys.empty()) std::abort();
      for (const auto& value : dimension.values)
        if (value.size() != dimension.keys.size()) std::abort();
      runs *= dimension.size();
    }
    if (runs == 0 || runs > most_study_runs) std::abort();
    // what was believed of a study must be what its snapshot says
    if (!text.starts_with('{') &&
        parse_snapshot(snapshot_text(study), "study.json").dimensions.size() !=
            study.dimensions.size())
      std::abort();
  } catch (const RequestError& fault) {
    if (std::string(fault.what()).empty()) std::abort();
  } catch (const FileError& fault) {
    if (std::string(fault.what()).empty()) std::abort();
  }
  return 0;
}
