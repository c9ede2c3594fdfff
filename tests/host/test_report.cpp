// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/report.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/hash.hpp"
#include "host/report/asked.hpp"
#include "host/report/folders.hpp"
#include "host/report/html.hpp"
#include "host/report/svg_chart.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/result_reader.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Html, LetsNoMarkupThrough) {
  EXPECT_EQ(html("<b a=\"1\" c='2'>&</b>"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;&lt;/b&gt;");
  EXPECT_THAT(html("a\x1b\nb\xff"), Not(testing::ContainsRegex("[\x1b\n\xff]")));
  EXPECT_EQ(html_lines("a\nb<"), "a\nb&lt;");
}

TEST(Html, WritesNumbersForPeople) {
  EXPECT_EQ(html_number(1234.5, 4), "1234");
  EXPECT_EQ(html_number(0), "0");
  EXPECT_EQ(html_number(-0.25), "−0.25");
  EXPECT_EQ(html_number(7.2134e-4),
            "7.21\u00a0×\u00a010"
            "<sup>−4</sup>");
  EXPECT_EQ(html_number(1e15),
            "1\u00a0×\u00a010"
            "<sup>15</sup>");
  EXPECT_EQ(html_number(std::nan("")), "–");
}

TEST(Html, HasBase64OfTheStandard) {  // RFC 4648, section 10
  for (const auto& [bytes, text] : {std::pair{"", ""},
                                    {"f", "Zg=="},
                                    {"fo", "Zm8="},
                                    {"foo", "Zm9v"},
                                    {"foob", "Zm9vYg=="},
                                    {"fooba", "Zm9vYmE="},
                                    {"foobar", "Zm9vYmFy"},
                                    {"\xff\xfe\xfd", "//79"}})
    EXPECT_EQ(base64(bytes), text);
}

TEST(SvgChart, StaysInItsFrameWhateverTheValues) {
  SvgChart chart({1, 100, true, "<x>", {}}, {0, 10, false, "y", {}}, "\"><script>");
  chart.line({-1, 0, 1, 10, 1e9}, {std::nan(""), -5, 5, HUGE_VAL, -HUGE_VAL});
  const std::string svg = chart.svg();
  EXPECT_THAT(svg, AllOf(Not(HasSubstr("<script")), Not(HasSubstr("<x>")), Not(HasSubstr("nan")),
                         Not(HasSubstr("inf"))));
  EXPECT_THAT(svg, AllOf(HasSubstr(">1<"), HasSubstr(">10<"), HasSubstr(">100<")));
}

TEST(SvgChart, RoundsLimitsOutwards) {
  EXPECT_EQ(rounded_limits({3, 27, -HUGE_VAL}, 10), std::pair(0.0, 30.0));
  EXPECT_EQ(rounded_limits({20}, 10), std::pair(20.0, 30.0));
  EXPECT_EQ(rounded_limits({}, 10), std::pair(0.0, 10.0));
}

TEST(AskedFacts, HaveTheUnitsOfTheirKeys) {
  const FactTable facts = asked_facts(read_scene(test::scene_file("moving-force")));
  const auto of = [&](const std::string& name) {
    for (const auto& [fact, text] : facts)
      if (fact == name) return text;
    return std::string();
  };
  EXPECT_EQ(of("sliding"), "0.015 s at 0 m/s, from 140 mm on");
  EXPECT_EQ(of("resonator"),
            "pinned beam, 300 mm long, 2 mm thick, 200 mm wide; 210 GPa, 7800 kg/m³, damping ratio "
            "0; modes up to 20 kHz");
  EXPECT_EQ(of("contact"), "penalty, 1\u00a0×\u00a010<sup>15</sup> Pa/m");
  EXPECT_EQ(of("spacing"), "1 mm");
  EXPECT_EQ(of("samples"), "100 kHz; counted from 0 s on");
  EXPECT_EQ(of("moving force"), "10 N at 20 m/s");
}

class Report : public testing::Test {
 protected:
  test::Ended ra2d(std::vector<std::string> words) const {
    words.insert(words.begin(), test::program());
    return test::run_program(folder_.path(), words);
  }
  void simulate(const std::string& file, std::vector<std::string> sets = {}) const {
    std::vector<std::string> words{"run", test::scene_file("dang2012"), "-o", file};
    sets.insert(sets.begin(),
                {"scene.duration=0.2", "time.scheme=adaptive", "time.tolerance=1e-5"});
    for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
    const test::Ended ran = ra2d(words);
    ASSERT_EQ(ran.status, 0) << ran.err;
  }
  std::string page(const std::string& name = "page.html") const {
    return test::read_file(folder_.path() / name);
  }
  const test::Folder folder_;
};

/// Whatever begins a tag or leads away.
void expect_harmless(const std::string& page) {
  for (const char* away : {"http:", "https:", "//", "<link", "<img", "<iframe", "@import", "url("})
    if (const std::size_t at = page.find(away); at != page.npos) {
      const std::size_t data = page.rfind("base64,", at), quote = page.rfind('"', at);
      EXPECT_TRUE(data != page.npos && data > quote)
          << page.substr(at - std::min<std::size_t>(at, 60), 120);
      if (!(data != page.npos && data > quote)) return;
    }
}

std::size_t times(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) ++count;
  return count;
}

