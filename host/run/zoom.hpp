// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/result/record.hpp"
#include "host/run/run.hpp"
#include "host/scene/scene.hpp"

/// Windows of a run that are sampled far more often (docs/results.md, "Zoom"). Each is a run of its
/// own, from the same start on the same clock, which keeps samples within the window alone and ends
/// with it.
namespace ra2d {

inline constexpr double usual_zoom_rate = 1e6, highest_zoom_rate = 1e7;  // Hz

struct ZoomWindow {
  double begin = 0, end = 0;   // s
  std::optional<Shock> shock;  // that it was chosen for
};

struct ZoomRequest {
  std::size_t strongest = 0;        // windows around the shocks of the highest peak force
  std::vector<long> shocks;         // around these, by their numbers
  std::vector<ZoomWindow> windows;  // these
  std::optional<double> rate;       // Hz

  bool is_empty() const { return strongest == 0 && shocks.empty() && windows.empty(); }
};

/// Reads "strongest=3", "shock=17" and "0.1032,0.1034". Throws RequestError for any other text.
ZoomRequest zoom_request(const std::vector<std::string>& texts, std::optional<double> rate);

/// Samples a second in the windows of a scene [Hz], by default 1e6. The adaptive scheme takes
/// output.rate times a power of two, no less than was requested: so its clock stays as it is. Fixed
/// steps take one sample a step at the most. Throws RequestError.
double zoom_rate(const Scene& scene, std::optional<double> requested);

/// Before the run: throws RequestError and FileError for what can be known to be wrong, such as a
/// window beyond the run, or one that the disk has no room for.
void require_zoom(const Scene& scene, const ZoomRequest& request,
                  const std::filesystem::path& output);

/// After it: the windows, those of the strongest shocks first. Of shocks that share a window only
/// the strongest has one. Throws RequestError where a shock is not there.
std::vector<ZoomWindow> zoom_windows(const Scene& scene, const ZoomRequest& request,
                                     const std::vector<Shock>& shocks);

/// The scene of a window. It keeps output.from, at which an adaptive step has to end: so its motion
/// is that of the whole run.
Scene zoomed(const Scene& scene, const ZoomWindow& window, std::optional<double> rate);

/// "OUT.zoom-1.h5" for "OUT.h5".
std::filesystem::path zoom_name(const std::filesystem::path& output, std::size_t number);

/// Results beside an output that have the name of a window of it and are of other runs than the
/// scene's. `own` are known not to be.
std::vector<std::filesystem::path> windows_of_other_runs(
    const Scene& scene, const std::filesystem::path& output,
    const std::vector<std::filesystem::path>& own);

}  // namespace ra2d
