// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/scene/scene.hpp"

/// The expected cost of a run, from the scene alone. A study has no time to make the models of a
/// million scenes before it says what they will cost.
namespace ra2d {

struct ExpectedWork {
  double steps = 0;      // steps that the march makes; of the adaptive scheme those it chooses
  double march = 0;      // s of one thread
  double readiness = 0;  // s of one thread: surfaces, static start, tables
  double seconds() const { return march + readiness; }
};

/// A contact at the peak of a shock, and how long it lasts; 0 where that is not known.
struct UsualContact {
  double width = 0;     // m
  double duration = 0;  // s
};

/// With a contact half of the time, as rough faces have it; of one node where its width is not
/// known. The steps of `adaptive` are right within a factor of 3
/// (tests/host/test_plan.cpp counts them), the seconds within as much on the machine that they were
/// measured on. Where hundreds of nodes lie on one another all the time a run takes longer:
/// 'ra2d plan' says how long at the worst.
ExpectedWork expected_work(const Scene& scene, const UsualContact& contact = {});

/// Steps of `adaptive` in a second between smooth faces of maps, under a fastest motion [rad/s] and
/// with so many cells in contact.
double map_steps_a_second(const Scene& scene, double fastest, double touching);

/// How long so many fixed steps of a plane scene search for the nodes that can touch [s];
/// `duration`: s of the scene.
double search_seconds(const Scene& scene, double steps, double duration);

}  // namespace ra2d
