// SPDX-License-Identifier: BSD-3-Clause
// Results with less in them ([output] modes, precision, compression), and windows with more of the
// time (run --zoom).
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/model/model.hpp"
#include "host/run/zoom.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/checked_file.hpp"
#include "host/store/result_reader.hpp"
#include "tests/child.hpp"
#include "tests/hdf5_content.hpp"
#include "tests/places.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class Kept : public testing::Test {
 protected:
  /// A run of the paper's scene to `name`, adaptive unless `more` says otherwise.
  Ended run(const std::string& name, std::vector<std::string> more = {}) const {
    std::vector<std::string> words{program(),
                                   "run",
                                   scene_file("dang2012"),
                                   "--set",
                                   "time.scheme=adaptive",
                                   "-o",
                                   (folder_.path() / name).string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(aside_.path(), words);
  }
  Ended ra2d(const std::vector<std::string>& more) const {
    std::vector<std::string> words{program()};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(aside_.path(), words);
  }
  nlohmann::json analysis(const std::string& name) const {
    const Ended ended = ra2d({"analyze", path(name), "--json"});
    EXPECT_EQ(ended.status, 0) << ended.err;
    return nlohmann::json::parse(ended.out);
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  const Folder folder_, aside_;
};

std::vector<std::string> set(const std::vector<std::string>& values) {
  std::vector<std::string> words;
  for (const std::string& value : values) words.insert(words.end(), {"--set", value});
  return words;
}

// ---- less --------------------------------------------------------------------------------------

TEST_F(Kept, WithoutModesAllElseIsThatOfTheFullFile) {
  const std::string none = "output.modes=none";
  ASSERT_EQ(run("full.h5").status, 0);
  const Ended ended = run("less.h5", set({none}));
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_LT(fs::file_size(path("less.h5")), fs::file_size(path("full.h5")) / 2);
  EXPECT_THAT(check_result(path("less.h5")).faults, IsEmpty());

  Content full = content_of(path("full.h5"));
  const Content less = content_of(path("less.h5"));
  for (const char* body : {"resonator", "slider"})
    for (const char* motion : {"displacement", "velocity"})
      EXPECT_EQ(full.erase(fmt::format("{}/{}", body, motion)), 1u);
  EXPECT_TRUE(less == full);
  EXPECT_TRUE(less.contains("summary/lv_low"));

  const nlohmann::json a = analysis("full.h5"), b = analysis("less.h5");
  for (const char* same : {"lv", "lv_interval", "no_interval", "shocks", "energy", "contact_share",
                           "probes", "natural_frequencies"})
    EXPECT_EQ(a[same], b[same]) << same;
  EXPECT_FALSE(a["lv_interval"].is_null());
  for (const char* same : {"psd_force", "psd_probe", "frequency"})
    EXPECT_EQ(a["spectrum"][same], b["spectrum"][same]) << same;
  EXPECT_EQ(a["bands"]["level_probe"], b["bands"]["level_probe"]);
  for (const nlohmann::json& value : b["spectrum"]["psd_mean"]) ASSERT_TRUE(value.is_null());
  for (const nlohmann::json& value : b["bands"]["level"]) ASSERT_TRUE(value.is_null());
  EXPECT_THAT(b["peaks"], IsEmpty());

  const std::string why = "the file has no motion of the modes (output.modes)";
  const Ended part = ra2d({"analyze", path("less.h5"), "--from", "0.1", "--a-weighting"});
  EXPECT_EQ(part.status, 0) << part.err;
  EXPECT_THAT(part.out, HasSubstr("level Lv         none of a part of the run: " + why));
  EXPECT_THAT(part.out, HasSubstr("third octaves    none: " + why));
  EXPECT_THAT(part.out, Not(HasSubstr("nan")));
  EXPECT_THROW(ResultReader(path("less.h5")).columns("slider/velocity", 0, 1, 0, 1), RequestError);
}

TEST_F(Kept, FloatsAreTheDoublesRounded) {
  const std::vector<std::string> shorter{"scene.duration=0.02"};
  ASSERT_EQ(run("double.h5", set(shorter)).status, 0);
  ASSERT_EQ(run("float.h5", set({shorter[0], "output.precision=float"})).status, 0);
  EXPECT_THAT(check_result(path("float.h5")).faults, IsEmpty());
  const ResultReader a(path("double.h5")), b(path("float.h5"));
  const SampleBlock x = a.samples(0, a.contents().samples), y = b.samples(0, b.contents().samples);
  EXPECT_EQ(x.time, y.time);
  EXPECT_EQ(x.nodes, y.nodes);
  for (const auto member :
       {&SampleBlock::resonator_velocity, &SampleBlock::slider_displacement, &SampleBlock::force,
        &SampleBlock::probe_velocity, &SampleBlock::load_work}) {
    std::vector<double> rounded = x.*member;
    for (double& value : rounded) value = static_cast<double>(static_cast<float>(value));
    EXPECT_EQ(rounded, y.*member);
    EXPECT_NE(x.*member, y.*member);
  }
  EXPECT_EQ(a.contents().summary.lv, b.contents().summary.lv);
  EXPECT_EQ(a.contents().shocks.size(), b.contents().shocks.size());
  EXPECT_EQ(a.contents().summary.energy_residual, b.contents().summary.energy_residual);
}

TEST_F(Kept, CompressionLosesNothingAndADamagedBitIsFound) {
  const std::string shorter = "scene.duration=0.02";
  ASSERT_EQ(run("plain.h5", set({shorter})).status, 0);
  ASSERT_EQ(run("small.h5", set({shorter, "output.compression=deflate"})).status, 0);
  EXPECT_LT(fs::file_size(path("small.h5")), fs::file_size(path("plain.h5")));
  EXPECT_TRUE(content_of(path("small.h5")) == content_of(path("plain.h5")));
  EXPECT_EQ(ra2d({"check", path("small.h5")}).status, 0);

  const std::string whole = read_file(path("small.h5"));
  for (std::size_t i = 1; i < 12; ++i) {
    std::string damaged = whole;
    damaged[whole.size() / 12 * i] ^= static_cast<char>(1 << i % 8);
    std::ofstream(path("small.h5"), std::ios::binary) << damaged;
    EXPECT_EQ(ra2d({"check", path("small.h5")}).status, 4) << i;
  }
}

/// A checkpoint keeps all that the report needs of the modes: the segments do not have them.
TEST_F(Kept, ACutRunWithoutModesGoesOnToTheSameBits) {
  const std::vector<std::string> less =
      set({"output.modes=none", "output.precision=float", "output.compression=deflate"});
  ASSERT_EQ(run("whole.h5", less).status, 0);
  std::vector<std::string> cut = less;
  cut.insert(cut.end(), {"--checkpoint", "1e-5", "--max-wall", "0.01"});
  int parts = 0;
  while (run("parts.h5", cut).status == 5 && ++parts < 3) continue;
  EXPECT_GT(parts, 0);
  ASSERT_EQ(run("parts.h5", less).status, 0);
  EXPECT_TRUE(content_of(path("parts.h5")) == content_of(path("whole.h5")));
}

TEST_F(Kept, WrongWordsAreRefused) {
  for (const auto& [value, says] :
       {std::pair{"output.modes=some", "expected \"all\" or \"none\""},
        {"output.precision=half", "expected \"double\" or \"float\""},
        {"output.compression=9", "output.compression"},
        {"output.window=[0.1]", "no stretch of the run"},
        {"output.window=[0.2, 0.1]", "no stretch of the run"},
        {"output.window=[0.2, 7]", "no stretch of the run"},
        {"output.window=[-1, 0.1]", "no stretch of the run"},
        {"output.window=[0.1, 0.100001]", "has no room for two samples"}}) {
    const Ended ended = run("none.h5", set({value}));
    EXPECT_EQ(ended.status, 2) << value;
    EXPECT_THAT(ended.err, HasSubstr(says)) << value;
  }
}

// ---- more --------------------------------------------------------------------------------------

/// The strongest shock is that of the run, to the last bit, with enough samples to see it.
void expect_same_shock(const ResultReader& run, const ResultReader& zoom) {
  const ResultContents &a = run.contents(), &b = zoom.contents();
  const double peak = std::max_element(a.shocks.begin(), a.shocks.end(), [](auto& x, auto& y) {
                        return x.peak_force < y.peak_force;
                      })->peak_force;
  const auto is_strongest = [&](const Shock& shock) { return shock.peak_force == peak; };
  const auto in_a = std::find_if(a.shocks.begin(), a.shocks.end(), is_strongest),
             in_b = std::find_if(b.shocks.begin(), b.shocks.end(), is_strongest);
  ASSERT_NE(in_b, b.shocks.end());
  EXPECT_EQ(in_a->serial, in_b->serial);
  EXPECT_EQ(in_a->start, in_b->start);
  EXPECT_EQ(in_a->duration, in_b->duration);
  EXPECT_EQ(in_a->impulse, in_b->impulse);
  EXPECT_EQ(in_a->position, in_b->position);

  EXPECT_NEAR(b.start, std::max(0.0, in_a->start - 1e-4), 1 / b.rate);
  EXPECT_NEAR(b.end, in_a->start + in_a->duration + 2e-4, 1 / b.rate);
  const std::vector<double> force = zoom.column("contact/force", 0, b.samples);
  const auto touching = std::count_if(force.begin(), force.end(), [](double f) { return f > 0; });
  EXPECT_GE(static_cast<double>(touching), in_a->duration * b.rate - 2);
  const double highest = *std::max_element(force.begin(), force.end());
  EXPECT_GT(highest, 0.8 * peak);
}

TEST_F(Kept, TheShockInAZoomIsTheShockOfTheRun) {
  const std::vector<std::string> shorter = set({"scene.duration=0.05"});
  ASSERT_EQ(run("alone.h5", shorter).status, 0);
  std::vector<std::string> zoom = shorter;
  zoom.insert(zoom.end(), {"--zoom", "strongest=2", "--zoom", "0.01,0.011"});
  Ended ended = run("out.h5", zoom);
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("at 1.6 MHz in"));
  EXPECT_TRUE(content_of(path("out.h5")) == content_of(path("alone.h5")));
  const ResultReader whole(path("out.h5")), first(path("out.zoom-1.h5"));
  expect_same_shock(whole, first);
  EXPECT_EQ(first.contents().rate, 1.6e6);
  EXPECT_EQ(ResultReader(path("out.zoom-3.h5")).contents().samples, 1601u);
  // every sixteenth sample is one of the run
  const ResultReader third(path("out.zoom-3.h5"));
  const auto zoomed_velocity = third.columns("resonator/velocity", 0, 1601, 3, 1).front(),
             velocity = whole.columns("resonator/velocity", 1000, 101, 3, 1).front();
  for (std::size_t j = 0; j < velocity.size(); ++j)
    EXPECT_NEAR(zoomed_velocity[16 * j], velocity[j], 1e-9 * std::abs(velocity[j]) + 1e-15);
  for (int number : {1, 2, 3})
    EXPECT_EQ(ra2d({"check", path(fmt::format("out.zoom-{}.h5", number))}).status, 0);
  EXPECT_EQ(ra2d({"analyze", path("out.zoom-1.h5")}).status, 0);

  // all is there: nothing is run again
  const auto made = fs::last_write_time(path("out.zoom-1.h5"));
  ended = run("out.h5", zoom);
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_EQ(fs::last_write_time(path("out.zoom-1.h5")), made);
  // another window does not take the place of one
  ended = run("out.h5", {"--set", "scene.duration=0.05", "--zoom", "0.02,0.021"});
  EXPECT_EQ(ended.status, 2);
  EXPECT_THAT(ended.err, HasSubstr("out.zoom-1.h5' is there already"));
}

