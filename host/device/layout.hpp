// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/model/model.hpp"
#include "kernels/tables.hpp"

/// How a scene is laid out over the lanes and in memory.
namespace ra2d {

struct FootprintShape;  // host/device/footprint_tables.hpp

/// The form of the scene's steps.
Form form_of(const Scene& scene);

/// The displacement series of a scene's resonator (kernels/tables.hpp, "Patches").
struct PatchSeries {
  int terms = 4;
  int patch_nodes = 1;
  /// Half a patch, half a group and a node more, in m: |eta| <= 1.
  double radius(const Model& model, int width) const {
    return (0.5 * (patch_nodes + width) + 1.0) * model.scene.spacing;
  }
};

/// Patches as wide as beta radius = 1/4 allows (four terms then leave out 2e-4 of the highest mode
/// and far less of the others), or of a single node when the nodes are that coarse; and terms until
/// what is left out, (beta radius)^terms/terms!, is below half an ulp. `width` is that of the
/// lanes. Throws RequestError where no number of terms will do.
PatchSeries choose_series(const Model& model, int width);

/// The lowest level of the flight tables. Flights of less are a Taylor step of third order: of
/// (fastest rate times time)^4/24 nothing is left there.
int first_flight_level(const Model& model);

/// Bound on what polynomials of a degree about the place of a cluster
/// (kernels/contact/cluster_places.hpp) leave out of a shape, in its own unit. Nothing of a
/// straight line.
double cluster_remainder(const Model& model, const BodyMode& mode, int degree);

/// The degree of these polynomials: the smaller of 2 and 3 that leaves out no more of any shape
/// than a small part of the tolerance, under fixed steps than 2^-24. 0 where a scene has no
/// clusters of nodes: neither does, the modes are too few (in packs of `width`), the scene is not
/// areal, its faces are smooth, or its forces are found with the end of a step.
int cluster_degree(const Model& model, int width);

/// By how many twos the order of an adaptive step's series may be raised, for longer steps: in
/// areal scenes between linear faces. The larger the block, the more of its nodes may touch within
/// a step: over a footprint of a high degree, and where there is none, to find these costs more
/// than longer steps save (bench_areal: 40 mm).
int higher_orders(const Scene& scene, const FootprintShape& footprint);

/// Rows of samples and shocks that a launch can hand out, and nodes that can carry force (areal
/// scenes: be evaluated) at once: the march stops where it needs more, and goes on once there is
/// more.
struct Capacity {
  int samples = 4096;                  // no more than the run has, or fill so many bytes:
  std::size_t sample_bytes = 1 << 20;  // what a processor's cache keeps
  int shocks = 8192;                   // beside what one step can end
  // where forces are found together, under the adaptive scheme, and in areal scenes
  int nodes = 64;
};
/// Of one of thousands on a GPU, where a launch makes a short way of each: what they hand out
/// stands in memory of the host that cannot be swapped.
inline constexpr Capacity capacity_on_a_gpu{
    .samples = 1024, .sample_bytes = 1 << 23, .shocks = 1024, .nodes = 64};

/// Lengths of all arrays of a scene whose modes fill `lanes` lanes.
Extents extents_of(const Model& model, const PatchSeries& series, int lanes, int width,
                   const Capacity& capacity);

}  // namespace ra2d
