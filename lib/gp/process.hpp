#pragma once

#include <optional>
#include <span>
#include <vector>

#include "gp/inputs.hpp"
#include "gp/prior.hpp"
#include "gp/sparse.hpp"
#include "numerics/growing_cholesky.hpp"

namespace bayesctrl {

/// Log-normal process prior, log f ~ GP: f is positive. Observed as log f + noise, so that everything below holds for
/// `log`, with targets log y; `exponential_of` turns its marginals into those of f.
struct LogNormalProcess {
  static constexpr std::string_view kName = "log_normal_process";
  static constexpr std::string_view kText = "log f ~ GP(mean, kernel), observed as log f + noise";
  GaussianProcess log;

  static void fields(auto& self, auto&& field) { GaussianProcess::fields(self.log, field); }
};

/// A prior with the data absorbed: n inputs X, targets y, noise S (diagonal). Keeps L of K + S = L L^T and z = L^-1 (y
/// - m(X)), so that E f(x) = m(x) + (L^-1 k) . z and var f(x) = k(x, x) - |L^-1 k|^2 (Rasmussen & Williams 2006,
/// Alg. 2.1). A prior with a budget keeps so many samples; once there are more it predicts by a sparse process that has
/// absorbed all of them, and takes bounded time and memory.
class Posterior {
 public:
  Posterior() = default;

  /// No data yet. Throws std::invalid_argument unless the kernel has one length scale per dimension.
  Posterior(GaussianProcess prior, int dimension);

  const GaussianProcess& prior() const { return prior_; }
  int dimension() const { return inputs_.dimension(); }

  /// Samples that were absorbed, and those of them that are kept: the first ones, up to the budget.
  int absorbed() const { return absorbed_; }
  int size() const { return inputs_.size(); }
  bool over_budget() const { return absorbed_ > size(); }

  const Inputs& inputs() const { return inputs_; }
  const std::vector<double>& targets() const { return targets_; }
  const std::vector<double>& noise_variances() const { return noise_variances_; }

  /// Noise variance of a sample under another prior: the sample's own, if it came with one, else that prior's.
  double noise_variance_under(const GaussianProcess& prior, int sample) const {
    const auto slot = static_cast<std::size_t>(sample);
    return own_noise_[slot] ? noise_variances_[slot] : prior.noise_variance;
  }
  bool has_own_noise(int sample) const { return own_noise_[static_cast<std::size_t>(sample)]; }

  /// Makes room, so that absorbing up to `samples` points allocates nothing.
  void reserve(int samples);

  /// Absorbs one more sample, O(n^2), with the prior's noise variance or the sample's own.
  /// Throws NumericalError for a value that is not finite or a covariance that is not positive definite, and is then
  /// as it was before.
  void extend(std::span<const double> x, double y);
  void extend(std::span<const double> x, double y, double noise_variance);

  /// Over budget: as if the prior's standard deviation had been so many times as large all along, O(m^3).
  void scale_output(double factor);

  /// Mean and variance of f(x), O(n^2). Allocates nothing.
  Marginal predict(std::span<const double> x) const;

  /// Of a weighted sum: means and covariance of its terms f_c(x), at an input without weights.
  TermMarginals predict_terms(std::span<const double> x) const;

  /// Mean of ((y_k - E y_k) / sd y_k)^2, each sample predicted from those before it; over budget of those since the
  /// scale was last changed. 0 without any.
  double mean_squared_innovation() const;

  /// log p(y | X) (Rasmussen & Williams 2006, Eq. 2.30), over budget that of the sparse process.
  double log_marginal_likelihood() const;

 private:
  void absorb(std::span<const double> x, double y, double noise_variance, bool own_noise);

  /// k(x, X), padded with zeros, in a scratch buffer of the calling thread.
  double* covariances(std::span<const double> x, int column = 0) const;

  double prior_variance(std::span<const double> x) const {
    return prior_.terms.empty() ? prior_variance_ : variance(prior_, x);
  }

  GaussianProcess prior_;
  double prior_variance_ = 0.0;  // unless it is a weighted sum, whose variance depends on the weights
  Inputs inputs_;
  std::vector<double> targets_;
  std::vector<double> noise_variances_;
  std::vector<char> own_noise_;  // whether a sample came with its noise variance
  std::vector<double> z_;        // padded with zeros
  GrowingCholesky factor_;
  int absorbed_ = 0;
  std::optional<SparsePosterior> sparse_;  // of a prior with a budget
};

/// Prior and data to posterior. `inputs`: n x dimension. `noise_variances` is one per sample (heteroscedastic), or
/// empty for the prior's.
Posterior condition(const GaussianProcess& prior, const Eigen::MatrixXd& inputs, std::span<const double> targets,
                    std::span<const double> noise_variances = {});

/// f(x), or of a weighted sum one term, at an input without weights.
Marginal term_at(const Posterior& posterior, std::span<const double> x, int term);

/// The samples that are kept under another prior; those that came with a noise variance of their own keep it.
Posterior condition(const GaussianProcess& prior, const Posterior& data);

/// Mean of exp(f) for f ~ N(m, s2): exp(m + s2/2) (the paper's mean of b). Variance: exp(2m + s2)(exp(s2) - 1); the
/// paper prints exp(2m + s2) exp(s2 - 1), which does not vanish with s2.
Marginal exponential_of(const Marginal& log_value);

}  // namespace bayesctrl
