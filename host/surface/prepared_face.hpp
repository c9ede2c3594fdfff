// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

/// Faces from measured profiles of any format, prepared as the scene says.
namespace ra2d {

/// Renames options of a command, as the readers of files have them in their messages, to keys of a
/// scene.
std::string in_keys(std::string text);

/// A measured face, and the body that carries it.
struct FaceExtent {
  double height = 0;  // m, from the lowest to the highest point
  double slope = 0;   // root mean square
};
struct CarryingBody {
  const char* name;              // "beam" or "body"
  double length, thickness = 0;  // m; thickness 0: not known
};

/// Throws RequestError where a measured face is too high or too steep for its body, so that its
/// units must be wrong; `doubts` takes a sentence where it is unusual.
void check_proportion(const std::filesystem::path& file, const FaceExtent& face,
                      const CarryingBody& body, std::vector<std::string>* doubts);

/// Whether a profile is more than two columns in metres that are taken as they stand.
bool needs_preparation(const SurfaceSpec& spec, const std::filesystem::path& file);

/// Heights [m] at n spacing, n = 0 ... nodes - 1, mean zero over the nodes: gaps are filled, the
/// form and then the waves that the filters take are taken off, and half a cut-off at each end. The
/// first point that is left is at n = 0. `length` and `thickness` [m] are the beam's (0: not
/// known); `doubts` takes a sentence for each value that looks wrong but may be intended. Throws
/// RequestError for what cannot be used, FileError where the file cannot be read.
std::vector<double> prepared_face(const SurfaceSpec& spec, const std::filesystem::path& file,
                                  int nodes, double length, double spacing, double thickness,
                                  std::vector<std::string>* doubts);

/// A profile that goes on for ever. Behind each copy of it stands a seam, in which the copy goes on
/// mirrored at its end and fades out while the next one, mirrored at its beginning, fades in: their
/// weights are a cosine and a sine, so that neither a jump nor a change of the mean square is made.
class RepeatedProfile {
 public:
  /// Heights of mean zero, at least 2 of them.
  explicit RepeatedProfile(const std::vector<double>& heights);
  double at(std::size_t point) const;
  std::size_t seam() const { return seam_; }  // steps from one copy to the next

 private:
  const std::vector<double>& heights_;
  std::size_t seam_;
};

}  // namespace ra2d
