// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/adaptive/moving_force_series.hpp"
#include "tests/dice.hpp"
#include "tests/filled.hpp"
#include "tests/numbers.hpp"
#include "tests/scenes.hpp"

namespace {

using namespace ra2d;
using test::Dice, test::Filled, test::lanes, test::packs, test::width;

using test::eps;

TEST(MovingForceSeries, IsTheForceOnEachModeAsLongAsItSaysItIs) {
  // F psi(x), x where the force is at that time: through patches and series, until it leaves the
  // patch.
  Dice dice(1);
  for (const double speed : {30.0, -30.0}) {
    Scene s = test::strip_scene(16, 0, 0.14, 0.02);
    s.spacing = 1e-4;
    s.gap = 1e-3;
    s.contact.stiffness = 1e13;
    s.duration = 1e-3;
    s.output.rate = 1e5;
    s.time.scheme = SchemeKind::adaptive;
    s.resonator.moving_forces = {{.force = 7, .speed = speed, .start = 0}};
    const Filled f(s);
    std::vector<double> series((most_order + 1) * packs * width);
    for (int trial = 0; trial < 300; ++trial) {
      MovingForceTable force = f.t.forces.list[0];
      force.position = dice.uniform(0, s.resonator.length);
      SceneTables t = f.t;
      t.forces.list = &force;
      const double scale = 0.5 * t.patches.nodes * s.spacing / std::abs(speed);
      const std::int64_t valid =
          MovingForceSeries<HostLanes, packs>(lanes, t.motion, t.patches, t.forces, t.adaptive,
                                              series.data())
              .expand(0, scale);
      ASSERT_GT(valid, 0);
      for (const double share : {0.0, 0.3, 1.0}) {
        const double ticks = std::floor(share * static_cast<double>(valid - 1));
        const double x = force.position + ticks * force.advance,
                     at = ticks * t.motion.time_step / scale;
        for (int k = 0; k < f.modes(); ++k) {
          double exact, sum = 0;
          f.mode(k).shape->evaluate(x, 1, &exact);
          for (int j = t.adaptive.order; j >= 0; --j)
            sum = sum * at + series[j * packs * width + k];
          // as a node's shape: the roundings of the series, of the place, and of beta x there
          const double roundings =
              8 * t.patches.terms + 40 + 2 * f.mode(k).shape->wave_number() * x;
          ASSERT_NEAR(sum, force.force * exact, roundings * eps * force.force * f.size(k))
              << "mode " << k << ", from " << force.position << ", " << share << " of the way";
        }
      }
    }
  }
}

}  // namespace
