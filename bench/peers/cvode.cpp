// SPDX-License-Identifier: BSD-3-Clause
#include <cvode/cvode.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "bench/peers/evaluated_nodes.hpp"
#include "bench/peers/integrators.hpp"
#include "bench/peers/shock_log.hpp"
#include "host/base/errors.hpp"

/// Contact as a sequence of smooth pieces. Within a piece the set of touching nodes stays: their
/// springs stiffness where they would, the other nodes carry nothing. CVODE steps beyond the
/// piece's end, undisturbed, and finds it as a root: the first open gap that closes or closed one
/// that opens. From there the integration starts anew. In contact a piece ends at a node crossing,
/// too, where the face's slope jumps; in flight nothing jumps there.
///
/// Two root functions serve all nodes: the largest overlap of the open ones and the least of the
/// touching ones. One for each would be thousands, each to be searched at every step.
///
/// A node may touch and leave within one step, unseen by roots. Where the rates at both ends allow
/// it, the extremum between is found on CVODE's interpolant.
namespace ra2d::peers {
namespace {

/// SUNDIALS' objects are freed by functions of their own.
template <class Object, auto release>
struct Release {
  void operator()(Object* object) const { release(object); }
};
template <class Object, auto release>
using Owned = std::unique_ptr<Object, Release<Object, release>>;

void free_context(_SUNContext* context) { SUNContext_Free(&context); }
void free_solver(_generic_SUNNonlinearSolver* solver) { SUNNonlinSolFree(solver); }
void free_linear(_generic_SUNLinearSolver* solver) { SUNLinSolFree(solver); }
struct FreeMemory {
  void operator()(void* memory) const { CVodeFree(&memory); }
};

Eigen::Map<Eigen::VectorXd> map(N_Vector v) { return {NV_DATA_S(v), NV_LENGTH_S(v)}; }

/// A vector whose most frequent operations are compiled for this machine, as our own code is: the
/// packaged library's are for any, and take most of its time on vectors as short as these.
N_Vector make_vector(double* data, Eigen::Index size, SUNContext context) {
  N_Vector v = N_VMake_Serial(static_cast<sunindextype>(size), data, context);
  v->ops->nvlinearsum = [](realtype a, N_Vector x, realtype b, N_Vector y, N_Vector out) {
    map(out) = a * map(x) + b * map(y);
  };
  v->ops->nvscale = [](realtype a, N_Vector x, N_Vector out) { map(out) = a * map(x); };
  v->ops->nvwrmsnorm = [](N_Vector x, N_Vector weight) {
    return std::sqrt(map(x).cwiseProduct(map(weight)).squaredNorm() /
                     static_cast<double>(NV_LENGTH_S(x)));
  };
  return v;
}

class Cvode {
 public:
  Cvode(PlaneEquations& equations, const PeerOptions& options, Eigen::VectorXd& y)
      : equations_{equations},
        options_{options},
        y_{y},
        before_{y},
        between_{y},
        force_(equations.modes()),
        evaluated_{equations, options.nodes},
        touches_(equations.nodes(), 0) {
    _SUNContext* context = nullptr;
    require(SUNContext_Create(nullptr, &context), "SUNContext_Create");
    context_.reset(context);
    const auto size = static_cast<sunindextype>(y.size());
    scale_ = options.tolerance * natural_scale(equations);
    state_.reset(make_vector(y.data(), size, context));
    tolerances_.reset(make_vector(scale_.data(), size, context));
    dense_.reset(make_vector(between_.data(), size, context));

    const bool bdf = options.integrator == Integrator::cvode_bdf;
    memory_.reset(CVodeCreate(bdf ? CV_BDF : CV_ADAMS, context));
    void* memory = memory_.get();
    require(CVodeSetErrHandlerFn(memory, on_error, this), "CVodeSetErrHandlerFn");
    require(CVodeInit(memory, right_hand_side, 0, state_.get()), "CVodeInit");
    require(CVodeSetUserData(memory, this), "CVodeSetUserData");
    require(CVodeSVtolerances(memory, options.tolerance, tolerances_.get()), "CVodeSVtolerances");
    require(CVodeSetMaxStep(memory, longest_step(equations)), "CVodeSetMaxStep");
    if (bdf) {
      matrix_.reset(SUNDenseMatrix(size, size, context));
      linear_.reset(SUNLinSol_Dense(state_.get(), matrix_.get(), context));
      require(CVodeSetLinearSolver(memory, linear_.get(), matrix_.get()), "CVodeSetLinearSolver");
      require(CVodeSetJacFn(memory, jacobian), "CVodeSetJacFn");
    } else {
      fixed_point_.reset(SUNNonlinSol_FixedPoint(state_.get(), 0, context));
      require(CVodeSetNonlinearSolver(memory, fixed_point_.get()), "CVodeSetNonlinearSolver");
    }
    int directions[] = {+1, -1};  // overlaps of open nodes rise to 0, those of touching ones fall
    require(CVodeRootInit(memory, 2, roots), "CVodeRootInit");
    require(CVodeSetRootDirection(memory, directions), "CVodeSetRootDirection");
    require(CVodeSetNoInactiveRootWarn(memory), "CVodeSetNoInactiveRootWarn");
  }

