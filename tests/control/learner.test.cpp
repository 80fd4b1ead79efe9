#include "control/learner.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/compare.hpp"
#include "support/dense_gp.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

/// Marginals of a machine of two joints about which nothing is uncertain.
BeliefMarginals certain() {
  return {JointVector::Zero(2),    JointVector::Zero(2), JointMatrix::Identity(2, 2),
          JointMatrix::Zero(2, 2), JointVector::Zero(2), JointVector::Zero(2)};
}

/// One joint, its processes together, as wide as these scales.
Belief belief_with(double drift_scale, double gain_scale, double drift_noise = 1e-6, double gain_noise = 1e-6) {
  BeliefPrior prior;
  prior.drift = {process_with({SquaredExponential{drift_scale, {2.0, 2.0}}}, drift_noise)};
  prior.input_gain = {LogNormalProcess{process_with({SquaredExponential{gain_scale, {2.0, 2.0}}}, gain_noise)}};
  Belief belief(prior, 1);
  belief.join();
  return belief;
}

Learner example_learner() {
  Learner learner;
  learner.drift_threshold = 0.1;
  learner.gain_threshold = 0.2;
  learner.probing_input = {1.5, -2.5};
  return learner;
}

/// A smooth motion of two joints: states at t, t + dt, t + 2 dt.
std::array<StateVector, 3> motion(double t, double dt) {
  std::array<StateVector, 3> x;
  for (int k = 0; k < 3; ++k) {
    const double s = t + k * dt;
    x[k] = Eigen::Vector4d(std::sin(1.3 * s), std::exp(-0.5 * s), 1.3 * std::cos(1.3 * s), -0.5 * std::exp(-0.5 * s));
  }
  return x;
}

Eigen::Vector2d acceleration_at(double s) { return {-1.69 * std::sin(1.3 * s), 0.25 * std::exp(-0.5 * s)}; }

Derivative sample_at(const StateVector& x, const Eigen::Vector2d& acceleration) {
  return {x, acceleration, JointVector::Zero(2), {}};
}

JointVector exact() { return JointVector::Zero(2); }

const StateVector kState = Eigen::Vector4d(0.3, -0.2, 1.0, 0.5);

}  // namespace

TEST_CASE("Nothing is learned where nothing is uncertain", "[control]") {
  CHECK_FALSE(decide(example_learner(), certain(), exact(), -1, 7).has_value());
}

TEST_CASE("The drift is learned first, then the first uncertain column", "[control]") {
  BeliefMarginals belief = certain();
  belief.log_gain_variance = Eigen::Vector2d(0.3, 0.3);
  belief.drift_variance = Eigen::Vector2d(0.0, 0.11);  // any joint's drift
  REQUIRE(decide(example_learner(), belief, exact(), -1, 7).has_value());
  CHECK(decide(example_learner(), belief, exact(), -1, 7)->column == Probe::kDrift);
  CHECK(decide(example_learner(), belief, exact(), -1, 7)->start == 7);
  belief.drift_variance.setZero();
  CHECK(decide(example_learner(), belief, exact(), -1, 7)->column == 0);
  belief.log_gain_variance[0] = 0.0;
  CHECK(decide(example_learner(), belief, exact(), -1, 7)->column == 1);
}

TEST_CASE("A column is uncertain by any of its entries, beside the diagonal by b itself", "[control]") {
  BeliefMarginals belief = certain();
  belief.gain_variance(0, 1) = 0.3;  // entry of column 1
  CHECK(decide(example_learner(), belief, exact(), -1, 0)->column == 1);
  belief = certain();
  belief.gain_variance(1, 0) = 0.3;
  CHECK(decide(example_learner(), belief, exact(), -1, 0)->column == 0);
  belief.log_gain_mean = Eigen::Vector2d(0.5, 1.0);
  CHECK(decide(example_learner(), belief, exact(), -1, 0)->column == 0);
  Learner watched = example_learner();  // with a monitor in units of b_11 b_22 = e^1.5, the threshold 0.2 of that
  watched.monitor.emplace();
  CHECK_FALSE(decide(watched, belief, exact(), -1, 0).has_value());
  belief.gain_variance(1, 0) = 1.0;
  CHECK(decide(watched, belief, exact(), -1, 0)->column == 0);
  belief = certain();
  belief.gain_variance(0, 0) = belief.gain_variance(1, 1) = 100.0;  // on the diagonal it is log b that counts
  CHECK_FALSE(decide(example_learner(), belief, exact(), -1, 0).has_value());
}

