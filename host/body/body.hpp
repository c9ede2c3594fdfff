// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <vector>

#include "host/scene/scene.hpp"
#include "kernels/schemes/mode_step.hpp"

/// Bodies as the march and its proofs see them (docs/model.md): modes, mass and load. The shape of
/// a mode is an interface, of which every kind of body has its own class: beams
/// (host/body/beam.hpp) in plane scenes, plates and blocks (host/body/plate.hpp, block.hpp) in
/// areal ones. Nothing here is called in the time loop: the tables of a scene (kernels/tables.hpp)
/// are filled from it once.
namespace ra2d {

/// Bound on the difference between a shape and its Taylor cubic about the centre of a stretch.
struct CubicRemainder {
  double value;  // of psi, m^(-1/2)
  double slope;  // of psi', m^(-3/2)
};

/// The shape psi of one mode along the line on which nodes pass it: x from 0 to the body's length
/// [m]. The integral of psi^2 over the body is 1; psi in m^(-1/2).
///
/// In an areal scene a node keeps its y, and the shape is a product: psi(x, y) = psi(x) across(y),
/// |across| <= 1. What is said of psi below is then of psi(x), the shape along the line of constant
/// y where it is largest; its unit is 1/m. Of a beam across is 1 everywhere. A shape that is no
/// such product (a measured mode) would need patches of its own for every row of nodes. That is not
/// built.
///
/// Bounds hold over the body. Those that take `beyond` or `radius` hold behind its far end, too:
/// the patches of the march (kernels/displacement.hpp) may end there.
class ModeShape {
 public:
  virtual ~ModeShape() = default;

  /// psi and its first `derivatives` - 1 derivatives at x [m]: out[j] = d^j psi/dx^j.
  virtual void evaluate(double x, int derivatives, double* out) const = 0;

  /// max |psi|, tight to a few per cent.
  virtual double largest() const = 0;
  /// The sizes of the parts that psi is a sum of, added up: at least max |psi|. The roundings of
  /// psi are in proportion to it.
  virtual double size() const = 0;
  /// Wave number of the bent shape [1/m]: |psi^(j)| <= wave_number()^j size() for j >= 2. 0 of a
  /// straight line.
  virtual double wave_number() const = 0;
  /// As wave_number(), but for all j >= 1 [1/m]: a straight line has a slope, too.
  virtual double change_rate() const = 0;

  /// max |psi'| [m^(-3/2)] and max |psi''| [m^(-5/2)] up to `beyond` [m] behind the far end.
  virtual double largest_slope(double beyond) const = 0;
  virtual double largest_curvature(double beyond) const = 0;
  /// Factor by which the bounds on psi grow up to `beyond` [m] behind the far end.
  virtual double growth(double beyond) const = 0;
  /// Within `radius` [m] of a centre that may itself be up to `radius` behind the far end.
  virtual CubicRemainder cubic_remainder(double radius) const = 0;

  /// Factor that leads from one derivative to the fourth after it, lengths in units of `unit` [m]:
  /// psi^(j+4) = fourth_derivative_factor psi^(j). The march stores the value and three derivatives
  /// of a shape at the centre of each patch, and continues the series by this factor.
  ///
  /// A shape without such a factor (a measured mode, a plate with free edges) needs all terms of
  /// its series stored for each patch: wider patch tables (host/device/fill.cpp), and kernels that
  /// read them where they multiply by the factor now (kernels/displacement.hpp). That is not built.
  virtual double fourth_derivative_factor(double unit) const = 0;

  /// across and its first `derivatives` - 1 derivatives at y [m], from the body's edge:
  /// out[j] = d^j across/dy^j.
  virtual void evaluate_across(double y, int derivatives, double* out) const;
  /// Rate of change across the body [1/m]: |d^j across/dy^j| <= across_rate()^j for j >= 1.
  virtual double across_rate() const { return 0; }

  /// Mean of psi^2 over `nodes` nodes from x = 0 on, `spacing` [m] apart [1/m]. Of an areal body:
  /// over its area [1/m^2], whatever the nodes.
  virtual double mean_square(int nodes, double spacing) const;

  /// Appends the numbers that psi depends on. Shapes of one kind with equal numbers are equal.
  virtual void append_parameters(std::vector<double>& out) const = 0;
};

/// One mode: m (U'' + 2 zeta omega U' + omega^2 U) = F, omega 0 of a rigid mode, and its shape. m
/// is the mass of a metre of a beam, of a square metre of an areal body.
struct BodyMode : Mode {
  std::shared_ptr<const ModeShape> shape;
};

struct Body {
  double length = 0;            // m, of the line on which nodes pass
  double mass = 0;              // kg
  std::vector<BodyMode> modes;  // rigid modes first, then elastic ones by frequency
  std::vector<double> load;     // N m^(-1/2), modal load of the body's evenly spread load W; N/m
                                // of an areal body
  double load_force = 0;        // N, W
};

/// The body that a scene describes. Throws RequestError where it keeps too many modes.
Body make_body(const BodySpec& spec);

/// The most elastic modes that a body may keep: more is a slip of the keyboard.
inline constexpr int most_elastic_modes = 100'000;
/// Throws RequestError where a body keeps more than that many.
void check_mode_count(int elastic_modes);

/// W [N] of a body of this mass [kg]: its load, or so many times its weight (9.80665 m/s^2).
double load_force(const BodySpec& spec, double mass);

/// Number of rigid modes of a body of this kind and support.
int rigid_mode_count(const BodySpec& spec);

/// Number of modes that a body keeps, its rigid ones among them. Of max_frequency up to `most`
/// elastic ones are counted.
int mode_count(const BodySpec& spec, int most);

/// Frequency in Hz of elastic mode k = 0, 1, ... of a body, whether it is kept or not. Infinite of
/// a block.
double elastic_frequency(const BodySpec& spec, int k);

/// The largest wave number of a body's modes [1/m]; 0 without any.
double highest_wave_number(const Body& body);

/// psi(x) [m^(-1/2)]; psi(x, y) [1/m] of an areal body.
double shape_at(const BodyMode& mode, double x);
double shape_at(const BodyMode& mode, double x, double y);

}  // namespace ra2d
