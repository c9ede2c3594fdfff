// SPDX-License-Identifier: BSD-3-Clause
// Files that the program may write to and read from: nothing finished is lost unasked, no output
// is an input or somebody else's, and only regular files are opened.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/store/result_reader.hpp"
#include "host/system/input_file.hpp"
#include "host/system/output_file.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"
#include "tests/studies.hpp"

namespace ra2d::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Outputs : public testing::Test {
 protected:
  Outputs() { write("s.toml", quick_scene); }

  Ended ra2d(std::vector<std::string> words) const {
    // "timeout": what waits for an input ends with 124
    words.insert(words.begin(), {"timeout", "60", program()});
    return run_program(said_.path(), in_folder(std::move(words)));
  }
  /// Runs ra2d while calls to the folder fail.
  Ended faulty(const std::string& how, std::vector<std::string> words) const {
    words.insert(words.begin(), {"timeout", "60", "env", "LD_PRELOAD=" + faulty_disk(),
                                 "FAULTY_FOLDER=" + folder_.string(), how, program()});
    return run_program(said_.path(), in_folder(std::move(words)));
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string read(const std::string& name) const { return read_file(folder_ / name); }
  /// Names of the files in the folder.
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_))
      found.push_back(entry.path().filename());
    std::sort(found.begin(), found.end());
    return found;
  }

  const Folder disk_, said_;
  const fs::path folder_ = fs::canonical(disk_.path());

 private:
  std::vector<std::string> in_folder(std::vector<std::string> words) const {
    words.insert(words.begin(), {"env", "-C", folder_.string()});
    return words;
  }
};

const std::string other_scene = "slider.density=7000";

// ---- results -----------------------------------------------------------------------------------

TEST_F(Outputs, AFinishedResultOfAnotherSceneIsReplacedByForceAlone) {
  ASSERT_EQ(ra2d({"run", "s.toml", "-o", "o.h5", "--set", "scene.name=\"the first\""}).status, 0);
  const std::string first = read("o.h5");
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {"--quiet"}, {"--fresh"}}) {
    std::vector<std::string> words{"run", "s.toml", "-o", "o.h5", "--set", other_scene};
    words.insert(words.end(), more.begin(), more.end());
    const Ended refused = ra2d(words);
    EXPECT_EQ(refused.status, 2);
    EXPECT_EQ(refused.out, "");
    EXPECT_THAT(refused.err,
                AllOf(HasSubstr("'o.h5' is there already, a finished run of another scene, "
                                "\"the first\", made 20"),
                      HasSubstr("'density = 7800.0' there, 'density = 7000.0' here"),
                      HasSubstr("-o"), HasSubstr("--force")));
    EXPECT_TRUE(read("o.h5") == first);
    EXPECT_EQ(names(), (std::vector<std::string>{"o.h5", "s.toml"}));
  }
  // the same run, with and without --force: there is nothing to do
  for (const char* more : {"--quiet", "--force"}) {
    const Ended same = ra2d({"run", "s.toml", "-o", "o.h5", more});
    EXPECT_EQ(same.status, 0) << same.err;
    EXPECT_TRUE(read("o.h5") == first);
  }
  const Ended forced = ra2d({"run", "s.toml", "-o", "o.h5", "--set", other_scene, "--force"});
  EXPECT_EQ(forced.status, 0) << forced.err;
  EXPECT_THAT(forced.err, HasSubstr("it will be replaced"));
  EXPECT_FALSE(read("o.h5") == first);
  EXPECT_TRUE(read_stamp(folder_ / "o.h5").complete);
}

