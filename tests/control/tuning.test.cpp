#include "control/tuning.hpp"

#include <catch2/catch.hpp>

#include "support/dense_gp.hpp"
#include "support/families.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

Eigen::MatrixXd points_of(const Posterior& data) { return data.inputs().points(); }

}  // namespace

TEST_CASE("Tuning a process raises its evidence and keeps its data", "[control]") {
  const Eigen::MatrixXd inputs = random_points(30, 2, 2.0, 71);
  for (const auto& [name, kernel] : example_kernels(2)) {
    Posterior data = condition(process_with(kernel, 0.1), inputs, smooth_at(inputs));
    const Posterior before = data;
    RandomStream random = random_stream(1, "tune");
    const int evaluations = tune(data, EvidenceOptions{}, random).evaluations;
    INFO(name);
    CHECK(evaluations > 0);
    CHECK(data.log_marginal_likelihood() > before.log_marginal_likelihood() + 1.0);
    CHECK(points_of(data) == points_of(before));
    CHECK(data.targets() == before.targets());
    CHECK(data.prior().mean == before.prior().mean);
  }
}

TEST_CASE("After tuning, the samples have the noise that was found", "[control]") {
  const Eigen::MatrixXd inputs = random_points(30, 2, 2.0, 72);
  Posterior data = condition(process_with({SquaredExponential{}}, 0.1), inputs, smooth_at(inputs));
  RandomStream random = random_stream(1, "tune");
  tune(data, EvidenceOptions{}, random);
  CHECK(data.prior().noise_variance != 0.1);
  CHECK(data.noise_variances() == std::vector<double>(30, data.prior().noise_variance));
}

TEST_CASE("A process without data is not tuned", "[control]") {
  Posterior data(process_with({SquaredExponential{}}, 0.1), 2);
  RandomStream random = random_stream(1, "tune"), untouched = random;
  CHECK(tune(data, EvidenceOptions{}, random).evaluations == 0);
  CHECK(data.prior().noise_variance == 0.1);
  CHECK(random == untouched);
}

TEST_CASE("Tuning a belief tunes each process that holds data by the options of its kind", "[control]") {
  Belief belief = example_belief(2, 15);
  belief.gain(0, 1) = Posterior(belief.gain(0, 1).prior(), 4);  // no data
  const Belief before = belief;
  Tuning tuning;
  tuning.evidence.bounds.noise_variance = {0.02, 0.02};
  tuning.gain_evidence = tuning.evidence;
  tuning.gain_evidence->bounds.noise_variance = {0.03, 0.03};
  RandomStream random = random_stream(1, "tune");
  const int evaluations = tune(belief, tuning, random).evaluations;
  CHECK(evaluations >= 5);
  for (int i = 0; i < 2; ++i) {
    CHECK(belief.drift(i).prior().noise_variance == 0.02);
    CHECK(belief.drift(i).targets() == before.drift(i).targets());
    for (int j = 0; j < 2; ++j) {
      const bool empty = i == 0 && j == 1;
      CHECK(belief.gain(i, j).prior().noise_variance == (empty ? 0.01 : 0.03));
      CHECK(belief.gain(i, j).targets() == before.gain(i, j).targets());
    }
  }
  CHECK(belief.drift_points() == before.drift_points());
  CHECK(belief.gain_points() == before.gain_points());
}

TEST_CASE("The gain is tuned by the options of the drift unless it has its own", "[control]") {
  Tuning tuning;
  tuning.evidence.restarts = 3;
  CHECK(tuning.for_gain().restarts == 3);
  tuning.gain_evidence = EvidenceOptions{};
  CHECK(tuning.for_gain().restarts == 0);
}

TEST_CASE("Tuning with a prior model keeps the model in the mean", "[control]") {
  BeliefPrior prior = example_prior(1);
  prior.prior_model = Model{Pendulum{}};
  Belief belief(prior, 1);
  const Eigen::MatrixXd inputs = random_points(20, 2, 2.0, 73);
  for (Eigen::Index i = 0; i < 20; ++i) {
    const Eigen::VectorXd x = inputs.row(i);
    belief.drift(0).extend(span_of(x), smooth(x));
  }
  RandomStream random = random_stream(1, "tune");
  tune(belief, Tuning{}, random);
  const Eigen::Vector2d far(1e6, 0.0);
  CHECK(belief.drift(0).predict(span_of(far)).mean == Approx(-9.81 * std::sin(1e6)));
}

