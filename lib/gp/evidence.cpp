#include "gp/evidence.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
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

std::vector<std::string> evidence_parameters(const GaussianProcess& prior, int term) {
  Kernel kernel = term_of(prior, term).kernel;
  std::vector<std::string> names;
  for (const HyperParameter& parameter : hyper_parameters(kernel)) names.push_back("kernel." + parameter.name);
  names.emplace_back("noise_variance");
  return names;
}

namespace {

/// The covariance of the samples as its lower Cholesky factor, alpha = K^-1 (y - m), and log p(y | X).
struct Factored {
  Eigen::MatrixXd factor;
  Eigen::VectorXd alpha;
  double value = 0.0;
};

Factored factored(const GaussianProcess& prior, const Posterior& data) {
  const int n = data.size();
  Factored result{Eigen::MatrixXd(n, n), {}};
  Eigen::MatrixXd& covariance = result.factor;
  for (int i = 0; i < n; ++i) {
    const Eigen::VectorXd x = data.inputs().points().row(i);
    covariance(i, i) =
        variance(prior, {x.data(), static_cast<std::size_t>(x.size())}) + data.noise_variance_under(prior, i);
  }
  BlockArray k;
  for_each_block(data.inputs(), [&](int j, int first, const InputBlock& block, const double* x) {
    evaluate(prior, block, x, k);
    covariance.col(j).segment(first, block.count) = k.matrix();
  });
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(covariance);  // in place; the upper triangle was never set
  if (factor.info() != Eigen::Success || !covariance.diagonal().allFinite()) {
    throw NumericalError("the covariance matrix of " + std::to_string(n) + " samples is not positive definite");
  }
  const Eigen::VectorXd rest = residuals(prior, data);
  result.alpha = factor.solve(rest);
  result.value = -0.5 * rest.dot(result.alpha) - covariance.diagonal().array().log().sum() -
                 0.5 * n * std::log(2.0 * std::numbers::pi);
  return result;
}

}  // namespace

double log_evidence(const GaussianProcess& prior, const Posterior& data) {
  return data.size() == 0 ? 0.0 : factored(prior, data).value;
}

