// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/zoom.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string_view>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/model/model.hpp"
#include "host/plan/plan.hpp"
#include "host/run/disk_room.hpp"
#include "host/run/run_key.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/result_reader.hpp"

namespace ra2d {
namespace {

constexpr double before_shock = 1e-4, after_shock = 2e-4, longest_shock = 2e-3;  // s
constexpr double rounding = 1e-9;
constexpr std::size_t most_zooms = 1000;

/// The whole text as a number; none where it is anything else.
template <class Number>
std::optional<Number> whole_number_of(std::string_view text) {
  Number number{};
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

void add_zoom(const std::string& text, ZoomRequest& request) {
  constexpr std::string_view strongest = "strongest=", shock = "shock=";
  if (text.starts_with(strongest)) {
    const auto count = whole_number_of<std::size_t>(text.substr(strongest.size()));
    if (count && *count > 0 && *count <= most_zooms) {
      request.strongest = std::max(request.strongest, *count);
      return;
    }
  } else if (text.starts_with(shock)) {
    const auto number = whole_number_of<long>(text.substr(shock.size()));
    if (number && *number >= 0) return request.shocks.push_back(*number);
  } else if (const std::size_t comma = text.find(','); comma != text.npos) {
    const auto begin = whole_number_of<double>(text.substr(0, comma)),
               end = whole_number_of<double>(text.substr(comma + 1));
    if (begin && end && *begin >= 0 && *begin < *end && std::isfinite(*end))
      return request.windows.push_back({*begin, *end, {}});
  }
  throw RequestError(
      fmt::format("--zoom {}: expected strongest=N (1 to {}), shock=NUMBER, or BEGIN,END in s",
                  printable(shortened(text)), most_zooms));
}

ZoomWindow around(const Shock& shock, const Scene& scene) {
  return {
      std::max(0.0, shock.start - before_shock),
      std::min(scene.duration, shock.start + std::min(shock.duration, longest_shock) + after_shock),
      shock};
}

}  // namespace

ZoomRequest zoom_request(const std::vector<std::string>& texts, std::optional<double> rate) {
  ZoomRequest request;
  request.rate = rate;
  for (const std::string& text : texts) add_zoom(text, request);
  if (rate && request.is_empty())
    throw RequestError("--zoom-rate says how often a window is sampled: expected --zoom, too");
  if (request.strongest + request.shocks.size() + request.windows.size() > most_zooms)
    throw RequestError(fmt::format("--zoom: more than {} windows", most_zooms));
  return request;
}

double zoom_rate(const Scene& scene, std::optional<double> requested) {
  const double base = scene.output.rate;
  if (requested && !(*requested > base && *requested <= highest_zoom_rate))
    throw RequestError(
        fmt::format("--zoom-rate {:g}: expected more than output.rate, {:g} Hz, and "
                    "at most {:g} Hz",
                    *requested, base, highest_zoom_rate));
  double rate = requested.value_or(usual_zoom_rate);
  if (is_adaptive(scene)) {
    double multiple = std::max(base, 0.5 / scene.duration);  // as the clock has it (make_model)
    while (multiple < rate * (1 - rounding)) multiple *= 2;
    if (!(multiple > base))
      throw RequestError(fmt::format(
          "--zoom: output.rate is {:g} Hz already: expected --zoom-rate with more", base));
    return multiple;
  }
  const double most = 1 / scene.time.step;
  if (requested && rate > most * (1 + rounding))
    throw RequestError(
        fmt::format("--zoom-rate {:g}: the steps are {:g} s long, expected at most "
                    "{:g} Hz, 1/time.step",
                    rate, scene.time.step, most));
  rate = std::min(rate, most);
  if (!(rate > base * (1 + rounding)))
    throw RequestError(
        fmt::format("--zoom: output.rate is {:g} Hz already, and time.step allows "
                    "{:g} Hz: there is nothing between two samples",
                    base, most));
  return rate;
}

void require_zoom(const Scene& scene, const ZoomRequest& request,
                  const std::filesystem::path& output) {
  const double rate = zoom_rate(scene, request.rate);
  for (std::size_t i = 0; i < request.windows.size(); ++i) {
    const ZoomWindow& window = request.windows[i];
    if (window.end > scene.duration)
      throw RequestError(fmt::format("--zoom {},{}: the run ends at {:g} s", window.begin,
                                     window.end, scene.duration));
    if ((window.end - window.begin) * rate < 1)
      throw RequestError(fmt::format("--zoom {},{}: no two samples fit into it at {:g} Hz",
                                     window.begin, window.end, rate));
    require_disk_room(make_model(zoomed(scene, window, request.rate)), zoom_name(output, i + 1));
  }
}

std::vector<ZoomWindow> zoom_windows(const Scene& scene, const ZoomRequest& request,
                                     const std::vector<Shock>& shocks) {
  std::vector<ZoomWindow> windows;
  std::vector<Shock> strongest;
  std::copy_if(shocks.begin(), shocks.end(), std::back_inserter(strongest),
               [&](const Shock& shock) { return shock.start >= scene.output.from; });
  std::stable_sort(strongest.begin(), strongest.end(),
                   [](const Shock& a, const Shock& b) { return a.peak_force > b.peak_force; });
  for (const Shock& shock : strongest) {
    if (windows.size() == request.strongest) break;
    if (std::none_of(windows.begin(), windows.end(), [&](const ZoomWindow& window) {
          return window.begin <= shock.start && shock.start <= window.end;
        }))
      windows.push_back(around(shock, scene));
  }
  if (request.strongest > 0 && windows.empty())
    throw RequestError(fmt::format("--zoom strongest={}: the run has no shock from output.from on",
                                   request.strongest));
  for (const long number : request.shocks) {
    const auto found = std::find_if(shocks.begin(), shocks.end(),
                                    [&](const Shock& shock) { return shock.serial == number; });
    if (found == shocks.end())
      throw RequestError(
          fmt::format("--zoom shock={}: the run has no shock of that number "
                      "(shocks/shock in its file lists them)",
                      number));
    windows.push_back(around(*found, scene));
  }
  windows.insert(windows.end(), request.windows.begin(), request.windows.end());
  return windows;
}

Scene zoomed(const Scene& scene, const ZoomWindow& window, std::optional<double> rate) {
  Scene zoom = scene;
  zoom.output.rate = zoom_rate(scene, rate);
  zoom.output.window = {window.begin, window.end};
  return zoom;
}

std::filesystem::path zoom_name(const std::filesystem::path& output, std::size_t number) {
  std::filesystem::path name = output;
  name.replace_extension(fmt::format(".zoom-{}{}", number, output.extension().string()));
  return name;
}

std::vector<std::filesystem::path> windows_of_other_runs(
    const Scene& scene, const std::filesystem::path& output,
    const std::vector<std::filesystem::path>& own) {
  std::vector<std::filesystem::path> others;
  std::optional<Model> model;  // of the run: its windows have its faces
  for (std::size_t number = 1; number <= most_zooms; ++number) {
    const std::filesystem::path file = zoom_name(output, number);
    if (std::find(own.begin(), own.end(), file) != own.end()) continue;
    try {
      const auto stamp = stamp_of(file);
      if (!stamp) continue;
      Scene window = scene;
      const Scene there = parse_echo(stamp->scene, file);
      window.output.rate = there.output.rate;
      window.output.window = there.output.window;
      if (!model) model = make_model(scene);
      if (run_key(with_settings(*model, window)) != stamp->key) others.push_back(file);
    } catch (const RequestError&) {  // no window that this program could have made of the scene
      others.push_back(file);
    } catch (const FileError&) {  // no result
      continue;
    }
  }
  return others;
}

}  // namespace ra2d
