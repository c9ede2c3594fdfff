// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_table.hpp"

#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/hash.hpp"
#include "host/base/version.hpp"
#include "host/scene_file/key_facts.hpp"
#include "host/store/attributes.hpp"
#include "host/store/hdf5.hpp"
#include "host/store/plausible.hpp"
#include "host/store/seal.hpp"
#include "host/store/sealed_hdf5.hpp"
#include "host/system/input_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

using h5::check;

constexpr std::size_t most_points = 2 * most_study_runs;  // of a table that is read

/// A number of every run.
struct Column {
  const char *name, *units, *long_name;
  double RunFigures::*figure;
  bool Study::*kept;  // whether the study wants it; none: always
};

constexpr Column columns[] = {
    {"v_rms", "m s-1", "root mean square velocity of the resonator's elastic modes",
     &RunFigures::v_rms, &Study::keep_level},
    {"level", "dB", "level of v_rms re 1 nm/s", &RunFigures::lv, &Study::keep_level},
    {"shock_rate", "s-1", "shocks a second", &RunFigures::shock_rate, &Study::keep_shocks},
    {"shock_duration_median", "s", "median duration of the shocks",
     &RunFigures::shock_duration_median, &Study::keep_shocks},
    {"peak_force_median", "N", "median peak force of the shocks", &RunFigures::peak_force_median,
     &Study::keep_shocks},
    {"contact_share", "1", "share of the time with a node in contact", &RunFigures::contact_share,
     nullptr},
    {"energy_closure", "1", "residual of the energy balance, over its largest term",
     &RunFigures::energy_closure, nullptr},
    {"wall_seconds", "s", "time that the run took of its thread", &RunFigures::wall_seconds,
     nullptr},
};

/// A level of the sound of every run, where the study keeps it.
struct SoundColumn {
  const char *name, *units, *long_name;
  double SoundFigures::*figure;
  std::vector<double> StudyAnswers::*answer;
};

constexpr SoundColumn sound_columns[] = {
    {"lp", "dB", "sound pressure level re 20 uPa, over the scene's microphones", &SoundFigures::lp,
     &StudyAnswers::lp},
    {"lpa", "dB", "A-weighted sound pressure level re 20 uPa", &SoundFigures::lp_a,
     &StudyAnswers::lp_a},
    {"lw", "dB", "sound power level re 1 pW, to one side", &SoundFigures::lw, &StudyAnswers::lw},
    {"lwa", "dB", "A-weighted sound power level re 1 pW", &SoundFigures::lw_a, &StudyAnswers::lw_a},
};

/// The unit of an axis. Throws for a key that no scene has: a study's folder may be forged.
std::string units_of(const StudyDimension& dimension) {
  if (dimension.is_text || dimension.in_weights) return "1";
  const KeyFacts* const key = find_key(dimension.keys.front());
  if (key == nullptr)
    throw FileError(
        fmt::format("the study varies {}, and a scene has no such key: expected a key "
                    "of docs/scene.md",
                    dimension.keys.front()));
  return udunits(key->unit);
}

/// HDF5 in memory: it reaches the disk as bytes, whole or not at all.
class Image {
 public:
  explicit Image(const std::string& name) {
    const h5::Properties access{check(H5Pcreate(H5P_FILE_ACCESS))};
    constexpr std::size_t growth = 1 << 20;  // bytes
    check(H5Pset_fapl_core(access, growth, false));
    const h5::Properties creation = h5::ordered(H5P_FILE_CREATE);
    check(H5Pset_obj_track_times(creation, false));
    file_ = h5::File{check(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation, access))};
  }
  hid_t file() const { return file_; }
  std::string bytes() {
    check(H5Fflush(file_, H5F_SCOPE_GLOBAL));
    const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
    if (size < 0) h5::throw_failure();
    std::string bytes(static_cast<std::size_t>(size), '\0');
    if (H5Fget_file_image(file_, bytes.data(), bytes.size()) != size) h5::throw_failure();
    h5::close(file_);
    return bytes;
  }

 private:
  h5::File file_;
};

h5::Type text_type() {
  h5::Type text{check(H5Tcopy(H5T_C_S1))};
  check(H5Tset_size(text, H5T_VARIABLE));
  check(H5Tset_cset(text, H5T_CSET_UTF8));
  return text;
}

