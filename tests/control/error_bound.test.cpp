// The bound on the tracking error against integrals, and against loops that begin at their goal.

#include "control/error_bound.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "support/dense_gp.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

TEST_CASE("The gains of a disturbance are the integrals of the impulse response and of its rate", "[control]") {
  for (const auto& [w1, w2] : {std::pair{1.0, 1.0}, {4.0, 4.0}, {4.0, 3.0}, {9.0, 5.0}, {2.0, 9.0}, {9.0, 0.6}}) {
    INFO("w1 = " << w1 << ", w2 = " << w2);
    double h = 0.0, rate = 1.0, position = 0.0, velocity = 0.0;
    constexpr double kStep = 1e-5;
    for (double t = 0.0; t < 60.0; t += kStep) {
      position += std::abs(h) * kStep;
      velocity += std::abs(rate) * kStep;
      rate += kStep * (-w1 * h - w2 * rate);
      h += kStep * rate;
    }
    const DisturbanceGain gain = disturbance_gain({w1, w2});
    CHECK(gain.position == Approx(position).epsilon(1e-3));
    CHECK(gain.velocity == Approx(velocity).epsilon(1e-3));
  }
}

TEST_CASE("A disturbance that is the same everywhere bounds the error by its gain; one that grows too fast by nothing",
          "[control]") {
  const DisturbanceGain gain = disturbance_gain({4.0, 3.0});
  std::vector<double> radii;
  for (double r = 1e-3; r < 2.0; r *= 1.1) radii.push_back(r);
  const double p = gain.position;
  CHECK(contained_error(gain, radii, [](double) { return 0.3; }) == Approx(0.3 * p));
  CHECK(contained_error(gain, radii, [p](double r) { return 0.1 + 0.5 / p * r; }) == Approx(0.2 * p).epsilon(0.1));
  CHECK(std::isnan(contained_error(gain, radii, [p](double r) { return 0.1 + 1.2 / p * r; })));
  CHECK(std::isnan(contained_error(gain, {}, [](double) { return 0.0; })));
}

TEST_CASE("The acceleration is within its bounds at all states at once, as often as they say", "[control]") {
  BeliefPrior prior;
  prior.drift = {process_with({SquaredExponential{2.0, {1.0, 2.0}}}, 1e-4)};
  prior.input_gain = {LogNormalProcess{process_with({SquaredExponential{0.4, {2.0, 4.0}}}, 1e-4)}};
  Belief belief(prior, 1);
  Eigen::MatrixXd states(5, 2);
  for (int k = 0; k < 5; ++k) states.row(k) << 0.3 * k - 0.5, 0.2 * k;
  for (const bool together : {false, true}) {
    if (together) belief.join();
    for (const double reach : {0.3, 3.0}) {
      const Eigen::ArrayXd inputs = Eigen::ArrayXd::LinSpaced(5, -reach, reach);
      const Eigen::ArrayXd bounds = acceleration_bounds(belief, {belief}, states, inputs, 0.1);
      RandomStream random = random_stream(6, "machines");
      int beyond = 0;
      constexpr int kDraws = 2000;
      for (int draw = 0; draw < kDraws; ++draw) {
        Posterior drift(prior.drift[0], 2), log_gain(prior.input_gain[0].log, 2);
        bool any = false;
        for (int k = 0; k < 5; ++k) {
          const Eigen::Vector2d x = states.row(k);
          const auto value = [&](Posterior& function) {
            const Marginal now = function.predict(span_of(x));
            const double drawn = now.mean + std::sqrt(now.variance) * draw_normal(random);
            function.extend(span_of(x), drawn, 1e-9);
            return drawn;
          };
          const double a = value(drift), b = std::exp(value(log_gain));
          const BeliefMarginals expected = belief.predict(x);
          any = any ||
                std::abs(a + b * inputs[k] - expected.drift_mean[0] - expected.gain_mean(0, 0) * inputs[k]) > bounds[k];
        }
        beyond += any ? 1 : 0;
      }
      INFO("together " << together << ", inputs up to " << reach << ": " << beyond);
      CHECK(beyond <= kDraws / 10);
      CHECK(beyond >= kDraws / 1000);  // neither is it empty
    }
  }
  CHECK(acceleration_bounds(belief, {belief}, states.topRows(1), Eigen::ArrayXd::Zero(1), 0.1)[0] ==
        Approx(2.0 * 1.9600).epsilon(1e-3));
}