TEST_CASE("A process that its data surprise is widened until they do not; one that they do not is left alone",
          "[control]") {
  const Eigen::MatrixXd inputs = random_points(12, 2, 2.0, 74);
  for (const auto& [name, kernel] : example_kernels(2)) {
    INFO(name);
    std::vector<double> targets = smooth_at(inputs);
    for (double& y : targets) y *= 100.0;
    Posterior surprised = condition(process_with(kernel, 1e-6), inputs, targets);
    const double before = variance(surprised.prior().kernel), excess = surprised.mean_squared_innovation();
    REQUIRE(excess > 1.0);
    widen(surprised);
    CHECK(variance(surprised.prior().kernel) == Approx(excess * before));
    CHECK(surprised.mean_squared_innovation() == Approx(1.0).epsilon(0.05));

    for (double& y : targets) y *= 1e-6;
    Posterior calm = condition(process_with(kernel, 0.1), inputs, targets);
    const double untouched = variance(calm.prior().kernel);
    widen(calm);
    CHECK(variance(calm.prior().kernel) == untouched);
  }
}

TEST_CASE("Over its budget a process is widened as it stands, keeps what it knows, and is not tuned", "[control]") {
  const Eigen::MatrixXd inputs = random_points(60, 2, 2.0, 79);
  for (const auto& [name, kernel] : example_kernels(2)) {
    INFO(name);
    std::vector<double> targets;  // large for this kernel, but such as it can have
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      const Eigen::VectorXd x = inputs.row(i);
      targets.push_back(50.0 * covariance(kernel, x, Eigen::Vector2d(0.3, -0.4)) -
                        30.0 * covariance(kernel, x, Eigen::Vector2d(-1.0, 0.5)));
    }
    GaussianProcess prior = process_with(kernel, 1e-3);
    prior.budget = 50;
    Posterior surprised = condition(prior, inputs, targets);
    const Posterior before = surprised;
    const double excess = before.mean_squared_innovation();
    REQUIRE(before.over_budget());
    REQUIRE(excess > 1.0);
    widen(surprised);
    CHECK(surprised.absorbed() == 60);
    CHECK(surprised.mean_squared_innovation() == 0.0);  // what was seen until then no longer counts
    CHECK(variance(surprised.prior().kernel) == Approx(excess * variance(kernel)));
    // As a process that keeps every sample is under the wider prior.
    GaussianProcess wide = process_with(kernel, 1e-3);
    scale_output(wide.kernel, std::sqrt(excess));
    const Posterior exact = condition(wide, inputs, targets);
    for (const Eigen::Vector2d& x : {Eigen::Vector2d(300.0, 211.0), Eigen::Vector2d(inputs.row(7))}) {
      const Marginal value = surprised.predict(span_of(x)), expected = exact.predict(span_of(x));
      CHECK(relative_error(value.mean, expected.mean, std::sqrt(variance(wide.kernel))) < 0.02);
      CHECK(relative_error(value.variance, expected.variance, variance(wide.kernel)) < 0.02);
    }

    const Eigen::Vector2d further(0.1, 0.2);
    const Marginal there = surprised.predict(span_of(further));
    const double sd = std::sqrt(there.variance + 1e-3);
    surprised.extend(span_of(further), there.mean + 3.0 * sd, 1e-3);
    CHECK(surprised.mean_squared_innovation() == Approx(9.0).epsilon(0.05));

    RandomStream random = random_stream(1, "tune");
    const TuneResult result = tune(surprised, EvidenceOptions{}, random);
    CHECK(result.failed == 1);
    CHECK(result.evaluations == 0);
    CHECK(surprised.absorbed() == 61);
  }
}

TEST_CASE("Of a weighted sum that its data surprise the term is widened that they accuse", "[control]") {
  const GaussianProcess term = process_with({SquaredExponential{1.0, {1.0, 1.0}}}, 1e-4);
  const Eigen::MatrixXd inputs = random_points(30, 2, 2.0, 75);
  for (const int accused : {0, 1}) {
    Posterior data(weighted_sum({term, term}), 4);
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      const Eigen::VectorXd x = inputs.row(i);
      const Eigen::Vector2d weights(1.0, i % 2 == 0 ? 0.0 : 2.0);
      const Eigen::Vector4d input(x[0], x[1], weights[0], weights[1]);
      data.extend(span_of(input), 20.0 * weights[accused] * smooth(x), 1e-4);
    }
    REQUIRE(data.mean_squared_innovation() > 1.0);
    widen(data);
    INFO("term " << accused);
    CHECK(variance(term_of(data.prior(), accused).kernel) > 10.0);
    CHECK(variance(term_of(data.prior(), 1 - accused).kernel) == 1.0);
  }
}

TEST_CASE("A process with fewer samples than the least is not tuned", "[control]") {
  Belief belief = example_belief(1, 4);
  const double before = belief.drift(0).prior().noise_variance;
  Tuning tuning;
  tuning.least_samples = 5;
  RandomStream random = random_stream(1, "tune");
  CHECK(tune(belief, tuning, random).evaluations == 0);
  CHECK(belief.drift(0).prior().noise_variance == before);
  tuning.least_samples = 4;
  CHECK(tune(belief, tuning, random).evaluations > 0);
}
