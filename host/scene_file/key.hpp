// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/base/text.hpp"
#include "host/scene/names.hpp"
#include "host/scene/scene.hpp"
#include "host/scene_file/key_facts.hpp"
#include "host/scene_file/reader.hpp"

/// The building blocks of the table of keys: how a value of each kind is read into a member of
/// `Part`, a struct of the scene, and written as TOML again.
namespace ra2d::keys {

/// One kind of value, bound to a member.
template <class Part>
struct Value {
  std::string type, unit;  // as in KeyFacts
  std::string by_default;  // as TOML; empty: nothing
  std::vector<KeyFacts> inner;
  std::function<void(Reader&, const std::string& key, Need, Part&)> read;
  /// Empty for a list that is written as sections of its own.
  std::function<std::string(const Part&, const Scene&)> toml;
  /// Whether the member has another value than an absent key gives it.
  std::function<bool(const Part&)> is_given;
};

/// Whether a key must stand in a scene, and whether the echo writes one that does not.
template <class Part>
struct Standing {
  std::string words;  // for docs/scene.md; empty: the value's default
  bool (*is_required)(const Part&) = nullptr;
  bool is_always_written = false;
};
template <class Part>
Standing<Part> required() {
  return {"required", [](const Part&) { return true; }, false};
}
template <class Part>
Standing<Part> required_if(bool (*condition)(const Part&), const std::string& words) {
  return {words, condition, false};
}
/// The echo writes it with its default.
template <class Part>
Standing<Part> has_default(const std::string& words = {}) {
  return {words, nullptr, true};
}
/// The echo writes it where it is given. `words`: what holds where it is not.
template <class Part>
Standing<Part> may_stand(const std::string& words = {}) {
  return {words, nullptr, false};
}

/// For which scenes a key has an effect.
template <class Part>
struct Use {
  std::string words;  // for docs/scene.md; empty: for all
  /// Why the key has no effect; an empty text: it has.
  std::string (*why_not)(const Part&, const Scene&) = nullptr;
};

template <class Part>
struct Key {
  std::string name;
  Value<Part> value;
  Standing<Part> standing;
  std::string meaning;
  Use<Part> use = {};

