// SPDX-License-Identifier: BSD-3-Clause
#include "tests/smooth_reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "host/body/plate.hpp"

namespace ra2d::test {
namespace {

using Real = long double;
using Numbers = std::vector<Real>;

constexpr int most_terms = 14;

/// A polynomial along a cell, of as many terms as the scene needs.
struct Polynomial {
  std::array<Real, most_terms> c{};
  int terms = 0;
  Real& operator[](int p) { return c[p]; }
  const Real& operator[](int p) const { return c[p]; }
};

Real value(const Polynomial& p, Real x) {
  Real sum = 0;
  for (int i = p.terms - 1; i >= 0; --i) sum = sum * x + p[i];
  return sum;
}
Real slope(const Polynomial& p, Real x) {
  Real sum = 0;
  for (int i = p.terms - 1; i >= 1; --i) sum = sum * x + i * p[i];
  return sum;
}
Real curvature(const Polynomial& p, Real x) {
  Real sum = 0;
  for (int i = p.terms - 1; i >= 2; --i) sum = sum * x + i * (i - 1) * p[i];
  return sum;
}
Polynomial derivative(const Polynomial& p) {
  Polynomial d;
  d.terms = std::max(p.terms - 1, 0);
  for (int i = 1; i < p.terms; ++i) d[i - 1] = i * p[i];
  return d;
}

/// Points and weights on [-1, 1].
struct GaussRule {
  int points;
  std::array<Real, most_terms> at, weight;

  explicit GaussRule(int count) : points{count} {
    for (int i = 0; i < points; ++i) {
      Real x = std::cos(std::numbers::pi_v<Real> * (i + 0.75L) / (points + 0.5L)), slope = 1;
      for (int round = 0; round < 30; ++round) {
        Real before = 1, now = x;
        for (int n = 2; n <= points; ++n) {
          const Real next = ((2 * n - 1) * x * now - (n - 1) * before) / n;
          before = now;
          now = next;
        }
        slope = points * (x * now - before) / (x * x - 1);
        x -= now / slope;
      }
      at[i] = x;
      weight[i] = 2 / ((1 - x * x) * slope * slope);
    }
  }
};

/// Second derivatives at the nodes, times the square of their distance, of the spline that is not
/// a knot at the second and the last node but one.
Numbers spline(const Numbers& h) {
  const int n = static_cast<int>(h.size());
  Numbers b(n, 0.0L);
  if (n < 3) return b;
  const auto second = [&](int i) { return h[i + 1] - 2 * h[i] + h[i - 1]; };
  if (n == 3) return {second(1), second(1), second(1)};
  // rows: unknowns 1 ... n - 2; b[0] = 2 b[1] - b[2], and as much at the other end
  Numbers diagonal(n, 4.0L), above(n, 1.0L), below(n, 1.0L), right(n);
  for (int i = 1; i <= n - 2; ++i) right[i] = 6 * second(i);
  diagonal[1] = diagonal[n - 2] = 6;
  above[1] = below[n - 2] = 0;
  for (int i = 2; i <= n - 2; ++i) {
    const Real share = below[i] / diagonal[i - 1];
    diagonal[i] -= share * above[i - 1];
    right[i] -= share * right[i - 1];
  }
  b[n - 2] = right[n - 2] / diagonal[n - 2];
  for (int i = n - 3; i >= 1; --i) b[i] = (right[i] - above[i] * b[i + 1]) / diagonal[i];
  b[0] = 2 * b[1] - b[2];
  b[n - 1] = 2 * b[n - 2] - b[n - 3];
  return b;
}

struct Cubic {
  std::array<Real, 4> c;
  Cubic about(Real x) const {
    return {{c[0] + x * (c[1] + x * (c[2] + x * c[3])), c[1] + x * (2 * c[2] + x * 3 * c[3]),
             c[2] + 3 * x * c[3], c[3]}};
  }
};

/// The pieces of a face between its nodes, each about its left node.
std::vector<Cubic> pieces_of(const std::vector<double>& heights) {
  const Numbers h(heights.begin(), heights.end()), b = spline(h);
  std::vector<Cubic> out;
  for (std::size_t i = 0; i + 1 < h.size(); ++i)
    out.push_back(
        {{h[i], h[i + 1] - h[i] - (2 * b[i] + b[i + 1]) / 6, b[i] / 2, (b[i + 1] - b[i]) / 6}});
  return out;
}

/// psi = sine sin bx + cosine cos bx + left exp(-bx) + right exp(-b (L - x)) + constant + slope x;
/// of plates and blocks times sin(wave_y y), or 1 + slope_y y.
struct Shape {
  Real beta = 0, sine = 0, cosine = 0, left = 0, right = 0, constant = 0, slope = 0, length = 0;
  Real wave_y = 0, slope_y = 0;

  Real across(Real y) const { return wave_y > 0 ? std::sin(wave_y * y) : 1 + slope_y * y; }
  Real most_across() const { return slope_y == 0 ? 1 : std::sqrt(3.0L); }
};

Shape shape_of(Support support, Real length, int k) {
  constexpr Real pi = std::numbers::pi_v<Real>;
  Shape s;
  s.length = length;
  if (support == Support::pinned) {
    s.beta = (k + 1) * pi / length;
    s.sine = std::sqrt(2 / length);
    return s;
  }
  if (k == 0) {
    s.constant = 1 / std::sqrt(length);
    return s;
  }
  if (k == 1) {
    s.slope = std::sqrt(12 / length) / length;
    s.constant = -s.slope * length / 2;
    return s;
  }
  // cosh z cos z = 1
  const int e = k - 2;
  Real z = (e + 1.5L) * pi;
  for (int i = 0; i < 20; ++i) {
    const Real f = std::cos(z) - 1 / std::cosh(z);
    z -= f / (-std::sin(z) + std::tanh(z) / std::cosh(z));
  }
  // cosh bx + cos bx - sigma (sinh bx + sin bx), sigma = (cosh z - cos z)/(sinh z - sin z), where
  // cos z = 1/cosh z and sin z = -+ tanh z
  const Real parity = e % 2 == 0 ? 1 : -1, scale = 1 / std::sqrt(length);
  const Real decay = parity * std::exp(-z);
  s.beta = z / length;
  s.cosine = scale;
  s.sine = -scale * (1 - decay) / (1 + decay);  // sigma = sinh z/(cosh z + parity)
  s.left = scale * 1 / (1 + decay);             // (1 + sigma)/2
  s.right = scale * parity / (1 + decay);       // exp(z) (1 - sigma)/2
  return s;
}

/// The shapes of a pinned plate, and of a block that heaves, pitches and rolls.
std::vector<Shape> plate_shapes(const BodySpec& plate, int count) {
  constexpr Real pi = std::numbers::pi_v<Real>;
  const Real a = plate.length, b = plate.width;
  std::vector<Shape> shapes;
  for (const PinnedPlateMode& mode : plate_modes(plate, count)) {
    Shape s;
    s.length = a;
    s.beta = mode.m * pi / a;
    s.sine = 2 / std::sqrt(a * b);
    s.wave_y = mode.n * pi / b;
    shapes.push_back(s);
  }
  return shapes;
}
std::vector<Shape> block_shapes(const BodySpec& block) {
  const Real l1 = block.length, l2 = block.width, unit = 1 / std::sqrt(l1 * l2);
  Shape heave, pitch, roll;
  heave.length = pitch.length = roll.length = l1;
  heave.constant = unit;
  pitch.slope = unit * std::sqrt(12.0L) / l1;
  pitch.constant = -pitch.slope * l1 / 2;
  roll.constant = -std::sqrt(3.0L) * unit;
  roll.slope_y = -2 / l2;
  return {heave, pitch, roll};
}

std::vector<Shape> body_shapes(const BodySpec& spec, int count, bool is_areal, bool is_slider) {
  if (is_areal) return is_slider ? block_shapes(spec) : plate_shapes(spec, count);
  std::vector<Shape> shapes;
  for (int k = 0; k < count; ++k) shapes.push_back(shape_of(spec.support, spec.length, k));
  return shapes;
}

/// One end of a piece of contact: a root of the overlap on the piece of cell `own` of the slider
/// and cell `other` of the resonator, or an end of the slider.
struct End {
  Real at = 0;  // chi along the slider
  int own = 0, other = 0;
  bool of_slider = false;
};
struct Interval {
  End left, right;
  int shock = -1;
};

/// Faces and modes; lengths along the slider in chi.
///
/// The rows of an areal scene stand one after the other on one long line: what is at x in row r has
/// the place r stride + x there, cells and places of the resonator alike.
class Scenery {
 public:
  int cells, modes2, modes1, modes;  // cells: of a row
  int rows = 1, stride = 0, pieces;  // pieces: of the resonator, in a row
  int terms = 5;                     // of polynomials along a cell
  int base_node;                     // of the resonator: its nodes are counted from here
  Real chi, start, speed, spring;    // m; chi, from that node; chi per s; N/m, of a cell
  std::vector<Cubic> own, other;     // the slider's less delta
  Numbers omega, zeta, mass, load;
  std::vector<Shape> shapes;
  Numbers factor;             // (mode, term): (beta chi)^(4 [p/4]) / p!
  Numbers slider;             // (mode, cell, 4): psi and three derivatives at a cell's middle
  Numbers share;              // (mode, row): psi(x, y)/psi(x)
  Numbers wave;               // (mode, cell of a row, 4): cos, sin, exp(-), exp(+) of beta i chi
  Numbers largest, steepest;  // of psi; of psi' [per chi]
  Real steepest_face = 0;
  std::vector<MovingForce> forces;
  Real length2;

