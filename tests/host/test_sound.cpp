// SPDX-License-Identifier: BSD-3-Clause
#include "host/sound/sound.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/result/level.hpp"
#include "host/store/store.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A velocity over time, m/s at s.
using Motion = std::function<double(double)>;

Motion sine(double amplitude, double frequency, double phase = 0.3) {
  return [=](double t) { return amplitude * std::sin(2 * M_PI * frequency * t + phase); };
}

std::vector<double> sampled(const Motion& motion, std::size_t count, double rate) {
  std::vector<double> values(count);
  for (std::size_t j = 0; j < count; ++j) values[j] = motion(static_cast<double>(j) / rate);
  return values;
}

// ---- the resampler -----------------------------------------------------------------------------

/// Fed in pieces of odd lengths.
std::vector<double> resampled(const std::vector<double>& in, double from, double to) {
  std::vector<double> out;
  const TakeSamples take = [&](std::span<const double> samples) {
    out.insert(out.end(), samples.begin(), samples.end());
  };
  Resampler resampler(from, to);
  for (std::size_t done = 0, now = 1; done < in.size(); done += now, now = now * 3 + 1)
    resampler.feed(std::span(in).subspan(done, std::min(now, in.size() - done)), take);
  resampler.finish(take);
  return out;
}

struct Rates {
  double from, to;
};
const std::vector<Rates> rates{{100e3, 48e3},     {100e3, 44.1e3}, {100e3, 96e3}, {1e6, 48e3},
                               {51234.5, 48e3},   {44.1e3, 48e3},  {20e3, 48e3},  {5e3, 48e3},
                               {100e3 / 7, 48e3}, {250, 48e3}};

/// Largest error of the middle of a signal against a motion.
double largest_error(const std::vector<double>& values, const Motion& motion, double rate) {
  double largest = 0;
  for (std::size_t i = values.size() / 4; i < 3 * values.size() / 4; ++i)
    largest = std::max(largest, std::abs(values[i] - motion(static_cast<double>(i) / rate)));
  return largest;
}

/// An error of 1e-3 of the amplitude would be 0.009 dB, or a delay of a thousandth of a radian;
/// asked is a hundred times less.
TEST(Resampler, KeepsAmplitudeAndTimeOfWhatIsBelowHalfTheRate) {
  for (const auto& [from, to] : rates)
    for (const double share : {0.01, 0.1, 0.5, 0.9}) {
      const Motion motion = sine(1, share * std::min(from, to) / 2);
      const auto samples = static_cast<std::size_t>(std::max(4000.0, 4000 * from / to));
      const std::vector<double> out = resampled(sampled(motion, samples, from), from, to);
      EXPECT_LT(largest_error(out, motion, to), 1e-5) << from << " to " << to << " Hz: " << share;
    }
}

TEST(Resampler, LetsNothingThroughFromAboveHalfTheNewRate) {
  for (const auto& [from, to] : rates)
    for (const double share : {1.0, 1.02, 1.2, 1.5, 2.0, 3.3}) {
      const double frequency = share * to / 2;
      if (frequency > from / 2) continue;
      const auto samples = static_cast<std::size_t>(4000 * from / to);
      const auto out = resampled(sampled(sine(1, frequency), samples, from), from, to);
      EXPECT_LT(largest_error(out, sine(0, 1), to), 1e-5)  // -100 dB
          << from << " to " << to << " Hz: " << frequency << " Hz";
    }
}

/// Anything above half the old rate after resampling to a higher one would be an image.
TEST(Resampler, MakesNoImages) {
  for (const double frequency : {100.0, 2000.0, 2270.0}) {
    const auto out = resampled(sampled(sine(1, frequency), 4000, 5e3), 5e3, 48e3);
    EXPECT_LT(largest_error(out, sine(1, frequency), 48e3), 1e-5) << frequency;
  }
}