  void march(PeerResult& result) {
    jumps_ = equations_.force_jumps();
    prepare_nodes();
    list_changed();
    choose_touching(-1);
    while (options_.until - equations_.lag - time_ > end_slack * options_.until) piece();
    result.steps = steps_;
    result.evaluations = evaluations_;
    result.displacement_sums = equations_.displacement_sums;
    result.onsets = onsets_;
    result.shocks = log_.finish(options_.until);
  }

 private:
  // ---- what CVODE calls

  static int right_hand_side(realtype t, N_Vector y, N_Vector rate, void* data) {
    auto& self = *static_cast<Cvode*>(data);
    ++self.evaluations_;
    const double* u = N_VGetArrayPointer(y);
    self.equations_.outer_force(t, self.force_.data());
    if (!self.touching_.list.empty()) {
      const Place& place = self.equations_.place(t, self.window_);
      self.equations_.overlaps(place, self.touching_, u, self.spring_);
      self.spring_ *= self.equations_.node_stiffness;
      self.equations_.project(place, self.touching_, self.spring_, self.force_.data());
    }
    self.equations_.state_rate(u, self.force_.data(), N_VGetArrayPointer(rate));
    return 0;
  }

  static int roots(realtype t, N_Vector y, realtype* out, void* data) {
    auto& self = *static_cast<Cvode*>(data);
    self.evaluate_all(t, N_VGetArrayPointer(y));
    out[0] = self.most_open_ > -1 ? self.most_open_ : -1;
    out[1] = self.least_touching_ < 1 ? self.least_touching_ : 1;
    return 0;
  }

  static int jacobian(realtype t, N_Vector, N_Vector, SUNMatrix out, void* data, N_Vector, N_Vector,
                      N_Vector) {
    auto& self = *static_cast<Cvode*>(data);
    const PlaneEquations& e = self.equations_;
    const Eigen::Index modes = e.modes();
    Eigen::Map<Eigen::MatrixXd> j(SUNDenseMatrix_Data(out), 2 * modes, 2 * modes);
    j.setZero();
    j.topRightCorner(modes, modes).setIdentity();
    auto stiffness = j.bottomLeftCorner(modes, modes);
    if (!self.touching_.list.empty()) {
      const Place& place = self.equations_.place(t, self.window_);
      e.shapes(place, self.touching_, self.shapes_);
      stiffness = -e.node_stiffness * self.shapes_.transpose() * self.shapes_;
      stiffness = e.mass.inverse().matrix().asDiagonal() * Eigen::MatrixXd(stiffness);
    }
    stiffness.diagonal() -= e.omega.square().matrix();
    j.bottomRightCorner(modes, modes).diagonal() = -e.damping.matrix();
    return 0;
  }

  static void on_error(int code, const char*, const char* function, char* message, void* data) {
    if (code < 0) static_cast<Cvode*>(data)->fault_ = fmt::format("{}: {}", function, message);
  }

  void require(int flag, const char* what) const {
    if (flag < 0)
      throw SimulationError(
          fmt::format("CVODE gave up at t = {:g} s: {}", time_, fault_.empty() ? what : fault_));
  }

  // ---- pieces

  /// Where the piece ends, if nothing else ends it [s]. Not rounded as time_ is, so it shifts.
  double piece_end(bool& crossing) const {
    double end = options_.until - equations_.lag;
    crossing = false;
    for (const double jump : jumps_) {
      const double at = jump - equations_.lag;
      if (at > time_ && at < end) end = at;
    }
    if (touching_.list.empty() || equations_.rate() == 0) return end;
    const double next = equations_.time_at(window_ + 1);
    crossing = next <= end;
    return crossing ? next : end;
  }

