#include "control/belief.hpp"

#include <cmath>
#include <stdexcept>

namespace bayesctrl {

namespace {

const auto& for_joint(const auto& list, int joint) { return list.size() == 1 ? list.front() : list[joint]; }

const GaussianProcess& latent(const GaussianProcess& process) { return process; }
const GaussianProcess& latent(const LogNormalProcess& process) { return process.log; }

/// The prior of one process with `value` of the prior model's a(x) and b(x) added to its mean.
GaussianProcess with_mean(GaussianProcess prior, const std::optional<Model>& model,
                          double (*value)(const Affine&, int, int), int i, int j) {
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
  return text;
}

Belief::Belief(const BeliefPrior& prior, int joints) {
  if (const std::string problem = prior.problem(joints); !problem.empty()) throw std::invalid_argument(problem);
  const int dimension = 2 * joints;
  for (int i = 0; i < joints; ++i) {
    drift_.emplace_back(with_mean(for_joint(prior.drift, i), prior.prior_model, drift_of, i, i), dimension);
    for (int j = 0; j < joints; ++j) {
      gain_.emplace_back(i == j ? with_mean(for_joint(prior.input_gain, i).log, prior.prior_model, log_gain_of, i, j)
                                : with_mean(for_joint(prior.coupling, i), prior.prior_model, gain_of, i, j),
                         dimension);
    }
  }
}

int Belief::drift_points() const { return drift_.empty() ? 0 : drift_.front().absorbed(); }

int Belief::gain_points() const {
  int points = 0;
  for (int j = 0; j < joints(); ++j) points += gain(j, j).absorbed();
  return points;
}

void Belief::reserve(int more) {
  for (Posterior& process : drift_) process.reserve(process.size() + more);
  for (Posterior& process : gain_) process.reserve(process.size() + more);
}

BeliefMarginals Belief::predict(const StateVector& x) const {
  const int n = joints();
  const std::span<const double> input(x.data(), static_cast<std::size_t>(x.size()));
  BeliefMarginals result{JointVector(n),    JointVector(n), JointMatrix(n, n),
                         JointMatrix(n, n), JointVector(n), JointVector(n)};
  for (int i = 0; i < n; ++i) {
    const Marginal drift = drift_[i].predict(input);
    result.drift_mean[i] = drift.mean;
    result.drift_variance[i] = drift.variance;
    for (int j = 0; j < n; ++j) {
      Marginal value = gain(i, j).predict(input);
      if (i == j) {
        result.log_gain_mean[i] = value.mean;
        result.log_gain_variance[i] = value.variance;
        value = exponential_of(value);
      }
      result.gain_mean(i, j) = value.mean;
      result.gain_variance(i, j) = value.variance;
    }
  }
  return result;
}

}  // namespace bayesctrl
