// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bench/peers/peers.hpp"
#include "host/run/timed_run.hpp"
#include "host/scene_file/scene_file.hpp"
#include "tests/places.hpp"
#include "tests/scenes.hpp"

/// The adaptive scheme against CVODE, which shares no code with it, over many shocks.
namespace {

using namespace ra2d;

struct Both {
  Model model;
  TimedRun own;
  peers::PeerResult peer;
  double apart;  // of the states at the end, relative, in the norm of the energy
};

Both run_both(Scene scene, double until) {
  scene.time.scheme = SchemeKind::adaptive;
  scene.time.tolerance = 1e-12;
  scene.duration = until;
  scene.output.rate = 1.0 / until;  // a sample at the end
  Both both{make_model(scene), {}, {}, 0};
  const ModalStart start = make_start(both.model);
  both.own = timed_run(both.model, start);
  EXPECT_EQ(both.own.status, Status::done);
  both.peer = peers::march_peer(both.model, start,
                                {.integrator = peers::Integrator::cvode_adams,
                                 .nodes = Nodes::candidates,
                                 .tolerance = 1e-13,
                                 .until = until});
  const peers::PeerResult& p = both.peer;
  both.apart = state_error(both.model, {p.resonator_u, p.resonator_v, p.slider_u, p.slider_v},
                           both.own.state);
  return both;
}

/// The slider's peak passes `count` peaks of the resonator, one every 2.5 mm.
Scene row_of_peaks(int count, double gap, double damping) {
  Scene scene = read_scene(test::scene_file("peaks"));
  std::vector<Peak> peaks;
  for (int i = 0; i < count; ++i) peaks.push_back({0.112 + 2.5e-3 * i, 10e-6, 2e-4});
  scene.resonator.surface = test::peaks(peaks);
  scene.gap = gap;
  scene.resonator.damping = damping;
  return scene;
}

/// A passage amplifies what is off at its beginning. By how much is measured: by a scene whose gap
/// differs by one part in 1e9. CVODE's own error at this tolerance, by its convergence, is about
/// 1e-12 of the motion a smooth piece; a hundred of them, amplified, are allowed.
void expect_agreement(const Scene& scene, double until, std::size_t least_shocks) {
  const Both both = run_both(scene, until);
  Scene moved = scene;
  moved.gap = *scene.gap * (1 + 1e-9);
  const double amplified =
      state_error(both.model, run_both(moved, until).own.state, both.own.state);
  const double bound = 1e-10 * std::max(1.0, amplified / 1e-9);
  EXPECT_LT(both.apart, bound) << "amplified " << amplified / 1e-9 << " times";
  EXPECT_LT(amplified, 1e-4) << "chaotic: agreement says nothing";

  ASSERT_GE(both.own.shocks.size(), least_shocks);
  // CVODE's ends by the nodes, ours by the pieces of contact: where one node touches they are one
  ASSERT_EQ(both.peer.shocks.size(), both.own.shocks.size());
  std::vector<Shock> theirs = both.peer.shocks;
  std::sort(theirs.begin(), theirs.end(),
            [](const Shock& a, const Shock& b) { return a.start < b.start; });
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    const Shock& own = both.own.shocks[i];
    // a time is off by the motion's error over its speed, here of periods of 1e-4 s
    EXPECT_NEAR(theirs[i].start, own.start, 1e-4 * bound) << "shock " << i;
    EXPECT_NEAR(theirs[i].duration, own.duration, 2e-4 * bound) << "shock " << i;
  }
}

TEST(AdaptiveAndCvode, AgreeOverARowOfPeaks) {
  expect_agreement(row_of_peaks(34, 19.4e-6, 0.05), 0.18, 20);
}

TEST(AdaptiveAndCvode, AgreeWhereShocksFollowOneAnotherAtOnce) {
  expect_agreement(row_of_peaks(12, 19.2e-6, 0.02), 0.065, 20);
}

}  // namespace