TEST_F(Report, OfOneResultHasItAll) {
  simulate("a.h5");
  const test::Ended said = ra2d({"report", "a.h5", "-o", "page.html"});
  ASSERT_EQ(said.status, 0) << said.err;
  EXPECT_EQ(said.err, "");
  const std::string text = page();
  EXPECT_THAT(text, AllOf(HasSubstr("level Lv"), HasSubstr("re 1 nm/s"), HasSubstr("a second</b>"),
                          HasSubstr("no interval: the run is too short"), HasSubstr("viewport")));
  EXPECT_THAT(text, AllOf(HasSubstr("Velocity spectrum"), HasSubstr("Third octaves"),
                          HasSubstr("Level in time"), HasSubstr("how long they last"),
                          HasSubstr("their peak force"), HasSubstr("nJ each, on average"),
                          HasSubstr("half-power damping"), HasSubstr("modal damping 0.02")));
  EXPECT_EQ(times(text, "<svg "), 5u);
  EXPECT_EQ(times(text, "src=\"data:audio/wav;base64,UklGR"), 2u);  // "RIFF"
  EXPECT_THAT(text, AllOf(HasSubstr("name = &quot;roughness noise&quot;"),
                          HasSubstr("<code>ra2d report a.h5 -o page.html</code>"),
                          HasSubstr("Made by ra2d 0."),
                          HasSubstr("penalty, 1\u00a0×\u00a010"
                                    "<sup>15</sup>")));
  EXPECT_LT(text.size(), 3e6);
  expect_harmless(text);
  EXPECT_EQ(ra2d({"report", "a.h5", "-o", "again.html"}).status, 0);
}

TEST_F(Report, OfSeveralResultsComparesThem) {
  simulate("a.h5");
  simulate("b.h5", {"resonator.surface.seed=7"});
  ASSERT_EQ(ra2d({"report", "a.h5", "b.h5", "-o", "page.html"}).status, 0);
  const std::string text = page();
  EXPECT_THAT(text, AllOf(HasSubstr("Side by side"), HasSubstr("<h2>Means</h2>"),
                          HasSubstr("href=\"#result2\""), HasSubstr("id=\"result2\"")));
  EXPECT_EQ(times(text, "<audio "), 4u);
  EXPECT_EQ(times(text, "<svg "), 10u);
}

TEST_F(Report, EscapesWhatComesFromOutside) {
  const std::string name =
      "</title><script>alert(1)</script>\\\"'><img src=x onerror=alert(2)>\\u202e";
  simulate("a.h5", {"scene.name=\"" + name + "\""});
  fs::rename(folder_.path() / "a.h5", folder_.path() / "<img src=x>'\".h5");
  ASSERT_EQ(ra2d({"report", "<img src=x>'\".h5", "-o", "page.html"}).status, 0);
  const std::string text = page();
  EXPECT_EQ(times(text, "<script>"), 1u);  // the page's own
  EXPECT_EQ(times(text, "<img"), 0u);
  EXPECT_EQ(times(text, "\u202e"), 0u);
  expect_harmless(text);
}