Evidence evidence(const GaussianProcess& prior, const Posterior& data, int term) {
  const int n = data.size();
  const auto parameters = static_cast<Eigen::Index>(evidence_parameters(prior, term).size());
  Evidence result{0.0, Eigen::VectorXd::Zero(parameters)};
  if (n == 0) return result;

  // One pass over the kernel for its values, the factorisation, then a second pass for the derivatives: the weights of
  // the derivatives are known only after the factorisation, and keeping all derivatives would take O(n^2) memory each.
  auto [covariance, alpha, value] = factored(prior, data);
  result.value = value;

  // d value / d theta = sum_ij W_ij dK_ij / 2 with W = alpha alpha^T - K^-1.
  invert_from_factor(covariance);
  Eigen::MatrixXd& weights = covariance;  // its lower triangle
  weights *= -1.0;
  weights.selfadjointView<Eigen::Lower>().rankUpdate(alpha);
  const bool sum = !prior.terms.empty();
  const int states = data.dimension() - static_cast<int>(prior.terms.size()), of_term = states + term;
  const Kernel& kernel = term_of(prior, term).kernel;
  BlockArray k;
  BlockGradient gradient;
  for_each_block(data.inputs(), [&](int j, int first, InputBlock block, const double* x) {
    if (sum && x[of_term] == 0.0) return;
    Eigen::VectorXd share = weights.col(j).segment(first, block.count);
    if (sum) share.array() *= x[of_term] * block.column(of_term);
    block.dimension = states;
    differentiate(kernel, block, x, k, gradient);
    result.gradient.head(parameters - 1).noalias() += gradient.matrix().transpose() * share;
  });
  const Eigen::VectorXd origin = Eigen::VectorXd::Zero(states);
  const InputBlock one{origin.data(), 1, 1, states};
  differentiate(kernel, one, origin.data(), k, gradient);
  double trace = weights.trace();
  if (sum) trace = weights.diagonal().dot(data.inputs().points().col(of_term).cwiseAbs2());
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

FreeParameters free_parameters(GaussianProcess& prior, const Posterior& data, const EvidenceOptions& options,
                               int term) {
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
  for (const HyperParameter& parameter : hyper_parameters(term_of(prior, term).kernel)) {
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
  if (!prior.terms.empty()) return free;  // whose samples have their own
  bool any = data.size() == 0;            // sample whose noise is the prior's: the others say nothing of it
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

/// Minus the logarithm of the hyper-priors, up to a constant, whose gradient is added where it is asked for.
double surprise(const FreeParameters& free, const Eigen::VectorXd& x, Eigen::VectorXd* gradient = nullptr) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const auto& believed = free.priors[static_cast<std::size_t>(i)];
    if (!believed) continue;
    const double z = (x[i] - std::log(believed->median)) / believed->spread;
    sum += 0.5 * z * z;
    if (gradient != nullptr) (*gradient)[i] += z / believed->spread;
  }
  return sum;
}

/// Minus the log posterior of a candidate's free parameters, up to a constant, by their logarithms; infinite outside
/// the region in which the covariance can be factorised. Refers to its arguments.
Objective negative_log_posterior(const GaussianProcess& candidate, const FreeParameters& free, const Posterior& data,
                                 int term) {
  return [&, term](const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
    place(free, x);
    try {
      const Evidence result = evidence(candidate, data, term);
      for (Eigen::Index i = 0; i < x.size(); ++i) gradient[i] = -result.gradient[free.index[i]];
      return surprise(free, x, &gradient) - result.value;
    } catch (const NumericalError&) {
      return kInfinity;
    }
  };
}

constexpr int kDraws = 100;        // of hyper-parameters,
constexpr int kThinning = 30;      // of a chain of so many steps each,
constexpr int kBurnIn = 900;       // after so many that set the lengths of its steps,
constexpr double kAccepted = 0.3;  // so that this share is accepted
constexpr double kAdaptation = 0.1;

/// A Markov chain over the free parameters whose distribution is their posterior. Its steps take turns: one parameter
/// anew from its hyper-prior (uniform within its bounds without one), which moves freely where the data say nothing;
/// one parameter a little; and all together by the covariance of where it has been, along the ridges that data leave.
class Chain {
 public:
  Chain(GaussianProcess& candidate, const FreeParameters& free, const Posterior& data, RandomStream& random)
      : candidate_(candidate), free_(free), data_(data), random_(random), x_(size()) {
    for (Eigen::Index i = 0; i < size(); ++i) x_[i] = std::log(*free.values[static_cast<std::size_t>(i)]);
    lengths_ = Eigen::VectorXd::Constant(size(), 0.3);
    root_ = 0.1 * Eigen::MatrixXd::Identity(size(), size());
    scatter_ = Eigen::MatrixXd::Zero(size(), size());
    mean_ = x_;
    value_ = negative_log(x_);
  }

  double value() const { return value_; }

  /// Sets the candidate's parameters to where the chain is.
  void place() const { bayesctrl::place(free_, x_); }

  void step(int number, bool adapt) {
    const auto one = static_cast<Eigen::Index>(draw_uniform(random_, 0.0, 1.0) * static_cast<double>(size()));
    const Eigen::Index i = std::min(size() - 1, one);
    const auto slot = static_cast<std::size_t>(i);
    Eigen::VectorXd next = x_;
    double* length = nullptr;
    double correction = 0.0;  // for proposals that do not depend on where they come from
    if (number % 3 == 0) {
      const auto& believed = free_.priors[slot];
      next[i] = believed ? std::log(believed->median) + believed->spread * draw_normal(random_)
                         : draw_uniform(random_, free_.low[slot], free_.high[slot]);
      correction = surprise(free_, next) - surprise(free_, x_);
    } else if (number % 3 == 1) {
      length = &lengths_[i];
      next[i] += *length * draw_normal(random_);
    } else {
      length = &together_;
      Eigen::VectorXd z(size());
      for (double& value : z) value = draw_normal(random_);
      next += *length * (root_ * z);
    }
    const double there = inside(next) ? negative_log(next) : kInfinity;
    const bool taken = std::log(draw_uniform(random_, 0.0, 1.0)) < value_ - there + correction;
    if (taken) {
      x_ = next;
      value_ = there;
    }
    if (!adapt) return;
    if (length != nullptr) *length *= std::exp(kAdaptation * ((taken ? 1.0 : 0.0) - kAccepted));
    remember(number);
  }

 private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(free_.values.size()); }

  bool inside(const Eigen::VectorXd& x) const {
    bool all = true;
    for (Eigen::Index i = 0; i < size(); ++i) {
      const auto slot = static_cast<std::size_t>(i);
      all = all && x[i] >= free_.low[slot] && x[i] <= free_.high[slot];
    }
    return all;
  }

  double negative_log(const Eigen::VectorXd& x) const {
    bayesctrl::place(free_, x);
    try {
      return surprise(free_, x) - log_evidence(candidate_, data_);
    } catch (const NumericalError&) {
      return kInfinity;
    }
  }

  /// The covariance of where the chain has been.
  void remember(int number) {
    ++seen_;
    const Eigen::VectorXd before = x_ - mean_;
    mean_ += before / seen_;
    scatter_ += before * (x_ - mean_).transpose();
    if (number % 50 != 0) return;
    Eigen::MatrixXd covariance = scatter_ / seen_;
    covariance.diagonal().array() += 1e-6;
    root_ = covariance.llt().matrixL();
  }

  const GaussianProcess& candidate_;
  const FreeParameters& free_;
  const Posterior& data_;
  RandomStream& random_;
  Eigen::VectorXd x_, mean_;
  Eigen::VectorXd lengths_;  // of the steps of one parameter
  double together_ = 1.0;    // of those of all, times root_
  Eigen::MatrixXd root_, scatter_;
  double value_ = 0.0, seen_ = 0.0;
};

}  // namespace

