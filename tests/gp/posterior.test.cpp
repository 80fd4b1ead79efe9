#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "base/error.hpp"
#include "gp/process.hpp"
#include "support/compare.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr double kDense = 1e-10;  // agreement with dense algebra, condition numbers up to 1e5

Kernel plain() { return {SquaredExponential{1.5, {0.8, 1.2}}}; }

/// The posterior grown sample by sample, with the given noises.
Posterior grown(const GaussianProcess& prior, const Eigen::MatrixXd& inputs, const std::vector<double>& targets,
                const std::vector<double>& noises) {
  Posterior posterior(prior, static_cast<int>(inputs.cols()));
  for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
    const Eigen::VectorXd x = inputs.row(i);
    posterior.extend(span_of(x), targets[i], noises[i]);
  }
  return posterior;
}

/// Compares predictions at 12 points and the marginal likelihood.
void check_against_dense(const Posterior& posterior, const DenseProcess& dense) {
  const double scale = std::max(1.0, variance(posterior.prior().kernel));
  const Eigen::MatrixXd queries = random_points(12, posterior.dimension(), 2.5, 33);
  for (Eigen::Index q = 0; q < queries.rows(); ++q) {
    const Eigen::VectorXd x = queries.row(q);
    const Marginal value = posterior.predict(span_of(x)), expected = dense.predict(x);
    REQUIRE(relative_error(value.mean, expected.mean, scale) < kDense);
    REQUIRE(relative_error(value.variance, expected.variance, scale) < kDense);
  }
  REQUIRE(relative_error(posterior.log_marginal_likelihood(), dense.log_marginal_likelihood(), 1.0) < kDense);
}

}  // namespace

TEST_CASE("Grown sample by sample, a posterior is that of the textbook's matrices for every kernel", "[gp]") {
  for (const int dimension : {1, 2, 3}) {
    const Eigen::MatrixXd inputs = random_points(30, dimension, 2.0, 31);
    const std::vector<double> targets = smooth_at(inputs), noises(30, 1e-2);
    for (const auto& [name, kernel] : example_kernels(dimension)) {
      INFO(name << " in " << dimension << " dimensions");
      const GaussianProcess prior = process_with(kernel, 1e-2);
      check_against_dense(grown(prior, inputs, targets, noises), DenseProcess(prior, inputs, targets, noises));
    }
  }
}

TEST_CASE("A posterior is the same before, at and after the edge of a block of inputs", "[gp]") {
  for (const int n : {1, 3, 4, 5, 63, 64, 65, 130}) {
    const Eigen::MatrixXd inputs = random_points(n, 2, 4.0, 32);
    const std::vector<double> targets = smooth_at(inputs), noises(static_cast<std::size_t>(n), 1e-2);
    const GaussianProcess prior = process_with(plain(), 1e-2);
    INFO(n << " samples");
    check_against_dense(grown(prior, inputs, targets, noises), DenseProcess(prior, inputs, targets, noises));
  }
}

TEST_CASE("Conditioning at once is extending one by one, and leaves the prior's other posteriors alone", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(70, 2, 3.0, 34);
  const std::vector<double> targets = smooth_at(inputs);
  const GaussianProcess prior = process_with(plain(), 1e-2);
  const Posterior at_once = condition(prior, inputs, targets);
  const Posterior one_by_one = grown(prior, inputs, targets, std::vector<double>(70, 1e-2));
  const Eigen::Vector2d x(0.3, 0.4);
  CHECK(at_once.predict(span_of(x)).mean == one_by_one.predict(span_of(x)).mean);
  CHECK(at_once.predict(span_of(x)).variance == one_by_one.predict(span_of(x)).variance);
  CHECK(largest_difference(at_once.inputs().points(), inputs) == 0.0);
  CHECK(at_once.targets() == targets);

  Posterior copy = at_once;
  copy.extend(span_of(x), 5.0);
  CHECK(at_once.size() == 70);
  CHECK(at_once.predict(span_of(x)).mean == one_by_one.predict(span_of(x)).mean);
}