TEST_F(Kept, WindowsOfAnotherRunAreNamed) {
  const auto changed = [&](const std::string& change, const std::vector<std::string>& more) {
    std::vector<std::string> words = set({"scene.duration=0.02", change});
    words.insert(words.end(), more.begin(), more.end());
    return run("out.h5", words);
  };
  const std::string as_before = "contact.stiffness=1e15", other = "contact.stiffness=1e14";
  ASSERT_EQ(changed(as_before, {"--zoom", "0.005,0.006", "--zoom", "0.001,0.002"}).status, 0);
  // another name makes no other run
  Ended ended = changed("scene.name=\"renamed\"", {});
  EXPECT_EQ(ended.status, 0);
  EXPECT_THAT(ended.err, Not(HasSubstr("windows of another run")));

  ended = changed(other, {"--force"});
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("windows of another run"));
  for (const char* name : {"out.zoom-1.h5", "out.zoom-2.h5"})
    EXPECT_THAT(ended.err, HasSubstr(fmt::format("'{}'", path(name))));
  // as it says: those that are made anew are the run's own
  ended = changed(other, {"--zoom", "0.005,0.006", "--force"});
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_THAT(ended.err,
              HasSubstr(fmt::format("'{}': '{}'. Remove", path("out.h5"), path("out.zoom-2.h5"))));
  fs::remove(path("out.zoom-2.h5"));
  std::ofstream(path("out.zoom-3.h5")) << "no result";
  ended = changed(other, {});
  EXPECT_THAT(ended.err, Not(HasSubstr("windows of another run")));
}

