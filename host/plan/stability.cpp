// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/stability.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>

#include "host/base/decompositions.hpp"
#include "host/scene/schemes.hpp"
#include "kernels/schemes/gautschi.hpp"

namespace ra2d {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The largest value of which `holds` is true, between one that holds and one that does not.
double bisect(double low, double high, const std::function<bool(double)>& holds) {
  for (;;) {
    const double middle = low + (high - low) / 2;
    if (!(low < middle && middle < high)) return low;
    (holds(middle) ? low : high) = middle;
  }
}

/// ln |1 + mu|, to the last digits of mu.
double log_radius(std::complex<double> mu) {
  return 0.5 * std::log1p(2 * mu.real() + std::norm(mu));
}

/// The eigenvalue of largest size of a mode's step, less one: what is small stays accurate.
std::complex<double> mode_increment(SchemeKind scheme, double zeta, double x) {
  const ModeStep step = scheme_table(scheme).prepare({.omega = x, .zeta = zeta, .mass = 1}, 1.0);
  const double half_trace = (step.u_u + (step.v_v - 1)) / 2;
  const double determinant = step.u_u * (step.v_v - 1) - step.u_v * step.v_u;
  const double square = half_trace * half_trace - determinant;
  if (square < 0) return {half_trace, std::sqrt(-square)};
  return half_trace + std::copysign(std::sqrt(square), 1 + half_trace);
}

/// The p_k of |R|^2 - 1 = sum_k p_k x^k at z = x (-zeta + i sqrt(1 - zeta^2)), zeta <= 1: with the
/// coefficients alpha of R and cos(theta) = -zeta, p_k = sum_{j + l = k} alpha_j alpha_l cos((j -
/// l) theta). Up to the order of the scheme they are those of |exp(z)|^2, exactly.
std::vector<double> growth_polynomial(const SchemeTable& table, double zeta) {
  const std::vector<double>& alpha = table.polynomial;
  const int degree = static_cast<int>(alpha.size()) - 1;
  std::vector<double> cosine{1.0, -zeta};  // by recursion: zero where zeta = 0 makes it so
  while (static_cast<int>(cosine.size()) <= degree)
    cosine.push_back(-2 * zeta * cosine[cosine.size() - 1] - cosine[cosine.size() - 2]);
  std::vector<double> p{0.0};
  for (int k = 1; k <= 2 * degree; ++k) {
    if (k <= table.order) {
      p.push_back(p.size() == 1 ? -2 * zeta : p.back() * -2 * zeta / k);
      continue;
    }
    double sum = 0;
    for (int j = std::max(0, k - degree); j <= std::min(k, degree); ++j)
      sum += alpha[j] * alpha[k - j] * cosine[std::abs(2 * j - k)];
    p.push_back(sum);
  }
  return p;
}

/// The smallest x > 0 beyond which |R| > 1, for zeta <= 1.
double polynomial_limit(const SchemeTable& table, double zeta) {
  std::vector<double> p = growth_polynomial(table, zeta);
  p.erase(p.begin(), std::find_if(p.begin(), p.end(), [](double c) { return c != 0; }));
  if (p.front() > 0) return 0.0;
  const auto holds = [&](double x) {
    double sum = 0;
    for (std::size_t k = p.size(); k-- > 0;) sum = sum * x + p[k];
    return sum <= 0;
  };
  // no root is below this bound (Cauchy); one comes, for the last coefficient is a square
  double largest = 0;
  for (const double c : p) largest = std::max(largest, std::abs(c));
  double low = std::max(-p.front() / (largest - p.front()), 1e-290);  // of which 1.001 is more
  constexpr double pace = 1.001;  // growth over a narrower interval than this is of no account
  while (holds(low * pace)) low *= pace;
  return bisect(low, low * pace, holds);
}

double mass_sum(const JoinedModes& joined) {
  double sum = 0;
  for (std::size_t j = 0; j < joined.modes.size(); ++j)
    sum += joined.square[j] / joined.modes[j].mass;
  return sum;
}

bool takes_new_force(const TimeSettings& choice) {
  return choice.scheme == SchemeKind::backward_euler && choice.contact_force == ForceTime::new_time;
}

/// The step of the joined modes less the identity, on (sigma U, V). Its columns are the answers to
/// a one in each.
Eigen::MatrixXd joined_increment(const TimeSettings& choice, const JoinedModes& joined,
                                 double stiffness, double tau) {
  const int n = static_cast<int>(joined.modes.size());
  std::vector<ModeStep> steps;
  double fastest = stiffness * mass_sum(joined);  // bound on the square of the fastest motion's
  Eigen::VectorXd psi(n);
  for (int j = 0; j < n; ++j) {
    steps.push_back(scheme_table(choice.scheme).prepare(joined.modes[j], tau));
    psi[j] = std::sqrt(joined.square[j]);
    fastest = std::max(fastest, stiffness * mass_sum(joined) + std::pow(joined.modes[j].omega, 2));
  }
  // weighs U and V alike, so that the eigenvalues keep their digits
  const double sigma = fastest > 0 ? std::min(std::sqrt(fastest), 1 / tau) : 1 / tau;
  const int stages = steps.empty() ? 1 : steps[0].stages;
  Eigen::MatrixXd out(2 * n, 2 * n);
  for (int input = 0; input < 2 * n; ++input) {
    const int mode = input % n;
    const double u0 = input < n ? 1 / sigma : 0.0, v0 = input < n ? 0.0 : 1.0;
    double force[most_stages];  // over psi_j, of each stage
    for (int i = 0; i < stages; ++i) {
      const ModeStep& own = steps[mode];
      double seen = psi[mode] * (u0 + own.stage_u[i] * u0 + own.stage_v[i] * v0),
             displacement_per_newton = 0;
      if (takes_new_force(choice)) {  // f = -k (seen + displacement_per_newton f)
        seen = psi[mode] * (u0 + own.u_u * u0 + own.u_v * v0);
        for (int j = 0; j < n; ++j) displacement_per_newton += joined.square[j] * steps[j].u_f[0];
      }
      for (int j = 0; j < n; ++j)
        for (int l = 0; l < i; ++l) seen += joined.square[j] * steps[j].stage_f[i][l] * force[l];
      force[i] = -stiffness * seen / (1 + stiffness * displacement_per_newton);
    }
    for (int j = 0; j < n; ++j) {
      double du = 0, dv = 0;
      for (int i = 0; i < stages; ++i) {
        du += steps[j].u_f[i] * psi[j] * force[i];
        dv += steps[j].v_f[i] * psi[j] * force[i];
      }
      if (j == mode) {
        du += steps[j].u_u * u0 + steps[j].u_v * v0;
        dv += steps[j].v_u * u0 + (steps[j].v_v - 1) * v0;
      }
      out(j, input) = sigma * du;
      out(n + j, input) = dv;
    }
  }
  return out;
}

/// ln of the largest factor of amplification(choice, joined, ...).
double log_amplification(const TimeSettings& choice, const JoinedModes& joined, double stiffness,
                         double tau) {
  if (joined.modes.empty()) return 0.0;
  double most = -infinity;
  for (const std::complex<double> mu :
       eigenvalues(joined_increment(choice, joined, stiffness, tau)))
    most = std::max(most, log_radius(mu));
  return most;
}

/// Of the logarithm of a spectral radius of so many modes; up to 50 of them the growth at
/// 1e-5/omega_c is 25 times it.
double roundings(const JoinedModes& joined) {
  return 1e-12 * std::max<double>(1.0, static_cast<double>(joined.modes.size()) / 50);
}

/// `exact` with a held force, by search. Undamped it grows by (omega_c tau)^2/2 a step, always.
double held_force_limit(const JoinedModes& joined, double stiffness) {
  const auto damped = [](const Mode& mode) { return mode.zeta * mode.omega > 0; };
  if (std::none_of(joined.modes.begin(), joined.modes.end(), damped)) return 0.0;
  const auto holds = [&](double tau) {
    return log_amplification({SchemeKind::exact}, joined, stiffness, tau) <= roundings(joined);
  };
  const double period = 1 / std::sqrt(stiffness * mass_sum(joined));
  double fastest = 0;
  for (const Mode& mode : joined.modes) fastest = std::max(fastest, mode.omega);
  // Beyond half a period of the fastest motion, windows of stability of all widths alternate with
  // growth, but for a single mode. No more is promised than up to there.
  const double top = joined.modes.size() > 1 ? M_PI / std::hypot(fastest, 1 / period)
                                             : std::numeric_limits<double>::infinity();
  double low = 1e-5 * period;
  if (!holds(low)) return 0.0;
  while (holds(std::min(1.5 * low, top))) {
    low *= 1.5;
    if (low > top) return top;
    if (low > 1e5 * period) return infinity;  // the spring is too soft to matter
  }
  double high = std::min(1.5 * low, top);
  while (high > 1.0001 * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

/// psi_k^2 of a body's modes at the place where their sum is largest.
std::vector<double> largest_squares(const Body& body) {
  std::vector<double> best(body.modes.size(), 0.0), here(body.modes.size());
  double most = -1;
  const std::size_t places = 40 * body.modes.size();  // tens to a wavelength, and both ends
  for (std::size_t i = 0; i <= places; ++i) {
    const double x = body.length * static_cast<double>(i) /
                     static_cast<double>(std::max<std::size_t>(places, 1));
    double sum = 0;
    for (std::size_t k = 0; k < body.modes.size(); ++k) {
      const double psi = shape_at(body.modes[k], x);
      here[k] = psi * psi;
      sum += here[k];
    }
    if (sum > most) {
      most = sum;
      best = here;
    }
  }
  return best;
}

/// As largest_squares(), of a body `width` [m] wide.
std::vector<double> largest_squares(const Body& body, double width) {
  constexpr double to_half_wave = 20;  // places
  const auto modes = static_cast<Eigen::Index>(body.modes.size());
  double along = 0, across = 0;  // half waves
  for (const BodyMode& mode : body.modes) {
    along = std::max(along, mode.shape->wave_number() * body.length / M_PI);
    across = std::max(across, mode.shape->across_rate() * width / M_PI);
  }
  const auto intervals = [](double waves) {
    return static_cast<Eigen::Index>(std::ceil(to_half_wave * std::max(1.0, waves)));
  };
  Eigen::ArrayXXd of_x(modes, intervals(along) + 1), of_y(modes, intervals(across) + 1);
  const auto place = [](double size, Eigen::Index i, const Eigen::ArrayXXd& of) {
    return size * static_cast<double>(i) / static_cast<double>(of.cols() - 1);
  };
  for (Eigen::Index k = 0; k < modes; ++k) {
    const BodyMode& mode = body.modes[static_cast<std::size_t>(k)];
    for (Eigen::Index i = 0; i < of_x.cols(); ++i)
      of_x(k, i) = std::pow(shape_at(mode, place(body.length, i, of_x)), 2);
    for (Eigen::Index j = 0; j < of_y.cols(); ++j) {
      double psi = 0;
      mode.shape->evaluate_across(place(width, j, of_y), 1, &psi);
      of_y(k, j) = psi * psi;
    }
  }
  Eigen::ArrayXd best = Eigen::ArrayXd::Zero(modes);
  double most = -1;
  for (Eigen::Index j = 0; j < of_y.cols(); ++j)
    for (Eigen::Index i = 0; i < of_x.cols(); ++i) {
      const double sum = (of_x.col(i) * of_y.col(j)).sum();
      if (!(sum > most)) continue;
      most = sum;
      best = of_x.col(i) * of_y.col(j);
    }
  return {best.begin(), best.end()};
}

}  // namespace

double amplification(SchemeKind scheme, double zeta, double x) {
  return std::abs(1.0 + mode_increment(scheme, zeta, x));
}

StepError step_error(SchemeKind scheme, double zeta, double x) {
  const std::complex<double> mu = mode_increment(scheme, zeta, x);
  StepError error;
  error.damping = -log_radius(mu) / x - zeta;
  const double turn = std::arg(1.0 + mu);
  if (mu.imag() != 0.0 && zeta < 1)
    error.period = std::sqrt((1 - zeta) * (1 + zeta)) * x / turn - 1;
  return error;
}

double mode_limit(SchemeKind scheme, double zeta) {
  if (scheme == SchemeKind::backward_euler || scheme == SchemeKind::exact ||
      scheme == SchemeKind::gautschi)
    return infinity;
  if (scheme == SchemeKind::midpoint) return 2.0;
  const SchemeTable& table = scheme_table(scheme);
  if (zeta <= 1) return polynomial_limit(table, zeta);
  // two real eigenvalues, -omega (zeta -+ sqrt(zeta^2 - 1)): the larger binds
  return polynomial_limit(table, 1.0) / (zeta + std::sqrt(zeta * zeta - 1));
}

double amplification(const TimeSettings& choice, const JoinedModes& joined, double stiffness,
                     double tau) {
  return std::exp(log_amplification(choice, joined, stiffness, tau));
}

double contact_limit(const TimeSettings& choice, const JoinedModes& joined, double stiffness) {
  const double omega_c = std::sqrt(stiffness * mass_sum(joined));
  if (takes_new_force(choice) || omega_c == 0) return infinity;
  if (!std::isfinite(omega_c)) return 0.0;  // beyond all doubles: no search would end
  const auto sum_over_modes = [&](const auto& part) {
    double sum = 0;
    for (std::size_t j = 0; j < joined.modes.size(); ++j)
      sum += stiffness * joined.square[j] / (joined.modes[j].mass * part(joined.modes[j]));
    return sum;
  };
  switch (choice.scheme) {
    case SchemeKind::backward_euler: {
      const auto holds = [&](double tau) {
        return sum_over_modes([&](const Mode& mode) {
                 return (4 / tau + 4 * mode.zeta * mode.omega) / tau + mode.omega * mode.omega;
               }) < 1;
      };
      const double low = 2 / omega_c * (1 - 1e-12);  // where all omega_j tau are small
      double high = 2 * low;
      while (holds(high)) {
        high *= 2;
        if (std::isinf(high)) return infinity;
      }
      return bisect(low, high, holds);
    }
    case SchemeKind::midpoint: {
      double fastest = omega_c;
      for (const Mode& mode : joined.modes) fastest = std::max(fastest, mode.omega);
      const auto holds = [&](double tau) {
        return sum_over_modes([&](const Mode& mode) {
                 return (2 / tau - mode.omega) * (2 / tau + mode.omega);
               }) < 1;
      };
      return bisect(0.0, 2 / fastest, holds);
    }
    case SchemeKind::gautschi: {
      double fastest = omega_c * M_PI / 2;
      for (const Mode& mode : joined.modes) fastest = std::max(fastest, mode.omega);
      const auto holds = [&](double tau) {
        double sum = 0;
        for (std::size_t j = 0; j < joined.modes.size(); ++j) {
          const ModeStep step = Gautschi::prepare(joined.modes[j], tau);
          sum += stiffness * joined.square[j] * tau * step.v_f[0] /
                 (2 * (1 + step.v_v) + tau * step.v_u);
        }
        return sum < 1;
      };
      return bisect(0.0, M_PI / fastest, holds);
    }
    case SchemeKind::exact:
      return held_force_limit(joined, stiffness);
    default:
      break;
  }
  // a Runge-Kutta scheme on the joined modes multiplies each of their motions by R(tau lambda)
  double limit = infinity;
  for (const std::complex<double>& value : joined_eigenvalues(joined, stiffness)) {
    const double size = std::abs(value);
    if (size > 0)
      limit = std::min(
          limit, mode_limit(choice.scheme, std::clamp(-value.real() / size, 0.0, 1.0)) / size);
  }
  return limit;
}

std::vector<std::complex<double>> joined_eigenvalues(const JoinedModes& joined, double stiffness) {
  const int n = static_cast<int>(joined.modes.size());
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd damping(n), q(n);
  for (int j = 0; j < n; ++j) {
    const Mode& mode = joined.modes[j];
    q[j] = std::sqrt(stiffness * joined.square[j] / mode.mass);
    damping[j] = 2 * mode.zeta * mode.omega;
    square(j, j) = mode.omega * mode.omega;
  }
  square += q * q.transpose();
  // in the eigenbasis of the undamped motion the matrix is nearly normal, and slow motions keep
  // their digits beside the stiffest
  const SymmetricEigen undamped = symmetric_eigen(square);
  const Eigen::VectorXd nu = undamped.values.cwiseMax(0.0).cwiseSqrt();
  std::vector<std::complex<double>> out;
  if (damping.isZero(0)) {
    for (const double frequency : nu) out.emplace_back(0.0, frequency);
    return out;
  }
  const Eigen::MatrixXd& basis = undamped.vectors;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  a.topRightCorner(n, n) = nu.asDiagonal();
  a.bottomLeftCorner(n, n).diagonal() = -nu;
  a.bottomRightCorner(n, n) = -basis.transpose() * damping.asDiagonal() * basis;
  const double roundings = 4 * n * std::numeric_limits<double>::epsilon() * a.norm();
  for (std::complex<double> value : eigenvalues(a)) {
    if (std::abs(value.real()) < roundings) value.real(0.0);
    out.push_back(value);
  }
  return out;
}

JoinedModes most_compliant(const Model& model) {
  JoinedModes joined;
  Mode drifting{};
  double drifting_square = 0;
  for (const Body* body : {&model.resonator, &model.slider}) {
    const double width =
        (body == &model.resonator ? model.scene.resonator : model.scene.slider).width;
    const std::vector<double> squares =
        model.is_areal ? largest_squares(*body, width) : largest_squares(*body);
    for (std::size_t k = 0; k < squares.size(); ++k) {
      const Mode& mode = body->modes[k];
      if (mode.omega > 0) {
        joined.modes.push_back(mode);
        joined.square.push_back(squares[k]);
      } else {
        if (drifting.mass == 0) drifting = mode;
        drifting_square += squares[k] * drifting.mass / mode.mass;
      }
    }
  }
  if (drifting_square > 0) {
    joined.modes.push_back(drifting);
    joined.square.push_back(drifting_square);
  }
  return joined;
}

double contact_frequency(const Model& model, const JoinedModes& place) {
  return std::sqrt(model.node_stiffness * mass_sum(place));
}

StepLimits step_limits(const Model& model, const TimeSettings& choice) {
  return step_limits(model, choice, most_compliant(model));
}

StepLimits step_limits(const Model& model, const TimeSettings& choice, const JoinedModes& place) {
  StepLimits limits;
  limits.modes = limits.contact_one = limits.contact_many = infinity;
  double zeta = -1, x = infinity;  // of the mode before: mostly they are all alike
  for (const Body* body : {&model.resonator, &model.slider})
    for (const Mode& mode : body->modes) {
      if (mode.zeta != zeta) x = mode_limit(choice.scheme, zeta = mode.zeta);
      if (choice.scheme == SchemeKind::gautschi) x = M_PI;  // beyond, samples have no velocity
      if (mode.omega == 0 || std::isinf(x)) continue;
      const double frequency = mode.omega / (2 * M_PI);
      if (x / mode.omega < limits.modes ||
          (x / mode.omega == limits.modes && frequency > limits.binding_frequency)) {
        limits.modes = x / mode.omega;
        limits.binding_frequency = frequency;
      }
    }
  if (model.scene.contact.law == ContactLaw::penalty) {
    limits.contact_one = contact_limit(choice, place, model.node_stiffness);
    limits.contact_many = contact_limit(choice, place, limits.many * model.node_stiffness);
  }
  return limits;
}

double mode_growth(const Model& model, SchemeKind scheme, double tau) {
  double most = -infinity;
  for (const Body* body : {&model.resonator, &model.slider})
    for (const Mode& mode : body->modes)
      if (mode.omega > 0)
        most =
            std::max(most, log_radius(mode_increment(scheme, mode.zeta, mode.omega * tau)) / tau);
  return most;
}

bool holds_in_contact(const Model& model, const TimeSettings& choice, const JoinedModes& place,
                      double tau) {
  return log_amplification(choice, place, model.node_stiffness, tau) <= roundings(place);
}

double contact_growth(const Model& model, const TimeSettings& choice, const JoinedModes& place,
                      double tau) {
  return log_amplification(choice, place, model.node_stiffness, tau) / tau;
}

}  // namespace ra2d
