// Functions that are observed in sums.

#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "gp/evidence.hpp"
#include "support/compare.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr int kSumSamples = 30, kSumInputs = 2, kSumTerms = 3;
constexpr double kTogether = 1e-8;  // of matrices with condition numbers up to 1e6

/// Three functions: one of the family, and two that are other than it.
GaussianProcess sum_with(const Kernel& kernel) {
  GaussianProcess first = process_with(kernel, 1e-2), second = process_with({Matern32{0.7, {1.5, 0.9}}}, 1e-3),
                  third = process_with({SquaredExponential{2.0, {0.8, 3.0}}}, 1e-2);
  first.mean = 0.4;
  second.mean = -1.2;
  third.mean_function = [](std::span<const double> x) { return 0.3 * x[0] - x[1]; };
  return weighted_sum({first, second, third});
}

struct Data {
  Eigen::MatrixXd states, weights;
  std::vector<double> targets, noise;
};

Data samples() {
  Data data{random_points(kSumSamples, kSumInputs, 2.0, 91), random_points(kSumSamples, kSumTerms, 3.0, 92), {}, {}};
  for (int i = 0; i < kSumSamples; ++i) {
    if (i % 3 == 0) data.weights.row(i) = Eigen::RowVector3d::Unit(i % 9 / 3);  // of one function alone
    data.targets.push_back(smooth(data.states.row(i)) * data.weights.row(i).sum());
    data.noise.push_back(0.01 + 0.02 * (i % 4));
  }
  return data;
}

Eigen::VectorXd joined(const Eigen::VectorXd& x, const Eigen::VectorXd& weights) {
  Eigen::VectorXd input(x.size() + weights.size());
  input << x, weights;
  return input;
}

Posterior absorbed(const GaussianProcess& sum, const Data& data) {
  Posterior posterior(sum, kSumInputs + kSumTerms);
  for (int i = 0; i < kSumSamples; ++i) {
    posterior.extend(span_of(joined(data.states.row(i), data.weights.row(i))),
                     data.targets[static_cast<std::size_t>(i)], data.noise[static_cast<std::size_t>(i)]);
  }
  return posterior;
}

/// Means and covariance of the terms by the textbook's algebra: f_c and y are jointly normal.
TermMarginals dense_terms(const GaussianProcess& sum, const Data& data, const Eigen::VectorXd& x) {
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(kSumSamples, kSumSamples), cross(kSumSamples, kSumTerms);
  Eigen::VectorXd rest(kSumSamples);
  TermMarginals result{TermVector(kSumTerms), TermMatrix::Zero(kSumTerms, kSumTerms)};
  for (int i = 0; i < kSumSamples; ++i) {
    rest[i] = data.targets[static_cast<std::size_t>(i)];
    k(i, i) = data.noise[static_cast<std::size_t>(i)];
  }
  for (int c = 0; c < kSumTerms; ++c) {
    const GaussianProcess& term = term_of(sum, c);
    const Eigen::VectorXd w = data.weights.col(c);
    k += w.asDiagonal() * gram(term.kernel, data.states, data.states) * w.asDiagonal();
    cross.col(c) = w.asDiagonal() * gram(term.kernel, data.states, x.transpose()).col(0);
    for (int i = 0; i < kSumSamples; ++i) {
      const Eigen::VectorXd at = data.states.row(i);
      rest[i] -= w[i] * term.prior_mean(span_of(at));
    }
    result.covariance(c, c) = variance(term.kernel);
    result.mean[c] = term.prior_mean(span_of(x));
  }
  result.mean += cross.transpose() * dense::solve(k, rest);
  for (int c = 0; c < kSumTerms; ++c) {
    result.covariance.col(c) -= cross.transpose() * dense::solve(k, Eigen::VectorXd(cross.col(c)));
  }
  return result;
}