TEST_CASE("A variance at its threshold is small enough", "[control]") {
  BeliefMarginals belief = certain();
  belief.drift_variance.setConstant(0.1);
  belief.log_gain_variance.setConstant(0.2);
  belief.gain_variance.setConstant(0.2);
  CHECK_FALSE(decide(example_learner(), belief, exact(), -1, 0).has_value());
  belief.log_gain_variance[1] = std::nextafter(0.2, 1.0);
  CHECK(decide(example_learner(), belief, exact(), -1, 0)->column == 1);
  belief.drift_variance[0] = std::nextafter(0.1, 1.0);
  CHECK(decide(example_learner(), belief, exact(), -1, 0)->column == Probe::kDrift);
}

TEST_CASE("A probe of the drift holds no input, one of a column holds u_j e_j", "[control]") {
  Learner learner = example_learner();
  CHECK(probing_input(learner, {Probe::kDrift, 0}, 2) == Eigen::Vector2d(0.0, 0.0));
  CHECK(probing_input(learner, {0, 0}, 2) == Eigen::Vector2d(1.5, 0.0));
  CHECK(probing_input(learner, {1, 0}, 2) == Eigen::Vector2d(0.0, -2.5));
  learner.probing_input = {4.0};
  CHECK(probing_input(learner, {1, 0}, 2) == Eigen::Vector2d(0.0, 4.0));
  learner.probing_input = {1.0, 0.0};
  CHECK(learner.problem() == "probing_input must not be 0: b cannot be seen without an input");
  CHECK(example_learner().problem().empty());
}

TEST_CASE("Both estimates of the derivatives are those of the middle sample, of second order", "[control]") {
  constexpr double kStart = 0.4;
  const auto errors = [&](auto&& estimate, double dt) {
    const std::array<StateVector, 3> x = motion(kStart - dt, dt);  // the middle stays
    const Derivative found = estimate(x, dt);
    return Eigen::Vector2d((found.x - x[1]).norm(), (found.acceleration - acceleration_at(kStart)).norm());
  };
  const auto check_order = [](double coarse, double fine) { CHECK(coarse / fine == Approx(4.0).epsilon(0.02)); };
  for (const double dt : {0.1, 0.05, 0.025}) {
    const Eigen::Vector2d states = errors(estimate_from_states, dt), half = errors(estimate_from_states, 0.5 * dt);
    CHECK(states[0] == 0.0);  // the state is the measured one
    check_order(states[1], half[1]);
    const Eigen::Vector2d positions = errors(estimate_from_positions, dt),
                          fine = errors(estimate_from_positions, 0.5 * dt);
    check_order(positions[0], fine[0]);
    check_order(positions[1], fine[1]);
  }
}

TEST_CASE("Estimates from positions do not look at the velocities, and keep the measured position", "[control]") {
  std::array<StateVector, 3> x = motion(0.0, 0.01);
  const Derivative before = estimate_from_positions(x, 0.01);
  for (StateVector& state : x) state.tail(2).setConstant(std::nan(""));
  const Derivative after = estimate_from_positions(x, 0.01);
  CHECK(before.x == after.x);
  CHECK(before.acceleration == after.acceleration);
  CHECK(after.x.head(2) == x[1].head(2));
}

TEST_CASE("A probe of the drift adds its acceleration to every joint's drift and to nothing else", "[control]") {
  Belief belief(example_prior(2), 2);
  CHECK(absorb(belief, example_learner(), {Probe::kDrift, 0}, sample_at(kState, {3.0, -4.0})).skipped == 0);
  CHECK(belief.drift(0).targets() == std::vector<double>{3.0});
  CHECK(belief.drift(1).targets() == std::vector<double>{-4.0});
  CHECK(belief.drift(0).inputs().points().row(0) == kState.transpose());
  CHECK(belief.drift(0).noise_variances() == std::vector<double>{0.01});
  CHECK(belief.gain_points() == 0);
}

