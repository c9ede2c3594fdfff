// SPDX-License-Identifier: BSD-3-Clause
#include "tests/areal_reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace ra2d::test {
namespace {

using Real = long double;
using Numbers = std::vector<Real>;

constexpr Real pi = std::numbers::pi_v<Real>;
constexpr Real never = std::numeric_limits<Real>::infinity();
constexpr Real rounding = std::numeric_limits<Real>::epsilon();

// ---- polynomials on [0, 1]

Real value(const Numbers& p, Real x) {
  Real sum = 0;
  for (std::size_t i = p.size(); i-- > 0;) sum = sum * x + p[i];
  return sum;
}
Numbers derivative(const Numbers& p) {
  Numbers d;
  for (std::size_t i = 1; i < p.size(); ++i) d.push_back(static_cast<Real>(i) * p[i]);
  return d;
}
Real integral(const Numbers& p, Real to) {
  Real sum = 0;
  for (std::size_t i = p.size(); i-- > 0;) sum = sum * to + p[i] / static_cast<Real>(i + 1);
  return sum * to;
}

/// The root of p between a and b, where it changes its sign.
Real root_between(const Numbers& p, Real a, Real b) {
  const Numbers slope = derivative(p);
  const bool rises = value(p, b) > 0;
  Real x = 0.5L * (a + b);
  for (int round = 0; round < 200; ++round) {
    const Real v = value(p, x);
    ((v > 0) == rises ? b : a) = x;
    Real next = x - v / value(slope, x);
    if (!(next > a && next < b)) next = 0.5L * (a + b);
    if (std::abs(next - x) <= 0.25L * rounding * x || next == a || next == b) return next;
    x = next;
  }
  return x;
}

/// Where p changes its sign in (a, b], in ascending order: parts on which the series about the
/// middle proves that p has no root, or that it is monotonic; others are halved.
void sign_changes(const Numbers& p, Real a, Real b, Numbers& out) {
  const Real middle = 0.5L * (a + b), half = 0.5L * (b - a);
  Numbers about = p;
  for (std::size_t m = 0; m < p.size(); ++m)
    for (std::size_t i = p.size() - 1; i-- > m;) about[i] += middle * about[i + 1];
  Real change = 0, slope_change = 0, power = 1;  // of p over this part; of its slope
  for (std::size_t i = 1; i < p.size(); ++i, power *= half) {
    change += std::abs(about[i]) * power * half;
    if (i > 1) slope_change += static_cast<Real>(i) * std::abs(about[i]) * power;
  }
  if (std::abs(about[0]) > change || change == 0) return;
  if (p.size() > 1 && std::abs(about[1]) > slope_change) {
    if ((value(p, a) > 0) != (value(p, b) > 0)) out.push_back(root_between(p, a, b));
    return;
  }
  if (half < 1e-16L) return;  // touches zero, to within roundings
  sign_changes(p, a, middle, out);
  sign_changes(p, middle, b, out);
}

struct GaussRule {
  static constexpr int points = 14;
  std::array<Real, points> at{}, weight{};  // on [0, 1]

  GaussRule() {
    for (int i = 0; i < points; ++i) {
      Real x = std::cos(pi * (i + 0.75L) / (points + 0.5L)), slope = 1;
      for (int round = 0; round < 20; ++round) {
        Real before = 1, now = x;
        for (int n = 2; n <= points; ++n) {
          const Real next = ((2 * n - 1) * x * now - (n - 1) * before) / n;
          before = now;
          now = next;
        }
        slope = points * (x * now - before) / (x * x - 1);
        x -= now / slope;
      }
      at[i] = 0.5L * (1 + x);
      weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
  }
};

// ---- modes

/// psi = X(x) Y(y), X = along sin(wave_x x) of the plate, along + slope_x x of the block;
/// Y = sin(wave_y y), or 1 + slope_y y.
struct ModeOfScene {
  Real omega = 0, zeta = 0, mass = 0, load = 0;
  Real along = 0, wave_x = 0, slope_x = 0, wave_y = 0, slope_y = 0;

