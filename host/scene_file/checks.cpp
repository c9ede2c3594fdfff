// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/text.hpp"
#include "host/body/body.hpp"
#include "host/body/plate.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/surface/form.hpp"
#include "host/surface/height_map.hpp"
#include "host/surface/measure.hpp"
#include "host/surface/random_map.hpp"
#include "kernels/limits.hpp"

namespace ra2d {
namespace {

constexpr double most_steps = 9e15;  // the number of a step or a sample stays exact in a double
constexpr double most_nodes = 5e7;
constexpr double least_mass = 1e-20, most_mass = 1e15;           // kg/m
constexpr double least_frequency = 1e-9, most_frequency = 1e15;  // Hz, the first
constexpr double most_apart = 1e6;                               // runs between two samples
constexpr double least_tolerance = 1e-13, most_tolerance = 1e-2;
constexpr double least_per_wave = 4;  // spacings in rsm or a correlation length
constexpr double most_wide = 1e9;     // peaks, of the body's length: a face of one is flat
constexpr double most_raised = 1e9;   // nodes under peaks: some 10 s
constexpr double rounding = 1e-9;     // of a spacing, as for the number of nodes

/// A positive bound, rounded down to six digits so that it can be copied into the scene.
std::string at_most(double bound) {
  const double unit = std::pow(10.0, std::floor(std::log10(bound)) - 5);
  // 1.7999999999999998 is 1.8: less is added than `rounding` forgives
  return fmt::format("{:.6g}", std::floor(bound / unit + 1e-5) * unit);
}

/// A number that has a part in a fault, and the usual size of such numbers.
struct Quantity {
  std::string key;
  double value, usual;
};

/// The number that is to blame for a fault: the first one, unless another is more than a thousand
/// times further from its usual size.
std::string to_blame(const std::vector<Quantity>& parts) {
  const auto away = [](const Quantity& part) {
    return part.value != 0 ? std::abs(std::log10(std::abs(part.value) / part.usual)) : 0.0;
  };
  const Quantity* blamed = &parts.front();
  double most = away(parts.front()) + 3;
  for (const Quantity& part : parts) {
    if (!(away(part) > most)) continue;
    most = away(part);
    blamed = &part;
  }
  return blamed->key;
}

Quantity duration_of(const Scene& s) { return {"scene.duration", s.duration, 1}; }
Quantity speed_of(const Scene& s) { return {"scene.speed", s.speed, 0.1}; }
Quantity spacing_of(const Scene& s) { return {"scene.spacing", s.spacing, 1e-5}; }
Quantity length_of(const std::string& name, const BodySpec& body) {
  return {name + ".length", body.length, 0.1};
}
Quantity thickness_of(const std::string& name, const BodySpec& body) {
  return {name + ".thickness", body.thickness, 5e-3};
}
Quantity width_of(const std::string& name, const BodySpec& body) {
  return {name + ".width", body.width, 5e-2};
}
Quantity density_of(const std::string& name, const BodySpec& body) {
  return {name + ".density", body.density, 5e3};
}
Quantity young_of(const std::string& name, const BodySpec& body) {
  return {name + ".young", body.young, 1e11};
}

/// Whether there is a window, and one that can be.
bool is_window_of(const Scene& s) {
  const std::vector<double>& window = s.output.window;
  return window.size() == 2 && window[0] >= 0 && window[0] < window[1] && window[1] <= s.duration;
}

/// More than a file could hold: a hundred terabytes of the fewest columns.
void check_samples(const Scene& s, Document& document) {
  constexpr double most_samples = 1e11;
  const bool is_window = is_window_of(s);
  const double sampled = is_window ? s.output.window[1] - s.output.window[0] : s.duration;
  const double samples = sampled * s.output.rate;
  if (samples > most_samples)
    document.fault(to_blame({{"output.rate", s.output.rate, 1e5}, duration_of(s)}),
                   fmt::format("{} Hz takes {:.3g} samples in {} s: expected at most {:g} samples "
                               "(a lower rate or a shorter duration)",
                               s.output.rate, samples, sampled, most_samples));
}

/// With less than one sample a run, only that at t = 0 is taken. Far less is a slip.
void check_rate(const Scene& s, Document& document) {
  if (s.output.rate * s.duration < 1 / most_apart)
    document.fault(to_blame({{"output.rate", s.output.rate, 1e5}, duration_of(s)}),
                   fmt::format("{} Hz takes no sample in {} s but that at t = 0: expected at least "
                               "{:.6g} Hz, for one at the end (or a longer duration)",
                               s.output.rate, s.duration, 1 / s.duration));
}

/// The adaptive scheme has no step to fit, neither to the run nor to the rate.
void check_adaptive(const Scene& s, Document& document) {
  const double tolerance = s.time.tolerance.value_or(usual_tolerance);
  const bool small = tolerance < least_tolerance;
  if (small || tolerance > most_tolerance)
    document.fault(
        "time.tolerance",
        fmt::format("{} {}: expected a relative error per step from {:g} to {:g}", tolerance,
                    small ? "asks for less than what roundings do in a step"
                          : "lets the errors of a few steps grow as large as the motion",
                    least_tolerance, most_tolerance));
}

void check_times(const Scene& s, Document& document) {
  check_rate(s, document);
  check_samples(s, document);
  if (is_adaptive(s)) return check_adaptive(s, document);
  const double steps = s.duration / s.time.step;
  if (steps > most_steps)
    document.fault(to_blame({{"time.step", s.time.step, 1e-8}, duration_of(s)}),
                   fmt::format("a step of {} s makes {:.3g} steps of {} s: expected at most {:g} "
                               "steps (a longer step or a shorter duration)",
                               s.time.step, steps, s.duration, most_steps));
  if (s.time.step > s.duration)
    document.fault("time.step", fmt::format("{} s is longer than the run: expected at most "
                                            "scene.duration, {} s",
                                            s.time.step, s.duration));
  if (s.output.rate * s.time.step > 1 + rounding)
    document.fault(
        "output.rate",
        fmt::format("{} Hz asks for more than one sample a step: expected at most {} Hz, "
                    "1/time.step (lower the rate or the step)",
                    s.output.rate, at_most(1 / s.time.step)));
}

void check_nodes(const Scene& s, const std::string& name, const BodySpec& body,
                 Document& document) {
  const double nodes = body.length / s.spacing;
  const std::string blamed = to_blame({spacing_of(s), length_of(name, body)});
  const bool is_spacing = blamed == "scene.spacing";
  if (nodes < 1 - rounding)
    document.fault(blamed,
                   is_spacing
                       ? fmt::format("{} m is larger than the {}, {} m: expected at least "
                                     "2 nodes on each body (refine the spacing)",
                                     s.spacing, name, body.length)
                       : fmt::format("{} m is shorter than scene.spacing, {} m: expected at least "
                                     "2 nodes on each body (is it in metres?)",
                                     body.length, s.spacing));
  if (nodes > most_nodes)
    document.fault(blamed, fmt::format("{}{} m puts {:.3g} nodes on the {}: expected at most "
                                       "{:g} (a wider spacing)",
                                       is_spacing ? "" : "scene.spacing = ", s.spacing, nodes, name,
                                       most_nodes));
}

/// Nodes in rows, and where the slider stands across the resonator.
void check_rows(const Scene& s, Document& document) {
  const double width = s.slider.width, spacing_y = s.spacing_y.value_or(s.spacing);
  if (width > s.resonator.width)
    return document.fault("slider.width", fmt::format("{} m is wider than the resonator: expected "
                                                      "at most resonator.width, {} m",
                                                      width, s.resonator.width));
  const double side = s.side.value_or(0), farthest = s.resonator.width - width;
  if (side < 0 || side > farthest + rounding * s.resonator.width)
    document.fault("scene.side",
                   fmt::format("{} m: the slider leaves the resonator's edge by {:.6g} m: expected "
                               "a place from 0 to {} m, or no key: it stands in the middle then",
                               side, side < 0 ? -side : side - farthest,
                               farthest > 0 ? at_most(farthest) : "0"));
  const double rows = map_rows(width, spacing_y);
  const std::string key = spacing_y != s.spacing ? "scene.spacing_y" : "scene.spacing";
  if (rows < 2)
    return document.fault(key, fmt::format("{} m puts {:.0f} rows of nodes on a slider {} m wide: "
                                           "expected at least 2 (one row: scene.kind = \"plane\")",
                                           spacing_y, rows, width));
  const double travelled = s.start + s.speed * s.duration;
  for (const auto& [name, along] :
       {std::pair{"slider", s.slider.length},
        std::pair{"resonator", std::min(travelled + s.slider.length, s.resonator.length)}}) {
    const double nodes = rows * (along / s.spacing + 1);
    if (nodes > most_map_points)
      return document.fault(
          key, fmt::format("{:.0f} rows {} m apart, of nodes {} m apart, put {:.3g} nodes on the "
                           "{}{}: expected at most {:g} (a larger spacing or spacing_y)",
                           rows, spacing_y, s.spacing, nodes, name,
                           name == std::string("slider") ? "" : ", as far as the slider comes",
                           most_map_points));
  }
}

/// Keys that a plane scene has no use for.
void check_plane(const Scene& s, Document& document) {
  const char* const cure = "is of areal scenes: expected scene.kind = \"areal\", or drop the key";
  if (s.spacing_y) document.fault("scene.spacing_y", cure);
  if (s.side) document.fault("scene.side", cure);
  for (const auto& [name, body] :
       {std::pair{"resonator", &s.resonator}, std::pair{"slider", &s.slider}}) {
    const FilePreparation& how = body->surface.prepared;
    const auto refuse = [&](bool is_given, const char* key, const std::string& what) {
      if (is_given) document.fault(fmt::format("{}.surface.{}", name, key), what);
    };
    refuse(body->surface.rsm_y.has_value(), "rsm_y", cure);
    refuse(how.spacing_y.has_value(), "spacing_y", cure);
    refuse(how.offset_x.has_value(), "offset_x", cure);
    refuse(how.offset_y.has_value(), "offset_y", cure);
    refuse(how.when_short == ShortProfile::mirror, "short",
           "only maps are mirrored: expected \"refuse\" or \"repeat\" (or scene.kind = \"areal\")");
    refuse(understand_map_form(how.form) && !understand_form(how.form), "form",
           toml_string(how.form) + " is of maps: expected none, mean, line or poly:N");
  }
}

/// Faces of an areal scene are maps.
void check_map(const std::string& name, const SurfaceSpec& surface, Document& document) {
  const auto refuse = [&](bool is_wrong, const char* key, const std::string& what) {
    if (is_wrong) document.fault(fmt::format("{}.surface.{}", name, key), what);
  };
  refuse(
      surface.kind == SurfaceKind::peaks, "kind",
      "\"peaks\" are ridges, which areal scenes do not have: expected \"gaussian\", \"flat\", or "
      "the heights as a map (\"file\")");
  const std::string of_profiles = "is of profiles, a map has none: drop the key";
  if (surface.kind == SurfaceKind::gaussian) {
    refuse(surface.correlation != Correlation::gaussian, "correlation",
           fmt::format("\"{}\" is of profiles: a map has the \"gaussian\" one: drop the key",
                       correlations.name(surface.correlation)));
    refuse(surface.hurst.has_value(), "hurst", of_profiles);
    refuse(surface.longest.has_value(), "longest", of_profiles);
    refuse(surface.shortest.has_value(), "shortest", of_profiles);
    refuse(surface.skewness.has_value(), "skewness", of_profiles);
    refuse(surface.kurtosis.has_value(), "kurtosis", of_profiles);
    refuse(surface.exact == Exactly::rq_and_rsm, "exact",
           "\"rq+rsm\" is of profiles: expected \"rq\" or \"none\"");
  }
  if (surface.kind != SurfaceKind::file) return;
  const FilePreparation& how = surface.prepared;
  refuse(how.x_unit.has_value(), "x_unit", of_profiles + " (spacings are in metres)");
  refuse(how.row.has_value(), "row", of_profiles + " (all rows are taken)");
  refuse(how.column.has_value(), "column", of_profiles + " (all columns are taken)");
  refuse(how.cutoff_s.has_value(), "cutoff_s", of_profiles);
  refuse(how.cutoff.has_value(), "cutoff", of_profiles);
  refuse(how.filter != FaceFilter::none, "filter", of_profiles);
  refuse(understand_form(how.form) && !understand_map_form(how.form), "form",
         toml_string(how.form) + " is of profiles: expected none, mean, plane or poly:N");
}

/// Finds what an areal scene cannot have. False where its resonator has no frequencies.
bool check_areal(const Scene& s, Document& document) {
  check_rows(s, document);
  check_map("resonator", s.resonator.surface, document);
  check_map("slider", s.slider.surface, document);
  if (s.slider.support == Support::pinned)
    document.fault("slider.support", "a block cannot be pinned: expected \"free\" or \"rigid\"");
  if (s.slider.modes.value_or(0) > 0)
    document.fault("slider.modes", "a block has no elastic modes: drop the key, or expected 0");
  if (s.resonator.support == Support::free) {
    document.fault("resonator.support",
                   "a plate with free edges has no modes in closed form: expected \"pinned\"");
    return false;
  }
  if (s.resonator.support == Support::rigid || has_plate_modes(s.resonator)) return true;
  const double nu = s.resonator.poisson.value_or(0);
  if (nu >= 0.5)
    document.fault("resonator.poisson",
                   fmt::format("{} makes a plate infinitely stiff: expected a number over -1 and "
                               "below 0.5 (steel: 0.3)",
                               nu));
  else if (s.resonator.length > 0 && s.resonator.width > 0 && nu > -1)
    document.fault(
        to_blame({length_of("resonator", s.resonator), width_of("resonator", s.resonator)}),
        fmt::format("{} m of length and {} m of width make no plate: expected sides of which none "
                    "is more than {:g} times the other",
                    s.resonator.length, s.resonator.width, most_slender_plate));
  return false;
}

/// Where the slider stands, from the first moment to the last.
void check_path(const Scene& s, Document& document) {
  constexpr double most_lengths = 100;
  if (s.gap && std::abs(*s.gap) > most_lengths * s.resonator.length)
    document.fault("scene.gap", fmt::format("{} m is out of all proportion to a resonator of {} m: "
                                            "expected at most {:g} times its length",
                                            *s.gap, s.resonator.length, most_lengths));
  if (s.slider.length > s.resonator.length) {
    document.fault("slider.length",
                   fmt::format("{} m is longer than the resonator: expected at most "
                               "resonator.length, {} m",
                               s.slider.length, s.resonator.length));
    return;
  }
  if (s.start < 0)
    document.fault("scene.start", fmt::format("the slider overhangs the resonator's left end by "
                                              "{:.6g} m: expected start >= 0",
                                              -s.start));
  const double farthest = s.resonator.length - s.slider.length;
  const double travel = s.speed * s.duration;
  const double excess = s.start + travel - farthest;
  if (!(excess > rounding * s.resonator.length)) return;
  std::vector<std::string> cures;
  const auto cure = [&](const char* key, double bound, const char* unit) {
    if (bound > 0) cures.push_back(fmt::format("{} <= {} {}", key, at_most(bound), unit));
  };
  if (travel > 0) {
    cure("duration", (farthest - s.start) / s.speed, "s");
    cure("speed", (farthest - s.start) / s.duration, "m/s");
  }
  cure("start", farthest - travel, "m");
  if (cures.empty()) cures.emplace_back("start = 0 with speed = 0");  // no room to spare
  document.fault(
      to_blame({{"scene.start", s.start, 0.1}, speed_of(s), duration_of(s)}),
      fmt::format("the slider leaves the resonator's right end by {:.6g} m during the run: "
                  "expected start + slider.length + speed * duration <= "
                  "resonator.length, {} m ({} would fit)",
                  excess, s.resonator.length, any_of(cures, "")));
}

/// Mass and first frequency of a body. Far from those of any body, roundings and the range of
/// doubles would decide. False where something is wrong.
bool check_body(const std::string& name, const BodySpec& body, Document& document) {
  if (body.support == Support::rigid) return true;
  const double mass = body.density * body.thickness * body.width;
  const bool heavy = mass < least_mass || mass > most_mass;
  if (heavy)
    document.fault(
        to_blame({density_of(name, body), thickness_of(name, body), width_of(name, body)}),
        fmt::format("{} kg/m^3, {} m thick and {} m wide, makes {:.3g} kg of each metre: expected "
                    "{:g} to {:g} kg/m (check all three)",
                    body.density, body.thickness, body.width, mass, least_mass, most_mass));
  if (body.kind == BodyKind::block) return !heavy;
  const double frequency = elastic_frequency(body, 0);
  const bool odd = frequency < least_frequency || frequency > most_frequency;
  if (odd)
    document.fault(
        to_blame({young_of(name, body), length_of(name, body), thickness_of(name, body),
                  density_of(name, body)}),
        fmt::format("{} Pa makes {:.3g} Hz the first frequency, with {} m of length, {} m "
                    "of thickness and {} kg/m^3: expected {:g} to {:g} Hz (check all four)",
                    body.young, frequency, body.length, body.thickness, body.density,
                    least_frequency, most_frequency));
  return !heavy && !odd;
}

/// The modes of both bodies have to fit into one march.
void check_modes(const Scene& s, Document& document) {
  constexpr int counted = 1000;
  constexpr int most = most_modes;
  const int resonator = mode_count(s.resonator, counted), slider = mode_count(s.slider, counted);
  const int total = resonator + slider;
  if (total <= most) return;
  const bool first = resonator >= slider;
  const BodySpec& body = first ? s.resonator : s.slider;
  const std::string name = first ? "resonator" : "slider";
  const int rigid = rigid_mode_count(body);
  const int most_elastic = most - std::min(resonator, slider) - rigid;
  std::string cure = fmt::format("at most {} here", most_elastic);
  if (most_elastic < 1)
    cure = "fewer on each body";
  else if (!body.modes)
    cure = fmt::format("less than {} Hz", at_most(elastic_frequency(body, most_elastic)));
  const std::string count =
      total >= counted ? fmt::format("{} or more", counted) : fmt::format("{}", total);
  const std::string key = name + (body.modes ? ".modes" : ".max_frequency");
  // so many modes below a usual frequency are of a body that is none
  const std::string blamed = body.modes ? key
                                        : to_blame({{key, body.max_frequency.value_or(0), 2e4},
                                                    thickness_of(name, body),
                                                    length_of(name, body),
                                                    young_of(name, body),
                                                    density_of(name, body)});
  document.fault(
      blamed,
      blamed == key
          ? fmt::format("{} modes in both bodies together, at most {} can be marched: expected {}",
                        count, most, cure)
          : fmt::format("with {} m of length, {} m of thickness, {} Pa and {} kg/m^3 the {} has {} "
                        "modes up to {} = {} Hz, at most {} can be marched: is it in another unit?",
                        body.length, body.thickness, body.young, body.density, name, count, key,
                        *body.max_frequency, most));
}

void check_preparation(const std::string& name, const FilePreparation& how, Document& document) {
  const auto fault = [&](const char* key, const std::string& what) {
    document.fault(fmt::format("{}.surface.{}", name, key), what);
  };
  const bool filtered = how.filter == FaceFilter::gaussian;
  if (how.row && how.column) fault("column", "stands beside `row`: expected one of them");
  if (how.cutoff && !filtered)
    fault("cutoff", "there is no filter that it would be of: expected filter = \"gaussian\" too");
  const double cutoff = how.cutoff.value_or(usual_cutoff);
  if (how.cutoff_s && filtered && *how.cutoff_s >= cutoff)
    fault("cutoff_s",
          fmt::format("{} m: expected less than the cutoff, {} m", *how.cutoff_s, cutoff));
}

void check_surface(const Scene& s, const std::string& name, const BodySpec& body,
                   Document& document) {
  const SurfaceSpec& surface = body.surface;
  const auto resolved = [&](const char* key, const std::optional<double>& wave) {
    if (!wave || !(*wave < least_per_wave * s.spacing * (1 - rounding))) return;
    document.fault(
        fmt::format("{}.surface.{}", name, key),
        fmt::format("{} m is not resolved by the spacing, {} m: expected at least {} "
                    "spacings (scene.spacing <= {} m, or a longer {})",
                    *wave, s.spacing, least_per_wave, at_most(*wave / least_per_wave), key));
  };
  if (surface.kind == SurfaceKind::gaussian) {
    resolved("rsm", surface.rsm);
    resolved("correlation_length", surface.correlation_length);
    const double spacing_y = s.spacing_y.value_or(s.spacing);
    if (s.kind == SceneKind::areal)
      if (const double wave = surface.rsm_y.value_or(surface.rsm.value_or(infinite));
          wave < least_per_wave * spacing_y * (1 - rounding))
        document.fault(
            fmt::format("{}.surface.{}", name, surface.rsm_y ? "rsm_y" : "rsm"),
            fmt::format("{} m is not resolved by the spacing of rows, {} m: expected at least {} "
                        "of them (scene.spacing_y <= {} m)",
                        wave, spacing_y, least_per_wave, at_most(wave / least_per_wave)));
    if (surface.rq > body.length)
      document.fault(fmt::format("{}.surface.rq", name),
                     fmt::format("{} m is higher than the body is long, {} m: expected a roughness "
                                 "(is it in another unit?)",
                                 surface.rq, body.length));
  }
  if (surface.kind == SurfaceKind::file) check_preparation(name, surface.prepared, document);
  if (surface.kind != SurfaceKind::peaks) return;
  double raised = 0;  // nodes, each as often as a peak lies over it
  for (const Peak& peak : surface.peaks)
    raised += std::min(2 * peak.half_width, body.length) / s.spacing;
  if (raised > most_raised)
    document.fault(
        fmt::format("{}.surface.peaks", name),
        fmt::format("{} peaks raise {:.3g} nodes, each as often as a peak lies over it: "
                    "expected at most {:g} (fewer or narrower peaks, or their sum as a profile: "
                    "kind = \"file\")",
                    surface.peaks.size(), raised, most_raised));
  for (std::size_t i = 0; i < surface.peaks.size(); ++i) {
    const Peak& peak = surface.peaks[i];
    if (peak.at + peak.half_width < 0 || peak.at - peak.half_width > body.length)
      document.fault(
          fmt::format("{}.surface.peaks[{}].at", name, i),
          fmt::format("the peak at {} m lies off the body: expected a place from 0 to {} m",
                      peak.at, body.length));
    if (peak.half_width > most_wide * body.length)
      document.fault(
          fmt::format("{}.surface.peaks[{}].half_width", name, i),
          fmt::format("{} m is out of all proportion to the body: expected at most {:g} m",
                      peak.half_width, most_wide * body.length));
  }
}

void check_microphones(const Scene& s, Document& document) {
  const std::vector<MicrophonePlace>& places = s.output.microphones;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [x, y, z] = places[i];
    if (std::abs(z) < nearest_microphone)
      document.fault(
          fmt::format("output.microphones[{}].z", i),
          fmt::format("{} m is in the plane of the resonator and its baffle: expected {} m or more "
                      "above it (or below it, z < 0)",
                      z, nearest_microphone));
    const double away = std::hypot(std::max({-x, x - s.resonator.length, 0.0}),
                                   std::max({-y, y - s.resonator.width, 0.0}), z);
    if (away > farthest_microphone)
      document.fault(fmt::format("output.microphones[{}]", i),
                     fmt::format("is {:.4g} m away: expected {} m at the most, farther off the air "
                                 "absorbs sound, which is left out",
                                 away, farthest_microphone));
  }
  if (places.empty()) return;
  if (s.output.modes == KeptModes::none)
    document.fault("output.microphones",
                   "need the motion of the modes, and output.modes is \"none\": expected \"all\"");
  if (s.resonator.support == Support::rigid)
    document.fault("output.microphones",
                   "hear nothing of a rigid resonator: expected another resonator.support, or none "
                   "of them");
}

void check_probes(const Scene& s, const char* key, const std::vector<ProbePlace>& places,
                  const char* name, const BodySpec& body, Document& document) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto fault = [&](const std::string& what) {
      document.fault(fmt::format("output.{}[{}]", key, i), what);
    };
    const auto& [x, y] = places[i];
    const bool is_areal = s.kind == SceneKind::areal;
    if (is_areal && !y)
      fault(fmt::format("{} m is not enough in an areal scene: expected a pair, [x, y]", x));
    else if (!is_areal && y)
      fault(fmt::format("[{}, {}] m is of areal scenes: expected x alone, {}", x, *y, x));
    else if (x < 0 || x > body.length)
      fault(
          fmt::format("{} m is off the {}: expected a place from 0 to {} m", x, name, body.length));
    else if (y && (*y < 0 || *y > body.width))
      fault(fmt::format("y = {} m is off the {}: expected a place from 0 to {} m", *y, name,
                        body.width));
  }
}

