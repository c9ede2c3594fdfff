// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/odeint/external/eigen/eigen.hpp>
#include <cmath>
#include <vector>

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
class Contact {
 public:
  Contact(Equations& equations, const EvaluatedNodes& evaluated)
      : equations_{equations},
        nodes_evaluated_{evaluated},
        scale_{natural_scale(equations)},
        y_{State::Zero(scale_.size())},
        rate_{y_},
        force_{State::Zero(equations.modes())} {}

  const State& scale() const { return scale_; }
  void list_changed() {
    nodes_.list = nodes_evaluated_.list();
    nodes_.base = nowhere;
  }

  void operator()(const State& scaled, State& out, double t) {
    ++evaluations;
    y_ = scaled.cwiseProduct(scale_);
    equations_.outer_force(t, force_.data());
    if (nodes_evaluated_.all()) {
      const Place& place = equations_.place(t);
      equations_.overlaps(place, y_.data(), overlap_);
      // listed first: a loop that does nothing else is the faster one
      touching_.resize(overlap_.size());
      int count = 0;
      for (Eigen::Index n = 0; n < overlap_.size(); ++n) {
        touching_[count] = static_cast<int>(n);
        count += overlap_[n] > 0;
      }
      for (int i = 0; i < count; ++i)
        equations_.project(place, touching_[i], equations_.node_stiffness * overlap_[touching_[i]],
                           force_.data());
    } else if (!nodes_.list.empty()) {
      const Place& place = equations_.place(t);
      equations_.overlaps(place, nodes_, y_.data(), some_);
      if (some_.maxCoeff() > 0) {
        some_ = equations_.node_stiffness * some_.cwiseMax(0.0);
        equations_.project(place, nodes_, some_, force_.data());
      }
    }
    equations_.state_rate(y_.data(), force_.data(), rate_.data());
    out = rate_.cwiseQuotient(scale_);
  }

  std::int64_t evaluations = 0;

 private:
  Equations& equations_;
  const EvaluatedNodes& nodes_evaluated_;
  State scale_, y_, rate_, force_;
  Eigen::ArrayXd overlap_;
  std::vector<int> touching_;
  SomeNodes nodes_;
  Eigen::VectorXd some_;
};

}  // namespace

void march_dopri5(Equations& equations, const PeerOptions& options, Eigen::VectorXd& y,
                  PeerResult& result) {
  EvaluatedNodes evaluated(equations, options.nodes);
  Contact contact(equations, evaluated);
  const auto system = [&](const State& x, State& rate, double t) { contact(x, rate, t); };
  auto stepper = odeint::make_controlled<Stepper>(options.tolerance, options.tolerance);

  State x = y.cwiseQuotient(contact.scale());
  const double longest = longest_step(equations);
  double t = 0, step = 0.01 * longest;
  for (;;) {
    const double left = options.until - equations.lag - t;
    if (left <= end_slack * options.until) break;
    step = std::min({step, longest, left});
    y = x.cwiseProduct(contact.scale());
    if (evaluated.prepare(t, y.data(), step)) contact.list_changed();
    const double first_try = step = std::min(step, evaluated.end() - t);
    const double before = t;
    if (stepper.try_step(system, x, t, step) == odeint::success) {
      ++result.steps;
      equations.lag += first_try - (t - before);
    }
    if (!x.allFinite() || !(step > 1e-14 * first_try))
      throw SimulationError(fmt::format("dopri5 gave up at t = {:g} s", t));
  }
  y = x.cwiseProduct(contact.scale());
  result.evaluations = contact.evaluations;
  result.displacement_sums = equations.displacement_sums;
}

}  // namespace ra2d::peers
