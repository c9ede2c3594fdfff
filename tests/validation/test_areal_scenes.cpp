// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/decompositions.hpp"
#include "host/body/body.hpp"
#include "host/device/batch.hpp"
#include "host/model/model.hpp"
#include "host/run/timed_run.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/child.hpp"
#include "tests/places.hpp"
#include "tests/simulate.hpp"

/// Areal scenes from their files: the static start of a free block, and limits that are known
/// exactly.
namespace ra2d::test {
namespace {

constexpr auto text = R"([scene]
kind = "areal"
duration = 4e-4
speed = 1.0
start = 0.0201
spacing = 1e-4
[resonator]
support = "pinned"
length = 0.06
thickness = 0.001
width = 0.04
young = 210e9
density = 7800
damping = 0.02
modes = 30
surface = { kind = "gaussian", rq = 2e-6, rsm = 8e-4, seed = 2 }
[slider]
support = "free"
length = 4e-3
thickness = 0.005
width = 3e-3
density = 7800
load = 3
surface = { kind = "gaussian", rq = 2e-6, rsm = 6e-4, seed = 1 }
[contact]
stiffness = 1e14
[time]
scheme = "midpoint"
step = 1e-7
nodes = "all"
[output]
rate = 1e5
)";

using Changes = std::vector<std::string>;

Scene scene_with(const Changes& changes) { return parse_scene(text, "areal.toml", changes); }

/// Place of a node on the block [m], from its middle.
struct FromMiddle {
  double x, y;
};
FromMiddle from_middle(const Model& m, int node) {
  return {(node % m.row_nodes()) * m.scene.spacing - m.scene.slider.length / 2,
          (node / m.row_nodes() + 0.5) * m.spacing_y - m.scene.slider.width / 2};
}

/// Forces of all nodes [N] at rest, by the overlaps of faces and modes.
std::vector<double> forces_of(const Model& m, const ModalStart& start) {
  std::vector<double> forces = overlaps(m, start.resonator_u, start.slider_u);
  for (double& f : forces) f = m.node_stiffness * std::max(0.0, f);
  return forces;
}

// ---- the three-point rest

/// a + b x + c y of a rigid block on a plate that does not yield, by Newton's method from stiffened
/// springs on: the equations are those of three unknowns, force and two moments.
Eigen::Vector3d rest_of_three(const Model& m, const std::vector<double>& faces) {
  std::vector<Eigen::Vector3d> shapes;
  for (int n = 0; n < m.nodes(); ++n) {
    const auto [x, y] = from_middle(m, n);
    shapes.emplace_back(1, x, y);
  }
  const auto force = [&](const Eigen::Vector3d& at, double spring, Eigen::Matrix3d& tangent) {
    Eigen::Vector3d out(m.slider.load_force, 0, 0);
    tangent.setZero();
    for (std::size_t n = 0; n < shapes.size(); ++n) {
      const double over = faces[n] + shapes[n].dot(at);
      if (over <= 0) continue;
      out -= spring * over * shapes[n];
      tangent += spring * shapes[n] * shapes[n].transpose();
    }
    return out;
  };
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  for (int stiffer = 20; stiffer >= 0; --stiffer) {
    const double spring = std::ldexp(m.node_stiffness, -stiffer);
    for (int round = 0; round < 60; ++round) {
      Eigen::Matrix3d tangent, there;
      const Eigen::Vector3d out = force(plane, spring, tangent);
      Eigen::Matrix3d regular = tangent;
      regular.diagonal() += 1e-12 * tangent.diagonal();
      regular += 1e-12 * spring * Eigen::Vector3d(1, 1e-6, 1e-6).asDiagonal().toDenseMatrix();
      const Eigen::Vector3d step = solve_symmetric(regular, Eigen::VectorXd(out));
      // the potential is convex: where its slope along the step ends
      double length = 1;
      if (force(plane + step, spring, there).dot(step) < -1e-12 * out.dot(step)) {
        double low = 0;
        for (int halving = 0; halving < 50; ++halving) {
          const double middle = 0.5 * (low + length);
          (force(plane + middle * step, spring, there).dot(step) > 0 ? low : length) = middle;
        }
      }
      plane += length * step;
      // the same nodes touch before and after: the system was linear
      force(plane, spring, there);
      if (length == 1 && there == tangent) break;
    }
  }
  return plane;
}

TEST(ArealStart, AFreeBlockStandsAsADirectSolveFinds) {
  for (const int seed : {1, 2, 3, 4})
    for (const char* stiffness : {"1e12", "1e14", "1e16"}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", kappa " << stiffness);
      const Model m = make_model(
          scene_with({"resonator.support=rigid", "slider.surface.seed=" + std::to_string(seed),
                      std::string("contact.stiffness=") + stiffness}));
      ASSERT_EQ(m.scene.initial, Initial::statics);
      const ModalStart start = make_start(m);
      const Eigen::Vector3d plane = rest_of_three(m, overlaps(m, {}, {}));
      // heave, pitch and roll are orthonormal over the area A
      const double l1 = m.scene.slider.length, l2 = m.scene.slider.width, area = l1 * l2;
      const Eigen::Vector3d expected(plane[0] * std::sqrt(area),
                                     plane[1] * std::sqrt(area * l1 * l1 / 12),
                                     plane[2] * std::sqrt(area * l2 * l2 / 12));
      // overlaps are differences of heights of micrometres
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(start.slider_u[static_cast<std::size_t>(k)], expected[k],
                    1e-13 * std::sqrt(area));
      EXPECT_GE(start.loaded_nodes.size(), 3);
    }
}