TEST_F(Kept, TheOutcomeIsPrintedAlsoWhereAWindowIsRefused) {
  const auto outcome = [&](const std::vector<std::string>& zoom) {
    std::vector<std::string> words = set({"scene.duration=0.02"});
    words.insert(words.end(), zoom.begin(), zoom.end());
    words.emplace_back("--json");
    const Ended ended = run("out.h5", words);
    EXPECT_EQ(ended.status, 2);
    EXPECT_FALSE(ended.err.empty());
    return nlohmann::json::parse(ended.out);
  };
  for (const bool was_there : {false, true}) {
    const auto none = outcome({"--zoom", "shock=99999999"});
    EXPECT_EQ(none["was_there"], was_there);
    EXPECT_EQ(none["complete"], true);
    EXPECT_EQ(none["exit_status"], 2);
    EXPECT_EQ(none["resumable"], false);
    EXPECT_TRUE(none["zooms"].empty());
  }
  ASSERT_EQ(run("out.h5", {"--set", "scene.duration=0.02", "--zoom", "0.001,0.002"}).status, 0);
  const auto taken = outcome({"--zoom", "0.003,0.004"});
  EXPECT_EQ(taken["complete"], true);
  EXPECT_EQ(taken["exit_status"], 2);
}

/// A name to which the run's own files can be added, and the window's no more.
TEST_F(Kept, AWindowThatCannotBeWrittenIsNoSuccess) {
  const std::string name = std::string(230, 'a') + ".h5";
  std::vector<std::string> words = set({"scene.duration=0.01"});
  words.insert(words.end(), {"--zoom", "0.001,0.002", "--json"});
  const Ended ended = run(name, words);
  EXPECT_EQ(ended.status, 4);
  EXPECT_THAT(ended.err, HasSubstr("File name too long"));
  const auto outcome = nlohmann::json::parse(ended.out);
  EXPECT_EQ(outcome["complete"], true);
  EXPECT_EQ(outcome["exit_status"], 4);
  EXPECT_TRUE(outcome["zooms"].empty());
  EXPECT_EQ(ra2d({"check", path(name)}).status, 0);
}

