// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene/scene.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/model/doubts.hpp"
#include "host/scene_file/key_facts.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

namespace ra2d {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// A small valid scene; the tests below count on its lines.
constexpr auto minimal = R"([scene]
duration = 0.1
speed = 0.5
start = 0.1
spacing = 1e-4
[resonator]
support = "pinned"
length = 0.3
thickness = 0.002
width = 0.2
young = 210e9
density = 7800
damping = 0.02
modes = 19
surface = { kind = "gaussian", rq = 8e-6, rsm = 1.5e-3, seed = 2 }
[slider]
support = "free"
length = 0.02
thickness = 0.02
width = 0.02
young = 210e9
density = 7800
damping = 0.02
max_frequency = 20e3
[contact]
stiffness = 1e15
[time]
step = 1e-6
)";

/// One change of a text: `from`, at its first place, becomes `to`; a `from` of nothing appends.
struct Change {
  std::string from, to;
};

std::string with(std::string text, const Change& change) {
  if (change.from.empty()) return text.append(change.to);
  const auto at = text.find(change.from);
  EXPECT_NE(at, std::string::npos) << "not in the text: " << change.from;
  return at == std::string::npos ? text : text.replace(at, change.from.size(), change.to);
}

/// The minimal scene with changes.
std::string scene_text(const std::vector<Change>& changes) {
  std::string text = minimal;
  for (const Change& change : changes) text = with(text, change);
  return text;
}

Scene parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_scene(text, "s.toml", overrides);
}

std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse(text, overrides);
  } catch (const RequestError& error) {
    return error.what();
  }
  return "accepted";
}

void expect_same(const SurfaceSpec& a, const SurfaceSpec& b) {
  EXPECT_EQ(a.kind, b.kind);
  ASSERT_EQ(a.peaks.size(), b.peaks.size());
  for (std::size_t i = 0; i < a.peaks.size(); ++i) {
    EXPECT_EQ(a.peaks[i].at, b.peaks[i].at);
    EXPECT_EQ(a.peaks[i].height, b.peaks[i].height);
    EXPECT_EQ(a.peaks[i].half_width, b.peaks[i].half_width);
  }
  EXPECT_EQ(a.path, b.path);
  EXPECT_EQ(a.prepared, b.prepared);
  EXPECT_EQ(a.rq, b.rq);
  EXPECT_EQ(a.rsm, b.rsm);
  EXPECT_EQ(a.correlation_length, b.correlation_length);
  EXPECT_EQ(a.correlation, b.correlation);
  EXPECT_EQ(a.hurst, b.hurst);
  EXPECT_EQ(a.longest, b.longest);
  EXPECT_EQ(a.shortest, b.shortest);
  EXPECT_EQ(a.skewness, b.skewness);
  EXPECT_EQ(a.kurtosis, b.kurtosis);
  EXPECT_EQ(a.exact, b.exact);
  EXPECT_EQ(a.seed, b.seed);
}

void expect_same(const BodySpec& a, const BodySpec& b) {
  EXPECT_EQ(a.support, b.support);
  EXPECT_EQ(a.length, b.length);
  EXPECT_EQ(a.thickness, b.thickness);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.young, b.young);
  EXPECT_EQ(a.density, b.density);
  EXPECT_EQ(a.poisson, b.poisson);
  EXPECT_EQ(a.damping, b.damping);
  EXPECT_EQ(a.max_frequency, b.max_frequency);
  EXPECT_EQ(a.modes, b.modes);
  expect_same(a.surface, b.surface);
  EXPECT_EQ(a.load_is_weight, b.load_is_weight);
  EXPECT_EQ(a.load, b.load);
  ASSERT_EQ(a.moving_forces.size(), b.moving_forces.size());
  for (std::size_t i = 0; i < a.moving_forces.size(); ++i) {
    EXPECT_EQ(a.moving_forces[i].force, b.moving_forces[i].force);
    EXPECT_EQ(a.moving_forces[i].speed, b.moving_forces[i].speed);
    EXPECT_EQ(a.moving_forces[i].start, b.moving_forces[i].start);
  }
}

void expect_same(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.file, b.file);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.duration, b.duration);
  EXPECT_EQ(a.speed, b.speed);
  EXPECT_EQ(a.start, b.start);
  EXPECT_EQ(a.gap, b.gap);
  EXPECT_EQ(a.spacing, b.spacing);
  EXPECT_EQ(a.initial, b.initial);
  expect_same(a.resonator, b.resonator);
  expect_same(a.slider, b.slider);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.contact.law, b.contact.law);
  EXPECT_EQ(a.contact.stiffness, b.contact.stiffness);
  EXPECT_EQ(a.contact.is_hertz, b.contact.is_hertz);
  EXPECT_EQ(a.time.scheme, b.time.scheme);
  EXPECT_EQ(a.time.contact_force, b.time.contact_force);
  EXPECT_EQ(a.time.step, b.time.step);
  EXPECT_EQ(a.time.tolerance, b.time.tolerance);
  EXPECT_EQ(a.time.nodes, b.time.nodes);
  EXPECT_EQ(a.time.force, b.time.force);
  EXPECT_EQ(a.output.rate, b.output.rate);
  EXPECT_EQ(a.output.probes, b.output.probes);
  EXPECT_EQ(a.output.slider_probes, b.output.slider_probes);
  EXPECT_EQ(a.output.from, b.output.from);
}

/// Reading the echo gives the scene again, and the echo is its own echo.
void expect_round_trip(const Scene& scene) {
  const std::string text = echo(scene);
  SCOPED_TRACE(text);
  const Scene again = parse_scene(text, scene.file);
  expect_same(again, scene);
  EXPECT_EQ(echo(again), text);
}

TEST(Scene, MinimalOneReadsWithDefaults) {
  const Scene s = parse(minimal);
  EXPECT_EQ(s.file, "s.toml");
  EXPECT_EQ(s.name, "");
  EXPECT_EQ(s.gap, std::nullopt);
  EXPECT_EQ(s.faces, Faces::smooth);
  EXPECT_EQ(s.initial, Initial::rest);
  EXPECT_EQ(s.slider.surface.kind, SurfaceKind::flat);
  EXPECT_FALSE(s.slider.load_is_weight);
  EXPECT_EQ(s.slider.load, 0);
  EXPECT_EQ(s.slider.poisson, std::nullopt);
  EXPECT_FALSE(s.contact.is_hertz);
  EXPECT_THAT(s.resonator.moving_forces, IsEmpty());
  EXPECT_EQ(s.contact.law, ContactLaw::penalty);
  EXPECT_EQ(s.time.scheme, SchemeKind::backward_euler);
  EXPECT_EQ(s.time.tolerance, std::nullopt);
  EXPECT_EQ(s.time.nodes, Nodes::candidates);
  EXPECT_EQ(s.output.rate, 100e3);
  EXPECT_THAT(s.output.probes, IsEmpty());
  EXPECT_EQ(s.output.from, 0);
}

TEST(Scene, ValuesArriveWhereTheyBelong) {
  const Scene s = parse(scene_text({
      {"duration = 0.1",
       "name = \"a \\\"b\\\"\"\ngap = 2e-5\ninitial = \"static\"\nduration = 0.1"},
      {"max_frequency = 20e3",
       "modes = 0\npoisson = 0.28\nload = \"weight\"\nsurface.kind = \"peaks\"\nsurface.peaks = [{ "
       "at = 0.01, "
       "height = "
       "-1e-5, half_width = 2e-4 }]"},
      {"stiffness", "law = \"penalty\"\nstiffness"},
      {"step", "scheme = \"backward-euler\"\nnodes = \"all\"\ntolerance = 1e-8\nstep"},
      {"",
       "[output]\nrate = 50_000\nprobes = [0, 0.15, 0.3]\n"
       "slider_probes = [0.02]\nfrom = 0.05\nmicrophones = [{ x = 0.1, y = \"20 cm\", z = -3 "
       "}]\n[air]\ntemperature = 15\npressure = \"900 hPa\"\n[[resonator.moving_force]]\nforce = "
       "10\n"
       "speed = 20\nstart = -1\n"},
  }));
  EXPECT_EQ(s.name, "a \"b\"");
  EXPECT_EQ(s.output.microphones, (std::vector<MicrophonePlace>{{0.1, 0.2, -3}}));
  EXPECT_EQ(s.air.celsius, 15);
  EXPECT_EQ(s.air.pascal, 9e4);
  EXPECT_EQ(s.gap, 2e-5);
  EXPECT_EQ(s.initial, Initial::statics);
  EXPECT_EQ(s.duration, 0.1);
  EXPECT_EQ(s.speed, 0.5);
  EXPECT_EQ(s.start, 0.1);
  EXPECT_EQ(s.spacing, 1e-4);
  EXPECT_EQ(s.resonator.support, Support::pinned);
  EXPECT_EQ(s.resonator.length, 0.3);
  EXPECT_EQ(s.resonator.thickness, 0.002);
  EXPECT_EQ(s.resonator.width, 0.2);
  EXPECT_EQ(s.resonator.young, 210e9);
  EXPECT_EQ(s.resonator.density, 7800);
  EXPECT_EQ(s.resonator.damping, 0.02);
  EXPECT_EQ(s.resonator.modes, 19);
  EXPECT_EQ(s.resonator.max_frequency, std::nullopt);
  EXPECT_EQ(s.resonator.surface.kind, SurfaceKind::gaussian);
  EXPECT_EQ(s.resonator.surface.rq, 8e-6);
  EXPECT_EQ(s.resonator.surface.rsm, 1.5e-3);
  EXPECT_EQ(s.resonator.surface.correlation_length, std::nullopt);
  EXPECT_EQ(s.resonator.surface.seed, 2);
  ASSERT_EQ(s.resonator.moving_forces.size(), 1);
  EXPECT_EQ(s.resonator.moving_forces[0].force, 10);
  EXPECT_EQ(s.resonator.moving_forces[0].speed, 20);
  EXPECT_EQ(s.resonator.moving_forces[0].start, -1);
  EXPECT_EQ(s.slider.support, Support::free);
  EXPECT_EQ(s.slider.modes, 0);
  EXPECT_EQ(s.slider.poisson, 0.28);
  EXPECT_TRUE(s.slider.load_is_weight);
  ASSERT_EQ(s.slider.surface.peaks.size(), 1);
  EXPECT_EQ(s.slider.surface.peaks[0].at, 0.01);
  EXPECT_EQ(s.slider.surface.peaks[0].height, -1e-5);
  EXPECT_EQ(s.slider.surface.peaks[0].half_width, 2e-4);
  EXPECT_EQ(s.contact.stiffness, 1e15);
  EXPECT_EQ(s.time.step, 1e-6);
  EXPECT_EQ(s.time.tolerance, 1e-8);
  EXPECT_EQ(s.time.nodes, Nodes::all);
  EXPECT_EQ(s.output.rate, 50e3);
  EXPECT_THAT(s.output.probes, ElementsAre(0, 0.15, 0.3));
  EXPECT_EQ(s.output.from, 0.05);
  EXPECT_THAT(s.output.slider_probes, ElementsAre(0.02));
}

