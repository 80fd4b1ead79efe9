#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "numerics/detail/dormand_prince.hpp"

using namespace bayesctrl;

namespace {

using Two = std::array<double, 2>;

/// q'' = -sin q from (1, 0.5).
void pendulum(const Two& y, Two& dydt, double /*t*/) { dydt = {y[1], -std::sin(y[0])}; }
constexpr Two kStart{1.0, 0.5};
constexpr double kEnd = 4.0;

double distance(const Two& a, const Two& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

/// One accepted step for each piece of length `h`: the tolerance never refuses one.
Two in_fixed_steps(int pieces) {
  const Integration loose{.relative_tolerance = 1e6, .absolute_tolerance = 1e6};
  Two y = kStart;
  const double h = kEnd / pieces;
  int calls = 0;
  for (int i = 0; i < pieces; ++i) {
    double step = h;
    const auto counted = [&](const Two& state, Two& dydt, double t) {
      ++calls;
      pendulum(state, dydt, t);
    };
    integrate(counted, y, h * i, h * (i + 1), loose, step);
  }
  REQUIRE(calls == 7 * pieces);  // seven stages: indeed one step for each piece
  return y;
}

/// Halved until two solutions agree to rounding; classical Runge-Kutta, which shares nothing with the code under test.
Two converged() {
  const auto runge_kutta = [](int steps) {
    std::array<long double, 2> y{kStart[0], kStart[1]};
    const long double h = kEnd / static_cast<long double>(steps);
    const auto f = [](const std::array<long double, 2>& s) {
      return std::array<long double, 2>{s[1], -std::sin(s[0])};
    };
    const auto plus = [](const auto& a, const auto& b, long double c) {
      return std::array<long double, 2>{a[0] + c * b[0], a[1] + c * b[1]};
    };
    for (int i = 0; i < steps; ++i) {
      const auto k1 = f(y), k2 = f(plus(y, k1, h / 2)), k3 = f(plus(y, k2, h / 2)), k4 = f(plus(y, k3, h));
      for (int c = 0; c < 2; ++c) y[c] += h / 6 * (k1[c] + 2 * k2[c] + 2 * k3[c] + k4[c]);
    }
    return Two{static_cast<double>(y[0]), static_cast<double>(y[1])};
  };
  Two coarse = runge_kutta(1000);
  for (int steps = 2000; steps < 1'000'000; steps *= 2) {
    const Two fine = runge_kutta(steps);
    if (distance(coarse, fine) < 4e-16) return fine;
    coarse = fine;
  }
  FAIL("the reference does not converge");
  return coarse;
}

Two solved(const Integration& options) {
  Two y = kStart;
  double step = 0.1;
  integrate(pendulum, y, 0.0, kEnd, options, step);
  return y;
}

}  // namespace

TEST_CASE("Halving the step divides the error of Dormand-Prince by 2^5", "[numerics]") {
  const Two reference = converged();
  double before = distance(in_fixed_steps(20), reference);
  for (const int pieces : {40, 80, 160}) {
    const double error = distance(in_fixed_steps(pieces), reference);
    INFO(pieces << " steps, error " << error);
    const double order = std::log2(before / error);
    CHECK(order > 4.5);
    CHECK(order < 5.5);
    before = error;
  }
}

TEST_CASE("The error falls with the tolerance", "[numerics]") {
  const Two reference = converged();
  // The tolerance holds per step and errors add up over some dozens of them; the chosen steps stay a little below it.
  constexpr double kMostSteps = 100.0;
  double before = 1.0;
  for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
    const double error =
        distance(solved({.relative_tolerance = tolerance, .absolute_tolerance = tolerance}), reference);
    INFO("tolerance " << tolerance << ", error " << error);
    CHECK(error < kMostSteps * tolerance);
    CHECK(error < 0.1 * before);
    before = error;
  }
}

TEST_CASE("Integrating in pieces with the step handed on gives the solution of one go", "[numerics]") {
  const Integration tight{.relative_tolerance = 1e-12, .absolute_tolerance = 1e-12};
  Two y = kStart;
  double step = 0.01;
  for (int i = 0; i < 400; ++i) integrate(pendulum, y, 0.01 * i, 0.01 * (i + 1), tight, step);
  CHECK(distance(y, solved(tight)) < 1e-10);  // 400 steps of 1e-12
  CHECK(step > 0.01);  // the last step was shortened by the end of its piece, the step to try next is not
}

TEST_CASE("A right side that depends on time sees the time of each stage", "[numerics]") {
  std::array<double, 1> y{0.0};
  double step = 0.1;
  integrate([](const auto&, auto& dydt, double t) { dydt[0] = 5.0 * t * t * t * t; }, y, 1.0, 2.0,
            Integration{.relative_tolerance = 1e-10, .absolute_tolerance = 1e-10}, step);
  CHECK(y[0] == Approx(31.0).epsilon(1e-12));  // exact for a polynomial of degree 4
}

TEST_CASE("A solution that runs to infinity ends in an error that names the time", "[numerics]") {
  for (const double start : {1.0, 0.5, 4.0}) {  // q' = q^2 from q0 diverges at 1 / q0
    std::array<double, 1> y{start};
    double step = 0.01;
    std::string reason;
    try {
      integrate([](const auto& q, auto& dqdt, double) { dqdt[0] = q[0] * q[0]; }, y, 0.0, 10.0, Integration{}, step);
    } catch (const NumericalError& error) {
      reason = error.what();
    }
    INFO(reason);
    REQUIRE(reason.find("t = ") != std::string::npos);
    const double named = std::strtod(reason.c_str() + reason.find("t = ") + 4, nullptr);
    CHECK(named == Approx(1.0 / start).epsilon(1e-3));
  }
}

TEST_CASE("A right side that is not finite is an error, not a solution", "[numerics]") {
  for (const double value : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    std::array<double, 1> y{0.0};
    double step = 0.01;
    CHECK_THROWS_AS(integrate([&](const auto&, auto& dydt, double t) { dydt[0] = t > 0.5 ? value : 1.0; }, y, 0.0, 1.0,
                              Integration{}, step),
                    NumericalError);
  }
}

TEST_CASE("An integration stops after max_steps steps", "[numerics]") {
  const auto stiff = [](const auto& y, auto& dydt, double t) { dydt[0] = -1e6 * (y[0] - std::cos(t)); };
  Integration options;
  options.max_steps = 500;
  std::array<double, 1> y{1.0};
  double step = 0.1;
  CHECK_THROWS_WITH(integrate(stiff, y, 0.0, 1.0, options, step), Catch::StartsWith("the integration stalls at t = "));
  options.max_steps = 10'000'000;
  y = {1.0};
  step = 0.1;
  CHECK_NOTHROW(integrate(stiff, y, 0.0, 1.0, options, step));
  CHECK(y[0] == Approx(std::cos(1.0)).epsilon(1e-5));
}

TEST_CASE("An interval of no length leaves the state alone", "[numerics]") {
  Two y = kStart;
  double step = 0.1;
  integrate(pendulum, y, 2.0, 2.0, Integration{}, step);
  CHECK(y == kStart);
  CHECK(step == 0.1);
}
