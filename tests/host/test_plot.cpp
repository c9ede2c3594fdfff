// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/chart/chart_files.hpp"
#include "host/store/store.hpp"
#include "host/surface/envelope.hpp"
#include "host/surface/profile_series.hpp"
#include "host/system/partial_file.hpp"
#include "tests/child.hpp"
#include "tests/numbers.hpp"
#include "tests/places.hpp"
#include "tests/warm_python.hpp"

/// Pictures: the series of profiles that are handed to the Python package, and the command.
namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// ---- long series -------------------------------------------------------------------------------

TEST(Envelope, KeepsEveryExtremeOfALongSeries) {
  std::vector<double> at(100'003), values(at.size());
  std::iota(at.begin(), at.end(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(0.37 * at[i]);
  values[77'777] = 9;
  values[0] = -8;
  values.back() = -9;
  const std::vector<std::size_t> groups = even_groups(values.size(), 1000);
  const Envelope e = envelope(at, values, groups);
  ASSERT_EQ(e.at.size(), 1000u);
  EXPECT_EQ(e.largest_group, 101u);
  EXPECT_EQ(groups.front(), 0u);
  EXPECT_EQ(groups.back(), values.size());
  EXPECT_EQ(e.low.front(), -8);
  EXPECT_EQ(e.low.back(), -9);
  EXPECT_EQ(*std::max_element(e.high.begin(), e.high.end()), 9);
  double sum = 0;
  for (std::size_t g = 0; g + 1 < groups.size(); ++g) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(groups[g]),
               last = values.begin() + static_cast<std::ptrdiff_t>(groups[g + 1]);
    ASSERT_EQ(e.low[g], *std::min_element(first, last)) << g;
    ASSERT_EQ(e.high[g], *std::max_element(first, last)) << g;
    sum += e.mean[g] * static_cast<double>(last - first);
  }
  EXPECT_NEAR(sum, std::accumulate(values.begin(), values.end(), 0.0), 1e-9);
}

TEST(Envelope, LeavesFewValuesAlone) {
  const std::vector<double> at{0, 1, 2, 3}, values{5, nan, -1, 2};
  const Envelope e = envelope(at, values, even_groups(4, 2));
  EXPECT_EQ(e.largest_group, 1u);
  EXPECT_THAT(e.at, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(e.mean[0], 5);
  EXPECT_TRUE(std::isnan(e.mean[1]));
  const json written = e;
  EXPECT_FALSE(written.contains("low"));
  EXPECT_TRUE(envelope({}, {}, even_groups(0, 10)).at.empty());
}

TEST(Envelope, DoesNotCountWhatIsNoNumber) {
  const std::vector<double> at{0, 1, 2, 3, 4, 5}, values{nan, 3, nan, nan, 1, -1};
  const Envelope e = envelope(at, values, {0, 2, 4, 6});
  EXPECT_THAT(e.at, ElementsAre(0.5, 2.5, 4.5));
  EXPECT_EQ(e.low[0], 3);
  EXPECT_EQ(e.mean[0], 3);
  EXPECT_TRUE(std::isnan(e.high[1]));
  EXPECT_EQ(e.mean[2], 0);
}

// ---- what is handed over -----------------------------------------------------------------------

struct Made {
  std::size_t samples = 4000;
  double velocity = 1e-3, force = 7;
  bool probes = true, shocks = true, complete = true;
};

/// A result of a rigid and an elastic mode that swings at 1 kHz; the force is 0 but at sample 1234.
void make_result(const fs::path& path, const Made& made) {
  constexpr double rate = 48e3;
  ResultHeader header;
  header.scene = "[scene]\n";
  header.started = "now";
  header.spacing = 1e-3;
  for (ModesHeader* modes : {&header.resonator, &header.slider}) {
    modes->frequency = {0, 1000};
    modes->position = {0, 1};
    modes->shape = {1, 1, 2, 2};
    modes->mean_square = std::vector<double>{0, 4};
  }
  if (made.probes) header.probe_position = {0.15};
  header.resonator_height = {0, 1e-6, -2e-6, 0};
  header.slider_height = {0, 0};
  ResultFile file(path, header);
  SampleBlock b;
  for (std::size_t j = 0; j < made.samples; ++j) {
    const double t = static_cast<double>(j) / rate;
    b.time.push_back(t);
    const double v = made.velocity * std::sin(2 * M_PI * 1000 * t);
    for (auto* modes : {&b.resonator_velocity, &b.resonator_displacement, &b.slider_velocity,
                        &b.slider_displacement})
      modes->insert(modes->end(), {5.0, v});
    b.force.push_back(j == 1234 ? made.force : 0);
    if (made.probes)
      for (auto* one : {&b.probe_displacement, &b.probe_velocity}) one->push_back(-t);
    for (auto* one : {&b.nodes, &b.kinetic, &b.elastic, &b.contact}) one->push_back(0);
    b.damping_loss.push_back(2 * t);
    b.sliding_work.push_back(3 * t);
    b.load_work.push_back(0);
  }
  file.append(b);
  if (made.shocks)
    file.append({Shock{0, 1e-3, 2e-5, 3, 4e-5, 1e-3}, Shock{1, 2e-3, 3e-5, 4, 5e-5, 2e-3}});
  ResultSummary summary;
  summary.v_rms = made.velocity * std::sqrt(2.0);
  summary.lv = 20 * std::log10(summary.v_rms / 1e-9);
  summary.shock_rate = made.shocks ? 24 : 0;
  summary.complete = made.complete;
  summary.ended = made.complete ? "complete" : "interrupted";
  file.close(summary);
}

class ProfileSeries : public testing::Test {
 protected:
  const Folder folder_;
};

/// A sine of 1 um and 0.1 mm.
void make_profile(const fs::path& file, int points, bool gap = false) {
  std::string text = "x [mm];z [um]\n";
  for (int i = 0; i < points; ++i)
    text += gap && i == 7 ? fmt::format("{:.3f};nan\n", 0.002 * i)
                          : fmt::format("{:.3f};{:.6f}\n", 0.002 * i,
                                        5 + std::sin(2 * M_PI * 0.002 * i / 0.1));
  write_text(file, text);
}

TEST_F(ProfileSeries, AProfileHasItsParametersAndHeights) {
  const fs::path file = folder_.path() / "sine.txt";
  make_profile(file, 10'001);
  const json long_one = json::parse(profile_series(file, {}));
  EXPECT_EQ(long_one["cutoff"], 2.5e-3);
  EXPECT_EQ(long_one["sampling_lengths"], 5);
  EXPECT_NEAR(long_one["parameters"]["Rq"], 1e-6 / std::sqrt(2.0), 1e-9);
  EXPECT_EQ(long_one["line_is"], "mean line of the filter");
  const std::vector<double> shares = long_one["heights"]["shares"];
  EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1, 1e-9);
  EXPECT_NEAR(long_one["heights"]["rms"], long_one["parameters"]["Rq"], 1e-18);
  EXPECT_GT(shares.front(), shares[shares.size() / 2]);  // a sine stays longest at its ends
  const std::vector<double> high = long_one["profile"]["high"];
  EXPECT_NEAR(*std::max_element(high.begin(), high.end()), 1e-6, 1e-8);  // from its mean

  make_profile(file, 501);  // 1 mm: no room for the usual cut-off
  EXPECT_FALSE(json::parse(profile_series(file, {})).contains("cutoff"));
  const ProfileSeriesOptions short_waves{
      .query = {}, .measure = {.cutoff = 2e-4}, .usual_filter = false};
  EXPECT_EQ(json::parse(profile_series(file, short_waves))["cutoff"], 2e-4);
  make_profile(file, 501, true);
  const json gap = json::parse(profile_series(file, {}));
  EXPECT_EQ(gap["missing"], 1);
  EXPECT_TRUE(gap["profile"]["mean"][7].is_null());
  EXPECT_FALSE(gap.contains("parameters"));
  const json filled = json::parse(
      profile_series(file, {.query = {}, .measure = {.fill = 1e-5}, .usual_filter = true}));
  EXPECT_EQ(filled["missing"], 1);
  EXPECT_NEAR(filled["parameters"]["Rq"], 1e-6 / std::sqrt(2.0), 1e-9);
  EXPECT_TRUE(filled["profile"]["mean"][7].is_null());  // as measured
}

/// A sine on a parabola: the form is the parabola, and what is measured the sine.
TEST_F(ProfileSeries, AProfileLosesItsForm) {
  const fs::path file = folder_.path() / "bent.txt";
  std::string text = "x [mm];z [um]\n";
  const auto parabola = [](double x) { return 40 * (x - 0.5) * (x - 0.5); };  // um, of mm
  for (int i = 0; i < 1000; ++i)
    text += fmt::format("{:.4f};{:.9f}\n", 0.001 * i,
                        parabola(0.001 * i) + std::sin(2 * M_PI * (i + 0.5) / 20));
  write_text(file, text);
  ProfileSeriesOptions options{.query = {}, .measure = {}, .usual_filter = false};
  options.measure.form.degree = 2;
  options.measure.filter = ProfileFilter::none;
  const json found = json::parse(profile_series(file, options));
  EXPECT_EQ(found["line_is"], "form");
  EXPECT_EQ(found["filtered"], false);
  EXPECT_NEAR(found["parameters"]["Rq"], 1e-6 / std::sqrt(2.0), 1e-9);
  const std::vector<double> line = found["line"]["mean"], at = found["line"]["x"];
  ASSERT_EQ(line.size(), 1000u);
  // a sine of 50 whole periods leaves a parabola alone, but for 1/(pi 50) of its height
  for (std::size_t i = 0; i < line.size(); ++i)
    ASSERT_NEAR(line[i] - line[500], 1e-6 * (parabola(1e3 * at[i]) - parabola(1e3 * at[500])), 2e-8)
        << i;
}

// ---- what the program makes --------------------------------------------------------------------

class Plot : public testing::Test {
 protected:
  Ended plot(std::vector<std::string> words) const {
    words.insert(words.begin(), {program(), "plot"});
    return run_program(folder_.path(), words);
  }
  void simulate(const std::string& scene, const std::string& file) const {
    const Ended run = run_program(folder_.path(), {program(), "run", scene_file(scene), "--set",
                                                   "time.scheme=adaptive", "-o", file, "--quiet"});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  bool can_draw() const {
    static const bool imported =
        !python().empty() &&
        run_program(folder_.path(), {python(), "-c", "import matplotlib"}).status == 0;
    return imported;
  }
  fs::path file(const std::string& name) const { return folder_.path() / name; }
  /// Names in the folder, but for what the tests themselves leave there.
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      if (const std::string name = entry.path().filename(); name != "stdout" && name != "stderr")
        found.push_back(name);
    std::sort(found.begin(), found.end());
    return found;
  }
  const Folder folder_;
};
#define RA2D_SKIP_WITHOUT_MATPLOTLIB()           \
  if (!can_draw()) {                             \
    GTEST_SKIP() << "no Python with matplotlib"; \
  }                                              \
  static_assert(true)

/// Texts of an SVG, a line each.
std::string texts_of(const std::string& svg) {
  std::string texts;
  for (std::size_t at = 0; (at = svg.find("<text", at)) != svg.npos;) {
    const std::size_t begin = svg.find('>', at) + 1;
    at = svg.find('<', begin);
    texts += svg.substr(begin, at - begin) + '\n';
  }
  return texts;
}

/// Width and height of a PNG.
std::pair<unsigned, unsigned> size_of(const std::string& png) {
  const auto number = [&](std::size_t at) {
    unsigned value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = value << 8 | static_cast<unsigned char>(png[at + i]);
    return value;
  };
  return {number(16), number(20)};
}

TEST_F(Plot, MakesPicturesOfAResult) {
  RA2D_SKIP_WITHOUT_MATPLOTLIB();
  simulate("peaks", "peaks.h5");
  for (const std::string what : {"overview", "shocks"}) {  // host/python/tests has all
    const Ended run = plot({"peaks.h5", "--what", what, "-o", what + ".png"});
    ASSERT_EQ(run.status, 0) << what << ": " << run.err;
    EXPECT_EQ(run.err, "") << what;
    EXPECT_EQ(run.out, "written: " + what + ".png\n");
    const std::string png = read_file(file(what + ".png"));
    ASSERT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n") << what;
    const auto [width, height] = size_of(png);
    EXPECT_GE(width, 1200u) << what;
    EXPECT_LE(width, 1600u) << what;
    EXPECT_GE(height, 500u) << what;
    EXPECT_LT(png.size(), 1u << 20) << what;
    fs::remove(file(what + ".png"));
  }
  EXPECT_THAT(names(), ElementsAre("peaks.h5"));
}

TEST_F(Plot, SvgIsXmlThatHasItsLabelsAsText) {
  RA2D_SKIP_WITHOUT_MATPLOTLIB();
  const WarmPython warm;
  simulate("drop", "drop.h5");
  ASSERT_EQ(plot({"drop.h5", "-o", "drop.SVG"}).status, 0);
  const Ended read = run_program(
      folder_.path(), {python(), "-c",
                       "import xml.etree.ElementTree as e\n"
                       "print(*(t for n in e.parse('drop.SVG').iter() for t in [n.text] if t))"});
  ASSERT_EQ(read.status, 0) << read.err;
  EXPECT_THAT(read.out,
              AllOf(HasSubstr("drop.h5"), HasSubstr("time [ms]"), HasSubstr("force [N]"),
                    HasSubstr("displacement ["), HasSubstr("PSD of velocity [(m/s)\u00b2/Hz]"),
                    HasSubstr("frequency [Hz]"), HasSubstr("level [dB re 1 nm/s]"),
                    HasSubstr("place on the resonator [mm]"), HasSubstr("energy [")));
  EXPECT_THAT(read.out, AllOf(HasSubstr("duration ["), HasSubstr("natural frequencies")));
}

TEST_F(Plot, PdfSeveralResultsAndProfiles) {
  RA2D_SKIP_WITHOUT_MATPLOTLIB();
  const WarmPython warm;
  make_result(file("a.h5"), {});
  make_result(file("b$x^$.h5"), {.velocity = 0});
  make_result(file("c.h5"), {.complete = false});
  make_profile(file("sine.csv"), 501);
  EXPECT_EQ(plot({"a.h5", "-o", "a.pdf", "--what", "level"}).status, 0);
  EXPECT_EQ(read_file(file("a.pdf")).substr(0, 5), "%PDF-");
  const Ended three = plot({"a.h5", "b$x^$.h5", "c.h5", "-o", "several.svg"});
  EXPECT_EQ(three.status, 0) << three.err;
  EXPECT_THAT(texts_of(read_file(file("several.svg"))),
              AllOf(HasSubstr("a: 123.01 dB"), HasSubstr("b$x^$: at rest"),
                    HasSubstr("c: The run was cut short"), HasSubstr("midband frequency [Hz]")));
  std::vector<std::string> many(9, "a.h5");
  many.insert(many.end(), {"--what", "spectrum"});
  const Ended nine = plot(many);
  EXPECT_EQ(nine.status, 0) << nine.err;
  EXPECT_THAT(nine.err, HasSubstr("the first 8 of 9"));
  const Ended profile = plot({"sine.csv", "-o", "sine.svg", "--quiet"});
  EXPECT_EQ(profile.status, 0) << profile.err;
  EXPECT_EQ(profile.out, "");
  EXPECT_THAT(texts_of(read_file(file("sine.svg"))),
              AllOf(HasSubstr("height [\u00b5m]"), HasSubstr("Pq"), HasSubstr("706.4 nm"),
                    HasSubstr("Height distribution")));
  // the name that nobody gave
  EXPECT_THAT(names(), ElementsAre("a.h5", "a.pdf", "a.png", "b$x^$.h5", "c.h5", "several.svg",
                                   "sine.csv", "sine.svg"));
}

TEST_F(Plot, RefusesWhatCannotBeDrawn) {
  make_result(file("a.h5"), {});
  make_profile(file("sine.csv"), 501);
  write_text(file("text.txt"), "no profile\nat all\n");
  write_text(file("damaged.h5"), read_file(file("a.h5")).substr(0, 900));
  const std::vector<std::string> before = names();
  const auto refused = [&](std::vector<std::string> words, int status) {
    const Ended run = plot(words);
    EXPECT_EQ(run.status, status) << fmt::format("{}", fmt::join(words, " ")) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(names(), before);
    return run.err;
  };
  EXPECT_THAT(refused({"a.h5", "-o", "a.jpg"}, 2), HasSubstr(".png, .svg or .pdf"));
  EXPECT_THAT(refused({"a.h5", "-o", "a.h5"}, 2), HasSubstr(".png, .svg or .pdf"));
  EXPECT_THAT(refused({"a.h5", "--what", "spectrm"}, 2),
              AllOf(HasSubstr("did you mean 'spectrum'?"), HasSubstr("'bands'")));
  EXPECT_THAT(refused({"a.h5", "a.h5", "--what", "force"}, 2), HasSubstr("several results"));
  EXPECT_THAT(refused({"a.h5", "sine.csv"}, 2), HasSubstr("sine.csv"));
  EXPECT_THAT(refused({"sine.csv", "--what", "level"}, 2), HasSubstr("a profile"));
  EXPECT_THAT(refused({"sine.csv", "--x-unit", "inch"}, 2), HasSubstr("mm"));
  EXPECT_THAT(refused({"a.h5", "--cutoff", "1e-3"}, 2), HasSubstr("--cutoff is of profiles"));
  EXPECT_THAT(refused({"a.h5", "--row", "3"}, 2), HasSubstr("--row is of profiles"));
  EXPECT_THAT(refused({"sine.csv", "--form", "circle"}, 2), HasSubstr("poly:N"));
  EXPECT_THAT(refused({"text.txt"}, 2), HasSubstr("text.txt"));
  EXPECT_THAT(refused({"nowhere.h5"}, 4), HasSubstr("nowhere.h5"));
  EXPECT_THAT(refused({"."}, 4), HasSubstr("folder"));
  EXPECT_THAT(refused({"damaged.h5"}, 4), HasSubstr("damaged.h5"));
  EXPECT_THAT(refused({"a.h5", "-o", "no/such.png"}, 4), HasSubstr("no"));
  refused({}, 2);
  fs::copy(file("a.h5"), file("b.png"));
  EXPECT_EQ(plot({"b.png"}).status, 2);  // its own picture would replace it
  const Ended help = run_program(folder_.path(), {program(), "help", "plot"});
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("--what"), HasSubstr("spectrogram"), HasSubstr("PICTURE")));
}

/// The tables of a chart of accuracy, as they stand in bench/, and of stability, three lines long.
void make_charts(const fs::path& folder) {
  for (const char* name : {"accuracy.csv", "accuracy-long.csv"})
    fs::copy(source_folder() / "bench" / name, folder / name);
  const auto table = [&](std::size_t i, const std::string& comments, const std::string& rows) {
    const ChartKind& kind = stability_tables();
    write_text(chart_files(kind, folder / "stability")[i],
               comments + heading(kind.tables[i]) + rows);
  };
  table(0, "", "rk4,old,4,4,open,0.02,0.02,2.8,2.79,2.81,0.1,-0.002,-0.002\n");
  table(1, "", "rk4,old,open,0,2.828,-0,2.828\nrk4,old,open,0.5,2.9,-1.45,2.51\n");
  table(2, "# scene: my $x^$ scene\n# step: 1e-07 s\n",
        "open,resonator,0,52,0.02,-6e-07,3.3e-05\n");
}

TEST_F(Plot, AChartIsDrawnAgainFromItsTables) {
  RA2D_SKIP_WITHOUT_MATPLOTLIB();
  const WarmPython warm;
  make_charts(folder_.path());
  EXPECT_EQ(plot({"accuracy.csv"}).out, "written: accuracy.png\n");  // the other is beside it
  EXPECT_EQ(read_file(file("accuracy.png")).substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(plot({"accuracy-long.csv", "-o", "long.svg"}).status, 0);
  EXPECT_THAT(texts_of(read_file(file("long.svg"))),
              AllOf(HasSubstr("Speed against accuracy. Scene: roughness noise"),
                    HasSubstr("shocks a second"), HasSubstr("midpoint")));
  EXPECT_EQ(plot({"stability-modes.csv", "-o", "stability.svg"}).status, 0);
  EXPECT_THAT(texts_of(read_file(file("stability.svg"))),
              HasSubstr("Stability of the time schemes. Scene: my $x^$ scene, step 1e-07 s"));
  // by content, not by name
  fs::rename(file("stability.csv"), file("a.txt"));
  fs::rename(file("stability-regions.csv"), file("b"));
  fs::rename(file("stability-modes.csv"), file("c.h5"));
  const Ended renamed = plot({"b", "c.h5", "a.txt", "-o", "again.svg"});
  EXPECT_EQ(renamed.status, 0) << renamed.err;
  EXPECT_EQ(read_file(file("again.svg")), read_file(file("stability.svg")));
}

TEST_F(Plot, RefusesChartsThatAreNotWhole) {
  const WarmPython warm;
  make_charts(folder_.path());
  make_result(file("a.h5"), {});
  const auto refused = [&](std::vector<std::string> words, int status) {
    words.insert(words.end(), {"-o", "chart.png"});
    const Ended run = plot(words);
    EXPECT_EQ(run.status, status) << fmt::format("{}", fmt::join(words, " ")) << run.err;
    EXPECT_FALSE(fs::exists(file("chart.png")));
    return run.err;
  };
  EXPECT_THAT(refused({"accuracy.csv", "stability.csv"}, 2), HasSubstr("a picture of its own"));
  EXPECT_THAT(refused({"a.h5", "accuracy.csv"}, 2), HasSubstr("a.h5"));
  EXPECT_THAT(refused({"accuracy.csv", "accuracy.csv"}, 2), HasSubstr("the same table"));
  EXPECT_THAT(refused({"accuracy.csv", "--what", "level"}, 2), HasSubstr("a chart"));
  EXPECT_THAT(refused({"accuracy.csv", "--form", "line"}, 2), HasSubstr("--form is of profiles"));
  fs::rename(file("stability-regions.csv"), file("regions.csv"));
  EXPECT_THAT(refused({"stability.csv"}, 2),
              AllOf(HasSubstr("'stability-regions.csv'"), HasSubstr("ra2d plot PREFIX.csv")));
  EXPECT_THAT(refused({"regions.csv"}, 2), HasSubstr("name all of them"));
  const std::string table = read_file(file("accuracy.csv"));
  write_text(file("accuracy.csv"), table.substr(0, table.size() - 40));
  EXPECT_THAT(refused({"accuracy.csv"}, 4),
              AllOf(HasSubstr("accuracy.csv"), HasSubstr("cut short or damaged")));
  if (!can_draw()) return;
  std::string words = table;
  words.replace(words.find("0.0032681"), 9, "a lot____");
  write_text(file("accuracy.csv"), words);
  EXPECT_THAT(refused({"accuracy.csv"}, 4),
              AllOf(HasSubstr("chart.png was not made"), HasSubstr("'a lot____'")));
}

TEST_F(Plot, WithoutMatplotlibNothingIsLeftButTheCure) {
  make_result(file("a.h5"), {});
  write_text(file("matplotlib.py"), "raise ImportError\n");
  const std::vector<std::string> before = names();
  ASSERT_EQ(setenv("PYTHONPATH", folder_.path().c_str(), 1), 0);
  ASSERT_EQ(setenv("PYTHONDONTWRITEBYTECODE", "1", 1), 0);
  const Ended run = plot({"a.h5"});
  unsetenv("PYTHONPATH");
  unsetenv("PYTHONDONTWRITEBYTECODE");
  EXPECT_EQ(run.status, 4);
  EXPECT_THAT(run.err, AllOf(HasSubstr("a.png was not made"), HasSubstr("python3-matplotlib")));
  EXPECT_EQ(names(), before);
}

TEST_F(Plot, AnEarlierPictureStaysWhereANewOneFails) {
  make_result(file("a.h5"), {});
  write_text(file("a.png"), "\x89PNG, an earlier one");
  write_text(file("matplotlib.py"), "raise RuntimeError('broken')\n");
  const std::vector<std::string> before = names();
  ASSERT_EQ(setenv("PYTHONPATH", folder_.path().c_str(), 1), 0);
  ASSERT_EQ(setenv("PYTHONDONTWRITEBYTECODE", "1", 1), 0);
  const Ended run = plot({"a.h5"});
  unsetenv("PYTHONPATH");
  unsetenv("PYTHONDONTWRITEBYTECODE");
  EXPECT_EQ(run.status, 4);
  EXPECT_EQ(read_file(file("a.png")), "\x89PNG, an earlier one");
  EXPECT_EQ(names(), before);
}

}  // namespace
}  // namespace ra2d::test