/// On a plate that yields: the forces balance load and moments, and bend the plate's modes.
TEST(ArealStart, BalancesLoadMomentsAndModes) {
  for (const char* load : {"0.2", "3", "\"weight\"", "\"50 weight\""}) {
    const Model m = make_model(scene_with({std::string("slider.load=") + load}));
    const ModalStart start = make_start(m);
    const std::vector<double> forces = forces_of(m, start);
    double sum = 0, moment_x = 0, moment_y = 0;
    std::vector<double> modal(m.resonator.modes.size(), 0.0);
    for (int n = 0; n < m.nodes(); ++n) {
      const auto [x, y] = from_middle(m, n);
      const double f = forces[static_cast<std::size_t>(n)];
      sum += f;
      moment_x += f * x;
      moment_y += f * y;
      const double at = (m.position + n % m.row_nodes()) * m.scene.spacing;
      for (std::size_t k = 0; k < modal.size() && f > 0; ++k)
        modal[k] -= f * shape_at(m.resonator.modes[k], at, m.side + m.eta(n / m.row_nodes()));
    }
    const double weight = m.slider.load_force;
    EXPECT_NEAR(sum, weight, 1e-8 * weight);
    EXPECT_NEAR(moment_x, 0, 1e-8 * weight * m.scene.slider.length);
    EXPECT_NEAR(moment_y, 0, 1e-8 * weight * m.scene.slider.width);
    EXPECT_NEAR(start.contact_force, sum, 1e-12 * weight);
    for (std::size_t k = 0; k < modal.size(); ++k) {
      const BodyMode& mode = m.resonator.modes[k];
      const double most = weight * mode.shape->largest();
      EXPECT_NEAR(mode.mass * mode.omega * mode.omega * start.resonator_u[k], modal[k],
                  1e-8 * most);
    }
  }
}

/// Three nodes of the block stand out, and no other touches: statics of three points.
TEST(ArealStart, ThreeBumpsShareTheLoadAsStaticsSays) {
  const Scene s = scene_with({"resonator.support=rigid", "slider.surface={kind=\"flat\"}",
                              "resonator.surface={kind=\"flat\"}", "scene.gap=3e-5"});
  HeightMaps maps{30, 1e-4, *s.side, std::vector<double>(30 * 300, 0.0),
                  std::vector<double>(30 * 41, 0.0)};
  struct Bump {
    int i, j;
    double height;
  };
  const std::vector<Bump> bumps{{3, 4, 2e-5}, {36, 8, 2.1e-5}, {17, 26, 1.9e-5}};
  for (const Bump& b : bumps) maps.slider[static_cast<std::size_t>(41 * b.j + b.i)] = b.height;
  const Model m = make_model(s, maps);
  const ModalStart start = make_start(m);
  Eigen::Matrix3d shapes;  // of heave, pitch and roll at the bumps
  for (int b = 0; b < 3; ++b)
    for (int k = 0; k < 3; ++k)
      shapes(b, k) = shape_at(m.slider.modes[static_cast<std::size_t>(k)], bumps[b].i * 1e-4,
                              (bumps[b].j + 0.5) * 1e-4);
  const Eigen::Vector3d load(m.slider.load[0], 0, 0);
  const Eigen::Vector3d forces = LeastSquares(shapes.transpose()).solve(Eigen::VectorXd(load));
  ASSERT_GT(forces.minCoeff(), 0.1);
  Eigen::Vector3d rise;  // of the block at the bumps
  for (int b = 0; b < 3; ++b) rise[b] = forces[b] / m.node_stiffness + 3e-5 - bumps[b].height;
  const Eigen::Vector3d expected = LeastSquares(shapes).solve(Eigen::VectorXd(rise));
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(start.slider_u[static_cast<std::size_t>(k)], expected[k],
                1e-11 * expected.cwiseAbs().maxCoeff());
  ASSERT_EQ(start.loaded_nodes.size(), 3);
  for (const Bump& b : bumps)
    EXPECT_TRUE(std::count(start.loaded_nodes.begin(), start.loaded_nodes.end(), 41 * b.j + b.i));
  EXPECT_NEAR(start.contact_force, 3, 1e-10);
}

