// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "host/run/simulation.hpp"

namespace ra2d {

/// Hands what a run records to a file: a ResultFile, or a Recording.
template <class File>
class FileSink : public Sink {
 public:
  explicit FileSink(File& file) : file_{file} {}
  void take(const SampleBlock& samples) override { file_.append(samples); }
  void take(const std::vector<Shock>& shocks) override { file_.append(shocks); }

 private:
  File& file_;
};

}  // namespace ra2d
