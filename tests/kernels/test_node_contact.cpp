// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/contact/node_contact.hpp"
#include "kernels/gap.hpp"
#include "kernels/lanes.hpp"
#include "tests/kernels_of.hpp"

namespace {

using namespace ra2d;

constexpr int width = HostLanes::width;
constexpr int K = (2 + width - 1) / width, stride = K * width;  // two modes, on lanes 0 and 1
using Real = HostLanes::Real;

const HostLanes lanes;

TEST(ExpandNode, CubicAboutTheWindowsMiddle) {
  // One resonator mode that is the cubic y^3 + 2 y^2 - 3 y + 5 of y = (x - centre of patch 1)/chi,
  // and one slider mode: every number is dyadic, so the expansion is exact.
  constexpr int patch_nodes = 14 - width, radius = 8;  // (patch_nodes + width)/2 + 1
  SceneTables t;
  t.motion.position = patch_nodes + 1.25;
  t.motion.windows = 2;
  t.motion.window_width = 0.5;
  t.patches.nodes = patch_nodes;
  t.patches.count = 2;
  t.patches.inverse_radius = 1.0 / radius;
  t.slider.first_lane = t.slider.modes = 1;
  t.slider.row = stride;
  t.faces.groups = K;
  t.faces.nodes = stride;
  std::vector<double> quartic(stride, 0.0), patch(2 * 4 * stride, 0.0), unit(stride, 0.0);
  std::vector<double> slider_shape(stride), height1(stride), height2(patch_nodes + 4);
  const double cubic[] = {5, -3, 2, 1}, factorial[] = {1, 1, 2, 6};
  for (int j = 0; j < 4; ++j)
    patch[(4 + j) * stride] = factorial[j] * cubic[j] * std::pow(radius, j);
  unit[1] = 1;
  for (int n = 0; n < stride; ++n) slider_shape[n] = 0.5 * n, height1[n] = -10 - n;
  for (std::size_t n = 0; n < height2.size(); ++n) height2[n] = static_cast<double>(n * n);
  t.patches.quartic = quartic.data(), t.patches.derivatives = patch.data(),
  t.slider.unit = unit.data();
  t.slider.shape = slider_shape.data(), t.faces.height1 = height1.data(),
  t.faces.height2 = height2.data();

  const Place place(t.motion, 0);
  ASSERT_EQ(place.part, 0);
  for (int node = 0; node < 2; ++node) {
    const int at = patch_nodes + 1 + node;
    ASSERT_EQ(at / patch_nodes, 1) << "the test means patch 1";
    std::array<double, 4 * stride> shape;
    double face[2];
    expand_node<HostLanes, K>(lanes, t.faces, t.slider, t.patches, place, node, shape.data(), face);
    const double y = at + 0.25 - 1.5 * patch_nodes;  // the middle of the first half chi
    EXPECT_EQ(shape[0], y * y * y + 2 * y * y - 3 * y + 5);
    EXPECT_EQ(shape[stride], 3 * y * y + 4 * y - 3);
    EXPECT_EQ(shape[2 * stride], 3 * y + 2);
    EXPECT_EQ(shape[3 * stride], 1);
    EXPECT_EQ(shape[1], 0.5 * node);  // the slider's: its nodes do not move on it
    for (int m = 1; m < 4; ++m) EXPECT_EQ(shape[m * stride + 1], 0);
    for (int lane = 2; lane < stride; ++lane)
      for (int m = 0; m < 4; ++m) EXPECT_EQ(shape[m * stride + lane], 0);
    EXPECT_EQ(face[0], -10 - node + at * at);
    EXPECT_EQ(face[1], 2 * at + 1);
  }
}

/// Four nodes that are expanded by hand. Mode 0, the resonator's, is 2 + 3 o + o^2 + 2 o^3 at every
/// node and mode 1, the slider's, is 1/2; their faces differ.
struct ByHand {
  static constexpr int count = 4;
  std::vector<double> shape = std::vector<double>(count * 4 * stride, 0.0);
  std::vector<double> face = std::vector<double>(2 * count, 0.0);
  std::vector<std::int64_t> window = std::vector<std::int64_t>(count, 0);
  std::array<int, count> touched{}, listed{0, 1, 2, 3};
  std::array<double, count> force{};
  SceneTables t;
  SceneState s;
  Real u[K], modal[K];