  bool is_required(const Part& part) const {
    return standing.is_required != nullptr && standing.is_required(part);
  }
  bool is_written(const Part& part) const {
    return standing.is_always_written || is_required(part) || value.is_given(part);
  }
  std::string why_not_used(const Part& part, const Scene& scene) const {
    return use.why_not != nullptr ? use.why_not(part, scene) : std::string();
  }
};

/// The keys of a section or of a table, in the order in which they are written. Where some are
/// required by the value of another one, that is the first.
template <class Part>
struct Keys {
  std::vector<Key<Part>> list;
  /// Finds what is wrong between them. `is_certain`: the first key was read without a fault.
  void (*check)(Reader&, const Part&, bool is_certain) = nullptr;
};

// ---- the kinds of values

/// `type` without its article, as a table has it.
inline std::string without_article(const std::string& type) {
  for (const char* article : {"a ", "an "})
    if (type.starts_with(article)) return type.substr(std::string(article).size());
  return type;
}

/// A member that is a double, or an optional one. There is no default for the unit: a number
/// without one says so, by `no_unit`.
template <class Part, class Number>
Value<Part> number(Number Part::*member, const Range& range, const std::string& unit,
                   std::optional<double> by_default = {}) {
  Value<Part> value{without_article(range.words),
                    unit,
                    by_default ? fmt::format("{}", *by_default) : "",
                    {},
                    {},
                    {},
                    {}};
  value.read = [=](Reader& in, const std::string& key, Need need, Part& part) {
    const std::optional<double> given = in.number(key, range, unit, need);
    if constexpr (std::is_same_v<Number, double>)
      part.*member = given.value_or(by_default.value_or(0));
    else
      part.*member = given;
  };
  if constexpr (std::is_same_v<Number, double>) {
    value.toml = [=](const Part& part, const Scene&) { return toml_number(part.*member); };
    value.is_given = [=](const Part& part) { return part.*member != by_default.value_or(0); };
  } else {
    value.toml = [=](const Part& part, const Scene&) {
      return toml_number((part.*member).value());
    };
    value.is_given = [=](const Part& part) { return (part.*member).has_value(); };
  }
  return value;
}
inline const std::string no_unit;

/// A number or a word, which sets the flag. Both are kept.
template <class Part>
Value<Part> number_or_word(double Part::*member, bool Part::*flag, const std::string& word,
                           const Range& range, const std::string& unit) {
  Value<Part> value = number(member, range, unit);
  value.type = fmt::format("{}, {}, or `\"{}\"`", value.type, unit, word);
  value.read = [=](Reader& in, const std::string& key, Need need, Part& part) {
    part.*flag = in.says(key, word);
    part.*member = in.number(key, range, unit, need, word).value_or(0);
  };
  value.toml = [=](const Part& part, const Scene&) {
    return part.*flag ? toml_string(word) : toml_number(part.*member);
  };
  value.is_given = [=](const Part& part) { return part.*flag || part.*member != 0; };
  return value;
}

/// A number or a word, for which the member holds none.
template <class Part>
Value<Part> number_or_word(std::optional<double> Part::*member, const std::string& word,
                           const Range& range, const std::string& unit) {
  Value<Part> value = number(member, range, unit);
  value.type = fmt::format("{}, {}, or `\"{}\"`", value.type, unit, word);
  value.by_default = toml_string(word);
  value.read = [=](Reader& in, const std::string& key, Need need, Part& part) {
    part.*member = in.number(key, range, unit, need, word);
  };
  value.toml = [=](const Part& part, const Scene&) {
    return part.*member ? toml_number(*(part.*member)) : toml_string(word);
  };
  return value;
}

/// A member that is an integer (0 where the key is absent), or an optional one.
template <class Part, class Integer>
Value<Part> integer(Integer Part::*member, std::int64_t low, std::int64_t high) {
  Value<Part> value{fmt::format("integer >= {}", low), "", "", {}, {}, {}, {}};
  value.read = [=](Reader& in, const std::string& key, Need need, Part& part) {
    const std::optional<std::int64_t> given = in.integer(key, low, high, need);
    if constexpr (std::is_integral_v<Integer>)
      part.*member = static_cast<Integer>(given.value_or(0));
    else if (given)
      part.*member = static_cast<typename Integer::value_type>(*given);
  };
  if constexpr (std::is_integral_v<Integer>) {
    value.toml = [=](const Part& part, const Scene&) { return fmt::format("{}", part.*member); };
    value.is_given = [=](const Part& part) { return part.*member != 0; };
  } else {
    value.toml = [=](const Part& part, const Scene&) {
      return fmt::format("{}", (part.*member).value());
    };
    value.is_given = [=](const Part& part) { return (part.*member).has_value(); };
  }
  return value;
}

template <class E>
std::string type_of(const Choices<E>& choices) {
  std::string type;
  for (const auto& [word, choice] : choices.words)
    type += fmt::format("{}`\"{}\"`", type.empty() ? "" : ", ", word);
  return type;
}

/// One of some words.
template <class Part, class E>
Value<Part> choice(E Part::*member, const Choices<E>& choices, E by_default) {
  Value<Part> value{type_of(choices), "", toml_string(choices.name(by_default)), {}, {}, {}, {}};
  value.read = [=, &choices](Reader& in, const std::string& key, Need need, Part& part) {
    part.*member = in.choice(key, choices, need).value_or(by_default);
  };
  value.toml = [=, &choices](const Part& part, const Scene&) {
    return toml_string(choices.name(part.*member));
  };
  value.is_given = [=](const Part& part) { return part.*member != by_default; };
  return value;
}

/// One of some words, or none.
template <class Part, class E>
Value<Part> choice(std::optional<E> Part::*member, const Choices<E>& choices) {
  Value<Part> value{type_of(choices), "", "", {}, {}, {}, {}};
  value.read = [=, &choices](Reader& in, const std::string& key, Need need, Part& part) {
    part.*member = in.choice(key, choices, need);
  };
  value.toml = [=, &choices](const Part& part, const Scene&) {
    return toml_string(choices.name((part.*member).value()));
  };
  value.is_given = [=](const Part& part) { return (part.*member).has_value(); };
  return value;
}

/// A text. `understands`: whether it is one that the key takes, as `expected` says; "none" stands
/// for an empty text then.
template <class Part>
Value<Part> text(std::string Part::*member, const std::string& type,
                 const std::string& expected = "a text",
                 bool (*understands)(const std::string&) = nullptr) {
  Value<Part> value{type, "", "", {}, {}, {}, {}};
  value.read = [=](Reader& in, const std::string& key, Need need, Part& part) {
    const std::optional<std::string> given = in.text(key, expected, need);
    if (!given || (understands != nullptr && *given == "none")) return;
    if (understands != nullptr && !understands(*given))
      in.fault(key, fmt::format("{} is not allowed: expected {}", toml_string(shortened(*given)),
                                expected));
    part.*member = *given;
  };
  value.toml = [=](const Part& part, const Scene&) { return toml_string(part.*member); };
  value.is_given = [=](const Part& part) { return !(part.*member).empty(); };
  return value;
}

template <class Part>
Value<Part> boolean(bool Part::*member) {
  Value<Part> value{"`true`, `false`", "", "false", {}, {}, {}, {}};
  value.read = [=](Reader& in, const std::string& key, Need, Part& part) {
    part.*member = in.boolean(key).value_or(false);
  };
  value.toml = [=](const Part& part, const Scene&) { return part.*member ? "true" : "false"; };
  value.is_given = [=](const Part& part) { return part.*member; };
  return value;
}

inline std::string toml_array(const std::vector<std::string>& elements) {
  return fmt::format("[{}]", fmt::join(elements, ", "));
}

template <class Part>
Value<Part> numbers(std::vector<double> Part::*member, const std::string& unit) {
  Value<Part> value{"array of numbers", unit, "[]", {}, {}, {}, {}};
  value.read = [=](Reader& in, const std::string& key, Need, Part& part) {
    part.*member = in.numbers(key, unit);
  };
  value.toml = [=](const Part& part, const Scene&) {
    std::vector<std::string> texts;
    for (const double one : part.*member) texts.push_back(toml_number(one));
    return toml_array(texts);
  };
  value.is_given = [=](const Part& part) { return !(part.*member).empty(); };
  return value;
}

/// Places on a body: numbers, or pairs `[x, y]`.
template <class Part>
Value<Part> places(std::vector<ProbePlace> Part::*member, const std::string& unit) {
  Value<Part> value{"array of numbers", unit, "[]", {}, {}, {}, {}};
  value.read = [=](Reader& in, const std::string& key, Need, Part& part) {
    for (const std::vector<double>& place : in.numbers_or_pairs(key, unit)) {
      if (place.empty()) continue;  // a fault
      (part.*member).emplace_back(place[0]);
      if (place.size() == 2) (part.*member).back().y = place[1];
    }
  };
  value.toml = [=](const Part& part, const Scene&) {
    std::vector<std::string> texts;
    for (const ProbePlace& place : part.*member)
      texts.push_back(place.y ? toml_array({toml_number(place.x), toml_number(*place.y)})
                              : toml_number(place.x));
    return toml_array(texts);
  };
  value.is_given = [=](const Part& part) { return !(part.*member).empty(); };
  return value;
}

// ---- all keys of a section or of a table

/// Reads the keys of a table that is there or missing. One that is missing, and whose need is not
/// certain because the key that decides it is at fault, reads as NaN.
template <class Part>
void read(const Keys<Part>& keys, Reader& in, Part& part) {
  bool is_certain = true;
  for (const Key<Part>& key : keys.list) {
    const std::size_t faults = in.fault_count();
    const Need need = !key.is_required(part) ? Need::optional
                      : is_certain           ? Need::required
                                             : Need::uncertain;
    key.value.read(in, key.name, need, part);
    if (&key == &keys.list.front()) is_certain = in.fault_count() == faults;
  }
  if (keys.check != nullptr) keys.check(in, part, is_certain);
}

/// The keys line by line, those without effect with the reason.
template <class Part>
std::string written(const Keys<Part>& keys, const Part& part, const Scene& scene) {
  std::string lines;
  for (const Key<Part>& key : keys.list) {
    if (!key.value.toml || !key.is_written(part)) continue;
    const std::string why = key.why_not_used(part, scene);
    lines += fmt::format("{} = {}{}\n", key.name, key.value.toml(part, scene),
                         why.empty() ? "" : "  # not used: " + why);
  }
  return lines;
}

/// The keys as an inline table.
template <class Part>
std::string inline_table(const Keys<Part>& keys, const Part& part, const Scene& scene) {
  std::vector<std::string> texts;
  for (const Key<Part>& key : keys.list)
    if (key.is_written(part))
      texts.push_back(fmt::format("{} = {}", key.name, key.value.toml(part, scene)));
  return fmt::format("{{ {} }}", fmt::join(texts, ", "));
}

/// The keys of an inline table that have no effect: "rq, seed, the kind is \"flat\"".
template <class Part>
std::string unused_keys(const Keys<Part>& keys, const Part& part, const Scene& scene) {
  std::vector<std::pair<std::string, std::vector<std::string>>> found;  // reason, names
  for (const Key<Part>& key : keys.list) {
    const std::string why = key.is_written(part) ? key.why_not_used(part, scene) : std::string();
    if (why.empty()) continue;
    auto at = std::find_if(found.begin(), found.end(),
                           [&](const auto& reason) { return reason.first == why; });
    if (at == found.end()) at = found.insert(found.end(), {why, {}});
    at->second.push_back(key.name);
  }
  std::vector<std::string> texts;
  for (const auto& [why, names] : found)
    texts.push_back(fmt::format("{}, {}", fmt::join(names, ", "), why));
  return fmt::format("{}", fmt::join(texts, "; "));
}

template <class Part>
std::vector<KeyFacts> facts_of(const Keys<Part>& keys) {
  std::vector<KeyFacts> facts;
  for (const Key<Part>& key : keys.list) {
    const std::string& fallback = key.value.by_default;
    std::string standing = key.standing.words;
    if (standing.empty() && !fallback.empty()) standing = fmt::format("`{}`", fallback);
    facts.push_back({key.name, key.value.type, key.value.unit, standing, key.use.words, key.meaning,
                     key.value.inner});
  }
  return facts;
}

// ---- tables within tables

/// A table with keys of its own.
template <class Part, class Inner>
Value<Part> table(Inner Part::*member, const Keys<Inner>& keys, const std::string& by_default) {
  Value<Part> value{"table", "", by_default, facts_of(keys), {}, {}, {}};
  value.read = [=, &keys](Reader& in, const std::string& key, Need, Part& part) {
    if (auto inner = in.table(key)) read(keys, *inner, part.*member);
  };
  value.toml = [=, &keys](const Part& part, const Scene& scene) {
    return inline_table(keys, part.*member, scene);
  };
  value.is_given = [](const Part&) { return true; };
  return value;
}

/// A list of tables.
template <class Part, class Inner>
Value<Part> tables(std::vector<Inner> Part::*member, const Keys<Inner>& keys) {
  Value<Part> value{"array of tables", "", "", facts_of(keys), {}, {}, {}};
  value.read = [=, &keys](Reader& in, const std::string& key, Need need, Part& part) {
    for (Reader element : in.tables(key, need)) read(keys, element, (part.*member).emplace_back());
  };
  value.toml = [=, &keys](const Part& part, const Scene& scene) {
    std::vector<std::string> texts;
    for (const Inner& element : part.*member) texts.push_back(inline_table(keys, element, scene));
    return toml_array(texts);
  };
  value.is_given = [=](const Part& part) { return !(part.*member).empty(); };
  return value;
}

/// A value of a struct that is itself a member of the part.
template <class Part, class Inner>
Value<Part> within(Inner Part::*member, const Value<Inner>& inner) {
  Value<Part> value{inner.type, inner.unit, inner.by_default, inner.inner, {}, {}, {}};
  value.read = [=](Reader& in, const std::string& key, Need need, Part& part) {
    inner.read(in, key, need, part.*member);
  };
  value.toml = [=](const Part& part, const Scene& scene) {
    return inner.toml(part.*member, scene);
  };
  value.is_given = [=](const Part& part) { return inner.is_given(part.*member); };
  return value;
}

}  // namespace ra2d::keys
