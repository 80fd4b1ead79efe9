#include "gp/evidence.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "support/compare.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr double kRoundOff = 1e-11;   // two factorisations of one matrix, condition number below 1e5
constexpr double kDifference = 1e-6;  // central difference with step 1e-3, extrapolated; by a period it bends most

Posterior smooth_data(const GaussianProcess& prior, int n, int dimension) {
  const Eigen::MatrixXd inputs = random_points(n, dimension, 2.0, 51);
  return condition(prior, inputs, smooth_at(inputs));
}

/// Pointers to what the evidence depends on, in the order of `evidence_parameters`.
std::vector<double*> parameters_of(GaussianProcess& prior) {
  std::vector<double*> list;
  for (const HyperParameter& parameter : hyper_parameters(prior.kernel)) list.push_back(parameter.value);
  list.push_back(&prior.noise_variance);
  return list;
}

void check_gradient(const GaussianProcess& prior, const Posterior& data) {
  const Evidence result = evidence(prior, data);
  GaussianProcess moved = prior;
  const std::vector<double*> parameters = parameters_of(moved);
  const std::vector<std::string> names = evidence_parameters(prior);
  REQUIRE(result.gradient.size() == static_cast<Eigen::Index>(parameters.size()));
  REQUIRE(names.size() == parameters.size());
  const double scale = std::max(1.0, result.gradient.cwiseAbs().maxCoeff());
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const double value = *parameters[p];
    const double expected = derivative(
        [&](double log_value) {
          *parameters[p] = std::exp(log_value);
          return evidence(moved, data).value;
        },
        std::log(value), 1e-3);
    *parameters[p] = value;
    INFO("by " << names[p]);
    REQUIRE(relative_error(result.gradient[static_cast<Eigen::Index>(p)], expected, scale) < kDifference);
  }
}

}  // namespace

TEST_CASE("The evidence is the posterior's log marginal likelihood for every kernel", "[gp]") {
  for (const int n : {1, 2, 30, 64, 65, 66, 130}) {
    for (const auto& [name, kernel] : example_kernels(2)) {
      GaussianProcess prior = process_with(kernel, 1e-2);
      prior.mean = 0.4;
      prior.mean_function = [](std::span<const double> x) { return 0.5 * x[0]; };
      const Posterior data = smooth_data(prior, n, 2);
      INFO(name << ", " << n << " samples");
      CHECK(relative_error(evidence(prior, data).value, data.log_marginal_likelihood(), 1.0) < kRoundOff);
    }
  }
}

TEST_CASE("The gradient of the evidence equals central differences for every kernel", "[gp]") {
  for (const int dimension : {1, 2, 3}) {
    for (const auto& [name, kernel] : example_kernels(dimension)) {
      const GaussianProcess prior = process_with(kernel, 1e-2);
      INFO(name << " in " << dimension << " dimensions");
      check_gradient(prior, smooth_data(prior, 20, dimension));
    }
  }
}

TEST_CASE("The gradient of the evidence is right beyond one block of inputs", "[gp]") {
  for (const int n : {1, 64, 65, 66, 130}) {
    for (const auto& [name, kernel] : leaf_kernels(2)) {
      const GaussianProcess prior = process_with(kernel, 1e-2);
      INFO(name << ", " << n << " samples");
      check_gradient(prior, smooth_data(prior, n, 2));
    }
  }
}

TEST_CASE("The evidence is that of the prior asked about, not of the one that the data were absorbed with", "[gp]") {
  const GaussianProcess first = process_with({SquaredExponential{1.0, {1.0, 1.0}}}, 1e-2);
  GaussianProcess second = process_with({Matern32{2.0, {0.5, 3.0}}}, 0.3);
  second.mean = -1.0;
  const Eigen::MatrixXd inputs = random_points(30, 2, 2.0, 52);
  const std::vector<double> targets = smooth_at(inputs);
  const Posterior data = condition(first, inputs, targets);
  CHECK(evidence(second, data).value ==
        Approx(DenseProcess(second, inputs, targets, std::vector<double>(30, 0.3)).log_marginal_likelihood())
            .epsilon(kRoundOff));
  CHECK(condition(second, data).noise_variances() == std::vector<double>(30, 0.3));
}

TEST_CASE("Samples with a noise of their own count with it, in the evidence and in its gradient", "[gp]") {
  GaussianProcess prior = process_with(example_kernels(2).front().value, 1e-2);
  const Eigen::MatrixXd inputs = random_points(20, 2, 2.0, 53);
  const std::vector<double> targets = smooth_at(inputs);
  Posterior data(prior, 2);
  for (int i = 0; i < 20; ++i) {
    const Eigen::VectorXd x = inputs.row(i);
    const double y = targets[static_cast<std::size_t>(i)];
    i % 3 == 0 ? data.extend({x.data(), 2}, y, 0.3) : data.extend({x.data(), 2}, y);
  }
  CHECK(relative_error(evidence(prior, data).value, data.log_marginal_likelihood(), 1.0) < kRoundOff);
  check_gradient(prior, data);
  prior.noise_variance = 0.2;
  CHECK(relative_error(evidence(prior, data).value, condition(prior, data).log_marginal_likelihood(), 1.0) < kRoundOff);
}

TEST_CASE("Without data the evidence is one, whatever the parameters", "[gp]") {
  const GaussianProcess prior = process_with({SquaredExponential{}}, 1e-2);
  const Evidence result = evidence(prior, Posterior(prior, 2));
  CHECK(result.value == 0.0);
  CHECK(result.gradient == Eigen::VectorXd::Zero(4));
  CHECK(evidence_parameters(prior) == std::vector<std::string>{"kernel.output_scale", "kernel.length_scales.0",
                                                               "kernel.length_scales.1", "noise_variance"});
}

TEST_CASE("Repeated samples without noise have no evidence", "[gp]") {
  GaussianProcess prior = process_with({SquaredExponential{}}, 1e-2);
  Posterior data(prior, 2);
  const Eigen::Vector2d x(0.3, 0.4);
  for (int i = 0; i < 3; ++i) data.extend(span_of(x), 1.0);
  prior.noise_variance = 0.0;
  CHECK_THROWS_WITH(evidence(prior, data), "the covariance matrix of 3 samples is not positive definite");
}

TEST_CASE("The evidence does not depend on what the memory held before", "[gp]") {
  const GaussianProcess prior = process_with({SquaredExponential{}}, 1e-2);
  for (const int n : {5, 12, 30, 70}) {
    const Posterior data = smooth_data(prior, n, 2);
    const double expected = data.log_marginal_likelihood();
    for (int pattern = 0; pattern < 3; ++pattern) {
      {
        std::vector<Eigen::MatrixXd> litter;
        for (int i = 0; i < 8; ++i) litter.push_back(Eigen::MatrixXd::Constant(n, n, pattern == 0 ? NAN : INFINITY));
      }
      INFO(n << " samples");
      CHECK(evidence(prior, data).value == Approx(expected).epsilon(kRoundOff));
    }
  }
}