TEST_F(Outputs, WhatARunDoesNotKnowIsReplacedByForceAlone) {
  ASSERT_EQ(ra2d({"run", "s.toml", "-o", "whole.h5"}).status, 0);
  const std::string whole = read("whole.h5");
  ASSERT_EQ(mkdir((folder_ / "x.h5.parts").c_str(), 0700), 0);
  for (const auto& [name, content, what] :
       {std::tuple<std::string, std::string, std::string>{"o.h5", "notes of mine\n",
                                                          "no HDF5 file"},
        {"o.h5", whole.substr(0, 5000), "it was cut short"},
        {"o.toml", quick_scene, "no HDF5 file"},
        {"x.h5.parts/000001.h5", whole, "a segment of a run"}}) {
    write(name, content);
    const Ended refused = ra2d({"run", "s.toml", "-o", name});
    EXPECT_EQ(refused.status, 2) << name;
    EXPECT_THAT(refused.err, AllOf(HasSubstr("'" + name + "' is there already"), HasSubstr(what),
                                   HasSubstr("--force")));
    EXPECT_TRUE(read(name) == content) << name;
    EXPECT_EQ(ra2d({"run", "s.toml", "-o", name, "--force"}).status, 0) << name;
    EXPECT_TRUE(read_stamp(folder_ / name).complete) << name;
  }
  // nothing is lost with an empty file
  write("empty.h5", "");
  EXPECT_EQ(ra2d({"run", "s.toml", "-o", "empty.h5"}).status, 0);
  // an input is never replaced, nor what is no file
  EXPECT_EQ(ra2d({"run", "s.toml", "-o", "s.toml", "--force"}).status, 2);
  EXPECT_EQ(read("s.toml"), quick_scene);
  EXPECT_EQ(ra2d({"run", "s.toml", "-o", "x.h5.parts", "--force"}).status, 2);
}

