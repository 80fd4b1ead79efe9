#include "sim/sensor.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/loop.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr int kSamples = 40'000;

Measurement measurement(const Sensor& sensor, double dt = 0.01, int joints = 1) {
  return {sensor, dt, joints, kSamples, random_stream(1, "sensor")};
}

/// A smooth motion: sin(2 t), 2 cos(2 t).
StateVector motion(double t) { return Eigen::Vector2d(std::sin(2.0 * t), 2.0 * std::cos(2.0 * t)); }

}  // namespace

TEST_CASE("A sensor without flaws shows the state", "[sim]") {
  Measurement sensor = measurement({}, 0.01, 2);
  for (int k = 0; k < 10; ++k) {
    const StateVector x = Eigen::Vector4d(k, 0.1 * k, -k, 3.0);
    CHECK(sensor(x) == x);
  }
}

TEST_CASE("The noise has the stated standard deviations, no mean and no memory", "[sim]") {
  constexpr double kPosition = 0.02, kVelocity = 0.5;
  Measurement sensor = measurement({.noise = kPosition, .velocity_noise = kVelocity});
  const StateVector x = Eigen::Vector2d(0.7, -1.0);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), square = mean, lag = mean, before = mean;
  double cross = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    const Eigen::Vector2d e = (sensor(x) - x).cwiseQuotient(Eigen::Vector2d(kPosition, kVelocity));
    mean += e / kSamples;
    square += e.cwiseAbs2() / kSamples;
    lag += e.cwiseProduct(before) / kSamples;
    cross += e[0] * e[1] / kSamples;
    before = e;
  }
  const double bound = 4.0 / std::sqrt(kSamples);  // four standard errors
  CHECK(mean.cwiseAbs().maxCoeff() < bound);
  CHECK((square.array() - 1.0).abs().maxCoeff() < std::sqrt(2.0) * bound);
  CHECK(lag.cwiseAbs().maxCoeff() < bound);
  CHECK(std::abs(cross) < bound);
}

TEST_CASE("Positions are rounded to the nearest multiple of the quantum, after the noise; velocities are not",
          "[sim]") {
  constexpr double kQuantum = 0.01;
  Measurement exact = measurement({.quantum = kQuantum}), noisy = measurement({.noise = 0.1, .quantum = kQuantum});
  for (int k = 0; k < 200; ++k) {
    const StateVector x = motion(0.013 * k);
    const StateVector seen = exact(x), blurred = noisy(x);
    CHECK(std::abs(seen[0] - x[0]) <= 0.5 * kQuantum * (1.0 + 1e-12));
    CHECK(seen[0] / kQuantum == Approx(std::round(seen[0] / kQuantum)).margin(1e-9));
    CHECK(blurred[0] / kQuantum == Approx(std::round(blurred[0] / kQuantum)).margin(1e-9));
    CHECK(seen[1] == x[1]);
  }
}

TEST_CASE("A delay shows the state of so many calls ago, the first one until then", "[sim]") {
  for (const int delay : {1, 3, 20}) {
    Measurement sensor = measurement({.delay_periods = delay});
    for (int k = 0; k < 60; ++k) {
      CHECK(sensor(motion(0.01 * k)) == motion(0.01 * std::max(0, k - delay)));
    }
  }
}

TEST_CASE("Velocities are estimated from the last three positions to second order", "[sim]") {
  const auto worst = [](double dt) {
    Measurement sensor = measurement({.positions_only = true}, dt);
    double error = 0.0;
    for (int k = 0; k < static_cast<int>(2.0 / dt); ++k) {
      const StateVector x = motion(dt * k), seen = sensor(x);
      REQUIRE(seen[0] == x[0]);
      if (k >= 2) error = std::max(error, std::abs(seen[1] - x[1]));
    }
    return error;
  };
  for (const double dt : {0.02, 0.01, 0.005}) CHECK(worst(dt) / worst(0.5 * dt) == Approx(4.0).epsilon(0.02));
}

TEST_CASE("From one position there is no velocity, from two a difference; the true velocity is never seen", "[sim]") {
  Measurement sensor = measurement({.positions_only = true, .velocity_noise = 5.0}, 0.5);
  const auto seen = [&](double q) { return sensor(Eigen::Vector2d(q, std::nan("")))[1]; };
  CHECK(seen(1.0) == 0.0);
  CHECK(seen(1.25) == 0.5);
  CHECK(seen(1.75) == Approx((3.0 * 1.75 - 4.0 * 1.25 + 1.0) / 1.0));
  CHECK(seen(2.5) == Approx((3.0 * 2.5 - 4.0 * 1.75 + 1.25) / 1.0));  // a parabola's slope
}

TEST_CASE("A sensor's noise follows from its stream", "[sim]") {
  Measurement one = measurement({.noise = 1.0}), same = measurement({.noise = 1.0});
  Measurement other({.noise = 1.0}, 0.01, 1, kSamples, random_stream(2, "sensor"));
  for (int k = 0; k < 10; ++k) {
    const StateVector x = motion(0.1 * k);
    const StateVector seen = one(x);
    CHECK(seen == same(x));
    CHECK(seen != other(x));
  }
}

TEST_CASE("Control and learning see what the sensor shows", "[sim]") {
  constexpr double kQuantum = 0.05;
  LoopSetup setup = example_setup(Pendulum{}, Adaptive{}, 1.0);
  setup.belief = Belief(example_prior(1), 1);
  setup.sensor.quantum = kQuantum;
  setup.learner.period = 0.2;
  setup.learner.drift_threshold = 1e-9;
  const LoopResult result = run_loop(setup, random_stream(1, "sensor"));
  REQUIRE(result.belief.drift(0).size() >= 4);
  for (const double q : Eigen::VectorXd(result.belief.drift(0).inputs().points().col(0))) {
    CHECK(q / kQuantum == Approx(std::round(q / kQuantum)).margin(1e-9));
  }
  setup.controller = Oracle{};
  for (const LoopStep& step : run_loop(setup, random_stream(1, "sensor")).steps) {
    const JointVector seen = JointVector::Constant(1, std::round(step.position[0] / kQuantum) * kQuantum);
    const Affine truth = affine(setup.plant, seen, step.velocity);
    const JointVector demand = setup.inner_law(step.reference, seen, step.velocity);
    CHECK(step.input[0] == Approx((demand[0] - truth.drift[0]) / truth.gain(0, 0)).epsilon(1e-12));
  }
}
