#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "base/error.hpp"

namespace bayesctrl {

/// Nonlinear least squares by damped Gauss-Newton steps within bounds (Levenberg 1944, Marquardt 1963).
///
/// The cost is c(x) = 1/2 |r(x)|^2 + 1/2 |W (x - m)|^2: residuals r, whatever their number, and a normal prior about m.
/// About a point it is taken to be c - g's + 1/2 s'Hs for a step s, with the Gauss-Newton Hessian H = J'J + W'W of the
/// Jacobian J = -dr/dx and g = J'r - W'W (x - m). A point may be more than a vector of numbers: nuisance parameters
/// that follow the others along (variable projection, Golub & Pereyra 1973) belong to it, and only the problem knows
/// them.
struct QuadraticModel {
  Eigen::MatrixXd hessian;    // n x n
  Eigen::VectorXd descent;    // g, n
  Eigen::VectorXd low, high;  // bounds of the step, n; empty: none
  bool kept = false;          // the Jacobian is that of an earlier point
};

struct LeastSquaresOptions {
  int max_iterations = 20;
  int max_trials = 6;                // dampings that are tried in one iteration
  double damping = 1e-4;             // at first; share of the Hessian's diagonal that is added to it
  double growth = 10.0;              // of the damping after a failure,
  double rejected = 1e-2;            // and the least it is then
  double least_gain = 0.0;           // of the cost: an iteration that gains less is the last,
  double least_relative_gain = 0.0;  // and one that gains less than this share of the cost above `floor`
  double least_promise = 0.0;        // share of the cost that a step has to promise, else it is not taken
  double floor = 0.0;                // cost that cannot be avoided: what noise leaves
};

/// Why the iteration ended.
enum class LeastSquaresEnd {
  converged,   // it gains, or promises, less than was asked for
  iterations,  // as many as were allowed
  no_descent,  // no damping leads to a lower cost
  undefined,   // the problem has no Jacobian here: next to here it cannot be computed
};
constexpr std::array<std::string_view, 4> names(LeastSquaresEnd) {
  return {"converged", "iterations", "no_descent", "undefined"};
}

struct LeastSquaresSummary {
  double cost = std::numeric_limits<double>::infinity();
  int iterations = 0;   // Jacobians
  int evaluations = 0;  // costs of trial points
  LeastSquaresEnd end = LeastSquaresEnd::iterations;
};

/// The step that makes the quadratic model least within its bounds, its Hessian's diagonal enlarged by `damping` times
/// itself. What would be pushed beyond a bound stops there, and the others make the best of it. A number that nothing
/// depends on does not move.
Eigen::VectorXd bounded_step(const QuadraticModel& model, double damping = 0.0);

/// By how much the model says that a step lowers the cost.
double promised_gain(const QuadraticModel& model, const Eigen::VectorXd& step);

namespace detail {

inline constexpr double kShrink = 0.1, kLeastDamping = 1e-9;  // of the damping after success, and its bound below
inline constexpr double kRounding = 0.01;  // of the least gain: who loses less than that is at a minimum

}  // namespace detail

/// Moves `point` to a minimum of the problem's cost. The problem says
///   double cost(const Point&);                              // of a point that `moved` has returned
///   QuadraticModel model(const Point&, double agreement);   // may throw NumericalError
///   Point moved(const Point&, const Eigen::VectorXd& step); // throws NumericalError where no cost is defined
/// `agreement`: how far, relative to the promise, the last step's gain was from what the last model promised. A problem
/// with an expensive Jacobian may keep the last one where that is small, and says so in `kept`.
template <class Problem, class Point>
LeastSquaresSummary least_squares(Problem& problem, Point& point, const LeastSquaresOptions& options = {}) {
  using enum LeastSquaresEnd;
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  LeastSquaresSummary summary;
  double damping = options.damping, agreement = kInfinite;
  for (; summary.iterations < options.max_iterations; ++summary.iterations) {
    QuadraticModel model;
    try {
      model = problem.model(point, agreement);
    } catch (const NumericalError&) {
      summary.end = undefined;
      return summary;
    }
    summary.cost = problem.cost(point);
    summary.end = converged;
    if (model.descent.size() == 0) return summary;
    const double before = summary.cost;
    const double asked = std::max(options.least_gain, options.least_relative_gain * (before - options.floor));
    double gain = -kInfinite, promise = 0.0;
    for (int trial = 0; trial < options.max_trials; ++trial) {
      const Eigen::VectorXd step = bounded_step(model, damping);
      promise = promised_gain(model, step);
      if (!std::isfinite(promise)) {  // nor has it one where its numbers overflow
        summary.end = undefined;
        return summary;
      }
      if (promise <= options.least_promise * before) return summary;
      ++summary.evaluations;
      try {
        Point next = problem.moved(point, step);
        summary.cost = problem.cost(next);
        gain = before - summary.cost;
        if (gain > 0.0) point = std::move(next);
      } catch (const NumericalError&) {
        gain = -kInfinite;
      }
      if (gain > 0.0) break;
      summary.cost = before;
      damping = std::max(options.growth * damping, options.rejected);
      if (model.kept || gain > -detail::kRounding * options.least_gain) break;
    }
    if (gain > 0.0) damping = std::max(detail::kShrink * damping, detail::kLeastDamping);
    agreement = gain > 0.0 ? std::abs(gain - promise) / promise : kInfinite;
    if (gain >= asked && gain > 0.0) continue;
    if (model.kept && !(gain > 0.0)) continue;  // once more with a Jacobian of this point
    if (!(gain > -detail::kRounding * options.least_gain)) summary.end = no_descent;
    ++summary.iterations;
    return summary;
  }
  summary.end = iterations;
  return summary;
}

}  // namespace bayesctrl