  Real across(Real y) const { return wave_y > 0 ? std::sin(wave_y * y) : 1 + slope_y * y; }
};

std::vector<ModeOfScene> plate_modes_of(const ArealScene& s) {
  if (s.plate.support == Support::rigid) return {};
  const Real a = s.plate.length, b = s.plate.width, h = s.plate.thickness;
  const Real nu = s.plate.poisson.value_or(0.3), young = s.plate.young, rho = s.plate.density;
  const Real bending = young * h * h * h / (12 * (1 - nu * nu));
  const int count = s.plate.modes.value();
  std::vector<std::tuple<Real, int, int>> numbers;
  for (int m = 1; m <= count; ++m)
    for (int n = 1; n <= (s.is_plane ? 1 : count); ++n) {
      const Real square = m * m / (a * a) + (s.is_plane ? 0 : n * n / (b * b));
      numbers.emplace_back(square, m, n);
    }
  std::sort(numbers.begin(), numbers.end());
  // a and b are doubles: their roundings part no modes of one frequency
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (std::get<0>(numbers[i]) < std::get<0>(numbers[i - 1]) * (1 + 1e-14L))
      std::get<0>(numbers[i]) = std::get<0>(numbers[i - 1]);
  std::sort(numbers.begin(), numbers.end());
  std::vector<ModeOfScene> modes;
  for (int k = 0; k < count; ++k) {
    const auto& [square, m, n] = numbers[k];
    ModeOfScene mode;
    mode.zeta = s.plate.damping;
    mode.wave_x = m * pi / a;
    if (s.is_plane) {
      mode.mass = rho * h * b;
      mode.omega = std::sqrt(young * h * h / (12 * rho)) * mode.wave_x * mode.wave_x;
      mode.along = std::sqrt(2 / a);
    } else {
      mode.mass = rho * h;
      mode.omega = std::sqrt(bending / mode.mass) * pi * pi * (m * m / (a * a) + n * n / (b * b));
      mode.along = 2 / std::sqrt(a * b);
      mode.wave_y = n * pi / b;
    }
    modes.push_back(mode);
  }
  return modes;
}

std::vector<ModeOfScene> block_modes_of(const ArealScene& s) {
  if (s.block.support == Support::rigid) return {};
  const Real l1 = s.block.length, l2 = s.block.width, h = s.block.thickness;
  // what modes are normed over: the area, of a beam the length
  const Real size = s.is_plane ? l1 : l1 * l2;
  const Real weight = static_cast<Real>(s.block.density) * l1 * l2 * h * 9.80665L;
  ModeOfScene heave;
  heave.zeta = s.block.damping;
  heave.mass = s.block.density * h * (s.is_plane ? l2 : 1);
  heave.along = 1 / std::sqrt(size);
  ModeOfScene pitch = heave, roll = heave;
  heave.load =
      (s.block.load_is_weight ? s.block.load_weights * weight : s.block.load) * heave.along;
  pitch.along = -std::sqrt(3 / size);
  pitch.slope_x = std::sqrt(12 / size) / l1;
  roll.along = -std::sqrt(3 / size);
  roll.slope_y = -2 / l2;
  if (s.is_plane) return {heave, pitch};
  return {heave, pitch, roll};
}

/// (w t)^p/p!, of sin and of cos: 0 where the power is of the other.
struct Waves {
  Numbers sine, cosine;
  Waves(Real w, int terms) {
    Real term = 1;
    for (int p = 0; p < terms; ++p) {
      const Real sign = p % 4 < 2 ? 1 : -1;
      sine.push_back(p % 2 == 1 ? sign * term : 0);
      cosine.push_back(p % 2 == 0 ? sign * term : 0);
      term *= w / (p + 1);
    }
  }
};

// ---- the march

/// One time that a node was in contact.
struct Touch {
  int node = 0;
  Real start = 0, end = 0, impulse = 0, moment = 0;  // moment: integral of f x
  bool is_open = true;
};
/// The force [N] of a touch over one step, over its length.
struct ForcePiece {
  int touch = 0;
  long step = 0;
  Real to = 0;  // the share of the step that was taken
  Numbers force;
};

class ArealMarch {
 public:
  ArealMarch(const ArealScene& scene, const ArealOptions& options, Real end)
      : scene_{scene},
        order_{options.order},
        longest_{options.longest},
        plate_{plate_modes_of(scene)},
        modes_{plate_} {
    for (const ModeOfScene& mode : block_modes_of(scene_)) modes_.push_back(mode);
    count_ = static_cast<int>(modes_.size());
    count2_ = static_cast<int>(plate_.size());
    nodes_ = scene_.block_heights.empty() ? 0 : static_cast<int>(scene_.block_heights[0].size());
    rows_ = static_cast<int>(scene_.block_heights.size());
    chi_ = scene_.spacing;
    speed_ = scene_.speed;
    spring_ = static_cast<Real>(scene_.stiffness) * chi_ * scene_.spacing_y;
    position_ = scene_.start / chi_;
    cell_ = static_cast<int>(std::floor(position_));
    check(end);
    across_.resize(static_cast<std::size_t>(rows_) * count_);
    for (int j = 0; j < rows_; ++j)
      for (int k = 0; k < count_; ++k)
        across_[j * count_ + k] =
            modes_[k].across((j + 0.5L) * scene_.spacing_y + (k < count2_ ? scene_.side : 0.0));
    for (Numbers* table : {&sine_, &cosine_, &own_sine_, &own_cosine_})
      table->assign(static_cast<std::size_t>(nodes_) * count_, 0.0L);
    for (int i = 0; i < nodes_; ++i)
      for (int k = 0; k < count_; ++k) {
        own_sine_[i * count_ + k] = std::sin(modes_[k].wave_x * (i * chi_));
        own_cosine_[i * count_ + k] = std::cos(modes_[k].wave_x * (i * chi_));
      }
    u_.assign(order_ + 2, Numbers(count_));
    a_ = b_ = forced_sine_ = forced_cosine_ = u_;
    set(u_[0], scene_.plate_u, scene_.block_u);
    set(u_[1], scene_.plate_v, scene_.block_v);
    for (const ModeOfScene& mode : modes_) waves_.emplace_back(mode.wave_x * speed_, order_ + 2);
    for (const ArealForce& f : scene_.forces)
      for (const ModeOfScene& mode : plate_)
        force_waves_.emplace_back(mode.wave_x * f.speed, order_ + 2);
    open_.assign(static_cast<std::size_t>(nodes_) * rows_, -1);
    Real highest = 0;
    for (const HeightMap* map : {&scene_.plate_heights, &scene_.block_heights})
      for (const std::vector<double>& row : *map)
        for (const double h : row) highest = std::max<Real>(highest, std::abs(h));
    height_scale_ = 2 * highest + std::abs(static_cast<Real>(scene_.gap));
    for (const std::vector<double>& row : scene_.plate_heights)
      for (std::size_t p = 0; p + 1 < row.size(); ++p)
        steepest_ = std::max<Real>(steepest_, std::abs(static_cast<Real>(row[p + 1]) - row[p]));
    steepest_ /= chi_;
  }

