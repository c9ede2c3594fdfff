// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <iterator>

#include "host/base/text.hpp"
#include "host/scene/hertz.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

std::string toml_value(double value) { return toml_number(value); }
std::string toml_value(const std::string& text) { return toml_string(text); }

std::string array(const std::vector<std::string>& elements) {
  return fmt::format("[{}]", fmt::join(elements, ", "));
}

class Writer {
 public:
  void section(const std::string& header, const std::string& unused = {}) {
    if (!text_.empty()) text_ += '\n';
    line(header, unused);
  }
  /// `unused` says why the key is not used, when it is not.
  template <class T>
  void key(const std::string& name, const T& value, const std::string& unused = {}) {
    raw(name, toml_value(value), unused);
  }
  void raw(const std::string& name, const std::string& value, const std::string& unused = {}) {
    line(name + " = " + value, unused);
  }
  const std::string& text() const { return text_; }

 private:
  void line(const std::string& content, const std::string& unused) {
    text_ += content;
    if (!unused.empty()) text_ += "  # not used: " + unused;
    text_ += '\n';
  }
  std::string text_;
};

/// The inline table of a surface: its kind, the keys of the kind, and those of others that stand;
/// and which of them are not used, and why. `folder`: the scene's.
struct SurfaceWords {
  std::string table, unused;
};
SurfaceWords words_of(const SurfaceSpec& surface, const std::filesystem::path& folder) {
  std::string table = fmt::format("kind = \"{}\"", surface_kinds.name(surface.kind));
  std::vector<std::string> unused;
  const auto key = [&](SurfaceKind user, bool stands, const char* name, const std::string& value) {
    if (surface.kind != user && stands) unused.emplace_back(name);
    if (stands) table += fmt::format(", {} = {}", name, value);
  };
  const auto is = [&](SurfaceKind kind) { return surface.kind == kind; };
  std::vector<std::string> peaks;
  for (const Peak& peak : surface.peaks)
    peaks.push_back(fmt::format("{{ at = {}, height = {}, half_width = {} }}", toml_number(peak.at),
                                toml_number(peak.height), toml_number(peak.half_width)));
  key(SurfaceKind::peaks, is(SurfaceKind::peaks) || !peaks.empty(), "peaks", array(peaks));
  key(SurfaceKind::file, is(SurfaceKind::file) || !surface.path.empty(), "path",
      toml_string(surface.path.empty()
                      ? std::string()
                      : absolute(folder / surface.path).lexically_normal().string()));
  const FilePreparation& how = surface.prepared;
  const auto word = [&](const char* name, bool stands, const std::string& text) {
    key(SurfaceKind::file, stands, name, toml_string(text));
  };
  const auto index = [&](const char* name, const std::optional<int>& number) {
    key(SurfaceKind::file, number.has_value(), name, fmt::format("{}", number.value_or(0)));
  };
  const auto length = [&](const char* name, const std::optional<double>& value) {
    key(SurfaceKind::file, value.has_value(), name, toml_number(value.value_or(0)));
  };
  word("x_unit", how.x_unit.has_value(), file_units.name(how.x_unit.value_or(FileUnit::m)));
  word("z_unit", how.z_unit.has_value(), file_units.name(how.z_unit.value_or(FileUnit::m)));
  length("spacing", how.spacing);
  word("decimal", how.decimal.has_value(),
       file_decimals.name(how.decimal.value_or(FileDecimal::point)));
  index("row", how.row);
  index("column", how.column);
  word("fill", !how.fill.empty(), how.fill);
  word("form", !how.form.empty(), how.form);
  length("cutoff_s", how.cutoff_s);
  word("filter", how.filter != FaceFilter::none, face_filters.name(how.filter));
  length("cutoff", how.cutoff);
  word("short", how.when_short != ShortProfile::refuse, short_profiles.name(how.when_short));
  key(SurfaceKind::gaussian, surface.rq != 0, "rq", toml_number(surface.rq));
  key(SurfaceKind::gaussian, surface.rsm.has_value(), "rsm", toml_number(surface.rsm.value_or(0)));
  key(SurfaceKind::gaussian, surface.correlation_length.has_value(), "correlation_length",
      toml_number(surface.correlation_length.value_or(0)));
  // of the random surfaces some keys belong to one correlation
  const bool random = is(SurfaceKind::gaussian);
  const bool self_affine = surface.correlation == Correlation::self_affine;
  if (random && self_affine && surface.correlation_length)
    unused.emplace_back("correlation_length");
  const auto wave = [&](const char* name, const std::optional<double>& value, bool used) {
    if (random && value && !used) unused.emplace_back(name);
    key(SurfaceKind::gaussian, value.has_value(), name, toml_number(value.value_or(0)));
  };
  key(SurfaceKind::gaussian, surface.correlation != Correlation::gaussian, "correlation",
      toml_string(correlations.name(surface.correlation)));
  wave("hurst", surface.hurst, self_affine);
  wave("longest", surface.longest, self_affine);
  wave("shortest", surface.shortest, surface.correlation != Correlation::gaussian);
  wave("skewness", surface.skewness, true);
  wave("kurtosis", surface.kurtosis, true);
  key(SurfaceKind::gaussian, surface.exact != Exactly::rq, "exact",
      toml_string(exact_choices.name(surface.exact)));
  key(SurfaceKind::gaussian, is(SurfaceKind::gaussian) || surface.seed != 0, "seed",
      fmt::format("{}", surface.seed));
  return {"{ " + table + " }", unused.empty()
                                   ? ""
                                   : fmt::format("{}, the {} is \"{}\"", fmt::join(unused, ", "),
                                                 random ? "correlation" : "kind",
                                                 random ? correlations.name(surface.correlation)
                                                        : surface_kinds.name(surface.kind))};
}