  explicit Scenery(const Model& m) {
    rows = m.rows;
    cells = m.row_nodes() - 1;
    chi = m.scene.spacing;
    base_node = static_cast<int>(m.position);
    start = static_cast<Real>(m.position) - base_node;
    speed = static_cast<Real>(m.scene.speed) / chi;
    spring = static_cast<Real>(m.scene.contact.stiffness) * chi *
             (m.is_areal ? m.spacing_y : std::min(m.scene.resonator.width, m.scene.slider.width));
    pieces = m.row_heights() - 1 - base_node;
    stride = rows == 1 ? 0 : pieces + 2;
    for (int r = 0; r < rows; ++r) {
      const auto row = [&](const std::vector<double>& heights, int length) {
        const auto first = heights.begin() + std::ptrdiff_t{r} * length;
        return pieces_of({first, first + length});
      };
      own.resize(static_cast<std::size_t>(r) * stride);
      for (Cubic& c : row(m.slider_height, m.row_nodes())) {
        c.c[0] -= m.delta;
        own.push_back(c);
      }
      const std::vector<Cubic> passed = row(m.resonator_height, m.row_heights());
      other.resize(static_cast<std::size_t>(r) * stride);
      other.insert(other.end(), passed.begin() + base_node, passed.end());
    }
    for (const Cubic& c : other)
      steepest_face =
          std::max(steepest_face, std::abs(c.c[1]) + 2 * std::abs(c.c[2]) + 3 * std::abs(c.c[3]));
    length2 = m.scene.resonator.length;
    forces = m.scene.resonator.moving_forces;
    modes2 = static_cast<int>(m.resonator.modes.size());
    modes1 = static_cast<int>(m.slider.modes.size());
    modes = modes2 + modes1;
    for (const Body* body : {&m.resonator, &m.slider}) {
      const BodySpec& spec = body == &m.slider ? m.scene.slider : m.scene.resonator;
      const auto count = static_cast<int>(body->modes.size());
      const std::vector<Shape> of_body = body_shapes(spec, count, m.is_areal, body == &m.slider);
      for (std::size_t k = 0; k < body->modes.size(); ++k) {
        const BodyMode& mode = body->modes[k];
        omega.push_back(mode.omega);
        zeta.push_back(mode.zeta);
        mass.push_back(mode.mass);
        load.push_back(k < body->load.size() ? body->load[k] : 0.0);
        const Shape& s = shapes.emplace_back(of_body.at(k));
        const Real edge = body == &m.slider ? 0 : static_cast<Real>(m.side);
        for (int r = 0; r < rows; ++r)
          share.push_back(m.is_areal ? s.across(edge + (r + 0.5L) * static_cast<Real>(m.spacing_y))
                                     : 1);
        largest.push_back(
            s.most_across() *
            (std::hypot(s.sine, s.cosine) + std::abs(s.left) + std::abs(s.right) +
             std::max(std::abs(s.constant), std::abs(s.constant + s.slope * s.length))));
        steepest.push_back((s.beta * largest.back() + std::abs(s.slope)) * chi);
      }
    }
    Real steepest_wave = 0;  // beta chi/2: with so many terms what is left out is below 1e-21
    for (const Shape& shape : shapes) steepest_wave = std::max(steepest_wave, shape.beta * chi / 2);
    for (Real left = std::pow(steepest_wave, 5) / 120; left > 1e-21L; left *= steepest_wave / terms)
      if (++terms > most_terms)
        throw std::invalid_argument("reference: modes too fine for the cells");
    factor.resize(modes * terms);
    wave.resize(static_cast<std::size_t>(modes) * cells * 4);
    slider.resize(static_cast<std::size_t>(modes) * length() * 4);
    for (int k = 0; k < modes; ++k) {
      const Shape& s = shapes[k];
      const Real b = s.beta * chi;
      Real factorial = 1;
      for (int p = 0; p < terms; ++p) {
        if (p > 0) factorial *= p;
        factor[k * terms + p] = std::pow(b, Real(4 * (p / 4))) / factorial;
        if (s.beta == 0) factor[k * terms + p] = p < 2 ? 1 : 0;
      }
      for (int i = 0; i < cells; ++i) {
        Real* w = waves(k, i);
        w[0] = std::cos(b * i), w[1] = std::sin(b * i);
        w[2] = std::exp(-b * i), w[3] = std::exp(b * i);
        if (k >= modes2) {
          const Real middle = (i + 0.5L) * b;
          for (int r = 0; r < rows; ++r) {
            Real* const own =
                &slider[(static_cast<std::size_t>(k) * length() + r * stride + i) * 4];
            base(s, std::sin(middle), std::cos(middle), std::exp(-middle),
                 std::exp(middle - s.beta * s.length), (i + 0.5L) * chi, own);
            for (int d = 0; d < 4; ++d) own[d] *= share_on(k, r);
          }
        }
      }
    }
  }
  /// Of the line, from its first cell to its last.
  int length() const { return (rows - 1) * stride + cells; }
  int row_of(int cell) const { return rows == 1 ? 0 : cell / stride; }
  int along(int cell) const { return cell - row_of(cell) * stride; }
  int row_at(Real at) const { return rows == 1 ? 0 : static_cast<int>(std::floor(at / stride)); }
  /// Where the row of a place begins and ends.
  Real row_start(Real at) const { return Real(row_at(at)) * stride; }
  Real row_end(Real at) const { return row_start(at) + cells; }
  Real share_on(int k, int row) const { return share[static_cast<std::size_t>(k) * rows + row]; }
  Real* waves(int k, int i) { return &wave[(static_cast<std::size_t>(k) * cells + i) * 4]; }
  const Real* waves(int k, int i) const {
    return &wave[(static_cast<std::size_t>(k) * cells + i) * 4];
  }
  const Real* of_slider(int k, int cell) const {
    return &slider[(static_cast<std::size_t>(k) * length() + cell) * 4];
  }
  /// psi and three derivatives, lengths in chi, from the four functions at x.
  void base(const Shape& s, Real sin, Real cos, Real falling, Real rising, Real x,
            Real* out) const {
    if (s.beta == 0) {
      out[0] = s.constant + s.slope * x;
      out[1] = s.slope * chi;
      out[2] = out[3] = 0;
      return;
    }
    const Real b = s.beta * chi, even = s.sine * sin + s.cosine * cos,
               odd = s.sine * cos - s.cosine * sin, l = s.left * falling, r = s.right * rising;
    out[0] = even + l + r;
    out[1] = b * (odd - l + r);
    out[2] = b * b * (-even + l + r);
    out[3] = b * b * b * (-odd - l + r);
  }
};

/// The overlap along the slider at one time and state.
class Field {
 public:
  explicit Field(const Scenery& scenery)
      : s{scenery},
        sin_(s.modes2),
        cos_(s.modes2),
        falling_(s.modes2),
        rising_(s.modes2),
        stamps_(s.length(), 0),
        u_(s.length()),
        u2_(s.length()),
        shape_(static_cast<std::size_t>(s.modes) * s.length() * 4) {}

