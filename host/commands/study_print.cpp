// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/study_print.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/text.hpp"
#include "host/commands/print.hpp"

namespace ra2d {

std::string runs_text(std::size_t count) {
  return fmt::format("{} run{}", count, count == 1 ? "" : "s");
}

std::string reason_of(const FinishedRun& run) {
  constexpr std::size_t longest = 300;  // bytes
  std::string reason = run.message;
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return shortened(reason, longest);
}

std::string names_of(const StudyPoints& points, const std::vector<std::size_t>& chosen) {
  std::string text;
  for (std::size_t i = 0; i < std::min(most_named, chosen.size()); ++i)
    text += (i > 0 ? "; " : "") + points.name(chosen[i]);
  if (chosen.size() > most_named) text += fmt::format("; and {} more", chosen.size() - most_named);
  return text;
}

void say_failed(const StudyRuns& runs, const std::vector<std::size_t>& failed) {
  if (failed.empty()) return;
  std::string text =
      fmt::format("{} failed (--retry-failed runs them again):", runs_text(failed.size()));
  for (std::size_t i = 0; i < std::min(most_named, failed.size()); ++i)
    text +=
        fmt::format("\n  {}: {}", runs.points.name(failed[i]), reason_of(*runs.find(failed[i])));
  if (failed.size() > most_named)
    text += fmt::format("\n  and {} more (--list names all)", failed.size() - most_named);
  say(text);
}

}  // namespace ra2d
