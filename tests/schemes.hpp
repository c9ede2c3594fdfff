// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "host/chart/methods.hpp"
#include "host/model/model.hpp"
#include "host/scene/schemes.hpp"
#include "kernels/schemes/mode_step.hpp"
#include "tests/scenes.hpp"

/// The time schemes in tests, and scenes on which they are alone.
namespace ra2d::test {

/// A method by the name that tests give it.
struct Scheme : Method {
  std::string name;

  const SchemeTable& table() const { return scheme_table(time.scheme); }
  bool implicit() const { return time.contact_force == ForceTime::new_time; }
};
inline const std::vector<Scheme> schemes = {{{{SchemeKind::explicit_euler}}, "ExplicitEuler"},
                                            {{{SchemeKind::midpoint}}, "Midpoint"},
                                            {{{SchemeKind::backward_euler}}, "BackwardEuler"},
                                            {{{SchemeKind::heun}}, "Heun"},
                                            {{{SchemeKind::rk4}}, "Rk4"},
                                            {{{SchemeKind::rk8}}, "Rk8"},
                                            {{{SchemeKind::exact}}, "Exact"},
                                            {{{SchemeKind::gautschi}}, "Gautschi"}};
/// That of this kind.
inline const Scheme& scheme_of(SchemeKind kind) {
  return *std::find_if(schemes.begin(), schemes.end(),
                       [&](const Scheme& s) { return s.time.scheme == kind; });
}
/// All schemes, and backward Euler with the contact force of the new time.
std::vector<Scheme> schemes_and_implicit();

/// omega tau from 1e-4 to 1e2, damping from none to beyond critical.
struct RandomModes {
  std::mt19937_64 random{7};
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  double tau() { return std::pow(10.0, uniform(-7, -4)); }
  Mode mode(double tau, double most = 1e2) {
    const double zeta = uniform(0, 1) < 0.3 ? 0.0 : std::pow(10.0, uniform(-3, 0.3));
    return {std::pow(10.0, uniform(-4, std::log10(most))) / tau, zeta, uniform(0.1, 10)};
  }
};

// ---- scenes

/// A pinned strip whose slider is a metre away.
Scene lone_beam(int modes, double damping);

/// So many steps of a length, with a sample at the beginning, at the end, and `samples` - 1
/// between.
void set_steps(Scene& s, double step, std::int64_t steps, std::int64_t samples = 1);

/// Kinetic and elastic energy of a body's modes [J].
double modal_energy(const Body& beam, const std::vector<double>& u, const std::vector<double>& v);

/// The energy at t = 0 of a start whose modal state was set by hand: the check of the energy asks
/// for it.
void count_energy(const Model& model, ModalStart& start);

}  // namespace ra2d::test