TEST_F(Outputs, WhatWasInterruptedIsKeptAndWhatFailedIsReplaced) {
  const std::vector<std::string> line{"run", scene_file("dang2012"), "-o", "o.h5"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = line;
    words.insert(words.end(), more.begin(), more.end());
    return ra2d(words);
  };
  ASSERT_EQ(with({"--max-wall", "0.02"}).status, 5);
  for (const char* name : {"o.h5.checkpoint", "o.h5.checkpoint.previous", "o.h5.parts"})
    fs::remove_all(folder_ / name);
  const std::string kept = read("o.h5");
  const Ended refused = with({"--set", "scene.duration=1e-4"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("a run that was cut short (stopped by --max-wall)"));
  EXPECT_TRUE(read("o.h5") == kept);
  fs::remove(folder_ / "o.h5");

  ASSERT_EQ(with({"--set", "time.scheme=explicit-euler", "--set", "time.step=1e-6", "--set",
                  "time.force=true"})
                .status,
            3);
  const Ended replaced = with({"--set", "scene.duration=1e-4"});
  EXPECT_EQ(replaced.status, 0) << replaced.err;
  EXPECT_THAT(replaced.err, AllOf(HasSubstr("cut short (unstable"), HasSubstr("will be replaced")));
}

TEST_F(Outputs, ACheckpointOfAnotherSceneGivesWayToForce) {
  const std::vector<std::string> line{"run", scene_file("dang2012"), "-o", "o.h5"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = line;
    words.insert(words.end(), more.begin(), more.end());
    return ra2d(words);
  };
  ASSERT_EQ(with({"--max-wall", "0.02"}).status, 5);
  ASSERT_TRUE(fs::exists(folder_ / "o.h5.checkpoint"));
  EXPECT_EQ(with({"--set", "scene.duration=1e-4"}).status, 2);
  const Ended forced = with({"--set", "scene.duration=1e-4", "--force"});
  EXPECT_EQ(forced.status, 0) << forced.err;
  EXPECT_EQ(names(), (std::vector<std::string>{"o.h5", "s.toml"}));
}

TEST_F(Outputs, NothingThatIsMadeOfAResultReplacesOne) {
  ASSERT_EQ(ra2d({"run", "s.toml", "-o", "o.h5"}).status, 0);
  const std::string result = read("o.h5");
  for (const char* name : {"p-spectrum.csv", "p.png", "p.wav", "p.wav.json", "p.html", "p.csv",
                           "p-regions.csv", "p-long.csv", "p.toml"})
    write(name, result);
  fs::create_symlink("p.html", folder_ / "link.html");
  fs::create_directories(folder_ / "study" / "ledger");
  write("study/study.json", "{}");
  write("study/ledger/all.log", "ra2dlog\nand so on");
  write("o.h5.checkpoint", "ra2d checkpoint and so on");
  write("measured.txt", "0 1e-6\n1e-6 2e-6\n");
  write("scene-of-mine.toml", quick_scene);
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"analyze", "o.h5", "--csv", "p"},
           {"plot", "o.h5", "-o", "p.png"},
           {"sound", "o.h5", "-o", "p.wav"},
           {"report", "o.h5", "-o", "p.html"},
           {"report", "o.h5", "-o", "link.html"},
           {"report", "o.h5", "-o", "study/study.json"},
           {"report", "o.h5", "-o", "study/ledger/all.log"},
           {"report", "o.h5", "-o", "study/ledger/new.html"},
           {"report", "o.h5", "-o", "o.h5.checkpoint"},
           {"report", "o.h5", "-o", "s.toml"},
           {"surface", "generate", "--length", "1e-3", "--spacing", "1e-6", "--rq", "1e-6", "--rsm",
            "1e-4", "-o", "measured.txt"},
           {"plan", "--accuracy", "0.1", "s.toml", "-o", "scene-of-mine.toml"},
           {"surface", "generate", "--length", "1e-3", "--spacing", "1e-6", "--rq", "1e-6", "--rsm",
            "1e-4", "-o", "p.csv"},
           {"chart", "stability", "-o", "p", "--no-plot"},
           {"chart", "accuracy", "s.toml", "-o", "p", "--no-plot"},
           {"plan", "--accuracy", "0.1", "s.toml", "-o", "p.toml"}}) {
    const Ended refused = ra2d(words);
    EXPECT_EQ(refused.status, 2) << fmt::format("{}", fmt::join(words, " ")) << refused.err;
    EXPECT_THAT(refused.err, HasSubstr("it is left as it is"));
    EXPECT_EQ(refused.out, "");
  }
  for (const auto& entry : fs::directory_iterator(folder_))
    if (entry.path().filename().string().starts_with("p")) {
      EXPECT_TRUE(read_file(entry.path()) == result) << entry.path();
    }
  EXPECT_EQ(read("s.toml"), quick_scene);
  EXPECT_EQ(ra2d({"report", "o.h5", "-o", "page.txt"}).status, 2) << "a page is no text";
  EXPECT_EQ(ra2d({"run", "s.toml", "-o", "study/ledger/new.h5"}).status, 2);
  // where the program prints to
  const Ended printed = test::run_program(
      folder_, {"/bin/sh", "-c", "'" + test::program() + "' run s.toml -o /dev/stdout > both.h5"});
  EXPECT_EQ(printed.status, 2) << printed.err;
  // files that are not what their names say are nobody's earlier picture, sound or page
  for (const auto& [command, output, taken] :
       {std::tuple<std::string, std::string, std::string>{"sound", "n.wav", "n.wav"},
        {"sound", "n.WAV", "n.WAV"},
        {"sound", "n.flac", "n.flac"},
        {"sound", "t.wav", "t.wav.json"},
        {"plot", "n.png", "n.png"},
        {"plot", "n.svg", "n.svg"},
        {"plot", "n.pdf", "n.pdf"},
        {"report", "n.html", "n.html"},
        {"report", "n.htm", "n.htm"}}) {
    write(taken, quick_scene);
    const Ended refused = ra2d({command, "o.h5", "-o", output});
    EXPECT_EQ(refused.status, 2) << taken;
    EXPECT_THAT(refused.err,
                AllOf(HasSubstr("'" + taken + "' is no ."), HasSubstr("it is left as it is")));
    EXPECT_EQ(read(taken), quick_scene);
  }
  write("target", quick_scene);
  fs::create_symlink("target", folder_ / "link.wav");
  EXPECT_EQ(ra2d({"sound", "o.h5", "-o", "link.wav"}).status, 2);
  EXPECT_EQ(read("target"), quick_scene);
  // an earlier page gives way to the next
  write("old.html", "<html>");
  EXPECT_EQ(ra2d({"report", "o.h5", "-o", "old.html"}).status, 0);
}

