#include <catch2/catch.hpp>
#include <cmath>

#include "gp/process.hpp"
#include "support/compare.hpp"
#include "support/dense_gp.hpp"
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
      SparsePosterior sparse(kernel, dimension, 64);
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

TEST_CASE("What leaves the basis is forgotten, and nothing else: the rest is the exact marginal", "[gp]") {
  // Noise so small that each input is its own value: after one left, the others still predict as if they had all been
  // seen without it.
  const Kernel kernel{SquaredExponential{2.0, {0.7, 0.9}}};
  const Eigen::MatrixXd inputs = random_points(40, 2, 3.0, 73);
  const std::vector<double> targets = smooth_at(inputs);
  SparsePosterior sparse(kernel, 2, 16);
  for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
    const Eigen::VectorXd x = inputs.row(i);
    sparse.absorb(span_of(x), targets[static_cast<std::size_t>(i)], 1e-6);
    REQUIRE(sparse.size() <= 16);
  }
  REQUIRE(sparse.size() == 16);
  for (int i = 0; i < sparse.size(); ++i) {
    const Eigen::VectorXd x = sparse.basis().points().row(i);
    Eigen::Index sample = 0;
    (inputs.rowwise() - x.transpose()).rowwise().squaredNorm().minCoeff(&sample);
    const Marginal value = sparse.predict(span_of(x));
    CHECK(value.mean == Approx(targets[static_cast<std::size_t>(sample)]).margin(2e-3));
    CHECK(value.variance < 1.0001e-6);
  }
  // Never surer than the exact one, which has seen as much.
  GaussianProcess prior;
  prior.kernel = kernel;
  prior.noise_variance = 1e-6;
  const Posterior exact = condition(prior, inputs, targets);
  const Eigen::MatrixXd queries = random_points(200, 2, 3.0, 74);
  for (Eigen::Index q = 0; q < queries.rows(); ++q) {
    const Eigen::VectorXd x = queries.row(q);
    CHECK(sparse.predict(span_of(x)).variance > exact.predict(span_of(x)).variance - 1e-8);
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
