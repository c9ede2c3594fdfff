// SPDX-License-Identifier: BSD-3-Clause
// Ledgers of studies. Run by run.sh. What begins with "ra2dlog" is taken as a ledger; no fuzzer
// would get past its hashes. Anything else is the bodies of records, each after two bytes that tell
// how long it is, and is sealed with hashes that are right. What is believed must be what would be
// written of it.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "host/base/errors.hpp"
#include "host/study/ledger.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ra2d;
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (!bytes.starts_with("ra2dlog")) {
    std::string ledger = ledger_head();
    while (size >= 2) {
      const std::size_t length =
          std::min<std::size_t>(data[0] | std::size_t{data[1]} << 8, size - 2);
      ledger += sealed_record(std::string(reinterpret_cast<const char*>(data + 2), length));
      data += 2 + length;
      size -= 2 + length;
    }
    bytes = ledger;
  }
  try {
    const ParsedLedger parsed = parse_ledger(bytes, "fuzzed.log");
    if (parsed.whole > bytes.size()) std::abort();
    std::string again = parsed.whole > 0 ? ledger_head() : std::string();
    for (const FinishedRun& run : parsed.runs) again += record_of(run);
    if (again != bytes.substr(0, parsed.whole)) std::abort();
  } catch (const FileError& fault) {
    if (std::string(fault.what()).empty()) std::abort();
  }
  return 0;
}