/// One fault each: a changed scene, and what its only message must say.
struct Refused {
  std::string name;
  std::vector<Change> changes;
  std::vector<std::string> says;
};

void PrintTo(const Refused& refused, std::ostream* out) { *out << refused.name; }

class SceneRefuses : public testing::TestWithParam<Refused> {};

TEST_P(SceneRefuses, WithOneMessage) {
  const std::string message = refusal(scene_text(GetParam().changes));
  EXPECT_THAT(message, StartsWith("s.toml: 1 fault\n"));
  for (const std::string& part : GetParam().says) EXPECT_THAT(message, HasSubstr(part));
}

std::string peaks_of(const std::string& list) {
  return "surface = { kind = \"peaks\", peaks = [" + list + "] }";
}

const std::string gaussian = "surface = { kind = \"gaussian\", rq = 8e-6, rsm = 1.5e-3, seed = 2 }";
const Change rigid_slider{"support = \"free\"", "support = \"rigid\""};
const Change static_start{"start", "initial = \"static\"\nstart"};
const Change free_resonator{"\"pinned\"", "\"free\""};

const std::string all_schemes =
    "\"explicit-euler\", \"midpoint\", \"backward-euler\", \"heun\", \"rk4\", \"rk8\", "
    "\"exact\", \"gautschi\" or \"adaptive\"";
const Change adaptive{"step = 1e-6", "scheme = \"adaptive\""};
const Change multiplier{"stiffness = 1e15", "law = \"multiplier\""};

