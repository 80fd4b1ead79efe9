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

namespace {

BeliefPrior wide_prior(double gain_scale = 0.4) {
  BeliefPrior prior;
  prior.drift = {process_with({SquaredExponential{2.0, {1.0, 2.0}}}, 1e-4)};
  prior.input_gain = {LogNormalProcess{process_with({SquaredExponential{gain_scale, {2.0, 4.0}}}, 1e-4)}};
  return prior;
}

}  // namespace

TEST_CASE("The acceleration is within its bound at all states at once, as often as it says", "[control]") {
  Eigen::MatrixXd states(5, 2);
  for (int k = 0; k < 5; ++k) states.row(k) << 0.3 * k - 0.5, 0.2 * k;
  for (const bool together : {false, true}) {
    for (const double reach : {0.3, 3.0}) {
      const Eigen::ArrayXd inputs = Eigen::ArrayXd::LinSpaced(5, -reach, reach);
      RandomStream random = random_stream(6, "machines");
      int beyond = 0;
      constexpr int kDraws = 2000;
      for (int draw = 0; draw < kDraws; ++draw) {
        const BeliefPrior prior = wide_prior();
        Posterior drift(prior.drift[0], 2), log_gain(prior.input_gain[0].log, 2);
        Belief belief(prior, 1);
        if (together) belief.join();
        Eigen::ArrayXd a(5), b(5);
        for (int k = 0; k < 5; ++k) {
          const Eigen::Vector2d x = states.row(k);
          const auto value = [&](Posterior& function) {
            const Marginal now = function.predict(span_of(x));
            const double drawn = now.mean + std::sqrt(now.variance) * draw_normal(random);
            function.extend(span_of(x), drawn, 1e-9);
            return drawn;
          };
          a[k] = value(drift);
          const double l = value(log_gain);
          b[k] = std::exp(l);
          // Samples of a + 2 l: their errors are opposite.
          if (together && k % 2 == 0) {
            belief.learn(0, x, Eigen::Vector2d(1.0, 2.0), a[k] + 2.0 * l + 0.1 * draw_normal(random), 1e-2);
          }
        }
        const double bound = acceleration_bound(belief, as_believed(belief), states, inputs, 0.1);
        bool any = false;
        for (int k = 0; k < 5; ++k) {
          const BeliefMarginals expected = belief.predict(StateVector(states.row(k)));
          const double mean = expected.drift_mean[0] + expected.gain_mean(0, 0) * inputs[k];
          any = any || std::abs(a[k] + b[k] * inputs[k] - mean) > bound;
        }
        beyond += any ? 1 : 0;
      }
      INFO("together " << together << ", inputs up to " << reach << ": " << beyond);
      CHECK(beyond <= kDraws / 10);
      if (reach < 1.0) CHECK(beyond >= 1);  // neither is it empty
    }
  }
  const Belief belief(wide_prior(), 1);
  CHECK(acceleration_bound(belief, as_believed(belief), states.topRows(1), Eigen::ArrayXd::Zero(1), 0.1) ==
        Approx(2.0 * 1.9600).epsilon(1e-3));
}

TEST_CASE("Where a and log b are apart both may be other than believed at once", "[control]") {
  const Belief belief(wide_prior(), 1);
  BeliefPrior other = wide_prior();
  other.drift[0].mean = 1.0;
  other.input_gain[0].log.mean = 0.3;
  const PossibleMachines own = as_believed(belief), others = as_believed(Belief(other, 1));
  PossibleMachines either = own;
  either.drift.push_back(others.drift[0]);
  either.log_gain.push_back(others.log_gain[0]);
  const Eigen::MatrixXd state = Eigen::MatrixXd::Zero(1, 2);
  const Eigen::ArrayXd input = Eigen::ArrayXd::Constant(1, 3.0);
  CHECK(acceleration_bound(belief, either, state, input, 0.1) ==
        Approx(acceleration_bound(belief, others, state, input, 0.1)));
}

TEST_CASE("There is no bound where b may be anything, outside of the box, or beyond the input's limit", "[control]") {
  const InnerLaw law{4.0, 3.0};
  const Box box{{-1.0, 3.0}, {-5.0, 5.0}};
  const auto bound = [&](const Belief& belief, double goal, const std::vector<double>& limit = {},
                         double caution = 0.1) {
    return error_bound(law, caution, limit, goal, box, belief, as_believed(belief), 0.05);
  };
  Belief known(wide_prior(0.01), 1);
  for (int k = 0; k < 9; ++k) {
    for (int j = 0; j < 5; ++j) {
      const Eigen::Vector2d x(0.6 + 0.1 * k, 0.4 * j - 0.8);
      known.drift(0).extend(span_of(x), std::sin(x[0]));
    }
  }
  CHECK(bound(known, 1.0) < 0.1);
  CHECK(std::isnan(bound(known, 1.0, {0.1})));
  CHECK(std::isnan(bound(known, 4.0)));
  // What caution leaves of u' is a disturbance, too.
  known.join();
  CHECK(bound(known, 1.0) < 0.1);
  CHECK(bound(known, 1.0, {}, 1e3) > 1.5 * bound(known, 1.0, {}, 0.0));
  CHECK(std::isnan(bound(known, 1.0, {}, 1e9)));
  for (const double scale : {3.0, 30.0, 38.0, 100.0, 1000.0})
    CHECK(std::isnan(bound(Belief(wide_prior(scale), 1), 1.0)));
}
