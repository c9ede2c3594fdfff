// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/growth.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "host/device/batch.hpp"

namespace ra2d {
namespace {

constexpr double spring_ratio = 1000;          // of the contact spring's stiffness to the mode's
constexpr double well_above_roundings = 1e-3;  // of the motion at the start
constexpr double peak_height = 1e-4, pressed = 1e-5, far_away = 1.0;  // m

/// A steel plate with one mode under a rigid slider whose one peak stands over the middle of it,
/// pressed on it or out of its reach.
Scene trial_scene(bool contact) {
  Scene s;
  s.start = 0.14;
  s.spacing = 0.01;
  s.gap = contact ? peak_height - pressed : far_away;
  s.initial = contact ? Initial::statics : Initial::rest;
  BodySpec& plate = s.resonator;
  plate.length = 0.3;
  plate.thickness = 0.002;
  plate.width = 0.2;
  plate.young = 210e9;
  plate.density = 7800;
  plate.modes = 1;
  s.slider = plate;
  s.slider.support = Support::rigid;
  s.slider.modes = 0;
  s.slider.length = 0.02;
  s.slider.surface.kind = SurfaceKind::peaks;
  s.slider.surface.peaks = {{.at = 0.01, .height = peak_height, .half_width = 0.005}};
  return s;
}

using ModeState = Eigen::Vector2d;   // U, V/omega
using ModeStates = Eigen::Matrix2d;  // two of them

/// Of a matrix of n steps. Where its two eigenvalues cannot be told from a double one, n steps are
/// a whole number of half periods: both have the size of their mean.
double spectral_radius(const ModeStates& m) {
  const double half = 0.5 * m.trace(), det = m.determinant(), apart = half * half - det;
  return apart <= 1e-8 * std::abs(det) ? std::sqrt(std::abs(det))
                                       : std::abs(half) + std::sqrt(apart);
}

Model trial_model(const GrowthTrial& trial, const TrialMode& mode, Scene scene, int steps) {
  scene.time = trial.choice;
  scene.resonator.damping = trial.zeta;
  scene.time.step = trial.x / mode.omega;
  scene.duration = steps * scene.time.step;
  scene.output.rate = 0.5 / scene.duration;  // the start alone
  scene.contact.stiffness =
      trial.contact ? mode.stiffness / (scene.spacing * scene.resonator.width) : 1.0;
  return make_model(scene);
}

}  // namespace

TrialMode::TrialMode(bool contact) : contact{contact} {
  const Body body = make_body(trial_scene(contact).resonator);
  const BodyMode& first = body.modes[0];
  const double psi = shape_at(first, 0.5 * body.length);
  omega_free = first.omega;
  mass = first.mass;
  square = psi * psi;
  stiffness = contact ? spring_ratio * mass * omega_free * omega_free / square : 0.0;
  omega = contact ? std::sqrt(spring_ratio) * omega_free : omega_free;
}

JoinedModes TrialMode::joined(double zeta) const {
  return {{Mode{omega_free, zeta, mass}}, {square}};
}

std::vector<double> measure_growth(const std::vector<GrowthTrial>& trials, int steps) {
  const std::array<TrialMode, 2> modes{TrialMode(false), TrialMode(true)};
  const std::array<Scene, 2> scenes{trial_scene(false), trial_scene(true)};
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  std::vector<double> rest, nudge, frequency;  // of each trial
  for (const GrowthTrial& trial : trials) {
    const TrialMode& mode = modes[trial.contact];
    const Model model = trial_model(trial, mode, scenes[trial.contact], steps);
    const ModalStart still = make_start(model);
    rest.push_back(still.resonator_u[0]);
    // a hundredth of the overlap, so that a contact stays closed
    nudge.push_back(trial.contact
                        ? 0.01 * still.contact_force / model.node_stiffness / std::sqrt(mode.square)
                        : 1e-9);
    frequency.push_back(std::hypot(mode.omega_free, trial.contact ? mode.omega : 0.0));
    for (const bool moving : {false, true}) {
      ModalStart start = still;
      (moving ? start.resonator_v : start.resonator_u)[0] +=
          nudge.back() * (moving ? frequency.back() : 1.0);
      start.energy = std::numeric_limits<double>::infinity();  // growth does not end the march
      models.push_back(model);
      starts.push_back(start);
    }
  }
  Batch batch(models, starts, {.capacity = {.samples = 1, .shocks = 16}, .least_packs = 0});

  // The states of a trial's two motions as they are now. False when one of them is past measuring.
  const auto take_states = [&](std::size_t i, std::int64_t step, ModeStates& state) {
    bool measured = true;
    for (const int j : {0, 1}) {
      const Snapshot now = batch.snapshot(static_cast<int>(2 * i + j));
      state.col(j) =
          ModeState{now.resonator_u[0] - rest[i], now.resonator_v[0] / frequency[i]} / nudge[i];
      measured = measured && now.step == step && state.col(j).allFinite() &&
                 now.contact_steps == (trials[i].contact ? step : 0);
    }
    return measured;
  };
  const std::size_t count = trials.size();
  std::vector<ModeStates> begin(count);
  std::vector<double> growth(count, 0.0);
  std::vector<bool> going(count, true);
  batch.march(0);
  for (std::size_t i = 0; i < count; ++i) take_states(i, 0, begin[i]);
  for (std::int64_t step = 1; step <= steps; step *= 2) {
    batch.march(step);
    for (std::size_t i = 0; i < count; ++i) {
      if (!going[i]) continue;
      ModeStates now;
      going[i] = take_states(i, step, now);
      const ModeStates taken = now * begin[i].inverse();
      going[i] = going[i] && taken.norm() > well_above_roundings;
      if (going[i] || step == 1)
        growth[i] = std::log(spectral_radius(taken)) / static_cast<double>(step);
    }
  }
  return growth;
}

}  // namespace ra2d