TEST_CASE("A probe of a column adds (q'' - E a) / u_j to that column, its logarithm on the diagonal", "[control]") {
  Belief belief = example_belief(2, 6);
  const BeliefMarginals before = belief.predict(kState);
  const Eigen::Vector2d acceleration(3.0, -4.0);
  CHECK(absorb(belief, example_learner(), {1, 0}, sample_at(kState, acceleration)).refused == 0);
  const Eigen::Vector2d estimate = (acceleration - before.drift_mean) / -2.5;
  REQUIRE(estimate[1] > 0.0);
  CHECK(belief.gain(0, 1).targets().back() == Approx(estimate[0]).epsilon(1e-14));
  CHECK(belief.gain(1, 1).targets().back() == Approx(std::log(estimate[1])).epsilon(1e-14));
  for (int i = 0; i < 2; ++i) {
    CHECK(belief.gain(i, 1).size() == 7);
    CHECK(belief.gain(i, 1).noise_variances().back() == 0.01);  // the prior's
    CHECK(belief.gain(i, 1).inputs().points().row(6) == kState.transpose());
    CHECK(belief.gain(i, 0).size() == 6);
    CHECK(belief.drift(i).size() == 6);
  }
}

TEST_CASE("The noise of a sample of b is propagated as the paper has it, through the logarithm on the diagonal",
          "[control]") {
  Belief belief = example_belief(2, 6);
  const BeliefMarginals before = belief.predict(kState);
  Learner learner = example_learner();
  learner.gain_noise = GainNoise::propagated;
  const Eigen::Vector2d acceleration(3.0, -4.0);
  absorb(belief, learner, {1, 0}, sample_at(kState, acceleration));
  const double b = (acceleration[1] - before.drift_mean[1]) / -2.5;
  // var b_j = (var x2' + var a) / u_j^2, the first being the drift's own noise; var log b = var b / b^2.
  const double beside = (0.01 + before.drift_variance[0]) / (2.5 * 2.5);
  const double diagonal = (0.01 + before.drift_variance[1]) / (2.5 * 2.5) / (b * b);
  CHECK(belief.gain(0, 1).noise_variances().back() == Approx(beside).epsilon(1e-13));
  CHECK(belief.gain(1, 1).noise_variances().back() == Approx(diagonal).epsilon(1e-13));
}

TEST_CASE("A gain that is not positive has no logarithm: it is refused, counted, and nothing changes", "[control]") {
  for (const double acceleration : {4.0, 0.0, std::nan("")}) {  // with u = -2.5 and no drift: b = -1.6, 0, none
    Belief belief(example_prior(2), 2);
    INFO("acceleration " << acceleration);
    CHECK(absorb(belief, example_learner(), {1, 0}, sample_at(kState, {1.0, acceleration})).refused == 1);
    for (int i = 0; i < 2; ++i) {
      CHECK(belief.drift(i).size() == 0);
      for (int j = 0; j < 2; ++j) CHECK(belief.gain(i, j).size() == 0);
    }
  }
  Belief belief(example_prior(2), 2);  // beside the diagonal any sign will do
  CHECK(absorb(belief, example_learner(), {1, 0}, sample_at(kState, {1.0, -4.0})).refused == 0);
  CHECK(belief.gain(0, 1).targets().back() == -0.4);
}

TEST_CASE("What is tolerated of each joint's drift is no reason for a probe", "[control]") {
  BeliefMarginals belief = certain();
  belief.drift_variance = Eigen::Vector2d(0.15, 0.4);
  CHECK(decide(example_learner(), belief, Eigen::Vector2d(0.2, 0.3), -1, 0)->column == Probe::kDrift);
  CHECK_FALSE(decide(example_learner(), belief, Eigen::Vector2d(0.2, 0.5), -1, 0).has_value());
}

TEST_CASE("In turn, a and the columns of b are probed one after the other, a only where a sample would halve it",
          "[control]") {
  Learner learner = example_learner();
  learner.order = ProbeOrder::in_turn;
  BeliefMarginals belief = certain();
  belief.drift_variance = Eigen::Vector2d(0.15, 0.0);
  belief.log_gain_variance = Eigen::Vector2d(0.3, 0.3);
  const auto after = [&](int last, double noise) {
    return decide(learner, belief, Eigen::Vector2d(noise, noise), last, 0).value().column;
  };
  CHECK(after(-2, 0.0) == Probe::kDrift);
  CHECK(after(Probe::kDrift, 0.0) == 0);
  CHECK(after(0, 0.0) == 1);
  CHECK(after(1, 0.0) == Probe::kDrift);
  CHECK(after(1, 0.14) == Probe::kDrift);
  CHECK(after(1, 0.16) == 0);  // a sample of a would leave more than half of its variance
  belief.log_gain_variance.setZero();
  CHECK(after(Probe::kDrift, 0.0) == Probe::kDrift);
  CHECK_FALSE(decide(learner, belief, Eigen::Vector2d(0.16, 0.16), Probe::kDrift, 0).has_value());
  CHECK(decide(learner, belief, Eigen::Vector2d(0.16, 0.16), Probe::kDrift, 0, 0b10).value().column == 1);  // wanted
}

