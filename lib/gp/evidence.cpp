#include "gp/evidence.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "numerics/minimize.hpp"
#include "numerics/spd_inverse.hpp"

namespace bayesctrl {

namespace {

Eigen::VectorXd residuals(const GaussianProcess& prior, const Posterior& data) {
  Eigen::VectorXd rest(data.size());
  for (int i = 0; i < data.size(); ++i) {
    const Eigen::VectorXd x = data.inputs().points().row(i);
    rest[i] = data.targets()[i] - prior.prior_mean({x.data(), static_cast<std::size_t>(x.size())});
  }
  return rest;
}

/// Calls f(j, first, block of inputs, x_j) for the blocks that cover rows j + 1 .. n - 1 of each column j.
void for_each_block(const Inputs& inputs, auto&& f) {
  const int n = inputs.size();
  const Eigen::MatrixXd rows = inputs.points().transpose();  // one input per column, contiguous
  for (int j = 0; j < n; ++j) {
    for (int first = j + 1; first < n; first += kBlock) {
      f(j, first, inputs.block(first, std::min(kBlock, n - first)), rows.col(j).data());
    }
  }
}

}  // namespace

std::vector<std::string> evidence_parameters(const GaussianProcess& prior) {
  Kernel kernel = prior.kernel;
  std::vector<std::string> names;
  for (const HyperParameter& parameter : hyper_parameters(kernel)) names.push_back("kernel." + parameter.name);
  names.emplace_back("noise_variance");
  return names;
}

Evidence evidence(const GaussianProcess& prior, const Posterior& data) {
  const int n = data.size();
  const auto parameters = static_cast<Eigen::Index>(evidence_parameters(prior).size());
  Evidence result{0.0, Eigen::VectorXd::Zero(parameters)};
  if (n == 0) return result;

  // One pass over the kernel for its values, the factorisation, then a second pass for the derivatives: the weights of
  // the derivatives are known only after the factorisation, and keeping all derivatives would take O(n^2) memory each.
  Eigen::MatrixXd covariance(n, n);
  const double prior_variance = variance(prior.kernel);
  for (int i = 0; i < n; ++i) covariance(i, i) = prior_variance + data.noise_variance_under(prior, i);
  BlockArray k;
  for_each_block(data.inputs(), [&](int j, int first, const InputBlock& block, const double* x) {
    evaluate(prior.kernel, block, x, k);
    covariance.col(j).segment(first, block.count) = k.matrix();
  });
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(covariance);  // in place; the upper triangle was never set
  if (factor.info() != Eigen::Success || !covariance.diagonal().allFinite()) {
    throw NumericalError("the covariance matrix of " + std::to_string(n) + " samples is not positive definite");
  }
  const Eigen::VectorXd rest = residuals(prior, data);
  const Eigen::VectorXd alpha = factor.solve(rest);
  const double half_log_determinant = covariance.diagonal().array().log().sum();
  result.value = -0.5 * rest.dot(alpha) - half_log_determinant - 0.5 * n * std::log(2.0 * std::numbers::pi);

  // d value / d theta = sum_ij W_ij dK_ij / 2 with W = alpha alpha^T - K^-1.
  invert_from_factor(covariance);
  Eigen::MatrixXd& weights = covariance;  // its lower triangle
  weights *= -1.0;
  weights.selfadjointView<Eigen::Lower>().rankUpdate(alpha);
  BlockGradient gradient;
  for_each_block(data.inputs(), [&](int j, int first, const InputBlock& block, const double* x) {
    differentiate(prior.kernel, block, x, k, gradient);
    result.gradient.head(parameters - 1).noalias() +=
        gradient.matrix().transpose() * weights.col(j).segment(first, block.count);
  });
  const Eigen::VectorXd origin = Eigen::VectorXd::Zero(data.dimension());
  const InputBlock one{origin.data(), 1, 1, data.dimension()};
  differentiate(prior.kernel, one, origin.data(), k, gradient);
  const double trace = weights.trace();
  result.gradient.head(parameters - 1) += 0.5 * trace * gradient.row(0).transpose().matrix();
  double noise_trace = 0.0;  // over the samples whose noise is the prior's
  for (int i = 0; i < n; ++i) noise_trace += data.has_own_noise(i) ? 0.0 : weights(i, i);
  result.gradient[parameters - 1] = 0.5 * noise_trace * prior.noise_variance;
  return result;
}

std::string EvidenceBounds::problem() const {
  std::string text;
  fields(*this, [&](std::string_view name, const std::vector<double>& bound, const Info&) {
    if (text.empty() && (bound.size() != 2 || bound[0] > bound[1])) {
      text = std::string(name) + " needs two bounds, the lowest first";
    }
  });
  return text;
}

namespace {

/// The parameters that may move, as pointers into a prior, with their bounds in logarithms.
struct FreeParameters {
  std::vector<double*> values;
  std::vector<Eigen::Index> index;  // place in the evidence's gradient
  std::vector<double> low, high;
  std::vector<std::optional<HyperPrior>> priors;
};

FreeParameters free_parameters(GaussianProcess& prior, const Posterior& data, const EvidenceOptions& options) {
  const EvidenceBounds& bounds = options.bounds;
  const HyperPriors& priors = options.hyper_priors;
  FreeParameters free;
  Eigen::Index index = 0;
  const auto add = [&](double& value, const std::vector<double>& bound, const std::optional<HyperPrior>& believed) {
    if (std::isfinite(value)) {
      value = std::min(std::max(value, bound[0]), bound[1]);
      if (bound[0] < bound[1]) {
        free.values.push_back(&value);
        free.index.push_back(index);
        free.low.push_back(std::log(bound[0]));
        free.high.push_back(std::log(bound[1]));
        free.priors.push_back(believed);
      }
    }
    ++index;
  };
  for (const HyperParameter& parameter : hyper_parameters(prior.kernel)) {
    if (parameter.field == "output_scale") {
      add(*parameter.value, bounds.output_scale, priors.output_scale);
    } else if (parameter.field == "length_scales") {
      add(*parameter.value, bounds.length_scale, priors.length_scale);
    } else if (parameter.field == "shape") {
      add(*parameter.value, bounds.shape, priors.shape);
    } else {
      add(*parameter.value, bounds.period, priors.period);
    }
  }
  bool any = data.size() == 0;  // sample whose noise is the prior's: the others say nothing of it
  for (int i = 0; i < data.size(); ++i) any = any || !data.has_own_noise(i);
  if (any) add(prior.noise_variance, bounds.noise_variance, priors.noise_variance);
  return free;
}

Eigen::VectorXd to_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void place(const FreeParameters& free, const Eigen::VectorXd& logarithms) {
  for (Eigen::Index i = 0; i < logarithms.size(); ++i) *free.values[i] = std::exp(logarithms[i]);
}

/// Minus the log posterior of a candidate's free parameters, up to a constant, by their logarithms; infinite outside
/// the region in which the covariance can be factorised. Refers to its arguments.
Objective negative_log_posterior(const GaussianProcess& candidate, const FreeParameters& free, const Posterior& data) {
  return [&](const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
    place(free, x);
    try {
      const Evidence result = evidence(candidate, data);
      double value = -result.value;
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        gradient[i] = -result.gradient[free.index[i]];
        if (const auto& believed = free.priors[static_cast<std::size_t>(i)]) {
          const double z = (x[i] - std::log(believed->median)) / believed->spread;
          value += 0.5 * z * z;
          gradient[i] += z / believed->spread;
        }
      }
      return value;
    } catch (const NumericalError&) {
      return kInfinity;
    }
  };
}

constexpr int kDraws = 100;        // of hyper-parameters,
constexpr int kThinning = 20;      // of a chain of so many steps each,
constexpr int kBurnIn = 500;       // after so many that set the length of a step,
constexpr double kAccepted = 0.3;  // so that this share is accepted
constexpr double kAdaptation = 0.1;

}  // namespace