TEST(ArealStart, TouchingIsTheSmallestDistanceWithoutOverlap) {
  const Model m = make_model(scene_with({"scene.initial=rest"}));
  const std::vector<double> faces = overlaps(m, {}, {});
  EXPECT_LE(std::abs(*std::max_element(faces.begin(), faces.end())), 0x1p-50 * m.delta);
  EXPECT_GT(m.delta, 0);
}

TEST(ArealStart, AHeldSliderPressesThePlate) {
  const Model m =
      make_model(scene_with({"slider.support=rigid", "slider.load=0", "scene.gap=3e-6"}));
  const ModalStart start = make_start(m);
  ASSERT_GT(start.contact_force, 1);
  const std::vector<double> forces = forces_of(m, start);
  double work = 0;  // of the forces on the first mode
  for (int n = 0; n < m.nodes(); ++n)
    work -= forces[static_cast<std::size_t>(n)] *
            shape_at(m.resonator.modes[0], (m.position + n % m.row_nodes()) * m.scene.spacing,
                     m.side + m.eta(n / m.row_nodes()));
  const BodyMode& mode = m.resonator.modes[0];
  EXPECT_NEAR(mode.mass * mode.omega * mode.omega * start.resonator_u[0], work,
              1e-9 * std::abs(work));
}

// ---- exact limits

