// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/model/model.hpp"

/// The contacts of an areal scene: between summits that are round, Hertz's point contacts.
namespace ra2d {

/// A sphere of a radius on a plane under a force (K. L. Johnson, Contact Mechanics, 1985, section
/// 4.2), and what a bed of springs needs to be as stiff under that force. Pressed in by d, the
/// springs carry F = pi kappa R d^2.
struct PointContact {
  double half_width = 0;  // m, a = (3 F R/(4 E*))^(1/3)
  double stiffness = 0;   // N/m, dF/dd = 2 E* a
  double kappa = 0;       // Pa/m, of springs with the same dF/dd: 3 E*/(4 pi a)
};

/// `modulus`: E* [Pa]; `radius` [m]; `force` [N], each above 0.
PointContact point_contact(double modulus, double radius, double force);

/// Width [m] of the contact of a sphere on springs of `kappa` [Pa/m] under a force.
double width_on_springs(double kappa, double radius, double force);

/// Radius [m] of the paraboloid through (2 m + 1)^2 heights about the middle one, by least squares:
/// 1/sqrt(k1 k2) of its curvatures. 0 where it is no summit. `heights`: (row, along x) in m.
double summit_radius(const std::vector<double>& heights, double spacing, double spacing_y);

struct PointContacts {
  double modulus = 0;  // Pa, E*: a block has no Young's modulus and counts as the plate's material
  double radius = 0;   // m, of the highest summits; 0 where nothing is known
  int contacts = 0;    // that share the load: at the start, at least three of a free block
  double load = 0;     // N, on each
  PointContact hertz;  // of the materials
  double width = 0;    // m, of a contact on the scene's springs
  double nodes = 0;    // that it is wide, along or across, where they are farther apart; smooth
                       // faces have none along x: rows
  double shock_error = 0;  // of rates of shocks and of their durations, relative (shock_error_of)
};

/// About how far rates of shocks and their median durations are off, relative, where a contact is
/// so many nodes, or rows between smooth faces, wide. Fitted to runs of scenes/areal.toml
/// (docs/accuracy.md, On maps).
double shock_error_of(double nodes, Faces faces);

/// How many nodes, or rows, wide a contact must be for such an error.
double nodes_for(double shock_error, Faces faces);

/// None (radius 0) of plane scenes, without a load that is known, under multipliers, and where both
/// bodies are rigid. `start`: of the model.
PointContacts point_contacts_of(const Model& model, const ModalStart& start);

/// A warning about an areal model whose shock_error is above 0.4; empty else. Looks at fewer places
/// than point_contacts_of(), and takes the fewest contacts that can carry the load.
std::string doubt_mesh(const Model& model);

/// Pieces of contact: nodes of a model in ascending order, neighbours as the eight around a node.
int pieces_of(const Model& model, const std::vector<int>& nodes);

}  // namespace ra2d
