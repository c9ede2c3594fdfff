// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "host/model/contact_program.hpp"
#include "tests/effort.hpp"

/// The programme is convex: what meets its conditions (Karush, Kuhn, Tucker) is its minimum.
namespace ra2d::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double ulp = std::numeric_limits<double>::epsilon();

void expect_minimum(const ContactProgram& p, const RestingContact& rest) {
  ASSERT_TRUE(rest.feasible);
  ASSERT_TRUE(rest.u.allFinite());
  const VectorXd overlap = p.faces + p.shapes * rest.u;
  VectorXd moved = rest.u.cwiseAbs();  // and where the load would move it without contact
  for (Eigen::Index k = 0; k < moved.size(); ++k)
    if (p.stiffness[k] > 0) moved[k] += std::abs(p.load[k] / p.stiffness[k]);
  const double size = p.faces.cwiseAbs().maxCoeff() + (p.shapes.cwiseAbs() * moved).maxCoeff();
  const double most = std::max(rest.forces.maxCoeff(), 1e-300);
  for (Eigen::Index n = 0; n < overlap.size(); ++n) {
    const double spring = p.compliance * rest.forces[n];
    EXPECT_GE(rest.forces[n], 0);
    EXPECT_LE(overlap[n], spring + 1e-11 * size) << n;
    if (rest.forces[n] > 1e-9 * most) {
      EXPECT_NEAR(overlap[n], spring, 1e-11 * size) << n;
    }
  }
  const VectorXd pulled = p.stiffness.cwiseProduct(rest.u),
                 pushed = p.shapes.transpose() * rest.forces;
  const double scale = p.load.cwiseAbs().sum() + pulled.cwiseAbs().sum() +
                       (p.shapes.cwiseAbs().transpose() * rest.forces).sum();
  EXPECT_LE((p.load - pulled - pushed).cwiseAbs().maxCoeff(), 1e-10 * scale);
}

/// Modes of which the first `rigid` shift and tilt, over nodes from -1 to 1.
ContactProgram random_program(int nodes, int rigid, int elastic, double compliance, bool flat,
                              std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  ContactProgram p;
  const int modes = rigid + elastic;
  p.stiffness = VectorXd::Zero(modes);
  p.load = VectorXd::Zero(modes);
  p.shapes = MatrixXd(nodes, modes);
  p.faces = VectorXd(nodes);
  p.compliance = compliance;
  for (int k = rigid; k < modes; ++k) {
    p.stiffness[k] = std::pow(10.0, 4 * uniform(random));
    p.load[k] = 0.1 * normal(random);
  }
  for (int n = 0; n < nodes; ++n) {
    const double x = 2.0 * n / (nodes - 1) - 1;
    p.faces[n] = flat ? 0.0 : 1e-3 * normal(random);
    for (int k = 0; k < modes; ++k)
      p.shapes(n, k) = k < rigid ? (k == 0 ? 1.0 : x) : std::cos((k - rigid + 1) * (x + 1.3));
  }
  if (rigid > 0) {
    p.load[0] = 1;
    p.load[1] = 0.4 * (2 * uniform(random) - 1);  // within the nodes
  }
  return p;
}

TEST(ContactProgram, MeetsItsConditions) {
  std::mt19937_64 random(1);
  for (int i = 0; i < draws(400); ++i) {
    const int rigid = i % 2 == 0 ? 2 : 0, nodes = 2 + static_cast<int>(random() % 60);
    const int elastic = 1 + static_cast<int>(random() % 12);
    const double compliance =
        i % 3 == 0 ? 0.0 : std::pow(10.0, -3.0 - static_cast<double>(random() % 9));
    const bool flat = i % 5 == 0;
    SCOPED_TRACE(testing::Message()
                 << "case " << i << ": " << nodes << " nodes, " << rigid << " + " << elastic
                 << " modes, compliance " << compliance << (flat ? ", flat" : ""));
    const ContactProgram p = random_program(nodes, rigid, elastic, compliance, flat, random);
    const auto rest = solve(p);
    ASSERT_TRUE(rest.has_value());
    if (!rest->feasible) {
      EXPECT_EQ(compliance, 0);  // springs yield always
      EXPECT_EQ(rigid, 0);       // and so does a body that may rise
      continue;
    }
    expect_minimum(p, *rest);
  }
}

