#include "control/belief.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "control/belief_record.hpp"
#include "support/compare.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

StateVector state(int joints) { return StateVector::LinSpaced(2 * joints, -0.4, 0.9); }

}  // namespace

TEST_CASE("A belief has a process for each drift and each entry of the gain, over positions and velocities",
          "[control]") {
  for (int n = 1; n <= kMaxJoints; ++n) {
    const Belief belief = example_belief(n, 5);
    CHECK(belief.joints() == n);
    for (int i = 0; i < n; ++i) {
      CHECK(belief.drift(i).dimension() == 2 * n);
      for (int j = 0; j < n; ++j) CHECK(belief.gain(i, j).dimension() == 2 * n);
    }
    const BeliefMarginals marginals = belief.predict(state(n));
    CHECK(marginals.drift_mean.size() == n);
    CHECK(marginals.gain_mean.rows() == n);
    CHECK(marginals.gain_mean.cols() == n);
    CHECK(marginals.log_gain_variance.size() == n);
  }
}

TEST_CASE("What is believed of a state is what its processes say, log-normal on the gain's diagonal", "[control]") {
  for (int n = 1; n <= 3; ++n) {
    Belief belief = example_belief(n, 8);
    for (int i = 0; i < n; ++i) {  // tell the processes apart
      belief.drift(i).extend(span_of(state(n)), 1.0 + i);
      for (int j = 0; j < n; ++j) belief.gain(i, j).extend(span_of(state(n)), 0.1 * i - 0.2 * j);
    }
    const StateVector x = 0.5 * state(n);
    const BeliefMarginals marginals = belief.predict(x);
    for (int i = 0; i < n; ++i) {
      const Marginal drift = belief.drift(i).predict(span_of(x));
      CHECK(marginals.drift_mean[i] == drift.mean);
      CHECK(marginals.drift_variance[i] == drift.variance);
      for (int j = 0; j < n; ++j) {
        const Marginal raw = belief.gain(i, j).predict(span_of(x));
        const Marginal expected = i == j ? exponential_of(raw) : raw;
        INFO("gain " << i << ", " << j);
        CHECK(marginals.gain_mean(i, j) == expected.mean);
        CHECK(marginals.gain_variance(i, j) == expected.variance);
        if (i != j) continue;
        CHECK(marginals.log_gain_mean[i] == raw.mean);
        CHECK(marginals.log_gain_variance[i] == raw.variance);
        CHECK(marginals.gain_mean(i, i) > 0.0);
      }
    }
  }
}

TEST_CASE("One prior serves every joint, or each has its own", "[control]") {
  BeliefPrior prior = example_prior(2);
  const GaussianProcess other = process_with({Matern52{2.0, {1.0, 1.0, 1.0, 1.0}}}, 0.5);
  prior.drift = {prior.drift[0], other};
  prior.input_gain = {LogNormalProcess{other}, prior.input_gain[0]};
  prior.coupling = {prior.coupling[0], other};
  const Belief belief(prior, 2);
  CHECK(belief.drift(0).prior().kernel == prior.drift[0].kernel);
  CHECK(belief.drift(1).prior().kernel == other.kernel);
  CHECK(belief.gain(0, 0).prior().kernel == other.kernel);
  CHECK(belief.gain(1, 1).prior().kernel == prior.input_gain[1].log.kernel);
  CHECK(belief.gain(0, 1).prior().kernel == prior.coupling[0].kernel);
  CHECK(belief.gain(1, 0).prior().kernel == other.kernel);
}

TEST_CASE("Priors that fit neither one nor all joints are refused, the coupling of one joint apart", "[control]") {
  BeliefPrior prior = example_prior(3);
  prior.drift.push_back(prior.drift[0]);
  CHECK_THROWS_AS(Belief(prior, 3), std::invalid_argument);
  prior = example_prior(3);
  prior.input_gain.clear();
  CHECK_THROWS_AS(Belief(prior, 3), std::invalid_argument);
  prior = example_prior(3);
  prior.coupling.clear();
  CHECK_THROWS_AS(Belief(prior, 3), std::invalid_argument);
  prior = example_prior(2);
  CHECK_THROWS_AS(Belief(prior, 3), std::invalid_argument);  // length scales for another machine
  prior = example_prior(1);
  prior.coupling.clear();
  CHECK_NOTHROW(Belief(prior, 1));
}