struct Writer {
  hid_t file;
  std::vector<hsize_t> shape{};
  std::vector<h5::Dataset> scales{};  // of the axes, in their order

  h5::Dataset make(const char* name, hid_t stored, hid_t given, const void* data,
                   const std::vector<hsize_t>& extent, const std::string& hash) const {
    const h5::Properties creation = h5::ordered(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(creation, false));
    const h5::Space space{
        check(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr))};
    h5::Dataset dataset{
        check(H5Dcreate2(file, name, stored, space, H5P_DEFAULT, creation, H5P_DEFAULT))};
    check(H5Dwrite(dataset, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
    h5::set_attribute(dataset, {"xxh3_128", hash});
    return dataset;
  }
  h5::Dataset numbers(const char* name, const std::vector<double>& values,
                      const std::vector<hsize_t>& extent) const {
    Hash hash;
    hash.add(values.data(), values.size());
    return make(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), extent, hash.text());
  }
  template <class Integer>
  h5::Dataset integers(const char* name, hid_t stored, hid_t given,
                       const std::vector<Integer>& values,
                       const std::vector<hsize_t>& extent) const {
    Hash hash;
    hash.add(std::string_view(reinterpret_cast<const char*>(values.data()),
                              values.size() * sizeof(Integer)));
    return make(name, stored, given, values.data(), extent, hash.text());
  }
  /// Hashed with a zero behind each.
  h5::Dataset words(const char* name, const std::vector<std::string>& texts,
                    const std::vector<hsize_t>& extent) const {
    Hash hash;
    std::vector<const char*> characters;
    for (const std::string& text : texts) {
      hash.add(std::string_view(text.c_str(), text.size() + 1));
      characters.push_back(text.c_str());
    }
    const h5::Type type = text_type();
    return make(name, type, type, characters.data(), extent, hash.text());
  }
  static void describe(const h5::Dataset& dataset, const std::string& units,
                       const std::string& long_name) {
    h5::set_attribute(dataset, {"units", units});
    h5::set_attribute(dataset, {"long_name", long_name});
  }
  void add_scale(h5::Dataset dataset, const std::string& name, const std::string& units,
                 const std::string& long_name, std::size_t size) {
    describe(dataset, units, long_name);
    check(H5DSset_scale(dataset, name.c_str()));
    scales.push_back(std::move(dataset));
    shape.push_back(size);
  }
  void add(h5::Dataset dataset, const std::string& units, const std::string& long_name) const {
    describe(dataset, units, long_name);
    for (unsigned axis = 0; axis < scales.size(); ++axis)
      check(H5DSattach_scale(dataset, scales[axis], axis));
    h5::close(dataset);
  }
};

void write_axes(Writer& out, const Study& study) {
  for (const StudyDimension& dimension : study.dimensions) {
    const std::vector<hsize_t> extent{dimension.size()};
    const char* const name = dimension.name.c_str();
    out.add_scale(dimension.is_text ? out.words(name, dimension.texts, extent)
                                    : out.numbers(name, dimension.numbers, extent),
                  dimension.name, units_of(dimension),
                  fmt::format("{}", fmt::join(dimension.keys, ", ")), dimension.size());
  }
  out.add_scale(
      out.integers("seed", H5T_STD_I64LE, H5T_NATIVE_INT64, study.seeds, {study.seeds.size()}),
      "seed", "1", "run, 1000 times which is added to both surfaces' seeds", study.seeds.size());
}

/// The study and its base as texts, and how many of its runs are done.
void write_attributes(hid_t file, const Study& study, std::size_t runs, std::int64_t done,
                      std::int64_t failed) {
  const auto give = [&](const h5::GivenAttribute& attribute) {
    h5::set_attribute(file, attribute);
  };
  give({"creator", "ra2d"});
  give({"study_format", std::int64_t{study_format}});
  give({"version", version()});
  give({"commit", commit()});
  give({"study", study.text});
  give({"base", study.base_text});
  give({"set", fmt::format("{}", fmt::join(study.given, "\n"))});
  std::string names;
  for (const StudyDimension& dimension : study.dimensions) names += dimension.name + ' ';
  give({"dimensions", names + "seed"});
  give({"runs", static_cast<std::int64_t>(runs)});
  give({"done", done});
  give({"failed", failed});
  give({"complete", std::int64_t{done + failed == static_cast<std::int64_t>(runs)}});
}