  void set(Real time, const Real* u) {
    amplitude_ = u;
    x_ = s.start + s.speed * time;
    ++stamp_;
    for (int k = 0; k < s.modes2; ++k) {
      const Shape& shape = s.shapes[k];
      const Real at = (s.base_node + x_ + 0.5L) * s.chi, phase = shape.beta * at;
      sin_[k] = std::sin(phase), cos_[k] = std::cos(phase);
      if (shape.left != 0 || shape.right != 0)
        falling_[k] = std::exp(-phase), rising_[k] = std::exp(shape.beta * (at - shape.length));
    }
  }
  Real x() const { return x_; }
  /// Of the piece on which a place of the slider stands.
  int own_at(Real at) const {
    const int first = s.row_at(at) * s.stride;
    return std::clamp(static_cast<int>(std::floor(at)), first, first + s.cells - 1);
  }
  int other_at(Real at) const {
    const int first = s.row_at(at) * s.stride;
    return std::clamp(static_cast<int>(std::floor(x_ + at)), first, first + s.pieces - 1);
  }

  /// Psi and three derivatives of a mode at the middle of a cell.
  const Real* shape(int k, int cell) {
    if (k >= s.modes2) return s.of_slider(k, cell);
    know(cell);
    return &shape_[(static_cast<std::size_t>(cell) * s.modes + k) * 4];
  }
  /// u_1 + u_2 about a cell's middle; u_2 alone.
  const Polynomial& displacement(int cell) { return know(cell), u_[cell]; }
  const Polynomial& displacement2(int cell) { return know(cell), u2_[cell]; }

  Cubic passing(int own, int other) const { return s.other[other].about(x_ + own + 0.5L - other); }
  Polynomial overlap(int own, int other) {
    Polynomial o = displacement(own);
    const Cubic a = s.own[own].about(0.5L), b = passing(own, other);
    for (int p = 0; p < 4; ++p) o[p] += a.c[p] + b.c[p];
    return o;
  }
  /// Slope of h_2 + u_2, per chi.
  Polynomial slope2(int own, int other) {
    const Polynomial& u = displacement2(own);
    const Cubic b = passing(own, other);
    Polynomial out = u;
    for (int p = 0; p < 4; ++p) out[p] += b.c[p];
    return derivative(out);
  }

 private:
  const Scenery& s;
  const Real* amplitude_ = nullptr;
  Real x_ = 0;
  long stamp_ = 0;
  Numbers sin_, cos_, falling_, rising_;
  std::vector<long> stamps_;
  std::vector<Polynomial> u_, u2_;
  Numbers shape_;