TEST(WithoutFolders, LeavesNamesAlone) {
  EXPECT_EQ(without_folders("path = \"/home/ann/a \\\"b\\\"/c.csv\" # \"/x\""),
            "path = \"c.csv\" # \"x\"");
  EXPECT_EQ(without_folders("base='/home/ann/b.toml'\nname = \"a/b\"\nx = \"/"),
            "base='b.toml'\nname = \"a/b\"\nx = \"/");
  EXPECT_EQ(without_folders("a = \"/it's/x\" b = \"/\" c = \"\\"), "a = \"x\" b = \"/\" c = \"\\");
  EXPECT_EQ(without_folders("a = \"/open\nb = \"/home/x\""), "a = \"open\nb = \"x\"");
}

TEST_F(Report, ShowsNoFolderOfTheDisk) {
  const std::filesystem::path folder = folder_.path() / "home-of-ann";
  std::filesystem::create_directory(folder);
  std::string text = "x [mm]; z [um]\n";
  for (int i = 0; i <= 4000; ++i)
    text += fmt::format("{:.2f};{:.6f}\n", 0.01 * i, 3 * std::sin(0.05 * i));
  std::ofstream(folder / "ground.csv") << text;
  const std::string face = "slider.surface={ kind = \"file\", path = \"" +
                           (folder / "ground.csv").string() + "\", column = 2 }";
  simulate((folder / "a.h5").string(), {face, "scene.duration=0.02"});
  ASSERT_EQ(
      ra2d({"report", (folder / "a.h5").string(), "-o", (folder / "page.html").string()}).status,
      0);
  const std::string made = page("home-of-ann/page.html");
  EXPECT_THAT(made, Not(HasSubstr("home-of-ann")));
  EXPECT_THAT(made, Not(HasSubstr(folder_.path().string())));
  EXPECT_THAT(made, AllOf(HasSubstr("path = &quot;ground.csv&quot;"),
                          HasSubstr("<code>ra2d report a.h5 -o page.html</code>")));
  const ResultReader reader(folder / "a.h5");
  Hash hash;
  const std::vector<double> heights =
      reader.column("surface/slider/height", 0, reader.rows("surface/slider/height"));
  hash.add(heights.data(), heights.size());
  EXPECT_THAT(made,
              HasSubstr("# ground.csv: put it beside this scene. surface/slider/height in the "
                        "result: xxh3_128 " +
                        hash.text()));
  // the result itself runs again from anywhere
  EXPECT_THAT(reader.contents().scene, HasSubstr((folder / "ground.csv").string()));
}

TEST_F(Report, ShortensLongSoundsAndDoesWithout) {
  simulate("a.h5", {"scene.duration=1.2", "time.tolerance=1e-3"});
  ASSERT_EQ(ra2d({"report", "a.h5", "-o", "page.html"}).status, 0);
  EXPECT_THAT(page(), HasSubstr("Shortened: all of it would last 24 s."));
  simulate("none.h5", {"output.probes=[]"});
  ASSERT_EQ(ra2d({"report", "none.h5"}).status, 0);
  EXPECT_THAT(page("none.html"),
              AllOf(HasSubstr("No sound: the result has no probe"), Not(HasSubstr("<audio "))));
}

TEST_F(Report, OfHardlyAnythingIsStillAPage) {
  const auto made = [&](const std::string& scene, std::vector<std::string> sets) {
    std::vector<std::string> words{"run", test::scene_file(scene), "-o", "a.h5", "--force"};
    for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
    EXPECT_EQ(ra2d(words).status, 0);
    const test::Ended said = ra2d({"report", "a.h5", "-o", "page.html"});
    EXPECT_EQ(said.status, 0) << said.err;
    const std::string text = page();
    EXPECT_THAT(text, AllOf(Not(HasSubstr(">nan")), Not(HasSubstr(" nan")), Not(HasSubstr("inf<")),
                            HasSubstr("</html>")));
  };
  for (const char* scene : {"peaks", "drop", "moving-force"}) made(scene, {});
  made("drop", {"scene.duration=1e-4"});
  made("drop", {"scene.duration=1e-7", "output.rate=1e7"});
}

