// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/base/text.hpp"
#include "host/base/units.hpp"
#include "host/scene_file/key_facts.hpp"
#include "host/scene_file/reader.hpp"

namespace ra2d {
namespace {

constexpr std::size_t largest_text = 16u << 20;      // bytes
constexpr std::size_t largest_snapshot = 64u << 20;  // bytes
constexpr std::size_t longest_name = 60;
constexpr std::size_t most_dimensions = 30;  // of the 32 that HDF5 knows; one is the seeds'
constexpr int snapshot_format = 1;

/// Names that the table and its means over the seeds have for themselves.
const std::vector<std::string> taken = {"seed",
                                        "runs",
                                        "lv",
                                        "v_rms",
                                        "level",
                                        "shock_rate",
                                        "shock_duration_median",
                                        "peak_force_median",
                                        "contact_share",
                                        "energy_closure",
                                        "wall_seconds",
                                        "status",
                                        "message",
                                        "file"};

/// And where it holds the runs' sound.
const std::vector<std::string> taken_by_sound = {"lp", "lpa", "lw", "lwa"};

/// Whether it is one of the names, or a column of the means of one: "level_low", "level_mean_dB".
bool is_taken(const std::string& name, const Study& study) {
  const auto holds = [&](const std::vector<std::string>& names) {
    return std::any_of(names.begin(), names.end(), [&](const std::string& own) {
      if (name == own) return true;
      for (const char* figure : {"_mean", "_deviation", "_low", "_high"})
        if (name == own + figure || name.starts_with(own + figure + "_")) return true;
      return false;
    });
  };
  return holds(taken) || (study.keep_sound && holds(taken_by_sound));
}

bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= longest_name &&
         std::isdigit(static_cast<unsigned char>(text[0])) == 0 &&
         std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

bool is_key(const std::string& text) {
  std::size_t parts = 1, length = 0;
  for (const unsigned char c : text) {
    if (c == '.') {
      if (length == 0) return false;
      ++parts;
      length = 0;
    } else if (std::isalnum(c) != 0 || c == '_' || c == '-') {
      ++length;
    } else {
      return false;
    }
  }
  return parts >= 2 && parts <= 8 && length > 0;
}

constexpr const char* a_key = "a key of the scene, like \"scene.speed\"";

bool is_single(const TomlValue& value) {
  return value.kind == TomlValue::Kind::text ||
         (value.kind == TomlValue::Kind::number && std::isfinite(value.number));
}

/// Keys that are set already, and by what.
using Users = std::map<std::string, std::string>;

std::vector<std::int64_t> read_seeds(Reader& root) {
  constexpr const char* expected =
      "how many runs of other seeds (1 or more), or a list of their numbers, from 0";
  constexpr double most = 1e9;
  const auto value = root.value("seeds", expected, Need::optional);
  if (!value) return {0};
  std::vector<std::int64_t> seeds;
  const auto is_count = [&](const TomlValue& one, double least) {
    return one.kind == TomlValue::Kind::number && one.number == std::floor(one.number) &&
           one.number >= least && one.number <= most;
  };
  if (is_count(*value, 1)) {
    if (value->number > static_cast<double>(most_study_runs)) {
      root.fault("seeds", fmt::format("{} is not allowed: expected at most {} runs", value->toml,
                                      most_study_runs));
      return {0};
    }
    for (std::int64_t k = 0; k < static_cast<std::int64_t>(value->number); ++k) seeds.push_back(k);
    return seeds;
  }
  std::set<std::int64_t> seen;
  bool fine = value->kind == TomlValue::Kind::list && !value->list.empty();
  for (const TomlValue& one : value->list) {
    fine = fine && is_count(one, 0);
    if (!fine) break;
    seeds.push_back(static_cast<std::int64_t>(one.number));
    if (!seen.insert(seeds.back()).second) {
      root.fault("seeds", fmt::format("{} stands twice: expected each seed once", one.toml));
      return {0};
    }
  }
  if (fine) return seeds;
  root.fault("seeds",
             fmt::format("{} is not allowed: expected {}", shortened(value->toml), expected));
  return {0};
}

void read_keep(Reader& root, Study& study) {
  constexpr const char* expected = "a list of \"level\", \"shocks\", \"sound\" and \"files\"";
  const auto value = root.value("keep", expected, Need::optional);
  if (!value) return;
  study.keep_level = study.keep_shocks = false;
  bool fine = value->kind == TomlValue::Kind::list && !value->list.empty();
  for (const TomlValue& one : value->list) {
    if (one.text == "level")
      study.keep_level = true;
    else if (one.text == "shocks")
      study.keep_shocks = true;
    else if (one.text == "sound")
      study.keep_sound = true;
    else if (one.text == "files")
      study.keep_files = true;
    else
      fine = false;
  }
  if (!fine)
    root.fault("keep",
               fmt::format("{} is not allowed: expected {}", shortened(value->toml), expected));
}

/// [set] and the sections within it: keys with dots in quotes, or sections as a scene has them.
void read_set(Reader in, const std::string& before, Study& study, Users& users) {
  for (const std::string& name : in.names()) {
    const std::string key = before.empty() ? name : fmt::format("{}.{}", before, name);
    if (in.is_section(name)) {
      if (auto inner = in.table(name)) read_set(*inner, key, study, users);
      continue;
    }
    const auto value = in.value(name, "a value", Need::optional);
    if (!is_key(key))
      in.fault(name, fmt::format("names no key: expected {}", a_key));
    else if (!users.emplace(key, "[set]").second)
      in.fault(name, "is set twice: expected each key once");
    else if (value)
      study.set.push_back(key + "=" + value->toml);
  }
}

std::vector<std::string> read_keys(Reader& in, const std::string& name, Users& users) {
  std::vector<std::string> keys;
  in.one_of("key", "keys");
  if (const auto key = in.text("key", a_key, Need::optional)) keys.push_back(*key);
  if (const auto list = in.value("keys", "a list of keys", Need::optional)) {
    const bool fine = list->kind == TomlValue::Kind::list && !list->list.empty() &&
                      std::all_of(list->list.begin(), list->list.end(), [](const TomlValue& one) {
                        return one.kind == TomlValue::Kind::text;
                      });
    if (!fine)
      in.fault("keys", fmt::format("{} is not allowed: expected a list of keys of the scene",
                                   shortened(list->toml)));
    else
      for (const TomlValue& one : list->list) keys.push_back(one.text);
  }
  for (const std::string& key : keys) {
    const char* const at = in.has("keys") ? "keys" : "key";
    if (!is_key(key))
      in.fault(at,
               fmt::format("{} is not allowed: expected {}", toml_string(shortened(key)), a_key));
    else if (const auto [user, is_new] = users.emplace(key, "vary." + name); !is_new)
      in.fault(at,
               fmt::format("{} is set by {} already: expected each key once", key, user->second));
  }
  return keys;
}

/// How often a value of a key is the slider's weight, "weight" or "2 weight"; nothing for others.
std::optional<double> weights_of(const std::string& path, const TomlValue& value) {
  if (path != "slider.load" || value.kind != TomlValue::Kind::text) return std::nullopt;
  return multiple_of(value.text, "weight");
}

/// A value with a unit as the number that its key takes; any other value as it stands. A unit that
/// the key does not take is refused with the scene.
TomlValue in_unit_of(const std::string& path, const TomlValue& value) {
  const KeyFacts* key = find_key(path);
  if (const auto weights = weights_of(path, value)) {
    TomlValue load = value;
    load.text = *weights == 1 ? "weight" : fmt::format("{} weight", *weights);
    load.toml = toml_string(load.text);
    return load;
  }
  if (value.kind != TomlValue::Kind::text || key == nullptr || key->unit.empty()) return value;
  const NumberWithUnit quantity = read_quantity(value.text, key->unit);
  if (!quantity.value || !std::isfinite(*quantity.value)) return value;
  TomlValue number;
  number.kind = TomlValue::Kind::number;
  number.number = *quantity.value;
  number.toml = toml_number(number.number);
  return number;
}

/// Fills the values and coordinates of a dimension whose keys are known; says what is wrong.
std::string read_values(const TomlValue& values, StudyDimension& dimension) {
  if (values.kind != TomlValue::Kind::list || values.list.empty())
    return fmt::format("{} is not allowed: expected a list with a value or more",
                       shortened(values.toml));
  const std::size_t keys = dimension.keys.size();
  std::set<std::string> seen;
  std::vector<TomlValue> coordinates;
  for (const TomlValue& value : values.list) {
    const bool is_list = value.kind == TomlValue::Kind::list;
    if (is_list && keys < 2)
      return fmt::format("{} is not allowed: expected a number or a text for its one key",
                         shortened(value.toml));
    if (is_list && value.list.size() != keys)
      return fmt::format("{} has {} values: expected {}, one for each of its keys",
                         shortened(value.toml), value.list.size(), keys);
    const TomlValue first =
        in_unit_of(dimension.keys.front(), is_list ? value.list.front() : value);
    const bool fine =
        is_list ? std::all_of(value.list.begin(), value.list.end(), is_single) : is_single(value);
    if (!fine)
      return fmt::format("{} is not allowed: expected finite numbers or texts{}",
                         shortened(value.toml),
                         keys > 1 ? ", or lists of one for each of its keys" : "");
    const bool is_text = first.kind == TomlValue::Kind::text;
    dimension.is_text = dimension.is_text || is_text;
    // two that are one number are one place on the axis, however they are written
    if (!seen.insert(is_text ? first.text : toml_number(first.number + 0.0)).second)
      return fmt::format("{} stands twice: expected each value once", shortened(first.toml));
    coordinates.push_back(first);
    std::vector<std::string> texts;
    for (std::size_t k = 0; k < keys; ++k)
      texts.push_back(in_unit_of(dimension.keys[k], is_list ? value.list[k] : value).toml);
    dimension.values.push_back(std::move(texts));
  }
  const std::string& key = dimension.keys.front();
  dimension.in_weights =
      coordinates.size() > 1 &&
      std::all_of(coordinates.begin(), coordinates.end(),
                  [&](const TomlValue& at) { return weights_of(key, at).has_value(); });
  if (dimension.in_weights) {
    dimension.is_text = false;
    for (const TomlValue& at : coordinates) dimension.numbers.push_back(*weights_of(key, at));
    return {};
  }
  // Some keys take a word or a number (slider.load): where one is a word, all stand there as words.
  for (const TomlValue& at : coordinates)
    if (!dimension.is_text)
      dimension.numbers.push_back(at.number);
    else
      dimension.texts.push_back(at.kind == TomlValue::Kind::text ? at.text : at.toml);
  return {};
}

void read_vary(Reader vary, Study& study, Users& users) {
  for (const std::string& name : vary.names()) {
    auto in = vary.table(name);
    if (!is_name(name))
      vary.fault(name, fmt::format("is no name of a dimension: expected letters, digits and _, at "
                                   "most {}, a letter first",
                                   longest_name));
    else if (is_taken(name, study))
      vary.fault(name, "is a name that the table has for itself: choose another");
    if (!in || !in->exists()) continue;
    StudyDimension dimension;
    dimension.name = name;
    dimension.keys = read_keys(*in, name, users);
    constexpr const char* expected = "a list of values";
    const auto values = in->value("values", expected, Need::required);
    if (!values || dimension.keys.empty()) continue;
    if (const std::string fault = read_values(*values, dimension); !fault.empty())
      in->fault("values", fault);
    else
      study.dimensions.push_back(std::move(dimension));
  }
}

void check_size(const Study& study, Document& document) {
  if (study.dimensions.size() > most_dimensions)
    document.fault("vary", fmt::format("has {} dimensions: expected at most {}",
                                       study.dimensions.size(), most_dimensions));
  double runs = static_cast<double>(study.seeds.size());
  for (const StudyDimension& dimension : study.dimensions)
    runs *= static_cast<double>(dimension.size());
  if (runs > static_cast<double>(most_study_runs))
    document.fault("vary", fmt::format("asks for {:.3g} runs: expected at most {}; make several "
                                       "studies of it",
                                       runs, most_study_runs));
}

void check_given(const std::vector<std::string>& given, const Users& users, Document& document) {
  for (const std::string& text : given) {
    std::string key = text.substr(0, text.find('='));
    key.erase(std::remove_if(key.begin(), key.end(),
                             [](unsigned char c) { return std::isspace(c) != 0; }),
              key.end());
    const auto user = users.find(key);
    if (user != users.end() && user->second != "[set]")
      document.fault("vary", fmt::format("--set {}: {} varies this key: drop one of the two",
                                         shortened(text), user->second));
  }
}

}  // namespace

Study parse_study(const std::string& text, const std::filesystem::path& file,
                  const std::vector<std::string>& given) {
  if (text.size() > largest_text)
    throw RequestError(
        fmt::format("{}: more than 16 MiB: expected a study, a short text (is it another file?)",
                    file.string()));
  Document document{text, file, {}};
  Study study;
  study.file = file;
  study.text = text;
  study.given = given;
  Users users;
  Reader root = document.root();
  const auto base = root.text("base", "the scene's file, relative to this one", Need::required);
  if (base && base->empty())
    root.fault("base", "is empty: expected the scene's file");
  else if (base)
    study.base = std::filesystem::absolute(file.parent_path() / *base).lexically_normal();
  study.seeds = read_seeds(root);
  read_keep(root, study);
  if (auto set = root.table("set")) read_set(*set, "", study, users);
  if (auto vary = root.table("vary")) read_vary(*vary, study, users);
  check_size(study, document);
  check_given(given, users, document);
  document.finish(
      {{"scene", "a study names a scene by `base` and changes it in [set] and [vary]"}});
  return study;
}

Study read_study(const std::filesystem::path& file, const std::vector<std::string>& given) {
  Study study = parse_study(read_text(file, "the study", largest_text), file, given);
  std::error_code none;
  if (!std::filesystem::exists(study.base, none))
    throw FileError(
        fmt::format("'{}': base: there is no file '{}': expected a scene, relative to the "
                    "study's file. 'ra2d scenes NAME > base.toml' writes one that comes with ra2d",
                    file.string(), study.base.string()));
  study.base_text = read_text(study.base, "the study's base", largest_text);
  return study;
}

std::string snapshot_text(const Study& study) {
  nlohmann::ordered_json json;
  json["format"] = snapshot_format;
  json["file"] = std::filesystem::absolute(study.file).lexically_normal().string();
  json["study"] = study.text;
  json["base"] = study.base.string();
  json["base_text"] = study.base_text;
  json["set"] = study.given;
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

Study parse_snapshot(const std::string& text, const std::filesystem::path& file) {
  try {
    const auto json = nlohmann::json::parse(text);
    if (json.at("format") != snapshot_format)  // which may be a number that no int holds
      throw FileError(
          fmt::format("'{}' was written by another version of ra2d: move it away and run the "
                      "study's line again, which writes it anew",
                      file.string()));
    Study study =
        parse_study(json.at("study").get<std::string>(), json.at("file").get<std::string>(),
                    json.at("set").get<std::vector<std::string>>());
    study.base = json.at("base").get<std::string>();
    study.base_text = json.at("base_text").get<std::string>();
    return study;
  } catch (const nlohmann::json::exception&) {
    throw FileError(
        fmt::format("'{}' is damaged: move it away and run the study's line again, which writes it "
                    "anew",
                    file.string()));
  } catch (const RequestError& fault) {
    throw FileError(fmt::format("'{}' holds no study: {}", file.string(), fault.what()));
  }
}

Study study_of(const StudyFolder& folder) {
  const std::filesystem::path file = folder.snapshot();
  std::error_code none;
  if (!std::filesystem::exists(file, none))
    throw FileError(
        fmt::format("'{}' is no folder of a study: there is no {}. 'ra2d study "
                    "STUDY.toml -o DIR' makes one",
                    folder.path.string(), file.string()));
  return parse_snapshot(read_text(file, "the study's snapshot", largest_snapshot), file);
}

}  // namespace ra2d
