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
  bool scale_to_model = true;                // each kernel to what prior_model states as its uncertainty

  static void fields(auto& self, auto&& field) {
    field("drift", self.drift, {.text = "process of the drift a(x), one or one per joint", .required = true});
    field("input_gain", self.input_gain,
          {.text = "log-normal process of b(x), one or one per joint", .required = true});
    field("coupling", self.coupling, {.text = "process of b_ij(x) off the diagonal, one or one per joint"});
    field("prior_model", self.prior_model, {.text = "a model whose a and b are the prior means"});
    field(
        "scale_to_model", self.scale_to_model,
        {.text = "where prior_model states its uncertainty, as one of a diagnosis does, that is the standard deviation "
                 "of the processes, in the place of their kernels' own"});
  }

  /// What is wrong with these priors for a machine of so many joints, in words; empty when nothing is.
  std::string problem(int joints) const;
};

/// What the belief says of one state; joints x inputs for the gain. The log fields hold for the diagonal.
struct BeliefMarginals {
  JointVector drift_mean, drift_variance;
  JointMatrix gain_mean, gain_variance;
  JointVector log_gain_mean, log_gain_variance;
  // Together, summed over joints i: the covariance of b_i1, b_i2, ..., and of a_i with them. Apart they are empty.
  JointMatrix gain_covariance{};
  JointVector drift_gain_covariance{};

  /// Of sum_j b_ij u_j, the b_ij being independent.
  Marginal of_inputs(int i, const JointVector& u) const;
};

/// Posterior processes over a and b; inputs of all are x = [q, v]. They are apart, each with samples of its own, as in
/// the paper, or together: one weighted sum of a_i, b_i1, ..., log b_ii, ... for each joint, which can be learned from
/// q_i'' = a_i + sum_j b_ij u_j itself, and knows that what such samples say of a_i and b_ij has its errors in common.
class Belief {
 public:
  Belief() = default;

  /// Throws std::invalid_argument with the prior's `problem(joints)`.
  Belief(const BeliefPrior& prior, int joints);

  int joints() const { return static_cast<int>(together() ? motion_.size() : drift_.size()); }
  Posterior& drift(int i) { return drift_[i]; }
  const Posterior& drift(int i) const { return drift_[i]; }

  /// Process of log b_ii on the diagonal and of b_ij beside it.
  Posterior& gain(int i, int j) { return gain_[i * joints() + j]; }
  const Posterior& gain(int i, int j) const { return gain_[i * joints() + j]; }

  /// From here on together, if it was not. Throws NumericalError where a process is over its budget.
  void join();
  bool together() const { return !motion_.empty(); }
  Posterior& motion(int i) { return motion_[i]; }
  const Posterior& motion(int i) const { return motion_[i]; }

  /// Together: a sample of joint i, sum_c weights_c f_c(x) + noise. Throws as `Posterior::extend` does.
  void learn(int i, const StateVector& x, const TermVector& weights, double y, double noise_variance);

  /// What weights.f is together, for joint i.
  Marginal predict(int i, const StateVector& x, const TermVector& weights) const;

  /// Of q_i'' = a_i + sum_j b_ij u_j at x, where this is `believed`.
  Marginal acceleration(const BeliefMarginals& believed, int i, const StateVector& x, const JointVector& u) const;

  /// The process that a_i (column -1) or b_ij is learned by, and its term there.
  Posterior& process(int i, int column) { return together() ? motion_[i] : column < 0 ? drift(i) : gain(i, column); }
  const Posterior& process(int i, int column) const {
    return together() ? motion_[i] : column < 0 ? drift(i) : gain(i, column);
  }
  int term(int column) const { return together() ? column + 1 : 0; }

  const GaussianProcess& drift_prior(int i) const;
  const GaussianProcess& gain_prior(int i, int j) const;

  /// Samples that tell of a_i (column -1) or of b_ij.
  int points(int i, int column) const;

  /// Calls f(i, column, process, its term) for each a_i and b_ij, column -1 for a_i.
  void for_each(auto&& f) {
    for (int i = 0; i < joints(); ++i) {
      for (int column = -1; column < joints(); ++column) f(i, column, process(i, column), term(column));
    }
  }

  /// Data points of the drift, and of the gain (all columns together; rows of one column are learned at once).
  int drift_points() const;
  int gain_points() const;

  /// The samples of `data` under the priors of this. Throws NumericalError for a process over its budget.
  Belief with_samples(const Belief& data) const;

  /// Makes room for this many more samples in each process.
  void reserve(int more);

  BeliefMarginals predict(const StateVector& x) const;

 private:
  std::vector<Posterior> drift_;
  std::vector<Posterior> gain_;
  std::vector<Posterior> motion_;
  std::vector<int> told_;  // together: samples with a weight for a term, joint after joint
};

}  // namespace bayesctrl