EvidenceSummary maximize_evidence(const GaussianProcess& prior, const Posterior& data, const EvidenceOptions& options,
                                  RandomStream& random) {
  EvidenceSummary best{prior, -kInfinity, 0, false};
  GaussianProcess candidate = prior;
  const FreeParameters free = free_parameters(candidate, data, options);
  best.prior = candidate;
  if (free.values.empty() || data.size() == 0) {
    best.value = evidence(candidate, data).value;
    best.converged = true;
    return best;
  }
  const auto size = static_cast<Eigen::Index>(free.values.size());
  const Objective objective = negative_log_posterior(candidate, free, data);
  const Eigen::VectorXd low = to_vector(free.low), high = to_vector(free.high);
  for (int start = 0; start <= options.restarts; ++start) {
    Eigen::VectorXd x(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      x[i] = start == 0 ? std::log(*free.values[i]) : draw_uniform(random, low[i], high[i]);
    }
    const MinimizeSummary summary =
        minimize(objective, x, low, high, {.method = options.method, .max_evaluations = options.max_evaluations});
    best.evaluations += summary.evaluations;
    if (-summary.value > best.value) {
      place(free, summary.x);
      best.prior = candidate;
      best.value = -summary.value;
      best.converged = summary.converged;
    }
  }
  if (!std::isfinite(best.value) || best.value <= -1e299) {
    throw NumericalError("the marginal likelihood could not be evaluated at any starting point");
  }
  return best;
}

std::vector<GaussianProcess> credible_priors(const GaussianProcess& prior, const Posterior& data,
                                             const EvidenceOptions& options, double risk, RandomStream& random) {
  GaussianProcess candidate = prior;
  const FreeParameters free = free_parameters(candidate, data, options);
  const auto size = static_cast<Eigen::Index>(free.values.size());
  if (size == 0) return {candidate};
  const Objective objective = negative_log_posterior(candidate, free, data);
  Eigen::VectorXd x(size), gradient(size), next(size);
  for (Eigen::Index i = 0; i < size; ++i) x[i] = std::log(*free.values[i]);
  double value = objective(x, gradient), length = 0.3;
  std::vector<std::pair<double, GaussianProcess>> draws;
  for (int step = 1 - kBurnIn; step <= kDraws * kThinning; ++step) {
    bool inside = true;
    for (Eigen::Index i = 0; i < size; ++i) {
      next[i] = x[i] + length * draw_normal(random);
      inside = inside && next[i] >= free.low[i] && next[i] <= free.high[i];
    }
    const double there = inside ? objective(next, gradient) : kInfinity;
    const bool taken = std::log(draw_uniform(random, 0.0, 1.0)) < value - there;
    if (taken) {
      x = next;
      value = there;
    }
    if (step <= 0) {
      length *= std::exp(kAdaptation * ((taken ? 1.0 : 0.0) - kAccepted));
    } else if (step % kThinning == 0 && std::isfinite(value)) {
      place(free, x);
      draws.emplace_back(value, candidate);
    }
  }
  std::stable_sort(draws.begin(), draws.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (draws.empty()) return {prior};
  std::vector<GaussianProcess> densest;
  const double count = std::ceil((1.0 - risk) * static_cast<double>(draws.size()));
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) densest.push_back(draws[i].second);
  return densest;
}

}  // namespace bayesctrl
