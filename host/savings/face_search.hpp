// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/savings/savings_search.hpp"

/// The cheapest faces and spacing that keep the answer.
namespace ra2d {

/// The scene with the faces that all others are compared with: smooth ones, if it is plane, one of
/// its faces is rough, and splines follow them on this spacing. Otherwise its own.
Scene with_faces_of_reference(const Scene& written);

/// Whether the faces as written hold, where the reference has others. Until `end`, a share of the
/// budget.
void check_faces(SavingsSearch& search, double end);

/// Tries other faces and spacings until `end`, a share of the budget. Where the reference's faces
/// are not smooth, or are maps, only wider spacings are tried.
void find_faces(SavingsSearch& search, double end);

/// The trial of the faces as written; null where they are the reference's.
const Trial* faces_as_written(const Savings& savings);

}  // namespace ra2d