// ---- files beside a result ---------------------------------------------------------------------

TEST_F(Outputs, NoInputHasTheNameOfAFileBesideTheResult) {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  fs::create_directory(folder_ / "o.h5.parts");
  fs::create_directory(folder_ / "sub");
  const std::string partial = fmt::format(".x.partial-{}-1", host);
  for (const std::string& name :
       {std::string("o.h5.checkpoint"), std::string("o.h5.checkpoint.previous"),
        std::string("o.h5.parts/000001.h5"), partial}) {
    fs::rename(folder_ / "s.toml", folder_ / name);
    fs::create_symlink(name, folder_ / "link.toml");
    for (const std::string& scene : {name, "sub/../" + name, std::string("link.toml")})
      for (const char* more : {"--quiet", "--fresh", "--force"}) {
        const Ended refused = ra2d({"run", scene, "-o", "o.h5", more});
        EXPECT_EQ(refused.status, 2) << scene << refused.err;
        EXPECT_THAT(refused.err, AllOf(HasSubstr("the input '" + scene), HasSubstr("rename it")));
        EXPECT_EQ(read(name), quick_scene);
        EXPECT_FALSE(fs::exists(folder_ / "o.h5"));
      }
    fs::rename(folder_ / name, folder_ / "s.toml");
    fs::remove(folder_ / "link.toml");
  }
  EXPECT_EQ(ra2d({"run", "s.toml", "-o", "o.h5"}).status, 0);
}

TEST_F(Outputs, WhatSomebodyElseHasBesideTheResultIsLeftThere) {
  fs::create_directory(folder_ / "o.h5.parts");
  const std::string text = "a file of mine\n";
  for (const char* name : {"o.h5.checkpoint", "o.h5.checkpoint.previous", "o.h5.parts/000001.h5"}) {
    write(name, text);
    for (const char* more : {"--quiet", "--fresh", "--force"}) {
      const Ended refused = ra2d({"run", "s.toml", "-o", "o.h5", more});
      EXPECT_EQ(refused.status, 4) << name << refused.err;
      EXPECT_THAT(refused.err,
                  AllOf(HasSubstr(name), HasSubstr("stands where"), HasSubstr("left as it is")));
      EXPECT_EQ(read(name), text);
      EXPECT_FALSE(fs::exists(folder_ / "o.h5"));
    }
    fs::remove(folder_ / name);
  }
  // of another name it is in nobody's way
  write("o.h5.parts/notes", text);
  EXPECT_EQ(ra2d({"run", "s.toml", "-o", "o.h5"}).status, 0);
  EXPECT_EQ(read("o.h5.parts/notes"), text);
}

