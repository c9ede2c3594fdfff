// SPDX-License-Identifier: BSD-3-Clause
#include "host/analysis/stretch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/errors.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

constexpr double time_slack = 1e-6;  // of a sample, for the roundings of its time

}  // namespace

std::optional<Scene> scene_of(const ResultContents& contents,
                              const std::filesystem::path& file) try {
  return parse_echo(contents.scene, file);
} catch (const RequestError&) {
  return {};
}

Stretch choose_stretch(const ResultContents& contents, const std::optional<Scene>& scene,
                       const std::filesystem::path& file, std::optional<double> from,
                       std::optional<double> to) {
  const bool has_window = scene && !scene->output.window.empty();
  const double counted_from = scene ? scene->output.from : 0.0;
  double end = contents.samples > 0 ? contents.end : 0.0;
  if (contents.summary.complete && scene)
    end = scene->output.window.empty() ? scene->duration : scene->output.window.back();
  Stretch s;
  s.from = from.value_or(has_window ? scene->output.window.front() : counted_from);
  s.to = to.value_or(end);
  // the summary counts from output.from on, which may be before the window
  s.whole = s.from == counted_from && s.to == end;
  if (s.to > end * (1 + 1e-12))
    throw RequestError(
        fmt::format("{}: --to {:g}: the run ends at {:g} s", file.string(), s.to, end));
  if (to && !(s.from < s.to))
    throw RequestError(
        fmt::format("{}: from {:g} s to {:g} s there is nothing: expected --from before --to",
                    file.string(), s.from, s.to));
  if (!s.whole && !(s.from < s.to))
    throw RequestError(fmt::format("{}: from {:g} s on there is nothing: the run ends at {:g} s",
                                   file.string(), s.from, end));
  if (std::isnan(contents.rate)) return s;
  const auto place = [&](double time) {
    return std::max(0.0, (time - contents.start) * contents.rate);
  };
  s.first = static_cast<std::size_t>(std::ceil(place(s.from) - time_slack));
  const auto beyond = static_cast<std::size_t>(std::floor(place(s.to) + time_slack)) + 1;
  s.first = std::min(s.first, contents.samples);
  s.count = std::max(s.first, std::min(beyond, contents.samples)) - s.first;
  if (!s.whole && s.count < 2)
    throw RequestError(fmt::format(
        "{}: from {:g} s to {:g} s there {}: expected a stretch of two samples or more, which are "
        "{:g} s apart",
        file.string(), s.from, s.to, s.count == 0 ? "is no sample" : "is one sample",
        1 / contents.rate));
  return s;
}

}  // namespace ra2d
