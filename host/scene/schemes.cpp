// SPDX-License-Identifier: BSD-3-Clause
#include "host/scene/schemes.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "kernels/schemes/backward_euler.hpp"
#include "kernels/schemes/exact.hpp"
#include "kernels/schemes/explicit_euler.hpp"
#include "kernels/schemes/gautschi.hpp"
#include "kernels/schemes/heun.hpp"
#include "kernels/schemes/midpoint.hpp"
#include "kernels/schemes/rk4.hpp"
#include "kernels/schemes/rk8.hpp"

namespace ra2d {
namespace {

/// R(z) = 1 + sum_j z^j b . A^(j-1) 1.
template <class Scheme>
std::vector<double> polynomial_of() {
  if constexpr (!requires { Scheme::a(0, 0); }) {
    return {};
  } else {
    std::vector<double> power(Scheme::stages, 1.0), coefficients{1.0};  // power = A^(j-1) 1
    for (int j = 1; j <= Scheme::stages; ++j) {
      double sum = 0;
      for (int i = 0; i < Scheme::stages; ++i) sum += Scheme::b(i) * power[i];
      coefficients.push_back(sum);
      for (int i = Scheme::stages - 1; i >= 0; --i) {  // explicit: row i needs the rows above
        double next = 0;
        for (int l = 0; l < i; ++l) next += Scheme::a(i, l) * power[l];
        power[i] = next;
      }
    }
    return coefficients;
  }
}

template <class Scheme>
const SchemeTable& table_of() {
  static const SchemeTable table{Scheme::order,        Scheme::stages,  Scheme::place,
                                 Scheme::velocity_lag, Scheme::prepare, polynomial_of<Scheme>()};
  return table;
}

}  // namespace

bool is_adaptive(const TimeSettings& time) { return time.scheme == SchemeKind::adaptive; }
bool is_adaptive(const Scene& scene) { return is_adaptive(scene.time); }

const SchemeTable& scheme_table(SchemeKind scheme) {
  switch (scheme) {
    case SchemeKind::explicit_euler:
      return table_of<ExplicitEuler>();
    case SchemeKind::midpoint:
      return table_of<Midpoint>();
    case SchemeKind::heun:
      return table_of<Heun>();
    case SchemeKind::rk4:
      return table_of<Rk4>();
    case SchemeKind::rk8:
      return table_of<Rk8>();
    case SchemeKind::exact:
      return table_of<Exact>();
    case SchemeKind::gautschi:
      return table_of<Gautschi>();
    case SchemeKind::backward_euler:
      return table_of<BackwardEuler>();
    case SchemeKind::adaptive:
      break;
  }
  throw std::logic_error("adaptive has no table of weights");
}

double mean_square(const TimeSettings& time, const Mode& mode, double tau) {
  return is_semi_implicit(time.scheme) ? scheme_table(time.scheme).prepare(mode, tau).mean_square
                                       : 1.0;
}

bool is_semi_implicit(SchemeKind scheme) {
  return scheme == SchemeKind::backward_euler || scheme == SchemeKind::midpoint ||
         scheme == SchemeKind::gautschi;
}

bool takes_multipliers(SchemeKind scheme) {
  return scheme != SchemeKind::explicit_euler && scheme != SchemeKind::adaptive;
}

bool holds_forces(const Scene& scene) {
  return scene.contact.law == ContactLaw::multiplier ||
         (scene.time.scheme == SchemeKind::backward_euler &&
          scene.time.contact_force == ForceTime::new_time);
}

}  // namespace ra2d
