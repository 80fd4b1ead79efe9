#include "numerics/minimize.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/fields.hpp"

using namespace bayesctrl;

namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

/// (1 - x)^2 + 100 (y - x^2)^2, least at (1, 1).
double rosenbrock(const VectorXd& p, VectorXd& gradient) {
  const double x = p[0], y = p[1], rest = y - x * x;
  gradient[0] = -2.0 * (1.0 - x) - 400.0 * x * rest;
  gradient[1] = 200.0 * rest;
  return (1.0 - x) * (1.0 - x) + 100.0 * rest * rest;
}

const Vector2d kRosenbrockStart(-1.2, 1.0);  // the customary start
const Vector2d kLow(-2.0, -2.0), kHigh(2.0, 2.0);

/// A relative change of the objective of 1e-9 near a minimum leaves errors of about its root in the argument.
constexpr double kArgument = 1e-3;

constexpr auto kMethods = {MinimizeMethod::lbfgs, MinimizeMethod::conjugate_gradients};

MinimizeOptions by(MinimizeMethod method, int evaluations = 200) {
  return {.method = method, .max_evaluations = evaluations};
}

}  // namespace

TEST_CASE("The minimum of Rosenbrock's function is found", "[numerics]") {
  for (const MinimizeMethod method : kMethods) {
    const MinimizeSummary summary = minimize(rosenbrock, kRosenbrockStart, kLow, kHigh, by(method));
    INFO(to_name(method));
    CHECK((summary.x - Vector2d(1.0, 1.0)).norm() < kArgument);
    CHECK(summary.value < 1e-8);
    CHECK((summary.converged || method == MinimizeMethod::conjugate_gradients));  // at zero no change is small
  }
}

TEST_CASE("A minimum beyond the bounds is found on the bounds", "[numerics]") {
  // On the edge x = 0.5 the function is least at y = x^2, with the value (1 - x)^2.
  for (const MinimizeMethod method : kMethods) {
    const MinimizeSummary summary = minimize(rosenbrock, kRosenbrockStart, kLow, Vector2d(0.5, 2.0), by(method));
    INFO(to_name(method));
    CHECK(summary.x[0] == Approx(0.5).epsilon(1e-6));
    CHECK(summary.x[1] == Approx(0.25).margin(kArgument));
    CHECK(summary.value == Approx(0.25).epsilon(1e-5));
  }
}

TEST_CASE("No point outside the bounds is evaluated", "[numerics]") {
  int outside = 0;
  const Vector2d low(-1.5, 0.2), high(0.8, 1.5);
  const Objective watched = [&](const VectorXd& x, VectorXd& gradient) {
    outside += (x.array() < low.array()).any() || (x.array() > high.array()).any();
    return rosenbrock(x, gradient);
  };
  for (const MinimizeMethod method : kMethods) {
    minimize(watched, Vector2d(-10.0, 10.0), low, high, by(method));  // the start, too, is moved within
  }
  CHECK(outside == 0);
}

TEST_CASE("The summary is of the best point that was evaluated", "[numerics]") {
  double best = INFINITY;
  VectorXd where;
  int calls = 0;
  const Objective watched = [&](const VectorXd& x, VectorXd& gradient) {
    ++calls;
    const double value = rosenbrock(x, gradient);
    if (value < best) {
      best = value;
      where = x;
    }
    return value;
  };
  for (const MinimizeMethod method : kMethods) {
    for (const int limit : {1, 2, 5, 20, 200}) {
      best = INFINITY;
      calls = 0;
      const MinimizeSummary summary = minimize(watched, kRosenbrockStart, kLow, kHigh, by(method, limit));
      INFO(to_name(method) << ", limit " << limit);
      CHECK(summary.value == best);
      CHECK(summary.x == where);
      CHECK(summary.evaluations == calls);
    }
  }
}

TEST_CASE("The number of evaluations is limited", "[numerics]") {
  for (const MinimizeMethod method : kMethods) {
    for (const int limit : {1, 2, 3, 7, 15}) {
      const MinimizeSummary summary = minimize(rosenbrock, kRosenbrockStart, kLow, kHigh, by(method, limit));
      CHECK(summary.evaluations <= limit);
      CHECK_FALSE(summary.converged);
    }
  }
}

TEST_CASE("Where the objective is not a number the search turns back", "[numerics]") {
  for (const double wall : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    int refused = 0;
    // -log x + x, undefined for x <= 0, least at 1; from 0.01 the first steps overshoot.
    const Objective objective = [&](const VectorXd& x, VectorXd& gradient) {
      if (x[0] <= 0.0 || x[0] > 40.0) {
        ++refused;
        gradient[0] = wall;
        return wall;
      }
      gradient[0] = 1.0 - 1.0 / x[0];
      return x[0] - std::log(x[0]);
    };
    const VectorXd start = VectorXd::Constant(1, 0.01);
    for (const MinimizeMethod method : kMethods) {
      const MinimizeSummary summary =
          minimize(objective, start, VectorXd::Constant(1, -100.0), VectorXd::Constant(1, 100.0), by(method));
      INFO(to_name(method));
      if (method == MinimizeMethod::lbfgs) CHECK(refused > 0);  // the wall was met
      CHECK(std::isfinite(summary.value));
      CHECK(summary.value <= 0.01 - std::log(0.01));
      CHECK(summary.x[0] == Approx(1.0).margin(kArgument));
    }
  }
}

TEST_CASE("Bounds that coincide hold their variable", "[numerics]") {
  for (const MinimizeMethod method : kMethods) {
    const MinimizeSummary summary =
        minimize(rosenbrock, kRosenbrockStart, Vector2d(-2.0, 0.49), Vector2d(2.0, 0.49), by(method));
    CHECK(summary.x[1] == 0.49);
    CHECK((summary.value < 0.1 || method == MinimizeMethod::conjugate_gradients));  // (0.7, 0.49) has 0.09
    CHECK(summary.value < 3.0);                                                     // the other minimum, at -0.7
  }
}

TEST_CASE("Bounds that do not fit are the caller's error", "[numerics]") {
  CHECK_THROWS_AS(minimize(rosenbrock, kRosenbrockStart, VectorXd::Zero(1), kHigh), std::invalid_argument);
  CHECK_THROWS_AS(minimize(rosenbrock, kRosenbrockStart, kHigh, kLow), std::invalid_argument);
}