  void march_to(Real time) {
    while (time_ < time) step(time);
  }
  ArealState state();
  ArealReference finish();

 private:
  const ArealScene& scene_;
  int order_;
  Real longest_;
  std::vector<ModeOfScene> plate_, modes_;  // modes_: of both bodies
  int count_ = 0, count2_ = 0, nodes_ = 0, rows_ = 0;
  Real chi_, speed_, spring_, position_, time_ = 0;
  int cell_;                              // of the plate, on which slider node 0 stands
  Numbers across_;                        // (row, mode)
  Numbers own_sine_, own_cosine_;         // (node, mode) of wave_x i chi
  Numbers sine_, cosine_;                 // (node, mode), X and the part that grows as sin
  Real height_scale_ = 0, steepest_ = 0;  // m; -
  // (power, mode): of the motion; of u cos(wave V t) and u sin(wave V t); of the forces' sums
  std::vector<Numbers> u_, a_, b_;
  std::vector<Numbers> forced_sine_, forced_cosine_;
  std::vector<int> open_;                   // of a node: its touch; -1: none
  std::vector<Waves> waves_, force_waves_;  // (mode) of the block's way; (force, mode)
  std::vector<int> active_, resting_;       // resting: neither overlap nor rate
  std::vector<Touch> touches_;
  std::vector<ForcePiece> pieces_;
  Real loss_ = 0, sliding_ = 0, load_ = 0;
  ArealReference out_;

