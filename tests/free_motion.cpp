// SPDX-License-Identifier: BSD-3-Clause
#include "tests/free_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ra2d::test {

State fly(const Mode& mode, long double load, State y, long double t, bool sum) {
  const long double w = mode.omega, z = mode.zeta, a = load / mode.mass;
  if (w == 0)
    return {y.u + y.v * t + a * t * t / 2, y.v + a * t,
            y.square + y.v * y.v * t + y.v * a * t * t + a * a * t * t * t / 3};
  const long double rest = a / (w * w), d = y.u - rest;
  // V = v S' - omega^2 d S and U - rest = d (S' + 2 zeta omega S) + v S, where S is what a unit of
  // velocity becomes
  const auto answers = [&](long double x) {  // (S, S') at omega t = x, S in units of 1/omega
    if (z == 1) return std::array{x * std::exp(-x), (1 - x) * std::exp(-x)};
    if (z < 1) {
      const long double q = std::sqrt(1 - z * z), e = std::exp(-z * x);
      const long double s = e * std::sin(q * x) / q;
      return std::array{s, e * std::cos(q * x) - z * s};
    }
    const long double q = std::sqrt(z * z - 1), slow = 1 / (z + q), fast = z + q;
    return std::array{(std::exp(-slow * x) - std::exp(-fast * x)) / (2 * q),
                      (fast * std::exp(-fast * x) - slow * std::exp(-slow * x)) / (2 * q)};
  };
  const auto v_at = [&](long double time) {
    const auto [s, ds] = answers(w * time);
    return y.v * ds - w * d * s;
  };
  const auto [s, ds] = answers(w * t);
  State out{rest + d * (ds + 2 * z * s) + y.v * s / w, v_at(t), 0};
  if (!sum) return out;
  // the integral by ten-point Gauss rules over pieces of omega t = 1/4: off by less than 1e-30
  const long double place[] = {0.1488743389816312108848260L, 0.4333953941292471907992659L,
                               0.6794095682990244062343274L, 0.8650633666889845107320967L,
                               0.9739065285171717200779640L},
                    weight[] = {0.2955242247147528701738930L, 0.2692667193099963550912269L,
                                0.2190863625159820439955349L, 0.1494513491505805931457763L,
                                0.0666713443086881375935688L};
  const int pieces = 1 + static_cast<int>(4 * w * std::max(1.0L, 2 * z) * t);
  const long double half = t / pieces / 2;
  for (int i = 0; i < pieces; ++i)
    for (int g = 0; g < 5; ++g)
      for (const int side : {-1, 1}) {
        const long double v = v_at((2 * i + 1 + side * place[g]) * half);
        out.square += weight[g] * half * v * v;
      }
  out.square += y.square;
  return out;
}

}  // namespace ra2d::test
