#include "control/law.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "control/controller.hpp"
#include "support/compare.hpp"
#include "support/families.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr double kRoundOff = 1e-11;  // condition number of the arm's gain up to 1e2

/// Processes together that have learned from some samples of a + b u.
Belief joined_belief(int n, RandomStream& random) {
  Belief belief(example_prior(n), n);
  belief.join();
  for (int k = 0; k < 6; ++k) {
    for (int i = 0; i < n; ++i) {
      TermVector weights = TermVector::Ones(n + 1);
      weights.tail(n) = random_joint_vector(random, n, 3.0);
      belief.learn(i, StateVector(StateVector::Constant(2 * n, 0.1 * k)), weights, draw_normal(random), 0.01);
    }
  }
  return belief;
}

/// Log-normal gain of one joint: u that a belief with these marginals leads to.
double input_of(double drift_mean, double log_gain_mean, double log_gain_variance, double acceleration) {
  const double gain = exponential_of({log_gain_mean, log_gain_variance}).mean;
  return feedback_linearise(JointVector::Constant(1, drift_mean), JointMatrix::Constant(1, 1, gain),
                            JointVector::Constant(1, acceleration))[0];
}

}  // namespace

TEST_CASE("Feedback linearisation gives every plant the desired acceleration", "[control]") {
  RandomStream random = random_stream(1, "law");
  for_each_plant(5, [&]<class PlantType>(const PlantType& plant) {
    constexpr int n = example_joints<PlantType>;
    for (int i = 0; i < 10; ++i) {
      const Affine affine = plant.affine(random_joint_vector(random, n, 4.0), random_joint_vector(random, n, 3.0));
      const JointVector desired = random_joint_vector(random, n, 10.0);
      const JointVector u = feedback_linearise(affine.drift, affine.gain, desired);
      INFO(PlantType::kName);
      CHECK(largest_difference(affine.drift + affine.gain * u, desired) < kRoundOff * (1.0 + affine.drift.norm()));
    }
  });
}

TEST_CASE("Feedback linearisation needs neither a symmetric nor a positive gain", "[control]") {
  RandomStream random = random_stream(2, "law");
  for (int n = 1; n <= kMaxJoints; ++n) {
    JointMatrix gain(n, n);
    for (int i = 0; i < n * n; ++i) gain(i / n, i % n) = draw_uniform(random, -1.0, 1.0);
    gain -= 2.0 * n * JointMatrix::Identity(n, n);
    const JointVector drift = random_joint_vector(random, n, 5.0), desired = random_joint_vector(random, n, 5.0);
    CHECK(largest_difference(drift + gain * feedback_linearise(drift, gain, desired), desired) < kRoundOff);
  }
}

TEST_CASE("Cautious control minimises the expected square of what is missed, the variance counted as asked",
          "[control]") {
  RandomStream random = random_stream(3, "law");
  for (int n = 1; n <= kMaxJoints; ++n) {
    for (const double caution : {0.1, 1.0}) {
      const Belief belief = joined_belief(n, random);
      const StateVector x = StateVector(StateVector::Constant(2 * n, 0.2));
      const BeliefMarginals believed = belief.predict(x);
      const JointVector wanted = random_joint_vector(random, n, 10.0);
      const auto cost = [&](const JointVector& u) {
        double sum = (believed.drift_mean + believed.gain_mean * u - wanted).squaredNorm();
        for (int i = 0; i < n; ++i) sum += caution * belief.acceleration(believed, i, x, u).variance;
        return sum;
      };
      const JointVector u = linearise_cautiously(believed, wanted, caution);
      for (int trial = 0; trial < 20; ++trial) {
        const JointVector other = u + random_joint_vector(random, n, trial % 2 == 0 ? 1.0 : 0.01);
        INFO(n << " joints, caution " << caution);
        CHECK(cost(other) > cost(u));
      }
      CHECK(linearise_cautiously(believed, wanted, 0.0) ==
            feedback_linearise(believed.drift_mean, believed.gain_mean, wanted));
    }
  }
}