TEST(ContactProgram, MeetsItsConditionsWhereMoreNodesTouchThanPush) {
  // Made around its answer: every node touches, a few push, and neighbours have nearly the same
  // shape. Which of them push roundings may get wrong on the way, and must not in the end.
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < draws(400); ++i) {
    SCOPED_TRACE(i);
    const int nodes = 3 + static_cast<int>(random() % 12),
              modes = 2 + static_cast<int>(random() % 6);
    const double apart = std::pow(10.0, -2 + uniform(random));
    ContactProgram p{.stiffness = VectorXd(modes),
                     .load = VectorXd(modes),
                     .shapes = MatrixXd(nodes, modes),
                     .faces = VectorXd(nodes)};
    VectorXd u(modes);
    for (int k = 0; k < modes; ++k) {
      p.stiffness[k] = std::pow(10.0, 4 * uniform(random));
      u[k] = 1e-3 * normal(random);
      for (int n = 0; n < nodes; ++n) p.shapes(n, k) = std::cos((k + 1) * 3 * (0.3 + apart * n));
    }
    p.faces = -p.shapes * u;
    p.load = p.stiffness.cwiseProduct(u);
    for (int pushing = 0; pushing < 3; ++pushing)
      p.load += std::pow(10.0, -4 * uniform(random)) *
                p.shapes.row(static_cast<Eigen::Index>(random() % nodes)).transpose();
    const auto rest = solve(p);
    ASSERT_TRUE(rest.has_value());
    expect_minimum(p, *rest);
  }
}

TEST(ContactProgram, SaysWhereNothingKeepsTheFacesApart) {
  // one mode, pressed from both sides
  ContactProgram p{.stiffness = VectorXd::Constant(1, 1.0),
                   .load = VectorXd::Zero(1),
                   .shapes = MatrixXd(2, 1),
                   .faces = VectorXd::Constant(2, 1e-3)};
  p.shapes << 1.0, -1.0;
  const auto rest = solve(p);
  ASSERT_TRUE(rest.has_value());
  EXPECT_FALSE(rest->feasible);
  // springs share it: o = faces = compliance f at both
  p.compliance = 1e-6;
  const auto sprung = solve(p);
  ASSERT_TRUE(sprung.has_value());
  expect_minimum(p, *sprung);
  EXPECT_NEAR(sprung->forces[0], 1e3, 16 * ulp * 1e3);
  EXPECT_NEAR(sprung->forces[1], 1e3, 16 * ulp * 1e3);
}

TEST(ContactProgram, ALoadOnTwoSupportsIsALever) {
  // a rigid bar of length 2 on supports at -1 and 1/2, loaded in the middle: 1/3 and 2/3
  ContactProgram p{.stiffness = VectorXd::Zero(2),
                   .load = VectorXd::Zero(2),
                   .shapes = MatrixXd(4, 2),
                   .faces = VectorXd(4)};
  p.load << 9.0, 0.0;
  p.shapes << 1, -1, 1, -0.5, 1, 0.5, 1, 1;
  p.faces << 2e-3, 0, 1e-3, -1e-3;
  const auto rest = solve(p);
  ASSERT_TRUE(rest.has_value());
  expect_minimum(p, *rest);
  EXPECT_NEAR(rest->forces[0], 3, 1e-13);
  EXPECT_NEAR(rest->forces[2], 6, 1e-13);
  EXPECT_EQ(rest->forces[1], 0);
  EXPECT_EQ(rest->forces[3], 0);
}

}  // namespace
}  // namespace ra2d::test
