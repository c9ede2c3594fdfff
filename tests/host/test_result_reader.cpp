// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/result_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

#include "host/base/errors.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/store/checked_file.hpp"
#include "host/store/entries.hpp"
#include "host/store/seal.hpp"
#include "host/store/store.hpp"
#include "tests/child.hpp"
#include "tests/reseal.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class Reader : public testing::Test {
 protected:
  /// A file of two modes, three of the slider, one probe; sample j of mode k has the velocity 10 j
  /// + k.
  void write(std::size_t samples) const {
    ResultHeader header;
    header.scene = scene_;
    header.started = "now";
    header.spacing = 8e-6;
    header.resonator.frequency = {0, 100};
    header.resonator.position = {0, 1};
    header.resonator.shape = {1, 1, 2, 2};
    header.resonator.mean_square = std::vector<double>{0, 4};
    header.slider.frequency = {0, 0, 900};
    header.slider.position = {0, 1};
    header.slider.shape = std::vector<double>(6);
    header.slider.mean_square = std::vector<double>{0, 0, 5};
    header.probe_position = {0.5};
    header.compression = compression_;
    header.is_areal = is_areal_;
    for (ModesHeader* modes : {&header.resonator, &header.slider}) {
      modes->y = {0, 1, 2};
      modes->shape_x.assign(2 * modes->frequency.size(), 1);
      modes->shape_y.assign(3 * modes->frequency.size(), 1);
    }
    header.resonator.mode_x = header.resonator.mode_y = {1, 2};
    header.probe_y = {0.05};
    if (is_areal_) header.resonator_height = header.slider_height = {0.0};
    ResultFile file(path_, header);
    SampleBlock b;
    for (std::size_t j = 0; j < samples; ++j) {
      const auto x = static_cast<double>(j);
      b.time.push_back(x / 48e3);
      for (const double k : {0, 1}) b.resonator_velocity.push_back(10 * x + k);
      b.resonator_displacement.insert(b.resonator_displacement.end(), 2, x);
      for (auto* three : {&b.slider_displacement, &b.slider_velocity})
        three->insert(three->end(), 3, x);
      for (auto* one : {&b.force, &b.nodes, &b.probe_displacement, &b.probe_velocity, &b.kinetic,
                        &b.elastic, &b.contact, &b.damping_loss, &b.sliding_work, &b.load_work})
        one->push_back(x);
    }
    file.append(b);
    file.append({Shock{0, 1e-3, 2e-5, 3, 4e-5, 0.1}, Shock{1, 2e-3, 3e-5, 4, 5e-5, 0.2}});
    ResultSummary summary;
    summary.v_rms = 1e-3;
    summary.lv = 120;
    summary.shock_rate = shock_rate_;
    summary.complete = false;
    summary.ended = "interrupted";
    file.close(summary);
  }
  /// Changes the file as other programs might, and gives it a seal that fits, which they do not.
  void change(const std::function<void(hid_t)>& body) const {
    change_unsealed(body);
    test::reseal(path_);
  }
  void change_unsealed(const std::function<void(hid_t)>& body) const {
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    body(file);
    H5Fclose(file);
  }
  /// All numbers and texts that a reader gets.
  std::string everything() const {
    const ResultReader reader(path_);
    const ResultContents& c = reader.contents();
    std::string all = c.scene + c.origin + c.summary.ended;
    const auto add = [&](const std::vector<double>& values) {
      all.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
    };
    for (const auto& values : {c.resonator_frequency, c.slider_frequency, c.mean_square})
      add(values);
    for (const Shock& shock : c.shocks)
      add({shock.start, shock.duration, shock.peak_force, shock.impulse, shock.position});
    add({c.rate, c.end, c.summary.v_rms, c.summary.lv, double(c.summary.steps)});
    const SampleBlock block = reader.samples(0, c.samples);
    for (const Entry& entry : entries())
      if (const Sampled* member = source_of<Sampled>(entry)) add(block.**member);
    return all;
  }
  std::string refusal() const {
    try {
      const ResultReader reader(path_);
      reader.columns("resonator/velocity", 0, reader.contents().samples, 0, 2);
      reader.samples(0, reader.contents().samples);
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr("cannot read '" + path_.string() + "': "));
      return error.what();
    }
    return "no FileError";
  }
  std::string scene_ = "[scene]\n";
  Compression compression_ = Compression::none;
  bool is_areal_ = false;
  double shock_rate_ = std::numeric_limits<double>::quiet_NaN();
  const test::Folder folder_;
  const fs::path path_ = folder_.path() / "out.h5";
};