void check_terms(const TermMarginals& value, const TermMarginals& expected, double tolerance) {
  for (int c = 0; c < kSumTerms; ++c) {
    CHECK(relative_error(value.mean[c], expected.mean[c], 1.0) < tolerance);
    for (int d = 0; d < kSumTerms; ++d) {
      CHECK(relative_error(value.covariance(c, d), expected.covariance(c, d), 1.0) < tolerance);
    }
  }
}

}  // namespace

TEST_CASE("The terms of a weighted sum are those of the textbook's algebra, for every kernel", "[gp]") {
  const Data data = samples();
  const Eigen::MatrixXd queries = random_points(10, kSumInputs, 2.5, 93),
                        weights = random_points(10, kSumTerms, 2.0, 94);
  for (const auto& [name, kernel] : example_kernels(kSumInputs)) {
    INFO(name);
    const GaussianProcess sum = sum_with(kernel);
    const Posterior posterior = absorbed(sum, data);
    for (Eigen::Index q = 0; q < queries.rows(); ++q) {
      const Eigen::VectorXd x = queries.row(q);
      const TermMarginals value = posterior.predict_terms(span_of(x)), expected = dense_terms(sum, data, x);
      check_terms(value, expected, kTogether);
      // And the sum itself is theirs.
      const Eigen::VectorXd w = weights.row(q);
      const Marginal all = posterior.predict(span_of(joined(x, w)));
      CHECK(all.mean == Approx(w.dot(expected.mean)).epsilon(1e-7));
      CHECK(all.variance == Approx(w.dot(expected.covariance * w)).epsilon(1e-6));
      CHECK(term_at(posterior, span_of(x), 1).mean == value.mean[1]);
      CHECK(term_at(posterior, span_of(x), 1).variance == value.covariance(1, 1));
    }
  }
}

TEST_CASE("Functions that are observed one at a time stay independent, and are what they are apart", "[gp]") {
  Data data = samples();
  for (int i = 0; i < kSumSamples; ++i) data.weights.row(i) = Eigen::RowVector3d::Unit(i % 3);
  for (const auto& [name, kernel] : example_kernels(kSumInputs)) {
    INFO(name);
    const GaussianProcess sum = sum_with(kernel);
    const Posterior together = absorbed(sum, data);
    const Eigen::Vector2d x(0.3, -0.7);
    const TermMarginals value = together.predict_terms(span_of(x));
    for (int c = 0; c < kSumTerms; ++c) {
      Posterior alone(term_of(sum, c), kSumInputs);
      for (int i = c; i < kSumSamples; i += 3) {
        const Eigen::VectorXd at = data.states.row(i);
        alone.extend(span_of(at), data.targets[static_cast<std::size_t>(i)], data.noise[static_cast<std::size_t>(i)]);
      }
      CHECK(relative_error(value.mean[c], alone.predict(span_of(x)).mean, 1.0) < kTogether);
      CHECK(relative_error(value.covariance(c, c), alone.predict(span_of(x)).variance, 1.0) < kTogether);
      for (int d = 0; d < c; ++d) CHECK(std::abs(value.covariance(c, d)) < 1e-12);
    }
  }
}

TEST_CASE("A sum that was observed is known though its terms are not: their errors are opposite", "[gp]") {
  const GaussianProcess term = process_with({SquaredExponential{2.0, {1.0, 1.0}}}, 1e-6);
  Posterior posterior(weighted_sum({term, term}), 4);
  const Eigen::Vector4d sample(0.2, 0.1, 1.0, 3.0);
  posterior.extend(span_of(sample), 5.0, 1e-6);
  const Eigen::Vector2d x(0.2, 0.1);
  const TermMarginals terms = posterior.predict_terms(span_of(x));
  CHECK(terms.covariance(0, 0) == Approx(4.0 * 0.9));
  CHECK(terms.covariance(1, 1) == Approx(4.0 * 0.1));
  CHECK(terms.covariance(0, 1) == Approx(-4.0 * 0.3));
  CHECK(posterior.predict(span_of(sample)).variance < 1e-5);
  CHECK(posterior.predict(span_of(sample)).mean == Approx(5.0));
}