TEST_CASE("Cautious control asks for less where b is vague, and for what is wanted where it is known", "[control]") {
  BeliefMarginals believed{JointVector::Constant(1, 1.0),    JointVector::Zero(1), JointMatrix::Constant(1, 1, 2.0),
                           JointMatrix::Constant(1, 1, 0.0), JointVector::Zero(1), JointVector::Zero(1)};
  const JointVector wanted = JointVector::Constant(1, 7.0);
  CHECK(linearise_cautiously(believed, wanted, 0.1)[0] == 3.0);  // processes apart: no covariances
  believed.drift_gain_covariance = JointVector::Zero(1);
  for (const double variance : {0.0, 4.0, 400.0}) {
    believed.gain_covariance = JointMatrix::Constant(1, 1, variance);
    CHECK(linearise_cautiously(believed, wanted, 0.1)[0] == Approx(3.0 * 4.0 / (4.0 + 0.1 * variance)));
  }
  // What is known of a + b u at u = 2 draws the input there.
  believed.gain_covariance = JointMatrix::Constant(1, 1, 1e8);
  believed.drift_gain_covariance = JointVector::Constant(1, -2e8);
  CHECK(linearise_cautiously(believed, wanted, 0.1)[0] == Approx(2.0).epsilon(1e-6));
  believed.gain_covariance = JointMatrix::Constant(1, 1, kInfinity);
  CHECK(linearise_cautiously(believed, wanted, 0.1)[0] == 0.0);
}

TEST_CASE("A gain that cannot be inverted, or no numbers, are a numerical error", "[control]") {
  const auto linearise = [](double drift, double gain) {
    return feedback_linearise(JointVector::Constant(1, drift), JointMatrix::Constant(1, 1, gain), JointVector::Ones(1));
  };
  CHECK_THROWS_WITH(linearise(0.0, 0.0), Catch::Contains("input gain cannot be inverted"));
  CHECK_THROWS_AS(linearise(NAN, 1.0), NumericalError);
  CHECK_THROWS_AS(linearise(0.0, NAN), NumericalError);
  CHECK_THROWS_AS(linearise(INFINITY, 1.0), NumericalError);
  CHECK_THROWS_AS(feedback_linearise(JointVector::Zero(2), JointMatrix::Zero(2, 2), JointVector::Ones(2)),
                  NumericalError);
  CHECK(linearise(0.0, INFINITY)[0] == 0.0);  // an input of no bounded use is not used
}

TEST_CASE("The control is cautious: at a fixed mean of log b, more variance means less input", "[control]") {
  for (const double log_gain : {-1.4, 0.0, 0.7}) {
    for (const double demand : {-3.0, 0.2, 8.0}) {
      const double certain = input_of(1.0, log_gain, 0.0, 1.0 + demand);
      CHECK(certain == Approx(demand / std::exp(log_gain)).epsilon(1e-13));
      double before = std::abs(certain);
      for (const double s2 : {0.01, 0.1, 1.0, 5.0, 50.0}) {
        const double u = input_of(1.0, log_gain, s2, 1.0 + demand);
        CHECK(std::abs(u) < before);
        CHECK(u == Approx(certain * std::exp(-0.5 * s2)).epsilon(1e-12));  // damped exponentially, as the paper says
        before = std::abs(u);
      }
    }
  }
}

TEST_CASE("Inputs are limited one by one", "[control]") {
  const Eigen::Vector3d u(-5.0, 0.5, 2.0);
  CHECK(limited(u, {}) == u);
  CHECK(limited(u, {1.0}) == Eigen::Vector3d(-1.0, 0.5, 1.0));
  CHECK(limited(u, {10.0, 0.1, 2.0}) == Eigen::Vector3d(-5.0, 0.1, 2.0));
}

TEST_CASE("The inner law adds weighted errors to the reference's acceleration", "[control]") {
  const InnerLaw law{3.0, 5.0};
  const ReferencePoint xi{Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(0.5, 0.0), Eigen::Vector2d(-7.0, 0.25)};
  const JointVector u = law(xi, Eigen::Vector2d(0.0, 4.0), Eigen::Vector2d(1.0, -1.0));
  CHECK(u == Eigen::Vector2d(-7.0 + 3.0 * 1.0 + 5.0 * -0.5, 0.25 + 3.0 * -2.0 + 5.0 * 1.0));
}

TEST_CASE("Each controller is its formula", "[control]") {
  const Eigen::Vector2d acceleration(3.0, -1.0);
  JointMatrix gain(2, 2);
  gain << 2.0, 0.5, -0.25, 1.0;
  const Affine truth{Eigen::Vector2d(0.5, 1.5), gain};
  BeliefMarginals belief;
  belief.drift_mean = Eigen::Vector2d(-0.5, 0.25);
  belief.gain_mean = 2.0 * gain;
  const JointVector a = acceleration;
  const LawInput in{a, &truth, &belief};
  CHECK(Proportional{.gain = 100.0}(in) == 100.0 * acceleration);
  CHECK(largest_difference(truth.drift + truth.gain * Oracle{}(in), acceleration) < kRoundOff);
  CHECK(largest_difference(belief.drift_mean + belief.gain_mean * Adaptive{}(in), acceleration) < kRoundOff);
}