const std::vector<Refused> refused_scenes{
    // not TOML
    {"Result", {{"[scene]", "\x89HDF\r\n[scene]"}}, {"s.toml: an HDF5 file, such as a result"}},
    {"Syntax", {{"speed = 0.5", "speed = = 0.5"}}, {"s.toml:3:", "not TOML"}},
    {"BadHeader", {{"[scene]", "[[[scene]]]"}}, {"s.toml:1:", "not TOML"}},
    {"KeyTwice",
     {{"speed = 0.5", "speed = 1\nspeed = 1"}},
     {"s.toml:4:", "not TOML", "'speed', which stands in line 3 already: keep one of the two"}},
    {"SectionTwice",
     {{"[contact]", "[scene]\n[contact]"}},
     {"not TOML", "'scene', which stands in line 1 already"}},
    // unknown
    {"KeyNear",
     {{"rsm =", "rms ="}, {"seed = 2", "seed = 2, rsm = 1e-3"}},
     {"\ns.toml:15: resonator.surface.rms: unknown key (did you mean `rsm`?)"}},
    {"KeyFar",
     {{"step", "colour = 3\nstep"}},
     {"\ns.toml:28: time.colour: unknown key: expected `scheme`, `contact_force`, "
      "`step`, `tolerance`, `nodes` or `force`"}},
    {"KeyOfAnotherSection",
     {{"step", "rate = 3\nstep"}},
     {"\ns.toml:28: time.rate: unknown key (did you mean `output.rate`?)"}},
    {"KeyOutsideSections",
     {{"[scene]", "duration = 3\n[scene]"}},
     {"\ns.toml:1: duration: unknown key (did you mean `scene.duration`?)"}},
    {"KeyOfPeak",
     {{gaussian, peaks_of("{ at = 0.1, height = 1e-6, halfwidth = 1, half_width = 1e-3 }")}},
     {"s.toml:15: resonator.surface.peaks[0].halfwidth: unknown key (did you mean `half_width`?)"}},
    {"QuotedKey", {{"step", "\"a\\nb\" = 3\nstep"}}, {"s.toml:28: time.\"a\\nb\": unknown key"}},
    {"Section",
     {{"", "[outptu]\nrate = 3\n"}},
     {"\ns.toml:29: outptu: unknown section (did you mean `output`?)"}},
    {"SectionFar",
     {{"", "[weather]\n"}},
     {"s.toml:29: weather: unknown section: expected `scene`, `resonator`, `slider`, `contact`, "
      "`time`, `output` or `air`"}},
    {"ResonatorLoad",
     {{"modes = 19", "modes = 19\nload = 3"}},
     {"s.toml:15: resonator.load: unknown key", "only the slider", "moving_force"}},
    {"SliderMovingForce",
     {{"", "[[slider.moving_force]]\nforce = 1\nspeed = 1\nstart = 1\n"}},
     {"s.toml:29: slider.moving_force: unknown key", "only the resonator"}},
    // missing
    {"MissingKey",
     {{"duration = 0.1\n", ""}},
     {"\ns.toml:1: scene.duration: missing: expected a number > 0 (s)"}},
    {"MissingMaterial", {{"young = 210e9\n", ""}}, {"s.toml:6: resonator.young: missing", "Pa"}},
    {"MissingSupport",
     {{"support = \"pinned\"\n", ""}},
     {"s.toml:6: resonator.support: missing: expected \"pinned\", \"free\" or \"rigid\""}},
    {"MissingStiffness", {{"stiffness = 1e15\n", ""}}, {"s.toml:25: contact.stiffness: missing"}},
    {"MissingSection",
     {{"[time]\nstep = 1e-6\n", ""}},
     {"\ns.toml:1: time: missing section: expected [time] with step"}},
    {"MissingRq", {{"rq = 8e-6, ", ""}}, {"s.toml:15: resonator.surface.rq: missing"}},
    {"MissingSeed", {{", seed = 2", ""}}, {"s.toml:15: resonator.surface.seed: missing"}},
    {"MissingKind",
     {{"kind = \"gaussian\", ", ""}},
     {"s.toml:15: resonator.surface.kind: missing"}},
    {"MissingPath",
     {{gaussian, "surface = { kind = \"file\" }"}},
     {"s.toml:15: resonator.surface.path: missing"}},
    {"MissingPeaks",
     {{gaussian, "surface = { kind = \"peaks\" }"}},
     {"s.toml:15: resonator.surface.peaks: missing: expected an array of tables"}},
    {"MissingPeakHeight",
     {{gaussian, peaks_of("{ at = 0.1, half_width = 1e-3 }")}},
     {"s.toml:15: resonator.surface.peaks[0].height: missing"}},
    {"MissingForce",
     {{"", "[[resonator.moving_force]]\nspeed = 1\nstart = 0\n"}},
     {"s.toml:29: resonator.moving_force[0].force: missing: expected a number (N)"}},
    // types
    {"TextForNumber",
     {{"speed = 0.5", "speed = \"0.5\""}},
     {"s.toml:3: scene.speed: \"0.5\" is a text without a unit: expected a number >= 0 (m/s), or "
      "with its unit"}},
    {"TruthForNumber", {{"speed = 0.5", "speed = true"}}, {"s.toml:3: scene.speed: true is not"}},
    {"FloatForInteger",
     {{"modes = 19", "modes = 19.0"}},
     {"s.toml:14: resonator.modes: 19.0 is not allowed: expected an integer from 0 to 1000000"}},
    {"NumberForText",
     {{"duration", "name = 3\nduration"}},
     {"s.toml:2: scene.name: 3 is not allowed: expected a text"}},
    {"NumberForChoice",
     {{"step", "scheme = 3\nstep"}},
     {"s.toml:28: time.scheme: 3 is not allowed: expected " + all_schemes}},
    {"NumberForTable",
     {{gaussian, "surface = 3"}},
     {"s.toml:15: resonator.surface: 3 is not allowed: expected a table"}},
    {"TableForTables",
     {{"", "[resonator.moving_force]\nforce = 1\n"}},
     {"s.toml:29: resonator.moving_force: a table is not allowed: expected an array of tables"}},
    {"NumberForSection",
     {{"[scene]", "output = 3\n[scene]"}},
     {"s.toml:1: output: 3 is not allowed: expected a table"}},
    {"NumberForProbes",
     {{"", "[output]\nprobes = 0.1\n"}},
     {"s.toml:30: output.probes: 0.1 is not allowed: expected an array of numbers (m)"}},
    {"TextForProbe",
     {{"", "[output]\nprobes = [\n  0.1,\n  \"middle\",\n]\n"}},
     {"s.toml:32: output.probes[1]: \"middle\" is not allowed: expected a number (m)"}},
    {"DateForNumber",
     {{"speed = 0.5", "speed = 1979-05-27"}},
     {"s.toml:3: scene.speed: a date or time is not allowed"}},
    {"WordForGap",
     {{"start", "gap = \"wide\"\nstart"}},
     {"s.toml:4: scene.gap: \"wide\" is not allowed: expected a number (m) or \"touching\""}},
    {"WordForLoad",
     {{"[slider]", "[slider]\nload = \"heavy\""}},
     {"s.toml:17: slider.load: \"heavy\" is not allowed: expected a number (N) or \"weight\""}},
    {"TypeOfUnusedKey", {{"step", "tolerance = \"small\"\nstep"}}, {"s.toml:28: time.tolerance"}},
    // values
    {"NegativeLength",
     {{"length = 0.3", "length = -0.3"}},
     {"s.toml:8: resonator.length: -0.3 is not allowed: expected a number > 0 (m)"}},
    {"ZeroStep", {{"step = 1e-6", "step = 0"}}, {"s.toml:28: time.step: 0 is not allowed"}},
    {"ZeroDuration", {{"duration = 0.1", "duration = 0.0"}}, {"s.toml:2: scene.duration: 0.0 is"}},
    {"NegativeSpeed", {{"speed = 0.5", "speed = -0.5"}}, {"s.toml:3: scene.speed: -0.5 is not"}},
    {"NotFinite", {{"start = 0.1", "start = nan"}}, {"s.toml:4: scene.start: nan is not allowed"}},
    {"Infinite",
     {{"stiffness = 1e15", "stiffness = inf"}},
     {"s.toml:26: contact.stiffness: inf is"}},
    {"InfiniteGap", {{"start", "gap = inf\nstart"}}, {"s.toml:4: scene.gap: inf is not allowed"}},
    {"Damping",
     {{"damping = 0.02", "damping = 1"}},
     {"s.toml:13: resonator.damping: 1 is not allowed: expected a number in [0, 1)"}},
    {"NegativeModes", {{"modes = 19", "modes = -1"}}, {"s.toml:14: resonator.modes: -1 is not"}},
    {"NegativeSeed",
     {{"seed = 2", "seed = -2"}},
     {"s.toml:15: resonator.surface.seed: -2 is not allowed: expected an integer >= 0"}},
    {"ZeroRq", {{"rq = 8e-6", "rq = 0"}}, {"s.toml:15: resonator.surface.rq: 0 is not allowed"}},
    {"ZeroHalfWidth",
     {{gaussian, peaks_of("{ at = 0.1, height = 1e-6, half_width = 0 }")}},
     {"s.toml:15: resonator.surface.peaks[0].half_width: 0 is not allowed"}},
    {"EmptyPath",
     {{gaussian, "surface = { kind = \"file\", path = \"\" }"}},
     {"s.toml:15: resonator.surface.path: empty: expected the path of a profile"}},
    {"UnknownUnit",
     {{gaussian, "surface = { kind = \"file\", path = \"a\", z_unit = \"inch\" }"}},
     {"s.toml:15: resonator.surface.z_unit: \"inch\" is unknown: expected \"m\", \"mm\""}},
    {"UnknownFilter",
     {{gaussian, "surface = { kind = \"file\", path = \"a\", filter = \"spline\" }"}},
     {"s.toml:15: resonator.surface.filter: \"spline\" is unknown"}},
    {"NegativeForceSpeed",
     {{"", "[[resonator.moving_force]]\nforce = 1\nspeed = -1\nstart = 0\n"}},
     {"s.toml:31: resonator.moving_force[0].speed: -1 is not allowed: expected a number >= 0"}},
    {"ValueOfUnusedKey", {{"step", "tolerance = -1\nstep"}}, {"s.toml:28: time.tolerance: -1 is"}},
    // choices
    {"Support",
     {{"\"pinned\"", "\"pined\""}},
     {"s.toml:7: resonator.support: \"pined\" is unknown: expected \"pinned\", \"free\" or "
      "\"rigid\" "
      "(did you mean \"pinned\"?)"}},
    {"Kind",
     {{"\"gaussian\"", "\"fractal\""}},
     {"s.toml:15: resonator.surface.kind: \"fractal\" is unknown: expected \"gaussian\", \"file\", "
      "\"peaks\" or \"flat\""}},
    {"Initial", {{"start", "initial = \"dynamic\"\nstart"}}, {"expected \"rest\" or \"static\""}},
    {"Nodes", {{"step", "nodes = \"candidate\"\nstep"}}, {"(did you mean \"candidates\"?)"}},
    {"UnknownScheme",
     {{"step", "scheme = \"backward_euler\"\nstep"}},
     {"s.toml:28: time.scheme: \"backward_euler\" is unknown: expected " + all_schemes +
      " (did you mean \"backward-euler\"?)"}},
    {"UnknownSchemeWithoutAStep",
     {{"step = 1e-6", "scheme = \"adaptiv\""}},
     {"s.toml:28: time.scheme: \"adaptiv\" is unknown: expected " + all_schemes +
      " (did you mean \"adaptive\"?)"}},
    {"UnknownLaw",
     {{"stiffness", "law = \"penalties\"\nstiffness"}},
     {"did you mean \"penalty\"?"}},
    {"ContactForce",
     {{"step", "contact_force = \"now\"\nstep"}},
     {"s.toml:28: time.contact_force: \"now\" is unknown: expected \"old\" or \"new\""}},
    {"Force",
     {{"step", "force = \"yes\"\nstep"}},
     {"s.toml:28: time.force: \"yes\" is not allowed: expected true or false"}},
    // combinations
    {"MultiplierWithExplicitEuler",
     {{"stiffness", "law = \"multiplier\"\nstiffness"},
      {"step", "scheme = \"explicit-euler\"\nstep"}},
     {"s.toml:26: contact.law: \"multiplier\" with time.scheme = \"explicit-euler\"",
      "does not move its end", "expected \"penalty\" (or time.scheme = \"backward-euler\")"}},
    {"MultiplierBetweenBodiesThatCannotMove",
     {rigid_slider, {"modes = 19", "modes = 0"}, {"stiffness", "law = \"multiplier\"\nstiffness"}},
     {"s.toml:26: contact.law: \"multiplier\" between bodies that keep no mode"}},
    {"MultiplierBetweenBodiesThatKeepNone",
     {{"support = \"free\"", "support = \"pinned\""},
      {"max_frequency = 20e3", "max_frequency = 1"},
      {"modes = 19", "modes = 0"},
      {"stiffness", "law = \"multiplier\"\nstiffness"}},
     {"s.toml:26: contact.law: \"multiplier\" between bodies that keep no mode",
      "a higher `max_frequency`"}},
    {"MultiplierWithAdaptive",
     {multiplier, adaptive},
     {"s.toml:26: contact.law: \"multiplier\" with time.scheme = \"adaptive\": between bodies of "
      "finitely many modes this law leaves open what an impact gives back",
      "expected \"penalty\", stiff (or a fixed step, time.scheme = \"backward-euler\")"}},
    {"AdaptiveToleranceTooSmall",
     {adaptive, {"", "tolerance = 0.99e-13\n"}},
     {"s.toml:29: time.tolerance: 9.9e-14 asks for less than what roundings do in a step: expected "
      "a relative error per step from 1e-13 to 0.01"}},
    {"AdaptiveToleranceTooLarge",
     {adaptive, {"", "tolerance = 0.011\n"}},
     {"s.toml:29: time.tolerance: 0.011 lets the errors of a few steps grow as large as the motion",
      "from 1e-13 to 0.01"}},
    {"AdaptiveToleranceNoNumber",
     {adaptive, {"", "tolerance = \"small\"\n"}},
     {"s.toml:29: time.tolerance: \"small\" is not allowed: expected a number > 0"}},
    {"AdaptiveStepNoNumber",
     {adaptive, {"", "step = 0\n"}},
     {"s.toml:29: time.step: 0 is not allowed: expected a number > 0 (s)"}},
    {"AdaptiveTooManySamples",
     {adaptive, {"", "[output]\nrate = 1e18\n"}},
     {"s.toml:30: output.rate: 1e+18 Hz takes 1e+17 samples in 0.1 s: expected at most 1e+11"}},
    {"BothModeKeys",
     {{"modes = 19", "modes = 19\nmax_frequency = 1"}},
     {"s.toml:14: resonator.modes: stands beside `max_frequency`: expected one of the two (drop "
      "one)"}},
    {"NoModeKey",
     {{"modes = 19\n", ""}},
     {"s.toml:6: ", "missing: expected `max_frequency` or `modes`"}},
    {"BothWaveKeys",
     {{"rsm", "correlation_length = 1e-3, rsm"}},
     {"s.toml:15: resonator.surface.correlation_length: stands beside `rsm`"}},
    {"NoWaveKey",
     {{"rsm = 1.5e-3, ", ""}},
     {"s.toml:15: resonator.surface.rsm: missing: expected `rsm` or `correlation_length`"}},
    {"NoHurst",
     {{"rsm = 1.5e-3", "correlation = \"self-affine\", longest = 1e-2, shortest = 1e-3"}},
     {"s.toml:15: resonator.surface.hurst: missing: a self-affine surface needs"}},
    {"ThreeWaves",
     {{"rsm = 1.5e-3",
       "rsm = 1.5e-3, correlation = \"self-affine\", hurst = 0.8, longest = 1e-2, shortest = "
       "1e-3"}},
     {"s.toml:15: resonator.surface.longest: 3 of `longest`, `shortest` and `rsm` stand: expected "
      "two"}},
    {"OneWave",
     {{"rsm = 1.5e-3", "correlation = \"self-affine\", hurst = 0.8, longest = 1e-2"}},
     {"s.toml:15: resonator.surface.longest: 1 of `longest`, `shortest` and `rsm` stand: expected "
      "two"}},
    {"NoRsmToBeExact",
     {{"rsm = 1.5e-3", "correlation_length = 1e-3, exact = \"rq+rsm\""}},
     {"s.toml:15: resonator.surface.exact: \"rq+rsm\" needs `rsm`"}},
    {"HurstBeyondOne",
     {{"rsm = 1.5e-3", "rsm = 1.5e-3, hurst = 1"}},
     {"s.toml:15: resonator.surface.hurst: 1 is not allowed: expected a number in (0, 1)"}},
    {"LeavesOnTheRight",
     {{"duration = 0.1", "duration = 0.5"}},
     {"s.toml:4: scene.start: the slider leaves the resonator's right end by 0.07 m",
      "start + slider.length + speed * duration <= resonator.length, 0.3 m (duration <= 0.36 s, "
      "speed <= 0.36 m/s or start <= 0.03 m would fit)"}},
    {"StartsOffTheRight",
     {{"start = 0.1", "start = 0.29"}},
     {"by 0.06 m", "(start <= 0.23 m would fit)"}},
    {"NoRoomToSlide",
     {{"length = 0.02", "length = 0.3"}, {"start = 0.1", "start = 0"}},
     {"by 0.05 m", "(start = 0 with speed = 0 would fit)"}},
    {"LeavesOnTheLeft",
     {{"start = 0.1", "start = -0.01"}},
     {"s.toml:4: scene.start: the slider overhangs the resonator's left end by 0.01 m"}},
    {"SliderTooLong",
     {{"length = 0.02", "length = 0.4"}},
     {"s.toml:18: slider.length: 0.4 m is longer than the resonator: expected at most"}},
    {"SpacingTooWide",
     {{"spacing = 1e-4", "spacing = 0.03"}, {gaussian, ""}},
     {"s.toml:5: scene.spacing: 0.03 m is larger than the slider, 0.02 m", "2 nodes"}},
    {"SpacingTooFine",
     {{"spacing = 1e-4", "spacing = 1e-9"}},
     {"s.toml:5: scene.spacing: 1e-09 m puts 3e+08 nodes on the resonator: expected at most "
      "5e+07"}},
    {"Unresolved",
     {{"rsm = 1.5e-3", "rsm = 3.9e-4"}},
     {"s.toml:15: resonator.surface.rsm: 0.00039 m is not resolved by the spacing, 0.0001 m: "
      "expected "
      "at least 4 spacings (scene.spacing <= 9.75e-05 m, or a longer rsm)"}},
    {"UnresolvedCorrelation",
     {{"rsm = 1.5e-3", "correlation_length = 1e-4"}},
     {"s.toml:15: resonator.surface.correlation_length: 0.0001 m is not resolved"}},
    {"PeakOffTheBody",
     {{gaussian, peaks_of("{ at = 0.4, height = 1e-6, half_width = 1e-3 }")}},
     {"s.toml:15: resonator.surface.peaks[0].at: the peak at 0.4 m lies off the body"}},
    {"PeakBeyondAllProportion",
     {{gaussian, peaks_of("{ at = 0.1, height = 1e-6, half_width = 1.7e29 }")}},
     {"s.toml:15: resonator.surface.peaks[0].half_width: 1.7e+29 m is out of all proportion"}},
    {"ProbeOff",
     {{"", "[output]\nprobes = [0.1, 0.31]\n"}},
     {"s.toml:30: output.probes[1]: 0.31 m is off the resonator: expected a place from 0 to 0.3 "
      "m"}},
    {"FromTheEnd",
     {{"", "[output]\nfrom = 0.1\n"}},
     {"s.toml:30: output.from: 0.1 s is not before the end of the run, 0.1 s"}},
    {"FromTheLastStep",
     {{"", "[output]\nfrom = 0.0999999\n"}},
     {"output.from: 0.0999999 s is not before the end of the run"}},
    {"GapOfNoProportion",
     {{"start", "gap = -1e4\nstart"}},
     {"scene.gap: -10000 m is out of all proportion to a resonator of 0.3 m"}},
    {"LoadOfNoProportion",
     {{"[slider]", "[slider]\nload = 1e29"}},
     {"slider.load: 1e+29 N is out of all proportion"}},
    {"NoStiffness",
     {{"stiffness = 1e15", "stiffness = 5e-324"}},
     {"contact.stiffness: 5e-324 is too small to compute with: expected at least 1e-30"}},
    {"MuchStiffness",
     {{"stiffness = 1e15", "stiffness = 1e29"}},
     {"contact.stiffness: 1e+29 Pa/m makes the spring of a node 2e+23 N/m, ",
      "expected at most 1e+20 N/m (steel: about 1e15 Pa/m)"}},
    {"NoDuration",
     {{"duration = 0.1", "duration = 1e-320"}},
     {"s.toml:2: scene.duration: 1e-320 is too small to compute with: expected at least 1e-30"}},
    {"MicrophoneInThePlane",
     {{"", "[output]\nmicrophones = [{ x = 0, y = 0, z = 1e-4 }]\n"}},
     {"output.microphones[0].z: 0.0001 m is in the plane of the resonator"}},
    {"MicrophoneFarAway",
     {{"", "[output]\nmicrophones = [{ x = 0, y = 0, z = 300 }]\n"}},
     {"output.microphones[0]: is 300 m away: expected 100 m at the most"}},
    {"MicrophoneWithoutModes",
     {{"", "[output]\nmodes = \"none\"\nmicrophones = [{ x = 0, y = 0, z = 1 }]\n"}},
     {"output.microphones: need the motion of the modes"}},
    {"ColdAir",
     {{"", "[air]\ntemperature = -100\n"}},
     {"air.temperature: -100 is not allowed: expected a number in [-50, 100)"}},
    {"ShortDuration",
     {adaptive, {"duration = 0.1", "duration = 1e-29"}},
     {"s.toml:2: scene.duration: 100000 Hz takes no sample in 1e-29 s but that at t = 0: expected "
      "at least 1e+29 Hz, for one at the end (or a longer duration)"}},
    {"NoSpacing",
     {{"spacing = 1e-4", "spacing = 1e-320"}},
     {"s.toml:5: scene.spacing: 1e-320 is too small to compute with: expected at least 1e-30"}},
    {"WidthOfNoBody",
     {{"width = 0.2", "width = 1e300"}},
     {"s.toml:10: resonator.width: 1e+300 is too large to compute with: expected at most 1e+30"}},
    {"StartOfNoPlace",
     {{"start = 0.1", "start = -1e31"}},
     {"s.toml:4: scene.start: -1e+31 is too large to compute with: expected at most 1e+30"}},
    {"MountainousRoughness",
     {{"rq = 8e-6", "rq = 1.7e29"}},
     {"resonator.surface.rq: 1.7e+29 m is higher than the body is long, 0.3 m"}},
    {"SeedSpacing",
     {{"seed = 2", "seed = 2, seed_spacing = 1e-5"}},
     {"resonator.surface.seed_spacing: unknown key: a seed means the same profile at every "
      "scene.spacing: drop the key"}},
    {"SliderProbeOff",
     {{"", "[output]\nslider_probes = [0.021]\n"}},
     {"s.toml:30: output.slider_probes[0]: 0.021 m is off the slider: expected a place from 0 to "
      "0.02 m"}},
    {"RigidLoad",
     {rigid_slider, {"[slider]", "[slider]\nload = \"weight\""}},
     {"s.toml:17: slider.load: a rigid slider has no mode to take a load"}},
    {"StaticFreeResonator",
     {free_resonator, static_start, {"[slider]", "[slider]\nload = 1"}},
     {"s.toml:4: scene.initial: \"static\" with a free resonator", "expected \"rest\""}},
    {"StaticUnloaded",
     {static_start},
     {"s.toml:4: scene.initial: \"static\" with a free slider that no load holds down",
      "slider.load = \"weight\""}},
    {"StaticPulledUp", {static_start, {"[slider]", "[slider]\nload = -1"}}, {"no load holds down"}},
    {"Rate",
     {{"", "[output]\nrate = 2e6\n"}},
     {"s.toml:30: output.rate: 2000000 Hz asks for more than one sample a step: expected at most "
      "1e+06 "
      "Hz"}},
    {"DefaultRate", {{"step = 1e-6", "step = 1e-4"}}, {"output.rate: 100000 Hz asks for more"}},
    {"TooManySteps",
     {{"step = 1e-6", "step = 1e-17"}},
     {"s.toml:28: time.step: a step of 1e-17 s makes 1e+16 steps"}},
    {"StepTooLong",
     {{"step = 1e-6", "step = 1.0"}, {"", "[output]\nrate = 1\n"}},
     {"s.toml:28: time.step: 1 s is longer than the run"}},
    {"TooManyModes",
     {{"max_frequency = 20e3", "max_frequency = 1e30"}},
     {"s.toml:24: slider.max_frequency: 1000 or more modes in both bodies together, at most 256 "
      "can "
      "be marched: expected less than "}},
    {"TooManyModesByNumber",
     {{"modes = 19", "modes = 300"}},
     {"s.toml:14: resonator.modes: 30", "expected at most 25", " here"}},
    {"RateOfNoSample",
     {{"", "[output]\nrate = 1e-29\n"}},
     {"s.toml:30: output.rate: 1e-29 Hz takes no sample in 0.1 s but that at t = 0: expected at "
      "least 10 Hz"}},
    {"MassOfNoBody",
     {{"density = 7800", "density = 1e-29"}, {"young = 210e9", "young = 1e-18"}},
     {"s.toml:12: resonator.density: 1e-29 kg/m^3, 0.002 m thick and 0.2 m wide, makes 4e-33 kg "
      "of each metre"}},
    {"FrequencyOfNoBody",
     {{"young = 210e9", "young = 1e-29"}},
     {"s.toml:11: resonator.young: 1e-29 Pa makes ", "Hz the first frequency"}},
    {"ThicknessOfNoBody",
     {{"thickness = 0.02\n", "thickness = 1e-12\n"}},
     {"slider.thickness: with 0.02 m of length, 1e-12 m of thickness", "slider.max_frequency"}},
    {"FastSlider",
     {{"speed = 0.5", "speed = 1e9"}},
     {"scene.speed: the slider leaves the resonator's right end"}},
    {"DeepKey",
     {{"speed = 0.5", "a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q = 0.5"}},
     {"s.toml:3: a key of more than 16 parts"}},
    {"PathOfNoFile",
     {{gaussian, "surface = { kind = \"file\", path = \"a\\u0000b\" }"}},
     {"s.toml:15: resonator.surface.path: \"a\\u0000b\" holds U+0000"}},
    {"NameThatHdf5Cuts",
     {{"speed = 0.5", "speed = 0.5\nname = \"a\\u0000b\""}},
     {"scene.name: \"a\\u0000b\" holds U+0000"}},
};

