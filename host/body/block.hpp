// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/body/body.hpp"

namespace ra2d {

/// The slider of an areal scene: a block of length l1 along x and width l2 along y.
///
/// A free one has three rigid modes, orthonormal over its area A: heave 1/sqrt(A), pitch
/// sqrt(12/(A l1^2)) (x - l1/2), roll sqrt(12/(A l2^2)) (y - l2/2), modal mass density thickness
/// [kg/m^2]. The inertia of its thickness is left out. Its load drives heave alone. A rigid one has
/// no modes. Throws RequestError where it is pinned, or where elastic modes are asked for by
/// number: those of a block lie far above the audible band.
Body make_block(const BodySpec& spec);

}  // namespace ra2d