TEST_F(Reader, FindsWhatWasWritten) {
  constexpr std::size_t samples = 20'000;  // more than are read at once
  write(samples);
  const ResultReader reader(path_);
  const ResultContents& c = reader.contents();
  EXPECT_EQ(c.scene, "[scene]\n");
  EXPECT_EQ(c.samples, samples);
  EXPECT_EQ(c.rate, 48e3);
  EXPECT_EQ(c.end, 19'999 / 48e3);
  EXPECT_THAT(c.resonator_frequency, ElementsAre(0, 100));
  EXPECT_THAT(c.slider_frequency, ElementsAre(0, 0, 900));
  EXPECT_THAT(c.mean_square, ElementsAre(0, 4));
  EXPECT_THAT(c.probe_position, ElementsAre(0.5));
  ASSERT_EQ(c.shocks.size(), 2u);
  EXPECT_EQ(c.shocks[1].start, 2e-3);
  EXPECT_EQ(c.shocks[1].duration, 3e-5);
  EXPECT_EQ(c.shocks[1].peak_force, 4);
  EXPECT_EQ(c.shocks[1].impulse, 5e-5);
  EXPECT_EQ(c.shocks[1].position, 0.2);
  EXPECT_EQ(c.summary.v_rms, 1e-3);
  EXPECT_TRUE(std::isnan(c.summary.shock_rate));  // the file has none
  EXPECT_FALSE(c.summary.complete);
  EXPECT_EQ(c.summary.ended, "interrupted");

  const auto both = reader.columns("resonator/velocity", 5, 19'000, 0, 2);
  const auto second = reader.columns("resonator/velocity", 5, 19'000, 1, 1);
  ASSERT_EQ(both.size(), 2u);
  for (std::size_t j = 0; j < 19'000; ++j) {
    ASSERT_EQ(both[0][j], 10 * static_cast<double>(j + 5));
    ASSERT_EQ(both[1][j], 10 * static_cast<double>(j + 5) + 1);
  }
  EXPECT_THAT(second, ElementsAre(both[1]));
  EXPECT_THAT(reader.column("contact/force", 19'998, 2), ElementsAre(19'998, 19'999));
}

TEST_F(Reader, TakesAFileWithoutSamples) {
  write(0);
  const ResultReader reader(path_);
  EXPECT_EQ(reader.contents().samples, 0u);
  EXPECT_TRUE(std::isnan(reader.contents().rate));
}

TEST_F(Reader, RefusesWhatIsNoResult) {
  EXPECT_THAT(refusal(), HasSubstr("No such file or directory"));
  fs::create_directory(path_);
  EXPECT_THAT(refusal(), HasSubstr("this is a folder"));
  fs::remove(path_);
  std::ofstream(path_) << "[scene]\nduration = 1\n";
  EXPECT_THAT(refusal(), HasSubstr("it is no HDF5 file"));
  H5Fclose(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  EXPECT_THAT(refusal(), HasSubstr("it has no seal at its end"));
  test::reseal(path_);
  EXPECT_THAT(refusal(), HasSubstr("it is no result of ra2d"));
}

TEST_F(Reader, RefusesAnotherFormat) {
  write(3);
  for (const std::int64_t format : {1, 4, 1000}) {
    change([&](hid_t file) {
      const hid_t attribute = H5Aopen(file, "format", H5P_DEFAULT);
      H5Awrite(attribute, H5T_NATIVE_INT64, &format);
      H5Aclose(attribute);
    });
    EXPECT_THAT(refusal(), HasSubstr(fmt::format(
                               "its format is {}, and this program reads 2, 3 and 5: {}", format,
                               format > 5 ? "a newer ra2d" : "run its scene again")));
  }
}

/// Stores a dataset of integers as doubles under another name, as format 2 had it.
void to_format_2(hid_t file, const char* path, const char* old_path) {
  const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT), space = H5Dget_space(dataset);
  std::vector<double> values(H5Sget_simple_extent_npoints(space));
  H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(dataset);
  const hsize_t extent = values.size();
  H5Sset_extent_simple(space, 1, &extent, &extent);
  H5Ldelete(file, path, H5P_DEFAULT);
  if (old_path != nullptr) {
    const hid_t old =
        H5Dcreate2(file, old_path, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(old, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(old);
  }
  H5Sclose(space);
}

TEST_F(Reader, ReadsTheFormatBefore) {
  for (const char* serial : {"shocks/serial", static_cast<const char*>(nullptr)}) {
    fs::remove(path_);
    write(3);
    const std::string content = everything();
    change([&](hid_t file) {
      for (const char* count : {"resonator/mode", "slider/mode", "contact/nodes"})
        to_format_2(file, count, count);
      to_format_2(file, "shocks/shock", serial);
      const std::int64_t format = 2;
      const hid_t attribute = H5Aopen(file, "format", H5P_DEFAULT);
      H5Awrite(attribute, H5T_NATIVE_INT64, &format);
      H5Aclose(attribute);
    });
    EXPECT_EQ(refusal(), "no FileError");
    EXPECT_TRUE(everything() == content);
    EXPECT_EQ(ResultReader(path_).contents().shocks[1].serial, 1);
  }
}

TEST_F(Reader, WantsAllMotionOfTheModesOrNone) {
  write(3);
  const auto remove = [&](const char* path) {
    change([&](hid_t file) { H5Ldelete(file, path, H5P_DEFAULT); });
  };
  remove("resonator/velocity");
  EXPECT_THAT(refusal(), HasSubstr("/resonator/displacement is there, and /resonator/velocity"));
  for (const char* path : {"resonator/displacement", "slider/displacement", "slider/velocity"})
    remove(path);
  const ResultReader reader(path_);
  EXPECT_FALSE(reader.contents().has_modes);
  EXPECT_THROW(reader.columns("resonator/velocity", 0, 3, 0, 2), RequestError);
  EXPECT_THAT(reader.samples(0, 3).force, ElementsAre(0, 1, 2));
}

/// A compressed dataset may hold more numbers than the file has bytes, but not any number.
TEST_F(Reader, RefusesMoreNumbersThanDeflateCanPack) {
  compression_ = Compression::deflate;
  write(20'000);
  EXPECT_EQ(refusal(), "no FileError");
  change([](hid_t file) {
    const hid_t dataset = H5Dopen2(file, "time", H5P_DEFAULT);
    const hsize_t many[] = {1'000'000'000'000};
    EXPECT_GE(H5Dset_extent(dataset, many), 0);
    H5Dclose(dataset);
  });
  EXPECT_THAT(refusal(), HasSubstr("/time should hold more numbers than the file has room"));
}

/// Bytes that are no deflated ones, in a seal that fits.
TEST_F(Reader, RefusesDamagedChunksUnderAForgedSeal) {
  compression_ = Compression::deflate;
  write(20'000);
  const std::string whole = test::without_seal(test::read_file(path_));
  haddr_t at = 0;
  hsize_t size = 0;
  {
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, "resonator/velocity", H5P_DEFAULT);
    unsigned mask = 0;
    hsize_t place[2];
    const hid_t space = H5Dget_space(dataset);
    ASSERT_GE(H5Dget_chunk_info(dataset, space, 1, place, &mask, &at, &size), 0);
    H5Sclose(space);
    H5Dclose(dataset);
    H5Fclose(file);
  }
  for (const hsize_t into : {size / 2, size - 2}) {
    std::string damaged = whole;
    damaged[at + into] ^= 0x10;
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << damaged;
    test::reseal(path_);
    EXPECT_THAT(check_result(path_).faults, testing::Not(testing::IsEmpty())) << into;
  }
}

/// HDF5 copies as many bytes of a text as its global heap says that it has, from wherever they end
/// to wherever that leads.
TEST_F(Reader, RefusesTextsThatDoNotFitTheirHeap) {
  write(2);
  const std::string whole = test::without_seal(test::read_file(path_));
  const std::size_t heap = whole.find("GCOL");
  ASSERT_NE(heap, whole.npos);
  const auto number = [&](std::size_t at) {
    std::uint64_t read = 0;
    std::memcpy(&read, whole.data() + at, sizeof read);
    return read;
  };
  const auto forge = [&](std::size_t at, std::uint64_t forged) {
    std::string bytes = whole;
    std::memcpy(bytes.data() + at, &forged, sizeof forged);
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes << seal_of(bytes);
    EXPECT_THAT(refusal(), HasSubstr("the lengths of its texts do not fit their global heap"))
        << at - heap << ": " << forged << " for " << number(at);
  };
  const std::size_t end = heap + number(heap + 8);
  ASSERT_LT(whole.find(scene_, heap), end);  // the reader needs it
  for (const std::uint64_t size : {std::uint64_t{8}, whole.size() - heap + 1, ~std::uint64_t{0}})
    forge(heap + 8, size);
  // what is left at the end may be shorter than the 16 bytes that an object begins with
  for (std::size_t object = heap + 16; object + 16 <= end;) {
    const std::uint64_t size = number(object + 8);
    for (const std::uint64_t forged :
         {end - object - 15, std::uint64_t{1} << 40, ~std::uint64_t{0} - 16, ~std::uint64_t{0}})
      forge(object + 8, forged);
    if ((number(object) & 0xffff) == 0) break;  // the free room at the end
    object += 16 + (size + 7) / 8 * 8;
  }
}

TEST_F(Reader, RefusesWhatIsCutShort) {
  write(20'000);
  const auto whole = fs::file_size(path_);
  for (const double share : {0.999, 0.5, 0.01}) {
    fs::resize_file(path_, static_cast<std::uintmax_t>(share * static_cast<double>(whole)));
    EXPECT_THAT(refusal(), HasSubstr("it was cut short, or another program")) << share;
  }
}

TEST_F(Reader, RefusesWhatIsMissingOrOfTheWrongShape) {
  const auto with = [&](const std::function<void(hid_t)>& fault) {
    write(5);
    change(fault);
    return refusal();
  };
  const auto replace = [](hid_t file, const char* path, std::vector<hsize_t> extent, hid_t type) {
    H5Ldelete(file, path, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr);
    H5Dclose(H5Dcreate2(file, path, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space);
  };
  EXPECT_THAT(with([](hid_t f) { H5Ldelete(f, "energy/elastic", H5P_DEFAULT); }),
              HasSubstr("/energy/elastic is missing"));
  EXPECT_THAT(with([](hid_t f) { H5Ldelete(f, "resonator", H5P_DEFAULT); }),
              HasSubstr("/resonator/mode is missing"));
  is_areal_ = true;
  EXPECT_THAT(with([](hid_t f) { H5Ldelete(f, "shocks/y", H5P_DEFAULT); }),
              HasSubstr("/shocks/y is missing"));
  EXPECT_THAT(with([&](hid_t f) { replace(f, "shocks/y", {3}, H5T_NATIVE_DOUBLE); }),
              HasSubstr("/shocks/y is of the shape (3), its axes of (2)"));
  is_areal_ = false;
  EXPECT_THAT(with([&](hid_t f) { replace(f, "contact/force", {4}, H5T_NATIVE_DOUBLE); }),
              HasSubstr("/contact/force is of the shape (4), its axes of (5)"));
  EXPECT_THAT(with([&](hid_t f) {
                replace(f, "resonator/velocity", {5, 3}, H5T_NATIVE_DOUBLE);
              }),
              HasSubstr("/resonator/velocity is of the shape (5, 3), its axes of (5, 2)"));
  EXPECT_THAT(with([&](hid_t f) { replace(f, "shocks/impulse", {2}, H5T_NATIVE_INT64); }),
              HasSubstr("/shocks/impulse holds numbers of another type"));
  EXPECT_THAT(with([&](hid_t f) { replace(f, "time", {5}, H5T_NATIVE_DOUBLE); }),
              HasSubstr("its samples do not stand evenly"));
  EXPECT_THAT(with([](hid_t f) { H5Adelete(f, "ended"); }),
              HasSubstr("its attribute 'ended' is missing"));
}

TEST_F(Reader, RefusesAttributesOfManyValues) {
  // as large as the stack has no room for
  for (const char* name : {"format", "steps", "complete", "scene", "creator"}) {
    SCOPED_TRACE(name);
    fs::remove(path_);
    write(3);
    change([&](hid_t file) {
      const hid_t old = H5Aopen(file, name, H5P_DEFAULT), type = H5Aget_type(old);
      const hsize_t count = 4000;
      const hid_t space = H5Screate_simple(1, &count, nullptr);
      H5Aclose(old);
      H5Adelete(file, name);
      H5Aclose(H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
      H5Sclose(space);
      H5Tclose(type);
    });
    EXPECT_THAT(refusal(), HasSubstr(std::string("its attribute '") + name + "' is no "));
  }
}

TEST_F(Reader, RefusesNumbersThatAreNone) {
  const auto grow = [&](const char* path, std::vector<hsize_t> extent) {
    change([&](hid_t file) {
      const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
      std::vector<hsize_t> none(extent.size(), 0);
      none.back() = extent.size() > 1 ? extent.back() : 0;
      EXPECT_GE(H5Dset_extent(dataset, none.data()), 0);
      EXPECT_GE(H5Dset_extent(dataset, extent.data()), 0);  // of what fills it
      H5Dclose(dataset);
    });
  };
  write(5);
  grow("resonator/velocity", {5, 2});
  EXPECT_THAT(refusal(), HasSubstr("/resonator/velocity has values that are no numbers"));
  write(5);
  grow("shocks/impulse", {2});
  EXPECT_THAT(refusal(), HasSubstr("/shocks/impulse has values that are no numbers"));
}

/// A few bytes can ask for more memory than there is.
TEST_F(Reader, RefusesMoreNumbersThanTheFileHasRoomFor) {
  write(5);
  change([](hid_t file) {
    const hid_t dataset = H5Dopen2(file, "shocks/shock", H5P_DEFAULT);
    const hsize_t many[] = {1'000'000'000'000};
    EXPECT_GE(H5Dset_extent(dataset, many), 0);
    H5Dclose(dataset);
  });
  EXPECT_THAT(refusal(),
              HasSubstr("/shocks/shock should hold more numbers than the file has room"));
}

/// No seal covers those, and where they are a pipe reading never ends.
TEST_F(Reader, RefusesNumbersInOtherFiles) {
  const auto replaced = [&](const std::function<void(hid_t)>& put) {
    write(5);
    change([&](hid_t file) {
      EXPECT_GE(H5Ldelete(file, "contact/force", H5P_DEFAULT), 0);
      put(file);
    });
    return refusal() + " " + fmt::format("{}", fmt::join(check_result(path_).faults, "; "));
  };
  const auto with = [](void (*store)(hid_t)) {
    return [store](hid_t file) {
      const hsize_t five[] = {5};
      const hid_t space = H5Screate_simple(1, five, nullptr), how = H5Pcreate(H5P_DATASET_CREATE);
      store(how);
      const hid_t made = H5Dcreate2(file, "contact/force", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                                    how, H5P_DEFAULT);
      EXPECT_GE(made, 0);
      H5Dclose(made);
      H5Pclose(how);
      H5Sclose(space);
    };
  };
  const std::string text = "/contact/force is kept in other files";
  EXPECT_THAT(replaced(with([](hid_t how) { H5Pset_external(how, "/dev/zero", 0, 40); })),
              HasSubstr(text));
  EXPECT_THAT(replaced(with([](hid_t how) {
                const hsize_t five[] = {5};
                const hid_t space = H5Screate_simple(1, five, nullptr);
                H5Pset_virtual(how, space, "other.h5", "/time", space);
                H5Sclose(space);
              })),
              HasSubstr(text));
}

/// Otherwise a program would find other places than it looks up.
TEST_F(Reader, AsksWhetherPlacesRise) {
  const auto faults_with = [&](const char* path) {
    write(5);
    change([&](hid_t file) {
      const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
      const double two[] = {1, 1};
      EXPECT_GE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, two), 0);
      H5Dclose(dataset);
    });
    return fmt::format("{}", fmt::join(check_result(path_).faults, "; "));
  };
  EXPECT_THAT(faults_with("resonator/position"), HasSubstr("/resonator/position does not rise"));
  EXPECT_THAT(faults_with("resonator/mode"), HasSubstr("/resonator/mode does not rise"));
  EXPECT_THAT(faults_with("slider/position"), HasSubstr("/slider/position does not rise"));
}

// ---- the seal, and what a forger's seal does not vouch for
// ----------------------------------------

/// A reading gives the bytes that were written, or refuses.
TEST_F(Reader, TakesNoByteThatWasDamaged) {
  write(2);
  const std::string whole = test::read_file(path_), content = everything();
  std::mt19937 dice(1);
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  int refused = 0;
  const std::size_t seal = whole.size() - test::without_seal(whole).size();
  for (std::size_t i = 0; i < 400; ++i) {
    // of the seal, and of the bytes before it
    const std::size_t at = i < 100 ? whole.size() - 1 - dice() % seal : dice() % whole.size();
    const auto put = [&](char byte) {
      file.seekp(static_cast<std::streamoff>(at));
      file.put(byte).flush();
    };
    put(static_cast<char>(whole[at] ^ (1 << i % 8)));
    EXPECT_THROW(read_stamp(path_), FileError) << at;
    const std::string said = refusal();
    if (said == "no FileError") {
      EXPECT_TRUE(everything() == content) << at;
      EXPECT_GE(i, 100u) << "every byte of the seal counts";
    } else {
      ++refused;
      EXPECT_TRUE(said.find("it is damaged") != said.npos ||
                  said.find("it has no seal") != said.npos)
          << at << said;
    }
    put(whole[at]);
  }
  EXPECT_GT(refused, 300);
}

TEST_F(Reader, TakesNoFileThatWasCutOrMadeLonger) {
  write(2);
  const std::string whole = test::read_file(path_);
  const auto refuses = [&](const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    const std::string said = refusal();
    return said.find("it is damaged") != said.npos || said.find("it has no seal") != said.npos ||
           said.find("it is no HDF5 file") != said.npos;
  };
  for (std::size_t size : {std::size_t{0}, std::size_t{1}, seal_line_size, whole.size() / 2,
                           whole.size() - seal_line_size, whole.size() - 1})
    EXPECT_TRUE(refuses(whole.substr(0, size))) << size;
  EXPECT_TRUE(refuses(whole + '\n'));
  EXPECT_TRUE(refuses(whole + whole));
  EXPECT_TRUE(refuses(whole + whole.substr(whole.size() - seal_line_size)));
  EXPECT_TRUE(refuses(whole.substr(1)));
  EXPECT_FALSE(refuses(whole));
}

/// The file of before must not vouch for the one that took its name, nor for itself once it was
/// changed.
TEST_F(Reader, LooksAgainAtWhatWasChanged) {
  write(2);
  std::string bytes = test::read_file(path_);
  const std::size_t at = bytes.find("interrupted");  // an attribute that is read
  ASSERT_NE(at, bytes.npos);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(refusal(), "no FileError");
    bytes[at] ^= 1;
    std::ofstream(path_, std::ios::binary) << bytes;  // the same inode and size
    EXPECT_THAT(refusal(), HasSubstr("it is damaged"));
    bytes[at] ^= 1;
    std::ofstream(folder_.path() / "new.h5", std::ios::binary) << bytes;
    fs::rename(folder_.path() / "new.h5", path_);
  }
}

TEST_F(Reader, RefusesWhatAnotherProgramHasChanged) {
  write(3);
  const std::string whole = test::read_file(path_);
  const auto changed = [&](const std::function<void(hid_t)>& body) {
    std::ofstream(path_, std::ios::binary) << whole;
    change_unsealed(body);
    return refusal();
  };
  const auto text = [](hid_t object, const char* name, const char* characters) {
    const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT), type = H5Aget_type(attribute);
    EXPECT_GE(H5Awrite(attribute, type, &characters), 0);
    H5Tclose(type);
    H5Aclose(attribute);
  };
  EXPECT_THAT(changed([&](hid_t f) { text(f, "scene", "[scenE]\n"); }),
              HasSubstr("another program (h5py, h5repack, an editor) has changed it"));
  EXPECT_THAT(changed([&](hid_t f) {
                const hid_t force = H5Dopen2(f, "contact/force", H5P_DEFAULT);
                text(force, "units", "kN");
                H5Dclose(force);
              }),
              HasSubstr("another program"));
  EXPECT_THAT(changed([](hid_t f) {
                const hid_t v_rms = H5Dopen2(f, "summary/v_rms", H5P_DEFAULT);
                const double other = 2e-3;
                H5Dwrite(v_rms, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &other);
                H5Dclose(v_rms);
              }),
              HasSubstr("another program"));
  EXPECT_THAT(changed([](hid_t f) { H5Lmove(f, "energy", f, "work", H5P_DEFAULT, H5P_DEFAULT); }),
              HasSubstr("another program"));
  EXPECT_THAT(changed([](hid_t f) { H5Ldelete(f, "shocks", H5P_DEFAULT); }),
              HasSubstr("another program"));
}

TEST_F(Reader, TakesNoNumberThatNoRunComesTo) {
  const auto with = [&](const char* path, double value) {
    write(3);
    change([&](hid_t file) {
      const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT), space = H5Dget_space(dataset);
      std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
      H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
      values.back() = value;
      H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
      H5Sclose(space);
      H5Dclose(dataset);
    });
    return refusal();
  };
  scene_ =
      "[scene]\nduration = 0.01\nspeed = 0.1\nstart = 0.02\nspacing = 8e-6\n[resonator]\n"
      "support = \"pinned\"\nlength = 0.5\nthickness = 2e-3\nwidth = 0.1\nyoung = 2e11\n"
      "density = 7800\ndamping = 0.02\nmodes = 5\nsurface = { kind = \"flat\" }\n[slider]\n"
      "support = \"free\"\nlength = 0.02\nthickness = 5e-3\nwidth = 0.02\nyoung = 2e11\n"
      "density = 7800\ndamping = 0.02\nmodes = 1\nsurface = { kind = \"flat\" }\nload = 1\n"
      "[contact]\nstiffness = 1e13\n[time]\nscheme = \"adaptive\"\n"
      "[output]\nrate = 48000\nprobes = [0.5]\n";
  write(3);
  ASSERT_NO_THROW((void)parse_scene(scene_, "scene"));
  ASSERT_EQ(refusal(), "no FileError");
  EXPECT_THAT(with("shocks/duration", 1e99), HasSubstr("lasts 1e+99 s, which is beyond the run"));
  EXPECT_THAT(with("shocks/duration", 0.0081), HasSubstr("beyond the run"));
  EXPECT_THAT(with("shocks/duration", 0.0079), "no FileError");
  EXPECT_THAT(with("shocks/start", 0.011), HasSubstr("which is no time of the run"));
  EXPECT_THAT(with("shocks/start", -1e-9), HasSubstr("which is no time of the run"));
  EXPECT_THAT(with("shocks/position", 0.51), HasSubstr("outside the resonator"));
  EXPECT_THAT(with("probes/position", -0.1), HasSubstr("outside the resonator"));
  EXPECT_THAT(with("resonator/frequency", HUGE_VAL), HasSubstr("no frequency"));
  EXPECT_THAT(with("resonator/mean_square", -1), HasSubstr("no mean of squares"));
  EXPECT_THAT(with("resonator/frequency", 2e100), HasSubstr("no frequency"));
  EXPECT_THAT(with("resonator/velocity", -2e100), HasSubstr("too large for any run"));
  EXPECT_THAT(with("energy/elastic", 2e100), HasSubstr("too large for any run"));
  EXPECT_THAT(with("summary/v_rms", 2e-3), HasSubstr("another value than the file has elsewhere"));
  EXPECT_THAT(with("summary/contact_share", 1.1), HasSubstr("expected at most 1"));
  EXPECT_THAT(with("summary/shock_duration_90", -1), HasSubstr("which no run comes to"));
  EXPECT_THAT(with("summary/peak_force_90", -HUGE_VAL), HasSubstr("which no run comes to"));
  shock_rate_ = 200;
  EXPECT_THAT(with("summary/shock_rate", 99), HasSubstr("less than one shock in the run"));
  EXPECT_THAT(with("summary/shock_rate", 100), "no FileError");
  is_areal_ = true;
  EXPECT_THAT(with("shocks/y", 0.05), "no FileError");
  EXPECT_THAT(with("shocks/y", 0.11), HasSubstr("at y = 0.11 m, outside the resonator"));
}

}  // namespace
}  // namespace ra2d