  void check(Real end) const;
  static void set(Numbers& to, const std::vector<double>& plate, const std::vector<double>& block) {
    std::copy(plate.begin(), plate.end(), to.begin());
    std::copy(block.begin(), block.end(), to.end() - static_cast<std::ptrdiff_t>(block.size()));
  }
  Real theta() const { return position_ + speed_ * time_ / chi_ - cell_; }
  int row_of(int node) const { return node / nodes_; }
  int along_of(int node) const { return node % nodes_; }
  Real height2(int row, int at) const {
    const std::vector<double>& h = scene_.plate_heights[row];
    return h[std::min<std::size_t>(at, h.size() - 1)];
  }
  Real rise(int node) const {
    const int at = cell_ + along_of(node);
    return height2(row_of(node), at + 1) - height2(row_of(node), at);
  }
  void locate();
  Real shape_sum(int node, const Numbers& a, const Numbers& b) const;
  Real overlap_term(int node, int power) const;
  void find_active();
  void begin_and_end_touches();
  void series();
  bool press_resting();
  Real longest_step() const;
  Numbers overlap_series(int node, Real step) const;
  Real first_event(Real step);
  void account(Real step, Real share);
  void advance(Real step, Real share);
  void step(Real to);
  /// When a force leaves the plate.
  Real end_of(const ArealForce& force) const {
    return force.speed > 0 ? (scene_.plate.length - force.start) / static_cast<Real>(force.speed)
                           : never;
  }
  bool acts(const ArealForce& force) const { return time_ < end_of(force); }
};

void ArealMarch::check(Real end) const {
  const auto fail = [](const char* what) { throw std::invalid_argument(what); };
  if (rows_ == 0 || nodes_ == 0 || scene_.plate_heights.size() != scene_.block_heights.size())
    fail("areal reference: the maps differ in their rows");
  for (const std::vector<double>& row : scene_.block_heights)
    if (static_cast<int>(row.size()) != nodes_) fail("areal reference: a row of another length");
  const auto fits = [](const std::vector<double>& start, int modes) {
    return start.empty() || static_cast<int>(start.size()) == modes;
  };
  for (const std::vector<double>* start : {&scene_.plate_u, &scene_.plate_v})
    if (!fits(*start, count2_)) fail("areal reference: the start has other modes than the plate");
  for (const std::vector<double>* start : {&scene_.block_u, &scene_.block_v})
    if (!fits(*start, count_ - count2_))
      fail("areal reference: the start has other modes than the block");
  const Real last = std::ceil((scene_.start + speed_ * end) / chi_ - 1e-9L) + nodes_ - 1;
  for (const std::vector<double>& row : scene_.plate_heights)
    if (static_cast<Real>(row.size()) <= last) fail("areal reference: the block leaves the map");
}

/// X of all modes at the nodes, and what the plate's grow into as the block moves on:
/// X(x + V t) = sine cos(wave V t) + cosine sin(wave V t).
void ArealMarch::locate() {
  const Real x = scene_.start + speed_ * time_;
  Numbers sin(count_), cos(count_);
  for (int k = 0; k < count_; ++k) {
    sin[k] = modes_[k].along * std::sin(modes_[k].wave_x * x);
    cos[k] = modes_[k].along * std::cos(modes_[k].wave_x * x);
  }
  for (int i = 0; i < nodes_; ++i)
    for (int k = 0; k < count_; ++k) {
      const int at = i * count_ + k;
      const ModeOfScene& mode = modes_[k];
      if (k >= count2_) {
        sine_[at] = mode.along + mode.slope_x * (i * chi_);
        continue;
      }
      sine_[at] = sin[k] * own_cosine_[at] + cos[k] * own_sine_[at];
      cosine_[at] = cos[k] * own_cosine_[at] - sin[k] * own_sine_[at];
    }
}

/// sum over the modes of Y (sine a + cosine b) at a node
Real ArealMarch::shape_sum(int node, const Numbers& a, const Numbers& b) const {
  const Real *y = &across_[row_of(node) * count_], *sin = &sine_[along_of(node) * count_],
             *cos = &cosine_[along_of(node) * count_];
  Real sum = 0;
  for (int k = 0; k < count_; ++k) sum += y[k] * (sin[k] * a[k] + cos[k] * b[k]);
  return sum;
}

/// Of the overlap of a node, by powers of the time since the step's begin.
Real ArealMarch::overlap_term(int node, int power) const {
  Real sum = shape_sum(node, a_[power], b_[power]);
  if (power == 0)
    sum += scene_.block_heights[row_of(node)][along_of(node)] - static_cast<Real>(scene_.gap) +
           height2(row_of(node), cell_ + along_of(node)) + theta() * rise(node);
  if (power == 1) sum += speed_ / chi_ * rise(node);
  return sum;
}

/// The nodes in contact, by the overlap; where that is zero to within roundings, by its rate.
void ArealMarch::find_active() {
  Real moved = height_scale_, moving = speed_ * steepest_;
  for (int k = 0; k < count_; ++k) {
    const Real largest =
        std::abs(modes_[k].along) + std::abs(modes_[k].slope_x) * scene_.block.length;
    a_[0][k] = u_[0][k], b_[0][k] = 0;
    a_[1][k] = u_[1][k], b_[1][k] = modes_[k].wave_x * speed_ * u_[0][k];
    moved += largest * std::abs(u_[0][k]);
    moving += largest * (std::abs(a_[1][k]) + std::abs(b_[1][k]));
  }
  active_.clear(), resting_.clear();
  for (int node = 0; node < nodes_ * rows_; ++node) {
    Real o = overlap_term(node, 0);
    if (std::abs(o) <= 256 * rounding * moved) {
      o = overlap_term(node, 1);
      if (std::abs(o) <= 256 * rounding * moving) resting_.push_back(node), o = 0;
    }
    if (o > 0) active_.push_back(node);
  }
}

void ArealMarch::begin_and_end_touches() {
  std::vector<char> is_active(open_.size(), 0);
  for (const int node : active_) is_active[node] = 1;
  for (int node = 0; node < nodes_ * rows_; ++node) {
    if (is_active[node] && open_[node] < 0) {
      open_[node] = static_cast<int>(touches_.size());
      touches_.push_back({node, time_, time_});
      ++out_.closings;
    } else if (!is_active[node] && open_[node] >= 0) {
      touches_[open_[node]].end = time_;
      touches_[open_[node]].is_open = false;
      open_[node] = -1;
      ++out_.openings;
    }
  }
}

/// The Taylor series of all modes, with the nodes of active_ in contact.
void ArealMarch::series() {
  struct ForceNow {
    Real sine, cosine;
  };
  std::vector<ForceNow> forces;  // (moving force, mode)
  for (const ArealForce& f : scene_.forces)
    for (const ModeOfScene& mode : plate_) {
      const Real amplitude = acts(f) ? f.force * mode.across(f.y) * mode.along : 0;
      const Real phase = mode.wave_x * (f.start + f.speed * time_);
      forces.push_back({amplitude * std::sin(phase), amplitude * std::cos(phase)});
    }
  for (int p = 0; p + 2 < order_ + 2; ++p) {
    for (int k = 0; k < count_; ++k) {
      a_[p][k] = b_[p][k] = forced_sine_[p][k] = forced_cosine_[p][k] = 0;
      for (int j = 0; j <= p; j += 2) a_[p][k] += u_[p - j][k] * waves_[k].cosine[j];
      for (int j = 1; j <= p; j += 2) b_[p][k] += u_[p - j][k] * waves_[k].sine[j];
    }
    for (const int node : active_) {
      const Real force = spring_ * overlap_term(node, p);
      const Real *y = &across_[row_of(node) * count_], *sin = &sine_[along_of(node) * count_],
                 *cos = &cosine_[along_of(node) * count_];
      for (int k = 0; k < count_; ++k) {
        forced_sine_[p][k] += force * y[k] * sin[k];
        forced_cosine_[p][k] += force * y[k] * cos[k];
      }
    }
    Numbers force(count_);
    for (int k = 0; k < count_; ++k) {
      if (p == 0) force[k] = modes_[k].load;
      for (int j = 0; j <= p; j += 2) force[k] -= waves_[k].cosine[j] * forced_sine_[p - j][k];
      for (int j = 1; j <= p; j += 2) force[k] -= waves_[k].sine[j] * forced_cosine_[p - j][k];
    }
    for (std::size_t i = 0; i < forces.size(); ++i)
      force[i % count2_] += p % 2 == 0 ? forces[i].sine * force_waves_[i].cosine[p]
                                       : forces[i].cosine * force_waves_[i].sine[p];
    for (int k = 0; k < count_; ++k) {
      const ModeOfScene& mode = modes_[k];
      u_[p + 2][k] = (force[k] / mode.mass - 2 * mode.zeta * mode.omega * (p + 1) * u_[p + 1][k] -
                      mode.omega * mode.omega * u_[p][k]) /
                     ((p + 1.0L) * (p + 2.0L));
    }
  }
}

/// Nodes that rest on each other without a force, and are pressed together from now on, join those
/// in contact. (The second derivative of their overlap does not depend on whether they are.)
bool ArealMarch::press_resting() {
  const std::size_t before = active_.size();
  for (const int node : resting_)
    if (overlap_term(node, 2) > 0) active_.push_back(node);
  return active_.size() > before;
}

/// Over the inverse of a bound on the rate of the motion: the series of a linear system with that
/// rate falls as (rate t)^p/p!.
Real ArealMarch::longest_step() const {
  Real square = 0, fastest = 0, wave = 0;
  for (const ModeOfScene& mode : modes_) {
    fastest = std::max(fastest, mode.omega * (1 + 2 * mode.zeta));
    wave = std::max(wave, mode.wave_x);
  }
  for (const int node : active_)
    for (int k = 0; k < count_; ++k) {
      const int at = along_of(node) * count_ + k;
      square += spring_ / modes_[k].mass * std::pow(across_[row_of(node) * count_ + k], 2) *
                (sine_[at] * sine_[at] + cosine_[at] * cosine_[at]);
    }
  Real crossing = speed_;
  for (const ArealForce& f : scene_.forces) crossing = std::max<Real>(crossing, f.speed);
  const Real rate = std::sqrt(fastest * fastest + square) + wave * crossing;
  return rate > 0 ? longest_ / rate : never;
}

/// Over a step, whose length is the unit of time.
Numbers ArealMarch::overlap_series(int node, Real step) const {
  Numbers o;
  Real power = 1;
  for (int p = 0; p < order_; ++p, power *= step) o.push_back(overlap_term(node, p) * power);
  return o;
}

/// When the first node opens or closes within the step, as a share of it; 2: none does.
Real ArealMarch::first_event(Real step) {
  // what any overlap can change over the step, and what it can leave its tangent by
  Real change = speed_ * steepest_ * step, curving = 0, moved = height_scale_, power = 1;
  for (int p = 0; p < order_; ++p, power *= step)
    for (int k = 0; k < count_; ++k) {
      const Real largest =
          std::abs(modes_[k].along) + std::abs(modes_[k].slope_x) * scene_.block.length;
      const Real part = largest * (std::abs(a_[p][k]) + std::abs(b_[p][k])) * power;
      (p == 0 ? moved : change) += part;
      if (p > 1) curving += part;
    }
  Real first = 2;
  for (int node = 0; node < nodes_ * rows_; ++node) {
    const Real o = overlap_term(node, 0);
    if (std::abs(o) > change || std::abs(o) > std::abs(overlap_term(node, 1)) * step + curving)
      continue;
    Numbers series = overlap_series(node, step);
    // of a node that has just opened or closed, o(t)/t
    if (std::abs(o) <= 256 * rounding * moved) series.erase(series.begin());
    if (std::find(resting_.begin(), resting_.end(), node) != resting_.end())
      series.erase(series.begin());
    Numbers roots;
    sign_changes(series, 0, 1, roots);
    if (!roots.empty()) first = std::min(first, roots.front());
  }
  return first;
}

/// Works, losses and impulses over a share of a step.
void ArealMarch::account(Real step, Real share) {
  static const GaussRule rule;
  const Real x0 = scene_.start + speed_ * time_;
  std::vector<Numbers> overlaps;
  for (const int node : active_) {
    Numbers force = overlap_series(node, step);
    overlaps.push_back(force);
    for (Real& f : force) f *= spring_;
    Touch& touch = touches_[open_[node]];
    const Real impulse = integral(force, share) * step;
    touch.impulse += impulse;
    Numbers moving = force;
    moving.insert(moving.begin(), 0);  // f times the time
    touch.moment +=
        (x0 + along_of(node) * chi_) * impulse + speed_ * integral(moving, share) * step * step;
    pieces_.push_back({open_[node], out_.steps, share, std::move(force)});
  }
  for (int g = 0; g < GaussRule::points; ++g) {
    const Real t = rule.at[g] * share * step, weight = rule.weight[g] * share * step;
    Numbers u(count_), v(count_), sin(count_), cos(count_);
    for (int k = 0; k < count_; ++k) {
      for (int p = order_ + 1; p >= 0; --p) {
        v[k] = v[k] * t + (p <= order_ ? (p + 1) * u_[p + 1][k] : 0);
        u[k] = u[k] * t + u_[p][k];
      }
      loss_ += weight * 2 * modes_[k].zeta * modes_[k].omega * modes_[k].mass * v[k] * v[k];
      load_ += weight * modes_[k].load * v[k];
      sin[k] = std::sin(modes_[k].wave_x * speed_ * t);
      cos[k] = std::cos(modes_[k].wave_x * speed_ * t);
    }
    for (const ArealForce& f : scene_.forces) {
      if (!acts(f)) continue;
      for (int k = 0; k < count2_; ++k)
        load_ += weight * f.force * v[k] * modes_[k].across(f.y) * modes_[k].along *
                 std::sin(modes_[k].wave_x * (f.start + f.speed * (time_ + t)));
    }
    for (std::size_t e = 0; e < active_.size(); ++e) {
      const int node = active_[e];
      Real slope = rise(node) / chi_;
      for (int k = 0; k < count2_; ++k) {
        const int at = along_of(node) * count_ + k;
        slope += u[k] * modes_[k].wave_x * across_[row_of(node) * count_ + k] *
                 (cosine_[at] * cos[k] - sine_[at] * sin[k]);
      }
      sliding_ += weight * spring_ * value(overlaps[e], rule.at[g] * share) * speed_ * slope;
    }
  }
}

void ArealMarch::advance(Real step, Real share) {
  const Real t = step * share;
  for (int k = 0; k < count_; ++k) {
    Real u = 0, v = 0;
    for (int p = order_ + 1; p >= 0; --p) {
      u = u * t + u_[p][k];
      if (p > 0) v = v * t + p * u_[p][k];
    }
    u_[0][k] = u, u_[1][k] = v;
  }
  time_ += t;
  ++out_.steps;
}

void ArealMarch::step(Real to) {
  const Real passing = speed_ > 0 ? ((cell_ + 1) - position_) * chi_ / speed_ : never;
  Real stop = std::min(to, passing);
  for (const ArealForce& f : scene_.forces)
    if (acts(f)) stop = std::min(stop, end_of(f));
  if (stop > time_) {
    locate();
    find_active();
    series();
    if (press_resting()) series();
    begin_and_end_touches();
    const Real length = std::min(stop - time_, longest_step()), event = first_event(length),
               share = std::min<Real>(event, 1);
    const bool arrives = share == 1 && length == stop - time_;
    account(length, share);
    advance(length, share);
    if (!arrives) return;
    time_ = stop;
  }
  if (stop == passing) ++cell_;
}

ArealState ArealMarch::state() {
  locate();
  find_active();
  ArealState out;
  out.time = static_cast<double>(time_);
  Real kinetic = 0, elastic = 0, contact = 0, force = 0;
  for (int k = 0; k < count_; ++k) {
    const Real u = u_[0][k], v = u_[1][k];
    (k < count2_ ? out.plate_u : out.block_u).push_back(static_cast<double>(u));
    (k < count2_ ? out.plate_v : out.block_v).push_back(static_cast<double>(v));
    kinetic += 0.5L * modes_[k].mass * v * v;
    elastic += 0.5L * modes_[k].mass * std::pow(modes_[k].omega * u, 2);
  }
  for (const int node : active_) {
    const Real o = overlap_term(node, 0);
    force += spring_ * o;
    contact += 0.5L * spring_ * o * o;
  }
  out.contacts = static_cast<int>(active_.size());
  const auto put = [](double& to, Real from) { to = static_cast<double>(from); };
  put(out.force, force), put(out.kinetic, kinetic), put(out.elastic, elastic);
  put(out.contact, contact), put(out.damping_loss, loss_), put(out.sliding_work, sliding_);
  put(out.load_work, load_);
  return out;
}

/// Touches of neighbouring nodes in one step are of one shock.
ArealReference ArealMarch::finish() {
  const int count = static_cast<int>(touches_.size());
  std::vector<int> parent(count);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto are_neighbours = [&](const Touch& a, const Touch& b) {
    return std::abs(row_of(a.node) - row_of(b.node)) <= 1 &&
           std::abs(along_of(a.node) - along_of(b.node)) <= 1;
  };
  Numbers peak(count, 0.0L);  // of a shock, at its root
  for (std::size_t first = 0, last = 0; first < pieces_.size(); first = last) {
    while (last < pieces_.size() && pieces_[last].step == pieces_[first].step) ++last;
    for (std::size_t i = first; i < last; ++i)
      for (std::size_t j = first; j < i; ++j) {
        const int a = root(pieces_[i].touch), b = root(pieces_[j].touch);
        if (a == b || !are_neighbours(touches_[pieces_[i].touch], touches_[pieces_[j].touch]))
          continue;
        parent[std::max(a, b)] = std::min(a, b);
        peak[std::min(a, b)] = std::max(peak[a], peak[b]);
      }
    std::map<int, Numbers> forces;
    for (std::size_t i = first; i < last; ++i) {
      Numbers& sum = forces[root(pieces_[i].touch)];
      sum.resize(pieces_[i].force.size());
      for (std::size_t p = 0; p < sum.size(); ++p) sum[p] += pieces_[i].force[p];
    }
    for (const auto& [of, force] : forces) {
      Numbers places;
      sign_changes(derivative(force), 0, pieces_[first].to, places);
      places.insert(places.end(), {0, pieces_[first].to});
      for (const Real place : places) peak[of] = std::max(peak[of], value(force, place));
    }
  }
  for (int of = 0; of < count; ++of) {  // touches, and so shocks, are in order of their start
    if (root(of) != of) continue;
    Real end = 0, impulse = 0, x = 0, y = 0;
    bool is_open = false;
    std::set<int> nodes;
    for (int i = of; i < count; ++i) {
      if (root(i) != of) continue;
      const Touch& touch = touches_[i];
      end = std::max(end, touch.is_open ? time_ : touch.end);
      impulse += touch.impulse;
      x += touch.moment;
      y += touch.impulse * (scene_.side + (row_of(touch.node) + 0.5L) * scene_.spacing_y);
      is_open = is_open || touch.is_open;
      nodes.insert(touch.node);
    }
    const auto number = [](Real of_shock) { return static_cast<double>(of_shock); };
    out_.shocks.push_back({number(touches_[of].start), number(end), number(impulse),
                           number(peak[of]), number(x / impulse), number(y / impulse),
                           static_cast<int>(nodes.size()), is_open});
  }
  return std::move(out_);
}

}  // namespace

ArealReference areal_reference(const ArealScene& scene, const std::vector<double>& times,
                               const ArealOptions& options) {
  ArealMarch march(scene, options, times.empty() ? 0 : times.back());
  std::vector<ArealState> states;
  for (const double time : times) {
    march.march_to(time);
    states.push_back(march.state());
  }
  ArealReference out = march.finish();
  out.states = std::move(states);
  return out;
}

}  // namespace ra2d::test
