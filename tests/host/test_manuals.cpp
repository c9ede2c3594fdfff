// SPDX-License-Identifier: BSD-3-Clause
// Help, manual pages and completion: all are written from the table of commands and options.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "host/scene_file/key_facts.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

namespace {

namespace fs = std::filesystem;
using ra2d::test::Ended;
using testing::AllOf;
using testing::AnyOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;
using testing::StartsWith;
using testing::UnorderedElementsAre;
using Words = std::vector<std::string>;

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The path of a program, or nothing.
std::string installed(const std::string& name) {
  std::istringstream folders(std::getenv("PATH") != nullptr ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  return {};
}

class Manuals : public testing::Test {
 protected:
  Ended run(Words words) const {
    words.insert(words.begin(), ra2d::test::program());
    return ra2d::test::run_program(folder_.path(), words);
  }
  /// The help of every command by its path, "study merge".
  std::map<std::string, std::string> every_help() const {
    std::map<std::string, std::string> all;
    add_help({}, all);
    return all;
  }
  /// Where the program writes manuals and completions; empty where there is no page to make one of.
  fs::path written() const {
    const fs::path page = ra2d::test::source_folder() / "docs/scene.md";
    if (!fs::exists(page)) return {};
    const fs::path folder = folder_.path() / "share";
    const Ended made = run({"--write-manuals", folder, page});
    EXPECT_EQ(made.status, 0) << made.err;
    EXPECT_EQ(made.out, "");
    return folder;
  }

  const ra2d::test::Folder folder_;

 private:
  void add_help(const Words& path, std::map<std::string, std::string>& all) const {
    Words words = path;
    words.emplace_back("--help");
    const Ended help = run(words);
    ASSERT_EQ(help.status, 0) << help.err;
    all[fmt::format("{}", fmt::join(path, " "))] = help.out;
    bool is_command = false;
    for (const std::string& line : lines_of(help.out)) {
      if (line.empty()) is_command = false;
      if (is_command && line[2] != ' ') {
        Words below = path;
        below.push_back(line.substr(2, line.find(' ', 2) - 2));
        add_help(below, all);
      }
      if (line == "Commands:") is_command = true;
    }
  }
};

/// The names of options that a help lists, "--quiet".
std::set<std::string> options_in(const std::string& help) {
  std::set<std::string> names;
  for (const std::string& line : lines_of(help)) {
    if (!line.starts_with("  -")) continue;
    const std::size_t begin = line.find("--");
    names.insert(line.substr(begin, line.find_first_of(" ", begin) - begin));
  }
  return names;
}

std::string without_roff(std::string text) {
  for (const auto& [roff, plain] : std::initializer_list<std::pair<std::string, std::string>>{
           {"\\-", "-"}, {"\\fB", ""}, {"\\fI", ""}, {"\\fR", ""}, {"\\(aq", "'"}, {"\\(dq", "\""}})
    for (std::size_t at = 0; (at = text.find(roff, at)) != text.npos;)
      text.replace(at, roff.size(), plain);
  return text;
}

TEST_F(Manuals, NoLineOfAHelpIsLongerThan80) {
  const auto helps = every_help();
  EXPECT_THAT(helps,
              IsSupersetOf({testing::Key(""), testing::Key("run"), testing::Key("study merge"),
                            testing::Key("surface measure"), testing::Key("chart accuracy")}));
  for (const auto& [path, help] : helps) {
    std::string words;  // as they stand in one line
    for (const std::string& line : lines_of(help)) {
      EXPECT_LE(line.size(), 80) << path << ": " << line;
      EXPECT_FALSE(line.ends_with(' ')) << path << ": " << line;
      words += line.substr(std::min(line.find_first_not_of(' '), line.size())) + ' ';
    }
    EXPECT_THAT(
        words,
        AllOf(HasSubstr(fmt::format("Usage: ra2d{}{} [OPTIONS]", path.empty() ? "" : " ", path)),
              HasSubstr("--help "), HasSubstr("130: Ctrl-C)")));
  }
  // a value with its range, its default, what it needs and what it excludes
  EXPECT_THAT(helps.at("plan"), HasSubstr("with --accuracy) [60]"));
  EXPECT_THAT(helps.at("run"), AllOf(HasSubstr("SCENE\n"), HasSubstr("1e-6 to 1e6)")));
  EXPECT_THAT(helps.at("analyze"), HasSubstr("not with --segment)"));
  EXPECT_THAT(helps.at("surface generate"), HasSubstr("(rq, rq+rsm, none) [rq]"));
  EXPECT_THAT(helps.at(""), Not(HasSubstr("--write-manuals")));
}

TEST_F(Manuals, ThereIsOneForEveryCommandWithAllItsOptions) {
  const fs::path folder = written();
  if (folder.empty()) GTEST_SKIP() << "docs/scene.md is not here";
  std::size_t pages = 0;
  for (const auto& [path, help] : every_help()) {
    std::string name = path.empty() ? "ra2d" : "ra2d-" + path;
    std::replace(name.begin(), name.end(), ' ', '-');
    const std::string page =
        without_roff(ra2d::test::read_file(folder / "man/man1" / (name + ".1")));
    ASSERT_NE(page, "") << name;
    ++pages;
    EXPECT_THAT(page, AllOf(HasSubstr(".SH \"NAME\"\n" + name + " - "), HasSubstr("ra2d-scene(5)"),
                            HasSubstr(".SH \"EXIT STATUS\"")));
    for (const std::string& option : options_in(help)) EXPECT_THAT(page, HasSubstr(option)) << name;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "man/man1"), {}),
            static_cast<std::ptrdiff_t>(pages));
}

