// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene_file/materials.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string>

namespace ra2d {
namespace {

constexpr std::string_view eurocode_3 = "EN 1993-1-1 (Eurocode 3), 3.2.6; density EN 1991-1-1",
                           eurocode_3_4 = "EN 1993-1-4 and EN 10088-1 (1.4301)",
                           eurocode_9 = "EN 1999-1-1 (Eurocode 9), 3.2.5",
                           eurocode_2 = "EN 1992-1-1 (Eurocode 2), C30/37; density EN 1991-1-1",
                           grey_iron = "EN 1561, EN-GJL-250, middle of 103 to 118 GPa",
                           ductile_iron = "EN 1563, EN-GJS-400-15",
                           kaye = "Kaye & Laby, Tables of Physical and Chemical Constants, 2.2",
                           asm_titanium = "ASM Materials Properties Handbook: Titanium Alloys",
                           flat_glass = "EN 572-1, soda-lime glass",
                           ashby =
                               "Ashby, Materials Selection in Mechanical Design, appendix A, "
                               "within its range";

constexpr Material all_materials[] = {
    {"steel", " iron ", 210e9, 7850, 0.3, 1e-4, 6e-4, eurocode_3},
    {"stainless-steel", " stainless inox ", 200e9, 7900, 0.3, 1e-4, 6e-4, eurocode_3_4},
    {"cast-iron", " grey-iron gray-iron ", 110e9, 7200, 0.26, 0, 0, grey_iron},
    {"ductile-iron", " nodular-iron ", 169e9, 7100, 0.275, 0, 0, ductile_iron},
    {"aluminium", " aluminum ", 70e9, 2700, 0.3, 1e-4, 1e-4, eurocode_9},
    {"titanium", " ti-6al-4v ", 113.8e9, 4430, 0.342, 0, 0, asm_titanium},
    {"copper", " ", 129.8e9, 8930, 0.343, 2e-3, 2e-3, kaye},
    {"brass", " ", 100.6e9, 8500, 0.35, 0, 1e-3, kaye},
    {"magnesium", " ", 44.7e9, 1740, 0.291, 1e-4, 1e-4, kaye},
    {"glass", " ", 70e9, 2500, 0.2, 6e-4, 2e-3, flat_glass},
    {"concrete", " ", 33e9, 2400, 0.2, 1e-2, 5e-2, eurocode_2},
    {"pmma", " acrylic plexiglas plexiglass perspex ", 3e9, 1190, 0.37, 2e-2, 4e-2, ashby},
    {"pom", " acetal delrin ", 3.5e9, 1410, 0.35, 0, 0, ashby},
};

}  // namespace

const std::string_view source_of_losses =
    "Beranek (ed.), Noise and Vibration Control, 1971: loss factors at audio frequencies";

std::span<const Material> materials() { return all_materials; }

const Material* find_material(std::string_view name) {
  std::string word(name);
  for (char& c : word) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (c == ' ' || c == '_') c = '-';
  }
  const auto* const found =
      std::find_if(std::begin(all_materials), std::end(all_materials), [&](const Material& one) {
        return one.name == word || one.other_names.find(' ' + word + ' ') != std::string_view::npos;
      });
  return found == std::end(all_materials) || word.empty() ? nullptr : found;
}

}  // namespace ra2d
