// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/base/text.hpp"
#include "host/base/units.hpp"
#include "host/scene_file/toml.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_parts = 16;          // of a dotted key
constexpr std::size_t most_shown = 20;          // faults
constexpr std::size_t longest_override = 200;   // bytes, in a message
constexpr std::size_t longest_complaint = 400;  // of the TOML parser

bool is_bare(std::string_view key) {
  return !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

/// Whether an integer is written in hexadecimal, octal or binary.
bool is_in_another_base(const toml::value<std::int64_t>& integer) {
  return (integer.flags() & toml::value_flags::format_as_hexadecimal) != toml::value_flags::none;
}

/// An integer in the base in which it is written.
std::string integer_text(const toml::value<std::int64_t>& integer) {
  using Flags = toml::value_flags;
  if (is_in_another_base(integer)) {
    const Flags base = integer.flags() & Flags::format_as_hexadecimal;
    if (base == Flags::format_as_hexadecimal) return fmt::format("{:#x}", integer.get());
    return base == Flags::format_as_octal ? fmt::format("0o{:o}", integer.get())
                                          : fmt::format("{:#b}", integer.get());
  }
  return fmt::format("{}", integer.get());
}

/// A value as a message shows it.
std::string shown(const toml::node& node) {
  if (const auto* text = node.as_string()) return toml_string(shortened(text->get()));
  if (const auto* integer = node.as_integer()) return integer_text(*integer);
  if (const auto* number = node.as_floating_point()) return toml_number(number->get());
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  if (node.is_array()) return "an array";
  return "a date or time";
}

/// Skips a string of TOML that begins at `i`; one that does not end takes the rest of its line, or
/// of the text: it is an error to toml++, which reads no further.
std::size_t after_string(std::string_view text, std::size_t i) {
  const char quote = text[i];
  const std::string three(3, quote);
  const bool lines = text.substr(i, 3) == three;
  i += lines ? 3 : 1;
  for (; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;
    } else if (lines && text.substr(i, 3) == three) {
      i += 3;
      for (int more = 0; more < 2 && i < text.size() && text[i] == quote; ++more) ++i;
      return i;
    } else if (!lines && (text[i] == quote || text[i] == '\n')) {
      return i + 1;
    }
  }
  return i;
}

/// The line of the first key of too many parts, 0 where there is none. toml++ makes a table of each
/// part and destroys them one within the other: 300 000 are more than a stack holds.
std::uint32_t deep_line(std::string_view text) {
  std::uint32_t line = 1;
  std::size_t parts = 1;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      const std::size_t end = std::min(after_string(text, i), text.size());
      line += static_cast<std::uint32_t>(std::count(text.begin() + i, text.begin() + end, '\n'));
      i = end;
      continue;
    }
    if (c == '#')
      i = std::min(text.find('\n', i), text.size());
    else
      ++i;
    if (c == '\n') ++line;
    if (c == '.' && ++parts > most_parts) return line;
    if (std::string_view("=,{}[]\n").find(c) != std::string_view::npos) parts = 1;
  }
  return 0;
}

/// The table to which a line at the end of the text would belong, from the table that holds `mark`.
const toml::table* table_with(const toml::table& table, std::string_view mark) {
  if (table.contains(mark)) return &table;
  for (const auto& [name, node] : table) {
    const toml::table* inner = node.as_table();
    if (const auto* array = node.as_array(); array != nullptr && !array->empty())
      inner = array->back().as_table();
    if (inner == nullptr) continue;
    if (const toml::table* found = table_with(*inner, mark)) return found;
  }
  return nullptr;
}

