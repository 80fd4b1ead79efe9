#include <catch2/catch.hpp>
#include <cmath>

#include "gp/process.hpp"
#include "support/compare.hpp"
#include "support/dense_gp.hpp"
#include "support/dense_sparse.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

GaussianProcess with_budget(GaussianProcess prior, int budget) {
  prior.budget = budget;
  return prior;
}

/// Root mean square of the difference of the two means, over the queries.
double rms_between(const Posterior& a, const Posterior& b, const Eigen::MatrixXd& queries) {
  double sum = 0.0;
  for (Eigen::Index q = 0; q < queries.rows(); ++q) {
    const Eigen::VectorXd x = queries.row(q);
    sum += std::pow(a.predict(span_of(x)).mean - b.predict(span_of(x)).mean, 2);
  }
  return std::sqrt(sum / static_cast<double>(queries.rows()));
}

/// State k of 33 a second along a motion that fills its range again and again, and wanders by `pace` a second.
Eigen::Vector2d along_a_motion(int k, double pace = 0.0) {
  const double t = 0.03 * k;
  return {1.5 * std::sin(0.8 * t) + 1.9 * std::sin(0.031 * t) + pace * t,
          1.2 * std::cos(0.8 * t) + 1.5 * std::cos(0.0231 * t)};
}

/// -9.81 sin x1 - 2 x2, the drift of a pendulum.
std::vector<double> drift_at(const Eigen::MatrixXd& inputs) {
  std::vector<double> y;
  for (Eigen::Index i = 0; i < inputs.rows(); ++i) y.push_back(-9.81 * std::sin(inputs(i, 0)) - 2.0 * inputs(i, 1));
  return y;
}

/// The same of the difference from `drift_at`.
double rms_error(const Posterior& posterior, const Eigen::MatrixXd& queries) {
  const std::vector<double> truth = drift_at(queries);
  double sum = 0.0;
  for (Eigen::Index q = 0; q < queries.rows(); ++q) {
    const Eigen::VectorXd x = queries.row(q);
    sum += std::pow(posterior.predict(span_of(x)).mean - truth[static_cast<std::size_t>(q)], 2);
  }
  return std::sqrt(sum / static_cast<double>(queries.rows()));
}

}  // namespace

TEST_CASE("While every input fits into the basis, the sparse process is the exact one, for every kernel", "[gp]") {
  for (const int dimension : {1, 2, 3}) {
    const Eigen::MatrixXd inputs = random_points(40, dimension, 2.0, 71);
    const std::vector<double> targets = smooth_at(inputs);
    const Eigen::MatrixXd queries = random_points(20, dimension, 2.5, 72);
    for (const auto& [name, kernel] : example_kernels(dimension)) {
      INFO(name << " in " << dimension << " dimensions");
      const GaussianProcess prior = process_with(kernel, 1e-2);
      const Posterior exact = condition(prior, inputs, targets);
      SparsePosterior sparse(process_with(kernel, 0.0), dimension, 64);
      for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
        const Eigen::VectorXd x = inputs.row(i);
        sparse.absorb(span_of(x), targets[static_cast<std::size_t>(i)] - prior.mean, 1e-2);
      }
      const double scale = std::max(1.0, variance(kernel));
      for (Eigen::Index q = 0; q < queries.rows(); ++q) {
        const Eigen::VectorXd x = queries.row(q);
        const Marginal value = sparse.predict(span_of(x)), expected = exact.predict(span_of(x));
        CHECK(relative_error(value.mean + prior.mean, expected.mean, scale) < 2e-3);
        CHECK(relative_error(value.variance, expected.variance, scale) < 2e-3);
      }
      CHECK(sparse.log_likelihood() == Approx(exact.log_marginal_likelihood()).epsilon(2e-2));
    }
  }
}

TEST_CASE("The sparse process is its plain twin, for every kernel along a motion", "[gp]") {
  for (const auto& [name, kernel] : example_kernels(2)) {
    for (const double noise : {1e-3, 1e-1}) {
      INFO(name << ", noise " << noise);
      SparsePosterior sparse(process_with(kernel, 0.0), 2, 12);
      DenseSparsePosterior plain(kernel, 12);
      RandomStream random(73);
      double largest = 0.0;
      for (int k = 0; k < 1500; ++k) {
        const Eigen::Vector2d x = along_a_motion(k);
        const double y = smooth(x) + std::sqrt(noise) * draw_normal(random);
        sparse.absorb(span_of(x), y, noise);
        plain.absorb(x, y, noise);
        for (const Eigen::Vector2d& query : {x, Eigen::Vector2d(0.3, -0.4)}) {
          const Marginal value = sparse.predict(span_of(query)), expected = plain.predict(query);
          largest =
              std::max({largest, std::abs(value.mean - expected.mean), std::abs(value.variance - expected.variance)});
        }
      }
      CHECK(plain.left() > 10);
      CHECK(largest < 1e-3 * variance(kernel));
    }
  }
}