void check_output(const Scene& s, Document& document) {
  if (s.output.from > 0 &&
      s.output.from > s.duration * (1 - rounding) - (is_adaptive(s) ? 0.0 : s.time.step))
    document.fault("output.from",
                   fmt::format("{} s is not before the end of the run, {} s: expected "
                               "a time from 0 to scene.duration",
                               s.output.from, s.duration));
  if (!s.output.window.empty() && !is_window_of(s))
    document.fault("output.window",
                   fmt::format("[{}] s is no stretch of the run: expected two times in "
                               "ascending order, from 0 to scene.duration, {} s",
                               fmt::join(s.output.window, ", "), s.duration));
  else if (!s.output.window.empty() &&
           (s.output.window[1] - s.output.window[0]) * s.output.rate < 1)
    document.fault("output.window",
                   fmt::format("[{}] s has no room for two samples at output.rate, {} Hz: expected "
                               "{:g} s or more",
                               fmt::join(s.output.window, ", "), s.output.rate, 1 / s.output.rate));
  check_probes(s, "probes", s.output.probes, "resonator", s.resonator, document);
  check_probes(s, "slider_probes", s.output.slider_probes, "slider", s.slider, document);
  check_microphones(s, document);
}

/// The contact spring of a node: a number that can be worked with.
void check_stiffness(const Scene& s, Document& document) {
  if (s.contact.law != ContactLaw::penalty) return;
  if (s.contact.is_hertz && s.kind == SceneKind::areal)
    return document.fault(
        "contact.stiffness",
        "\"hertz\" is that of ridges as wide as the slider: expected a number in Pa/m (steel, on a "
        "spacing that resolves its contacts: about 1e16)");
  if (s.contact.is_hertz && std::isinf(s.contact.stiffness))
    return document.fault("contact.stiffness",
                          "\"hertz\", and neither body has a Young's modulus: expected a number in "
                          "Pa/m (or `young` of a body; one without does not yield)");
  const auto flat = [](const BodySpec& body) { return body.surface.kind == SurfaceKind::flat; };
  if (s.contact.is_hertz && flat(s.resonator) && flat(s.slider))
    return document.fault("contact.stiffness",
                          "\"hertz\" between two flat faces: there is no asperity that it would be "
                          "of: expected a number in Pa/m (or a face that is not flat)");
  const double strip = s.kind == SceneKind::areal ? s.spacing_y.value_or(s.spacing)
                                                  : std::min(s.resonator.width, s.slider.width);
  const double node = s.contact.stiffness * s.spacing * strip;
  constexpr double stiffest = 1e20;
  if (node > stiffest)
    document.fault(
        to_blame({{"contact.stiffness", s.contact.stiffness, 1e15},
                  spacing_of(s),
                  width_of("resonator", s.resonator),
                  width_of("slider", s.slider)}),
        fmt::format("{} Pa/m makes the spring of a node {:.3g} N/m, {} m apart and {} m wide: "
                    "expected at most {:g} N/m (steel: about 1e15 Pa/m)",
                    s.contact.stiffness, node, s.spacing, strip, stiffest));
}

