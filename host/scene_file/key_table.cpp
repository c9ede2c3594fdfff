// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/key_table.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "host/scene/schemes.hpp"
#include "host/surface/form.hpp"
#include "host/surface/height_map.hpp"
#include "host/surface/profile.hpp"

namespace ra2d::keys {
namespace {

constexpr Range air_celsius{-50, 100, true, "a number in [-50, 100)"};
constexpr Range air_pascal{1e4, 1e6, true, "a number in [1e4, 1e6)"};
constexpr Range hurst_exponent{0, 1, false, "a number in (0, 1)"};
constexpr Range poisson_ratio{-1, 0.5 + std::numeric_limits<double>::epsilon(), false,
                              "a number over -1, at most 0.5 (of a plate below 0.5)"};
constexpr std::int64_t most_modes_of_a_body = 1'000'000;
constexpr std::int64_t most_profiles = 100'000'000;  // in a file
constexpr std::int64_t largest_seed = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t longest_path = 4096;  // bytes, of a file that the system opens

// ---- what keys depend on

bool is_elastic(const BodySpec& body) { return body.support != Support::rigid; }
/// Of a block: it moves, and does not bend.
bool bends(const BodySpec& body) { return is_elastic(body) && body.kind != BodyKind::block; }
bool has_spring(const ContactSettings& contact) { return contact.law == ContactLaw::penalty; }
bool has_fixed_steps(const TimeSettings& time) { return !is_adaptive(time); }
template <SurfaceKind kind>
bool is(const SurfaceSpec& surface) {
  return surface.kind == kind;
}

/// A reason, or none.
std::string unless(bool is_used, const std::string& reason) { return is_used ? "" : reason; }

std::string of_elastic_body(const BodySpec& body, const Scene&) {
  return unless(is_elastic(body), "the body is rigid");
}
std::string of_bent_body(const BodySpec& body, const Scene& scene) {
  const std::string rigid = of_elastic_body(body, scene);
  return rigid.empty() ? unless(bends(body), "a block does not bend") : rigid;
}
std::string of_bent_body_or_hertz(const BodySpec& body, const Scene& scene) {
  return takes_hertz(scene.contact) ? "" : of_bent_body(body, scene);
}
std::string of_plate_or_hertz(const BodySpec& body, const Scene& scene) {
  if (body.kind == BodyKind::plate) return of_elastic_body(body, scene);
  return unless(takes_hertz(scene.contact), "only contact.stiffness = \"hertz\" takes it");
}
std::string of_areal_scene(const Scene&, const Scene& scene) {
  return unless(scene.kind == SceneKind::areal, "the scene is plane");
}

template <SurfaceKind kind>
std::string of_kind(const SurfaceSpec& surface, const Scene&) {
  return unless(surface.kind == kind,
                fmt::format("the kind is \"{}\"", surface_kinds.name(surface.kind)));
}
/// A key of random surfaces that some correlations do not take.
template <bool (*takes)(Correlation)>
std::string of_correlation(const SurfaceSpec& surface, const Scene& scene) {
  const std::string other_kind = of_kind<SurfaceKind::gaussian>(surface, scene);
  if (!other_kind.empty()) return other_kind;
  return unless(takes(surface.correlation),
                fmt::format("the correlation is \"{}\"", correlations.name(surface.correlation)));
}
bool is_self_affine(Correlation c) { return c == Correlation::self_affine; }
bool is_not_self_affine(Correlation c) { return c != Correlation::self_affine; }
bool is_not_gaussian(Correlation c) { return c != Correlation::gaussian; }

std::string of_spring(const ContactSettings& contact, const Scene&) {
  return unless(has_spring(contact), "multipliers have no spring");
}
std::string of_penalty_and_backward_euler(const TimeSettings& time, const Scene& scene) {
  if (!has_spring(scene.contact)) return "multipliers are found with the end of the step";
  if (is_adaptive(time)) return "adaptive takes the force as it changes";
  return unless(time.scheme == SchemeKind::backward_euler,
                fmt::format("{} takes the force at its stages", schemes.name(time.scheme)));
}
std::string of_fixed_steps(const TimeSettings& time, const Scene&) {
  return unless(has_fixed_steps(time), "adaptive finds its steps");
}
std::string of_adaptive(const TimeSettings& time, const Scene&) {
  return unless(is_adaptive(time), fmt::format("{} takes fixed steps", schemes.name(time.scheme)));
}
std::string of_limited_steps(const TimeSettings& time, const Scene&) {
  return unless(has_fixed_steps(time), "adaptive has no limit of stability");
}

// ---- values that only one key has

/// A length, or "inf".
Value<SurfaceSpec> rsm_along_y() {
  const std::string infinite_word = "inf";
  Value<SurfaceSpec> value = number(&SurfaceSpec::rsm_y, positive, "m");
  value.type += ", m, or `\"inf\"`";
  value.read = [=](Reader& in, const std::string& key, Need need, SurfaceSpec& surface) {
    const bool is_infinite = in.says(key, infinite_word);
    surface.rsm_y = in.number(key, positive, "m", need, infinite_word);
    if (is_infinite) surface.rsm_y = infinite;
  };
  value.toml = [=](const SurfaceSpec& surface, const Scene&) {
    return *surface.rsm_y == infinite ? toml_string(infinite_word) : toml_number(*surface.rsm_y);
  };
  return value;
}

/// Of a profile, or of a map.
bool is_form(const std::string& form) {
  return understand_form(form).has_value() || understand_map_form(form).has_value();
}

/// The path of a profile. It is kept as it was written, and written as an absolute one.
Value<SurfaceSpec> profile_path() {
  Value<SurfaceSpec> value{"text", "", "", {}, {}, {}, {}};
  value.read = [](Reader& in, const std::string& key, Need need, SurfaceSpec& surface) {
    const auto path = in.text(key, "the path of a profile, a text", need);
    if (!path) return;
    surface.path = *path;
    if (surface.kind != SurfaceKind::file) return;
    if (path->empty()) in.fault(key, "empty: expected the path of a profile");
    if (path->size() >= longest_path)
      in.fault(key, toml_string(shortened(*path)) +
                        " cannot be the name of a file: expected the path of a profile");
  };
  value.toml = [](const SurfaceSpec& surface, const Scene& scene) {
    if (surface.path.empty()) return toml_string("");
    return toml_string(
        absolute(scene.file.parent_path() / surface.path).lexically_normal().string());
  };
  value.is_given = [](const SurfaceSpec& surface) { return !surface.path.empty(); };
  return value;
}

/// Always written as a number. A comment says that it comes from "hertz".
Value<ContactSettings> contact_stiffness() {
  Value<ContactSettings> value = number_or_word(
      &ContactSettings::stiffness, &ContactSettings::is_hertz, "hertz", positive, "Pa/m");
  value.toml = [](const ContactSettings& contact, const Scene&) {
    return toml_number(contact.stiffness) +
           (takes_hertz(contact) ? "  # \"hertz\": of the young, poisson and width of both bodies"
                                 : "");
  };
  value.is_given = [](const ContactSettings& contact) { return contact.stiffness != 0; };
  return value;
}

/// In newtons, or as a multiple of the slider's weight.
Value<BodySpec> slider_load() {
  const std::string weight = "weight";
  Value<BodySpec> value =
      number_or_word(&BodySpec::load, &BodySpec::load_is_weight, weight, any_number, "N");
  value.type += " (`\"2 weight\"`)";
  const auto read_force = value.read;
  value.read = [=](Reader& in, const std::string& key, Need need, BodySpec& body) {
    const std::optional<double> weights = in.multiple(key, weight);
    if (!weights) return read_force(in, key, need, body);
    in.text(key, "", need);
    body.load_is_weight = true;
    body.load_weights = *weights;
    if (!(*weights >= smallest_size && *weights <= largest_size))
      in.fault(key, fmt::format("{:g} times the weight is not allowed: expected a number > 0 of "
                                "weights (a force that lifts is one in N, such as \"-5 N\")",
                                *weights));
  };
  value.toml = [=](const BodySpec& body, const Scene&) {
    if (!body.load_is_weight) return toml_number(body.load);
    return toml_string(body.load_weights == 1 ? weight
                                              : fmt::format("{} {}", body.load_weights, weight));
  };
  return value;
}

template <class T>
Value<SurfaceSpec> prepared(const T& value) {
  return within(&SurfaceSpec::prepared, value);
}

// ---- what is wrong between the keys of one table

void check_body_keys(Reader& in, const BodySpec& body, bool is_certain) {
  if (bends(body) && is_certain) in.one_of("max_frequency", "modes");
}

void check_surface_keys(Reader& in, const SurfaceSpec& surface, bool) {
  if (!is<SurfaceKind::gaussian>(surface)) return;
  if (surface.exact == Exactly::rq_and_rsm && !in.has("rsm"))
    in.fault("exact", "\"rq+rsm\" needs `rsm`");
  if (surface.correlation != Correlation::self_affine)
    return in.one_of("rsm", "correlation_length");
  if (!in.has("hurst"))
    in.fault("hurst", "missing: a self-affine surface needs its Hurst exponent");
  const int count = in.has("longest") + in.has("shortest") + in.has("rsm");
  if (count != 2)
    in.fault("longest", fmt::format("{} of `longest`, `shortest` and `rsm` stand: expected two of "
                                    "them, the third follows",
                                    count));
}

}  // namespace

bool takes_hertz(const ContactSettings& contact) { return contact.is_hertz && has_spring(contact); }

const Keys<Scene>& of_scene() {
  static const Keys<Scene> keys{
      {{"name", text(&Scene::name, "text"), has_default<Scene>("the file's name"),
        "title of the report"},
       {"kind", choice(&Scene::kind, scene_kinds, SceneKind::plane), may_stand<Scene>(),
        "beams, and every asperity is a ridge as wide as the slider; or "
        "[a plate, a block and height maps](#areal-scenes)"},
       {"duration", number(&Scene::duration, positive, "s"), required<Scene>(), "simulated time"},
       {"speed", number(&Scene::speed, not_negative, "m/s"), required<Scene>(),
        "sliding speed of the slider, imposed and constant"},
       {"start", number(&Scene::start, any_number, "m"), required<Scene>(),
        "where the slider's left end stands on the resonator at t = 0. The slider must stay on the "
        "resonator until the end"},
       {"gap", number_or_word(&Scene::gap, "touching", any_number, "m"), has_default<Scene>(),
        "distance between the mean lines of the undeformed faces. `\"touching\"` is the smallest "
        "distance without overlap at t = 0"},
       {"spacing", number(&Scene::spacing, positive, "m"), required<Scene>(),
        "distance between two nodes, on both bodies"},
       {"spacing_y",
        number(&Scene::spacing_y, positive, "m"),
        may_stand<Scene>("`spacing`"),
        "distance between two rows of nodes, on both bodies",
        {"areal", of_areal_scene}},
       {"side",
        number(&Scene::side, any_number, "m"),
        may_stand<Scene>("the slider in the middle"),
        "where the slider's side stands on the resonator",
        {"areal", of_areal_scene}},
       {"faces", choice(&Scene::faces, face_choices, Faces::linear),
        has_default<Scene>("`\"smooth\"`, of areal scenes `\"linear\"`"),
        "how a face goes from node to node: straight, with contact at the nodes, as in the paper; "
        "or "
        "as a [spline](schemes.md#smooth-faces), along which contact is integrated"},
       {"initial", choice(&Scene::initial, initial_states, Initial::rest),
        has_default<Scene>("`\"static\"` where there is an equilibrium, else `\"rest\"`"),
        "how the bodies stand at t = 0"}}};
  return keys;
}

const Keys<Peak>& of_peak() {
  static const Keys<Peak> keys{
      {{"at", number(&Peak::at, any_number, "m"), required<Peak>(), "place along the body"},
       {"height", number(&Peak::height, any_number, "m"), required<Peak>(), "height of its tip"},
       {"half_width", number(&Peak::half_width, positive, "m"), required<Peak>(),
        "half of the width at the foot"}}};
  return keys;
}

namespace {

using S = SurfaceSpec;

std::vector<Key<S>> file_keys() {
  using F = FilePreparation;
  const Use<S> file{"`\"file\"`", of_kind<SurfaceKind::file>};
  return {
      {"path", profile_path(), required_if(is<SurfaceKind::file>, "required"),
       "a measured profile, see below", file},
      {"x_unit", prepared(choice(&F::x_unit, file_units)), may_stand<S>("the file's own"),
       "unit of the places in a text", file},
      {"z_unit", prepared(choice(&F::z_unit, file_units)), may_stand<S>("the file's own"),
       "unit of the heights in a text", file},
      {"spacing", prepared(number(&F::spacing, positive, "m")), may_stand<S>(),
       "step from height to height, of a file that has none", file},
      {"spacing_y", prepared(number(&F::spacing_y, positive, "m")), may_stand<S>("`spacing`"),
       "of a map: step from row to row, of a file that has none", file},
      {"offset_x", prepared(number(&F::offset_x, any_number, "m")), may_stand<S>("0"),
       "of a map: where on the body it begins", file},
      {"offset_y", prepared(number(&F::offset_y, any_number, "m")),
       may_stand<S>("on the resonator `scene.side`, else 0"), "the same across", file},
      {"decimal", prepared(choice(&F::decimal, file_decimals)), may_stand<S>("from the file"),
       "the decimal mark, where a text is ambiguous", file},
      {"row", prepared(integer(&F::row, 1, most_profiles)), may_stand<S>(),
       "which profile of an areal file is meant", file},
      {"column", prepared(integer(&F::column, 1, most_profiles)), may_stand<S>(),
       "the same across; of a text, which column has the heights", file},
      {"fill",
       prepared(text(&F::fill, "`\"linear:WIDTH\"`", "linear:WIDTH, with a width in metres",
                     [](const std::string& fill) { return to_fill_width(fill).has_value(); })),
       may_stand<S>("missing points are refused"),
       "straight lines through gaps of up to WIDTH metres", file},
      {"form",
       prepared(text(&F::form,
                     "`\"none\"`, `\"mean\"`, `\"line\"` (map: `\"plane\"`), `\"poly:N\"`",
                     "none, mean, line (of a map: plane) or poly:N with N from 0 to 10", is_form)),
       may_stand<S>("`\"none\"`"),
       "form that is taken off, by least squares; of a map in x and y together", file},
      {"cutoff_s", prepared(number(&F::cutoff_s, positive, "m")), may_stand<S>("no such filter"),
       "cut-off of the Gaussian filter against short waves", file},
      {"filter", prepared(choice(&F::filter, face_filters, FaceFilter::none)), may_stand<S>(),
       "`\"gaussian\"`: long waves are taken off. `\"none\"`, too, for a profile that its "
       "instrument has filtered",
       file},
      {"cutoff", prepared(number(&F::cutoff, positive, "m")), may_stand<S>("2.5e-3"),
       "of `filter = \"gaussian\"`", file},
      {"short", prepared(choice(&F::when_short, short_profiles, ShortProfile::refuse)),
       may_stand<S>(),
       "what is done with a profile that is shorter than the beam, or a map smaller than the body. "
       "Only maps are mirrored",
       file}};
}

std::vector<Key<S>> random_keys() {
  const Use<S> gaussian{"`\"gaussian\"`", of_kind<SurfaceKind::gaussian>};
  const Use<S> self_affine{"self-affine", of_correlation<is_self_affine>};
  const Use<S> not_self_affine{"not self-affine", of_correlation<is_not_self_affine>};
  const Use<S> not_gaussian{"exponential, self-affine", of_correlation<is_not_gaussian>};
  return {{"rq", number(&S::rq, positive, "m"), required_if(is<SurfaceKind::gaussian>, "required"),
           "root mean square height over the beam's length", gaussian},
          {"rsm", number(&S::rsm, positive, "m"), may_stand<S>("this or `correlation_length`"),
           "mean spacing of the profile elements, on average over many profiles", gaussian},
          {"rsm_y", rsm_along_y(), may_stand<S>("`rsm`"),
           "of a map: `rsm` along y. `\"inf\"`: every row is the profile that a plane scene has",
           gaussian},
          {"correlation_length", number(&S::correlation_length, positive, "m"), may_stand<S>(),
           "distance at which the autocorrelation has fallen to 1/e", not_self_affine},
          {"correlation", choice(&S::correlation, correlations, Correlation::gaussian),
           may_stand<S>(), "how the correlation of the heights falls with distance", gaussian},
          {"hurst", number(&S::hurst, hurst_exponent, no_unit), may_stand<S>("required"),
           "Hurst exponent", self_affine},
          {"longest", number(&S::longest, positive, "m"),
           may_stand<S>("two of `longest`, `shortest` and `rsm`"), "its longest wave", self_affine},
          {"shortest", number(&S::shortest, positive, "m"),
           may_stand<S>("exponential: `correlation_length`/50"), "its shortest wave", not_gaussian},
          {"skewness", number(&S::skewness, any_number, no_unit), may_stand<S>("0"),
           "of the heights; 0 is that of normal ones", gaussian},
          {"kurtosis", number(&S::kurtosis, positive, no_unit), may_stand<S>("3"),
           "of the heights; 3 is that of normal ones", gaussian},
          {"exact", choice(&S::exact, exact_choices, Exactly::rq), may_stand<S>(),
           "what holds exactly over the beam's length; the rest holds in expectation", gaussian},
          {"seed", integer(&S::seed, 0, largest_seed),
           required_if(is<SurfaceKind::gaussian>, "required"),
           "a seed means one profile, on every platform and at every `scene.spacing`", gaussian}};
}

}  // namespace

const Keys<SurfaceSpec>& of_surface() {
  static const Keys<S> keys = [] {
    Keys<S> all{{{"kind", choice(&S::kind, surface_kinds, SurfaceKind::flat), required<S>(),
                  "how the face is given"},
                 {"peaks",
                  tables(&S::peaks, of_peak()),
                  required_if(is<SurfaceKind::peaks>, "required"),
                  "raised cosines on a flat face, `{ at, height, half_width }` in m: place along "
                  "the body, height, half of the width at the foot",
                  {"`\"peaks\"`", of_kind<SurfaceKind::peaks>}}},
                check_surface_keys};
    for (const auto& more : {file_keys(), random_keys()})
      all.list.insert(all.list.end(), more.begin(), more.end());
    return all;
  }();
  return keys;
}

const Keys<MovingForce>& of_moving_force() {
  using M = MovingForce;
  static const Keys<M> keys{
      {{"force", number(&M::force, any_number, "N"), required<M>(), "positive upwards"},
       {"speed", number(&M::speed, not_negative, "m/s"), required<M>(), "along the resonator"},
       {"start", number(&M::start, any_number, "m"), required<M>(), "where it stands at t = 0"},
       {"y",
        number(&M::y, any_number, "m"),
        may_stand<M>("required in areal scenes"),
        "across the resonator",
        {"areal", nullptr}}}};
  return keys;
}

namespace {

/// The keys of both bodies, and those that one of them has.
Keys<BodySpec> body_with(Key<BodySpec> own) {
  using B = BodySpec;
  const Use<B> elastic{"", of_elastic_body};
  const Standing<B> of_mass = required_if(is_elastic, "required, but for rigid bodies");
  const Standing<B> of_material = required_if(bends, "required, but for rigid bodies and blocks");
  const Use<B> bent{"", of_bent_body};
  Keys<B> keys{
      {{"support", choice(&B::support, supports, Support::pinned), required<B>(), "see below"},
       {"length", number(&B::length, positive, "m"), required<B>(), "along the sliding direction"},
       {"thickness", number(&B::thickness, positive, "m"), of_mass, "height of the cross section",
        elastic},
       {"width", number(&B::width, positive, "m"), required<B>(),
        "across. The contact strip has the smaller of the two widths"},
       {"young",
        number(&B::young, positive, "Pa"),
        of_material,
        "Young's modulus",
        {"", of_bent_body_or_hertz}},
       {"density", number(&B::density, positive, "kg/m^3"), of_mass, "", elastic},
       {"poisson",
        number(&B::poisson, poisson_ratio, no_unit),
        may_stand<B>("0.3"),
        "Poisson's ratio. Only plates and `contact.stiffness = \"hertz\"` take it",
        {"", of_plate_or_hertz}},
       {"damping", number(&B::damping, ratio, no_unit), of_material, "damping ratio of each mode",
        bent},
       {"max_frequency", number(&B::max_frequency, positive, "Hz"),
        may_stand<B>("this or `modes`, but for rigid bodies and blocks"),
        "keep the elastic modes up to this frequency", bent},
       {"modes", integer(&B::modes, 0, most_modes_of_a_body), may_stand<B>(),
        "keep this many elastic modes. 0: the body moves, but does not bend", bent},
       {"surface",
        table(&B::surface, of_surface(), "{ kind = \"flat\" }"),
        may_stand<B>(),
        "the rough face, see below",
        {"", [](const B& body,
                const Scene& scene) { return unused_keys(of_surface(), body.surface, scene); }}}},
      check_body_keys};
  keys.list.push_back(std::move(own));
  return keys;
}

}  // namespace

const Keys<BodySpec>& of_resonator() {
  static const Keys<BodySpec> keys = [] {
    Value<BodySpec> forces = tables(&BodySpec::moving_forces, of_moving_force());
    forces.toml = {};  // sections of their own
    return body_with({"moving_force",
                      forces,
                      may_stand<BodySpec>("none"),
                      "see below",
                      {"resonator", of_elastic_body}});
  }();
  return keys;
}

const Keys<BodySpec>& of_slider() {
  static const Keys<BodySpec> keys =
      body_with({"load",
                 slider_load(),
                 has_default<BodySpec>("0"),
                 "pressed evenly onto the slider, towards the resonator",
                 {"slider", of_elastic_body}});
  return keys;
}

const Keys<ContactSettings>& of_contact() {
  using C = ContactSettings;
  static const Keys<C> keys{
      {{"law", choice(&C::law, contact_laws, ContactLaw::penalty), has_default<C>(), "see below"},
       {"stiffness",
        contact_stiffness(),
        required_if(has_spring, "required under penalty"),
        "the penalty parameter kappa. `\"hertz\"`: that of the bodies' "
        "[materials](schemes.md#what-kappa). The number that it takes stands in the scene that a "
        "result keeps",
        {"penalty", of_spring}}}};
  return keys;
}

const Keys<TimeSettings>& of_time() {
  using T = TimeSettings;
  static const Keys<T> keys{
      {{"scheme", choice(&T::scheme, schemes, SchemeKind::backward_euler), has_default<T>(),
        "the paper's six, two with the modes in closed form, and steps of any length; "
        "see [schemes.md](schemes.md)"},
       {"contact_force",
        choice(&T::contact_force, force_times, ForceTime::old_time),
        has_default<T>(),
        "take the contact force at the beginning or at the end of the step. With `\"new\"` the "
        "scheme is fully implicit, but for moving forces",
        {"`backward-euler` under penalty", of_penalty_and_backward_euler}},
       {"step",
        number(&T::step, positive, "s"),
        required_if(has_fixed_steps, "required"),
        "length of a step. A step beyond the scheme's limit of stability is refused",
        {"all but `adaptive`", of_fixed_steps}},
       {"tolerance",
        number(&T::tolerance, positive, no_unit),
        may_stand<T>("1e-8"),
        "error of a step, relative to the motion, from 1e-13 to 1e-2",
        {"`adaptive`", of_adaptive}},
       {"nodes", choice(&T::nodes, node_choices, Nodes::candidates), has_default<T>(),
        "which nodes are evaluated. The answer is the same, bit for bit; `\"all\"` is far slower"},
       {"force",
        boolean(&T::force),
        may_stand<T>(),
        "`true`: run a step beyond the limit of stability all the same. The report and the file "
        "say so",
        {"all but `adaptive`", of_limited_steps}}}};
  return keys;
}

const Keys<MicrophonePlace>& of_microphone() {
  using M = MicrophonePlace;
  static const Keys<M> keys{
      {{"x", number(&M::x, any_number, "m"), required<M>(), "along the resonator"},
       {"y", number(&M::y, any_number, "m"), required<M>(), "across, from its edge"},
       {"z", number(&M::z, any_number, "m"), required<M>(), "above it"}}};
  return keys;
}

const Keys<AirSettings>& of_air() {
  using A = AirSettings;
  static const Keys<A> keys{{{"temperature", number(&A::celsius, air_celsius, no_unit, 20.0),
                              may_stand<A>(), "degrees Celsius"},
                             {"pressure", number(&A::pascal, air_pascal, "Pa", 101'325.0),
                              may_stand<A>(), "of the still air"}}};
  return keys;
}

const Keys<OutputSettings>& of_output() {
  using O = OutputSettings;
  static const Keys<O> keys{
      {{"rate", number(&O::rate, positive, "Hz", 100e3), has_default<O>(),
        "samples are taken at t = j/rate. With fixed steps at most one a step; at most 1e11 in a "
        "run. `ra2d run` begins nothing that the disk has no room for"},
       {"probes", places(&O::probes, "m"), has_default<O>(),
        "places on the resonator where displacement and velocity are written; in areal scenes "
        "pairs `[x, y]`"},
       {"slider_probes", places(&O::slider_probes, "m"), has_default<O>(),
        "such places on the slider"},
       {"microphones", tables(&O::microphones, of_microphone()), may_stand<O>("none"),
        "places above the resonator, `{ x, y, z }` in m, whose [sound](sound.md) ends the report"},
       {"from", number(&O::from, not_negative, "s", 0.0), has_default<O>(),
        "level, shock statistics and the energy balance of the report begin here. Samples begin at "
        "0 all the same"},
       {"window", numbers(&O::window, "s"), may_stand<O>("the whole run"),
        "`[begin, end]`: samples are kept from begin on alone, and the run ends at end. "
        "[`ra2d run --zoom`](results.md#zoom) makes scenes with it"},
       {"modes", choice(&O::modes, kept_modes, KeptModes::all), may_stand<O>(),
        "`\"none\"`: the file lacks displacement and velocity of each mode, most of its bytes, and "
        "[what needs them](results.md#less-in-a-file)"},
       {"precision", choice(&O::precision, precisions, Precision::real64), may_stand<O>(),
        "of samples in the file. Everything is computed in double precision all the same"},
       {"compression", choice(&O::compression, compressions, Compression::none), may_stand<O>(),
        "of samples in the file, by HDF5, without loss"}}};
  return keys;
}

}  // namespace ra2d::keys