TEST_CASE("The order of the samples does not matter", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(40, 2, 3.0, 35);
  const std::vector<double> targets = smooth_at(inputs);
  const std::vector<double> reversed_targets(targets.rbegin(), targets.rend());
  const GaussianProcess prior = process_with(plain(), 1e-2);
  const Posterior forward = condition(prior, inputs, targets);
  const Posterior backward = condition(prior, inputs.colwise().reverse(), reversed_targets);
  for (const double q : {-2.0, 0.1, 1.7}) {
    const Eigen::Vector2d x(q, -q);
    CHECK(forward.predict(span_of(x)).mean == Approx(backward.predict(span_of(x)).mean).epsilon(kDense).margin(kDense));
    CHECK(forward.predict(span_of(x)).variance ==
          Approx(backward.predict(span_of(x)).variance).epsilon(kDense).margin(kDense));
  }
  CHECK(forward.log_marginal_likelihood() == Approx(backward.log_marginal_likelihood()).epsilon(kDense));
}

TEST_CASE("Without data the posterior is the prior, its variance included", "[gp]") {
  for (const auto& [name, kernel] : example_kernels(2)) {
    GaussianProcess prior = process_with(kernel, 1e-2);
    prior.mean = 1.5;
    const Posterior posterior(prior, 2);
    const Eigen::Vector2d x(0.3, 0.4);
    INFO(name);
    CHECK(posterior.predict(span_of(x)).mean == 1.5);
    CHECK(posterior.predict(span_of(x)).variance == variance(kernel));
    CHECK(posterior.log_marginal_likelihood() == 0.0);
  }
}

TEST_CASE("Each sample may have its own noise", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(25, 2, 2.0, 36);
  const std::vector<double> targets = smooth_at(inputs);
  std::vector<double> noises;
  for (int i = 0; i < 25; ++i) noises.push_back(std::pow(10.0, -4.0 + 0.2 * i));
  const GaussianProcess prior = process_with(plain(), 0.5);
  check_against_dense(condition(prior, inputs, targets, noises), DenseProcess(prior, inputs, targets, noises));
  CHECK(condition(prior, inputs, targets, noises).noise_variances() == noises);
}

TEST_CASE("Under another prior samples keep their own noise, and the others take the new prior's", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(20, 2, 2.0, 37);
  const std::vector<double> targets = smooth_at(inputs);
  const GaussianProcess before = process_with(plain(), 0.5);
  GaussianProcess after = process_with(plain(), 0.5);
  after.noise_variance = 7.0 * before.noise_variance;
  Posterior data(before, 2);
  std::vector<double> noises;
  for (int i = 0; i < 20; ++i) {
    const Eigen::VectorXd x = inputs.row(i);
    const double own = std::pow(10.0, -3.0 + 0.1 * i), y = targets[static_cast<std::size_t>(i)];
    noises.push_back(i % 2 == 0 ? own : after.noise_variance);
    i % 2 == 0 ? data.extend({x.data(), 2}, y, own) : data.extend({x.data(), 2}, y);
  }
  const Posterior again = condition(after, data);
  CHECK(again.noise_variances() == noises);
  check_against_dense(again, DenseProcess(after, inputs, targets, noises));
}

TEST_CASE("The prior's mean is constant, a function, or both", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(25, 2, 2.0, 37);
  const std::vector<double> targets = smooth_at(inputs), noises(25, 1e-2);
  GaussianProcess prior = process_with(plain(), 1e-2);
  prior.mean = -3.0;
  check_against_dense(condition(prior, inputs, targets), DenseProcess(prior, inputs, targets, noises));
  prior.mean_function = [](std::span<const double> x) { return 2.0 * std::sin(x[0]) - x[1]; };
  check_against_dense(condition(prior, inputs, targets), DenseProcess(prior, inputs, targets, noises));
  const Eigen::Vector2d far(1e3, 0.5);
  CHECK(condition(prior, inputs, targets).predict(span_of(far)).mean == -3.0 + 2.0 * std::sin(1e3) - 0.5);
}

