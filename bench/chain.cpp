// SPDX-License-Identifier: BSD-3-Clause
#include "bench/chain.hpp"

#include <array>

#include "kernels/contact/penalty.hpp"
#include "kernels/fixed/advance.hpp"
#include "kernels/lanes.hpp"
#include "kernels/schemes/backward_euler.hpp"

namespace ra2d::bench {
namespace {

using Lanes = HostLanes;
using Real = Lanes::Real;
constexpr int packs = (21 + Lanes::width - 1) / Lanes::width;
constexpr double tau = 1e-5;  // s, and everything else of the order of one

struct Packs {
  Real u[packs], v[packs], c0[packs], c1[packs], c2[packs];

  Packs() {
    for (int p = 0; p < packs; ++p) {
      const ModeStep step = BackwardEuler::prepare({1000.0 * (p + 1), 1e-6, 1.0}, tau);
      u[p] = Real(1.0);
      v[p] = Real(0.0);
      c0[p] = Real(step.v_v);
      c1[p] = Real(step.v_u);
      c2[p] = Real(step.v_f[0]);
    }
  }
  double sum() const {
    Real total(0.0);
    for (int p = 0; p < packs; ++p) total = total + u[p];
    return Lanes::sum(total);
  }
};

}  // namespace

// U -> c1 U + dv -> V -> U: the packs wait for themselves alone.
int flight_chain_operations() { return 3; }

// U -> one product or fma a pack -> the sum over lanes, a shuffle and an addition for each halving
// ->
// + faces -> times stiffness -> sign -> broadcast -> into the modal force -> times c2 -> + c1 U ->
// V -> U. Whether the node touches is a branch, here as in the march, and a branch that is foreseen
// waits for nothing.
int contact_chain_operations() {
  int halvings = 0;
  for (int lanes = Lanes::width; lanes > 1; lanes /= 2) ++halvings;
  return packs + 2 * halvings + 9;
}

double flight_chain(std::int64_t steps) {
  Packs modes;
  Real u = modes.u[0], v = modes.v[0];
  const Real dv = Real(1e-3) * modes.c2[0];
  for (std::int64_t i = 0; i < steps; ++i)
    advance_semi_implicit(u, v, modes.c0[0], modes.c1[0], dv, Real(tau));
  return Lanes::sum(u);
}

double contact_chain(std::int64_t steps) {
  Packs modes;
  Real phi[packs];
  for (int p = 0; p < packs; ++p) phi[p] = Real(1.0 / (Lanes::width * packs));
  const Penalty penalty{1e6};
  const double faces = 2.0;  // stays in contact
  for (std::int64_t i = 0; i < steps; ++i) {
    Real product = phi[0] * modes.u[0];
    for (int p = 1; p < packs; ++p) product = multiply_add(phi[p], modes.u[p], product);
    const double overlap = faces + Lanes::sum(product);
    if (!(overlap >= 0.0)) continue;
    const double f = penalty.force(overlap);
    for (int p = 0; p < packs; ++p) {
      const Real force = multiply_add(-f, phi[p], Real(1e-3));
      advance_semi_implicit(modes.u[p], modes.v[p], modes.c0[p], modes.c1[p], modes.c2[p] * force,
                            Real(tau));
    }
  }
  return modes.sum();
}

}  // namespace ra2d::bench