  void know(int cell) {
    if (stamps_[cell] == stamp_) return;
    stamps_[cell] = stamp_;
    Polynomial &u = u_[cell], &u2 = u2_[cell];
    u = u2 = Polynomial{};
    u.terms = u2.terms = s.terms;
    for (int k = 0; k < s.modes2; ++k) {
      const int along = s.along(cell);
      const Real* w = s.waves(k, along);
      Real* base = &shape_[(static_cast<std::size_t>(cell) * s.modes + k) * 4];
      s.base(s.shapes[k], sin_[k] * w[0] + cos_[k] * w[1], cos_[k] * w[0] - sin_[k] * w[1],
             falling_[k] * w[2], rising_[k] * w[3], (s.base_node + x_ + along + 0.5L) * s.chi,
             base);
      for (int d = 0; d < 4; ++d) base[d] *= s.share_on(k, s.row_of(cell));
      add(u2, k, base);
    }
    u = u2;
    for (int k = s.modes2; k < s.modes; ++k) add(u, k, s.of_slider(k, cell));
  }
  void add(Polynomial& sum, int k, const Real* base) const {
    const Real* f = &s.factor[k * s.terms];
    for (int p = 0; p < s.terms; ++p) sum[p] += amplitude_[k] * f[p] * base[p % 4];
  }
};

/// The root of p, monotonic in between.
Real root_between(const Polynomial& p, Real low, Real high, bool rises) {
  Real x = 0.5L * (low + high);
  for (int round = 0; round < 200; ++round) {
    const Real v = value(p, x);
    ((v > 0) == rises ? high : low) = x;
    Real next = x - v / slope(p, x);
    if (!(next > low && next < high)) next = 0.5L * (low + high);
    if (std::abs(next - x) < 1e-19L || high - low < 1e-19L) return next;
    x = next;
  }
  return x;
}

/// Roots of p within (a, b), in ascending order, by those of its derivative.
void roots_of(const Polynomial& p, Real a, Real b, Numbers& out) {
  out.clear();
  if (p.terms < 2) return;
  const Polynomial d = derivative(p);
  // none where the value in the middle outweighs all changes
  const Real middle = 0.5L * (a + b), half = 0.5L * (b - a);
  const Real range = std::max(std::abs(a), std::abs(b));
  Real most = 0;
  for (int i = d.terms - 1; i >= 0; --i) most = most * range + std::abs(d[i]);
  if (std::abs(value(p, middle)) > most * half) return;
  Numbers edges;
  roots_of(d, a, b, edges);
  edges.insert(edges.begin(), a);
  edges.push_back(b);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    Real low = edges[i], high = edges[i + 1];
    const Real at_low = value(p, low), at_high = value(p, high);
    if ((at_low > 0) != (at_high > 0)) out.push_back(root_between(p, low, high, at_high > 0));
  }
}

/// All contact at a field, and its highest places that are open.
struct Contact {
  std::vector<Interval> intervals;
  Real highest_open = -std::numeric_limits<Real>::infinity();
  Real highest_at = 0;
};

/// An upper bound on the overlap in a cell.
Real bound_of(Field& f, int cell) {
  Real most = -std::numeric_limits<Real>::infinity();
  for (int side = 0; side < 2; ++side) {
    const int other = f.other_at(cell + (side == 0 ? 1e-12L : 1 - 1e-12L));
    const Polynomial o = f.overlap(cell, other);
    Real sum = o[0], power = 0.5L;
    for (int p = 1; p < o.terms; ++p, power *= 0.5L) sum += std::abs(o[p]) * power;
    most = std::max(most, sum);
  }
  return most;
}

Contact contact_of(const Scenery& s, Field& f, const std::vector<int>& cells) {
  Contact out;
  bool inside = false;
  int before = -2;
  Numbers summits;
  Interval open;
  const auto begin = [&](End e) { open = {e, {}, -1}, inside = true; };
  const auto finish = [&](End e) {
    open.right = e;
    out.intervals.push_back(open);
    inside = false;
  };
  for (const int i : cells) {
    if (i != before + 1 && inside) throw std::logic_error("contact leaves the list of cells");
    before = i;
    const int j0 = f.other_at(i);
    const bool is_first = s.along(i) == 0, is_last = s.along(i) == s.cells - 1;
    const Real knot = j0 + 1 - f.x() - i;  // from the cell's left node
    for (int side = 0; side < 2; ++side) {
      const Real a = side == 0 ? -0.5L : std::clamp<Real>(knot, 0, 1) - 0.5L;
      const Real b = side == 0 ? std::clamp<Real>(knot, 0, 1) - 0.5L : 0.5L;
      if (!(b > a)) continue;
      const int j = std::min(j0 + side, s.row_of(i) * s.stride + s.pieces - 1);
      const Polynomial o = f.overlap(i, j);
      if (is_first && side == 0 && value(o, a) > 0) begin({Real(i), i, j, true});
      roots_of(derivative(o), a, b, summits);
      summits.insert(summits.begin(), a);
      summits.push_back(b);
      for (std::size_t m = 0; m + 1 < summits.size(); ++m) {
        const Real from = summits[m], to = summits[m + 1], at_to = value(o, to);
        const bool last_of_slider = is_last && to == 0.5L;
        if (at_to <= 0 && at_to > out.highest_open &&
            (m + 2 < summits.size() ? curvature(o, to) < 0 : last_of_slider && slope(o, to) > 0)) {
          out.highest_open = at_to;
          out.highest_at = i + 0.5L + to;
        }
        if (is_first && side == 0 && m == 0 && value(o, from) <= 0 && slope(o, from) < 0 &&
            value(o, from) > out.highest_open) {
          out.highest_open = value(o, from);
          out.highest_at = i;
        }
        if ((at_to > 0) == inside) continue;
        const Real x = root_between(o, from, to, at_to > 0);
        const End e{i + 0.5L + x, i, j, false};
        inside ? finish(e) : begin(e);
      }
      if (is_last && b == 0.5L && inside) finish({Real(i + 1), i, j, true});
    }
  }
  if (inside) throw std::logic_error("contact leaves the list of cells");
  return out;
}

/// Follows a root of the piece's polynomial from where it was. `rises`: a left end. False where
/// there is none.
bool follow(const Polynomial& o, Real middle, bool rises, Real& at) {
  Real x = at - middle;
  for (int round = 0; round < 60; ++round) {
    const Real v = value(o, x), d = slope(o, x), c = curvature(o, x);
    const Real discriminant = d * d - 2 * v * c;
    Real step;
    if (discriminant < 0) {
      step = -d / c;  // to the summit
      if (std::abs(step) < 1e-12L) return at = middle + x, false;
    } else {
      const Real root = rises ? std::sqrt(discriminant) : -std::sqrt(discriminant);
      // of both zeros of the parabola that one whose slope has the right sign
      step = (d > 0) == rises ? -2 * v / (d + root) : (root - d) / c;
      if (d + root == 0 && (d > 0) == rises) step = 0;
    }
    step = std::clamp<Real>(step, -0.5L, 0.5L);
    if (!std::isfinite(step)) return false;
    x += step;
    if (std::abs(step) <= 1e-9L) break;  // of third order
  }
  at = middle + x;
  return std::abs(x) < 3;
}

class Solver {
 public:
  Solver(const Model& model, const ModalStart& start, const ReferenceOptions& options)
      : model_{model}, options_{options}, scenery_{model}, field_{scenery_}, end_field_{scenery_} {
    const int m = scenery_.modes;
    y_.assign(2 * m + 3, 0.0L);
    const auto put = [&](const std::vector<double>& u, const std::vector<double>& v, int first) {
      for (std::size_t k = 0; k < u.size(); ++k) {
        y_[first + k] = u[k];
        y_[m + first + k] = v[k];
      }
    };
    put(start.resonator_u, start.resonator_v, 0);
    put(start.slider_u, start.slider_v, scenery_.modes2);
    first_ = y_;
    Real contact = 0, fastest = 0;
    for (int k = 0; k < m; ++k) {
      contact += scenery_.spring * scenery_.largest[k] * scenery_.largest[k] / scenery_.mass[k];
      fastest = std::max(fastest, scenery_.omega[k]);
    }
    contact_omega_ = std::sqrt(contact);
    fastest = std::max(fastest, 0.005L * contact_omega_);
    longest_ = fastest > 0 ? options.longest / fastest : model.scene.duration;
    for (int r = 0; r < scenery_.rows; ++r)
      for (int i = 0; i < scenery_.cells; ++i) all_.push_back(r * scenery_.stride + i);
    if (scenery_.cells > 0) {
      end_field_.set(0, y_.data());
      intervals_ = contact_of(scenery_, end_field_, all_).intervals;
      update_shocks();
    }
    // from rest, errors count against a motion of a ten thousandth of the faces' heights
    Real least = 0;
    for (int k = 0; k < m; ++k)
      least = std::max(least, std::sqrt(scenery_.mass[k]) / scenery_.largest[k] * fastest);
    most_ = std::max(norm(y_), 1e-4L * heights(model) * least);
  }

  Reference run(const std::vector<double>& times) {
    h_ = longest_;
    for (const double t : times) {
      while (time_ < t) advance(t);
      out_.states.push_back(state());
    }
    for (int i = 0; i < static_cast<int>(shocks_.size()); ++i)
      if (shocks_[i].is_open) finish_shock(i, true);
    std::sort(out_.shocks.begin(), out_.shocks.end(),
              [](const ReferenceShock& a, const ReferenceShock& b) { return a.start < b.start; });
    return out_;
  }

 private:
  struct OpenShock {
    Real start = 0, peak = 0;
    bool is_open = true;
    int slot = 0;  // of y_: impulse, then moment
  };

  const Model& model_;
  ReferenceOptions options_;
  Scenery scenery_;
  Field field_, end_field_;
  GaussRule gauss_{scenery_.terms};
  std::vector<int> all_, near_;
  Numbers y_, first_, bounds_;
  Real time_ = 0, h_ = 0, longest_ = 0, contact_omega_ = 0, most_ = 0;
  std::vector<Interval> intervals_;
  bool is_kink_ = false;  // a piece of contact began or parted where this step starts
  std::vector<OpenShock> shocks_;
  Reference out_;

  /// Of both faces together, from the lowest to the highest [m].
  static Real heights(const Model& model) {
    Real sum = 0;
    for (const SharedNumbers* face : {&model.resonator_height, &model.slider_height})
      sum += *std::max_element(face->begin(), face->end()) -
             *std::min_element(face->begin(), face->end());
    return sum;
  }

  // ---- equations

  struct Sums {
    Real force = 0, energy = 0;
    Numbers of_shock;  // N
  };

  /// The contact of intervals whose ends are followed from where they were.
  template <class Add>
  void integrate(Field& f, std::vector<Interval>& intervals, const Add& add) {
    for (Interval& c : intervals) {
      bool closed = true;
      for (End* e : {&c.left, &c.right})
        if (!e->of_slider)
          closed =
              follow(f.overlap(e->own, e->other), e->own + 0.5L, e == &c.left, e->at) && closed;
      if (!closed || !(c.right.at > c.left.at)) continue;
      // through the pieces; an end that has just left its own counts beyond it, with a minus
      Real from = c.left.at;
      int i = c.left.own, j = c.left.other;
      for (;;) {
        const Real node = i < c.right.own ? Real(i + 1) : std::numeric_limits<Real>::infinity();
        const Real knot = j < c.right.other ? j + 1 - f.x() : std::numeric_limits<Real>::infinity();
        const Real to = std::min({node, knot, std::numeric_limits<Real>::infinity()});
        const bool last = std::isinf(to);
        const Real until = last ? c.right.at : to;
        const Polynomial o = f.overlap(i, j), slope2 = f.slope2(i, j);
        const Real middle = 0.5L * (from + until) - (i + 0.5L), half = 0.5L * (until - from);
        for (int g = 0; g < gauss_.points; ++g) {
          const Real x = middle + half * gauss_.at[g];
          add(c, i, x, value(o, x), value(slope2, x), half * gauss_.weight[g]);
        }
        if (last) break;
        from = to;
        node <= knot ? ++i : ++j;
      }
    }
  }

