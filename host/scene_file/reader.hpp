// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/names.hpp"

/// Reads a TOML text key by key, and collects every fault on the way.
namespace ra2d {

/// The finite numbers that a key takes, and how a message calls them. Beyond these bounds none is
/// taken: products and quotients of a few numbers of a scene stay finite between them.
inline constexpr double smallest_size = 1e-30;  // of a number that cannot be negative, and is not 0
inline constexpr double largest_size = 1e30;
struct Range {
  double low, high;  // low <= x < high
  bool low_itself;   // false: low < x
  const char* words;
};
inline constexpr double infinite = std::numeric_limits<double>::infinity();
inline constexpr Range any_number{-infinite, infinite, false, "a number"};
inline constexpr Range positive{0, infinite, false, "a number > 0"};
inline constexpr Range not_negative{0, infinite, true, "a number >= 0"};
inline constexpr Range ratio{0, 1, true, "a number in [0, 1)"};

/// `uncertain`: whether it is required depends on a key at fault. A missing number then reads as
/// NaN, without a fault of its own.
enum class Need { required, optional, uncertain };

class Document;

/// A value of any type.
struct TomlValue {
  enum class Kind { number, text, list, other };
  Kind kind = Kind::other;
  std::string toml;             // on one line, reads back as the same value
  double number = 0;            // of a number
  std::string text;             // of a text
  std::vector<TomlValue> list;  // of an array
};

/// One table of the document. Each key is read once; a key that no call reads is unknown. A value
/// at fault reads as NaN, so that comparisons with it find no further fault.
class Reader {
 public:
  Reader(Document& document, std::size_t index) : document_{&document}, index_{index} {}

  bool exists() const;
  bool has(const std::string& key) const;
  /// Faults of the whole document so far.
  std::size_t fault_count() const;

  /// In `unit`: a number, or a text with another unit (host/base/units.hpp).
  std::optional<double> number(const std::string& key, const Range& range, const std::string& unit,
                               Need need = Need::required, const std::string& or_word = {});
  /// Whether the key's value is this word.
  bool says(const std::string& key, const std::string& word) const;
  /// How often the key's value says this word: 2 for "2 weight", 1 for "weight".
  std::optional<double> multiple(const std::string& key, const std::string& word) const;
  std::optional<std::int64_t> integer(const std::string& key, std::int64_t low, std::int64_t high,
                                      Need need);
  std::optional<std::string> text(const std::string& key, const std::string& what, Need need);
  std::optional<bool> boolean(const std::string& key);
  std::vector<double> numbers(const std::string& key, const std::string& unit);
  /// As numbers(), but an element may also be two numbers in brackets.
  std::vector<std::vector<double>> numbers_or_pairs(const std::string& key,
                                                    const std::string& unit);
  std::optional<Reader> table(const std::string& key);
  std::vector<Reader> tables(const std::string& key, Need need);

  template <class E>
  std::optional<E> choice(const std::string& key, const Choices<E>& choices, Need need) {
    std::vector<std::string> words;
    for (const auto& named : choices.words) words.push_back(named.first);
    const auto chosen = word(key, words, need);
    for (const auto& [name, value] : choices.words)
      if (chosen == name) return value;
    return std::nullopt;
  }

  /// The names of all its keys, in the order in which they stand. It reads none of them.
  std::vector<std::string> names() const;
  /// Whether the key is a section of its own, written as [a.b] or with dots, and no value.
  bool is_section(const std::string& key) const;
  std::optional<TomlValue> value(const std::string& key, const std::string& expected, Need need);
  /// A fault at one of its keys.
  void fault(const std::string& key, const std::string& what);

  /// Two keys for one thing: exactly one of them must stand.
  void one_of(const std::string& first, const std::string& second);

 private:
  std::optional<std::string> word(const std::string& key, const std::vector<std::string>& words,
                                  Need need);
  Document* document_;
  std::size_t index_;
};

/// A TOML text that is parsed once, for many documents that differ in their overrides. It has lost
/// its line numbers: for a message read the text itself.
class ParsedText {
 public:
  /// Throws RequestError for what is not TOML.
  explicit ParsedText(const std::string& text);

 private:
  friend class Document;
  struct Table;
  std::shared_ptr<const Table> table_;
};

/// A TOML text with overrides applied, and the faults found in it so far.
class Document {
 public:
  Document(const ParsedText& text, const std::filesystem::path& file,
           const std::vector<std::string>& overrides);
  /// Throws RequestError for what is not TOML at all.
  Document(const std::string& text, const std::filesystem::path& file,
           const std::vector<std::string>& overrides);
  ~Document();
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;

  /// The keys outside all sections.
  Reader root() { return {*this, 0}; }
  Reader section(const std::string& name);

  /// A fault at "section.key". Of a missing key the message has the line of its section.
  void fault(const std::string& path, const std::string& what);

  /// Ends the reading: finds the keys that were not read, and throws all faults as one RequestError
  /// that names the first of them. `hints`: for some unknown "section.key" the reason.
  void finish(const std::map<std::string, std::string>& hints);

  /// Throws the faults found so far, if there are any.
  void require_none();

  /// The place of each "section.key" and of each section: "FILE:LINE", or the override.
  std::map<std::string, std::string> places() const;

 private:
  friend class Reader;
  struct Parts;
  void override_with(const std::vector<std::string>& overrides);
  std::unique_ptr<Parts> parts_;
};

}  // namespace ra2d
