#include "control/belief.hpp"

#include <stdexcept>

namespace bayesctrl {

namespace {

const GaussianProcess& for_joint(const std::vector<GaussianProcess>& list, int joint, int joints, const char* what) {
  if (list.size() == 1) return list.front();
  if (static_cast<int>(list.size()) == joints) return list[joint];
  throw std::invalid_argument(std::string(what) + ": " + std::to_string(list.size()) + " processes for " +
                              std::to_string(joints) + " joints");
}

}  // namespace

Belief::Belief(const BeliefPrior& prior, int joints) {
  for (int i = 0; i < joints; ++i) drift_.emplace_back(for_joint(prior.drift, i, joints, "drift"), 2 * joints);
  for (int i = 0; i < joints; ++i) {
    for (int j = 0; j < joints; ++j) {
      gain_.emplace_back(i == j ? for_joint(prior.input_gain, i, joints, "input_gain")
                                : for_joint(prior.coupling, i, joints, "coupling"),
                         2 * joints);
    }
  }
}

int Belief::drift_points() const { return drift_.empty() ? 0 : drift_.front().size(); }

int Belief::gain_points() const {
  int points = 0;
  for (int j = 0; j < joints(); ++j) points += gain(j, j).size();
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