TEST_CASE("A budget follows a motion that goes away for good, and a thousand changes cost no digit", "[gp]") {
  const Kernel kernel{SquaredExponential{2.0, {0.7, 0.9}}};
  SparsePosterior sparse(process_with(kernel, 0.0), 2, 12);
  DenseSparsePosterior plain(kernel, 12);
  for (int k = 0; k < 30000; ++k) {
    const Eigen::Vector2d x = along_a_motion(k, 0.5);
    sparse.absorb(span_of(x), smooth(x), 0.1);
    plain.absorb(x, smooth(x), 0.1);
    REQUIRE(sparse.predict(span_of(x)).variance < 0.1 * variance(kernel));
  }
  CHECK(plain.left() > 1000);
  const Eigen::Vector2d x = along_a_motion(30000, 0.5);
  CHECK(sparse.predict(span_of(x)).mean == Approx(plain.predict(x).mean).epsilon(1e-6));
  CHECK(sparse.predict(span_of(x)).variance == Approx(plain.predict(x).variance).epsilon(1e-6));
}

TEST_CASE("What leaves the basis is forgotten, and nothing else: the rest is the exact marginal", "[gp]") {
  // One input of three leaves for a far one: what the others have learned from all samples stays.
  const Kernel kernel{SquaredExponential{2.0, {1.0}}};
  const std::vector<double> inputs{0.0, 0.5, 1.5, 40.0}, targets{1.0, -0.5, 0.7, 2.0};
  SparsePosterior sparse(process_with(kernel, 0.0), 1, 3);
  GaussianProcess prior;
  prior.kernel = kernel;
  Posterior exact(prior, 1);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    sparse.absorb({&inputs[i], 1}, targets[i], 0.1);
    exact.extend({&inputs[i], 1}, targets[i], 0.1);
  }
  REQUIRE(sparse.size() == 3);
  for (int i = 0; i < 3; ++i) {
    const double x = sparse.basis().points()(i, 0);
    INFO(x);
    CHECK(sparse.predict({&x, 1}).mean == Approx(exact.predict({&x, 1}).mean).epsilon(1e-6));
    CHECK(sparse.predict({&x, 1}).variance == Approx(exact.predict({&x, 1}).variance).epsilon(1e-6));
  }
  const double gone = 0.5;  // the middle one, which the others know best
  CHECK(sparse.predict({&gone, 1}).variance > 2.0 * exact.predict({&gone, 1}).variance);
}

TEST_CASE("Many samples of much noise teach as much as they do the exact process", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(600, 1, 2.0, 81);
  for (const auto& [name, kernel] : leaf_kernels(1)) {
    INFO(name);
    const double noise = 1500.0 * variance(kernel);
    GaussianProcess prior = process_with(kernel, noise);
    SparsePosterior sparse(prior, 1, 100);
    Posterior exact(prior, 1);
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      sparse.absorb({&inputs(i, 0), 1}, 3.0, noise);
      exact.extend({&inputs(i, 0), 1}, 3.0 + prior.mean, noise);
    }
    for (const double x : {-1.7, 0.0, 0.9}) {
      const Marginal value = sparse.predict({&x, 1}), expected = exact.predict({&x, 1});
      CHECK(value.mean + prior.mean == Approx(expected.mean).epsilon(0.02));
      CHECK(value.variance == Approx(expected.variance).epsilon(0.02));
    }
  }
}

