// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "host/analysis/analysis.hpp"
#include "host/analysis/analysis_text.hpp"
#include "host/analysis/bands.hpp"
#include "host/base/fourier.hpp"
#include "host/radiation/resistance.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

/// The sound of results at microphones, by the program and by the library.
namespace ra2d {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Sounds : public testing::Test {
 protected:
  test::Ended ra2d(std::vector<std::string> words) const {
    words.insert(words.begin(), test::program());
    return test::run_program(folder_.path(), words);
  }
  void run(const std::string& name, const std::vector<std::string>& sets = {}) const {
    std::vector<std::string> words{"run", test::scene_file("dang2012"), "-o", name, "--quiet"};
    for (const char* set : {"time.scheme=adaptive", "time.tolerance=1e-6", "scene.duration=0.1"})
      words.insert(words.end(), {"--set", set});
    for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
    const test::Ended ended = ra2d(words);
    ASSERT_EQ(ended.status, 0) << ended.err;
  }
  const test::Folder folder_;
};

/// Microphones on a hemisphere above the plate, each with the area that it stands for.
struct Hemisphere {
  std::vector<Position> places;
  std::vector<double> areas;  // m^2
};
Hemisphere hemisphere(double r) {
  constexpr int around = 16;
  const Points polar = even_points(0, M_PI / 2, 0, {12, 1, 1});
  Hemisphere found;
  for (std::size_t i = 0; i < polar.size(); ++i)
    for (int j = 0; j < around; ++j) {
      const double angle = polar.at[i], turn = 2 * M_PI * j / around;
      found.places.push_back({0.15 + r * std::sin(angle) * std::cos(turn),
                              0.1 + r * std::sin(angle) * std::sin(turn), r * std::cos(angle)});
      found.areas.push_back(polar.weight[i] * std::sin(angle) * 2 * M_PI / around * r * r);
    }
  return found;
}

/// The power by the resistances is that which passes a hemisphere of microphones.
TEST_F(Sounds, PowerIsWhatPassesAHemisphere) {
  run("a.h5", {"scene.duration=0.5", "output.rate=10e3", "resonator.max_frequency=1e3"});
  AnalysisOptions options;
  options.from = 0.05;
  options.sound.power = true;
  const Hemisphere around = hemisphere(3);
  options.sound.microphones = around.places;
  const Analysis a = analyze(folder_.path() / "a.h5", options);
  ASSERT_EQ(a.microphones.size(), around.places.size());
  double passed_power = 0;
  for (std::size_t i = 0; i < a.microphones.size(); ++i)
    passed_power += around.areas[i] * a.microphones[i].rms * a.microphones[i].rms /
                    (a.air.density * a.air.sound_speed);
  EXPECT_NEAR(passed_power / a.power->watts, 1, 0.05);  // 9 ms of 0.45 s are others
  EXPECT_NEAR(a.microphones[0].lp, 20 * std::log10(a.microphones[0].rms / 20e-6), 1e-12);
  EXPECT_NEAR(a.microphones[0].arrives, a.microphones[0].distance / a.air.sound_speed, 1e-15);
  EXPECT_NEAR(a.power->lw, 10 * std::log10(a.power->watts / 1e-12), 1e-12);
  // a mode's damping by the air, 2 zeta m omega = R of both sides
  const double stiff = 2 * M_PI * a.power->mode_frequency[0] * 7800 * 0.002;
  EXPECT_NEAR(a.power->mode_damping[0],
              a.power->mode_efficiency[0] * a.air.density * a.air.sound_speed / stiff, 1e-9);
}

/// A free plate moves off under the slider's load. Where the record is cut off its velocity is
/// large, and only what its acceleration radiates counts: band by band what passes a hemisphere.
TEST_F(Sounds, PowerOfAPlateThatMovesOff) {
  run("a.h5", {"scene.duration=0.5", "output.rate=10e3", "resonator.max_frequency=2e3",
               "resonator.support=free", "scene.initial=rest"});
  AnalysisOptions options;
  options.from = 0.05;
  options.sound.power = true;
  const Hemisphere around = hemisphere(3);
  options.sound.microphones = around.places;
  const Analysis a = analyze(folder_.path() / "a.h5", options);
  const std::vector<int>& bands = a.microphones[0].number;
  ASSERT_EQ(a.microphones.size(), around.places.size());
  ASSERT_GT(bands.size(), 8u);
  double found = 0, passed_power = 0;
  for (std::size_t j = 0; j < a.power->number.size(); ++j)
    if (std::find(bands.begin(), bands.end(), a.power->number[j]) != bands.end())
      found += 1e-12 * std::pow(10, a.power->level[j] / 10);
  for (std::size_t i = 0; i < a.microphones.size(); ++i)
    for (const double level : a.microphones[i].level)
      passed_power +=
          around.areas[i] * 4e-10 * std::pow(10, level / 10) / (a.air.density * a.air.sound_speed);
  EXPECT_NEAR(passed_power / found, 1, 0.05);  // 9 ms of 0.45 s are others
}

/// The power takes resistances between frequencies by a polynomial. Against those of each line.
TEST_F(Sounds, PowerIsTheSumOverAllLines) {
  run("a.h5", {"output.rate=20e3", "resonator.max_frequency=3e3", "scene.duration=0.05"});
  const std::filesystem::path file = folder_.path() / "a.h5";
  AnalysisOptions options;
  options.sound.power = true;
  const double found = analyze(file, options).power->watts;
  const ResultReader reader(file);
  const SoundingResonator resonator =
      sounding_resonator(reader, scene_of(reader.contents(), file), file, {});
  const std::size_t samples = reader.contents().samples, modes = resonator.face.modes.size();
  const double rate = reader.contents().rate;
  Fourier fourier(quick_length(samples));
  std::vector<std::vector<std::complex<double>>> lines;
  for (const auto& velocity : velocity_record(reader).read(0, samples)) {
    const auto input = fourier.input();
    std::fill(input.begin(), input.end(), 0.0);
    for (std::size_t n = 0; n < samples; ++n)  // without what the record's ends make
      input[n] = velocity[n] - std::lerp(velocity.front(), velocity.back(),
                                         static_cast<double>(n) / static_cast<double>(samples - 1));
    fourier.transform();
    lines.emplace_back(fourier.spectrum().begin(), fourier.spectrum().end());
  }
  const RadiationResistance resistance(resonator.face, resonator.air, rate / 2);
  double sum = 0;
  for (std::size_t j = 1; j < fourier.lines(); ++j) {
    const std::vector<double> half = resistance.lower_half(
        std::min(rate / 2, static_cast<double>(j) * rate / static_cast<double>(fourier.length())));
    for (std::size_t k = 0, at = 0; k < modes; ++k)
      for (std::size_t l = 0; l <= k; ++l, ++at)
        sum += (2 * j == fourier.length() ? 1 : 2) * (k == l ? 1 : 2) * half[at] *
               std::real(lines[k][j] * std::conj(lines[l][j]));
  }
  sum /= static_cast<double>(samples) * static_cast<double>(fourier.length());
  EXPECT_NEAR(found / sum, 1, 1e-5);
}

/// Bands add up to the level, and weigh as the norm says.
TEST_F(Sounds, BandsAddUpToTheLevel) {
  run("a.h5", {"scene.duration=0.8"});
  AnalysisOptions options;
  options.sound.microphones = {{0.15, 0.1, 0.5}, {0.15, 0.1, -0.5}};
  const Analysis a = analyze(folder_.path() / "a.h5", options);
  const MicrophoneLevels& m = a.microphones[0];
  double sum = 0, weighted = 0;
  for (std::size_t i = 0; i < m.number.size(); ++i) {
    sum += std::pow(10, m.level[i] / 10);
    weighted += std::pow(10, m.level_a[i] / 10);
    EXPECT_NEAR(m.level_a[i] - m.level[i], a_weighting(third_octave_centre(m.number[i])), 3);
  }
  EXPECT_NEAR(10 * std::log10(sum), m.lp, 0.3);
  EXPECT_NEAR(10 * std::log10(weighted), m.lp_a, 0.3);
  EXPECT_NEAR(m.lp, a.microphones[1].lp, 1e-9);  // below the plate the sign alone differs
  EXPECT_NEAR(m.from, m.arrives, 1e-5);
  EXPECT_NEAR(m.to, 0.8, 1e-12);  // the way of the sound covers what the filter needs
  EXPECT_LT(m.intervals.level.low, m.lp);
  EXPECT_GT(m.intervals.level.high, m.lp);
}

TEST_F(Sounds, HotThinAirIsQuieter) {
  run("a.h5");
  AnalysisOptions options;
  options.sound.power = true;
  const double usual = analyze(folder_.path() / "a.h5", options).power->lw;
  options.sound.pascal = 50'662.5;
  // half the density at the same speed of sound
  EXPECT_NEAR(analyze(folder_.path() / "a.h5", options).power->lw, usual - 10 * std::log10(2.0),
              1e-9);
  options.sound.celsius = 80;
  EXPECT_LT(analyze(folder_.path() / "a.h5", options).power->lw, usual - 10 * std::log10(2.0));
}

TEST_F(Sounds, SaysWhatTheLibraryFinds) {
  run("a.h5");
  run("b.h5", {"slider.surface.seed=7"});
  AnalysisOptions options;
  options.sound.microphones = {{0.15, 0.1, 0.5}, {-0.2, 0.1, 0.3}};
  options.sound.power = true;
  Analysis found = analyze(folder_.path() / "a.h5", options);
  found.file = "a.h5";
  const std::vector<std::string> options_of_sound{"--at", "0.15,0.1,0.5", "--at", "-0.2,0.1,0.3",
                                                  "--power"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), options_of_sound.begin(), options_of_sound.end());
    return words;
  };
  const test::Ended json = ra2d(with({"analyze", "a.h5", "--json"}));
  EXPECT_EQ(json.status, 0) << json.err;
  EXPECT_EQ(json.out, json_of({found}));
  const auto said = nlohmann::json::parse(json.out);
  EXPECT_EQ(said["microphones"][1]["position"], (std::vector<double>{-0.2, 0.1, 0.3}));
  EXPECT_EQ(said["microphones"][0]["lpa"], found.microphones[0].lp_a);
  EXPECT_EQ(said["power"]["lw"], found.power->lw);
  EXPECT_EQ(said["power"]["bands"]["efficiency"].size(), found.power->number.size());
  const test::Ended text = ra2d(with({"analyze", "a.h5", "--csv", "x"}));
  EXPECT_THAT(
      text.out,
      AllOf(HasSubstr(fmt::format("{:.2f} dB re 20 uPa, {:.2f} dB(A)", found.microphones[1].lp,
                                  found.microphones[1].lp_a)),
            HasSubstr("sound power"), HasSubstr("the slider's own sound; modes above 18.87 kHz"),
            HasSubstr("0.00146 s to 0.1 s, 1.46 ms or more after the motion"),
            HasSubstr("x-{spectrum,bands,shocks,sound,sound-level}.csv")));
  // the level in time: ten on the screen, and all parts in a table, whose mean is the level
  EXPECT_THAT(text.out,
              HasSubstr("in time          dB re 20 uPa, over 0.0098 s each from 0.00146 s on"));
  std::ifstream times(folder_.path() / "x-sound-level.csv");
  std::string line;
  std::getline(times, line);
  EXPECT_EQ(line, "microphone,x_m,y_m,z_m,from_s,to_s,p_rms_Pa,lp_dB");
  double squares = 0;
  int parts = 0;
  while (std::getline(times, line) && line.starts_with("1,")) {
    std::vector<std::string> fields{""};
    for (const char c : line) c == ',' ? fields.emplace_back() : fields.back() += c;
    ASSERT_EQ(fields.size(), 8u);
    squares += std::pow(std::stod(fields[6]), 2);
    EXPECT_NEAR(std::stod(fields[7]), 20 * std::log10(std::stod(fields[6]) / 20e-6), 1e-9);
    ++parts;
  }
  EXPECT_NEAR(10 * std::log10(squares / parts / 4e-10), found.microphones[0].lp, 0.1);
  std::ifstream csv(folder_.path() / "x-sound.csv");
  std::string header, first;
  std::getline(csv, header);
  std::getline(csv, first);
  EXPECT_THAT(header, HasSubstr("level_dB"));
  EXPECT_THAT(first, HasSubstr("microphone 1,0.15,0.1,0.5,"));
  const auto means = nlohmann::json::parse(ra2d(with({"analyze", "a.h5", "b.h5", "--json"})).out);
  const double a = means["files"][0]["microphones"][0]["lpa"],
               b = means["files"][1]["microphones"][0]["lpa"];
  EXPECT_NE(a, b);
  EXPECT_NEAR(means["mean"]["microphones.1.lpa"]["mean"], (a + b) / 2, 1e-9);
}

