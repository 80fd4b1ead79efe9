#pragma once

#include <Eigen/QR>

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// What starts and unknowns do, by differences of the machine's own runs: slower than the linear response, and right
/// where a joint sticks, a motion is unstable, or effects change the dynamics. Starts follow the unknowns along to
/// where they explain each window best.
class ExactSlopes {
 public:
  /// `linear`: slopes that set the size of differences. Throws NumericalError where a run next to here diverges.
  ExactSlopes(const FitProblem& problem, const Fit& fit, const Eigen::MatrixXd& linear);

  /// Rows x unknowns.
  const Eigen::MatrixXd& slopes() const { return slopes_; }

  /// Starts of a fit whose unknowns have changed, and its residual.
  void follow(const FitProblem& problem, Fit& next, const Eigen::VectorXd& change) const;

 private:
  Eigen::MatrixXd slopes_;
  std::vector<Eigen::ColPivHouseholderQR<Eigen::MatrixXd>> starts_;  // per window: samples, then start, x start
  std::vector<WindowStart> weights_;                                 // per window: of the start itself
  std::vector<Eigen::MatrixXd> along_;                               // per window: start x unknowns
};

}  // namespace bayesctrl