TEST_CASE("A scaled sparse process is one that has absorbed all under the scaled prior, for every kernel", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(40, 2, 2.0, 79);
  const std::vector<double> targets = smooth_at(inputs);
  for (const auto& [name, kernel] : example_kernels(2)) {
    for (const double factor : {0.5, 30.0}) {
      INFO(name << " times " << factor);
      Kernel scaled = kernel;
      scale_output(scaled, factor);
      SparsePosterior sparse(process_with(kernel, 0.0), 2, 64), expected(process_with(scaled, 0.0), 2, 64);
      for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
        const Eigen::VectorXd x = inputs.row(i);
        sparse.absorb(span_of(x), targets[static_cast<std::size_t>(i)], 1e-2);
        expected.absorb(span_of(x), targets[static_cast<std::size_t>(i)], 1e-2);
      }
      sparse.scale_output(factor);
      for (const Eigen::Vector2d& x : {Eigen::Vector2d(0.3, -0.4), Eigen::Vector2d(2.5, 1.0)}) {
        const Marginal value = sparse.predict(span_of(x)), other = expected.predict(span_of(x));
        CHECK(relative_error(value.mean, other.mean, std::sqrt(variance(scaled))) < 5e-3);
        CHECK(relative_error(value.variance, other.variance, variance(scaled)) < 5e-3);
      }
      // And goes on as one.
      const Eigen::Vector2d further(-3.0, 2.0);
      for (SparsePosterior* process : {&sparse, &expected}) process->absorb(span_of(further), 5.0, 1e-2);
      CHECK(sparse.predict(span_of(further)).mean == Approx(expected.predict(span_of(further)).mean).epsilon(5e-3));
    }
  }
}

TEST_CASE("A budget costs little where inputs lie densely along a motion", "[gp]") {
  const int samples = 1200;
  Eigen::MatrixXd inputs(samples, 2), queries(samples / 4, 2);
  for (int k = 0; k < samples; ++k) inputs.row(k) = along_a_motion(k).transpose();
  for (int k = 0; k < samples / 4; ++k) queries.row(k) = 0.5 * (inputs.row(4 * k) + inputs.row(4 * k + 1));
  for (const double noise : {1e-4, 1e-3, 1e-2}) {
    GaussianProcess prior;
    prior.noise_variance = noise;
    prior.kernel.form = SquaredExponential{10.0, {1.5, 4.0}};
    std::vector<double> targets = drift_at(inputs);
    RandomStream random(78);
    for (double& y : targets) y += std::sqrt(noise) * draw_normal(random);
    const Posterior exact = condition(prior, inputs, targets);
    for (const int budget : {50, 100, 200}) {
      INFO("noise " << noise << ", budget " << budget);
      const Posterior sparse = condition(with_budget(prior, budget), inputs, targets);
      CHECK(rms_error(sparse, queries) < 1.1 * rms_error(exact, queries));
      const std::vector<double> truth = drift_at(queries);
      int outside = 0;
      for (Eigen::Index q = 0; q < queries.rows(); ++q) {
        const Eigen::VectorXd x = queries.row(q);
        const Marginal value = sparse.predict(span_of(x));
        if (std::abs(value.mean - truth[static_cast<std::size_t>(q)]) > 3.0 * std::sqrt(value.variance)) ++outside;
      }
      CHECK(outside < queries.rows() / 20);
    }
  }
}

TEST_CASE("Over its budget a process keeps learning: within 5 % of the exact one's error", "[gp]") {
  GaussianProcess prior;
  prior.noise_variance = 1e-2;
  prior.kernel.form = SquaredExponential{10.0, {1.5, 4.0}};
  const Eigen::MatrixXd inputs = random_points(2000, 2, 3.14, 75), queries = random_points(500, 2, 3.0, 76);
  std::vector<double> targets = drift_at(inputs);
  RandomStream random(77);
  for (double& y : targets) y += 0.1 * draw_normal(random);
  const Posterior exact = condition(prior, inputs, targets),
                  sparse = condition(with_budget(prior, 100), inputs, targets);
  CHECK(sparse.absorbed() == 2000);
  CHECK(sparse.size() == 100);
  CHECK(sparse.over_budget());
  CHECK(rms_error(sparse, queries) < 1.05 * rms_error(exact, queries));
  CHECK(rms_between(sparse, exact, queries) < 0.05 * rms_error(exact, queries));
  CHECK(sparse.mean_squared_innovation() == Approx(exact.mean_squared_innovation()).epsilon(0.05));
  CHECK(sparse.log_marginal_likelihood() == Approx(exact.log_marginal_likelihood()).epsilon(0.05));
}

TEST_CASE("Until it is spent, a budget changes no bit", "[gp]") {
  for (const auto& [name, kernel] : example_kernels(2)) {
    INFO(name);
    const GaussianProcess prior = process_with(kernel, 1e-2);
    const Eigen::MatrixXd inputs = random_points(60, 2, 2.0, 78);
    const std::vector<double> targets = smooth_at(inputs);
    const Posterior all = condition(prior, inputs, targets), some = condition(with_budget(prior, 60), inputs, targets);
    const Eigen::Vector2d x(0.3, -0.4);
    CHECK(some.predict(span_of(x)).mean == all.predict(span_of(x)).mean);
    CHECK(some.predict(span_of(x)).variance == all.predict(span_of(x)).variance);
    CHECK_FALSE(some.over_budget());
  }
}