  /// dy/dt; the ends of `intervals` are moved.
  void rate(Real t, const Numbers& y, std::vector<Interval>& intervals, Numbers& out) {
    ++out_.evaluations;
    const int m = scenery_.modes;
    out.assign(y.size(), 0.0L);
    for (int k = 0; k < m; ++k) {
      const Real v = y[m + k], w = scenery_.omega[k];
      out[k] = v;
      out[m + k] =
          scenery_.load[k] / scenery_.mass[k] - 2 * scenery_.zeta[k] * w * v - w * w * y[k];
      out[2 * m] += 2 * scenery_.zeta[k] * w * scenery_.mass[k] * v * v;
    }
    for (const MovingForce& force : scenery_.forces) {
      const Real x = force.start + static_cast<Real>(force.speed) * t;
      if (!(x >= 0 && x <= scenery_.length2)) continue;
      for (int k = 0; k < scenery_.modes2; ++k) {
        Real psi[4];
        const Shape& shape = scenery_.shapes[k];
        const Real phase = shape.beta * x;
        scenery_.base(shape, std::sin(phase), std::cos(phase), std::exp(-phase),
                      std::exp(shape.beta * (x - shape.length)), x, psi);
        out[m + k] += force.force * psi[0] / scenery_.mass[k];
        out[2 * m + 2] += force.force * psi[0] * y[m + k];
      }
    }
    if (intervals.empty()) return;
    field_.set(t, y.data());
    moments_.assign(static_cast<std::size_t>(scenery_.length()), Polynomial{});
    touched_.clear();
    integrate(field_, intervals,
              [&](const Interval& c, int cell, Real x, Real o, Real slope2, Real weight) {
                if (touched_.empty() || touched_.back() != cell)
                  if (std::find(touched_.begin(), touched_.end(), cell) == touched_.end())
                    touched_.push_back(cell);
                Real part = weight * o * scenery_.spring;
                out[2 * m + 1] += part * slope2 * scenery_.speed;
                if (c.shock >= 0) {
                  const int slot = shocks_[c.shock].slot;
                  out[slot] += part;
                  out[slot + 1] +=
                      part * (scenery_.base_node + field_.x() + scenery_.along(cell) + 0.5L + x);
                }
                Polynomial& moment = moments_[cell];
                for (int p = 0; p < scenery_.terms; ++p, part *= x) moment[p] += part;
              });
    for (const int cell : touched_)
      for (int k = 0; k < m; ++k) {
        const Real* base = field_.shape(k, cell);
        const Real* f = &scenery_.factor[k * scenery_.terms];
        Real sum = 0;
        for (int p = 0; p < scenery_.terms; ++p) sum += moments_[cell][p] * f[p] * base[p % 4];
        out[m + k] -= sum / scenery_.mass[k];
      }
  }
  std::vector<Polynomial> moments_;
  std::vector<int> touched_;

  Sums sums(Real t, const Numbers& y, std::vector<Interval> intervals) {
    Sums out;
    out.of_shock.assign(shocks_.size(), 0.0L);
    if (intervals.empty()) return out;
    field_.set(t, y.data());
    integrate(field_, intervals, [&](const Interval& c, int, Real, Real o, Real, Real weight) {
      out.force += weight * o * scenery_.spring;
      out.energy += 0.5L * weight * o * o * scenery_.spring;
      if (c.shock >= 0) out.of_shock[c.shock] += weight * o * scenery_.spring;
    });
    return out;
  }

  // ---- a step in time

  /// In the energy's norm; displacements count by the contact's frequency, too.
  Real norm(const Numbers& y) const {
    Real sum = 0;
    for (int k = 0; k < scenery_.modes; ++k) {
      const Real w = std::max(scenery_.omega[k], contact_omega_);
      sum +=
          scenery_.mass[k] * (y[scenery_.modes + k] * y[scenery_.modes + k] + w * w * y[k] * y[k]);
    }
    return std::sqrt(sum);
  }

  static constexpr int columns = 8;

  /// From time_ to `until`. `graded`: time goes as a square from both ends. Returns the error.
  Real solve(Real until, bool graded, Numbers& y) {
    const Real h = until - time_;
    std::array<Numbers, columns> table;
    Numbers before, now, next, slope;
    Real error = 0;
    const auto f = [&](Real x, const Numbers& at, std::vector<Interval>& ends) {
      const Real t = graded ? time_ + h * x * x * (3 - 2 * x) : time_ + h * x;
      rate(t, at, ends, slope);
      const Real speed = graded ? 6 * h * x * (1 - x) : h;
      for (Real& v : slope) v *= speed;
    };
    for (int c = 0; c < columns; ++c) {
      const int n = 2 * (c + 1);
      const Real step = 1.0L / n;
      std::vector<Interval> ends = intervals_;
      before = y_;
      now = y_;
      f(0, y_, ends);
      for (std::size_t i = 0; i < y_.size(); ++i) now[i] += step * slope[i];
      for (int q = 1; q < n; ++q) {
        f(q * step, now, ends);
        next = before;
        for (std::size_t i = 0; i < y_.size(); ++i) next[i] += 2 * step * slope[i];
        before.swap(now);
        now.swap(next);
      }
      f(1, now, ends);
      for (std::size_t i = 0; i < y_.size(); ++i)
        now[i] = 0.5L * (now[i] + before[i] + step * slope[i]);
      // extrapolated to steps of no length
      Numbers newest = now, old;
      for (int q = 0; q < c; ++q) {
        const Real ratio = Real(n) / (2 * (c - q)), share = 1 / (ratio * ratio - 1);
        old = newest;
        for (std::size_t i = 0; i < y_.size(); ++i)
          newest[i] = newest[i] + (newest[i] - table[q][i]) * share;
        table[q] = old;
        if (c == columns - 1 && q == c - 1) {
          Numbers difference = newest;
          for (std::size_t i = 0; i < y_.size(); ++i) difference[i] -= old[i];
          error = norm(difference);
        }
      }
      table[c] = newest;
    }
    y = table[columns - 1];
    return error > 0 ? error / std::max(most_, norm(y)) : error;
  }

  /// Displacements in between: the polynomial of fifth degree through U, U' and U'' at both ends.
  struct Between {
    Real from, h;
    Numbers u0, v0, a0, u1, v1, a1;
    void operator()(Real share, Numbers& u) const {
      const Real x = share, x2 = x * x, x3 = x2 * x, x4 = x3 * x, x5 = x4 * x;
      const Real p0 = 1 - 10 * x3 + 15 * x4 - 6 * x5, q0 = x - 6 * x3 + 8 * x4 - 3 * x5,
                 r0 = 0.5L * (x2 - 3 * x3 + 3 * x4 - x5), p1 = 10 * x3 - 15 * x4 + 6 * x5,
                 q1 = -4 * x3 + 7 * x4 - 3 * x5, r1 = 0.5L * (x3 - 2 * x4 + x5);
      u.resize(u0.size());
      for (std::size_t k = 0; k < u0.size(); ++k)
        u[k] = p0 * u0[k] + h * q0 * v0[k] + h * h * r0 * a0[k] + p1 * u1[k] + h * q1 * v1[k] +
               h * h * r1 * a1[k];
    }
  };

  Between between(Real until, const Numbers& y1) {
    const int m = scenery_.modes;
    Between b;
    b.from = time_;
    b.h = until - time_;
    Numbers slope;
    std::vector<Interval> ends = intervals_;
    rate(time_, y_, ends, slope);
    b.u0.assign(y_.begin(), y_.begin() + m);
    b.v0.assign(y_.begin() + m, y_.begin() + 2 * m);
    b.a0.assign(slope.begin() + m, slope.begin() + 2 * m);
    ends = intervals_;
    // in two halves, so that an end is followed over a long step
    rate(until, y1, ends, slope);
    b.u1.assign(y1.begin(), y1.begin() + m);
    b.v1.assign(y1.begin() + m, y1.begin() + 2 * m);
    b.a1.assign(slope.begin() + m, slope.begin() + 2 * m);
    return b;
  }