TEST_CASE("Over its budget a weighted sum is the exact one as long as all inputs fit into the basis", "[gp]") {
  const Data data = samples();
  for (const auto& [name, kernel] : example_kernels(kSumInputs)) {
    INFO(name);
    const GaussianProcess sum = sum_with(kernel);
    const Posterior exact = absorbed(sum, data);
    SparsePosterior sparse(sum, kSumInputs + kSumTerms, 64);
    Posterior means(sum, kSumInputs + kSumTerms);  // the prior's
    for (int i = 0; i < kSumSamples; ++i) {
      const Eigen::VectorXd input = joined(data.states.row(i), data.weights.row(i));
      sparse.absorb(span_of(input), data.targets[static_cast<std::size_t>(i)] - means.predict(span_of(input)).mean,
                    data.noise[static_cast<std::size_t>(i)]);
    }
    const Eigen::Vector2d x(-0.4, 0.6);
    TermMarginals value = sparse.predict_terms(span_of(x));
    value.mean += means.predict_terms(span_of(x)).mean;
    check_terms(value, exact.predict_terms(span_of(x)), 2e-3);
  }
}

TEST_CASE("The budget of a weighted sum is what those of its terms add up to", "[gp]") {
  GaussianProcess a = process_with({Matern32{1.0, {1.0}}}, 1e-2), b = a, c = a;
  CHECK_FALSE(weighted_sum({a, b, c}).budget.has_value());
  a.budget = 20;
  b.budget = 30;
  CHECK(weighted_sum({a, b, c}).budget == 50);
  b.budget = GaussianProcess::kMostBudget;
  CHECK(weighted_sum({a, b, c}).budget == GaussianProcess::kMostBudget);
}

TEST_CASE("The evidence of a weighted sum is its likelihood, and its gradient by each term central differences",
          "[gp]") {
  const Data data = samples();
  for (const auto& [name, kernel] : example_kernels(kSumInputs)) {
    const GaussianProcess sum = sum_with(kernel);
    const Posterior posterior = absorbed(sum, data);
    CHECK(evidence(sum, posterior).value == Approx(posterior.log_marginal_likelihood()).epsilon(1e-9));
    for (int term = 0; term < kSumTerms; ++term) {
      const Evidence result = evidence(sum, posterior, term);
      GaussianProcess moved = sum;
      const std::vector<HyperParameter> parameters = hyper_parameters(term_of(moved, term).kernel);
      REQUIRE(result.gradient.size() == static_cast<Eigen::Index>(parameters.size()) + 1);
      const double scale = std::max(1.0, result.gradient.cwiseAbs().maxCoeff());
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        const double value = *parameters[p].value;
        const double expected = derivative(
            [&](double log_value) {
              *parameters[p].value = std::exp(log_value);
              return evidence(moved, posterior, term).value;
            },
            std::log(value), 1e-3);
        *parameters[p].value = value;
        INFO(name << ", term " << term << ", " << parameters[p].name);
        CHECK(relative_error(result.gradient[static_cast<Eigen::Index>(p)], expected, scale) < 1e-5);
      }
    }
  }
}

TEST_CASE("Tuning one term of a weighted sum raises the evidence and leaves the others", "[gp]") {
  const Data data = samples();
  const GaussianProcess sum = sum_with({SquaredExponential{1.0, {1.0, 1.0}}});
  const Posterior posterior = absorbed(sum, data);
  for (int term = 0; term < kSumTerms; ++term) {
    RandomStream random = random_stream(3, "tune");
    const GaussianProcess best = maximize_evidence(sum, posterior, {}, random, term).prior;
    CHECK(evidence(best, posterior).value > evidence(sum, posterior).value);
    for (int other = 0; other < kSumTerms; ++other) {
      CHECK((term_of(best, other).kernel == term_of(sum, other).kernel) == (other != term));
    }
  }
}
