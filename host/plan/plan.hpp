// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/run/model.hpp"

/// What would be modelled, and why: modes, nodes, step, limits of stability, cost.
namespace ra2d {

/// Largest step [s] at which backward Euler with the contact force taken at the old time is stable
/// while `nodes` nodes, all at the place where the bodies yield most, stay in contact; infinity
/// when every step is (kernels/schemes/backward_euler.hpp).
double contact_step_limit(const Model& model, int nodes);

/// Angular frequency [rad/s] of the contact spring of one node against the bodies' inertia,
/// omega_c^2 = kappa chi w sum psi^2/m at the place where they yield most.
double contact_frequency(const Model& model);

struct BodyPlan {
  int rigid_modes = 0, elastic_modes = 0;
  double highest = 0;  // Hz, of the modes that are kept; 0 without any
  double next = 0;     // Hz, of the first that is left out
  int nodes = 0;
  double wavelength_nodes = 0;   // nodes to the shortest wavelength; 0 without any
  double numerical_damping = 0;  // omega tau / 2 of the highest mode: backward Euler's, beside zeta
};

struct Plan {
  BodyPlan resonator, slider;
  double delta = 0;                      // m
  double limit_one = 0, limit_many = 0;  // s, contact_step_limit for one node and for `many` nodes
  int many = 16;
  double contact_period = 0;  // s, half a period of the contact spring: about a shock's length
  double steps_per_node = 0;  // steps while the slider moves on by one node
  std::int64_t steps = 0, samples = 0;
  double seconds_low = 0, seconds_high = 0;  // of wall time, see plan.cpp
  std::size_t memory = 0;                    // bytes on the device, for tables and buffers
  std::size_t file = 0;                      // bytes, without the shocks
  std::vector<std::string> notes;            // what a user may not expect
};

/// Runs nothing; `memory` is what the march would take (Batch::bytes).
Plan make_plan(const Model& model, std::size_t memory);

/// The plan as text, a line a fact.
std::string describe(const Model& model, const Plan& plan);

}  // namespace ra2d
