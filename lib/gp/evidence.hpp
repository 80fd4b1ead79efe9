#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "gp/process.hpp"
#include "numerics/minimize.hpp"

namespace bayesctrl {

/// Log marginal likelihood and its gradient by the logarithm of each parameter in the order of `evidence_parameters`.
struct Evidence {
  double value = 0.0;
  Eigen::VectorXd gradient;
};

/// Names of what the evidence depends on: the kernel's hyper-parameters as "kernel.<path>", then "noise_variance"; of a
/// weighted sum those of one term.
std::vector<std::string> evidence_parameters(const GaussianProcess& prior, int term = 0);

/// log p(y | X). Throws as `evidence` does.
double log_evidence(const GaussianProcess& prior, const Posterior& data);

/// log p(y | X) and its analytic gradient (Rasmussen & Williams 2006, Eq. 5.9), O(n^3). Throws NumericalError if the
/// covariance is not positive definite. Takes inputs and targets from `data`; the noise is the prior's but for samples
/// that came with their own. Of a weighted sum, by
/// the parameters of one term.
Evidence evidence(const GaussianProcess& prior, const Posterior& data, int term = 0);

/// Bounds on the hyper-parameters; a parameter whose bounds coincide is fixed there, an infinite length scale stays.
struct EvidenceBounds {
  std::vector<double> output_scale{1e-3, 1e3};
  std::vector<double> length_scale{1e-2, 1e3};
  std::vector<double> shape{1e-2, 1e3};
  std::vector<double> period{1e-1, 1e2};
  std::vector<double> noise_variance{1e-8, 1e2};

  static void fields(auto& self, auto&& field) {
    field("output_scale", self.output_scale, {kPositive, "output unit", "lowest and highest output scale"});
    field("length_scale", self.length_scale, {kPositive, "input unit", "lowest and highest length scale"});
    field("shape", self.shape, {kPositive, "", "lowest and highest shape of a rational quadratic"});
    field("period", self.period, {kPositive, "input unit", "lowest and highest period"});
    field("noise_variance", self.noise_variance,
          {kPositive, "output unit squared", "lowest and highest noise variance"});
  }
  std::string problem() const;
  bool operator==(const EvidenceBounds&) const = default;
};

/// Belief in a hyper-parameter before the data: its logarithm is normal.
struct HyperPrior {
  double median = 1.0;
  double spread = 1.0;

  static void fields(auto& self, auto&& field) {
    field("median", self.median, {kPositive, "unit of the parameter", "median", kRequired});
    field("spread", self.spread, {kPositive, "nat", "standard deviation of its logarithm", kRequired});
  }
  bool operator==(const HyperPrior&) const = default;
};

/// Hyper-priors, by kind of parameter; the evidence of few samples alone prefers long scales and small variances.
struct HyperPriors {
  std::optional<HyperPrior> output_scale, length_scale, shape, period, noise_variance;

  static void fields(auto& self, auto&& field) {
    field("output_scale", self.output_scale, {.text = "of output scales"});
    field("length_scale", self.length_scale, {.text = "of every length scale"});
    field("shape", self.shape, {.text = "of the shape of a rational quadratic"});
    field("period", self.period, {.text = "of every period"});
    field("noise_variance", self.noise_variance, {.text = "of the noise variance"});
  }
  bool operator==(const HyperPriors&) const = default;
};

struct EvidenceOptions {
  EvidenceBounds bounds;
  HyperPriors hyper_priors;
  MinimizeMethod method = MinimizeMethod::lbfgs;
  int max_evaluations = 100;  // of the likelihood, for each start
  int restarts = 0;           // further starts, drawn log-uniformly within the bounds

  static void fields(auto& self, auto&& field) {
    field("bounds", self.bounds, {.text = "bounds of the hyper-parameters"});
    field("hyper_priors", self.hyper_priors,
          {.text = "log-normal priors of the hyper-parameters; none: the evidence alone"});
    field("method", self.method,
          {.text = "limited-memory BFGS, or conjugate gradients with a line search by Rasmussen's rules"});
    field("max_evaluations", self.max_evaluations,
          {between(1, 1e6), "", "evaluations of the likelihood for each start"});
    field("restarts", self.restarts, {between(0, 1000), "", "further starts, drawn log-uniformly within the bounds"});
  }
  bool operator==(const EvidenceOptions&) const = default;
};

struct EvidenceSummary {
  GaussianProcess prior;  // with the best hyper-parameters found
  double value = 0.0;     // its log marginal likelihood, with the logarithm of its hyper-priors up to a constant
  int evaluations = 0;
  bool converged = false;
};

/// Maximises the log marginal likelihood, or with hyper-priors the log posterior, over the logarithms of the
/// hyper-parameters within their bounds, starting at `prior`. Never returns a prior whose likelihood is below that of
/// the (bounded) start. Of a weighted sum, over those of one term, the others being what they are.
EvidenceSummary maximize_evidence(const GaussianProcess& prior, const Posterior& data, const EvidenceOptions& options,
                                  RandomStream& random, int term = 0);

/// 100 draws from the posterior of the hyper-parameters (Metropolis, 3900 evaluations of the likelihood; log-uniform
/// within the bounds where there is no hyper-prior), without the least probable, a share `risk`: what they may be but
/// for that probability. None where no likelihood is finite. Of a weighted sum one term's, the others being what they
/// are.
std::vector<GaussianProcess> credible_priors(const GaussianProcess& prior, const Posterior& data,
                                             const EvidenceOptions& options, double risk, RandomStream& random,
                                             int term = 0);

}  // namespace bayesctrl