  /// From time_ to the next event.
  void piece() {
    for (bool begun = false;; begun = true) {
      bool crossing;
      const double end = piece_end(crossing);
      if (end - time_ <= 16 * std::numeric_limits<double>::epsilon() * end) {
        time_ = end;
        cross(crossing);
        return;
      }
      if (!begun) {
        require(CVodeReInit(memory_.get(), time_, state_.get()), "CVodeReInit");
        solver_time_ = time_;
      }
      require(CVodeSetStopTime(memory_.get(), end), "CVodeSetStopTime");
      prepare_nodes();
      before_ = y_;
      const double from = time_;
      const int flag = CVode(memory_.get(), end, state_.get(), &time_, CV_ONE_STEP);
      require(flag, "CVode");
      ++steps_;
      count_time();
      if (!y_.allFinite())
        throw SimulationError(fmt::format("CVODE's state is not finite at t = {:g} s", time_));
      int missed = -1;
      if (find_missed(from, flag == CV_ROOT_RETURN, missed) || flag == CV_ROOT_RETURN) {
        record(from);
        choose_touching(missed);
        return;
      }
      record(from);
      if (flag == CV_TSTOP_RETURN) {
        cross(crossing);
        return;
      }
    }
  }

  void cross(bool crossing) {
    if (crossing) ++window_;
  }

  /// Adds up the roundings that CVODE made when it added the last step to its time.
  void count_time() {
    double reached = 0, step = 0;
    require(CVodeGetCurrentTime(memory_.get(), &reached), "CVodeGetCurrentTime");
    if (reached == solver_time_) return;
    require(CVodeGetLastStep(memory_.get(), &step), "CVodeGetLastStep");
    equations_.lag += step - (reached - solver_time_);
    solver_time_ = reached;
  }

  /// A list of evaluated nodes that is good for the next step.
  void prepare_nodes() {
    double step = 0;
    if (steps_ > 0) require(CVodeGetCurrentStep(memory_.get(), &step), "CVodeGetCurrentStep");
    if (evaluated_.prepare(time_, y_.data(), step)) list_changed();
  }
  void list_changed() {
    open_.list.clear();
    for (const int node : evaluated_.list())
      if (!touches_[node]) open_.list.push_back(node);
    open_.base = nowhere;
    evaluated_at_ = -1;
  }

  /// The overlaps of all evaluated nodes, and their extremes.
  void evaluate_all(double t, const double* u) {
    evaluated_at_ = t;
    most_open_ = -std::numeric_limits<double>::infinity();
    least_touching_ = std::numeric_limits<double>::infinity();
    if (!touching_.list.empty()) {
      equations_.overlaps(equations_.place(t, window_), touching_, u, touching_overlap_);
      least_touching_ = touching_overlap_.minCoeff();
    }
    if (evaluated_.all()) {
      equations_.overlaps(equations_.place(t), u, overlap_);
      for (const int node : touching_.list) overlap_[node] = -1;
      most_open_ = overlap_.maxCoeff();
    } else if (!open_.list.empty()) {
      const Place& place =
          touching_.list.empty() ? equations_.place(t) : equations_.place(t, window_);
      equations_.overlaps(place, open_, u, open_overlap_);
      most_open_ = open_overlap_.maxCoeff();
    }
  }

  double open_overlap(std::size_t i) const {
    return evaluated_.all() ? overlap_[open_.list[i]] : open_overlap_[static_cast<Eigen::Index>(i)];
  }

  /// After an event: which nodes touch. `missed` is one that has just changed sides.
  void choose_touching(int missed) {
    if (touching_.list.empty())
      window_ = static_cast<std::int64_t>(std::floor(equations_.position(time_)));
    evaluate_all(time_, y_.data());
    const auto rising = [&](int node) {
      one_.list = {node};
      one_.base = nowhere;
      evaluate(time_, window_, y_, one_, middle_);
      return middle_.rate[0] > 0;
    };
    const auto touches = [&](int node, double overlap) {
      return overlap > 0 || (overlap == 0 && rising(node));
    };
    std::vector<int> begun, ended;
    for (std::size_t i = 0; i < touching_.list.size(); ++i) {
      const int node = touching_.list[i];
      if (node == missed || !touches(node, touching_overlap_[static_cast<Eigen::Index>(i)]))
        ended.push_back(node);
    }
    for (std::size_t i = 0; i < open_.list.size(); ++i) {
      const int node = open_.list[i];
      if (node == missed || touches(node, open_overlap(i))) begun.push_back(node);
    }
    // the new ones first: where one takes over from its neighbour, the shock goes on
    for (const int node : begun) log_.onset(node, time_);
    for (const int node : ended) log_.release(node, time_);
    onsets_ += static_cast<std::int64_t>(begun.size());
    for (const int node : begun) touches_[node] = 1;
    for (const int node : ended) touches_[node] = 0;
    std::erase_if(touching_.list, [&](int node) { return !touches_[node]; });
    touching_.list.insert(touching_.list.end(), begun.begin(), begun.end());
    touching_.base = nowhere;
    list_changed();
    record_begin();
  }

