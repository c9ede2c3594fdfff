// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace ra2d::bench {

/// Prints like the console reporter, and keeps the time per step of every case for a table of ratios.
class RatioReporter : public benchmark::ConsoleReporter {
 public:
  RatioReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      failed_ = failed_ || run.error_occurred;
      const auto counter = run.counters.find("ns_per_step");
      if (counter == run.counters.end() || run.error_occurred) continue;
      // when only aggregates are asked for, their median stands for the repetitions
      const std::string name = run.run_name.function_name + run.run_name.args;
      if (run.run_type == Run::RT_Iteration)
        samples_[name].push_back(counter->second);
      else if (run.aggregate_name == "median")
        medians_[name] = counter->second;
    }
    ConsoleReporter::ReportRuns(runs);
  }

  /// Whether any case gave up.
  bool failed() const { return failed_; }

  /// Medians over the repetitions, and each against the baselines on the same scene.
  std::string table() {
    for (auto& [name, values] : samples_) {
      std::sort(values.begin(), values.end());
      medians_[name] = 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
    }
    if (medians_.empty()) return {};
    std::string out = fmt::format("\n{:<28}{:>12}{:>14}{:>14}\n", "median over repetitions",
                                  "ns/step", "plain /this", "tables /this");
    for (const auto& [name, ns] : medians_) {
      const std::string scene = name.substr(0, name.find('/'));
      const std::string size = name.ends_with("/small") ? "/small" : "";
      const auto ratio = [&, ns = ns](const std::string& baseline) {
        const auto found = medians_.find(scene + "/" + baseline + size);
        return found == medians_.end() ? std::string("-")
                                       : fmt::format("{:.4g}", found->second / ns);
      };
      out += fmt::format("{:<28}{:>12.4g}{:>14}{:>14}\n", name, ns, ratio("plain"), ratio("tables"));
    }
    return out;
  }

 private:
  bool failed_ = false;
  std::map<std::string, std::vector<double>> samples_;
  std::map<std::string, double> medians_;
};

}  // namespace ra2d::bench
