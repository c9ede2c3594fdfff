// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace ra2d::bench {

/// Prints like the console reporter, and keeps the time per step of every case for a table of
/// ratios.
class RatioReporter : public benchmark::ConsoleReporter {
 public:
  RatioReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      failed_ = failed_ || run.error_occurred;
      const auto wall = run.counters.find("ns_per_step");
      const auto processor = run.counters.find("cpu_ns_per_step");
      if (run.run_type != Run::RT_Iteration || run.error_occurred || wall == run.counters.end() ||
          processor == run.counters.end())
        continue;
      Case& one = cases_[run.run_name.function_name];
      one.wall.push_back(wall->second);
      one.processor.push_back(processor->second);
    }
    ConsoleReporter::ReportRuns(runs);
  }

  /// Whether any case gave up.
  bool failed() const { return failed_; }

  /// Median time per step of a case [ns], NaN without it.
  double median_of(const std::string& name) const {
    const auto found = cases_.find(name);
    return found == cases_.end() ? std::numeric_limits<double>::quiet_NaN()
                                 : median(found->second.wall);
  }

  /// Time per step: medians over the repetitions, and those of the baselines on the same scene over
  /// them.
  std::string table() const {
    if (cases_.empty()) return {};
    std::string out = fmt::format("\n{:<24}{:>14}{:>14}{:>14}{:>14}{:>14}\n", "ns per step",
                                  "median", "least", "processor", "plain /this", "tables /this");
    for (const auto& [name, one] : cases_) {
      const double wall = median(one.wall);
      const std::string scene = name.substr(0, name.find('/'));
      const std::string size = name.ends_with("/small") ? "/small" : "";
      const auto ratio = [&](const std::string& baseline) {
        const auto found = cases_.find(scene + "/" + baseline + size);
        return found == cases_.end() ? std::string("-")
                                     : fmt::format("{:.2f}", median(found->second.wall) / wall);
      };
      out += fmt::format("{:<24}{:>14.2f}{:>14.2f}{:>14.2f}{:>14}{:>14}\n", name, wall,
                         *std::min_element(one.wall.begin(), one.wall.end()), median(one.processor),
                         ratio("plain"), ratio("tables"));
    }
    return out;
  }

 private:
  struct Case {
    std::vector<double> wall, processor;  // ns per step, one a repetition
  };
  static double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  }

  bool failed_ = false;
  std::map<std::string, Case> cases_;
};

}  // namespace ra2d::bench
