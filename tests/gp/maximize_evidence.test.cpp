#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "gp/evidence.hpp"
#include "support/dense.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

/// exp(log(bound)) may differ from the bound in its last digit.
constexpr double kLastDigit = 1e-14;

/// What that does to an evidence: the matrices below have condition numbers up to 1e6.
constexpr double kConditioned = 1e-9;

Posterior smooth_data(const GaussianProcess& prior, int n) {
  const Eigen::MatrixXd inputs = random_points(n, 2, 2.0, 61);
  return condition(prior, inputs, smooth_at(inputs));
}

EvidenceSummary maximized(const GaussianProcess& prior, const Posterior& data, const EvidenceOptions& options = {}) {
  RandomStream random = random_stream(1, "restarts");
  return maximize_evidence(prior, data, options, random);
}

EvidenceOptions evaluations(int limit) {
  EvidenceOptions options;
  options.max_evaluations = limit;
  return options;
}

/// The kernel's own example and far away from it.
std::vector<GaussianProcess> starts(const Kernel& kernel) {
  std::vector<GaussianProcess> list;
  for (const double factor : {1.0, 0.2, 4.0}) {
    GaussianProcess prior = process_with(kernel, 1e-2 * factor);
    for (const HyperParameter& parameter : hyper_parameters(prior.kernel)) *parameter.value *= factor;
    list.push_back(prior);
  }
  return list;
}

const std::vector<double>& bound_of(const EvidenceBounds& bounds, const std::string& field) {
  if (field == "output_scale") return bounds.output_scale;
  if (field == "length_scales") return bounds.length_scale;
  return field == "shape" ? bounds.shape : bounds.period;
}

}  // namespace

TEST_CASE("The maximised evidence is never below that of the start, for every kernel and any number of evaluations",
          "[gp]") {
  for (const auto& [name, kernel] : example_kernels(2)) {
    for (const GaussianProcess& start : starts(kernel)) {
      const Posterior data = smooth_data(start, 20);
      const double before = evidence(start, data).value;
      for (const int limit : {1, 3, 20}) {
        const EvidenceSummary summary = maximized(start, data, evaluations(limit));
        INFO(name << ", " << limit << " evaluations");
        CHECK(summary.value >= before - kConditioned * std::abs(before));
        CHECK(summary.value == Approx(evidence(summary.prior, data).value).epsilon(kLastDigit));
        CHECK(summary.evaluations <= limit);
      }
    }
  }
}

TEST_CASE("Every hyper-parameter stays within its bounds, also when the start is not", "[gp]") {
  EvidenceOptions options;
  options.max_evaluations = 30;
  options.bounds = {.output_scale = {0.9, 1.1},
                    .length_scale = {0.4, 0.5},
                    .shape = {0.6, 0.7},
                    .period = {3.0, 4.0},
                    .noise_variance = {1e-3, 2e-3}};
  for (auto [name, kernel] : example_kernels(2)) {
    const GaussianProcess start = process_with(kernel, 1.0);
    EvidenceSummary summary = maximized(start, smooth_data(start, 20), options);
    for (const HyperParameter& parameter : hyper_parameters(summary.prior.kernel)) {
      const std::vector<double>& bound = bound_of(options.bounds, parameter.field);
      INFO(name << " " << parameter.name << " = " << *parameter.value);
      CHECK(*parameter.value >= bound[0] * (1.0 - kLastDigit));
      CHECK(*parameter.value <= bound[1] * (1.0 + kLastDigit));
    }
    CHECK(summary.prior.noise_variance >= 1e-3 * (1.0 - kLastDigit));
    CHECK(summary.prior.noise_variance <= 2e-3 * (1.0 + kLastDigit));
  }
}

TEST_CASE("A parameter whose bounds coincide is fixed there, the others are free", "[gp]") {
  EvidenceOptions options;
  options.bounds.noise_variance = {0.01, 0.01};
  options.bounds.length_scale = {0.7, 0.7};
  for (const auto& [name, kernel] : example_kernels(2)) {
    const GaussianProcess start = process_with(kernel, 0.5);
    EvidenceSummary summary = maximized(start, smooth_data(start, 20), options);
    INFO(name);
    CHECK(summary.prior.noise_variance == 0.01);
    bool moved = false;
    Kernel before = kernel;
    const std::vector<HyperParameter> old = hyper_parameters(before), now = hyper_parameters(summary.prior.kernel);
    for (std::size_t p = 0; p < now.size(); ++p) {
      if (now[p].field == "length_scales") CHECK(*now[p].value == 0.7);
      if (now[p].field == "output_scale") moved = moved || *now[p].value != *old[p].value;
    }
    CHECK(moved);
  }
}