/// The scene's microphones end the report; they and the air change nothing of the run.
TEST_F(Sounds, OfTheScenesMicrophonesEndTheReport) {
  const std::vector<std::string> words{
      "run",   test::scene_file("dang2012"), "-o",    "a.h5",
      "--set", "time.scheme=adaptive",       "--set", "scene.duration=0.1"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    return more;
  };
  const std::string place = "output.microphones=[{ x = 0.15, y = 0.1, z = 0.5 }]";
  const test::Ended first = ra2d(with({"--set", place, "--set", "air.temperature=30"}));
  ASSERT_EQ(first.status, 0) << first.err;
  AnalysisOptions options;
  options.sound.microphones = {{0.15, 0.1, 0.5}};
  const auto level = [&] {
    return analyze(folder_.path() / "a.h5", options).microphones.at(0).lp_a;
  };
  const std::string line = first.out.substr(first.out.find("microphone 1"));
  EXPECT_THAT(line, HasSubstr(fmt::format("{:.2f} dB(A)", level())));  // in the scene's air
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  options.sound.celsius = 20;
  const test::Ended again = ra2d(with({"--set", place, "--json"}));
  const auto said = nlohmann::json::parse(again.out);
  EXPECT_EQ(said["was_there"], true);
  EXPECT_EQ(said["microphones"][0]["lpa"], level());
  const auto is_said = HasSubstr("'a.h5' keeps the microphones and the air that it was made with");
  EXPECT_THAT(again.err, is_said);  // air of 30 C
  EXPECT_THAT(ra2d(with({"--set", place, "--set", "air.temperature=30"})).err, Not(is_said));
  // the file's own scene has the first microphone: analyze needs no --at
  options = {};
  EXPECT_EQ(analyze(folder_.path() / "a.h5", options).microphones.size(), 1u);
  // one that nothing reaches is said, and the run is done
  const test::Ended far =
      ra2d(with({"--set", "output.microphones=[{ x = 0.15, y = 0.1, z = 90 }]", "--fresh"}));
  EXPECT_EQ(far.status, 0);
  EXPECT_THAT(far.out, HasSubstr("microphones      none: "));
  EXPECT_THAT(ra2d({"analyze", "a.h5"}).out, HasSubstr("sound            none: "));
}

