// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/asked.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/report/html.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/key_facts.hpp"

namespace ra2d {
namespace {

/// A prefix of a unit, and the factor that goes with it.
struct Prefix {
  const char* letter;
  double factor;
};
constexpr Prefix no_prefix{"", 1}, giga{"G", 1e-9}, kilo{"k", 1e-3}, milli{"m", 1e3},
    micro{"µ", 1e6};

/// A value of a key, with the unit that the key has in the table of keys.
std::string with_unit(const std::string& key, double value, int digits = 3,
                      const Prefix& prefix = no_prefix) {
  std::string unit = key_unit(key);
  if (const std::size_t cube = unit.find("^3"); cube != std::string::npos)
    unit.replace(cube, 2, "³");
  return fmt::format("{} {}{}", html_number(value * prefix.factor, digits), prefix.letter, unit);
}
/// A length, in a unit that suits its size.
std::string length(const std::string& key, double value) {
  const double size = std::abs(value);
  const bool is_plain = size == 0 || !(size < 0.9995);
  return with_unit(key, value, 4, is_plain ? no_prefix : size < 0.9995e-3 ? micro : milli);
}

/// `key`: the path of the surface.
std::string random_face(const std::string& key, const SurfaceSpec& s) {
  std::string text = fmt::format("random, {} correlation, Rq {}",
                                 html(correlations.name(s.correlation)), length(key + ".rq", s.rq));
  if (s.rsm) text += ", RSm " + length(key + ".rsm", *s.rsm);
  if (s.correlation_length)
    text += ", correlation length " + length(key + ".correlation_length", *s.correlation_length);
  if (s.hurst) text += ", Hurst exponent " + html_number(*s.hurst);
  if (s.skewness) text += ", skewness " + html_number(*s.skewness);
  if (s.kurtosis) text += ", kurtosis " + html_number(*s.kurtosis);
  return text + fmt::format(", seed {}", s.seed);
}

std::string face(const std::string& key, const SurfaceSpec& s) {
  switch (s.kind) {
    case SurfaceKind::flat:
      return "flat";
    case SurfaceKind::peaks:
      return fmt::format("{} peak{}", s.peaks.size(), s.peaks.size() == 1 ? "" : "s");
    case SurfaceKind::file:
      return "measured: " + html(s.path.filename().string());
    case SurfaceKind::gaussian:
      return random_face(key, s);
  }
  return {};
}

std::string body(const std::string& key, const BodySpec& b) {
  std::string text =
      fmt::format("{} beam, {} long, {} thick, {} wide", html(supports.name(b.support)),
                  length(key + ".length", b.length), length(key + ".thickness", b.thickness),
                  length(key + ".width", b.width));
  if (b.support == Support::rigid) return text;
  text += fmt::format("; {}, {}, damping ratio {}", with_unit(key + ".young", b.young, 4, giga),
                      with_unit(key + ".density", b.density, 4), html_number(b.damping));
  if (b.max_frequency)
    text += "; modes up to " + with_unit(key + ".max_frequency", *b.max_frequency, 3, kilo);
  if (b.modes) text += fmt::format("; {} elastic modes", *b.modes);
  return text;
}

std::string contact(const Scene& scene) {
  return scene.contact.law == ContactLaw::penalty
             ? "penalty, " + with_unit("contact.stiffness", scene.contact.stiffness)
             : std::string("Lagrange multipliers: no penetration");
}

std::string time_steps(const Scene& scene) {
  const TimeSettings& t = scene.time;
  const std::string name = html(schemes.name(t.scheme));
  return is_adaptive(scene) ? fmt::format("{}, tolerance {}", name,
                                          html_number(t.tolerance.value_or(usual_tolerance)))
                            : fmt::format("{}, steps of {}", name, with_unit("time.step", t.step));
}

}  // namespace

FactTable asked_facts(const Scene& s) {
  FactTable facts{
      {"sliding", fmt::format("{} at {}, from {} on", with_unit("scene.duration", s.duration, 4),
                              with_unit("scene.speed", s.speed), length("scene.start", s.start))},
      {"resonator", body("resonator", s.resonator)},
      {"its face", face("resonator.surface", s.resonator.surface)},
      {"slider", body("slider", s.slider)},
      {"its face", face("slider.surface", s.slider.surface)},
      {"load", s.slider.load_is_weight ? std::string("its weight")
                                       : with_unit("slider.load", s.slider.load)},
      {"contact", contact(s)},
      {"spacing", length("scene.spacing", s.spacing)},
      {"time scheme", time_steps(s)},
      {"samples",
       fmt::format("{}; counted from {} on", with_unit("output.rate", s.output.rate, 4, kilo),
                   with_unit("output.from", s.output.from))}};
  for (const MovingForce& force : s.resonator.moving_forces)
    facts.emplace_back(
        "moving force",
        fmt::format("{} at {}", with_unit("resonator.moving_force.force", force.force),
                    with_unit("resonator.moving_force.speed", force.speed)));
  return facts;
}

}  // namespace ra2d