TEST_CASE("A sample in passing teaches a where b is known, b where a is, and else their sum", "[control]") {
  Learner learner;
  learner.drift_threshold = 1e-4;
  const Derivative sample{Eigen::Vector2d(0.3, -0.1), JointVector::Constant(1, 5.0), JointVector::Constant(1, 2.0),
                          JointVector::Constant(1, 1e-6)};
  Belief open_drift = belief_with(10.0, 1e-3), open_gain = belief_with(1e-3, 0.3), both = belief_with(1.0, 0.5);
  CHECK(absorb_in_passing(open_drift, learner, sample).taken == 1);
  CHECK(open_drift.points(0, Probe::kDrift) == 1);
  CHECK(open_drift.points(0, 0) == 1);
  CHECK(open_drift.predict(sample.x).drift_mean[0] == Approx(5.0 - 2.0).epsilon(1e-3));         // E b = 1
  for (int k = 0; k < 5; ++k) CHECK(absorb_in_passing(open_gain, learner, sample).taken == 1);  // linearised anew
  CHECK(open_gain.predict(sample.x).gain_mean(0, 0) == Approx(2.5).epsilon(0.05));              // E a = 0
  for (int k = 0; k < 5; ++k) absorb_in_passing(both, learner, sample);
  const BeliefMarginals learned = both.predict(sample.x);
  const Marginal motion = both.acceleration(learned, 0, sample.x, sample.input);
  CHECK(motion.mean == Approx(5.0).epsilon(0.02));
  CHECK(std::sqrt(motion.variance) < 0.1);
  CHECK(std::sqrt(learned.drift_variance[0]) > 0.5);  // neither is known by itself
  CHECK(std::sqrt(learned.gain_variance(0, 0)) > 0.3);
  CHECK(both.motion(0).predict_terms(span_of(sample.x)).covariance(0, 1) < 0.0);

  // What is known and does not surprise is no news; what surprises is.
  Belief known = belief_with(1e-4, 1e-5);
  Derivative again = sample;
  again.acceleration[0] = 2.0;
  CHECK(absorb_in_passing(known, learner, again).taken == 0);
  again.acceleration[0] += 0.1;
  const Absorbed surprising = absorb_in_passing(known, learner, again);
  CHECK(surprising.taken == 1);
  CHECK(surprising.surprises[0] > 2.0);
}

TEST_CASE("A drift that is believed to be known does not turn its surprise into a b without bound", "[control]") {
  // q'' = -7 where 0 +- 0.05 is believed, while an earlier input still acts: linear in log b that is e^-20.
  Belief belief = belief_with(0.05, 0.5, 1e-4, 1e-5);
  const Derivative sample{Eigen::Vector2d(0.9, -0.1), JointVector::Constant(1, -7.0), JointVector::Constant(1, 0.26),
                          JointVector::Constant(1, 1e-6)};
  const Absorbed absorbed = absorb(belief, Learner{}, Probe{}, sample);
  CHECK(absorbed.taken == 1);
  CHECK(absorbed.surprises[0] < -20.0);
  const BeliefMarginals told = belief.predict(sample.x);
  CHECK(told.log_gain_mean[0] == Approx(0.0).margin(1e-9));
  CHECK(told.drift_mean[0] < -0.5);
}

TEST_CASE("Where the errors of a and b are opposite, a second sample in passing teaches their sum", "[control]") {
  Belief belief = belief_with(3.0, 0.3, 1e-4, 1e-5);
  Learner learner;
  learner.drift_threshold = 1e-4;
  Derivative sample{Eigen::Vector2d(0.3, -0.1), JointVector::Constant(1, 5.0), JointVector::Constant(1, 4.0),
                    JointVector::Constant(1, 0.01)};
  CHECK(absorb_in_passing(belief, learner, sample).taken == 1);
  const auto expected = [&] { return belief.acceleration(belief.predict(sample.x), 0, sample.x, sample.input).mean; };
  const double before = expected();
  sample.acceleration[0] = before + 0.3;
  CHECK(absorb_in_passing(belief, learner, sample).taken == 1);
  CHECK(expected() - before == Approx(0.15).margin(0.05));
}