/// A variable for each figure of the runs: NaN where a run has none.
void write_figures(Writer& out, const Study& study, const std::vector<const FinishedRun*>& runs) {
  std::vector<double> values(runs.size());
  for (const Column& column : columns) {
    if (column.kept != nullptr && !(study.*column.kept)) continue;
    for (std::size_t i = 0; i < runs.size(); ++i)
      values[i] = (runs[i] != nullptr ? runs[i]->figures : no_figures).*column.figure;
    out.add(out.numbers(column.name, values, out.shape), column.units, column.long_name);
  }
  if (!study.keep_sound) return;
  for (const SoundColumn& column : sound_columns) {
    for (std::size_t i = 0; i < runs.size(); ++i)
      values[i] =
          runs[i] != nullptr && runs[i]->sound ? (*runs[i]->sound).*column.figure : quiet_nan;
    out.add(out.numbers(column.name, values, out.shape), column.units, column.long_name);
  }
}

std::string table_bytes(const std::filesystem::path& file, const StudyPoints& points,
                        const PointCensus& census, const FinishedRuns& finished) {
  const Study& study = points.study();
  const std::size_t count = points.size();
  std::vector<const FinishedRun*> runs(count);
  std::vector<std::int32_t> status(count, static_cast<std::int32_t>(RunStatus::missing));
  std::vector<std::string> messages(count);
  std::int64_t done = 0, failed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    runs[i] = finished.find(census.keys[i]);
    if (runs[i] == nullptr) continue;
    status[i] = static_cast<std::int32_t>(runs[i]->status);
    messages[i] = runs[i]->message;
    (runs[i]->status == RunStatus::done ? done : failed)++;
  }

  Image image(file.string());
  write_attributes(image.file(), study, count, done, failed);
  Writer out{image.file()};
  write_axes(out, study);
  write_figures(out, study, runs);
  out.add(out.integers("status", H5T_STD_I32LE, H5T_NATIVE_INT32, status, out.shape), "1",
          "0 done, 1 not run, 2 refused before its first step, 3 failed");
  out.add(out.words("message", messages, out.shape), "1",
          "why there are no numbers, or what the run warns of, a line each");
  if (study.keep_files) {
    std::vector<std::filesystem::path> folders;  // of the study, from the table's
    for (const std::filesystem::path& folder : finished.folders)
      folders.push_back(std::filesystem::proximate(folder, folder_of(file)));
    std::vector<std::string> files(count);
    for (std::size_t i = 0; i < count; ++i)
      if (runs[i] != nullptr && runs[i]->status != RunStatus::refused) {
        const std::filesystem::path result = StudyFolder::result(key_text(runs[i]->run));
        files[i] = folders.empty()
                       ? result.string()
                       : (folders[runs[i]->folder] / result).lexically_normal().string();
      }
    out.add(out.words("file", files, out.shape), "1",
            "the run's own result, from the table's folder");
  }
  for (h5::Dataset& scale : out.scales) h5::close(scale);
  return image.bytes();
}

// ---- reading -----------------------------------------------------------------------------------

/// A fault of a file; its name goes before it.
struct TableFault {
  std::string text;
};

h5::Dataset open_dataset(hid_t file, const std::string& name) {
  if (check(H5Lexists(file, name.c_str(), H5P_DEFAULT)) <= 0)
    throw TableFault{fmt::format("there is no /{} in it", name)};
  h5::Dataset dataset{check(H5Dopen2(file, name.c_str(), H5P_DEFAULT))};
  if (h5::is_elsewhere(dataset)) throw TableFault{fmt::format("/{} is kept in other files", name)};
  return dataset;
}

std::vector<hsize_t> extent_of(const h5::Dataset& dataset) {
  const h5::Space space{check(H5Dget_space(dataset))};
  std::vector<hsize_t> extent(static_cast<std::size_t>(check(H5Sget_simple_extent_ndims(space))));
  check(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
  return extent;
}

std::size_t size_of(const std::vector<hsize_t>& extent) {
  double size = 1;
  for (const hsize_t length : extent) size *= static_cast<double>(length);
  if (!(size <= static_cast<double>(most_points))) throw TableFault{"it is too large"};
  return static_cast<std::size_t>(size);
}

std::vector<double> read_numbers(const h5::Dataset& dataset) {
  const h5::Type type{check(H5Dget_type(dataset))};
  if (const H5T_class_t kind = H5Tget_class(type); kind != H5T_FLOAT && kind != H5T_INTEGER)
    throw TableFault{"it holds something else where numbers are expected"};
  std::vector<double> numbers(size_of(extent_of(dataset)));
  check(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()));
  return numbers;
}

