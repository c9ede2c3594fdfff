// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

/// The keys of a scene as other parts of the program ask for them: by name, without the member.
/// Both come from one table, host/scene_file/key_table.cpp.
namespace ra2d {

struct KeyFacts {
  std::string name;
  std::string type;      // "number > 0", "`\"rest\"`, `\"static\"`"
  std::string unit;      // "kg/m^3"; empty: a number without a unit, or no number
  std::string standing;  // "required", or its default
  std::string use;       // for what it is used; empty: always
  std::string meaning;
  std::vector<KeyFacts> inner;  // keys of a section, or of a table
};

/// The sections of a scene, each with its keys.
const std::vector<KeyFacts>& scene_sections();

/// A key by its path, such as "resonator.surface.rq" or "slider.surface.peaks[2].at"; null where a
/// scene has no such key.
const KeyFacts* find_key(const std::string& path);

/// The unit of a key by its path, "kg/m^3"; empty for none. Throws std::logic_error where a scene
/// has no such key.
const std::string& key_unit(const std::string& path);

/// A unit as the CF conventions and UDUNITS write it: "kg m-3" for "kg/m^3", "1" for none.
std::string udunits(const std::string& unit);
/// Back again: "m/s" for "m s-1", empty for "1".
std::string unit_of_udunits(const std::string& text);

/// The keys as a table in Markdown, for docs/scene.md.
std::string markdown_table(const std::vector<KeyFacts>& keys);

/// docs/scene.md with each of its tables of keys made anew. They stand between lines
/// "<!-- keys: SECTION -->" and "<!-- end of keys -->".
std::string with_key_tables(const std::string& page);

}  // namespace ra2d