INSTANTIATE_TEST_SUITE_P(Each, SceneRefuses, testing::ValuesIn(refused_scenes),
                         [](const auto& info) { return info.param.name; });

TEST(Scene, AdaptiveNeedsNoStep) {
  const Scene s = parse(scene_text({adaptive}));
  EXPECT_EQ(s.time.scheme, SchemeKind::adaptive);
  EXPECT_EQ(s.time.step, 0);
  EXPECT_EQ(s.time.tolerance, 1e-8);
  EXPECT_THAT(echo(s), HasSubstr("\nscheme = \"adaptive\"\n"));
  EXPECT_THAT(echo(s), HasSubstr("\ntolerance = 1e-08\n"));
  EXPECT_THAT(echo(s), Not(HasSubstr("\nstep")));
  expect_round_trip(s);
}

TEST(Scene, AdaptiveLetsAStepStand) {
  // one that would be too long for the run and for the rate
  const Scene s = parse(minimal, {"time.scheme=adaptive", "time.step=1", "time.tolerance=1e-10",
                                  "time.contact_force=new", "time.force=true", "output.rate=1e7"});
  EXPECT_EQ(s.time.step, 1);
  EXPECT_EQ(s.time.tolerance, 1e-10);
  for (const char* line :
       {"\nstep = 1.0  # not used: adaptive finds its steps\n", "\ntolerance = 1e-10\n",
        "\ncontact_force = \"new\"  # not used: adaptive takes the force as it changes\n",
        "\nforce = true  # not used: adaptive has no limit of stability\n"})
    EXPECT_THAT(echo(s), HasSubstr(line));
  expect_round_trip(s);
}

TEST(Scene, AdaptiveTakesTolerancesFromEndToEnd) {
  for (const std::string tolerance : {"1e-13", "1e-2"})
    EXPECT_EQ(refusal(minimal, {"time.scheme=adaptive", "time.tolerance=" + tolerance}),
              "accepted");
  // other schemes let any stand
  EXPECT_EQ(refusal(minimal, {"time.tolerance=1e-20"}), "accepted");
  EXPECT_EQ(refusal(minimal, {"time.tolerance=1"}), "accepted");
}