TEST_F(Kept, FixedStepsZoomToOneSampleAStep) {
  std::vector<std::string> words =
      set({"scene.duration=0.02", "time.scheme=backward-euler", "time.step=5e-7"});
  words.insert(words.end(), {"--zoom", "strongest=1", "--zoom-rate", "2e6"});
  const Ended ended = run("out.h5", words);
  ASSERT_EQ(ended.status, 0) << ended.err;
  expect_same_shock(ResultReader(path("out.h5")), ResultReader(path("out.zoom-1.h5")));
}

TEST_F(Kept, AZoomThatIsCutOffGoesOn) {
  const std::vector<std::string> zoom = {"--set", "scene.duration=0.4", "--zoom", "0.39,0.395"};
  ASSERT_EQ(run("out.h5", {"--set", "scene.duration=0.4"}).status, 0);
  std::vector<std::string> cut = zoom;
  cut.insert(cut.end(), {"--checkpoint", "1e-5", "--max-wall", "0.01", "--json"});
  const Ended ended = run("out.h5", cut);
  EXPECT_EQ(ended.status, 5) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("out.zoom-1.h5, marked as cut short"));
  const auto outcome = nlohmann::json::parse(ended.out);
  EXPECT_EQ(outcome["complete"], true) << "the run itself";
  EXPECT_EQ(outcome["resumable"], true);
  EXPECT_EQ(outcome["exit_status"], 5);
  EXPECT_TRUE(outcome["zooms"].empty());
  ASSERT_EQ(run("out.h5", zoom).status, 0);
  ASSERT_EQ(run("other.h5", zoom).status, 0);
  EXPECT_TRUE(content_of(path("out.zoom-1.h5")) == content_of(path("other.zoom-1.h5")));
}

