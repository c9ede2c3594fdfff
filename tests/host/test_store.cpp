// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <thread>
#include <utility>

#include "host/base/errors.hpp"
#include "host/store/store.hpp"
#include "host/store/writer_thread.hpp"
#include "host/system/partial_file.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"

// HDF5 loses a little memory when a flush fails; nothing of ours can give it back.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A folder of its own for each test.
class Store : public testing::Test {
 protected:
  Store() {
    std::string name = (fs::temp_directory_path() / "ra2d_store_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    path_ = folder_ / "out.h5";
  }
  ~Store() override { fs::remove_all(folder_); }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_))
      names.push_back(entry.path().filename());
    return names;
  }

  fs::path folder_, path_;
};

ModesHeader modes(std::size_t count, double frequency) {
  ModesHeader m;
  m.position = {0, 1, 2};
  std::vector<double> squares;
  for (std::size_t k = 0; k < count; ++k) {
    m.frequency.push_back(frequency * double(k));
    squares.push_back(1 + double(k));
    for (const double x : m.position) m.shape.push_back(10 * double(k) + x);
  }
  m.mean_square = squares;
  return m;
}

ResultHeader header(std::size_t resonator, std::size_t slider, std::size_t probes) {
  ResultHeader h;
  h.scene = "[scene]\nname = \"k\u00e4se\"\n";
  h.backend = "Serial";
  h.started = "2026-01-02T03:04:05Z";
  h.spacing = 8e-6;
  h.resonator = modes(resonator, 100);
  h.slider = modes(slider, 900);
  for (std::size_t k = 0; k < probes; ++k) {
    h.probe_position.push_back(0.1 * double(k + 1));
    h.slider_probe_position.push_back(0.01 * double(k + 1));
  }
  h.resonator_height = {1e-6, -2e-6, 3e-6, 0};
  h.slider_height = {-1e-6, 4e-6};
  return h;
}

/// Samples first, first + 1, ...: every number tells its sample, its quantity and its column.
double value(std::size_t sample, int quantity, std::size_t column) {
  return double(sample) * 1e3 + quantity * 10 + double(column);
}
SampleBlock block(const ResultHeader& h, std::size_t first, std::size_t rows) {
  SampleBlock b;
  int quantity = 0;
  const auto fill = [&](std::vector<double>& data, std::size_t width) {
    for (std::size_t j = first; j < first + rows; ++j)
      for (std::size_t k = 0; k < width; ++k) data.push_back(value(j, quantity, k));
    ++quantity;
  };
  const std::size_t resonator = h.resonator.frequency.size(), slider = h.slider.frequency.size();
  fill(b.time, 1);
  fill(b.resonator_displacement, resonator);
  fill(b.resonator_velocity, resonator);
  fill(b.slider_displacement, slider);
  fill(b.slider_velocity, slider);
  for (auto* data : {&b.force, &b.nodes}) fill(*data, 1);
  for (auto* data : {&b.probe_displacement, &b.probe_velocity})
    fill(*data, h.probe_position.size());
  for (auto* data : {&b.slider_probe_displacement, &b.slider_probe_velocity})
    fill(*data, h.slider_probe_position.size());
  for (auto* data :
       {&b.kinetic, &b.elastic, &b.contact, &b.damping_loss, &b.sliding_work, &b.load_work})
    fill(*data, 1);
  return b;
}

Shock shock(long serial) {
  return {serial, serial * 1.0, serial * 5.0, serial * 2.0, serial * 3.0, serial * 4.0};
}

ResultSummary summary() {
  ResultSummary s;
  s.v_rms = 1e-3;
  s.lv = 120;
  s.wall_seconds = 2.5;
  s.steps = 1'000'000'000'000;
  s.ended = "complete";
  return s;
}

std::vector<double> read(const fs::path& path, const char* name) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(dataset);
  std::vector<double> data(H5Sget_simple_extent_npoints(space));
  EXPECT_GE(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), 0);
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  return data;
}

/// Opens the file with h5py, netCDF4 and xarray.
void check_in_python(const fs::path& path) {
  if (test::python().empty()) return;
  const fs::path script = test::source_folder() / "tests/host/check_result.py";
  const std::string command =
      fmt::format("{} '{}' '{}'", test::python(), script.string(), path.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const FileError& error) {
    return error.what();
  }
  return "no FileError";
}