TEST_F(Sounds, SaysWhatTheRecordCannotCarry) {
  run("a.h5", {"output.rate=20e3"});
  EXPECT_THAT(
      ra2d({"analyze", "a.h5", "--at", "0.1,0.1,1"}).out,
      AllOf(HasSubstr("nothing above 9100 Hz"), HasSubstr("modes lie above half the rate")));
}

/// Of two samples the power came out as 2e-41 W. There is no total of a stretch that carries no
/// band with modes; means over the samples there are.
/// The silence before the sound comes is no part of its level.
TEST_F(Sounds, LevelsBeginWhenTheSoundArrives) {
  run("a.h5");
  AnalysisOptions options;
  options.sound.microphones = {{0.15, 0.1, 20}};
  const MicrophoneLevels far = analyze(folder_.path() / "a.h5", options).microphones[0];
  EXPECT_GE(far.from, far.arrives);
  EXPECT_LT(far.from, far.arrives + 2e-5);
  options.from = far.from;
  const MicrophoneLevels heard = analyze(folder_.path() / "a.h5", options).microphones[0];
  EXPECT_EQ(heard.lp, far.lp);
  EXPECT_EQ(heard.history.mean_square, far.history.mean_square);
}

TEST_F(Sounds, OfAShortStretchHasNoTotals) {
  run("a.h5");
  AnalysisOptions options;
  options.sound.microphones = {{0.15, 0.1, 0.5}};
  options.sound.power = true;
  options.a_weighting = true;
  options.from = 0.05;
  for (const auto& [to, is_known] :
       {std::pair{0.05001, false}, {0.0502, false}, {0.05085, false}, {0.05087, true}}) {
    options.to = to;
    const Analysis a = analyze(folder_.path() / "a.h5", options);
    const MicrophoneLevels& m = a.microphones[0];
    for (const double total : {m.lp_a, m.above.all, m.above.a_weighted, a.power->watts, a.power->lw,
                               a.power->lw_a, a.power->above.all, a.power->above.a_weighted,
                               a.power->efficiency, a.power->share_of_damping, a.lv_a})
      EXPECT_EQ(std::isfinite(total), is_known) << to;
    EXPECT_NEAR(m.lp, 20 * std::log10(m.rms / 20e-6), 1e-12);
    const std::vector<bool> above = bands_above_modes(a, a.power->number);
    EXPECT_EQ(std::find(above.begin(), above.end(), false) != above.end(), is_known) << to;
    for (const double level : a.power->level) EXPECT_GT(level, 0);
    const auto said = nlohmann::json::parse(json_of({a}));
    EXPECT_EQ(said["power"]["lwa"].is_number(), is_known);
    EXPECT_EQ(said["power"]["no_lw"], said["microphones"][0]["no_lpa"]);
    EXPECT_EQ(said["power"]["no_lw"] == "", is_known);
  }
  options.to = 0.05001;
  // four cycles of the width of the band of 20 kHz
  const std::string least =
      "the stretch is too short: the third octave of 20000 Hz, the highest that modes and samples "
      "reach, takes 0.000873 s or more";
  EXPECT_THAT(describe(analyze(folder_.path() / "a.h5", options)),
              AllOf(HasSubstr("sound power      not known: " + least + "\n"),
                    HasSubstr("dB re 20 uPa at 0.15, 0.1, 0.5 m; dB(A) not known: " + least),
                    Not(HasSubstr("nan"))));
  EXPECT_NEAR(shortest_stretch(18.87e3, 100e3), 4 / (0.2307 * 19'953), 1e-6);
  EXPECT_NEAR(shortest_stretch(18.87e3, 10e3), 4 / (0.2307 * 3981), 1e-5);  // of 4 kHz
  EXPECT_NEAR(shortest_stretch(std::nan(""), 10e3), 4 / (0.2307 * 3981), 1e-5);
  // in a report, and in the levels of a study: the end of the record is not heard yet
  const test::Ended short_run = ra2d(
      {"run", test::scene_file("dang2012"), "-o", "s.h5", "--set", "time.scheme=adaptive", "--set",
       "scene.duration=0.0014", "--set", "output.microphones=[{ x = 0.15, y = 0.1, z = 0.2 }]"});
  EXPECT_THAT(short_run.out, HasSubstr("at 0.15, 0.1, 0.2 m; dB(A) not known: " + least));
  const std::filesystem::path file = folder_.path() / "s.h5";
  const SoundLevels levels = sound_levels(*scene_of(ResultReader(file).contents(), file), file);
  EXPECT_TRUE(std::isfinite(levels.lp) && std::isnan(levels.lp_a) && std::isfinite(levels.lw));
  EXPECT_EQ(levels.why_none, "no dB(A) at the microphones: " + least);
}

/// Of a plate with few modes most of the level is that of their flanks.
TEST_F(Sounds, WarnsWhereTheLevelComesFromAboveTheLastMode) {
  run("a.h5");
  run("few.h5",
      {"resonator.max_frequency=2e3", "output.microphones=[{ x = 0.15, y = 0.1, z = 0.5 }]"});
  AnalysisOptions options;
  options.sound.microphones = {{0.15, 0.1, 0.5}};
  options.sound.power = true;
  const std::string warning = "% of the A-weighted power lies above the last mode";
  EXPECT_THAT(describe(analyze(folder_.path() / "a.h5", options)), Not(HasSubstr(warning)));
  const Analysis few = analyze(folder_.path() / "few.h5", options);
  const std::string text = describe(few);
  const std::size_t first = text.find(warning);
  ASSERT_NE(first, std::string::npos);
  EXPECT_NE(text.find(warning, first + 1), std::string::npos) << "once for each total";
  const MicrophoneLevels& m = few.microphones[0];
  const std::vector<bool> above = bands_above_modes(few, m.number);
  const auto share_of = [&above](const std::vector<double>& levels) {
    double share = 0, all = 0;
    for (std::size_t i = 0; i < above.size(); ++i) {
      const double power = std::pow(10, levels[i] / 10);
      all += power;
      share += above[i] ? power : 0;
    }
    return share / all;
  };
  EXPECT_NEAR(m.above.a_weighted, share_of(m.level_a), 0.01);
  EXPECT_NEAR(m.above.all, share_of(m.level), 0.01);
  EXPECT_GT(m.above.a_weighted, 0.5);
  const auto json = nlohmann::json::parse(json_of({few}));
  EXPECT_EQ(json["power"]["share_above_last_mode"], few.power->above.a_weighted);
  EXPECT_EQ(json["power"]["unweighted_share_above_last_mode"], few.power->above.all);
  EXPECT_EQ(json["microphones"][0]["share_above_last_mode"], m.above.a_weighted);
  EXPECT_EQ(json["microphones"][0]["unweighted_share_above_last_mode"], m.above.all);
  const test::Ended again = ra2d({"run", test::scene_file("dang2012"), "-o", "few.h5", "--set",
                                  "time.scheme=adaptive", "--set", "time.tolerance=1e-6", "--set",
                                  "scene.duration=0.1", "--set", "resonator.max_frequency=2e3",
                                  "--set", "output.microphones=[{ x = 0.15, y = 0.1, z = 0.5 }]"});
  EXPECT_THAT(again.out, AllOf(HasSubstr("  warning "), HasSubstr(warning)));

  // with modes up to 7.5 kHz the filter A takes off what is above, the unweighted level has it
  run("more.h5", {"resonator.max_frequency=8e3", "output.rate=2e5"});
  const Analysis more = analyze(folder_.path() / "more.h5", options);
  EXPECT_LT(more.microphones[0].above.a_weighted, 0.2);
  EXPECT_GT(more.microphones[0].above.all, 0.25);
  EXPECT_THAT(warning_of(more.microphones[0]),
              HasSubstr("% of the unweighted power lies above the last mode"));
}

/// Where damping takes little, the air would take as much: the level is too high, and it is said.
TEST_F(Sounds, WarnsWhereTheAirWouldDampTheMotion) {
  run("a.h5");
  run("b.h5", {"resonator.damping=1e-4"});
  EXPECT_THAT(ra2d({"analyze", "a.h5", "--power"}).out, Not(HasSubstr("the air would damp")));
  const std::string said = ra2d({"analyze", "b.h5", "--power"}).out;
  EXPECT_THAT(said, HasSubstr("warning          the air would damp the motion"));
  AnalysisOptions options;
  options.sound.power = true;
  EXPECT_GT(analyze(folder_.path() / "b.h5", options).power->share_of_damping, 1);
  run("c.h5", {"resonator.damping=0"});
  EXPECT_THAT(ra2d({"analyze", "c.h5", "--power"}).out,
              AllOf(HasSubstr("the resonator's damping none"), Not(HasSubstr("take inf"))));
}

TEST_F(Sounds, RefusesWhatCannotBeHeard) {
  run("a.h5");
  run("none.h5", {"output.modes=none"});
  run("rigid.h5", {"resonator.support=rigid"});
  for (const auto& [words, status, why] :
       std::vector<std::tuple<std::vector<std::string>, int, std::string>>{
           {{"a.h5", "--at", "0.1,0.1,0"}, 2, "expected 0.001 m or more above it"},
           {{"a.h5", "--at", "0.1,0.1,-1e-4"}, 2, "expected 0.001 m or more above it"},
           {{"a.h5", "--at", "0.1,0.1,300"}, 2, "100 m at the most"},
           {{"a.h5", "--at", "0.1,0.1,50"}, 2, "nothing to hear"},
           {{"a.h5", "--at", "0.1,0.1"}, 2, "three numbers"},
           {{"a.h5", "--at", "0.1,0.1,nan"}, 2, "three numbers"},
           {{"a.h5", "--at", "0.1,0.1,1,"}, 2, "three numbers"},
           {{"a.h5", "--temperature", "30"}, 2, "--at x,y,z"},
           {{"a.h5", "--at", "0.1,0.1,1", "--temperature", "-300"}, 2, "from -50 to 100"},
           {{"none.h5", "--at", "0.1,0.1,1"}, 2, "output.modes"},
           {{"rigid.h5", "--power"}, 2, "makes no sound"}}) {
    std::vector<std::string> line{"analyze"};
    line.insert(line.end(), words.begin(), words.end());
    const test::Ended ended = ra2d(line);
    EXPECT_EQ(ended.status, status) << fmt::format("{}: {}", fmt::join(words, " "), ended.err);
    EXPECT_THAT(ended.err, HasSubstr(why)) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_EQ(ended.out, "");
  }
  std::vector<std::string> many{"analyze", "a.h5"};
  for (int i = 0; i < 9000; ++i) many.insert(many.end(), {"--at", "0.1,0.1,1"});
  EXPECT_THAT(ra2d(many).err, HasSubstr("take fewer at a time"));
  EXPECT_THAT(ra2d({"sound", "a.h5", "--at", "0,0,1", "--at", "1,0,1", "--at", "2,0,1"}).err,
              HasSubstr("one channel or two"));
  // pictures and pages: refused before Python is asked
  for (const auto& [words, why] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"plot", "a.h5", "--at", "0,0,1", "--what", "force"},
            "--what overview, bands or level"},
           {{"plot", "a.h5", "none.h5", "--at", "0,0,1", "--at", "1,0,1"},
            "a picture of several results has one"},
           {{"plot", "a.h5", "--at", "0,0,0"}, "expected 0.001 m or more"},
           {{"report", "a.h5", "--at", "0,0,0"}, "expected 0.001 m or more"},
           {{"report", "a.h5", "--temperature", "30"}, "name a microphone with --at x,y,z\n"}})
    EXPECT_THAT(ra2d(words).err, HasSubstr(why)) << fmt::format("{}", fmt::join(words, " "));
  EXPECT_THAT(ra2d({"sound", "a.h5", "--at", "0,0,1", "--probe", "1"}).err, HasSubstr("excludes"));
}