TEST_F(Report, SaysThatARunWasCutShort) {
  EXPECT_EQ(
      ra2d({"run", test::scene_file("dang2012"), "-o", "a.h5", "--set",
            "time.scheme=explicit-euler", "--set", "time.step=1e-6", "--set", "time.force=true"})
          .status,
      3);
  ASSERT_EQ(ra2d({"report", "a.h5", "-o", "page.html"}).status, 0);
  EXPECT_THAT(page(), AllOf(HasSubstr("The run was cut short: unstable"),
                            HasSubstr("beyond a limit of stability, on request")));
}

TEST_F(Report, RefusesAndLeavesNothing) {
  std::ofstream(folder_.path() / "text.h5") << "no result";
  EXPECT_EQ(ra2d({"report"}).status, 2);
  EXPECT_EQ(ra2d({"report", "text.h5", "-o", "page.html"}).status, 4);
  EXPECT_EQ(ra2d({"report", "text.h5", "-o", "text.h5"}).status, 2);
  EXPECT_EQ(ra2d({"report", "nowhere.h5", "-o", "page.html"}).status, 4);
  EXPECT_FALSE(fs::exists(folder_.path() / "page.html"));
  EXPECT_EQ(test::read_file(folder_.path() / "text.h5"), "no result");
}

// ---- in a browser ------------------------------------------------------------------------------

std::string chromium() {
  for (const char* place :
       {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"})
    if (fs::exists(place)) return place;
  return {};
}

/// Sets the state of the loaded page as an attribute of its body.
constexpr char measure[] = R"js(<script>addEventListener("load", () => {
  const sounds = [...document.querySelectorAll("audio")].map(a => a.duration.toFixed(3));
  const fetched = performance.getEntriesByType("resource").filter(e => !e.name.startsWith("data:"));
  const root = document.documentElement;
  document.querySelector("button[data-copies]").click();
  document.body.dataset.seen = [root.clientWidth, root.scrollWidth, fetched.length,
    document.querySelectorAll("svg").length, getSelection().toString().includes("duration = 0.2"),
    ...sounds].join(" ");
});</script>)js";

/// Windows have a least width; frames do not.
constexpr char frames[] = R"html(<!DOCTYPE html>
<iframe src="measured.html" style="width:360px;height:800px;border:0"></iframe>
<iframe src="measured.html" style="width:1200px;height:800px;border:0"></iframe>
<script>addEventListener("load", () => document.body.append([...document.querySelectorAll("iframe")]
  .map(f => f.contentDocument.body.dataset.seen).join("; ")));</script>)html";

TEST_F(Report, StandsInABrowser) {
  if (chromium().empty()) GTEST_SKIP() << "no Chromium here";
  simulate("a.h5", {"scene.name=\"one long word: " + std::string(150, 'x') + "\""});
  simulate("b.h5", {"resonator.surface.seed=7"});
  ASSERT_EQ(ra2d({"report", "a.h5", "b.h5", "-o", "page.html"}).status, 0);
  std::string text = page();
  text.insert(text.rfind("</body>"), measure);
  std::ofstream(folder_.path() / "measured.html") << text;
  std::ofstream(folder_.path() / "frames.html") << frames;
  const test::Ended shown = test::run_program(
      folder_.path(),
      {chromium(), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
       "--enable-logging=stderr", "--host-resolver-rules=MAP * ~NOTFOUND",
       "--allow-file-access-from-files", "--window-size=1300,2000", "--dump-dom",
       "--user-data-dir=" + (folder_.path() / "profile").string(),
       "file://" + (folder_.path() / "frames.html").string()});
  EXPECT_EQ(shown.status, 0) << shown.err;
  EXPECT_THAT(shown.err, Not(HasSubstr("CONSOLE")));
  EXPECT_THAT(shown.out, HasSubstr("360 360 0 10 true 0.200 4.000 0.200 4.000; "
                                   "1200 1200 0 10 true 0.200 4.000 0.200 4.000"));
}

}  // namespace
}  // namespace ra2d
