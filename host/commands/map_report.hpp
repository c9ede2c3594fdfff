// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/surface/height_map.hpp"

/// A height map in numbers, for people and as JSON.
namespace ra2d {

/// A length [m] for people.
std::string length_text(double length);

/// Lines with size, spacings and roughness, `missing` points having been filled.
void print_map(const HeightMap& map, std::size_t missing);

/// The figures of print_map in SI units; null is what is not defined.
nlohmann::ordered_json map_json(const HeightMap& map, std::size_t missing);

/// To be asked before the work: whether a map may be written there. An earlier file is replaced
/// only where its first line says that `command` has made it; .npy has no room to say so. Throws
/// RequestError.
void require_map_output(const std::filesystem::path& output, const std::string& command,
                        const std::vector<std::filesystem::path>& inputs);

}  // namespace ra2d