/// Of a key or section that stands twice: the line of the first, and the cure. Empty for all other
/// errors, and inside lists and tables of one line.
std::string first_place(const std::string& text, const toml::parse_error& error) {
  constexpr std::string_view twice = "cannot redefine existing", mark = "the end";
  const std::string_view says = error.description();
  const std::size_t open = says.find('\''), close = says.rfind('\'');
  if (says.find(twice) == says.npos || open == close) return {};
  const std::string_view key = says.substr(open + 1, close - open - 1);
  std::size_t begin = 0;  // of the line with the error
  for (std::uint32_t line = 1; line < error.source().begin.line; ++line)
    begin = text.find('\n', begin) + 1;
  const std::string_view line = trimmed(std::string_view(text).substr(begin));
  const bool is_section = line.starts_with('[');
  if (!is_section && !line.starts_with(key)) return {};
  try {
    const toml::table before = toml::parse(text.substr(0, begin) + fmt::format("\"{}\" = 0", mark));
    const toml::table* table = is_section ? &before : table_with(before, mark);
    if (table == nullptr) return {};
    const toml::node* first = toml::at_path(*table, key).node();
    if (first == nullptr) return {};
    return fmt::format(", which stands in line {} already: keep one of the two",
                       first->source().begin.line);
  } catch (const toml::parse_error&) {  // the line is part of a value of several lines
    return {};
  }
}

std::string of(const std::string& what, const std::string& unit) {
  return unit.empty() ? what : fmt::format("{} ({})", what, unit);
}

std::string join(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + '.' + key;
}

