#pragma once

#include "diagnose/motion/linear_response.hpp"

namespace bayesctrl {

/// The most probable intensity of process noise, per joint, where a residual is left of a response. What does not
/// depend on the residual is computed once.
class LikelyIntensity {
 public:
  explicit LikelyIntensity(const LinearResponse& response);

  /// `residual`: rows of the response.
  Eigen::VectorXd operator()(const Eigen::VectorXd& residual) const;

 private:
  const LinearResponse& response_;
  std::vector<std::vector<Eigen::MatrixXd>> covariance_;  // [window][joint], of its rows by an intensity of 1
  double scale_ = 0.0;                                    // mean variance of a row by that
};

}  // namespace bayesctrl
