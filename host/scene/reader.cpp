// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "host/errors.hpp"
#include "host/scene/text.hpp"
#include "host/scene/toml.hpp"

namespace ra2d {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

std::string trimmed(const std::string& text) {
  constexpr auto blanks = " \t\r\n";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

bool is_bare(std::string_view key) {
  return !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

/// A value as a message shows it.
std::string shown(const toml::node& node) {
  if (const auto* text = node.as_string()) return toml_string(shortened(text->get()));
  if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
  if (const auto* number = node.as_floating_point()) return toml_number(number->get());
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  if (node.is_array()) return "an array";
  return "a date or time";
}

std::string of(const std::string& what, const std::string& unit) {
  return unit.empty() ? what : fmt::format("{} ({})", what, unit);
}

std::string join(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + '.' + key;
}

}  // namespace

struct Document::Parts {
  struct Fault {
    std::uint32_t line;  // 0: not in the file
    std::string text;
  };
  struct Seen {
    std::string path;
    const toml::table* table;         // null: missing or no table, then nothing more is said of it
    bool missing;                     // and this once, with the keys it needs
    std::vector<std::string> keys;    // asked for
    std::vector<std::string> needed;  // while the table is missing
  };

  std::string file;
  toml::table root;
  std::vector<Fault> faults;
  std::vector<Seen> seen;

  void fault(const toml::node& node, const std::string& path, const std::string& what) {
    const auto& source = node.source();
    if (source.path)  // only overrides carry one
      faults.push_back({0, fmt::format("{}: {}: {}", *source.path, path, what)});
    else
      faults.push_back(
          {source.begin.line, fmt::format("{}:{}: {}: {}", file, source.begin.line, path, what)});
  }

  void fault(const std::string& path, const std::string& what) {
    for (std::string there = path; !there.empty();) {
      if (const auto found = toml::at_path(std::as_const(root), there)) {
        return fault(*found.node(), path, what);
      }
      const auto cut = there.find_last_of(".[");
      there.resize(cut == std::string::npos ? 0 : cut);
    }
    fault(root, path, what);
  }

  void wrong(const toml::node& node, const std::string& path, const std::string& expected) {
    fault(node, path, fmt::format("{} is not allowed: expected {}", shown(node), expected));
  }

  double number(const toml::node& node, const std::string& path, const Range& range,
                const std::string& expected) {
    std::optional<double> value;
    if (const auto* number = node.as_floating_point()) value = number->get();
    if (const auto* integer = node.as_integer()) value = static_cast<double>(integer->get());
    if (value && std::isfinite(*value) && *value < range.high &&
        (range.low_itself ? *value >= range.low : *value > range.low))
      return *value;
    wrong(node, path, expected);
    return not_a_number;
  }

  Reader reader(Document& document, std::string path, const toml::node* node) {
    if (node != nullptr && !node->is_table()) wrong(*node, path, "a table");
    seen.push_back(
        {std::move(path), node != nullptr ? node->as_table() : nullptr, node == nullptr, {}, {}});
    return {document, seen.size() - 1};
  }

  /// The node of a key that is asked for; null when there is none.
  const toml::node* take(std::size_t index, const std::string& key, Need need,
                         const std::string& expected) {
    Seen& at = seen[index];
    at.keys.push_back(key);
    const toml::node* node = at.table != nullptr ? at.table->get(key) : nullptr;
    if (node == nullptr && need == Need::required) {
      if (at.table != nullptr)
        fault(join(at.path, key), "missing: expected " + expected);
      else
        at.needed.push_back(key);
    }
    return node;
  }

  /// "section.key=value", merged into the document with its own text as source.
  void apply(const std::string& text) {
    std::string where = "--set " + text;
    std::replace(where.begin(), where.end(), '\n', ' ');  // a fault is one line
    const auto equals = text.find('=');
    std::vector<std::string> path(1);
    for (const char c : trimmed(text.substr(0, equals))) {
      if (c == '.')
        path.emplace_back();
      else
        path.back() += c;
    }
    if (equals == std::string::npos || !std::all_of(path.begin(), path.end(), is_bare)) {
      faults.push_back({0, where + ": not an override: expected section.key=value"});
      return;
    }
    toml::table given = parse_override(path, trimmed(text.substr(equals + 1)), where);
    toml::table* from = &given;
    toml::table* to = &root;
    for (std::size_t i = 0;; ++i) {
      toml::node* const value = from->get(path[i]);
      toml::node* const old = to->get(path[i]);
      if (old == nullptr || i + 1 == path.size()) {
        to->insert_or_assign(path[i],
                             std::move(*value));  // a move keeps the source, a copy does not
        return;
      }
      if (!old->is_table()) {
        std::string parent = path[0];
        for (std::size_t j = 1; j <= i; ++j) parent = join(parent, path[j]);
        faults.push_back(
            {0, fmt::format("{}: {}: {} is no table, it has no `{}`: expected {}=value, "
                            "to set it as a whole",
                            where, parent, shown(*old), path[i + 1], parent)});
        return;
      }
      from = value->as_table();
      to = old->as_table();
    }
  }

  /// The value as TOML; text that is none is a string, so that words need no quotes.
  static toml::table parse_override(const std::vector<std::string>& path, const std::string& value,
                                    const std::string& where) {
    const std::string key = fmt::format("{}", fmt::join(path, "."));
    try {
      toml::table given = toml::parse(key + " = " + value, where);
      const toml::table* at = &given;  // a value with line ends must not bring keys of its own
      std::size_t alone = 0;
      while (alone < path.size() && at != nullptr && at->size() == 1)
        at = at->begin()->second.as_table(), ++alone;
      if (alone == path.size()) return given;
    } catch (const toml::parse_error&) {  // no TOML value: a word
    }
    return toml::parse(key + " = " + toml_string(value), where);
  }

  void find_unknown(const Seen& at, const std::map<std::string, std::string>& hints) {
    if (at.table == nullptr) return;
    for (const auto& [name, node] : *at.table) {
      const std::string key{name.str()};
      if (std::find(at.keys.begin(), at.keys.end(), key) != at.keys.end()) continue;
      const std::string path = join(at.path, is_bare(key) ? key : toml_string(key));
      const std::string noun = at.path.empty() && node.is_table() ? "section" : "key";
      fault(node, path, fmt::format("unknown {}{}", noun, cure(at, key, path, hints)));
    }
  }

  std::string cure(const Seen& at, const std::string& key, const std::string& path,
                   const std::map<std::string, std::string>& hints) const {
    if (const auto hint = hints.find(path); hint != hints.end()) return ": " + hint->second;
    for (const Seen& other : seen) {  // in the wrong section
      if (!other.path.empty() && other.path.find('.') == std::string::npos &&
          std::find(other.keys.begin(), other.keys.end(), key) != other.keys.end())
        return fmt::format(" (did you mean `{}`?)", join(other.path, key));
    }
    if (const auto near = nearest(key, at.keys)) return fmt::format(" (did you mean `{}`?)", *near);
    return ": expected " + any_of(at.keys, "`");
  }
};

Document::Document(const std::string& text, const std::filesystem::path& file,
                   const std::vector<std::string>& overrides)
    : parts_{std::make_unique<Parts>()} {
  parts_->file = file.string();
  bool is_toml = true;
  try {
    parts_->root = toml::parse(text);
  } catch (const toml::parse_error& error) {
    const auto& at = error.source().begin;
    is_toml = false;
    parts_->faults.push_back({at.line, fmt::format("{}:{}:{}: not TOML: {}", parts_->file, at.line,
                                                   at.column, error.description())});
  }
  for (const std::string& override_text : overrides) parts_->apply(override_text);
  parts_->seen.push_back({"", &parts_->root, false, {}, {}});
  if (!is_toml) {
    parts_->seen.clear();  // what stands after the error is not known: no word on missing keys
    finish({});
  }
}

Document::~Document() = default;

Reader Document::section(const std::string& name) {
  parts_->seen.front().keys.push_back(name);
  return parts_->reader(*this, name, parts_->root.get(name));
}

void Document::fault(const std::string& path, const std::string& what) {
  parts_->fault(path, what);
}

void Document::finish(const std::map<std::string, std::string>& hints) {
  for (const Parts::Seen& at : parts_->seen) {
    if (at.missing && !at.needed.empty())
      fault(at.path, fmt::format("missing section: expected [{}] with {}", at.path,
                                 fmt::join(at.needed, ", ")));
    parts_->find_unknown(at, hints);
  }
  auto& faults = parts_->faults;
  if (faults.empty()) return;
  std::stable_sort(faults.begin(), faults.end(),
                   [](const auto& a, const auto& b) { return a.line < b.line; });
  std::string message =
      fmt::format("{}: {} fault{}", parts_->file, faults.size(), faults.size() == 1 ? "" : "s");
  for (const auto& fault : faults) message += '\n' + fault.text;
  throw RequestError(message);
}

bool Reader::stands() const { return document_->parts_->seen[index_].table != nullptr; }

bool Reader::has(const std::string& key) const {
  const auto& at = document_->parts_->seen[index_];
  return at.table != nullptr && at.table->contains(key);
}

bool Reader::says(const std::string& key, const std::string& word) const {
  const auto& at = document_->parts_->seen[index_];
  return at.table != nullptr && (*at.table)[key].value<std::string>() == word;
}

std::optional<double> Reader::number(const std::string& key, const Range& range,
                                     const std::string& unit, Need need,
                                     const std::string& or_word) {
  auto& parts = *document_->parts_;
  std::string expected = of(range.words, unit);
  if (!or_word.empty()) expected += " or " + toml_string(or_word);
  const toml::node* node = parts.take(index_, key, need, expected);
  if (node == nullptr) return need == Need::required ? std::optional(not_a_number) : std::nullopt;
  if (!or_word.empty() && says(key, or_word)) return std::nullopt;
  return parts.number(*node, join(parts.seen[index_].path, key), range, expected);
}

std::optional<std::int64_t> Reader::integer(const std::string& key, std::int64_t low,
                                            std::int64_t high, Need need) {
  auto& parts = *document_->parts_;
  const bool open = high == std::numeric_limits<std::int64_t>::max();
  const std::string expected = open ? fmt::format("an integer >= {}", low)
                                    : fmt::format("an integer from {} to {}", low, high);
  const toml::node* node = parts.take(index_, key, need, expected);
  if (node == nullptr) return std::nullopt;
  const auto* integer = node->as_integer();
  if (integer != nullptr && integer->get() >= low && integer->get() <= high) return integer->get();
  parts.wrong(*node, join(parts.seen[index_].path, key), expected);
  return low;
}

std::optional<std::string> Reader::text(const std::string& key, const std::string& what,
                                        Need need) {
  auto& parts = *document_->parts_;
  const toml::node* node = parts.take(index_, key, need, what);
  if (node == nullptr) return std::nullopt;
  if (const auto* text = node->as_string()) return text->get();
  parts.wrong(*node, join(parts.seen[index_].path, key), what);
  return std::nullopt;
}

std::optional<std::string> Reader::word(const std::string& key,
                                        const std::vector<std::string>& words, Need need) {
  auto& parts = *document_->parts_;
  const std::string expected = any_of(words, "\"");
  const toml::node* node = parts.take(index_, key, need, expected);
  if (node == nullptr) return std::nullopt;
  const std::string path = join(parts.seen[index_].path, key);
  const auto* given = node->as_string();
  if (given == nullptr) {
    parts.wrong(*node, path, expected);
    return std::nullopt;
  }
  if (std::find(words.begin(), words.end(), given->get()) != words.end()) return given->get();
  const auto near = nearest(given->get(), words);
  const std::string meant = near ? fmt::format(" (did you mean \"{}\"?)", *near) : std::string{};
  parts.fault(*node, path,
              fmt::format("{} is unknown: expected {}{}", shown(*node), expected, meant));
  return std::nullopt;
}

std::optional<bool> Reader::boolean(const std::string& key) {
  auto& parts = *document_->parts_;
  const std::string expected = "true or false";
  const toml::node* node = parts.take(index_, key, Need::optional, expected);
  if (node == nullptr) return std::nullopt;
  if (const auto* truth = node->as_boolean()) return truth->get();
  parts.wrong(*node, join(parts.seen[index_].path, key), expected);
  return std::nullopt;
}

std::vector<double> Reader::numbers(const std::string& key, const std::string& unit) {
  auto& parts = *document_->parts_;
  const std::string expected = of("an array of numbers", unit);
  const toml::node* node = parts.take(index_, key, Need::optional, expected);
  if (node == nullptr) return {};
  const std::string path = join(parts.seen[index_].path, key);
  std::vector<double> out;
  if (const auto* array = node->as_array()) {
    for (const toml::node& element : *array)
      out.push_back(parts.number(element, fmt::format("{}[{}]", path, out.size()), any_number,
                                 of(any_number.words, unit)));
  } else {
    parts.wrong(*node, path, expected);
  }
  return out;
}

std::optional<Reader> Reader::table(const std::string& key) {
  auto& parts = *document_->parts_;
  const toml::node* node = parts.take(index_, key, Need::optional, "a table");
  if (node == nullptr) return std::nullopt;
  return parts.reader(*document_, join(parts.seen[index_].path, key), node);
}

std::vector<Reader> Reader::tables(const std::string& key, Need need) {
  auto& parts = *document_->parts_;
  const toml::node* node = parts.take(index_, key, need, "an array of tables");
  if (node == nullptr) return {};
  const std::string path = join(parts.seen[index_].path, key);
  std::vector<Reader> out;
  if (const auto* array = node->as_array()) {
    for (const toml::node& element : *array)
      out.push_back(parts.reader(*document_, fmt::format("{}[{}]", path, out.size()), &element));
  } else {
    parts.wrong(*node, path, "an array of tables");
  }
  return out;
}

void Reader::one_of(const std::string& first, const std::string& second) {
  auto& at = document_->parts_->seen[index_];
  const std::string path = at.path;
  if (at.table == nullptr)
    at.needed.push_back(first + " or " + second);
  else if (has(first) && has(second))
    document_->fault(join(path, second),
                     fmt::format("stands beside `{}`: expected one of the two (drop one)", first));
  else if (!has(first) && !has(second))
    document_->fault(join(path, first),
                     fmt::format("missing: expected `{}` or `{}`", first, second));
}

}  // namespace ra2d
