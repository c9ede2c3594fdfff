// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/scene_file.hpp"

#include <fmt/format.h>

#include <limits>
#include <map>
#include <memory>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/scene/hertz.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/checks.hpp"
#include "host/scene_file/reader.hpp"
#include "host/scene_file/unit_doubts.hpp"
#include "host/surface/form.hpp"
#include "host/surface/profile.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t largest_file = 16u << 20;  // bytes
constexpr Range hurst_exponent{0, 1, false, "a number in (0, 1)"};
constexpr Range poisson_ratio{-1, 0.5 + std::numeric_limits<double>::epsilon(), false,
                              "a number over -1, at most 0.5"};
constexpr int most_asked = 1'000'000;       // modes
constexpr std::size_t longest_path = 4096;  // bytes, of a file that the system opens

Need needed(bool is) { return is ? Need::required : Need::optional; }

/// The text of a key that `understand` takes; empty for what is none.
template <class Understand>
std::string read_words(Reader& in, const std::string& key, const std::string& path,
                       Document& document, const char* expected, const Understand& understand) {
  const auto text = in.text(key, expected, Need::optional);
  if (!text || *text == "none") return {};
  if (!understand(*text))
    document.fault(path + "." + key, fmt::format("{} is not allowed: expected {}",
                                                 toml_string(shortened(*text)), expected));
  return *text;
}

FilePreparation read_preparation(Reader& in, const std::string& path, Document& document) {
  constexpr std::int64_t most = 100'000'000;
  FilePreparation how;
  how.x_unit = in.choice("x_unit", file_units, Need::optional);
  how.z_unit = in.choice("z_unit", file_units, Need::optional);
  how.spacing = in.number("spacing", positive, "m", Need::optional);
  how.decimal = in.choice("decimal", file_decimals, Need::optional);
  if (const auto row = in.integer("row", 1, most, Need::optional)) how.row = static_cast<int>(*row);
  if (const auto column = in.integer("column", 1, most, Need::optional))
    how.column = static_cast<int>(*column);
  how.form =
      read_words(in, "form", path, document, "none, mean, line or poly:N with N from 0 to 10",
                 [](const std::string& text) { return understand_form(text).has_value(); });
  how.fill = read_words(in, "fill", path, document, "linear:WIDTH, with a width in metres",
                        [](const std::string& text) { return to_fill_width(text).has_value(); });
  how.filter = in.choice("filter", face_filters, Need::optional).value_or(FaceFilter::none);
  how.cutoff = in.number("cutoff", positive, "m", Need::optional);
  how.cutoff_s = in.number("cutoff_s", positive, "m", Need::optional);
  how.when_short =
      in.choice("short", short_profiles, Need::optional).value_or(ShortProfile::refuse);
  return how;
}

