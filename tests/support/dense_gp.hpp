#pragma once

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "gp/process.hpp"
#include "support/dense.hpp"

namespace bayesctrl::testing {

/// k(x, y) of two single points.
inline double covariance(const Kernel& kernel, const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  BlockArray k;
  evaluate(kernel, InputBlock{y.data(), 1, 1, static_cast<int>(y.size())}, x.data(), k);
  return k[0];
}

/// k(x_i, y_j) for points in rows, one pair at a time.
inline Eigen::MatrixXd gram(const Kernel& kernel, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
  Eigen::MatrixXd k(x.rows(), y.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    for (Eigen::Index j = 0; j < y.rows(); ++j) k(i, j) = covariance(kernel, x.row(i), y.row(j));
  }
  return k;
}

/// The posterior by the textbook's matrix algebra on all data at once: m + k^T K^-1 (y - m), k(x,x) - k^T K^-1 k,
/// log N(y; m, K) (Rasmussen & Williams 2006, Eq. 2.25, 2.26, 2.30), K including the noise.
class DenseProcess {
 public:
  DenseProcess(const GaussianProcess& prior, const Eigen::MatrixXd& inputs, std::vector<double> targets,
               std::vector<double> noise_variances)
      : prior_(prior), inputs_(inputs), covariance_(gram(prior.kernel, inputs, inputs)), rest_(inputs.rows()) {
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      const Eigen::VectorXd x = inputs.row(i);
      rest_[i] = targets[i] - prior.prior_mean(span_of(x));
      covariance_(i, i) += noise_variances[i];
    }
  }

  Marginal predict(const Eigen::VectorXd& x) const {
    const Eigen::VectorXd k = gram(prior_.kernel, inputs_, x.transpose()).col(0);
    return {prior_.prior_mean(span_of(x)) + k.dot(solved(rest_)), covariance(prior_.kernel, x, x) - k.dot(solved(k))};
  }

  double log_marginal_likelihood() const {
    return dense::log_density(rest_, covariance_) -
           0.5 * static_cast<double>(rest_.size()) * std::log(2.0 * std::numbers::pi);
  }

 private:
  Eigen::VectorXd solved(const Eigen::VectorXd& b) const { return dense::solve(covariance_, b); }

  GaussianProcess prior_;
  Eigen::MatrixXd inputs_, covariance_;
  Eigen::VectorXd rest_;
};

inline GaussianProcess process_with(const Kernel& kernel, double noise_variance) {
  GaussianProcess process;
  process.kernel = kernel;
  process.noise_variance = noise_variance;
  return process;
}

/// A smooth, nowhere symmetric function of any number of inputs.
inline double smooth(const Eigen::VectorXd& x) {
  double value = 0.3;
  for (Eigen::Index d = 0; d < x.size(); ++d)
    value += std::sin(1.3 * x[d] + static_cast<double>(d)) + 0.2 * x[d] * x[0];
  return value;
}

/// The smooth function at each row.
inline std::vector<double> smooth_at(const Eigen::MatrixXd& inputs) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < inputs.rows(); ++i) values.push_back(smooth(inputs.row(i)));
  return values;
}

}  // namespace bayesctrl::testing