TEST_CASE("Data points are counted per drift and per column of the gain", "[control]") {
  Belief belief(example_prior(2), 2);
  CHECK(belief.drift_points() == 0);
  CHECK(belief.gain_points() == 0);
  const StateVector x = state(2);
  for (int i = 0; i < 2; ++i) belief.drift(i).extend(span_of(x), 1.0);
  for (int i = 0; i < 2; ++i) belief.gain(i, 1).extend(span_of(x), 1.0);
  CHECK(belief.drift_points() == 1);
  CHECK(belief.gain_points() == 1);
  CHECK(Belief{}.drift_points() == 0);
  CHECK(Belief{}.gain_points() == 0);
}

TEST_CASE("Processes that are joined say what they said apart, and keep their samples under other priors",
          "[control]") {
  for (int n = 1; n <= kMaxJoints; ++n) {
    const Belief apart = example_belief(n, 8);
    Belief together = apart;
    together.join();
    REQUIRE(together.together());
    CHECK(together.joints() == n);
    const StateVector x = 0.5 * state(n);
    JointVector u = JointVector::LinSpaced(n, 0.7, -1.1);
    const auto same = [&](const Belief& left, const Belief& right) {
      const BeliefMarginals value = left.predict(x), expected = right.predict(x);
      for (int i = 0; i < n; ++i) {
        INFO(n << " joints, joint " << i);
        CHECK(value.drift_mean[i] == Approx(expected.drift_mean[i]).epsilon(1e-9));
        CHECK(value.drift_variance[i] == Approx(expected.drift_variance[i]).epsilon(1e-9));
        CHECK(value.log_gain_mean[i] == Approx(expected.log_gain_mean[i]).epsilon(1e-9));
        const Marginal motion = left.acceleration(value, i, x, u), other = right.acceleration(expected, i, x, u);
        CHECK(motion.mean == Approx(other.mean).epsilon(1e-9));
        CHECK(motion.variance == Approx(other.variance).epsilon(1e-9));
        for (int j = 0; j < n; ++j) {
          CHECK(value.gain_mean(i, j) == Approx(expected.gain_mean(i, j)).epsilon(1e-9));
          CHECK(value.gain_variance(i, j) == Approx(expected.gain_variance(i, j)).epsilon(1e-9));
          CHECK(left.points(i, j) == right.points(i, j));
          CHECK(left.gain_prior(i, j).kernel == right.gain_prior(i, j).kernel);
        }
        CHECK(left.points(i, -1) == right.points(i, -1));
        CHECK(left.drift_prior(i).kernel == right.drift_prior(i).kernel);
      }
      CHECK(left.drift_points() == right.drift_points());
      CHECK(left.gain_points() == right.gain_points());
    };
    same(together, apart);
    const Belief fresh(example_prior(n), n);
    same(fresh.with_samples(together), fresh.with_samples(apart));
    CHECK_FALSE(fresh.together());
  }
}

TEST_CASE("A process over its budget cannot be joined", "[control]") {
  BeliefPrior prior = example_prior(1);
  prior.drift[0].budget = 4;
  Belief belief(prior, 1);
  for (int k = 0; k < 6; ++k) belief.drift(0).extend(std::vector{0.1 * k, 0.0}, 1.0, 1e-2);
  CHECK_THROWS_WITH(belief.join(), Catch::Contains("over budget"));
}

TEST_CASE("Making room changes nothing that is believed", "[control]") {
  Belief belief = example_belief(2, 7);
  const BeliefMarginals before = belief.predict(state(2));
  belief.reserve(1000);
  const BeliefMarginals after = belief.predict(state(2));
  CHECK(before.drift_mean == after.drift_mean);
  CHECK(before.gain_variance == after.gain_variance);
}

