// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Costs of steps on one core of a server processor of 2023 (bench/bench_march.cpp,
/// bench_schemes.cpp, bench_adaptive.cpp), in ns unless a name says otherwise. Every estimate of
/// cost takes its constants from here. Times are of `counted_modes` modes or fewer; more take
/// longer in proportion.
namespace ra2d::step_costs {

inline constexpr double counted_modes = 24;

// Of a step of fixed length: in free flight; in contact at a node, by the form of the step, of
// staged schemes a stage.
inline constexpr double flight = 5.0, contact = 45.0, stage = 50.0, held = 100.0;
// Which nodes can touch is found again whenever the bodies have moved by as much as the nodes are
// off, in long steps at each: a step at the most, and a second of a free slider.
inline constexpr double search = 600.0, searches_a_second = 0.2e9;
// Each node more, a mode. Where every node is evaluated: a node and an evaluation.
inline constexpr double more_nodes = 1.7, node = 0.7;
// Where every node of an areal scene is evaluated: a node and an evaluation, and each mode of it.
inline constexpr double row_node = 2.3, row_node_mode = 0.03;
// Between smooth faces: a stage in contact, and each cell more; with the penalty force of the new
// time; Newton's steps where many cells touch.
inline constexpr double cells = 400.0, cell = 70.0, new_cells = 2500.0, cells_newton_steps = 4;

// Of the adaptive scheme: a flight; a step with forces, for each order of its series; a sample.
inline constexpr double leap = 600.0, order = 130.0, sample = 40.0;
// Of areal scenes, from runs of bench_areal: spacings of 64 to 8 um, blocks of 5 to 80 mm. Steps
// over those that plan_adaptive_steps counts: by the fastest motion, where the series has its usual
// order, and where that may be raised, at the highest; by nodes that touch or let go; for each node
// in contact that passes another. Before there is a model: for each radian of the fastest mode. A
// step, over one of a plane scene of as many modes; each node in contact, over the same; what a
// step evaluates elsewhere, for each metre that the block is wide. Nodes in contact on average,
// over those of the static start.
inline constexpr double row_turns = 0.6, row_raised_turns = 1.1, row_touches = 0.1,
                        row_crossings = 0.9, row_steps_a_radian = 0.35, row_step = 0.5,
                        row_more_share = 0.05, row_groups = 0.55e6, row_contacts = 0.7;
// Of their fixed steps, a stage in contact; each node more, a mode.
inline constexpr double row_stage = 270, row_more_nodes = 2.5;
// Of areal scenes between smooth faces, from runs of scenes/areal.toml at 62.5 um along and 32 to 8
// um across: steps over those of a plane scene, and what each cell in contact adds to them; the
// share of a step that each such cell takes; what a step evaluates elsewhere.
inline constexpr double row_smooth_steps = 0.47, row_smooth_steps_more = 0.041,
                        row_smooth_more_share = 0.3, row_smooth_groups = 7000;
// Between smooth faces: a step with contact, of nine points.
inline constexpr double smooth_step = 4000.0;
// The share of such a step that each node or cell more takes: where all of them touch; and on
// average over runs of rough faces, for each that a contact is wide.
inline constexpr double more_share = 0.25, usual_more_share = 0.14;
// Steps of the adaptive scheme: for each node that a node passes, where contacts are narrower than
// a spacing, and where they are wide; for each radian of the fastest mode. Between smooth faces no
// node ends a step, and a radian takes so many steps at the tolerance of 1e-6; where it is known
// how long contacts last, so many a radian, and so many in that time, for not all of it is contact.
// The error of a step goes with this power of its length.
inline constexpr double steps_a_crossing = 1.2, steps_a_wide_crossing = 3.5, steps_a_radian = 0.45,
                        smooth_steps_a_radian = 0.7, smooth_steps_a_free_radian = 0.2,
                        smooth_steps_a_contact = 1.2, smooth_order = 16;

// Of forces that are found with the end of the step, at many nodes
// (kernels/contact/complementarity.hpp): each pressed one after the other, by the cube of how many;
// or, on springs, by Newton's method, some ten steps of a product over all modes and one of their
// squares for each node, and a factorisation.
inline constexpr double pressed = 0.7, newton_steps = 10, newton_node = 100, newton_square = 0.08,
                        newton_cube = 0.4;
inline constexpr double pressed_at_most = 256;  // nodes

// A force that travels, each time that it is evaluated.
inline constexpr double travelling_force = 20;

// Before the march: always; a node; a node and mode of the static start; of that of a block on a
// plate, each pair of modes.
inline constexpr double readiness = 2e6, surface_node = 60, balanced_node = 70,
                        balanced_pair = 5000;

// Sound at a microphone: a point of the face; a sample, and each mode of it. A sample and mode that
// is read.
inline constexpr double face_point = 230, heard = 70, heard_mode = 2.5, read_mode = 10;

}  // namespace ra2d::step_costs
