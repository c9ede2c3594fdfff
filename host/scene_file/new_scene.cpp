// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/new_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/base/units.hpp"
#include "host/body/body.hpp"
#include "host/surface/map_file.hpp"
#include "host/surface/map_roughness.hpp"
#include "host/surface/measure.hpp"
#include "host/surface/profile.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr double audible = 20e3;                 // Hz
constexpr double usual_rate = 100e3;             // Hz
constexpr double nodes_to_rsm = 50;              // at least: splines follow random faces
constexpr double most_nodes_of_new_scene = 2e6;  // on the resonator
constexpr double map_nodes_to_rsm = 50;          // of areal scenes: splines follow random faces
constexpr double most_nodes_of_new_block = 2e6;  // of areal scenes, on the slider
constexpr int most_resonator_modes = 200, most_slider_modes = 40;
constexpr int fewest_modes = 3;        // elastic ones of the resonator
constexpr double longest_new_run = 2;  // s
constexpr double share_of_path = 0.9;  // that the slider travels at most

[[noreturn]] void refuse(const std::string& answer, const std::string& why) {
  throw RequestError(fmt::format("'{}' {}", shortened(printable(answer)), why));
}

std::vector<std::string> split(const std::string& text, char mark) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(mark, begin), text.size());
    parts.emplace_back(trimmed(std::string_view(text).substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

/// A number > 0 with its unit.
GivenNumber with_unit(const std::string& text, const std::string& unit) {
  const NumberWithUnit quantity = read_quantity(text, unit);
  const std::string expected =
      fmt::format("expected a number > 0 with its unit, {}", quantity_examples(unit));
  if (!quantity.value)
    refuse(text,
           fmt::format("{}: {}", quantity.fault.empty() ? "is not understood" : quantity.fault,
                       expected));
  if (!(*quantity.value > 0) || !std::isfinite(*quantity.value))
    refuse(text, "is not allowed: " + expected);
  return {*quantity.value, toml_string(text)};
}

std::string names_of_materials() {
  std::vector<std::string> names;
  for (const Material& material : materials()) names.emplace_back(material.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

const Material& named_material(const std::string& name) {
  if (const Material* found = find_material(name)) return *found;
  std::vector<std::string> names;
  for (const Material& material : materials()) names.emplace_back(material.name);
  const auto near = nearest(name, names);
  refuse(name, fmt::format(
                   "is no material here{}: there are {} (take one that is close, and change "
                   "`young` and `density` in the file)",
                   near ? fmt::format(" (did you mean '{}'?)", *near) : "", names_of_materials()));
}

/// "500 x 20 x 3 mm", also with a unit to each.
void take_size(NewBody& body, const std::string& text) {
  constexpr const char* expected = "expected length x width x thickness, such as 500 x 20 x 3 mm";
  std::string plain = text;  // with one sign for times
  for (const std::string_view times : {"\u00D7", "*", "X"})
    for (std::size_t at = plain.find(times); at != plain.npos; at = plain.find(times, at))
      plain.replace(at, times.size(), "x");
  const std::vector<std::string> parts = split(plain, 'x');
  if (parts.size() != 3) refuse(text, fmt::format("is no size: {}", expected));
  const std::string& last = parts.back();
  const std::size_t unit = std::min(last.find_last_of("0123456789.") + 1, last.size());
  const std::string unit_of_all(trimmed(std::string_view(last).substr(unit)));
  if (unit_of_all.empty()) refuse(text, fmt::format("is a size without a unit: {}", expected));
  GivenNumber* const sizes[] = {&body.length, &body.width, &body.thickness};
  for (std::size_t i = 0; i < 3; ++i) {
    const bool is_plain =
        !parts[i].empty() && parts[i].find_last_of("0123456789.") + 1 == parts[i].size();
    const std::string number =
        i == 2 ? std::string(trimmed(std::string_view(last).substr(0, unit))) : parts[i];
    *sizes[i] =
        with_unit(is_plain || i == 2 ? fmt::format("{} {}", number, unit_of_all) : parts[i], "m");
  }
}

/// "steel, 500 x 20 x 3 mm", also without the comma, or one of the two.
NewBody body_of(NewBody body, const std::string& answer) {
  std::string with_comma = answer;
  for (std::size_t i = 1; i < answer.size() && answer.find(',') == answer.npos; ++i)
    if (answer[i - 1] == ' ' && std::isalpha(static_cast<unsigned char>(answer[0])) != 0 &&
        std::isdigit(static_cast<unsigned char>(answer[i])) != 0) {
      with_comma[i - 1] = ',';
      break;
    }
  const std::vector<std::string> parts = split(with_comma, ',');
  if (parts.size() > 2)
    refuse(answer,
           "is not understood: expected a material and a size, such as steel, 500 x 20 x 3 "
           "mm");
  for (const std::string& part : parts) {
    const bool is_size = !part.empty() && part.find_first_of("0123456789") == 0;
    if (is_size)
      take_size(body, part);
    else
      body.material = &named_material(part);
  }
  return body;
}

NewFace random_face(const std::string& answer, const std::vector<std::string>& parts,
                    SceneKind kind) {
  if (parts.size() != 2)
    refuse(answer, fmt::format("is no file here, and no roughness: expected Rq and RSm, such as 8 "
                               "um, 1.55 mm, the file of a {}, or flat",
                               kind == SceneKind::areal ? "height map" : "measured profile"));
  NewFace face;
  face.kind = NewFace::Kind::random;
  face.rq = with_unit(parts[0], "m");
  face.rsm = with_unit(parts[1], "m");
  if (!(face.rq.value < face.rsm.value))
    refuse(answer,
           "has an Rq that is not smaller than RSm: expected the height of the roughness "
           "first, then its mean spacing");
  return face;
}

/// Root mean square slope of straight lines between points `step` apart.
double slope_between(const Profile& profile, std::size_t step) {
  double sum = 0;
  for (std::size_t i = step; i < profile.heights.size(); ++i) {
    const double rise = profile.heights[i] - profile.heights[i - step];
    sum += rise * rise;
  }
  return std::sqrt(sum / static_cast<double>(profile.heights.size() - step)) /
         (static_cast<double>(step) * profile.spacing);
}

/// The widest spacing of nodes that shows a profile: a share of the mean spacing of its elements,
/// as of random faces, that keeps its slopes.
double spacing_for(Profile profile) {
  constexpr double least_slope = 0.98;  // of that from point to point
  constexpr std::size_t fewest_points = 200;
  if (profile.missing() > 0 || profile.heights.size() < fewest_points) return profile.spacing;
  shape_profile(profile, ProfileForm{1}, {}, {});
  std::size_t crossings = 0;
  for (std::size_t i = 1; i < profile.heights.size(); ++i)
    crossings += (profile.heights[i] > 0) != (profile.heights[i - 1] > 0);
  const double rsm = 2 * profile.length() / std::max(2.0, static_cast<double>(crossings));
  const double whole = slope_between(profile, 1);
  std::size_t step = 1;
  for (const std::size_t wider : {2, 3, 4, 5, 8, 10, 15, 20, 30, 40, 50, 80, 100})
    if (static_cast<double>(wider) * profile.spacing * nodes_to_rsm <= rsm &&
        slope_between(profile, wider) >= least_slope * whole)
      step = wider;
    else
      break;
  return static_cast<double>(step) * profile.spacing;
}

bool is_file(const std::string& name) {
  std::error_code none;
  return !name.empty() && name.find('\0') == name.npos && fs::is_regular_file(name, none);
}

/// "map.x3p", "map.npy, 5 um" or "map.txt, 5 um, nm": `parts` behind the file's name.
NewFace map_face_of(const std::string& answer, const fs::path& file,
                    const std::vector<std::string>& parts) {
  NewFace face;
  face.kind = NewFace::Kind::map;
  face.file = file;
  MapQuery query;
  if (parts.size() > 1) {
    face.step = with_unit(parts[1], "m");
    query.spacing = face.step.value;
  }
  if (parts.size() > 2) {
    query.z_unit = to_unit(parts[2]);
    if (!query.z_unit || parts.size() > 3)
      refuse(answer,
             "is not understood: expected FILE, or FILE, SPACING, or FILE, SPACING, Z_UNIT with a "
             "unit of m, mm, um or nm");
    face.z_unit = query.z_unit->name;
  }
  HeightMap map;
  try {
    map = read_height_map(file, query);
  } catch (const RequestError& fault) {
    throw RequestError(fmt::format(
        "{} (spacing, and unit of the heights, of a file that names none: FILE, 5 um, um)",
        fault.what()));
  }
  face.spacing = std::min(map.spacing, map.spacing_y);
  face.length = (static_cast<double>(map.nx) - 0.5) * map.spacing;
  face.width = static_cast<double>(map.ny) * map.spacing_y;
  if (map.missing() > 0) return face;
  remove_map_form(map, MapForm{1});
  const MapRoughness roughness = map_roughness(map);
  face.spacing = std::numeric_limits<double>::infinity();
  for (const double rsm : {roughness.rsm, roughness.rsm_y})
    if (rsm > 0) face.spacing = std::min(face.spacing, rsm / map_nodes_to_rsm);
  return face;
}

/// "8 um, 1.55 mm", "profile.csv", "profile.csv, mm, um" or "flat".
NewFace face_of(const std::string& answer, SceneKind kind) {
  NewFace face;
  if (answer == "flat") return face;
  const std::vector<std::string> parts = split(answer, ',');
  const bool is_whole = is_file(answer);
  if (!is_whole && !is_file(parts[0])) return random_face(answer, parts, kind);
  face.kind = NewFace::Kind::profile;
  face.file = is_whole ? answer : parts[0];
  if (kind == SceneKind::areal)
    return map_face_of(answer, face.file, is_whole ? std::vector<std::string>{answer} : parts);
  ProfileQuery query;
  if (!is_whole && parts.size() > 1) {
    if (parts.size() == 3) {
      query.x_unit = to_unit(parts[1]);
      query.z_unit = to_unit(parts[2]);
    }
    if (!query.x_unit || !query.z_unit)
      refuse(answer,
             "is not understood: expected FILE, or FILE, X_UNIT, Z_UNIT with units of m, "
             "mm, um or nm");
    face.x_unit = query.x_unit->name;
    face.z_unit = query.z_unit->name;
  }
  const Profile profile = [&] {
    try {
      return read_measured_profile(face.file, query);
    } catch (const RequestError& fault) {
      throw RequestError(
          fmt::format("{} (units of a file that names none: FILE, mm, um; a height map: --areal)",
                      fault.what()));
    }
  }();
  face.spacing = spacing_for(profile);
  face.length = profile.length();
  return face;
}

void take_resonator(NewScene& scene, const std::string& answer) {
  scene.resonator = body_of(scene.resonator, answer);
}
constexpr const char* both_flat =
    "both faces are flat, and nothing would sound: expected a rough one, such as 8 um, 1.55 mm";
void take_resonator_face(NewScene& scene, const std::string& answer) {
  scene.resonator.face = face_of(answer, scene.kind);
}
void take_slider(NewScene& scene, const std::string& answer) {
  const NewBody body = body_of(scene.slider, answer);
  if (body.length.value >= scene.resonator.length.value)
    refuse(answer, fmt::format("is not shorter than the resonator, {:g} m: expected a shorter one, "
                               "which has room to slide",
                               scene.resonator.length.value));
  scene.slider = body;
}
void take_slider_face(NewScene& scene, const std::string& answer) {
  const NewFace face = face_of(answer, scene.kind);
  if (face.kind == NewFace::Kind::flat && scene.resonator.face.kind == NewFace::Kind::flat)
    refuse(answer, std::string("leaves nothing rough: ") + both_flat);
  scene.slider.face = face;
}
void take_speed(NewScene& scene, const std::string& answer) {
  scene.speed = with_unit(answer, "m/s");
}
void take_load(NewScene& scene, const std::string& answer) {
  const auto weights = multiple_of(answer, "weight");
  if (!weights)
    scene.load = with_unit(answer, "N").toml;
  else if (!(*weights > 0) || std::isinf(*weights))
    refuse(answer, "is not allowed: expected a number > 0 of weights");
  else
    scene.load = toml_string(answer);
}
void take_damping(NewScene& scene, const std::string& answer) {
  double value = 0;
  const auto [rest, fault] = std::from_chars(answer.data(), answer.data() + answer.size(), value);
  if (fault != std::errc() || rest != answer.data() + answer.size() || !(value >= 0 && value < 1))
    refuse(answer,
           "is not allowed: expected a damping ratio from 0 to below 1, such as 0.01 for 1 "
           "per cent of critical damping");
  scene.damping = {value, toml_number(value)};
}
double free_path(const NewScene& scene) {
  return scene.resonator.length.value - scene.slider.length.value;
}
void take_duration(NewScene& scene, const std::string& answer) {
  if (answer == "path") {
    scene.duration = {};
    return;
  }
  const GivenNumber duration = with_unit(answer, "s");
  if (!(scene.speed.value * duration.value <= free_path(scene)))
    refuse(answer,
           fmt::format("takes the slider beyond the resonator's end: expected at most {:.3g} "
                       "s at this speed",
                       free_path(scene) / scene.speed.value));
  scene.duration = duration;
}

constexpr NewSceneQuestion all_questions[] = {
    {"--resonator", "MATERIAL,SIZE",
     "the resonator, the lower body that stays: material, length x width x thickness",
     "steel, 300 x 200 x 2 mm", take_resonator},
    {"--resonator-face", "FACE",
     "its face: Rq, RSm of a random one; the file of a measured profile or map; flat",
     "8 um, 1.55 mm", take_resonator_face},
    {"--slider", "MATERIAL,SIZE",
     "the slider, the upper body that moves, written like the resonator", "steel, 20 x 20 x 20 mm",
     take_slider},
    {"--slider-face", "FACE", "its face, written like the resonator's", "8 um, 1.55 mm",
     take_slider_face},
    {"--speed", "SPEED", "the sliding speed", "100 mm/s", take_speed},
    {"--load", "LOAD", "the load on the slider, in N or in weights of the slider", "weight",
     take_load},
    {"--damping", "RATIO", "the damping ratio of the modes of both bodies", "0.02", take_damping},
    {"--duration", "TIME", "the simulated time; path: as far as the resonator reaches, at most 2 s",
     "path", take_duration}};

// ---- the text

BodySpec spec_of(const NewBody& body, Support support, BodyKind kind = BodyKind::beam) {
  BodySpec spec;
  spec.kind = kind;
  spec.support = support;
  spec.length = body.length.value;
  spec.width = body.width.value;
  spec.thickness = body.thickness.value;
  spec.young = body.material->young;
  spec.density = body.material->density;
  return spec;
}

/// `value` rounded down to one of 1, 2, 4, 5, 8 times a power of ten.
double round_down(double value) {
  const double ten = std::pow(10, std::floor(std::log10(value)));
  double found = ten;
  for (const double digit : {2, 4, 5, 8})
    if (digit * ten <= value * (1 + 1e-9)) found = digit * ten;
  return found;
}

/// Up to the end of hearing, or as far as the modes that can be marched reach; at least the first
/// few of the resonator.
double highest_frequency(const BodySpec& spec, int fewest, int most) {
  const double lowest = fewest > 0 ? 1.1 * elastic_frequency(spec, fewest - 1) : 0;
  return std::max(std::min(audible, round_down(elastic_frequency(spec, most))), lowest);
}

std::string frequency_text(double frequency) {
  return fmt::format("\"{:.3g} kHz\"", frequency * 1e-3);
}

/// Fine enough for the contacts between maps, as far as the nodes do not become too many.
double spacing_of_new_areal_scene(const NewScene& scene) {
  constexpr double fewest_nodes_to_rsm = 5;
  double spacing = std::min(scene.slider.length.value, scene.slider.width.value) / 100,
         widest = spacing;
  for (const NewFace* face : {&scene.resonator.face, &scene.slider.face}) {
    if (face->kind == NewFace::Kind::map) spacing = std::min(spacing, face->spacing);
    if (face->kind != NewFace::Kind::random) continue;
    spacing = std::min(spacing, face->rsm.value / map_nodes_to_rsm);
    widest = std::min(widest, face->rsm.value / fewest_nodes_to_rsm);
  }
  const double area = scene.slider.length.value * scene.slider.width.value;
  return round_down(std::min(std::max(spacing, std::sqrt(area / most_nodes_of_new_block)), widest));
}

/// Fine enough for the contacts, as far as the nodes do not become too many.
double row_spacing_of_new_scene(const NewScene& scene, double spacing) {
  const double area = scene.slider.length.value * scene.slider.width.value;
  return std::min(
      spacing, round_down(std::max(scene.row_spacing, area / (spacing * most_nodes_of_new_block))));
}

/// Fine enough for the roughness.
double spacing_of_new_scene(const NewScene& scene) {
  double spacing = std::min(scene.slider.length.value, scene.resonator.length.value) / 100;
  for (const NewFace* face : {&scene.resonator.face, &scene.slider.face}) {
    if (face->kind == NewFace::Kind::random)
      spacing = std::min(spacing, round_down(face->rsm.value / nodes_to_rsm));
    if (face->kind == NewFace::Kind::profile) spacing = std::min(spacing, face->spacing);
  }
  return std::max(spacing, round_down(scene.resonator.length.value / most_nodes_of_new_scene));
}

/// `touched_width` [m]: of a map, the slider's.
std::string face_text(const NewBody& body, const fs::path& file, int seed, double touched_width) {
  const NewFace& face = body.face;
  switch (face.kind) {
    case NewFace::Kind::flat:
      return "{ kind = \"flat\" }";
    case NewFace::Kind::random:
      return fmt::format("{{ kind = \"gaussian\", rq = {}, rsm = {}, seed = {} }}", face.rq.toml,
                         face.rsm.toml, seed);
    case NewFace::Kind::profile:
    case NewFace::Kind::map:
      break;
  }
  const bool is_map = face.kind == NewFace::Kind::map;
  const fs::path from = fs::absolute(file).lexically_normal().parent_path();
  const fs::path path = fs::absolute(face.file).lexically_normal().lexically_proximate(from);
  std::string text = fmt::format("{{ kind = \"file\", path = {}", toml_string(path.string()));
  if (!face.step.toml.empty()) text += fmt::format(", spacing = {}", face.step.toml);
  if (!face.x_unit.empty()) text += fmt::format(", x_unit = \"{}\"", face.x_unit);
  if (!face.z_unit.empty()) text += fmt::format(", z_unit = \"{}\"", face.z_unit);
  text += is_map ? ", form = \"plane\"" : ", form = \"line\"";
  if (face.length < body.length.value || (is_map && face.width < touched_width))
    text += is_map ? ", short = \"mirror\"" : ", short = \"repeat\"";
  return text + " }";
}

const char* face_comment(const NewFace& face) {
  switch (face.kind) {
    case NewFace::Kind::flat:
      return "smooth";
    case NewFace::Kind::random:
      return "another seed, another face";
    case NewFace::Kind::profile:
      return "the measured profile";
    case NewFace::Kind::map:
      return "the measured map";
  }
  return "";
}

std::string damping_comment(const Material& material) {
  if (material.most_loss == 0) return "of each mode: best a measured one";
  return fmt::format("of each mode: best a measured one; the material alone has {}{:g}",
                     material.least_loss < material.most_loss && material.least_loss > 0
                         ? fmt::format("{:g} to ", material.least_loss / 2)
                     : material.least_loss == 0 ? std::string("less than ")
                                                : std::string("about "),
                     material.most_loss / 2);
}

/// Lines "key = value  # comment" with their signs below one another.
class Lines {
 public:
  void section(const std::string& name, const std::string& comment) {
    flush();
    text_ += comment.empty() ? fmt::format("\n[{}]\n", name)
                             : fmt::format("\n[{}]  # {}\n", name, comment);
  }
  void key(const std::string& name, const std::string& value, const std::string& comment = {}) {
    keys_.push_back({name, value, comment});
  }
  std::string text() {
    flush();
    return text_;
  }

 private:
  struct Line {
    std::string name, value, comment;
  };
  void flush() {
    constexpr std::size_t widest = 16;  // a longer value moves its own comment alone
    std::size_t name = 0, value = 0;
    for (const Line& line : keys_) {
      name = std::max(name, line.name.size());
      if (line.value.size() <= widest) value = std::max(value, line.value.size());
    }
    for (const Line& line : keys_) {
      std::string whole = fmt::format("{:<{}} = {:<{}}", line.name, name, line.value, value);
      if (!line.comment.empty()) whole += "  # " + line.comment;
      text_ += whole.substr(0, whole.find_last_not_of(' ') + 1) + '\n';
    }
    keys_.clear();
  }
  std::string text_;
  std::vector<Line> keys_;
};

void add_body(Lines& lines, const NewScene& scene, const NewBody& body, const fs::path& file,
              bool is_slider, double frequency) {
  const Material& material = *body.material;
  const bool is_areal = scene.kind == SceneKind::areal;
  lines.section(is_slider ? "slider" : "resonator",
                is_slider ? "the upper body, which slides"
                          : "the lower body: the level is that of its vibration");
  lines.key("support", is_slider ? "\"free\"" : "\"pinned\"",
            is_slider  ? is_areal ? "it can rise and tilt; or \"rigid\" at an imposed scene.gap"
                                  : "it can rise and tilt; or \"pinned\" at an imposed scene.gap"
            : is_areal ? "all edges are held and can turn"
                       : "both ends are held and can turn; or \"free\"");
  lines.key("length", body.length.toml, "along the sliding direction");
  lines.key("width", body.width.toml, "across");
  lines.key("thickness", body.thickness.toml);
  const std::string source = fmt::format("{}, typical: {}", material.name, material.source);
  const bool bends = !is_areal || !is_slider;  // a block does not
  if (bends) lines.key("young", fmt::format("\"{:g} GPa\"", material.young * 1e-9), source);
  lines.key("density", fmt::format("\"{:g} g/cm^3\"", material.density * 1e-3),
            bends ? std::string() : source);
  if (bends) {
    lines.key("poisson", fmt::format("{:g}", material.poisson));
    lines.key("damping", scene.damping.toml, damping_comment(material));
    lines.key("max_frequency", frequency_text(frequency), "keep the modes up to here");
  }
  if (is_slider) lines.key("load", scene.load, "\"weight\": its own; \"2 weight\"; or \"5 N\"");
  lines.key("surface", face_text(body, file, is_slider ? 1 : 2, scene.slider.width.value),
            face_comment(body.face));
}

/// Contact, time and output. `highest` [Hz]: of the resonator's modes.
void add_rest(Lines& lines, const NewScene& scene, double highest) {
  const bool is_areal = scene.kind == SceneKind::areal;
  lines.section("contact", "");
  lines.key("law", "\"penalty\"");
  if (is_areal)
    lines.key("stiffness", fmt::format("{:.2g}", scene.point_kappa),
              "Pa/m: about that of Hertz's point contacts, see 'ra2d plan'");
  else
    lines.key("stiffness", "\"hertz\"", "of the materials; or a number, such as \"4 MPa/um\"");
  lines.section("time", "");
  lines.key("scheme", "\"adaptive\"", "steps of any length, to the tolerance");
  lines.key("tolerance", "1e-6", "error of a step; with 1e-7 the level should stay");
  lines.section("output", "");
  lines.key("rate", frequency_text(std::max(usual_rate, 4 * highest)), "samples a second");
  const double probe_x = 0.4e3 * scene.resonator.length.value,
               probe_y = 0.4e3 * scene.resonator.width.value;  // mm
  lines.key("probes",
            is_areal ? fmt::format("[[\"{:.4g} mm\", \"{:.4g} mm\"]]", probe_x, probe_y)
                     : fmt::format("[\"{:.4g} mm\"]", probe_x),
            "places on the resonator that are recorded");
}

}  // namespace

std::span<const NewSceneQuestion> new_scene_questions() { return all_questions; }

NewScene usual_new_scene(SceneKind kind) {
  NewScene scene;
  scene.kind = kind;
  for (const NewSceneQuestion& question : all_questions) question.take(scene, question.usual);
  return scene;
}

std::string new_scene_text(const NewScene& scene, const fs::path& file) {
  const double path = free_path(scene);
  if (!(path > 0))
    throw RequestError(
        fmt::format("the slider, {:g} m long, is not shorter than the resonator, {:g} "
                    "m: there is no room to slide",
                    scene.slider.length.value, scene.resonator.length.value));
  if (scene.resonator.face.kind == NewFace::Kind::flat &&
      scene.slider.face.kind == NewFace::Kind::flat)
    throw RequestError(both_flat);
  GivenNumber duration = scene.duration;
  if (!(duration.value > 0)) {
    duration.value =
        round_down(std::min(longest_new_run, share_of_path * path / scene.speed.value));
    duration.toml = duration.value < 1 ? fmt::format("\"{:g} ms\"", duration.value * 1e3)
                                       : fmt::format("\"{:g} s\"", duration.value);
  }
  const bool is_areal = scene.kind == SceneKind::areal;
  const double start = (path - scene.speed.value * duration.value) / 2;
  const double highest = highest_frequency(
      spec_of(scene.resonator, Support::pinned, is_areal ? BodyKind::plate : BodyKind::beam),
      fewest_modes, most_resonator_modes);
  const double spacing = is_areal ? spacing_of_new_areal_scene(scene) : spacing_of_new_scene(scene);
  const double highest_of_slider =
      highest_frequency(spec_of(scene.slider, Support::free), 0, most_slider_modes);
  const std::string name = printable(file.filename().string());

  Lines lines;
  lines.section("scene", "");
  lines.key("name", toml_string(printable(file.stem().string())), "title of the report");
  if (is_areal) lines.key("kind", "\"areal\"", "a plate, a block and height maps");
  lines.key("duration", duration.toml, "simulated time");
  lines.key("speed", scene.speed.toml, "of the slider, constant");
  lines.key("start", fmt::format("\"{:.4g} mm\"", start * 1e3),
            "where its left end begins: it slides over the middle");
  lines.key("spacing", fmt::format("\"{:.4g} um\"", spacing * 1e6),
            "between two nodes; with half of it the level should stay");
  if (is_areal && scene.row_spacing > 0) {
    const double rows = row_spacing_of_new_scene(scene, spacing);
    lines.key("spacing_y", fmt::format("\"{:.4g} um\"", rows * 1e6),
              rows > scene.row_spacing * (1 + 1e-9)
                  ? "between two rows; contacts ask for less: see 'ra2d plan'"
                  : "between two rows: contacts are a few rows wide");
    lines.key("faces", "\"smooth\"", "contact is integrated along splines");
  }
  add_body(lines, scene, scene.resonator, file, false, highest);
  add_body(lines, scene, scene.slider, file, true, highest_of_slider);
  add_rest(lines, scene, highest);
  return fmt::format(
             "# A slider of {0} on a resonator of {1}, made by 'ra2d new'.\n"
             "#   ra2d plan {2}    # what is computed, and its cost\n"
             "#   ra2d run {2}     # simulates, and writes the result\n"
             "# Change first: damping, surface and load, on which the level rests most.\n"
             "# A number is in SI units, or a text with its unit. docs/scene.md has every key.\n",
             scene.slider.material->name, scene.resonator.material->name, name) +
         lines.text();
}

}  // namespace ra2d