TEST_CASE("With every parameter fixed the evidence is that of the bounds", "[gp]") {
  EvidenceOptions options;
  options.bounds = {{2.0, 2.0}, {0.7, 0.7}, {1.0, 1.0}, {1.0, 1.0}, {0.1, 0.1}};
  const GaussianProcess start = process_with({SquaredExponential{}}, 0.5);
  const Posterior data = smooth_data(start, 20);
  const EvidenceSummary summary = maximized(start, data, options);
  const GaussianProcess expected = process_with({SquaredExponential{2.0, {0.7, 0.7}}}, 0.1);
  CHECK(summary.prior.kernel == expected.kernel);
  CHECK(summary.value == evidence(expected, data).value);
  CHECK(summary.converged);
}

TEST_CASE("An infinite length scale stays infinite", "[gp]") {
  const GaussianProcess start = process_with({SquaredExponential{1.0, {1.0, kInfinity}}}, 1e-2);
  const EvidenceSummary summary = maximized(start, smooth_data(start, 20));
  CHECK(std::get<SquaredExponential>(summary.prior.kernel.form).length_scales[1] == kInfinity);
  CHECK(std::get<SquaredExponential>(summary.prior.kernel.form).length_scales[0] != 1.0);
}

TEST_CASE("At a maximum within the bounds the gradient vanishes", "[gp]") {
  const EvidenceBounds bounds;
  for (const auto& [name, kernel] : leaf_kernels(2)) {
    const GaussianProcess start = process_with(kernel, 1e-2);
    const Posterior data = smooth_data(start, 30);
    EvidenceSummary summary = maximized(start, data, evaluations(1000));
    INFO(name << ", " << summary.evaluations << " evaluations, " << summary.value);
    const Eigen::VectorXd gradient = evidence(summary.prior, data).gradient;
    Eigen::Index index = 0;
    for (const HyperParameter& parameter : hyper_parameters(summary.prior.kernel)) {
      const std::vector<double>& bound = bound_of(bounds, parameter.field);
      const bool inside = *parameter.value > bound[0] * 1.001 && *parameter.value < bound[1] * 0.999;
      INFO(name << " " << parameter.name << " = " << *parameter.value);
      // The search stops when the evidence, of order 10 here, no longer changes by 1e-9 of itself.
      if (inside) CHECK(std::abs(gradient[index]) < 1e-2);
      ++index;
    }
  }
}

TEST_CASE("Restarts follow from their stream, never do harm, and leave a poor maximum", "[gp]") {
  // With a long length scale, the wiggle of 12 samples looks like noise: a maximum of its own.
  const GaussianProcess poor = process_with({SquaredExponential{1.0, {30.0}}}, 1.0);
  Eigen::MatrixXd inputs(24, 1);
  std::vector<double> targets;
  for (int i = 0; i < 24; ++i) {
    inputs(i, 0) = 0.25 * i;
    targets.push_back(std::sin(4.0 * inputs(i, 0)));
  }
  const Posterior data = condition(poor, inputs, targets);
  const EvidenceSummary alone = maximized(poor, data);
  EvidenceOptions options;
  options.restarts = 8;
  const EvidenceSummary once = maximized(poor, data, options), again = maximized(poor, data, options);
  CHECK(once.prior.kernel == again.prior.kernel);
  CHECK(once.prior.noise_variance == again.prior.noise_variance);
  CHECK(once.value == again.value);
  CHECK(once.evaluations == again.evaluations);
  CHECK(once.evaluations > alone.evaluations);
  CHECK(once.value > alone.value + 10.0);
  CHECK(std::get<SquaredExponential>(once.prior.kernel.form).length_scales[0] < 2.0);
}

TEST_CASE("The parameters of a known process are recovered from its draws", "[gp]") {
  constexpr int kSamples = 250;
  const GaussianProcess truth = process_with({SquaredExponential{2.0, {0.7}}}, 0.04);
  const Eigen::MatrixXd inputs = random_points(kSamples, 1, 15.0, 62);
  Eigen::MatrixXd k = gram(truth.kernel, inputs, inputs);
  k.diagonal().array() += truth.noise_variance;
  const Eigen::MatrixXd factor = testing::dense::lower_factor(k);
  RandomStream random = random_stream(4, "draw");
  Eigen::VectorXd z(kSamples);
  for (double& value : z) value = draw_normal(random);
  const Eigen::VectorXd y = factor * z;
  const std::vector<double> targets(y.begin(), y.end());

  const GaussianProcess start = process_with({SquaredExponential{1.0, {2.0}}}, 0.5);
  const EvidenceSummary summary = maximized(start, condition(start, inputs, targets));
  const auto& found = std::get<SquaredExponential>(summary.prior.kernel.form);
  // Some 40 independent stretches of the function and 200 spare samples: errors of 10 to 20 %.
  CHECK(found.output_scale == Approx(2.0).epsilon(0.4));
  CHECK(found.length_scales[0] == Approx(0.7).epsilon(0.15));
  CHECK(summary.prior.noise_variance == Approx(0.04).epsilon(0.3));
  CHECK(summary.value >= evidence(truth, condition(truth, inputs, targets)).value);
}