TEST_CASE("Together a probe of b is a sample of a + b u, or where its jump told of b alone", "[control]") {
  for (const int n : {1, 2}) {
    Belief belief(example_prior(n), n);
    belief.join();
    Learner learner;
    learner.probing_input = {2.0};
    learner.gain_threshold = 0.04;
    const StateVector x = StateVector::LinSpaced(2 * n, -0.4, 0.9);
    const Probe probe{n - 1, 0};
    Derivative sample{x, JointVector::Constant(n, 9.0), JointVector::Zero(n), JointVector::Constant(n, 1e-4)};
    sample.input[n - 1] = 2.0;
    const Belief before = belief;
    sample.acceleration = before.predict(x).drift_mean.array() + 2.0 * 1.7;
    CHECK(absorb(belief, learner, probe, sample).taken == n);
    for (int i = 0; i < n; ++i) {
      INFO(n << " joints, joint " << i);
      CHECK(belief.points(i, Probe::kDrift) == 1);
      CHECK(belief.points(i, n - 1) == 1);
      CHECK(belief.acceleration(belief.predict(x), i, x, sample.input).variance <
            0.1 * before.acceleration(before.predict(x), i, x, sample.input).variance);
      CHECK(belief.motion(i).predict_terms(span_of(x)).covariance(0, n) < 0.0);
    }
    sample.gain = JointVector::Constant(n, 1.7);
    sample.gain_variance = JointVector::Constant(n, 1e-6);
    CHECK(absorb(belief, learner, probe, sample).taken == n);
    CHECK(belief.points(0, Probe::kDrift) == 1);
    CHECK(belief.points(0, n - 1) == 2);
    CHECK(belief.predict(x).gain_mean(n - 1, n - 1) == Approx(1.7).epsilon(0.1));
    sample.gain = JointVector::Constant(n, -1.7);
    CHECK(absorb(belief, learner, probe, sample).refused == 1);
  }
}

TEST_CASE("What a probe of b leaves uncertain of a is as wrong as it says", "[control]") {
  constexpr int kDraws = 2000;
  Learner learner;
  learner.probing_input = {6.0};
  const Eigen::Vector2d x(0.3, -0.1);
  for (const double drift_scale : {0.3, 1.0, 3.0}) {
    RandomStream random = random_stream(11, "machines");
    double squares = 0.0, of_gain = 0.0;
    int taken = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const double a = drift_scale * draw_normal(random), log_b = 0.5 * draw_normal(random);
      Belief belief = belief_with(drift_scale, 0.5, 1e-4, 1e-4);
      const Derivative sample{x, JointVector::Constant(1, a + 6.0 * std::exp(log_b) + 1e-2 * draw_normal(random)),
                              JointVector::Constant(1, 6.0), JointVector::Constant(1, 1e-4)};
      taken += absorb(belief, learner, Probe{0, 0}, sample).taken;
      const BeliefMarginals told = belief.predict(x);
      squares += std::pow(a - told.drift_mean[0], 2) / told.drift_variance[0] / kDraws;
      of_gain += std::pow(log_b - told.log_gain_mean[0], 2) / told.log_gain_variance[0] / kDraws;
    }
    INFO("a within " << drift_scale);
    CHECK(taken > 0.95 * kDraws);  // estimates of b that are not positive are refused
    CHECK(std::sqrt(squares) < 1.2);
    CHECK(std::sqrt(squares) > 0.7);
    CHECK(std::sqrt(of_gain) < 1.2);
  }
}

TEST_CASE("Of a probe's jump and of the drift that estimate of b is taken that is accurate enough, else the better one",
          "[control]") {
  Belief belief = example_belief(1, 10);
  Learner learner;
  learner.gain_threshold = 0.04;
  learner.probing_input = {2.0};
  const Probe probe{0, 0};
  Derivative sample{Eigen::Vector2d(0.1, 0.2), JointVector::Constant(1, 3.0), JointVector::Constant(1, 2.0),
                    JointVector::Constant(1, 1e-4)};
  const GainEstimate by_drift = estimate_gain(belief, learner, probe, sample);
  const double mean = belief.drift(0).predict(span_of(sample.x)).mean;
  CHECK(by_drift.value[0] == Approx((3.0 - mean) / 2.0));
  sample.gain = JointVector::Constant(1, 1.7);
  sample.gain_variance = JointVector::Constant(1, 0.9 * asked_gain_variance(learner) * 1.7 * 1.7);
  CHECK(estimate_gain(belief, learner, probe, sample).value[0] == 1.7);
  sample.gain_variance = JointVector::Constant(1, 1e3);
  CHECK(estimate_gain(belief, learner, probe, sample).value[0] == by_drift.value[0]);
}
