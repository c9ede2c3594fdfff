// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/odeint/external/eigen/eigen.hpp>
#include <cmath>

#include "bench/peers/evaluated_nodes.hpp"
#include "bench/peers/integrators.hpp"
#include "host/base/errors.hpp"

namespace ra2d::peers {
namespace {

namespace odeint = boost::numeric::odeint;
using State = Eigen::VectorXd;
using Stepper =
    odeint::runge_kutta_dopri5<State, double, State, double, odeint::vector_space_algebra>;

/// The right-hand side with the penalty force as it is: max(0, overlap) of every evaluated node.
/// The state is in units of its natural scale: the error control has one absolute tolerance.
class RightHandSide {
 public:
  explicit RightHandSide(ContactEquations& equations)
      : equations_{equations},
        scale_{natural_scale(equations)},
        y_{State::Zero(scale_.size())},
        rate_{y_},
        force_{State::Zero(equations.modes())} {}

  const State& scale() const { return scale_; }

  void operator()(const State& scaled, State& out, double t) {
    ++evaluations;
    y_ = scaled.cwiseProduct(scale_);
    equations_.outer_force(t, force_.data());
    equations_.contact(t, y_.data(), force_.data());
    equations_.state_rate(y_.data(), force_.data(), rate_.data());
    out = rate_.cwiseQuotient(scale_);
  }

  std::int64_t evaluations = 0;

 private:
  ContactEquations& equations_;
  State scale_, y_, rate_, force_;
};

}  // namespace

void march_dopri5(ContactEquations& equations, const PeerOptions& options, Eigen::VectorXd& y,
                  PeerResult& result) {
  EvaluatedNodes evaluated(equations, options.nodes);
  RightHandSide right_hand_side(equations);
  const auto system = [&](const State& x, State& rate, double t) { right_hand_side(x, rate, t); };
  auto stepper = odeint::make_controlled<Stepper>(options.tolerance, options.tolerance);

  State x = y.cwiseQuotient(right_hand_side.scale());
  const double longest = longest_step(equations);
  double t = 0, step = 0.01 * longest;
  for (;;) {
    const double left = options.until - equations.lag - t;
    if (left <= end_slack * options.until) break;
    step = std::min({step, longest, left});
    y = x.cwiseProduct(right_hand_side.scale());
    if (evaluated.prepare(t, y.data(), step)) equations.evaluate_only(evaluated.list());
    const double first_try = step = std::min(step, evaluated.end() - t);
    const double before = t;
    if (stepper.try_step(system, x, t, step) == odeint::success) {
      ++result.steps;
      equations.lag += first_try - (t - before);
    }
    if (!x.allFinite() || !(step > 1e-14 * first_try))
      throw SimulationError(fmt::format("dopri5 gave up at t = {:g} s", t));
  }
  y = x.cwiseProduct(right_hand_side.scale());
  result.evaluations = right_hand_side.evaluations;
  result.displacement_sums = equations.displacement_sums;
}

}  // namespace ra2d::peers