  ByHand() {
    const double cubic[] = {2, 3, 1, 2};
    for (int n = 0; n < count; ++n) {
      for (int m = 0; m < 4; ++m) shape[(n * 4 + m) * stride] = cubic[m];
      shape[n * 4 * stride + 1] = 0.5;
      face[2 * n + 1] = 4;  // rise
    }
    t.faces.nodes = count;
    t.contact.node_stiffness = 1024;
    t.motion.position = 0.5;  // theta 1/2
    s.caches.node_shape = shape.data(), s.caches.node_face = face.data(),
    s.marks.node_window = window.data();
    s.work.contact_list.nodes = touched.data(), s.work.contact_list.forces = force.data();
    std::vector<double> amplitude(stride, 0.0), outer(stride, 0.0);
    amplitude[0] = 0.25, amplitude[1] = 1;
    outer[0] = 7, outer[1] = 9;  // modal forces that are there already
    for (int p = 0; p < K; ++p) {
      u[p] = lanes.load(amplitude.data() + p * width);
      modal[p] = lanes.load(outer.data() + p * width);
    }
  }
  ContactTotals<Real> contact(int nodes) {
    Place place(t.motion, 0);
    place.offset = 0.5;  // phi = 2 + 3/2 + 1/4 + 1/4 = 4, its slope 3 + 1 + 3/2 = 11/2
    return test::node_contact_of<K>(t, s)(place, u, listed.data(), nodes, modal);
  }
  std::vector<double> modal_force() const {
    std::vector<double> out(stride);
    for (int p = 0; p < K; ++p) lanes.store(out.data() + p * width, modal[p]);
    return out;
  }
};

TEST(NodeContact, ForceOnBothBodiesAndWorkOfTheWay) {
  // heights of -3, and of 0 and 4 half way between; the modes add 4/4 and 1/2
  EXPECT_EQ(gap(3.0, 0.0, 0.5 * 1.0, {0.0, 4.0, 0.5}, 4.0 * 0.25), -0.5);  // 1024 N/m: 512 N
  ByHand nodes;
  nodes.face[0] = -3;
  const auto totals = nodes.contact(1);
  EXPECT_EQ(totals.nodes, 1);
  EXPECT_EQ(nodes.touched[0], 0);
  EXPECT_EQ(nodes.force[0], 512);
  EXPECT_EQ(totals.force, 512);
  EXPECT_EQ(totals.face_work, 512 * 4);                            // on the face
  EXPECT_EQ(lanes.sum(totals.deflection_work), 512 * 5.5 * 0.25);  // on the deflection
  EXPECT_EQ(nodes.modal_force()[0], 7 - 512 * 4);                  // -f phi
  EXPECT_EQ(nodes.modal_force()[1], 9 - 512 * 0.5);
}

TEST(NodeContact, OpenGapTouchesNothing) {
  ByHand nodes;
  nodes.face[0] = -4;
  const auto totals = nodes.contact(1);
  EXPECT_EQ(totals.nodes, 0);
  EXPECT_EQ(totals.force, 0);
  EXPECT_EQ(totals.face_work, 0);
  EXPECT_EQ(lanes.sum(totals.deflection_work), 0);
  EXPECT_EQ(nodes.modal_force()[0], 7);
  EXPECT_EQ(nodes.modal_force()[1], 9);
}

TEST(NodeContact, TouchingAtExactlyZeroIsListedWithoutForce) {
  ByHand nodes;
  nodes.face[0] = -3.5;
  nodes.force[0] = -1;
  const auto totals = nodes.contact(1);
  EXPECT_EQ(totals.nodes, 1);
  EXPECT_EQ(nodes.force[0], 0);
  EXPECT_EQ(nodes.modal_force()[0], 7);
}

TEST(NodeContact, SumsOverTheNodesThatTouchAndListsThemInOrder) {
  ByHand nodes;
  nodes.face[0] = -3.25;  // 1/4 over
  nodes.face[2] = std::numeric_limits<double>::quiet_NaN();
  nodes.face[4] = -100;
  nodes.face[6] = -2.5;  // 1 over
  const auto totals = nodes.contact(4);
  ASSERT_EQ(totals.nodes, 2);
  EXPECT_EQ(nodes.touched[0], 0);
  EXPECT_EQ(nodes.touched[1], 3);
  EXPECT_EQ(nodes.force[0], 256);
  EXPECT_EQ(nodes.force[1], 1024);
  EXPECT_EQ(totals.force, 1280);
  EXPECT_EQ(totals.face_work, 1280 * 4);
  EXPECT_EQ(lanes.sum(totals.deflection_work), 1280 * 5.5 * 0.25);
  EXPECT_EQ(nodes.modal_force()[0], 7 - 1280 * 4);
}

TEST(NodeContact, ExpandsOnceAWindow) {
  ByHand nodes;
  SceneTables& t = nodes.t;
  std::vector<double> quartic(stride, 0.0), patch(4 * stride, 0.0), heights(64);
  patch[0] = 5;  // the mode is 5 everywhere
  for (int n = 0; n < 64; ++n) heights[n] = n;
  t.patches.count = 1, t.patches.nodes = 64, t.patches.inverse_radius = 1.0 / 64;
  t.slider.first_lane = 1, t.faces.groups = ByHand::count;
  t.patches.quartic = quartic.data(), t.patches.derivatives = patch.data();
  t.faces.height1 = t.faces.height2 = heights.data();
  t.motion.advance = 1;
  nodes.window = {-1, -1, -1, -1};
  auto contact = test::node_contact_of<K>(t, nodes.s);
  const int listed[] = {1, 3};
  contact.expand(Place(t.motion, 0), listed, 2);
  EXPECT_EQ(nodes.window, (std::vector<std::int64_t>{-1, 0, -1, 0}));
  EXPECT_EQ(nodes.shape[1 * 4 * stride], 5);
  EXPECT_EQ(nodes.face[2 * 3], 3 + 3);
  EXPECT_EQ(nodes.shape[0], 2) << "not listed";
  nodes.shape[1 * 4 * stride] = -1;
  contact.expand(Place(t.motion, 0), listed, 2);
  EXPECT_EQ(nodes.shape[1 * 4 * stride], -1) << "expanded again without need";
  contact.expand(Place(t.motion, 1), listed, 2);
  EXPECT_EQ(nodes.window, (std::vector<std::int64_t>{-1, 1, -1, 1}));
  EXPECT_EQ(nodes.shape[1 * 4 * stride], 5);
  EXPECT_EQ(nodes.face[2 * 3], 3 + 4);
}

}  // namespace