TEST(Resampler, GoesFromTheFirstSampleToTheLast) {
  for (const auto& [from, to] : rates)
    for (const std::size_t count : {1, 2, 3, 10, 1000, 4801}) {
      const double last = static_cast<double>(count - 1) / from;  // s
      const auto out = resampled(std::vector<double>(count, 1.0), from, to);
      ASSERT_EQ(out.size(), resampled_count(count, from, to)) << from << " to " << to;
      EXPECT_LE(static_cast<double>(out.size() - 1) / to, last * (1 + 1e-12) + 1e-12);
      EXPECT_GT(static_cast<double>(out.size()) / to, last * (1 - 1e-12));
    }
  EXPECT_EQ(resampled_count(100'001, 100e3, 48e3), 48'001u);
  EXPECT_EQ(resampled_count(0, 100e3, 48e3), 0u);
}

TEST(Resampler, LeavesASignalOfTheSameRateAsItIs) {
  const std::vector<double> in = sampled(sine(1, 777), 1234, 48e3);
  EXPECT_EQ(resampled(in, 48e3, 48e3), in);
}

TEST(Sound, FullScaleIsTheNextRoundVelocity) {
  for (const auto& [peak, scale] : {std::pair{1.0, 1.0},
                                    {1.0001, 2.0},
                                    {2.0, 2.0},
                                    {2.1, 5.0},
                                    {5e-3, 5e-3},
                                    {5.1e-3, 1e-2},
                                    {9.99e-7, 1e-6},
                                    {0.0, 1.0},
                                    {3e-300, 5e-300},
                                    {0.1, 0.1},
                                    {1e-3, 1e-3},
                                    {720.0, 1000.0}})
    EXPECT_EQ(round_full_scale(peak), scale) << peak;
}

// ---- files -------------------------------------------------------------------------------------

struct Heard {
  SF_INFO info{};
  std::vector<double> values;
  std::string comment, title;
};

Heard listen(const fs::path& file) {
  Heard heard;
  SNDFILE* sound = sf_open(file.c_str(), SFM_READ, &heard.info);
  EXPECT_NE(sound, nullptr) << file << ": " << sf_strerror(nullptr);
  if (sound == nullptr) return heard;
  heard.values.resize(static_cast<std::size_t>(heard.info.frames));
  EXPECT_EQ(sf_read_double(sound, heard.values.data(), heard.info.frames), heard.info.frames);
  const auto text = [&](int type) {
    const char* found = sf_get_string(sound, type);
    return std::string(found == nullptr ? "" : found);
  };
  heard.comment = text(SF_STR_COMMENT);
  heard.title = text(SF_STR_TITLE);
  sf_close(sound);
  return heard;
}

class SoundFile : public testing::Test {
 protected:
  /// A result whose probes move like this, those of the slider at last; 100 kHz unless told
  /// otherwise.
  void write(const std::vector<Motion>& probes, std::size_t samples, double rate = 100e3,
             const std::vector<double>& modes = {100, 18.9e3},
             const std::vector<Motion>& on_slider = {}) const {
    ResultHeader header;
    header.scene = "[scene]\n";  // of no use: the run begins at 0 and ends with its samples
    header.started = "now";
    header.spacing = 8e-6;
    for (ModesHeader* body : {&header.resonator, &header.slider}) {
      body->frequency = body == &header.resonator ? modes : std::vector<double>{0};
      body->position = {0, 1};
      body->shape.resize(2 * body->frequency.size());
      body->mean_square = std::vector<double>(body->frequency.size());
    }
    for (std::size_t p = 0; p < probes.size(); ++p)
      header.probe_position.push_back(0.1 * static_cast<double>(p + 1));
    for (std::size_t p = 0; p < on_slider.size(); ++p)
      header.slider_probe_position.push_back(0.01 * static_cast<double>(p));
    ResultFile file(result_, header);
    SampleBlock b;
    for (std::size_t j = 0; j < samples; ++j) {
      const double t = static_cast<double>(j) / rate;
      b.time.push_back(t);
      for (auto* each : {&b.resonator_displacement, &b.resonator_velocity})
        each->insert(each->end(), modes.size(), 0.0);
      for (const Motion& motion : probes) {
        b.probe_displacement.push_back(0);
        b.probe_velocity.push_back(motion(t));
      }
      for (const Motion& motion : on_slider) {
        b.slider_probe_displacement.push_back(0);
        b.slider_probe_velocity.push_back(motion(t));
      }
      for (auto* one : {&b.slider_displacement, &b.slider_velocity, &b.force, &b.nodes, &b.kinetic,
                        &b.elastic, &b.contact, &b.damping_loss, &b.sliding_work, &b.load_work})
        one->push_back(0);
    }
    file.append(b);
    ResultSummary summary;
    summary.lv = level(summary.v_rms);
    summary.ended = "complete";
    file.close(summary);
  }
  SoundFacts make(const SoundOptions& options = {}, const std::string& name = "noise.wav") const {
    const ProbeSound sound(result_, options);
    write_sound(sound, folder_.path() / name);
    return sound.facts();
  }
  Heard heard(const std::string& name = "noise.wav") const { return listen(folder_.path() / name); }
  test::Ended ra2d(std::vector<std::string> words) const {
    words.insert(words.begin(), {test::program(), "sound", "out.h5"});
    return test::run_program(folder_.path(), words);
  }
  /// Names in the folder, but those of the test's own.
  std::vector<std::string> left() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      if (const std::string name = entry.path().filename();
          name != "out.h5" && name != "stdout" && name != "stderr")
        names.push_back(name);
    return names;
  }
  const test::Folder folder_;
  const fs::path result_ = folder_.path() / "out.h5";
};