double largest_of(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

/// Equal rows on a plate that does not yield: the block moves as the beam of the plane scene, and
/// does not roll.
TEST(ArealScenes, EqualRowsGiveThePlaneScene) {
  const std::string face =
      ".surface={kind=\"gaussian\",rq=2e-6,rsm=8e-4,rsm_y=\"inf\",exact=\"rq\",seed=";
  const Changes common{"resonator.support=rigid", "slider.width=0.04", "scene.duration=2e-3",
                       "contact.stiffness=1e13"};
  Changes rows = common;
  rows.insert(rows.end(),
              {"resonator" + face + "2}", "slider" + face + "1}", "scene.spacing_y=8e-3"});
  const Recording areal = simulate(scene_with(rows));
  std::string plane_text = text;
  const std::string kind = "kind = \"areal\"\n";
  plane_text.erase(plane_text.find(kind), kind.size());
  Changes beams = common;
  beams.insert(beams.end(), {"scene.faces=linear",
                             "resonator.surface={kind=\"gaussian\",rq=2e-6,rsm=8e-4,seed=2}",
                             "slider.surface={kind=\"gaussian\",rq=2e-6,rsm=8e-4,seed=1}",
                             "slider.young=210e9", "slider.damping=0", "slider.modes=0"});
  const Recording plane = simulate(parse_scene(plane_text, "plane.toml", beams));
  ASSERT_EQ(areal.end.status, Status::done);
  ASSERT_EQ(areal.model.rows, 5);
  EXPECT_EQ(areal.model.delta, plane.model.delta);
  ASSERT_GE(plane.shocks.size(), 3);
  EXPECT_EQ(areal.shocks.size(), plane.shocks.size());
  const std::size_t samples = plane.samples.time.size();
  ASSERT_EQ(areal.samples.time.size(), samples);
  const double most = largest_of(plane.samples.slider_displacement),
               force = largest_of(plane.samples.force), width = std::sqrt(0.04);
  for (std::size_t i = 0; i < samples; ++i) {
    const double* const block = &areal.samples.slider_displacement[3 * i];
    const double* const beam = &plane.samples.slider_displacement[2 * i];
    // modes of an area are 1/sqrt(b) times those of a line; roundings, which shocks amplify
    EXPECT_NEAR(block[0], beam[0] * width, 1e-9 * most * width);
    EXPECT_NEAR(block[1], beam[1] * width, 1e-9 * most * width);
    EXPECT_NEAR(block[2], 0, 1e-4 * most * width);  // sums of other roundings, which grow
    EXPECT_NEAR(areal.samples.force[i], plane.samples.force[i], 1e-6 * force);
    EXPECT_EQ(areal.samples.nodes[i], 5 * plane.samples.nodes[i]);
  }
}

/// Measured maps with their rows turned round, at the other side of the plate.
TEST(ArealScenes, MirrorImagesMoveAsMirrorImages) {
  const Folder folder;
  const auto write = [&](const std::string& name, const std::vector<double>& heights, int rows,
                         bool turned) {
    const int nx = static_cast<int>(heights.size()) / rows;
    std::ofstream out(folder.path() / name);
    out.precision(17);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < nx; ++i)
        out << heights[static_cast<std::size_t>((turned ? rows - 1 - j : j) * nx + i)]
            << (i + 1 < nx ? ' ' : '\n');
  };
  const Model random = make_model(scene_with({}));
  std::vector<Recording> runs;
  for (const bool turned : {false, true}) {
    write("plate.txt", random.resonator_height, random.rows, turned);
    write("block.txt", random.slider_height, random.rows, turned);
    const auto face = [](const std::string& body, const std::string& name) {
      return body + ".surface={kind=\"file\",path=\"" + name + "\",spacing=1e-4}";
    };
    // 11.1 mm from one edge or from the other
    runs.push_back(
        simulate(parse_scene(text, folder.path() / "s.toml",
                             {face("resonator", "plate.txt"), face("slider", "block.txt"),
                              turned ? "scene.side=0.0259" : "scene.side=0.0111"})));
    ASSERT_EQ(runs.back().end.status, Status::done);
  }
  const Recording &a = runs[0], &b = runs[1];
  const auto shocks = [](const Recording& r) { return r.shocks.size() + r.end.open_shocks.size(); };
  EXPECT_GE(shocks(a), 3);
  EXPECT_EQ(shocks(a), shocks(b));
  const std::size_t modes = a.model.resonator.modes.size();
  const double most = largest_of(a.samples.resonator_displacement),
               force = largest_of(a.samples.force);
  int odd = 0;
  for (std::size_t k = 0; k < modes; ++k) {
    // sin(n pi (b - y)/b) = -(-1)^n sin(n pi y/b)
    double across = 0;
    a.model.resonator.modes[k].shape->evaluate_across(0.04 / 3, 1, &across);
    double turned = 0;
    a.model.resonator.modes[k].shape->evaluate_across(0.04 - 0.04 / 3, 1, &turned);
    // between two half waves of an n that 3 divides both are 0: such n are odd and even alike
    if (std::abs(across) < 0.1) continue;
    const double sign = across * turned > 0 ? 1 : -1;
    odd += sign < 0;
    for (std::size_t i = 0; i < a.samples.time.size(); ++i)
      EXPECT_NEAR(a.samples.resonator_displacement[i * modes + k],
                  sign * b.samples.resonator_displacement[i * modes + k], 1e-8 * most);
  }
  EXPECT_GE(odd, 5);
  for (std::size_t i = 0; i < a.samples.time.size(); ++i) {
    EXPECT_NEAR(a.samples.force[i], b.samples.force[i], 1e-6 * force);
    const double* const u = &a.samples.slider_displacement[3 * i];
    const double* const v = &b.samples.slider_displacement[3 * i];
    const double block = largest_of(a.samples.slider_displacement);
    EXPECT_NEAR(u[0], v[0], 1e-8 * block);
    EXPECT_NEAR(u[1], v[1], 1e-8 * block);
    EXPECT_NEAR(u[2], -v[2], 1e-8 * block);
  }
}