TomlValue value_of(const toml::node& node) {
  TomlValue value;
  if (const auto* text = node.as_string()) {
    value.kind = TomlValue::Kind::text;
    value.text = text->get();
    value.toml = toml_string(value.text);
  } else if (const auto* integer = node.as_integer()) {
    value.kind = TomlValue::Kind::number;
    value.number = static_cast<double>(integer->get());
    value.toml = integer_text(*integer);
  } else if (const auto* number = node.as_floating_point()) {
    value.kind = TomlValue::Kind::number;
    value.number = number->get();
    value.toml = toml_number(value.number);
  } else if (const auto* truth = node.as_boolean()) {
    value.toml = truth->get() ? "true" : "false";
  } else if (const auto* array = node.as_array()) {
    value.kind = TomlValue::Kind::list;
    std::vector<std::string> texts;
    for (const toml::node& element : *array) {
      value.list.push_back(value_of(element));
      texts.push_back(value.list.back().toml);
    }
    value.toml = fmt::format("[{}]", fmt::join(texts, ", "));
  } else if (const auto* table = node.as_table()) {
    std::vector<std::string> texts;
    for (const auto& [name, inner] : *table) {
      const std::string key{name.str()};
      texts.push_back(
          fmt::format("{} = {}", is_bare(key) ? key : toml_string(key), value_of(inner).toml));
    }
    value.toml = fmt::format("{{ {} }}", fmt::join(texts, ", "));
  } else {  // a date or a time
    std::ostringstream text;
    node.visit([&](const auto& one) { text << one; });
    value.toml = text.str();
  }
  return value;
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
    std::vector<std::string> keys;    // that were read
    std::vector<std::string> needed;  // while the table is missing
  };

  std::string file;
  toml::table root;
  std::vector<Fault> faults;  // those of the first lines
  std::size_t count = 0;      // of all
  std::vector<Seen> seen;

  void add(std::uint32_t line, std::string text) {
    ++count;
    faults.push_back({line, std::move(text)});
    if (faults.size() >= 50 * most_shown) keep_first();
  }

  void keep_first() {
    std::stable_sort(faults.begin(), faults.end(),
                     [](const Fault& a, const Fault& b) { return a.line < b.line; });
    if (faults.size() > most_shown) faults.resize(most_shown);
  }

  /// Of a node: the file and the line, or the override.
  std::string place(const toml::node& node) const {
    const auto& source = node.source();
    return source.path ? *source.path  // only overrides carry one
                       : fmt::format("{}:{}", file, source.begin.line);
  }

  void fault(const toml::node& node, const std::string& path, const std::string& what) {
    const auto& source = node.source();
    add(source.path ? 0 : source.begin.line, fmt::format("{}: {}: {}", place(node), path, what));
  }

  void find_places(const toml::table& table, const std::string& path,
                   std::map<std::string, std::string>& places) const {
    places[path] = place(table);
    for (const auto& [name, node] : table) {
      const std::string key = join(path, std::string(name.str()));
      if (const toml::table* inner = node.as_table())
        find_places(*inner, key, places);
      else
        places[key] = place(node);
    }
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

  /// Whether a text at or in the node has the character at which files and names of files would
  /// cut it; says so.
  bool holds_nul(const toml::node& node, const std::string& path) {
    if (const auto* array = node.as_array())
      return std::any_of(array->begin(), array->end(),
                         [&](const toml::node& element) { return holds_nul(element, path); });
    const auto* text = node.as_string();
    if (text == nullptr || text->get().find('\0') == std::string::npos) return false;
    fault(node, path,
          fmt::format("{} holds U+0000, which ends a text in results: expected a text without it",
                      shown(node)));
    return true;
  }

  /// A number as it stands, in `unit`, or a text with a number and its unit.
  double number(const toml::node& node, const std::string& path, const Range& range,
                const std::string& unit, const std::string& expected) {
    std::optional<double> value;
    if (const auto* number = node.as_floating_point()) value = number->get();
    if (const auto* integer = node.as_integer()) {
      if (is_in_another_base(*integer)) {
        wrong(node, path, expected + ", in decimals");
        return quiet_nan;
      }
      value = static_cast<double>(integer->get());
    }
    if (const auto* text = node.as_string()) {
      const NumberWithUnit quantity = read_quantity(text->get(), unit);
      if (!quantity.fault.empty()) {
        fault(node, path,
              fmt::format("{} {}: expected {}{}", shown(node), quantity.fault, expected,
                          unit.empty() ? "" : ", or with its unit, " + quantity_examples(unit)));
        return quiet_nan;
      }
      constexpr double most = std::numeric_limits<double>::max();
      if (quantity.value) value = std::clamp(*quantity.value, -most, most);
    }
    const bool is_fine = value && std::isfinite(*value) && *value < range.high &&
                         (range.low_itself ? *value >= range.low : *value > range.low);
    if (!is_fine)
      wrong(node, path, expected);
    else if (std::abs(*value) > largest_size)
      fault(node, path,
            fmt::format("{} is too large to compute with: expected at most {:g}", shown(node),
                        largest_size));
    else if (range.low == 0 && *value != 0 && *value < smallest_size)
      fault(node, path,
            fmt::format("{} is too small to compute with: expected at least {:g}", shown(node),
                        smallest_size));
    else
      return *value;
    return quiet_nan;
  }

  Reader reader(Document& document, std::string path, const toml::node* node) {
    if (node != nullptr && !node->is_table()) wrong(*node, path, "a table");
    seen.push_back(
        {std::move(path), node != nullptr ? node->as_table() : nullptr, node == nullptr, {}, {}});
    return {document, seen.size() - 1};
  }

  /// The node of a key that is read; null when there is none.
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
    std::string where = "--set " + shortened(text, longest_override);
    std::replace(where.begin(), where.end(), '\n', ' ');  // a fault is one line
    const auto equals = text.find('=');
    constexpr std::string_view blanks = " \t\r\n";
    std::vector<std::string> path(1);
    for (const char c : trimmed(std::string_view(text).substr(0, equals), blanks)) {
      if (c == '.')
        path.emplace_back();
      else
        path.back() += c;
    }
    if (equals == std::string::npos || path.size() > most_parts ||
        !std::all_of(path.begin(), path.end(), is_bare))
      return add(0, where + ": not an override: expected section.key=value");
    toml::table given;
    try {
      given = parse_override(
          path, std::string(trimmed(std::string_view(text).substr(equals + 1), blanks)), where);
    } catch (const toml::parse_error&) {
      return add(0, where + ": not UTF-8: expected a value that TOML can hold");
    }
    toml::table* from = &given;
    toml::table* to = &root;
    for (std::size_t i = 0;; ++i) {
      toml::node* const value = from->get(path[i]);
      toml::node* const old = to->get(path[i]);
      if (old == nullptr || i + 1 == path.size()) {
        to->insert_or_assign(path[i],
                             std::move(*value));  // a move keeps the source, a copy does not
        drop_rival(*to, path[i]);
        return;
      }
      if (!old->is_table()) {
        std::string parent = path[0];
        for (std::size_t j = 1; j <= i; ++j) parent = join(parent, path[j]);
        return add(0, fmt::format("{}: {}: {} is no table, it has no `{}`: expected {}=value, "
                                  "to set it as a whole",
                                  where, parent, shown(*old), path[i + 1], parent));
      }
      from = value->as_table();
      to = old->as_table();
    }
  }

  /// Of two keys of which a scene has one, the one that is set last stays: on the command line
  /// nothing can be dropped.
  static void drop_rival(toml::table& table, const std::string& key) {
    constexpr std::pair<std::string_view, std::string_view> rivals[] = {
        {"max_frequency", "modes"}, {"rsm", "correlation_length"}};
    for (const auto& [first, second] : rivals)
      if (key == first || key == second) table.erase(key == first ? second : first);
  }

  /// The value as TOML; text that is none is a string, so that words need no quotes.
  static toml::table parse_override(const std::vector<std::string>& path, const std::string& value,
                                    const std::string& where) {
    const std::string key = fmt::format("{}", fmt::join(path, "."));
    try {
      const std::string line = key + " = " + value;
      toml::table given = deep_line(line) == 0 ? toml::parse(line, where) : toml::table{};
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
      const std::string shown = shortened(key);
      const std::string path = join(at.path, is_bare(key) ? shown : toml_string(shown));
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
  const std::uint32_t deep = deep_line(text);
  bool is_toml = deep == 0;
  if (!is_toml)
    parts_->add(deep, fmt::format("{}:{}: a key of more than {} parts: expected section.key",
                                  parts_->file, deep, most_parts));
  try {
    if (is_toml) parts_->root = toml::parse(text);
  } catch (const toml::parse_error& error) {
    const auto& at = error.source().begin;
    is_toml = false;
    if (text.starts_with("\x89HDF"))
      parts_->add(at.line, fmt::format("{}: an HDF5 file, such as a result: expected a text (TOML)",
                                       parts_->file));
    else
      parts_->add(at.line, fmt::format("{}:{}:{}: not TOML: {}{}", parts_->file, at.line, at.column,
                                       shortened(error.description(), longest_complaint),
                                       first_place(text, error)));
  }
  override_with(overrides);
  if (!is_toml) {
    parts_->seen.clear();  // what stands after the error is not known: no word on missing keys
    finish({});
  }
}

struct ParsedText::Table {
  toml::table root;
};

ParsedText::ParsedText(const std::string& text) {
  const std::string no_toml = "not TOML";
  if (deep_line(text) != 0) throw RequestError(no_toml);
  try {
    table_ = std::make_shared<const Table>(Table{toml::parse(text)});
  } catch (const toml::parse_error&) {
    throw RequestError(no_toml);
  }
}

Document::Document(const ParsedText& text, const std::filesystem::path& file,
                   const std::vector<std::string>& overrides)
    : parts_{std::make_unique<Parts>()} {
  parts_->file = file.string();
  parts_->root = text.table_->root;
  override_with(overrides);
}

void Document::override_with(const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) parts_->apply(text);
  parts_->seen.push_back({"", &parts_->root, false, {}, {}});
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
  require_none();
}