SurfaceSpec read_surface(Reader in, const std::string& path, Document& document) {
  const auto kind = in.choice("kind", surface_kinds, Need::required);
  SurfaceSpec surface;
  surface.kind = kind.value_or(SurfaceKind::flat);
  const bool gaussian = kind == SurfaceKind::gaussian;
  surface.rq = in.number("rq", positive, "m", needed(gaussian)).value_or(0);
  surface.rsm = in.number("rsm", positive, "m", Need::optional);
  surface.correlation_length = in.number("correlation_length", positive, "m", Need::optional);
  surface.correlation =
      in.choice("correlation", correlations, Need::optional).value_or(Correlation::gaussian);
  surface.hurst = in.number("hurst", hurst_exponent, "", Need::optional);
  surface.longest = in.number("longest", positive, "m", Need::optional);
  surface.shortest = in.number("shortest", positive, "m", Need::optional);
  surface.skewness = in.number("skewness", any_number, "", Need::optional);
  surface.kurtosis = in.number("kurtosis", positive, "", Need::optional);
  surface.exact = in.choice("exact", exact_choices, Need::optional).value_or(Exactly::rq);
  if (gaussian && surface.exact == Exactly::rq_and_rsm && !in.has("rsm"))
    document.fault(path + ".exact", "\"rq+rsm\", and there is no `rsm` to be exact");
  if (gaussian && surface.correlation != Correlation::self_affine)
    in.one_of("rsm", "correlation_length");
  if (gaussian && surface.correlation == Correlation::self_affine) {
    if (!in.has("hurst"))
      document.fault(path + ".hurst", "missing: a self-affine surface needs its Hurst exponent");
    const int told = in.has("longest") + in.has("shortest") + in.has("rsm");
    if (told != 2)
      document.fault(path + ".longest",
                     fmt::format("{} of `longest`, `shortest` and `rsm` stand: expected two of "
                                 "them, the third follows",
                                 told));
  }
  surface.seed = static_cast<std::uint64_t>(
      in.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), needed(gaussian))
          .value_or(0));
  const bool file = kind == SurfaceKind::file;
  const auto profile = in.text("path", "the path of a profile, a text", needed(file));
  if (file && profile) {
    if (profile->empty()) document.fault(path + ".path", "empty: expected the path of a profile");
    if (profile->find('\0') != std::string::npos || profile->size() >= longest_path)
      document.fault(path + ".path", toml_string(shortened(*profile)) +
                                         " cannot be the name of a file: expected the path of a "
                                         "profile");
  }
  surface.path = profile.value_or("");
  surface.prepared = read_preparation(in, path, document);
  for (Reader peak : in.tables("peaks", needed(kind == SurfaceKind::peaks)))
    surface.peaks.push_back({.at = *peak.number("at", any_number, "m"),
                             .height = *peak.number("height", any_number, "m"),
                             .half_width = *peak.number("half_width", positive, "m")});
  return surface;
}

/// The keys of both bodies.
BodySpec read_body(Reader in, const std::string& name, Document& document) {
  const auto support = in.choice("support", supports, Need::required);
  // without a support it is not known which keys are missing; without the section, all are
  const Need material = needed(support ? *support != Support::rigid : !in.stands());
  BodySpec body;
  body.support = support.value_or(Support::pinned);
  body.length = *in.number("length", positive, "m");
  body.thickness = in.number("thickness", positive, "m", material).value_or(0);
  body.width = *in.number("width", positive, "m");
  body.young = in.number("young", positive, "Pa", material).value_or(0);
  body.density = in.number("density", positive, "kg/m^3", material).value_or(0);
  body.poisson = in.number("poisson", poisson_ratio, "", Need::optional);
  body.damping = in.number("damping", ratio, "", material).value_or(0);
  body.max_frequency = in.number("max_frequency", positive, "Hz", Need::optional);
  if (const auto modes = in.integer("modes", 0, most_asked, Need::optional))
    body.modes = static_cast<int>(*modes);
  if (material == Need::required) in.one_of("max_frequency", "modes");
  if (auto surface = in.table("surface"))
    body.surface = read_surface(*surface, name + ".surface", document);
  return body;
}