void check_loads(const Scene& s, Document& document) {
  constexpr double most_load = 1e12;  // N
  const auto check_force = [&](const std::string& key, double force) {
    if (std::abs(force) > most_load)
      document.fault(key, fmt::format("{} N is out of all proportion: expected at most {:g} N",
                                      force, most_load));
  };
  check_force("slider.load", s.slider.load);
  for (std::size_t i = 0; i < s.resonator.moving_forces.size(); ++i) {
    const MovingForce& moving = s.resonator.moving_forces[i];
    const std::string name = fmt::format("resonator.moving_force[{}].", i);
    check_force(name + "force", moving.force);
    const double width = s.resonator.width;
    if (s.kind != SceneKind::areal && moving.y)
      document.fault(name + "y",
                     "is of areal scenes: expected scene.kind = \"areal\", or drop the key");
    else if (s.kind == SceneKind::areal && !moving.y)
      document.fault(name + "y", fmt::format("missing: expected a place from 0 to {} m", width));
    else if (moving.y && (*moving.y < 0 || *moving.y > width))
      document.fault(name + "y",
                     fmt::format("{} m is off the resonator: expected a place from 0 to {} m",
                                 *moving.y, width));
  }
  const bool loaded = s.slider.load_is_weight || s.slider.load != 0;
  if (s.slider.support == Support::rigid && loaded && !std::isnan(s.slider.load))
    document.fault("slider.load",
                   "a rigid slider has no mode to take a load: expected 0 (drop the key, or take "
                   "support = \"free\")");
  if (s.initial != Initial::statics) return;
  if (s.resonator.support == Support::free)
    document.fault("scene.initial",
                   "\"static\" with a free resonator: nothing holds it, there is no equilibrium: "
                   "expected \"rest\" (or resonator.support = \"pinned\")");
  if (s.slider.support == Support::free && !s.slider.load_is_weight && s.slider.load <= 0)
    document.fault(
        "scene.initial",
        "\"static\" with a free slider that no load holds down, there is no equilibrium: "
        "expected \"rest\" (or slider.load = \"weight\")");
}

