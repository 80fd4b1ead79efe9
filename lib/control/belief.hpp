#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/vector.hpp"
#include "gp/process.hpp"
#include "physics/model.hpp"

namespace bayesctrl {

/// Priors over the drift a(x) and the input gain b(x) of q'' = a(x) + b(x) u. A list of one serves every joint.
struct BeliefPrior {
  std::vector<GaussianProcess> drift;        // a_i, one per joint
  std::vector<LogNormalProcess> input_gain;  // b_ii, one per joint: positive
  std::vector<GaussianProcess> coupling;     // b_ij off the diagonal, one per joint i; only for several joints
  std::optional<Model> prior_model;          // its a, log b_ii and b_ij are added to the processes' constant means

  static void fields(auto& self, auto&& field) {
    field("drift", self.drift, {.text = "process of the drift a(x), one or one per joint", .required = true});
    field("input_gain", self.input_gain,
          {.text = "log-normal process of b(x), one or one per joint", .required = true});
    field("coupling", self.coupling, {.text = "process of b_ij(x) off the diagonal, one or one per joint"});
    field("prior_model", self.prior_model, {.text = "a model whose a and b are the prior means"});
  }

  /// What is wrong with these priors for a machine of so many joints, in words; empty when nothing is.
  std::string problem(int joints) const;
};

/// What the belief says of one state; joints x inputs for the gain. The log fields hold for the diagonal.
struct BeliefMarginals {
  JointVector drift_mean, drift_variance;
  JointMatrix gain_mean, gain_variance;
  JointVector log_gain_mean, log_gain_variance;
};

/// Posterior processes over a and b; inputs of all are x = [q, v].
class Belief {
 public:
  Belief() = default;

  /// Throws std::invalid_argument with the prior's `problem(joints)`.
  Belief(const BeliefPrior& prior, int joints);

  int joints() const { return static_cast<int>(drift_.size()); }
  Posterior& drift(int i) { return drift_[i]; }
  const Posterior& drift(int i) const { return drift_[i]; }

  /// Process of log b_ii on the diagonal and of b_ij beside it.
  Posterior& gain(int i, int j) { return gain_[i * joints() + j]; }
  const Posterior& gain(int i, int j) const { return gain_[i * joints() + j]; }

  /// Data points of the drift, and of the gain (all columns together; rows of one column are learned at once).
  int drift_points() const;
  int gain_points() const;

  /// Makes room for this many more samples in each process.
  void reserve(int more);

  BeliefMarginals predict(const StateVector& x) const;

 private:
  std::vector<Posterior> drift_;
  std::vector<Posterior> gain_;
};

}  // namespace bayesctrl