  // ---- events

  enum class Event { none, passes, topology };

  static constexpr Real overshoot = 1e-6L;  // chi, of an end beyond a node

  /// Whether contact at this field is that of the intervals followed there.
  Event check(Field& f, std::vector<Interval>& ends, Contact& contact, Real beyond) {
    bool closed = true, within = true;
    for (Interval& c : ends) {
      for (End* e : {&c.left, &c.right}) {
        if (!e->of_slider)
          closed =
              follow(f.overlap(e->own, e->other), e->own + 0.5L, e == &c.left, e->at) && closed;
        const Real knot = e->other - f.x();
        within = within && e->at >= e->own - beyond && e->at <= e->own + 1 + beyond &&
                 e->at >= knot - beyond && e->at <= knot + 1 + beyond;
      }
    }
    contact = contact_of(scenery_, f, near_);
    if (!within) {
      // is it only that?
      if (closed && contact.intervals.size() == ends.size()) return Event::passes;
      return Event::topology;
    }
    if (!closed || contact.intervals.size() != ends.size()) return Event::topology;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const Interval &a = ends[i], &b = contact.intervals[i];
      if (std::abs(a.left.at - b.left.at) > 1e-3L || std::abs(a.right.at - b.right.at) > 1e-3L ||
          a.left.of_slider != b.left.of_slider || a.right.of_slider != b.right.of_slider)
        return Event::topology;
    }
    return Event::none;
  }

  /// Cells that can come into contact until a time from now on.
  void find_near(Real h) {
    const int m = scenery_.modes;
    Real speed = scenery_.speed * scenery_.steepest_face;
    for (int k = 0; k < m; ++k) {
      const Real largest_rate = std::hypot(y_[m + k], scenery_.omega[k] * y_[k]);
      speed += 2 * largest_rate * scenery_.largest[k];
      if (k < scenery_.modes2) speed += scenery_.speed * std::abs(y_[k]) * scenery_.steepest[k];
    }
    const Real range = 1.5L * h * speed + 1e-16L;
    near_.clear();
    end_field_.set(time_, y_.data());
    std::vector<char> is_near(scenery_.length() + 1, 0);
    for (const int i : all_) is_near[i] = bound_of(end_field_, i) + range > 0;
    for (const Interval& c : intervals_)
      for (int i = std::max(0, c.left.own - 1); i <= c.right.own + 1; ++i) is_near[i] = 1;
    for (const int i : all_)
      if (is_near[i]) near_.push_back(i);
  }

  /// The rate of the overlap at a place of the slider.
  Real rate_at(Field& f, const Numbers& y, Real at) {
    const int i = f.own_at(at), j = f.other_at(at);
    const Real x = at - (i + 0.5L);
    Real sum = scenery_.speed * value(f.slope2(i, j), x);
    for (int k = 0; k < scenery_.modes; ++k) {
      const Real* base = f.shape(k, i);
      Real psi = 0, power = 1;
      for (int p = 0; p < scenery_.terms; ++p, power *= x)
        psi += scenery_.factor[k * scenery_.terms + p] * base[p % 4] * power;
      sum += y[scenery_.modes + k] * psi;
    }
    return sum;
  }
  Real overlap_at(Field& f, Real at) {
    const int i = f.own_at(at);
    return value(f.overlap(i, f.other_at(at)), at - (i + 0.5L));
  }
  /// The extremum of the overlap next to a place.
  Real extremum(Field& f, Real at) {
    const Real first = scenery_.row_start(at), end = scenery_.row_end(at);
    if (at <= first || at >= end) return at;
    for (int round = 0; round < 60; ++round) {
      const int i = f.own_at(at);
      const Polynomial o = f.overlap(i, f.other_at(at));
      const Real x = at - (i + 0.5L);
      const Real step = std::clamp<Real>(-slope(o, x) / curvature(o, x), -0.1L, 0.1L);
      at = std::clamp<Real>(at + step, first, end);
      if (std::abs(step) < 1e-17L) break;
    }
    return at;
  }

  /// How soon an end of contact passes a node, about.
  Real time_to_node() {
    Real soonest = std::numeric_limits<Real>::infinity();
    if (intervals_.empty()) return soonest;
    Field& f = end_field_;
    f.set(time_, y_.data());
    for (const Interval& c : intervals_)
      for (const End* e : {&c.left, &c.right})
        for (int side = 0; side < 2; ++side) {
          const Real node = e->own + side, knot = e->other + side - f.x();
          for (const Real at : {node, knot}) {
            if (at < scenery_.row_start(e->own) || at > scenery_.row_end(e->own) ||
                std::abs(at - e->at) < 1e-9L)
              continue;
            const Real o = overlap_at(f, at);
            Real speed = rate_at(f, y_, at);
            if (at == knot) {
              const int i = f.own_at(at);
              speed -= scenery_.speed * slope(f.overlap(i, f.other_at(at)), at - (i + 0.5L));
            }
            const Real t = -o / speed;
            if (t > 0) soonest = std::min(soonest, t);
          }
        }
    return soonest;
  }

  /// A step, at most to `limit`.
  void advance(Real limit) {
    Real until = std::min(limit, time_ + std::min({h_, longest_, 1.05L * time_to_node()}));
    if (until > limit - 1e-3L * (limit - time_)) until = limit;
    if (scenery_.cells > 0) find_near(until - time_);
    const Real tolerance = options_.tolerance;
    for (int attempt = 0; attempt < 200; ++attempt) {
      Numbers y;
      const bool graded = is_kink_;
      const Real error = solve(until, graded, y);
      const Real growth =
          0.9L * std::pow(tolerance / std::max(error, 1e-3L * tolerance), 1.0L / (2 * columns - 1));
      const Real next = (until - time_) * std::clamp<Real>(growth, 0.3L, 3.0L);
      const bool exact = error <= tolerance || until - time_ <= 1e-14L * longest_;
      const auto shorten = [&](Real share) { until = time_ + share * (until - time_); };
      if (scenery_.cells == 0 && exact) return accept(until, y, next, limit);
      if (scenery_.cells == 0) {
        shorten(std::clamp<Real>(growth, 0.1L, 0.7L));
        continue;
      }
      const Between path = between(until, y);
      Real good = 0, bad = 0;
      Contact seen;
      const Event event = first_event(path, good, bad, seen);
      if (event == Event::none) {
        if (!exact) {
          shorten(std::clamp<Real>(growth, 0.1L, 0.7L));
          continue;
        }
        take_peaks(path, until);
        return accept(until, y, next, limit);
      }
      ++out_.events;
      if (event == Event::passes) {
        until = time_ + bad * path.h;
        Numbers there;
        if (!(solve(until, graded, there) <= tolerance) && until - time_ > 1e-14L * longest_) {
          shorten(0.5L);
          continue;
        }
        end_field_.set(until, there.data());
        std::vector<Interval> ends = intervals_;
        follow_along(path, bad, ends);
        Contact contact;
        if (check(end_field_, ends, contact, 20 * overshoot) != Event::none) {
          shorten(0.7L);  // too long to say where it ends
          continue;
        }
        take_peaks(path, until);
        accept(until, there, next, limit);
        // on in the pieces that the ends are in now
        for (std::size_t i = 0; i < intervals_.size(); ++i) {
          const int shock = intervals_[i].shock;
          intervals_[i] = contact.intervals[i];
          intervals_[i].shock = shock;
        }
        update_shocks();
        return;
      }
      if (land(path, good, bad, seen, limit)) return;
      shorten(0.5L);
    }
    throw std::logic_error("reference: no step ends");
  }