TEST(Scene, SchemesAndLawsAreChosenByName) {
  const std::vector<std::pair<std::string, SchemeKind>> names{
      {"explicit-euler", SchemeKind::explicit_euler},
      {"midpoint", SchemeKind::midpoint},
      {"backward-euler", SchemeKind::backward_euler},
      {"heun", SchemeKind::heun},
      {"rk4", SchemeKind::rk4},
      {"rk8", SchemeKind::rk8},
      {"exact", SchemeKind::exact},
      {"gautschi", SchemeKind::gautschi},
      {"adaptive", SchemeKind::adaptive}};
  for (const auto& [name, scheme] : names) {
    const Scene s = parse(minimal, {"time.scheme=" + name});
    EXPECT_EQ(s.time.scheme, scheme);
    expect_round_trip(s);
    if (scheme == SchemeKind::explicit_euler || scheme == SchemeKind::adaptive) continue;
    EXPECT_EQ(parse(minimal, {"time.scheme=" + name, "contact.law=multiplier"}).contact.law,
              ContactLaw::multiplier);
  }
  Scene s = parse(minimal);
  EXPECT_EQ(s.time.contact_force, ForceTime::old_time);
  EXPECT_FALSE(s.time.force);
  s = parse(minimal, {"time.contact_force=new", "time.force=true"});
  EXPECT_EQ(s.time.contact_force, ForceTime::new_time);
  EXPECT_TRUE(s.time.force);
  expect_round_trip(s);
}

TEST(Scene, MultipliersNeedNoStiffness) {
  const Scene s = parse(scene_text({{"stiffness = 1e15", "law = \"multiplier\""}}));
  EXPECT_EQ(s.contact.stiffness, 0);
  EXPECT_THAT(echo(s), Not(HasSubstr("stiffness")));
  expect_round_trip(s);
  // a rigid slider on modes, and modes on a free slider alone, can move
  EXPECT_EQ(refusal(scene_text({rigid_slider}), {"contact.law=multiplier"}), "accepted");
  EXPECT_EQ(refusal(minimal, {"contact.law=multiplier", "resonator.modes=0"}), "accepted");
}

TEST(Scene, NamesEveryFaultAtOnceInOrderOfLines) {
  const std::string message = refusal(scene_text({{"speed = 0.5", "sped = 0.5"},
                                                  {"\"pinned\"", "\"pinnd\""},
                                                  {"young = 210e9", "young = -1"},
                                                  {"stiffness = 1e15", "stiffness = \"stiff\""},
                                                  {"", "[output]\nprobes = [1, 2]\n"}}),
                                      {"time.step=0", "nonsense"});
  EXPECT_THAT(message, StartsWith("s.toml: 9 faults\n--set "));
  std::vector<std::size_t> places;
  for (const char* part :
       {"--set nonsense: not an override: expected section.key=value",
        "--set time.step=0: time.step: 0 is not allowed", "s.toml:1: scene.speed: missing",
        "s.toml:3: scene.sped: unknown key (did you mean `speed`?)", "s.toml:7: resonator.support",
        "s.toml:11: resonator.young", "s.toml:26: contact.stiffness", "s.toml:30: output.probes[0]",
        "s.toml:30: output.probes[1]"}) {
    places.push_back(message.find(part));
    EXPECT_NE(places.back(), std::string::npos) << part << "\nnot in\n" << message;
  }
  EXPECT_TRUE(std::is_sorted(places.begin(), places.end())) << message;
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 9);
}

TEST(Scene, EmptyTextNamesTheSections) {
  const std::string message = refusal("");
  EXPECT_THAT(message, StartsWith("s.toml: 5 faults\n"));
  EXPECT_THAT(message,
              HasSubstr("s.toml:1: slider: missing section: expected [slider] with support, "
                        "length, thickness, width, young, density, damping, "
                        "max_frequency or modes"));
}

TEST(Scene, WhatWouldFitFits) {
  const Change longer{"duration = 0.1", "duration = 0.7"};
  EXPECT_THAT(refusal(scene_text({longer})),
              HasSubstr("duration <= 0.36 s or speed <= 0.257142 m/s would fit"));
  EXPECT_EQ(refusal(scene_text({longer}), {"scene.speed=0.257142"}), "accepted");
  EXPECT_EQ(refusal(scene_text({longer}), {"scene.duration=0.36"}), "accepted");
}

TEST(Scene, NumberOfModesThatIsNamedFits) {
  for (const Change& support : {Change{}, free_resonator}) {
    const auto keeping = [&](int modes) {
      return refusal(scene_text({{"modes = 19", "modes = " + std::to_string(modes)}, support}));
    };
    const std::string said = keeping(300), words = "expected at most ";
    ASSERT_THAT(said, HasSubstr(words));
    const int most = std::stoi(said.substr(said.rfind(words) + words.size()));
    EXPECT_EQ(keeping(most), "accepted");
    EXPECT_NE(keeping(most + 1), "accepted");
  }
}

TEST(Scene, EndsAreInside) {
  // 0.28 + 0.02 > 0.3 in doubles
  EXPECT_EQ(refusal(minimal, {"scene.start=0.28", "scene.speed=0"}), "accepted");
  EXPECT_EQ(refusal(minimal, {"scene.start=0", "output.probes=[0, 0.3]"}), "accepted");
  EXPECT_EQ(refusal(minimal, {"output.rate=1e6"}), "accepted");
  EXPECT_EQ(refusal(minimal, {"resonator.surface.rsm=4e-4"}), "accepted");
}

TEST(Scene, PeaksOffTheBodyMayReachIn) {
  const auto with_peak_at = [](const std::string& at) {
    return refusal(scene_text(
        {{gaussian, peaks_of("{ at = " + at + ", height = 1e-6, half_width = 1e-3 }")}}));
  };
  EXPECT_EQ(with_peak_at("-9e-4"), "accepted");
  EXPECT_EQ(with_peak_at("0.3009"), "accepted");
  EXPECT_THAT(with_peak_at("-1.1e-3"), HasSubstr("lies off the body"));
  EXPECT_THAT(with_peak_at("0.3011"), HasSubstr("lies off the body"));
}

TEST(Scene, FreeBodiesAndBodiesThatDoNotBend) {
  EXPECT_EQ(refusal(scene_text({free_resonator})), "accepted");
  EXPECT_EQ(refusal(scene_text({{"modes = 19", "modes = 0"}})), "accepted");
  EXPECT_EQ(refusal(scene_text({static_start, {"[slider]", "[slider]\nload = 0.1"}})), "accepted");
}

TEST(Scene, RigidBodyNeedsNoMaterial) {
  const Scene s = parse(scene_text({{R"(thickness = 0.02
width = 0.02
young = 210e9
density = 7800
damping = 0.02
max_frequency = 20e3)",
                                     "width = 0.02"},
                                    rigid_slider}));
  EXPECT_EQ(s.slider.support, Support::rigid);
  EXPECT_THAT(echo(s), Not(HasSubstr("young = 0")));
  expect_round_trip(s);
  EXPECT_THAT(refusal(scene_text({rigid_slider, {"width = 0.02\n", ""}})),
              HasSubstr("s.toml:16: slider.width: missing"));
}

TEST(SceneOverrides, ReplaceAndAdd) {
  const Scene s =
      parse(minimal, {"scene.speed=0.25", "resonator.surface.rq=4e-6", "time.scheme=backward-euler",
                      " scene.name = two words ", "slider.load=weight", "output.probes=[0.1]",
                      "scene.gap=touching", "slider.surface={ kind = \"flat\" }",
                      "scene.speed=0.125", "scene.initial=\"rest\"",
                      "resonator.moving_force=[{ force = 1, speed = 2, start = 3 }]"});
  EXPECT_EQ(s.speed, 0.125);  // the later one
  EXPECT_EQ(s.resonator.surface.rq, 4e-6);
  EXPECT_EQ(s.resonator.surface.rsm, 1.5e-3);
  EXPECT_EQ(s.name, "two words");
  EXPECT_TRUE(s.slider.load_is_weight);
  EXPECT_THAT(s.output.probes, ElementsAre(0.1));
  ASSERT_EQ(s.resonator.moving_forces.size(), 1);
  EXPECT_EQ(s.resonator.moving_forces[0].speed, 2);
}

TEST(SceneOverrides, MakeTheSectionsTheyNeed) {
  const Scene s = parse(scene_text({{"[time]\nstep = 1e-6\n", ""}}),
                        {"time.step=1e-7", "slider.surface.kind=peaks", "slider.surface.peaks=[]"});
  EXPECT_EQ(s.time.step, 1e-7);
  EXPECT_EQ(s.slider.surface.kind, SurfaceKind::peaks);
}

TEST(SceneOverrides, OfAKindLeaveTheOtherKeys) {
  const Scene s = parse(minimal, {"resonator.surface.kind=flat"});
  EXPECT_EQ(s.resonator.surface.kind, SurfaceKind::flat);
  EXPECT_THAT(echo(s),
              HasSubstr("surface = { kind = \"flat\", rq = 8e-06, rsm = 0.0015, seed = 2 }  # "
                        "not used: rq, rsm, seed, the kind is \"flat\"\n"));
  expect_round_trip(s);
}

TEST(SceneOverrides, OfOneOfTwoKeysDropTheOther) {
  for (const std::string& text :
       {std::string(minimal), scene_text({{"modes = 19", "max_frequency = 3e3"}})}) {
    const Scene by_modes = parse(text, {"resonator.modes=3"});
    EXPECT_EQ(by_modes.resonator.modes, 3);
    EXPECT_FALSE(by_modes.resonator.max_frequency);
    const Scene by_frequency = parse(text, {"resonator.max_frequency=1e3"});
    EXPECT_EQ(by_frequency.resonator.max_frequency, 1e3);
    EXPECT_FALSE(by_frequency.resonator.modes);
  }
  const Scene correlated = parse(minimal, {"resonator.surface.correlation_length=1e-3"});
  EXPECT_EQ(correlated.resonator.surface.correlation_length, 1e-3);
  EXPECT_FALSE(correlated.resonator.surface.rsm);
  // the later one
  const Scene twice = parse(minimal, {"resonator.modes=3", "resonator.max_frequency=1e3"});
  EXPECT_EQ(twice.resonator.max_frequency, 1e3);
  EXPECT_FALSE(twice.resonator.modes);
}

