#include "control/belief.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

const auto& for_joint(const auto& list, int joint) { return list.size() == 1 ? list.front() : list[joint]; }

const GaussianProcess& latent(const GaussianProcess& process) { return process; }
const GaussianProcess& latent(const LogNormalProcess& process) { return process.log; }

/// The prior of one process with `value` of the prior model's a(x) and b(x) added to its mean, and as wide as `doubt`,
/// one standard deviation or one per joint i, says; with none as wide as it is.
GaussianProcess with_mean(GaussianProcess prior, const std::optional<Model>& model,
                          double (*value)(const Affine&, int, int), int i, int j, const std::vector<double>& doubt) {
  if (!doubt.empty()) {
    scale_output(prior.kernel, for_joint(doubt, i) / std::sqrt(variance(prior.kernel)));
  }
  if (model) {
    prior.mean_function = [believed = *model, value, i, j](std::span<const double> x) {
      const auto n = static_cast<Eigen::Index>(x.size() / 2);
      const Eigen::Map<const JointVector> q(x.data(), n), v(x.data() + n, n);
      return value(affine(believed, q, v), i, j);
    };
  }
  return prior;
}

double drift_of(const Affine& affine, int i, int /*j*/) { return affine.drift[i]; }
double log_gain_of(const Affine& affine, int i, int j) { return std::log(affine.gain(i, j)); }
double gain_of(const Affine& affine, int i, int j) { return affine.gain(i, j); }

}  // namespace

std::string BeliefPrior::problem(int joints) const {
  const auto check = [joints](const auto& list, const std::string& what) -> std::string {
    if (list.size() != 1 && static_cast<int>(list.size()) != joints) {
      return what + " has " + std::to_string(list.size()) + " processes for " + std::to_string(joints) +
             (joints == 1 ? " joint" : " joints: one for all or one for each");
    }
    for (const auto& process : list) {
      const std::string problem = dimension_problem(latent(process).kernel, 2 * joints);
      if (!problem.empty()) return what + ": " + problem + " (positions, then velocities)";
    }
    return "";
  };
  std::string text = check(drift, "drift");
  if (text.empty()) text = check(input_gain, "input_gain");
  if (text.empty() && joints > 1) text = check(coupling, "coupling");
  if (text.empty() && prior_model && bayesctrl::joints(prior_model->plant) != joints) {
    text = "prior_model has another number of joints than the machine";
  }
  if (text.empty() && prior_model && prior_model->uncertainty) {
    text = prior_model->uncertainty->problem(joints);
    if (!text.empty()) text = "uncertainty of prior_model: " + text;
  }
  return text;
}

Belief::Belief(const BeliefPrior& prior, int joints) {
  if (const std::string problem = prior.problem(joints); !problem.empty()) throw std::invalid_argument(problem);
  const int dimension = 2 * joints;
  const std::optional<Model>& model = prior.prior_model;
  const ModelUncertainty doubt =
      prior.scale_to_model && model ? model->uncertainty.value_or(ModelUncertainty{}) : ModelUncertainty{};
  for (int i = 0; i < joints; ++i) {
    drift_.emplace_back(with_mean(for_joint(prior.drift, i), model, drift_of, i, i, doubt.drift), dimension);
    for (int j = 0; j < joints; ++j) {
      gain_.emplace_back(i == j
                             ? with_mean(for_joint(prior.input_gain, i).log, model, log_gain_of, i, j, doubt.input_gain)
                             : with_mean(for_joint(prior.coupling, i), model, gain_of, i, j, doubt.coupling),
                         dimension);
    }
  }
}

namespace {

using WeightedInput = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 2 * kMaxJoints + kMostTerms, 1>;
static_assert(kMaxJoints + 1 <= kMostTerms && 2 * kMaxJoints + kMostTerms <= kMostInputs);

WeightedInput with_weights(const StateVector& x, const TermVector& weights) {
  WeightedInput input(x.size() + weights.size());
  input << x, weights;
  return input;
}

void require_within_budget(const Posterior& process) {
  if (process.over_budget()) {
    throw NumericalError(
        "the data it starts with are over budget: what was absorbed holds under its own priors only, by a learner of "
        "the same kind (keep_hyper_parameters: true, and a monitor in both or in neither)");
  }
}

}  // namespace

void Belief::join() {
  if (together()) return;
  const int n = joints();
  std::vector<Posterior> motion;
  for (int i = 0; i < n; ++i) {
    std::vector<GaussianProcess> priors{drift(i).prior()};
    for (int j = 0; j < n; ++j) priors.push_back(gain(i, j).prior());
    motion.emplace_back(weighted_sum(std::move(priors)), 3 * n + 1);
    const auto take = [&](const Posterior& process, int term) {
      require_within_budget(process);
      const Eigen::MatrixXd points = process.inputs().points();
      for (int k = 0; k < process.size(); ++k) {
        const auto slot = static_cast<std::size_t>(k);
        motion.back().extend(span_of(with_weights(points.row(k).transpose(), TermVector::Unit(n + 1, term))),
                             process.targets()[slot], process.noise_variances()[slot]);
      }
      told_.push_back(process.size());
    };
    take(drift(i), 0);
    for (int j = 0; j < n; ++j) take(gain(i, j), j + 1);
  }
  motion_ = std::move(motion);
  drift_.clear();
  gain_.clear();
}

