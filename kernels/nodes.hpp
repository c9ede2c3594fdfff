// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// Where contact is searched for: at every node, or where the proof says that it could be
/// (kernels/candidates.hpp). A scene's `time.nodes`.
enum class Nodes : int { all, candidates };

}  // namespace ra2d
