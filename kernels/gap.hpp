// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ra2d {

/// A rough face between two neighbouring nodes: a straight line, here at `theta` of the way from
/// the left one to the right one. Heights in m.
template <class Real>
struct FaceBetweenNodes {
  Real left, right, theta;
};

/// Contact detection: the gap at a slider's node (paper, equation 10; docs/model.md),
///
///   g_n = delta - h_1(s_n) - u_1(t, s_n) - h_2(x_n) - u_2(t, x_n),   contact: g_n <= 0,
///
/// n the node, s_n its place on the slider, x_n = s_n + x0 + V t that on the resonator, between two
/// nodes (the paper prints -g_n, and h_2(x - V t), which slides the other way). delta: the distance
/// of the mean lines; h: the faces' heights, u: the bodies' displacements, all towards the other
/// body.
///
/// This is the plain form: a scene starts from it, and tests hold the kernels to it. These work
/// with the overlap -g_n, in parts that are found once and used often: GroupSweep::overlap
/// (kernels/group_sweep.hpp) at groups of nodes, NodeContact::overlap
/// (kernels/contact/node_contact.hpp) at single ones. host/device/fill.cpp takes delta off h_1
/// for them. The order of the sum stays as it is: the bits of a "touching" gap follow from it.
template <class Real>
constexpr Real gap(Real delta, Real h1, Real u1, const FaceBetweenNodes<Real>& h2, Real u2) {
  const Real faces = h1 - delta + h2.left + h2.theta * (h2.right - h2.left);
  return -(faces + u2 + u1);
}

}  // namespace ra2d