  // ---- contact that begins and ends, or ends and begins, within a step

  void state_at(double t) {
    require(CVodeGetDky(memory_.get(), t, 0, dense_.get()), "CVodeGetDky");
  }

  /// Overlaps of nodes and their rates at one moment.
  struct Evaluation {
    Eigen::VectorXd overlap, rate;
  };
  void evaluate(double t, std::int64_t window, const Eigen::VectorXd& y, SomeNodes& nodes,
                Evaluation& out) {
    const Place& place = equations_.place(t, window);
    equations_.overlaps(place, nodes, y.data(), out.overlap);
    equations_.rates(place, nodes, y.data(), y.data() + equations_.modes(), out.rate);
  }

  /// Bisection, to the last digit of time, of a function that is positive at `high` and not at
  /// `low`; returns the end where it is positive.
  template <class Function>
  static double first_positive(double low, double high, const Function& function) {
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      if (middle <= low || middle >= high) break;
      (function(middle) > 0 ? high : low) = middle;
    }
    return high;
  }

  /// Whether a node changed sides in the step that began at `from` without CVODE's noticing (or, if
  /// `noticed`, before what it noticed). If so, goes back to where the first did.
  bool find_missed(double from, bool noticed, int& missed) {
    const bool list_was_good = evaluated_.covered(from, before_.data(), time_, y_.data());
    if (!list_was_good) list_changed();
    noticed = noticed && list_was_good;
    // no overlap changes by more
    const double travel = (time_ - from) * (1.5 * std::max(evaluated_.rate_bound(before_.data()),
                                                           evaluated_.rate_bound(y_.data())) +
                                            equations_.face_rate);
    if (evaluated_at_ != time_) evaluate_all(time_, y_.data());
    suspects_ = touching_.list;
    if (most_open_ > -travel) {
      const auto list = [&](const auto& overlaps, const auto& node) {
        for (Eigen::Index i = 0; i < overlaps.size(); ++i)
          if (overlaps[i] > -travel) suspects_.push_back(node(i));
      };
      if (evaluated_.all())
        list(overlap_, [](Eigen::Index i) { return static_cast<int>(i); });
      else
        list(open_overlap_, [&](Eigen::Index i) { return open_.list[i]; });
    }
    if (suspects_.empty()) return false;
    if (suspects_ != suspected_.list) {
      suspected_.list = suspects_;
      suspected_.base = nowhere;
    }

    double first = time_;
    missed = -1;
    before_piece_ = before_;
    for (double left = from; left < first && missed < 0;) {
      // up to the next crossing: there the rates jump
      double right = time_;
      std::int64_t window = window_;
      if (touching_.list.empty() && equations_.rate() > 0) {
        window = static_cast<std::int64_t>(std::floor(equations_.position(left) + 1e-9));
        right = std::min(right, equations_.time_at(window + 1));
        if (right <= left) right = time_;
      }
      if (right < time_) state_at(right);
      const Eigen::VectorXd& after = right < time_ ? after_piece_ = between_ : y_;
      evaluate(left, window, before_piece_, suspected_, begin_);
      evaluate(right, window, after, suspected_, end_);
      for (std::size_t i = 0; i < suspected_.list.size(); ++i) {
        const double found =
            first_in(left, right, window, static_cast<Eigen::Index>(i), noticed && right == time_);
        if (!(found < first)) continue;
        first = found;
        missed = suspected_.list[i];
      }
      if (right >= time_) break;
      left = right;
      before_piece_ = after_piece_;
    }
    if (missed < 0) return false;
    state_at(first);
    y_ = between_;
    time_ = first;
    evaluated_at_ = -1;
    return true;
  }