Scene read(Document& document, const std::filesystem::path& file) {
  Scene scene;
  scene.file = file;

  Reader in = document.section("scene");
  scene.name = in.text("name", "a text", Need::optional).value_or("");
  scene.duration = *in.number("duration", positive, "s");
  scene.speed = *in.number("speed", not_negative, "m/s");
  scene.start = *in.number("start", any_number, "m");
  scene.gap = in.number("gap", any_number, "m", Need::optional, "touching");
  scene.spacing = *in.number("spacing", positive, "m");
  const auto initial = in.choice("initial", initial_states, Need::optional);

  in = document.section("resonator");
  scene.resonator = read_body(in, "resonator", document);
  for (Reader force : in.tables("moving_force", Need::optional))
    scene.resonator.moving_forces.push_back({.force = *force.number("force", any_number, "N"),
                                             .speed = *force.number("speed", not_negative, "m/s"),
                                             .start = *force.number("start", any_number, "m")});

  in = document.section("slider");
  scene.slider = read_body(in, "slider", document);
  scene.slider.load_is_weight = in.says("load", "weight");
  scene.slider.load = in.number("load", any_number, "N", Need::optional, "weight").value_or(0);

  in = document.section("contact");
  scene.contact.law = in.choice("law", contact_laws, Need::optional).value_or(ContactLaw::penalty);
  const bool spring = scene.contact.law == ContactLaw::penalty;
  scene.contact.is_hertz = in.says("stiffness", "hertz");
  scene.contact.stiffness =
      in.number("stiffness", positive, "Pa/m", needed(spring), "hertz").value_or(0);
  if (scene.contact.is_hertz) scene.contact.stiffness = hertz_stiffness(scene);

  in = document.section("time");
  const auto scheme = in.choice("scheme", schemes, Need::optional);
  scene.time.scheme = scheme.value_or(SchemeKind::backward_euler);
  scene.time.contact_force =
      in.choice("contact_force", force_times, Need::optional).value_or(ForceTime::old_time);
  const bool adaptive = is_adaptive(scene);
  // of a scheme that is not known it is not known either whether it needs a step
  const bool fixed = !adaptive && (scheme || !in.has("scheme"));
  scene.time.step = in.number("step", positive, "s", needed(fixed))
                        .value_or(adaptive ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  scene.time.tolerance = in.number("tolerance", positive, "", Need::optional);
  if (adaptive && !scene.time.tolerance) scene.time.tolerance = usual_tolerance;
  scene.time.nodes = in.choice("nodes", node_choices, Need::optional).value_or(Nodes::candidates);
  scene.time.force = in.boolean("force").value_or(false);

  in = document.section("output");
  scene.output.rate = in.number("rate", positive, "Hz", Need::optional).value_or(100e3);
  scene.output.probes = in.numbers("probes", "m");
  scene.output.slider_probes = in.numbers("slider_probes", "m");
  scene.output.from = in.number("from", not_negative, "s", Need::optional).value_or(0);

  scene.initial = initial.value_or(has_equilibrium(scene) ? Initial::statics : Initial::rest);
  return scene;
}

void require_size(std::size_t bytes, const std::filesystem::path& file) {
  if (bytes > largest_file)
    throw RequestError(
        fmt::format("{}: 1 fault\n{}: more than 16 MiB: expected a scene, a short "
                    "text (is it another file?)",
                    file.string(), file.string()));
}

}  // namespace

Scene parse_scene(const ParsedText& text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides) {
  Document document{text, file, overrides};
  Scene scene = read(document, file);
  check(scene, document);
  document.finish({});
  return scene;
}

Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides) {
  require_size(text.size(), file);
  Document document{text, file, overrides};
  Scene scene = read(document, file);
  check(scene, document);
  const char* const drawn = "a seed means the same profile at every scene.spacing: drop the key";
  const char* const study = "this is a study: run it with 'ra2d study'";
  const std::map<std::string, std::string> hints = {
      {"base", study},
      {"vary", study},
      {"resonator.surface.seed_spacing", drawn},
      {"slider.surface.seed_spacing", drawn},
      {"resonator.load",
       "only the slider takes a load (slider.load, or [[resonator.moving_force]])"},
      {"slider.moving_force",
       "only the resonator takes a moving force (slider.load loads the slider)"}};
  try {
    document.finish(hints);
  } catch (const RequestError& fault) {  // what looks odd may be why
    std::string text = fault.what();
    for (const std::string& odd : unit_doubts(scene)) text += "\nlooks odd: " + odd;
    throw RequestError(text);
  }
  scene.places = std::make_shared<const std::map<std::string, std::string>>(document.places());
  return scene;
}

Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return parse_scene(InputFile(file, "the scene").beginning(largest_file + 1), file, overrides);
}

}  // namespace ra2d