TEST_F(Manuals, ThatOfTheSceneHasEveryKey) {
  const fs::path folder = written();
  if (folder.empty()) GTEST_SKIP() << "docs/scene.md is not here";
  const std::string page = ra2d::test::read_file(folder / "man/man5/ra2d-scene.5");
  const auto expect_keys = [&](const auto& self, const std::vector<ra2d::KeyFacts>& keys) -> void {
    for (const ra2d::KeyFacts& key : keys) {
      EXPECT_THAT(page, HasSubstr("\n.TP\n\\fB" + key.name + "\\fR\n"));
      if (key.type == "table") self(self, key.inner);
    }
  };
  for (const ra2d::KeyFacts& section : ra2d::scene_sections())
    expect_keys(expect_keys, section.inner);
  EXPECT_THAT(without_roff(page), AllOf(HasSubstr("simulated time (number > 0, s; required)"),
                                        HasSubstr("\n.SH [scene]"), Not(HasSubstr("`")),
                                        Not(HasSubstr("](")), Not(HasSubstr("<!--"))));
}

/// man(1) and mandoc(1) find nothing wrong with them.
TEST_F(Manuals, AreFreeOfFaults) {
  const std::string man = installed("man"), mandoc = installed("mandoc");
  if (man.empty() && mandoc.empty()) GTEST_SKIP() << "neither man nor mandoc is here";
  const fs::path folder = written();
  if (folder.empty()) GTEST_SKIP() << "docs/scene.md is not here";
  for (const auto& entry : fs::recursive_directory_iterator(folder / "man")) {
    if (!entry.is_regular_file()) continue;
    if (!man.empty()) {
      const Ended shown = ra2d::test::run_program(
          folder_.path(),
          {"/usr/bin/env", "LC_ALL=C.UTF-8", man, "--warnings", "-l", entry.path()});
      EXPECT_EQ(shown.status, 0) << entry.path();
      EXPECT_EQ(shown.err, "") << entry.path();
    }
    if (!mandoc.empty()) {
      const Ended lint = ra2d::test::run_program(
          folder_.path(), {mandoc, "-T", "lint", "-W", "warning", entry.path()});
      for (const std::string& line : lines_of(lint.out))
        EXPECT_THAT(line, HasSubstr("missing date"));  // so that a build twice gives the same bytes
    }
  }
}

/// The words that bash offers for a line. They are parted as readline does it.
Words offered_by_bash(const fs::path& folder, const fs::path& script, const std::string& line,
                      const std::string& breaks) {
  std::ofstream(folder / "try.bash") << R"(
. "$1"
COMP_WORDBREAKS=$3
compopt() { :; }
line=$2
[[ $COMP_WORDBREAKS != *=* ]] || line=${line//=/ = }
read -ra COMP_WORDS <<< "$line"
[[ $2 != *' ' ]] || COMP_WORDS+=('')
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
_ra2d
printf '%s\n' "${COMPREPLY[@]}"
)";
  const Ended tried = ra2d::test::run_program(
      folder, {"/bin/bash", "--norc", folder / "try.bash", script, line, breaks});
  EXPECT_EQ(tried.status, 0) << tried.err;
  EXPECT_EQ(tried.err, "") << line;
  Words words;
  for (const std::string& word : lines_of(tried.out))
    if (!word.empty()) words.push_back(word);
  return words;
}