void Document::require_none() {
  const std::size_t count = parts_->count;
  if (count == 0) return;
  parts_->keep_first();
  std::string message = fmt::format("{}: {} fault{}", parts_->file, count, count == 1 ? "" : "s");
  for (const auto& fault : parts_->faults) message += '\n' + fault.text;
  if (count > most_shown) message += fmt::format("\nand {} more", count - most_shown);
  throw RequestError(message);
}

std::map<std::string, std::string> Document::places() const {
  std::map<std::string, std::string> places;
  parts_->find_places(parts_->root, "", places);
  return places;
}

bool Reader::exists() const { return document_->parts_->seen[index_].table != nullptr; }

std::size_t Reader::fault_count() const { return document_->parts_->count; }

bool Reader::has(const std::string& key) const {
  const auto& at = document_->parts_->seen[index_];
  return at.table != nullptr && at.table->contains(key);
}

bool Reader::says(const std::string& key, const std::string& word) const {
  const auto& at = document_->parts_->seen[index_];
  return at.table != nullptr && (*at.table)[key].value<std::string>() == word;
}

std::optional<double> Reader::multiple(const std::string& key, const std::string& word) const {
  const auto& at = document_->parts_->seen[index_];
  if (at.table == nullptr) return std::nullopt;
  const auto text = (*at.table)[key].value<std::string>();
  return text ? multiple_of(*text, word) : std::nullopt;
}