TEST_CASE("The mean function may itself be a posterior", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(25, 2, 2.0, 38), other = random_points(40, 2, 2.0, 39);
  const std::vector<double> targets = smooth_at(inputs), noises(25, 1e-2);
  const Posterior nominal = condition(process_with({Matern52{2.0, {1.0, 1.0}}}, 1e-2), other, smooth_at(other));
  GaussianProcess prior = process_with(plain(), 1e-2);
  prior.mean_function = [&](std::span<const double> x) { return 0.5 * nominal.predict(x).mean; };
  check_against_dense(condition(prior, inputs, targets), DenseProcess(prior, inputs, targets, noises));
}

TEST_CASE("A repeated sample without noise is an error that leaves the posterior as it was", "[gp]") {
  for (const auto& [name, kernel] : example_kernels(2)) {
    for (const double noise : {0.0, 1e-18}) {
      const Eigen::MatrixXd inputs = random_points(6, 2, 4.0, 40);
      Posterior posterior = condition(process_with(kernel, noise), inputs, smooth_at(inputs));
      const Eigen::VectorXd repeated = inputs.row(2), query = random_points(1, 2, 2.0, 41).row(0);
      const Marginal before = posterior.predict(span_of(query));
      const double likelihood = posterior.log_marginal_likelihood();
      INFO(name << ", noise variance " << noise);
      CHECK_THROWS_AS(posterior.extend(span_of(repeated), 1.0), NumericalError);
      CHECK(posterior.size() == 6);
      CHECK(posterior.predict(span_of(query)).mean == before.mean);
      CHECK(posterior.predict(span_of(query)).variance == before.variance);
      CHECK(posterior.log_marginal_likelihood() == likelihood);
      posterior.extend(span_of(query), 0.5);
      CHECK(std::isfinite(posterior.predict(span_of(repeated)).mean));
    }
  }
}

TEST_CASE("Repeated samples with noise average", "[gp]") {
  // k = s^2 and noise v at one point: mean s^2 sum(y) / (n s^2 + v), variance s^2 v / (n s^2 + v).
  Posterior posterior(process_with(plain(), 0.4), 2);
  const Eigen::Vector2d x(0.3, 0.4);
  const double s2 = variance(plain());
  for (const double y : {1.0, 2.0, 4.5}) posterior.extend(span_of(x), y);
  CHECK(posterior.predict(span_of(x)).mean == Approx(s2 * 7.5 / (3.0 * s2 + 0.4)).epsilon(1e-12));
  CHECK(posterior.predict(span_of(x)).variance == Approx(s2 * 0.4 / (3.0 * s2 + 0.4)).epsilon(1e-12));
}

TEST_CASE("A sample that is not finite is refused and leaves the posterior as it was", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(10, 2, 2.0, 42);
  Posterior posterior = condition(process_with(plain(), 1e-2), inputs, smooth_at(inputs));
  const Eigen::Vector2d x(0.3, 0.4);
  const double before = posterior.predict(span_of(x)).mean;
  const double nan = std::nan(""), infinity = INFINITY;
  for (const double y : {nan, infinity, -infinity}) CHECK_THROWS_AS(posterior.extend(span_of(x), y), NumericalError);
  for (const double noise : {nan, infinity, -1.0})
    CHECK_THROWS_AS(posterior.extend(span_of(x), 1.0, noise), NumericalError);
  for (const double coordinate : {nan, infinity}) {
    const Eigen::Vector2d wrong(0.3, coordinate);
    CHECK_THROWS_AS(posterior.extend(span_of(wrong), 1.0), NumericalError);
  }
  CHECK(posterior.size() == 10);
  CHECK(posterior.predict(span_of(x)).mean == before);
}