/// Whether the bodies' elastic constants give the contact its stiffness.
bool takes_hertz(const ContactSettings& contact) {
  return contact.is_hertz && contact.law == ContactLaw::penalty;
}

void write_body(const std::string& name, const BodySpec& body, const ContactSettings& contact,
                const std::filesystem::path& folder, Writer& out) {
  const bool is_rigid = body.support == Support::rigid, hertz = takes_hertz(contact);
  const std::string unused = is_rigid ? "the body is rigid" : "";
  const auto material = [&](const char* key, double value) {
    if (!is_rigid || value != 0) out.key(key, value, unused);
  };
  out.section(fmt::format("[{}]", name));
  out.key("support", supports.name(body.support));
  out.key("length", body.length);
  material("thickness", body.thickness);
  out.key("width", body.width);
  if (!is_rigid || body.young != 0) out.key("young", body.young, hertz ? "" : unused);
  material("density", body.density);
  if (body.poisson || (hertz && body.young != 0))
    out.key("poisson", body.poisson.value_or(usual_poisson),
            hertz ? "" : "only contact.stiffness = \"hertz\" takes it");
  material("damping", body.damping);
  if (body.max_frequency) out.key("max_frequency", *body.max_frequency, unused);
  if (body.modes) out.raw("modes", fmt::format("{}", *body.modes), unused);
  const SurfaceWords surface = words_of(body.surface, folder);
  out.raw("surface", surface.table, surface.unused);
}

}  // namespace

std::string surface_text(const SurfaceSpec& surface, const std::filesystem::path& folder) {
  return words_of(surface, folder).table;
}

std::string echo(const Scene& scene) {
  Writer out;
  out.section("[scene]");
  out.key("name", scene.name);
  out.key("duration", scene.duration);
  out.key("speed", scene.speed);
  out.key("start", scene.start);
  out.raw("gap", scene.gap ? toml_number(*scene.gap) : toml_string("touching"));
  out.key("spacing", scene.spacing);
  out.key("initial", initial_states.name(scene.initial));

  const std::filesystem::path folder = scene.file.parent_path();
  write_body("resonator", scene.resonator, scene.contact, folder, out);
  for (const MovingForce& force : scene.resonator.moving_forces) {
    out.section("[[resonator.moving_force]]",
                scene.resonator.support == Support::rigid ? "the body is rigid" : "");
    out.key("force", force.force);
    out.key("speed", force.speed);
    out.key("start", force.start);
  }

  write_body("slider", scene.slider, scene.contact, folder, out);
  out.raw("load",
          scene.slider.load_is_weight ? toml_string("weight") : toml_number(scene.slider.load),
          scene.slider.support == Support::rigid ? "the body is rigid" : "");

  out.section("[contact]");
  out.key("law", contact_laws.name(scene.contact.law));
  const bool spring = scene.contact.law == ContactLaw::penalty;
  if (takes_hertz(scene.contact))
    out.raw("stiffness", toml_number(scene.contact.stiffness) +
                             "  # \"hertz\": of the young, poisson and width of both bodies");
  else if (spring || scene.contact.stiffness != 0)
    out.key("stiffness", scene.contact.stiffness, spring ? "" : "multipliers have no spring");

  out.section("[time]");
  out.key("scheme", schemes.name(scene.time.scheme));
  out.key("contact_force", force_times.name(scene.time.contact_force),
          !spring              ? "multipliers are found with the end of the step"
          : is_adaptive(scene) ? "adaptive takes the force as it changes"
          : scene.time.scheme != SchemeKind::backward_euler
              ? fmt::format("{} takes the force at its stages", schemes.name(scene.time.scheme))
              : "");
  const bool adaptive = is_adaptive(scene);
  if (!adaptive || scene.time.step > 0)
    out.key("step", scene.time.step, adaptive ? "adaptive finds its steps" : "");
  if (scene.time.tolerance)
    out.key("tolerance", *scene.time.tolerance,
            adaptive ? "" : fmt::format("{} takes fixed steps", schemes.name(scene.time.scheme)));
  out.key("nodes", node_choices.name(scene.time.nodes));
  if (scene.time.force)
    out.raw("force", "true", adaptive ? "adaptive has no limit of stability" : "");

  out.section("[output]");
  out.key("rate", scene.output.rate);
  const auto places = [](const std::vector<double>& probes) {
    std::vector<std::string> texts;
    for (const double probe : probes) texts.push_back(toml_number(probe));
    return array(texts);
  };
  out.raw("probes", places(scene.output.probes));
  out.raw("slider_probes", places(scene.output.slider_probes));
  out.key("from", scene.output.from);
  return out.text();
}

}  // namespace ra2d