std::optional<double> Reader::number(const std::string& key, const Range& range,
                                     const std::string& unit, Need need,
                                     const std::string& or_word) {
  auto& parts = *document_->parts_;
  std::string expected = of(range.words, unit);
  if (!or_word.empty()) expected += " or " + toml_string(or_word);
  const toml::node* node = parts.take(index_, key, need, expected);
  if (node == nullptr) return need == Need::optional ? std::nullopt : std::optional(quiet_nan);
  if (!or_word.empty() && says(key, or_word)) return std::nullopt;
  return parts.number(*node, join(parts.seen[index_].path, key), range, unit, expected);
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
  const std::string path = join(parts.seen[index_].path, key);
  if (parts.holds_nul(*node, path)) return std::nullopt;
  if (const auto* text = node->as_string()) return text->get();
  parts.wrong(*node, path, what);
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
      out.push_back(parts.number(element, fmt::format("{}[{}]", path, out.size()), any_number, unit,
                                 of(any_number.words, unit)));
  } else {
    parts.wrong(*node, path, expected);
  }
  return out;
}

std::vector<std::vector<double>> Reader::numbers_or_pairs(const std::string& key,
                                                          const std::string& unit) {
  auto& parts = *document_->parts_;
  const std::string expected = of("an array of numbers", unit);
  const toml::node* node = parts.take(index_, key, Need::optional, expected);
  if (node == nullptr) return {};
  const std::string path = join(parts.seen[index_].path, key);
  std::vector<std::vector<double>> out;
  const auto* array = node->as_array();
  if (array == nullptr) {
    parts.wrong(*node, path, expected);
    return out;
  }
  for (const toml::node& element : *array) {
    const std::string place = fmt::format("{}[{}]", path, out.size());
    const auto number = [&](const toml::node& one) {
      return parts.number(one, place, any_number, unit, of(any_number.words, unit));
    };
    std::vector<double>& numbers = out.emplace_back();
    if (const auto* pair = element.as_array(); pair == nullptr)
      numbers = {number(element)};
    else if (pair->size() == 2)
      numbers = {number((*pair)[0]), number((*pair)[1])};
    else
      parts.wrong(element, place, of("a number, or two in brackets", unit));
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

std::vector<std::string> Reader::names() const {
  const toml::table* table = document_->parts_->seen[index_].table;
  if (table == nullptr) return {};
  std::vector<std::pair<toml::source_position, std::string>> found;  // the table has them by name
  for (const auto& [name, node] : *table)
    found.emplace_back(name.source().begin, std::string(name.str()));
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [position, name] : found) names.push_back(std::move(name));
  return names;
}

bool Reader::is_section(const std::string& key) const {
  const toml::table* table = document_->parts_->seen[index_].table;
  const toml::node* node = table != nullptr ? table->get(key) : nullptr;
  return node != nullptr && node->is_table() && !node->as_table()->is_inline();
}

std::optional<TomlValue> Reader::value(const std::string& key, const std::string& expected,
                                       Need need) {
  auto& parts = *document_->parts_;
  const toml::node* node = parts.take(index_, key, need, expected);
  if (node == nullptr || parts.holds_nul(*node, join(parts.seen[index_].path, key)))
    return std::nullopt;
  return value_of(*node);
}

void Reader::fault(const std::string& key, const std::string& what) {
  auto& parts = *document_->parts_;
  const auto& at = parts.seen[index_];
  const toml::node* node = at.table != nullptr ? at.table->get(key) : nullptr;
  const std::string path = join(at.path, is_bare(key) ? key : toml_string(shortened(key)));
  if (node != nullptr)
    parts.fault(*node, path, what);
  else
    parts.fault(path, what);
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
