// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/key_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "host/scene_file/key_table.hpp"

namespace ra2d {
namespace {

/// The keys of both bodies as one table: those of the resonator, and what the slider has alone.
std::vector<KeyFacts> body_keys() {
  std::vector<KeyFacts> facts = keys::facts_of(keys::of_resonator());
  for (KeyFacts& own : keys::facts_of(keys::of_slider()))
    if (std::none_of(facts.begin(), facts.end(),
                     [&](const KeyFacts& one) { return one.name == own.name; }))
      facts.push_back(std::move(own));
  return facts;
}

/// The keys that a table of docs/scene.md shows.
std::vector<KeyFacts> keys_of_page_section(const std::string& section) {
  if (section == "body") return body_keys();
  const KeyFacts* found = find_key(section);
  if (found == nullptr) throw std::logic_error("a scene has no section " + section);
  return found->inner;
}

}  // namespace

const std::vector<KeyFacts>& scene_sections() {
  static const std::vector<KeyFacts> sections = [] {
    std::vector<KeyFacts> all;
    const auto add = [&](const char* name, std::vector<KeyFacts> inner) {
      all.push_back({name, "table", "", "", "", "", std::move(inner)});
    };
    add("scene", keys::facts_of(keys::of_scene()));
    add("resonator", keys::facts_of(keys::of_resonator()));
    add("slider", keys::facts_of(keys::of_slider()));
    add("contact", keys::facts_of(keys::of_contact()));
    add("time", keys::facts_of(keys::of_time()));
    add("output", keys::facts_of(keys::of_output()));
    add("air", keys::facts_of(keys::of_air()));
    return all;
  }();
  return sections;
}

const KeyFacts* find_key(const std::string& path) {
  const std::vector<KeyFacts>* among = &scene_sections();
  const KeyFacts* found = nullptr;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string part = path.substr(begin, end - begin);
    const std::string name = part.substr(0, part.find('['));  // of an element: of its list
    const auto at = std::find_if(among->begin(), among->end(),
                                 [&](const KeyFacts& key) { return key.name == name; });
    if (at == among->end()) return nullptr;
    found = &*at;
    among = &found->inner;
    begin = end + 1;
  }
  return found;
}

const std::string& key_unit(const std::string& path) {
  const KeyFacts* found = find_key(path);
  if (found == nullptr) throw std::logic_error("a scene has no key " + path);
  return found->unit;
}

std::string udunits(const std::string& unit) {
  if (unit.empty()) return "1";
  const std::size_t slash = unit.find('/'), power = unit.find('^');
  if (slash == std::string::npos) return unit;
  return fmt::format("{} {}-{}", unit.substr(0, slash), unit.substr(slash + 1, power - slash - 1),
                     power == std::string::npos ? "1" : unit.substr(power + 1));
}

std::string unit_of_udunits(const std::string& text) {
  if (text == "1") return {};
  const std::size_t blank = text.find(' '), sign = text.rfind('-');
  if (blank == std::string::npos || sign == std::string::npos || sign < blank) return text;
  const std::string power = text.substr(sign + 1);
  return text.substr(0, blank) + "/" + text.substr(blank + 1, sign - blank - 1) +
         (power == "1" ? "" : "^" + power);
}

std::string markdown_table(const std::vector<KeyFacts>& keys) {
  const bool has_use =
      std::any_of(keys.begin(), keys.end(), [](const KeyFacts& key) { return !key.use.empty(); });
  std::string text =
      fmt::format("| key | {}type, unit | default | meaning |\n|---|{}---|---|---|\n",
                  has_use ? "for | " : "", has_use ? "---|" : "");
  for (const KeyFacts& key : keys) {
    const bool has_unit = !key.unit.empty() && key.type.find(", " + key.unit) == std::string::npos;
    text += fmt::format("| `{}` | {}{}{} | {} | {} |\n", key.name,
                        has_use ? key.use + " | " : std::string(), key.type,
                        has_unit ? ", " + key.unit : "", key.standing, key.meaning);
  }
  return text;
}

std::string with_key_tables(const std::string& page) {
  const std::string begin = "<!-- keys: ", begin_end = " -->\n", end = "<!-- end of keys -->";
  std::string text;
  std::size_t at = 0;
  for (;;) {
    const std::size_t open = page.find(begin, at);
    const std::size_t name = open + begin.size(), name_end = page.find(begin_end, name);
    const std::size_t close = page.find(end, name_end);
    if (open == std::string::npos || name_end == std::string::npos || close == std::string::npos)
      return text + page.substr(at);
    text += page.substr(at, name_end + begin_end.size() - at) +
            markdown_table(keys_of_page_section(page.substr(name, name_end - name)));
    at = close;
  }
}

}  // namespace ra2d