TEST_CASE("A mean function that is not finite is refused and leaves the posterior as it was", "[gp]") {
  GaussianProcess prior = process_with(plain(), 1e-2);
  prior.mean_function = [](std::span<const double> x) { return std::log(x[0]); };
  Posterior posterior(prior, 2);
  const Eigen::Vector2d sound(2.0, 0.0), outside(-1.0, 0.0);
  posterior.extend(span_of(sound), 1.0);
  const double before = posterior.predict(span_of(sound)).mean;
  CHECK_THROWS_AS(posterior.extend(span_of(outside), 1.0), NumericalError);
  CHECK(posterior.size() == 1);
  CHECK(posterior.predict(span_of(sound)).mean == before);
}

TEST_CASE("With hardly any noise the posterior passes through the data", "[gp]") {
  constexpr double kNoise = 1e-10;
  const Eigen::MatrixXd inputs = random_points(12, 2, 4.0, 43);
  const std::vector<double> targets = smooth_at(inputs);
  for (const auto& [name, kernel] : example_kernels(2)) {
    const Posterior posterior = condition(process_with(kernel, kNoise), inputs, targets);
    INFO(name);
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      const Eigen::VectorXd x = inputs.row(i);
      CHECK(posterior.predict(span_of(x)).mean == Approx(targets[i]).margin(1e-4));
      CHECK(posterior.predict(span_of(x)).variance < 10.0 * kNoise);
    }
  }
}

TEST_CASE("The variance never grows with data, is never negative, and forgets the target", "[gp]") {
  for (const auto& [name, kernel] : example_kernels(2)) {
    Posterior posterior(process_with(kernel, 1e-8), 2), other = posterior;
    const Eigen::Vector2d query(0.1, -0.2);
    const Eigen::MatrixXd inputs = random_points(40, 2, 2.0, 44);
    double before = variance(kernel);
    INFO(name);
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      const Eigen::VectorXd x = inputs.row(i);
      posterior.extend(span_of(x), std::sin(static_cast<double>(i)));
      other.extend(span_of(x), 100.0);
      const double now = posterior.predict(span_of(query)).variance;
      REQUIRE(now >= 0.0);
      REQUIRE(now <= before + 1e-12 * variance(kernel));
      REQUIRE(now == other.predict(span_of(query)).variance);
      before = now;
    }
  }
}

TEST_CASE("Several threads may ask one posterior", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(100, 2, 2.0, 45), queries = random_points(200, 2, 2.0, 46);
  const Posterior posterior = condition(process_with(plain(), 1e-2), inputs, smooth_at(inputs));
  const auto ask = [&](std::vector<double>& means) {
    for (Eigen::Index q = 0; q < queries.rows(); ++q) {
      const Eigen::VectorXd x = queries.row(q);
      means.push_back(posterior.predict(span_of(x)).mean);
    }
  };
  std::vector<double> alone;
  ask(alone);
  std::vector<std::vector<double>> together(4);
  std::vector<std::thread> threads;
  for (std::vector<double>& means : together) threads.emplace_back([&] { ask(means); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& means : together) CHECK(means == alone);
}

TEST_CASE("Shapes that do not fit are the caller's error", "[gp]") {
  Posterior posterior(process_with(plain(), 1e-2), 2);
  const Eigen::Vector3d x(1.0, 2.0, 3.0);
  const std::vector<double> two{1.0, 2.0};
  CHECK_THROWS_AS(posterior.predict({x.data(), 3}), std::invalid_argument);
  CHECK_THROWS_AS(posterior.extend({x.data(), 3}, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(Posterior(process_with(plain(), 1e-2), 3), std::invalid_argument);
  CHECK_THROWS_AS(condition(process_with(plain(), 1e-2), Eigen::MatrixXd::Zero(3, 2), two), std::invalid_argument);
  CHECK_THROWS_AS(
      condition(process_with(plain(), 1e-2), Eigen::MatrixXd::Identity(2, 2), two, std::vector<double>{1.0}),
      std::invalid_argument);
}