  /// When node i of the near ones first changes sides between two times within a window; never:
  /// infinity. If `seen_at_end`, not what is so at the right end.
  double first_in(double left, double right, std::int64_t window, Eigen::Index i,
                  bool seen_at_end) {
    const double never = std::numeric_limits<double>::infinity();
    const double side = touches_[suspected_.list[i]] ? -1 : 1;
    const double a = side * begin_.overlap[i], b = side * end_.overlap[i];
    if (a > 0) return never;
    const double rate_a = side * begin_.rate[i], rate_b = side * end_.rate[i];
    const bool crosses = b > 0 && !seen_at_end;
    if (!crosses) {
      if (!(rate_a > 0 && rate_b < 0)) return never;
      // the largest value between, were the rate to stay as it is at either end until it turns
      if (std::max(a, b) + (right - left) * std::min(rate_a, -rate_b) <= 0) return never;
    }
    one_.list = {suspected_.list[i]};
    one_.base = nowhere;
    const auto evaluated = [&](double t) -> const Evaluation& {
      state_at(t);
      evaluate(t, window, between_, one_, middle_);
      return middle_;
    };
    const auto overlap = [&](double t) { return side * evaluated(t).overlap[0]; };
    if (crosses) return first_positive(left, right, overlap);
    const double top =
        first_positive(left, right, [&](double t) { return -side * evaluated(t).rate[0]; });
    return overlap(top) > 0 ? first_positive(left, top, overlap) : never;
  }

  // ---- forces of the shocks

  /// The force of a shock and its rate.
  struct Sum {
    std::int64_t shock;
    double force, rate;
  };
  void sum_forces() {
    sums_.clear();
    if (touching_.list.empty()) return;
    evaluate(time_, window_, y_, touching_, middle_);
    for (std::size_t i = 0; i < touching_.list.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const std::int64_t shock = log_.shock_of(touching_.list[i]);
      auto sum = std::find_if(sums_.begin(), sums_.end(),
                              [&](const Sum& each) { return each.shock == shock; });
      if (sum == sums_.end()) sum = sums_.insert(sum, {shock, 0, 0});
      sum->force += equations_.node_stiffness * middle_.overlap[at];
      sum->rate += equations_.node_stiffness * middle_.rate[at];
    }
  }
  void record_begin() {
    sum_forces();
    for (const Sum& each : sums_) log_.peak(each.shock, each.force);
  }
  /// The largest force of each shock in the step that began at `from`: of the cubic through both
  /// ends.
  void record(double from) {
    if (touching_.list.empty()) return;
    std::swap(sums_, sums_before_);
    sum_forces();
    const double h = time_ - from;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const Sum &a = sums_before_[i], &b = sums_[i];
      double most = std::max(a.force, b.force);
      if (a.rate > 0 && b.rate < 0) {
        // q(s) = a + c1 s + c2 s^2 + c3 s^3, 0 <= s <= 1
        const double c1 = h * a.rate, rise = b.force - a.force;
        const double c2 = 3 * rise - 2 * c1 - h * b.rate, c3 = c1 + h * b.rate - 2 * rise;
        const double s = c1 / (std::sqrt(std::max(0.0, c2 * c2 - 3 * c3 * c1)) - c2);
        most = std::max(most, a.force + s * (c1 + s * (c2 + s * c3)));
      }
      log_.peak(b.shock, most);
    }
  }

  PlaneEquations& equations_;
  const PeerOptions& options_;
  Eigen::VectorXd& y_;
  Eigen::VectorXd before_, between_, before_piece_, after_piece_, scale_;
  Eigen::VectorXd force_, spring_;
  double time_ = 0, solver_time_ = 0;  // s; where CVODE itself stands

  EvaluatedNodes evaluated_;
  std::int64_t window_ = nowhere;  // in contact
  std::vector<char> touches_;      // of each node
  SomeNodes touching_, open_;      // open: evaluated, not in contact
  std::vector<double> jumps_;      // of the outer force, s

  double evaluated_at_ = -1;  // s
  Eigen::ArrayXd overlap_;
  Eigen::VectorXd touching_overlap_, open_overlap_;
  double most_open_ = 0, least_touching_ = 0;
  std::vector<int> suspects_;
  SomeNodes suspected_, one_;
  Evaluation begin_, end_, middle_;
  Rows shapes_;

  ShockLog log_;
  std::vector<Sum> sums_, sums_before_;
  std::int64_t steps_ = 0, evaluations_ = 0, onsets_ = 0;
  std::string fault_;

  Owned<_SUNContext, free_context> context_;
  Owned<_generic_N_Vector, N_VDestroy> state_, tolerances_, dense_;
  struct FreeMatrix {
    void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
  };
  std::unique_ptr<_generic_SUNMatrix, FreeMatrix> matrix_;
  Owned<_generic_SUNLinearSolver, free_linear> linear_;
  Owned<_generic_SUNNonlinearSolver, free_solver> fixed_point_;
  std::unique_ptr<void, FreeMemory> memory_;
};

}  // namespace

void march_cvode(PlaneEquations& equations, const PeerOptions& options, Eigen::VectorXd& y,
                 PeerResult& result) {
  Cvode cvode(equations, options, y);
  cvode.march(result);
}

}  // namespace ra2d::peers