TEST_F(Manuals, BashCompletes) {
  if (!fs::exists("/bin/bash")) GTEST_SKIP() << "no bash here";
  const fs::path share = written();
  if (share.empty()) GTEST_SKIP() << "docs/scene.md is not here";
  const fs::path script = share / "bash-completion/completions/ra2d", folder = folder_.path();
  for (const char* name : {"a.toml", "b.toml", "r.h5", "note.txt", "my scene.toml"})
    std::ofstream(folder / name) << "";
  fs::create_directory(folder / "table");
  std::string breaks = " \t\n\"'><=;|&(:";
  const auto offered = [&](const std::string& line) {
    return offered_by_bash(folder, script, line, breaks);
  };
  for (const auto& [path, help] : every_help()) {
    const std::set<std::string> options = options_in(help);
    EXPECT_THAT(offered(fmt::format("ra2d{}{} --", path.empty() ? "" : " ", path)),
                testing::UnorderedElementsAreArray(options))
        << path;
  }
  EXPECT_THAT(offered("ra2d ru"), UnorderedElementsAre("run"));
  EXPECT_THAT(offered("ra2d "), IsSupersetOf({"run", "study", "surface"}));
  EXPECT_THAT(offered("ra2d run "),
              UnorderedElementsAre("a.toml", "b.toml", "my scene.toml", "share", "table"));
  EXPECT_THAT(offered("ra2d run a.toml --set time.sch"), UnorderedElementsAre("time.scheme="));
  EXPECT_THAT(offered("ra2d run --set time.scheme="), IsSupersetOf({"adaptive", "rk4"}));
  EXPECT_THAT(offered("ra2d run --set=time.scheme=ad"), UnorderedElementsAre("adaptive"));
  EXPECT_THAT(offered("ra2d run --set slider.surface.exact=rq"),
              UnorderedElementsAre("rq", "rq+rsm"));
  EXPECT_THAT(offered("ra2d run --set scene.duration=1"), IsEmpty());
  EXPECT_THAT(offered("ra2d run -o x --quiet --set contact.l"),
              UnorderedElementsAre("contact.law="));
  EXPECT_THAT(offered("ra2d run --threads "), IsEmpty());
  EXPECT_THAT(offered("ra2d study "), IsSupersetOf({"status", "merge", "a.toml"}));
  EXPECT_THAT(offered("ra2d study status "), UnorderedElementsAre("share", "table"));
  EXPECT_THAT(offered("ra2d study --threads status st"), UnorderedElementsAre("status"));
  EXPECT_THAT(offered("ra2d surface generate --exact=n"), UnorderedElementsAre("none"));
  EXPECT_THAT(offered("ra2d surface measure --x-unit u"), UnorderedElementsAre("um"));
  EXPECT_THAT(offered("ra2d surface measure --form "),
              UnorderedElementsAre("none", "mean", "line"));  // and poly:N, which stands for many
  for (const char* command : {"analyze", "plot", "report", "sound", "check"})
    EXPECT_THAT(offered(fmt::format("ra2d {} ", command)),
                AllOf(Contains("r.h5"), Contains("table"), Not(Contains("a.toml"))));
  // other software takes "=" from the breaks: then the whole word is replaced
  breaks = " \t\n";
  EXPECT_THAT(offered("ra2d run --set time.scheme=ad"),
              UnorderedElementsAre("time.scheme=adaptive"));
  EXPECT_THAT(offered("ra2d run --set=time.scheme=ad"),
              UnorderedElementsAre("--set=time.scheme=adaptive"));
}

TEST_F(Manuals, ZshAndFishComplete) {
  const fs::path share = written();
  if (share.empty()) GTEST_SKIP() << "docs/scene.md is not here";
  const std::string zsh = installed("zsh"), fish = installed("fish");
  if (zsh.empty() && fish.empty()) GTEST_SKIP() << "neither zsh nor fish is here";
  if (!zsh.empty()) {
    const fs::path script = share / "zsh/site-functions/_ra2d";
    const Ended parsed = ra2d::test::run_program(folder_.path(), {zsh, "-f", "-n", script});
    EXPECT_EQ(parsed.status, 0) << parsed.err;
    EXPECT_EQ(parsed.err, "");
    EXPECT_THAT(ra2d::test::read_file(script), StartsWith("#compdef ra2d\n"));
  }
  if (fish.empty()) return;
  std::ofstream(folder_.path() / "a.toml") << "";
  std::ofstream(folder_.path() / "r.h5") << "";
  const auto offered = [&](const std::string& line) {
    const Ended tried = ra2d::test::run_program(
        folder_.path(),
        {"/usr/bin/env", "HOME=" + folder_.path().string(), fish, "--no-config", "-c",
         fmt::format("source {}; complete -C '{}'",
                     (share / "fish/vendor_completions.d/ra2d.fish").string(), line)});
    EXPECT_EQ(tried.err, "");
    Words words;
    for (const std::string& word : lines_of(tried.out))
      words.push_back(word.substr(0, word.find('\t')));
    return words;
  };
  EXPECT_THAT(offered("ra2d ru"), UnorderedElementsAre("run"));
  EXPECT_THAT(offered("ra2d run --thr"), UnorderedElementsAre("--threads"));
  EXPECT_THAT(offered("ra2d run a.toml --set time.scheme=ad"),
              UnorderedElementsAre("time.scheme=adaptive"));
  EXPECT_THAT(offered("ra2d study m"), UnorderedElementsAre("merge"));
  EXPECT_THAT(offered("ra2d run a"), UnorderedElementsAre("a.toml"));
  EXPECT_THAT(offered("ra2d surface generate --exact=n"), UnorderedElementsAre("--exact=none"));
}

}  // namespace