std::vector<std::string> read_texts(const h5::Dataset& dataset) {
  std::vector<char*> characters(size_of(extent_of(dataset)), nullptr);
  check(H5Dread(dataset, text_type(), H5S_ALL, H5S_ALL, H5P_DEFAULT, characters.data()));
  std::vector<std::string> texts;
  for (char* one : characters) {
    texts.emplace_back(one == nullptr ? "" : one);
    H5free_memory(one);
  }
  return texts;
}

std::string read_text_attribute(hid_t file, const char* name) {
  if (check(H5Aexists(file, name)) <= 0)
    throw TableFault{"it is not the table of a study (write one with 'ra2d study')"};
  const h5::Attribute attribute{check(H5Aopen(file, name, H5P_DEFAULT))};
  const h5::Type type{check(H5Aget_type(attribute))};
  const h5::Space space{check(H5Aget_space(attribute))};
  if (H5Tis_variable_str(type) <= 0 || H5Sget_simple_extent_npoints(space) != 1)
    throw TableFault{fmt::format("its attribute '{}' is no text", name)};
  char* characters = nullptr;
  check(H5Aread(attribute, type, &characters));
  std::string text = characters == nullptr ? "" : characters;
  H5free_memory(characters);
  return text;
}

/// A table of another format may have other meanings.
void require_format(hid_t file) {
  if (check(H5Aexists(file, "study_format")) <= 0)
    throw TableFault{"it is not the table of a study (write one with 'ra2d study')"};
  const h5::Attribute attribute{check(H5Aopen(file, "study_format", H5P_DEFAULT))};
  const h5::Type type{check(H5Aget_type(attribute))};
  const h5::Space space{check(H5Aget_space(attribute))};
  std::int64_t format = -1;
  if (H5Tget_class(type) == H5T_INTEGER && H5Sget_simple_extent_npoints(space) == 1)
    check(H5Aread(attribute, H5T_NATIVE_INT64, &format));
  if (format != study_format)
    throw TableFault{
        fmt::format("it has format {}, and this program reads {}: take the program "
                    "that made it, or make it anew with 'ra2d study'",
                    format, study_format)};
}

/// Numbers that no study writes must not become a law.
void require_plausible(const StudyAnswers& answers) {
  for (const StudyAxis& axis : answers.axes)
    for (const double number : axis.numbers)
      if (!std::isfinite(number))
        throw TableFault{fmt::format("/{} has a value that is no number", axis.name)};
  for (std::size_t run = 0; run < answers.status.size(); ++run) {
    const double status = answers.status[run];
    if (status != std::floor(status) || !(status >= static_cast<double>(RunStatus::done)) ||
        !(status <= static_cast<double>(RunStatus::failed)))
      throw TableFault{fmt::format("/status says {} of a run, which means nothing", status)};
    for (const SoundColumn& level : sound_columns)
      if (const auto& values = answers.*level.answer; !values.empty() && values[run] > 1000)
        throw TableFault{fmt::format("/{} has {} dB, which is no sound", level.name, values[run])};
    if (!answers.shock_rate.empty() &&
        !(std::isnan(answers.shock_rate[run]) ||
          (answers.shock_rate[run] >= 0 && is_of_a_run(answers.shock_rate[run]))))
      throw TableFault{fmt::format("/shock_rate has {} shocks a second", answers.shock_rate[run])};
    if (answers.v_rms.empty()) continue;
    const double v_rms = answers.v_rms[run];
    const bool is_done = status == static_cast<double>(RunStatus::done);
    if (is_done ? !(v_rms >= 0 && is_of_a_run(v_rms)) && !std::isnan(v_rms) : !std::isnan(v_rms))
      throw TableFault{fmt::format("/v_rms has {} m/s for a run that {}", v_rms,
                                   is_done ? "is done" : "did not end")};
  }
}