  /// Moves ends along a path up to a share of it.
  void follow_along(const Between& path, Real share, std::vector<Interval>& ends) {
    Numbers u;
    constexpr int parts = 16;
    for (int q = 1; q <= parts; ++q) {
      // slowly at first: a new piece of contact grows with the root of time
      const Real x = share * q * q / (parts * parts);
      path(x, u);
      field_.set(path.from + x * path.h, u.data());
      for (Interval& c : ends)
        for (End* e : {&c.left, &c.right})
          if (!e->of_slider)
            follow(field_.overlap(e->own, e->other), e->own + 0.5L, e == &c.left, e->at);
    }
  }

  /// The first share of a step at which contact is no longer that of its start, between `good` and
  /// `bad`.
  Event first_event(const Between& path, Real& good, Real& bad, Contact& seen) {
    constexpr int samples = 12;
    Numbers u;
    std::vector<Interval> ends = intervals_, at_good = ends;
    Field& f = end_field_;
    const auto evaluate = [&](Real share, std::vector<Interval>& from, Contact& contact) {
      path(share, u);
      f.set(path.from + share * path.h, u.data());
      return check(f, from, contact, overshoot);
    };
    Event event = Event::none;
    good = 0;
    std::array<Real, 3> open{}, at{};
    for (int q = 1; q <= samples; ++q) {
      const Real share = Real(q) * q / (samples * samples);
      std::vector<Interval> trial = at_good;
      event = evaluate(share, trial, seen);
      if (event != Event::none) {
        bad = share;
        break;
      }
      at_good = trial;
      // does a summit come and go in between?
      open = {open[1], open[2], seen.highest_open};
      at = {at[1], at[2], share};
      if (q >= 3 && open[1] >= open[0] && open[1] >= open[2] &&
          open[1] + std::abs(open[0] - 2 * open[1] + open[2]) > 0) {
        Real a = at[0], b = at[2];
        for (int round = 0; round < 40 && event == Event::none; ++round) {
          const Real x = a + 0.382L * (b - a), z = a + 0.618L * (b - a);
          Contact at_x, at_z;
          std::vector<Interval> followed = intervals_;
          follow_along(path, x, followed);
          const Event in_x = evaluate(x, followed, at_x);
          if (in_x != Event::none) {
            event = in_x;
            bad = x;
            seen = at_x;
            good = at[0];
            break;
          }
          followed = intervals_;
          follow_along(path, z, followed);
          const Event in_z = evaluate(z, followed, at_z);
          if (in_z != Event::none) {
            event = in_z;
            bad = z;
            seen = at_z;
            good = at[0];
            break;
          }
          (at_x.highest_open > at_z.highest_open ? b : a) =
              at_x.highest_open > at_z.highest_open ? z : x;
        }
        if (event != Event::none) {
          at_good = intervals_;
          follow_along(path, good, at_good);
          break;
        }
      }
      good = share;
    }
    if (event == Event::none) return event;
    for (int round = 0; round < 60 && bad - good > 1e-15L; ++round) {
      const Real middle = 0.5L * (good + bad);
      std::vector<Interval> trial = at_good;
      Contact contact;
      const Event here = evaluate(middle, trial, contact);
      if (here == Event::none) {
        good = middle;
        at_good = trial;
      } else {
        bad = middle;
        event = here;
        seen = contact;
      }
    }
    return event;
  }

  /// Ends the step where a piece of contact begins, ends, parts, or meets another.
  bool land(const Between& path, Real good, Real bad, const Contact& seen, Real limit) {
    // where, along the slider: what is there on one side only
    std::vector<Interval> before = intervals_;
    follow_along(path, good, before);
    const std::vector<Interval>& after = seen.intervals;
    enum { begins, ends, parts, meets } kind;
    std::size_t which = 0;
    Real at = 0;
    if (after.size() == before.size() + 1) {
      while (which < before.size() && overlaps(before[which], after[which]) &&
             !(which + 1 < after.size() && overlaps(before[which], after[which + 1])))
        ++which;
      if (which < before.size() && which + 1 < after.size() &&
          overlaps(before[which], after[which]) && overlaps(before[which], after[which + 1])) {
        kind = parts;
        at = 0.5L * (after[which].right.at + after[which + 1].left.at);
      } else {
        kind = begins;
        const Interval& c = after[which];
        at = c.left.of_slider    ? c.left.at
             : c.right.of_slider ? c.right.at
                                 : 0.5L * (c.left.at + c.right.at);
      }
    } else if (after.size() + 1 == before.size()) {
      while (which < after.size() && overlaps(before[which], after[which]) &&
             !(which + 1 < before.size() && overlaps(before[which + 1], after[which])))
        ++which;
      if (which < after.size() && which + 1 < before.size() &&
          overlaps(before[which], after[which]) && overlaps(before[which + 1], after[which])) {
        kind = meets;
        at = 0.5L * (before[which].right.at + before[which + 1].left.at);
      } else {
        kind = ends;
        const Interval& c = before[which];
        at = c.left.of_slider    ? c.left.at
             : c.right.of_slider ? c.right.at
                                 : 0.5L * (c.left.at + c.right.at);
      }
    } else if (after.size() == before.size()) {
      return land_at_end(path, good, bad, limit);
    } else {
      return false;  // several at once: a shorter step
    }
    const bool graded = is_kink_ || kind == ends || kind == meets;
    Real until = time_ + 0.5L * (good + bad) * path.h;
    Numbers y;
    Real change = 0, error = 0;
    for (int round = 0; round < 12; ++round) {
      error = solve(until, graded, y);
      if (!(error <= 1e3L * options_.tolerance) && round > 1) return false;
      end_field_.set(until, y.data());
      at = extremum(end_field_, at);
      change = overlap_at(end_field_, at) / rate_at(end_field_, y, at);
      if (!std::isfinite(change)) return false;
      if (std::abs(change) <= 1e-17L * longest_ || until + 1e-18L * longest_ == until) break;
      const Real to = until - change;
      if (!(to > time_ && to < time_ + 1.5L * path.h)) return false;
      until = to;
    }
    if (std::abs(change) > 1e-12L * longest_ || !(error <= options_.tolerance)) return false;
    if (until > limit) return false;
    take_peaks(path, until);
    std::vector<Interval> next_intervals = before;
    end_field_.set(until, y.data());
    const int own = end_field_.own_at(at), other = end_field_.other_at(at);
    const End here{at, own, other, false};
    accept(until, y, 0.5L * longest_, limit);
    // all other ends where they are now
    for (Interval& c : next_intervals)
      for (End* e : {&c.left, &c.right})
        if (!e->of_slider)
          follow(end_field_.overlap(e->own, e->other), e->own + 0.5L, e == &c.left, e->at);
    const auto place = next_intervals.begin() + static_cast<std::ptrdiff_t>(which);
    switch (kind) {
      case begins: {
        Interval fresh{here, here, -1};
        if (at <= scenery_.row_start(own)) fresh.left = {Real(own), own, other, true};
        if (at >= scenery_.row_end(own)) fresh.right = {Real(own + 1), own, other, true};
        next_intervals.insert(place, fresh);
        is_kink_ = true;
        break;
      }
      case ends:
        next_intervals.erase(place);
        break;
      case parts: {
        Interval second = *place;
        place->right = here;
        second.left = here;
        next_intervals.insert(place + 1, second);
        is_kink_ = true;
        break;
      }
      case meets:
        place->right = (place + 1)->right;
        next_intervals.erase(place + 1);
        break;
    }
    intervals_ = next_intervals;
    update_shocks();
    return true;
  }