/// Runs `body` in a child process, which leaves by exit() as the program does; its wait status.
int in_child(const std::function<int()>& body) {
  fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) exit(body());
  int status = -1;
  waitpid(child, &status, 0);
  return status;
}

// ---- content -----------------------------------------------------------------------------------

TEST_F(Store, ReadsBackWhatWasWritten) {
  const ResultHeader h = header(3, 2, 2);
  ResultFile file(path_, h);
  std::size_t rows = 0;
  for (std::size_t count : {1, 0, 7, 10'000, 3, 20'000}) {  // within, across and beyond the buffer
    file.append(block(h, rows, count));
    rows += count;
  }
  file.append({shock(0), shock(1)});
  file.close(summary());
  EXPECT_THAT(files(), ElementsAre("out.h5"));

  const SampleBlock all = block(h, 0, rows);
  EXPECT_EQ(read(path_, "/time"), all.time);
  EXPECT_EQ(read(path_, "/resonator/displacement"), all.resonator_displacement);
  EXPECT_EQ(read(path_, "/resonator/velocity"), all.resonator_velocity);
  EXPECT_EQ(read(path_, "/slider/displacement"), all.slider_displacement);
  EXPECT_EQ(read(path_, "/slider/velocity"), all.slider_velocity);
  EXPECT_EQ(read(path_, "/contact/force"), all.force);
  EXPECT_EQ(read(path_, "/contact/nodes"), all.nodes);
  EXPECT_EQ(read(path_, "/probes/displacement"), all.probe_displacement);
  EXPECT_EQ(read(path_, "/probes/velocity"), all.probe_velocity);
  EXPECT_EQ(read(path_, "/energy/kinetic"), all.kinetic);
  EXPECT_EQ(read(path_, "/energy/elastic"), all.elastic);
  EXPECT_EQ(read(path_, "/energy/contact"), all.contact);
  EXPECT_EQ(read(path_, "/energy/damping_loss"), all.damping_loss);
  EXPECT_EQ(read(path_, "/energy/sliding_work"), all.sliding_work);
  EXPECT_EQ(read(path_, "/energy/load_work"), all.load_work);
  EXPECT_EQ(read(path_, "/resonator/frequency"), h.resonator.frequency);
  EXPECT_EQ(read(path_, "/resonator/shape"), h.resonator.shape);
  EXPECT_EQ(read(path_, "/slider/mean_square"), h.slider.mean_square.get());
  EXPECT_EQ(read(path_, "/resonator/time"), all.time);
  EXPECT_EQ(read(path_, "/slider_probes/velocity"), all.slider_probe_velocity);
  EXPECT_EQ(read(path_, "/slider_probes/position"), h.slider_probe_position);
  EXPECT_EQ(read(path_, "/slider/frequency"), h.slider.frequency);
  EXPECT_EQ(read(path_, "/probes/position"), h.probe_position);
  EXPECT_EQ(read(path_, "/surface/resonator/height"), h.resonator_height);
  EXPECT_EQ(read(path_, "/surface/slider/height"), h.slider_height);
  EXPECT_THAT(read(path_, "/surface/slider/position"), ElementsAre(0, 8e-6));
  EXPECT_THAT(read(path_, "/level/v_rms"), ElementsAre(1e-3));
  EXPECT_THAT(read(path_, "/level/lv"), ElementsAre(120));
  EXPECT_THAT(read(path_, "/shocks/peak_force"), ElementsAre(0, 2));
  check_in_python(path_);
}

TEST_F(Store, OpensWithoutModesProbesShocksAndSamples) {
  const ResultHeader rigid = header(0, 0, 0);
  {
    ResultFile file(path_, rigid);
    file.append(block(rigid, 0, 5));
    file.close(summary());
  }
  EXPECT_EQ(read(path_, "/time").size(), 5u);
  EXPECT_THAT(read(path_, "/resonator/displacement"), IsEmpty());
  check_in_python(path_);

  ResultSummary cut = summary();
  cut.complete = false;
  cut.ended = "interrupted";
  cut.lv = std::numeric_limits<double>::quiet_NaN();
  ResultFile(path_, rigid).close(cut);
  EXPECT_THAT(read(path_, "/time"), IsEmpty());
  check_in_python(path_);
}