void Belief::learn(int i, const StateVector& x, const TermVector& weights, double y, double noise_variance) {
  motion(i).extend(span_of(with_weights(x, weights)), y, noise_variance);
  const auto first = static_cast<std::size_t>(i * (joints() + 1));
  for (Eigen::Index c = 0; c < weights.size(); ++c) {
    if (weights[c] != 0.0) ++told_[first + static_cast<std::size_t>(c)];
  }
}

Marginal Belief::predict(int i, const StateVector& x, const TermVector& weights) const {
  return motion(i).predict(span_of(with_weights(x, weights)));
}

const GaussianProcess& Belief::drift_prior(int i) const { return term_of(process(i, -1).prior(), term(-1)); }

const GaussianProcess& Belief::gain_prior(int i, int j) const { return term_of(process(i, j).prior(), term(j)); }

int Belief::points(int i, int column) const {
  return together() ? told_[static_cast<std::size_t>(i * (joints() + 1) + column + 1)] : process(i, column).absorbed();
}

int Belief::drift_points() const { return joints() == 0 ? 0 : points(0, -1); }

int Belief::gain_points() const {
  int sum = 0;
  for (int j = 0; j < joints(); ++j) sum += points(j, j);
  return sum;
}

Belief Belief::with_samples(const Belief& data) const {
  Belief result = *this;
  if (data.together() && !together()) result.join();
  result.told_ = data.told_;
  const auto under = [](Posterior& process, const Posterior& samples) {
    require_within_budget(samples);
    process = condition(process.prior(), samples);
  };
  for (int i = 0; i < joints(); ++i) {
    if (data.together()) {
      under(result.motion(i), data.motion(i));
      continue;
    }
    under(result.drift(i), data.drift(i));
    for (int j = 0; j < joints(); ++j) under(result.gain(i, j), data.gain(i, j));
  }
  return result;
}

void Belief::reserve(int more) {
  for (auto* list : {&drift_, &gain_, &motion_}) {
    for (Posterior& process : *list) process.reserve(process.size() + more);
  }
}

Marginal BeliefMarginals::of_inputs(int i, const JointVector& u) const {
  if (u.isZero(0.0)) return {};  // also where a gain is believed to be without bound
  return {gain_mean.row(i).dot(u), gain_variance.row(i).dot(u.cwiseAbs2())};
}

Marginal Belief::acceleration(const BeliefMarginals& believed, int i, const StateVector& x,
                              const JointVector& u) const {
  const Marginal inputs = believed.of_inputs(i, u);
  const double mean = believed.drift_mean[i] + inputs.mean;
  if (!together() || u.isZero(0.0)) return {mean, believed.drift_variance[i] + inputs.variance};
  TermVector weights(u.size() + 1);
  weights << 1.0, u;
  weights[i + 1] *= believed.gain_mean(i, i);  // cov(a, e^l) = E e^l cov(a, l)
  const double curved =
      believed.gain_variance(i, i) - std::pow(believed.gain_mean(i, i), 2) * believed.log_gain_variance[i];
  return {mean, predict(i, x, weights).variance + u[i] * u[i] * curved};
}

BeliefMarginals Belief::predict(const StateVector& x) const {
  const int n = joints();
  BeliefMarginals result{JointVector(n),    JointVector(n), JointMatrix(n, n),
                         JointMatrix(n, n), JointVector(n), JointVector(n)};
  if (together()) {
    result.gain_covariance = JointMatrix::Zero(n, n);
    result.drift_gain_covariance = JointVector::Zero(n);
  }
  for (int i = 0; i < n; ++i) {
    TermMarginals terms;
    if (together()) terms = motion(i).predict_terms(span_of(x));
    const auto marginal = [&](int column) {
      const int c = term(column);
      return together() ? Marginal{terms.mean[c], terms.covariance(c, c)} : process(i, column).predict(span_of(x));
    };
    const Marginal drift = marginal(-1);
    result.drift_mean[i] = drift.mean;
    result.drift_variance[i] = drift.variance;
    for (int j = 0; j < n; ++j) {
      Marginal value = marginal(j);
      if (i == j) {
        result.log_gain_mean[i] = value.mean;
        result.log_gain_variance[i] = value.variance;
        value = exponential_of(value);
      }
      result.gain_mean(i, j) = value.mean;
      result.gain_variance(i, j) = value.variance;
    }
    if (!together()) continue;
    TermMatrix& covariance = terms.covariance;
    covariance.row(i + 1) *= result.gain_mean(i, i);  // cov(f, e^l) = E e^l cov(f, l)
    covariance.col(i + 1) *= result.gain_mean(i, i);
    covariance(i + 1, i + 1) = result.gain_variance(i, i);
    result.gain_covariance += covariance.bottomRightCorner(n, n);
    result.drift_gain_covariance += covariance.col(0).tail(n);
  }
  return result;
}

}  // namespace bayesctrl