TEST_F(SoundFile, IsTheVelocityOverFullScale) {
  const Motion motion = sine(3e-3, 1000);
  write({motion}, 100'001);
  const SoundFacts facts = make();
  EXPECT_EQ(facts.full_scale, 5e-3);
  EXPECT_NEAR(facts.peak / 3e-3, 1, 0.1);  // the sine begins and ends at once, so it rings there
  EXPECT_EQ(facts.frames, 48'001u);
  EXPECT_THAT(facts.doubts, testing::IsEmpty());
  const Heard sound = heard();
  EXPECT_EQ(sound.info.format, SF_FORMAT_WAV | SF_FORMAT_FLOAT);
  EXPECT_EQ(sound.info.samplerate, 48'000);
  EXPECT_EQ(sound.info.channels, 1);
  ASSERT_EQ(sound.values.size(), 48'001u);
  EXPECT_LT(largest_error(sound.values, sine(0.6, 1000), 48e3), 1e-5);
  EXPECT_THAT(sound.comment, HasSubstr("the value 1.0 is 0.005 m/s"));
}

TEST_F(SoundFile, IsTheSameInFlacToItsLastBit) {
  write({sine(3e-3, 1000)}, 50'001);
  make({}, "noise.wav");
  make({}, "NOISE.FLAC");
  const Heard wav = heard(), flac = heard("NOISE.FLAC");
  EXPECT_EQ(flac.info.format & SF_FORMAT_TYPEMASK, SF_FORMAT_FLAC);
  EXPECT_EQ(flac.info.format & SF_FORMAT_SUBMASK, SF_FORMAT_PCM_24);
  EXPECT_THAT(flac.comment, HasSubstr("the value 1.0 is 0.005 m/s"));
  ASSERT_EQ(flac.values.size(), wav.values.size());
  for (std::size_t i = 0; i < wav.values.size(); ++i)
    ASSERT_NEAR(flac.values[i], wav.values[i], 0x1p-24 + 0x1p-25);  // half a step, and a float's
}

TEST_F(SoundFile, OfASlowedRunIsLongerAndLower) {
  const Motion motion = sine(3e-3, 5000);
  write({motion}, 20'001);
  const SoundOptions options{.slow = 20};
  const SoundFacts facts = make(options);
  EXPECT_EQ(facts.frames, 192'001u);  // 0.2 s make 4 s
  const Heard sound = heard();
  EXPECT_LT(largest_error(sound.values, sine(0.6, 250), 48e3), 1e-5);
  EXPECT_THAT(sound.comment, HasSubstr("20 times slower"));
}

TEST_F(SoundFile, TakesAProbeAPartAndARate) {
  const Motion second = sine(0.7, 440);
  write({sine(1, 1000), second}, 100'001);
  SoundOptions options{.probe = 2, .rate = 44'100, .from = 0.25, .to = 0.75};
  const SoundFacts facts = make(options);
  EXPECT_EQ(facts.position, 0.2);
  EXPECT_EQ(facts.from, 0.25);
  EXPECT_EQ(facts.to, 0.75);
  const Heard sound = heard();
  EXPECT_EQ(sound.info.samplerate, 44'100);
  ASSERT_EQ(sound.values.size(), 22'051u);
  EXPECT_LT(largest_error(
                sound.values, [&](double t) { return second(t + 0.25); }, 44.1e3),
            1e-5);
}

TEST_F(SoundFile, OfTheSliderWhenAsked) {
  const Motion second = sine(0.3, 700);
  write({sine(1, 1000)}, 20'001, 100e3, {100, 60e3}, {sine(1, 500), second});
  const SoundFacts facts = make({.probe = 2, .body = ProbeOf::slider});
  EXPECT_EQ(facts.position, 0.01);
  EXPECT_THAT(facts.doubts, testing::IsEmpty());  // the resonator's modes are not in it
  const Heard sound = heard();
  EXPECT_LT(largest_error(
                sound.values, [&](double t) { return second(t) / 0.5; }, 48e3),
            1e-5);
  EXPECT_THAT(sound.comment, HasSubstr("velocity of slider probe 2 at 0.01 m"));
  const test::Ended said = ra2d({"--slider-probe", "2", "-o", "same.wav"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("velocity of slider probe 2 at 0.01 m"));
  EXPECT_EQ(heard("same.wav").values, sound.values);
  EXPECT_THAT(test::read_file(folder_.path() / "same.wav.json"),
              AllOf(HasSubstr("\"body\": \"slider\""), HasSubstr("\"probe\": 2")));
}

TEST_F(SoundFile, IsNormalisedOnlyWhenAsked) {
  write({sine(3e-3, 1000)}, 100'001);
  const SoundFacts facts = make({.normalize = true});
  EXPECT_EQ(facts.full_scale, facts.peak);
  const std::vector<double> values = heard().values;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  EXPECT_EQ(std::max(-*low, *high), 1);
}

TEST_F(SoundFile, AFullScaleThatNoFloatCanFollowIsRefused) {
  write({sine(3e-3, 1000)}, 10'001);
  for (const char* scale : {"1e-300", "1e-42", "1e300"}) {
    const test::Ended said = ra2d({"-o", "n.wav", "--full-scale", scale});
    EXPECT_EQ(said.status, 2) << scale;
    EXPECT_THAT(said.err,
                AllOf(HasSubstr("--full-scale"), HasSubstr("expected a velocity near the peak")));
    EXPECT_FALSE(fs::exists(folder_.path() / "n.wav"));
  }
  // what a float holds is written, and a FLAC that would be silent is doubted
  EXPECT_EQ(ra2d({"-o", "n.wav", "--full-scale", "1e-38"}).status, 0);
  for (const float value : heard("n.wav").values) ASSERT_TRUE(std::isfinite(value));
  EXPECT_THAT(ra2d({"-o", "n.flac", "--full-scale", "1e6"}).err, HasSubstr("is silent"));
}

TEST_F(SoundFile, ANumberOfAProbeIsNotCutShortInItsMessage) {
  write({sine(3e-3, 1000)}, 1'001);
  const test::Ended said = ra2d({"--probe", "99999999999999999999"});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err,
              AllOf(HasSubstr("'99999999999999999999'"), testing::Not(HasSubstr("1000000000"))));
  EXPECT_THAT(ra2d({"--probe", "999999999"}).err, HasSubstr("999999999"));
}

TEST_F(SoundFile, SaysWhatIsBeyondFullScale) {
  write({sine(3e-3, 1000)}, 100'001);
  const SoundOptions options{.full_scale = 1e-3};
  const SoundFacts facts = make(options);
  make(options, "noise.flac");
  const std::vector<double> wav = heard().values, flac = heard("noise.flac").values;
  const auto beyond =
      std::count_if(wav.begin(), wav.end(), [](double value) { return std::abs(value) > 1; });
  EXPECT_NEAR(static_cast<double>(beyond), static_cast<double>(facts.beyond), 2);  // of floats
  EXPECT_NEAR(static_cast<double>(beyond) / 48e3, 1 - 2 / M_PI * std::asin(1 / 3.0), 1e-2);
  EXPECT_NEAR(*std::max_element(wav.begin() + 100, wav.end() - 100), 3, 1e-2);
  EXPECT_EQ(*std::max_element(flac.begin(), flac.end()), 1 - 0x1p-23);
  EXPECT_EQ(*std::min_element(flac.begin(), flac.end()), -1);
  const test::Ended said = ra2d({"-o", "n.flac", "--full-scale", "1e-3"});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.err, HasSubstr(fmt::format("{} of 48001 samples are beyond", facts.beyond)));
}

TEST_F(SoundFile, OfSilenceIsSilentAndSaysSo) {
  write({sine(0, 1)}, 10'001);
  const test::Ended said = ra2d({"-o", "noise.wav", "--normalize"});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.err, HasSubstr("silence: the probe at 0.1 m does not move"));
  EXPECT_THAT(heard().values, testing::Each(0));
}

TEST_F(SoundFile, SaysWhatTheRatesLeaveOut) {
  write({sine(1, 100)}, 10'001, 20e3, {0, 100, 9e3, 12e3, 15e3});
  EXPECT_THAT(ra2d({}).err, AllOf(HasSubstr("2 of the resonator's modes ring above 10000 Hz"),
                                  HasSubstr("output.rate above 3e+04")));
  write({sine(1, 100)}, 10'001, 20e3, {0, 100, 9e3});
  EXPECT_THAT(ra2d({}).err, AllOf(HasSubstr("nothing above 10000 Hz"), HasSubstr("= 40000")));
  EXPECT_EQ(ra2d({"--quiet"}).err, "");
  write({sine(1, 100)}, 10'001, 100e3, {0, 100, 9e3});
  EXPECT_EQ(ra2d({}).err, "");
  EXPECT_THAT(ra2d({"--rate", "16000"}).err, HasSubstr("1 of the resonator's modes are left out"));
}

TEST_F(SoundFile, HasItsScaleBesideIt) {
  write({sine(3e-3, 1000)}, 10'001);
  const test::Ended said = ra2d({"-o", "noise.wav", "--slow", "2"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, AllOf(HasSubstr("1.0 in the file is 0.005 m/s"), HasSubstr("200 ms, 9601 "),
                              HasSubstr("noise.wav.json")));
  const std::string text = test::read_file(folder_.path() / "noise.wav.json");
  EXPECT_THAT(
      text, AllOf(HasSubstr("\"file\": \"noise.wav\""), HasSubstr("\"probe\": 1"),
                  HasSubstr("\"position\": 0.1"), HasSubstr("\"full_scale_m_per_s\": 0.005"),
                  HasSubstr("\"peak_m_per_s\": 0.00"), HasSubstr("\"rate\": 48000"),
                  HasSubstr("\"slow\": 2.0"), HasSubstr("\"from\": 0.0"), HasSubstr("\"to\": 0.1"),
                  HasSubstr("\"source\": \"out.h5\""), HasSubstr("\"version\": \"0.")));
  const std::string bytes = test::read_file(folder_.path() / "noise.wav");
  EXPECT_EQ(ra2d({"-o", "noise.wav", "--slow", "2"}).status, 0);
  EXPECT_EQ(test::read_file(folder_.path() / "noise.wav"), bytes);  // the same every time
}

TEST_F(SoundFile, RefusesWhatItCannotDoAndLeavesNothing) {
  write({}, 1001);
  const auto refused = [&](std::vector<std::string> words, const std::string& why) {
    const test::Ended said = ra2d(words);
    EXPECT_EQ(said.status, 2) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_THAT(said.err, HasSubstr(why));
    EXPECT_EQ(said.out, "");
    EXPECT_THAT(left(), testing::IsEmpty());
  };
  refused({}, "output.probes = [0.15]");
  refused({"--slider-probe", "1"}, "output.slider_probes = [0.01]");
  write({}, 1001, 100e3, {100}, {sine(1, 100)});
  refused({}, "(there is 1 of the slider: --slider-probe 1)");
  refused({"--slider-probe", "2"}, "--slider-probe 2: expected 1 to 1 (at 0 m)");
  refused({"--slider-probe", "1", "--probe", "1"}, "excludes");
  write({sine(1, 100), sine(1, 100)}, 1001);
  refused({"--probe", "3"}, "expected 1 to 2 (at 0.1, 0.2 m)");
  refused({"--probe", "0"}, "--probe");
  refused({"--slow", "0.5"}, "--slow");
  refused({"--slow", "nan"}, "--slow");
  refused({"--rate", "100"}, "--rate");
  refused({"--rate", "44100.5"}, "--rate");
  refused({"--full-scale", "0"}, "--full-scale");
  refused({"--full-scale", "1", "--normalize"}, "--normalize");
  refused({"--from", "0.005", "--to", "0.004"}, "there is nothing");
  refused({"--to", "7"}, "the run ends at 0.01 s");
  refused({"--from", "0.009995"}, "there is one sample");
  refused({"-o", "noise.mp3"}, "expected a name that ends in .wav or .flac");
  refused({"-o", "out.h5"}, "expected a name that ends in .wav or .flac");
}

TEST_F(SoundFile, NeverReplacesTheResult) {
  write({sine(1, 100)}, 1001);
  fs::rename(result_, folder_.path() / "result.wav");
  fs::copy(folder_.path() / "result.wav", folder_.path() / "x.wav.json");
  const auto run = [&](const char* in, const char* out) {
    return test::run_program(folder_.path(), {test::program(), "sound", in, "-o", out});
  };
  const std::string bytes = test::read_file(folder_.path() / "result.wav");
  EXPECT_THAT(run("result.wav", "result.wav").err, HasSubstr("would be overwritten"));
  EXPECT_THAT(run("x.wav.json", "x.wav").err, HasSubstr("would be overwritten"));
  EXPECT_EQ(test::read_file(folder_.path() / "result.wav"), bytes);
  EXPECT_EQ(test::read_file(folder_.path() / "x.wav.json"), bytes);
  EXPECT_FALSE(fs::exists(folder_.path() / "x.wav"));
}

TEST_F(SoundFile, ThatCannotBeWrittenLeavesNothing) {
  write({sine(1, 100)}, 100'001);
  for (const char* name : {"noise.wav", "noise.flac"}) {
    const test::Ended said = test::run_program(
        folder_.path(),
        {"/bin/sh", "-c",
         fmt::format("ulimit -f 8; exec '{}' sound out.h5 -o {}", test::program(), name)});
    EXPECT_EQ(said.status, 4);
    EXPECT_THAT(said.err, AllOf(HasSubstr(name), HasSubstr("File too large")));
    EXPECT_THAT(left(), testing::IsEmpty());
  }
  fs::create_directory(folder_.path() / "noise.wav.json");  // where the scale should stand
  EXPECT_EQ(ra2d({"-o", "noise.wav"}).status, 2);
  EXPECT_FALSE(fs::exists(folder_.path() / "noise.wav"));
}

/// A run, as a user makes it.
TEST(SoundOfARun, LastsAsLongAsTheRunFromOutputFromOn) {
  const test::Folder folder;
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), test::program());
    return test::run_program(folder.path(), words);
  };
  const test::Ended ran =
      run({"run", test::scene_file("dang2012"), "-o", "a.h5", "--set", "scene.duration=0.1",
           "--set", "output.from=0.02", "--set", "time.scheme=adaptive", "--set",
           "time.tolerance=1e-5", "--set", "scene.name=\"hiss\\u001b[2J\""});
  ASSERT_EQ(ran.status, 0) << ran.err;
  const test::Ended said = run({"sound", "a.h5"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_EQ(said.err, "");
  const Heard sound = listen(folder.path() / "a.wav");
  EXPECT_EQ(sound.values.size(), 3841u);
  EXPECT_THAT(sound.title, AllOf(HasSubstr("hiss"), Not(HasSubstr("\x1b"))));
  const double peak =
      std::abs(*std::max_element(sound.values.begin(), sound.values.end(),
                                 [](double a, double b) { return std::abs(a) < std::abs(b); }));
  EXPECT_GT(peak, 0.35);  // of the next round full scale
  EXPECT_LE(peak, 1);
}

}  // namespace
}  // namespace ra2d