TEST_CASE("Where the start has no evidence a restart may; where nothing has, that is an error", "[gp]") {
  GaussianProcess prior = process_with({SquaredExponential{}}, 1e-2);
  Posterior data(prior, 2);
  const Eigen::Vector2d x(0.3, 0.4);
  for (int i = 0; i < 3; ++i) data.extend(span_of(x), 1.0 + 0.1 * i);
  prior.noise_variance = 1e-30;
  EvidenceOptions options;
  options.bounds.noise_variance = {1e-30, 1e2};
  options.restarts = 10;
  CHECK(std::isfinite(maximized(prior, data, options).value));
  options.bounds.noise_variance = {1e-30, 1e-29};
  CHECK_THROWS_WITH(maximized(prior, data, options),
                    "the marginal likelihood could not be evaluated at any starting point");
}

TEST_CASE("Bounds are two numbers, the lowest first", "[gp]") {
  CHECK(EvidenceBounds{}.problem().empty());
  EvidenceBounds bounds;
  bounds.shape = {1.0};
  CHECK(bounds.problem() == "shape needs two bounds, the lowest first");
  bounds.shape = {2.0, 1.0};
  CHECK(bounds.problem() == "shape needs two bounds, the lowest first");
  bounds.shape = {1.0, 1.0};
  CHECK(bounds.problem().empty());
}

TEST_CASE("A hyper-prior draws a maximum towards its median, a narrow one holds it there, a wide one does nothing",
          "[gp]") {
  const GaussianProcess prior = process_with({SquaredExponential{1.0, {1.0, 1.0}}}, 0.1);
  const Posterior data = smooth_data(prior, 25);
  const auto scale = [&](double spread) {
    EvidenceOptions options;
    options.hyper_priors.output_scale = HyperPrior{5.0, spread};
    const EvidenceSummary best = maximized(prior, data, options);
    return std::get<SquaredExponential>(best.prior.kernel.form).output_scale;
  };
  const double alone = std::get<SquaredExponential>(maximized(prior, data).prior.kernel.form).output_scale;
  CHECK(scale(1e3) == Approx(alone).epsilon(1e-3));
  CHECK(scale(1e-4) == Approx(5.0).epsilon(1e-3));
  CHECK(std::abs(std::log(scale(0.5) / 5.0)) < std::abs(std::log(alone / 5.0)));
}

TEST_CASE("Few samples alone say that a function is flat; with hyper-priors it stays what was believed of it", "[gp]") {
  const GaussianProcess prior = process_with({SquaredExponential{0.5, {20.0, 20.0}}}, 1e-4);
  Eigen::MatrixXd inputs(3, 2);
  inputs << 0.0, 0.0, 0.1, 0.0, 0.0, 0.1;
  const std::vector<double> targets{0.10, 0.12, 0.09};
  const Posterior data = condition(prior, inputs, targets);
  EvidenceOptions believed;
  believed.hyper_priors.output_scale = HyperPrior{10.0, 1.0};
  believed.hyper_priors.length_scale = HyperPrior{2.0, 0.7};
  const Eigen::Vector2d far(2.0, 0.0);
  const double alone = condition(maximized(prior, data).prior, data).predict(span_of(far)).variance;
  const double with = condition(maximized(prior, data, believed).prior, data).predict(span_of(far)).variance;
  CHECK(with > 5.0 * alone);
}

TEST_CASE("Where every sample has a noise of its own the prior's noise stays as it was", "[gp]") {
  const GaussianProcess prior = process_with({SquaredExponential{1.0, {1.0, 1.0}}}, 0.1);
  const Eigen::MatrixXd inputs = random_points(10, 2, 2.0, 62);
  const Posterior data = condition(prior, inputs, smooth_at(inputs), std::vector<double>(10, 1e-3));
  EvidenceOptions options;
  options.restarts = 3;
  options.hyper_priors.noise_variance = HyperPrior{5.0, 0.1};
  CHECK(maximized(prior, data, options).prior.noise_variance == 0.1);
}
