// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <variant>
#include <vector>

#include "host/result/record.hpp"
#include "host/store/entries.hpp"

namespace ra2d {

/// Samples and shocks on their way to a file.
struct WriteBuffer {
  /// Samples of one dataset, row by row.
  struct Column {
    const Entry* entry;
    std::size_t width;
    std::vector<double> rows;

    const std::vector<double>& of(const SampleBlock& block) const {
      return block.*std::get<Sampled>(entry->source);
    }
  };
  std::vector<Column> columns;  // in the order of the entries; the first one is the time
  std::size_t rows = 0;
  std::vector<Shock> shocks;
};

}  // namespace ra2d