  /// An end of contact reaches or leaves an end of the slider.
  bool land_at_end(const Between& path, Real good, Real bad, Real limit) {
    const Real until = time_ + bad * path.h;
    if (until > limit) return false;
    if (path.h > 1e-7L * longest_ && bad > 1e-6L) {
      // close in, so that what lies between the end and the step's is nothing
      Numbers y;
      const Real to = time_ + good * path.h;
      solve(to, is_kink_, y);
      take_peaks(path, to);
      std::vector<Interval> ends = intervals_;
      follow_along(path, good, ends);
      accept(to, y, 1e-9L * longest_, limit);
      intervals_ = ends;
      return true;
    }
    Numbers y;
    solve(until, is_kink_, y);
    end_field_.set(until, y.data());
    const Contact contact = contact_of(scenery_, end_field_, near_);
    if (contact.intervals.size() != intervals_.size()) return false;
    accept(until, y, 1e-3L * longest_, limit);
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      const int shock = intervals_[i].shock;
      intervals_[i] = contact.intervals[i];
      intervals_[i].shock = shock;
    }
    update_shocks();
    return true;
  }

  static bool overlaps(const Interval& a, const Interval& b) {
    return a.left.at <= b.right.at && b.left.at <= a.right.at;
  }

  void accept(Real until, const Numbers& y, Real next, Real limit) {
    ++out_.steps;
    const bool was_cut = until >= limit;
    // the ends of contact, for the next step
    if (scenery_.cells > 0 && !intervals_.empty()) {
      Numbers middle(y_.begin(), y_.begin() + scenery_.modes);
      constexpr int parts = 8;
      const Numbers old = middle;
      Between path = between(until, y);
      for (int q = 1; q <= parts; ++q) {
        const Real x = Real(q) * q / (parts * parts);
        path(x, middle);
        field_.set(time_ + x * path.h, middle.data());
        for (Interval& c : intervals_)
          for (End* e : {&c.left, &c.right})
            if (!e->of_slider)
              follow(field_.overlap(e->own, e->other), e->own + 0.5L, e == &c.left, e->at);
      }
    }
    y_ = y;
    time_ = until;
    is_kink_ = false;
    if (!was_cut || next < h_) h_ = std::min(next, longest_);
    if (!(h_ > 0)) h_ = longest_;
    most_ = std::max(most_, norm(y_));
  }

  // ---- shocks

  /// Whether pieces of contact are in the same cell or in neighbours, of one row or two.
  bool are_neighbours(const Interval& a, const Interval& b) const {
    const Scenery& s = scenery_;
    return std::abs(s.row_of(a.left.own) - s.row_of(b.left.own)) <= 1 &&
           s.along(a.left.own) <= s.along(b.right.own) + 1 &&
           s.along(b.left.own) <= s.along(a.right.own) + 1;
  }
  /// Neighbours are one shock.
  void update_shocks() {
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      Interval& c = intervals_[i];
      for (const Interval& other : intervals_) {
        if (&other == &c || other.shock < 0 || !are_neighbours(c, other)) continue;
        if (c.shock >= 0 && c.shock != other.shock) join(other.shock, c.shock, intervals_);
        c.shock = other.shock;
      }
      if (c.shock < 0) {
        c.shock = static_cast<int>(shocks_.size());
        shocks_.push_back({time_, 0, true, static_cast<int>(y_.size())});
        y_.push_back(0);
        y_.push_back(0);
      }
    }
    for (int i = 0; i < static_cast<int>(shocks_.size()); ++i) {
      if (!shocks_[i].is_open) continue;
      const bool lives = std::any_of(intervals_.begin(), intervals_.end(),
                                     [&](const Interval& c) { return c.shock == i; });
      if (!lives) finish_shock(i, false);
    }
    compact();
  }
  /// The older takes over.
  void join(int a, int b, std::vector<Interval>& intervals) {
    const int keep = shocks_[a].start <= shocks_[b].start ? a : b, drop = a + b - keep;
    for (int q = 0; q < 2; ++q) y_[shocks_[keep].slot + q] += y_[shocks_[drop].slot + q];
    shocks_[keep].peak = std::max(shocks_[keep].peak, shocks_[drop].peak);
    shocks_[drop].is_open = false;
    for (Interval& c : intervals)
      if (c.shock == drop) c.shock = keep;
  }
  void finish_shock(int i, bool is_open) {
    OpenShock& shock = shocks_[i];
    shock.is_open = false;
    const Real impulse = y_[shock.slot];
    ReferenceShock out;
    out.start = static_cast<double>(shock.start);
    out.end = static_cast<double>(time_);
    out.impulse = static_cast<double>(impulse);
    out.peak = static_cast<double>(shock.peak);
    out.centre = static_cast<double>(y_[shock.slot + 1] / impulse * scenery_.chi);
    out.is_open = is_open;
    out_.shocks.push_back(out);
  }
  /// Without the shocks that have ended.
  void compact() {
    std::vector<OpenShock> open;
    std::vector<int> number(shocks_.size(), -1);
    Numbers y(y_.begin(), y_.begin() + 2 * scenery_.modes + 3);
    for (std::size_t i = 0; i < shocks_.size(); ++i) {
      if (!shocks_[i].is_open) continue;
      number[i] = static_cast<int>(open.size());
      open.push_back(shocks_[i]);
      open.back().slot = static_cast<int>(y.size());
      y.push_back(y_[shocks_[i].slot]);
      y.push_back(y_[shocks_[i].slot + 1]);
    }
    for (Interval& c : intervals_) c.shock = number[c.shock];
    shocks_ = open;
    y_ = y;
  }
  /// The largest forces of a step that is about to be accepted.
  void take_peaks(const Between& path, Real until) {
    if (shocks_.empty()) return;
    const Real whole = (until - time_) / path.h;
    constexpr int samples = 6;
    const auto force = [&](Real share) {
      std::vector<Interval> ends = intervals_;
      follow_along(path, share, ends);
      Numbers u;
      path(share, u);
      return sums(path.from + share * path.h, u, ends).of_shock;
    };
    std::vector<Numbers> at;
    for (int q = 0; q <= samples; ++q) at.push_back(force(whole * q / samples));
    for (std::size_t i = 0; i < shocks_.size(); ++i) {
      int best = 0;
      for (int q = 1; q <= samples; ++q)
        if (at[q][i] > at[best][i]) best = q;
      Real& peak = shocks_[i].peak;
      peak = std::max({peak, at[0][i], at[samples][i]});
      if (best == 0 || best == samples || at[best][i] < 0.99L * peak) continue;
      Real a = whole * (best - 1) / samples, b = whole * (best + 1) / samples;
      for (int round = 0; round < 20; ++round) {
        const Real x = a + 0.382L * (b - a), z = a + 0.618L * (b - a);
        const Real at_x = force(x)[i], at_z = force(z)[i];
        peak = std::max({peak, at_x, at_z});
        (at_x > at_z ? b : a) = at_x > at_z ? z : x;
      }
    }
  }

  ReferenceState state() {
    const int m = scenery_.modes;
    ReferenceState out;
    out.time = static_cast<double>(time_);
    Real kinetic = 0, elastic = 0, load = y_[2 * m + 2];
    for (int k = 0; k < m; ++k) {
      const Real u = y_[k], v = y_[m + k];
      (k < scenery_.modes2 ? out.resonator_u : out.slider_u).push_back(static_cast<double>(u));
      (k < scenery_.modes2 ? out.resonator_v : out.slider_v).push_back(static_cast<double>(v));
      kinetic += 0.5L * scenery_.mass[k] * v * v;
      elastic += 0.5L * scenery_.mass[k] * scenery_.omega[k] * scenery_.omega[k] * u * u;
      load += scenery_.load[k] * (u - first_[k]);
    }
    const Sums now = sums(time_, y_, intervals_);
    out.force = static_cast<double>(now.force);
    out.contact = static_cast<double>(now.energy);
    out.kinetic = static_cast<double>(kinetic);
    out.elastic = static_cast<double>(elastic);
    out.damping_loss = static_cast<double>(y_[2 * m]);
    out.sliding_work = static_cast<double>(y_[2 * m + 1]);
    out.load_work = static_cast<double>(load);
    return out;
  }
};

}  // namespace

Reference smooth_reference(const Model& model, const ModalStart& start,
                           const std::vector<double>& times, const ReferenceOptions& options) {
  return Solver(model, start, options).run(times);
}

}  // namespace ra2d::test
