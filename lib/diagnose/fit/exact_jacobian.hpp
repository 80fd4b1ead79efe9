#pragma once

#include "diagnose/fit/fit.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

/// Jacobian of the rows by the unknowns, by differences of the machine's own free runs, the initial state of each
/// segment projected out (variable projection): slower than the linear response, and right where a joint sticks, a
/// motion is unstable, or effects change the dynamics.
class ExactJacobian {
 public:
  /// `linear`: the Jacobian that sets the size of differences. Throws NumericalError where a run next to here diverges.
  ExactJacobian(const FitProblem& problem, const Fit& fit, const Eigen::MatrixXd& linear);

  /// Rows x unknowns.
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

  /// Initial states of a fit whose unknowns have changed by `change`, and its residual.
  void follow(const FitProblem& problem, Fit& next, const Eigen::VectorXd& change) const;

 private:
  Eigen::MatrixXd jacobian_;
  std::vector<PivotedQr> by_initial_state_;  // per window: samples, then initial state, x initial state
  std::vector<SegmentState> weights_;        // per window: of the initial state a priori
  std::vector<Eigen::MatrixXd> along_;       // per window: initial state x unknowns
};

}  // namespace bayesctrl