TEST_F(Store, LongSceneAndEmptyStringsAreKept) {
  ResultHeader h = header(1, 1, 1);
  h.scene = std::string(300'000, '#');
  h.backend = "";
  ResultFile(path_, h).close(summary());
  check_in_python(path_);
}

TEST_F(Store, TakesManySmallBlocks) {
  const ResultHeader h = header(2, 1, 1);
  ResultFile file(path_, h);
  for (std::size_t j = 0; j < 50'000; ++j) file.append(block(h, j, 1));
  file.close(summary());
  EXPECT_EQ(read(path_, "/resonator/velocity"), block(h, 0, 50'000).resonator_velocity);
}

TEST_F(Store, RefusesABlockOfTheWrongShape) {
  const ResultHeader h = header(2, 1, 1);
  ResultFile file(path_, h);
  SampleBlock b = block(h, 0, 3);
  b.force.pop_back();
  EXPECT_THROW(file.append(b), std::logic_error);
}

// ---- shocks ------------------------------------------------------------------------------------

TEST_F(Store, ShocksInAnyOrderStandInOrderOfStartWithoutHoles) {
  ResultFile file(path_, header(1, 1, 0));
  file.append({shock(5), shock(2)});
  file.append(std::vector<Shock>{});
  file.append({shock(9), shock(0)});
  file.close(summary());
  EXPECT_THAT(read(path_, "/shocks/start"), ElementsAre(0, 2, 5, 9));
  EXPECT_THAT(read(path_, "/shocks/duration"), ElementsAre(0, 10, 25, 45));
  EXPECT_THAT(read(path_, "/shocks/peak_force"), ElementsAre(0, 4, 10, 18));
  EXPECT_THAT(read(path_, "/shocks/impulse"), ElementsAre(0, 6, 15, 27));
  EXPECT_THAT(read(path_, "/shocks/position"), ElementsAre(0, 8, 20, 36));
  check_in_python(path_);
}

TEST_F(Store, TheLastWordOnAShockCounts) {
  ResultFile file(path_, header(1, 1, 0));
  Shock longer = shock(1);
  longer.impulse = 77;
  file.append({shock(1), longer});
  file.close(summary());
  EXPECT_THAT(read(path_, "/shocks/impulse"), ElementsAre(77));
}

TEST_F(Store, ManyShocksFarOutOfOrder) {
  constexpr long count = 60'000, stride = 7'919;  // coprime: every serial once
  ResultFile file(path_, header(1, 1, 0));
  std::vector<double> expected;
  std::vector<Shock> batch;
  for (long k = 0; k < count; ++k) {
    const long serial = k * stride % count;
    if (serial % 3 != 1 && serial / 10'000 != 4) batch.push_back(shock(serial));
    if (batch.size() == 100) file.append(std::exchange(batch, {}));
    if (k % 3 != 1 && k / 10'000 != 4) expected.push_back(shock(k).impulse);
  }
  file.append(batch);
  file.close(summary());
  EXPECT_EQ(read(path_, "/shocks/impulse"), expected);
}

// ---- the thread that writes --------------------------------------------------------------------

TEST(WriterThread, DoesOneThingAfterTheOtherBesideTheCaller) {
  std::vector<int> done;
  std::thread::id there;
  WriterThread writer;
  for (int task = 0; task < 5; ++task)
    writer.start([&done, &there, task] {
      std::this_thread::sleep_for(std::chrono::milliseconds(5 - task));
      done.push_back(task);
      there = std::this_thread::get_id();
    });
  writer.wait();
  EXPECT_THAT(done, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_NE(there, std::this_thread::get_id());
}

TEST(WriterThread, PassesOnWhatATaskThrewBeforeTheNextBegins) {
  WriterThread writer;
  bool begun = false;
  writer.start([] { throw FileError("first"); });
  EXPECT_EQ(message_of([&] { writer.start([&] { begun = true; }); }), "first");
  EXPECT_FALSE(begun);
  EXPECT_FALSE(writer.has_failed());
  writer.wait();  // once
  writer.start([&] { begun = true; });
  writer.wait();
  EXPECT_TRUE(begun);
  writer.start([] { throw FileError("second"); });
  while (!writer.has_failed()) std::this_thread::yield();
  writer.finish();
  EXPECT_EQ(message_of([&] { writer.wait(); }), "second");
  writer.start([] { throw FileError("that nobody hears of"); });
}

// ---- what goes wrong ---------------------------------------------------------------------------

TEST_F(Store, DestroyedWithoutCloseLeavesNothing) {
  const ResultHeader h = header(20, 5, 1);
  {
    ResultFile file(path_, h);
    EXPECT_THAT(files(), ElementsAre(testing::StartsWith(".out.h5.partial-")));
    file.append(block(h, 0, 20'000));
    file.append({shock(3)});
  }
  EXPECT_THAT(files(), IsEmpty());
  EXPECT_EQ(H5Fget_obj_count(hid_t(H5F_OBJ_ALL), H5F_OBJ_ALL), 0);
}

TEST_F(Store, AnOlderFileStaysUntilTheNewOneIsWhole) {
  std::ofstream(path_) << "older";
  const auto content = [&] {
    std::ifstream file(path_);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  { ResultFile abandoned(path_, header(1, 1, 1)); }
  EXPECT_EQ(content(), "older");
  ResultFile file(path_, header(1, 1, 1));
  EXPECT_EQ(content(), "older");
  file.close(summary());
  EXPECT_THAT(files(), ElementsAre("out.h5"));
  EXPECT_THAT(read(path_, "/time"), IsEmpty());
}

TEST_F(Store, NamesTheMissingFolderAtOnce) {
  const fs::path path = folder_ / "missing" / "out.h5";
  const std::string message = message_of([&] { ResultFile(path, header(1, 1, 1)); });
  EXPECT_THAT(message, HasSubstr(path.string()));
  EXPECT_THAT(message, HasSubstr("No such file or directory"));
  EXPECT_THAT(message, HasSubstr("Create the folder"));
}

TEST_F(Store, NeverReplacesAFolderADeviceOrAPipe) {
  // root, who could replace the system's null device, has one of its own
  fs::path device = folder_ / "device";
  std::vector<std::string> there = {"pipe", "link", "ring"};
  if (mknod(device.c_str(), S_IFCHR | 0600, makedev(1, 3)) == 0)
    there.emplace_back("device");
  else
    device = "/dev/null";
  const fs::path pipe = folder_ / "pipe", link = folder_ / "link", ring = folder_ / "ring";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("pipe", link);
  fs::create_symlink("ring", ring);
  const std::pair<fs::path, const char*> refused[] = {
      {folder_, "this is a folder"}, {folder_ / "", "this is a folder"},
      {{}, "this is a folder"},      {device, "this is a device"},
      {pipe, "this is a pipe"},      {link, "it leads to a pipe"},
      {ring, "in a ring"},
  };
  for (const auto& [path, why] : refused)
    EXPECT_THAT(message_of([&] { ResultFile(path, header(1, 1, 1)); }), HasSubstr(why));
  EXPECT_THAT(files(), testing::UnorderedElementsAreArray(there));
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(Store, FollowsALinkAndKeepsIt) {
  fs::create_directory(folder_ / "far");
  std::ofstream(folder_ / "far" / "old.h5") << "an earlier result";
  fs::create_symlink("far/old.h5", path_);
  fs::create_symlink("out.h5", folder_ / "twice.h5");
  const ResultHeader h = header(1, 1, 1);
  for (const fs::path& path : {path_, folder_ / "twice.h5"}) {
    ResultFile file(path, h);
    file.append(block(h, 0, 1));
    file.close(summary());
    EXPECT_TRUE(fs::is_symlink(path));
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder_ / "far" / "old.h5")));
    EXPECT_EQ(read(path, "/time").size(), 1u);
  }
  // one that leads to no file yet
  fs::create_symlink("far/new.h5", folder_ / "fresh.h5");
  ResultFile(folder_ / "fresh.h5", h).close(summary());
  EXPECT_TRUE(fs::is_symlink(folder_ / "fresh.h5"));
  EXPECT_TRUE(fs::is_regular_file(folder_ / "far" / "new.h5"));
}

TEST_F(Store, WritesAgainstAFinishedFileAreRefused) {
  const ResultHeader h = header(1, 1, 1);
  ResultFile file(path_, h);
  file.close(summary());
  EXPECT_THROW(file.append(block(h, 0, 1)), FileError);
  EXPECT_THROW(file.append({shock(0)}), FileError);
  EXPECT_THROW(file.close(summary()), FileError);
  EXPECT_THAT(files(), ElementsAre("out.h5"));
}

TEST_F(Store, AFileThatDoesNotReadBackIsNotPublished) {
  ResultFile file(path_, header(1, 1, 1));
  for (const auto& entry : fs::directory_iterator(folder_)) fs::remove(entry);
  EXPECT_THAT(message_of([&] { file.close(summary()); }), HasSubstr("cannot finish"));
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(Store, KilledWhileWritingLeavesNothingUnderTheFinalName) {
  const pid_t child = fork();
  if (child == 0) {
    const ResultHeader h = header(20, 5, 1);
    ResultFile file(path_, h);
    for (std::size_t j = 0;; j += 1000) file.append(block(h, j, 1000));
  }
  const auto written = [&] {
    for (const auto& entry : fs::directory_iterator(folder_)) return entry.file_size();
    return std::uintmax_t{0};
  };
  EXPECT_TRUE(test::wait_until([&] { return written() >= 4'000'000; }));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_FALSE(fs::exists(path_));
}

/// Whether this process holds files open in `folder`, or what was taken back from there.
bool holds_files(const fs::path& folder) {
  for (const auto& link : fs::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const std::string target = fs::read_symlink(link, gone).string();
    if (target.starts_with(folder.string()) || target.starts_with("/memfd:ra2d")) return true;
  }
  return false;
}

/// Writes 50 MB and a few shocks; what was thrown.
std::string write_much(const fs::path& path) {
  return message_of([&] {
    const ResultHeader h = header(20, 5, 1);
    ResultFile file(path, h);
    for (std::size_t j = 0; j < 100'000; j += 1000) {
      file.append(block(h, j, 1000));
      file.append({shock(long(j))});
    }
    file.close(summary());
  });
}

/// No file may grow beyond `bytes`, in this process from now on.
void limit_file_size(rlim_t bytes) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_FSIZE, &limit);
}

TEST_F(Store, FailedWritesAreReportedAndLeaveNothing) {
  for (rlim_t bytes : {0, 1'000, 20'000, 100'000, 1'000'000, 3'000'000, 10'000'000, 20'000'001}) {
    const int status = in_child([&] {
      limit_file_size(bytes);
      for (int run = 0; run < 3; ++run) {  // a study goes on with its next run
        EXPECT_THAT(write_much(path_), AllOf(HasSubstr("File too large"), HasSubstr("ulimit -f")));
        EXPECT_THAT(files(), IsEmpty());
        EXPECT_FALSE(holds_files(folder_));
      }
      return HasFailure();
    });
    ASSERT_EQ(status, 0) << bytes << " bytes";
  }
}

TEST_F(Store, AFailureBesideTheCallerIsHeardOfAtTheNextCall) {
  const int status = in_child([&] {
    const ResultHeader h = header(20, 5, 1);
    ResultFile file(path_, h);
    file.append(block(h, 0, 10'000));
    limit_file_size(6'000'000);
    const std::string message = message_of([&] {
      file.append(block(h, 10'000, 6'400));            // which are more than that
      for (std::size_t j = 16'400; j < 24'000; ++j) {  // with the next ones nothing is written yet
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        file.append(block(h, j, 1));
      }
    });
    EXPECT_THAT(message, AllOf(HasSubstr("write the samples"), HasSubstr("File too large")));
    EXPECT_THAT(message_of([&] { file.append({shock(0)}); }), HasSubstr("an earlier write failed"));
    EXPECT_THAT(message_of([&] { file.close(summary()); }), HasSubstr("an earlier write failed"));
    EXPECT_THAT(files(), IsEmpty());
    return HasFailure();
  });
  EXPECT_EQ(status, 0);
}

TEST_F(Store, FailuresJustBeforeTheEndAreReported) {
  const auto write = [&] {
    const ResultHeader h = header(4, 2, 1);
    ResultFile file(path_, h);
    file.append(block(h, 0, 10'000));
    file.append({shock(1), shock(4)});
    file.close(summary());
  };
  write();
  const rlim_t whole = fs::file_size(path_);
  fs::remove(path_);
  for (rlim_t missing : {1, 8, 500, 2000, 5000, 66'000, 300'000}) {
    const int status = in_child([&] {
      limit_file_size(whole - missing);
      EXPECT_THAT(message_of(write), HasSubstr("File too large"));
      EXPECT_THAT(files(), IsEmpty());
      return HasFailure();
    });
    ASSERT_EQ(status, 0) << missing << " bytes missing";
  }
}

/// Takes the folder that the environment names for a disk: see tests/faults/faulty_disk.c.
void write_to_a_full_disk(const fs::path& folder) {
  for (int run = 0; run < 3; ++run) {
    EXPECT_THAT(write_much(folder / "out.h5"),
                AllOf(HasSubstr("No space left on device"), HasSubstr("Free some space")));
    EXPECT_TRUE(fs::is_empty(folder));
    EXPECT_EQ(H5Fget_obj_count(hid_t(H5F_OBJ_ALL), H5F_OBJ_ALL), 0);
    EXPECT_FALSE(holds_files(folder));
  }
}

TEST_F(Store, AFullDiskIsReportedAndLeavesNothing) {
  if (test::faulty_disk().empty()) GTEST_SKIP() << "no calls are made to fail under sanitizers";
  if (const char* folder = std::getenv("FAULTY_FOLDER")) return write_to_a_full_disk(folder);
  const test::Folder aside;
  for (int bytes : {0, 16'000, 1'000'000, 3'000'000, 20'000'000}) {
    // this test in a process of its own, where the folder has so much room
    const test::Ended child = test::run_program(
        aside.path(), {"env", "LD_PRELOAD=" + test::faulty_disk(),
                       "FAULTY_FOLDER=" + fs::canonical(folder_).string(),
                       fmt::format("FAULTY_ROOM={}", bytes), fs::read_symlink("/proc/self/exe"),
                       "--gtest_filter=Store.AFullDiskIsReportedAndLeavesNothing"});
    EXPECT_EQ(child.status, 0) << bytes << " bytes: " << child.out << child.err;
  }
}

// ---- what killed processes leave
// -----------------------------------------------------------------

/// A process that has written some of a file, until it is ended.
pid_t start_writing(const fs::path& path) {
  int ready[2];
  if (pipe(ready) != 0) return -1;
  const pid_t child = fork();
  if (child == 0) {
    const ResultHeader h = header(4, 2, 1);
    ResultFile file(path, h);
    file.append(block(h, 0, 10'000));
    [[maybe_unused]] const ssize_t written = write(ready[1], "x", 1);
    for (;;) pause();
  }
  char x;
  EXPECT_EQ(::read(ready[0], &x, 1), 1);
  close(ready[0]);
  close(ready[1]);
  return child;
}

void end(pid_t process) {
  kill(process, SIGKILL);
  waitpid(process, nullptr, 0);
}

TEST_F(Store, WhatKilledRunsLeftIsRemovedAndSaid) {
  const pid_t gone = start_writing(path_), also_gone = start_writing(folder_ / "other.h5");
  const pid_t living = start_writing(path_);
  end(gone);
  end(also_gone);
  char name[256] = "";
  gethostname(name, sizeof name);
  const std::string own = ".out.h5.partial-", host = name;
  // others', and what only looks like one of ours
  std::vector<std::string> kept = {own + "far-" + host + "-77", own + host + "-far-77", own + "77",
                                   "out.h5.partial-" + host + "-77", own + host + "-77.toml"};
  for (const std::string& other : kept) std::ofstream(folder_ / other) << "x";
  fs::create_symlink("elsewhere", folder_ / (own + host + "-78"));
  fs::create_directory(folder_ / (own + host + "-79"));
  kept.insert(kept.end(),
              {own + host + "-78", own + host + "-79", fmt::format("{}{}-{}", own, host, living)});
  EXPECT_EQ(files().size(), kept.size() + 2);

  testing::internal::CaptureStderr();
  ResultFile(folder_ / "new.h5", header(1, 1, 1)).close(summary());
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::MatchesRegex("ra2d: removed 2 partial files .[0-9.]+ MB. that killed runs "
                                    "had left beside the output\n"));
  kept.emplace_back("new.h5");
  EXPECT_THAT(files(), testing::UnorderedElementsAreArray(kept));

  end(living);
  testing::internal::CaptureStderr();
  write_text(folder_ / "a.csv", "texts do the same");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("removed 1 partial file ("));
}

TEST_F(Store, TwoFilesOfOneNameDoNotMeet) {
  testing::internal::CaptureStderr();
  ResultFile first(path_, header(1, 1, 1));
  ResultFile second(path_, header(2, 1, 1));
  EXPECT_EQ(files().size(), 2u);
  second.close(summary());
  EXPECT_EQ(read(path_, "/resonator/frequency").size(), 2u);
  first.close(summary());
  EXPECT_EQ(read(path_, "/resonator/frequency").size(), 1u);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Store, PartialFilesCanBeDroppedFromASignalHandler) {
  const int status = in_child([&] {
    const ResultFile file(path_, header(1, 1, 1));
    const PartialFile text(folder_ / "text");
    drop_partials();
    EXPECT_THAT(files(), IsEmpty());
    return int(HasFailure());
  });
  EXPECT_EQ(status, 0);
  // a child's copies are not its own
  const PartialFile ours(path_);
  EXPECT_EQ(in_child([] { return drop_partials(), 0; }), 0);
  EXPECT_EQ(files().size(), 1u);
}

TEST_F(Store, AFileWhereAFolderIsToStandIsNotDropped) {
  write_text(folder_ / "ours.parts", "x");
  const int status = in_child([&] {
    const PartialFolder parts(folder_ / "ours.parts");
    drop_partials();
    return 0;
  });
  EXPECT_EQ(status, 0);
  EXPECT_THAT(files(), ElementsAre("ours.parts"));
}

TEST_F(Store, TheLongestNameThatASystemTakesWillDo) {
  const std::string name = std::string(252, 'x') + "\u0bb3";  // a letter of three bytes
  write_text(folder_ / name, "x");
  EXPECT_THAT(files(), ElementsAre(name));
  EXPECT_THAT(message_of([&] { write_text(folder_ / (name + "x"), "x"); }),
              HasSubstr("Choose a shorter name"));
}

// ---- hashes
// --------------------------------------------------------------------------------------

TEST_F(Store, DatasetsCarryTheHashOfTheirBytes) {
  ResultFile(path_, header(0, 1, 0)).close(summary());
  const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const auto hash = [&](const char* name) {
    const hid_t attribute = H5Aopen_by_name(file, name, "xxh3_128", H5P_DEFAULT, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    char* characters = nullptr;
    H5Aread(attribute, type, &characters);
    std::string text = characters;
    H5free_memory(characters);
    H5Tclose(type);
    H5Aclose(attribute);
    return text;
  };
  // of nothing, and of the eight bytes of 0.0, as xxhsum -H2 prints them
  EXPECT_EQ(hash("/time"), "99aa06d3014798d86001c324468d497f");
  EXPECT_EQ(hash("/slider/frequency"), "2c0a8a99dc147d5445c3b49d035665b2");
  H5Fclose(file);
}

/// Overwrites a number in the only file of a folder; false when it is not there.
bool spoil(const fs::path& folder, double number) {
  const fs::path path = fs::directory_iterator(folder)->path();
  const std::size_t at =
      test::read_file(path).find(std::string(reinterpret_cast<const char*>(&number), 8));
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(std::streamoff(at));
  file.write("spoilt!!", 8);
  return at != std::string::npos;
}

TEST_F(Store, ANumberThatChangedOnItsWayIsSeen) {
  const ResultHeader h = header(4, 2, 1);
  const SampleBlock samples = block(h, 0, 20'000);
  ResultFile file(path_, h);
  file.append(samples);
  ASSERT_TRUE(spoil(folder_, samples.resonator_velocity[5'000 * 4 + 2]));
  EXPECT_THAT(message_of([&] { file.close(summary()); }), HasSubstr("does not read back"));
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(Store, AShockThatChangedOnItsWayIsSeen) {
  for (const double number : {shock(100).start, shock(100).impulse}) {
    ResultFile file(path_, header(1, 1, 0));
    std::vector<Shock> shocks;  // of more than HDF5 keeps to itself
    for (long k = 0; k < 200'000; ++k) shocks.push_back(shock(k));
    file.append(shocks);
    ASSERT_TRUE(spoil(folder_, number));
    EXPECT_THAT(message_of([&] { file.close(summary()); }), HasSubstr("does not read back"));
    EXPECT_THAT(files(), IsEmpty());
  }
}

}  // namespace
}  // namespace ra2d