TEST(SceneOverrides, FaultsAreLocatedByTheirText) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"resonator.surfce=3", "resonator.surfce: unknown key (did you mean `surface`?)"},
      {"resonatr.length=3", "resonatr: unknown section (did you mean `resonator`?)"},
      {"duration=3", "duration: unknown key (did you mean `scene.duration`?)"},
      {"scene.duration=long", "scene.duration: \"long\" is not allowed: expected a number > 0 (s)"},
      {"resonator.surface.kind=gausian",
       "resonator.surface.kind: \"gausian\" is unknown: expected \"gaussian\", \"file\", \"peaks\" "
       "or "
       "\"flat\" (did you mean \"gaussian\"?)"},
      {"time.scheme=adaptve", "time.scheme: \"adaptve\" is unknown: expected " + all_schemes +
                                  " (did you mean \"adaptive\"?)"},
      {"scene.speed=1 2", "scene.speed: \"1 2\" is not allowed: expected a number >= 0 (m/s)"},
      {"scene.start.x=1",
       "scene.start: 0.1 is no table, it has no `x`: expected scene.start=value, to set it as a "
       "whole"},
      {"output.probes=[0.4]",
       "output.probes[0]: 0.4 m is off the resonator: expected a place from 0 to 0.3 m"},
      {"time.step", "not an override: expected section.key=value"},
      {"=3", "not an override: expected section.key=value"},
      {"time..step=3", "not an override: expected section.key=value"},
      {"a b.c=3", "not an override: expected section.key=value"},
  };
  for (const auto& [text, fault] : cases) {
    std::string expected = "s.toml: 1 fault\n--set ";
    expected.append(text).append(": ").append(fault);
    EXPECT_EQ(refusal(minimal, {text}), expected);
  }
}

TEST(SceneOverrides, OfAValueWithLineEndsSetOneKey) {
  const Scene s = parse(minimal, {"scene.name=\"a\"\nstart = 0.2", "output.probes=[\n0.1,\n0.2]"});
  EXPECT_EQ(s.name, "\"a\"\nstart = 0.2");
  EXPECT_EQ(s.start, 0.1);
  EXPECT_THAT(s.output.probes, ElementsAre(0.1, 0.2));
  expect_round_trip(s);
}

TEST(SceneOverrides, AreReadBesideASyntaxError) {
  const std::string message = refusal("[scene\n", {"nonsense"});
  EXPECT_THAT(message, StartsWith("s.toml: 2 faults\n--set nonsense: not an override"));
  EXPECT_THAT(message, HasSubstr("\ns.toml:1:"));
}

TEST(SceneOverrides, OfNoUtf8AreFaults) {
  EXPECT_EQ(
      refusal(minimal, {"scene.name=\xff"}),
      "s.toml: 1 fault\n--set scene.name=\xff: not UTF-8: expected a value that TOML can hold");
}