/// The scheme and the bodies under multipliers.
void check_law(const Scene& s, Document& document) {
  if (s.contact.law != ContactLaw::multiplier) return;
  if (is_adaptive(s))
    document.fault(
        "contact.law",
        "\"multiplier\" with time.scheme = \"adaptive\": between bodies of finitely many "
        "modes this law leaves open what an impact gives back. With fixed steps the "
        "scheme decides it, each in its own way however small the step, so there is no "
        "motion for an error control to converge to: expected \"penalty\", stiff (or a "
        "fixed step, time.scheme = \"backward-euler\")");
  else if (!takes_multipliers(s.time.scheme))
    document.fault("contact.law",
                   fmt::format("\"multiplier\" with time.scheme = \"{}\": the force of a step does "
                               "not move its end, so none keeps the faces apart: expected "
                               "\"penalty\" (or time.scheme = \"backward-euler\")",
                               schemes.name(s.time.scheme)));
  if (mode_count(s.resonator, 1) == 0 && mode_count(s.slider, 1) == 0)
    document.fault("contact.law",
                   "\"multiplier\" between bodies that keep no mode: nothing can move out of the "
                   "way: expected \"penalty\" (or modes on a body that is not rigid, "
                   "by `modes` or a higher `max_frequency`)");
}

}  // namespace

void check(const Scene& scene, Document& document) {
  check_times(scene, document);
  check_path(scene, document);
  bool bodies = true;
  if (scene.kind == SceneKind::areal)
    bodies = check_areal(scene, document);
  else
    check_plane(scene, document);
  for (const auto& [name, body] :
       {std::pair{"resonator", &scene.resonator}, std::pair{"slider", &scene.slider}}) {
    check_nodes(scene, name, *body, document);
    // of a plate without frequencies the fault has been named
    bodies = (body->kind == BodyKind::plate && !bodies)
                 ? false
                 : check_body(name, *body, document) && bodies;
    check_surface(scene, name, *body, document);
  }
  if (bodies) check_modes(scene, document);
  check_loads(scene, document);
  check_law(scene, document);
  check_stiffness(scene, document);
  check_output(scene, document);
}

}  // namespace ra2d