EvidenceSummary maximize_evidence(const GaussianProcess& prior, const Posterior& data, const EvidenceOptions& options,
                                  RandomStream& random, int term) {
  EvidenceSummary best{prior, -kInfinity, 0, false};
  GaussianProcess candidate = prior;
  const FreeParameters free = free_parameters(candidate, data, options, term);
  best.prior = candidate;
  if (free.values.empty() || data.size() == 0) {
    best.value = log_evidence(candidate, data);
    best.converged = true;
    return best;
  }
  const auto size = static_cast<Eigen::Index>(free.values.size());
  const Objective objective = negative_log_posterior(candidate, free, data, term);
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
                                             const EvidenceOptions& options, double risk, RandomStream& random,
                                             int term) {
  GaussianProcess candidate = prior;
  const FreeParameters free = free_parameters(candidate, data, options, term);
  if (free.values.empty()) return {candidate};
  Chain chain(candidate, free, data, random);
  std::vector<std::pair<double, GaussianProcess>> draws;
  for (int step = 1; step <= kBurnIn + kDraws * kThinning; ++step) {
    chain.step(step, step <= kBurnIn);
    if (step <= kBurnIn || step % kThinning != 0 || !std::isfinite(chain.value())) continue;
    chain.place();
    draws.emplace_back(chain.value(), candidate);
  }
  std::stable_sort(draws.begin(), draws.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<GaussianProcess> densest;
  const double count = std::ceil((1.0 - risk) * static_cast<double>(draws.size()));
  for (std::size_t d = 0; d < static_cast<std::size_t>(count); ++d) densest.push_back(draws[d].second);
  return densest;
}

}  // namespace bayesctrl
