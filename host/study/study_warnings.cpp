// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string_view>

#include "host/base/text.hpp"
#include "host/study/law.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_warnings = 5;  // that are shown

/// The part of a warning that stays the same where its numbers are others.
std::string kind_of_warning(std::string text) {
  std::erase_if(text, [](char c) {
    return std::string_view("0123456789.+-e").find(c) != std::string_view::npos;
  });
  return text;
}

/// "speed = 0.1, seed 3"
std::string run_name(const StudyAnswers& answers, std::size_t run) {
  const std::vector<std::size_t> place = place_of_run(answers.axes, run);
  std::string name;
  for (std::size_t a = 0; a + 1 < place.size(); ++a)
    name += fmt::format("{} = {}, ", answers.axes[a].name,
                        shortened(value_text(answers.axes[a], place[a])));
  return name + "seed " + value_text(answers.axes.back(), place.back());
}

}  // namespace

std::vector<SharedWarning> shared_warnings(const StudyAnswers& answers) {
  std::vector<SharedWarning> found;
  std::map<std::string, std::size_t> places;  // in `found`, by kind
  for (std::size_t run = 0; run < answers.messages.size(); ++run) {
    if (answers.status[run] != static_cast<double>(RunStatus::done)) continue;
    std::set<std::size_t> of_run;  // each once: those of two faces may be the same
    std::istringstream lines(answers.messages[run]);
    for (std::string line; std::getline(lines, line);) {
      const auto [at, is_new] = places.try_emplace(kind_of_warning(line), found.size());
      if (is_new) found.push_back({line, run_name(answers, run), 0});
      of_run.insert(at->second);
    }
    for (const std::size_t one : of_run) ++found[one].runs;
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const SharedWarning& a, const SharedWarning& b) { return a.runs > b.runs; });
  return found;
}

std::string warnings_text(const StudyAnswers& answers) {
  const std::vector<SharedWarning> warnings = shared_warnings(answers);
  const auto done = std::count(answers.status.begin(), answers.status.end(),
                               static_cast<double>(RunStatus::done));
  std::string text;
  for (std::size_t i = 0; i < std::min(most_warnings, warnings.size()); ++i)
    text += fmt::format("  {:<17}{} of {} runs (the first: {}): {}\n", "warning", warnings[i].runs,
                        done, printable(warnings[i].first), printable(warnings[i].text));
  if (warnings.size() > most_warnings)
    text += fmt::format("  {:<17}and {} more kinds: 'message' of the table has all\n", "",
                        warnings.size() - most_warnings);
  return text;
}

}  // namespace ra2d