TEST_F(Kept, ZoomsThatCannotBeAreRefusedBeforeTheRun) {
  for (const auto& [words, says] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--zoom", "strongest"}, "expected strongest=N"},
           {{"--zoom", "strongest=0"}, "expected strongest=N"},
           {{"--zoom", "strongest=-1"}, "expected strongest=N"},
           {{"--zoom", "strongest=99999999999999999999"}, "expected strongest=N"},
           {{"--zoom", "shock=1.5"}, "expected strongest=N"},
           {{"--zoom", "0.2,0.1"}, "expected strongest=N"},
           {{"--zoom", "nan,1"}, "expected strongest=N"},
           {{"--zoom", "0.1,inf"}, "expected strongest=N"},
           {{"--zoom", "0.1;0.2"}, "expected strongest=N"},
           {{"--zoom", ""}, "expected strongest=N"},
           {{"--zoom", "0.5,2"}, "the run ends at 1 s"},
           {{"--zoom", "0.5,0.5000001"}, "no two samples fit"},
           {{"--zoom", "0.1,0.2", "--zoom-rate", "1e9"}, "at most 1e+07 Hz"},
           {{"--zoom", "0.1,0.2", "--zoom-rate", "1e5"}, "more than output.rate"},
           {{"--zoom-rate", "1e6"}, "expected --zoom, too"},
           {{"--set", "output.rate=2e6", "--zoom", "0.1,0.2"}, "is 2e+06 Hz already"},
           {{"--set", "time.scheme=backward-euler", "--set", "time.step=1e-6", "--zoom", "0.1,0.2",
             "--zoom-rate", "2e6"},
            "at most 1e+06 Hz, 1/time.step"},
           {{"--set", "time.scheme=backward-euler", "--set", "time.step=1e-5", "--zoom", "0.1,0.2"},
            "there is nothing between two samples"}}) {
    const Ended ended = run("out.h5", words);
    EXPECT_EQ(ended.status, 2) << words.back();
    EXPECT_THAT(ended.err, HasSubstr(says)) << words.back();
    EXPECT_FALSE(fs::exists(path("out.h5"))) << words.back();
  }
  const Ended ended = run("out.h5", {"--set", "scene.duration=0.01", "--zoom", "shock=999999"});
  EXPECT_EQ(ended.status, 2);
  EXPECT_THAT(ended.err, HasSubstr("no shock of that number"));
}

/// Of which the motion's bits depend.
TEST(Zoom, KeepsTheClock) {
  for (const double duration : {0.0123, 1.0, 77.7, 3000.0})
    for (const double rate : {100e3, 44.1e3, 1.0}) {
      const Scene scene = read_scene(
          scene_file("dang2012"),
          {fmt::format("scene.duration={}", duration), fmt::format("output.rate={}", rate),
           "scene.speed=1e-6", "resonator.max_frequency=300", "time.scheme=adaptive"});
      const double begin = 0.5 * duration;
      const Scene zoom = zoomed(scene, {begin, begin + 1e-3, {}}, {});
      const Model a = make_model(scene), b = make_model(zoom);
      EXPECT_EQ(a.tick, b.tick) << duration << " s, " << rate << " Hz";
      EXPECT_GE(zoom.output.rate, 1e6);
      EXPECT_LT(zoom.output.rate, 2e6 + rate);
      EXPECT_LE(b.steps, a.steps);
      EXPECT_NEAR(static_cast<double>(b.first_sample) / zoom.output.rate, begin, 1e-6);
      EXPECT_NEAR(static_cast<double>(b.kept_samples()), 1e-3 * zoom.output.rate, 1.5);
    }
}

}  // namespace
}  // namespace ra2d::test
