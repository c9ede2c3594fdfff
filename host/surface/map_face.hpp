// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

/// The faces of areal scenes (docs/scene.md).
namespace ra2d {

/// The nodes of a body that need a height: `nx` of each row from the body's end on, and `rows`. Row
/// j is the middle of a strip, at side + (j + 1/2) spacing_y.
struct MapNodes {
  double length = 0, width = 0;       // m, of the area over which a random map has its rq and mean
  double spacing = 0, spacing_y = 0;  // m
  double side = 0;                    // m, where on the body the first strip begins
  double thickness = 0;               // m, of the body; 0: not known
  std::size_t nx = 0, rows = 0;
  std::size_t first = 0;   // the first node of a row that is ever touched
  std::size_t beyond = 0;  // nodes behind nx that are welcome: a spline feels them
};

/// Rows of a face: heights [m] at `nx` nodes each, row after row, positive towards the opposite
/// body.
struct MapRows {
  std::vector<double> heights;
  std::size_t nx = 0;     // with those of the nodes beyond that the face has
  std::size_t first = 0;  // the first node on the face: in front of it a row is level
};

/// The heights at the nodes. A random map begins at the first node and strip. A measured one, less
/// its mean, begins where its offsets say: node for node where its points are the nodes, else by
/// its bicubic spline (map_on_spline); in front of it, where nothing touches, it goes on level.
/// `scene_file` anchors a relative path; `doubts` takes a sentence for each value that looks wrong
/// but may be intended. Throws RequestError for a map that cannot be used: with gaps, too small, or
/// of more points than memory holds; FileError where it cannot be read.
MapRows map_face(const SurfaceSpec& spec, const MapNodes& nodes,
                 const std::filesystem::path& scene_file, std::vector<std::string>* doubts);

}  // namespace ra2d