/// The load's impulse is that of the contact and of the block's momentum.
TEST(ArealScenes, ImpulsesBalanceTheLoad) {
  const Recording r = simulate(scene_with({"scene.duration=2e-3", "output.rate=1e7"}));
  ASSERT_EQ(r.end.status, Status::done);
  const Model& m = r.model;
  double impulse = 0;  // of the contact, force at the beginning of each step
  for (std::size_t i = 0; i + 1 < r.samples.force.size(); ++i) impulse += 1e-7 * r.samples.force[i];
  const double area = m.scene.slider.length * m.scene.slider.width;
  const double momentum =
      -7800 * 0.005 * area * r.samples.slider_velocity.end()[-3] / std::sqrt(area);
  const double load = 3 * 2e-3;
  // the rule of the midpoint takes the force between two samples: one step of its change
  EXPECT_NEAR(impulse, load + momentum, 1e-7 * 2 * largest_of(r.samples.force) + 1e-6 * load);
}

/// Bounds on what the modes can do within a step leave few nodes of a large block to be looked at,
/// of many modes and of few: 28 and 340 a step, of 160 000. With bounds by the modes' sizes alone,
/// as faults on purpose have them, they are 160 and 10 000. Between smooth faces they are 110 of
/// 80 000, without polynomials for the modes 470.
TEST(ArealScenes, OfALargeBlockFewNodesAreEvaluated) {
  struct Case {
    std::string side, across, faces, highest, duration;  // m, m, Hz, s
    int most;                                            // nodes a step
  };
  for (const auto& [side, across, faces, highest, duration, most] :
       {Case{"0.04", "1e-4", "linear", "20e3", "0.005", 60},
        Case{"0.04", "1e-4", "linear", "2e3", "0.01", 700},
        Case{"0.02", "5e-5", "smooth", "20e3", "0.005", 200}}) {
    const Model m = make_model(read_scene(
        scene_file("areal"), {"slider.length=" + side, "slider.width=" + side, "scene.spacing=1e-4",
                              "scene.spacing_y=" + across, "scene.faces=" + faces,
                              "resonator.max_frequency=" + highest, "scene.duration=" + duration}));
    const TimedRun r = timed_run(m, make_start(m));
    EXPECT_EQ(r.status, Status::done);
    EXPECT_GT(r.end.shocks_begun, 10);
    EXPECT_LT(r.end.evaluated, most * r.end.steps_made) << faces << ", " << highest;
  }
}

/// A block that a lightly damped plate throws up flies for long. The cubics of such a flight rule
/// out contact at less than half of these 94 700 nodes, more than can be listed, before it is cut
/// to the series' length.
TEST(ArealScenes, ALongFlightOfALargeBlockNeedsNoRoomForMostNodes) {
  const Model m =
      make_model(read_scene(scene_file("areal"), {"slider.length=0.04", "slider.width=0.04",
                                                  "scene.spacing=130e-6", "resonator.damping=2e-4",
                                                  "slider.surface.seed=7", "scene.duration=0.02"}));
  const TimedRun r = timed_run(m, make_start(m));
  EXPECT_EQ(r.status, Status::done) << "at step " << r.end.step;
  EXPECT_GT(r.end.shocks_begun, 10);
}

/// At 50 um most steps go as far as the series lets them, and its order is raised; at 8 um most end
/// as a node touches or leaves, and an order that is too high for them is lowered again. Of a large
/// block longer steps would have too many nodes to look at.
TEST(ArealScenes, TheOrderIsRaisedWhereStepsMakeTheirWholeLength) {
  const auto raised_from = [](int raised, const std::string& side, const std::string& spacing,
                              const std::string& duration) {
    const Model m = make_model(read_scene(
        scene_file("areal"), {"slider.length=" + side, "slider.width=" + side,
                              "scene.spacing=" + spacing, "scene.duration=" + duration}));
    Batch batch({m}, {make_start(m)});
    SavedState begin = batch.save(0);
    begin.values.control.raised = raised;
    batch.restore(0, begin);
    while (batch.snapshot(0).status == Status::running) {
      batch.march(m.steps);
      batch.drain(0);
    }
    EXPECT_EQ(batch.snapshot(0).status, Status::done);
    return batch.save(0).values.control.raised;
  };
  EXPECT_GE(raised_from(0, "0.005", "50e-6", "0.03"), 2);
  EXPECT_LE(raised_from(3, "0.005", "8e-6", "0.01"), 1);
  EXPECT_EQ(raised_from(0, "0.04", "1e-4", "0.005"), 0);
}

}  // namespace
}  // namespace ra2d::test
