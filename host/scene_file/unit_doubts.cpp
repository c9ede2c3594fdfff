// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/unit_doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/base/quiet_nan.hpp"
#include "host/body/body.hpp"
#include "host/body/plate.hpp"
#include "host/scene_file/key_facts.hpp"

// The bounds are those of what is built and rubbed, from micromachines to bridges and from rubber
// to diamond, with room to spare. What is off by a factor of a thousand lies beyond one of them in
// most scenes.
namespace ra2d {

void doubt(std::vector<std::string>& doubts, const std::string& key, double value,
           const std::string& why, const Slip& slip) {
  const std::string& unit = key_unit(key);
  const std::string other = slip.unit;
  doubts.push_back(
      fmt::format("{} = {:g} {}: {}: {} ({:.4g} {})?{}", key, value, unit, why,
                  other.empty() ? slip.words : "is it in " + other, value * slip.factor, unit,
                  other.empty() ? "" : fmt::format(" Then write \"{:g} {}\"", value, other)));
}

namespace {

using Doubts = std::vector<std::string>;

constexpr Slip giga{1e9, "GPa", ""}, mega{1e6, "MPa", ""}, grams{1e3, "g/cm^3", ""},
    kilohertz{1e3, "kHz", ""}, millimetres_a_second{1e-3, "mm/s", ""};

/// How fast sound runs along a beam [m/s].
double sound_speed(const BodySpec& body) { return std::sqrt(body.young / body.density); }

void doubt_young(const std::string& name, const BodySpec& body, Doubts& doubts) {
  constexpr double softest = 1e4, stiffest = 1.5e12;     // Pa: gels, and beyond diamond
  constexpr double most_giga = 1500, most_mega = 1.5e6;  // numbers of GPa, of MPa
  constexpr double dense = 2000, slow = 200;  // kg/m^3, m/s: no metal, glass or stone is slower
  const Slip meant = body.young < most_giga ? giga : body.young < most_mega ? mega : too_small;
  const std::string key = name + ".young";
  if (body.young < softest)
    doubt(doubts, key, body.young, "softer than a gel", meant);
  else if (body.young > stiffest)
    doubt(doubts, key, body.young, "stiffer than diamond", too_large);
  else if (body.density > dense && sound_speed(body) < slow)
    doubt(doubts, key, body.young, fmt::format("softer than anything of {:g} kg/m^3", body.density),
          meant);
}

void doubt_density(const std::string& name, const BodySpec& body, Doubts& doubts) {
  constexpr double lightest = 10, heaviest = 23000;      // kg/m^3: foam, and beyond osmium
  constexpr double most_in_grams = 25, fastest = 20000;  // m/s: sound in diamond takes 18 000
  const std::string key = name + ".density";
  if (body.density < lightest)
    doubt(doubts, key, body.density, "lighter than foam", grams);
  else if (body.density > heaviest)
    doubt(doubts, key, body.density, "heavier than any metal", too_large);
  else if (body.density < most_in_grams && sound_speed(body) > fastest)
    doubt(doubts, key, body.density, fmt::format("lighter than anything of {:g} Pa", body.young),
          grams);
  else if (sound_speed(body) > fastest)
    doubt(doubts, name + ".young", body.young,
          fmt::format("stiffer than anything of {:g} kg/m^3", body.density), too_large);
}

void doubt_section(const std::string& name, const BodySpec& body, bool is_slider, Doubts& doubts) {
  constexpr double longest = 50, widest = 10, shortest = 1e-6, narrowest = 1e-7;  // m
  constexpr double slender = 2e4, tall_block = 10, tall_edge = 8;                 // ratios
  const auto is_far = [&](const char* key, double value, double low, double high) {
    if (value > high)
      doubt(doubts, name + key, value, "larger than what is rubbed", millimetres);
    else if (value < low)
      doubt(doubts, name + key, value, "smaller than what is rubbed", too_small);
    return value > high || value < low;
  };
  const bool odd_length = is_far(".length", body.length, shortest, longest);
  const bool odd_width = is_far(".width", body.width, narrowest, widest);
  // proportions to what is doubted say nothing; a rigid body need not give a thickness
  if (odd_length || odd_width || body.thickness == 0) return;
  // a block that slides may stand; what bends is longer than thick
  const double most = (is_slider ? tall_block : 1) * body.length;
  const std::string key = name + ".thickness";
  if (body.thickness > most)
    doubt(doubts, key, body.thickness,
          fmt::format("{:.3g} times {}.length = {:g} m, out of proportion",
                      body.thickness / body.length, name, body.length),
          millimetres);
  else if (body.length > slender * body.thickness)
    doubt(doubts, key, body.thickness,
          fmt::format("{}.length = {:g} m is {:.3g} times as much, more than a foil's", name,
                      body.length, body.length / body.thickness),
          too_small);
  else if (body.thickness > tall_edge * body.width)
    doubt(doubts, name + ".width", body.width,
          fmt::format("{}.thickness = {:g} m is {:.3g} times as much, a blade on its edge", name,
                      body.thickness, body.thickness / body.width),
          too_small);
}

/// Of elastic mode 0 [Hz]; not a number of a plate that can be none.
double first_frequency(const BodySpec& body) {
  if (body.kind == BodyKind::plate && !has_plate_modes(body)) return quiet_nan;
  return elastic_frequency(body, 0);
}

void doubt_body(const std::string& name, const BodySpec& body, bool is_slider, Doubts& doubts) {
  constexpr double most_damping = 0.5, most_kilohertz = 1000;
  doubt_section(name, body, is_slider, doubts);
  if (body.support == Support::rigid || body.young == 0 || body.density == 0 || body.thickness == 0)
    return;  // the rest is not given
  doubt_young(name, body, doubts);
  doubt_density(name, body, doubts);
  if (body.damping > most_damping)
    doubts.push_back(
        fmt::format("{}.damping = {:g}: more than half of critical damping, and its modes hardly "
                    "swing: is it in per cent ({:g})?",
                    name, body.damping, body.damping / 100));
  // of larger numbers it is the body that is odd
  if (body.max_frequency && *body.max_frequency < most_kilohertz && !is_slider &&
      first_frequency(body) > *body.max_frequency)
    doubt(doubts, name + ".max_frequency", *body.max_frequency,
          fmt::format("it keeps no mode, the first is at {:.4g} Hz", first_frequency(body)),
          kilohertz);
}

/// The resonator's deflection under a force in its middle [m], by its first mode: 1.5 % more than
/// that of the whole beam; of a plate up to a third less.
double static_deflection(const BodySpec& body, double force) {
  const double omega = 2 * M_PI * first_frequency(body);
  const double mass = body.density * body.thickness * body.width * body.length;
  const double square = body.kind == BodyKind::plate ? 4 : 2;  // of the shape there, over its mean
  return square * std::abs(force) / (mass * omega * omega);
}

void doubt_loads(const Scene& scene, Doubts& doubts) {
  constexpr double large = 0.1;    // of the length: more than anything bends
  constexpr double little = 0.02;  // of the weight
  const BodySpec& slider = scene.slider;
  const auto bends = [&](const std::string& key, double force) {
    if (scene.resonator.support != Support::pinned) return false;
    const double deflection = static_deflection(scene.resonator, force);
    const double length = scene.resonator.length, thickness = scene.resonator.thickness;
    const bool is_plate = scene.resonator.kind == BodyKind::plate;
    if (deflection > large * length)
      doubt(doubts, key, force,
            fmt::format("it bends the resonator by {:.3g} m of its {:g} m", deflection, length),
            too_large);
    else if (is_plate && deflection > thickness)  // a beam may draw in its ends
      doubts.push_back(fmt::format(
          "{} = {:g} N: it bends the plate by {:.3g} m, more than its thickness, {:g} m: "
          "a plate that is bent so far is stretched, too, which the model leaves out",
          key, force, deflection, thickness));
    else
      return false;
    return true;
  };
  for (std::size_t i = 0; i < scene.resonator.moving_forces.size(); ++i) {
    const MovingForce& force = scene.resonator.moving_forces[i];
    const std::string key = fmt::format("resonator.moving_force[{}]", i);
    bends(key + ".force", force.force);
    const double end = force.start + force.speed * scene.duration;
    if (std::isfinite(end) &&
        (std::max(force.start, end) < 0 || std::min(force.start, end) > scene.resonator.length)) {
      const std::string never = fmt::format("at {:g} m/s it is never on the resonator in {:g} s",
                                            force.speed, scene.duration);
      if (force.start > 10 * scene.resonator.length)
        doubt(doubts, key + ".start", force.start, never, millimetres);
      else
        doubts.push_back(fmt::format("{}.start = {:g} m: {}", key, force.start, never));
    }
    constexpr double fastest = 1000;  // m/s
    if (force.speed > fastest)
      doubt(doubts, key + ".speed", force.speed, "faster than a bullet", millimetres_a_second);
  }
  if (slider.support == Support::rigid) return;
  const double weight =
      9.80665 * slider.density * slider.length * slider.thickness * slider.width;  // N
  const bool is_own_weight = slider.load_is_weight && slider.load_weights <= 1;
  if (!is_own_weight &&
      bends("slider.load", slider.load_is_weight ? slider.load_weights * weight : slider.load))
    return;
  if (slider.load_is_weight || slider.load == 0) return;
  if (std::abs(slider.load) < little * weight)
    doubt(doubts, "slider.load", slider.load,
          fmt::format("the slider alone weighs {:.3g} N", weight), too_small);
}

void doubt_motion(const Scene& scene, Doubts& doubts) {
  constexpr double slowest = 2e-4, fastest = 50;  // m/s
  if (scene.speed > fastest)
    doubt(doubts, "scene.speed", scene.speed, "faster than brakes and rails rub",
          millimetres_a_second);
  else if (scene.speed > 0 && scene.speed < slowest)
    doubt(doubts, "scene.speed", scene.speed, "so slow that little is heard", too_small);
}

/// Nodes against the waves and peaks that they have to show. Measured faces are checked where they
/// are read.
void doubt_spacing(const Scene& scene, const std::string& name, const BodySpec& body,
                   Doubts& doubts) {
  constexpr double most_to_wave = 1e4, most_to_peak = 2000, least_to_peak = 2;  // spacings
  const SurfaceSpec& surface = body.surface;
  const auto fine = [&](double length, const std::string& what) {
    doubt(doubts, "scene.spacing", scene.spacing,
          fmt::format("{:.3g} nodes to {}, far more than show anything", length / scene.spacing,
                      what),
          too_small);
  };
  if (surface.kind == SurfaceKind::gaussian) {
    const double wave =
        surface.shortest.value_or(surface.rsm.value_or(surface.correlation_length.value_or(0)));
    if (wave > most_to_wave * scene.spacing)
      fine(wave, fmt::format("the {:g} m of {}.surface", wave, name));
    if (surface.rsm.value_or(0) > body.length)
      doubt(doubts, name + ".surface.rsm", *surface.rsm,
            "longer than the body, which is then "
            "bent and not rough",
            millimetres);
  }
  if (surface.kind != SurfaceKind::peaks) return;
  double narrowest = std::numeric_limits<double>::infinity(), widest = 0;
  std::size_t index = 0;  // of the widest
  for (std::size_t i = 0; i < surface.peaks.size(); ++i) {
    const double half_width = surface.peaks[i].half_width;
    narrowest = std::min(narrowest, half_width);
    if (!(half_width > widest)) continue;
    widest = half_width;
    index = i;
  }
  if (widest > body.length)
    doubt(doubts, fmt::format("{}.surface.peaks[{}].half_width", name, index), widest,
          "wider than the body is long", millimetres);
  if (narrowest < least_to_peak * scene.spacing)
    doubts.push_back(
        fmt::format("{}.surface: a peak of half_width {:g} m falls between nodes {:g} m "
                    "apart, which see little of it: scene.spacing = {:g} sees it",
                    name, narrowest, scene.spacing, narrowest / 10));
  else if (std::isfinite(narrowest) && narrowest > most_to_peak * scene.spacing)
    fine(narrowest, fmt::format("the half_width of a peak, {:g} m", narrowest));
}

void doubt_peaks(const std::string& name, const BodySpec& body, Doubts& doubts) {
  constexpr double large_share = 0.05, steep = 1, flat = 1e-4;
  for (std::size_t i = 0; i < body.surface.peaks.size(); ++i) {
    const Peak& peak = body.surface.peaks[i];
    const std::string key = fmt::format("{}.surface.peaks[{}].height", name, i);
    const double height = std::abs(peak.height);
    if ((body.thickness > 0 && height > large_share * body.thickness) ||
        height > steep * peak.half_width)
      doubt(doubts, key, peak.height,
            fmt::format("a peak of half_width {:g} m that is so high", peak.half_width), too_large);
    else if (height > 0 && height < flat * peak.half_width)
      doubt(doubts, key, peak.height,
            fmt::format("a peak of half_width {:g} m that is so low", peak.half_width), too_small);
  }
}

}  // namespace

std::vector<std::string> unit_doubts(const Scene& scene) {
  Doubts doubts;
  doubt_motion(scene, doubts);
  for (const auto& [name, body] :
       {std::pair{"resonator", &scene.resonator}, std::pair{"slider", &scene.slider}}) {
    doubt_body(name, *body, body == &scene.slider, doubts);
    doubt_spacing(scene, name, *body, doubts);
    if (body->surface.kind == SurfaceKind::peaks) doubt_peaks(name, *body, doubts);
  }
  doubt_loads(scene, doubts);
  return doubts;
}

}  // namespace ra2d