/// Whatever is nested in a text, no more than a bounded depth of it is built.
TEST(SceneDepth, IsLimitedBeforeTheParse) {
  const auto repeated = [](const std::string& part, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += part;
    return text;
  };
  const std::string dotted = repeated("a.", 300'000) + "a";
  const std::string quoted = repeated("\"a.b\" . 'c' .", 300'000) + "a";
  for (const std::string& key : {dotted, quoted})
    for (const std::string& text : {key + " = 1", "[" + key + "]", "[[" + key + "]]",
                                    "x = {" + key + " = 1}", "x = [{ y = 1, " + key + " = 1}]",
                                    "x = '''\n'''\n" + key + " = 1", "x = 1 # \"\n" + key + " = 1"})
      EXPECT_THAT(refusal(text), HasSubstr("a key of more than 16 parts")) << text.substr(0, 20);
  EXPECT_THAT(refusal(minimal, {dotted + "=1"}), HasSubstr("not an override"));
  EXPECT_THAT(refusal(minimal, {"scene.x={" + dotted + "=1}"}), HasSubstr("scene.x: unknown key"));
  for (const char* open : {"[", "{a=", "{a.b.c=", "[{a=["})
    EXPECT_THAT(refusal("x = " + repeated(open, 100'000)), HasSubstr("not TOML"));
  EXPECT_THAT(refusal("x = " + repeated("[", 40) + repeated("]", 40)), HasSubstr("not TOML"));
  // dots elsewhere are none of keys
  const std::string dots = repeated("a.b", 100);
  for (const std::string& name :
       {"\"" + dots + "\\\"" + dots + "\"", "'" + dots + "'", "'''\n" + dots + "'''''",
        "\"\"\"" + dots + "\"\"\\\"\"\"\" # " + dots})
    EXPECT_EQ(refusal(scene_text({{"[scene]", "[scene]\nname = " + name}})), "accepted") << name;
}

TEST(Scene, ManyFaultsAreCountedAndTheFirstAreNamed) {
  std::string probes;
  for (int i = 0; i < 20'000; ++i) probes += "9,\n";
  const std::string message = refusal(
      scene_text({{"speed = 0.5", "sped = 0.5"}, {"", "[output]\nprobes = [" + probes + "]\n"}}));
  EXPECT_THAT(message, StartsWith("s.toml: 20002 faults\ns.toml:1: scene.speed: missing"));
  EXPECT_THAT(message, HasSubstr("\ns.toml:3: scene.sped: unknown key"));
  EXPECT_THAT(message, HasSubstr("\ns.toml:47: output.probes[17]: 9 m is off"));
  EXPECT_THAT(message, testing::EndsWith("\nand 19982 more"));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 21);
  EXPECT_LT(refusal(scene_text({{"", std::string(1'000'000, 'x') + " = 1\n"}})).size(), 1000u);
  EXPECT_LT(refusal(minimal, {std::string(100'000, 'x') + "=1"}).size(), 1000u);
}

TEST(Scene, LaterRefusalsNameFileLineAndKey) {
  const Scene s = parse(minimal, {"scene.speed=0.25", "resonator.surface.rq=4e-6"});
  const auto message_of = [](const Scene& scene, const std::string& key) {
    return std::string(ra2d::refusal(scene, key, "no").what());
  };
  EXPECT_EQ(message_of(s, "time.step"), "s.toml: 1 fault\ns.toml:28: time.step: no");
  EXPECT_EQ(message_of(s, "scene.speed"),
            "s.toml: 1 fault\n--set scene.speed=0.25: scene.speed: no");
  EXPECT_EQ(message_of(s, "resonator.surface.rsm"),
            "s.toml: 1 fault\ns.toml:15: resonator.surface.rsm: no");
  EXPECT_EQ(message_of(s, "scene.gap"), "s.toml: 1 fault\ns.toml:1: scene.gap: no");
  EXPECT_EQ(message_of(s, "output.rate"), "s.toml: 1 fault\ns.toml:1: output.rate: no");
  Scene made;
  made.file = "m.toml";
  EXPECT_EQ(message_of(made, "time.step"), "m.toml: 1 fault\nm.toml: time.step: no");
}

TEST(Text, ForATerminalHasNoControlCharacters) {
  EXPECT_EQ(printable("a\x1b[2J\n\t\x7f\xc2\x9bz \xc3\xa9 \xe2\x82\xac \xf0\x9f\x8e\xb5"),
            "a\\u001B[2J\\u000A\\u0009\\u007F\\u009Bz \xc3\xa9 \xe2\x82\xac \xf0\x9f\x8e\xb5");
  EXPECT_EQ(printable("\xff\xc3"), "\\xFF\\xC3");
  EXPECT_EQ(printable_lines("a\x01\n\nb\n"), "a\\u0001\n\nb\n");
  // nor what ends a line, turns the direction of writing, or is not seen; their neighbours stay
  EXPECT_EQ(printable("\u061c\u200e\u200f\u2028\u202e\u2066\u2069\ufeff"),
            "\\u061C\\u200E\\u200F\\u2028\\u202E\\u2066\\u2069\\uFEFF");
  EXPECT_EQ(printable("\u200d\u2027\u202f\u2065\u206a"), "\u200d\u2027\u202f\u2065\u206a");
  // and TOML reads its own escapes back
  Scene s = parse(minimal);
  s.name = "\x1b[31m \xc2\x9b \"\\\n\t \x7f \u202e";
  EXPECT_EQ(printable_lines(echo(s)), echo(s));
  EXPECT_EQ(parse(echo(s)).name, s.name);
}

TEST(SceneEcho, IsCompleteAndCanonical) {
  EXPECT_EQ(echo(parse(minimal)), R"([scene]
name = ""
duration = 0.1
speed = 0.5
start = 0.1
gap = "touching"
spacing = 0.0001
faces = "smooth"
initial = "rest"

[resonator]
support = "pinned"
length = 0.3
thickness = 0.002
width = 0.2
young = 21e10
density = 7800.0
damping = 0.02
modes = 19
surface = { kind = "gaussian", rq = 8e-06, rsm = 0.0015, seed = 2 }

[slider]
support = "free"
length = 0.02
thickness = 0.02
width = 0.02
young = 21e10
density = 7800.0
damping = 0.02
max_frequency = 20000.0
surface = { kind = "flat" }
load = 0.0

[contact]
law = "penalty"
stiffness = 1e15

[time]
scheme = "backward-euler"
contact_force = "old"
step = 1e-06
nodes = "candidates"

[output]
rate = 100000.0
probes = []
slider_probes = []
from = 0.0
)");
}

/// Programs whose faces were linear by default wrote that key for smooth ones alone.
TEST(SceneEcho, WithoutFacesIsThatOfLinearOnes) {
  const Scene linear = parse(minimal, {"scene.faces=linear"});
  const std::string text = echo(linear), key = "faces = \"linear\"\n";
  ASSERT_THAT(text, HasSubstr(key));
  EXPECT_EQ(echo(parse_echo(with(text, {key, ""}), "s.toml")), text);
  for (const Scene& scene : {linear, parse(minimal)})
    EXPECT_EQ(echo(parse_echo(echo(scene), "s.toml")), echo(scene));
}

TEST(SceneEcho, ReadsBackAsTheSameScene) {
  expect_round_trip(parse(minimal));
  expect_round_trip(
      parse(minimal,
            {"scene.name=\"q\\\" b\\\\ \\t \\n \\u0001 \\u007f µ\"", "scene.gap=-1e-6",
             "resonator.surface.seed=9223372036854775807", "slider.load=weight",
             "slider.surface={ kind = \"file\", path = \"/a \\\"b\\\"/c.csv\" }", "time.nodes=all",
             "time.tolerance=1e-8", "output.probes=[0, 0.1, 0.3]", "scene.initial=static",
             "output.microphones=[{ x = 0.1, y = 0.2, z = 1 }, { x = 1, y = -1, z = -2 }]",
             "air.temperature=-3.5", "air.pressure=9e4"}));
  expect_round_trip(parse(
      minimal, {"resonator.surface={ kind = \"gaussian\", rq = 1e-6, correlation_length = 2e-3, "
                "seed = 0 }",
                "slider.surface={ kind = \"peaks\", peaks = [{ at = 0, height = 1e-5, half_width "
                "= 1e-4 }, { at = 0.01, height = -1e-5, half_width = 1 }] }",
                "resonator.moving_force=[{ force = -10, speed = 0, start = 0 }, { force = 1e10, "
                "speed = 2, start = -3 }]"}));
  expect_round_trip(parse(
      minimal, {"resonator.surface={ kind = \"gaussian\", rq = 1e-6, rsm = 1e-3, correlation = "
                "\"exponential\", shortest = 1e-4, skewness = -0.5, kurtosis = 4, exact = "
                "\"rq+rsm\", seed = 3 }",
                "slider.surface={ kind = \"gaussian\", rq = 1e-6, correlation = "
                "\"self-affine\", hurst = 0.8, longest = 1e-2, shortest = 1e-3, exact = "
                "\"none\", seed = 4 }"}));
  expect_round_trip(parse(
      minimal, {"resonator.surface={ kind = \"file\", path = \"/p\", x_unit = \"mm\", z_unit = "
                "\"um\", row = 7, form = \"poly:3\", filter = \"gaussian\", cutoff = 8e-4, "
                "cutoff_s = 8e-6, fill = \"linear:1e-5\", short = \"repeat\" }",
                "slider.surface={ kind = \"file\", path = \"/p\", column = 2, x_unit = \"m\" }"}));
  expect_round_trip(parse(
      minimal, {"resonator.surface={ kind = \"file\", path = \"/p\", spacing = 1e-6, decimal = "
                "\"comma\" }",
                "slider.surface={ kind = \"file\", path = \"/p\", decimal = \"point\" }"}));
}

TEST(Scene, PreparationOfAFile) {
  const Scene s = parse(
      minimal, {"resonator.surface={ kind = \"file\", path = \"/p\", x_unit = \"mm\", z_unit = "
                "\"um\", row = 7, form = \"line\", filter = \"gaussian\", cutoff = 2.5e-3, "
                "cutoff_s = 8e-6, fill = \"linear:1e-5\", short = \"repeat\" }",
                "slider.surface={ kind = \"file\", path = \"/p\", column = 2, form = \"none\", "
                "filter = \"none\", short = \"refuse\" }"});
  const FilePreparation& how = s.resonator.surface.prepared;
  EXPECT_EQ(how.x_unit, FileUnit::mm);
  EXPECT_EQ(how.z_unit, FileUnit::um);
  EXPECT_EQ(how.row, 7);
  EXPECT_EQ(how.column, std::nullopt);
  EXPECT_EQ(how.form, "line");
  EXPECT_EQ(how.fill, "linear:1e-5");
  EXPECT_EQ(how.filter, FaceFilter::gaussian);
  EXPECT_EQ(how.cutoff, 2.5e-3);
  EXPECT_EQ(how.cutoff_s, 8e-6);
  EXPECT_EQ(how.when_short, ShortProfile::repeat);
  FilePreparation second;
  second.column = 2;
  EXPECT_EQ(s.slider.surface.prepared, second);
  const auto with = [](const std::string& keys) {
    return refusal(minimal, {"resonator.surface={ kind = \"file\", path = \"/p\", " + keys + " }"});
  };
  EXPECT_EQ(with("cutoff_s = 1e-5"), "accepted");
  EXPECT_THAT(with("x_unit = \"inch\""), HasSubstr("expected \"m\", \"mm\", \"um\" or \"nm\""));
  EXPECT_THAT(with("spacing = 0"), HasSubstr("surface.spacing: 0 is not allowed"));
  EXPECT_THAT(with("decimal = \"dot\""), HasSubstr("expected \"point\" or \"comma\""));
  EXPECT_THAT(with("row = 0"), HasSubstr("surface.row: 0 is not allowed"));
  EXPECT_THAT(with("row = 1, column = 1"), HasSubstr("surface.column: stands beside `row`"));
  EXPECT_THAT(with("form = \"poly:11\""),
              HasSubstr("surface.form: \"poly:11\" is not allowed: expected none, mean, line"));
  EXPECT_THAT(with("fill = \"linear:0\""), HasSubstr("surface.fill: \"linear:0\" is not allowed"));
  EXPECT_THAT(with("fill = \"linear:1e400\""), HasSubstr("surface.fill"));
  EXPECT_THAT(with("cutoff = 1e-3"), HasSubstr("surface.cutoff: there is no filter"));
  EXPECT_THAT(with("filter = \"gaussian\", cutoff = 0"), HasSubstr("surface.cutoff: 0 is not"));
  EXPECT_THAT(with("filter = \"gaussian\", cutoff_s = 2.5e-3"),
              HasSubstr("surface.cutoff_s: 0.0025 m: expected less than the cutoff, 0.0025 m"));
  EXPECT_THAT(with("short = \"mirror\""), HasSubstr("expected \"refuse\" or \"repeat\""));
  EXPECT_THAT(echo(parse(minimal, {"resonator.surface.row=3"})),
              HasSubstr("row = 3, rq = 8e-06, rsm = 0.0015, seed = 2 }  # not used: row, the "));
}

TEST(SceneEcho, SaysWhichWordsACorrelationDoesNotUse) {
  const Scene s = parse(
      minimal,
      {"resonator.surface={ kind = \"gaussian\", rq = 1e-6, rsm = 1e-3, correlation = "
       "\"self-affine\", correlation_length = 1e-3, hurst = 0.8, longest = 1e-2, seed = 3 }",
       "slider.surface={ kind = \"gaussian\", rq = 1e-6, rsm = 1e-3, hurst = 0.8, seed = 3 }"});
  EXPECT_THAT(echo(s),
              HasSubstr("# not used: correlation_length, the correlation is \"self-affine\"\n"));
  EXPECT_THAT(echo(s), HasSubstr("# not used: hurst, the correlation is \"gaussian\"\n"));
  expect_round_trip(s);
}

TEST(SceneEcho, KeepsEveryBitOfANumber) {
  for (const double value : {0.1, 1.0 / 3, 1e-300, 5e-324, 1e30, 123456789.0, 2e6, 1e22,
                             9007199254740993.0, std::nextafter(0.3, 1), -0.0}) {
    Scene s = parse(minimal);
    s.resonator.moving_forces = {{.force = 1, .speed = 1, .start = value}};
    const double again = parse(echo(s)).resonator.moving_forces.at(0).start;
    EXPECT_EQ(again, value);
    EXPECT_EQ(std::signbit(again), std::signbit(value));
  }
}

TEST(SceneEcho, SaysWhatIsNotUsed) {
  const Scene s = parse(scene_text({rigid_slider,
                                    {"max_frequency = 20e3", "max_frequency = 20e3\nmodes = 3"},
                                    {"step", "tolerance = 1e-8\nstep"}}));
  const std::string text = echo(s);
  for (const char* line :
       {"\nthickness = 0.02  # not used: the body is rigid\n",
        "\nyoung = 21e10  # not used: the body is",
        "\ndensity = 7800.0  # not used: the body is rigid\n",
        "\ndamping = 0.02  # not used: the body", "\nmax_frequency = 20000.0  # not used: the body",
        "\nmodes = 3  # not used: the body is rigid\n",
        "\nload = 0.0  # not used: the body is rigid\n",
        "\ntolerance = 1e-08  # not used: backward-euler takes fixed steps\n",
        "\nthickness = 0.002\n", "\nwidth = 0.02\n"})
    EXPECT_THAT(text, HasSubstr(line));
  expect_round_trip(s);
}

TEST(SceneEcho, SaysWhatSchemeAndLawDoNotUse) {
  Scene s = parse(minimal, {"time.scheme=rk4", "time.contact_force=new"});
  EXPECT_THAT(
      echo(s),
      HasSubstr("\ncontact_force = \"new\"  # not used: rk4 takes the force at its stages\n"));
  expect_round_trip(s);
  s = parse(minimal, {"contact.law=multiplier", "time.contact_force=new"});
  EXPECT_THAT(echo(s), HasSubstr("\nstiffness = 1e15  # not used: multipliers have no spring\n"));
  EXPECT_THAT(echo(s), HasSubstr("\ncontact_force = \"new\"  # not used: multipliers are found"));
  expect_round_trip(s);
  s = parse(minimal, {"time.contact_force=new", "time.force=true"});
  EXPECT_THAT(echo(s), HasSubstr("\ncontact_force = \"new\"\n"));
  EXPECT_THAT(echo(s), HasSubstr("\nforce = true\n"));
  EXPECT_THAT(echo(parse(minimal)), Not(HasSubstr("\nforce =")));
}

TEST(SceneEcho, SaysThatARigidResonatorTakesNoForce) {
  const Scene s = parse(minimal, {"resonator.support=rigid",
                                  "resonator.moving_force=[{ force = 1, speed = 2, start = 3 }]"});
  EXPECT_THAT(echo(s), HasSubstr("[[resonator.moving_force]]  # not used: the body is rigid\n"));
  expect_round_trip(s);
}

TEST(SceneEcho, GroupsUnusedKeysOfASurfaceByReason) {
  const Scene s = parse(minimal, {"resonator.surface.row=3", "resonator.surface.hurst=0.8",
                                  "resonator.surface.column=2"});
  EXPECT_THAT(echo(s), HasSubstr("seed = 2 }  # not used: row, column, the kind is \"gaussian\"; "
                                 "hurst, the correlation is \"gaussian\"\n"));
  expect_round_trip(s);
}

TEST(SceneEcho, MarksNothingThatIsUsed) {
  EXPECT_THAT(echo(parse(minimal)), Not(HasSubstr("not used")));
}

class SceneFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "ra2d-scene-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& text) const {
    auto file = folder_ / "s.toml";
    std::ofstream(file) << text;
    return file;
  }
  std::filesystem::path folder_;
};

TEST_F(SceneFile, IsReadWithOverrides) {
  const auto file = write(minimal);
  const Scene s = read_scene(file, {"scene.speed=0.25"});
  EXPECT_EQ(s.file, file);
  EXPECT_EQ(s.speed, 0.25);
}

TEST_F(SceneFile, FaultsNameIt) {
  const auto file = write(scene_text({{"speed = 0.5", "speed = -1"}}));
  try {
    read_scene(file);
    FAIL() << "accepted";
  } catch (const RequestError& error) {
    EXPECT_THAT(error.what(),
                StartsWith(file.string() + ": 1 fault\n" + file.string() + ":3: scene.speed"));
  }
}

TEST_F(SceneFile, ThatCannotBeReadIsAFileError) {
  EXPECT_THROW(read_scene(folder_ / "none.toml"), FileError);
  EXPECT_THROW(read_scene(folder_), FileError);
}

TEST_F(SceneFile, ThatIsHugeIsRefused) {
  EXPECT_THAT(refusal(std::string((16u << 20) + 1, '#')), HasSubstr("more than 16 MiB"));
}

TEST_F(SceneFile, OfTheScenesFolderAreAllFine) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_folder() / "scenes")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().filename());
    if (test::read_file(entry.path()).find("\nbase ") != std::string::npos) continue;  // a study
    expect_round_trip(read_scene(entry.path()));
    ++count;
  }
  EXPECT_GE(count, 5);
}

TEST_F(SceneFile, OfThePaperHasItsNumbers) {
  const Scene s = read_scene(test::scene_file("dang2012"));
  EXPECT_EQ(s.duration, 1);
  EXPECT_EQ(s.spacing, 8e-6);
  EXPECT_EQ(s.time.step, 1e-8);
  EXPECT_EQ(s.resonator.length, 0.3);
  EXPECT_EQ(s.resonator.width, 0.2);
  EXPECT_EQ(s.resonator.thickness, 0.002);
  EXPECT_EQ(s.slider.length, 0.02);
  for (const BodySpec* body : {&s.resonator, &s.slider}) {
    EXPECT_EQ(body->young, 210e9);
    EXPECT_EQ(body->density, 7800);
    EXPECT_EQ(body->damping, 0.02);
    EXPECT_EQ(body->max_frequency, 20e3);
    EXPECT_EQ(body->surface.rq, 8e-6);
    EXPECT_EQ(body->surface.rsm, 1.55e-3);
  }
}

/// Every number has a unit that a study's axis can be written with; that of others is "".
void expect_units(const std::string& section, const std::vector<KeyFacts>& keys) {
  const std::vector<std::string> without = {"damping",  "poisson",   "hurst",      "skewness",
                                            "kurtosis", "tolerance", "temperature"};
  const std::vector<std::string> units = {"s", "m", "m/s", "Pa", "kg/m^3", "Hz", "N", "Pa/m"};
  for (const KeyFacts& key : keys) {
    SCOPED_TRACE(section + "." + key.name);
    EXPECT_FALSE(key.type.empty());
    const bool is_number = key.type.find("number") != std::string::npos;
    const bool has_unit = std::find(units.begin(), units.end(), key.unit) != units.end();
    const bool has_none = std::find(without.begin(), without.end(), key.name) != without.end();
    if (is_number)
      EXPECT_NE(has_unit, has_none) << "unit: " << key.unit;
    else
      EXPECT_EQ(key.unit, "");
    expect_units(section + "." + key.name, key.inner);
  }
}

TEST(SceneKeys, EveryNumberHasAUnit) { expect_units("", scene_sections()); }

TEST(SceneKeys, AreFoundByTheirPath) {
  ASSERT_NE(find_key("resonator.surface.peaks[3].half_width"), nullptr);
  EXPECT_EQ(find_key("resonator.surface.peaks[3].half_width")->unit, "m");
  EXPECT_EQ(find_key("slider.density")->unit, "kg/m^3");
  EXPECT_EQ(find_key("resonator.moving_force[0].speed")->unit, "m/s");
  EXPECT_EQ(find_key("scene")->inner.front().name, "name");
  for (const char* path : {"", "scene.sped", "slider.moving_force", "resonator.load", "scene.",
                           "scene.speed.x", "speed", ".speed"}) {
    EXPECT_EQ(find_key(path), nullptr) << path;
    EXPECT_THROW(key_unit(path), std::logic_error) << path;
  }
  EXPECT_EQ(key_unit("resonator.moving_force[0].speed"), "m/s");
}

TEST(SceneKeys, UnitsOfAStudysAxes) {
  EXPECT_EQ(udunits(""), "1");
  EXPECT_EQ(udunits("Hz"), "Hz");
  EXPECT_EQ(udunits("m/s"), "m s-1");
  EXPECT_EQ(udunits("kg/m^3"), "kg m-3");
  EXPECT_EQ(udunits("Pa/m"), "Pa m-1");
  for (const char* unit : {"", "m", "m/s", "kg/m^3", "Pa/m"})
    EXPECT_EQ(unit_of_udunits(udunits(unit)), unit);
}

TEST(SceneKeys, ThePageHasThem) {
  const std::filesystem::path page = test::source_folder() / "docs/scene.md";
  const std::string text = test::read_file(page);
  for (const char* section : {"scene", "body", "resonator.surface", "resonator.moving_force",
                              "contact", "time", "output"})
    EXPECT_NE(text.find(fmt::format("<!-- keys: {} -->\n", section)), text.npos) << section;
  const std::string expected = with_key_tables(text);
  if (text == expected) return;
  const auto made = std::filesystem::temp_directory_path() / "ra2d-scene.md";
  std::ofstream(made) << expected;
  FAIL() << "its tables are not those of host/scene_file/key_table.cpp: cp " << made.string() << " "
         << page.string();
}

}  // namespace
TEST(Scene, StartsFromEquilibriumWhereThereIsOne) {
  const auto initial = [](const std::vector<Change>& changes) {
    return parse(scene_text(changes)).initial;
  };
  const Change weight{"[slider]", "[slider]\nload = \"weight\""},
      pressed{"[slider]", "[slider]\nload = 1"};
  EXPECT_EQ(initial({}), Initial::rest);  // free, and nothing holds it down
  EXPECT_EQ(initial({{"[slider]", "[slider]\nload = -1"}}), Initial::rest);
  EXPECT_EQ(initial({weight}), Initial::statics);
  EXPECT_EQ(initial({pressed}), Initial::statics);
  EXPECT_EQ(initial({rigid_slider}), Initial::statics);
  EXPECT_EQ(initial({free_resonator, pressed}), Initial::rest);
  EXPECT_EQ(initial({weight, {"start", "initial = \"rest\"\nstart"}}), Initial::rest);
}

/// The number stands in the echo, with where it comes from. What reads it sees a number.
TEST(SceneEcho, HertzIsANumberThatTellsItsOrigin) {
  const Scene s = parse(scene_text({{"stiffness = 1e15", "stiffness = \"hertz\""},
                                    {"modes = 19", "modes = 19\npoisson = 0.25"}}));
  const std::string text = echo(s);
  EXPECT_THAT(text, HasSubstr(fmt::format("\nstiffness = {}  # \"hertz\"",
                                          toml_number(s.contact.stiffness))));
  EXPECT_THAT(text, HasSubstr("\npoisson = 0.25\n"));
  EXPECT_THAT(text, HasSubstr("\npoisson = 0.3\n"));
  const Scene again = parse(text);
  EXPECT_EQ(again.contact.stiffness, s.contact.stiffness);
  EXPECT_EQ(again.slider.poisson, 0.3);
  expect_round_trip(again);
  EXPECT_THAT(echo(again), HasSubstr("poisson = 0.3  # not used: only contact.stiffness"));
  // under multipliers there is no spring; one word changes the law
  const Scene other =
      parse(scene_text({{"stiffness = 1e15", "law = \"multiplier\"\nstiffness = \"hertz\""}}));
  EXPECT_THAT(echo(other), HasSubstr("# not used: multipliers have no spring"));
  // of rigid bodies the modulus serves
  const Scene rigid =
      parse(scene_text({{"stiffness = 1e15", "stiffness = \"hertz\""}, rigid_slider}));
  EXPECT_THAT(echo(rigid), HasSubstr("density = 7800.0  # not used: the body is rigid"));
  EXPECT_THAT(echo(rigid), testing::Not(HasSubstr("young = 21e10  # not used")));
}

/// Numbers without sense make several faults; the one that is odd is named in each.
TEST(Scene, NumbersWithoutSenseAreNamed) {
  EXPECT_THAT(refusal(scene_text({{"length = 0.3\n", "length = 1e-12\n"}})),
              HasSubstr("resonator.length: 1e-12 m is shorter than scene.spacing"));
  EXPECT_THAT(refusal(scene_text({{"duration = 0.1", "duration = 1e15"}})),
              HasSubstr("scene.duration: a step of 1e-06 s makes 1e+21 steps"));
}

/// A fault may be another number's: what looks odd is said with it.
TEST(Scene, FaultsComeWithWhatLooksOdd) {
  const std::string message = refusal(
      scene_text({{"modes = 19", "max_frequency = 20e3"}, {"young = 210e9", "young = 210"}}));
  EXPECT_THAT(message, HasSubstr("modes up to resonator.max_frequency"));
  EXPECT_THAT(
      message,
      HasSubstr(
          "\nlooks odd: resonator.young = 210 Pa: softer than a gel: is it in GPa (2.1e+11 Pa)?"));
}

TEST(Scene, SaysWhichLoadsNothingHolds) {
  const auto said = [](std::vector<Change> changes) {
    changes.push_back({"1e15", "\"hertz\""});
    return scene_doubts(parse(scene_text(changes)));
  };
  const Change pressed{"[slider]", "[slider]\nload = 1"};
  const Change pushed{"", "[[resonator.moving_force]]\nforce = 10\nspeed = 20\nstart = -1\n"};
  EXPECT_THAT(said({}), IsEmpty());
  EXPECT_THAT(said({pressed, pushed}), IsEmpty());
  EXPECT_THAT(said({free_resonator}), IsEmpty());
  EXPECT_THAT(said({free_resonator, pushed}),
              ElementsAre(HasSubstr("nothing holds the free resonator against its moving force")));
  EXPECT_THAT(said({free_resonator, pressed}),
              ElementsAre(HasSubstr("nothing holds the free resonator against the slider's load")));
  EXPECT_THAT(said({{"[slider]", "[slider]\nload = -1"}}),
              ElementsAre(HasSubstr("nothing holds the free slider against its load")));
}

}  // namespace ra2d
