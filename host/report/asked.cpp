// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/asked.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/report/html.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

std::string metres(double value) {
  const double size = std::abs(value);
  if (size == 0) return "0 m";
  if (size < 0.9995e-3) return html_number(value * 1e6, 4) + " µm";
  return size < 0.9995 ? html_number(value * 1e3, 4) + " mm" : html_number(value, 4) + " m";
}

std::string random_face(const SurfaceSpec& s) {
  std::string text = fmt::format("random, {} correlation, Rq {}",
                                 html(correlations.name(s.correlation)), metres(s.rq));
  if (s.rsm) text += ", RSm " + metres(*s.rsm);
  if (s.correlation_length) text += ", correlation length " + metres(*s.correlation_length);
  if (s.hurst) text += ", Hurst exponent " + html_number(*s.hurst);
  if (s.skewness) text += ", skewness " + html_number(*s.skewness);
  if (s.kurtosis) text += ", kurtosis " + html_number(*s.kurtosis);
  return text + fmt::format(", seed {}", s.seed);
}

std::string face(const SurfaceSpec& s) {
  switch (s.kind) {
    case SurfaceKind::flat:
      return "flat";
    case SurfaceKind::peaks:
      return fmt::format("{} peak{}", s.peaks.size(), s.peaks.size() == 1 ? "" : "s");
    case SurfaceKind::file:
      return "measured: " + html(s.path.filename().string());
    case SurfaceKind::gaussian:
      return random_face(s);
  }
  return {};
}

std::string body(const BodySpec& b) {
  std::string text =
      fmt::format("{} beam, {} long, {} thick, {} wide", html(supports.name(b.support)),
                  metres(b.length), metres(b.thickness), metres(b.width));
  if (b.support == Support::rigid) return text;
  text += fmt::format("; {} GPa, {} kg/m³, damping ratio {}", html_number(b.young * 1e-9, 4),
                      html_number(b.density, 4), html_number(b.damping));
  if (b.max_frequency)
    text += fmt::format("; modes up to {} kHz", html_number(*b.max_frequency * 1e-3));
  if (b.modes) text += fmt::format("; {} elastic modes", *b.modes);
  return text;
}

std::string contact(const Scene& scene) {
  return scene.contact.law == ContactLaw::penalty
             ? fmt::format("penalty, {} Pa/m", html_number(scene.contact.stiffness))
             : std::string("Lagrange multipliers: no penetration");
}

std::string time_steps(const Scene& scene) {
  const TimeSettings& t = scene.time;
  const std::string name = html(schemes.name(t.scheme));
  return is_adaptive(scene) ? fmt::format("{}, tolerance {}", name,
                                          html_number(t.tolerance.value_or(usual_tolerance)))
                            : fmt::format("{}, steps of {} s", name, html_number(t.step));
}

}  // namespace

FactTable asked_facts(const Scene& s) {
  FactTable facts{
      {"sliding", fmt::format("{} s at {} m/s, from {} on", html_number(s.duration, 4),
                              html_number(s.speed), metres(s.start))},
      {"resonator", body(s.resonator)},
      {"its face", face(s.resonator.surface)},
      {"slider", body(s.slider)},
      {"its face", face(s.slider.surface)},
      {"load",
       s.slider.load_is_weight ? std::string("its weight") : html_number(s.slider.load) + " N"},
      {"contact", contact(s)},
      {"spacing", metres(s.spacing)},
      {"time scheme", time_steps(s)},
      {"samples", fmt::format("{} kHz; counted from {} s on", html_number(s.output.rate * 1e-3, 4),
                              html_number(s.output.from))}};
  for (const MovingForce& force : s.resonator.moving_forces)
    facts.emplace_back("moving force", fmt::format("{} N at {} m/s", html_number(force.force),
                                                   html_number(force.speed)));
  return facts;
}

}  // namespace ra2d