TEST_F(Outputs, AnotherUsersFileInAStickyFolderIsFoundBeforeTheRun) {
  if (geteuid() != 0) GTEST_SKIP() << "only root has other users' files";
  write("o.h5", "");
  ASSERT_EQ(chmod(folder_.c_str(), 01777), 0);
  ASSERT_EQ(chmod((folder_ / "o.h5").c_str(), 0666), 0);
  const auto refusal = [&](const fs::path& file) -> int {
    const pid_t child = fork();
    if (child == 0) {
      if (setgroups(0, nullptr) != 0 || setgid(65534) != 0 || setuid(65534) != 0) _exit(3);
      try {
        require_output(file, {});
        _exit(0);
      } catch (const FileError& fault) {
        _exit(std::string(fault.what()).find("may not be replaced") != std::string::npos ? 1 : 2);
      }
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WEXITSTATUS(status);
  };
  EXPECT_EQ(refusal(folder_ / "o.h5"), 1);
  EXPECT_EQ(refusal(folder_ / "new.h5"), 0);
  EXPECT_TRUE(fs::exists(folder_ / "o.h5"));
  ASSERT_EQ(chmod(folder_.c_str(), 0777), 0);  // there everybody may
  EXPECT_EQ(refusal(folder_ / "o.h5"), 0);
  require_output(folder_ / "o.h5", {});
}

TEST_F(Outputs, AnOpenFileWithoutANameIsNoOutput) {
  const int file = open((folder_ / "gone").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_GE(file, 0);
  fs::create_symlink(fmt::format("/proc/{}/fd/{}", getpid(), file), folder_ / "link");
  fs::remove(folder_ / "gone");
  const Ended refused = ra2d({"run", "s.toml", "-o", "link"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("it leads to a file that has lost its name"));
  EXPECT_EQ(names(), (std::vector<std::string>{"link", "s.toml"}));
  close(file);
}

// ---- inputs ------------------------------------------------------------------------------------

TEST_F(Outputs, OnlyRegularFilesAreRead) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", folder_ / "zero");
  fs::create_symlink("a", folder_ / "b");
  fs::create_symlink("b", folder_ / "a");
  fs::create_directory(folder_ / "folder");
  const int listening = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un place{};
  place.sun_family = AF_UNIX;
  fmt::format_to_n(place.sun_path, sizeof place.sun_path - 1, "{}/socket", folder_.string());
  ASSERT_EQ(bind(listening, reinterpret_cast<const sockaddr*>(&place), sizeof place), 0);
  write("study.toml", "base = 's.toml'\n[vary]\nspeed = { key = 'scene.speed', values = [0.1] }\n");
  for (const auto& [file, why] : {std::pair{"pipe", "this is a pipe"},
                                  {"zero", "this is a device"},
                                  {"a", "its symbolic links lead in a ring"},
                                  {"socket", "this is a socket"},
                                  {"folder", "folder"}}) {
    const std::string profile =
        fmt::format("slider.surface={{ kind = \"file\", path = \"{}\" }}", file);
    write("based.toml", fmt::format("base = '{}'\n", file));
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {"run", file, "-o", "o.h5"},
             {"plan", file},
             {"check", file},
             {"analyze", file},
             {"report", file},
             {"sound", file},
             {"plot", file},
             {"study", file, "-o", "out"},
             {"study", "based.toml", "-o", "out"},
             {"study", "study.toml", "-o", "out", "--set", profile},
             {"study", "status", file},
             {"surface", "measure", file},
             {"run", "s.toml", "-o", "o.h5", "--set", profile}}) {
      const Ended ended = ra2d(words);
      EXPECT_EQ(ended.status, 4) << fmt::format("{}: ", fmt::join(words, " ")) << ended.err;
      EXPECT_THAT(ended.err, HasSubstr(words[0] == "study" || words[0] == "check" ? file : why))
          << fmt::format("{}", fmt::join(words, " "));
    }
  }
  close(listening);
  // an output in a ring
  const Ended ring = ra2d({"run", "s.toml", "-o", "a"});
  EXPECT_EQ(ring.status, 4);
  EXPECT_THAT(ring.err, HasSubstr("its symbolic links lead in a ring"));
}

TEST_F(Outputs, AnInputIsReadAsFarAsItReachedWhenItWasOpened) {
  write("file", "0123456789");
  const InputFile file(folder_ / "file", "the file");
  write("file", "0123456789 and more");
  EXPECT_EQ(file.beginning(100), "0123456789");
  char part[4];
  EXPECT_EQ(file.read(8, part, sizeof part), 2u);
  EXPECT_EQ(file.read(10, part, sizeof part), 0u);
  InputStream stream(folder_ / "file");
  std::string word;
  stream.seekg(15);
  stream >> word;
  EXPECT_EQ(word, "more");
  EXPECT_TRUE(stream.eof());
  // what has no size has no end either, and is read as empty
  EXPECT_EQ(InputFile("/proc/self/environ").beginning(100), "");
}