TEST_CASE("With a prior model and no data, every plant is believed to be that model", "[control]") {
  RandomStream random = random_stream(1, "prior model");
  for_each_plant(2, [&]<class PlantType>(const PlantType& plant) {
    constexpr int n = example_joints<PlantType>;
    BeliefPrior prior = example_prior(n);
    prior.prior_model = Model{plant};
    for (LogNormalProcess& process : prior.input_gain) {
      process.log.kernel.form = SquaredExponential{1e-8, std::vector<double>(2 * n, 1.0)};  // hardly uncertain: E b = b
    }
    const Belief belief(prior, n);
    const JointVector q = random_joint_vector(random, n, 3.0), v = random_joint_vector(random, n, 3.0);
    StateVector x(2 * n);
    x << q, v;
    const Affine truth = plant.affine(q, v);
    const BeliefMarginals marginals = belief.predict(x);
    INFO(PlantType::kName);
    CHECK(largest_difference(marginals.drift_mean, truth.drift) < 1e-13 * (1.0 + truth.drift.norm()));
    CHECK(largest_difference(marginals.gain_mean, truth.gain) < 1e-13 * truth.gain.norm());
    CHECK(marginals.drift_variance == JointVector::Ones(n));
  });
  BeliefPrior prior = example_prior(1);
  prior.prior_model = Model{TwoLinkArm{}};
  CHECK(prior.problem(1) == "prior_model has another number of joints than the machine");
}

TEST_CASE("Processes are as wide as their prior model says that it may be wrong, unless that is not wanted",
          "[control]") {
  BeliefPrior prior = example_prior(3);
  prior.prior_model = Model{Custom({}, {"u1", "u2", "u3"}, {})};
  prior.prior_model->uncertainty = ModelUncertainty{{0.3, 0.2, 0.1}, {0.05}, {0.7, 0.8, 0.9}};
  const auto sd = [](const Posterior& process) { return std::sqrt(variance(process.prior().kernel)); };
  const Belief scaled(prior, 3);
  prior.scale_to_model = false;
  const Belief own(prior, 3);
  for (int i = 0; i < 3; ++i) {
    INFO("joint " << i + 1);
    const auto joint = static_cast<std::size_t>(i);
    CHECK(sd(scaled.drift(i)) == Approx(prior.prior_model->uncertainty->drift[joint]));
    CHECK(sd(scaled.gain(i, i)) == Approx(0.05));
    CHECK(sd(scaled.gain(i, (i + 1) % 3)) == Approx(prior.prior_model->uncertainty->coupling[joint]));
    CHECK(own.drift(i).prior().kernel == prior.drift[0].kernel);
    CHECK(own.gain(i, i).prior().kernel == prior.input_gain[0].log.kernel);
  }
  prior.prior_model->uncertainty->coupling.pop_back();
  CHECK(prior.problem(3) == "uncertainty of prior_model: coupling has one number for all joints or one for each");
}

TEST_CASE("A record gives back what was believed at each call, without covariances", "[control]") {
  for (int n = 1; n <= kMaxJoints; ++n) {
    Belief belief = example_belief(n, 8);
    belief.join();
    BeliefRecord record;
    CHECK(record.empty());
    std::vector<BeliefMarginals> given;
    for (int k = 0; k < 3; ++k) {
      given.push_back(belief.predict((0.2 + 0.1 * k) * state(n)));
      record.push_back(given.back());
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const BeliefMarginals kept = record[k];
      CHECK(kept.drift_mean == given[k].drift_mean);
      CHECK(kept.drift_variance == given[k].drift_variance);
      CHECK(kept.gain_mean == given[k].gain_mean);
      CHECK(kept.gain_variance == given[k].gain_variance);
      CHECK(kept.log_gain_mean == given[k].log_gain_mean);
      CHECK(kept.log_gain_variance == given[k].log_gain_variance);
      CHECK(kept.gain_covariance.size() == 0);
    }
  }
}