/// A WAV of floats: its values times full scale are pascals.
TEST_F(Sounds, OfTwoMicrophonesIsStereoInPascals) {
  RA2D_SKIP_WITHOUT_PYTHON();
  run("a.h5", {"scene.duration=0.3", "air.temperature=35"});
  const test::Ended made = ra2d({"sound", "a.h5", "--at", "0.15,0.1,0.5", "--at", "0.3,0,0.2",
                                 "--bits", "float", "--rate", "96000", "-o", "s.wav"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, AllOf(HasSubstr("sound pressure at 0.15, 0.1, 0.5 and 0.3, 0, 0.2 m"),
                              HasSubstr("left out         the slider's own sound; modes above 18.9 "
                                        "kHz, which were not kept")));
  EXPECT_THAT(ra2d({"sound", "a.h5", "-o", "v.wav"}).out,
              AllOf(HasSubstr("velocity of probe 1"), HasSubstr("no sound pressure")));
  std::ifstream sidecar(folder_.path() / "s.wav.json");
  const auto about = nlohmann::json::parse(sidecar);
  const double scale = about["full_scale_pa"];
  EXPECT_EQ(about["quantity"], "sound pressure");
  EXPECT_EQ(about["microphones"][1], (std::vector<double>{0.3, 0, 0.2}));
  std::ifstream file(folder_.path() / "s.wav", std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(bytes[22], 2);  // channels
  const std::size_t data = bytes.find("data") + 8;
  std::vector<float> values((bytes.size() - data) / sizeof(float));
  std::memcpy(values.data(), bytes.data() + data, values.size() * sizeof(float));
  AnalysisOptions options;
  options.sound.microphones = {{0.15, 0.1, 0.5}, {0.3, 0, 0.2}};
  const Analysis a = analyze(folder_.path() / "a.h5", options);
  EXPECT_NEAR(a.air.sound_speed, 351.9, 0.1);  // the scene's
  EXPECT_EQ(about["sound_speed"], a.air.sound_speed);
  for (std::size_t channel = 0; channel < 2; ++channel) {
    double sum = 0;
    for (std::size_t n = channel; n < values.size(); n += 2)
      sum += std::pow(static_cast<double>(values[n]) * scale, 2);
    const double rms = std::sqrt(sum / (static_cast<double>(values.size()) / 2));
    EXPECT_NEAR(rms / a.microphones[channel].rms, 1, 0.01) << channel;
  }
}

}  // namespace
}  // namespace ra2d