// ---- file systems of another kind --------------------------------------------------------------

TEST_F(Outputs, AFailingFstatEndsARunAndLeavesNothing) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const Ended failed = faulty("FAULTY_FSTAT=5", {"run", scene_file("peaks"), "-o", "o.h5"});
  EXPECT_EQ(failed.status, 4) << failed.err;
  EXPECT_THAT(failed.err, HasSubstr("Input/output error"));
  EXPECT_EQ(names(), std::vector<std::string>{"s.toml"});
}

TEST_F(Outputs, NumbersOfInodesThatChangeDoNoHarm) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  const Ended done = faulty("FAULTY_INODES=1", {"run", scene_file("peaks"), "-o", "o.h5"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(names(), (std::vector<std::string>{"o.h5", "s.toml"}));
  EXPECT_EQ(faulty("FAULTY_INODES=1", {"run", "s.toml", "-o", "s.toml"}).status, 2);
  EXPECT_EQ(read("s.toml"), quick_scene);
}

// ---- studies -----------------------------------------------------------------------------------

class StudyOutputs : public Outputs {
 protected:
  StudyOutputs() {
    write("study.toml",
          "base = 's.toml'\n[vary]\nspeed = { key = 'scene.speed', values = [0.1, 0.2] }\n");
  }
};

TEST_F(StudyOutputs, AMergeReplacesNothingButATableOfItsStudy) {
  ASSERT_EQ(ra2d({"study", "study.toml", "-o", "d", "--threads", "1"}).status, 0);
  ASSERT_EQ(
      ra2d({"study", "study.toml", "-o", "other", "--threads", "1", "--set", "scene.duration=1e-3"})
          .status,
      0);
  ASSERT_EQ(ra2d({"run", "s.toml", "-o", "result.h5"}).status, 0);
  write("notes", "mine");
  fs::create_hard_link(folder_ / "s.toml", folder_ / "hard");
  fs::create_symlink("d/ledger/all.log", folder_ / "soft");
  fs::create_directory_symlink("d", folder_ / "dd");
  for (const char* name : {"d/ledger/all.log", "d/study.json", "d/status.json", "study.toml",
                           "s.toml", "notes", "hard", "soft", "result.h5", "dd/../d/ledger/all.log",
                           "dd/ledger/all.log", "other/ledger/all.log"}) {
    const std::string before = read(name);
    const Ended refused = ra2d({"study", "merge", "d", "-o", name});
    EXPECT_EQ(refused.status, 2) << name << refused.err;
    EXPECT_TRUE(read(name) == before) << name;
  }
  EXPECT_EQ(ra2d({"study", "merge", "d", "-o", "d/ledger"}).status, 2);
  for (const char* name : {"d/ledger/new.log", "dd/ledger/new.h5", "d/status-shard-1-of-2.json"}) {
    EXPECT_EQ(ra2d({"study", "merge", "d", "-o", name}).status, 2) << name;
    EXPECT_FALSE(fs::exists(folder_ / name)) << name;
  }
  EXPECT_EQ(ra2d({"study", "status", "d"}).status, 0);
  // its own table, an earlier one of it, a new one
  for (const std::vector<std::string>& more : {std::vector<std::string>{},
                                               {"-o", "d/results.h5"},
                                               {"-o", "dd/results.h5"},
                                               {"-o", "t.h5"},
                                               {"-o", "t.h5"}}) {
    std::vector<std::string> words{"study", "merge", "d"};
    words.insert(words.end(), more.begin(), more.end());
    const Ended merged = ra2d(words);
    EXPECT_EQ(merged.status, 0) << merged.err;
  }
  // a table of another study
  write("study.toml",
        "base = 's.toml'\n[vary]\nspeed = { key = 'scene.speed', values = [0.1, 0.3] }\n");
  ASSERT_EQ(ra2d({"study", "study.toml", "-o", "third", "--threads", "1"}).status, 0);
  const std::string table = read("t.h5");
  EXPECT_EQ(ra2d({"study", "merge", "third", "-o", "t.h5"}).status, 2);
  EXPECT_TRUE(read("t.h5") == table);
}

TEST_F(StudyOutputs, AStudyReplacesNothingThatNoStudyHasWritten) {
  fs::create_directory(folder_ / "out");
  for (const char* name : {"results.h5", "study.json", "status.json"}) {
    write("out/" + std::string(name), "somebody else's");
    const Ended refused = ra2d({"study", "study.toml", "-o", "out", "--threads", "1"});
    EXPECT_EQ(refused.status, 2) << name << refused.err;
    EXPECT_THAT(refused.err, AllOf(HasSubstr(name), HasSubstr("left as it is")));
    EXPECT_EQ(read("out/" + std::string(name)), "somebody else's");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "out"), {}), 1) << "nothing is made";
    fs::remove(folder_ / "out" / name);
  }
  // a table that was merged there is nobody's earlier one
  ASSERT_EQ(ra2d({"study", "study.toml", "-o", "d", "--threads", "1"}).status, 0);
  ASSERT_EQ(ra2d({"study", "merge", "d", "-o", "out/results.h5"}).status, 0);
  EXPECT_EQ(ra2d({"study", "study.toml", "-o", "out", "--set", "scene.duration=1e-3"}).status, 2);
  fs::remove(folder_ / "out/results.h5");
  // an input that a link leads to
  fs::create_symlink("../s.toml", folder_ / "out/results.h5");
  EXPECT_EQ(ra2d({"study", "study.toml", "-o", "out"}).status, 2);
  EXPECT_EQ(read("s.toml"), quick_scene);
  fs::remove(folder_ / "out/results.h5");
  // its own files, whole or damaged, are written anew
  ASSERT_EQ(ra2d({"study", "study.toml", "-o", "out", "--threads", "1"}).status, 0);
  write("out/results.h5", read("out/results.h5").substr(0, 1000));
  write("out/study.json", read("out/study.json").substr(0, 50));
  const Ended again = ra2d({"study", "study.toml", "-o", "out", "--threads", "1"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(ra2d({"check", "out"}).status, 0);
}

// ---- signals -----------------------------------------------------------------------------------

TEST_F(Outputs, SigUsr1EndsNoRunThatHasNotBegun) {
  // It comes again and again while the run begins. Only what the system does before the program has
  // a word is kept from it here, as the manual says.
  Child run(said_.path(),
            {"sh", "-c", "trap '' USR1; cd \"$0\" && touch ready && exec \"$@\"", folder_.string(),
             program(), "run", "s.toml", "-o", "o.h5", "--set", "scene.duration=0.1"});
  for (int i = 0; i < 10000 && !fs::exists(folder_ / "ready"); ++i) usleep(1000);
  for (int i = 0; i < 3000 && !fs::exists(folder_ / "o.h5.parts"); ++i) {
    run.send(SIGUSR1);
    usleep(50);
  }
  const int status = run.wait();
  EXPECT_EQ(status, 0) << run.err();
}

TEST_F(Outputs, SigUsr1IsHeldBackBeforeTheLibrariesBegin) {
  if (faulty_disk().empty()) GTEST_SKIP() << "no library is loaded first under sanitizers";
  const Ended done = faulty("FAULTY_USR1_FIRST=1", {"run", "s.toml", "-o", "o.h5"});
  EXPECT_EQ(done.status, 0) << done.err;
}

}  // namespace
}  // namespace ra2d::test