StudyAnswers read_table(hid_t file) {
  require_format(file);
  StudyAnswers answers;
  answers.study = read_text_attribute(file, "study");
  answers.base = read_text_attribute(file, "base");
  answers.given = read_text_attribute(file, "set");
  answers.origin = fmt::format("ra2d {} ({})", read_text_attribute(file, "version"),
                               read_text_attribute(file, "commit"));
  std::string names = read_text_attribute(file, "dimensions") + ' ';
  for (std::size_t end; (end = names.find(' ')) != names.npos; names.erase(0, end + 1)) {
    StudyAxis axis;
    axis.name = names.substr(0, end);
    const h5::Dataset dataset = open_dataset(file, axis.name);
    const h5::Type type{check(H5Dget_type(dataset))};
    if (H5Tget_class(type) == H5T_STRING) {
      if (H5Tis_variable_str(type) <= 0) throw TableFault{"its words are of a fixed length"};
      axis.texts = read_texts(dataset);
    } else {
      axis.numbers = read_numbers(dataset);
      axis.units = read_text_attribute(dataset, "units");
    }
    axis.keys = read_text_attribute(dataset, "long_name");
    answers.axes.push_back(std::move(axis));
  }
  std::vector<hsize_t> shape;
  for (const StudyAxis& axis : answers.axes) shape.push_back(axis.size());
  const auto column = [&](const char* name) {
    const h5::Dataset dataset = open_dataset(file, name);
    if (extent_of(dataset) != shape)
      throw TableFault{fmt::format("/{} has another shape than its axes", name)};
    return read_numbers(dataset);
  };
  answers.status = column("status");
  const h5::Dataset messages = open_dataset(file, "message");
  if (extent_of(messages) == shape) answers.messages = read_texts(messages);
  if (check(H5Lexists(file, "v_rms", H5P_DEFAULT)) > 0) answers.v_rms = column("v_rms");
  if (check(H5Lexists(file, "shock_rate", H5P_DEFAULT)) > 0)
    answers.shock_rate = column("shock_rate");
  for (const SoundColumn& level : sound_columns)
    if (std::none_of(answers.axes.begin(), answers.axes.end(),
                     [&](const StudyAxis& axis) { return axis.name == level.name; }) &&
        check(H5Lexists(file, level.name, H5P_DEFAULT)) > 0)
      answers.*level.answer = column(level.name);
  require_plausible(answers);
  return answers;
}

}  // namespace

void write_study_table(const std::filesystem::path& file, const StudyPoints& points,
                       const PointCensus& census, const FinishedRuns& finished) {
  std::string bytes;
  try {
    const auto library = h5::take_library();
    bytes = table_bytes(file, points, census, finished);
  } catch (const h5::Failure& failure) {
    throw write_failure("make", file, failure.reason, failure.error);
  }
  write_text(file, bytes + seal_of(bytes));
}

bool is_study_table(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return false;
  const auto library = h5::take_library();
  const h5::CrashWatch watch(file);
  try {
    return looks_like_hdf5(file) && H5Aexists(open_sealed(file), "study_format") > 0;
  } catch (const FileError&) {
    return false;
  } catch (const Unreadable&) {
    return false;
  } catch (const h5::Failure&) {
    return false;
  }
}

bool is_damaged_table(const std::filesystem::path& file) {
  return is_damaged_with(file, "study_format");
}

std::filesystem::path study_table_of(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::is_directory(file, none)) return is_study_table(file) ? file : "";
  const std::filesystem::path table = StudyFolder{file}.table();
  return std::filesystem::exists(table, none) ? table : "";
}

StudyAnswers read_study_table(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::exists(file, none) && !std::filesystem::is_symlink(file, none))
    throw FileError(fmt::format("cannot read '{}': there is no such file. 'ra2d study' writes it",
                                file.string()));
  const auto library = h5::take_library();
  const h5::CrashWatch watch(file);
  try {
    require_seal(file);  // all of it: others read it, too, and do not look
    return read_table(open_sealed(file));
  } catch (const Unsealed& fault) {
    throw FileError(
        fmt::format("cannot read '{}': {}. Take a copy of it that is whole, or make it anew from "
                    "the ledgers with "
                    "'ra2d study merge'",
                    file.string(), fault.what()));
  } catch (const Unreadable& fault) {
    throw FileError(fmt::format("cannot read '{}': {}", file.string(), fault.what()));
  } catch (const h5::Failure& failure) {
    throw FileError(fmt::format("cannot read '{}': {}", file.string(), failure.reason));
  } catch (const TableFault& fault) {
    throw FileError(fmt::format("cannot read '{}': {}", file.string(), fault.text));
  }
}

}  // namespace ra2d
